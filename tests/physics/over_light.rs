//! What tests of light over lit surfaces have in common: panes, media, particles.

use ontile::glam::Vec3;
use ontile::plan::{Path, Tonemap};
use ontile::reference::render;
use ontile::scene::{Fog, Scene};

use crate::error::Errors;
use crate::gpu::{Ask, Gpu};

/// Every path on which it is drawn.
const PATHS: [Path; 3] = [Path::Deferred, Path::Forward, Path::ForwardMultipass];

/// In fog, with ambient light.
pub fn misty(scene: Scene) -> Scene {
    let fog = Some(Fog { color_nt: Vec3::new(0.3, 0.35, 0.4), density_per_m: 0.15, height: None });
    Scene { name: "misty".into(), fog, ambient_nt: Vec3::new(0.1, 0.12, 0.15), ..scene }
}

/// The scenes and paths of which a picture is not the reference's, with a tone curve and without.
pub fn differing(gpu: &Gpu, base: Ask, scenes: impl IntoIterator<Item = Scene>) -> Vec<String> {
    let mut failed = Vec::new();
    for scene in scenes {
        let camera = &scene.cameras[0];
        for (path, tonemap) in
            PATHS.into_iter().flat_map(|p| [Tonemap::Linear, Tonemap::Aces].map(|t| (p, t)))
        {
            let rendered = gpu.render(&scene, camera, Ask { path, tonemap, ..base });
            let expected = render(&scene, camera, &rendered.settings);
            let errors = Errors::of_display(&expected, &rendered.light());
            println!("{}, {path}, {tonemap}: {errors}", scene.name);
            if let Err(reason) = errors.check() {
                failed.push(format!("{}, {path}, {tonemap}: {reason}", scene.name));
            }
        }
    }
    failed
}

/// Checks that each of these ways in which the renderer might be wrong shows when it is done to the reference's scene instead.
pub fn catches(scene: &Scene, ask: Ask, faults: impl IntoIterator<Item = (&'static str, Scene)>) {
    let Some(gpu) = Gpu::open() else { return };
    let camera = &scene.cameras[0];
    let rendered = gpu.render(scene, camera, ask);
    for (name, faulty) in faults {
        let expected = render(&faulty, camera, &rendered.settings);
        let errors = Errors::of_display(&expected, &rendered.light());
        println!("{name}: {errors}");
        assert!(errors.check().is_err(), "not caught: {name}");
    }
    gpu.finish();
}

/// A way in which the renderer might be wrong, done to what the reference is given instead.
pub type Fault = (&'static str, fn(&mut Scene));

/// The scene with each fault done to it.
pub fn spoilt(scene: &Scene, faults: &'static [Fault]) -> impl Iterator<Item = (&'static str, Scene)> {
    let scene = scene.clone();
    faults.iter().map(move |(name, fault)| {
        let mut faulty = scene.clone();
        fault(&mut faulty);
        (*name, faulty)
    })
}

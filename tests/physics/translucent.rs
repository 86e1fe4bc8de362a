//! Surfaces that are blended over others against the reference, which composes all that a ray meets in its exact order.

use ontile::glam::Vec3;
use ontile::plan::{Layout, LightFormat, Path, Tonemap};
use ontile::reference::render;
use ontile::scene::{AlphaMode, Background, Scene};

use crate::common::scenes::glass_scenes::{glass, glass_alone};
use crate::error::Errors;
use crate::gpu::{Ask, Gpu};

/// Every path on which they are drawn.
const PATHS: [Path; 3] = [Path::Deferred, Path::Forward, Path::ForwardMultipass];

/// [`glass`] in fog, with ambient light.
fn misty() -> Scene {
    let fog =
        Some(ontile::scene::Fog { color_nt: Vec3::new(0.3, 0.35, 0.4), density_per_m: 0.15, height: None });
    Scene { name: "misty".into(), fog, ambient_nt: Vec3::new(0.1, 0.12, 0.15), ..glass() }
}

/// [`glass`] over a colour that no curve is applied to.
fn on_paper() -> Scene {
    let mut scene = glass();
    scene.background = Background::Color(Vec3::new(0.6, 0.5, 0.3));
    // Without its floor, most of which would cover the background.
    scene.instances.retain(|instance| scene.materials[scene.meshes[instance.mesh].material].name != "floor");
    Scene { name: "on_paper".into(), ..scene }
}

#[test]
fn blended_light_is_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let mut failed = Vec::new();
    for scene in [glass(), misty(), on_paper(), glass_alone()] {
        let camera = &scene.cameras[0];
        for (path, tonemap) in
            PATHS.into_iter().flat_map(|p| [Tonemap::Linear, Tonemap::Aces].map(|t| (p, t)))
        {
            let rendered = gpu.render(&scene, camera, Ask { path, tonemap, ..Ask::EXACT });
            let expected = render(&scene, camera, &rendered.settings);
            let errors = Errors::of_display(&expected, &rendered.light());
            println!("{}, {path}, {tonemap}: {errors}", scene.name);
            if let Err(reason) = errors.check() {
                failed.push(format!("{}, {path}, {tonemap}: {reason}", scene.name));
            }
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// A way in which the renderer might be wrong, done to what the reference is given instead.
type Fault = (&'static str, fn(&mut Scene));

const FAULTS: &[Fault] = &[
    ("nothing blended", |scene| {
        scene.materials.iter_mut().for_each(|m| m.alpha_mode = AlphaMode::Opaque);
    }),
    ("alpha off by 1 %", |scene| {
        let blended = scene.materials.iter_mut().filter(|m| m.alpha_mode == AlphaMode::Blend);
        blended.for_each(|m| m.base_color_factor.w *= 0.99);
    }),
    ("clear where it is solid", |scene| {
        let solid = scene.materials.iter_mut().find(|m| m.name == "solid");
        solid.unwrap().base_color_factor.w = 0.9;
    }),
    ("emission not multiplied by alpha", |scene| {
        let glow = scene.materials.iter_mut().find(|m| m.name == "glow");
        glow.unwrap().emissive_factor /= 0.6;
    }),
];

#[test]
fn every_fault_of_blending_is_caught() {
    let Some(gpu) = Gpu::open() else { return };
    let scene = glass();
    let camera = &scene.cameras[0];
    let rendered = gpu.render(&scene, camera, Ask::EXACT);
    for (name, fault) in FAULTS {
        let mut faulty = scene.clone();
        fault(&mut faulty);
        let expected = render(&faulty, camera, &rendered.settings);
        let errors = Errors::of_display(&expected, &rendered.light());
        println!("{name}: {errors}");
        assert!(errors.check().is_err(), "not caught: {name}");
    }
    gpu.finish();
}

/// Light above the range of ten bits behind glass: the light target that the plan picks holds it, whatever the layout.
#[test]
fn bright_light_behind_glass_is_not_cut_off() {
    /// What half floats and surfaces in few bits may be off by, of the light.
    const MAX_ERROR: f64 = 0.05;
    let Some(gpu) = Gpu::open() else { return };
    let mut scene = glass();
    scene.lights.clear();
    for material in scene.materials.iter_mut() {
        material.emissive_factor = match material.alpha_mode {
            AlphaMode::Blend => Vec3::ZERO,
            _ => Vec3::new(40.0, 30.0, 20.0),
        };
    }
    for &layout in Layout::ALL {
        let rendered = gpu.render(&scene, &scene.cameras[0], Ask { layout, ..Ask::EXACT });
        let expected = render(&scene, &scene.cameras[0], &rendered.settings);
        let errors = Errors::of_display(&expected, &rendered.light());
        assert_eq!(errors.check_within(MAX_ERROR), Ok(()), "{layout}");
    }
    let cut = Ask { light_target: Some(LightFormat::Rgb10a2), path: Path::Deferred, ..Ask::EXACT };
    let rendered = gpu.render(&scene, &scene.cameras[0], cut);
    let expected = render(&scene, &scene.cameras[0], &rendered.settings);
    let errors = Errors::of_display(&expected, &rendered.light());
    assert!(errors.check_within(MAX_ERROR).is_err(), "ten bits hold it too");
    gpu.finish();
}

//! Light from all around: the GPU against the reference that looks up the same texels, and both against the integral.

use std::sync::Arc;

use ontile::environment::{Panorama, Prefiltered, TexelFormat, direction_from_uv};
use ontile::glam::{DVec3, Vec3};
use ontile::plan::{Layout, Options, Path};
use ontile::reference::around::Method;
use ontile::reference::{Settings, render};
use ontile::scene::{Environment, Light, Scene};

use crate::error::Errors;
use crate::gpu::{Ask, Gpu};
use crate::scenes;

/// A sky with a low sun over a reddish ground, nowhere the same.
fn sky() -> Panorama {
    const WIDTH: u32 = 128;
    let texel = |i: u32| {
        let (x, y) = (f64::from(i % WIDTH) + 0.5, f64::from(i / WIDTH) + 0.5);
        let d = direction_from_uv([x / f64::from(WIDTH), y / f64::from(WIDTH / 2)]);
        let base = if d.y > 0.0 { DVec3::new(0.3, 0.5, 0.9) } else { DVec3::new(0.3, 0.2, 0.12) };
        let sun = if d.dot(DVec3::new(-0.6, 0.5, 0.624)) > 0.99 { 40.0 } else { 0.0 };
        (base * (1.0 + 0.5 * d.x + 0.3 * (7.0 * d.z).sin()) + sun).as_vec3()
    };
    Panorama::new(WIDTH, WIDTH / 2, (0..WIDTH * WIDTH / 2).map(texel).collect()).expect("a panorama")
}

fn under_sky(scene: Scene, panorama: &Panorama, format: TexelFormat) -> Scene {
    let environment = Environment {
        prefiltered: Some(Arc::new(Prefiltered::new(panorama, 64, format))),
        rotation_deg: 70.0,
        intensity: 0.8,
        ..Environment::new("sky", panorama.clone())
    };
    Scene { name: format!("{} under {format}", scene.name), environment: Some(environment), ..scene }
}

fn without_lights(scene: Scene) -> Scene {
    Scene { lights: Vec::<Light>::new(), ..scene }
}

#[test]
fn environments_are_looked_up_as_the_reference_does() {
    let Some(gpu) = Gpu::open() else { return };
    let panorama = sky();
    let mut failed = Vec::new();
    let mut check = |scene: &Scene, path: Path| {
        for camera in &scene.cameras {
            let rendered = gpu.render(scene, camera, Ask { path, ..Ask::EXACT });
            let errors = Errors::of_display(&render(scene, camera, &rendered.settings), &rendered.light());
            println!("{}, {}, {path}: {errors}", scene.name, camera.name);
            if let Err(reason) = errors.check() {
                failed.push(format!("{}, {}, {path}: {reason}", scene.name, camera.name));
            }
        }
    };
    for &format in TexelFormat::ALL {
        check(&without_lights(under_sky(scenes::materials(), &panorama, format)), Path::Deferred);
    }
    for path in [Path::Deferred, Path::Forward] {
        check(&under_sky(scenes::surfaces(), &panorama, TexelFormat::E5B9G9R9), path);
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// A way in which the renderer might be wrong, done to what the reference is given instead.
type Fault = (&'static str, fn(&mut Scene));

const FAULTS: &[Fault] = &[
    ("turned by 1 degree more", |scene| environment(scene).rotation_deg += 1.0),
    ("turned the other way", |scene| environment(scene).rotation_deg *= -1.0),
    ("brighter by 1 %", |scene| environment(scene).intensity *= 1.01),
    ("stored in another format", |scene| {
        let panorama = environment(scene).panorama.clone().expect("it has one");
        let other = Prefiltered::new(&panorama, 64, TexelFormat::B10G11R11);
        environment(scene).prefiltered = Some(Arc::new(other));
    }),
    ("fewer levels", |scene| {
        let panorama = environment(scene).panorama.clone().expect("it has one");
        environment(scene).prefiltered =
            Some(Arc::new(Prefiltered::new(&panorama, 32, TexelFormat::E5B9G9R9)));
    }),
    ("forgotten", |scene| scene.environment = None),
];

fn environment(scene: &mut Scene) -> &mut Environment {
    scene.environment.as_mut().expect("the scene has one")
}

#[test]
fn every_fault_is_caught() {
    let Some(gpu) = Gpu::open() else { return };
    let scene = without_lights(under_sky(scenes::materials(), &sky(), TexelFormat::E5B9G9R9));
    let camera = &scene.cameras[0];
    let rendered = gpu.render(&scene, camera, Ask::EXACT);
    for (name, fault) in FAULTS {
        let mut faulty = scene.clone();
        fault(&mut faulty);
        let errors = Errors::of_display(&render(&faulty, camera, &rendered.settings), &rendered.light());
        println!("{name}: {errors}");
        assert!(errors.check().is_err(), "{name}: not caught, {errors}");
    }
    gpu.finish();
}

/// In light that is the same from everywhere the split sum is exact: what remains is the table's error and that of the
/// integral by its samples.
#[test]
fn a_furnace_is_the_integral() {
    /// Linear light of a white environment, on 99.9 % of the pixels.
    const MOST: f64 = 0.01;
    let Some(gpu) = Gpu::open() else { return };
    let white = Panorama::new(8, 4, vec![Vec3::ONE; 32]).expect("a panorama");
    let mut scene = without_lights(scenes::materials());
    let filtered = Prefiltered::new(&white, 16, Options::default().environment_format);
    scene.environment =
        Some(Environment { prefiltered: Some(Arc::new(filtered)), ..Environment::new("furnace", white) });
    let camera = &scene.cameras[0];
    let rendered = gpu.render(&scene, camera, Ask::EXACT);
    let truth = Settings { around: Method::Integral { samples: 256 }, ..rendered.settings.clone() };
    let errors = Errors::of_display(&render(&scene, camera, &truth), &rendered.light());
    println!("furnace: {errors}");
    gpu.finish();
    assert!(errors.quantile(0.999) < MOST, "{errors}");
}

/// What split sum, levels, harmonics and texels cost together, in the picture of a grid of all materials.
#[test]
fn the_cost_of_looking_up_is_known() {
    /// Decibels of linear light's peak signal to noise over the covered pixels, the peak being 1.
    const LEAST_DB: f64 = 25.0;
    let panorama = sky();
    for format in TexelFormat::ALL {
        let scene = without_lights(under_sky(scenes::materials(), &panorama, *format));
        let camera = &scene.cameras[0];
        let settings = Settings { size: [128, 72], layout: None::<Layout>, ..Settings::default() };
        let found = render(&scene, camera, &settings);
        let integral = Settings { around: Method::Integral { samples: 256 }, ..settings };
        let truth = render(&scene, camera, &integral);
        let pairs = truth.pixels.iter().zip(&found.pixels).filter(|(t, _)| t.covered);
        let errors: Vec<f64> = pairs.map(|(t, f)| (t.linear - f.linear).length_squared() / 3.0).collect();
        let db = -10.0 * (errors.iter().sum::<f64>() / errors.len() as f64).log10();
        println!("{}: {db:.1} dB against the integral", scene.name);
        assert!(db > LEAST_DB, "{format}: {db}");
    }
}

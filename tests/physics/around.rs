//! Light from all around: the GPU against the reference that looks up the same texels, and both against the integral.

use std::sync::Arc;

use ontile::environment::{Panorama, Prefiltered, TexelFormat, direction_from_uv};
use ontile::glam::{DVec3, Quat, Vec3};
use ontile::plan::{Options, Path};
use ontile::reference::around::Method;
use ontile::reference::{Settings, render};
use ontile::scene::{Environment, Light, Scene};

use crate::common::environments::rooms;
use crate::error::Errors;
use crate::gpu::{Ask, Gpu};
use crate::scenes;

/// A sky with a low sun over a reddish ground, nowhere the same.
pub fn sky() -> Panorama {
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

pub fn under_sky(scene: Scene, panorama: &Panorama, format: TexelFormat) -> Scene {
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

/// The rooms of the parity tests, filtered to this size and large enough for the scene.
fn in_rooms(scene: Scene, face_size: u32) -> Scene {
    let mut probes = rooms();
    for probe in &mut probes {
        probe.half_size_m *= 1.7;
        let panorama = probe.environment.panorama.clone().expect("it has one");
        let filtered = Prefiltered::new(&panorama, face_size, TexelFormat::E5B9G9R9);
        probe.environment.prefiltered = Some(Arc::new(filtered));
    }
    Scene { name: format!("{}, in rooms", scene.name), probes, ..scene }
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
        check(&in_rooms(under_sky(scenes::materials(), &panorama, TexelFormat::E5B9G9R9), 64), path);
        check(&Scene { environment: None, ..in_rooms(without_lights(scenes::surfaces()), 32) }, path);
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

const FAULTS_OF_ROOMS: &[Fault] = &[
    ("moved by 2 cm", |scene| scene.probes[0].position_world.x += 0.02),
    ("turned by 1 degree", |scene| {
        scene.probes[1].world_from_probe *= Quat::from_rotation_y(1.0_f32.to_radians())
    }),
    ("higher by 2 cm", |scene| scene.probes[1].half_size_m.y += 0.02),
    ("wider falloff", |scene| scene.probes[0].falloff_m += 0.02),
    ("picture turned", |scene| scene.probes[0].environment.rotation_deg += 1.0),
    ("brighter by 1 %", |scene| scene.probes[1].environment.intensity *= 1.01),
    ("in another order", |scene| {
        let [a, b] = &mut scene.probes[..] else { unreachable!("there are two") };
        std::mem::swap(&mut a.environment, &mut b.environment);
        a.environment.intensity *= 1.1;
    }),
    ("forgotten", |scene| scene.probes.truncate(1)),
    ("nothing far away", |scene| scene.environment = None),
];

#[test]
fn every_fault_is_caught() {
    let scene = without_lights(under_sky(scenes::materials(), &sky(), TexelFormat::E5B9G9R9));
    catches(&scene, FAULTS);
    catches(&in_rooms(scene, 64), FAULTS_OF_ROOMS);
}

fn catches(scene: &Scene, faults: &[Fault]) {
    let Some(gpu) = Gpu::open() else { return };
    let camera = &scene.cameras[0];
    let rendered = gpu.render(scene, camera, Ask::EXACT);
    for (name, fault) in faults {
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
        let settings = Settings { size: [128, 72], gbuffer: None, ..Settings::default() };
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

/// A mirror shows where things are: a red spot towards -X lies on the left half, as the picture's right half does, and turns
/// with the environment towards +Z.
#[test]
fn an_environment_lies_where_it_is_said_to() {
    let Some(gpu) = Gpu::open() else { return };
    let spot = |i: u32| {
        let d = direction_from_uv([(f64::from(i % 64) + 0.5) / 64.0, (f64::from(i / 64) + 0.5) / 32.0]);
        // Three quarters of the width, at half the height.
        if d.dot(DVec3::NEG_X) > 0.95 { Vec3::X } else { Vec3::new(0.0, 0.0, 0.1) }
    };
    let panorama = Panorama::new(64, 32, (0..64 * 32).map(spot).collect()).expect("a panorama");
    assert_eq!(panorama.texels()[16 * 64 + 48], Vec3::X);
    let scene = scenes::mirror();
    let mut found = Vec::new();
    for rotation_deg in [0.0, 90.0, 180.0] {
        let mut scene = under_sky(scene.clone(), &panorama, TexelFormat::Rgba16F);
        environment(&mut scene).rotation_deg = rotation_deg;
        let light = gpu.render(&scene, &scene.cameras[0], Ask::EXACT).light();
        // Columns where the ball's normal is halfway between the viewer and -X, the viewer, and +X.
        let [width, height] = crate::SIZE.map(|n| n as usize);
        let half_ball = height / 2;
        let offset = (half_ball as f64 * std::f64::consts::FRAC_1_SQRT_2) as usize;
        let red = |x: usize| light[height / 2 * width + x].x > 0.4;
        found.push([red(width / 2 - offset), red(width / 2), red(width / 2 + offset)]);
    }
    gpu.finish();
    assert_eq!(found, [[true, false, false], [false, true, false], [false, false, true]]);
}

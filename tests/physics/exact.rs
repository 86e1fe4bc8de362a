//! The `exact` layout's pictures against the reference's own, from visibility to tone curve.

use ontile::glam::{Vec3, Vec3Swizzles};
use ontile::plan::{GBuffer, Options, Path, Tonemap};
use ontile::reference::{Settings, render};
use ontile::scene::{Camera, GlobeMap, GlobePicture, LightKind, Scene};

use crate::error::{Errors, MAX_RELATIVE_ERROR};
use crate::gpu::{Ask, Gpu, Rendered};
use crate::{light_scenes, scenes};

/// Every path that takes its own turn at the light.
const PATHS: [Path; 3] = [Path::Deferred, Path::Forward, Path::ForwardMultipass];

fn compare(rendered: &Rendered, scene: &Scene, camera: &Camera, settings: &Settings) -> Errors {
    Errors::of_display(&render(scene, camera, settings), &rendered.light())
}

#[test]
fn linear_light_is_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let mut failed = Vec::new();
    for scene in scenes::all() {
        for camera in &scene.cameras {
            let all = PATHS.map(|path| gpu.render(&scene, camera, Ask { path, ..Ask::EXACT }));
            let expected = render(&scene, camera, &all[0].settings);
            for (path, rendered) in PATHS.iter().zip(&all) {
                let errors = Errors::of_display(&expected, &rendered.light());
                println!("{}, {}, {path}: {errors}", scene.name, camera.name);
                if let Err(reason) = errors.check() {
                    failed.push(format!("{}, {}, {path}: {reason}", scene.name, camera.name));
                }
            }
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn globe_maps_are_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let scene = light_scenes::globes();
    for camera in &scene.cameras {
        for path in [Path::Deferred, Path::Forward] {
            let rendered = gpu.render(&scene, camera, Ask { path, ..Ask::EXACT });
            let errors = compare(&rendered, &scene, camera, &rendered.settings);
            println!("{}, {path}: {errors}", camera.name);
            assert_eq!(errors.check_within(light_scenes::DECODED), Ok(()), "{}, {path}", camera.name);
        }
    }
    gpu.finish();
}

#[test]
fn every_curve_at_every_exposure_is_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let mut failed = Vec::new();
    for scene in [scenes::lights(), scenes::surfaces()] {
        let camera = &scene.cameras[0];
        for &tonemap in Tonemap::ALL {
            for exposure_ev in [-3.0, 0.0, 3.0] {
                let rendered = gpu.render(&scene, camera, Ask { tonemap, exposure_ev, ..Ask::EXACT });
                let errors = compare(&rendered, &scene, camera, &rendered.settings);
                println!("{}, {tonemap}, {exposure_ev:+} EV: {errors}", scene.name);
                if let Err(reason) = errors.check() {
                    failed.push(format!("{}, {tonemap}, {exposure_ev:+} EV: {reason}", scene.name));
                }
            }
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// A way in which the renderer might be wrong, done to what the reference is given instead.
type Fault = (&'static str, fn(&mut Scene, &mut Settings));

const FAULTS: &[Fault] = &[
    ("pi off by 1 %", |scene, _| {
        for light in &mut scene.lights {
            light.color *= 1.01;
        }
    }),
    ("one light off by 2 %", |scene, _| scene.lights[0].color *= 1.02),
    ("roughness off by 0.02", |scene, _| {
        for material in &mut scene.materials {
            material.roughness_factor += 0.02;
        }
    }),
    ("metallic off by 0.02", |scene, _| {
        for material in &mut scene.materials {
            material.metallic_factor = (material.metallic_factor - 0.02).abs();
        }
    }),
    ("normal axes swapped", |scene, _| {
        for normal in scene.meshes.iter_mut().flat_map(|m| &mut m.normals) {
            std::mem::swap(&mut normal.x, &mut normal.z);
        }
    }),
    ("spot cone in degrees of another angle", |scene, _| {
        for light in &mut scene.lights {
            if let LightKind::Spot { outer_cone_rad, .. } = &mut light.kind {
                *outer_cone_rad *= 0.98;
            }
        }
    }),
    ("range ignored", |scene, _| {
        for light in &mut scene.lights {
            light.range_m = None;
        }
    }),
    ("exposure off by 0.01 EV", |_, settings| settings.exposure_ev += 0.01),
    ("another curve", |_, settings| settings.tonemap = Tonemap::Aces),
    ("quantised", |_, settings| settings.gbuffer = Some(GBuffer::new(&Options::default()).unwrap())),
];

const EXTENT_FAULTS: &[Fault] = &[
    ("back colours off by 2 %", |scene, _| {
        for light in scene.lights.iter_mut().filter(|l| !matches!(l.kind, LightKind::Hemisphere { .. })) {
            light.back_color *= 1.02;
        }
    }),
    ("back light of a box ignored", |scene, _| scene.lights[3].back_color = Vec3::ZERO),
    ("a hemisphere's ground off by 2 %", |scene, _| scene.lights[1].back_color *= 1.02),
    ("a hemisphere upside down", |scene, _| scene.lights[2].direction_world = Vec3::X),
    ("boxes off by 1 %", |scene, _| {
        for light in &mut scene.lights {
            if let LightKind::Box { size_m, .. } = &mut light.kind {
                *size_m *= 1.01;
            }
        }
    }),
    ("a box's sides swapped", |scene, _| {
        for light in &mut scene.lights {
            if let LightKind::Box { size_m, .. } = &mut light.kind {
                *size_m = size_m.yxz();
            }
        }
    }),
    ("falloff off by 2 %", |scene, _| {
        for light in &mut scene.lights {
            if let LightKind::Box { falloff_m, .. } = &mut light.kind {
                *falloff_m *= 1.02;
            }
        }
    }),
    ("too much falloff not held to half the box", |scene, _| {
        if let LightKind::Box { falloff_m, .. } = &mut scene.lights[4].kind {
            *falloff_m = 0.6;
        }
    }),
    ("roll ignored", |scene, _| {
        scene.lights[3] = scene.lights[3].clone().towards(scene.lights[3].direction_world)
    }),
];

fn each_map(scene: &mut Scene, change: impl Fn(&mut GlobeMap)) {
    scene.lights.iter_mut().filter_map(|l| l.globe_map.as_mut()).for_each(change);
}

const GLOBE_FAULTS: &[Fault] = &[
    ("no globe maps", |scene, _| scene.lights.iter_mut().for_each(|l| l.globe_map = None)),
    ("turned the other way", |scene, _| each_map(scene, |map| map.rotation_rad *= -1.0)),
    ("turned by 3 degrees more", |scene, _| each_map(scene, |map| map.rotation_rad += 0.052)),
    ("pictures mirrored", |scene, _| {
        for image in &mut scene.images {
            let row = image.width as usize * 4;
            image.rgba8_mut().chunks_mut(row).for_each(|row| row.as_chunks_mut::<4>().0.reverse());
        }
    }),
    ("pictures upside down", |scene, _| {
        for image in &mut scene.images {
            image.rgba8_mut().as_chunks_mut::<4>().0.reverse();
        }
    }),
    ("sides of the cube swapped", |scene, _| {
        each_map(scene, |map| {
            if let GlobePicture::Cube { images } = &mut map.picture {
                images.swap(2, 3);
                images.swap(4, 5);
            }
        });
    }),
    ("colours taken as linear", |scene, _| {
        for image in &mut scene.images {
            image
                .rgba8_mut()
                .iter_mut()
                .for_each(|b| *b = (255.0 * (f32::from(*b) / 255.0).powf(1.0 / 2.2)) as u8);
        }
    }),
    ("the light behind comes through the map", |scene, _| scene.lights[2].back_color = Vec3::splat(0.05)),
];

#[test]
fn every_fault_of_globe_maps_is_caught() {
    catches(&light_scenes::globes(), light_scenes::DECODED, GLOBE_FAULTS);
}

#[test]
fn every_fault_is_caught() {
    catches(&scenes::lights(), MAX_RELATIVE_ERROR, FAULTS);
}

#[test]
fn every_fault_of_extents_is_caught() {
    catches(&light_scenes::extents(), MAX_RELATIVE_ERROR, EXTENT_FAULTS);
}

fn catches(scene: &Scene, bound: f64, faults: &[Fault]) {
    let Some(gpu) = Gpu::open() else { return };
    let camera = &scene.cameras[0];
    let rendered = gpu.render(scene, camera, Ask::EXACT);
    assert_eq!(compare(&rendered, scene, camera, &rendered.settings).check_within(bound), Ok(()));
    for (name, fault) in faults {
        let (mut faulty, mut settings) = (scene.clone(), rendered.settings.clone());
        fault(&mut faulty, &mut settings);
        let errors = compare(&rendered, &faulty, camera, &settings);
        println!("{name}: {errors}");
        assert!(errors.check_within(bound).is_err(), "{name}: not caught, {errors}");
    }
    let other = compare(&rendered, scene, &scene.cameras[1], &rendered.settings);
    assert!(other.check_within(bound).is_err(), "another camera: not caught, {other}");
    gpu.finish();
}

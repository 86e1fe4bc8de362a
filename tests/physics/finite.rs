//! No picture has a NaN or an infinity in it, wherever light, viewer and surface are.

use ontile::glam::DVec3;
use ontile::plan::Tonemap;
use ontile::reference::render;
use ontile::scene::{Camera, Projection};

use crate::gpu::{Ask, Gpu};
use crate::{light_scenes, scenes};

/// The first pixel that no display could show, if there is one.
fn first_bad(light: &[DVec3]) -> Option<(usize, DVec3)> {
    light.iter().copied().enumerate().find(|(_, light)| !light.is_finite() || light.min_element() < 0.0)
}

#[test]
fn every_picture_is_finite_and_not_negative() {
    let Some(gpu) = Gpu::open() else { return };
    for scene in scenes::all().into_iter().chain([light_scenes::globes()]) {
        for camera in &scene.cameras {
            for &tonemap in Tonemap::ALL {
                for exposure_ev in [-20.0, 0.0, 20.0] {
                    let rendered = gpu.render(&scene, camera, Ask { tonemap, exposure_ev, ..Ask::EXACT });
                    let bad = first_bad(&rendered.light());
                    assert_eq!(bad, None, "{}, {}, {tonemap}, {exposure_ev} EV", scene.name, camera.name);
                }
            }
        }
    }
    gpu.finish();
}

#[test]
fn light_straight_at_the_viewer_is_dark_not_nan() {
    let Some(gpu) = Gpu::open() else { return };
    let scene = scenes::orthographic_along_light();
    let seen = |camera: &Camera| {
        let light = gpu.render(&scene, camera, Ask::EXACT).light();
        assert_eq!(first_bad(&light), None, "{}", camera.name);
        light.iter().map(|l| l.max_element()).fold(0.0, f64::max)
    };
    let [from_the_light, towards_the_light] = [0, 1].map(|i| seen(&scene.cameras[i]));
    assert!(from_the_light > 0.1, "{from_the_light}");
    // Every surface that is seen turns its back on the only light.
    assert_eq!(towards_the_light, 0.0);
    let Projection::Orthographic { .. } = scene.cameras[1].projection else { panic!("rays are parallel") };
    let reference =
        render(&scene, &scene.cameras[1], &gpu.render(&scene, &scene.cameras[1], Ask::EXACT).settings);
    assert!(reference.pixels.iter().any(|p| p.covered));
    gpu.finish();
}

#[test]
fn a_nan_or_a_negative_value_is_found() {
    for bad in [f64::NAN, f64::INFINITY, -1e-9] {
        let mut light = vec![DVec3::ONE; 4];
        assert_eq!(first_bad(&light), None);
        light[2].z = bad;
        assert!(first_bad(&light).is_some());
    }
}

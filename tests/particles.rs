//! Particles that a host replaces from frame to frame, and several samples a pixel of what reads the depth behind it.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes::media_scenes::water;
use common::scenes::particle_scenes::sparks;
use ontile::glam::{DVec3, Vec3};
use ontile::gpu::{RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Layout, Options, OutputFormat, Tonemap};
use ontile::reference::Settings;
use ontile::reference::samples::{STANDARD_4, supersampled};
use ontile::scene::{Particle, Scene};

const SIZE: [u32; 2] = [160, 90];

#[test]
fn particles_change_from_frame_to_frame() {
    on_device(None, |gpu| {
        let mut scene = sparks().without_shadows();
        let plan = gpu.plan(&scene, Options { size: SIZE, ..Options::default() });
        let mut offscreen = gpu.offscreen(&scene, plan.clone(), RendererConfig::default());
        let camera = scene.cameras[0].clone();
        let mut frame = |lists: &[(usize, Vec<Particle>)]| {
            for (index, list) in lists {
                offscreen.renderer_mut().set_particles(*index, list).unwrap();
            }
            offscreen.render(&View { camera: &camera, exposure_ev: 0.0 }).unwrap();
            offscreen.picture()
        };
        let before = frame(&[]);
        let mut moved = scene.particles[0].list.clone();
        moved.iter_mut().for_each(|p| p.position_world += Vec3::new(0.2, 0.1, 0.0));
        let fewer = scene.particles[1].list[..1].to_vec();
        let after = frame(&[(0, moved.clone()), (1, fewer.clone())]);
        (scene.particles[0].list, scene.particles[1].list) = (moved, fewer);
        assert!(difference(&before, &after).is_some(), "nothing has changed");
        // The plan knows how many there may be.
        let made = gpu.picture(&scene, plan, 0.0);
        assert_eq!(difference(&made, &after), None);
        let none = frame(&[(0, Vec::new()), (1, Vec::new())]);
        assert!(difference(&none, &after).is_some());

        let one = scene.particles[0].list[0];
        let bad = Particle { size_m: f32::NAN, ..one };
        for (index, list, part) in [
            (9, vec![], "no particles 9"),
            (0, vec![one; 4], "more than the 3"),
            (1, vec![bad], "size is not finite"),
        ] {
            let error = offscreen.renderer_mut().set_particles(index, &list).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    });
}

/// Drawn with four samples a pixel.
fn of_samples(gpu: &Gpu<'_>, scene: &Scene) -> Picture {
    let options = Options {
        size: SIZE,
        samples: 4,
        layout: Layout::Exact,
        output: OutputFormat::Rgba32Float,
        tonemap: Tonemap::Aces,
        ..Options::default()
    };
    gpu.picture(scene, gpu.plan(scene, options), 0.0)
}

/// What the reference makes of it with samples in the same places.
fn referred(scene: &Scene) -> Vec<DVec3> {
    let settings = Settings { size: SIZE, tonemap: Tonemap::Aces, ..Settings::default() };
    supersampled(scene, &scene.cameras[0], &settings, &STANDARD_4, |pixel| pixel.display)
}

/// Four samples a pixel: the fade of a pixel is the mean over the samples that particles are in front of, and a square's edge is as
/// smooth as a triangle's.
#[test]
fn samples_of_particles_are_those_of_the_reference() {
    /// Of display light, root of the mean square over all pixels: what the mean fade is off by where one pixel has two depths, and the
    /// texture's filter.
    const MAX_RMS: f64 = 0.004;
    on_device(None, |gpu| {
        let mut scene = sparks().without_shadows();
        // Light of particles alone: what is lit has its own tests.
        scene.lights.clear();
        let picture = of_samples(gpu, &scene);
        let expected = referred(&scene);
        let rms = rms(&picture, &expected);
        println!("off by {rms:.5}");
        assert!(rms < MAX_RMS, "{rms}");
        scene.particles[0].soft_m = 0.0;
        let hard = referred(&scene);
        assert!(self::rms(&picture, &hard) > MAX_RMS, "a hard cut is not told apart");
    });
}

/// Likewise what lets light through: the way of a pixel is that of the samples that are behind it.
#[test]
fn samples_of_water_are_those_of_the_reference() {
    /// Of display light, root of the mean square over all pixels: surfaces lit once a pixel, and the mean way where one has two depths.
    const MAX_RMS: f64 = 0.008;
    on_device(None, |gpu| {
        let mut scene = water().without_shadows();
        let picture = of_samples(gpu, &scene);
        let expected = referred(&scene);
        let found = rms(&picture, &expected);
        println!("off by {found:.5}");
        assert!(found < MAX_RMS, "{found}");
        let media = scene.materials.iter_mut().filter_map(|m| m.transmission.as_mut());
        media.for_each(|t| t.attenuation_distance_m *= 1.5);
        let clearer = referred(&scene);
        assert!(rms(&picture, &clearer) > MAX_RMS, "clearer water is not told apart");
    });
}

fn rms(picture: &Picture, expected: &[DVec3]) -> f64 {
    let Pixels::Rgba32F(found) = &picture.pixels else { unreachable!() };
    let errors = found.chunks_exact(4).zip(expected).map(|(found, expected)| {
        let found = DVec3::new(found[0].into(), found[1].into(), found[2].into());
        found.distance_squared(*expected)
    });
    (errors.sum::<f64>() / expected.len() as f64).sqrt()
}

//! Images that lie as a turned screen does show the picture that upright ones show.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes;
use ontile::gpu::{OverlayFrame, OverlayPart, OverlayVertex, RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Layout, LightWay, Options, OutputFormat, Path, Refraction, Translucency};
use ontile::scene::{PreRotation, Scene};

/// Of the upright picture.
const SIZE: [u32; 2] = [120, 70];

/// The scene's first camera, drawn to images that are turned, and turned back.
fn drawn(gpu: &Gpu<'_>, scene: &Scene, options: &Options, pre_rotation: PreRotation) -> Picture {
    let options = Options { size: pre_rotation.size(SIZE), ..options.clone() };
    let mut offscreen = gpu.offscreen(scene, gpu.plan(scene, options), RendererConfig::default());
    offscreen.pre_rotate(pre_rotation);
    if offscreen.renderer().plan().options.overlay {
        let renderer = offscreen.renderer_mut();
        renderer.set_overlay_image([1, 1], &[255; 4]).unwrap();
        let at = |x: f32, y: f32| OverlayVertex {
            position: [x, y],
            texcoord: [0.5; 2],
            color: [90, 40, 200, 255],
        };
        let frame = OverlayFrame {
            vertices: &[at(3.0, 2.0), at(23.0, 2.0), at(23.0, 9.0), at(3.0, 9.0)],
            indices: &[0, 1, 2, 0, 2, 3],
            parts: &[OverlayPart { clip_px: [10, 0, 44, 15], indices: 0..6 }],
            pixels_per_point: 2.0,
        };
        renderer.set_overlay(0, &frame).unwrap();
    }
    offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 }).unwrap();
    offscreen.picture().upright(pre_rotation)
}

/// The share of pixels that differ by more than this of the light, or of white where there is less.
fn differing(a: &Picture, b: &Picture, more_than: f32) -> f64 {
    let (Pixels::Rgba32F(a), Pixels::Rgba32F(b)) = (&a.pixels, &b.pixels) else { panic!("floats") };
    let differ =
        |(a, b): &(&[f32], &[f32])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > more_than * a.max(1.0));
    let count = a.chunks(4).zip(b.chunks(4)).filter(differ).count();
    count as f64 / (a.len() / 4) as f64
}

/// Pixels that may differ by more than the second number. Filtered textures differ by a step of lavapipe's weights, of which there are
/// 256 a texel, and edges where a pixel's centre lies upon them. A wrong turn changes a third of the pixels or more.
const SHARES: [(f64, f32); 2] = [(0.03, 1e-3), (0.002, 1e-2)];

#[track_caller]
fn check(gpu: &Gpu<'_>, scene: &Scene, options: &Options) {
    let upright = drawn(gpu, scene, options, PreRotation::Identity);
    for pre_rotation in &PreRotation::ALL[1..] {
        let turned = drawn(gpu, scene, options, *pre_rotation);
        for (most, error) in SHARES {
            let share = differing(&upright, &turned, error);
            assert!(
                share <= most,
                "{} {pre_rotation:?} {options:?}: {share} of the pixels differ by more than {error}",
                scene.name
            );
        }
    }
}

fn exact() -> Options {
    Options { layout: Layout::Exact, output: OutputFormat::Rgba32Float, ..Options::default() }
}

#[test]
fn turned_images_show_what_upright_ones_do() {
    on_device(None, |gpu| {
        for scene in scenes::built() {
            check(gpu, &scene, &exact());
        }
    });
}

/// What goes by places in the picture, or draws by itself.
#[test]
fn so_does_whatever_looks_at_pixels() {
    on_device(None, |gpu| {
        let lit = scenes::lights_only();
        for lights in [LightWay::Volumes, LightWay::Stencil, LightWay::Clusters] {
            check(gpu, &lit, &Options { lights, ..exact() });
        }
        let feature = scenes::every_feature();
        check(gpu, &feature, &Options { samples: 4, ..exact() });
        check(gpu, &feature, &Options { path: Path::Forward, ..exact() });
        check(gpu, &feature, &Options { edge_filter: true, ..exact() });
        let volumes = Options { shadow_volumes: true, ..exact() };
        scenes::shadow_scenes::one_light_each().iter().for_each(|scene| check(gpu, scene, &volumes));
        let water = scenes::media_scenes::water_and_more();
        check(gpu, &water, &Options { refraction: Refraction::Pass, ..exact() });
        let oit = Options { translucency: Translucency::Oit, layout: Layout::Packed128, ..exact() };
        check(gpu, &scenes::glass_scenes::crossing(), &oit);
        // Spins that are no quarter of a turn.
        let mut sparks = scenes::particle_scenes::sparks();
        for (i, particle) in sparks.particles.iter_mut().flat_map(|p| &mut p.list).enumerate() {
            particle.rotation_rad = 0.4 + 0.3 * i as f32;
            particle.size_m *= 3.0;
        }
        check(gpu, &sparks, &exact());
    });
}

/// Its corners lie between pixels, so nothing is left to rounding.
#[test]
fn overlays_turn_to_the_pixel() {
    on_device(None, |gpu| {
        let scene = scenes::nothing();
        let options = Options { overlay: true, ..exact() };
        let upright = drawn(gpu, &scene, &options, PreRotation::Identity);
        let Pixels::Rgba32F(channels) = &upright.pixels else { panic!("floats") };
        let inside = [[10, 4], [43, 14]].map(|[x, y]| 4 * (y * SIZE[0] as usize + x));
        let outside = [[9, 4], [44, 14], [10, 3], [43, 15]].map(|[x, y]| 4 * (y * SIZE[0] as usize + x));
        assert!(inside.iter().all(|at| channels[*at..][..3] != channels[..3]));
        assert!(outside.iter().all(|at| channels[*at..][..3] == channels[..3]));
        for pre_rotation in &PreRotation::ALL[1..] {
            let turned = drawn(gpu, &scene, &options, *pre_rotation);
            assert_eq!(difference(&upright, &turned), None, "{pre_rotation:?}");
        }
    });
}

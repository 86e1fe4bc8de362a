//! What a host draws over the picture, in the pass: where it lands, what colours become, and that it changes nothing else.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes;
use ontile::gpu::{OverlayFrame, OverlayPart, OverlayVertex, RendererConfig, View};
use ontile::picture::{Picture, Pixels, linear_from_srgb, srgb_from_linear};
use ontile::plan::{BloomWay, Limits, Needs, Options, Path, Plan, Strategy};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [96, 64];

/// In points of two pixels: an opaque rectangle, one of half of it, and a third that is cut.
const COLORS: [[u8; 4]; 3] = [[200, 100, 50, 255], [100, 50, 25, 128], [0, 0, 255, 255]];

fn small() -> Options {
    Options { size: SIZE, overlay: true, ..Options::default() }
}

/// A picture with the rectangles over it.
fn drawn(gpu: &Gpu<'_>, scene: &Scene, options: Options) -> Picture {
    let mut offscreen = gpu.offscreen(scene, gpu.plan(scene, options), RendererConfig::default());
    let mut vertices = Vec::new();
    for (i, color) in (0_u8..).zip(COLORS) {
        let x = 2.0 + 12.0 * f32::from(i);
        for (dx, dy) in [(0.0, 0.0), (8.0, 0.0), (8.0, 8.0), (0.0, 8.0)] {
            vertices.push(OverlayVertex { position: [x + dx, 2.0 + dy], texcoord: [0.5; 2], color });
        }
    }
    let indices: Vec<u32> = (0..3).flat_map(|i| [0, 1, 2, 0, 2, 3].map(|n| 4 * i + n)).collect();
    let parts = [
        OverlayPart { clip_px: [0, 0, 1000, 1000], indices: 0..12 },
        OverlayPart { clip_px: [52, 4, 60, 20], indices: 12..18 },
        OverlayPart { clip_px: [200, 0, 300, 10], indices: 0..18 },
    ];
    let frame = OverlayFrame { vertices: &vertices, indices: &indices, parts: &parts, pixels_per_point: 2.0 };
    let renderer = offscreen.renderer_mut();
    renderer.set_overlay_image([2, 1], &[255; 8]).unwrap();
    renderer.set_overlay(0, &frame).unwrap();
    for _ in 0..offscreen.renderer().plan().frames_to_settle() {
        offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 }).unwrap();
    }
    offscreen.picture()
}

fn pixels(picture: &Picture) -> Vec<[u8; 4]> {
    let Pixels::Rgba8(bytes) = &picture.pixels else { panic!("8 bits a channel") };
    bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
}

#[test]
fn what_is_drawn_over_lands_where_it_should_and_mixes_as_light() {
    on_device(None, |gpu| {
        let scene = scenes::every_feature();
        let plain =
            pixels(&gpu.picture(&scene, gpu.plan(&scene, Options { overlay: false, ..small() }), 0.0));
        let over = pixels(&drawn(gpu, &scene, small()));
        let within = |x: u32, y: u32, [left, top, right, bottom]: [u32; 4]| {
            (left..right).contains(&x) && (top..bottom).contains(&y)
        };
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let at = (y * SIZE[0] + x) as usize;
                if within(x, y, [4, 4, 20, 20]) {
                    assert_eq!(over[at], COLORS[0], "opaque at {x}, {y}");
                } else if within(x, y, [28, 4, 44, 20]) {
                    for channel in 0..3 {
                        let linear = |value: u8| linear_from_srgb(f32::from(value) / 255.0);
                        let mixed = linear(COLORS[1][channel])
                            + linear(plain[at][channel]) * (1.0 - f32::from(COLORS[1][3]) / 255.0);
                        let expected = srgb_from_linear(mixed.min(1.0)) * 255.0;
                        // The attachment rounds once more than this does: to 8 bits below what is mixed and above.
                        let off = (f32::from(over[at][channel]) - expected).abs();
                        assert!(off <= 1.0, "mixed at {x}, {y}: {} is not {expected}", over[at][channel]);
                    }
                    assert_eq!(over[at][3], 255, "the picture stays opaque at {x}, {y}");
                } else if within(x, y, [52, 4, 60, 20]) {
                    assert_eq!(over[at], COLORS[2], "cut at {x}, {y}");
                } else {
                    assert_eq!(over[at], plain[at], "nothing is over {x}, {y}");
                }
            }
        }
    });
}

#[test]
fn arrangements_do_not_change_the_pixels_with_an_overlay() {
    on_device(None, |gpu| {
        for scene in [scenes::every_feature(), scenes::lights_only(), scenes::before_sky()] {
            for samples in [1, 4] {
                for path in [Path::Deferred, Path::Forward] {
                    let options = Options { samples, path, ..small() };
                    let expected = drawn(gpu, &scene, options.clone());
                    for other in [
                        Options { strategy: Strategy::Separate, ..options.clone() },
                        Options { recycle: false, ..options.clone() },
                        Options { output_is_input_attachment: false, ..options.clone() },
                    ] {
                        let difference = difference(&expected, &drawn(gpu, &scene, other.clone()));
                        assert_eq!(difference, None, "{}: {other:?}", scene.name);
                    }
                }
            }
        }
    });
}

/// A pipeline, and nothing of memory.
#[test]
fn an_overlay_adds_a_draw_and_no_byte() {
    let scene = scenes::every_feature();
    for options in [small(), Options { samples: 4, ..small() }, Options { path: Path::Forward, ..small() }] {
        let plan = |options| Plan::new(Needs::of(&scene), options, &Limits::default()).unwrap();
        let (with, without) = (plan(options.clone()), plan(Options { overlay: false, ..options }));
        assert_eq!(with.pipelines.len(), without.pipelines.len() + 1);
        assert_eq!(with.passes, without.passes);
        let bytes = |plan: &Plan| {
            let totals = plan.report(&scene).totals;
            [totals.loaded_bytes_per_pixel.value, totals.stored_bytes_per_pixel.value]
        };
        assert_eq!(bytes(&with), bytes(&without));
        assert!(with.notes.iter().any(|note| note.starts_with("overlay: ")));
    }
}

/// Light that is stored beside the picture is the scene's own: where nothing is drawn over, scattered light is as without an overlay.
#[test]
fn nothing_of_an_overlay_is_scattered_from_light_that_is_stored() {
    on_device(None, |gpu| {
        let scene = scenes::every_feature();
        for strategy in [Strategy::Subpasses, Strategy::Separate] {
            for fold in [true, false] {
                let options =
                    Options { bloom: BloomWay::Store, bloom_strength: 0.5, strategy, fold, ..small() };
                let over = pixels(&drawn(gpu, &scene, options.clone()));
                let plan = gpu.plan(&scene, Options { overlay: false, ..options });
                let mut plain = gpu.offscreen(&scene, plan, RendererConfig::default());
                for _ in 0..plain.renderer().plan().frames_to_settle() {
                    plain.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 }).unwrap();
                }
                let plain = pixels(&plain.picture());
                let is_over = |at: usize| {
                    let (x, y) = (at as u32 % SIZE[0], at as u32 / SIZE[0]);
                    (4..20).contains(&y) && (4..60).contains(&x)
                };
                let others = (0..plain.len()).filter(|at| !is_over(*at));
                others.for_each(|at| assert_eq!(over[at], plain[at], "{strategy}, pixel {at}"));
                assert_eq!(over[(10 * SIZE[0] + 10) as usize], COLORS[0], "{strategy}");
            }
        }
    });
}

#[test]
fn what_cannot_be_drawn_over_is_refused() {
    let scene = scenes::every_feature();
    on_device(None, |gpu| {
        let mut plain = gpu.offscreen(
            &scene,
            gpu.plan(&scene, Options { overlay: false, ..small() }),
            RendererConfig::default(),
        );
        let error = plain.renderer_mut().set_overlay(0, &triangle(&[0, 1, 2], &[])).unwrap_err();
        assert!(error.to_string().contains("no overlay"), "{error}");
        let mut over = gpu.offscreen(&scene, gpu.plan(&scene, small()), RendererConfig::default());
        let renderer = over.renderer_mut();
        let part = |indices| [OverlayPart { clip_px: [0, 0, 9, 9], indices }];
        for (last, end) in [(3, 3), (2, 4)] {
            let error = renderer.set_overlay(0, &triangle(&[0, 1, last], &part(0..end))).unwrap_err();
            assert!(error.to_string().contains("beyond"), "{error}");
        }
        let flat = OverlayFrame { pixels_per_point: f32::NAN, ..triangle(&[0, 1, 2], &[]) };
        assert!(renderer.set_overlay(0, &flat).is_err());
        assert!(renderer.set_overlay_image([2, 2], &[0; 4]).is_err());
    });
}

fn triangle<'a>(indices: &'a [u32], parts: &'a [OverlayPart]) -> OverlayFrame<'a> {
    const CORNERS: [OverlayVertex; 3] =
        [OverlayVertex { position: [0.0; 2], texcoord: [0.0; 2], color: [0; 4] }; 3];
    OverlayFrame { vertices: &CORNERS, indices, parts, pixels_per_point: 1.0 }
}

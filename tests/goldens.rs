//! Pictures that people have looked at. They are lavapipe's: `ONTILE_UPDATE=1 cargo test --test goldens` rewrites them.

mod common;

use common::expected::Expected;
use common::render::{LAVAPIPE, on_device};
use common::{environments, scenes};
use ontile::gpu::{RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{BloomWay, Options, Refraction};
use ontile::scene::Scene;
use std::io::Cursor;

const SIZE: [u32; 2] = [160, 90];

/// Versions of lavapipe and of the LLVM below it contract and reorder float operations differently, which moves an
/// 8-bit channel by a step; texture filtering with its own rounding of weights by another.
const MOST_STEPS: u8 = 2;

/// Pixels at the edges of triangles, shadows of alpha masks and the like may fall to the other side: 14 of 14,400.
const OUTLIER_SHARE: f64 = 0.001;

/// What is too far apart.
fn difference(expected: &Picture, actual: &Picture) -> Option<String> {
    if [expected.width, expected.height] != [actual.width, actual.height] {
        return Some(format!("{}x{} expected", expected.width, expected.height));
    }
    let [Pixels::Rgba8(a), Pixels::Rgba8(b)] = [&expected.pixels, &actual.pixels] else {
        return Some("8 bits a channel expected".into());
    };
    let steps = |(a, b): (&[u8], &[u8])| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    let steps: Vec<_> = a.chunks(4).zip(b.chunks(4)).map(steps).collect();
    let outliers = steps.iter().filter(|&&s| s > MOST_STEPS).count();
    let most = steps.iter().max().copied().unwrap_or(0);
    (outliers as f64 > OUTLIER_SHARE * steps.len() as f64)
        .then(|| format!("{outliers} pixels differ by more than {MOST_STEPS} steps, the worst by {most}"))
}

fn png(picture: &Picture) -> Vec<u8> {
    let Pixels::Rgba8(channels) = &picture.pixels else { panic!("goldens have 8 bits a channel") };
    let mut bytes = Cursor::new(Vec::new());
    let (color, format) = (image::ExtendedColorType::Rgba8, image::ImageFormat::Png);
    image::write_buffer_with_format(&mut bytes, channels, picture.width, picture.height, color, format)
        .expect("PNG can be encoded");
    bytes.into_inner()
}

fn from_png(bytes: &[u8]) -> Result<Picture, String> {
    let decoded = image::load_from_memory(bytes).map_err(|e| e.to_string())?.into_rgba8();
    let (width, height) = decoded.dimensions();
    Ok(Picture { width, height, pixels: Pixels::Rgba8(decoded.into_raw()) })
}

#[test]
fn pictures_look_as_expected() {
    on_device(Some(LAVAPIPE), |gpu| {
        let mut expected = Expected::in_folder("golden");
        let mut all = scenes::shipped();
        all.extend([scenes::every_feature(), environments::environment(), environments::probes()]);
        let mut names = Vec::new();
        let plain = |scene: Scene| (scene.name.clone(), scene, Options { size: SIZE, ..Options::default() });
        let samples = Options { samples: 4, size: SIZE, ..Options::default() };
        let bloom =
            Options { bloom: BloomWay::Previous, bloom_strength: 0.2, size: SIZE, ..Options::default() };
        let named = |name: &str| all.iter().find(|scene| scene.name == name).expect("it is shipped").clone();
        let (lamps, pool) = (named("lamps"), named("pool"));
        let refraction = Options { refraction: Refraction::Pass, size: SIZE, ..Options::default() };
        let mut all: Vec<_> = all.into_iter().map(plain).collect();
        all.push(("every_feature_4_samples".into(), scenes::every_feature(), samples.clone()));
        all.push(("stop_4_samples".into(), scenes::tram_stop(), samples));
        all.push(("lamps_bloom".into(), lamps, bloom));
        all.push(("pool_refraction".into(), pool, refraction));
        let moving = scenes::shipped_files().into_iter().find(|file| file.ends_with("charmer.glb"));
        let moving = Scene::load_moving(&moving.expect("it is shipped")).expect("it loads");
        let moving = scenes::moving_scenes::moved(moving, 1.3);
        all.push(("charmer_moving".into(), moving, Options { size: SIZE, ..Options::default() }));
        for (name, scene, options) in all {
            let mut offscreen = gpu.offscreen(&scene, gpu.plan(&scene, options), RendererConfig::default());
            let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
            // Bloom is of the frame before.
            let frames = if name.ends_with("bloom") { 2 } else { 1 };
            (0..frames)
                .for_each(|_| offscreen.render(&view).unwrap_or_else(|error| panic!("{name}: {error}")));
            let picture = offscreen.picture();
            let name = format!("{name}.png");
            expected.check(&name, &png(&picture), |file| match from_png(file) {
                Ok(golden) => difference(&golden, &picture),
                Err(error) => Some(error),
            });
            names.push(name);
        }
        expected.nothing_else(&names);
        expected.finish();
    });
}

#[test]
fn a_tampered_golden_is_seen() {
    on_device(Some(LAVAPIPE), |gpu| {
        let scene = scenes::every_feature();
        let options = Options { size: SIZE, ..Options::default() };
        let picture = gpu.picture(&scene, gpu.plan(&scene, options), 0.0);
        assert_eq!(from_png(&png(&picture)).as_ref(), Ok(&picture), "PNG keeps every bit");
        let tampered = |tamper: &dyn Fn(&mut [u8])| {
            let mut golden = picture.clone();
            let Pixels::Rgba8(channels) = &mut golden.pixels else { unreachable!() };
            tamper(channels);
            difference(&golden, &picture)
        };
        assert_eq!(tampered(&|_| ()), None);
        let one_off = |c: &mut u8| *c = c.saturating_add(1);
        assert_eq!(
            tampered(&|channels| channels.iter_mut().for_each(one_off)),
            None,
            "rounding is tolerated"
        );
        let brighter = |c: &mut u8| *c = if *c < 128 { *c + 3 } else { *c - 3 };
        let seen = [
            ("all a little brighter", tampered(&|channels| channels.iter_mut().for_each(brighter))),
            ("red and blue swapped", tampered(&|channels| channels.chunks_mut(4).for_each(|p| p.swap(0, 2)))),
            ("a pixel aside", tampered(&|channels| channels.rotate_right(4))),
            ("a patch of 4 by 4", {
                let patch = |p: usize| p % 160 < 4 && p / 160 < 4;
                tampered(&|channels| {
                    let pixels = channels.chunks_mut(4).enumerate().filter(|(p, _)| patch(*p));
                    pixels.for_each(|(_, channels)| channels.iter_mut().for_each(brighter));
                })
            }),
        ];
        for (what, difference) in seen {
            assert!(difference.is_some(), "not seen: {what}");
        }
    });
}

//! Decals: one picture in whatever way they are ordered.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes::decal_scenes::{color_decals, decals};
use ontile::picture::Picture;
use ontile::picture::Pixels;
use ontile::plan::{Choice, DecalWay, Layout, LightWay, Needs, Options, Plan, Strategy};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [128, 72];

/// The picture, if the device and the layout allow the way.
fn painted(gpu: &Gpu<'_>, scene: &Scene, options: &Options, decals: DecalWay) -> Option<Picture> {
    let options = Options { decals, ..options.clone() };
    let plan = Plan::new(Needs::of(scene), options.clone(), &gpu.device().caps().limits());
    plan.is_ok().then(|| gpu.picture(scene, gpu.plan(scene, options), 0.0))
}

/// How many steps of 255 pictures are apart at most.
fn steps_apart(a: &Picture, b: &Picture) -> u8 {
    let [Pixels::Rgba8(a), Pixels::Rgba8(b)] = [&a.pixels, &b.pixels] else { panic!("8 bits are compared") };
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// Blending rounds what it mixes as storing what a shader has mixed does, but may mix with fewer bits: half a code of base colour,
/// which in 8 bits without gamma is up to 4 steps of the picture where it is dark.
const BLENDED_STEPS: u8 = 4;

#[test]
fn every_way_gives_the_same_picture() {
    on_device(None, |gpu| {
        let (mut ordered, mut blended, mut most) = (0, 0, 0);
        for scene in [decals().without_shadows(), color_decals().without_shadows()] {
            for choice in Choice::one_by_one(Choice::of(Layout::Ontile128)) {
                for lights in [LightWay::Auto, LightWay::Volumes] {
                    let options = choice.apply(&Options { size: SIZE, lights, ..Options::default() });
                    let Some(expected) = painted(gpu, &scene, &options, DecalWay::Barrier) else { continue };
                    let name = format!("{}, {choice}, {lights}", scene.name);
                    if let Some(picture) = painted(gpu, &scene, &options, DecalWay::RasterOrder) {
                        assert_eq!(difference(&expected, &picture), None, "{name}");
                        ordered += 1;
                    }
                    if let Some(picture) = painted(gpu, &scene, &options, DecalWay::Fixed) {
                        let steps = steps_apart(&expected, &picture);
                        assert!(steps <= BLENDED_STEPS, "{name}: {steps} steps");
                        most = most.max(steps);
                        blended += 1;
                    }
                    let separate = Options { strategy: Strategy::Separate, ..options.clone() };
                    let picture = painted(gpu, &scene, &separate, DecalWay::Barrier).expect("as in one pass");
                    assert_eq!(difference(&expected, &picture), None, "{name}, separate");
                }
            }
        }
        println!("{ordered} in raster order alike; {blended} blended, at most {most} steps of 255 apart");
    });
}

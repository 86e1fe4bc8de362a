//! Lit as they are drawn, surfaces look as they do when they are lit from a G-buffer that rounds nothing.

mod common;

use common::render::{Gpu, difference, on_device, on_device_with_faults};
use common::scenes;
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Layout, Limits, Needs, Options, OutputFormat, Path, Plan, Strategy, Tonemap};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [160, 90];

/// Room for arithmetic in 32-bit floats that compilers contract and reorder: some hundred roundings of 2^-24, relative
/// to the channel ...
const MOST_RELATIVE: f32 = 128.0 / (1 << 24) as f32;
/// ... or to this, where tone curves subtract: a tenth of the first step of 8 bits in sRGB.
const FLOOR: f32 = 3.0e-5;
/// The same difference may fall to either side of a step of 8 bits.
const MOST_STEPS: u8 = 1;

fn options(path: Path) -> Options {
    Options { size: SIZE, layout: Layout::Exact, path, ..Options::default() }
}

fn all_scenes() -> Vec<Scene> {
    scenes::built().into_iter().chain(scenes::shipped()).collect()
}

fn picture(gpu: &Gpu<'_>, scene: &Scene, options: Options) -> Picture {
    gpu.picture(scene, gpu.plan(scene, options), 0.0)
}

/// What is further apart than rounding takes it: not one pixel may be.
fn beyond_rounding(a: &Picture, b: &Picture) -> Option<String> {
    let far: Vec<bool> = match (&a.pixels, &b.pixels) {
        (Pixels::Rgba32F(a), Pixels::Rgba32F(b)) => {
            let near = |a: f32, b: f32| (a - b).abs() <= MOST_RELATIVE * a.abs().max(b.abs()).max(FLOOR);
            a.iter().zip(b).map(|(&a, &b)| !near(a, b)).collect()
        }
        (Pixels::Rgba8(a), Pixels::Rgba8(b)) => {
            a.iter().zip(b).map(|(a, b)| a.abs_diff(*b) > MOST_STEPS).collect()
        }
        _ => panic!("pictures of two formats"),
    };
    let count = far.iter().filter(|&&far| far).count();
    let first = far.iter().position(|&far| far)? as u32 / 4;
    Some(format!("{count} channels differ, the first at {}, {}", first % a.width, first / a.width))
}

fn each_case(mut check: impl FnMut(Tonemap, OutputFormat)) {
    for &tonemap in Tonemap::ALL {
        for output in [OutputFormat::Rgba8Srgb, OutputFormat::Rgba32Float] {
            check(tonemap, output);
        }
    }
}

#[test]
fn forward_looks_like_deferred() {
    on_device(None, |gpu| {
        let check = |scene: &Scene, tonemap, output| {
            let of = |path| picture(gpu, scene, Options { tonemap, output, ..options(path) });
            let far = beyond_rounding(&of(Path::Deferred), &of(Path::Forward));
            assert_eq!(far, None, "{}, {tonemap}, {output}", scene.name);
        };
        scenes::built().iter().for_each(|scene| each_case(|tonemap, output| check(scene, tonemap, output)));
        let exact = (Tonemap::Neutral, OutputFormat::Rgba32Float);
        scenes::shipped().iter().for_each(|scene| check(scene, exact.0, exact.1));
    });
}

#[test]
fn arrangements_of_forward_do_not_change_the_pixels() {
    type Change = fn(Options) -> Options;
    const CHANGES: [(&str, Change); 6] = [
        ("separate", |o| Options { strategy: Strategy::Separate, ..o }),
        ("depth pre-pass", |o| Options { depth_prepass: true, ..o }),
        ("separate, depth pre-pass", |o| Options { strategy: Strategy::Separate, depth_prepass: true, ..o }),
        ("not recycled", |o| Options { recycle: false, ..o }),
        ("another layout", |o| Options { layout: Layout::Metallic128, ..o }),
        ("output not an input attachment", |o| Options { output_is_input_attachment: false, ..o }),
    ];
    on_device(None, |gpu| {
        for scene in all_scenes() {
            let expected = picture(gpu, &scene, options(Path::Forward));
            for (name, change) in CHANGES {
                let changed = picture(gpu, &scene, change(options(Path::Forward)));
                assert_eq!(difference(&expected, &changed), None, "{}, {name}", scene.name);
            }
        }
    });
}

#[test]
fn what_rounding_does_not_explain_is_seen() {
    on_device_with_faults(|gpu| {
        let scene = scenes::every_feature();
        each_case(|tonemap, output| {
            let of = |scene: &Scene, path| picture(gpu, scene, Options { tonemap, output, ..options(path) });
            let deferred = of(&scene, Path::Deferred);
            for light in 0..scene.lights.len() {
                let mut fewer = scene.clone();
                fewer.lights.remove(light);
                let far = beyond_rounding(&deferred, &of(&fewer, Path::Forward));
                assert!(far.is_some(), "{tonemap}, {output}: light {light} is not missed");
            }
            let dark = Scene { ambient_nt: ontile::glam::Vec3::ZERO, ..scene.clone() };
            assert!(beyond_rounding(&deferred, &of(&dark, Path::Forward)).is_some(), "ambient light");
        });
    });
}

#[test]
fn forward_holds_the_output_and_nothing_else() {
    for scene in scenes::built() {
        let plan = Plan::new(Needs::of(&scene), options(Path::Forward), &Limits::default()).unwrap();
        let colors: Vec<_> = plan.attachments.iter().filter(|a| !a.format.is_depth()).collect();
        assert_eq!(colors.len(), 1, "{}", scene.name);
        assert!(colors[0].is_output && colors[0].format.bits() == 32);
        assert_eq!((plan.passes.len(), plan.stage_count()), (1, 1));
    }
}

#[test]
fn a_gbuffer_that_does_not_exist_cannot_be_kept() {
    let kept = Options { keep_gbuffer: true, ..options(Path::Forward) };
    let error = Plan::new(Needs::of(&scenes::lights_only()), kept, &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("no G-buffer"), "{error}");
}

//! Folding lighting and tonemap into one subpass skips the light target, and with it only that target's rounding.

mod common;

use common::render::{Gpu, difference, on_device, on_device_with_faults};
use common::scenes;
use ontile::glam::DVec3;
use ontile::picture::{Picture, Pixels, linear_from_srgb, srgb_from_linear};
use ontile::plan::{Format, Layout, LightFormat, LightTarget, Needs, Options, OutputFormat, Plan, Tonemap};
use ontile::reference::tonemap::tonemap;
use ontile::scene::Scene;

const SIZE: [u32; 2] = [160, 90];

/// Steps of one channel of the light target of `metallic128`, 10 bits normalised. Light is stored up to a step off, not
/// half a step: Vulkan lets a driver take either neighbour (Fundamentals, "Conversion From Floating-Point to Normalized
/// Fixed-Point"), and lavapipe 22.3 takes the lower one where it blends.
const LIGHT_STEPS: f64 = 1023.0;

/// Room for the arithmetic in 32-bit floats around the light target: some 16 roundings of values up to 2.
const FLOAT_SLACK: f64 = 16.0 * 2.0 / (1 << 24) as f64;

/// How much of the light target's range the brightest pixel takes: what is clipped is not within any bound.
const HEADROOM: f32 = 0.95;

/// The most that any channel of a tone curve's result changes, per change of the light's channels by at most 1 each.
fn steepest_slope(curve: Tonemap) -> f64 {
    match curve {
        Tonemap::Linear => 1.0,
        // 1 / (1 + x)^2 at 0.
        Tonemap::Reinhard => 1.0,
        // In the toe a channel c becomes c - m + m^2 / 0.16 with the least channel m: 1 for c, and up to 1 for m.
        Tonemap::Neutral => 2.0,
        // The fit's steepest slope, 0.90513 at 0.249, times the absolute sums of the rows of the matrices around it is
        // below 2.0; but no colour takes all of it at once, and the test below finds 1.26 at most.
        Tonemap::Aces => 1.3,
    }
}

#[test]
fn no_tone_curve_is_steeper_than_its_bound() {
    const CELLS: i32 = 24;
    const CHANGE: f64 = 1e-4;
    let axis = || (0..=CELLS).map(|i| 2.0 * f64::from(i) / f64::from(CELLS));
    for &curve in Tonemap::ALL {
        let mut steepest: f64 = 0.0;
        for (r, g, b) in axis().flat_map(|r| axis().flat_map(move |g| axis().map(move |b| (r, g, b)))) {
            let light = DVec3::new(r, g, b);
            // Where a curve is linear, a corner of the box of changes moves each channel the most.
            for corner in 0..8 {
                let sign = |bit: u32| if corner >> bit & 1 == 1 { CHANGE } else { -CHANGE };
                let moved = (light + DVec3::new(sign(0), sign(1), sign(2))).max(DVec3::ZERO);
                let change = (tonemap(curve, moved) - tonemap(curve, light)).abs().max_element();
                steepest = steepest.max(change / CHANGE);
            }
        }
        let bound = steepest_slope(curve);
        assert!(steepest <= bound * (1.0 + CHANGE), "{curve}: {steepest} is above {bound}");
        assert!(steepest >= 0.9 * bound, "{curve}: {bound} is far above {steepest}");
    }
}

/// Scenes in which nothing but lighting makes light.
fn foldable() -> Vec<Scene> {
    let mut all = scenes::built();
    all.extend(scenes::shipped());
    all.retain(|scene| {
        let needs = Needs::of(scene);
        needs.lit.is_some() && needs.prelit.is_empty() && needs.over_light().is_none()
    });
    assert!(!all.is_empty(), "no scene can be folded");
    all
}

fn plans(gpu: &Gpu<'_>, scene: &Scene, options: &Options) -> [Plan; 2] {
    let plans = [true, false].map(|fold| gpu.plan(scene, Options { fold, ..options.clone() }));
    assert_eq!([&plans[0], &plans[1]].map(|p| p.folded), [true, false]);
    plans
}

/// The greatest whole exposure at which no light is clipped.
fn unclipped_ev(gpu: &Gpu<'_>, scene: &Scene) -> f32 {
    let light = Options {
        size: SIZE,
        layout: Layout::Metallic128,
        tonemap: Tonemap::Linear,
        output: OutputFormat::Rgba32Float,
        ..Options::default()
    };
    let Pixels::Rgba32F(light) = gpu.picture(scene, gpu.plan(scene, light), 0.0).pixels else {
        unreachable!()
    };
    let brightest = light.chunks(4).flat_map(|p| &p[..3]).copied().fold(0.0, f32::max);
    assert!(brightest > 0.0, "{}: black", scene.name);
    (HEADROOM * LightTarget::new(LightFormat::Rgb10a2).range / brightest).log2().floor()
}

/// What is further apart than rounding the light to the light target's steps can take it.
fn beyond_rounding(curve: Tonemap, a: &Picture, b: &Picture) -> Option<String> {
    let step = f64::from(LightTarget::new(LightFormat::Rgb10a2).range) / LIGHT_STEPS;
    let bound = steepest_slope(curve) * step + FLOAT_SLACK;
    let too_far = |a: f64, b: f64| (a - b).abs() > bound;
    // Each output is rounded by up to half a step. What a curve takes out of range is clipped: that only helps.
    let too_far_encoded = |a: u8, b: u8| {
        let least = linear_from_srgb((f32::from(a.min(b)) - 0.5).max(0.0) / 255.0);
        let moved = srgb_from_linear(least + bound as f32) - srgb_from_linear(least);
        f32::from(a.abs_diff(b)) > 255.0 * moved + 1.0
    };
    let far: Vec<_> = match (&a.pixels, &b.pixels) {
        (Pixels::Rgba32F(a), Pixels::Rgba32F(b)) => {
            a.iter().zip(b).map(|(&a, &b)| too_far(a.into(), b.into())).collect()
        }
        (Pixels::Rgba8(a), Pixels::Rgba8(b)) => {
            a.iter().zip(b).map(|(&a, &b)| too_far_encoded(a, b)).collect()
        }
        _ => panic!("pictures of two formats"),
    };
    let count = far.iter().filter(|&&far| far).count();
    (count > 0).then(|| format!("{count} of {} channels are beyond {bound}", far.len()))
}

fn each_case(mut check: impl FnMut(Tonemap, OutputFormat)) {
    for &tonemap in Tonemap::ALL {
        for output in [OutputFormat::Rgba8Srgb, OutputFormat::Rgba32Float] {
            check(tonemap, output);
        }
    }
}

#[test]
fn folding_changes_nothing_where_the_light_target_holds_floats() {
    on_device(None, |gpu| {
        for scene in foldable() {
            each_case(|tonemap, output| {
                let options =
                    Options { size: SIZE, layout: Layout::Exact, tonemap, output, ..Options::default() };
                let [folded, apart] = plans(gpu, &scene, &options).map(|plan| gpu.picture(&scene, plan, 0.0));
                assert_eq!(difference(&folded, &apart), None, "{}, {tonemap}, {output}", scene.name);
            });
        }
    });
}

#[test]
fn folding_saves_the_light_targets_rounding_and_nothing_else() {
    on_device(None, |gpu| {
        for scene in foldable() {
            let ev = unclipped_ev(gpu, &scene);
            each_case(|tonemap, output| {
                let options = Options { size: SIZE, tonemap, output, ..Options::default() };
                let [folded, apart] = plans(gpu, &scene, &options).map(|plan| gpu.picture(&scene, plan, ev));
                let beyond = beyond_rounding(tonemap, &folded, &apart);
                assert_eq!(beyond, None, "{}, {tonemap}, {output}, {ev} EV", scene.name);
            });
        }
    });
}

#[test]
fn more_than_the_light_targets_rounding_is_seen() {
    on_device_with_faults(|gpu| {
        let scene = scenes::lights_only();
        let ev = unclipped_ev(gpu, &scene);
        each_case(|tonemap, output| {
            let options = Options { size: SIZE, tonemap, output, ..Options::default() };
            let [folded, apart] = plans(gpu, &scene, &options);
            let folded = gpu.picture(&scene, folded, ev);
            let seen =
                |broken: Plan| beyond_rounding(tonemap, &folded, &gpu.picture(&scene, broken, ev)).is_some();

            // An 8-bit output's own rounding hides what light of 8 bits loses.
            if output.is_float() {
                let mut coarse = apart.clone();
                let light =
                    coarse.attachments.iter_mut().find(|a| a.name == "light").expect("a light target");
                light.format = Format::Rgba8Unorm;
                assert!(seen(coarse), "{tonemap}, {output}: light of 8 bits is not seen");
            }

            let mut other_curve = apart;
            let linear = tonemap == Tonemap::Linear;
            other_curve.options.tonemap = if linear { Tonemap::Reinhard } else { Tonemap::Linear };
            assert!(seen(other_curve), "{tonemap}, {output}: another curve is not seen");
        });
    });
}

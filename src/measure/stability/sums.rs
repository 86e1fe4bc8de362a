//! Sums of light in few bits: many lights one by one, and their order.

use glam::DVec3;

use super::light_target::{HALF, Rounding, SMALL, Store, TEN_SCALED};
use super::{Answer, Bound, Case, Figure, Findings, Lab, Sweep, Worst, display_steps};
use crate::Result;
use crate::measure::plot::{Axis, Plot};
use crate::plan::Tonemap;
use crate::reference::tonemap::tonemap;

pub const SUM: Sweep = Sweep {
    name: "sum",
    title: "Many lights added one by one",
    varies: "number of equal lights that add up to 1, 1 to 1024",
    about: "Each addition in the target is rounded: lights of less than half a step are lost, and a float's step grows with \
            the sum.",
    needs_device: false,
    find: sum,
};

pub const ORDER: Sweep = Sweep {
    name: "order",
    title: "The order of blending",
    varies: "number of lights, 2 to 1024: one of exposed light 1 before or after all others, which have up to a step of it each",
    about: "Floats are not associative: what is dim survives only before what is bright. Fixed point is, for light: on a lattice \
            all sums of what is not negative round alike, and the clamp comes last in any order. Draw order is defined, so a \
            frame repeats itself; but if lights change places in a list, pixels change by this much.",
    needs_device: false,
    find: order,
};

/// Adds light to a target that starts empty.
fn added(store: Store, lights: impl IntoIterator<Item = f64>) -> f64 {
    // Vulkan 1.3, 29.1: a fixed-point source is clamped before it is added, and the sum rounded once. It is not rounded
    // itself.
    let source = |light: f64| match store {
        Store::Fixed(_, range) => light.min(range),
        Store::Float(..) => light,
    };
    lights.into_iter().fold(0.0, |sum, light| store.keep(sum + source(light)))
}

/// Higham, "Accuracy and Stability of Numerical Algorithms", 2002, equation 4.4: n additions of what is not negative lose at
/// most n u of the sum.
const HIGHAM: &str =
    "n additions lose at most n u of the sum (Higham 2002, eq. 4.4); 1 % is below one step of the display";
/// The most lights that are added here.
const MOST_LIGHTS: u32 = 1024;

fn light_counts() -> impl Iterator<Item = u32> {
    (0..=10).map(|n| 1 << n)
}

fn sum(_: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for (name, stores) in [TEN_SCALED, HALF, SMALL] {
        let mut worst = Worst::new();
        let mut curve = Vec::new();
        for lights in light_counts() {
            // 0.9 is not dyadic: a power of two would be kept exactly.
            let each = 0.9 / f64::from(lights);
            let error = (added(stores[1], (0..lights).map(|_| each)) / 0.9 - 1.0).abs();
            worst.add(error, || lights);
            curve.push([f64::from(lights), 100.0 * error]);
        }
        let answered = !matches!(stores[1], Store::Float(10, _));
        findings.cases.push(Case {
            method: name.into(),
            worst: 100.0 * worst.error,
            at: format!("{} lights", worst.at.unwrap_or_default()),
            bound: Bound {
                name: "ADDED",
                unit: "% of the sum",
                good: 1.0,
                most: 100.0 * f64::from(MOST_LIGHTS) * Store::Float(10, Rounding::Nearest).unit(),
                reason: HIGHAM,
            },
            answer: answered.then_some(Answer::Mended),
            remedy: if answered {
                "lights that are added one by one (--lights volumes, stencil; --path forward-multipass) get a target of half \
                 floats unless --light-target asks for another; the other ways sum in registers and store once"
                    .into()
            } else {
                String::new()
            },
        });
        curves.push((name.to_owned(), curve));
    }
    findings.figures.push(Figure::plot(
        "lost",
        "What is missing of a sum of 0.9 by the number of lights that it is made of.",
        Plot {
            title: "Light that additions lose".into(),
            x_label: "lights".into(),
            y_label: "% of the sum".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("1 %".into(), 1.0)],
        },
    ));
    Ok(findings)
}

fn order(_: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for (name, stores) in [TEN_SCALED, HALF, SMALL] {
        let mut worst = Worst::new();
        let mut curve = Vec::new();
        for lights in light_counts().skip(1) {
            // One light of 1, the others each a part of its step: after it they are rounded away or up, before it they are not.
            let step = 2.0 * stores[1].unit();
            let mut most = 0.0;
            for part in 1..=60 {
                // Never half a step: how ties are rounded is the device's affair.
                let dim = step * (f64::from(part) - 0.37) / 60.0;
                let dims = || (1..lights).map(|_| dim);
                let orders = [
                    added(stores[1], dims().chain([1.0])),
                    added(stores[1], [1.0].into_iter().chain(dims())),
                ];
                let shown = orders.map(|light| tonemap(Tonemap::Neutral, DVec3::new(0.0, 0.0, light)).z);
                most = f64::max(most, display_steps(shown[0], shown[1]));
            }
            worst.add(most, || lights);
            curve.push([f64::from(lights), most]);
        }
        let answered = matches!(stores[1], Store::Float(5, _));
        findings.cases.push(Case {
            method: name.into(),
            worst: worst.error,
            at: format!("{} lights", worst.at.unwrap_or_default()),
            bound: Bound {
                name: "REORDERED",
                unit: "8-bit steps",
                good: 1.0,
                most: 1.1 * steps_of_half_floats(),
                reason: "after a light of 1, each of 1023 others is off by half a step of half floats at most: half as much again; one step \
                         of the display is no more than noise",
            },
            answer: answered.then_some(Answer::Mended),
            remedy: if answered {
                "as many lights: added one by one, they get half floats".into()
            } else {
                String::new()
            },
        });
        curves.push((name.to_owned(), curve));
    }
    findings.figures.push(Figure::plot(
        "apart",
        "How far two orders of the same lights are apart.",
        Plot {
            title: "The brightest light last against the brightest light first".into(),
            x_label: "lights".into(),
            y_label: "steps of an 8-bit sRGB display".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("one step".into(), 1.0)],
        },
    ));
    Ok(findings)
}

/// Display steps that 1023 additions in half floats, each off by half a step, make of a light of 1.
fn steps_of_half_floats() -> f64 {
    let off = f64::from(MOST_LIGHTS - 1) * HALF.1[1].unit();
    let [true_sum, found] =
        [1.0, 1.0 + off].map(|light| tonemap(Tonemap::Neutral, DVec3::new(0.0, 0.0, light)).z);
    display_steps(true_sum, found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_below_half_a_step_are_lost() {
        assert_eq!(added(TEN_SCALED.1[0], (0..1000).map(|_| 0.4 * 2.0 / 1023.0)), 0.0);
    }
}

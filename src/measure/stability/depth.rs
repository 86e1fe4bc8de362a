//! Distances from stored depth.

use super::{Answer, Bound, Case, Figure, Findings, Lab, Sweep, Worst};
use crate::Result;
use crate::measure::canvas::short;
use crate::measure::plot::{Axis, Plot};
use crate::plan::DepthStore;
use crate::reference::quantise::formats::{half, unorm};
use crate::reference::quantise::store_depth;

pub const DEPTH: Sweep = Sweep {
    name: "depth",
    title: "Distances from depth",
    varies: "distance along the view axis, 0.1 m (the near plane) to 100 km; no far plane, but for the rows that name one",
    about: "Depth is near / distance, reversed: a float's steps, fine near 0, make up for the quotient's, fixed point's do not. \
            Stored the other way round even floats lose what they have.",
    needs_device: false,
    find: depth,
};

const NEAR_M: f64 = 0.1;
const FAR_M: f64 = 1e5;

/// How a depth is stored.
struct Format {
    name: &'static str,
    /// What is read back of a distance, metres; infinite if it is taken for background.
    keep: fn(f64) -> f64,
    /// The error at a distance that half a step explains, metres.
    most: fn(f64) -> f64,
    reason: &'static str,
    /// What is done where it fails.
    answer: Option<Answer>,
    remedy: &'static str,
}

fn reversed(distance: f64, store: impl Fn(f64) -> f64) -> f64 {
    NEAR_M / store(NEAR_M / distance)
}

/// A step of f32 is at most 2^-23 of the value; half of it, and as much again of the division.
const FLOAT_STEP: f64 = 1.0 / (1 << 24) as f64;

const fn fixed_error(distance: f64, bits: u32) -> f64 {
    // d(near / depth) = distance² / near of depth; exact for the whole half step: distance / (1 - x) - distance.
    let x = 0.5 / ((1_u64 << bits) - 1) as f64 * distance / NEAR_M;
    if x < 1.0 { distance * x / (1.0 - x) } else { f64::INFINITY }
}

const FORMATS: [Format; 6] = [
    Format {
        name: "f32 reversed (r32f, D32)",
        keep: |d| reversed(d, |depth| store_depth(DepthStore::R32f, depth)),
        most: |d| d * FLOAT_STEP * 1.001,
        reason: "half a step of f32 is 6e-8 of any distance; a tenth is where nothing that needs a position works",
        answer: None,
        remedy: "",
    },
    Format {
        name: "D24 reversed",
        keep: |d| reversed(d, |depth| store_depth(DepthStore::D24, depth)),
        most: |d| fixed_error(d, 24) * 1.001,
        reason: "half a step of 24 bits times distance² / near; a tenth is where nothing that needs a position works",
        answer: None,
        remedy: "as near a far plane as the scene allows changes little: a near plane that is ten times as far divides errors by ten",
    },
    Format {
        name: "D16 reversed",
        keep: |d| reversed(d, |depth| store_depth(DepthStore::D16, depth)),
        most: |d| fixed_error(d, 16) * 1.001,
        reason: "half a step of 16 bits times distance² / near; a tenth is where nothing that needs a position works",
        answer: Some(Answer::Guarded),
        remedy: "for rooms: beyond half a code, 13.1 km at a near plane of 0.1 m, surfaces are background, and at 36 m distances are off \
                 by 10 cm; ontile render warns of scenes that reach further",
    },
    Format {
        name: "f32, 0 at the near plane",
        keep: |d| {
            let stored = f64::from((1.0 - NEAR_M / d) as f32);
            NEAR_M / (1.0 - stored)
        },
        most: |d| d * FLOAT_STEP * 1.001,
        reason: "half a step of f32, as if its steps near 1 were as fine as near 0",
        answer: Some(Answer::Mended),
        remedy: "depth is reversed in every layout: 1 near, 0 far",
    },
    Format {
        name: "positions in half floats",
        keep: half,
        most: |d| if d < 65_520.0 { d / 2048.0 * 1.001 } else { f64::INFINITY },
        reason: "half a step of half floats is 5e-4 of a coordinate, which ends at 65.5 km; thibieroz128 and 96 store them from the \
                 world's origin, dissertation192 from the camera",
        answer: Some(Answer::Guarded),
        remedy: "worlds beyond 65 km take a layout that stores depth; coordinates are held there, so that no light is NaN",
    },
    Format {
        name: "D24, far plane 100 km",
        keep: |d| {
            let depth = NEAR_M * (FAR_M - d) / (d * (FAR_M - NEAR_M));
            NEAR_M * FAR_M / (NEAR_M + unorm(depth, 24) * (FAR_M - NEAR_M))
        },
        most: |d| fixed_error(d, 24) * 1.01,
        reason: "as without a far plane: a plane that is a million times as far as the near one takes a millionth of the codes",
        answer: None,
        remedy: "",
    },
];

/// What nobody sees: lights of a few metres' range fall by 2 % over as much of a pixel's distance.
const GOOD: f64 = 1e-3;
/// Beyond a tenth nothing that needs a position works: lights, fog, shadows.
const MOST: f64 = 0.1;

fn depth(lab: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for format in FORMATS {
        let (mut worst, mut unexplained) = (Worst::new(), Worst::new());
        let mut good_to = FAR_M;
        let mut curve: Vec<[f64; 2]> = Vec::new();
        let count = lab.pick(20_000, 400_000);
        for i in 0..=count {
            let distance = NEAR_M * (FAR_M / NEAR_M).powf(f64::from(i) / f64::from(count));
            let error = ((format.keep)(distance) - distance).abs();
            if error > GOOD * distance {
                good_to = f64::min(good_to, distance);
            }
            let most = (format.most)(distance);
            if error > most {
                unexplained.add(error / most, || (distance, most / distance));
            }
            worst.add(error / distance, || distance);
            if i % (count / 100) == 0 {
                curve.push([distance, 0.0]);
            }
            let last = curve.last_mut().expect("the first is added at once");
            last[1] = f64::max(last[1], error / distance);
        }
        let reach = if good_to < FAR_M {
            format!("; within 0.1 % up to {} m", short(good_to))
        } else {
            String::new()
        };
        // What half a step does not explain is worse than any error that it does.
        let (distance, error, most) = match unexplained.at {
            Some((distance, most)) => (distance, unexplained.error * most, most),
            None => (worst.at.unwrap_or_default(), worst.error, MOST),
        };
        findings.cases.push(Case {
            method: format.name.into(),
            worst: 100.0 * error,
            at: format!("{} m{reach}", short(distance)),
            bound: Bound {
                name: "HALF_A_STEP_OF_DEPTH",
                unit: "% of distance",
                good: 100.0 * GOOD.min(most),
                most: 100.0 * most,
                reason: format.reason,
            },
            answer: format.answer,
            remedy: format.remedy.into(),
        });
        curves.push((format.name.to_owned(), curve));
    }
    findings.figures.push(Figure::plot(
        "error",
        "The largest relative error within each hundredth of the range; curves end where surfaces become background.",
        Plot {
            title: "Error of distances from depth, near plane at 0.1 m".into(),
            x_label: "distance, m".into(),
            y_label: "relative error".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("0.1 %".into(), GOOD)],
        },
    ));
    Ok(findings)
}

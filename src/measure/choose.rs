//! The cheapest G-buffer that is good enough for a scene: what `--layout auto` means.

use std::fmt;

use super::probe::{Content, Predicted, Probe};
use crate::plan::{Choice, DepthStore, Limits, Needs, Options, Plan, Strategy, named_enum};
use crate::scene::{Camera, Scene};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

named_enum! {
    /// What an error is measured by.
    ErrorMetric {
        /// FLIP, the mean over the picture: 0 is equal, 1 the most.
        Flip = "flip",
        /// Peak signal-to-noise ratio of the 8-bit picture, dB: more is better.
        Psnr = "psnr",
        /// CIEDE2000 that 95 % of the pixels do not exceed: 1 is about what an eye can just tell apart.
        Ciede = "ciede",
    }
}

/// How good is good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// What counts.
    pub metric: ErrorMetric,
    /// FLIP and CIEDE2000: at most this. PSNR: at least this.
    pub limit: f64,
}

/// Pictures may err by so much more than predicted: the windows are not the whole picture, and arithmetic, texture filters and
/// the rounding of drivers err too. `ontile chart` tells how well it serves.
const MARGIN: f64 = 1.2;

impl Default for Goal {
    /// A mean FLIP of 0.02.
    fn default() -> Self {
        Self { metric: ErrorMetric::Flip, limit: 0.02 }
    }
}

impl Goal {
    /// Whether a figure of the metric meets it.
    pub fn is_met_by(&self, figure: f64) -> bool {
        if self.metric == ErrorMetric::Psnr { figure >= self.limit } else { figure <= self.limit }
    }

    /// The predicted figure and what the probe does not know: see `MARGIN`.
    pub fn with_margin(&self, predicted: &Predicted) -> f64 {
        let figure = predicted.of(self.metric);
        match self.metric {
            ErrorMetric::Psnr => figure - 10.0 * (MARGIN * MARGIN).log10(),
            ErrorMetric::Flip | ErrorMetric::Ciede => figure * MARGIN,
        }
    }

    /// The figure so that less is better.
    fn badness(&self, predicted: &Predicted) -> f64 {
        let figure = predicted.of(self.metric);
        if self.metric == ErrorMetric::Psnr { -figure } else { figure }
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.metric {
            ErrorMetric::Flip => write!(f, "FLIP of at most {}", self.limit),
            ErrorMetric::Psnr => write!(f, "PSNR of at least {} dB", self.limit),
            ErrorMetric::Ciede => write!(f, "CIEDE2000 of at most {} for 95 % of the pixels", self.limit),
        }
    }
}

impl Predicted {
    /// The figure of a metric.
    pub fn of(&self, metric: ErrorMetric) -> f64 {
        match metric {
            ErrorMetric::Flip => self.flip,
            ErrorMetric::Psnr => self.psnr_db.unwrap_or(f64::INFINITY),
            ErrorMetric::Ciede => self.ciede2000_p95,
        }
    }
}

/// What was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// The G-buffer.
    pub choice: Choice,
    /// Its error, as the probe has it.
    pub predicted: Predicted,
    /// Why: one statement each.
    pub why: Vec<String>,
}

/// Chooses the cheapest G-buffer for a scene and device whose error meets the goal, by a [`Probe`]. The cheapest has the
/// fewest bytes a pixel: on the tile, where a G-buffer stays on the chip ([`Limits::gbuffer_on_chip`]), else moved to and from
/// memory; among equals the most accurate wins. `options` says all but the G-buffer; `check` refuses what the device cannot
/// do, besides what the limits tell.
///
/// # Errors
/// [`Error::Unsupported`] if nothing meets the goal, with the best that there is; as [`Probe::new`].
pub fn choose(
    scene: &Scene,
    camera: &Camera,
    options: &Options,
    exposure_ev: f32,
    limits: &Limits,
    goal: Goal,
    check: &dyn Fn(&Plan) -> Result<()>,
) -> Result<Chosen> {
    let needs = Needs::of(scene);
    let plan = |choice: Choice| {
        let plan = Plan::new(needs.clone(), choice.apply(options), limits)?;
        check(&plan).map(|()| plan)
    };
    // What does not stay on the chip moves between any two subpasses.
    let separate = |choice: Choice| {
        let options = Options { strategy: Strategy::Separate, ..choice.apply(options) };
        Plan::new(needs.clone(), options, limits)
    };
    let mut candidates: Vec<(u32, Choice, Plan)> = Vec::new();
    for choice in candidates_for(&needs) {
        if let Ok(plan) = plan(choice) {
            let bytes =
                if limits.gbuffer_on_chip { plan.bytes_on_tile() } else { separate(choice)?.bytes_moved() };
            candidates.push((bytes, choice, plan));
        }
    }
    if !candidates.iter().any(|(_, _, plan)| plan.has_gbuffer()) {
        return Err(Error::unsupported(
            format!("{}: without a G-buffer there is none to choose", scene.name),
            "name a layout instead of 'auto'",
        ));
    }
    candidates.sort_by_key(|(bytes, choice, _)| (*bytes, *choice));
    let probe = Probe::new(scene, camera, options, exposure_ev)?;
    let mut passed: Option<(Choice, Predicted)> = None;
    for level in candidates.chunk_by(|a, b| a.0 == b.0) {
        let probed = level.iter().map(|(_, choice, plan)| (*choice, probe.error(plan)));
        let by_error = |(_, a): &(Choice, Predicted), (_, b): &(Choice, Predicted)| {
            goal.badness(a).total_cmp(&goal.badness(b))
        };
        let Some((choice, predicted)) = probed.min_by(by_error) else { continue };
        if goal.is_met_by(goal.with_margin(&predicted)) {
            let why = why(&probe.content(), goal, choice, &predicted, level[0].0, passed, limits);
            return Ok(Chosen { choice, predicted, why });
        }
        if passed.is_none_or(|(_, known)| goal.badness(&predicted) < goal.badness(&known)) {
            passed = Some((choice, predicted));
        }
    }
    let best = passed.map_or(String::new(), |(choice, predicted)| {
        format!("; the best is {choice} with {}", told(goal.metric, &predicted))
    });
    Err(Error::unsupported(
        format!("{}: no G-buffer is expected to give a {goal}{best}", scene.name),
        "raise --max-error (for PSNR: lower it)",
    ))
}

/// What is considered for a scene. Where lights cast shadows, 16 bits of depth are not: shadows are looked up at positions that
/// follow from depth, and the probe leaves shadows out.
pub fn candidates_for(needs: &Needs) -> Vec<Choice> {
    let mut candidates = Choice::candidates();
    candidates.retain(|c| needs.shadows.lights.is_empty() || c.depth != Some(DepthStore::D16));
    candidates
}

fn told(metric: ErrorMetric, predicted: &Predicted) -> String {
    match metric {
        ErrorMetric::Flip => format!("FLIP {:.4}", predicted.flip),
        ErrorMetric::Psnr => format!("{:.1} dB", predicted.of(metric)),
        ErrorMetric::Ciede => format!("CIEDE2000 {:.2}", predicted.ciede2000_p95),
    }
}

fn why(
    content: &Content,
    goal: Goal,
    choice: Choice,
    predicted: &Predicted,
    bytes: u32,
    passed: Option<(Choice, Predicted)>,
    limits: &Limits,
) -> Vec<String> {
    let place = if limits.gbuffer_on_chip { "on the tile" } else { "to and from memory" };
    let metric = goal.metric;
    let mut why = vec![format!(
        "G-buffer chosen for a {goal}: {choice}, {bytes} bytes a pixel {place}, {} expected",
        told(metric, predicted)
    )];
    why.extend(passed.map(|(choice, predicted)| {
        format!(
            "fewer bytes are not enough: the best of them, {choice}, would give {}",
            told(metric, &predicted)
        )
    }));
    why.push(format!("what the choice goes by, a probe of the picture: {content}"));
    why
}

impl fmt::Display for Content {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let [near, far] = self.distance_m;
        write!(
            f,
            "{} metal, {} smooth, {} brighter than white, {} darker than a hundredth of it, {} with light of their own, from \
             {near:.1} to {far:.1} m away",
            percent(self.metal),
            percent(self.smooth),
            percent(self.bright),
            percent(self.dark),
            percent(self.prelit)
        )
    }
}

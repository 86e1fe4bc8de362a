//! How well `--layout auto` would have chosen: its choice by prediction against what was measured.

use super::data::{Cell, Errors, Measured, Report};
use crate::measure::{ErrorMetric, Goal, Predicted};
use crate::plan::Choice;

/// The limits that choices are tried with, from strict to lax.
const LIMITS: [(ErrorMetric, [f64; 5]); 3] = [
    (ErrorMetric::Flip, [0.0075, 0.01, 0.015, 0.02, 0.03]),
    (ErrorMetric::Psnr, [55.0, 50.0, 45.0, 42.0, 40.0]),
    (ErrorMetric::Ciede, [0.6, 0.8, 1.0, 1.5, 2.0]),
];

/// Decisions of one metric over all places and limits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Hits {
    /// How many there were.
    pub decisions: usize,
    /// The measured error keeps the limit, or nothing was chosen where nothing keeps it.
    pub kept: usize,
    /// And nothing that keeps it is cheaper.
    pub cheapest: usize,
}

/// Who predicts errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Predictor {
    /// The probe, with its margin.
    Probe,
    /// The worst that was measured of the same G-buffer in all other scenes.
    OtherScenes,
}

/// A device's decisions by each metric.
pub(super) fn hits(report: &Report, device: &str, predictor: Predictor) -> Vec<(ErrorMetric, Hits)> {
    let places = report.by_place();
    let places = || places.iter().filter(|(place, _)| place.device == device);
    let of_metric = |(metric, limits): (ErrorMetric, [f64; 5])| {
        let mut hits = Hits::default();
        for (place, cells) in places() {
            let known: Vec<(&Measured, f64)> = cells
                .iter()
                .filter_map(|cell| {
                    let m = cell.measured().filter(|m| m.is_candidate)?;
                    let predicted = match predictor {
                        Predictor::Probe => Goal { metric, limit: 0.0 }.with_margin(&m.predicted?),
                        Predictor::OtherScenes => {
                            let others = places().filter(|(p, _)| p.scene != place.scene);
                            worst(metric, others.flat_map(|(_, cells)| cells), cell.choice)?
                        }
                    };
                    Some((m, predicted))
                })
                .collect();
            if !known.is_empty() {
                limits.iter().for_each(|&limit| hits.decide(Goal { metric, limit }, &known));
            }
        }
        (metric, hits)
    };
    LIMITS.into_iter().map(of_metric).collect()
}

fn worst<'a>(metric: ErrorMetric, cells: impl Iterator<Item = &'a &'a Cell>, choice: Choice) -> Option<f64> {
    let errors = cells.filter(|cell| cell.choice == choice).filter_map(|cell| cell.measured());
    let errors = errors.map(|m| figure(metric, &m.against_reference));
    if metric == ErrorMetric::Psnr { errors.reduce(f64::min) } else { errors.reduce(f64::max) }
}

fn figure(metric: ErrorMetric, errors: &Errors) -> f64 {
    Predicted { flip: errors.flip, psnr_db: errors.psnr_db, ciede2000_p95: errors.ciede2000_p95 }.of(metric)
}

impl Hits {
    fn decide(&mut self, goal: Goal, known: &[(&Measured, f64)]) {
        let good = |m: &Measured| goal.is_met_by(figure(goal.metric, &m.against_reference));
        let best = known.iter().filter(|(m, _)| good(m)).map(|(m, _)| m.bytes.counted).min();
        let better = |a: &f64, b: &f64| match goal.metric {
            ErrorMetric::Psnr => b.total_cmp(a),
            _ => a.total_cmp(b),
        };
        let chosen = known
            .iter()
            .filter(|(_, predicted)| goal.is_met_by(*predicted))
            .min_by(|(m, p), (n, q)| m.bytes.counted.cmp(&n.bytes.counted).then(better(p, q)));
        let (kept, cheapest) = match (chosen, best) {
            (Some((m, _)), best) => (good(m), good(m) && Some(m.bytes.counted) == best),
            (None, None) => (true, true),
            // Nothing is promised that is not kept.
            (None, Some(_)) => (true, false),
        };
        self.decisions += 1;
        self.kept += usize::from(kept);
        self.cheapest += usize::from(cheapest);
    }
}

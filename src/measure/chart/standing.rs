//! How G-buffers stand over all places of a device.

use super::data::{Cell, Measured, Outcome, Report};
use super::metric::Metric;
use crate::plan::{Brdf, Choice, Layout};

/// One G-buffer over all places.
pub(super) struct Standing {
    pub choice: Choice,
    /// The most of all places.
    pub bytes_on_tile: u32,
    pub color_bits: u32,
    pub moved_separate: u32,
    /// Time over that of the base, the geometric mean.
    pub ratio: f64,
    /// Of each of [`Metric::ALL`], the worst figure against the reference, and against `exact`.
    pub worst: Vec<[f64; 2]>,
    /// In how many places it was drawn, and in how many refused.
    pub drawn: usize,
    pub refused: usize,
    /// Whether that is all places of the device.
    pub is_complete: bool,
}

impl Standing {
    /// The worst figure against the reference.
    pub fn error(&self, metric: Metric) -> f64 {
        self.worst[metric as usize][0]
    }

    /// For people who compare: no ruler, and drawn everywhere.
    pub fn is_eligible(&self) -> bool {
        self.choice.layout != Layout::Exact && self.refused == 0 && self.is_complete
    }

    /// Whether its time is its own: half floats are emulated ([`Brdf::Mediump`]), which takes longer than what it stands for.
    pub fn has_time(&self) -> bool {
        self.choice.brdf != Brdf::Mediump
    }
}

/// Of a device, in the order in which G-buffers appear.
pub(super) fn standings(report: &Report, device: &str) -> Vec<Standing> {
    let mut choices: Vec<Choice> = Vec::new();
    let cells: Vec<&Cell> = report.cells.iter().filter(|cell| cell.place.device == device).collect();
    for cell in &cells {
        if !choices.contains(&cell.choice) {
            choices.push(cell.choice);
        }
    }
    let places = report.by_place().iter().filter(|(place, _)| place.device == device).count();
    choices.into_iter().filter_map(|choice| standing(&cells, choice, places)).collect()
}

fn standing(cells: &[&Cell], choice: Choice, places: usize) -> Option<Standing> {
    let own = || cells.iter().filter(move |cell| cell.choice == choice);
    let measured: Vec<&Measured> = own().filter_map(|cell| cell.measured()).collect();
    let logs: f64 = measured.iter().map(|m| m.ratio.median.ln()).sum();
    let most = |figure: fn(&Measured) -> u32| measured.iter().map(|m| figure(m)).max();
    let worst = |metric: Metric| {
        [|m: &Measured| m.against_reference, |m: &Measured| m.against_exact].map(|errors| {
            let all = measured.iter().map(|m| metric.of(&errors(m)));
            match metric {
                Metric::Psnr => all.fold(f64::INFINITY, f64::min),
                _ => all.fold(0.0, f64::max),
            }
        })
    };
    Some(Standing {
        choice,
        bytes_on_tile: most(|m| m.bytes.on_tile)?,
        color_bits: most(|m| m.bytes.color_bits)?,
        moved_separate: most(|m| m.bytes.moved_separate)?,
        ratio: (logs / measured.len() as f64).exp(),
        worst: Metric::ALL.iter().map(|&metric| worst(metric)).collect(),
        drawn: measured.len(),
        refused: own().filter(|cell| matches!(cell.outcome, Outcome::Refused(_))).count(),
        is_complete: own().count() == places,
    })
}

/// A need, and what serves it best.
pub(super) struct Winner<'a> {
    pub need: String,
    pub best: Option<&'a Standing>,
}

/// Colour bits of a tile at full size on every Mali and PowerVR GPU.
const STRICT_BITS: u32 = 128;

/// Times nearer to each other than this share change from one run to the next.
const LEVEL: f64 = 0.03;

/// What wins for which need.
pub(super) fn winners(standings: &[Standing]) -> Vec<Winner<'_>> {
    let eligible = || standings.iter().filter(|s| s.is_eligible());
    let flip = |s: &Standing| s.error(Metric::Flip);
    let least = |candidates: &mut dyn Iterator<Item = &'_ Standing>, by: &dyn Fn(&Standing) -> [f64; 2]| {
        let best = candidates
            .map(|s| (by(s), s.choice))
            .min_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        best.and_then(|(_, choice)| standings.iter().find(|s| s.choice == choice))
    };
    let timed = || eligible().filter(|s| s.has_time());
    let fastest = timed().map(|s| s.ratio).fold(f64::INFINITY, f64::min);
    let bytes = |s: &Standing| f64::from(s.bytes_on_tile);
    let mut all = vec![
        Winner { need: "least error".into(), best: least(&mut eligible(), &|s| [flip(s), bytes(s)]) },
        Winner {
            need: format!(
                "least error in {STRICT_BITS} bits of colour, which every Mali and PowerVR tile holds"
            ),
            best: least(&mut eligible().filter(|s| s.color_bits <= STRICT_BITS), &|s| [flip(s), bytes(s)]),
        },
        Winner {
            need: "fewest bytes on the tile".into(),
            best: least(&mut eligible(), &|s| [bytes(s), flip(s)]),
        },
        Winner {
            need: format!(
                "least time; within {:.0} % counts as level, then the error decides",
                100.0 * LEVEL
            ),
            best: least(&mut timed().filter(|s| s.ratio <= (1.0 + LEVEL) * fastest), &|s| [flip(s), s.ratio]),
        },
    ];
    for limit in [0.005, 0.01, 0.02] {
        all.push(Winner {
            need: format!("fewest bytes with FLIP of at most {limit}"),
            best: least(&mut eligible().filter(|s| flip(s) <= limit), &|s| [bytes(s), s.ratio]),
        });
    }
    all
}

//! Statements follow from data: made-up cells whose answers are known.

use super::data::{Bytes, Cell, Errors, Measured, Outcome, Place, Report, Truth};
use super::metric::Metric;
use super::page::page;
use super::standing::{standings, winners};
use crate::measure::{Clock, Predicted, Summary};
use crate::plan::{Choice, Layout, Strategy, Tonemap};

fn place(scene: &str) -> Place {
    Place {
        scene: scene.into(),
        scene_sha256: "0".into(),
        camera: "0".into(),
        size: [640, 360],
        strategy: Strategy::Subpasses,
        tonemap: Tonemap::Neutral,
        exposure_ev: 0.0,
        rounds: 9,
        seconds: 1.0,
        device: "Made up (TM)".into(),
        driver: "1".into(),
        program: "1".into(),
    }
}

fn cell(scene: &str, layout: Layout, [ms, flip]: [f64; 2], on_tile: u32) -> Cell {
    let summary = |x| Summary::of([0.9 * x, x, 1.1 * x]).unwrap();
    let errors = Errors {
        psnr_db: Some(40.0 - 100.0 * flip),
        flip,
        ciede2000_p95: 10.0 * flip,
        relative_max: flip,
        relative_p95: flip,
    };
    let measured = Measured {
        clock: Clock::Gpu,
        frame_ms: summary(ms),
        ratio: summary(ms / 2.0),
        bytes: Bytes {
            on_tile,
            color_bits: 8 * (on_tile - 4),
            moved: 4,
            moved_separate: 3 * on_tile,
            counted: on_tile,
        },
        bins: Vec::new(),
        truth: Truth::Scene,
        left_out: 0.05,
        against_reference: errors,
        against_exact: errors,
        is_candidate: layout != Layout::Exact,
        predicted: Some(Predicted { flip, psnr_db: Some(40.0 - 100.0 * flip), ciede2000_p95: 10.0 * flip }),
    };
    let outcome = Outcome::Measured(Box::new(measured));
    Cell { place: place(scene), choice: Choice::of(layout), outcome }
}

#[test]
fn the_worst_place_counts_and_the_ruler_does_not() {
    let report = Report::new(vec![
        cell("a", Layout::Metallic128, [2.0, 0.01], 20),
        cell("a", Layout::Exact, [4.0, 0.001], 60),
        cell("b", Layout::Metallic128, [2.0, 0.03], 16),
        cell("b", Layout::Exact, [1.0, 0.0], 60),
    ]);
    let standings = standings(&report, "Made up (TM)");
    assert_eq!(standings.len(), 2);
    let base = &standings[0];
    assert_eq!((base.error(Metric::Flip), base.error(Metric::Psnr), base.bytes_on_tile), (0.03, 37.0, 20));
    assert!((standings[1].ratio - 1.0).abs() < 1e-12, "the geometric mean of 2 and 1/2");
    for winner in winners(&standings) {
        // At most 0.005, 0.01 and 0.02: only the ruler would.
        let expected = (!winner.need.contains("at most 0")).then_some(Layout::Metallic128);
        assert_eq!(winner.best.map(|s| s.choice.layout), expected, "{}", winner.need);
    }
    let page = page(&report);
    for said in [
        "least error | **metallic128** | 0.03 | 37.0 dB | 20 | 1.00 |",
        "At most 5.0 %",
        "`exact` | 60 | 448 |",
    ] {
        assert!(page.contains(said), "'{said}' is missing in:\n{page}");
    }
}

#[test]
fn what_is_refused_somewhere_wins_nothing_and_is_listed() {
    let refused = Outcome::Refused("no such format; choose another".into());
    let report = Report::new(vec![
        cell("a", Layout::Metallic128, [2.0, 0.01], 20),
        Cell { outcome: refused, ..cell("b", Layout::Metallic128, [2.0, 0.01], 20) },
    ]);
    let standings = standings(&report, "Made up (TM)");
    assert!(winners(&standings).iter().all(|w| w.best.is_none()));
    let page = page(&report);
    assert!(page.contains("`metallic128` (1 of 2 refused)"), "{page}");
    assert!(page.contains("- no such format; choose another. Prevented: `metallic128` in b"), "{page}");
}

#[test]
fn a_cell_takes_the_place_of_one_under_the_same_conditions_only() {
    let mut report = Report::new(vec![cell("a", Layout::Metallic128, [2.0, 0.01], 20)]);
    report.merge(Report::new(vec![cell("a", Layout::Metallic128, [3.0, 0.01], 20)]));
    assert_eq!(report.cells.len(), 1);
    assert_eq!(report.cells[0].measured().unwrap().frame_ms.median, 3.0);
    let mut other = cell("a", Layout::Metallic128, [2.0, 0.01], 20);
    other.place.program = "2".into();
    report.put(other);
    assert_eq!(report.cells.len(), 2);
}

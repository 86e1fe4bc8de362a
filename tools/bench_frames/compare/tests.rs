//! Statements follow from data: made-up runs whose answers are known.

use ontile::measure::{Clock, rounded_ms};

use super::data::{Auto, Cell, Measured, Outcome, Report, Row, Run, Table, TableName};
use super::findings::{Verdict, findings, floating_cost_ms, targets};
use super::page::page;
use super::rules::rules;
use super::tables::{CLUSTERS, DEFERRED, FORWARD, FULLSCREEN, MULTIPASS, STENCIL, VOLUMES, WITHOUT};

/// As noisy as machines are; the same rounds for all ways.
const NOISE: [f64; 9] = [1.0, 1.3, 0.98, 1.02, 2.5, 1.0, 1.01, 0.99, 1.1];

fn cell(way: &str, ms: f64) -> Cell {
    let frame_ms = NOISE.map(|noise| rounded_ms(ms * noise)).to_vec();
    let measured = Measured { frame_ms, first_draws: (ms * 10.0) as usize, ..Measured::default() };
    Cell { way: way.into(), outcome: Outcome::Measured(measured) }
}

fn row(label: &str, x: f64, size: [u32; 2], costs: &[(&str, f64)]) -> Row {
    Row {
        label: label.into(),
        x,
        size,
        auto: None,
        cells: costs.iter().map(|(way, ms)| cell(way, *ms)).collect(),
    }
}

fn run(device: &str, tables: Vec<Table>) -> Run {
    let mut run =
        Run { device: device.into(), driver: "made up".into(), clock: Clock::Gpu, tables: Vec::new() };
    tables.into_iter().for_each(|table| run.put(table));
    run
}

/// Deferred against forward in many passes at two sizes.
fn sizes(name: TableName, deferred: [f64; 2], multipass: [f64; 2]) -> Table {
    let rows = [0, 1].map(|i| {
        let costs = [(DEFERRED, deferred[i]), (MULTIPASS, multipass[i])];
        row(["800 x 600", "1600 x 1200"][i], [0.48, 1.92][i], [800, 600], &costs)
    });
    Table { name, rows: rows.into() }
}

fn verdict(run: &Run, claim: &str) -> Verdict {
    let findings = findings(run);
    findings.iter().find(|f| f.claim.contains(claim)).unwrap_or_else(|| panic!("no claim '{claim}'")).verdict
}

#[test]
fn conclusions_follow_from_the_numbers() {
    // The dissertation's own milliseconds: its conclusions hold of them.
    let there = run(
        "there",
        vec![
            sizes(TableName::Exterior, [5.7, 21.7], [4.4, 7.8]),
            sizes(TableName::Interior, [7.6, 32.3], [10.0, 35.7]),
        ],
    );
    for claim in [
        "Outdoors under one sun forward is faster",
        "Outdoors forward's lead grows",
        "Indoors with several lights deferred is faster",
        "Indoors deferred's lead shrinks",
    ] {
        assert_eq!(verdict(&there, claim), Verdict::Holds, "{claim}");
    }
    assert_eq!(verdict(&there, "Illumination sets"), Verdict::Unknown);
    // And the opposite.
    let here = run(
        "here",
        vec![
            sizes(TableName::Exterior, [4.4, 7.8], [4.44, 9.0]),
            sizes(TableName::Interior, [7.6, 40.0], [10.0, 35.7]),
        ],
    );
    assert_eq!(verdict(&here, "Outdoors under one sun forward is faster"), Verdict::Fails);
    assert_eq!(verdict(&here, "Outdoors forward's lead grows"), Verdict::Fails);
    assert_eq!(verdict(&here, "Indoors with several lights deferred is faster"), Verdict::Partly);
    let findings = findings(&here);
    let evidence = &findings[2].evidence;
    assert!(evidence.starts_with("1.32 (800 x 600), 0.89 (1600 x 1200)"), "{evidence}");
}

#[test]
fn a_floating_light_costs_what_the_frame_without_it_does_not() {
    let costs = [(VOLUMES, 5.0), (STENCIL, 3.2)];
    let mut all: Vec<_> = costs.iter().map(|(way, ms)| cell(way, *ms)).collect();
    all.extend(costs.iter().map(|(way, _)| cell(&format!("{way}, {WITHOUT}"), 3.0)));
    let row = Row { label: String::new(), x: 0.0, size: [4, 3], auto: None, cells: all };
    let cost = floating_cost_ms(&row, STENCIL).unwrap();
    // 0.2 times the median of the noise.
    assert!((cost - 0.202).abs() < 1e-9, "{cost}");
    assert_eq!(floating_cost_ms(&row, CLUSTERS), None);
    let run = run("there", vec![Table { name: TableName::Floating, rows: vec![row] }]);
    assert_eq!(verdict(&run, "The stencil mask"), Verdict::Holds);
}

/// Clusters cost little more with more lights, full screens cost each light.
fn sweep(name: TableName, size: [u32; 2], clusters: fn(f64) -> f64) -> Table {
    let row = |n: f64| {
        let costs = [
            (FULLSCREEN, 1.0 + 0.5 * n),
            (VOLUMES, 1.1 + 0.1 * n),
            (CLUSTERS, clusters(n)),
            (FORWARD, 2.0 + 0.005 * n),
        ];
        row(&n.to_string(), n, size, &costs)
    };
    Table { name, rows: [1.0, 4.0, 16.0, 64.0, 256.0, 1024.0].map(row).into() }
}

#[test]
fn targets_are_judged_on_their_device_at_their_size_only() {
    let size = [1280, 720];
    let met = run("llvmpipe (LLVM 15)", vec![sweep(TableName::Small, size, |n| 1.5 + 0.005 * n)]);
    let judged: Vec<_> = targets(&met).iter().map(|t| t.met).collect();
    assert_eq!(judged, [Some(true), Some(true)], "{:?}", targets(&met));
    let missed = run("llvmpipe (LLVM 15)", vec![sweep(TableName::Small, size, |n| 1.5 + 0.05 * n)]);
    assert_eq!(targets(&missed).iter().map(|t| t.met).collect::<Vec<_>>(), [Some(false), Some(false)]);
    let small = run("llvmpipe (LLVM 15)", vec![sweep(TableName::Small, [64, 36], |n| n)]);
    assert_eq!(targets(&small).iter().map(|t| t.met).collect::<Vec<_>>(), [None, None]);
    let gpu = run("NVIDIA H200", vec![sweep(TableName::Lights, [1920, 1080], |n| 1.3 + 0.004 * n)]);
    assert_eq!(targets(&gpu).iter().map(|t| t.met).collect::<Vec<_>>(), [Some(true), Some(false)]);
    assert!(targets(&run("Another GPU", vec![])).is_empty());
}

#[test]
fn rules_name_the_crossovers() {
    let mut table = sweep(TableName::Lights, [1920, 1080], |n| 1.5 + 0.01 * n);
    for row in &mut table.rows {
        // Right but at 4 lights, where volumes cost 1.5 and clusters 1.54; and never forward.
        let lights = if row.x < 4.0 { VOLUMES } else { CLUSTERS };
        row.auto = Some(Auto { path: DEFERRED.into(), lights: lights.into() });
    }
    let run = run("somewhere", vec![table]);
    let rules = rules(&run);
    let names = |i: usize| rules[i].winners.iter().map(|w| w.name.as_str()).collect::<Vec<_>>();
    assert_eq!(rules.len(), 2);
    assert_eq!(names(0), [VOLUMES, CLUSTERS]);
    // 1.1 + 0.1 n = 1.5 + 0.01 n at 4.4.
    assert!((4.0..6.0).contains(&rules[0].winners[1].from), "{:?}", rules[0]);
    // Deferred in its best way, 1.5 + 0.01 n, against 2 + 0.005 n: level at 100.
    assert_eq!(names(1), [DEFERRED, FORWARD]);
    assert!((64.0..130.0).contains(&rules[1].winners[1].from), "{:?}", rules[1]);
    let (ratio, place) = rules[0].auto_at_worst.unwrap();
    assert!((ratio - 1.54 / 1.5).abs() < 1e-3 && place == 4.0, "{ratio} at {place}");
    // 1.5 + 0.01 n over 2 + 0.005 n at 1024.
    assert!((rules[1].auto_at_worst.unwrap().0 - 11.74 / 7.12).abs() < 1e-3);
    assert!(rules[0].describe().starts_with("volumes, from "), "{}", rules[0].describe());
}

#[test]
fn merged_reports_show_devices_side_by_side() {
    let table = |ms| sizes(TableName::Exterior, [ms, ms], [ms * 2.0, ms * 2.0]);
    let mut report = Report::new(vec![run("First GPU (made up)", vec![table(1.0)])]);
    report.merge(Report::new(vec![run("Second | GPU", vec![table(2.0)])]));
    // Measured again: replaces.
    report.merge(Report::new(vec![run("First GPU (made up)", vec![table(3.0)])]));
    assert_eq!(report.runs.len(), 2);
    assert_eq!(report.runs[0].tables[0].rows[0].ms(DEFERRED), Some(3.03));
    let page = page(&report);
    assert!(page.contains(r"| | question | First GPU | Second \| GPU |"), "{page}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("comparison.json");
    report.write(&path).unwrap();
    let read = Report::read(&path).unwrap();
    assert_eq!(serde_json::to_string(&read).unwrap(), serde_json::to_string(&report).unwrap());
    for bad in ["", "{}", r#"{"version": 99, "runs": []}"#] {
        std::fs::write(&path, bad).unwrap();
        let message = Report::read(&path).unwrap_err().to_string();
        assert!(message.contains("comparison.json") && message.contains("tools/bench compare"), "{message}");
    }
}

//! `ontile chart`: a small run writes every file, keeps what it has, and puts parts together; what cannot be is said.

#![cfg(feature = "cli")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use ontile::gpu::{Headless, HeadlessOptions};
use ontile::measure::chart::{Outcome, Report};
use ontile::measure::ways;
use ontile::plan::{Choice, Layout};

fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name)
}

/// Exit status, standard output and standard error.
fn ontile(arguments: &[&Path]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ontile"));
    let output = command.arg("chart").args(arguments).env_remove("ONTILE_TURNIP_RUN").output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Charts the lamps in little time.
#[track_caller]
fn charted(folder: &Path, more: &[&str]) -> Report {
    let lamps = asset("lamps.glb");
    let flags = ["--sizes", "96x54", "--frames", "2", "--device", common::render::LAVAPIPE];
    let mut arguments = vec![lamps.as_path(), Path::new("-o"), folder];
    arguments.extend(flags.iter().chain(more).map(Path::new));
    let (status, out, err) = ontile(&arguments);
    assert_eq!(status, Some(0), "{out}\n{err}");
    assert!(out.trim_end().ends_with("README.md"), "{out}");
    Report::read(folder).unwrap()
}

fn has_device() -> bool {
    let options =
        HeadlessOptions { device_name_part: Some(common::render::LAVAPIPE.into()), ..Default::default() };
    let found = Headless::new(&options);
    if let Err(error) = &found {
        common::ignored_unless_required(&error.to_string());
    }
    found.is_ok()
}

#[test]
fn a_small_run_writes_everything_and_is_not_repeated() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let all = folder.path().join("all");
    let report = charted(&all, &[]);
    let choices = ontile::measure::chart::default_choices();
    let found: Vec<_> = report.cells.iter().map(|cell| cell.choice).collect();
    assert_eq!(found, choices);

    let mut drawn = 0;
    for cell in &report.cells {
        let Outcome::Measured(m) = &cell.outcome else { continue };
        drawn += 1;
        assert_eq!(m.frame_ms.count, 2, "{}", cell.choice);
        assert!(m.left_out > 0.0 && m.left_out < 0.3, "{}: {}", cell.choice, m.left_out);
        assert!(m.bytes.on_tile >= m.bytes.color_bits / 8 && m.bytes.moved < m.bytes.moved_separate, "{m:?}");
        let (reference, exact) = (&m.against_reference, &m.against_exact);
        if cell.choice == Choice::of(Layout::Exact) {
            // The picture is the ruler's own; from the reference it differs by arithmetic (tests/physics: 1e-3).
            assert_eq!((exact.psnr_db, exact.flip, exact.relative_max), (None, 0.0, 0.0));
            assert!(reference.relative_max < 0.01, "{reference:?}");
        } else {
            assert!(reference.flip > 0.0 && exact.psnr_db.is_some_and(|db| db > 15.0), "{m:?}");
        }
    }
    assert!(drawn >= 2);

    // One line a cell, as many fields in each.
    let csv = fs::read_to_string(all.join("chart.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + report.cells.len());
    let commas = |line: &str| line.split('"').step_by(2).map(|part| part.matches(',').count()).sum::<usize>();
    let counts: Vec<_> = csv.lines().map(commas).collect();
    assert!(counts.iter().all(|count| *count == counts[0]), "{counts:?}");

    // Every picture that the page shows is there, in both formats.
    let page = fs::read_to_string(all.join("README.md")).unwrap();
    let shown: Vec<_> = page.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    assert_eq!(shown.len(), 2, "{shown:?}");
    for name in shown {
        assert!(fs::read_to_string(all.join(name)).unwrap().contains("<svg"), "{name}");
        image::open(all.join(name).with_extension("png")).unwrap();
    }

    // The second run measures nothing: times would not be the same again.
    assert_eq!(charted(&all, &[]), report);
    // Other conditions are other cells.
    assert_eq!(charted(&all, &["--exposure", "1"]).cells.len(), 2 * report.cells.len());

    // Two parts have all cells, once.
    let parts = ["1/2", "2/2"].map(|part| {
        let part_folder = folder.path().join(part.replace('/', "of"));
        charted(&part_folder, &["--shard", part]);
        part_folder
    });
    let merged = folder.path().join("merged");
    let arguments = [Path::new("--merge"), &parts[0], &parts[1], Path::new("-o"), &merged];
    let (status, out, err) = ontile(&arguments);
    assert_eq!(status, Some(0), "{out}\n{err}");
    let merged = Report::read(&merged).unwrap();
    let of = |report: &Report| report.cells.iter().map(|cell| cell.choice).collect::<Vec<_>>();
    assert_eq!(of(&merged), of(&report));
    assert!(merged.cells.iter().all(|cell| cell.place == report.cells[0].place));
}

#[test]
fn what_cannot_be_charted_is_named_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("file"), "no folder").unwrap();
    fs::create_dir(at("broken")).unwrap();
    fs::write(at("broken/chart.json"), "{\"schema\":\"ontile-chart-1\",\"cells\":[{}]}").unwrap();
    fs::create_dir(at("old")).unwrap();
    fs::write(at("old/chart.json"), "{\"schema\":\"ontile-chart-0\"}").unwrap();
    let (lamps, out) = (asset("lamps.glb"), at("out"));
    let [merge, o] = [Path::new("--merge"), Path::new("-o")];
    let cases: [(i32, &[&Path], &str); 7] = [
        (1, &[Path::new("absent.glb"), o, &out], "absent.glb: cannot read"),
        (1, &[&lamps, o, &out, Path::new("--camera"), Path::new("7")], "lamps.glb"),
        (1, &[merge, &at("file"), o, &out], "chart.json: cannot read"),
        (1, &[merge, &at("broken"), o, &out], "chart.json: cells: missing field"),
        (1, &[merge, &at("old"), o, &out], "'ontile-chart-0', not 'ontile-chart-1'"),
        (2, &[&lamps, o, &out, Path::new("--shard"), Path::new("3/2")], "as in 2/4"),
        (2, &[o, &out], "<SCENE>"),
    ];
    for (expected, arguments, message) in cases {
        let (status, said, err) = ontile(arguments);
        assert_eq!(status, Some(expected), "{arguments:?}\n{said}\n{err}");
        assert!(err.contains(message), "{arguments:?}: '{message}' is missing in: {err}");
        assert!(!out.exists(), "{arguments:?}");
    }
}

#[test]
fn ways_are_charted_beside_gbuffers() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (lamps, decals) = (asset("lamps.glb"), asset("decals.glb"));
    let flags = ["--ways", "--sizes", "48x27", "--frames", "1", "--device", common::render::LAVAPIPE];
    let mut arguments = vec![lamps.as_path(), decals.as_path(), Path::new("-o"), folder.path()];
    arguments.extend(flags.iter().map(Path::new));
    let (status, out, err) = ontile(&arguments);
    assert_eq!(status, Some(0), "{out}\n{err}");
    let report: ways::Report =
        serde_json::from_slice(&fs::read(folder.path().join("ways.json")).unwrap()).unwrap();
    let figures = |scene: &str, way: &str| {
        let found = |p: &&ways::Point| p.scene == scene && p.way == way;
        report.points.iter().find(found).unwrap_or_else(|| panic!("{scene}, {way}")).outcome.as_ref()
    };
    let lamps = |way| figures("lamps", way).unwrap();
    let [one, all, compare] = ["1 sample", "4 samples, all", "4 samples, compare"].map(lamps);
    assert!(all.error < one.error && compare.error == all.error, "{one:?}, {all:?}, {compare:?}");
    assert!(compare.lit_by_sample.is_some_and(|share| share > 0.01 && share < 0.9), "{compare:?}");
    assert!(one.lit_by_sample.is_none() && one.on_tile * 4 == all.on_tile);
    let (map, volumes) = (lamps("hardware, 1024 texels"), lamps("volumes"));
    assert!(volumes.error < map.error && volumes.shadow_bytes == 0 && map.shadow_bytes > 0);
    let painted = figures("decals", "barrier, packed128").unwrap();
    assert!(painted.error < 0.02, "{painted:?}");
    let refused = figures("decals", "fixed, packed128").unwrap_err();
    assert!(refused.contains("--decals"), "{refused}");
    let page = fs::read_to_string(folder.path().join("README.md")).unwrap();
    for picture in page.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        assert!(folder.path().join(picture).is_file(), "no {picture}");
    }
    assert!(refused.lines().all(|line| page.contains(line)), "the page does not say why");
    // The page is made of the figures alone.
    let again = tempfile::tempdir().unwrap();
    let merge = ["--ways", "--merge"].map(Path::new);
    let (status, out, err) = ontile(&[&merge[..], &[folder.path(), Path::new("-o"), again.path()]].concat());
    assert_eq!(status, Some(0), "{out}\n{err}");
    assert_eq!(fs::read_to_string(again.path().join("README.md")).unwrap(), page);
}

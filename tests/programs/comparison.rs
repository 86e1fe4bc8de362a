//! `tools/bench compare`: a tiny run writes every file with every table, and runs can be merged.

use std::fs;
use std::path::Path;

use clap::Parser;
use serde_json::Value;

use super::bench::{Args, run};

const TABLES: [&str; 10] = [
    "exterior", "interior", "draws", "coverage", "floating", "sets", "lights", "small", "overlap", "overdraw",
];

/// Runs the program with arguments separated by spaces, and a folder for the output.
fn compare(arguments: &str, output: &Path) -> Result<(), String> {
    let arguments = ["bench", "compare"].into_iter().chain(arguments.split_whitespace());
    let mut arguments: Vec<_> = arguments.map(Into::into).collect();
    arguments.extend(["-o".into(), output.as_os_str().to_owned()]);
    let parsed = Args::try_parse_from(arguments).map_err(|e| e.to_string())?;
    run(&parsed).map_err(|e| e.to_string())
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn a_tiny_run_writes_all_tables_charts_and_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let first = folder.path().join("first");
    compare("--quick --sizes 64x48,80x60 --size 64x36 --frames 2 --most-lights 4", &first).unwrap();

    let report = json(&first.join("comparison.json"));
    let tables = report["runs"][0]["tables"].as_array().unwrap();
    let names: Vec<_> = tables.iter().map(|t| t["name"].as_str().unwrap()).collect();
    assert_eq!(names, TABLES);
    let mut measured = 0;
    for table in tables {
        let rows = table["rows"].as_array().unwrap();
        assert!(!rows.is_empty(), "{}", table["name"]);
        for cell in rows.iter().flat_map(|row| row["cells"].as_array().unwrap()) {
            match cell["measured"]["frame_ms"].as_array() {
                Some(times) => {
                    // Draws are the same in every frame, so one is counted.
                    let rounds = if table["name"] == "draws" { 1 } else { 2 };
                    assert_eq!(times.len(), rounds, "{}: {cell}", table["name"]);
                    assert!(times.iter().all(|ms| ms.as_f64().unwrap() > 0.0), "{cell}");
                    assert!(cell["measured"]["draws"].as_u64().unwrap() > 0, "{cell}");
                    measured += 1;
                }
                // What is refused says why and what to do.
                None => assert!(cell["refused"].as_str().unwrap().contains("; "), "{cell}"),
            }
        }
    }
    assert!(measured > 0);
    let csv = fs::read_to_string(first.join("comparison.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(
        csv.lines().filter(|line| !line.contains('"')).all(|line| line.split(',').count() == columns),
        "{csv}"
    );
    assert!(json(&first.join("derived.json"))[0]["rules"].is_array());

    let page = fs::read_to_string(first.join("README.md")).unwrap();
    let charts: Vec<_> = page.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    assert!(!charts.is_empty(), "{page}");
    for chart in charts {
        let svg = fs::read_to_string(first.join(chart)).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{chart}");
        image::open(first.join(chart).with_extension("png")).unwrap_or_else(|e| panic!("{chart}: {e}"));
    }
    for heading in ["## Where each wins", "## Targets", "## What \"Deferred versus forward", "## The numbers"]
    {
        assert!(page.contains(heading), "{heading} is missing in {page}");
    }

    // One table again, and both runs on one page.
    let second = folder.path().join("second");
    compare("--quick --size 64x36 --frames 2 --most-lights 2 --only small", &second).unwrap();
    let merged = folder.path().join("merged");
    let [a, b] = [&first, &second].map(|folder| folder.join("comparison.json"));
    compare(&format!("--merge {} {}", a.display(), b.display()), &merged).unwrap();
    let report = json(&merged.join("comparison.json"));
    assert_eq!(report["runs"].as_array().unwrap().len(), 1);
    let tables = report["runs"][0]["tables"].as_array().unwrap();
    assert_eq!(tables.len(), TABLES.len());
    let small = tables.iter().find(|t| t["name"] == "small").unwrap();
    assert_eq!(small["rows"].as_array().unwrap().len(), 2, "the later run's");
}

#[test]
fn wrong_arguments_say_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, expected) in [
        ("--device absent-device", "absent-device"),
        ("--merge absent.json", "absent.json"),
        ("--only everything", "everything"),
        ("--sizes 0x3", "0x3"),
        ("--merge a.json --quick", "--quick"),
    ] {
        let message = compare(arguments, folder.path()).unwrap_err();
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}

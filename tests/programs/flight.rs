//! `tools/bench flight`: a place after the other along a camera path.

use std::fs;

use clap::Parser;
use serde_json::Value;

use super::bench::{Args, run};

#[test]
fn a_scene_is_measured_along_a_path() {
    let folder = tempfile::tempdir().unwrap();
    let [way, out] = ["way.flight", "out.json"].map(|name| folder.path().join(name));
    fs::write(&way, "ontile flight 1\n0 0 1 4 0 0 0 1 0.8\n2 1 1 3 0 0 0 1 0.8\n").unwrap();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/lamps.glb");
    let [way, out] = [&way, &out].map(|path| path.to_str().unwrap());
    let args =
        ["bench", "flight", scene, way, "--frames", "3", "--rounds", "1", "--size", "64x36", "-o", out];
    run(&Args::try_parse_from(args).unwrap()).unwrap();
    let results: Value = serde_json::from_slice(&fs::read(out).unwrap()).unwrap();
    let places = results["places"].as_array().unwrap();
    let times: Vec<_> = places.iter().map(|place| place["time_s"].as_f64().unwrap()).collect();
    assert_eq!(times, [0.0, 1.0, 2.0]);
    for place in places {
        assert!(
            ["subpasses_ms", "separate_ms"].iter().all(|ms| place[ms].as_f64().unwrap() > 0.0),
            "{place}"
        );
    }
    fs::write(way, "ontile flight 1\n0 0 1 4\n").unwrap();
    let error = run(&Args::try_parse_from(args).unwrap()).unwrap_err().to_string();
    assert!(error.contains("way.flight: line 2: has 4 values, not 9"), "{error}");
}

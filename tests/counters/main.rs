//! Performance counters (VK_KHR_performance_query) from driver to report. `layer.c` gives lavapipe some whose values are known, below the
//! validation layer, which watches how they are used; Turnip has its own, and no GPU to count.
//!
//! Layers are named in the environment, so what runs on them is a process: the program, or this executable.

#![cfg(feature = "cli")]

#[path = "../common/mod.rs"]
mod common;
mod host;
mod misuse;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use common::render::LAVAPIPE;
use common::{ignored, lavapipe::newer_lavapipe, turnip};
use ontile::measure::tiler::{TilerTrace, Verdict};
use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_ontile");

fn scene(name: &str) -> String {
    format!("{}/assets/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The folder with the compiled layer and its manifest, or why there is none.
fn layer() -> &'static Result<PathBuf, String> {
    static LAYER: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    LAYER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("counters");
        std::fs::create_dir_all(&folder).unwrap();
        let run = |command: &mut Command| {
            let output = command.output().map_err(|e| format!("cc: {e}"))?;
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            output.status.success().then_some(()).ok_or(said)
        };
        let probe = folder.join("probe.c");
        std::fs::write(&probe, "#include <vulkan/vulkan.h>\n#include <vulkan/vk_layer.h>\n").unwrap();
        run(Command::new("cc").arg("-fsyntax-only").arg(&probe))
            .map_err(|why| format!("no C compiler with Vulkan's headers (libvulkan-dev): {why}"))?;
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/counters/layer.c");
        let library = folder.join("libVkLayer_ontile_counters.so");
        let flags =
            ["-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC", "-fvisibility=hidden"];
        run(Command::new("cc").args(flags).arg("-o").arg(&library).arg(source)).unwrap();
        let manifest = serde_json::json!({ "file_format_version": "1.2.0", "layer": {
            "name": "VK_LAYER_ONTILE_counters", "type": "GLOBAL", "library_path": library,
            "api_version": "1.3.0", "implementation_version": "1", "description": "counters for tests",
        }});
        std::fs::write(folder.join("VkLayer_ontile_counters.json"), manifest.to_string()).unwrap();
        Ok(folder)
    })
}

/// A command on the newer lavapipe with counters, below its validation layer (that of 1.3.239 finds mistakes where none are); `None`, and
/// "ignored" is said, where something is absent.
fn counting(program: &Path) -> Option<Command> {
    let mut command = newer_lavapipe(program)?;
    let folder = layer().as_ref().map_err(|why| ignored(why)).ok()?;
    let layers = Path::new(command.get_program()).with_file_name("layers");
    command.env("VK_LAYER_PATH", std::env::join_paths([&layers, folder]).unwrap());
    // From the application to the driver.
    command.env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation:VK_LAYER_ONTILE_counters");
    Some(command)
}

/// What a run that has to end with a status prints, on standard error unless that is 0.
#[track_caller]
fn expect(command: &mut Command, status: i32) -> String {
    let Output { status: ended, stdout, stderr } = command.output().unwrap();
    let (out, err) = (String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap());
    assert_eq!(ended.code(), Some(status), "{command:?}: {ended}\n{out}\n{err}");
    if status == 0 { out } else { err }
}

/// The report of a frame, and its picture.
#[track_caller]
fn render(mut command: Command, args: &[&str]) -> (Value, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    command.arg("render").arg(scene("lamps.glb")).args(["--size", "160x90", "--validate"]).args(args);
    expect(command.arg("-o").arg(at("o.png")).arg("--report").arg(at("r.json")), 0);
    let report = serde_json::from_slice(&std::fs::read(at("r.json")).unwrap()).unwrap();
    (report, std::fs::read(at("o.png")).unwrap())
}

fn program() -> Option<Command> {
    counting(Path::new(PROGRAM))
}

/// What `layer.c` counts in a frame: name, category, unit, value.
fn counted(report: &Value) -> [(&'static str, &'static str, &'static str, f64); 8] {
    let draws = report["device"]["frame"]["draws"].as_f64().unwrap();
    let passes = report["passes"].as_array().unwrap().len() as f64;
    [
        ("Draws", "Commands", "generic", draws),
        ("Render Passes", "Commands", "generic", passes),
        ("Written", "Memory", "bytes", 1_099_511_627_781.0),
        ("Busy", "Shader", "percentage", 62.5),
        ("Drift", "Time", "nanoseconds", -1_099_511_627_779.0),
        ("Below", "Heat", "kelvin", -7.0),
        ("Power", "Core", "watts", 0.1),
        ("Power", "Memory", "watts", 0.2),
    ]
}

#[track_caller]
fn assert_counted(report: &Value, passes: u32, wanted: &[usize]) {
    let counters = &report["device"]["counters"];
    assert_eq!(counters["passes"], passes);
    let known = counted(report);
    let expected: Vec<_> = wanted
        .iter()
        .map(|&index| {
            let (name, category, unit, value) = known[index];
            let value = serde_json::json!({ "value": value, "origin": "driver" });
            serde_json::json!({ "name": name, "category": category, "unit": unit, "value": value })
        })
        .collect();
    assert_eq!(counters["counters"], Value::Array(expected));
}

#[test]
fn reports_hold_what_was_counted() {
    let Some(command) = program() else { return };
    let (plain, picture) = render(command, &[]);
    assert!(plain["device"].get("counters").is_none(), "nobody asked");
    let all = [0, 1, 2, 3, 4, 5, 6, 7];
    let (report, counted_picture) = render(program().unwrap(), &["--counters", "all"]);
    assert_counted(&report, 3, &all);
    assert_eq!(picture, counted_picture);
    assert_eq!(plain["device"]["frame"], report["device"]["frame"]);
    // The layer counts n in pass n % 3, and the frames before have nothing to do with it.
    for (args, passes, wanted) in [
        (["--counters", "draws", "--frames", "3"], 1, &[0][..]),
        (["--counters", "POWER,0", "--samples", "4"], 2, &[6, 7, 0]),
        (["--counters", "written,Render Passes", "--strategy", "separate"], 3, &[2, 1]),
        (["--counters", "5,Draws,1", "--bloom", "previous"], 3, &[5, 0, 1]),
    ] {
        let (mut report, _) = render(program().unwrap(), &args);
        // Bloom's own passes follow the frame's.
        let post = report["post_passes"].as_array().unwrap().clone();
        report["passes"].as_array_mut().unwrap().extend(post);
        assert_counted(&report, passes, wanted);
    }
}

#[test]
fn info_lists_counters() {
    let Some(mut command) = program() else { return };
    let json = expect(command.args(["info", "--counters", "--json"]), 0);
    let json: Value = serde_json::from_str(&json).unwrap();
    let is_lavapipe = |device: &&Value| device["name"].as_str().unwrap().contains(LAVAPIPE);
    let device = json["devices"].as_array().unwrap().iter().find(is_lavapipe).unwrap();
    assert_eq!(device["performance_counters"], true);
    let counters = device["counters"].as_array().unwrap();
    let kinds = counters.iter().map(|c| [&c["name"], &c["unit"], &c["scope"], &c["storage"]]);
    let kinds: Vec<_> = kinds.map(|all| all.map(|v| v.as_str().unwrap())).collect();
    assert_eq!(
        kinds,
        [
            ["Draws", "generic", "command", "uint32"],
            ["Render Passes", "generic", "render_pass", "uint64"],
            ["Written", "bytes", "command_buffer", "uint64"],
            ["Busy", "percentage", "command", "float32"],
            ["Drift", "nanoseconds", "command_buffer", "int64"],
            ["Below", "kelvin", "command_buffer", "int32"],
            ["Power", "watts", "command", "float64"],
            ["Power", "watts", "command", "float64"],
        ]
    );
    let impacting: Vec<_> = counters.iter().map(|c| c["performance_impacting"] == true).collect();
    assert_eq!(impacting, [false, false, true, false, false, false, false, false]);
    let text = expect(program().unwrap().args(["info", "--counters"]), 0);
    let line = "counter 2                   Written (Memory; bytes, per command buffer), slows down: Bytes that leave the chip";
    assert!(text.contains(line), "{text}");
    assert!(!expect(program().unwrap().arg("info"), 0).contains("counter 2"), "nobody asked");
}

#[test]
fn what_cannot_be_counted_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let asked = |mut command: Command, counters: &str| {
        command.current_dir(folder.path()).args([
            "render",
            &scene("unlit.glb"),
            "-o",
            "o.png",
            "--counters",
            counters,
        ]);
        command
    };
    let refused = |mut command: Command, message: &str| {
        let said = expect(command.args(["--report", "r.json", "--device", LAVAPIPE]), 1);
        assert!(said.contains(message) && said.lines().count() == 1, "'{message}' is not in: {said}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "something was written");
    };
    expect(&mut asked(Command::new(PROGRAM), "all"), 2);
    let Some(command) = program() else { return };
    for nonsense in ["nonsense", "draws,,busy", "8", "-1", ""] {
        let name = nonsense.split(',').find(|name| *name != "draws").unwrap();
        let message = format!("has no performance counter '{name}'; 'ontile info --counters' lists");
        refused(asked(program().unwrap(), nonsense), &message);
    }
    let mut locked = asked(command, "all");
    locked.env("ONTILE_COUNTERS_LOCKED", "1");
    refused(locked, "does not hand out its profiling lock; end other programs");
    refused(
        asked(Command::new(PROGRAM), "all"),
        "has no performance counters (VK_KHR_performance_query); use",
    );
}

const FAULT: &str = "ONTILE_COUNTERS_FAULT";
const TOLD: &str = "ONTILE_COUNTERS_TOLD";

#[test]
#[ignore = "the other tests run it, each in a process with counters"]
fn child_counts() {
    let (Ok(fault), Some(told)) = (std::env::var(FAULT), std::env::var_os(TOLD)) else { return };
    let messages = if fault == "host" { host::counts() } else { misuse::run(&fault) };
    std::fs::write(told, serde_json::to_vec(&messages).unwrap()).unwrap();
}

/// What the validation layer says of a child with this fault.
fn child(fault: &str) -> Option<Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    let told = folder.path().join("told.json");
    let mut command = counting(&std::env::current_exe().unwrap())?;
    command.args(["--ignored", "--exact", "child_counts", "--nocapture"]).env(FAULT, fault).env(TOLD, &told);
    expect(&mut command, 0);
    Some(serde_json::from_slice(&std::fs::read(told).unwrap()).unwrap())
}

#[test]
fn a_host_counts_its_own_frames() {
    let Some(messages) = child("host") else { return };
    assert_eq!(messages, Vec::<String>::new());
}

/// The rules that the other tests keep are watched.
#[test]
fn misuse_is_found_out() {
    for (fault, rule) in misuse::FAULTS {
        let Some(messages) = child(fault) else { return };
        match rule {
            "" => assert_eq!(messages, Vec::<String>::new()),
            rule => assert!(messages.iter().any(|m| m.contains(rule)), "{fault}: no {rule} in {messages:#?}"),
        }
    }
}

/// A driver of its own counters: it lists them, has so many that they take several passes, and each of these stays on the tile. Without
/// a GPU no value ever comes.
#[test]
fn turnip_counts_on_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (gpu, least) in [(660, 400), (740, 1000)] {
        let command = || {
            let mut command = turnip.command(gpu, Path::new(PROGRAM));
            command.env("TU_DEBUG", "gmem,nolrz,perf,perfcraw");
            command
        };
        let listed: Value =
            serde_json::from_str(&expect(command().args(["info", "--counters", "--json"]), 0)).unwrap();
        let listed = listed["devices"][0]["counters"].as_array().unwrap().clone();
        assert!(listed.len() > least, "{gpu}: {} counters", listed.len());
        let mut rendered = command();
        rendered.args(["render", &scene("lamps.glb"), "--size", "1920x1080", "--no-shadows", "--validate"]);
        rendered.arg("-o").arg(at("o.png")).args(["--counters", "all", "--report"]).arg(at("r.json"));
        let TilerTrace { passes, warnings } = turnip::trace(rendered).trace;
        let report: Value = serde_json::from_slice(&std::fs::read(at("r.json")).unwrap()).unwrap();
        let counters = &report["device"]["counters"];
        let told = counters["counters"].as_array().unwrap();
        assert_eq!(told.len(), listed.len());
        for (told, listed) in told.iter().zip(&listed) {
            assert_eq!([&told["name"], &told["unit"]], [&listed["name"], &listed["unit"]]);
            assert_eq!(told["value"], Value::Null);
        }
        let counted = counters["passes"].as_u64().unwrap() as usize;
        println!("Adreno {gpu}: {} counters in {counted} passes", listed.len());
        // Beside the frame itself, and those that count what edges there are.
        assert!(counted > 1 && passes.len() > counted, "{gpu}: {counted} passes of {}", passes.len());
        for pass in passes {
            let alone = TilerTrace { passes: vec![pass], warnings: warnings.clone() };
            assert_eq!(alone.verdict(4), Verdict::OnTile, "{gpu}");
        }
    }
}

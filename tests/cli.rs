//! The program as a user meets it: exit status, standard output, standard error, files.

#![cfg(feature = "cli")]

#[path = "common/gltf_build.rs"]
#[allow(dead_code, reason = "each test file uses some of this")]
mod gltf_build;

use std::path::Path;
use std::process::{Command, Output, Stdio};

use ontile::picture::{Picture, Pixels};

fn ontile(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ontile")).args(args).current_dir(folder).output().unwrap()
}

/// The output of a run that has to end with `status`; failures have one message and print nothing else.
#[track_caller]
fn expect(folder: &Path, status: i32, args: &[&str]) -> String {
    let output = ontile(folder, args);
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (out, err) = (text(output.stdout), text(output.stderr));
    assert_eq!(output.status.code(), Some(status), "{args:?}\n{out}\n{err}");
    match status {
        0 => assert_eq!(err, "", "{args:?}"),
        1 => {
            assert!(err.starts_with("ontile: "), "{args:?}: {err}");
            assert_eq!((err.lines().count(), out.as_str()), (1, ""), "{args:?}: {err}");
        }
        _ => assert_eq!(out, "", "{args:?}"),
    }
    if status == 0 { out } else { err }
}

fn rgba8(width: u32, height: u32, red: impl Fn(u32) -> u8) -> Picture {
    let pixels = (0..width * height).flat_map(|i| [red(i), 50, 60, 255]).collect();
    Picture { width, height, pixels: Pixels::Rgba8(pixels) }
}

/// `a.png`, `b.png` (red is one step higher), `wide.png`, `a.exr`, `half.png` (a mask for the left half).
fn pictures() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let a = rgba8(16, 16, |i| (i % 16) as u8 * 8);
    a.write(&at("a.png")).unwrap();
    a.to_linear().write(&at("a.exr")).unwrap();
    rgba8(16, 16, |i| (i % 16) as u8 * 8 + 1).write(&at("b.png")).unwrap();
    rgba8(32, 16, |_| 0).write(&at("wide.png")).unwrap();
    let left = (0..256).flat_map(|i| if i % 16 < 8 { [255; 4] } else { [0, 0, 0, 255] }).collect();
    Picture { width: 16, height: 16, pixels: Pixels::Rgba8(left) }.write(&at("half.png")).unwrap();
    std::fs::write(at("text.png"), "no picture").unwrap();
    folder
}

#[test]
fn compare_tells_people_and_programs() {
    let folder = pictures();
    let text = expect(folder.path(), 0, &["compare", "a.png", "b.png"]);
    // Red differs by one step of 255 and green and blue do not: 10 log10(255² * 3) = 52.90 dB.
    for expected in ["16x16, 256 compared", "256 (100.000 %)", "52.90 dB", "SSIM", "FLIP", "CIEDE2000"] {
        assert!(text.contains(expected), "{expected} is missing in:\n{text}");
    }
    let json = expect(folder.path(), 0, &["compare", "a.png", "b.png", "--json", "--mask", "half.png"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["compared_pixels"], 128);
    assert_eq!(json["differing_pixels"], 128);
    assert_eq!(json["channels"][0]["max"], 1.0);
    assert_eq!(json["channels"][1]["max"], 0.0);
    assert_eq!(json["unit"], "8-bit steps");
}

#[test]
fn the_model_is_fed_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let json = |args: &[&str]| -> serde_json::Value {
        serde_json::from_str(&expect(folder.path(), 0, args)).unwrap()
    };
    let table = json(&["model", "--table-2", "--json"]);
    assert_eq!((&table[8]["n_mrt"], &table[8]["mrt_bpp"]), (&4.into(), &128.into()));
    assert_eq!(table[8]["printed_gb_s"], 42.0);
    // By hand, a pixel: 3 * 4 + 1.5 * 4 of depth, 2 * 3 * 1.5 of textures, 16 * 1.5 of targets; then 2 * (8 + 12 + 16).
    let hand = json(&["model", "--size", "100x10", "--n", "2", "--c-geometry", "0", "--fps", "30", "--json"]);
    let both =
        hand["bandwidth_b_s"]["read"].as_f64().unwrap() + hand["bandwidth_b_s"]["written"].as_f64().unwrap();
    assert_eq!(both, 30.0 * 1000.0 * (51.0 + 72.0));
    assert!(hand["approximated_b_s"].is_null());
    assert!(expect(folder.path(), 0, &["model"]).contains("approximated (7), GB/s"));
    assert!(
        expect(folder.path(), 1, &["model", "--sorting", "4"]).contains("Sorting (4) is above Overdraw (3)")
    );
    for wrong in [&["--n", "-1"][..], &["--t-b", "NaN"], &["--fps", "inf"], &["--table-2", "--n", "3"]] {
        expect(folder.path(), 2, &[&["model"], wrong].concat());
    }
}

#[test]
fn compare_knows_identical_pictures() {
    let folder = pictures();
    assert!(expect(folder.path(), 0, &["compare", "a.exr", "a.exr"]).contains("identical"));
    let json = expect(folder.path(), 0, &["compare", "a.png", "a.png", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["identical"], true);
    assert!(json["psnr_db"].is_null());
    assert_eq!(json["ssim"], 1.0);
}

#[test]
fn compare_paints_where_pictures_differ() {
    let folder = pictures();
    expect(folder.path(), 0, &["compare", "a.png", "b.png", "--mask", "half.png", "--picture", "where.png"]);
    let Pixels::Rgba8(channels) = Picture::read(&folder.path().join("where.png")).unwrap().pixels else {
        panic!("8 bits expected")
    };
    assert_eq!(channels[..4], [252, 253, 191, 255], "the left half differs most");
    assert_eq!(channels[8 * 4..9 * 4], [0, 0, 4, 255], "the right half does not count");
}

#[test]
fn failures_are_one_message_and_status_1() {
    let folder = pictures();
    let cases: [(&[&str], &str); 6] = [
        (&["absent.png", "a.png"], "absent.png: cannot read: No such file"),
        (&["a.png", "text.png"], "text.png: picture: "),
        (&["a.png", "wide.png"], "the pictures differ in size: 16x16 and 32x16"),
        (&["a.png", "a.exr"], "8 bits a channel"),
        (&["a.png", "b.png", "--mask", "wide.png"], "the mask is 32x16"),
        (&["a.png", "b.png", "--picture", "absent/where.png"], "absent/where.png: cannot write"),
    ];
    for (args, expected) in cases {
        let message = expect(folder.path(), 1, &[&["compare"], args].concat());
        assert!(message.contains(expected), "{message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 6, "a failure left a file behind");
}

#[test]
fn wrong_usage_is_status_2() {
    let folder = pictures();
    let cases: [(&[&str], &str); 5] = [
        (&[], "Usage: ontile"),
        (&["paint"], "paint"),
        (&["compare", "a.png"], "<B>"),
        (&["compare", "a.png", "b.png", "--loud"], "--loud"),
        (&["compare", "a.png", "b.png", "--picture", "where.jpg"], "name it .png"),
    ];
    for (args, expected) in cases {
        let message = expect(folder.path(), 2, args);
        assert!(message.contains(expected), "{args:?}: {message}");
    }
}

#[test]
fn help_names_every_flag() {
    let folder = pictures();
    let help = expect(folder.path(), 0, &["--help"]);
    for expected in ["compare", "Exit status: 0", "--version"] {
        assert!(help.contains(expected), "{expected} is missing in:\n{help}");
    }
    let help = expect(folder.path(), 0, &["compare", "--help"]);
    for expected in ["<A>", "<B>", "--json", "--mask", "--picture", "Examples:\n  ontile compare "] {
        assert!(help.contains(expected), "{expected} is missing in:\n{help}");
    }
    assert!(expect(folder.path(), 0, &["--version"]).starts_with("ontile "));
}

/// A reader that left is no failure; a full disk is one.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_may_break() {
    let folder = pictures();
    let run = |out: Stdio, args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ontile"));
        command.args(args).current_dir(folder.path()).stdout(out).stderr(Stdio::piped()).output().unwrap()
    };
    for args in [&["compare", "a.png", "b.png"][..], &["compare", "--help"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = run(writer.into(), args);
        assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]), "{args:?}");
    }
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = run(full.into(), &["compare", "a.png", "b.png"]);
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.starts_with("ontile: standard output: cannot write"), "{message}");
}

#[test]
fn environments_are_baked_and_taken_in_the_panoramas_place() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sky = |i: u32| if i < 256 { 200 } else { 20 };
    rgba8(32, 16, sky).to_linear().write(&at.join("sky.exr")).unwrap();
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/grid.glb"), at.join("grid.glb")).unwrap();
    expect(at, 0, &["bake", "environment", "sky.exr", "-o", "sky.ktx2", "--size", "32"]);

    let plan = |args: &[&str]| expect(at, 0, &[&["plan", "grid.glb", "--environment"], args].concat());
    assert!(plan(&["sky.exr", "--environment-format", "rgbm"]).contains("cube 256x256, 6 levels, rgbm"));
    assert!(plan(&["sky.ktx2"]).contains("cube 32x32, 3 levels, e5b9g9r9"), "as it was baked");
    assert!(
        !plan(&["sky.ktx2", "--environment-intensity", "0"]).contains("radiance"),
        "no light, no texture"
    );

    let fails = |args: &[&str], part: &str| {
        let message = expect(at, 1, args);
        assert!(message.contains(part), "{args:?}: {message}");
    };
    rgba8(32, 16, sky).write(&at.join("sky.png")).unwrap();
    fails(&["bake", "environment", "sky.ktx2", "-o", "again.ktx2"], "filtered already");
    fails(&["bake", "environment", "sky.exr", "-o", "sky.hdr"], "ends in .ktx2");
    fails(&["bake", "environment", "sky.png", "-o", "new.ktx2"], "cannot hold radiance");
    fails(&["plan", "grid.glb", "--environment", "absent.hdr"], "absent.hdr: cannot read");
    assert!(!at.join("again.ktx2").exists() && !at.join("new.ktx2").exists());
}

const GRID: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/grid.glb");

#[test]
fn flags_without_effect_are_told() {
    let folder = tempfile::tempdir().unwrap();
    rgba8(32, 16, |_| 200).to_linear().write(&folder.path().join("sky.exr")).unwrap();
    for (flags, part) in [
        (
            &["--environment-format", "rgbm"][..],
            "--environment-format is without effect: there is no environment",
        ),
        (&["--lightmap-format", "rgbm"], "--lightmap-format is without effect: there is no lightmap"),
        (
            &["--no-illumination-sets"],
            "--no-illumination-sets is without effect: the path is not forward-multipass",
        ),
        (&["--bloom-radius", "0.3"], "--bloom-strength or --bloom-radius is without effect: --bloom is off"),
        (
            &["--resolve", "plain"],
            "--edges or --resolve is without effect: a pixel has one sample (--samples)",
        ),
    ] {
        let output = ontile(folder.path(), &[&["plan", GRID], flags].concat());
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && err.contains(part), "{flags:?}: {err}");
    }
    // `expect` wants no word on standard error.
    expect(folder.path(), 0, &["plan", GRID, "--environment-format", "rgbm", "--environment", "sky.exr"]);
    expect(folder.path(), 0, &["plan", GRID, "--no-illumination-sets", "--path", "forward-multipass"]);
    expect(folder.path(), 0, &["plan", GRID, "--bloom", "previous", "--bloom-radius", "0.3"]);
    expect(folder.path(), 0, &["plan", GRID, "--samples", "4", "--resolve", "plain"]);
}

#[test]
fn environments_that_are_too_bright_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    rgba8(32, 16, |_| 200).to_linear().write(&folder.path().join("sky.exr")).unwrap();
    let plan = ["plan", GRID, "--environment", "sky.exr", "--environment-intensity"];
    let message = expect(folder.path(), 1, &[&plan[..], &["1e38"]].concat());
    assert!(message.contains("at most 1e12 cd/m² are supported; lower --environment-intensity"), "{message}");
    expect(folder.path(), 0, &[&plan[..], &["1e11"]].concat());
}

#[test]
fn lightmaps_are_baked_with_an_environment_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    rgba8(32, 16, |_| 200).to_linear().write(&at.join("sky.exr")).unwrap();
    let dark = gltf_build::Gltf::triangle().write_beside(at, "dark");
    let dark = dark.to_str().unwrap();
    let bake = ["bake", "lightmap", dark, "-o", "out.glb", "--size", "16", "--samples", "4"];
    let message = expect(at, 1, &bake);
    assert!(message.contains("dark.gltf: ") && message.contains("no light to bake"), "{message}");
    let with = |more: &[&str]| {
        expect(at, 0, &[&bake[..], &["--environment", "sky.exr"], more].concat());
        std::fs::read(at.join("out.glb")).unwrap()
    };
    assert_ne!(with(&[]), with(&["--environment-intensity", "2"]));
    let message = expect(at, 1, &["plan", GRID, "--camera", "-1"]);
    assert!(message.contains("grid.glb: scene 'grid' has no camera '-1'; use one of"), "{message}");
}

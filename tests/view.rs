//! `ontile view` in a real window: an X server without a screen, lavapipe, the validation layer.

#![cfg(all(feature = "cli", feature = "view", target_os = "linux"))]

mod common;
#[path = "common/gltf_build.rs"]
#[allow(dead_code, reason = "what is made here is little")]
mod gltf_build;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use common::ignored_unless_required;
use common::render::{LAVAPIPE, difference};
use gltf_build::{Channel, Gltf, animate};
use ontile::picture::{Picture, Pixels};
use ontile::scene::Flight;
use serde_json::json;

/// An X server of the test's own.
struct Screen {
    server: Child,
    display: String,
}

impl Screen {
    /// `None`, and said so, where there is no such server.
    fn new() -> Option<Self> {
        let server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x1024x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut server = match server {
            Ok(server) => server,
            Err(error) => {
                ignored_unless_required(&format!("no Xvfb: {error}"));
                return None;
            }
        };
        // It tells its number once it listens.
        let mut number = String::new();
        let out = server.stdout.take().expect("it is piped");
        BufReader::new(out).read_line(&mut number).expect("Xvfb tells its display");
        Some(Self { server, display: format!(":{}", number.trim()) })
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

fn asset(name: &str) -> String {
    let path: PathBuf = [env!("CARGO_MANIFEST_DIR"), "assets", name].iter().collect();
    path.to_str().expect("its name is text").to_owned()
}

/// Runs the program; what it said on standard error.
#[track_caller]
fn ontile(folder: &Path, display: &str, args: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ontile"));
    command.args(args).args(["--device", LAVAPIPE]).current_dir(folder);
    command.env("DISPLAY", display).env_remove("WAYLAND_DISPLAY");
    let output = command.output().expect("the program runs");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {told}");
    told
}

/// Runs a script in a window under the validation layer.
#[track_caller]
fn view(folder: &Path, display: &str, script: &str, args: &[&str]) -> String {
    std::fs::write(folder.join("script.txt"), script).expect("the folder takes files");
    ontile(folder, display, &[&["view"], args, &["--script", "script.txt", "--validate"]].concat())
}

#[test]
fn the_window_shows_the_picture_of_render() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let cases: [(&str, &[&str]); 9] = [
        ("lamps.glb", &[]),
        ("lamps.glb", &["--strategy", "separate", "--layout", "packed128", "--samples", "4"]),
        ("glass.glb", &["--present", "immediate", "--frames-in-flight", "3"]),
        ("chapel.glb", &["--shadow-map", "1024", "--no-recycle"]),
        ("decals.glb", &["--edge-filter"]),
        ("lamps.glb", &["--show", "channels"]),
        ("lamps.glb", &["--show", "lights", "--lights", "clusters", "--layout", "packed128"]),
        ("decals.glb", &["--show", "edges", "--samples", "4"]),
        ("lamps.glb", &["--exposure", "1", "--dither", "--lights", "clusters"]),
    ];
    for (name, options) in cases {
        let scene = asset(name);
        let args = [&[scene.as_str(), "--size", "160x90"], options].concat();
        let told = view(folder.path(), &screen.display, "frames 4\nscreenshot window.png", &args);
        assert_eq!(told, "", "{args:?}");
        let of_window = ["--present", "immediate", "fifo", "--frames-in-flight", "3"];
        let rest: Vec<_> = args.iter().copied().filter(|arg| !of_window.contains(arg)).collect();
        ontile(folder.path(), "", &[&["render"], &rest[..], &["-o", "render.png"]].concat());
        let difference = difference(&picture("window.png"), &picture("render.png"));
        assert_eq!(difference, None, "{args:?}");
    }
}

/// Images that lie as a turned screen does, whose size the window has: the picture of the other size.
#[test]
fn a_turned_screen_shows_the_same() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let lamps = asset("lamps.glb");
    let script = "frames 1\nturn 90\nframes 1\nscreenshot 90.png\nsize 160x90\nturn 180\nscreenshot 180.png\n\
                  size 90x160\nturn 270\nscreenshot 270.png\nsize 160x90\nturn 0\nscreenshot 0.png\n";
    let told = view(folder.path(), &screen.display, script, &[&lamps, "--size", "90x160"]);
    assert_eq!(told, "");
    ontile(folder.path(), "", &["render", &lamps, "--size", "160x90", "-o", "render.png"]);
    assert_eq!(difference(&picture("0.png"), &picture("render.png")), None);
    for name in ["90.png", "180.png"] {
        // The tests of pre-rotation say how near; a picture that is turned wrongly is below 15 dB.
        let error = ontile::measure::compare(&picture(name), &picture("render.png"), None).unwrap();
        assert!(error.psnr_db.is_none_or(|db| db > 45.0), "{name}: {error:?}");
    }
}

/// The overlay covers a part of the picture, by whatever the frame is drawn, and leaves no trace when it goes.
#[test]
fn the_overlay_comes_and_goes() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let lamps = asset("lamps.glb");
    let mut script =
        String::from("frames 3\nscreenshot before.png\nlive before.json\noverlay on\nframes 3\n");
    for (name, value) in OVER {
        script += &format!("set {name} {value}\nframes 2\nscreenshot {name}-{value}.png\n");
    }
    script += "size 200x120\nframes 2\nsize 640x360\noverlay off\nset strategy subpasses\nset samples 1\nset layout metallic128\n";
    script += "frames 3\nscreenshot after.png\nlive after.json\n";
    let told = view(folder.path(), &screen.display, &script, &[&lamps, "--size", "640x360"]);
    assert_eq!(told, "");
    assert_eq!(difference(&picture("after.png"), &picture("before.png")), None);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("after.json"), read("before.json"));
    for (name, value) in OVER {
        let over = picture(&format!("{name}-{value}.png"));
        assert!(difference(&over, &picture("before.png")).is_some(), "{name} {value}: no overlay");
    }
}

/// Options that change what the overlay is drawn over.
const OVER: [(&str, &str); 4] =
    [("strategy", "separate"), ("samples", "4"), ("strategy", "subpasses"), ("layout", "packed128")];

/// A triangle that shrinks to nothing and comes back mirrored, another beside it that turns, a lamp that passes by and a camera that
/// nears; by a second animation the first one slides.
fn moving_parts() -> Vec<u8> {
    let mut file = Gltf::triangle();
    let other = file.root_node(json!({"mesh": 0, "translation": [-1, 0, 0]}));
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 8}]}});
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    file.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}));
    let lamp = json!({"translation": [0, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}});
    let (lamp, camera) =
        (file.root_node(lamp), file.root_node(json!({"camera": 0, "translation": [0, 0, 3]})));
    let sizes = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 1.0];
    let channels: [Channel; 4] = [
        (0, "scale", "STEP", &[0.0, 0.25, 0.5], "VEC3", &sizes),
        (other, "rotation", "LINEAR", &[0.0, 0.75], "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.6, 0.8]),
        (lamp, "translation", "LINEAR", &[0.0, 0.75], "VEC3", &[-1.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
        (camera, "translation", "LINEAR", &[0.0, 0.75], "VEC3", &[0.0, 0.0, 3.0, 0.5, 0.0, 2.0]),
    ];
    animate(&mut file, &channels);
    let slide: Channel = (0, "translation", "LINEAR", &[0.0, 0.5], "VEC3", &[0.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
    animate(&mut file, &[slide]);
    file.to_gltf()
}

/// A window that goes from one time to another shows what `render` shows of it at once; hundreds of frames that play leave nothing.
#[test]
fn what_plays_is_the_picture_of_its_time_and_leaves_nothing_behind() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("parts.gltf"), moving_parts()).unwrap();
    let charmer = asset("charmer.glb");
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let cases: [(&str, &[&str], [f64; 4]); 4] = [
        ("parts.gltf", &["--animation", "all"], [0.6, 0.3, 0.1, 0.7]),
        (
            "parts.gltf",
            &["--strategy", "separate", "--samples", "4", "--animation", "0"],
            [0.3, 0.0, 0.6, 9.0],
        ),
        (&charmer, &[], [1.3, 0.2, 2.9, 0.0]),
        (&charmer, &["--shadow-volumes", "--frames-in-flight", "3"], [0.4, 1.3, 1.3, -1.0]),
    ];
    for (scene, options, times) in cases {
        let args = [&[scene, "--size", "160x90"], options].concat();
        let mut script = String::from("frames 4\nscreenshot begin.png\nlive before.json\n");
        for (i, time) in times.iter().enumerate() {
            script += &format!("time {time}\nframes {}\nscreenshot {i}.png\n", i % 3);
        }
        script += &format!("speed 3\nplay\nframes {PLAYED}\noverlay on\nframes 20\noverlay off\npause\n");
        script += "time 0\nframes 4\nscreenshot end.png\nlive after.json\n";
        let told = view(folder.path(), &screen.display, &script, &args);
        assert_eq!(told, "", "{args:?}");
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(read("after.json"), read("before.json"), "{args:?}");
        assert_eq!(difference(&picture("end.png"), &picture("begin.png")), None, "{args:?}");
        for (name, time) in ["begin", "0", "1", "2", "3"].into_iter().zip([0.0].iter().chain(&times)) {
            let time = time.to_string();
            let of_window = ["--frames-in-flight", "3"];
            let rest: Vec<_> = args.iter().copied().filter(|arg| !of_window.contains(arg)).collect();
            let at = [&["render"], &rest[..], &["--time", &time, "-o", "render.png"]].concat();
            ontile(folder.path(), "", &at);
            let difference = difference(&picture(&format!("{name}.png")), &picture("render.png"));
            assert_eq!(difference, None, "{args:?} at {time} s");
        }
        let moves = times
            .iter()
            .zip(0..)
            .any(|(_, i)| difference(&picture(&format!("{i}.png")), &picture("begin.png")).is_some());
        assert!(moves, "{args:?}: nothing moves");
    }
}

/// Frames that play: several times round at any rate.
const PLAYED: usize = 300;

/// A camera that is turned by hand, recorded and flown again; `render` flies the same way.
#[test]
fn a_camera_path_is_recorded_and_flown() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let lamps = asset("lamps.glb");
    let args = [lamps.as_str(), "--size", "160x90"];
    let script = "frames 3\nscreenshot begin.png\nrecord way.flight\nframes 2\ndrag 40 5\nframes 2\ndrag 30 -3\nframes 2\nstop\n\
                  camera 0\nfly way.flight\nscreenshot flown.png\ncamera 0\nscreenshot back.png\nrecord whole.flight\nframes 1";
    assert_eq!(view(folder.path(), &screen.display, script, &args), "");
    let way = Flight::load(&folder.path().join("way.flight")).unwrap();
    let mut eyes: Vec<_> = way.keys().iter().map(|key| key.eye_m).collect();
    eyes.dedup();
    assert_eq!(eyes.len(), 3, "{way:?}");
    assert!(way.keys().iter().all(|key| key.yfov_rad == way.keys()[0].yfov_rad));
    assert!(Flight::load(&folder.path().join("whole.flight")).is_ok(), "what is not stopped is written too");
    assert_eq!(difference(&picture("back.png"), &picture("begin.png")), None);
    assert!(difference(&picture("flown.png"), &picture("begin.png")).is_some(), "it flies");
    let render =
        ["render", &lamps, "--size", "160x90", "--flight", "way.flight", "--frames", "3", "-o", "render.png"];
    ontile(folder.path(), "", &render);
    assert_eq!(difference(&picture("flown.png"), &picture("render.png")), None);
    // A flight to begin with.
    view(
        folder.path(),
        &screen.display,
        "frames 300\nscreenshot end.png",
        &[&args[..], &["--flight", "way.flight"]].concat(),
    );
    assert_eq!(difference(&picture("end.png"), &picture("flown.png")), None);
}

/// A left of the divider and B right of it are the two pictures bit for bit, the difference of equal ones is black, and what is told of
/// others is true; the divider moves, the window changes its size, and nothing is left behind.
#[test]
fn two_ways_to_draw_are_compared() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = "frames 3\nscreenshot a.png\nlive before.json\nset b.layout packed128\nset b.samples 4\nset b.tonemap aces\n\
                  split 0.25\nframes 3\nscreenshot quarter.png\nsplit 0.7\nscreenshot most.png\noverlay on\nframes 3\n\
                  size 200x120\nframes 2\nsize 160x90\nframes 2\noverlay off\nsuspend\nframes 1\nresume\nframes 2\n\
                  screenshot again.png\nmeasure apart.json\ndifference 2\nframes 3\nscreenshot apart.png\noverlay on\nframes 3\n\
                  size 200x120\nframes 2\nsize 160x90\noverlay off\nset layout packed128\nset samples 4\nset tonemap aces\n\
                  frames 2\nscreenshot none.png\nmeasure none.json\nset edge-filter true\ndifference off\nframes 2\nscreenshot b.png\n\
                  set layout metallic128\nset samples 1\nset tonemap neutral\nframes 3\nscreenshot after.png\nlive after.json\n";
    let lamps = asset("lamps.glb");
    let told = view(folder.path(), &screen.display, script, &[&lamps, "--size", "160x90"]);
    assert!(told.lines().count() == 1 && told.contains("--edge-filter out"), "{told}");
    let bytes = |name: &str| match Picture::read(&folder.path().join(name)).unwrap().pixels {
        Pixels::Rgba8(bytes) => bytes,
        Pixels::Rgba32F(_) => panic!("{name} has floats"),
    };
    let (a, b) = (bytes("a.png"), bytes("b.png"));
    for (name, at) in [("quarter.png", 40), ("most.png", 112), ("again.png", 112)] {
        let found = bytes(name);
        let wrong =
            (0..a.len()).filter(|i| found[*i] != if i / 4 % 160 < at { a[*i] } else { b[*i] }).count();
        assert_eq!(wrong, 0, "{name}");
    }
    let colors = || (0..a.len()).filter(|i| i % 4 < 3);
    let none = bytes("none.png");
    assert!(colors().all(|i| none[i] == 0), "equal pictures differ");
    let apart = bytes("apart.png");
    for i in colors() {
        let expected = 2.0 * f32::from(a[i].abs_diff(b[i]));
        // Both are decoded by the device's approximation, each off by up to half a step.
        assert!((f32::from(apart[i]) - expected.min(255.0)).abs() <= 2.5, "{} {expected}", apart[i]);
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let most = colors().map(|i| a[i].abs_diff(b[i])).max().unwrap();
    let squares: f64 = colors().map(|i| f64::from(a[i].abs_diff(b[i])).powi(2)).sum();
    let psnr_db = 10.0 * (255.0_f64.powi(2) * colors().count() as f64 / squares).log10();
    let measured: serde_json::Value = serde_json::from_str(&read("apart.json")).unwrap();
    assert!(most > 20 && measured["most"] == most, "{measured}, {most}");
    assert!((measured["psnr_db"].as_f64().unwrap() - psnr_db).abs() < 1e-9, "{measured}, {psnr_db}");
    assert_eq!(read("none.json"), r#"{"most":0,"psnr_db":null}"#);
    assert_eq!(bytes("after.png"), a);
    assert_eq!(read("after.json"), read("before.json"));
}

/// GLSL that has changed is drawn with; what is broken is told with its place, and what was drawn before goes on.
#[cfg(feature = "shader-compiler")]
#[test]
fn changed_glsl_is_compiled_while_the_window_goes_on() {
    fn copy(from: &Path, to: &Path) {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
            let to = to.join(entry.file_name());
            match entry.file_type().unwrap().is_dir() {
                true => copy(&entry.path(), &to),
                false => std::fs::copy(entry.path(), &to).map(drop).unwrap(),
            }
        }
    }
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let glsl = folder.path().join("glsl");
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl"), &glsl);
    let curve = glsl.join("tonemap.glsl");
    let text = std::fs::read_to_string(&curve).unwrap();
    let begin = "vec3 tonemap_neutral(vec3 color) {\n";
    let line = text.lines().position(|line| line == begin.trim_end()).expect("the curve is there") + 2;
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let lamps = asset("lamps.glb");
    let args = [lamps.as_str(), "--size", "160x90", "--glsl", "glsl"];
    let script = "reload\nframes 3\nscreenshot window.png\nlive live.json";
    let mut live = Vec::new();
    for (statement, is_other, problem) in
        [("", false, None), ("color *= 0.5;\n", true, None), ("colour *= 0.5;\n", false, Some("colour"))]
    {
        std::fs::write(&curve, text.replace(begin, &format!("{begin}{statement}"))).unwrap();
        let told = view(folder.path(), &screen.display, script, &args);
        match problem {
            None => assert_eq!(told, "", "{statement}"),
            Some(name) => {
                let place = format!("tonemap.glsl:{line}: error: ");
                assert!(told.contains(&place) && told.contains(name), "{told}");
            }
        }
        ontile(folder.path(), "", &["render", &lamps, "--size", "160x90", "-o", "render.png"]);
        let difference = difference(&picture("window.png"), &picture("render.png"));
        assert_eq!(difference.is_some(), is_other, "{statement}");
        live.push(std::fs::read_to_string(folder.path().join("live.json")).unwrap());
    }
    assert_eq!(live[1], live[0], "what was drawn with before is gone");
}

#[test]
fn without_a_screen_it_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_ontile"));
    command.args(["view", &asset("unlit.glb")]).current_dir(folder.path());
    let output = command.env("DISPLAY", ":65000").env_remove("WAYLAND_DISPLAY").output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.starts_with("ontile: no window can be opened: ") && told.lines().count() == 1, "{told}");
}

/// Sizes, none at all, surfaces taken away, scenes and options that change, some of which cannot be: all as before in the end.
#[test]
fn what_a_window_goes_through_leaves_nothing_behind() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let [lamps, unlit] = ["lamps.glb", "unlit.glb"].map(asset);
    let begin = "frames 3\n";
    let mut script = format!("{begin}screenshot before.png\nlive before.json\n");
    for i in 0_u32..60 {
        let [width, height] = [1 + 37 * i % 400, 1 + 53 * i % 300];
        script += &format!("size {width}x{height}\nframes {}\n", i % 3);
        if i % 10 == 0 {
            script += "size 0x0\nframes 2\nsuspend\nframes 1\nlow-memory\nlive low.json\nresume\n";
        }
    }
    script += "size 160x90\nopen none.glb\nset samples 3\nset lamps 1\n";
    for i in 0..SCENE_CHANGES {
        script += &format!("open {}\nframes {}\n", if i % 2 == 0 { &unlit } else { &lamps }, i % 3);
    }
    for (name, value, again) in [("layout", "packed128", "metallic128"), ("samples", "4", "1")] {
        script += &format!("set {name} {value}\nframes 1\nset {name} {again}\n");
    }
    script += &format!("{begin}screenshot after.png\nlive after.json\ndrag 30 10\nscreenshot turned.png\n");
    let told = view(folder.path(), &screen.display, &script, &[&lamps, "--size", "160x90"]);
    let lines: Vec<_> = told.lines().collect();
    assert_eq!(lines.len(), 3, "{told}");
    for (line, part) in lines.iter().zip(["none.glb: cannot read", "3 samples", "no option 'lamps'"]) {
        assert!(line.contains(part), "{line}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("before.json").contains("\"swapchain_khr\":1"), "{}", read("before.json"));
    assert_eq!(read("after.json"), read("before.json"));
    // Where memory is short and nobody looks, what frames are submitted with is all that stays.
    let low = read("low.json");
    assert!(low.contains("\"allocations\":0,\"bytes\":0") && !low.contains("pipeline\":"), "{low}");
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    assert_eq!(difference(&picture("after.png"), &picture("before.png")), None);
    assert!(difference(&picture("turned.png"), &picture("before.png")).is_some(), "a drag turns the camera");
}

/// Each makes a plan, pipelines and buffers.
const SCENE_CHANGES: usize = 200;

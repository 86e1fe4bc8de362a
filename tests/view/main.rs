//! `ontile view` in a real window: an X server without a screen, lavapipe, the validation layer.

#![cfg(all(feature = "cli", feature = "view", target_os = "linux"))]

#[path = "../common/mod.rs"]
mod common;
mod compare;
#[path = "../common/gltf_build.rs"]
#[allow(dead_code, reason = "what is made here is little")]
mod gltf_build;
mod life;
mod motion;
mod overlay;
#[cfg(feature = "shader-compiler")]
mod reload;
mod wayland;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use common::ignored_unless_required;
use common::render::{LAVAPIPE, difference};
use ontile::picture::Picture;

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
    command.env("DISPLAY", display).env_remove("WAYLAND_DISPLAY");
    run(command, folder, args)
}

#[track_caller]
fn run(mut command: Command, folder: &Path, args: &[&str]) -> String {
    command.args(args).args(["--device", LAVAPIPE]).current_dir(folder);
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

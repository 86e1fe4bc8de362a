//! The same window on Wayland: a compositor without a screen.

use std::time::{Duration, Instant};

use super::*;

/// A compositor of the test's own, with a folder for its socket.
struct Compositor {
    server: Child,
    folder: tempfile::TempDir,
}

const SOCKET: &str = "wayland-ontile";

impl Compositor {
    /// `None`, and said so, where there is none.
    fn new() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let server = Command::new("weston")
            .args(["--backend=headless-backend.so", "--width=1280", "--height=1024", "--idle-time=0"])
            .arg(format!("--socket={SOCKET}"))
            .env("XDG_RUNTIME_DIR", folder.path())
            .env_remove("DISPLAY")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let mut compositor = match server {
            Ok(server) => Self { server, folder },
            Err(error) => {
                println!("ignored: no weston: {error}");
                return None;
            }
        };
        let since = Instant::now();
        while !compositor.folder.path().join(SOCKET).exists() {
            let ended = compositor.server.try_wait().expect("it is a child");
            assert!(ended.is_none(), "weston has ended: {ended:?}");
            assert!(since.elapsed() < Duration::from_secs(30), "weston makes no socket");
            std::thread::sleep(Duration::from_millis(20));
        }
        Some(compositor)
    }

    /// Runs a script in a window under the validation layer.
    #[track_caller]
    fn view(&self, folder: &Path, script: &str, args: &[&str]) -> String {
        std::fs::write(folder.join("script.txt"), script).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_ontile"));
        command
            .env("XDG_RUNTIME_DIR", self.folder.path())
            .env("WAYLAND_DISPLAY", SOCKET)
            .env_remove("DISPLAY");
        run(command, folder, &[&["view"], args, &["--script", "script.txt", "--validate"]].concat())
    }
}

impl Drop for Compositor {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

#[test]
fn a_window_on_wayland_shows_the_picture_of_render_and_leaves_nothing_behind() {
    let Some(compositor) = Compositor::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let [lamps, unlit] = ["lamps.glb", "unlit.glb"].map(asset);
    for options in [&[][..], &["--strategy", "separate", "--layout", "packed128", "--samples", "4"]] {
        let args = [&[lamps.as_str(), "--size", "160x90"][..], options].concat();
        let mut script = String::from("frames 12\nscreenshot before.png\nlive before.json\n");
        for i in 0_u32..20 {
            let [width, height] = [1 + 37 * i % 400, 1 + 53 * i % 300];
            script += &format!("size {width}x{height}\nframes {}\n", i % 3);
            if i % 10 == 0 {
                script += "size 0x0\nframes 2\nsuspend\nframes 1\nlow-memory\nresume\n";
            }
        }
        script += &format!(
            "size 200x120\nopen {lamps}\nframes 2\nscreenshot wide.png\noverlay on\nframes 3\nopen {unlit}\nframes 2\noverlay off\n"
        );
        script += &format!("size 160x90\nopen {lamps}\nframes 12\nscreenshot after.png\nlive after.json\n");
        assert_eq!(compositor.view(folder.path(), &script, &args), "", "{options:?}");
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(read("after.json"), read("before.json"), "{options:?}");
        for (name, size) in [("before.png", "160x90"), ("wide.png", "200x120"), ("after.png", "160x90")] {
            let rest = [&["render", &lamps, "--size", size], options, &["-o", "render.png"]].concat();
            ontile(folder.path(), "", &rest);
            assert_eq!(difference(&picture(name), &picture("render.png")), None, "{options:?} {name}");
        }
    }
}

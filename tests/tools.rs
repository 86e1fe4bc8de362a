//! The scripts that fetch devices for the tests, and the devices that they fetch.

mod common;

use common::{ignored, swiftshader::swiftshader_env, turnip};
use std::{path::Path, process::Command};

/// The exit status of a script whose product cannot exist on this machine.
const UNAVAILABLE: i32 = 77;

fn vulkaninfo() -> Option<&'static Path> {
    let path = Path::new("/usr/bin/vulkaninfo");
    if path.is_file() {
        return Some(path);
    }
    ignored("/usr/bin/vulkaninfo absent (package vulkan-tools)");
    None
}

fn summary(mut command: Command) -> String {
    let output = command.arg("--summary").output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn turnip_is_the_adreno_that_was_asked_for() {
    let (Some(turnip), Some(vulkaninfo)) = (turnip::find(), vulkaninfo()) else { return };
    for gpu_id in [630, 660, 740] {
        let text = summary(turnip.command(gpu_id, vulkaninfo));
        assert!(text.contains(&format!("Turnip Adreno (TM) {gpu_id}")), "{gpu_id}: {text}");
        assert!(!text.contains("GPU1"), "other drivers are visible: {text}");
    }
}

#[test]
fn swiftshader_is_the_only_device_in_its_environment() {
    let (Some(env), Some(vulkaninfo)) = (swiftshader_env(), vulkaninfo()) else { return };
    let mut command = Command::new(vulkaninfo);
    command.envs(env).env("VK_LOADER_LAYERS_DISABLE", "~implicit~");
    let text = summary(command);
    assert!(text.contains("DRIVER_ID_GOOGLE_SWIFTSHADER") && !text.contains("GPU1"), "{text}");
}

#[test]
fn without_an_archive_the_scripts_say_unavailable_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for (script, variable) in [("tilers", "ONTILE_TILERS"), ("swiftshader", "ONTILE_SWIFTSHADER")] {
        let output = Command::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("tools").join(script))
            .env(variable, folder.path().join("cache"))
            .env("ONTILE_DEBIAN_MIRROR", format!("file:{}", folder.path().join("absent").display()))
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(UNAVAILABLE), "{script}: {message}");
        assert!(message.contains(&format!("{script}: not available: ")), "{message}");
        assert_eq!(output.stdout, b"", "{script} prints a path that does not exist");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{script} left something");
    }
}

#[test]
fn the_scripts_never_replace_a_folder_of_someone_else() {
    let folder = tempfile::tempdir().unwrap();
    let precious = folder.path().join("precious");
    std::fs::write(&precious, "mine").unwrap();
    for (script, variable) in [("tilers", "ONTILE_TILERS"), ("swiftshader", "ONTILE_SWIFTSHADER")] {
        let output = Command::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("tools").join(script))
            .env(variable, folder.path())
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{script}: {message}");
        assert!(message.contains("not made by this script"), "{message}");
        assert_eq!(std::fs::read_to_string(&precious).unwrap(), "mine");
    }
}

//! The Android package: it is built, linked and packed, and `tools/android --verify` sees what could be wrong with it.

#[path = "../common/mod.rs"]
mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The exit status of a script whose product cannot exist on this machine.
const UNAVAILABLE: i32 = 77;

fn script() -> Command {
    let mut command = Command::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/android"));
    // The standard library's source, where it lies beside the checkout.
    let shared = std::env::var_os("ONTILE_SHARED").map_or_else(beside, PathBuf::from).join("android");
    let archive = std::fs::read_dir(shared).into_iter().flatten().flatten().map(|entry| entry.path());
    let archive = archive.into_iter().find(|path| path.to_string_lossy().ends_with("-library.tar.xz"));
    if let (None, Some(archive)) = (std::env::var_os("ONTILE_RUST_SRC"), archive) {
        command.env("ONTILE_RUST_SRC", archive);
    }
    command.env("CARGO_TARGET_DIR", common::target_dir());
    command
}

fn beside() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn verify(package: &Path) -> Output {
    script().arg("--verify").arg(package).output().expect("a shell")
}

#[test]
fn the_package_is_whole_and_faults_are_seen() {
    let built = script().output().expect("a shell");
    if built.status.code() == Some(UNAVAILABLE) {
        return common::ignored(&said(&built));
    }
    assert!(built.status.success(), "{}", said(&built));
    let package = PathBuf::from(String::from_utf8_lossy(&built.stdout).trim());
    let verified = verify(&package);
    assert!(verified.status.success(), "{}", said(&verified));

    let folder = tempfile::tempdir().unwrap();
    let faults = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/android/faults.py");
    let made = Command::new("python3").arg(faults).arg(&package).arg(folder.path()).output().unwrap();
    assert!(made.status.success(), "{}", said(&made));
    let listed = String::from_utf8_lossy(&made.stdout).into_owned();
    assert!(listed.lines().count() >= 13, "{listed}");
    for line in listed.lines() {
        let (faulty, expected) = line.split_once('\t').unwrap();
        let refused = verify(Path::new(faulty));
        let message = said(&refused);
        assert_eq!(refused.status.code(), Some(1), "{faulty}: {message}");
        assert!(message.contains(expected), "{faulty} does not say '{expected}': {message}");
    }
}

//! What several test files share: devices, scenes, pictures, expected files.

#![allow(dead_code, reason = "each test file uses some of this")]

pub mod environments;
pub mod expected;
pub mod lavapipe;
pub mod pairs;
pub mod render;
pub mod scenes;
pub mod swiftshader;
pub mod turnip;

use std::{io::Write, path::PathBuf};

/// Says that a test could not run. Written past the test harness, which hides what passing tests print.
pub fn ignored(reason: &str) {
    let test = std::thread::current().name().unwrap_or("a test").to_owned();
    let _ = writeln!(std::io::stderr(), "ignored: {test}: {reason}");
}

/// As [`ignored`], for a device that `tools/test` installs (lavapipe): under `ONTILE_REQUIRE_DEVICES` (CI) it fails.
///
/// # Panics
///
/// When that variable is set and not empty.
pub fn ignored_unless_required(reason: &str) {
    let required = std::env::var_os("ONTILE_REQUIRE_DEVICES").is_some_and(|value| !value.is_empty());
    assert!(!required, "{reason}, and ONTILE_REQUIRE_DEVICES is set");
    ignored(reason);
}

/// Cargo's target folder.
pub fn target_dir() -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).parent().expect("the target folder holds it").to_owned()
}

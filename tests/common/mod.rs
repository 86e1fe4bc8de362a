//! Where the devices of the tests are.

#![allow(dead_code, reason = "each test file uses some of this")]

pub mod swiftshader;
pub mod turnip;

use std::{io::Write, path::PathBuf};

/// Says that a test could not run. Written past the test harness, which hides what passing tests print.
pub fn ignored(reason: &str) {
    let test = std::thread::current().name().unwrap_or("a test").to_owned();
    let _ = writeln!(std::io::stderr(), "ignored: {test}: {reason}");
}

/// Cargo's target folder.
pub fn target_dir() -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).parent().expect("the target folder holds it").to_owned()
}

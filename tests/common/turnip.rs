//! Turnip, Mesa's Adreno driver, with no GPU.

use super::ignored;
pub use ontile::measure::turnip::{Turnip, TurnipRun};
use std::process::Command;

/// The wrapper that `ONTILE_TURNIP_RUN` names, or the one that `tools/tilers` unpacked; says "ignored" if absent.
pub fn find() -> Option<Turnip> {
    let run = super::target_dir().join("tilers/run");
    let found = Turnip::find(Some(run.clone()));
    if found.is_none() {
        ignored(&format!("Turnip: {} absent (tools/tilers unpacks it)", run.display()));
    }
    found
}

/// Runs the command and reads its trace.
///
/// # Panics
///
/// With the program's output, when it fails or prints no well-formed trace.
pub fn trace(command: Command) -> TurnipRun {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    Turnip::trace(command, folder.path()).unwrap_or_else(|error| panic!("{error}"))
}

//! A lavapipe that is newer than the machine's, with what Vulkan has gained since.

use super::ignored;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A command that runs `program` on the newer lavapipe under a validation layer that knows its extensions; says "ignored" and
/// returns `None` if it is absent. From `ONTILE_LAVAPIPE_RUN`, or where `tools/lavapipe` unpacks it.
pub fn newer_lavapipe(program: &Path) -> Option<Command> {
    let named = std::env::var_os("ONTILE_LAVAPIPE_RUN").filter(|path| !path.is_empty()).map(PathBuf::from);
    let run = named.unwrap_or_else(|| super::target_dir().join("lavapipe/run"));
    if !run.is_file() {
        ignored(&format!("lavapipe with local reads: {} absent (tools/lavapipe unpacks it)", run.display()));
        return None;
    }
    let mut command = Command::new(run);
    command.arg(program);
    // What the machine's own layer is told.
    for name in ["VK_INSTANCE_LAYERS", "VK_LAYER_ENABLES", "VK_LAYER_SETTINGS_PATH", "VK_LAYER_PATH"] {
        command.env_remove(name);
    }
    Some(command)
}

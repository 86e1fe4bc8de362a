//! Runs a program on Turnip, Mesa's Adreno driver, with no GPU, and reads what the driver says about its render passes.

use super::ignored;
use ontile::measure::tiler::TilerTrace;
use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

/// The unpacked driver's wrapper: `run PROGRAM ARGUMENTS`.
pub struct Turnip {
    run: PathBuf,
}

/// What a program did on the driver.
pub struct TurnipRun {
    pub trace: TilerTrace,
    pub output: Output,
}

impl Turnip {
    /// The wrapper that `ONTILE_TURNIP_RUN` names, or the one that `tools/tilers` unpacked; says "ignored" if absent.
    pub fn find() -> Option<Self> {
        let named = std::env::var_os("ONTILE_TURNIP_RUN").filter(|path| !path.is_empty()).map(PathBuf::from);
        let run = named.unwrap_or_else(|| super::target_dir().join("tilers/run"));
        if run.is_file() {
            return Some(Self { run });
        }
        ignored(&format!("Turnip: {} absent (tools/tilers unpacks it)", run.display()));
        None
    }

    /// A command that runs `program` on the Adreno `gpu_id` (618, 630, 660, 730, 740 or 750). Tiling is forced where
    /// the driver would skip it for few draws, and the LRZ buffer, which commits memory of its own, is off.
    pub fn command(&self, gpu_id: u32, program: &Path) -> Command {
        let mut command = Command::new(&self.run);
        command
            .arg(program)
            .env("FD_GPU_ID", gpu_id.to_string())
            .env("MESA_GPU_TRACES", "print")
            .env("TU_DEBUG", "gmem,nolrz,perf")
            .env_remove("VK_INSTANCE_LAYERS");
        command
    }

    /// Runs the command and reads its trace.
    ///
    /// # Panics
    ///
    /// With the program's output, when it fails or prints no well-formed trace.
    pub fn trace(mut command: Command) -> TurnipRun {
        let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let stdout = String::from_utf8_lossy(&output.stdout);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{command:?}: {}\n{stdout}\n{stderr}", output.status);
        let text = format!("{stdout}\n{stderr}");
        let trace = TilerTrace::parse(Path::new("Turnip's output"), &text)
            .unwrap_or_else(|error| panic!("{command:?}: {error}\n{text}"));
        TurnipRun { trace, output }
    }
}

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
            .env("TU_DEBUG", "gmem,nolrz,perf");
        // What other layers than the one beside the driver are told.
        for name in ["VK_INSTANCE_LAYERS", "VK_LAYER_ENABLES", "VK_LAYER_SETTINGS_PATH"] {
            command.env_remove(name);
        }
        command
    }

    /// Runs the command and reads its trace. The driver writes that to a file of its own: on standard output it would
    /// mix with the program's lines, since each has its own buffer.
    ///
    /// # Panics
    ///
    /// With the program's output, when it fails or prints no well-formed trace.
    pub fn trace(mut command: Command) -> TurnipRun {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let file = folder.path().join("trace.txt");
        command.env("MESA_GPU_TRACEFILE", &file);
        let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let stdout = String::from_utf8_lossy(&output.stdout);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{command:?}: {}\n{stdout}\n{stderr}", output.status);
        let trace = std::fs::read_to_string(&file).unwrap_or_default();
        let text = format!("{trace}\n{stderr}");
        let trace = TilerTrace::parse(Path::new("Turnip's output"), &text)
            .unwrap_or_else(|error| panic!("{command:?}: {error}\n{stdout}\n{text}"));
        TurnipRun { trace, output }
    }
}

//! Runs a program on Turnip, Mesa's Adreno driver, with no GPU, and reads what the driver says about its render passes.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::tiler::TilerTrace;
use crate::{Error, Result};

/// The unpacked driver's wrapper, which `tools/tilers` makes: `run PROGRAM ARGUMENTS`.
#[derive(Clone, Debug)]
pub struct Turnip {
    run: PathBuf,
}

/// What a program did on the driver.
pub struct TurnipRun {
    /// What the driver says.
    pub trace: TilerTrace,
    /// What the program says.
    pub output: Output,
}

impl Turnip {
    /// The environment variable that names the wrapper.
    pub const RUN: &'static str = "ONTILE_TURNIP_RUN";

    /// The wrapper that [`Self::RUN`] names; else `other`, if there is such a file.
    pub fn find(other: Option<PathBuf>) -> Option<Self> {
        let named = std::env::var_os(Self::RUN).filter(|path| !path.is_empty()).map(PathBuf::from);
        named.or(other).filter(|run| run.is_file()).map(|run| Self { run })
    }

    /// A command that runs `program` on the Adreno `id` (618, 630, 660, 730, 740 or 750). Tiling is forced where
    /// the driver would skip it for few draws, and the LRZ buffer, which commits memory of its own, is off.
    pub fn command(&self, id: u32, program: &Path) -> Command {
        let mut command = Command::new(&self.run);
        command
            .arg(program)
            .env("FD_GPU_ID", id.to_string())
            .env("MESA_GPU_TRACES", "print")
            .env("TU_DEBUG", "gmem,nolrz,perf");
        // What other layers than the one beside the driver are told.
        for name in ["VK_INSTANCE_LAYERS", "VK_LAYER_ENABLES", "VK_LAYER_SETTINGS_PATH"] {
            command.env_remove(name);
        }
        command
    }

    /// Runs the command and reads its trace. The driver writes that to a file of its own in `folder`: on standard output it
    /// would mix with the program's lines, since each has its own buffer.
    ///
    /// Under load the driver's threads now and then mix lines of the trace itself. Such a trace is not well-formed, so the command is
    /// run again, three times at most; what is well-formed is taken as it is.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be run; [`Error::Unsupported`] with the program's output if it fails; [`Error::Input`] if
    /// the trace is not well-formed.
    pub fn trace(mut command: Command, folder: &Path) -> Result<TurnipRun> {
        const MOST_RUNS: usize = 3;
        let file = folder.join("trace.txt");
        command.env("MESA_GPU_TRACEFILE", &file);
        let mut traced = Self::trace_once(&mut command, &file);
        for _ in 1..MOST_RUNS {
            if !matches!(traced, Err(Error::Input { .. })) {
                break;
            }
            traced = Self::trace_once(&mut command, &file);
        }
        traced
    }

    fn trace_once(command: &mut Command, file: &Path) -> Result<TurnipRun> {
        let program = PathBuf::from(command.get_program());
        let output = command.output().map_err(|e| Error::io(&program, "run", e))?;
        let stderr = String::from_utf8_lossy(&output.stderr);
        if !output.status.success() {
            let stdout = String::from_utf8_lossy(&output.stdout);
            return Err(Error::unsupported(
                format!("{command:?}: {}\n{stdout}\n{stderr}", output.status),
                "see what it says; tools/tilers unpacks the driver",
            ));
        }
        let trace = std::fs::read_to_string(file).unwrap_or_default();
        let trace = TilerTrace::parse(file, &format!("{trace}\n{stderr}"))?;
        Ok(TurnipRun { trace, output })
    }
}

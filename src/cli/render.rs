//! `ontile render`

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use ontile::picture::Picture;
use ontile::plan::Options;
use ontile::{Error, Result, file};
use serde::Serialize;

use super::args::{Output, PlanArgs, SceneArgs};

/// Render a scene to a picture.
///
/// Uses the first device that can do it; without a GPU, Mesa's lavapipe does it on the CPU.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile render scene.glb -o scene.png
  ontile render scene.glb -o scene.exr --tonemap linear --size 640x360
  ontile render scene.glb -o scene.png --camera 1 --exposure -2.5 --report scene.json
  ontile render scene.glb -o scene.png --strategy separate --frames 100 --report separate.json

Colours in .exr are linear and not clamped; '--tonemap linear' leaves them in the scene's units times 2^EV.")]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The picture to write: .png has 8 bits a channel in sRGB, .exr has linear floats
    #[arg(short, long, value_name = "OUT.png|OUT.exr", value_parser = Output::parser())]
    pub output: Output,
    #[command(flatten)]
    pub plan: PlanArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

/// How the program renders and what it tells.
#[derive(Args, Debug)]
#[command(next_help_heading = "Run")]
pub struct RunArgs {
    /// How many times the frame is rendered; more give steadier times
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: u32,
    /// Write what was created and measured as JSON: bytes per pixel, attachments, times [default: none]
    #[arg(long, value_name = "R.json")]
    pub report: Option<PathBuf>,
    /// Use the first device whose name contains this, in either case [default: the first that fits]
    #[arg(long, value_name = "NAME_PART")]
    pub device: Option<String>,
    /// Run under the Khronos validation layer; any message of it is a failure [default: off]
    #[arg(long)]
    pub validate: bool,
    /// Use ordinary memory for attachments that stay on the tile, so that RenderDoc can capture them; the pixels
    /// are the same [default: off]
    #[arg(long)]
    pub capture: bool,
}

impl RenderArgs {
    /// The library's options.
    pub fn options(&self) -> Options {
        self.plan.options(self.output.image_format())
    }
}

/// Renders with `render_frames` and writes the picture, then the report.
///
/// Checks before the long work that both files can have a place.
pub fn run<R: Serialize>(
    args: &RenderArgs,
    render_frames: impl FnOnce(&RenderArgs) -> Result<(Picture, R)>,
) -> Result<()> {
    let report_path = args.run.report.as_deref();
    for path in [Some(args.output.path.as_path()), report_path].into_iter().flatten() {
        folder_exists(path)?;
    }
    let (picture, report) = render_frames(args)?;
    picture.write(&args.output.path)?;
    if let Some(path) = report_path {
        let mut json =
            serde_json::to_string_pretty(&report).map_err(|e| Error::io(path, "write", e.into()))?;
        json.push('\n');
        file::write_whole(path, json.as_bytes())?;
    }
    Ok(())
}

fn folder_exists(path: &Path) -> Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    if folder.is_none_or(Path::is_dir) {
        return Ok(());
    }
    Err(Error::io(path, "write", io::Error::new(io::ErrorKind::NotFound, "its folder does not exist")))
}

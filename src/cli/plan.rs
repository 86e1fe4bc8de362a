//! `ontile plan`

use clap::Args;

use super::args::{PlanArgs, SceneArgs};

/// Show what would be created for a scene, and why; needs no device.
///
/// Prints subpasses, attachments (format, bits, load and store, lifetime), dependencies, bits on the tile, bytes
/// per pixel, and a verdict for each family of tile-based GPUs.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile plan scene.glb
  ontile plan scene.glb --strategy separate --json
  ontile plan scene.glb --layout exact --no-recycle")]
pub struct PlanCommandArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub plan: PlanArgs,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

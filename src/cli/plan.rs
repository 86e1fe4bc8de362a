//! `ontile plan`

use clap::Args;
use ontile::gpu::Explanation;
use ontile::plan::{Limits, Merging, Needs, OutputFormat, Plan, Report};

use super::args::{PlanArgs, SceneArgs};
use super::{auto, print, scene};

/// Show what would be created for a scene, and why; needs no device.
///
/// Prints subpasses, attachments (format, bits, load and store, lifetime), dependencies, bits on the tile, bytes
/// per pixel, and a verdict for each family of tile-based GPUs.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile plan scene.glb
  ontile plan scene.glb --strategy separate --json
  ontile plan scene.glb --explain
  ontile plan scene.glb --layout exact --no-recycle
  ontile plan scene.glb --layout auto --max-error 0.01")]
pub struct PlanCommandArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub plan: PlanArgs,
    /// Print instead what will exist, object by object, each with the element of the scene or the option that needs it:
    /// attachments, subpasses, pipelines with their attributes, bindings and constants, images, buffers
    #[arg(long)]
    pub explain: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// A plan that prints as text, or as the ledger's schema.
#[derive(serde::Serialize)]
#[serde(transparent)]
struct Printed {
    report: Report,
    #[serde(skip)]
    plan: Plan,
}

impl std::fmt::Display for Printed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.plan.fmt(f)
    }
}

/// Prints the plan of a PNG picture of the scene.
pub fn run(args: &PlanCommandArgs) -> ontile::Result<()> {
    let mut scene = scene::load(&args.scene)?;
    let camera = scene::camera(&scene, &args.scene)?.clone();
    scene::tell_idle_flags(&scene, &args.plan);
    // No device is asked: the picture's size is its only limit that may go beyond the guaranteed ones.
    let merging = Merging { local_read: Ok(()), ..Merging::default() };
    let limits = Limits {
        max_image_size: u32::MAX,
        ordered_attachment_access: true,
        depth_clamp: true,
        merging,
        sample_counts: 1 | 2 | 4 | 8,
        word_sample_counts: 1 | 2 | 4 | 8,
        ..Limits::default()
    };
    let options = auto::options(&args.plan, OutputFormat::Rgba8Srgb, &mut scene, &camera, &limits)?;
    let plan = Plan::new(Needs::of(&scene), options, &limits)?;
    plan.warnings.iter().for_each(|warning| print::warning(warning));
    if args.explain {
        return print::value(&Explanation::new(&scene, &plan)?, args.json);
    }
    print::value(&Printed { report: plan.report(&scene), plan }, args.json)
}

//! From the arguments to the options, the G-buffer chosen if that is wished.

use ontile::gpu::{Device, check_formats};
use ontile::measure::{Goal, choose};
use ontile::plan::{Limits, Options, OutputFormat, Plan};
use ontile::scene::{Camera, Scene};
use ontile::{Error, Result};

use super::args::PlanArgs;
use super::progress::Progress;
use super::scene;
use super::wanted_layout::WantedLayout;

/// The options for a device; environments are filtered first where they are to be looked at.
pub fn options_on(
    args: &PlanArgs,
    output: OutputFormat,
    scene: &Scene,
    camera: &Camera,
    device: &Device,
) -> Result<Options> {
    chosen(args, output, scene, camera, &device.limits(), &|plan| check_formats(device, plan))
}

/// The options where no device is asked.
pub fn options(
    args: &PlanArgs,
    output: OutputFormat,
    scene: &mut Scene,
    camera: &Camera,
    limits: &Limits,
) -> Result<Options> {
    if args.layout == WantedLayout::Auto {
        scene::prefilter(scene, args.options(output).environment_format);
    }
    chosen(args, output, scene, camera, limits, &|_| Ok(()))
}

fn chosen(
    args: &PlanArgs,
    output: OutputFormat,
    scene: &Scene,
    camera: &Camera,
    limits: &Limits,
    check: &dyn Fn(&Plan) -> Result<()>,
) -> Result<Options> {
    let options = args.options(output);
    let goal = args.max_error.map_or(Goal::default(), |limit| Goal { metric: args.metric, limit });
    if args.layout != WantedLayout::Auto {
        return match args.max_error {
            None => Ok(options),
            Some(_) => Err(Error::unsupported(
                format!("--max-error says what may be chosen, and layout {} is named", args.layout),
                "use --layout auto, or leave --max-error out",
            )),
        };
    }
    let named =
        [args.normals.is_some(), args.gamma.is_some(), args.light_target.is_some(), args.depth.is_some()];
    if named.contains(&true) {
        return Err(Error::unsupported(
            "--layout auto chooses encodings and formats too",
            "leave --normals, --gamma, --light-target and --depth out, or name a layout",
        ));
    }
    let _progress = Progress::of("choosing a G-buffer");
    let chosen = choose(scene, camera, &options, args.exposure, limits, goal, check)?;
    Ok(Options { gbuffer_why: chosen.why, ..chosen.choice.apply(&options) })
}

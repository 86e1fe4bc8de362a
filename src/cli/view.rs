//! `ontile view`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use ontile::Result;
use ontile::gpu::{Headless, HeadlessOptions};
use ontile::plan::{Options, OutputFormat};
use ontile::scene::Flight;
use ontile::view::{HELP, PresentMode, Script, Viewer};

use super::args::{PlanArgs, SceneArgs, named};
use super::wanted_layout::WantedLayout;
use super::{auto, print, scene};

/// Show a scene in a window.
///
/// The frame is drawn straight into the window's images. Another scene is opened by dropping its file on the window.
#[derive(Args, Debug)]
#[command(after_help = format!("\
Keys:
{HELP}

Commands of a script, one a line: frames N, size WxH, open FILE, set OPTION VALUE, camera N|NAME, time SECONDS,
animation N|NAME|all, play, pause, speed FACTOR, record FILE, stop, fly FILE, reload, exposure EV, drag X Y, screenshot FILE,
scenes FILE, pick N,
set b.OPTION VALUE, split SHARE|off, difference GAIN|off, measure FILE, live FILE, overlay on|off, volumes on|off, clusters most|N|off,
turn DEGREES, low-memory, suspend, resume, stay; after the last one the window is closed.

Examples:
  ontile view scene.glb
  ontile view scene.glb --layout packed128 --lights clusters --samples 4
  ontile view scene.glb --script tour.txt"))]
pub struct ViewArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub plan: PlanArgs,
    #[command(flatten)]
    pub window: WindowArgs,
}

/// The window.
#[derive(Args, Debug)]
#[command(next_help_heading = "Window")]
pub struct WindowArgs {
    /// When a frame that is done is shown: with the screen's next refresh, in order; in the place of one that still waits; or
    /// at once, torn
    #[arg(long, value_name = "MODE", default_value_t = PresentMode::Fifo, value_parser = named(PresentMode::ALL, PresentMode::name))]
    pub present: PresentMode,
    /// Frames that are prepared while the GPU draws
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=3))]
    pub frames_in_flight: u32,
    /// Fly this camera path to begin with, which was recorded by R, or by 'record FILE' of a script
    #[arg(long, value_name = "FILE")]
    pub flight: Option<PathBuf>,
    /// Watch this folder of GLSL and draw with what changes there [default: glsl/ of the checkout that the program was built from, if
    /// it is there]
    #[cfg(feature = "shader-compiler")]
    #[arg(long, value_name = "DIR")]
    pub glsl: Option<PathBuf>,
    /// Begin without the overlay, which costs nothing then; F2 shows it [default: with it, unless there is a script]
    #[arg(long)]
    pub no_overlay: bool,
    /// Carry out the commands of this file in the place of a user
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Use the first device whose name contains this, in either case [default: the first that fits]
    #[arg(long, value_name = "NAME_PART")]
    pub device: Option<String>,
    /// Run under the Khronos validation layer; any message of it is a failure [default: off]
    #[arg(long)]
    pub validate: bool,
}

/// Shows the scene until the window is closed.
pub fn run(args: &ViewArgs) -> Result<()> {
    let window = &args.window;
    let script = window.script.as_deref().map(Script::load).transpose()?;
    let options = Options { overlay: !window.no_overlay && script.is_none(), ..options(args)? };
    let (scene_args, environment_format) = (args.scene.clone(), options.environment_format);
    let load = move |path: &Path| {
        let mut scene = scene::load_moving(&SceneArgs { scene: path.to_owned(), ..scene_args.clone() })?;
        scene::prefilter(&mut scene, environment_format);
        Ok(scene)
    };
    Viewer {
        load: Arc::new(load),
        options,
        exposure_ev: args.plan.exposure,
        camera: args.scene.camera.clone(),
        flight: window.flight.as_deref().map(Flight::load).transpose()?,
        #[cfg(feature = "shader-compiler")]
        glsl: window.glsl.clone().or_else(|| {
            let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl");
            own.is_dir().then_some(own)
        }),
        animation: args.scene.animation.clone(),
        time_s: args.scene.time,
        present: window.present,
        frames_in_flight: window.frames_in_flight as usize,
        device: window.device.clone(),
        validate: window.validate,
        script,
        tell: Box::new(print::note),
        ..Viewer::new(&args.scene.scene)
    }
    .run()
}

/// The options, the G-buffer chosen for the scene if that is wished.
fn options(args: &ViewArgs) -> Result<Options> {
    // The window's format, which has the same texels, is not known yet.
    let output = OutputFormat::Rgba8Srgb;
    if args.plan.layout != WantedLayout::Auto {
        return Ok(args.plan.options(output));
    }
    let mut scene = scene::load(&args.scene)?;
    let camera = scene::camera(&scene, &args.scene)?.clone();
    scene::prefilter(&mut scene, args.plan.options(output).environment_format);
    let host = Headless::new(&HeadlessOptions {
        device_name_part: args.window.device.clone(),
        validate: false,
        application_name: "ontile".into(),
        ..HeadlessOptions::default()
    })?;
    auto::options_on(&args.plan, output, &scene, &camera, host.device())
}

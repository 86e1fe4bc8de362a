//! `ontile render`

use std::path::PathBuf;

use clap::Args;
use ontile::gpu::{
    Headless, HeadlessOptions, Offscreen, PipelineCache, RendererConfig, View, expected_advice,
};
use ontile::measure::lit_by_sample;
use ontile::picture::Picture;
use ontile::plan::{Figure, Needs, Options, Plan, Report};
use ontile::scene::{Camera, Flight, Scene};
use ontile::{Error, Result, file};
use serde::Serialize;

use super::args::{Output, PlanArgs, SceneArgs};
use super::auto;
use super::output;
use super::print;
use super::progress::Progress;
use super::scene;

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
  ontile render scene.glb -o end.png --frames 100 --flight tour.flight --report tour.json

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
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    pub frames: u32,
    /// Render the frames along this camera path, in equal steps of time from its begin to its end, with the camera's projection; the picture
    /// is the last one's. 'ontile view' records it [default: the camera stands]
    #[arg(long, value_name = "FILE")]
    pub flight: Option<PathBuf>,
    /// Write what was created and measured as JSON: bytes per pixel, attachments, times [default: none]
    #[arg(long, value_name = "R.json")]
    pub report: Option<PathBuf>,
    /// Write to the report what these performance counters of the device count in one more frame of the last view: by number or name
    /// ('ontile info --counters' lists them), or all [default: none]
    #[arg(
        long,
        value_name = "N|NAME,...|all",
        value_delimiter = ',',
        requires = "report",
        allow_negative_numbers = true
    )]
    pub counters: Vec<String>,
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

/// Renders, writes picture and report, and tells what a frame consists of.
pub fn run(args: &RenderArgs) -> Result<()> {
    let report = run_with(args, || {
        let mut scene = scene::load(&args.scene)?;
        scene::tell_idle_flags(&scene, &args.plan);
        scene::prefilter(&mut scene, args.options().environment_format);
        render(args, &scene)
    })?;
    report.device.map_or(Ok(()), |device| print::value(&device.frame, false))
}

/// The files around the rendering: checks before the long work that both can have a place of their own.
pub(super) fn run_with<R: Serialize>(
    args: &RenderArgs,
    render: impl FnOnce() -> Result<(Picture, R)>,
) -> Result<R> {
    let report_path = args.run.report.as_deref();
    let picture_path = args.output.path.as_path();
    output::check(picture_path, &[&args.scene.scene])?;
    if let Some(path) = report_path {
        output::check(path, &[&args.scene.scene, picture_path])?;
    }
    let (picture, report) = render()?;
    // The picture is the last to get its name: a run that fails leaves the old one.
    let picture = picture.stage(picture_path)?;
    if let Some(path) = report_path {
        let mut json =
            serde_json::to_string_pretty(&report).map_err(|e| Error::io(path, "write", e.into()))?;
        json.push('\n');
        file::write_whole(path, json.as_bytes())?;
    }
    picture.commit()?;
    Ok(report)
}

fn render(args: &RenderArgs, scene: &Scene) -> Result<(Picture, Report)> {
    let camera = scene::camera(scene, &args.scene)?;
    let flight = args.run.flight.as_deref().map(Flight::load).transpose()?;
    let host = Headless::new(&HeadlessOptions {
        device_name_part: args.run.device.clone(),
        validate: args.run.validate,
        application_name: "ontile".into(),
        performance_counters: !args.run.counters.is_empty(),
    })?;
    let drawn = draw(args, scene, camera, flight.as_ref(), &host);
    // Destroying the device may bring messages too, and is when some drivers tell what they did.
    let mut messages = host.finish();
    let (picture, mut report, expected) = drawn?;
    messages.retain(|message| !expected.iter().any(|part| message.contains(part)));
    if args.run.validate {
        if let Some(first) = messages.first() {
            return Err(Error::unsupported(
                format!("the validation layer has {} messages, first: {first}", messages.len()),
                "report this as a bug of ontile or of the driver",
            ));
        }
        if let Some(device) = &mut report.device {
            device.validation_messages = Some(messages);
        }
    }
    Ok((picture, report))
}

/// The picture, the report, and what the validation layer may say of the plan.
fn draw(
    args: &RenderArgs,
    scene: &Scene,
    camera: &Camera,
    flight: Option<&Flight>,
    host: &Headless,
) -> Result<(Picture, Report, Vec<&'static str>)> {
    let device = host.device();
    // An unknown name is told before the long work.
    let counters = (!args.run.counters.is_empty()).then(|| host.counters()).transpose()?;
    let chosen = counters.as_ref().map(|counters| counters.choose(&args.run.counters)).transpose()?;
    let options = auto::options_on(&args.plan, args.output.image_format(), scene, camera, device)?;
    let plan = Plan::new(Needs::of(scene), options, &device.limits())?;
    plan.warnings.iter().for_each(|warning| print::warning(warning));
    if plan.has_gbuffer() {
        scene::tell_distance(scene, camera, &plan.gbuffer);
    }
    let expected = expected_advice(&plan);
    let cache = PipelineCache::load(device)?;
    // On a tiler the stages of one pass interleave, so times between them would be of nothing.
    let interleaved = device.caps().lazily_allocated_memory && plan.passes.len() == 1;
    let config = RendererConfig {
        frames_in_flight: 1,
        capture: args.run.capture,
        stage_timestamps: args.run.report.is_some() && !interleaved,
        ..RendererConfig::default()
    };
    let progress = Progress::of("preparing");
    let mut offscreen = Offscreen::new(device, scene, plan, config, &cache)?;
    drop(progress);
    cache.store();
    // Scattered light is that of the frames before.
    let frames = args.run.frames.max(offscreen.renderer().plan().frames_to_settle());
    let progress = (frames > 1).then(|| Progress::of_steps("rendering", frames.into()));
    let mut camera = camera.clone();
    for frame in 0..frames {
        if let Some(flight) = flight {
            let way = f64::from(frame.min(args.run.frames - 1)) / f64::from((args.run.frames - 1).max(1));
            flight.place(&mut camera, way * flight.duration_s());
        }
        offscreen.render(&View { camera: &camera, exposure_ev: args.plan.exposure })?;
        progress.iter().for_each(Progress::step);
    }
    let mut report = offscreen.report(scene);
    if let Some(figures) = report.device.as_mut().filter(|_| args.run.report.is_some()) {
        let view = View { camera: &camera, exposure_ev: args.plan.exposure };
        let share = lit_by_sample(device, scene, offscreen.renderer().plan(), &view, &cache)?;
        figures.lit_by_sample = share.map(Figure::driver);
        let counted =
            counters.zip(chosen).map(|(counters, chosen)| offscreen.count(&view, &counters, &chosen));
        figures.counters = counted.transpose()?;
    }
    Ok((offscreen.picture(), report, expected))
}

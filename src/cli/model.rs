//! `ontile model`

use clap::{ArgMatches, Args, Command, FromArgMatches};
use ontile::gpu::{Headless, HeadlessOptions, PipelineCache, View};
use ontile::measure::bandwidth::{Counts, FrameTraffic, Table2, Thibieroz, Traffic, count, table_2};
use ontile::plan::{Origin, OutputFormat};
use serde::Serialize;

use super::args::{PlanArgs, SceneArgs};
use super::auto;
use super::print;
use super::progress::Progress;
use super::scene;

/// Show what frames move between GPU and memory, by formula and by count.
///
/// The formula is of deferred shading that leaves the chip (Thibieroz, "Deferred Shading with Multiple Render Targets", 2004):
/// a GPU without tiles, one texel a lookup, no caches. The flags under 'Model' have the paper's names and default to the values
/// of its table 1; with a SCENE, to what a frame of it is counted to have. Then follow this renderer's ledger for the same
/// frame, and the whole frame's traffic in separate passes and in subpasses of one.
#[derive(Args, Debug)]
#[command(
    after_help = "\
Examples:
  ontile model
  ontile model --n-mrt 4 --mrt-bpp 32 --n 1 --size 1920x1080
  ontile model --table-2
  ontile model scene.glb --size 1920x1080",
    mut_arg("size", |a| a.default_value("1024x768")),
)]
pub struct ModelArgs {
    #[command(flatten)]
    pub scene: OptionalScene,
    #[command(flatten)]
    pub plan: PlanArgs,
    #[command(flatten)]
    pub inputs: InputArgs,
    /// Print the paper's table 2 instead: what is printed there, equation 6, and the paper's own working of it
    #[arg(long, conflicts_with_all = ["InputArgs", "PlanArgs", "scene"])]
    pub table_2: bool,
    /// Count on the first device whose name contains this, in either case [default: the first that fits]
    #[arg(long, value_name = "NAME_PART", requires = "scene")]
    pub device: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// What is looked at, if a scene is.
#[derive(Debug)]
pub struct OptionalScene(Option<SceneArgs>);

impl FromArgMatches for OptionalScene {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = matches.contains_id("scene");
        given.then(|| SceneArgs::from_arg_matches(matches)).transpose().map(Self)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for OptionalScene {
    fn augment_args(command: Command) -> Command {
        let flags = SceneArgs::augment_args(Command::new("scene"));
        let flags: Vec<_> = flags.get_arguments().map(|arg| arg.get_id().clone()).collect();
        SceneArgs::augment_args(command).mut_args(|arg| match arg.get_id().as_str() {
            "scene" => arg.required(false).help(
                "The scene whose frame is counted: a glTF 2.0 file, .gltf or .glb [default: none, the model is fed by hand]",
            ),
            id if flags.iter().any(|flag| flag == id) => arg.requires("scene"),
            _ => arg,
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The paper's variables.
#[derive(Args, Debug)]
#[command(next_help_heading = "Model")]
pub struct InputArgs {
    /// Bits of depth and stencil a pixel [default: 32]
    #[arg(long, value_name = "BITS", value_parser = amount, allow_negative_numbers = true)]
    pub z_bpp: Option<f64>,
    /// Bits of the back buffer a pixel [default: 32]
    #[arg(long, value_name = "BITS", value_parser = amount, allow_negative_numbers = true)]
    pub bb_bpp: Option<f64>,
    /// Fragments a pixel that reach the depth test [default: 3]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub overdraw: Option<f64>,
    /// Fragments a pixel that pass the depth test, at most as many [default: 1.5]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub sorting: Option<f64>,
    /// Bits of a texel, on average [default: 24]
    #[arg(long, value_name = "BITS", value_parser = amount, allow_negative_numbers = true)]
    pub t_bpp: Option<f64>,
    /// Texture lookups of a fragment in the building pass [default: 2]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub t_b: Option<f64>,
    /// Texture lookups of a pixel in a shading pass [default: 4]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub t_s: Option<f64>,
    /// Shading passes over the whole screen [default: 8]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub n: Option<f64>,
    /// Render targets of the G-buffer [default: 4]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub n_mrt: Option<f64>,
    /// Bits of a render target a pixel [default: 32]
    #[arg(long, value_name = "BITS", value_parser = amount, allow_negative_numbers = true)]
    pub mrt_bpp: Option<f64>,
    /// Bytes of vertices and indices read a frame [default: 16e6]
    #[arg(long, value_name = "BYTES", value_parser = amount, allow_negative_numbers = true)]
    pub c_geometry: Option<f64>,
    /// Frames a second [default: 60]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub fps: Option<f64>,
}

impl InputArgs {
    /// The variables as typed, and as they are in `otherwise` where they were not.
    fn over(&self, otherwise: Thibieroz) -> Thibieroz {
        let typed = |value: Option<f64>, other: f64| value.unwrap_or(other);
        Thibieroz {
            size: otherwise.size,
            z_bpp: typed(self.z_bpp, otherwise.z_bpp),
            bb_bpp: typed(self.bb_bpp, otherwise.bb_bpp),
            overdraw: typed(self.overdraw, otherwise.overdraw),
            sorting: typed(self.sorting, otherwise.sorting),
            t_bpp: typed(self.t_bpp, otherwise.t_bpp),
            t_b: typed(self.t_b, otherwise.t_b),
            t_s: typed(self.t_s, otherwise.t_s),
            n: typed(self.n, otherwise.n),
            n_mrt: typed(self.n_mrt, otherwise.n_mrt),
            mrt_bpp: typed(self.mrt_bpp, otherwise.mrt_bpp),
            c_geometry: typed(self.c_geometry, otherwise.c_geometry),
            fps: typed(self.fps, otherwise.fps),
        }
    }
}

fn amount(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(amount) if amount >= 0.0 && amount.is_finite() => Ok(amount),
        _ => Err("give a number, 0 or more".into()),
    }
}

/// The model by hand; bytes a frame, and bytes a second where it says so.
#[derive(Serialize)]
struct ByHand {
    model: Thibieroz,
    building_pass: Traffic,
    shading_passes: Traffic,
    frame: Traffic,
    bandwidth_b_s: Traffic,
    /// Equation 7, which holds for table 1 alone.
    approximated_b_s: Option<f64>,
}

impl ByHand {
    fn new(model: Thibieroz) -> Self {
        let of_table_1 =
            model == Thibieroz { n_mrt: model.n_mrt, mrt_bpp: model.mrt_bpp, ..Thibieroz::default() };
        Self {
            model,
            building_pass: model.building_pass(),
            shading_passes: model.shading_passes(),
            frame: model.frame(),
            bandwidth_b_s: model.bandwidth(),
            approximated_b_s: of_table_1.then(|| model.bandwidth_approximated()),
        }
    }
}

impl std::fmt::Display for ByHand {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let m = &self.model;
        let [width, height] = m.size;
        writeln!(f, "Thibieroz 2004, modelled: {width}x{height}, {} targets of {} bpp", m.n_mrt, m.mrt_bpp)?;
        writeln!(
            f,
            "  Z {} bpp, back buffer {} bpp, Overdraw {}, Sorting {}, T {} bpp, T_B {}, T_S {}, n {}, C_Geometry {} bytes\n",
            m.z_bpp, m.bb_bpp, m.overdraw, m.sorting, m.t_bpp, m.t_b, m.t_s, m.n, m.c_geometry
        )?;
        writeln!(f, "  {:<32} {:>10} {:>10} {:>10}", "", "read", "written", "both")?;
        let mut row = |what: &str, traffic: Traffic, unit: f64| {
            let [read, written, both] =
                [traffic.read, traffic.written, traffic.total()].map(|bytes| bytes / unit);
            writeln!(f, "  {what:<32} {read:>10.3} {written:>10.3} {both:>10.3}")
        };
        row("building pass (4), MB a frame", self.building_pass, 1e6)?;
        row("shading passes (5), MB a frame", self.shading_passes, 1e6)?;
        row("both, MB a frame", self.frame, 1e6)?;
        row(&format!("both at {} fps (6), GB/s", m.fps), self.bandwidth_b_s, 1e9)?;
        match self.approximated_b_s {
            Some(bytes) => {
                write!(f, "  {:<32} {:>10} {:>10} {:>10.3}", "approximated (7), GB/s", "", "", bytes / 1e9)
            }
            None => write!(f, "  (7) approximates (6) for the values of table 1 alone"),
        }
    }
}

/// Table 2.
#[derive(Serialize)]
#[serde(transparent)]
struct Table(Vec<Table2>);

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "Thibieroz 2004, table 2, modelled, GB/s:\n\n  targets  bpp   printed = (7)     (6)   (6) with 8 bytes of Z"
        )?;
        self.0.iter().try_for_each(|e| {
            write!(
                f,
                "\n  {:>7} {:>4} {:>15} {:>7.2} {:>23.2}",
                e.n_mrt, e.mrt_bpp, e.printed_gb_s, e.equation_6_gb_s, e.practical_example_gb_s
            )
        })
    }
}

/// A counted frame.
#[derive(Serialize)]
struct OfScene {
    scene: String,
    device: String,
    counts: Counts,
    #[serde(flatten)]
    traffic: FrameTraffic,
}

impl std::fmt::Display for OfScene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (counts, traffic) = (&self.counts, &self.traffic);
        let [width, height] = counts.size;
        let pixels = counts.pixels();
        let [covered, rasterized, passed] =
            [counts.covered, counts.rasterized, counts.passed].map(|fragments| fragments / pixels);
        writeln!(f, "{}: {width}x{height}, {} lights in view", self.scene, counts.lights)?;
        writeln!(
            f,
            "  fragments of surfaces a pixel, counted by {}: {rasterized:.3} drawn, {passed:.3} in front when drawn, {covered:.3} seen",
            self.device
        )?;
        writeln!(f, "\nG-buffer in memory, by Thibieroz 2004 (modelled)")?;
        for modelled in &traffic.modelled {
            let m = &modelled.model;
            writeln!(
                f,
                "  {}: n {}, {} targets of {} bpp, Z {} bpp, back buffer {} bpp,\n    Overdraw {:.3}, Sorting {:.3}, T {:.1} bpp, T_B {:.2}, T_S {:.2}, C_Geometry {:.0} bytes",
                modelled.what,
                m.n,
                m.n_mrt,
                (m.mrt_bpp * 1e3).round() / 1e3,
                m.z_bpp,
                m.bb_bpp,
                m.overdraw,
                m.sorting,
                m.t_bpp,
                m.t_b,
                m.t_s,
                m.c_geometry
            )?;
        }
        writeln!(f, "\n  {:<58} {:>10} {:>10}", "MB a frame", "read", "written")?;
        let mut row = |what: &str, traffic: Traffic| {
            writeln!(f, "  {what:<58} {:>10.3} {:>10.3}", traffic.read / 1e6, traffic.written / 1e6)
        };
        for modelled in &traffic.modelled {
            row(&format!("modelled: {}", modelled.what), modelled.frame)?;
        }
        let attachments = &traffic.parts[0];
        row("planned: attachments of separate passes", attachments.separate)?;
        row("planned: attachments of subpasses", attachments.subpasses)?;
        writeln!(
            f,
            "\nwhole frame, MB:                       separate passes       subpasses           more read"
        )?;
        writeln!(
            f,
            "                                         read  written      read  written      without caches"
        )?;
        for part in &traffic.parts {
            let [separate, subpasses] =
                [part.separate, part.subpasses].map(|t| [t.read / 1e6, t.written / 1e6]);
            writeln!(
                f,
                "  {:<24} {:<9} {:>8.3} {:>8.3}  {:>8.3} {:>8.3}  {:>18.3}",
                part.what,
                match part.origin {
                    Origin::Planned => "planned",
                    Origin::Modelled => "modelled",
                    Origin::Driver => "driver",
                },
                separate[0],
                separate[1],
                subpasses[0],
                subpasses[1],
                part.uncached_read / 1e6
            )?;
        }
        let published = traffic.published;
        write!(f, "\nsubpasses move less by                                  read  written")?;
        for saved in &traffic.saved {
            let [read, written] = [saved.share.read, saved.share.written].map(|share| 100.0 * share);
            write!(f, "\n  {:<48} {read:>7.1} % {written:>6.1} %", saved.assuming)?;
        }
        let [read, written] = [published.read, published.written].map(|share| 100.0 * share);
        write!(f, "\n  {:<48} {read:>7.1} % {written:>6.1} %", "Smith and Einig 2015, figure 2.8, measured")
    }
}

/// Counts a frame of a scene.
fn of_scene(args: &ModelArgs, scene_args: &SceneArgs) -> ontile::Result<OfScene> {
    let mut scene = scene::load(scene_args)?;
    let camera = scene::camera(&scene, scene_args)?.clone();
    scene::tell_idle_flags(&scene, &args.plan);
    scene::prefilter(&mut scene, args.plan.options(OutputFormat::Rgba8Srgb).environment_format);
    let host = Headless::new(&HeadlessOptions {
        device_name_part: args.device.clone(),
        validate: false,
        application_name: "ontile".into(),
        ..HeadlessOptions::default()
    })?;
    let device = host.device();
    let options = auto::options_on(&args.plan, OutputFormat::Rgba8Srgb, &scene, &camera, device)?;
    let cache = PipelineCache::load(device)?;
    let progress = Progress::of("counting");
    let view = View { camera: &camera, exposure_ev: args.plan.exposure };
    let counts = count(device, &scene, &options, &view, &cache)?;
    drop(progress);
    cache.store();
    let mut traffic = FrameTraffic::new(&scene, &options, &device.limits(), &counts)?;
    for modelled in &mut traffic.modelled {
        modelled.model = args.inputs.over(modelled.model);
        modelled.model.check()?;
        modelled.frame = modelled.model.frame();
    }
    Ok(OfScene { scene: scene.name.clone(), device: device.caps().name.clone(), counts, traffic })
}

/// Prints the model.
pub fn run(args: &ModelArgs) -> ontile::Result<()> {
    if args.table_2 {
        return print::value(&Table(table_2()), args.json);
    }
    if let Some(scene) = &args.scene.0 {
        return print::value(&of_scene(args, scene)?, args.json);
    }
    let model = args.inputs.over(Thibieroz { size: args.plan.size.0, ..Thibieroz::default() });
    model.check()?;
    print::value(&ByHand::new(model), args.json)
}

//! `ontile chart`

use std::path::{Path, PathBuf};

use clap::Args;
use ontile::gpu::{Headless, HeadlessOptions};
use ontile::measure::chart::{self, DriverFigures, Report, Sweep};
use ontile::measure::turnip::Turnip;
use ontile::measure::{Clock, Effort, ways};
use ontile::plan::{Adreno, Bins, Choice, Needs, Options, Strategy, Tonemap};
use ontile::scene::Scene;
use ontile::{Error, Result};
use sha2::{Digest, Sha256};

use super::args::{Size, exposure, named};
use super::print;
use super::progress::Progress;
use super::scene;

/// Chart speed against accuracy: every G-buffer's frame time and bytes against its error.
///
/// Draws each scene with every layout, and with each other choice of a G-buffer over the default one; compares the pictures
/// with a renderer in f64 and with the layout 'exact'; and writes chart.json, chart.csv, charts (SVG, PNG) and a page to read,
/// README.md. What the device does not do is listed with the reason. A run that is broken off goes on where it was: results
/// that are there and were made under the same conditions are kept. Where Mesa's Turnip is at hand (ONTILE_TURNIP_RUN), it
/// is asked how Adreno GPUs would tile each frame.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile chart assets/courtyard.glb assets/lamps.glb -o out/chart
  ontile chart scene.glb -o out/phone --device Mali --sizes 1280x720,1920x1080
  ontile chart scene.glb -o out/part2 --shard 2/4
  ontile chart --merge out/part1 out/part2 out/part3 out/part4 -o out/chart")]
pub struct ChartArgs {
    /// The scenes: glTF 2.0 files, .gltf or .glb
    #[arg(value_name = "SCENE", required_unless_present = "merge")]
    scenes: Vec<PathBuf>,
    /// The folder to write; made if it does not exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Widths and heights of the pictures, in pixels
    #[arg(long, value_name = "WxH,...", value_delimiter = ',', default_value = "1280x720")]
    sizes: Vec<Size>,
    /// The camera of each scene, by its number (from 0) or its name
    #[arg(long, value_name = "N|NAME", default_value = "0", allow_negative_numbers = true)]
    camera: String,
    /// How stages become render passes
    #[arg(long, default_value_t = Strategy::Subpasses, value_parser = named(Strategy::ALL, Strategy::name))]
    strategy: Strategy,
    /// The curve from scene light to display light
    #[arg(long, default_value_t = Tonemap::Neutral, value_parser = named(Tonemap::ALL, Tonemap::name))]
    tonemap: Tonemap,
    /// Exposure in EV (stops)
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = exposure, allow_negative_numbers = true)]
    exposure: f32,
    /// Every combination of choices, not only one at a time
    #[arg(long)]
    full: bool,
    /// Use the first device whose name or driver contains this, in either case [default: the first that fits]
    #[arg(long, value_name = "NAME_PART")]
    device: Option<String>,
    /// Rounds at most of each race
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    frames: u32,
    /// After so many seconds a race of seven G-buffers ends with the rounds it has, but at least six
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    seconds: u32,
    /// Measure the I-th of N parts of the cells only; --merge puts them together
    #[arg(long, value_name = "I/N", value_parser = shard, default_value = "1/1", allow_hyphen_values = true)]
    shard: [usize; 2],
    /// Chart ways instead of G-buffers: samples a pixel (error against 64), decals, shadows by maps and volumes,
    /// translucency and refraction
    #[arg(long, conflicts_with_all = ["full", "shard"])]
    ways: bool,
    /// Measure nothing: put the results of these folders together
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["scenes", "full", "device", "shard"])]
    merge: Vec<PathBuf>,
}

/// The part, counted from 0, of how many.
fn shard(text: &str) -> Result<[usize; 2], String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some([i.parse().ok()?, n.parse().ok()?]));
    match numbers {
        Some([i, n]) if (1..=n).contains(&i) => Ok([i - 1, n]),
        _ => Err("give the part and the number of parts, as in 2/4".into()),
    }
}

/// Measures or merges, and writes everything.
pub fn run(args: &ChartArgs) -> Result<()> {
    if args.ways {
        let report = if args.merge.is_empty() { ways(args)? } else { merged_ways(args)? };
        ways::write(&report, &args.output)?;
        return print::text(&args.output.join("README.md").display());
    }
    let report = if args.merge.is_empty() { measured(args)? } else { merged(args)? };
    chart::write_all(&report, &args.output)?;
    print::text(&format_args!("{}{}", chart::summary(&report), args.output.join("README.md").display()))
}

fn merged_ways(args: &ChartArgs) -> Result<ways::Report> {
    let mut all = args.merge.iter().map(|folder| ways::Report::read(folder));
    let first =
        all.next().unwrap_or_else(|| Err(Error::unsupported("nothing is to be merged", "name folders")))?;
    let report = all.try_fold(first, |mut report, other| report.merge(other?).map(|()| report))?;
    make_folder(&args.output)?;
    Ok(report)
}

fn ways(args: &ChartArgs) -> Result<ways::Report> {
    let scenes = args.scenes.iter().map(|path| load(path, &args.camera)).collect::<Result<Vec<_>>>()?;
    let host = host(args)?;
    make_folder(&args.output)?;
    let device = host.device();
    let caps = device.caps();
    let (name, driver, clock) = (caps.name.clone(), caps.driver.clone(), Clock::of(device));
    let mut report = ways::Report { device: name, driver, clock, points: Vec::new() };
    let effort = Effort { rounds: args.frames as usize, seconds: args.seconds.into() };
    let of_scene =
        |scene: &Scene| ways::series(&Needs::of(scene), &Options::default()).len() * args.sizes.len();
    let steps = scenes.iter().map(|(scene, _)| of_scene(scene)).sum::<usize>();
    let progress = Progress::of_steps("charting", steps as u64);
    for (scene, camera) in &scenes {
        for size in args.sizes.iter().map(|size| size.0) {
            let camera = &scene.cameras[*camera];
            let stage = ways::Stage { device, scene, camera, exposure_ev: args.exposure, effort };
            let options =
                Options { size, strategy: args.strategy, tonemap: args.tonemap, ..Options::default() };
            report.points.extend(stage.run(&options, &|| progress.step())?);
        }
    }
    drop(progress);
    Ok(report)
}

fn host(args: &ChartArgs) -> Result<Headless> {
    Headless::new(&HeadlessOptions {
        device_name_part: args.device.clone(),
        validate: false,
        application_name: "ontile".into(),
        ..HeadlessOptions::default()
    })
}

fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| Error::io(path, "create", e))
}

fn merged(args: &ChartArgs) -> Result<Report> {
    let mut report = Report::new(Vec::new());
    for folder in &args.merge {
        report.merge(Report::read(folder)?);
    }
    make_folder(&args.output)?;
    report.write(&args.output)?;
    Ok(report)
}

fn measured(args: &ChartArgs) -> Result<Report> {
    let scenes = args.scenes.iter().map(|path| load(path, &args.camera)).collect::<Result<Vec<_>>>()?;
    let mut report = match Report::path(&args.output).exists() {
        true => Report::read(&args.output)?,
        false => Report::new(Vec::new()),
    };
    let host = host(args)?;
    make_folder(&args.output)?;
    let options = Options { strategy: args.strategy, tonemap: args.tonemap, ..Options::default() };
    let sweep = Sweep {
        scenes: scenes.iter().map(|(scene, camera)| (scene, *camera)).collect(),
        sizes: args.sizes.iter().map(|size| size.0).collect(),
        choices: if args.full { Choice::every() } else { chart::default_choices() },
        options,
        exposure_ev: args.exposure,
        effort: Effort { rounds: args.frames as usize, seconds: args.seconds.into() },
        shard: args.shard,
        program: program()?,
    };
    let turnip = Turnip::find(None).map(Asked::new).transpose()?;
    let ask = |scene: usize, size: [u32; 2], choice: Choice, adreno: &Adreno| {
        let turnip = turnip.as_ref().expect("it is asked where it is");
        turnip.ask(&args.scenes[scene], &args.camera, size, args.strategy, choice, adreno)
    };
    let progress = Progress::of_steps("charting", sweep.cells() as u64);
    let ask_driver: Option<&chart::AskDriver<'_>> = if turnip.is_some() { Some(&ask) } else { None };
    sweep.run(host.device(), &args.output, &mut report, ask_driver, &|| progress.step())?;
    drop(progress);
    report.write(&args.output)?;
    Ok(report)
}

fn load(path: &Path, camera: &str) -> Result<(Scene, usize)> {
    let mut scene = {
        let _progress = Progress::of(format!("loading {}", path.display()));
        Scene::load(path)?
    };
    scene.keep_lights(None, Some(Scene::DEFAULT_SHADOWS));
    scene.warnings.iter().for_each(|warning| print::warning(warning));
    scene::prefilter(&mut scene, Options::default().environment_format);
    let wanted = scene.camera(camera).map_err(|e| scene::about(path, e))?;
    let index = scene.cameras.iter().position(|known| std::ptr::eq(known, wanted));
    Ok((scene, index.expect("the camera is the scene's")))
}

/// The version, and enough of the program's hash to tell builds apart.
fn program() -> Result<String> {
    let path = std::env::current_exe().map_err(|e| Error::io(Path::new("ontile"), "read", e))?;
    let bytes = std::fs::read(&path).map_err(|e| Error::io(&path, "read", e))?;
    let hash: String = Sha256::digest(&bytes).iter().take(6).map(|byte| format!("{byte:02x}")).collect();
    Ok(format!("{} {hash}", env!("CARGO_PKG_VERSION")))
}

/// The driver of another GPU, which draws nothing.
struct Asked {
    turnip: Turnip,
    program: PathBuf,
    folder: PathBuf,
}

impl Asked {
    fn new(turnip: Turnip) -> Result<Self> {
        let program = std::env::current_exe().map_err(|e| Error::io(Path::new("ontile"), "read", e))?;
        let folder = std::env::temp_dir().join(format!("ontile-chart-{}", std::process::id()));
        make_folder(&folder)?;
        Ok(Self { turnip, program, folder })
    }

    fn ask(
        &self,
        scene: &Path,
        camera: &str,
        size: [u32; 2],
        strategy: Strategy,
        choice: Choice,
        adreno: &Adreno,
    ) -> Result<Option<DriverFigures>> {
        let mut command = self.turnip.command(adreno.id, &self.program);
        command.arg("render").arg(scene).arg("-o").arg(self.folder.join("frame.png"));
        command.args(["--size", &Size(size).to_string(), "--camera", camera, "--no-shadows"]);
        command.args(["--strategy", strategy.name()]).args(choice.flags());
        let passes = match Turnip::trace(command, &self.folder) {
            Ok(run) => run.trace.passes,
            Err(error) => {
                print::warning(&format!("Adreno {} does not draw {choice}: {error}", adreno.id));
                return Ok(None);
            }
        };
        let Some(last) = passes.last() else { return Ok(None) };
        let size_px = [last.bin_width_px, last.bin_height_px];
        Ok(Some(DriverFigures {
            bins: last.tiled.then_some(Bins { count: last.bins, size_px }),
            passes: passes.len() as u32,
            loaded: passes.iter().map(|p| p.load_bytes_per_pixel).sum(),
            stored: passes.iter().map(|p| p.store_bytes_per_pixel).sum(),
        }))
    }
}

impl Drop for Asked {
    fn drop(&mut self) {
        // In the system's own folder for such things: no harm if it stays.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

//! Measures what this machine does: frame times of both strategies, the cost of recording, loading and memory.
//! Run by `tools/bench`. Nothing here passes or fails; times of other runs, machines and loads do not compare.

mod compare;
mod flight;
mod frames;
mod loading;
mod recording;
mod scenes;

// What makes the scenes that are compared.
#[path = "../make_scenes/main.rs"]
#[allow(dead_code, reason = "its main function and the scenes that are not compared")]
pub mod make_scenes;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use ontile::gpu::{Headless, HeadlessOptions};
use ontile::{Error, Result, file};
use serde::Serialize;

/// Measure frame times, recording, loading and memory.
#[derive(Parser, Debug)]
#[command(name = "bench", args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    command: Option<Command>,
    /// Width and height of the frames, in pixels [default: 1280x720]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Use the first device whose name or driver contains this, in either case
    #[arg(long, value_name = "NAME_PART", default_value = "llvmpipe")]
    device: String,
    /// Frames of each kind that count [default: 15]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// 5 frames of 640x360, unless said otherwise
    #[arg(long)]
    quick: bool,
    /// Also measure the way from this file to the first picture
    #[arg(long, value_name = "SCENE")]
    load: Option<PathBuf>,
    /// Write the results as JSON
    #[arg(short, long, value_name = "OUT.json")]
    output: Option<PathBuf>,
    /// Load the scene once and print the times as JSON: what the program asks of itself
    #[arg(long, hide = true, requires = "load")]
    load_once: bool,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Compare deferred with forward, and the ways of lights with each other; writes numbers, charts and a page
    Compare(compare::Compare),
    /// Measure a scene along a camera path that was recorded
    Flight(flight::Flight),
}

#[derive(Serialize)]
struct Results {
    device: String,
    driver: String,
    size: [u32; 2],
    frames: Vec<frames::Frames>,
    recording: Vec<recording::Recording>,
    loading: Option<loading::Loading>,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("bench: {e}");
            ExitCode::FAILURE
        }
    }
}

/// Does what the command line asks for.
///
/// # Errors
/// As the parts.
pub fn run(args: &Args) -> Result<()> {
    match &args.command {
        Some(Command::Compare(compare)) => return compare::run(compare),
        Some(Command::Flight(flight)) => return flight::run(flight),
        None => {}
    }
    let size = args.size.unwrap_or(if args.quick { [640, 360] } else { [1280, 720] });
    let frames = args.frames.unwrap_or(if args.quick { 5 } else { 15 }) as usize;
    let json_error = |e: serde_json::Error| Error::io(Path::new("results"), "write", e.into());
    if let (Some(scene), true) = (&args.load, args.load_once) {
        let once = loading::once(scene, size, Some(args.device.clone()))?;
        println!("{}", serde_json::to_string(&once).map_err(json_error)?);
        return Ok(());
    }

    let headless = Headless::new(&HeadlessOptions {
        device_name_part: Some(args.device.clone()),
        validate: false,
        application_name: "ontile bench".into(),
        ..HeadlessOptions::default()
    })?;
    let device = headless.device();
    let (name, driver) = (device.caps().name.clone(), device.caps().driver.clone());
    println!("{name} ({driver}), {}x{}, {frames} frames of each kind\n", size[0], size[1]);

    let recording = recording::measure(device)?;
    recording::print(&recording);
    let loading = args.load.as_deref().map(|scene| measure_loading(args, scene, size, frames)).transpose()?;
    loading.iter().for_each(loading::print);
    let frames = frames::measure(device, size, frames, |scene| eprintln!("measuring {scene} ..."))?;
    frames::print(&frames);

    if let Some(path) = &args.output {
        let results = Results { device: name, driver, size, frames, recording, loading };
        let json = serde_json::to_string_pretty(&results).map_err(json_error)?;
        file::write_whole(path, json.as_bytes())?;
    }
    Ok(())
}

fn measure_loading(args: &Args, scene: &Path, size: [u32; 2], runs: usize) -> Result<loading::Loading> {
    let program = std::env::current_exe().map_err(|e| Error::io(Path::new("bench"), "run", e))?;
    loading::measure(scene, runs, || {
        let mut child = std::process::Command::new(&program);
        let [width, height] = size;
        child.arg("--load-once").arg("--load").arg(scene);
        child.args(["--device", &args.device, "--size", &format!("{width}x{height}")]);
        child
    })
}

fn size(text: &str) -> std::result::Result<[u32; 2], String> {
    let parts = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parts.filter(|[w, h]| *w > 0 && *h > 0).ok_or_else(|| "give width and height, as 1280x720".to_owned())
}

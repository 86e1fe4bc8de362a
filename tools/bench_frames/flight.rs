//! Frame times of a scene along a camera path, in one render pass and in separate ones.

use std::path::{Path, PathBuf};

use ontile::environment::{Cache, DEFAULT_FACE_SIZE, TexelFormat};
use ontile::gpu::{Headless, HeadlessOptions, View};
use ontile::measure::{FrameTimes, Host, Summary};
use ontile::plan::{Options, Strategy};
use ontile::scene::{Flight as Way, Scene};
use ontile::{Error, Result, file};
use serde::Serialize;

/// What `flight` is told.
#[derive(clap::Args, Debug)]
pub struct Flight {
    /// The scene: a glTF 2.0 file
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// The camera path, as 'ontile view' records it
    #[arg(value_name = "FILE")]
    flight: PathBuf,
    /// The camera whose projection it has, by its number or name
    #[arg(long, value_name = "N|NAME", default_value = "0")]
    camera: String,
    /// Width and height of the frames, in pixels
    #[arg(long, value_name = "WxH", value_parser = super::size, default_value = "1280x720")]
    size: [u32; 2],
    /// Use the first device whose name or driver contains this, in either case
    #[arg(long, value_name = "NAME_PART", default_value = "llvmpipe")]
    device: String,
    /// Places along the path, in equal steps of time
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// Frames at each place that count; its time is their median
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Write the results as JSON
    #[arg(short, long, value_name = "OUT.json")]
    output: Option<PathBuf>,
}

#[derive(Serialize)]
struct Results {
    device: String,
    driver: String,
    scene: String,
    size: [u32; 2],
    subpasses: Summary,
    separate: Summary,
    places: Vec<Place>,
}

/// What a frame takes at a place, milliseconds: by timestamps, where the device has them.
#[derive(Clone, Copy, Serialize)]
struct Place {
    /// Seconds after the path's begin.
    time_s: f64,
    subpasses_ms: f64,
    separate_ms: f64,
}

const STRATEGIES: [Strategy; 2] = [Strategy::Subpasses, Strategy::Separate];

/// Measures, prints and writes.
///
/// # Errors
/// Those of loading, and of rendering.
pub fn run(args: &Flight) -> Result<()> {
    let way = Way::load(&args.flight)?;
    let mut scene = Scene::load(&args.scene)?;
    for environment in scene.environments_mut() {
        environment.prefilter(DEFAULT_FACE_SIZE, TexelFormat::E5B9G9R9, Cache::of_user().as_ref());
    }
    let headless = Headless::new(&HeadlessOptions {
        device_name_part: Some(args.device.clone()),
        validate: false,
        application_name: "ontile bench".into(),
        ..HeadlessOptions::default()
    })?;
    let device = headless.device();
    let mut camera = scene.camera(&args.camera)?.clone();
    let host = |strategy| {
        Host::new(device, &scene, &Options { size: args.size, strategy, ..Options::default() }, false)
    };
    let [subpasses, separate] = STRATEGIES.map(host);
    let mut hosts = [subpasses?, separate?];
    let mut places = Vec::new();
    for place in 0..args.frames {
        let time_s = way.duration_s() * f64::from(place) / f64::from(args.frames - 1);
        way.place(&mut camera, time_s);
        let view = View { camera: &camera, exposure_ev: 0.0 };
        let mut times: [Vec<f64>; 2] = Default::default();
        // Drivers compile and allocate in the first; each goes first every other time.
        for round in 0..=args.rounds as usize {
            for which in [round % 2, 1 - round % 2] {
                let FrameTimes { gpu_ms, wall_ms, .. } = hosts[which].frame(&view)?;
                if round > 0 {
                    times[which].push(gpu_ms.unwrap_or(wall_ms));
                }
            }
        }
        let [subpasses_ms, separate_ms] = times.map(|times| Summary::of(times).map_or(0.0, |s| s.median));
        places.push(Place { time_s, subpasses_ms, separate_ms });
    }
    let of = |ms: fn(&Place) -> f64| Summary::of(places.iter().map(ms));
    let (Some(subpasses), Some(separate)) = (of(|p| p.subpasses_ms), of(|p| p.separate_ms)) else {
        return Ok(());
    };
    let caps = device.caps();
    let results = Results {
        device: caps.name.clone(),
        driver: caps.driver.clone(),
        scene: scene.name.clone(),
        size: args.size,
        subpasses,
        separate,
        places,
    };
    print(&results);
    let Some(path) = &args.output else { return Ok(()) };
    let json = serde_json::to_string_pretty(&results);
    file::write_whole(path, json.map_err(|e| Error::io(Path::new("results"), "write", e.into()))?.as_bytes())
}

fn print(results: &Results) {
    let Results { device, driver, scene, size: [width, height], places, .. } = results;
    println!("{device} ({driver}), {scene} at {} places of a camera path, {width}x{height}", places.len());
    println!("milliseconds: median [quartiles] over the places, and the slowest");
    type Ms = fn(&Place) -> f64;
    let rows: [(&str, &Summary, Ms); 2] = [
        ("subpasses", &results.subpasses, |p| p.subpasses_ms),
        ("separate", &results.separate, |p| p.separate_ms),
    ];
    for (name, summary, ms) in rows {
        let worst = places.iter().max_by(|a, b| ms(a).total_cmp(&ms(b)));
        let worst = worst.map_or(String::new(), |p| format!("{:.3} at {:.2} s", ms(p), p.time_s));
        println!("{name:<10} {:>25}  {worst}", summary.to_string());
    }
}

//! From a file to the first picture, in a process of its own, so that its memory is only its own.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use ontile::gpu::{Headless, HeadlessOptions, PipelineCache, Renderer, RendererConfig, View};
use ontile::measure::{Host, Summary};
use ontile::plan::{Needs, Options, Plan};
use ontile::scene::Scene;
use ontile::{Error, Result};
use serde::{Deserialize, Serialize};

/// Milliseconds of each step, and the process's memory.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Once {
    /// Instance and device.
    device_ms: f64,
    /// Reading and decoding the file.
    parse_ms: f64,
    /// Pipelines, buffers, textures, and the copy of their contents, mipmaps made, to staging memory.
    objects_ms: f64,
    /// The copies to the device.
    upload_ms: f64,
    /// Drivers may compile in it.
    first_frame_ms: f64,
    /// The frame after it, to compare.
    second_frame_ms: f64,
    /// VmHWM: the most memory that was resident, drivers and attachments counted in.
    peak_resident_mib: Option<f64>,
}

#[derive(Serialize)]
pub struct Loading {
    file: PathBuf,
    file_mib: f64,
    device_ms: Option<Summary>,
    parse_ms: Option<Summary>,
    objects_ms: Option<Summary>,
    upload_ms: Option<Summary>,
    first_frame_ms: Option<Summary>,
    second_frame_ms: Option<Summary>,
    total_ms: Option<Summary>,
    peak_resident_mib: Option<Summary>,
}

/// The work of the child process.
pub fn once(file: &Path, size: [u32; 2], device: Option<String>) -> Result<Once> {
    let mut last = Instant::now();
    let mut lap_ms = || {
        let now = Instant::now();
        (now - std::mem::replace(&mut last, now)).as_secs_f64() * 1e3
    };
    let headless = Headless::new(&HeadlessOptions {
        device_name_part: device,
        validate: false,
        application_name: "ontile bench".into(),
        ..HeadlessOptions::default()
    })?;
    let device = headless.device();
    let device_ms = lap_ms();
    let scene = Scene::load(file)?;
    let parse_ms = lap_ms();
    let options = Options { size, ..Options::default() };
    let plan = Plan::new(Needs::of(&scene), options, &device.caps().limits())?;
    let cache = PipelineCache::new(device, &[])?;
    let renderer = Renderer::new(device, &scene, plan, RendererConfig::default(), &cache)?;
    let mut host = Host::with_renderer(device, renderer)?;
    let objects_ms = lap_ms();
    host.upload()?;
    let upload_ms = lap_ms();
    let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
    host.frame(&view)?;
    let first_frame_ms = lap_ms();
    host.frame(&view)?;
    let second_frame_ms = lap_ms();
    let peak_resident_mib = peak_resident_mib();
    Ok(Once {
        device_ms,
        parse_ms,
        objects_ms,
        upload_ms,
        first_frame_ms,
        second_frame_ms,
        peak_resident_mib,
    })
}

/// Linux only.
fn peak_resident_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kib = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?;
    Some(kib.parse::<f64>().ok()? / 1024.0)
}

/// Runs `child` (this program, asked for [`once`]) several times.
pub fn measure(file: &Path, runs: usize, child: impl Fn() -> Command) -> Result<Loading> {
    let bytes = std::fs::metadata(file).map_err(|e| Error::io(file, "read", e))?.len();
    let failed = |what: String| Error::unsupported(what, "run the program on this scene alone to see why");
    let runs = (0..runs).map(|_| {
        let output = child().output().map_err(|e| failed(format!("the loading process cannot run: {e}")))?;
        let message = String::from_utf8_lossy(&output.stderr);
        serde_json::from_slice::<Once>(&output.stdout)
            .map_err(|_| failed(format!("loading {}: {}", file.display(), message.trim())))
    });
    let runs = runs.collect::<Result<Vec<_>>>()?;
    let of = |value: fn(&Once) -> f64| Summary::of(runs.iter().map(value));
    Ok(Loading {
        file: file.to_owned(),
        file_mib: bytes as f64 / f64::from(1 << 20),
        device_ms: of(|r| r.device_ms),
        parse_ms: of(|r| r.parse_ms),
        objects_ms: of(|r| r.objects_ms),
        upload_ms: of(|r| r.upload_ms),
        first_frame_ms: of(|r| r.first_frame_ms),
        second_frame_ms: of(|r| r.second_frame_ms),
        total_ms: of(|r| r.device_ms + r.parse_ms + r.objects_ms + r.upload_ms + r.first_frame_ms),
        peak_resident_mib: Summary::of(runs.iter().filter_map(|r| r.peak_resident_mib)),
    })
}

/// The results as a table.
pub fn print(r: &Loading) {
    println!(
        "From {} ({:.1} MiB) to the first picture: median milliseconds [quartiles]",
        r.file.display(),
        r.file_mib
    );
    let rows = [
        ("device", &r.device_ms),
        ("parse and decode", &r.parse_ms),
        ("pipelines and staging", &r.objects_ms),
        ("upload", &r.upload_ms),
        ("first frame", &r.first_frame_ms),
        ("total", &r.total_ms),
        ("(second frame)", &r.second_frame_ms),
        ("peak resident MiB", &r.peak_resident_mib),
    ];
    for (name, summary) in rows {
        println!("  {name:<22} {}", summary.map_or("-".into(), |s| format!("{s:.1}")));
    }
    println!();
}

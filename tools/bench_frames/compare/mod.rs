//! The comparison: deferred against forward, and the ways of lights against each other, on the scene kinds and with the
//! tables of "Deferred versus forward shading" (2007). Writes numbers (JSON, CSV), charts (SVG, PNG) and a page.

mod chart;
mod csv;
mod data;
mod findings;
mod maths;
mod measure;
mod page;
mod rules;
mod scenes;
mod tables;
#[cfg(test)]
mod tests;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use ontile::gpu::{Device, DeviceType, Headless, HeadlessOptions};
use ontile::measure::canvas::Drawing;
use ontile::measure::{Clock, Effort};
use ontile::{Error, Result, file};
use serde::Serialize;

use data::{Report, Run, Table, TableName};
use tables::Settings;

/// The file that people read.
const PAGE: &str = "README.md";

/// What `compare` is told.
#[derive(clap::Args, Debug)]
pub struct Compare {
    /// The folder to write: comparison.json, comparison.csv, derived.json, charts and README.md
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Use the first device whose name or driver contains this, in either case
    #[arg(long, value_name = "NAME_PART", default_value = "llvmpipe")]
    device: String,
    /// Fewer rounds and fewer places in each sweep
    #[arg(long)]
    quick: bool,
    /// Sizes of the exterior and the interior
    #[arg(long, value_name = "WxH,...", value_delimiter = ',', value_parser = super::size,
        default_value = "800x600,1024x768,1280x960,1600x1200")]
    sizes: Vec<[u32; 2]>,
    /// Size of everything else [default: 1024x768 for what the dissertation measured, 1280x720 for the sweeps on a
    /// CPU, 1920x1080 on a GPU]
    #[arg(long, value_name = "WxH", value_parser = super::size)]
    size: Option<[u32; 2]>,
    /// Rounds at most [default: 25, quick: 7]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// After so many seconds a row ends with the rounds it has, but at least six [default: 25, quick: 5]
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u32).range(1..))]
    seconds: Option<u32>,
    /// Where the sweep over lights ends [default: 1024 on a CPU, 4096 on a GPU, quick: 256]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    most_lights: Option<u32>,
    /// These tables only
    #[arg(long, value_name = "TABLE", value_enum, value_delimiter = ',')]
    only: Vec<TableName>,
    /// Measure nothing: put these comparison.json together, so that one page shows all devices
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["device", "quick", "frames", "only"])]
    merge: Vec<PathBuf>,
}

/// Measures or merges, and writes everything.
///
/// # Errors
/// [`Error::Io`], [`Error::Unsupported`] for no such device or bad files to merge, [`Error::Vulkan`].
pub fn run(args: &Compare) -> Result<()> {
    if args.merge.is_empty() {
        measure_all(args)?
    } else {
        write(&merged(&args.merge)?, &args.output)?
    }
    println!("{}", args.output.join(PAGE).display());
    Ok(())
}

fn merged(files: &[PathBuf]) -> Result<Report> {
    let mut report = Report::new(Vec::new());
    for path in files {
        report.merge(Report::read(path)?);
    }
    Ok(report)
}

fn measure_all(args: &Compare) -> Result<()> {
    let headless = Headless::new(&HeadlessOptions {
        device_name_part: Some(args.device.clone()),
        validate: false,
        application_name: "ontile bench".into(),
        ..HeadlessOptions::default()
    })?;
    let device = headless.device();
    let caps = device.caps();
    let effort = Effort {
        rounds: args.frames.unwrap_or(if args.quick { 7 } else { 25 }) as usize,
        seconds: f64::from(args.seconds.unwrap_or(if args.quick { 5 } else { 25 })),
    };
    let settings = settings(args, device);
    let mut run = Run {
        device: caps.name.clone(),
        driver: caps.driver.clone(),
        clock: Clock::of(device),
        tables: Vec::new(),
    };
    for &name in TableName::value_variants() {
        if !args.only.is_empty() && !args.only.contains(&name) {
            continue;
        }
        // Counts are the same in every round.
        let rounds = if name == TableName::Draws { 1 } else { effort.rounds };
        let mut rows = Vec::new();
        for case in tables::cases(name, device, &settings)? {
            eprintln!("measuring {}: {} ...", name.name(), case.label);
            rows.push(measure::case(device, &case, Effort { rounds, ..effort })?);
        }
        run.put(Table { name, rows });
        // What is measured so far survives what may come.
        write(&Report::new(vec![run.clone()]), &args.output)?;
    }
    Ok(())
}

fn settings(args: &Compare, device: &Device) -> Settings {
    let on_cpu = device.caps().device_type == DeviceType::Cpu;
    let most_lights = match (args.quick, on_cpu) {
        (true, _) => 256,
        (false, true) => 1024,
        (false, false) => 4096,
    };
    Settings {
        sizes: args.sizes.clone(),
        view_size: args.size.unwrap_or([1024, 768]),
        sweep_size: args.size.unwrap_or(if on_cpu { [1280, 720] } else { [1920, 1080] }),
        most_lights: args.most_lights.map_or(most_lights, |n| n as usize),
        quick: args.quick,
    }
}

/// What follows from the numbers, for programs.
#[derive(Serialize)]
struct Derived {
    device: String,
    targets: Vec<findings::Target>,
    findings: Vec<findings::Finding>,
    rules: Vec<rules::Rule>,
}

fn write(report: &Report, folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
    report.write(&folder.join("comparison.json"))?;
    file::write_whole(&folder.join("comparison.csv"), csv::csv(report).as_bytes())?;
    let derived = |run: &Run| Derived {
        device: run.device.clone(),
        targets: findings::targets(run),
        findings: findings::findings(run),
        rules: rules::rules(run),
    };
    let path = folder.join("derived.json");
    let derived: Vec<_> = report.runs.iter().map(derived).collect();
    let json = serde_json::to_string_pretty(&derived).map_err(|e| Error::io(&path, "write", e.into()))?;
    file::write_whole(&path, json.as_bytes())?;
    for run in &report.runs {
        for (name, chart) in chart::charts(run) {
            chart.write(&folder.join(page::chart_name(name, run)))?;
        }
    }
    file::write_whole(&folder.join(PAGE), page::page(report).as_bytes())
}

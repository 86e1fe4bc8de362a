//! `ontile stability`

use std::fs;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use ontile::gpu::HeadlessOptions;
use ontile::measure::stability::{Bench, Lab, Scale, Study, Sweep};
use ontile::{Error, Result};

use super::print;
use super::progress::Progress;

/// Find where methods fail: sweeps that take each method from where it is right to where it is not.
///
/// Each sweep varies one quantity (roughness, angles, distances, bits), measures against the f64 reference or a closed form,
/// and compares each method's worst case with a named bound. Writes a page (README.md), stability.json and pictures of the
/// worst cases; prints a table. Fails if a method is worse than its bound and nothing is done about it.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile stability -o stability
  ontile stability -o stability --sweep roughness --sweep depth
  ontile stability -o stability --quick --device llvmpipe

Sweeps that draw need a Vulkan device; without one they are left out, and the table says so.")]
pub struct StabilityArgs {
    /// The folder to write to; made if it does not exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Run this sweep only; may be given several times [default: all]
    #[arg(long = "sweep", value_name = "NAME", value_parser = PossibleValuesParser::new(Sweep::ALL.iter().map(|sweep| sweep.name)))]
    sweeps: Vec<String>,
    /// Measure fewer places: seconds instead of minutes [default: off]
    #[arg(long)]
    quick: bool,
    /// Use the first device whose name contains this, in either case [default: the first that fits]
    #[arg(long, value_name = "NAME_PART")]
    device: Option<String>,
    /// Run under the Khronos validation layer; any message of it is a failure [default: off]
    #[arg(long)]
    validate: bool,
}

pub fn run(args: &StabilityArgs) -> Result<()> {
    fs::create_dir_all(&args.output).map_err(|e| Error::io(&args.output, "create", e))?;
    let chosen: Vec<_> = Sweep::ALL
        .iter()
        .filter(|sweep| args.sweeps.is_empty() || args.sweeps.iter().any(|name| name == sweep.name))
        .collect();
    let bench = chosen.iter().any(|sweep| sweep.needs_device).then(|| open(args));
    let (bench, missing) = match bench {
        None => (None, None),
        Some(Ok(bench)) => (Some(bench), None),
        // A device or layer that was asked for must be there.
        Some(Err(error)) if args.device.is_some() || args.validate => return Err(error),
        Some(Err(error)) => (None, Some(error.to_string())),
    };
    let scale = if args.quick { Scale::Quick } else { Scale::Full };
    let mut study = Study::new(scale, bench.as_ref().map(|bench| bench.device().caps().name.clone()));
    let progress = Progress::of_steps("sweeps", chosen.len() as u64);
    for sweep in chosen {
        progress.tell(sweep.name);
        match &missing {
            Some(why) if sweep.needs_device => study.skip(sweep, why.clone()),
            _ => study.add(sweep, sweep.run(&Lab { scale, bench: bench.as_ref() })?),
        }
        progress.step();
    }
    drop(progress);
    let messages = bench.map(Bench::finish).unwrap_or_default();
    study.write(&args.output)?;
    print::text(&study)?;
    if let (true, Some(first)) = (args.validate, messages.first()) {
        return Err(Error::unsupported(
            format!("the validation layer has {} messages, first: {first}", messages.len()),
            "report this as a bug of ontile or of the driver",
        ));
    }
    match study.failures().as_slice() {
        [] => Ok(()),
        failures => {
            let list: Vec<_> = failures.iter().map(|(sweep, method)| format!("{sweep} ({method})")).collect();
            Err(Error::unsupported(
                format!("{} methods are worse than their bounds: {}", failures.len(), list.join(", ")),
                format!("see {}", args.output.join("README.md").display()),
            ))
        }
    }
}

fn open(args: &StabilityArgs) -> Result<Bench> {
    Bench::open(&HeadlessOptions {
        device_name_part: args.device.clone(),
        validate: args.validate,
        application_name: "ontile".into(),
        ..HeadlessOptions::default()
    })
}

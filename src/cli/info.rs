//! `ontile info`

use clap::Args;
use ontile::gpu::{self, Caps, Counter};
use serde::Serialize;

use super::print;

/// List the Vulkan devices and what matters for on-tile rendering: lazily allocated memory, input attachments,
/// sample counts, extensions.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile info
  ontile info --json
  ontile info --counters")]
pub struct InfoArgs {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// List the performance counters that 'ontile render --counters' can read, by number and name
    #[arg(long)]
    pub counters: bool,
}

/// What is printed.
#[derive(Serialize)]
struct Devices {
    devices: Vec<Listed>,
}

#[derive(Serialize)]
struct Listed {
    #[serde(flatten)]
    caps: Caps,
    #[serde(skip_serializing_if = "Option::is_none")]
    counters: Option<Vec<Counter>>,
}

impl std::fmt::Display for Devices {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, device) in self.devices.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{}", device.caps)?;
            for (number, counter) in device.counters.iter().flatten().enumerate() {
                writeln!(f, "  counter {number:<4}                {counter}")?;
            }
        }
        Ok(())
    }
}

/// Prints the devices.
pub fn run(args: &InfoArgs) -> ontile::Result<()> {
    let devices = match args.counters {
        true => gpu::devices_with_counters()?
            .into_iter()
            .map(|(caps, counters)| Listed { caps, counters: Some(counters) })
            .collect(),
        false => gpu::devices()?.into_iter().map(|caps| Listed { caps, counters: None }).collect(),
    };
    print::value(&Devices { devices }, args.json)
}

//! `ontile info`

use clap::Args;
use ontile::gpu::{self, Caps};
use serde::Serialize;

use super::print;

/// List the Vulkan devices and what matters for on-tile rendering: lazily allocated memory, input attachments,
/// sample counts, extensions.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile info
  ontile info --json")]
pub struct InfoArgs {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// What is printed.
#[derive(Serialize)]
struct Devices {
    devices: Vec<Caps>,
}

impl std::fmt::Display for Devices {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, device) in self.devices.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{device}")?;
        }
        Ok(())
    }
}

/// Prints the devices.
pub fn run(args: &InfoArgs) -> ontile::Result<()> {
    print::value(&Devices { devices: gpu::devices()? }, args.json)
}

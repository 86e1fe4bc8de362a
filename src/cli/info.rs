//! `ontile info`

use clap::Args;

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

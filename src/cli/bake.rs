//! `ontile bake`

use clap::{Args, Subcommand};
use ontile::Result;

use super::bake_environment::{self, EnvironmentArgs};

/// Compute light ahead, once, so that frames need not.
#[derive(Args, Debug)]
pub struct BakeArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Environment(EnvironmentArgs),
}

/// Bakes and writes.
pub fn run(args: &BakeArgs) -> Result<()> {
    match &args.what {
        What::Environment(args) => bake_environment::run(args),
    }
}

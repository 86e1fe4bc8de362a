//! Makes the scenes in `assets/` and, on request, scenes to measure with. The same bytes on every run.
//!
//! `make_scenes [NAME...] [-o DIRECTORY] [--check]` and `make_scenes bench --lights N --objects M -o FILE`;
//! `--help` tells more.

pub mod bench;
pub mod canyon;
mod chapel;
mod charmer;
mod courtyard;
mod decals;
mod glass;
mod glb;
mod grid;
mod interior;
mod lamps;
mod mesh;
mod model;
mod noise;
mod pool;
mod program;
mod shape;
mod stop;
mod texture;
mod unlit;

pub use program::{Arguments, Shipped, check, run};

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("make_scenes: {problem}");
            ExitCode::FAILURE
        }
    }
}

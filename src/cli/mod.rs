//! The command line: what was typed, done and told.

mod args;
mod auto;
mod bake;
mod bake_environment;
mod chart;
mod compare;
mod info;
mod model;
mod output;
mod plan;
mod print;
mod progress;
mod render;
mod scene;
mod stability;
#[cfg(feature = "view")]
mod view;
mod wanted_layout;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Deferred shading that never leaves the tile: G-buffer, lighting and tonemap in one Vulkan render pass.
#[derive(Debug, Parser)]
#[command(name = "ontile", version, arg_required_else_help = true, after_help = EXIT_STATUS)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_STATUS: &str = "\
Exit status: 0 done, 1 failed with one message on standard error, 2 wrong usage.
'ontile COMMAND --help' explains a command and gives examples.";

#[derive(Debug, Subcommand)]
enum Command {
    Render(render::RenderArgs),
    Plan(plan::PlanCommandArgs),
    Info(info::InfoArgs),
    Compare(compare::CompareArgs),
    Chart(chart::ChartArgs),
    Model(model::ModelArgs),
    Bake(bake::BakeArgs),
    Stability(stability::StabilityArgs),
    #[cfg(feature = "view")]
    View(view::ViewArgs),
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(usage) => {
            // Help, version or a usage error; nobody is left to tell if it cannot be printed.
            let _ = usage.print();
            return ExitCode::from(usage.exit_code() as u8);
        }
    };
    let done = match &cli.command {
        Command::Render(args) => render::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Info(args) => info::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Chart(args) => chart::run(args),
        Command::Model(args) => model::run(args),
        Command::Bake(args) => bake::run(args),
        Command::Stability(args) => stability::run(args),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print::error(&error);
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests;

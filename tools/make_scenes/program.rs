//! The command line: which scenes are made, and whether they are written or compared.

use super::{
    bench, canyon, chapel, charmer, courtyard, decals, glass, grid, interior, lamps, pool, stop, unlit,
};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Makes the scenes in assets/, or a scene to measure with.
#[derive(Parser)]
#[command(name = "make_scenes", args_conflicts_with_subcommands = true)]
pub struct Arguments {
    /// Scenes to make [default: all]
    names: Vec<Shipped>,
    /// The folder they are in
    #[arg(short, long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/assets"))]
    output: PathBuf,
    /// Compare with the files that are there instead of writing; exit status 1 lists those that differ
    #[arg(long)]
    check: bool,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Make a scene to measure with: objects on a floor of 24 m by 24 m under coloured point lights
    Bench(Bench),
    /// Make an exterior to measure with: a canyon of four large meshes under the sun
    Canyon {
        /// The file to write
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
    },
}

#[derive(Args)]
struct Bench {
    /// Point lights
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=65536))]
    lights: u32,
    /// Spheres and boxes
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(0..=65536))]
    objects: u32,
    /// Where each light ends
    #[arg(long = "range", value_name = "METRES", default_value_t = 4.0, value_parser = positive)]
    range_m: f32,
    /// Grow the file to about this size (10^6 bytes) with textures of noise
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=2000))]
    megabytes: u32,
    /// Give every object a material of its own
    #[arg(long)]
    distinct: bool,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// A scene of `assets/`.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Shipped {
    /// A corner of a chapel under one light of each kind
    Chapel,
    /// A snake, a ball and a lantern that move
    Charmer,
    /// A walled courtyard at dusk
    Courtyard,
    /// A corner of a workshop that decals make look used
    Decals,
    /// Coloured panes and bottles of glass before a lamp
    Glass,
    /// Spheres from plastic to metal, from glossy to matt
    Grid,
    /// A generator hall at night
    Interior,
    /// A still life of things that glow
    Lamps,
    /// A tram stop at dusk: everything at once
    Stop,
    /// A pool of water beside a fire, with steam and sparks
    Pool,
    /// A poster and solids that no light touches
    Unlit,
}

impl Shipped {
    /// The scene's file name.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Chapel => "chapel.glb",
            Self::Charmer => "charmer.glb",
            Self::Courtyard => "courtyard.glb",
            Self::Decals => "decals.glb",
            Self::Glass => "glass.glb",
            Self::Grid => "grid.glb",
            Self::Interior => "interior.glb",
            Self::Lamps => "lamps.glb",
            Self::Stop => "stop.glb",
            Self::Pool => "pool.glb",
            Self::Unlit => "unlit.glb",
        }
    }

    /// The file's bytes.
    pub fn glb(self) -> Vec<u8> {
        match self {
            Self::Chapel => chapel::glb(),
            Self::Charmer => charmer::glb(),
            Self::Courtyard => courtyard::glb(),
            Self::Decals => decals::glb(),
            Self::Glass => glass::glb(),
            Self::Grid => grid::glb(),
            Self::Interior => interior::glb(),
            Self::Lamps => lamps::glb(),
            Self::Stop => stop::glb(),
            Self::Pool => pool::glb(),
            Self::Unlit => unlit::glb(),
        }
    }

    /// Its files, names and bytes: [`Self::glb`] and what that names.
    fn files(self) -> Vec<(&'static str, Vec<u8>)> {
        let sky = (self == Self::Stop).then(|| (stop::SKY, stop::sky()));
        std::iter::once((self.file_name(), self.glb())).chain(sky).collect()
    }
}

/// Does what the command line asks for, or tells in one line what went wrong.
pub fn run(arguments: &Arguments) -> Result<(), String> {
    match &arguments.command {
        Some(Command::Bench(options)) => {
            let path = &options.output;
            let options = bench::Options {
                lights: options.lights as usize,
                objects: options.objects as usize,
                range_m: options.range_m,
                padding_bytes: options.megabytes as usize * 1_000_000,
                distinct: options.distinct,
            };
            return write(path, &bench::glb(&options));
        }
        Some(Command::Canyon { output }) => return write(output, &canyon::glb()),
        None => {}
    }
    let all = Shipped::value_variants();
    let names = if arguments.names.is_empty() { all } else { &arguments.names };
    if arguments.check {
        let differing = check(names, &arguments.output)?;
        if differing.is_empty() {
            return Ok(());
        }
        let directory = arguments.output.display();
        let list = differing.join(", ");
        return Err(format!("{directory}: {list} differ from what this program makes; run tools/scenes"));
    }
    let files = names.iter().flat_map(|name| name.files());
    files.into_iter().try_for_each(|(name, bytes)| write(&arguments.output.join(name), &bytes))
}

/// File names of those scenes that are not, byte for byte, in `directory`; absent files are among them.
pub fn check(names: &[Shipped], directory: &Path) -> Result<Vec<&'static str>, String> {
    let mut differing = Vec::new();
    for (name, bytes) in names.iter().flat_map(|name| name.files()) {
        let path = directory.join(name);
        let found = match fs::read(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            other => Some(other.map_err(|error| format!("{}: {error}", path.display()))?),
        };
        if found.as_deref() != Some(&bytes) {
            differing.push(name);
        }
    }
    Ok(differing)
}

/// Writes a whole file or leaves what was there.
fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let in_path = |error: std::io::Error| format!("{}: {error}", path.display());
    if let Some(directory) = path.parent() {
        fs::create_dir_all(directory).map_err(in_path)?;
    }
    let temporary = path.with_extension("part");
    fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path)).map_err(|error| {
        // What could not be written is of no use; that it cannot be removed either says nothing new.
        let _ = fs::remove_file(&temporary);
        in_path(error)
    })
}

fn positive(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f32::is_finite(x) => Ok(x),
        _ => Err("a positive number is wanted".into()),
    }
}

//! `ontile bake`

use std::path::PathBuf;

use clap::{Args, Subcommand};
use ontile::glam::Vec3;
use ontile::lightmap::{self, Density, Settings};
use ontile::{Error, Result};

use super::args::FarArgs;
use super::bake_environment::{self, EnvironmentArgs};
use super::progress::Progress;
use super::{args, output, print, scene};

/// Compute light ahead, once, so that frames need not.
#[derive(Args, Debug)]
pub struct BakeArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Lightmap(LightmapArgs),
    Environment(EnvironmentArgs),
}

/// Put the diffuse light of everything that does not move into a lightmap, in a copy of the scene.
///
/// Traces paths on the CPU: direct light with shadows, emissive and unlit surfaces, light from all around, and what surfaces
/// reflect on each other. The result is the same on every machine. Lights whose node's extras say
/// {"ontile": {"dynamic": true}} are left out and go on shining; the others are marked "baked" and shine no more. Nodes with
/// "dynamic" or "lightmap": false get no part of the map. A mesh's TEXCOORD_1 is used if its triangles lie side by side in
/// 0 to 1, and made where it is missing.
///
/// Baked lights give diffuse light only: no highlights. An environment that is named here lights the map, but is not put into
/// the file: name it again when rendering, for what surfaces reflect of it.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile bake lightmap room.glb -o room.baked.glb
  ontile bake lightmap room.glb -o room.baked.glb --texels-per-metre 20 --samples 1024 --bounces 6
  ontile bake lightmap room.glb -o room.baked.glb --environment sky.hdr")]
pub struct LightmapArgs {
    /// The scene: a glTF 2.0 file, .gltf or .glb
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// The file to write: a copy of the scene with the lightmap in it
    #[arg(short, long, value_name = "OUT.glb")]
    pub output: PathBuf,
    /// The lightmap's width and height in texels, at most; surfaces get as many texels as fit
    #[arg(long, value_name = "TEXELS", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=4096), allow_negative_numbers = true)]
    pub size: u32,
    /// Texels along a metre of surface; the lightmap gets as large as it takes, up to 4096x4096 [default: as --size allows]
    #[arg(long, value_name = "N", value_parser = density, allow_negative_numbers = true, conflicts_with = "size")]
    pub texels_per_metre: Option<f64>,
    /// Paths traced for each texel; four times as many halve the noise
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=1 << 20), allow_negative_numbers = true)]
    pub samples: u32,
    /// How often light is reflected before it arrives; 0 is direct light only
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(0..=1000), allow_negative_numbers = true)]
    pub bounces: u32,
    /// Light from every direction alike, in cd/m² [default: none]
    #[arg(long, value_name = "RADIANCE", value_parser = args::radiance, allow_negative_numbers = true)]
    pub ambient: Option<f32>,
    #[command(flatten)]
    pub far: FarArgs,
}

/// Bakes and writes.
pub fn run(args: &BakeArgs) -> Result<()> {
    match &args.what {
        What::Lightmap(args) => bake_lightmap(args),
        What::Environment(args) => bake_environment::run(args),
    }
}

fn bake_lightmap(args: &LightmapArgs) -> Result<()> {
    if args.output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("glb")) {
        return Err(Error::unsupported(
            format!("{}: a baked scene is written as GLB", args.output.display()),
            "give the output a name that ends in .glb",
        ));
    }
    output::check(&args.output, &[&args.scene])?;
    let progress = Progress::of(format!("unwrapping {}", args.scene.display()));
    let density = args.texels_per_metre.map_or(Density::Side(args.size), Density::TexelsPerMetre);
    let mut prepared = lightmap::prepare(&args.scene, density)?;
    drop(progress);
    prepared.scene.ambient_nt = Vec3::splat(args.ambient.unwrap_or(0.0));
    scene::read_environment(&mut prepared.scene, &args.far)?;
    for warning in &prepared.scene.warnings {
        print::warning(warning);
    }
    let settings = Settings { size: prepared.size, samples: args.samples, bounces: args.bounces };
    let progress = Progress::of_steps("tracing paths", prepared.size[1].into());
    let baked = lightmap::bake(&prepared.scene, &settings, || progress.step())
        .map_err(|e| scene::about(&args.scene, e))?;
    drop(progress);
    let [width, height] = prepared.size;
    let done = Done { width, height, texels_per_metre: prepared.texels_per_metre };
    prepared.write(&baked, &args.output)?;
    print::value(&done, false)
}

/// What was made.
#[derive(serde::Serialize)]
struct Done {
    width: u32,
    height: u32,
    texels_per_metre: f64,
}

impl std::fmt::Display for Done {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { width, height, texels_per_metre } = self;
        write!(f, "lightmap of {width}x{height} texels, {texels_per_metre:.3} texels a metre")
    }
}

fn density(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(density) if density > 0.0 && density.is_finite() => Ok(density),
        _ => Err("give a number of texels above 0".into()),
    }
}

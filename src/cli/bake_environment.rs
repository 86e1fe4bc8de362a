//! `ontile bake environment`

use std::path::PathBuf;

use clap::Args;
use ontile::environment::{self, Content, DEFAULT_FACE_SIZE, FACE_SIZES, Prefiltered, TexelFormat};
use ontile::{Error, Result};

use super::args::named;
use super::output;
use super::progress::Progress;

/// Filter a panorama into what shading looks up of it.
///
/// Writes a KTX 2.0 cube map, one level for each roughness from 0 (the largest) to 1, with the spherical harmonics of diffuse
/// light in its metadata. '--environment' and scenes take the file in the panorama's place. The result is the same on every
/// machine; 'ontile render' makes the same by itself and keeps it in the user's cache.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile bake environment sky.hdr -o sky.ktx2
  ontile bake environment sky.exr -o sky.ktx2 --size 128 --environment-format rgbm")]
pub struct EnvironmentArgs {
    /// The panorama: an equirectangular .hdr or .exr picture of radiance in cd/m², at most 8192 columns wide
    #[arg(value_name = "FILE")]
    pub panorama: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "OUT.ktx2")]
    pub output: PathBuf,
    /// Texels along the edge of a face, for roughness 0: a power of two
    #[arg(long, value_name = "TEXELS", default_value_t = DEFAULT_FACE_SIZE, value_parser = face_size, allow_negative_numbers = true)]
    pub size: u32,
    /// How radiance is stored: rgbm, b10g11r11 and e5b9g9r9 take 4 bytes a texel, rgba16f 8
    #[arg(long, value_name = "NAME", default_value_t = TexelFormat::E5B9G9R9, value_parser = named(TexelFormat::ALL, TexelFormat::name))]
    pub environment_format: TexelFormat,
}

/// Filters and writes.
pub fn run(args: &EnvironmentArgs) -> Result<()> {
    let path = &args.panorama;
    if args.output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("ktx2")) {
        return Err(Error::unsupported(
            format!("{}: a filtered environment is written as KTX 2.0", args.output.display()),
            "give the output a name that ends in .ktx2",
        ));
    }
    output::check(&args.output, &[path])?;
    let _progress = Progress::of(format!("filtering {}", path.display()));
    match environment::read(path)? {
        Content::Panorama(panorama) => {
            Prefiltered::new(&panorama, args.size, args.environment_format).write(&args.output)
        }
        Content::Prefiltered(_) => Err(Error::input(
            path,
            "environment",
            "was filtered already",
            "give the panorama that it was made of",
        )),
    }
}

fn face_size(text: &str) -> Result<u32, String> {
    let (least, most) = FACE_SIZES.into_inner();
    match text.parse::<u32>() {
        Ok(size) if size.is_power_of_two() && FACE_SIZES.contains(&size) => Ok(size),
        _ => Err(format!("give a power of two from {least} to {most}")),
    }
}

//! `ontile compare`

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use ontile::Result;
use ontile::measure::{compare, false_color};
use ontile::picture::{FileFormat, Picture};

use super::{output, print};

/// Say how far picture B is from the reference A.
///
/// Prints the maximum and mean difference of each channel (in steps of 1/255 for 8-bit pictures, in linear light
/// for floats), how many pixels differ, the mean squared error, PSNR and SSIM; what an eye sees of it (FLIP, and the
/// colour difference CIEDE2000); and for floats the largest relative error and the one that 95 % of the values stay
/// below. Reads PNG, JPEG and OpenEXR; both must be of one size and kind.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile compare golden.png now.png
  ontile compare truth.exr now.exr --json
  ontile compare golden.png now.png --mask object.png --picture where.png

Pictures that differ are no failure: the exit status is 0 whenever they could be compared.")]
pub struct CompareArgs {
    /// The reference picture
    #[arg(value_name = "A")]
    reference: PathBuf,
    /// The picture to judge
    #[arg(value_name = "B")]
    judged: PathBuf,
    /// Print JSON; "psnr_db" is null where it is not finite, as for identical pictures
    #[arg(long)]
    json: bool,
    /// Count only pixels where this picture is not black [default: count all]
    #[arg(long, value_name = "FILE")]
    mask: Option<PathBuf>,
    /// Write where they differ as a false-colour PNG: nearly black for equal, pale yellow for the largest
    /// difference, cyan for NaN or infinity [default: none]
    #[arg(long, value_name = "OUT.png", value_parser = PathBufValueParser::new().try_map(png))]
    picture: Option<PathBuf>,
}

fn png(path: PathBuf) -> Result<PathBuf, String> {
    match FileFormat::from_path(&path) {
        Ok(FileFormat::Png) => Ok(path),
        _ => Err("the false-colour picture is a PNG: name it .png".into()),
    }
}

pub fn run(args: &CompareArgs) -> Result<()> {
    if let Some(path) = &args.picture {
        let read = [Some(&args.reference), Some(&args.judged), args.mask.as_ref()];
        let read: Vec<_> = read.into_iter().flatten().map(PathBuf::as_path).collect();
        output::check(path, &read)?;
    }
    let a = Picture::read(&args.reference)?;
    let b = Picture::read(&args.judged)?;
    let mask = args.mask.as_deref().map(Picture::read).transpose()?;
    let comparison = compare(&a, &b, mask.as_ref())?;
    if let Some(path) = &args.picture {
        false_color(&a, &b, mask.as_ref())?.write(path)?;
    }
    print::value(&comparison, args.json)
}

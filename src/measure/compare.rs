//! All figures about the difference of two pictures.

use std::fmt;

use glam::DVec3;
use image::{GrayImage, imageops};
use image_compare::Algorithm;
use rayon::prelude::*;
use serde::Serialize;

use super::flip::{PIXELS_PER_DEGREE, flip};
use super::metrics::{ErrorStats, percentile, psnr_db, relative_error};
use super::pairs::{Difference, Pairs};
use super::{ciede2000, lab_from_linear};
use crate::Result;
use crate::picture::{Picture, Pixels};

/// The channels, in order.
const CHANNELS: [&str; 4] = ["red", "green", "blue", "alpha"];

/// The linear value of the first step of 8-bit sRGB: darker references are as good as black to a viewer at
/// exposure 0, so relative errors take at least this as the whole.
pub const RELATIVE_FLOOR: f64 = 1.0 / (255.0 * 12.92);

/// The width and height of the windows in which the crate `image-compare` takes SSIM.
const SSIM_WINDOW_PX: u32 = 8;

/// How far picture `b` is from the reference `a`; see [`compare`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Of both pictures, in pixels.
    pub width: u32,
    /// Of both pictures, in pixels.
    pub height: u32,
    /// What `max`, `mean` and `peak` are measured in.
    pub unit: Unit,
    /// No compared pixel differs in any channel.
    pub identical: bool,
    /// Pixels that the mask lets count; all without one.
    pub compared_pixels: usize,
    /// Of those, how many differ in any channel.
    pub differing_pixels: usize,
    /// Of those, how many have a NaN or infinity that the other picture has not. All that follows leaves them
    /// out.
    pub non_finite_pixels: usize,
    /// Each channel by itself.
    pub channels: [ChannelError; 4],
    /// Red, green and blue together. So are the figures below: an alpha of 1 everywhere would flatter them.
    pub color: ChannelError,
    /// Mean squared difference.
    pub mse: f64,
    /// The signal that `psnr_db` compares with: 255 for 8 bits, else the largest value of the reference.
    pub peak: f64,
    /// Peak signal-to-noise ratio; `None` where it is not finite: equal colours, or a reference that is black.
    pub psnr_db: Option<f64>,
    /// The relative error that 95 % of the colour values do not exceed; only for floats. Where the reference is
    /// below the first step of 8-bit sRGB, 1 / (255 * 12.92), the error is relative to that.
    pub relative_error_p95: Option<f64>,
    /// The largest relative error of all colour values, by the same floor; only for floats.
    pub relative_error_max: Option<f64>,
    /// The mean of [`flip`] over the pixels that count, seen at [`PIXELS_PER_DEGREE`]; floats are clamped to what a display
    /// shows. 0 is equal, 1 the most.
    pub flip_mean: f64,
    /// The colour difference [`ciede2000`] that 95 % of the pixels do not exceed, floats clamped in the same way.
    pub ciede2000_p95: f64,
    /// The largest of them.
    pub ciede2000_max: f64,
    /// Structural similarity (Wang et al. 2004) of the 8-bit sRGB pictures as the crate `image-compare` has it:
    /// windows of 8x8 pixels that do not overlap, the worst of red, green and blue; 1 is equal. It takes sums for
    /// the paper's variances, which makes it stricter than others in smooth areas.
    pub ssim: f64,
}

/// A channel's difference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelError {
    /// `red`, `green`, `blue`, `alpha` or `color`.
    pub name: &'static str,
    /// Largest absolute difference.
    pub max: f64,
    /// Mean absolute difference.
    pub mean: f64,
}

impl ChannelError {
    fn new(name: &'static str, stats: &ErrorStats) -> Self {
        Self { name, max: stats.max(), mean: stats.mean() }
    }
}

impl fmt::Display for Comparison {
    /// A table to read.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = 100.0 * self.differing_pixels as f64 / self.compared_pixels as f64;
        writeln!(f, "{:<12}{}x{}, {} compared", "pixels", self.width, self.height, self.compared_pixels)?;
        writeln!(f, "{:<12}{} ({share:.3} %)", "differ", self.differing_pixels)?;
        if self.non_finite_pixels > 0 {
            writeln!(f, "{:<12}{} (left out of the figures below)", "non-finite", self.non_finite_pixels)?;
        }
        writeln!(f, "{:<12}{:>12} {:>12}  ({})", "", "max", "mean", self.unit)?;
        for error in self.channels.iter().chain([&self.color]) {
            writeln!(f, "{:<12}{:>12.6} {:>12.6}", error.name, error.max, error.mean)?;
        }
        writeln!(f, "{:<12}{:.6e}", "MSE", self.mse)?;
        match self.psnr_db {
            Some(db) => writeln!(f, "{:<12}{db:.2} dB (peak {})", "PSNR", self.peak)?,
            None if self.identical => writeln!(f, "{:<12}identical", "PSNR")?,
            None if self.mse == 0.0 => writeln!(f, "{:<12}infinite: no finite colour differs", "PSNR")?,
            None => writeln!(f, "{:<12}undefined: the reference is black", "PSNR")?,
        }
        if let Some(error) = self.relative_error_p95 {
            let max = self.relative_error_max.unwrap_or(f64::NAN);
            writeln!(f, "{:<12}{error:.6} (95th percentile), {max:.6} (max)", "relative")?;
        }
        writeln!(f, "{:<12}{:.6} (mean)", "FLIP", self.flip_mean)?;
        let (p95, max) = (self.ciede2000_p95, self.ciede2000_max);
        writeln!(f, "{:<12}{p95:.4} (95th percentile), {max:.4} (max)", "CIEDE2000")?;
        write!(f, "{:<12}{:.6}", "SSIM", self.ssim)
    }
}

/// What differences are measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Unit {
    /// Steps of sRGB-encoded 8-bit channels.
    #[serde(rename = "8-bit steps")]
    Steps8Bit,
    /// Linear light.
    #[serde(rename = "linear")]
    Linear,
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Steps8Bit => "8-bit steps",
            Self::Linear => "linear",
        })
    }
}

/// Compares `b` with the reference `a`. With a mask, only pixels where it is not black count: a background that
/// is equal in both flatters every mean.
///
/// # Errors
/// [`crate::Error::Unsupported`] if the pictures (or the mask) differ in size, if one has 8 bits and the other floats,
/// or if no pixel counts.
pub fn compare(a: &Picture, b: &Picture, mask: Option<&Picture>) -> Result<Comparison> {
    let pairs = Pairs::new(a, b, mask)?;
    let unit = match a.pixels {
        Pixels::Rgba8(_) => Unit::Steps8Bit,
        Pixels::Rgba32F(_) => Unit::Linear,
    };
    let (mut compared_pixels, mut differing_pixels, mut non_finite_pixels) = (0, 0, 0);
    let mut stats = [ErrorStats::default(); 4];
    let mut largest: f64 = 0.0;
    let mut relative = Vec::new();
    for i in pairs.counted() {
        compared_pixels += 1;
        match pairs.difference(i) {
            Difference::Finite(difference) => differing_pixels += usize::from(difference > 0.0),
            Difference::NonFinite => {
                differing_pixels += 1;
                non_finite_pixels += 1;
                continue;
            }
        }
        let (a, b) = pairs.get(i);
        for c in 0..4 {
            // Infinite or NaN here means the same in both.
            let (a, b) = if a[c].is_finite() { (a[c], b[c]) } else { (0.0, 0.0) };
            stats[c].add(a, b);
            if c < 3 {
                largest = largest.max(a);
                if unit == Unit::Linear {
                    relative.push(relative_error(a, b, RELATIVE_FLOOR));
                }
            }
        }
    }
    let displays = [a, b].map(display_light);
    let [shown_a, shown_b] = displays.each_ref();
    let errors = flip(shown_a, shown_b, [a.width, a.height], PIXELS_PER_DEGREE);
    let (mut flips, mut ciede) = (ErrorStats::default(), Vec::new());
    let finite = |&i: &usize| pairs.difference(i).finite().is_some();
    for i in pairs.counted().filter(finite) {
        flips.add(errors[i], 0.0);
        ciede.push(ciede2000(lab_from_linear(shown_a[i]), lab_from_linear(shown_b[i])));
    }
    let color = stats[0].union(stats[1]).union(stats[2]);
    let peak = if unit == Unit::Steps8Bit { 255.0 } else { largest };
    Ok(Comparison {
        width: a.width,
        height: a.height,
        unit,
        identical: differing_pixels == 0,
        compared_pixels,
        differing_pixels,
        non_finite_pixels,
        channels: std::array::from_fn(|c| ChannelError::new(CHANNELS[c], &stats[c])),
        color: ChannelError::new("color", &color),
        mse: color.mse(),
        peak,
        psnr_db: Some(psnr_db(color.mse(), peak)).filter(|db| db.is_finite()),
        relative_error_p95: percentile(&mut relative, 0.95),
        relative_error_max: percentile(&mut relative, 1.0),
        flip_mean: flips.mean(),
        ciede2000_p95: percentile(&mut ciede, 0.95).unwrap_or(0.0),
        ciede2000_max: percentile(&mut ciede, 1.0).unwrap_or(0.0),
        ssim: ssim(a, b, &pairs),
    })
}

/// Linear light as a display shows it: from 0 to 1, not a number as black.
fn display_light(picture: &Picture) -> Vec<DVec3> {
    let Pixels::Rgba32F(channels) = picture.to_linear().pixels else { unreachable!("converted to floats") };
    let shown = |c: f32| if c.is_nan() { 0.0 } else { f64::from(c).clamp(0.0, 1.0) };
    channels.chunks_exact(4).map(|p| DVec3::new(shown(p[0]), shown(p[1]), shown(p[2]))).collect()
}

/// See [`Comparison::ssim`]: for each channel, the mean over the pixels that count of their windows' similarity.
fn ssim(a: &Picture, b: &Picture, pairs: &Pairs) -> f64 {
    let starts = |length: u32| (0..length).step_by(SSIM_WINDOW_PX as usize);
    let windows: Vec<_> = starts(a.height).flat_map(|y| starts(a.width).map(move |x| (x, y))).collect();
    let (images_a, images_b) = (channel_images(a), channel_images(b));
    let (weighted, weight) = windows
        .into_par_iter()
        .map(|(x, y)| {
            let width = SSIM_WINDOW_PX.min(a.width - x);
            let height = SSIM_WINDOW_PX.min(a.height - y);
            let index = |x: u32, y: u32| y as usize * a.width as usize + x as usize;
            let pixels = (y..y + height).flat_map(|y| (x..x + width).map(move |x| index(x, y)));
            let weight = pixels.filter(|&i| pairs.counts(i)).count() as f64;
            let similarity = |c: usize| {
                let window = |image: &GrayImage| imageops::crop_imm(image, x, y, width, height).to_image();
                let (a, b) = (window(&images_a[c]), window(&images_b[c]));
                let similarity = image_compare::gray_similarity_structure(&Algorithm::MSSIMSimple, &a, &b);
                similarity.expect("windows of one size").score
            };
            let weighted = if weight > 0.0 { [0, 1, 2].map(|c| weight * similarity(c)) } else { [0.0; 3] };
            (weighted, weight)
        })
        .reduce(
            || ([0.0; 3], 0.0),
            |(s, weight), (t, other)| (std::array::from_fn(|c| s[c] + t[c]), weight + other),
        );
    weighted.into_iter().fold(f64::INFINITY, f64::min) / weight
}

/// Red, green and blue by themselves, in 8-bit sRGB.
fn channel_images(picture: &Picture) -> [GrayImage; 3] {
    let Pixels::Rgba8(channels) = picture.to_srgb8().pixels else { unreachable!("converted to 8 bits") };
    std::array::from_fn(|c| {
        let channel = channels.iter().skip(c).step_by(4).copied().collect();
        GrayImage::from_raw(picture.width, picture.height, channel).expect("four values for every pixel")
    })
}

#[cfg(test)]
mod tests;

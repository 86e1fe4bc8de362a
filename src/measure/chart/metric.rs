//! The charts' axes: four errors and two costs.

use serde::{Deserialize, Serialize};

use super::data::{Errors, Measured};
use crate::plan::named_enum;

named_enum! {
    /// An error by which G-buffers are compared.
    Metric {
        /// FLIP, the mean over the picture.
        Flip = "flip",
        /// Peak signal-to-noise ratio, dB: more is better.
        Psnr = "psnr",
        /// CIEDE2000, 95th percentile.
        Ciede = "ciede",
        /// The largest relative error of linear light.
        Relative = "relative",
    }
}

impl Metric {
    /// Its figure.
    pub fn of(self, errors: &Errors) -> f64 {
        match self {
            Self::Psnr => errors.psnr_db.unwrap_or(f64::INFINITY),
            Self::Flip => errors.flip,
            Self::Ciede => errors.ciede2000_p95,
            Self::Relative => errors.relative_max,
        }
    }

    /// The figure so that less is better.
    pub fn badness(self, errors: &Errors) -> f64 {
        if self == Self::Psnr { -self.of(errors) } else { self.of(errors) }
    }

    /// In words, with the unit.
    pub fn label(self) -> &'static str {
        match self {
            Self::Psnr => "PSNR, dB (more is better)",
            Self::Flip => "FLIP, mean",
            Self::Ciede => "CIEDE2000, 95th percentile",
            Self::Relative => "relative error of linear light, maximum",
        }
    }
}

/// What a G-buffer costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Of a frame, median.
    Time,
    /// On the tile, a pixel.
    Bytes,
}

impl Cost {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Time, Self::Bytes];

    /// Its figure, and the quartiles of one that varies. Times are ratios to the base's frames of the same rounds times
    /// `base_ms`, so that what the machine did in other races counts for nothing.
    pub fn of(self, measured: &Measured, base_ms: f64) -> (f64, Option<[f64; 2]>) {
        let ratio = measured.ratio;
        match self {
            Self::Time => (
                ratio.median * base_ms,
                Some([ratio.first_quartile, ratio.third_quartile].map(|r| r * base_ms)),
            ),
            Self::Bytes => (f64::from(measured.bytes.on_tile), None),
        }
    }

    /// As file names have it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Bytes => "bytes",
        }
    }
}

/// The points that no other beats in one direction without losing in the other, by index, in order of the first: both are
/// to be small. Of equal points the first stays.
pub fn pareto(points: &[[f64; 2]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&i, &j| points[i][0].total_cmp(&points[j][0]).then(points[i][1].total_cmp(&points[j][1])));
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i][1] < least;
        least = least.min(points[i][1]);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [[3.0, 1.0], [1.0, 3.0], [2.0, 3.0], [2.0, 2.0], [2.0, 2.0], [4.0, 1.0], [5.0, 0.5]];
        assert_eq!(pareto(&points), [1, 3, 0, 6]);
        assert_eq!(pareto(&[]), [0; 0]);
    }
}

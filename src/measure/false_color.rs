//! Differences made visible.

use crate::Result;
use crate::picture::{Picture, Pixels};

use super::pairs::{Difference, Pairs};

/// Marks pixels that differ by a NaN or an infinity: a colour that [`magma`] does not contain.
pub const NON_FINITE_RGB: [u8; 3] = [0, 255, 255];

/// Where and how much two pictures differ: an opaque 8-bit picture of their size.
///
/// A pixel's difference is the largest absolute one of its four channels, in the pictures' own values. The
/// largest of all pixels is the top of [`magma`], no difference its bottom; two equal pictures give the bottom
/// everywhere. Pixels that `mask` leaves out are at the bottom and do not set the scale.
///
/// # Errors
/// As `compare`.
pub fn false_color(a: &Picture, b: &Picture, mask: Option<&Picture>) -> Result<Picture> {
    let pairs = Pairs::new(a, b, mask)?;
    let max = pairs.counted().filter_map(|i| pairs.difference(i).finite()).fold(0.0, f64::max);
    let color = |i: usize| match pairs.difference(i) {
        _ if !pairs.counts(i) => magma(0.0),
        Difference::NonFinite => NON_FINITE_RGB,
        Difference::Finite(0.0) => magma(0.0),
        Difference::Finite(difference) => magma(difference / max),
    };
    let channels = (0..pairs.len()).map(color).flat_map(|[r, g, b]| [r, g, b, 255]).collect();
    Ok(Picture { width: a.width, height: a.height, pixels: Pixels::Rgba8(channels) })
}

/// The perceptually uniform colour map "magma" by Smith and van der Walt (2015, matplotlib; the data is CC0), in
/// sRGB: nearly black for 0, through purple and orange, to pale yellow for 1. Linear between nine of its colours.
pub fn magma(share: f64) -> [u8; 3] {
    const COLORS: [[u8; 3]; 9] = [
        [0x00, 0x00, 0x04],
        [0x1d, 0x11, 0x47],
        [0x51, 0x12, 0x7c],
        [0x82, 0x26, 0x81],
        [0xb6, 0x36, 0x79],
        [0xe6, 0x51, 0x64],
        [0xfb, 0x88, 0x61],
        [0xfe, 0xc2, 0x87],
        [0xfc, 0xfd, 0xbf],
    ];
    let position = share.clamp(0.0, 1.0) * (COLORS.len() - 1) as f64;
    let below = (position as usize).min(COLORS.len() - 2);
    let weight = position - below as f64;
    std::array::from_fn(|c| {
        let [from, to] = [COLORS[below][c], COLORS[below + 1][c]].map(f64::from);
        (from + (to - from) * weight).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rgba8(channels: &[[u8; 4]]) -> Picture {
        Picture { width: channels.len() as u32, height: 1, pixels: Pixels::Rgba8(channels.concat()) }
    }

    #[test]
    fn ends_of_the_scale() {
        let a = rgba8(&[[10, 20, 30, 255], [0, 0, 0, 255], [100, 100, 100, 255]]);
        let b = rgba8(&[[10, 20, 30, 255], [0, 20, 0, 255], [100, 90, 95, 255]]);
        // Differences 0, 20, 10 on a scale of 20; half way is the fifth of magma's nine colours.
        let expected = rgba8(&[[0, 0, 4, 255], [252, 253, 191, 255], [182, 54, 121, 255]]);
        assert_eq!(false_color(&a, &b, None).unwrap(), expected);
        assert_eq!(false_color(&a, &a, None).unwrap(), rgba8(&[[0, 0, 4, 255]; 3]));
    }

    #[test]
    fn masked_pixels_do_not_set_the_scale() {
        let a = rgba8(&[[0, 0, 0, 255], [0, 0, 0, 255]]);
        let b = rgba8(&[[2, 0, 0, 255], [200, 0, 0, 255]]);
        let mask = rgba8(&[[255, 255, 255, 255], [0, 0, 0, 255]]);
        let expected = rgba8(&[[252, 253, 191, 255], [0, 0, 4, 255]]);
        assert_eq!(false_color(&a, &b, Some(&mask)).unwrap(), expected);
    }

    #[test]
    fn not_a_number_stands_out() {
        let picture =
            |r: f32| Picture { width: 1, height: 1, pixels: Pixels::Rgba32F(vec![r, 0.0, 0.0, 1.0]) };
        let (number, nan) = (picture(1.0), picture(f32::NAN));
        assert_eq!(false_color(&number, &nan, None).unwrap(), rgba8(&[[0, 255, 255, 255]]));
        assert_eq!(false_color(&nan, &nan, None).unwrap(), rgba8(&[[0, 0, 4, 255]]));
    }

    #[test]
    fn magma_only_gets_brighter() {
        let luma = |[r, g, b]: [u8; 3]| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
        let lumas: Vec<f64> = (0..=64).map(|i| luma(magma(f64::from(i) / 64.0))).collect();
        assert!(lumas.windows(2).all(|w| w[1] > w[0]), "{lumas:?}");
    }
}

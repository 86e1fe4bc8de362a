//! Numbers as formats hold them: Vulkan 1.3, chapter 3, "Fixed-Point Data Conversion" and "Floating-Point Format Conversions",
//! rounding to the nearest code.

use glam::DVec3;

use crate::reference::texture::{linear_from_srgb, srgb_from_linear};

/// The nearest value that `bits` bits of UNORM can hold.
pub fn unorm(value: f64, bits: u32) -> f64 {
    let steps = f64::from((1_u32 << bits) - 1);
    (value.clamp(0.0, 1.0) * steps).round() / steps
}

/// The linear value of the nearest 8-bit sRGB code.
pub fn srgb8(value: f64) -> f64 {
    linear_from_srgb(unorm(srgb_from_linear(value.clamp(0.0, 1.0)), 8))
}

/// The nearest f32.
pub fn float32(value: f64) -> f64 {
    f64::from(value as f32)
}

/// The nearest float with five bits of exponent (bias 15) and this many of mantissa; not beyond the greatest finite one.
pub fn small_float(value: f64, mantissa_bits: i32) -> f64 {
    let greatest = 65536.0 - (15 - mantissa_bits).exp2();
    let exponent = (value.abs().max(f64::MIN_POSITIVE).log2().floor() as i32).max(-14);
    let step = (exponent - mantissa_bits).exp2();
    ((value / step).round_ties_even() * step).clamp(-greatest, greatest)
}

/// The nearest half float.
pub fn half(value: f64) -> f64 {
    small_float(value, 10)
}

/// The nearest B10G11R11_UFLOAT.
pub fn b10g11r11(v: DVec3) -> DVec3 {
    let v = v.max(DVec3::ZERO);
    DVec3::new(small_float(v.x, 6), small_float(v.y, 6), small_float(v.z, 5))
}

/// The nearest E5B9G9R9_UFLOAT ("Shared Exponent to RGB").
pub fn e5b9g9r9(v: DVec3) -> DVec3 {
    let v = v.clamp(DVec3::ZERO, DVec3::splat(65408.0));
    let largest = v.max_element();
    let exponent = (largest.max(f64::MIN_POSITIVE).log2().floor() as i32).max(-16) + 1;
    let step = (exponent - 9).exp2();
    let step = if (largest / step).round() == 512.0 { step * 2.0 } else { step };
    (v / step).round() * step
}

trait Exp2 {
    fn exp2(self) -> f64;
}

impl Exp2 for i32 {
    fn exp2(self) -> f64 {
        f64::from(self).exp2()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_vulkans() {
        assert_eq!(unorm(0.5, 8), 128.0 / 255.0);
        assert_eq!(unorm(1.7, 10), 1.0);
        assert_eq!(unorm(-1.0, 10), 0.0);
        assert_eq!(unorm(0.499 / 1023.0, 10), 0.0);
        assert_eq!(unorm(0.501 / 1023.0, 10), 1.0 / 1023.0);
        // Mid grey of 18 % light is sRGB code 118 (117.7 by IEC 61966-2-1).
        assert!((srgb_from_linear(srgb8(0.18)) * 255.0 - 118.0).abs() < 1e-6);
    }

    #[test]
    fn small_floats_are_vulkans() {
        assert_eq!((half(1.0), half(65504.0), half(1e9), half(-2.5)), (1.0, 65504.0, 65504.0, -2.5));
        assert_eq!((half(2049.0), half(2051.0)), (2048.0, 2052.0), "ties to even");
        assert_eq!((half(0.75 * 2f64.powi(-24)), half(0.25 * 2f64.powi(-24))), (2f64.powi(-24), 0.0));
        assert_eq!(
            b10g11r11(DVec3::new(1e9, 1.0 + 1.0 / 64.0, 1.0 + 1.0 / 64.0)).to_array(),
            [65024.0, 1.0 + 1.0 / 64.0, 1.0]
        );
        // Nine bits: of the largest channel's 256 to 511 steps, the smaller ones have the same.
        assert_eq!(
            e5b9g9r9(DVec3::new(1.0, 0.5 / 256.0 + 1e-9, 0.1 / 256.0)).to_array(),
            [1.0, 1.0 / 256.0, 0.0]
        );
        assert_eq!(e5b9g9r9(DVec3::new(511.6, 0.0, 1.0)).to_array(), [512.0, 0.0, 2.0]);
    }
}

//! How radiance is stored in textures.
//!
//! What storage costs, against floats, over look-ups at all directions and roughnesses in a sky with a sun (signal to noise
//! and mean relative error; two photographed panoramas give the same but for RGBM):
//!
//! | format | bits a texel | dB | mean | 99 % within |
//! |---|---|---|---|---|
//! | RGBM | 32 | 12 (20 without a sun) | 5 % | 26 % |
//! | B10G11R11 | 32 | 49 | 0.35 % | 0.9 % |
//! | E5B9G9R9 | 32 | 66 | 0.06 % | 0.13 % |
//! | RGBA16F | 64 | 79 | 0.013 % | 0.03 % |
//!
//! RGBM is right at texel centres; between them it filters factors apart from colours, which is worst beside a sun. So
//! E5B9G9R9 is the default. (`formats_cost_what_they_are_said_to` in `prefiltered` prints the table.)

use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};

use crate::plan::named_enum;

named_enum! {
    /// A texel format for radiance; every Vulkan device samples and filters all of them.
    TexelFormat {
        /// 32 bits: eight of a common factor, eight a channel, both of square roots (Smith and Einig 2015, listing 2.5;
        /// Karis 2009). Filtered as stored, so it is exact at texel centres only.
        Rgbm = "rgbm",
        /// 32 bits: floats of 6, 6 and 5 bits of mantissa.
        B10G11R11 = "b10g11r11",
        /// 32 bits: nine bits of mantissa a channel with one exponent.
        E5B9G9R9 = "e5b9g9r9",
        /// 64 bits: half floats.
        Rgba16F = "rgba16f",
    }
}

/// `RGBM_SCALE` of listing 2.5: the square root of the largest value.
const RGBM_RANGE: f32 = 6.0;

impl TexelFormat {
    /// Bytes of one texel.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Rgbm | Self::B10G11R11 | Self::E5B9G9R9 => 4,
            Self::Rgba16F => 8,
        }
    }

    /// The largest value that every channel can hold.
    pub const fn max(self) -> f32 {
        match self {
            Self::Rgbm => RGBM_RANGE * RGBM_RANGE,
            // Blue has five bits of mantissa, the fewest.
            Self::B10G11R11 => 64512.0,
            Self::E5B9G9R9 => 65408.0,
            Self::Rgba16F => 65504.0,
        }
    }

    /// Stores a value from 0 to [`Self::max`] in each channel, rounded to the nearest.
    pub(crate) fn encode(self, value: Vec3, out: &mut Vec<u8>) {
        let [r, g, b] = value.to_array();
        match self {
            Self::Rgbm => out.extend(encode_rgbm(value)),
            Self::B10G11R11 => {
                let bits = small_float(r, 6) | small_float(g, 6) << 11 | small_float(b, 5) << 22;
                out.extend(bits.to_le_bytes());
            }
            Self::E5B9G9R9 => out.extend(shared_exponent(value).to_le_bytes()),
            Self::Rgba16F => {
                // Nothing reads alpha.
                let halves =
                    [small_float(r, 10), small_float(g, 10), small_float(b, 10), small_float(1.0, 10)];
                out.extend(halves.iter().flat_map(|&h| (h as u16).to_le_bytes()));
            }
        }
    }

    /// What a texture unit makes of a texel before it filters.
    pub(crate) fn load(self, bytes: &[u8]) -> Vec4 {
        let word = || bytes.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte));
        match self {
            Self::Rgbm => Vec4::from_array(std::array::from_fn(|i| f32::from(bytes[i]) / 255.0)),
            Self::B10G11R11 => {
                let bits = word();
                let channels = [(0, 6), (11, 6), (22, 5)];
                let [r, g, b] = channels.map(|(at, mantissa)| from_small_float(bits >> at, mantissa));
                Vec4::new(r, g, b, 1.0)
            }
            Self::E5B9G9R9 => {
                let bits = word();
                let step = f32::exp2((bits >> 27) as f32 - 24.0);
                let channel = |at: u32| (bits >> at & 0x1FF) as f32 * step;
                Vec4::new(channel(0), channel(9), channel(18), 1.0)
            }
            Self::Rgba16F => Vec4::from_array(std::array::from_fn(|i| {
                let bits = u16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]);
                let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
                sign * from_small_float(u32::from(bits), 10)
            })),
        }
    }

    /// What a shader makes of what was filtered: the stored value.
    pub(crate) fn decode(self, filtered: Vec4) -> Vec3 {
        match self {
            Self::Rgbm => {
                let root = filtered.truncate() * (filtered.w * RGBM_RANGE);
                root * root
            }
            _ => filtered.truncate(),
        }
    }
}

/// The smallest factor that the largest channel's root does not exceed, so that the channels have most of their steps.
fn encode_rgbm(value: Vec3) -> [u8; 4] {
    let root = Vec3::from_array(value.to_array().map(f32::sqrt)) / RGBM_RANGE;
    let factor = (root.max_element() * 255.0).ceil().clamp(1.0, 255.0);
    let [r, g, b] = root.to_array().map(|c| (c * 255.0 / factor * 255.0).round() as u8);
    [r, g, b, factor as u8]
}

/// The bits of a float without sign, with five bits of exponent (bias 15) and this many of mantissa, as Vulkan's packed
/// formats and half floats have it. `value` is not negative and at most the format's largest.
pub(super) fn small_float(value: f32, mantissa_bits: u32) -> u32 {
    let exponent = (value.max(f32::MIN_POSITIVE).log2().floor() as i32).max(-14);
    // In steps of the last bit; ties go to even, as the hardware's conversion does. A carry moves on to the next
    // exponent by itself, and subnormals have the exponent's bits zero by the same sum.
    let steps = (value * f32::exp2((mantissa_bits as i32 - exponent) as f32)).round_ties_even() as u32;
    let carried = ((exponent + 14) as u32) << mantissa_bits;
    carried + steps
}

/// Not negative: bits above the exponent are left out.
pub(super) fn from_small_float(bits: u32, mantissa_bits: u32) -> f32 {
    let mantissa = bits & ((1 << mantissa_bits) - 1);
    let exponent = bits >> mantissa_bits & 0x1F;
    match exponent {
        0x1F if mantissa == 0 => f32::INFINITY,
        0x1F => f32::NAN,
        0 => mantissa as f32 * f32::exp2(-14.0 - mantissa_bits as f32),
        _ => {
            (mantissa | 1 << mantissa_bits) as f32 * f32::exp2(exponent as f32 - 15.0 - mantissa_bits as f32)
        }
    }
}

/// Vulkan 1.3, "Shared Exponent to RGB": nine bits of mantissa without hidden bit, exponent bias 15.
fn shared_exponent(value: Vec3) -> u32 {
    let largest = value.max_element();
    let exponent = (largest.max(f32::MIN_POSITIVE).log2().floor() as i32).max(-16) + 16;
    let steps = |value: f32, exponent: i32| (value * f32::exp2((24 - exponent) as f32)).round() as u32;
    // Rounding may reach 2^9, which the next exponent holds.
    let exponent = exponent + i32::from(steps(largest, exponent) == 1 << 9);
    let [r, g, b] = value.to_array().map(|channel| steps(channel, exponent));
    r | g << 9 | b << 18 | (exponent as u32) << 27
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored(format: TexelFormat, value: Vec3) -> Vec3 {
        let mut bytes = Vec::new();
        format.encode(value, &mut bytes);
        assert_eq!(bytes.len(), format.bytes());
        format.decode(format.load(&bytes))
    }

    #[test]
    fn values_come_back_within_half_a_step() {
        // Relative to the largest channel: of 2^-mantissa, half; RGBM's steps of the root count twice, twice.
        let bounds = [
            (TexelFormat::Rgbm, 2.5 / 255.0),
            (TexelFormat::B10G11R11, 0.5 / 32.0),
            (TexelFormat::E5B9G9R9, 0.5 / 256.0),
            (TexelFormat::Rgba16F, 0.5 / 1024.0),
        ];
        for (format, bound) in bounds {
            for i in 0..4000 {
                let brightness = f32::exp2(i as f32 / 4000.0 * 12.0 - 12.0) * format.max();
                let value = Vec3::new(1.0, 0.3 + 0.0001 * i as f32, 0.7) * brightness / 1.0;
                let value = value / value.max_element() * brightness;
                let error = (stored(format, value) - value).abs().max_element();
                assert!(error <= bound * brightness * 1.0001, "{format} {value}: {error}");
            }
            assert_eq!(stored(format, Vec3::ZERO), Vec3::ZERO, "{format}");
            assert_eq!(stored(format, Vec3::splat(format.max())), Vec3::splat(format.max()), "{format}");
        }
    }

    #[test]
    fn small_floats_are_those_of_the_standard() {
        // Half floats with known bits (IEEE 754): 1, the largest, the smallest normal and subnormal, a carry, a tie.
        for (value, bits) in [
            (1.0, 0x3C00),
            (65504.0, 0x7BFF),
            (f32::exp2(-14.0), 0x0400),
            (f32::exp2(-24.0), 0x0001),
            (1.999_9, 0x4000),
            (1.0 + f32::exp2(-11.0), 0x3C00),
            (0.333_251_95, 0x3555),
        ] {
            assert_eq!(small_float(value, 10), bits, "{value}");
        }
        for bits in (0..0x7C00).step_by(7) {
            assert_eq!(small_float(from_small_float(bits, 10), 10), bits);
        }
        assert!(from_small_float(0x7C00, 10).is_infinite() && from_small_float(0x7C01, 10).is_nan());
    }
}

//! What decoded elements go through (KHR_meshopt_compression, appendix B), in place.
//!
//! In f32, in the order of their author's decoder: the bits agree, though the extension would allow a step more or less.

use std::f32::consts::SQRT_2;

/// What is beyond an `i32` (of damaged elements) stays within.
fn round(x: f32) -> i32 {
    x.round_ties_even() as i32
}

/// Four components each, as integers of `stride / 4` bytes.
fn components(bytes: &mut [u8], stride: usize, filter: impl Fn([i32; 4]) -> [i32; 4]) {
    for element in bytes.chunks_exact_mut(stride) {
        if let [a, b, c, d] = *element {
            let new = filter([a, b, c, d].map(|byte| i32::from(byte.cast_signed())));
            element.copy_from_slice(&new.map(|value| value as u8));
            continue;
        }
        let short = |i: usize| i32::from(i16::from_le_bytes([element[i * 2], element[i * 2 + 1]]));
        let new = filter(std::array::from_fn(short));
        for (short, value) in element.chunks_exact_mut(2).zip(new) {
            short.copy_from_slice(&(value as u16).to_le_bytes());
        }
    }
}

pub fn octahedral(bytes: &mut [u8], stride: usize) {
    let most = if stride == 4 { 127.0 } else { 32767.0 };
    components(bytes, stride, |[x, y, one, other]| {
        let [x, y, one] = [x, y, one].map(|value| value as f32);
        let z = one - x.abs() - y.abs();
        let fold = z.min(0.0);
        let unfolded = |v: f32| if v >= 0.0 { v + fold } else { v - fold };
        let (x, y) = (unfolded(x), unfolded(y));
        let scale = most / (x * x + y * y + z * z).sqrt();
        let [x, y, z] = [x, y, z].map(|v| round(v * scale));
        [x, y, z, other]
    });
}

pub fn quaternion(bytes: &mut [u8]) {
    components(bytes, 8, |[x, y, z, one]| {
        let [x, y, z, unit] = [x, y, z, one | 3].map(|value| value as f32);
        // All but the largest component have been multiplied by the square root of 2; here it is too.
        let w = (unit * unit * 2.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let scale = 32767.0 / SQRT_2 / unit;
        let mut out = [0; 4];
        for (i, value) in [w, x, y, z].into_iter().enumerate() {
            out[((one & 3) as usize + i) % 4] = round(value * scale);
        }
        out
    });
}

pub fn exponential(bytes: &mut [u8]) {
    for word in bytes.chunks_exact_mut(4) {
        let code = i32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        let (exponent, mantissa) = (code >> 24, code << 8 >> 8);
        let power = f32::from_bits(((exponent + 127) as u32) << 23);
        word.copy_from_slice(&(power * mantissa as f32).to_le_bytes());
    }
}

pub fn color(bytes: &mut [u8], stride: usize) {
    let (most, mask) = if stride == 4 { (255.0, 0xff) } else { (65535.0, 0xffff) };
    components(bytes, stride, |[luma, orange, green, alpha]| {
        let (luma, alpha) = (luma & mask, alpha & mask);
        let range = (1 << (32 - alpha.leading_zeros())) - 1;
        let alpha = alpha & range >> 1;
        let scale = most / range as f32;
        let rgb = [luma + orange - green, luma + green, luma - orange - green];
        [rgb[0], rgb[1], rgb[2], alpha << 1 | alpha & 1].map(|v| round(v as f32 * scale))
    });
}

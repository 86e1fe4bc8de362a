//! Mip chains, averaged in linear light.
//!
//! A level's texel is the mean of the area it covers in the level above. Where a size is odd, that area takes
//! in parts of texels, which count by their share (so nothing shifts and nothing is dropped). Levels stay in
//! floating point until they are encoded, so rounding does not add up.

use super::Image;
use rayon::prelude::*;

/// One level of a mip chain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MipLevel {
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// `width * height * 4` bytes, encoded as in the image.
    pub rgba8: Vec<u8>,
}

/// The length of a full mip chain, level 0 counted: `1 + floor(log2(max(width, height)))`.
pub fn mip_level_count(width: u32, height: u32) -> u32 {
    1 + width.max(height).max(1).ilog2()
}

/// Levels 1 and up of an image's mip chain, down to 1 x 1; level 0 is the image.
///
/// With `srgb`, red, green and blue are decoded (IEC 61966-2-1) before they are averaged and encoded again;
/// alpha always is linear.
pub fn mipmaps(image: &Image, srgb: bool) -> Vec<MipLevel> {
    let decode = decode_table(srgb);
    let rgba8 = image.rgba8();
    let texel = |i: usize| {
        let t = &rgba8[i * 4..i * 4 + 4];
        [decode[t[0] as usize], decode[t[1] as usize], decode[t[2] as usize], f32::from(t[3]) / 255.0]
    };
    let mut levels = Vec::new();
    let mut size = [image.width, image.height];
    if size == [1, 1] {
        return levels;
    }
    let mut linear = Vec::new();
    while size != [1, 1] {
        let half = size.map(|n| (n / 2).max(1));
        linear = match levels.is_empty() {
            // Level 0 is decoded on the way: a copy in floats would take four times its memory.
            true => reduce(size, half, texel),
            false => reduce(size, half, |i| linear[i]),
        };
        levels.push(MipLevel { width: half[0], height: half[1], rgba8: encode(&linear, srgb) });
        size = half;
    }
    levels
}

type Texel = [f32; 4];

/// The area averages of `from`-sized texels on a `to`-sized grid.
fn reduce(from: [u32; 2], to: [u32; 2], texel: impl Fn(usize) -> Texel + Sync) -> Vec<Texel> {
    let columns: Vec<_> = (0..to[0]).map(|x| Taps::new(x, from[0], to[0])).collect();
    let mut out = vec![[0.0; 4]; to[0] as usize * to[1] as usize];
    out.par_chunks_mut(to[0] as usize).enumerate().for_each(|(y, row)| {
        let rows = Taps::new(y as u32, from[1], to[1]);
        for (out, column) in row.iter_mut().zip(&columns) {
            for (source_y, weight_y) in rows.iter() {
                for (source_x, weight_x) in column.iter() {
                    let value = texel(source_y * from[0] as usize + source_x);
                    for (sum, channel) in out.iter_mut().zip(value) {
                        *sum += weight_x * weight_y * channel;
                    }
                }
            }
        }
    });
    out
}

/// The texels that one texel of half the size covers along an axis, and their shares: one texel (nothing to
/// halve), two of a half each (even sizes), or three (odd sizes).
struct Taps {
    first: usize,
    weights: [f32; 3],
    count: usize,
}

impl Taps {
    fn new(index: u32, from: u32, to: u32) -> Self {
        // In units of 1 / to of a source texel, the area is [index * from, (index + 1) * from]; source texel
        // `s` is [s * to, (s + 1) * to]. Integers, so the shares are exact.
        let (index, from, to) = (u64::from(index), u64::from(from), u64::from(to));
        let (start, end) = (index * from, (index + 1) * from);
        let first = start / to;
        let mut weights = [0.0; 3];
        let mut count = 0;
        for (source, weight) in (first..).zip(&mut weights) {
            let covered = end.min((source + 1) * to).saturating_sub(start.max(source * to));
            if covered == 0 {
                break;
            }
            *weight = (covered as f64 / from as f64) as f32;
            count += 1;
        }
        Self { first: first as usize, weights, count }
    }

    fn iter(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        (self.first..).zip(self.weights[..self.count].iter().copied())
    }
}

fn decode_table(srgb: bool) -> [f32; 256] {
    std::array::from_fn(|i| {
        let encoded = i as f64 / 255.0;
        (if srgb { linear_from_srgb(encoded) } else { encoded }) as f32
    })
}

fn encode(texels: &[Texel], srgb: bool) -> Vec<u8> {
    let byte = |v: f32| (v * 255.0).round().clamp(0.0, 255.0) as u8;
    let color = |v: f32| byte(if srgb { srgb_from_linear(v) } else { v });
    let mut bytes = vec![0; texels.len() * 4];
    bytes
        .par_chunks_exact_mut(4)
        .with_min_len(4096)
        .zip(texels)
        .for_each(|(out, &[r, g, b, a])| out.copy_from_slice(&[color(r), color(g), color(b), byte(a)]));
    bytes
}

/// IEC 61966-2-1, decoding.
pub(super) fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// IEC 61966-2-1, encoding.
pub(super) fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes that look random; a linear congruential generator (Knuth's MMIX constants).
    fn noise(width: u32, height: u32) -> Image {
        let mut state = u64::from(width) << 32 | u64::from(height);
        let rgba8 = (0..width * height * 4)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 56) as u8
            })
            .collect();
        Image { name: "noise".into(), width, height, texels: rgba8 }
    }

    /// The mean of a piecewise constant function over [x0, x1] x [y0, y1], by intersecting every texel.
    fn area_mean(src: &[[f64; 4]], w: usize, h: usize, x: [f64; 2], y: [f64; 2]) -> [f64; 4] {
        let overlap = |i: usize, r: [f64; 2]| (r[1].min(i as f64 + 1.0) - r[0].max(i as f64)).max(0.0);
        let mut sum = [0.0; 4];
        for j in 0..h {
            for i in 0..w {
                let area = overlap(i, x) * overlap(j, y);
                (0..4).for_each(|c| sum[c] += area * src[j * w + i][c]);
            }
        }
        sum.map(|s| s / ((x[1] - x[0]) * (y[1] - y[0])))
    }

    /// The chain in f64, straight from its definition. Returns values on the 0 to 255 scale, not rounded.
    fn oracle(image: &Image, srgb: bool) -> Vec<Vec<[f64; 4]>> {
        let to_linear = |v: f64| match srgb {
            true if v > 0.04045 => ((v + 0.055) / 1.055).powf(2.4),
            true => v / 12.92,
            false => v,
        };
        let to_encoded = |v: f64| match srgb {
            true if v > 0.0031308 => 1.055 * v.powf(1.0 / 2.4) - 0.055,
            true => v * 12.92,
            false => v,
        };
        let (mut w, mut h) = (image.width as usize, image.height as usize);
        let unit = |b: u8| f64::from(b) / 255.0;
        let mut src: Vec<[f64; 4]> = image
            .rgba8()
            .chunks(4)
            .map(|t| [to_linear(unit(t[0])), to_linear(unit(t[1])), to_linear(unit(t[2])), unit(t[3])])
            .collect();
        let mut levels = Vec::new();
        while w > 1 || h > 1 {
            let (nw, nh) = ((w / 2).max(1), (h / 2).max(1));
            let (sx, sy) = (w as f64 / nw as f64, h as f64 / nh as f64);
            let texels = (0..nw * nh).map(|i| {
                let (x, y) = ((i % nw) as f64, (i / nw) as f64);
                area_mean(&src, w, h, [x * sx, (x + 1.0) * sx], [y * sy, (y + 1.0) * sy])
            });
            src = texels.collect();
            (w, h) = (nw, nh);
            let encode = |t: &[f64; 4]| [to_encoded(t[0]), to_encoded(t[1]), to_encoded(t[2]), t[3]];
            levels.push(src.iter().map(|t| encode(t).map(|v| v * 255.0)).collect());
        }
        levels
    }

    /// Rounding to a byte is off by half at most; f32 sums and powers add far less than this on the 0 to 255
    /// scale.
    const ROUNDING: f64 = 0.5 + 1e-3;

    #[test]
    fn agrees_with_the_definition_in_f64() {
        for (width, height) in [(1, 1), (2, 2), (3, 3), (1, 7), (8, 4), (13, 5), (31, 1), (33, 18)] {
            for srgb in [false, true] {
                let image = noise(width, height);
                let (levels, expected) = (mipmaps(&image, srgb), oracle(&image, srgb));
                assert_eq!(levels.len(), expected.len(), "{width}x{height}");
                assert_eq!(levels.len() as u32 + 1, mip_level_count(width, height));
                for (n, (level, expected)) in levels.iter().zip(&expected).enumerate() {
                    assert_eq!(level.rgba8.len(), expected.len() * 4);
                    for (bytes, expected) in level.rgba8.chunks(4).zip(expected) {
                        for (&byte, e) in bytes.iter().zip(expected) {
                            let error = (f64::from(byte) - e).abs();
                            assert!(
                                error <= ROUNDING,
                                "{width}x{height} srgb {srgb} level {}: {byte} for {e}",
                                n + 1
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_checkerboard_keeps_its_light() {
        // Half the light of white is 0.5 linear: 188 in sRGB (0.7354 * 255 = 187.5), not 128.
        let texel = |i: u32| if (i % 2) ^ (i / 2) == 0 { [255; 4] } else { [0; 4] };
        let image =
            Image { name: "checker".into(), width: 2, height: 2, texels: (0..4).flat_map(texel).collect() };
        assert_eq!(mipmaps(&image, true)[0].rgba8, [188, 188, 188, 128]);
        assert_eq!(mipmaps(&image, false)[0].rgba8, [128; 4]);
    }

    #[test]
    fn a_constant_stays_constant() {
        for byte in 0..=255_u8 {
            let image = Image { name: "flat".into(), width: 5, height: 3, texels: vec![byte; 60].into() };
            for srgb in [false, true] {
                for level in mipmaps(&image, srgb) {
                    assert!(level.rgba8.iter().all(|&b| b == byte), "{byte} srgb {srgb}");
                }
            }
        }
    }
}

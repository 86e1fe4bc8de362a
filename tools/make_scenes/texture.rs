//! Pictures of surfaces: albedo, height, roughness and metallicness per texel, encoded as glTF's textures.

use glam::{IVec2, Vec2, Vec3};
use image::codecs::{jpeg::JpegEncoder, png};
use image::{ExtendedColorType, ImageEncoder};

/// File format of an [`Encoded`] picture.
#[derive(Clone, Copy)]
pub enum Mime {
    Png,
    Jpeg,
}

/// A picture as a file's bytes.
pub struct Encoded {
    pub mime: Mime,
    pub bytes: Vec<u8>,
}

/// One point of a surface.
#[derive(Clone, Copy)]
pub struct Texel {
    /// sRGB-encoded, 0..1.
    pub albedo: Vec3,
    /// Above the surface's mean plane.
    pub height_m: f32,
    /// Perceptual, 0..1.
    pub roughness: f32,
    /// 0 or 1, between only at borders.
    pub metallic: f32,
}

/// A square sample of a surface that tiles seamlessly.
pub struct Surface {
    size_px: u32,
    /// Edge length of the sample, metres.
    extent_m: f32,
    texels: Vec<Texel>,
}

/// A surface's three glTF textures.
pub struct Maps {
    pub base_color: Encoded,
    pub normal: Encoded,
    /// Red occlusion, green roughness, blue metallicness.
    pub occlusion_roughness_metallic: Encoded,
}

impl Surface {
    /// Samples `texel` over [0, 1) x [0, 1), v downward.
    pub fn sample(size_px: u32, extent_m: f32, texel: impl Fn(Vec2) -> Texel) -> Self {
        let at = |i: u32| texel(texel_center(size_px, i));
        Self { size_px, extent_m, texels: (0..size_px * size_px).map(at).collect() }
    }

    /// All three textures. Colour is a JPEG (small), the others are PNG (exact).
    pub fn maps(&self) -> Maps {
        Maps {
            base_color: jpeg(self.size_px, &self.each(|_, t| rgb8(t.albedo))),
            normal: self.normal(),
            occlusion_roughness_metallic: png(
                self.size_px,
                ExtendedColorType::Rgb8,
                &self.each(|at, t| rgb8(Vec3::new(self.occlusion(at), t.roughness, t.metallic))),
            ),
        }
    }

    /// The tangent-space normal map: +X right, +Y up (green brightens towards the picture's top).
    pub fn normal(&self) -> Encoded {
        let texels = self.each(|at, _| rgb8(self.normal_at(at) * 0.5 + 0.5));
        png(self.size_px, ExtendedColorType::Rgb8, &texels)
    }

    /// Unit length, from central differences of the height.
    fn normal_at(&self, at: IVec2) -> Vec3 {
        let two_texels_m = 2.0 * self.extent_m / self.size_px as f32;
        let rise = |step: IVec2| (self.height_m(at + step) - self.height_m(at - step)) / two_texels_m;
        // Rows go down, so the slope upward is the negative of the slope along the rows.
        Vec3::new(-rise(IVec2::X), rise(IVec2::Y), 1.0).normalize()
    }

    /// How open the sky is above a texel: 1 minus what the neighbourhood's mean rise hides.
    fn occlusion(&self, at: IVec2) -> f32 {
        let reach_px = (self.size_px / 64) as i32;
        let reach_m = reach_px as f32 * self.extent_m / self.size_px as f32;
        let mut rise_m = 0.0;
        for y in -2..=2 {
            for x in -2..=2 {
                let other = self.height_m(at + IVec2::new(x, y) * reach_px / 2);
                rise_m += (other - self.height_m(at)).max(0.0) / 25.0;
            }
        }
        1.0 / (1.0 + 2.0 * rise_m / reach_m)
    }

    /// Edge length, texels.
    #[cfg(test)]
    pub fn size_px(&self) -> i32 {
        self.size_px as i32
    }

    /// The height of a texel; the surface repeats.
    pub fn height_m(&self, at: IVec2) -> f32 {
        let at = at.rem_euclid(IVec2::splat(self.size_px as i32));
        self.texels[(at.y * self.size_px as i32 + at.x) as usize].height_m
    }

    fn each<const N: usize>(&self, f: impl Fn(IVec2, &Texel) -> [u8; N]) -> Vec<u8> {
        let size = self.size_px as i32;
        (self.texels.iter().enumerate())
            .flat_map(|(i, t)| f(IVec2::new(i as i32 % size, i as i32 / size), t))
            .collect()
    }
}

/// A PNG with alpha from sRGB colour and coverage, both 0..1.
pub fn masked_picture(size_px: u32, texel: impl Fn(Vec2) -> (Vec3, f32)) -> Encoded {
    let texels: Vec<u8> = (0..size_px * size_px)
        .flat_map(|i| {
            let (color, alpha) = texel(texel_center(size_px, i));
            let [r, g, b] = rgb8(color);
            [r, g, b, rgb8(Vec3::splat(alpha))[0]]
        })
        .collect();
    png(size_px, ExtendedColorType::Rgba8, &texels)
}

/// A PNG from sRGB colours 0..1.
pub fn picture(size_px: u32, texel: impl Fn(Vec2) -> Vec3) -> Encoded {
    let texels: Vec<u8> =
        (0..size_px * size_px).flat_map(|i| rgb8(texel(texel_center(size_px, i)))).collect();
    png(size_px, ExtendedColorType::Rgb8, &texels)
}

/// An sRGB hex triple as linear Rec.709 (IEC 61966-2-1).
pub fn linear(hex: u32) -> Vec3 {
    let decode = |x: f32| if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    let [r, g, b] = srgb(hex).to_array().map(decode);
    Vec3::new(r, g, b)
}

/// An sRGB hex triple as 0..1.
pub fn srgb(hex: u32) -> Vec3 {
    Vec3::new((hex >> 16) as f32, (hex >> 8 & 255) as f32, (hex & 255) as f32) / 255.0
}

fn texel_center(size_px: u32, index: u32) -> Vec2 {
    Vec2::new((index % size_px) as f32 + 0.5, (index / size_px) as f32 + 0.5) / size_px as f32
}

fn rgb8(color: Vec3) -> [u8; 3] {
    color.to_array().map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
}

fn png(size_px: u32, color: ExtendedColorType, texels: &[u8]) -> Encoded {
    let mut bytes = Vec::new();
    png::PngEncoder::new_with_quality(&mut bytes, png::CompressionType::Best, png::FilterType::Adaptive)
        .write_image(texels, size_px, size_px, color)
        .expect("memory is writable and sizes agree");
    Encoded { mime: Mime::Png, bytes }
}

fn jpeg(size_px: u32, texels: &[u8]) -> Encoded {
    const QUALITY_PERCENT: u8 = 88;
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY_PERCENT)
        .write_image(texels, size_px, size_px, ExtendedColorType::Rgb8)
        .expect("memory is writable and sizes agree");
    Encoded { mime: Mime::Jpeg, bytes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    #[test]
    fn normals_follow_the_slope_of_a_known_wave() {
        let (amplitude_m, extent_m) = (0.01, 2.0);
        let wave = |uv: Vec2| amplitude_m * ((uv.x * TAU).sin() + (uv.y * 2.0 * TAU).sin());
        let surface = Surface::sample(256, extent_m, |uv| Texel {
            albedo: Vec3::ONE,
            height_m: wave(uv),
            roughness: 1.0,
            metallic: 0.0,
        });
        for at in [IVec2::ZERO, IVec2::new(40, 99), IVec2::new(255, 255)] {
            let uv = (at.as_vec2() + 0.5) / 256.0;
            let right = amplitude_m * TAU * (uv.x * TAU).cos() / extent_m;
            let down = amplitude_m * 2.0 * TAU * (uv.y * 2.0 * TAU).cos() / extent_m;
            let expected = Vec3::new(-right, down, 1.0).normalize();
            // Central differences over two of 128 texels a period err by (TAU / 128)² / 6 of the slope.
            assert!(surface.normal_at(at).distance(expected) < 1e-3 * right.hypot(down).max(0.02), "{at}");
        }
    }
}

//! Texture look-ups from level 0.
//!
//! Bilinear as Vulkan 1.3 section 16.8 defines it, in f64 and without mip levels; or the nearest texel where the
//! sampler does not magnify linearly. A GPU differs: it picks a level, and may weigh texels with as little as
//! 8 fractional bits.

use glam::{DVec2, DVec4};

use crate::scene::{Image, Mesh, Scene, TextureRef, Wrap};

/// How an image's bytes become colour. Alpha is linear always.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// The byte is proportional to the value.
    Linear,
    /// The sRGB transfer function, undone before filtering.
    Srgb,
}

/// Light from an sRGB-encoded value, both in \[0, 1\]: IEC 61966-2-1.
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`linear_from_srgb`].
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.0031308 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Looks a material slot up at barycentric weights within a triangle of `mesh`.
pub(super) fn sample_at(
    scene: &Scene,
    mesh: &Mesh,
    vertices: [u32; 3],
    barycentric: [f64; 3],
    slot: &TextureRef,
    encoding: Encoding,
) -> DVec4 {
    let texcoords = &mesh.texcoords[slot.texcoord];
    let corner = |k: usize| texcoords[vertices[k] as usize].as_dvec2() * barycentric[k];
    let texcoord = if texcoords.is_empty() { DVec2::ZERO } else { corner(0) + corner(1) + corner(2) };
    sample(scene, slot, texcoord, encoding)
}

/// The colour of a material slot's texture at a mesh coordinate.
pub fn sample(scene: &Scene, slot: &TextureRef, texcoord: DVec2, encoding: Encoding) -> DVec4 {
    let texture = &scene.textures[slot.texture];
    let image = &scene.images[texture.image];
    let row = |k: usize| slot.uv_from_texcoord[k].as_dvec3().dot(texcoord.extend(1.0));
    let uv = DVec2::new(row(0), row(1));
    let wraps = [texture.sampler.wrap_u, texture.sampler.wrap_v];
    if !texture.sampler.mag_linear {
        let nearest = (uv * size(image)).floor();
        return wrapped(image, nearest, wraps, encoding);
    }
    filtered(image, uv, wraps, encoding)
}

/// The colour at a texture coordinate, linearly between texels; edges go on.
pub fn bilinear(image: &Image, uv: DVec2, encoding: Encoding) -> DVec4 {
    filtered(image, uv, [Wrap::ClampToEdge; 2], encoding)
}

fn size(image: &Image) -> DVec2 {
    DVec2::new(f64::from(image.width), f64::from(image.height))
}

fn wrapped(image: &Image, at: DVec2, [u, v]: [Wrap; 2], encoding: Encoding) -> DVec4 {
    texel(image, wrap(at.x, image.width, u), wrap(at.y, image.height, v), encoding)
}

fn filtered(image: &Image, uv: DVec2, wraps: [Wrap; 2], encoding: Encoding) -> DVec4 {
    let place = uv * size(image);
    let at = |x: f64, y: f64| wrapped(image, DVec2::new(x, y), wraps, encoding);
    let base = (place - 0.5).floor();
    let weight = place - 0.5 - base;
    let upper = at(base.x, base.y).lerp(at(base.x + 1.0, base.y), weight.x);
    let lower = at(base.x, base.y + 1.0).lerp(at(base.x + 1.0, base.y + 1.0), weight.x);
    upper.lerp(lower, weight.y)
}

/// The texel within `0..size` that stands for any whole number.
fn wrap(texel: f64, size: u32, mode: Wrap) -> u32 {
    let n = f64::from(size);
    let inside = match mode {
        Wrap::Repeat => texel.rem_euclid(n),
        Wrap::MirroredRepeat => {
            let within_pair = texel.rem_euclid(2.0 * n);
            within_pair.min(2.0 * n - 1.0 - within_pair)
        }
        Wrap::ClampToEdge => texel.clamp(0.0, n - 1.0),
    };
    (inside as u32).min(size - 1)
}

fn texel(image: &Image, x: u32, y: u32, encoding: Encoding) -> DVec4 {
    let start = (y as usize * image.width as usize + x as usize) * 4;
    let [r, g, b, a] = std::array::from_fn(|k| f64::from(image.rgba8()[start + k]) / 255.0);
    match encoding {
        Encoding::Linear => DVec4::new(r, g, b, a),
        Encoding::Srgb => DVec4::new(linear_from_srgb(r), linear_from_srgb(g), linear_from_srgb(b), a),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Sampler, Texture};
    use glam::Vec3;

    fn checker(wrap_u: Wrap, mag_linear: bool) -> (Scene, TextureRef) {
        let image = Image {
            name: String::new(),
            width: 2,
            height: 1,
            texels: vec![0, 0, 0, 255, 255, 255, 255, 255].into(),
        };
        let sampler = Sampler { wrap_u, mag_linear, ..Sampler::default() };
        let scene =
            Scene { images: vec![image], textures: vec![Texture { image: 0, sampler }], ..Scene::default() };
        (scene, TextureRef { texture: 0, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY })
    }

    fn red(wrap_u: Wrap, mag_linear: bool, u: f64) -> f64 {
        let (scene, slot) = checker(wrap_u, mag_linear);
        sample(&scene, &slot, DVec2::new(u, 0.3), Encoding::Linear).x
    }

    #[test]
    fn bilinear_weights_and_wrapping() {
        // Texel centres lie at u = 0.25 and 0.75.
        assert_eq!(red(Wrap::Repeat, true, 0.25), 0.0);
        assert_eq!(red(Wrap::Repeat, true, 0.75), 1.0);
        assert!((red(Wrap::Repeat, true, 0.375) - 0.25).abs() < 1e-12);
        // Over the left border: the other texel, the same texel, the same texel.
        assert!((red(Wrap::Repeat, true, 0.0) - 0.5).abs() < 1e-12);
        assert_eq!(red(Wrap::ClampToEdge, true, 0.0), 0.0);
        assert_eq!(red(Wrap::MirroredRepeat, true, 0.0), 0.0);
        // A whole picture further the mirror shows the right texel first.
        assert_eq!(red(Wrap::MirroredRepeat, true, 1.25), 1.0);
        assert_eq!(red(Wrap::Repeat, true, -0.25), 1.0);
        assert_eq!(red(Wrap::Repeat, false, 0.49), 0.0);
        assert_eq!(red(Wrap::Repeat, false, 0.51), 1.0);
    }

    #[test]
    fn the_uv_transform_is_applied() {
        let (scene, mut slot) = checker(Wrap::Repeat, true);
        slot.uv_from_texcoord = [Vec3::new(0.0, 1.0, 0.5), Vec3::X];
        assert_eq!(sample(&scene, &slot, DVec2::new(0.1, 0.25), Encoding::Linear).x, 1.0);
    }

    #[test]
    fn srgb_has_its_published_values() {
        // IEC 61966-2-1: the two branches meet, and the middle byte is 21.59 % light.
        assert!((linear_from_srgb(128.0 / 255.0) - 0.215_860_5).abs() < 1e-6);
        assert!((linear_from_srgb(0.04045) - linear_from_srgb(0.040_450_001)).abs() < 1e-7);
        for byte in 0..=255 {
            let encoded = f64::from(byte) / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(encoded)) - encoded).abs() < 1e-7);
        }
    }
}

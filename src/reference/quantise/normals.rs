//! Encodings of a direction: the counterparts of `glsl/gbuffer/normal.glsl`.

use glam::{DMat3, DVec2, DVec3, DVec4};

use super::formats::{float32, unorm};
use crate::plan::Normals;
use crate::reference::view::View;

/// The view's axes in world space: right, up, towards the viewer.
pub fn world_from_view(view: &View) -> DMat3 {
    DMat3::from_cols(view.right_world.normalize(), -view.down_world.normalize(), -view.forward_world)
}

/// The octahedron's unfolding, \[-1, 1\]² (Meyer et al. 2010; Cigolle et al. 2014).
pub fn octahedral_from_direction(n: DVec3) -> DVec2 {
    let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |x: f64| if x >= 0.0 { 1.0 } else { -1.0 };
    match n.z < 0.0 {
        true => DVec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)),
        false => p,
    }
}

/// The inverse of [`octahedral_from_direction`].
pub fn direction_from_octahedral(p: DVec2) -> DVec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let t = (-z).max(0.0);
    let towards_0 = |x: f64| if x >= 0.0 { x - t } else { x + t };
    DVec3::new(towards_0(p.x), towards_0(p.y), z).normalize_or_zero()
}

/// Steps from the middle code to either end: an even number of steps, so that 0 is kept exactly.
pub fn half_steps(bits: u32) -> f64 {
    f64::from((1_u32 << (bits - 1)) - 1)
}

fn codes(p: DVec2, bits: u32) -> DVec2 {
    let h = half_steps(bits);
    (p * h + (h + 0.5)).floor().clamp(DVec2::ZERO, DVec2::splat(2.0 * h))
}

fn from_codes(codes: DVec2, bits: u32) -> DVec2 {
    codes / half_steps(bits) - 1.0
}

/// Codes of `bits` bits of the unfolding. (0, 0), one of four codes of the direction -z, is left to "not lit".
pub fn octahedral_codes(n: DVec3, bits: u32) -> DVec2 {
    let codes = codes(octahedral_from_direction(n), bits);
    if codes == DVec2::ZERO { DVec2::splat(2.0 * half_steps(bits)) } else { codes }
}

/// The direction of codes of `bits` bits.
pub fn direction_from_octahedral_codes(codes: DVec2, bits: u32) -> DVec3 {
    direction_from_octahedral(from_codes(codes, bits))
}

/// Two codes of 12 bits and a channel of 8 in four bytes.
fn bytes_of(codes: DVec2, roughness: f64) -> DVec4 {
    let [x, y] = [codes.x as u32, codes.y as u32];
    let bytes = [x >> 4, (x & 15) << 4 | y >> 8, y & 255].map(|b| f64::from(b) / 255.0);
    DVec3::from_array(bytes).extend(unorm(roughness, 8))
}

fn codes_in(stored: DVec4) -> DVec2 {
    let [x, y, z, _] = stored.to_array().map(|b| (b * 255.0).round() as u32);
    DVec2::new(f64::from(x << 4 | y >> 4), f64::from((y & 15) << 8 | z))
}

/// Bits of each code, of the encodings that have two channels of a target for it.
fn two_channels(normals: Normals) -> Option<u32> {
    match normals {
        Normals::Oct8 => Some(8),
        Normals::Oct10 => Some(10),
        Normals::Oct16 => Some(16),
        _ => None,
    }
}

/// What the target of normal and roughness holds; all zero says "not lit".
pub fn encode(normals: Normals, normal_world: DVec3, roughness: f64, view: &View) -> DVec4 {
    let in_view = || world_from_view(view).transpose() * normal_world;
    match normals {
        Normals::Xyz8 => {
            let n = normal_world * 0.5 + 0.5;
            DVec4::new(unorm(n.x, 8), unorm(n.y, 8), unorm(n.z, 8), unorm(roughness, 8))
        }
        Normals::Float => normal_world.extend(roughness).to_array().map(float32).into(),
        Normals::Oct8 | Normals::Oct10 | Normals::Oct16 => {
            let bits = two_channels(normals).unwrap_or_default();
            let codes = octahedral_codes(normal_world, bits) / f64::from((1_u32 << bits) - 1);
            DVec4::new(codes.x, codes.y, unorm(roughness, bits), 1.0)
        }
        Normals::Oct12 => bytes_of(octahedral_codes(normal_world, 12), roughness),
        Normals::Sphere12 => {
            let n = in_view();
            let p = n.truncate() / (2.0 * n.z + 2.0).max(1e-12).sqrt();
            bytes_of(codes(p, 12), roughness)
        }
        Normals::View12 => bytes_of(codes(in_view().truncate(), 12), roughness),
    }
}

/// Direction and roughness of what [`encode`] gave; `None`: not lit.
pub fn decode(normals: Normals, stored: DVec4, view: &View) -> Option<(DVec3, f64)> {
    if stored.truncate() == DVec3::ZERO {
        return None;
    }
    if let Some(bits) = two_channels(normals) {
        let codes = (stored.truncate().truncate() * f64::from((1_u32 << bits) - 1)).round();
        return Some((direction_from_octahedral_codes(codes, bits), stored.z));
    }
    let p = from_codes(codes_in(stored), 12);
    let normal = match normals {
        Normals::Float => stored.truncate(),
        Normals::Oct12 => direction_from_octahedral(p),
        Normals::Sphere12 => {
            let f = p.length_squared();
            world_from_view(view) * (p * (2.0 * (1.0 - f).max(0.0).sqrt())).extend(1.0 - 2.0 * f).normalize()
        }
        Normals::View12 => in_view(p, view),
        // 8 bits do not keep the length.
        _ => (stored.truncate() * 2.0 - 1.0).normalize_or_zero(),
    };
    Some((normal, stored.w))
}

/// The world-space direction with these x and y in view space, and a z towards the viewer.
pub fn in_view(p: DVec2, view: &View) -> DVec3 {
    world_from_view(view) * p.extend((1.0 - p.length_squared()).max(0.0).sqrt()).normalize()
}

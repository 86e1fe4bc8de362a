//! Globe maps: pictures that light shines through.

use glam::{DMat3, DVec2, DVec3};

use super::texture::{Encoding, bilinear};
use crate::scene::{GlobeMap, GlobePicture, Image, Light, LightKind};

/// Maps are projected from at least this distance, metres: in front of a spot (what is nearer or behind is dark), and
/// around a point light.
const MIN_AHEAD_M: f64 = 1e-4;

/// The colour that a light has left at a point, behind its globe map; white without one.
///
/// Projective texturing (Segal et al. 1992, "Fast Shadows and Lighting Effects Using Texture Mapping") from the light's
/// frame, turned by the map's own rotation. Sampled linearly; beyond the edge the edge goes on.
pub fn globe_color(light: &Light, images: &[Image], position_world: DVec3) -> DVec3 {
    let Some(GlobeMap { picture, rotation_rad }) = light.shown_globe_map() else { return DVec3::ONE };
    let angle = f64::from(rotation_rad);
    let frame = DMat3::from_cols(
        light.right_world().as_dvec3(),
        light.up_world.as_dvec3(),
        -light.direction_world.as_dvec3(),
    );
    let position_light = frame.transpose() * (position_world - light.position_world.as_dvec3());
    match picture {
        GlobePicture::Flat { image } => {
            let p = DMat3::from_rotation_z(-angle) * position_light;
            let (p, half) = match light.kind {
                LightKind::Box { size_m, .. } => (p.truncate(), size_m.as_dvec3().truncate() * 0.5),
                LightKind::Spot { outer_cone_rad, .. } => {
                    let widest = f64::from(outer_cone_rad.min(GlobeMap::MOST_CONE_RAD));
                    (p.truncate() / (-p.z).max(MIN_AHEAD_M), DVec2::splat(widest.tan()))
                }
                _ => return DVec3::ONE,
            };
            look_up(&images[image], p / half)
        }
        GlobePicture::Cube { images: faces } => {
            let (face, p) = cube_face(DMat3::from_rotation_y(-angle) * position_light);
            look_up(&images[faces[face]], p)
        }
    }
}

/// Which face a direction in the light's frame meets (+X, -X, +Y, -Y, +Z, -Z), and where: x to the right and y up, each
/// from -1 to 1, as [`GlobePicture::Cube`] has them.
pub fn cube_face(d: DVec3) -> (usize, DVec2) {
    let a = d.abs();
    if a.x >= a.y && a.x >= a.z {
        let sign = if d.x < 0.0 { -1.0 } else { 1.0 };
        (usize::from(d.x < 0.0), DVec2::new(sign * d.z, d.y) / a.x.max(MIN_AHEAD_M))
    } else if a.y >= a.z {
        let sign = if d.y < 0.0 { -1.0 } else { 1.0 };
        (2 + usize::from(d.y < 0.0), DVec2::new(d.x, sign * d.z) / a.y.max(MIN_AHEAD_M))
    } else {
        let sign = if d.z < 0.0 { -1.0 } else { 1.0 };
        (4 + usize::from(d.z < 0.0), DVec2::new(-sign * d.x, d.y) / a.z.max(MIN_AHEAD_M))
    }
}

/// From -1 to 1, y up.
fn look_up(image: &Image, p: DVec2) -> DVec3 {
    let uv = DVec2::new(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y);
    bilinear(image, uv, Encoding::Srgb).truncate()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Faces and corners as a camera at the light sees them: forward, up.
    const FACES: [(DVec3, DVec3); 6] = [
        (DVec3::X, DVec3::Y),
        (DVec3::NEG_X, DVec3::Y),
        (DVec3::Y, DVec3::Z),
        (DVec3::NEG_Y, DVec3::NEG_Z),
        (DVec3::Z, DVec3::Y),
        (DVec3::NEG_Z, DVec3::Y),
    ];

    #[test]
    fn faces_are_what_a_camera_sees() {
        for (face, (forward, up)) in FACES.into_iter().enumerate() {
            for at in [DVec2::ZERO, DVec2::new(0.7, 0.1), DVec2::new(-0.2, -0.9), DVec2::new(0.4, -0.8)] {
                let d = forward + forward.cross(up) * at.x + up * at.y;
                let (found, p) = cube_face(d * 3.7);
                assert!(found == face && p.distance(at) < 1e-12, "{face} at {at}: {found} at {p}");
            }
        }
    }

    /// 2 x 2 texels: red, green above blue, white.
    fn quarters() -> Image {
        let rgba8 = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]].as_flattened().to_vec();
        Image { name: String::new(), width: 2, height: 2, texels: rgba8.into() }
    }

    #[test]
    fn flat_maps_are_upright_as_the_light_sees_them() {
        const RED: DVec3 = DVec3::X;
        const GREEN: DVec3 = DVec3::Y;
        const BLUE: DVec3 = DVec3::Z;
        let boxed = LightKind::Box { illuminance_lx: 1.0, size_m: Vec3::new(4.0, 2.0, 9.0), falloff_m: 0.0 };
        let spot = LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.0, outer_cone_rad: 0.5 };
        let color = |kind, rotation_rad, at: DVec3| {
            let globe_map = Some(GlobeMap { picture: GlobePicture::Flat { image: 0 }, rotation_rad });
            globe_color(&Light { globe_map, ..Light::new(kind) }, &[quarters()], at)
        };
        let quarter = std::f32::consts::FRAC_PI_2;
        for (kind, scale) in
            [(boxed, DVec3::new(1.0, 0.5, 1.0)), (spot, DVec3::new(0.5, 0.5, 1.0) * 0.5_f64.tan())]
        {
            // It looks along -Z from above: +X is right, +Y is up. These are texel centres.
            let at = |x: f64, y: f64| DVec3::new(x, y, -1.0 / scale.z) * scale;
            assert!(color(kind, 0.0, at(-1.0, 1.0)).distance(RED) < 1e-12, "{kind:?}");
            assert!(color(kind, 0.0, at(1.0, 1.0)).distance(GREEN) < 1e-12, "{kind:?}");
            assert!(color(kind, 0.0, at(-1.0, -1.0)).distance(BLUE) < 1e-12, "{kind:?}");
        }
        // A quarter turn counter-clockwise takes the upper right to the upper left.
        let at = DVec3::new(-1.0, 1.0, 0.0) * 0.5 * 0.5_f64.tan() - DVec3::Z;
        assert!(color(spot, quarter, at).distance(GREEN) < 1e-6);
        // Beyond the map its edge goes on, also behind a spot.
        assert_eq!(color(spot, 0.0, DVec3::new(-9.0, 9.0, -1.0)), RED);
        assert_eq!(color(spot, 0.0, DVec3::new(-9.0, 9.0, 1.0)), RED);
    }
}

//! A camera and lights for files that have none.

use glam::{DMat3, DMat4, DVec3, Vec3};

use crate::scene::{Aabb, Camera, Light, LightKind, Projection};

/// Full vertical field of view of the default camera, degrees.
const YFOV_DEG: f64 = 45.0;
/// The default camera stands this far from the front (+Z) towards the right, degrees.
const AZIMUTH_DEG: f64 = 35.0;
/// And this far above the horizon, degrees.
const ELEVATION_DEG: f64 = 20.0;
/// The scene's share of the frame's narrower side.
const FILL: f64 = 0.92;

/// The camera `default`: all of `bounds` in view from a slightly raised three-quarter position, in square
/// images and wider ones.
pub fn camera(bounds: Option<Aabb>) -> Camera {
    let bounds = bounds.unwrap_or(Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) });
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let center = (min + max) * 0.5;
    // A point has no size to go by, f32 has no smaller planes to clip at, and far from the origin it cannot
    // tell close positions apart.
    let least = if max == min { 1.0 } else { 1e-12 };
    let radius = ((max - min).length() * 0.5).max(center.length() * 1e-5).max(least);

    let (sin_azimuth, cos_azimuth) = AZIMUTH_DEG.to_radians().sin_cos();
    let (sin_elevation, cos_elevation) = ELEVATION_DEG.to_radians().sin_cos();
    let back = DVec3::new(sin_azimuth * cos_elevation, sin_elevation, cos_azimuth * cos_elevation);
    let right = DVec3::Y.cross(back).normalize();
    let view_axes = DMat3::from_cols(right, back.cross(right), back);

    // A corner at (x, y, z) from the centre is in view from a distance d if |x|, |y| <= (d - z) tan(fov / 2).
    let tan_half = (YFOV_DEG * 0.5).to_radians().tan() * FILL;
    let corners = (0..8).map(|i| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { min[axis] } else { max[axis] };
        view_axes.transpose() * (DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)) - center)
    });
    let (mut distance, mut nearest, mut farthest) = (radius, -radius, radius);
    for (i, corner) in corners.enumerate() {
        distance = distance.max(corner.z + corner.x.abs().max(corner.y.abs()) / tan_half);
        nearest = if i == 0 { corner.z } else { nearest.max(corner.z) };
        farthest = if i == 0 { corner.z } else { farthest.min(corner.z) };
    }
    let zfar = (distance - farthest) * 2.0;
    let znear = ((distance - nearest) * 0.5).max(zfar * 1e-3);
    let eye = center + back * distance;
    Camera {
        name: "default".into(),
        world_from_view: (DMat4::from_translation(eye) * DMat4::from_mat3(view_axes)).as_mat4(),
        projection: Projection::Perspective {
            yfov_rad: YFOV_DEG.to_radians() as f32,
            znear_m: znear as f32,
            zfar_m: Some(zfar as f32),
        },
    }
}

/// A key light of 3 lx over the camera's right shoulder and a fill light of 0.8 lx from the lower left, without shadows.
pub fn lights(camera: &Camera) -> Vec<Light> {
    let light = |name: &str, illuminance_lx: f32, towards_light_view: Vec3| {
        let light = Light { name: name.into(), ..Light::new(LightKind::Directional { illuminance_lx }) };
        light.towards(-camera.world_from_view.transform_vector3(towards_light_view))
    };
    vec![
        light("default key", 3.0, Vec3::new(0.6, 0.8, 1.0)),
        light("default fill", 0.8, Vec3::new(-1.0, -0.4, 0.7)),
    ]
}

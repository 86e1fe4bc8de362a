//! What stands between a light and a surface: the counterpart of the shadow map, by one ray a light.

use glam::DVec3;

use super::view::Ray;
use super::visibility::Visibility;
use crate::scene::{Light, LightKind, Scene};

/// A surface is moved this far along its normal before it is asked whether it is lit, in metres per metre from the world's
/// origin, and at least as much as at one metre: more than positions lose when they come from a depth in f32, less than
/// anything that is seen.
const RECEIVER_OFFSET: f64 = 1e-5;

/// The scene as lights see it: back faces of single-sided materials and what alpha masks cut away cast no shadow.
pub struct Occlusion<'a> {
    visibility: &'a Visibility<'a>,
    /// No two points of the scene are farther apart, metres.
    extent_m: f64,
}

impl<'a> Occlusion<'a> {
    /// Of the scene that the triangles are from.
    pub fn new(scene: &Scene, visibility: &'a Visibility<'a>) -> Self {
        let extent = scene.bounds_world().map_or(0.0, |b| (b.max.as_dvec3() - b.min.as_dvec3()).length());
        Self { visibility, extent_m: extent + 1.0 }
    }

    /// Whether something stands between a surface and a light that casts shadows. `to_light` has unit length.
    ///
    /// The ray goes from the light to the surface, so that it meets the sides that the light sees. It begins at a point or
    /// spot light's place, outside of the scene for directional lights, and at the face through which a box light enters.
    pub fn hides(&self, light: &Light, position: DVec3, normal: DVec3, to_light: DVec3) -> bool {
        if light.shadow.is_none() {
            return false;
        }
        let receiver = position + normal * (RECEIVER_OFFSET * position.length().max(1.0));
        let origin = match light.kind {
            LightKind::Point { .. } | LightKind::Spot { .. } => light.position_world.as_dvec3(),
            LightKind::Directional { .. } => receiver + to_light * self.extent_m,
            LightKind::Box { size_m, .. } => {
                let center = light.position_world.as_dvec3();
                let beyond = f64::from(size_m.z) * 0.5 - (receiver - center).dot(to_light);
                receiver + to_light * beyond.max(0.0)
            }
            LightKind::Hemisphere { .. } => return false,
        };
        let ray = Ray { origin, direction: receiver - origin, range: [0.0, 1.0] };
        ray.direction != DVec3::ZERO && self.visibility.trace(&ray).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::{scene_of, square};
    use crate::scene::{Material, Shadow};
    use glam::{Mat4, Vec3};

    /// Whether a light is hidden from the origin, whose surface faces +Z, by a square at z = 1 that faces +Z or -Z.
    fn hidden(kind: LightKind, position_world: Vec3, faces_light: bool) -> bool {
        let turned = Mat4::from_rotation_y(if faces_light { 0.0 } else { std::f32::consts::PI });
        let placed = Mat4::from_translation(Vec3::Z) * turned;
        let scene = scene_of(Material::default(), vec![(square(0.5), placed)]);
        let visibility = Visibility::new(&scene);
        let light = Light { position_world, shadow: Some(Shadow::default()), ..Light::new(kind) };
        Occlusion::new(&scene, &visibility).hides(&light, DVec3::ZERO, DVec3::Z, DVec3::Z)
    }

    #[test]
    fn what_faces_the_light_hides_it() {
        let point = LightKind::Point { intensity_cd: 1.0 };
        let sun = LightKind::Directional { illuminance_lx: 1.0 };
        let boxed =
            |z| LightKind::Box { illuminance_lx: 1.0, size_m: Vec3::new(3.0, 3.0, z), falloff_m: 0.1 };
        let above = Vec3::Z * 3.0;
        assert!(hidden(point, above, true) && hidden(sun, Vec3::ZERO, true));
        assert!(hidden(boxed(4.0), Vec3::ZERO, true));
        // Light from below the square, and a box that ends there.
        assert!(!hidden(point, Vec3::Z * 0.5, true) && !hidden(boxed(1.5), Vec3::ZERO, true));
        assert!(!hidden(point, above, false) && !hidden(sun, Vec3::ZERO, false));
    }
}

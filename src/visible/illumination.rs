//! What a light may light of the scene.

use glam::Vec3;

use super::Reach;
use crate::scene::Aabb;

/// What may be lost to rounding, as a share of the coordinates: a shader's place of a pixel, computed from its depth.
const ROUNDING: f32 = 1e-5;

impl Reach {
    /// Whether the light does not reach the box: an object that fills it is not in the light's illumination set (O'Rorke
    /// 2004, "Managing Visibility for Per-Pixel Lighting", GPU Gems, chapter 15). One-sided: what is missed gets no light;
    /// what is not may still be dark.
    pub fn misses_aabb(&self, bounds: &Aabb) -> bool {
        let center = bounds.center();
        let far = center.abs() + (bounds.max - center);
        let half = (bounds.max - center).max(center - bounds.min) + Vec3::splat(far.max_element() * ROUNDING);
        match *self {
            Self::Everywhere => false,
            Self::Sphere { center_world, radius_m } => misses_sphere(center, half, center_world, radius_m),
            Self::Cone { apex_world, direction_world, cos, sin, range_m } => {
                misses_sphere(center, half, apex_world, range_m)
                    || misses_cone(center - apex_world, half.length(), direction_world, cos, sin)
            }
            // Separated along an axis of either box (Gottschalk et al. 1996, "OBBTree", without the edges' products).
            Self::Box { center_world, half_axes_world } => {
                let between = (center - center_world).abs();
                let reach = half_axes_world.iter().fold(half, |sum, axis| sum + axis.abs());
                between.cmpgt(reach).any()
                    || half_axes_world.iter().any(|axis| {
                        let extent = axis.length_squared() + axis.abs().dot(half);
                        axis.dot(center - center_world).abs() > extent
                    })
            }
        }
    }
}

fn misses_sphere(center: Vec3, half: Vec3, sphere: Vec3, radius: f32) -> bool {
    let outside = ((sphere - center).abs() - half).max(Vec3::ZERO);
    outside.length_squared() > radius * radius
}

/// Whether the ball is outside of an endless cone from the origin: Eberly, "Intersection of a Sphere and a Cone". Its
/// distance from the cone's side is `across * cos - along * sin`, as long as the side is what is nearest.
fn misses_cone(ball: Vec3, radius: f32, direction: Vec3, cos: f32, sin: f32) -> bool {
    let along = ball.dot(direction);
    let across = (ball.length_squared() - along * along).max(0.0).sqrt();
    across * cos - along * sin > radius || along < -radius
}

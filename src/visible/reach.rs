//! Where a light can be seen at all.

use glam::Vec3;

use crate::scene::{Aabb, Light, LightKind};

/// A volume beyond which a light adds exactly nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// No limits.
    Everywhere,
    /// Around a point.
    Sphere {
        /// World space, metres.
        center_world: Vec3,
        /// Metres.
        radius_m: f32,
    },
    /// The part of a sphere around `apex_world` that lies within a cone.
    Cone {
        /// World space, metres.
        apex_world: Vec3,
        /// Unit length: the cone's axis.
        direction_world: Vec3,
        /// Cosine of the angle between axis and edge, at least 0.
        cos: f32,
        /// Sine of that angle.
        sin: f32,
        /// The sphere's radius, metres; may be infinite.
        range_m: f32,
    },
    /// A box that stands in any way.
    Box {
        /// World space, metres.
        center_world: Vec3,
        /// From the centre to the middles of three faces, metres.
        half_axes_world: [Vec3; 3],
    },
}

impl Reach {
    /// How much wider than they are lights are taken, since shaders compare rounded distances and cosines.
    const WIDER: f32 = 1e-5;

    /// Of a light.
    pub fn of(light: &Light) -> Self {
        let (position, range_m) = (light.position_world, light.range_m.map(|r| r * (1.0 + Self::WIDER)));
        let sphere =
            range_m.map_or(Self::Everywhere, |radius_m| Self::Sphere { center_world: position, radius_m });
        match light.kind {
            LightKind::Directional { .. } | LightKind::Hemisphere { .. } => Self::Everywhere,
            LightKind::Box { size_m, .. } => {
                let half = size_m * (0.5 * (1.0 + Self::WIDER));
                let half_axes_world =
                    [light.right_world() * half.x, light.up_world * half.y, light.direction_world * half.z];
                Self::Box { center_world: position, half_axes_world }
            }
            LightKind::Point { .. } => sphere,
            LightKind::Spot { outer_cone_rad, .. } => match outer_cone_rad.cos() - Self::WIDER {
                // More than half of a sphere is not convex.
                ..0.0 => sphere,
                cos => Self::Cone {
                    apex_world: position,
                    direction_world: light.direction_world,
                    cos,
                    sin: (1.0 - cos * cos).sqrt(),
                    range_m: range_m.unwrap_or(f32::INFINITY),
                },
            },
        }
    }

    /// How much of `ground`, seen along its shortest side, the smallest box around the volume covers: from 0 to 1. Boxes are
    /// along the world's axes.
    pub fn share_of(&self, ground: &Aabb) -> f32 {
        let size = ground.max - ground.min;
        let covers = |axis: usize| {
            let [below, above] = [-Vec3::AXES[axis], Vec3::AXES[axis]].map(|a| self.support(a));
            let (min, max) = ((-below).max(ground.min[axis]), above.min(ground.max[axis]));
            // What is flat is covered or not.
            if max < min {
                0.0
            } else if size[axis] > 0.0 {
                ((max - min) / size[axis]).min(1.0)
            } else {
                1.0
            }
        };
        let shortest = (0..3).min_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or_default();
        let along = (0..3).map(|axis| (axis, covers(axis)));
        // A light that ends before it touches the ground covers none of it.
        along.map(|(axis, share)| if axis == shortest { share.ceil() } else { share }).product()
    }

    /// How far the volume goes along a unit vector, metres from the world's origin.
    fn support(&self, along: Vec3) -> f32 {
        match *self {
            Self::Everywhere => f32::INFINITY,
            Self::Sphere { center_world, radius_m } => center_world.dot(along) + radius_m,
            Self::Cone { apex_world, direction_world, cos, sin, range_m } => {
                let c = direction_world.dot(along).clamp(-1.0, 1.0);
                // The cosine of what is left of the angle to the axis beyond the cone's own.
                let nearest = if c >= cos { 1.0 } else { c * cos + (1.0 - c * c).sqrt() * sin };
                let reach = if nearest > 0.0 { nearest * range_m } else { 0.0 };
                apex_world.dot(along) + reach
            }
            Self::Box { center_world, half_axes_world } => {
                center_world.dot(along)
                    + half_axes_world.iter().map(|axis| axis.dot(along).abs()).sum::<f32>()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    /// 20 m by 10 m, 1 m high.
    const GROUND: Aabb = Aabb { min: vec3(-10.0, 0.0, -5.0), max: vec3(10.0, 1.0, 5.0) };

    fn share(reach: Reach) -> f32 {
        reach.share_of(&GROUND)
    }

    #[test]
    fn what_reaches_far_covers_all() {
        assert_eq!(share(Reach::Everywhere), 1.0);
        assert_eq!(share(Reach::Sphere { center_world: Vec3::ZERO, radius_m: 10.0 }), 1.0);
    }

    #[test]
    fn balls_cover_the_square_around_them_and_no_more_than_there_is() {
        let ball = |x, y| share(Reach::Sphere { center_world: vec3(x, y, 0.0), radius_m: 2.0 });
        assert_eq!(ball(0.0, 1.0), 4.0 / 20.0 * (4.0 / 10.0));
        assert_eq!(ball(10.0, 1.0), 2.0 / 20.0 * (4.0 / 10.0));
        assert_eq!(ball(0.0, 4.0), 0.0, "it ends above");
        assert_eq!(ball(20.0, 1.0), 0.0, "it ends beside");
    }

    #[test]
    fn cones_cover_what_they_open_to() {
        let half = 0.5_f32;
        let cone = |range_m| Reach::Cone {
            apex_world: vec3(0.0, 4.0, 0.0),
            direction_world: Vec3::NEG_Y,
            cos: half.cos(),
            sin: half.sin(),
            range_m,
        };
        let width = 2.0 * 5.0 * half.sin();
        assert!((share(cone(5.0)) - width * width / 200.0).abs() < 1e-6);
        assert_eq!(share(cone(2.0)), 0.0, "it ends above");
        assert_eq!(share(cone(f32::INFINITY)), 1.0);
    }

    #[test]
    fn boxes_cover_themselves_and_flat_ground_is_covered_or_not() {
        let at = |y| Reach::Box {
            center_world: vec3(0.0, y, 0.0),
            half_axes_world: [Vec3::X, Vec3::Y, Vec3::Z * 2.0],
        };
        assert_eq!(share(at(0.0)), 2.0 / 20.0 * (4.0 / 10.0));
        let flat = Aabb { max: vec3(10.0, 0.0, 5.0), ..GROUND };
        assert_eq!(at(0.5).share_of(&flat), 2.0 / 20.0 * (4.0 / 10.0));
        assert_eq!(at(1.5).share_of(&flat), 0.0);
    }
}

//! Where a light can be seen at all.

use glam::Vec3;

use crate::scene::{Light, LightKind};

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
}

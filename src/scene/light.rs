//! Punctual lights as KHR_lights_punctual defines them.

use glam::Vec3;

/// A light at a point or from a direction.
#[derive(Clone, Debug)]
pub struct Light {
    /// A name for messages.
    pub name: String,
    /// Linear Rec.709; multiplies the intensity.
    pub color: Vec3,
    /// Type and photometric quantity.
    pub kind: LightKind,
    /// World space, metres. Unused by directional lights.
    pub position_world: Vec3,
    /// World space, unit length: the way the light travels (the node's -Z). Unused by point lights.
    pub direction_world: Vec3,
    /// Distance at which the light ends, smoothly; `None` reaches everywhere. Unused by directional lights.
    pub range_m: Option<f32>,
}

impl Light {
    /// Whether it adds nothing anywhere: no colour, no intensity, or no range.
    pub fn is_dark(&self) -> bool {
        let (intensity, local) = match self.kind {
            LightKind::Directional { illuminance_lx } => (illuminance_lx, false),
            LightKind::Point { intensity_cd } | LightKind::Spot { intensity_cd, .. } => (intensity_cd, true),
        };
        self.color * intensity == Vec3::ZERO || (local && self.range_m == Some(0.0))
    }
}

/// Type of a [`Light`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Infinitely far.
    Directional {
        /// On a surface that faces the light, in lux.
        illuminance_lx: f32,
    },
    /// Alike in all directions.
    Point {
        /// Candela.
        intensity_cd: f32,
    },
    /// Within a cone.
    Spot {
        /// Candela along the axis.
        intensity_cd: f32,
        /// From the axis, radians: full intensity within. 0 <= inner < outer.
        inner_cone_rad: f32,
        /// From the axis, radians: dark outside. At most pi / 2.
        outer_cone_rad: f32,
    },
}

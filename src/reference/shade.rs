//! Light that a surface sends to the viewer: the counterpart of the lighting stage.

use glam::DVec3;

use super::brdf::brdf;
use super::gbuffer::Attributes;
use super::punctual::incident;
use crate::scene::Light;

/// Reflected light of all `lights` in cd/m², before exposure: for each, BRDF * n·l * illuminance (glTF 2.0
/// appendix B). Zero where the surface is not lit.
///
/// `to_viewer` is the unit vector from the surface to the viewer, world space.
pub fn reflected(attributes: &Attributes, to_viewer: DVec3, lights: &[Light]) -> DVec3 {
    if !attributes.lit {
        return DVec3::ZERO;
    }
    let n = attributes.normal_world;
    lights
        .iter()
        .map(|light| {
            let light = incident(light, attributes.position_world);
            let n_dot_l = n.dot(light.to_light);
            if n_dot_l <= 0.0 || light.illuminance == DVec3::ZERO {
                return DVec3::ZERO;
            }
            brdf(attributes, n, to_viewer, light.to_light) * light.illuminance * n_dot_l
        })
        .sum()
}

/// Exposed light towards the viewer: what the surface sends by itself and what it reflects, times `exposure`
/// (the multiplier 2^EV).
pub fn shade(attributes: &Attributes, to_viewer: DVec3, lights: &[Light], exposure: f64) -> DVec3 {
    (attributes.prelit + reflected(attributes, to_viewer, lights)) * exposure
}

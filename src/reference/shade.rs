//! Light that a surface sends to the viewer: the counterpart of the lighting stage.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::brdf::brdf_parts;
use super::gbuffer::Attributes;
use super::punctual::{diffuse_irradiance, incident};
use crate::plan::Brdf;
use crate::scene::Scene;

/// Reflected light of all the scene's lights in cd/m², before exposure: for each, BRDF * n·l * illuminance (glTF 2.0
/// appendix B), plus base colour / pi * irradiance of what is diffuse by definition (back colours, hemispheres; Koonce
/// 2007, 19.4.1). Zero where the surface is not lit.
///
/// `to_viewer` is the unit vector from the surface to the viewer, world space.
/// `hidden` says whether something stands between the surface and the light with this index, in whose direction it is.
pub fn reflected(
    attributes: &Attributes,
    to_viewer: DVec3,
    scene: &Scene,
    hidden: impl Fn(usize, DVec3) -> bool,
) -> DVec3 {
    let [diffuse, specular] = reflected_parts(Brdf::Exact, attributes, to_viewer, scene, hidden);
    diffuse * attributes.diffuse() + specular
}

/// The same as what diffuse albedo multiplies, and the rest, reflection evaluated in a chosen way.
pub fn reflected_parts(
    brdf: Brdf,
    attributes: &Attributes,
    to_viewer: DVec3,
    scene: &Scene,
    hidden: impl Fn(usize, DVec3) -> bool,
) -> [DVec3; 2] {
    if !attributes.lit {
        return [DVec3::ZERO; 2];
    }
    let n = attributes.normal_world;
    scene
        .lights
        .iter()
        .enumerate()
        .filter(|(_, light)| !light.is_dark())
        .map(|(index, light)| {
            let incident = incident(light, &scene.images, attributes.position_world);
            let diffuse = diffuse_irradiance(light, &incident, n) * FRAC_1_PI;
            let n_dot_l = n.dot(incident.to_light);
            if n_dot_l <= 0.0 || incident.illuminance == DVec3::ZERO || hidden(index, incident.to_light) {
                return [diffuse, DVec3::ZERO];
            }
            let (per_albedo, specular) = brdf_parts(brdf, attributes, n, to_viewer, incident.to_light);
            let irradiance = incident.illuminance * n_dot_l;
            [diffuse + irradiance * per_albedo, specular * irradiance]
        })
        .fold([DVec3::ZERO; 2], |[a, b], [c, d]| [a + c, b + d])
}

/// Exposed light towards the viewer: what the surface sends by itself and what it reflects, times `exposure`
/// (the multiplier 2^EV); nothing stands between it and the lights.
pub fn shade(attributes: &Attributes, to_viewer: DVec3, scene: &Scene, exposure: f64) -> DVec3 {
    (attributes.prelit + reflected(attributes, to_viewer, scene, |_, _| false)) * exposure
}

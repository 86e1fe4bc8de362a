//! Surfaces that light goes through.

use glam::DVec3;

use super::fog::fogged;
use super::gbuffer::{Attributes, medium};
use super::view::{Ray, View};
use super::visibility::{Hit, Visibility};
use crate::scene::Transmission;

/// What such a surface makes of light behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Film {
    /// The share of it that arrives.
    pub(super) through: DVec3,
    /// Exposed light that is added, as it arrives at the viewer.
    pub(super) light: DVec3,
    /// How much of a background's colour is covered, whatever is behind it; `None` as follows from `through`.
    pub(super) covered: Option<f64>,
}

/// The surface without what of it lets light through: less diffuse light, and the reflectance of its index of refraction.
pub(super) fn remaining(transmission: &Transmission, surface: &Attributes) -> Attributes {
    let dielectric = DVec3::splat(transmission.f0());
    Attributes {
        base_color: surface.base_color * ((1.0 - surface.metallic) * (1.0 - f64::from(transmission.factor))),
        metallic: 0.0,
        reflectance: Some(dielectric.lerp(surface.base_color, surface.metallic)),
        ..*surface
    }
}

impl Film {
    /// Of a blended hit with the shading normal `normal_world`, if light goes through it: what enters (Schlick 1994) and is not
    /// scattered back, coloured by the surface, is left after its way to what is opaque at the view distance `opaque_m` (infinity:
    /// nothing); beside that, where alpha has no surface, all. `shaded` is exposed light of the surface itself, fog included.
    pub(super) fn new(
        visibility: &Visibility,
        view: &View,
        exposure: f64,
        (ray, hit, opaque_m): (&Ray, &Hit, f64),
        (normal_world, alpha, shaded): (DVec3, f64, DVec3),
    ) -> Option<Self> {
        let (transmission, tint) = tint(visibility, (ray, hit), normal_world)?;
        let way_m = (opaque_m - hit.distance) * ray.direction.length();
        let through = tint * transmission.left_after(way_m) * alpha + (1.0 - alpha);
        // What is behind has its fog already: that before the surface is what is let through of it, and the rest.
        let at = ray.at(hit.distance);
        let fog = visibility.scene.fog.as_ref();
        let fog = fog.map_or(DVec3::ZERO, |fog| fogged(fog, DVec3::ZERO, exposure, view.ray_start(at), at));
        Some(Self { through, light: (shaded - fog) * alpha + fog * (1.0 - through), covered: None })
    }
}

/// The share of light that passes a surface with this shading normal, coloured by it; `None` if light does not go through it.
pub(super) fn tint<'a>(
    visibility: &Visibility<'a>,
    (ray, hit): (&Ray, &Hit),
    normal_world: DVec3,
) -> Option<(&'a Transmission, DVec3)> {
    let (transmission, base_color, metallic) = medium(visibility, hit)?;
    let n_dot_v = normal_world.dot(-ray.direction.normalize()).clamp(0.0, 1.0);
    let entered = (1.0 - transmission.f0()) * (1.0 - (1.0 - n_dot_v).powi(5));
    Some((transmission, base_color * (f64::from(transmission.factor) * (1.0 - metallic) * entered)))
}

/// What is left of light, and how much of what was behind all of them is covered; from far to near.
pub(super) fn behind(light: DVec3, near_to_far: &[Film]) -> (DVec3, f64) {
    near_to_far.iter().rev().fold((light, 0.0), |(light, covered), film| {
        let left = film.through.element_sum() / 3.0;
        (light * film.through + film.light, film.covered.unwrap_or(1.0 - (1.0 - covered) * left))
    })
}

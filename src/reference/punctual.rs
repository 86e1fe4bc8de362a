//! Lights without extent: those of KHR_lights_punctual, boxes and hemispheres.

use glam::DVec3;

use super::globe::globe_color;
use crate::scene::{Image, Light, LightKind};

/// The inverse square law holds down to this distance: a light within 0.1 mm of a surface gets no brighter.
pub const MIN_DISTANCE_M: f64 = 1e-4;

/// Light that arrives at a point from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incident {
    /// Unit vector towards the light, world space: the `l` of the shading formulas.
    pub to_light: DVec3,
    /// On a surface that faces the light, in lux, linear Rec.709.
    pub illuminance: DVec3,
    /// On a surface that faces away from the light, in lux, as diffuse light.
    pub back: DVec3,
}

impl Incident {
    fn front(to_light: DVec3, illuminance: DVec3) -> Self {
        Self { to_light, illuminance, back: DVec3::ZERO }
    }
}

/// Smooth end of a light at its range: KHR_lights_punctual, "Range Property", without the inverse square.
///
/// `inverse_range` is in 1/m; 0 reaches everywhere.
pub fn range_window(distance_m: f64, inverse_range: f64) -> f64 {
    (1.0 - (distance_m * inverse_range).powi(4)).clamp(0.0, 1.0)
}

/// A spot's angle scale and offset: KHR_lights_punctual, "Inner and Outer Cone Angles".
pub fn spot_scale_offset(inner_cone_rad: f64, outer_cone_rad: f64) -> (f64, f64) {
    let scale = 1.0 / (inner_cone_rad.cos() - outer_cone_rad.cos()).max(0.001);
    (scale, -outer_cone_rad.cos() * scale)
}

/// A spot's dimming away from its axis: the same section. `direction_cosine` is between the axis and the way
/// from the light.
pub fn spot_falloff(direction_cosine: f64, scale: f64, offset: f64) -> f64 {
    let falloff = (direction_cosine * scale + offset).clamp(0.0, 1.0);
    falloff * falloff
}

/// From infinitely far: the same everywhere. Surfaces that face away get `back_lx` (Koonce 2007, 19.4.1).
pub fn light_directional(direction_world: DVec3, color_lx: DVec3, back_lx: DVec3) -> Incident {
    Incident { back: back_lx, ..Incident::front(-direction_world, color_lx) }
}

/// Alike in all directions: intensity over the distance squared, within the range.
pub fn light_point(
    light_world: DVec3,
    color_cd: DVec3,
    inverse_range: f64,
    position_world: DVec3,
) -> Incident {
    let way = light_world - position_world;
    let distance = way.length();
    let guarded = distance.max(MIN_DISTANCE_M);
    let window = range_window(distance, inverse_range);
    Incident::front(way / guarded, color_cd * (window / (guarded * guarded)))
}

/// A point light within a cone.
pub fn light_spot(
    light_world: DVec3,
    direction_world: DVec3,
    color_cd: DVec3,
    inverse_range: f64,
    (scale, offset): (f64, f64),
    position_world: DVec3,
) -> Incident {
    let incident = light_point(light_world, color_cd, inverse_range, position_world);
    let falloff = spot_falloff(direction_world.dot(-incident.to_light), scale, offset);
    Incident { illuminance: incident.illuminance * falloff, ..incident }
}

/// How much of a box light there is at `position_light` (the light's frame, metres from its centre): 0 outside the
/// box, smoothstep over the falloff inside each face, the three axes multiplied.
///
/// The falloff is held between [`MIN_DISTANCE_M`] and half the extent.
pub fn box_window(position_light: DVec3, half_size_m: DVec3, falloff_m: f64) -> f64 {
    let inside = half_size_m - position_light.abs();
    let falloff = DVec3::splat(falloff_m.max(MIN_DISTANCE_M)).min(half_size_m);
    let t = (inside / falloff).clamp(DVec3::ZERO, DVec3::ONE);
    (t * t * (3.0 - 2.0 * t)).element_product()
}

/// Irradiance of a hemisphere light, lux: two half spheres of uniform radiance, of which a surface at cosine
/// `n_dot_up` from the middle of the upper one sees the shares (1 + n·up) / 2 and (1 - n·up) / 2.
pub fn light_hemisphere(n_dot_up: f64, color_lx: DVec3, ground_lx: DVec3) -> DVec3 {
    ground_lx.lerp(color_lx, 0.5 + 0.5 * n_dot_up)
}

/// The light that arrives at a point from one direction, nothing but its globe map standing in the way; none of
/// hemispheres. `images` are the scene's. Light from behind does not come through the globe map.
pub fn incident(light: &Light, images: &[Image], position_world: DVec3) -> Incident {
    let incident = bare(light, position_world);
    if incident.illuminance == DVec3::ZERO {
        return incident;
    }
    Incident { illuminance: incident.illuminance * globe_color(light, images, position_world), ..incident }
}

/// [`incident`] without globe map.
fn bare(light: &Light, position_world: DVec3) -> Incident {
    let color = light.color.as_dvec3();
    let back = light.back_color.as_dvec3();
    let place = light.position_world.as_dvec3();
    let direction = light.direction_world.as_dvec3();
    let inverse_range = light.range_m.map_or(0.0, |range| f64::from(range).recip());
    match light.kind {
        LightKind::Directional { illuminance_lx } => {
            light_directional(direction, color * f64::from(illuminance_lx), back * f64::from(illuminance_lx))
        }
        LightKind::Point { intensity_cd } => {
            light_point(place, color * f64::from(intensity_cd), inverse_range, position_world)
        }
        LightKind::Spot { intensity_cd, inner_cone_rad, outer_cone_rad } => light_spot(
            place,
            direction,
            color * f64::from(intensity_cd),
            inverse_range,
            spot_scale_offset(f64::from(inner_cone_rad), f64::from(outer_cone_rad)),
            position_world,
        ),
        LightKind::Box { illuminance_lx, size_m, falloff_m } => {
            let up = light.up_world.as_dvec3();
            let from_center = position_world - place;
            let position_light = DVec3::new(
                from_center.dot(direction.cross(up)),
                from_center.dot(up),
                -from_center.dot(direction),
            );
            let window = box_window(position_light, size_m.as_dvec3() * 0.5, f64::from(falloff_m));
            let amount = f64::from(illuminance_lx) * window;
            light_directional(direction, color * amount, back * amount)
        }
        LightKind::Hemisphere { .. } => Incident::front(-direction, DVec3::ZERO),
    }
}

/// Diffuse light on a surface with this normal beside what comes from one direction, lux.
pub fn diffuse_irradiance(light: &Light, incident: &Incident, normal_world: DVec3) -> DVec3 {
    let n_dot_l = normal_world.dot(incident.to_light);
    match light.kind {
        LightKind::Hemisphere { illuminance_lx } => {
            let scale = f64::from(illuminance_lx);
            light_hemisphere(n_dot_l, light.color.as_dvec3() * scale, light.back_color.as_dvec3() * scale)
        }
        _ => incident.back * (-n_dot_l).max(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    #[test]
    fn the_range_ends_where_the_extension_says() {
        assert_eq!(range_window(0.0, 0.1), 1.0);
        assert_eq!(range_window(10.0, 0.1), 0.0);
        assert_eq!(range_window(25.0, 0.1), 0.0);
        assert_eq!(range_window(5.0, 0.1), 15.0 / 16.0);
        assert_eq!(range_window(1e9, 0.0), 1.0);
        // Its slope at the end is -4 / range: not an abrupt cut.
        let slope = (range_window(10.0 - 1e-6, 0.1) - range_window(10.0, 0.1)) / 1e-6;
        assert!((slope - 0.4).abs() < 1e-6);
    }

    #[test]
    fn the_cone_is_full_inside_and_dark_outside() {
        for (inner, outer) in [(0.0, FRAC_PI_4), (0.3, 0.5), (0.2, FRAC_PI_2)] {
            let (scale, offset) = spot_scale_offset(inner, outer);
            let at = |angle: f64| spot_falloff(angle.cos(), scale, offset);
            assert_eq!(at(outer + 1e-3), 0.0);
            assert!(at(outer) < 1e-12);
            assert!((at(inner) - 1.0).abs() < 1e-12 && (at(inner * 0.5) - 1.0).abs() < 1e-12);
            // Halfway between the cosines: half, squared.
            let cosine = (inner.cos() + outer.cos()) / 2.0;
            assert!((spot_falloff(cosine, scale, offset) - 0.25).abs() < 1e-12);
        }
    }

    #[test]
    fn equal_cones_do_not_divide_by_zero() {
        let (scale, offset) = spot_scale_offset(0.5, 0.5);
        assert_eq!(scale, 1000.0);
        assert_eq!(spot_falloff(0.5_f64.cos() - 1e-6, scale, offset), 0.0);
        assert_eq!(spot_falloff(0.5_f64.cos() + 1.1e-3, scale, offset), 1.0);
    }

    #[test]
    fn a_point_lights_flux_does_not_depend_on_the_sphere() {
        // 1 cd in all directions is 4 pi lumens, through a sphere of any radius.
        let mut lamp = Light::new(LightKind::Point { intensity_cd: 1.0 });
        lamp.position_world = glam::Vec3::ZERO;
        for radius in [0.01, 1.0, 50.0] {
            let at = incident(&lamp, &[], DVec3::new(0.0, radius, 0.0));
            assert!((at.illuminance.x * 4.0 * PI * radius * radius / (4.0 * PI) - 1.0).abs() < 1e-12);
            assert_eq!(at.to_light, DVec3::NEG_Y);
        }
        assert!(incident(&lamp, &[], DVec3::ZERO).illuminance.is_finite());
    }

    #[test]
    fn kinds_and_colours() {
        let mut lamp = Light::new(LightKind::Directional { illuminance_lx: 3.0 });
        lamp.color = glam::Vec3::new(1.0, 0.5, 0.0);
        lamp.direction_world = glam::Vec3::NEG_Y;
        let at = incident(&lamp, &[], DVec3::splat(1e3));
        assert_eq!((at.to_light, at.illuminance), (DVec3::Y, DVec3::new(3.0, 1.5, 0.0)));

        lamp.kind = LightKind::Spot { intensity_cd: 8.0, inner_cone_rad: 0.1, outer_cone_rad: 0.5 };
        lamp.position_world = glam::Vec3::new(0.0, 2.0, 0.0);
        let below = incident(&lamp, &[], DVec3::ZERO);
        assert!((below.illuminance - DVec3::new(2.0, 1.0, 0.0)).length() < 1e-12);
        assert_eq!(incident(&lamp, &[], DVec3::new(0.0, 4.0, 0.0)).illuminance, DVec3::ZERO);
        assert_eq!(incident(&lamp, &[], DVec3::new(3.0, 0.0, 0.0)).illuminance, DVec3::ZERO);
    }
}

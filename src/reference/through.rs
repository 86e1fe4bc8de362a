//! Light that is followed through media by rays, from surface to surface: what is seen where nothing is left to a picture.
//!
//! A medium fills the space behind its surface as far as the next such surface or something opaque, and absorbs on a way of its
//! thickness at most. Surfaces bend rays by Snell's law and let through what [`tint`] says; what they reflect of what is beside them
//! is left out, as everywhere, and so are fog and backgrounds' colours, which are of the display.

use glam::DVec3;

use super::around::Around;
use super::gbuffer::attributes;
use super::media::{Film, tint};
use super::refraction::refract;
use super::settings::Settings;
use super::shade::reflected_parts;
use super::shadow::Occlusion;
use super::view::{Ray, View};
use super::visibility::{Hit, Visibility};
use crate::scene::{Background, Transmission};

/// Surfaces after which a ray is given up.
const MOST_SURFACES: u32 = 16;

/// What rays meet behind a surface.
pub(super) struct Through<'a> {
    pub(super) opaque: &'a Visibility<'a>,
    pub(super) blended: &'a Visibility<'a>,
    pub(super) around: &'a Around<'a>,
    pub(super) occlusion: Option<&'a Occlusion<'a>>,
    pub(super) view: &'a View,
    pub(super) settings: &'a Settings,
}

impl Through<'_> {
    /// As [`Film::new`] of a hit, whose light takes the place of all that is behind it.
    pub(super) fn film(
        &self,
        (ray, hit): (&Ray, &Hit),
        (normal_world, alpha, shaded): (DVec3, f64, DVec3),
    ) -> Option<Film> {
        let (medium, tint) = tint(self.blended, (ray, hit), normal_world)?;
        let (position_world, direction) = (ray.at(hit.distance), ray.direction.normalize());
        let bent = refract(direction, normal_world, 1.0 / f64::from(medium.ior));
        let inside = self.arriving(position_world, bent, Some(medium), MOST_SURFACES) * tint;
        let beside = match alpha < 1.0 {
            true => self.arriving(position_world, direction, None, MOST_SURFACES),
            false => DVec3::ZERO,
        };
        let light = (shaded + inside) * alpha + beside * (1.0 - alpha);
        Some(Film { through: DVec3::ZERO, light, covered: Some(1.0) })
    }

    /// Exposed light that arrives from this direction through a medium.
    fn arriving(
        &self,
        origin: DVec3,
        direction: DVec3,
        medium: Option<&Transmission>,
        surfaces: u32,
    ) -> DVec3 {
        const LEAST_WAY: f64 = 1e-9;
        let range = [LEAST_WAY * (1.0 + origin.length()), f64::INFINITY];
        let ray = Ray { origin, direction, range };
        let opaque = self.opaque.trace(&ray);
        let end_m = opaque.map_or(f64::INFINITY, |hit| hit.distance);
        let normal_of = |hit: &Hit| {
            attributes(self.blended, self.around, self.view, ray.at(hit.distance), hit).normal_world
        };
        let next = self.blended.trace_all(&ray, end_m).into_iter().find_map(|hit| {
            let normal_world = normal_of(&hit);
            tint(self.blended, (&ray, &hit), normal_world).map(|film| (hit, normal_world, film))
        });
        let way_m = next.as_ref().map_or(end_m, |(hit, ..)| hit.distance);
        let left = medium.map_or(DVec3::ONE, |medium| medium.left_after(way_m));
        left * match (next, opaque) {
            (Some(_), _) if surfaces == 0 => DVec3::ZERO,
            (Some((hit, normal_world, (next, tint))), _) => {
                let here = medium.map_or(1.0, |medium| f64::from(medium.ior));
                let bent = refract(direction, normal_world, here / f64::from(next.ior));
                self.arriving(ray.at(hit.distance), bent, Some(next), surfaces - 1) * tint
            }
            (None, Some(hit)) => self.sent(&ray, &hit),
            (None, None) => match self.opaque.scene.background {
                Background::Environment => self.around.sky(direction) * self.settings.exposure(),
                Background::Black | Background::Color(_) => DVec3::ZERO,
            },
        }
    }

    /// Exposed light that an opaque surface sends back along a ray; of light from all around, what it sends to the viewer.
    fn sent(&self, ray: &Ray, hit: &Hit) -> DVec3 {
        let position_world = ray.at(hit.distance);
        let surface = attributes(self.opaque, self.around, self.view, position_world, hit);
        let lights = &self.opaque.scene.lights;
        let hidden = |light: usize, to_light| {
            let hides =
                |o: &Occlusion| o.hides(&lights[light], position_world, surface.normal_world, to_light);
            self.occlusion.is_some_and(hides)
        };
        let to_viewer = -ray.direction;
        let [diffuse, specular] =
            reflected_parts(self.settings.brdf, &surface, to_viewer, self.opaque.scene, hidden);
        (surface.prelit + diffuse * surface.diffuse() + specular) * self.settings.exposure()
    }
}

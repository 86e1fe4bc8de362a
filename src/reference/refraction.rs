//! What is behind surfaces that bend light, as far as a picture of what is opaque shows it.
//!
//! The model is that of KHR_materials_volume's sample viewer (`getVolumeTransmissionRay`, `getIBLVolumeRefraction`): the view ray is
//! bent by Snell's law, ends after some way, and what the picture shows there is taken for what it meets. Two things are other
//! here: the ray ends as far below the surface as the unbent one does where it meets something opaque, and after the medium's
//! thickness at most, so that what stands out of water is whole, and a bottom that is parallel to the surface is seen where it
//! is; and what absorbs is the way to what was found.

use glam::{DVec2, DVec3};

use super::fog::fogged;
use super::frame::Frame;
use super::media::{Film, tint};
use super::view::{Ray, View};
use super::visibility::{Hit, Visibility};
use crate::scene::Transmission;

/// The picture of what is opaque.
pub(super) struct Backdrop {
    picture: Frame,
}

/// Light that arrives at a surface from inside.
#[derive(Clone, Copy, Debug, Default)]
struct Bent {
    light: DVec3,
    /// The share that its way has left.
    left: DVec3,
    /// That of a background's colour.
    background: DVec3,
}

impl Backdrop {
    /// Of a picture in which nothing lies over what is opaque.
    pub(super) fn new(picture: Frame) -> Self {
        Self { picture }
    }

    /// As [`Film::new`] of a pixel; and whether a rasteriser may rightly find something else.
    pub(super) fn film(
        &self,
        visibility: &Visibility,
        (view, pixel): (&View, [u32; 2]),
        exposure: f64,
        (ray, hit): (&Ray, &Hit),
        (normal_world, alpha, shaded): (DVec3, f64, DVec3),
    ) -> Option<(Film, bool)> {
        let (transmission, tint) = tint(visibility, (ray, hit), normal_world)?;
        let tint = tint * alpha;
        let (bent, edge) = self.bent(view, pixel, (ray, hit), normal_world, transmission);
        let through = tint * bent.left + (1.0 - alpha);
        let ahead = self.picture.pixel(pixel[0], pixel[1]);
        let at = ray.at(hit.distance);
        let fog = visibility.scene.fog.as_ref();
        let fog = fog.map_or(DVec3::ZERO, |fog| fogged(fog, DVec3::ZERO, exposure, view.ray_start(at), at));
        let behind = bent.light * tint + ahead.linear * (1.0 - alpha);
        let open = if ahead.covered { 0.0 } else { 1.0 - alpha };
        let covered = 1.0 - (bent.background * tint).element_sum() / 3.0 - open;
        let light = (shaded - fog) * alpha + fog * (1.0 - through) + behind;
        Some((Film { through: DVec3::ZERO, light, covered: Some(covered) }, edge))
    }

    fn bent(
        &self,
        view: &View,
        pixel: [u32; 2],
        (ray, hit): (&Ray, &Hit),
        normal_world: DVec3,
        transmission: &Transmission,
    ) -> (Bent, bool) {
        let position_world = ray.at(hit.distance);
        let direction = refract(ray.direction.normalize(), normal_world, 1.0 / f64::from(transmission.ior));
        let steeper =
            normal_world.dot(-ray.direction.normalize()).max(0.0) / (-normal_world.dot(direction)).max(1e-6);
        let end_world = position_world + direction * self.way_m(position_world, pixel, transmission, steeper);
        let last = self.picture.size.map(|side| side - 1);
        let (mut sum, mut weights, mut edge) = (Bent::default(), 0.0, false);
        if let Some(place) = view.place(end_world) {
            let place = (place - 0.5).clamp(DVec2::ZERO, DVec2::new(f64::from(last[0]), f64::from(last[1])));
            let first = place.floor();
            let share = place - first;
            for corner in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                let of = |axis: usize| if corner[axis] == 0 { 1.0 - share[axis] } else { share[axis] };
                let pixel = [0, 1].map(|axis| (first[axis] as u32 + corner[axis]).min(last[axis]));
                edge = edge || self.picture.pixel(pixel[0], pixel[1]).edge;
                if self.distance(view, pixel) > hit.distance {
                    self.add(&mut sum, (position_world, pixel), transmission, of(0) * of(1));
                    weights += of(0) * of(1);
                }
            }
        }
        if weights > 0.0 {
            let Bent { light, left, background } = sum;
            return (
                Bent { light: light / weights, left: left / weights, background: background / weights },
                edge,
            );
        }
        self.add(&mut sum, (position_world, pixel), transmission, 1.0);
        (sum, edge)
    }

    fn add(
        &self,
        sum: &mut Bent,
        (position_world, pixel): (DVec3, [u32; 2]),
        transmission: &Transmission,
        weight: f64,
    ) {
        let shown = self.picture.pixel(pixel[0], pixel[1]);
        let left = transmission.left_after(self.way_m(position_world, pixel, transmission, 1.0)) * weight;
        sum.light += shown.linear * left;
        sum.left += left;
        sum.background += if shown.covered { DVec3::ZERO } else { left };
    }

    /// To what a pixel shows, or a share of that: light takes no longer way than the medium is thick, also from where nothing is.
    fn way_m(&self, position_world: DVec3, [x, y]: [u32; 2], transmission: &Transmission, share: f64) -> f64 {
        let shown = self.picture.pixel(x, y);
        let most = f64::from(transmission.thickness_m);
        let way = shown.attributes.position_world.distance(position_world) * share;
        if shown.covered { way.min(most) } else { most }
    }

    /// View distance of what a pixel shows.
    fn distance(&self, view: &View, [x, y]: [u32; 2]) -> f64 {
        let shown = self.picture.pixel(x, y);
        let way = shown.attributes.position_world - view.position_world;
        if shown.covered { way.dot(view.forward_world) } else { f64::INFINITY }
    }
}

/// Snell's law for a ray of this direction, both of unit length, that enters what is `1 / eta` as dense (`refract` of GLSL).
pub(crate) fn refract(direction: DVec3, normal: DVec3, eta: f64) -> DVec3 {
    let cosine = -normal.dot(direction);
    let inside = (1.0 - eta * eta * (1.0 - cosine * cosine)).max(0.0).sqrt();
    direction * eta + normal * (eta * cosine - inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_are_as_the_indices_of_refraction() {
        for degrees in [0.0_f64, 20.0, 60.0, 89.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let bent = refract(DVec3::new(sine, -cosine, 0.0), DVec3::Y, 1.0 / 1.333);
            assert!((bent.length() - 1.0).abs() < 1e-12 && bent.y < 0.0);
            assert!((bent.x * 1.333 - sine).abs() < 1e-12, "{degrees}: {bent}");
        }
    }
}

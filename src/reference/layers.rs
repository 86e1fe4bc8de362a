//! What is blended over a pixel: every surface along its ray, in its exact order.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::edges::{SNAP_PX, is_creased, is_torn};
use super::gbuffer;
use super::view::{Ray, View};
use super::visibility::{Hit, Visibility};
use crate::scene::Scene;

/// Light that one surface lays over what is behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Exposed light that leaves it towards the viewer, as it arrives there, not yet multiplied by `alpha`.
    pub light: DVec3,
    /// The part of what is behind that it covers, 0 to 1.
    pub alpha: f64,
}

/// The operator "over" (Porter and Duff 1984, "Compositing Digital Images") for every layer, from far to near. Returns the light
/// and how much of what was behind all of them is covered.
pub fn over(behind: DVec3, near_to_far: &[Layer]) -> (DVec3, f64) {
    let start = (behind, 0.0);
    near_to_far.iter().rev().fold(start, |(light, covered), layer| {
        (light.lerp(layer.light, layer.alpha), covered + (1.0 - covered) * layer.alpha)
    })
}

/// The blended surfaces of a scene.
pub struct Blended<'a> {
    visibility: Visibility<'a>,
}

/// Those along each ray of a regular grid, one pixel apart.
pub struct BlendedLattice {
    width: u32,
    height: u32,
    start_px: f64,
    hits: Vec<Vec<Hit>>,
}

impl<'a> Blended<'a> {
    /// Of a scene; `None` if nothing in it is blended.
    pub fn new(scene: &'a Scene) -> Option<Self> {
        let any = scene.drawn_instances().any(|instance| scene.is_blended(instance));
        any.then(|| Self { visibility: Visibility::blended(scene) })
    }

    /// The triangles.
    pub fn visibility(&self) -> &Visibility<'a> {
        &self.visibility
    }

    /// The alpha of a hit, clamped as the blending does.
    pub fn alpha(&self, hit: &Hit) -> f64 {
        gbuffer::alpha(&self.visibility, hit).clamp(0.0, 1.0)
    }

    /// All hits along rays through a grid that are before what is opaque there.
    pub fn trace(
        &self,
        opaque: &Visibility,
        view: &View,
        [width, height]: [u32; 2],
        start_px: f64,
    ) -> BlendedLattice {
        let hits = (0..width * height).into_par_iter().map(|i| {
            let place = DVec2::new(f64::from(i % width), f64::from(i / width)) + start_px;
            self.before(opaque, &view.ray(place))
        });
        BlendedLattice { width, height, start_px, hits: hits.collect() }
    }

    fn before(&self, opaque: &Visibility, ray: &Ray) -> Vec<Hit> {
        let all = self.visibility.trace_all(ray, f64::INFINITY);
        if all.is_empty() {
            return all;
        }
        let end = opaque.trace(ray).map_or(f64::INFINITY, |hit| hit.distance);
        all.into_iter().take_while(|hit| hit.distance < end).collect()
    }

    /// As the opaque surfaces' edges: whether the layers around a pixel are not the same ones side by side.
    pub fn is_edge(
        &self,
        opaque: &Visibility,
        view: &View,
        [centers, corners]: [&BlendedLattice; 2],
        [x, y]: [u32; 2],
    ) -> bool {
        let hits = centers.at(x, y);
        let ray = view.ray_through_pixel([x, y]);
        let torn = |(other_ray, other): (Ray, &[Hit])| {
            let pair = |(a, b): (&Hit, &Hit)| is_torn(&self.visibility, (&ray, a), (&other_ray, b));
            hits.len() != other.len() || hits.iter().zip(other).any(pair)
        };
        let around = centers.around(view, [x.saturating_sub(1), y.saturating_sub(1)], [x + 1, y + 1]);
        if around.chain(corners.around(view, [x, y], [x + 1, y + 1])).any(torn) {
            return true;
        }
        let center_px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].into_iter().any(|(dx, dy)| {
            let near_ray = view.ray(center_px + DVec2::new(dx, dy) * SNAP_PX);
            let near = self.before(opaque, &near_ray);
            let pair = |(a, b): (&Hit, &Hit)| is_creased(&self.visibility, a, &near_ray, b);
            hits.len() != near.len() || hits.iter().zip(&near).any(pair)
        })
    }
}

impl BlendedLattice {
    /// The hits of one ray, from near to far.
    pub fn at(&self, x: u32, y: u32) -> &[Hit] {
        &self.hits[(y * self.width + x) as usize]
    }

    /// Those from one place to another, as far as the grid goes, with their rays.
    fn around(&self, view: &View, from: [u32; 2], to: [u32; 2]) -> impl Iterator<Item = (Ray, &[Hit])> {
        let last = [to[0].min(self.width - 1), to[1].min(self.height - 1)];
        let places = (from[1]..=last[1]).flat_map(move |y| (from[0]..=last[0]).map(move |x| (x, y)));
        places.map(move |(x, y)| {
            let place = DVec2::new(f64::from(x), f64::from(y)) + self.start_px;
            (view.ray(place), self.at(x, y))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_lie_over_each_other_in_order() {
        let layer = |light: f64, alpha| Layer { light: DVec3::splat(light), alpha };
        let (light, covered) = over(DVec3::ONE, &[layer(4.0, 0.5), layer(8.0, 0.25)]);
        // 1 * 0.75 + 8 * 0.25 = 2.75, of which half is left beside 4 * 0.5.
        assert_eq!((light, covered), (DVec3::splat(3.375), 0.625));
        assert_eq!(over(DVec3::ONE, &[layer(4.0, 0.0), layer(8.0, 0.0)]), (DVec3::ONE, 0.0));
        assert_eq!(over(DVec3::ONE, &[layer(4.0, 1.0), layer(8.0, 0.5)]), (DVec3::splat(4.0), 1.0));
    }
}

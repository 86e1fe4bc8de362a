//! Diffuse light by path tracing: what lightmaps are baked from.
//!
//! The irradiance of a point is estimated with the rendering equation for surfaces that scatter alike in all
//! directions (Kajiya, "The Rendering Equation", SIGGRAPH 1986; radiosity form: Goral et al., SIGGRAPH 1984). With
//! E(x) the irradiance, a the albedo, Le emitted radiance, and y(x, w) the first surface that x sees along w:
//!
//! ```text
//! E(x) = sum over lights of V n.l El(x)  +  integral of (Le(y) + a(y) E(y) / pi) n.w dw
//! ```
//!
//! One sample follows one path. Directions are drawn by the cosine, density n.w / pi, so every vertex weighs its
//! light by the product of the albedos before it and nothing else. At each vertex all lights are asked, those with
//! shadows by a ray (next event estimation), one point is drawn on the surfaces that send light of their own, and one
//! direction of the environment. Both are found by the path too; the ways are weighed by the balance heuristic (Veach
//! and Guibas, "Optimally Combining Sampling Techniques", SIGGRAPH 1995, section 3.2). Paths end after a fixed number of bounces, so light that was reflected more often than that is missing, and nothing
//! else is: with albedo a and b bounces at most the share a^(b+1).
//!
//! How surfaces take part:
//! - what they reflect in all is their base colour, whether dielectric or metal, and goes to all directions alike;
//! - emissive surfaces send their emission, unlit ones their base colour: the radiance that a picture shows;
//! - sides that are never drawn (backs of single-sided materials) stop light, and send and reflect none;
//! - places that an alpha mask cuts out let light through.

mod emitters;
mod far;
mod sampling;

use std::f64::consts::PI;

use glam::DVec3;

use super::gbuffer::{corner_normals, diffuse_albedo, own_light};
use super::punctual::{diffuse_irradiance, incident};
use super::view::Ray;
use super::visibility::{Hit, Visibility};
use crate::scene::{Light, LightKind, Scene};
use emitters::Emitters;
use far::FarLight;
pub use sampling::{Random, quasi_random};
use sampling::{cosine_direction, fraction};

/// Rays start this far from the surface, as a share of the largest coordinate: far above the rounding of f64, far
/// below anything that is modelled.
const OFFSET: f64 = 1e-7;

/// A scene, ready for paths.
pub struct Paths<'a> {
    visibility: Visibility<'a>,
    lights: Vec<&'a Light>,
    emitters: Emitters,
    far: FarLight,
    bounces: u32,
}

/// A point of a surface that receives light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// World space, metres.
    pub position_world: DVec3,
    /// World space, unit length: irradiance is that of a plane with this normal.
    pub normal_world: DVec3,
    /// World space, unit length: of the triangle, on the side that receives. Rays start on this side.
    pub plane_normal_world: DVec3,
}

/// What one path brings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// An estimate of the irradiance, in lux.
    pub irradiance: DVec3,
    /// Whether the path's first ray meets a side that is never drawn: the receiver may be inside something.
    pub is_enclosed: bool,
}

impl<'a> Paths<'a> {
    /// The scene's surfaces that do not move, lit by `lights`, by what surfaces send themselves, and from far away. After
    /// `bounces` reflections light is not followed; 0 gives direct light.
    ///
    /// # Panics
    /// If an index within the scene is out of range.
    pub fn new(scene: &'a Scene, lights: Vec<&'a Light>, bounces: u32) -> Self {
        let visibility = Visibility::of(scene, |instance| !instance.dynamic);
        let emitters = Emitters::new(&visibility);
        Self { visibility, lights, emitters, far: FarLight::new(scene), bounces }
    }

    /// Whether there is no light to be found.
    pub fn are_dark(&self) -> bool {
        self.lights.is_empty() && self.emitters.is_empty() && self.far.is_dark()
    }

    /// The scene's triangles.
    pub fn visibility(&self) -> &Visibility<'a> {
        &self.visibility
    }

    /// A point on the front of a triangle (its index among all triangles of [`Self::visibility`]).
    ///
    /// Where vertex normals make a bulge of flat triangles, the point is lifted onto it, so that the triangles around do not
    /// hide what the bulge would see (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021).
    pub fn receiver_on(&self, triangle: u32, barycentric: [f64; 3]) -> Receiver {
        let hit = Hit { distance: 0.0, triangle, barycentric, front_facing: true };
        let corners = self.visibility.triangles[triangle as usize].corners_world;
        let flat = self.visibility.front_normal(&hit);
        let normals = corner_normals(&self.visibility, triangle).unwrap_or([flat; 3]);
        let on_plane: DVec3 = (0..3).map(|k| corners[k] * barycentric[k]).sum();
        let lift: DVec3 = (0..3)
            .map(|k| normals[k] * (normals[k].dot(corners[k] - on_plane).max(0.0) * barycentric[k]))
            .sum();
        let normal: DVec3 = (0..3).map(|k| normals[k] * barycentric[k]).sum();
        Receiver {
            position_world: on_plane + lift,
            normal_world: normal.try_normalize().unwrap_or(flat),
            plane_normal_world: flat,
        }
    }

    /// Irradiance in lux: the mean of `samples` paths. The same seed gives the same result.
    pub fn irradiance(&self, receiver: &Receiver, samples: u32, seed: u64) -> DVec3 {
        let mut random = Random::new(seed);
        let start = [random.next(), random.next()];
        let sum: DVec3 =
            (0..samples).map(|i| self.sample(receiver, quasi_random(i, start), &mut random).irradiance).sum();
        sum / f64::from(samples.max(1))
    }

    /// One path. `first` in \[0, 1) decides its first direction, `random` everything else.
    pub fn sample(&self, receiver: &Receiver, first: [f64; 2], random: &mut Random) -> Sample {
        let mut at = *receiver;
        let mut throughput = DVec3::ONE;
        let mut irradiance = self.direct(&at, random);
        let mut direction = cosine_direction(at.normal_world, first);
        let mut is_enclosed = false;
        for bounce in 0.. {
            let ray = ray_from(&at, direction, f64::INFINITY);
            let Some(hit) = self.visibility.trace_solid(&ray) else {
                let by_cosine = at.normal_world.dot(direction).max(0.0) / PI;
                let share = fraction(by_cosine, self.far.density(direction));
                irradiance +=
                    throughput * PI * (self.far.ambient_nt() + self.far.radiance(direction) * share);
                break;
            };
            if !self.visibility.is_drawn(&hit) {
                is_enclosed = bounce == 0;
                break;
            }
            let own = own_light(&self.visibility, &hit);
            if own != DVec3::ZERO {
                let by_cosine = at.normal_world.dot(direction).max(0.0) / PI;
                let by_area = self.emitters.density(&self.visibility, &hit, direction, hit.distance);
                irradiance += throughput * PI * own * fraction(by_cosine, by_area);
            }
            if bounce == self.bounces {
                break;
            }
            throughput *= diffuse_albedo(&self.visibility, &hit);
            if throughput == DVec3::ZERO {
                break;
            }
            at = self.receiver(&ray, &hit);
            irradiance += throughput * self.direct(&at, random);
            direction = cosine_direction(at.normal_world, [random.next(), random.next()]);
        }
        Sample { irradiance, is_enclosed }
    }

    /// Irradiance in lux from the lights; from one point of the surfaces that send light, and from one direction of the
    /// environment, their shares by the balance heuristic.
    fn direct(&self, at: &Receiver, random: &mut Random) -> DVec3 {
        let lights: DVec3 = self.lights.iter().map(|light| self.light_of(light, at)).sum();
        lights + self.of_emitters(at, random) + self.of_environment(at, random)
    }

    fn of_environment(&self, at: &Receiver, random: &mut Random) -> DVec3 {
        let Some(direction) = self.far.draw(random) else { return DVec3::ZERO };
        let (cosine, density) = (at.normal_world.dot(direction), self.far.density(direction));
        if cosine <= 0.0
            || density <= 0.0
            || self.visibility.is_blocked(&ray_from(at, direction, f64::INFINITY))
        {
            return DVec3::ZERO;
        }
        self.far.radiance(direction) * (cosine / (density + cosine / PI))
    }

    fn of_emitters(&self, at: &Receiver, random: &mut Random) -> DVec3 {
        let Some(point) = self.emitters.draw(&self.visibility, random) else { return DVec3::ZERO };
        let way = point.position_world - at.position_world;
        let (distance, direction) = (way.length(), way.normalize_or_zero());
        let cosine = at.normal_world.dot(direction);
        let by_area = self.emitters.density(&self.visibility, &point.hit, direction, distance);
        if cosine <= 0.0 || !by_area.is_finite() || by_area <= 0.0 {
            return DVec3::ZERO;
        }
        // The ray starts off the surface: it ends as far before the point.
        let ray = ray_from(at, direction, distance);
        let end = (point.position_world - ray.origin).length() * (1.0 - OFFSET) - offset(at.position_world);
        if self.visibility.is_blocked(&Ray { range: [0.0, end], ..ray }) {
            return DVec3::ZERO;
        }
        own_light(&self.visibility, &point.hit) * (cosine / (by_area + cosine / PI))
    }

    fn light_of(&self, light: &Light, at: &Receiver) -> DVec3 {
        let arriving = incident(light, &self.visibility.scene.images, at.position_world);
        let from_all_around = diffuse_irradiance(light, &arriving, at.normal_world);
        let cosine = at.normal_world.dot(arriving.to_light);
        if cosine <= 0.0 || arriving.illuminance == DVec3::ZERO {
            return from_all_around;
        }
        let ray = ray_from(at, arriving.to_light, distance_to(light, at.position_world));
        if light.shadow.is_some() && self.visibility.is_blocked(&ray) {
            return from_all_around;
        }
        from_all_around + arriving.illuminance * cosine
    }

    /// The hit surface's point, on the side that the ray comes from; flat, as its triangle is.
    fn receiver(&self, ray: &Ray, hit: &Hit) -> Receiver {
        let plane_normal = self.visibility.plane_normal(hit);
        let normal = if plane_normal.dot(ray.direction) > 0.0 { -plane_normal } else { plane_normal };
        Receiver { position_world: ray.at(hit.distance), normal_world: normal, plane_normal_world: normal }
    }
}

/// How far the light comes, in metres: what is farther casts no shadow.
fn distance_to(light: &Light, position: DVec3) -> f64 {
    let way = light.position_world.as_dvec3() - position;
    match light.kind {
        LightKind::Directional { .. } | LightKind::Hemisphere { .. } => f64::INFINITY,
        // From the face that the light enters by.
        LightKind::Box { size_m, .. } => {
            f64::from(size_m.z) * 0.5 - way.dot(light.direction_world.as_dvec3())
        }
        LightKind::Point { .. } | LightKind::Spot { .. } => way.length(),
    }
}

fn offset(position: DVec3) -> f64 {
    position.abs().max_element().max(1e-3) * OFFSET
}

/// A ray whose parameter is metres, from the receiver's side of its triangle.
fn ray_from(at: &Receiver, direction: DVec3, distance: f64) -> Ray {
    let origin = at.position_world + at.plane_normal_world * offset(at.position_world);
    Ray { origin, direction, range: [0.0, distance] }
}

#[cfg(test)]
mod tests;

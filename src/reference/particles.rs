//! Light that particles add to a pixel.

use glam::{DVec2, DVec3};

use super::edges::SNAP_PX;
use super::fog::transmittance;
use super::texture::{Encoding, sample};
use super::view::{Ray, View};
use crate::scene::{Particle, Particles, Scene};

/// A scene's particles.
pub(super) struct Sparks<'a> {
    scene: &'a Scene,
}

/// What of them a pixel shows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shine {
    /// Light as it arrives at the viewer, cd/m².
    pub(super) light_nt: DVec3,
    /// Whether a square ends here.
    pub(super) edge: bool,
}

impl<'a> Sparks<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        Self { scene }
    }

    /// What arrives along a pixel's ray, which meets something opaque at this view distance (infinity: nothing), metres.
    pub(super) fn shine(&self, view: &View, ray: &Ray, opaque_m: f64) -> Shine {
        let all = self.scene.particles.iter();
        let shown = all.filter(|particles| particles.shine(&self.scene.materials[particles.material]));
        let each =
            shown.flat_map(|particles| particles.list.iter().map(move |particle| (particles, particle)));
        each.fold(Shine::default(), |sum, (particles, particle)| {
            let one = self.of(particles, particle, view, ray, opaque_m);
            Shine { light_nt: sum.light_nt + one.light_nt, edge: sum.edge || one.edge }
        })
    }

    fn of(&self, particles: &Particles, particle: &Particle, view: &View, ray: &Ray, opaque_m: f64) -> Shine {
        let center = particle.position_world.as_dvec3();
        let distance = (center - view.position_world).dot(view.forward_world);
        let [near, far] = ray.range;
        if distance <= near || distance >= far || distance >= opaque_m {
            return Shine::default();
        }
        let at = ray.at(distance);
        let (right, down) = (view.right_world.normalize(), view.down_world.normalize());
        let on_image = DVec2::new((at - center).dot(right), -(at - center).dot(down));
        let half = f64::from(particle.size_m) * 0.5;
        let place = DVec2::from_angle(-f64::from(particle.rotation_rad)).rotate(on_image) / half;
        let outwards = place.abs().max_element();
        // One pixel at this distance, as a share of the square's half side.
        let pixel = 2.0 * (ray.at(distance) - ray.at(distance - 1.0)).length().max(1.0)
            / f64::from(view.size[1])
            * view.down_world.length()
            * distance.abs().max(1.0)
            / half;
        let edge = (outwards - 1.0).abs() < pixel * SNAP_PX;
        if outwards > 1.0 {
            return Shine { edge, ..Shine::default() };
        }
        let material = &self.scene.materials[particles.material];
        let texcoord = DVec2::new(0.5 + 0.5 * place.x, 0.5 - 0.5 * place.y);
        let texel = material.emissive_texture.as_ref();
        let texel = texel.map_or(DVec3::ONE, |t| sample(self.scene, t, texcoord, Encoding::Srgb).truncate());
        let emitted = texel * material.emissive_factor.as_dvec3() * particle.color.as_dvec3();
        let fog = self.scene.fog.as_ref().map_or(1.0, |fog| transmittance(fog, view.ray_start(at), at));
        let share = particles.fade(opaque_m - distance) * particles.fade(distance - near) * fog;
        Shine { light_nt: emitted * share, edge }
    }
}

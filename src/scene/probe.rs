//! What surroundings look like from inside a room: local specular light.

use glam::{DQuat, DVec3, Quat, Vec3};

use super::Environment;
use crate::{Error, Result};

/// A box, and what glossy surfaces inside it reflect: the radiance that was captured at its centre.
///
/// The radiance is taken to come from the box's faces, so reflections move as the viewer does ("parallax-corrected cube
/// maps", Lagarde and Zanuttini, "Local Image-based Lighting With Parallax-corrected Cubemap", SIGGRAPH 2012). Inside, it
/// takes the place of [`super::Scene::environment`] and [`super::Scene::ambient_nt`] for specular light; diffuse light stays theirs.
/// Where boxes overlap they are blended by weight. Each pixel looks at all probes, so they should be few.
#[derive(Clone, Debug)]
pub struct Probe {
    /// A name for messages.
    pub name: String,
    /// World space, metres: the box's centre, where the radiance was captured.
    pub position_world: Vec3,
    /// Unit length: turns the box's axes, which are also those of the captured picture, into the world's.
    pub world_from_probe: Quat,
    /// Half the box's size along its axes, metres, above 0.
    pub half_size_m: Vec3,
    /// How far inside each face the probe's weight reaches 1, metres, at least 0; at the faces it is 0.
    pub falloff_m: f32,
    /// What was seen from the centre.
    pub environment: Environment,
}

/// A falloff is at least this, metres: an edge, but no division by 0.
const MIN_FALLOFF_M: f64 = 1e-4;

impl Probe {
    /// A place of the world in the box's space: metres from its centre along its axes.
    pub fn probe_from_world(&self, position_world: DVec3) -> DVec3 {
        self.rotation().inverse() * (position_world - self.position_world.as_dvec3())
    }

    /// The weight at a place in the box's space: 0 outside, smoothstep over the falloff inside each face, the three axes
    /// multiplied.
    pub fn weight(&self, position: DVec3) -> f64 {
        let half_size = self.half_size_m.as_dvec3();
        let width = f64::from(self.falloff_m).max(MIN_FALLOFF_M);
        let t = ((half_size - position.abs()) / half_size.min(DVec3::splat(width)))
            .clamp(DVec3::ZERO, DVec3::ONE);
        (t * t * (3.0 - 2.0 * t)).element_product()
    }

    /// From the box's centre to where a ray, from a place in the box, leaves it (there, "Box volume"); in the box's space.
    pub fn projected(&self, position: DVec3, direction_world: DVec3) -> DVec3 {
        let direction = self.rotation().inverse() * direction_world;
        let half_size = self.half_size_m.as_dvec3();
        // Distances to the faces ahead; a face that the ray runs along is far away.
        let ahead = DVec3::select(direction.cmplt(DVec3::ZERO), -half_size, half_size);
        let distances = (ahead - position).abs() / direction.abs().max(DVec3::splat(1e-12));
        position + direction * distances.min_element()
    }

    /// # Errors
    /// [`Error::Unsupported`] for numbers that make no box, or no light.
    pub fn check(&self) -> Result<()> {
        let environment = &self.environment;
        let numbers = [self.falloff_m, environment.rotation_deg, environment.intensity];
        let is_sound = self.position_world.is_finite()
            && self.half_size_m.is_finite()
            && self.half_size_m.min_element() > 0.0
            && self.world_from_probe.is_normalized()
            && numbers.iter().all(|number| number.is_finite())
            && self.falloff_m.min(environment.intensity) >= 0.0;
        is_sound.then_some(()).ok_or_else(|| {
            let Self { name, position_world, half_size_m, falloff_m, .. } = self;
            let problem = format!(
                "probe '{name}' at {position_world}, half its size {half_size_m} m, falloff {falloff_m} m, intensity {}",
                environment.intensity
            );
            Error::unsupported(problem, "give finite numbers, a size above 0, and a rotation of unit length")
        })
    }

    fn rotation(&self) -> DQuat {
        self.world_from_probe.as_dquat().normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::Panorama;

    fn probe() -> Probe {
        let dark = Panorama::new(4, 2, vec![Vec3::ZERO; 8]).unwrap();
        Probe {
            name: "room".into(),
            position_world: Vec3::new(1.0, 2.0, 3.0),
            world_from_probe: Quat::from_rotation_y(std::f32::consts::FRAC_PI_2),
            half_size_m: Vec3::new(4.0, 2.0, 1.0),
            falloff_m: 0.5,
            environment: Environment::new("dark", dark),
        }
    }

    #[test]
    fn places_are_turned_and_moved() {
        // The box's +X lies towards the world's -Z.
        let local = probe().probe_from_world(DVec3::new(1.0, 2.5, 0.0));
        assert!((local - DVec3::new(3.0, 0.5, 0.0)).length() < 1e-6, "{local}");
    }

    #[test]
    fn weight_falls_to_nothing_at_the_faces() {
        let probe = probe();
        let at = |x: f64, y: f64, z: f64| probe.weight(DVec3::new(x, y, z));
        assert_eq!(at(0.0, 0.0, 0.0), 1.0);
        assert_eq!((at(3.5, 0.0, 0.0), at(4.0, 0.0, 0.0), at(-4.1, 0.0, 0.0)), (1.0, 0.0, 0.0));
        assert!((at(3.75, 0.0, 0.0) - 0.5).abs() < 1e-12);
        assert!((at(3.75, -1.75, 0.0) - 0.25).abs() < 1e-12);
        // No wider than the box itself, and never a division by zero.
        let wide = Probe { falloff_m: 100.0, ..probe.clone() };
        assert!(wide.weight(DVec3::ZERO) == 1.0 && wide.weight(DVec3::new(0.0, 0.0, 0.5)) == 0.5);
        let hard = Probe { falloff_m: 0.0, ..probe };
        assert_eq!(
            (hard.weight(DVec3::new(3.99, 0.0, 0.0)), hard.weight(DVec3::new(4.0, 0.0, 0.0))),
            (1.0, 0.0)
        );
    }

    #[test]
    fn numbers_that_make_no_box_are_refused() {
        let spoil: [fn(&mut Probe); 6] = [
            |p| p.position_world.y = f32::NAN,
            |p| p.half_size_m.x = 0.0,
            |p| p.half_size_m.z = f32::INFINITY,
            |p| p.falloff_m = -0.1,
            |p| p.world_from_probe = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
            |p| p.environment.intensity = f32::NAN,
        ];
        probe().check().unwrap();
        for (i, spoil) in spoil.iter().enumerate() {
            let mut bad = probe();
            spoil(&mut bad);
            let message = bad.check().expect_err(&i.to_string()).to_string();
            assert!(message.contains("probe 'room'"), "{message}");
        }
    }

    #[test]
    fn rays_end_on_the_faces() {
        let probe = Probe { world_from_probe: Quat::IDENTITY, ..probe() };
        let start = DVec3::new(1.0, -1.0, 0.5);
        for (direction, end) in [
            (DVec3::X, DVec3::new(4.0, -1.0, 0.5)),
            (DVec3::NEG_X * 3.0, DVec3::new(-4.0, -1.0, 0.5)),
            (DVec3::new(0.0, 1.0, 0.1), DVec3::new(1.0, 2.0, 0.8)),
            (DVec3::new(0.2, 0.0, -1.0), DVec3::new(1.3, -1.0, -1.0)),
        ] {
            assert!((probe.projected(start, direction) - end).length() < 1e-9, "{direction}");
        }
        // On a face, where the weight is 0: no division by zero.
        let on_face = DVec3::new(4.0, 0.0, 0.0);
        assert!(probe.projected(on_face, DVec3::X).abs_diff_eq(on_face, 1e-9));
        assert!(probe.projected(on_face, DVec3::Y).is_finite());
    }
}

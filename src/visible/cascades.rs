//! Cascades: which parts of the world a directional light's shadow maps show, fine near the camera and coarse far away.
//!
//! The view is cut into slices by distance, and each slice gets a map of the sphere around it. A slice's sphere has the
//! same radius wherever the camera stands and however it turns, so a map's texels keep their size; its centre follows
//! the camera in steps of whole texels ([`super::ShadowView::parallel`]), so they keep their places in the world too, and
//! the shadows of what stands still do not shimmer (Koonce 2007, listing 19-2; Valient 2007, "Stable Rendering of
//! Cascaded Shadow Maps", ShaderX6).

use glam::DVec3;

use crate::scene::{Aabb, Camera, Projection};

/// The most cascades that a light can have.
pub const MOST_CASCADES: usize = 4;

/// Between slices of equal ratios (1) and of equal lengths (0): the weight of Zhang et al. 2006, "Parallel-split shadow
/// maps for large-scale virtual environments", section 3, equation 3.
const LOGARITHMIC: f64 = 0.75;

/// Distances are rounded to this many steps per factor of two, so that slices change seldom while the camera moves.
const STEPS_PER_OCTAVE: f64 = 2.0;

/// Parts of the world, each with the one before it inside the view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cascades {
    spheres: [Sphere; MOST_CASCADES],
    count: usize,
}

/// A ball of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sphere {
    /// World space, metres.
    pub center: DVec3,
    /// Metres.
    pub radius_m: f64,
}

impl Sphere {
    /// Around a box.
    pub fn around(bounds: &Aabb) -> Self {
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        Self { center: (min + max) * 0.5, radius_m: (max - min).length() * 0.5 }
    }
}

impl Cascades {
    /// At most `most` cascades (and [`MOST_CASCADES`]) that together hold all of `bounds` that a view of this aspect ratio
    /// (width over height) shows, nearest first.
    ///
    /// Fewer where fewer do: a parallel view has the same detail everywhere and needs one, and nothing follows a cascade
    /// that holds all of `bounds`, which stands still whatever the camera does.
    pub fn new(camera: &Camera, aspect: f64, bounds: &Aabb, most: usize) -> Self {
        let whole = Sphere::around(bounds);
        let world_from_view = camera.world_from_view.as_dmat4();
        let eye = world_from_view.w_axis.truncate();
        let forward = -world_from_view.z_axis.truncate();
        let most = most.clamp(1, MOST_CASCADES);
        let (slices, across, count) = match camera.projection {
            Projection::Perspective { yfov_rad, znear_m, zfar_m } => {
                let half_height = (f64::from(yfov_rad) * 0.5).tan();
                let diagonal = half_height * (1.0 + aspect * aspect).sqrt();
                let range = distances(eye, bounds, diagonal, f64::from(znear_m), zfar_m.map(f64::from));
                (range, Across::Growing(diagonal), most)
            }
            Projection::Orthographic { ymag_m, znear_m, zfar_m, .. } => {
                let diagonal = f64::from(ymag_m) * (1.0 + aspect * aspect).sqrt();
                ([znear_m, zfar_m].map(f64::from), Across::Constant(diagonal), 1)
            }
        };
        let mut cascades = Self::default();
        for index in 0..count {
            let [begin, end] = [index, index + 1].map(|i| split(slices, i as f64 / count as f64));
            let (distance, radius_m) = across.sphere(begin, end);
            // Where distances overflow, there is no number to compare.
            let holds_all = radius_m.is_nan() || radius_m >= whole.radius_m;
            cascades.spheres[index] = match holds_all {
                true => whole,
                false => Sphere { center: eye + forward * distance, radius_m },
            };
            cascades.count = index + 1;
            if holds_all {
                break;
            }
        }
        cascades
    }

    /// The cascades, nearest first.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres[..self.count]
    }
}

/// How wide a view is: from its axis to a corner.
enum Across {
    /// Per metre of distance.
    Growing(f64),
    /// Metres.
    Constant(f64),
}

impl Across {
    /// Distance of the centre along the view axis, and radius, of the smallest sphere around a slice.
    fn sphere(&self, begin: f64, end: f64) -> (f64, f64) {
        match *self {
            // At the distance that the corners of both ends have the same distance from, or at the far end if that lies
            // beyond it.
            Self::Growing(k) => {
                let center = ((begin + end) * 0.5 * (1.0 + k * k)).min(end);
                (center, (end - center).hypot(k * end))
            }
            Self::Constant(half) => ((begin + end) * 0.5, ((end - begin) * 0.5).hypot(half)),
        }
    }
}

/// Nearest and farthest distance along the view axis at which something of `bounds` can be, rounded outwards.
fn distances(eye: DVec3, bounds: &Aabb, diagonal: f64, near: f64, far: Option<f64>) -> [f64; 2] {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let nearest = (eye.clamp(min, max) - eye).length();
    let farthest = (eye - min).abs().max((eye - max).abs()).length();
    // What is at a distance r from the eye is at least r * cos(angle) away along the axis.
    let begin = round(nearest / diagonal.hypot(1.0), f64::floor).max(near);
    let end = round(farthest, f64::ceil).min(far.unwrap_or(f64::INFINITY));
    [begin, end.max(begin * 2.0)]
}

/// To the next step of [`STEPS_PER_OCTAVE`]; 0 stays.
fn round(distance: f64, to: fn(f64) -> f64) -> f64 {
    (to(distance.log2() * STEPS_PER_OCTAVE) / STEPS_PER_OCTAVE).exp2()
}

/// Where a share of the slices ends (Zhang et al. 2006, equation 3).
fn split([near, far]: [f64; 2], share: f64) -> f64 {
    let uniform = near + (far - near) * share;
    // A parallel view may begin behind the camera; it has one slice, of which only the ends are asked.
    if near <= 0.0 {
        return uniform;
    }
    uniform + (near * (far / near).powf(share) - uniform) * LOGARITHMIC
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat4, Vec3};

    const ASPECT: f64 = 16.0 / 9.0;

    fn camera(world_from_view: Mat4) -> Camera {
        let projection = Projection::Perspective { yfov_rad: 0.8, znear_m: 0.1, zfar_m: None };
        Camera { name: "test".into(), world_from_view, projection }
    }

    fn bounds(half: f32) -> Aabb {
        Aabb { min: Vec3::splat(-half), max: Vec3::splat(half) }
    }

    /// Corners of the view's slice between two distances.
    fn corners(camera: &Camera, [begin, end]: [f64; 2]) -> Vec<DVec3> {
        let Projection::Perspective { yfov_rad, .. } = camera.projection else { unreachable!() };
        let half = (f64::from(yfov_rad) * 0.5).tan();
        let mut all = Vec::new();
        for distance in [begin, end] {
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
                let view = DVec3::new(x * half * ASPECT, y * half, -1.0) * distance;
                all.push(camera.world_from_view.as_dmat4().transform_point3(view));
            }
        }
        all
    }

    #[test]
    fn every_slice_is_inside_its_sphere() {
        // The camera's axes are rounded to f32.
        const ROUNDING: f64 = 1e-6;
        let camera = camera(Mat4::from_rotation_y(0.7) * Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0)));
        let cascades = Cascades::new(&camera, ASPECT, &bounds(400.0), 4);
        assert_eq!(cascades.spheres().len(), 4);
        let eye = camera.world_from_view.w_axis.truncate().as_dvec3();
        let range = distances(eye, &bounds(400.0), 1.0, 0.1, None);
        for (i, sphere) in cascades.spheres().iter().enumerate() {
            let slice = [i, i + 1].map(|i| split(range, i as f64 / 4.0));
            let farthest =
                corners(&camera, slice).iter().map(|c| c.distance(sphere.center)).fold(0.0, f64::max);
            assert!(farthest <= sphere.radius_m * (1.0 + ROUNDING), "{i}: {farthest} {sphere:?}");
            // And no larger than it must be.
            assert!(farthest >= sphere.radius_m * (1.0 - ROUNDING), "{i}: {farthest} {sphere:?}");
        }
    }

    #[test]
    fn turning_and_small_steps_keep_the_radii() {
        let radii = |placement: Mat4| {
            let cascades = Cascades::new(&camera(placement), ASPECT, &bounds(100.0), 3);
            cascades.spheres().iter().map(|s| s.radius_m).collect::<Vec<_>>()
        };
        let start = radii(Mat4::IDENTITY);
        assert_eq!(start.len(), 3);
        assert!(start.windows(2).all(|w| w[0] < w[1]), "{start:?}");
        for placement in [
            Mat4::from_rotation_y(2.1),
            Mat4::from_rotation_x(-1.0),
            Mat4::from_translation(Vec3::new(0.3, -0.2, 0.7)),
        ] {
            assert_eq!(radii(placement), start);
        }
    }

    #[test]
    fn a_small_scene_is_one_map_that_stands_still() {
        let scene = bounds(1.0);
        for x in [0.0, 0.5, 20.0] {
            let away = Mat4::from_translation(Vec3::new(x, 1.0, 30.0));
            let cascades = Cascades::new(&camera(away), ASPECT, &scene, 3);
            assert_eq!(cascades.spheres(), [Sphere::around(&scene)]);
        }
        let projection =
            Projection::Orthographic { xmag_m: 500.0, ymag_m: 500.0, znear_m: -5.0, zfar_m: 900.0 };
        let parallel = Camera { projection, ..camera(Mat4::IDENTITY) };
        assert_eq!(Cascades::new(&parallel, ASPECT, &scene, 3).spheres(), [Sphere::around(&scene)]);
    }
}

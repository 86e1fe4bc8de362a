//! The part of the world that a view shows, and what is certain to lie outside of it.

use glam::{Mat4, Vec3, Vec4};

use super::Reach;
use crate::scene::Aabb;

/// Six planes and two that nothing is outside of, so that compilers test four at a time.
const LANES: usize = 8;

/// What may be lost to rounding, as a share of the magnitudes that were added up: the GPU's transform into clip space,
/// the sum of rows below, and the test itself take at most 16 roundings of half an epsilon. Twice that covers what
/// shaders make of a pixel's depth (a position, with which lights are tested) too.
const ROUNDING: f32 = 16.0 * f32::EPSILON;

/// The volume that a view shows: between its sides, its near plane and its far plane, where it has one.
///
/// Tests are one-sided: what they call missed has no point inside, not even as a GPU computes it in `f32`, so leaving it
/// out changes no pixel; what they do not may still be outside, near the volume's edges. A view of NaN misses nothing.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    /// Inside is where `normal . p + offset >= 0`; not unit length, pointing inwards.
    normal: [[f32; LANES]; 3],
    offset: [f32; LANES],
    length: [f32; LANES],
    /// How far the above may be off at a point: `error . |p| + error_offset`.
    error: [[f32; LANES]; 3],
    error_offset: [f32; LANES],
}

impl Frustum {
    /// The volume of Vulkan's clip space with reversed depth: `-w <= x, y <= w` and `0 <= z <= w`. A projection
    /// without a far plane gives the far plane's test nothing to miss.
    ///
    /// Gribb and Hartmann 2001, "Fast Extraction of Viewing Frustum Planes from the World-View-Projection Matrix".
    pub fn new(clip_from_world: &Mat4) -> Self {
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| clip_from_world.row(i));
        let mut frustum = Self::everything();
        let planes = [(w + x, x), (w - x, x), (w + y, y), (w - y, y), (w - z, z), (z, z)];
        for (lane, (plane, row)) in planes.into_iter().enumerate() {
            frustum.set(lane, plane, w.abs() + row.abs());
        }
        frustum
    }

    /// Misses nothing.
    fn everything() -> Self {
        Self {
            normal: [[0.0; LANES]; 3],
            offset: [0.0; LANES],
            length: [0.0; LANES],
            error: [[0.0; LANES]; 3],
            error_offset: [0.0; LANES],
        }
    }

    fn set(&mut self, lane: usize, plane: Vec4, magnitude: Vec4) {
        let error = magnitude * ROUNDING;
        for axis in 0..3 {
            self.normal[axis][lane] = plane[axis];
            self.error[axis][lane] = error[axis];
        }
        self.offset[lane] = plane.w;
        self.error_offset[lane] = error.w;
        self.length[lane] = plane.truncate().length();
    }

    /// Whether the box is outside.
    pub fn misses_aabb(&self, bounds: &Aabb) -> bool {
        let center = bounds.center();
        // Rounded halves would not reach both corners.
        let half = (bounds.max - center).max(center - bounds.min);
        let Self { normal: n, error: e, .. } = self;
        let reach = |i: usize| {
            (n[0][i].abs() + e[0][i]) * half.x
                + (n[1][i].abs() + e[1][i]) * half.y
                + (n[2][i].abs() + e[2][i]) * half.z
        };
        self.any_outside(center, reach)
    }

    /// Whether the sphere is outside.
    pub fn misses_sphere(&self, center: Vec3, radius: f32) -> bool {
        let Self { error: e, .. } = self;
        self.any_outside(center, |i| (self.length[i] + e[0][i] + e[1][i] + e[2][i]) * radius)
    }

    /// Whether no point that a light reaches is inside.
    pub fn misses(&self, reach: &Reach) -> bool {
        match *reach {
            Reach::Everywhere => false,
            Reach::Sphere { center_world, radius_m } => self.misses_sphere(center_world, radius_m),
            Reach::Cone { apex_world, direction_world, cos, sin, range_m } => {
                let Self { normal: n, error: e, .. } = self;
                let along = |i: usize| {
                    let normal = Vec3::new(n[0][i], n[1][i], n[2][i]);
                    let length = self.length[i];
                    // The cone's farthest point along the normal: on the cap if it holds the normal, on its rim, or
                    // the apex. `a` is the normal's part along the axis, `b` the one across.
                    let a = normal.dot(direction_world);
                    let b = normal.cross(direction_world).length();
                    let error = e[0][i] + e[1][i] + e[2][i] + length * ROUNDING;
                    let farthest = if a >= length * cos { length } else { a * cos + b * sin } + error;
                    // An infinite range times 0 is no number.
                    if farthest > 0.0 { farthest * range_m } else { 0.0 }
                };
                self.any_outside(apex_world, along)
            }
            Reach::Box { center_world, half_axes_world } => {
                let Self { normal: n, error: e, .. } = self;
                let along = |i: usize| {
                    let normal = Vec3::new(n[0][i], n[1][i], n[2][i]);
                    let error = Vec3::new(e[0][i], e[1][i], e[2][i]) + normal.abs() * ROUNDING;
                    half_axes_world.iter().map(|axis| normal.dot(*axis).abs() + error.dot(axis.abs())).sum()
                };
                self.any_outside(center_world, along)
            }
        }
    }

    /// Whether some plane has all points within `reach` of `center` behind it; `reach` is scaled by the normal's length.
    fn any_outside(&self, center: Vec3, reach: impl Fn(usize) -> f32) -> bool {
        let Self { normal: n, offset, error: e, error_offset, .. } = self;
        let far = center.abs();
        let mut outside = false;
        for i in 0..LANES {
            let distance = n[0][i] * center.x + n[1][i] * center.y + n[2][i] * center.z + offset[i];
            let error = e[0][i] * far.x + e[1][i] * far.y + e[2][i] * far.z + error_offset[i];
            outside |= distance + error + reach(i) < 0.0;
        }
        outside
    }
}

//! Which decals have to wait for which others.

use std::ops::RangeInclusive;

use glam::{Mat4, Vec2, Vec3};

/// Parts of the image along each side.
const SIDE: usize = 32;
/// By how much a box is taken to be larger than it is, as a share of half the image: rounding, and the pixels that its edge cuts.
const MARGIN: f32 = 0.01;

/// Sorts boxes that are painted one after the other into levels: none of a level shares a part of the image with another of that
/// level, and where two do, the one that is painted later has the higher level. So those of one level may be painted in any order,
/// and all at once.
///
/// This is greedy colouring in order of painting over the interval graph that a coarse grid of the image makes of overlaps: each
/// box goes one above the highest in the parts that it covers.
#[derive(Clone, Debug)]
pub struct DecalLevels {
    /// One above the highest level of each part.
    free: Box<[u32; SIDE * SIDE]>,
}

impl Default for DecalLevels {
    fn default() -> Self {
        Self { free: Box::new([0; SIDE * SIDE]) }
    }
}

impl DecalLevels {
    /// Forgets all boxes.
    pub fn clear(&mut self) {
        self.free.fill(0);
    }

    /// The level of the next box: the image of the cube from -0.5 to 0.5.
    pub fn place(&mut self, clip_from_world: &Mat4, world_from_decal: &Mat4) -> u32 {
        let [columns, rows] = parts(&(*clip_from_world * *world_from_decal));
        let covered = || rows.clone().flat_map(|row| columns.clone().map(move |column| row * SIDE + column));
        let level = covered().map(|part| self.free[part]).max().unwrap_or(0);
        covered().for_each(|part| self.free[part] = level + 1);
        level
    }
}

/// Columns and rows that a box may be seen in.
fn parts(clip_from_decal: &Mat4) -> [RangeInclusive<usize>; 2] {
    let all = 0..=SIDE - 1;
    let (mut least, mut most) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for corner in 0..8 {
        let place = Vec3::from_array([0, 1, 2].map(|axis| (corner >> axis & 1) as f32 - 0.5));
        let clip = *clip_from_decal * place.extend(1.0);
        // In or behind the plane of the eye: it may be seen anywhere.
        if clip.w.is_nan() || clip.w <= 1e-6 * clip.truncate().abs().max_element().max(f32::MIN_POSITIVE) {
            return [all.clone(), all];
        }
        let ndc = clip.truncate().truncate() / clip.w;
        least = least.min(ndc);
        most = most.max(ndc);
    }
    [0, 1].map(|axis| {
        // Casts hold to the range; NaN becomes 0.
        let part = |ndc: f32| (((ndc * 0.5 + 0.5) * SIDE as f32) as usize).min(SIDE - 1);
        if least[axis].is_nan() || most[axis].is_nan() {
            return all.clone();
        }
        part(least[axis] - MARGIN)..=part(most[axis] + MARGIN)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Projection};

    fn clip() -> Mat4 {
        let projection = Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None };
        let camera = Camera { name: String::new(), world_from_view: Mat4::IDENTITY, projection };
        camera.projection.clip_from_view(1.0) * camera.world_from_view.inverse()
    }

    fn cube(x: f32, y: f32, z: f32) -> Mat4 {
        Mat4::from_translation(Vec3::new(x, y, z))
    }

    #[test]
    fn only_what_overlaps_waits() {
        let clip = clip();
        let mut levels = DecalLevels::default();
        let mut place = |m| levels.place(&clip, &m);
        assert_eq!(place(cube(-2.0, 0.0, -8.0)), 0);
        assert_eq!(place(cube(2.0, 0.0, -8.0)), 0, "beside");
        assert_eq!(place(cube(-2.0, 0.3, -9.0)), 1, "over the first");
        assert_eq!(place(cube(0.0, 2.5, -8.0)), 0, "above");
        assert_eq!(place(cube(0.0, 0.0, 0.0)), 2, "around the eye: over all");
        assert_eq!(place(cube(2.0, 0.0, -8.0)), 3);
    }

    /// Against a plain search: of any two boxes that touch on the image, the later has the higher level.
    #[test]
    fn later_ones_are_above_whatever_they_touch() {
        let clip = clip();
        let mut seed = 7_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let mut levels = DecalLevels::default();
        let mut placed: Vec<([Vec2; 2], u32)> = Vec::new();
        for _ in 0..300 {
            let size = Mat4::from_scale(Vec3::splat(0.2 + random().abs()));
            let m = cube(8.0 * random(), 8.0 * random(), -8.0 + 4.0 * random()) * size;
            let corners = (0..8).map(|corner: u32| {
                let place = Vec3::from_array([0, 1, 2].map(|axis| (corner >> axis & 1) as f32 - 0.5));
                (clip * m).project_point3(place).truncate()
            });
            let (least, most) =
                corners.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(a, b), c| (a.min(c), b.max(c)));
            let level = levels.place(&clip, &m);
            let seen = |v: Vec2| v.clamp(Vec2::NEG_ONE, Vec2::ONE);
            for ([a, b], other) in &placed {
                let [least, most] = [seen(least), seen(most)];
                let touches = least.cmple(*b).all() && a.cmple(most).all();
                assert!(!touches || level > *other, "{level} over {other}");
            }
            placed.push(([seen(least), seen(most)], level));
        }
    }
}

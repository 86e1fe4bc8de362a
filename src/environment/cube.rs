//! Cube maps: faces, directions, filtered look-ups across edges.

use glam::{DVec3, Vec4};

/// Faces of a cube, in Vulkan's order: +X, -X, +Y, -Y, +Z, -Z.
pub const FACES: usize = 6;

/// The direction of a place on a face, not normalised: s and t run from -1 to 1 to the right and downwards. (Vulkan 1.3,
/// table "Cube map face and coordinate selection", solved for the direction.)
pub fn direction(face: usize, s: f64, t: f64) -> DVec3 {
    match face {
        0 => DVec3::new(1.0, -t, -s),
        1 => DVec3::new(-1.0, -t, s),
        2 => DVec3::new(s, 1.0, t),
        3 => DVec3::new(s, -1.0, -t),
        4 => DVec3::new(s, -t, 1.0),
        _ => DVec3::new(-s, -t, -1.0),
    }
}

/// The face that a direction meets, and where: the inverse of [`direction`].
pub fn place(d: DVec3) -> (usize, f64, f64) {
    let a = d.abs();
    let (face, major, s, t) = if a.z >= a.x && a.z >= a.y {
        if d.z >= 0.0 { (4, a.z, d.x, -d.y) } else { (5, a.z, -d.x, -d.y) }
    } else if a.y >= a.x {
        if d.y >= 0.0 { (2, a.y, d.x, d.z) } else { (3, a.y, d.x, -d.z) }
    } else if d.x >= 0.0 {
        (0, a.x, -d.z, -d.y)
    } else {
        (1, a.x, d.z, -d.y)
    };
    (face, s / major, t / major)
}

/// The place of a texel's centre along one axis of a face.
pub fn center(index: usize, size: usize) -> f64 {
    (2.0 * index as f64 + 1.0) / size as f64 - 1.0
}

/// The solid angle of a texel: the difference of the arctangents at its corners, sr.
pub fn solid_angle(x: usize, y: usize, size: usize) -> f64 {
    let corner = |i: usize, j: usize| {
        let (s, t) = (2.0 * i as f64 / size as f64 - 1.0, 2.0 * j as f64 / size as f64 - 1.0);
        (s * t).atan2((s * s + t * t + 1.0).sqrt())
    };
    corner(x, y) - corner(x + 1, y) - corner(x, y + 1) + corner(x + 1, y + 1)
}

/// One level of a cube map, each face with a border of its neighbours' texels, so that bilinear filtering crosses edges
/// as Vulkan's does. At a corner, where three faces meet, the fourth texel is the mean of the three.
#[derive(Clone, Debug)]
pub struct Cube {
    size: usize,
    /// By face, rows of `size + 2`.
    bordered: Vec<Vec4>,
}

impl Cube {
    /// From `6 size²` texels: by face, row and column.
    pub fn new(size: usize, texels: &[Vec4]) -> Self {
        assert_eq!(texels.len(), FACES * size * size, "six square faces");
        let side = size + 2;
        let mut bordered = vec![Vec4::ZERO; FACES * side * side];
        for (face, out) in bordered.chunks_exact_mut(side * side).enumerate() {
            for y in 0..size {
                let from = (face * size + y) * size;
                let to = (y + 1) * side + 1;
                out[to..to + size].copy_from_slice(&texels[from..from + size]);
            }
            for i in 0..size {
                let along = center(i, size);
                out[i + 1] = texels[beyond_edge(face, along, -1.0, size)];
                out[(size + 1) * side + i + 1] = texels[beyond_edge(face, along, 1.0, size)];
                out[(i + 1) * side] = texels[beyond_edge(face, -1.0, along, size)];
                out[(i + 1) * side + size + 1] = texels[beyond_edge(face, 1.0, along, size)];
            }
            for (x, y) in [(0, 0), (size + 1, 0), (0, size + 1), (size + 1, size + 1)] {
                let inner = |i: usize| i.clamp(1, size);
                let three =
                    out[inner(y) * side + inner(x)] + out[y * side + inner(x)] + out[inner(y) * side + x];
                out[y * side + x] = three / 3.0;
            }
        }
        Self { size, bordered }
    }

    /// Bilinear between texel centres. The direction need not be of unit length, but not zero.
    pub fn sample(&self, d: DVec3) -> Vec4 {
        let (face, s, t) = place(d);
        let side = self.size + 2;
        let position = |c: f64| (c + 1.0) * 0.5 * self.size as f64 + 0.5;
        let (x, y) = (position(s), position(t));
        // At most size + 0.5, so that the next texel is the border at the latest.
        let (i, j) = (x as usize, y as usize);
        let (fx, fy) = ((x - i as f64) as f32, (y - j as f64) as f32);
        let at = (face * side + j) * side + i;
        let row = |at: usize| self.bordered[at].lerp(self.bordered[at + 1], fx);
        row(at).lerp(row(at + side), fy)
    }
}

/// The index of the texel on the other side of an edge of `face`; one of s and t is -1 or 1, the other a texel's centre.
fn beyond_edge(face: usize, s: f64, t: f64, size: usize) -> usize {
    // A little towards the face's back lies the neighbour, with the place along the edge unchanged.
    let inwards = direction(face, 0.0, 0.0);
    let (face, s, t) = place(direction(face, s, t) - inwards * (0.5 / size as f64));
    let index = |c: f64| (((c + 1.0) * 0.5 * size as f64) as usize).min(size - 1);
    (face * size + index(t)) * size + index(s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn places_and_directions_are_inverse() {
        for face in 0..FACES {
            for (s, t) in [(0.0, 0.0), (-0.9, 0.3), (0.5, 0.99), (0.2, -0.7)] {
                let (f, s2, t2) = place(direction(face, s, t) * 3.0);
                assert!(f == face && (s - s2).abs() < 1e-15 && (t - t2).abs() < 1e-15, "{face} {s} {t}");
            }
        }
    }

    #[test]
    fn solid_angles_fill_the_sphere() {
        let size = 7;
        let all: f64 = (0..size * size).map(|i| solid_angle(i % size, i / size, size)).sum();
        assert!((all * FACES as f64 - 4.0 * PI).abs() < 1e-12, "{all}");
    }

    #[test]
    fn filtering_crosses_edges_and_corners_without_a_seam() {
        /// Half a texel's change of the function at a corner, where a texel stands for three.
        const CORNER: f32 = 0.03;
        const SIZE: usize = 32;
        let value = |d: DVec3| (d.normalize() * 0.5 + 0.5).as_vec3().extend(1.0);
        let texel = |i: usize| {
            let (face, y, x) = (i / (SIZE * SIZE), i / SIZE % SIZE, i % SIZE);
            value(direction(face, center(x, SIZE), center(y, SIZE)))
        };
        let cube = Cube::new(SIZE, &(0..FACES * SIZE * SIZE).map(texel).collect::<Vec<_>>());
        for face in 0..FACES {
            for i in 0..=64 {
                let along = f64::from(i) / 32.0 - 1.0;
                for (s, t) in [(along, 1.0), (along, -1.0), (1.0, along), (-1.0, along)] {
                    let d = direction(face, s, t);
                    // Both sides of the edge, and the function itself.
                    let inwards = direction(face, 0.0, 0.0) * 1e-9;
                    let (here, there) = (cube.sample(d + inwards), cube.sample(d - inwards));
                    assert!((here - there).length() < 1e-5, "face {face}, {s}, {t}: {here} {there}");
                    assert!(
                        (here - value(d)).length() < CORNER,
                        "face {face}, {s}, {t}: {here} {}",
                        value(d)
                    );
                }
            }
        }
    }
}

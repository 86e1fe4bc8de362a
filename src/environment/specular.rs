//! Radiance blurred by GGX lobes, one cube level per roughness: a prefiltered mipmapped radiance environment map (PMREM).

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::cube::{FACES, center, direction, solid_angle};

/// Texels along the edge of the smallest level, which is for roughness 1: there a lobe is 60 degrees wide, a texel 11.
const LAST_SIZE: u32 = 8;

/// Levels of a cube whose largest has faces of this size, a power of two from 16 on.
pub const fn level_count(face_size: u32) -> u32 {
    (face_size / LAST_SIZE).ilog2() + 1
}

/// The level for a perceptual roughness from 0 to 1, between 0 and `levels - 1`. It follows roughness (2 - roughness), so
/// that smooth surfaces, whose lobes change fastest, get most of the levels: Filament's choice ("Physically Based
/// Rendering in Filament", section 5.3.4). `level` is not whole in general: look-ups blend two levels.
pub fn level_from_roughness(roughness: f64, levels: u32) -> f64 {
    f64::from(levels - 1) * roughness * (2.0 - roughness)
}

/// The roughness that a level is filtered for: the inverse of [`level_from_roughness`].
pub fn roughness_from_level(level: u32, levels: u32) -> f64 {
    1.0 - (1.0 - f64::from(level) / f64::from(levels - 1)).sqrt()
}

/// The sphere of light, cut into quarters again and again, so that a lobe sees what is near its axis in small parts
/// and the rest in large ones.
pub(super) struct Tree {
    /// From one part a face to the finest; each by face, row and column.
    levels: Vec<Vec<Part>>,
}

/// A part of the sphere: a texel of some level of a cube.
#[derive(Clone, Copy, Default)]
struct Part {
    /// Unit length: its middle, weighted by solid angle.
    center: Vec3,
    /// The square of the chord from the middle of its face's square to the furthest corner.
    radius2: f32,
    /// Unit length: the middle of its light.
    centroid: Vec3,
    /// sr.
    solid_angle: f32,
    /// Radiance times solid angle.
    light: Vec3,
}

impl Tree {
    /// Of a cube of radiance whose size is a power of two: texels by face, row and column.
    pub fn new(size: u32, texels: &[Vec3]) -> Self {
        let mut size = size as usize;
        let leaf = |index: usize| {
            let part = Part::dark(index, size);
            Part { centroid: part.center, light: texels[index] * part.solid_angle, ..part }
        };
        let mut levels = vec![(0..texels.len()).into_par_iter().map(leaf).collect::<Vec<_>>()];
        while size > 1 {
            size /= 2;
            let children = &levels[levels.len() - 1];
            let parent = |index: usize| {
                let four = children_of(index, size).map(|child| children[child]);
                let center = four.iter().map(|c| c.center * c.solid_angle).sum::<Vec3>().normalize();
                let light: Vec3 = four.iter().map(|c| c.light).sum();
                let centroid: Vec3 = four.iter().map(|c| c.centroid * c.light.element_sum()).sum();
                let centroid = centroid.try_normalize().unwrap_or(center);
                Part { center, light, centroid, ..Part::dark(index, size) }
            };
            let parents = (0..FACES * size * size).into_par_iter().map(parent).collect();
            levels.push(parents);
        }
        levels.reverse();
        Self { levels }
    }

    /// A level of the map: for each direction the mean of the radiance around it, weighted by n·l D(h), with both normal
    /// and view that direction (Karis, "Real Shading in Unreal Engine 4", 2013, "Pre-Filtered Environment Map").
    pub fn filter(&self, size: u32, roughness: f64) -> Vec<Vec3> {
        let size = size as usize;
        let alpha = (roughness * roughness) as f32;
        let texel = |index: usize| {
            let (face, y, x) = (index / (size * size), index / size % size, index % size);
            let axis = direction(face, center(x, size), center(y, size)).normalize().as_vec3();
            self.mean(&Lobe { axis, alpha2: alpha * alpha })
        };
        (0..FACES * size * size).into_par_iter().map(texel).collect()
    }

    /// The mean over all parts of the sphere. Every texel of light is counted exactly once, as itself or in a larger
    /// part, so that no small bright light is missed, as it is by any number of samples that one can wait for: with 1024
    /// filtered ones (Křivánek and Colbert 2008) a sun leaves errors of 5 to 25 %, here it is below 1 %.
    fn mean(&self, lobe: &Lobe) -> Vec3 {
        let mut sums = Sums::default();
        for face in 0..FACES {
            self.add(0, face, lobe, &mut sums);
        }
        (sums.light / sums.weight).as_vec3()
    }

    fn add(&self, level: usize, index: usize, lobe: &Lobe, sums: &mut Sums) {
        let part = &self.levels[level][index];
        let apart2 = lobe.axis.distance_squared(part.center);
        match self.levels.get(level + 1) {
            Some(_) if !lobe.is_flat_over(part, apart2) => {
                for child in children_of(index, 1 << level) {
                    self.add(level + 1, child, lobe, sums);
                }
            }
            _ => {
                let light = part.light * lobe.weight(lobe.axis.distance_squared(part.centroid));
                sums.light += light.as_dvec3();
                sums.weight += f64::from(part.solid_angle * lobe.weight(apart2));
            }
        }
    }
}

#[derive(Default)]
struct Sums {
    light: DVec3,
    weight: f64,
}

struct Lobe {
    /// Unit length.
    axis: Vec3,
    /// alpha².
    alpha2: f32,
}

impl Lobe {
    /// n·l D(h), but for a constant, of light at the end of a chord of this squared length from the axis.
    fn weight(&self, apart2: f32) -> f32 {
        // n·l = 1 - apart² / 2 and n·h² = (1 + n·l) / 2; the difference 1 - n·h² would cancel.
        let f = self.alpha2 + (1.0 - self.alpha2) * 0.25 * apart2;
        (1.0 - 0.5 * apart2).max(0.0) / (f * f)
    }

    /// Whether the weight changes so little over a part that its light may be taken to be in one place: the part is
    /// small against the distance over which D changes, 2 alpha at the axis and the distance itself further out, and
    /// against the hemisphere. (Barnes and Hut, "A hierarchical O(N log N) force-calculation algorithm", 1986, do the
    /// same with masses.)
    fn is_flat_over(&self, part: &Part, apart2: f32) -> bool {
        /// Errors of the result go with its square: at 0.2 about 0.5 %.
        const RELATIVE_RADIUS: f32 = 0.2;
        let is_dark = apart2 > 2.0 + 2.0 * part.radius2.sqrt();
        let scale2 = (apart2 + 4.0 * self.alpha2).min(1.0);
        is_dark || part.radius2 < RELATIVE_RADIUS * RELATIVE_RADIUS * scale2
    }
}

impl Part {
    /// Texel `index` of a level.
    fn dark(index: usize, size: usize) -> Self {
        let (face, y, x) = (index / (size * size), index / size % size, index % size);
        let middle = direction(face, center(x, size), center(y, size)).normalize();
        let corner = |i: usize, j: usize| {
            let along = |i: usize| 2.0 * i as f64 / size as f64 - 1.0;
            direction(face, along(x + i), along(y + j)).normalize().distance_squared(middle)
        };
        let radius2 = corner(0, 0).max(corner(1, 0)).max(corner(0, 1)).max(corner(1, 1));
        Self {
            center: middle.as_vec3(),
            radius2: radius2 as f32,
            solid_angle: solid_angle(x, y, size) as f32,
            ..Self::default()
        }
    }
}

/// The indices of a texel's four in the level twice as large.
fn children_of(index: usize, size: usize) -> [usize; 4] {
    let (face, y, x) = (index / (size * size), index / size % size, index % size);
    let first = (face * 2 * size + 2 * y) * 2 * size + 2 * x;
    [first, first + 1, first + 2 * size, first + 2 * size + 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Black but for one texel.
    fn spot(size: usize, lit: usize, light: f32) -> Vec<Vec3> {
        (0..FACES * size * size).map(|i| if i == lit { Vec3::splat(light) } else { Vec3::ZERO }).collect()
    }

    #[test]
    fn levels_and_roughness_are_inverse() {
        for levels in [2, 4, 6] {
            for level in 0..levels {
                let roughness = roughness_from_level(level, levels);
                assert!((level_from_roughness(roughness, levels) - f64::from(level)).abs() < 1e-12);
            }
        }
        assert_eq!((level_count(16), level_count(256)), (2, 6));
    }

    #[test]
    fn uniform_light_stays_as_it_is() {
        /// Of sums of some hundred f32.
        const RELATIVE: f32 = 1e-5;
        let tree = Tree::new(32, &vec![Vec3::new(3.0, 2.0, 0.5); FACES * 32 * 32]);
        for roughness in [0.1, 0.4, 1.0] {
            for texel in tree.filter(8, roughness) {
                let error = (texel / Vec3::new(3.0, 2.0, 0.5) - 1.0).abs().max_element();
                assert!(error < RELATIVE, "{roughness}: {texel}");
            }
        }
    }

    #[test]
    fn a_small_light_is_neither_lost_nor_moved() {
        /// Of the integral with the light's own direction, where it is at least 1 % of its peak.
        const RELATIVE: f64 = 0.02;
        let size = 64;
        for lit in [5, 64 * 64 + 777, 6 * 64 * 64 - 64] {
            let tree = Tree::new(size as u32, &spot(size, lit, 1e5));
            let light = Part::dark(lit, size);
            for roughness in [0.2, 0.5, 1.0] {
                let alpha2 = f64::powi(roughness, 4);
                // Integral of n·l / f² over the hemisphere, f = alpha² + (1 - alpha²) (1 - c) / 2 linear in c = n·l.
                let steps = 100_000;
                let total: f64 = (0..steps)
                    .map(|i| {
                        // Dense where c is near 1.
                        let t = (f64::from(i) + 0.5) / f64::from(steps);
                        let c = 1.0 - t.powi(4);
                        let f = alpha2 + (1.0 - alpha2) * (1.0 - c) / 2.0;
                        c / (f * f) * 4.0 * t.powi(3) / f64::from(steps) * std::f64::consts::TAU
                    })
                    .sum();
                for (index, texel) in tree.filter(16, roughness).into_iter().enumerate() {
                    let axis: DVec3 = Part::dark(index, 16).center.as_dvec3();
                    let c = axis.dot(light.center.as_dvec3());
                    let f = alpha2 + (1.0 - alpha2) * (1.0 - c) / 2.0;
                    let exact = c.max(0.0) / (f * f) / total * 1e5 * f64::from(light.solid_angle);
                    let peak = 1.0 / (alpha2 * alpha2) / total * 1e5 * f64::from(light.solid_angle);
                    let error = (f64::from(texel.x) - exact).abs();
                    assert!(
                        error < RELATIVE * exact.max(0.01 * peak),
                        "{roughness}, {index}: {texel} {exact}"
                    );
                }
            }
        }
    }
}

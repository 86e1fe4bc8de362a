//! Integer-hashed noise: the same values on every machine and in every run, periodic so that textures tile.

use glam::{IVec2, Vec2};

/// A well-mixed 32-bit hash of a lattice cell (the multipliers are those of Wang's and lowbias32's mixers).
pub fn hash(cell: IVec2, seed: u32) -> u32 {
    let mut h = seed ^ (cell.x as u32).wrapping_mul(0x9e37_79b9) ^ (cell.y as u32).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// A number in [0, 1) for a lattice cell.
pub fn unit(cell: IVec2, seed: u32) -> f32 {
    (hash(cell, seed) >> 8) as f32 / (1_u32 << 24) as f32
}

/// A number in [0, 1) for an index.
pub fn pick(index: usize, seed: u32) -> f32 {
    unit(IVec2::new(index as i32, 0), seed)
}

/// 0 below `from`, 1 above `to`, smooth between.
pub fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Gradient noise in about [-1, 1] that repeats after `period` cells. `p` is in cells.
pub fn gradient_noise(p: Vec2, period: IVec2, seed: u32) -> f32 {
    let cell = p.floor().as_ivec2();
    let f = p - p.floor();
    let corner = |offset: IVec2| {
        let wrapped = (cell + offset).rem_euclid(period);
        let gradient =
            Vec2::new(unit(wrapped, seed) * 2.0 - 1.0, unit(wrapped, seed ^ 0x51ed_270b) * 2.0 - 1.0);
        gradient.dot(f - offset.as_vec2())
    };
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (x, y) = (fade(f.x), fade(f.y));
    let low = corner(IVec2::ZERO) * (1.0 - x) + corner(IVec2::X) * x;
    let high = corner(IVec2::Y) * (1.0 - x) + corner(IVec2::ONE) * x;
    // Two uniform components of the gradient give a typical amplitude of about a half.
    2.0 * (low * (1.0 - y) + high * y)
}

/// Sum of octaves of [`gradient_noise`] in about [-1, 1]. `uv` in [0, 1), `cells` across it in the first octave.
pub fn fractal(uv: Vec2, cells: IVec2, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut amplitude, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let period = cells * (1 << octave);
        sum += amplitude * gradient_noise(uv * period.as_vec2(), period, seed.wrapping_add(octave * 7919));
        total += amplitude;
        amplitude *= 0.5;
    }
    sum / total
}

/// The nearest feature point of cellular noise.
pub struct Cellular {
    /// Distance to the nearest point, in cells.
    pub nearest: f32,
    /// Distance to the second nearest point, in cells.
    pub second: f32,
}

/// Cellular (Worley) noise that repeats over [0, 1) with `cells` cells across.
pub fn cellular(uv: Vec2, cells: IVec2, seed: u32) -> Cellular {
    let p = uv * cells.as_vec2();
    let base = p.floor().as_ivec2();
    let mut best = Cellular { nearest: f32::MAX, second: f32::MAX };
    for y in -1..=1 {
        for x in -1..=1 {
            let cell = base + IVec2::new(x, y);
            let wrapped = cell.rem_euclid(cells);
            let jitter = Vec2::new(unit(wrapped, seed), unit(wrapped, seed ^ 0x2545_f491));
            let distance = (cell.as_vec2() + jitter).distance(p);
            if distance < best.nearest {
                best = Cellular { nearest: distance, second: best.nearest };
            } else {
                best.second = best.second.min(distance);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_after_its_period() {
        let cells = IVec2::new(5, 3);
        for i in 0..50 {
            let uv = Vec2::new(pick(i, 1), pick(i, 2));
            for shift in [Vec2::X, Vec2::Y] {
                // The shifted coordinate has lost bits of its fraction: about 1e-7 times the steepest slope.
                let tolerance = 1e-4;
                let change = fractal(uv, cells, 3, 9) - fractal(uv + shift, cells, 3, 9);
                assert!(change.abs() < tolerance, "{uv} + {shift}: {change}");
                let change = cellular(uv, cells, 4).nearest - cellular(uv + shift, cells, 4).nearest;
                assert!(change.abs() < tolerance, "{uv} + {shift}: {change}");
            }
        }
    }

    #[test]
    fn hash_spreads_over_the_unit_interval() {
        let mut buckets = [0; 8];
        for i in 0..8000 {
            buckets[(pick(i, 3) * 8.0) as usize] += 1;
        }
        // 1000 are expected in each; 150 is about five standard deviations.
        assert!(buckets.iter().all(|&n: &i32| (n - 1000).abs() < 150), "{buckets:?}");
    }
}

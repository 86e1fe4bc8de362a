//! Random numbers and directions.

use std::f64::consts::TAU;

use glam::DVec3;

/// SplitMix64: Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014. Any two seeds give
/// unrelated sequences, so each texel can have its own.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A sequence of its own for every seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number in \[0, 1), 53 bits.
    #[expect(clippy::should_implement_trait, reason = "the sequence has no end")]
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// The i-th point of a sequence that fills the unit square evenly at every length, moved by `start`: an additive recurrence with
/// the powers of the plastic number's inverse (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
pub fn quasi_random(i: u32, start: [f64; 2]) -> [f64; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let i = f64::from(i);
    [(start[0] + i / PLASTIC).fract(), (start[1] + i / (PLASTIC * PLASTIC)).fract()]
}

/// A unit vector around `normal` with density cosine / pi, from two numbers in \[0, 1): Malley's method, a point
/// of the disc lifted to the hemisphere (Pharr, Jakob and Humphreys, "Physically Based Rendering", 13.6.3).
pub fn cosine_direction(normal: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * v).sin_cos();
    let radius = u.sqrt();
    tangent * (radius * cos) + bitangent * (radius * sin) + normal * (1.0 - u).sqrt()
}

/// The balance heuristic: the part of a sample of density `mine` that counts when `other` could have drawn it too.
pub fn fraction(mine: f64, other: f64) -> f64 {
    if mine > 0.0 { mine / (mine + other) } else { 0.0 }
}

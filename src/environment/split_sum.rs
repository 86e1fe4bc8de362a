//! What a surface reflects of uniform light: the second factor of the split-sum approximation.
//!
//! The albedo of glTF's specular lobe is linear in the reflectance at normal incidence, f0 a + b (Karis, "Real Shading in
//! Unreal Engine 4", 2013, "Environment BRDF"), with a and b functions of n·v and roughness alone. They are kept as a
//! table. Karis' later fit for mobile GPUs ([`fitted`]) is for another visibility term:
//! against glTF's height-correlated one it is off by up to 0.10 for dielectrics and 0.55 for white metal, both at grazing
//! angles. The table is off by at most 0.007, by 0.0002 in the mean (`reference::environment` measures it), and costs one
//! look-up in 16 KiB. No rational function of up to 19 coefficients came below 0.03.

use super::texel::{from_small_float, small_float};

/// Nodes along each axis.
pub const SIZE: usize = 64;

/// [`SIZE`] rows of as many pairs (a, b) of half floats, little-endian: R16G16_SFLOAT. Columns are sqrt(n·v), since b
/// rises steeply towards grazing angles, rows are roughness, both from 0 at the first node's centre to 1 at the last's.
pub static TABLE: &[u8; SIZE * SIZE * 4] = include_bytes!("split_sum.bin");

/// A node of the table.
pub fn encode(a_and_b: [f64; 2]) -> [u8; 4] {
    let halves = a_and_b.map(|value| (small_float(value as f32, 10) as u16).to_le_bytes());
    [halves[0][0], halves[0][1], halves[1][0], halves[1][1]]
}

/// a and b, as a texture unit gives them.
pub fn look_up(n_dot_v: f64, roughness: f64) -> [f64; 2] {
    let place = |value: f64| {
        let position = value.clamp(0.0, 1.0) * (SIZE - 1) as f64;
        let first = (position as usize).min(SIZE - 2);
        (first, position - first as f64)
    };
    let ((i, s), (j, t)) = (place(n_dot_v.max(0.0).sqrt()), place(roughness));
    let node = |i: usize, j: usize, which: usize| {
        let at = (j * SIZE + i) * 4 + which * 2;
        f64::from(from_small_float(u32::from(u16::from_le_bytes([TABLE[at], TABLE[at + 1]])), 10))
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    [0, 1].map(|k| {
        mix(mix(node(i, j, k), node(i + 1, j, k), s), mix(node(i, j + 1, k), node(i + 1, j + 1, k), s), t)
    })
}

/// What a coat with f0 = 0 lets through to the diffuse base, of uniform light: 1 less the mean of Schlick's
/// (1 - v·h)^5 over directions of light weighted by n·l. It goes from 0.972 at grazing angles to 1; this cubic is within
/// 0.0001. A coat of reflectance f0 lets through (1 - f0) times as much.
pub fn transmission(n_dot_v: f64) -> f64 {
    0.97191 + n_dot_v * (0.07756 + n_dot_v * (-0.07515 + n_dot_v * 0.02567))
}

/// a and b without the table (Karis, "Physically Based Shading on Mobile", 2014, `EnvBRDFApprox`). Made for Schlick's form of the
/// visibility term; `reference::environment` measures what it is off by.
pub fn fitted(n_dot_v: f64, roughness: f64) -> [f64; 2] {
    let smoothness = 1.0 - roughness;
    let edge =
        (smoothness * smoothness).min((-9.28 * n_dot_v).exp2()) * smoothness + 0.0425 - 0.0275 * roughness;
    [1.04 - 0.572 * roughness - 1.04 * edge, -0.04 + 0.022 * roughness + 1.04 * edge]
}

//! Diffuse light by spherical harmonics.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::panorama::{Panorama, direction_from_uv};

/// Polynomials in the components of a direction: the real spherical harmonics of the orders 0 to 2 without their
/// constants, in the order that `glsl/light/environment.glsl` evaluates them.
pub fn basis(d: DVec3) -> [f64; 9] {
    [1.0, d.y, d.z, d.x, d.x * d.y, d.y * d.z, 3.0 * d.z * d.z - 1.0, d.x * d.z, d.x * d.x - d.y * d.y]
}

/// The squared constant of each harmonic (Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance
/// Environment Maps", 2001, equation 3): once for the projection, once for the evaluation.
const NORMALISATION: [f64; 9] = [
    1.0 / (4.0 * PI),
    3.0 / (4.0 * PI),
    3.0 / (4.0 * PI),
    3.0 / (4.0 * PI),
    15.0 / (4.0 * PI),
    15.0 / (4.0 * PI),
    5.0 / (16.0 * PI),
    15.0 / (4.0 * PI),
    15.0 / (16.0 * PI),
];

/// What the clamped cosine leaves of each order, over pi (there, equation 8: pi, 2 pi / 3, pi / 4).
const COSINE: [f64; 9] = [1.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25, 0.25, 0.25, 0.25, 0.25];

/// Irradiance over pi, the radiance of a white diffuse surface, as nine coefficients of [`basis`].
///
/// No window is applied: windows (Sloan, "Stupid Spherical Harmonics Tricks", 2008) take away what rings below zero
/// opposite a small bright light, at the price of a larger error everywhere else; the sum is clamped at zero instead.
pub fn project(panorama: &Panorama) -> [Vec3; 9] {
    let (width, height) = (panorama.width() as usize, panorama.height() as usize);
    let row = |y: usize| {
        // Texels hold over their row's height, where two points of Gauss and Legendre in cos(theta), solid angle but for a
        // constant, integrate all harmonics of even order exactly: uniform light stays uniform.
        let edge = |i: usize| (PI * i as f64 / height as f64).cos();
        let (middle, half) = ((edge(y) + edge(y + 1)) / 2.0, (edge(y) - edge(y + 1)) / 2.0);
        let mut sum = [DVec3::ZERO; 9];
        for cos in [middle - half / 3.0_f64.sqrt(), middle + half / 3.0_f64.sqrt()] {
            let v = cos.acos() / PI;
            for (x, texel) in panorama.texels()[y * width..(y + 1) * width].iter().enumerate() {
                let light = texel.as_dvec3() * (half * TAU / width as f64);
                let d = direction_from_uv([(x as f64 + 0.5) / width as f64, v]);
                for (sum, harmonic) in sum.iter_mut().zip(basis(d)) {
                    *sum += light * harmonic;
                }
            }
        }
        sum
    };
    // Rows are summed in order, so that the number of threads changes nothing.
    let rows: Vec<_> = (0..height).into_par_iter().map(row).collect();
    std::array::from_fn(|i| {
        (rows.iter().map(|row| row[i]).sum::<DVec3>() * (NORMALISATION[i] * COSINE[i])).as_vec3()
    })
}

/// Irradiance over pi for a normal of unit length.
pub fn evaluate(coefficients: &[Vec3; 9], normal: DVec3) -> DVec3 {
    let terms = coefficients.iter().zip(basis(normal)).map(|(c, b)| c.as_dvec3() * b);
    terms.sum::<DVec3>().max(DVec3::ZERO)
}

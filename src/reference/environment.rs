//! Light of an environment: the integrals that [`crate::environment`] approximates.

use std::f64::consts::PI;

use glam::DVec3;

use super::brdf::{MIN_N_DOT_V, alpha_from_roughness, v_smith_correlated};

/// The factors a and b of f0 a + b, the part of uniform light that the specular lobe of glTF 2.0 appendix B reflects
/// towards a viewer at this cosine: the integral of D V n·l, times F = f0 + (1 - f0) (1 - v·h)^5 split by f0.
///
/// Half vectors are placed where visible microfacets are (Heitz, "Sampling the GGX Distribution of Visible Normals", 2018,
/// appendix A), which leaves an integrand between 0 and 1; `rings * rings / 2` midpoints.
pub fn split_sum(n_dot_v: f64, roughness: f64, rings: u32) -> [f64; 2] {
    let n_dot_v = n_dot_v.clamp(MIN_N_DOT_V, 1.0);
    let v = DVec3::new((1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v);
    let alpha = alpha_from_roughness(roughness);
    // Seen from where the distribution is a hemisphere.
    let stretched = DVec3::new(alpha * v.x, 0.0, v.z).normalize();
    let across = stretched.cross(DVec3::Y);
    let masking = n_dot_v + (alpha * alpha + (1.0 - alpha * alpha) * n_dot_v * n_dot_v).sqrt();
    let sectors = rings / 2;
    let mut sums = [0.0; 2];
    for i in 0..rings * sectors {
        // Denser at the disk's rim, where the sphere above it is steep.
        let rim = 1.0 - (f64::from(i / sectors) + 0.5) / f64::from(rings);
        let radius = (1.0 - rim * rim).sqrt();
        // Half a turn: the other half is its mirror image.
        let azimuth = PI * ((f64::from(i % sectors) + 0.5) / f64::from(sectors) - 0.5);
        let (y, x) = (radius * azimuth.cos(), radius * azimuth.sin());
        let visible = 0.5 * (1.0 + stretched.z);
        let x = (1.0 - visible) * (1.0 - y * y).sqrt() + visible * x;
        let up = (1.0 - x * x - y * y).max(0.0).sqrt();
        let hemisphere = DVec3::Y * y + across * x + stretched * up;
        let h = DVec3::new(alpha * hemisphere.x, alpha * hemisphere.y, hemisphere.z.max(0.0)).normalize();
        let v_dot_h = v.dot(h);
        let n_dot_l = 2.0 * v_dot_h * h.z - n_dot_v;
        if n_dot_l <= 0.0 {
            continue;
        }
        // D V n·l over the density of l, D G1 / (4 n·v): both D cancel.
        let lobe = 2.0 * v_smith_correlated(n_dot_l, n_dot_v, alpha) * n_dot_l * masking * 2.0 * rim;
        let fresnel = (1.0 - v_dot_h).powi(5);
        sums[0] += lobe * (1.0 - fresnel);
        sums[1] += lobe * fresnel;
    }
    sums.map(|sum| sum / f64::from(rings * sectors))
}

/// What uniform light a coat with f0 = 0 lets through to a diffuse base: the integral of (1 - (1 - v·h)^5) n·l / pi.
pub fn transmission(n_dot_v: f64, rings: u32) -> f64 {
    let v = DVec3::new((1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v);
    let sectors = rings / 2;
    let lost: f64 = (0..rings * sectors)
        .map(|i| {
            let u = (f64::from(i / sectors) + 0.5) / f64::from(rings);
            let azimuth = PI * (f64::from(i % sectors) + 0.5) / f64::from(sectors);
            // Weighted by n·l: uniform over the disk below.
            let l = DVec3::new(u.sqrt() * azimuth.cos(), u.sqrt() * azimuth.sin(), (1.0 - u).sqrt());
            (1.0 - v.dot((v + l).normalize())).max(0.0).powi(5)
        })
        .sum();
    1.0 - lost / f64::from(rings * sectors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::split_sum as table;
    use crate::reference::gbuffer::Attributes;
    use crate::reference::testing::directional_albedo;
    use rayon::prelude::*;

    #[test]
    fn the_quadrature_has_converged() {
        /// A step of the half floats that the table holds, at 0.1.
        const MOST: f64 = 6e-5;
        for i in 0..100 {
            let (n_dot_v, roughness) = ((f64::from(i % 10) / 10.0).powi(2), f64::from(i / 10) / 10.0);
            let (coarse, fine) = (split_sum(n_dot_v, roughness, 200), split_sum(n_dot_v, roughness, 800));
            let error = f64::max((coarse[0] - fine[0]).abs(), (coarse[1] - fine[1]).abs());
            assert!(error < MOST, "{n_dot_v} {roughness}: {coarse:?} {fine:?}");
        }
    }

    #[test]
    fn the_split_is_that_of_the_whole_lobe() {
        for (roughness, n_dot_v) in [(0.0, 0.9), (0.3, 0.2), (0.7, 0.6), (1.0, 1.0)] {
            for f0 in [0.04, 0.5, 1.0] {
                let base_color = DVec3::splat(f0);
                let surface = Attributes { roughness, base_color, metallic: 1.0, ..Attributes::default() };
                let whole = directional_albedo(&surface, n_dot_v).x;
                let [a, b] = split_sum(n_dot_v, roughness, 400);
                assert!((f0 * a + b - whole).abs() < 2e-3, "{roughness} {n_dot_v} {f0}: {a} {b} {whole}");
            }
        }
    }

    /// The table as these integrals give it.
    fn made() -> Vec<u8> {
        let nodes = table::SIZE * table::SIZE;
        let last = (table::SIZE - 1) as f64;
        let node = |i: usize| {
            let (sqrt_n_dot_v, roughness) =
                ((i % table::SIZE) as f64 / last, (i / table::SIZE) as f64 / last);
            table::encode(split_sum(sqrt_n_dot_v * sqrt_n_dot_v, roughness, 200))
        };
        (0..nodes).into_par_iter().flat_map_iter(node).collect()
    }

    /// With `ONTILE_UPDATE=1` it writes the table, and fails.
    #[test]
    fn the_table_holds_the_integrals() {
        let made = made();
        if std::env::var_os("ONTILE_UPDATE").is_some() {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/environment/split_sum.bin");
            crate::file::write_whole(path.as_ref(), &made).unwrap();
            panic!("{path} was written; build again");
        }
        assert!(made == table::TABLE[..], "the table is out of date: run with ONTILE_UPDATE=1");
    }

    #[test]
    fn between_its_nodes_the_table_is_close_to_the_integrals() {
        /// Of f0 a + b for any f0: near grazing angles on smooth surfaces, and in the mean.
        const MOST: f64 = 0.01;
        const MEAN: f64 = 3e-4;
        let places: Vec<_> = (0..2500)
            .map(|i| (f64::from(i % 50) + 0.37, f64::from(i / 50) + 0.41))
            .map(|(x, y)| ((x / 50.0).powi(2), y / 50.0))
            .collect();
        let error = |&(n_dot_v, roughness): &(f64, f64)| {
            let [a, b] = split_sum(n_dot_v, roughness, 200);
            let [c, d] = table::look_up(n_dot_v, roughness);
            f64::max((b - d).abs(), (a + b - c - d).abs())
        };
        let errors: Vec<f64> = places.par_iter().map(error).collect();
        let (most, sum) = errors.iter().fold((0.0, 0.0), |(m, s), e| (f64::max(m, *e), s + e));
        println!("split-sum table: at most {most:.4}, {:.5} in the mean", sum / errors.len() as f64);
        assert!(most < MOST && sum / (errors.len() as f64) < MEAN, "{most} {sum}");
    }

    #[test]
    fn the_cubic_is_close_to_the_transmission() {
        for i in 0..=40 {
            let n_dot_v = f64::from(i) / 40.0;
            let error = table::transmission(n_dot_v) - transmission(n_dot_v, 600);
            assert!(error.abs() < 1e-4, "{n_dot_v}: {error}");
        }
    }
}

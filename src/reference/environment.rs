//! Light of an environment: the integrals that [`crate::environment`] approximates.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::{DVec2, DVec3};

use super::brdf::{MIN_N_DOT_V, alpha_from_roughness, brdf, d_ggx, v_smith_correlated};
use super::gbuffer::Attributes;
use crate::environment::{Panorama, direction_from_uv, uv_from_direction};

/// The factors a and b of f0 a + b, the part of uniform light that the specular lobe of glTF 2.0 appendix B reflects
/// towards a viewer at this cosine: the integral of D V n·l, times F = f0 + (1 - f0) (1 - v·h)^5 split by f0.
///
/// Half vectors are placed where visible microfacets are (Heitz, "Sampling the GGX Distribution of Visible Normals", 2018,
/// appendix A), which leaves an integrand between 0 and 1; `rings * rings / 2` midpoints.
pub fn split_sum(n_dot_v: f64, roughness: f64, rings: u32) -> [f64; 2] {
    let n_dot_v = n_dot_v.clamp(MIN_N_DOT_V, 1.0);
    let v = DVec3::new((1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v);
    let alpha = alpha_from_roughness(roughness);
    let sectors = rings / 2;
    let mut sums = [0.0; 2];
    for i in 0..rings * sectors {
        // Denser at the disk's rim, where the sphere above it is steep.
        let rim = 1.0 - (f64::from(i / sectors) + 0.5) / f64::from(rings);
        // Half a turn: the other half is its mirror image.
        let azimuth = PI * ((f64::from(i % sectors) + 0.5) / f64::from(sectors) - 0.5);
        let h = visible_normal(v, alpha, (1.0 - rim * rim).sqrt(), azimuth);
        let v_dot_h = v.dot(h);
        let n_dot_l = 2.0 * v_dot_h * h.z - n_dot_v;
        if n_dot_l <= 0.0 {
            continue;
        }
        // D V n·l over the density of l, D G1 / (4 n·v): both D cancel.
        let lobe =
            2.0 * v_smith_correlated(n_dot_l, n_dot_v, alpha) * n_dot_l * masking(n_dot_v, alpha) * 2.0 * rim;
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

/// The integral of BRDF, n·l and the radiance around a surface.
///
/// Directions are chosen in three ways, each of which finds light that the others miss: where the panorama is bright, where
/// the lobe is high, and by n·l; they are weighted by the balance heuristic (Veach, "Robust Monte Carlo Methods for Light
/// Transport Simulation", 1997, section 9.2). All are points of a Hammersley set, the same for every surface.
pub struct Integrator {
    samples: u32,
    panorama: Option<(Panorama, Vec<f64>)>,
}

impl Integrator {
    /// Of a panorama, if there is one, by `samples` directions for each way of choosing them.
    pub fn new(panorama: Option<&Panorama>, samples: u32) -> Self {
        Self { samples, panorama: panorama.map(|p| (p.clone(), cumulative(p))) }
    }

    /// What a surface reflects of light of radiance 1 from everywhere, and of the panorama's; directions are in the
    /// panorama's space.
    pub fn reflected(&self, surface: &Attributes, v: DVec3) -> [DVec3; 2] {
        let n = surface.normal_world;
        let (tangent, bitangent) = n.any_orthonormal_pair();
        let world = |local: DVec3| tangent * local.x + bitangent * local.y + n * local.z;
        let local_v = DVec3::new(v.dot(tangent), v.dot(bitangent), n.dot(v).max(MIN_N_DOT_V)).normalize();
        let alpha = alpha_from_roughness(surface.roughness);
        let mut sums = [DVec3::ZERO; 2];
        for i in 0..self.samples {
            let place = DVec2::new(
                (f64::from(i) + 0.5) / f64::from(self.samples),
                f64::from(i.reverse_bits()) / 4_294_967_296.0,
            );
            let (radius, azimuth) = (place.x.sqrt(), TAU * place.y);
            let by_cosine =
                DVec3::new(radius * azimuth.cos(), radius * azimuth.sin(), (1.0 - place.x).sqrt());
            let h = visible_normal(local_v, alpha, radius, azimuth);
            let by_lobe = h * (2.0 * local_v.dot(h)) - local_v;
            let by_light =
                self.panorama.as_ref().map(|(panorama, cumulative)| pick(panorama, cumulative, place));
            for l in [Some(world(by_cosine)), Some(world(by_lobe)), by_light].into_iter().flatten() {
                let n_dot_l = n.dot(l);
                if n_dot_l <= 0.0 {
                    continue;
                }
                let radiance = self.panorama.as_ref().map_or(DVec3::ZERO, |(p, _)| p.radiance(l));
                let reflected = brdf(surface, n, v, l) * n_dot_l / self.density(local_v, alpha, n, v, l);
                sums[0] += reflected;
                sums[1] += reflected * radiance;
            }
        }
        sums.map(|sum| sum / f64::from(self.samples))
    }

    /// Of all three ways together, per steradian.
    fn density(&self, local_v: DVec3, alpha: f64, n: DVec3, v: DVec3, l: DVec3) -> f64 {
        let h = (v + l).normalize_or_zero();
        let by_cosine = n.dot(l) * FRAC_1_PI;
        let by_lobe = d_ggx(n.dot(h).clamp(0.0, 1.0), n.cross(h), alpha) / (2.0 * masking(local_v.z, alpha));
        let by_light =
            self.panorama.as_ref().map_or(0.0, |(panorama, cumulative)| probability(panorama, cumulative, l));
        by_cosine + by_lobe + by_light
    }
}

/// n·v + sqrt(alpha² + (1 - alpha²) n·v²): G1 is 2 n·v over it (Heitz 2014, equation 43 with GGX's Lambda).
fn masking(n_dot_v: f64, alpha: f64) -> f64 {
    n_dot_v + (alpha * alpha + (1.0 - alpha * alpha) * n_dot_v * n_dot_v).sqrt()
}

/// A normal as seen from `v`, both around +Z (Heitz 2018, appendix A), for a place on the unit disk.
fn visible_normal(v: DVec3, alpha: f64, radius: f64, azimuth: f64) -> DVec3 {
    // Seen from where the distribution is a hemisphere.
    let stretched = DVec3::new(alpha * v.x, alpha * v.y, v.z).normalize();
    let first = DVec3::new(-stretched.y, stretched.x, 0.0).try_normalize().unwrap_or(DVec3::X);
    let second = stretched.cross(first);
    let (x, y) = (radius * azimuth.cos(), radius * azimuth.sin());
    let visible = 0.5 * (1.0 + stretched.z);
    let y = (1.0 - visible) * (1.0 - x * x).sqrt() + visible * y;
    let up = (1.0 - x * x - y * y).max(0.0).sqrt();
    let hemisphere = first * x + second * y + stretched * up;
    DVec3::new(alpha * hemisphere.x, alpha * hemisphere.y, hemisphere.z.max(0.0)).normalize()
}

/// Sums of the texels' shares in the panorama's light, a tenth of it spread evenly so that no direction has none.
fn cumulative(panorama: &Panorama) -> Vec<f64> {
    let texels = panorama.texels();
    let width = panorama.width() as usize;
    let light: Vec<f64> = texels
        .iter()
        .enumerate()
        .map(|(i, texel)| f64::from(texel.element_sum()) * solid_angle(panorama, i / width))
        .collect();
    let all = light.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let share =
        |(i, light): (usize, &f64)| 0.9 * light / all + 0.1 * solid_angle(panorama, i / width) / (4.0 * PI);
    let sums = light.iter().enumerate().map(share).scan(0.0, |sum, share| {
        *sum += share;
        Some(*sum)
    });
    sums.collect()
}

/// Of a texel in this row, sr.
fn solid_angle(panorama: &Panorama, row: usize) -> f64 {
    let edge = |row: usize| (PI * row as f64 / f64::from(panorama.height())).cos();
    (edge(row) - edge(row + 1)) * TAU / f64::from(panorama.width())
}

/// A direction where the panorama is bright.
fn pick(panorama: &Panorama, cumulative: &[f64], place: DVec2) -> DVec3 {
    let last = cumulative[cumulative.len() - 1];
    let texel = cumulative.partition_point(|sum| *sum <= place.x * last).min(cumulative.len() - 1);
    let before = if texel == 0 { 0.0 } else { cumulative[texel - 1] };
    let within = (place.x * last - before) / (cumulative[texel] - before);
    let width = panorama.width() as usize;
    let (column, row) = (texel % width, texel / width);
    // Even in solid angle: in the cosine from the row's upper edge to its lower one.
    let edge = |row: usize| (PI * row as f64 / f64::from(panorama.height())).cos();
    let cos = edge(row) + (edge(row + 1) - edge(row)) * within.clamp(0.0, 1.0);
    direction_from_uv([(column as f64 + place.y) / width as f64, cos.clamp(-1.0, 1.0).acos() / PI])
}

/// Of [`pick`], per steradian.
fn probability(panorama: &Panorama, cumulative: &[f64], l: DVec3) -> f64 {
    let [u, v] = uv_from_direction(l);
    let index = |place: f64, count: u32| ((place * f64::from(count)) as usize).min(count as usize - 1);
    let (column, row) = (index(u, panorama.width()), index(v, panorama.height()));
    let texel = row * panorama.width() as usize + column;
    let before = if texel == 0 { 0.0 } else { cumulative[texel - 1] };
    (cumulative[texel] - before) / cumulative[cumulative.len() - 1] / solid_angle(panorama, row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::split_sum as table;
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

    /// Of what the fit for mobile GPUs says that a dielectric and a white metal reflect: the most, where, and the mean.
    #[test]
    fn the_fit_without_a_table_is_off_by_what_is_published() {
        let places: Vec<_> =
            (0..2500).map(|i| (f64::from(i % 50) / 49.0, f64::from(i / 50) / 49.0)).collect();
        let errors = |f0: f64| {
            let error = |&(n_dot_v, roughness): &(f64, f64)| {
                let [a, b] = split_sum(n_dot_v, roughness, 100);
                let [c, d] = table::fitted(n_dot_v, roughness);
                (f0 * (c - a) + d - b, n_dot_v, roughness)
            };
            let all: Vec<_> = places.par_iter().map(error).collect();
            let mean = all.iter().map(|e| e.0.abs()).sum::<f64>() / all.len() as f64;
            let worst = all.into_iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).unwrap();
            println!(
                "f0 {f0}: at most {:.3} at n·v {:.3}, roughness {:.3}; mean {mean:.4}",
                worst.0, worst.1, worst.2
            );
            (worst, mean)
        };
        let ((dielectric, ..), dielectric_mean) = errors(0.04);
        let ((metal, n_dot_v, roughness), metal_mean) = errors(1.0);
        assert!((0.09..0.105).contains(&dielectric.abs()) && dielectric_mean < 0.02, "{dielectric}");
        assert!((0.53..0.57).contains(&metal.abs()) && metal_mean < 0.12, "{metal} {n_dot_v} {roughness}");
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

//! Light that arrives from every direction alike.

use glam::DVec3;

use super::brdf::{DIELECTRIC_F0, MIN_N_DOT_V};
use super::gbuffer::Attributes;

/// Directional albedo of the specular lobe: Karis, "Physically Based Shading on Mobile", 2014, an analytic fit to
/// the two integrals of his split-sum approximation.
pub fn env_brdf(f0: DVec3, roughness: f64, n_dot_v: f64) -> DVec3 {
    let r =
        [1.0 - roughness, 0.0425 - 0.0275 * roughness, 1.04 - 0.572 * roughness, -0.04 + 0.022 * roughness];
    let a004 = (r[0] * r[0]).min((-9.28 * n_dot_v).exp2()) * r[0] + r[1];
    f0 * (-1.04 * a004 + r[2]) + (1.04 * a004 + r[3])
}

/// Reflected ambient light in cd/m²: `ambient_nt` is the radiance from every direction, `occlusion` its visible
/// part.
///
/// The diffuse part of a uniform environment is its radiance times the albedo (glTF 2.0 appendix B.2 with the
/// integral of n·l / pi = 1); the specular part is [`env_brdf`].
pub fn light_ambient(surface: &Attributes, n_dot_v: f64, ambient_nt: DVec3, occlusion: f64) -> DVec3 {
    let f0 = DVec3::splat(DIELECTRIC_F0).lerp(surface.base_color, surface.metallic);
    let diffuse = surface.base_color * (1.0 - surface.metallic);
    let specular = env_brdf(f0, surface.roughness, n_dot_v.clamp(MIN_N_DOT_V, 1.0));
    ambient_nt * occlusion * (diffuse + specular)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::directional_albedo;

    #[test]
    fn the_fit_follows_the_integral() {
        /// Karis gives no figure for his fit's error, only plots, and against glTF's integrals it is coarse:
        /// for white metal it is 1 - 0.55 roughness at every angle, where the truth at roughness 1 goes from
        /// 0.31 (facing) to 0.76 (n·v = 0.1). Dielectrics are within a tenth.
        const METAL: f64 = 0.32;
        const DIELECTRIC: f64 = 0.09;
        const MEAN: f64 = 0.07;
        let mut errors = Vec::new();
        for roughness in [0.1, 0.25, 0.5, 0.75, 1.0] {
            for n_dot_v in [0.1, 0.3, 0.6, 1.0] {
                for f0 in [DIELECTRIC_F0, 0.5, 1.0] {
                    let surface = Attributes {
                        roughness,
                        base_color: DVec3::splat(f0),
                        metallic: 1.0,
                        ..Attributes::default()
                    };
                    let truth = directional_albedo(&surface, n_dot_v).x;
                    let fit = env_brdf(DVec3::splat(f0), roughness, n_dot_v).x;
                    let bound = if f0 == DIELECTRIC_F0 { DIELECTRIC } else { METAL };
                    assert!((truth - fit).abs() < bound, "{roughness} {n_dot_v} {f0}: {truth} {fit}");
                    errors.push((truth - fit).abs());
                }
            }
        }
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(mean < MEAN, "{mean}");
    }

    #[test]
    fn occlusion_and_radiance_scale_it() {
        let surface = Attributes { roughness: 0.4, base_color: DVec3::splat(0.5), ..Attributes::default() };
        let full = light_ambient(&surface, 0.7, DVec3::ONE, 1.0);
        let half = light_ambient(&surface, 0.7, DVec3::new(2.0, 0.0, 1.0), 0.25);
        assert!((half - full * DVec3::new(0.5, 0.0, 0.25)).length() < 1e-15);
        // Diffuse and a dielectric's few per cent.
        assert!(full.x > 0.5 && full.x < 0.62);
    }

    #[test]
    fn a_metal_has_no_diffuse_part() {
        let surface = Attributes { metallic: 1.0, base_color: DVec3::X, ..Attributes::default() };
        let light = light_ambient(&surface, 1.0, DVec3::ONE, 1.0);
        assert!(light.x > 0.95 && light.y.abs() < 0.02, "{light}");
    }
}

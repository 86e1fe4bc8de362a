//! The metallic-roughness BRDF of glTF 2.0, appendix B.3.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::gbuffer::Attributes;
use crate::plan::Brdf;

/// Perceptual roughness is clamped to at least this, so that alpha = roughness² = 0.002 and alpha² = 4.1e-6:
/// the peak of D, 1 / (pi alpha²) = 7.8e4, and its square stay in the range and precision of f32, and a
/// highlight is not narrower than a light could be seen through f32 directions.
pub const MIN_ROUGHNESS: f64 = 0.045;

/// n·v is clamped to at least this: interpolated and mapped normals may face away from the viewer.
pub const MIN_N_DOT_V: f64 = 1e-4;

/// Reflectance of a dielectric at normal incidence: index of refraction 1.5 (glTF 2.0 appendix B.3.2).
pub const DIELECTRIC_F0: f64 = 0.04;

/// alpha of the microfacet distribution: the clamped roughness squared (glTF 2.0 appendix B.2.3).
pub fn alpha_from_roughness(roughness: f64) -> f64 {
    let r = roughness.max(MIN_ROUGHNESS);
    r * r
}

/// Trowbridge-Reitz (GGX) normal distribution, glTF 2.0 appendix B.3.2: Walter et al. 2007, eq. 33.
///
/// |n × h|² stands for 1 - (n·h)², which cancels near the peak. The denominator's base is at least alpha² for
/// any unit h; for h = 0, when the light shines straight at the viewer, that bound stands in. No microfacet
/// faces below the surface: 0 where n·h is not positive. 1/sr.
pub fn d_ggx(n_dot_h: f64, n_cross_h: DVec3, alpha: f64) -> f64 {
    if n_dot_h <= 0.0 {
        return 0.0;
    }
    let alpha_squared = alpha * alpha;
    let f = (n_dot_h * n_dot_h * alpha_squared + n_cross_h.length_squared()).max(alpha_squared);
    alpha_squared / (PI * f * f)
}

/// Height-correlated Smith visibility G / (4 n·l n·v), glTF 2.0 appendix B.3.2: Heitz 2014, eq. 99.
///
/// With n·v of at least [`MIN_N_DOT_V`] and a clamped alpha the denominator is at least 2e-7, also at n·l = 0.
pub fn v_smith_correlated(n_dot_l: f64, n_dot_v: f64, alpha: f64) -> f64 {
    let alpha_squared = alpha * alpha;
    let lambda_v = n_dot_l * (n_dot_v * n_dot_v * (1.0 - alpha_squared) + alpha_squared).sqrt();
    let lambda_l = n_dot_v * (n_dot_l * n_dot_l * (1.0 - alpha_squared) + alpha_squared).sqrt();
    0.5 / (lambda_v + lambda_l)
}

/// [`v_smith_correlated`] without square roots: exact at alpha = 0 and 1, the denominator linear in alpha between (Hammon, "PBR
/// Diffuse Lighting for GGX+Smith Microsurfaces", 2017, "Smith's shadowing-masking").
pub fn v_smith_fitted(n_dot_l: f64, n_dot_v: f64, alpha: f64) -> f64 {
    let smooth = 2.0 * n_dot_l * n_dot_v;
    0.5 / (smooth + (n_dot_l + n_dot_v - smooth) * alpha)
}

/// Schlick's Fresnel reflectance with f90 = 1, glTF 2.0 appendix B.3.4: Schlick 1994, eq. 15.
pub fn f_schlick(f0: DVec3, v_dot_h: f64) -> DVec3 {
    f0 + (1.0 - f0) * (1.0 - v_dot_h).clamp(0.0, 1.0).powi(5)
}

/// The BRDF for unit vectors away from the surface, 1/sr; the caller multiplies by n·l and the light.
///
/// glTF 2.0 appendix B.2: dielectric (diffuse under a coat) and metal, mixed by metallicness.
pub fn brdf(surface: &Attributes, n: DVec3, v: DVec3, l: DVec3) -> DVec3 {
    let (diffuse, specular) = brdf_parts(Brdf::Exact, surface, n, v, l);
    surface.diffuse() * diffuse + specular
}

/// The BRDF as what diffuse albedo multiplies, and the rest. Half floats are not modelled here: [`Brdf::Mediump`] is exact.
pub fn brdf_parts(brdf: Brdf, surface: &Attributes, n: DVec3, v: DVec3, l: DVec3) -> (f64, DVec3) {
    let h = (v + l).normalize_or_zero();
    let alpha = alpha_from_roughness(surface.roughness);
    let n_dot_v = n.dot(v).max(MIN_N_DOT_V);
    let n_dot_l = n.dot(l).max(0.0);
    let v_dot_h = v.dot(h).clamp(0.0, 1.0);

    let d = d_ggx(n.dot(h).clamp(0.0, 1.0), n.cross(h), alpha);
    let visibility = match brdf {
        Brdf::Exact | Brdf::Mediump => v_smith_correlated,
        Brdf::Fitted => v_smith_fitted,
    };
    let specular = d * visibility(n_dot_l, n_dot_v, alpha);
    let coat = f_schlick(DVec3::splat(DIELECTRIC_F0), v_dot_h);
    let fresnel = match surface.reflectance {
        Some(f0) => f_schlick(f0, v_dot_h),
        None => coat.lerp(f_schlick(surface.base_color, v_dot_h), surface.metallic),
    };
    (FRAC_1_PI * (1.0 - coat.x), fresnel * specular)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::{direction, directional_albedo};

    fn metal(roughness: f64) -> Attributes {
        Attributes { lit: true, roughness, base_color: DVec3::ONE, metallic: 1.0, ..Attributes::default() }
    }

    #[test]
    fn d_is_a_distribution_of_projected_area() {
        // Integral of D n·h over the hemisphere. Substituting s = sin², tan² = alpha² x / (1 - x) spreads the
        // narrowest peak evenly over x; the midpoint rule is then exact to its step.
        for alpha in [0.002_025, 0.01, 0.1, 0.5, 1.0] {
            let steps = 20_000;
            let total: f64 = (0..steps)
                .map(|i| {
                    let x = (f64::from(i) + 0.5) / f64::from(steps);
                    let tan2 = alpha * alpha * x / (1.0 - x);
                    let (cos2, sin2) = (1.0 / (1.0 + tan2), tan2 / (1.0 + tan2));
                    // d(sin²) = cos⁴ d(tan²); dω cos = pi d(sin²).
                    let d_tan2 = alpha * alpha / ((1.0 - x) * (1.0 - x));
                    d_ggx(cos2.sqrt(), DVec3::X * sin2.sqrt(), alpha) * PI * cos2 * cos2 * d_tan2
                        / f64::from(steps)
                })
                .sum();
            assert!((total - 1.0).abs() < 1e-9, "alpha {alpha}: {total}");
        }
    }

    #[test]
    fn d_has_no_cancellation_at_its_peak() {
        let alpha = alpha_from_roughness(0.0);
        assert!((d_ggx(1.0, DVec3::ZERO, alpha) * PI * alpha * alpha - 1.0).abs() < 1e-12);
        // At tan(theta) = alpha (Walter eq. 33): D = 1 / (4 pi alpha² cos⁴).
        let cos2 = 1.0 / (1.0 + alpha * alpha);
        let expected = 1.0 / (4.0 * PI * alpha * alpha * cos2 * cos2);
        assert!((d_ggx(cos2.sqrt(), DVec3::X * (1.0 - cos2).sqrt(), alpha) / expected - 1.0).abs() < 1e-9);
    }

    /// Heitz 2014, eq. 72: GGX's Lambda.
    fn lambda(cos: f64, alpha: f64) -> f64 {
        let tan = (1.0 - cos * cos).sqrt() / cos;
        ((1.0 + alpha * alpha * tan * tan).sqrt() - 1.0) / 2.0
    }

    #[test]
    fn v_is_the_height_correlated_masking_shadowing() {
        for alpha in [0.002_025, 0.05, 0.3, 1.0] {
            for cos_v in [0.02, 0.3, 0.71, 1.0] {
                for cos_l in [0.01, 0.2, 0.9, 1.0] {
                    let g = 1.0 / (1.0 + lambda(cos_v, alpha) + lambda(cos_l, alpha));
                    let expected = g / (4.0 * cos_v * cos_l);
                    let ratio = v_smith_correlated(cos_l, cos_v, alpha) / expected;
                    assert!((ratio - 1.0).abs() < 1e-12, "alpha {alpha}, {cos_v}, {cos_l}: {ratio}");
                }
            }
        }
        let least = v_smith_correlated(0.0, MIN_N_DOT_V, alpha_from_roughness(0.0));
        assert!(least <= 0.5 / 2e-7, "{least}");
    }

    #[test]
    fn the_fitted_visibility_is_at_most_29_percent_too_dark() {
        // Where n·l = n·v = alpha and all are small, the denominators are 2 sqrt(2) alpha² and 4 alpha².
        let (mut least, mut place) = (f64::INFINITY, [0.0; 3]);
        for i in 0..=100 {
            let alpha = (f64::from(i) / 100.0).max(alpha_from_roughness(0.0));
            for (j, k) in (0..=200).flat_map(|j| (0..=200).map(move |k| (j, k))) {
                let (n_dot_v, n_dot_l) = ((f64::from(j) / 200.0).max(MIN_N_DOT_V), f64::from(k) / 200.0);
                let ratio =
                    v_smith_fitted(n_dot_l, n_dot_v, alpha) / v_smith_correlated(n_dot_l, n_dot_v, alpha);
                assert!(ratio < 1.0 + 1e-12, "too bright by {ratio} at {alpha} {n_dot_v} {n_dot_l}");
                if ratio < least {
                    (least, place) = (ratio, [alpha, n_dot_v, n_dot_l]);
                }
            }
        }
        println!("V fitted / V exact: at least {least:.4}, at alpha, n·v, n·l = {place:?}");
        let [alpha, n_dot_v, n_dot_l] = place;
        assert!((0.707..0.712).contains(&least), "{least}");
        assert!(alpha <= 0.01 && n_dot_v <= 0.01 && n_dot_l <= 0.01, "{place:?}");
        // Exact at either end of alpha.
        for (a, b) in [(0.01, 0.7), (0.5, 0.5), (1.0, 0.02)] {
            for alpha in [0.0, 1.0] {
                assert!((v_smith_fitted(a, b, alpha) / v_smith_correlated(a, b, alpha) - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn f_goes_from_f0_to_one() {
        let f0 = DVec3::new(0.04, 0.5, 0.9);
        assert_eq!(f_schlick(f0, 1.0), f0);
        assert_eq!(f_schlick(f0, 0.0), DVec3::ONE);
        // Halfway in cosine: 2^-5 of the way from f0 to 1.
        let halfway = f0 + (DVec3::ONE - f0) / 32.0;
        assert!((f_schlick(f0, 0.5) - halfway).length() < 1e-15);
    }

    #[test]
    fn no_metal_reflects_more_than_it_receives() {
        /// The quadrature's own error at the narrowest lobe.
        const QUADRATURE: f64 = 2e-3;
        for roughness in [0.0, 0.1, 0.3, 0.5, 0.8, 1.0] {
            for cos in [0.1, 0.4, 0.8, 1.0] {
                let albedo = directional_albedo(&metal(roughness), cos).max_element();
                assert!(albedo <= 1.0 + QUADRATURE, "roughness {roughness}, cos {cos}: {albedo}");
            }
        }
    }

    #[test]
    fn smooth_white_metal_reflects_everything() {
        // Masking loses light in proportion to alpha tan(theta): none is left to lose where both are small.
        for cos in [0.4, 0.8, 1.0] {
            let albedo = directional_albedo(&metal(0.0), cos).min_element();
            assert!((albedo - 1.0).abs() < 3e-3, "cos {cos}: {albedo}");
        }
        // A rough one loses a good part: single scattering.
        assert!(directional_albedo(&metal(1.0), 0.5).max_element() < 0.8);
    }

    #[test]
    fn fully_rough_white_metal_has_a_closed_form() {
        // At alpha = 1, D = 1 / pi and V = 1 / (2 (n·l + n·v)): the integral of n·l / (n·l + n·v) over n·l.
        for cos in [0.1, 0.5, 1.0_f64] {
            let expected = 1.0 - cos * ((1.0 + cos) / cos).ln();
            let albedo = directional_albedo(&metal(1.0), cos).x;
            assert!((albedo - expected).abs() < 2e-3, "cos {cos}: {albedo} {expected}");
        }
    }

    #[test]
    fn light_and_viewer_may_be_exchanged() {
        let n = DVec3::Z;
        for (metallic, roughness) in [(0.0, 0.2), (0.5, 0.6), (1.0, 0.05), (1.0, 1.0)] {
            let base_color = DVec3::new(0.9, 0.4, 0.1);
            let surface = Attributes { base_color, metallic, roughness, ..metal(0.0) };
            for (a, b) in [((0.3, 0.1), (0.9, 2.0)), ((0.99, 3.0), (0.05, 0.4)), ((0.6, 1.0), (0.6, 4.1))] {
                let (v, l) = (direction(a.0, a.1), direction(b.0, b.1));
                let (there, back) = (brdf(&surface, n, v, l), brdf(&surface, n, l, v));
                assert!((there - back).length() <= 1e-12 * there.length(), "{there} {back}");
            }
        }
    }

    #[test]
    fn a_black_body_keeps_only_the_coat() {
        // A black dielectric at normal incidence and roughness 1: D = 1/pi, V = 1/4, F = 0.04.
        let surface =
            Attributes { roughness: 1.0, base_color: DVec3::ZERO, metallic: 0.0, ..Attributes::default() };
        let value = brdf(&surface, DVec3::Z, DVec3::Z, DVec3::Z);
        assert!((value - DVec3::splat(0.04 / (4.0 * PI))).length() < 1e-15);
        // A white one adds 0.96 / pi.
        let white = Attributes { base_color: DVec3::ONE, ..surface };
        let added = brdf(&white, DVec3::Z, DVec3::Z, DVec3::Z) - value;
        assert!((added - DVec3::splat(0.96 / PI)).length() < 1e-12);
    }

    #[test]
    fn no_microfacet_faces_below_the_surface() {
        // A viewer under the horizon, further than the light is above it.
        let (v, l) = (direction(-0.6, 0.0), direction(0.3, 0.0));
        assert_eq!(brdf(&metal(0.5), DVec3::Z, v, l), DVec3::ZERO);
        assert!(brdf(&metal(0.5), DVec3::Z, direction(-0.2, 0.0), l).x > 0.0);
    }

    #[test]
    fn degenerate_directions_stay_finite() {
        for roughness in [0.0, 1.0] {
            for (v, l) in [(DVec3::X, DVec3::X), (DVec3::X, DVec3::NEG_X), (DVec3::NEG_Z, DVec3::Z)] {
                assert!(brdf(&metal(roughness), DVec3::Z, v, l).is_finite());
            }
        }
    }
}

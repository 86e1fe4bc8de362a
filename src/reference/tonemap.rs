//! From scene-referred to display-referred light, both linear Rec.709.

use glam::{DMat3, DVec3};

use crate::plan::Tonemap;

/// Applies a curve to exposed light; negative input counts as 0. The result is not clamped at 1.
pub fn tonemap(curve: Tonemap, light: DVec3) -> DVec3 {
    let light = light.max(DVec3::ZERO);
    match curve {
        Tonemap::Neutral => tonemap_neutral(light),
        Tonemap::Aces => tonemap_aces(light),
        Tonemap::Reinhard => tonemap_reinhard(light),
        Tonemap::Linear => light,
    }
}

/// Khronos PBR Neutral Tone Mapper, specification of 2024, constants as named there.
pub fn tonemap_neutral(light: DVec3) -> DVec3 {
    const F90: f64 = 0.04;
    const K_S: f64 = 0.8 - F90;
    const K_D: f64 = 0.15;
    let x = light.min_element();
    let f = if x < 2.0 * F90 { x - x * x / (4.0 * F90) } else { F90 };
    let color = light - f;
    let peak = color.max_element();
    if peak <= K_S {
        return color;
    }
    let compressed = 1.0 - (1.0 - K_S) * (1.0 - K_S) / (peak + 1.0 - 2.0 * K_S);
    let g = 1.0 / (K_D * (peak - compressed) + 1.0);
    DVec3::splat(compressed).lerp(color * (compressed / peak), g)
}

/// Stephen Hill's fit of the ACES reference rendering transform and the sRGB output transform (in MJP's
/// BakingLab, ACES.hlsl), Rec.709 in and out, without that file's exposure factor.
///
/// The curve of 0 is below 0, and saturated colours leave Rec.709: no display shows less than no light.
pub fn tonemap_aces(light: DVec3) -> DVec3 {
    // Rec.709 -> XYZ -> D65 to D60 -> AP1 -> RRT saturation; and back. Rows as printed.
    let rrt_from_rec709 = from_rows(ACES_RRT_FROM_REC709);
    let rec709_from_odt = from_rows(ACES_REC709_FROM_ODT);
    let v = rrt_from_rec709 * light;
    let fitted =
        (v * (v + 0.0245786) - DVec3::splat(0.000090537)) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    (rec709_from_odt * fitted).max(DVec3::ZERO)
}

/// Rows of the matrix before Hill's fit.
pub(super) const ACES_RRT_FROM_REC709: [[f64; 3]; 3] =
    [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];

/// Rows of the matrix after it.
pub(super) const ACES_REC709_FROM_ODT: [[f64; 3]; 3] =
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];

fn from_rows(rows: [[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(&rows).transpose()
}

/// Reinhard et al., "Photographic Tone Reproduction for Digital Images", 2002, eq. 3, per channel.
pub fn tonemap_reinhard(light: DVec3) -> DVec3 {
    light / (1.0 + light)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_below_the_shoulder_only_removes_the_coat() {
        // At and above twice F90 in every channel, below the shoulder: 0.04 less, hue and contrast untouched.
        for light in [DVec3::new(0.1, 0.2, 0.5), DVec3::splat(0.08), DVec3::new(0.8, 0.09, 0.3)] {
            assert!((tonemap_neutral(light) - (light - 0.04)).length() < 1e-15);
        }
        // A channel of 0 leaves the others as they are; grey within the toe is x² / 0.16.
        assert_eq!(tonemap_neutral(DVec3::new(0.5, 0.0, 0.2)), DVec3::new(0.5, 0.0, 0.2));
        assert!((tonemap_neutral(DVec3::splat(0.04)) - DVec3::splat(0.01)).length() < 1e-15);
    }

    #[test]
    fn neutral_compresses_grey_by_a_hyperbola() {
        // Grey stays grey: 1 - 0.24² / (x - 0.04 + 0.24 - 0.76).
        for x in [0.9, 1.0, 4.0, 100.0] {
            let expected = 1.0 - 0.0576 / (x - 0.56);
            assert!((tonemap_neutral(DVec3::splat(x)) - DVec3::splat(expected)).length() < 1e-12);
        }
        // Very bright red turns white.
        let red = tonemap_neutral(DVec3::new(1e4, 0.0, 0.0));
        assert!(red.y > 0.99 && red.x > red.y);
    }

    #[test]
    fn neutral_is_smooth_at_the_shoulder() {
        let at = |x: f64| tonemap_neutral(DVec3::splat(x)).x;
        let step = 1e-6;
        let (below, above) = ((at(0.8) - at(0.8 - step)) / step, (at(0.8 + step) - at(0.8)) / step);
        assert!((below - 1.0).abs() < 1e-5 && (above - 1.0).abs() < 1e-4, "{below} {above}");
    }

    #[test]
    fn reinhard_has_its_values() {
        let out = tonemap_reinhard(DVec3::new(0.0, 1.0, 3.0));
        assert!((out - DVec3::new(0.0, 0.5, 0.75)).length() < 1e-15);
    }

    /// The fit for grey in scalars: both matrices reduce to their row sums.
    fn aces_grey(x: f64) -> DVec3 {
        let input = [0.59719 + 0.35458 + 0.04823, 0.076 + 0.90834 + 0.01566, 0.0284 + 0.13383 + 0.83777];
        let curve =
            |v: f64| (v * v + 0.0245786 * v - 0.000090537) / (0.983729 * v * v + 0.432951 * v + 0.238081);
        let [r, g, b] = input.map(|row| curve(row * x));
        let unclamped = [
            1.60475 * r - 0.53108 * g - 0.07367 * b,
            1.10813 * g - 0.10208 * r - 0.00605 * b,
            1.07602 * b - 0.00327 * r - 0.07276 * g,
        ];
        DVec3::from_array(unclamped.map(|v| v.max(0.0)))
    }

    #[test]
    fn aces_on_grey_is_its_curve() {
        for x in [0.0, 0.01, 0.18, 1.0, 10.0, 1e4] {
            let out = tonemap_aces(DVec3::splat(x));
            assert!((out - aces_grey(x)).length() < 1e-12, "{x}: {out}");
            // The matrices keep white white to the printed digits.
            assert!((out.max_element() - out.min_element()).abs() < 1e-4);
        }
        // By hand: curve(1) = 1.0244881 / 1.654761 = 0.619115.
        assert!((tonemap_aces(DVec3::ONE).x - 0.619_115).abs() < 2e-5);
    }

    #[test]
    fn aces_keeps_each_primary_dominant() {
        // The rows and columns are in order: a transposed matrix turns blue light redder than greener.
        let blue = tonemap_aces(DVec3::new(0.0, 0.0, 1.0));
        let v = [0.04823, 0.01566, 0.83777]
            .map(|v: f64| (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081));
        assert!((blue.z - (1.07602 * v[2] - 0.00327 * v[0] - 0.07276 * v[1])).abs() < 1e-12);
        // Redder than Rec.709 can show: less than none.
        assert!(1.60475 * v[0] - 0.53108 * v[1] - 0.07367 * v[2] < 0.0 && blue.x == 0.0);
        assert!(blue.z > blue.x && blue.z > blue.y);
    }

    #[test]
    fn curves_rise_and_stay_in_range() {
        /// Hill's fit tends to 1 / 0.983729, and passes 0 where x² + 0.0245786 x = 0.000090537.
        const ACES_MOST: f64 = 1.0166;
        const ACES_BLACK: f64 = 0.003_253_1;
        for curve in [Tonemap::Neutral, Tonemap::Reinhard, Tonemap::Aces] {
            let (black, most) = if curve == Tonemap::Aces { (ACES_BLACK, ACES_MOST) } else { (0.0, 1.0) };
            let mut previous = 0.0;
            for step in 0..4000 {
                let x = (f64::from(step) * 0.005 - 10.0).exp2();
                let out = tonemap(curve, DVec3::splat(x)).x;
                let rises = if x > black { out > previous } else { out == 0.0 };
                assert!(rises && out < most, "{curve} at {x}: {out}");
                previous = out;
            }
        }
    }

    #[test]
    fn no_curve_shows_less_than_no_light() {
        let levels = [0.0, 1e-4, 3e-3, 0.18, 1.0, 30.0];
        for &curve in Tonemap::ALL {
            for r in levels {
                for (g, b) in levels.into_iter().flat_map(|g| levels.map(|b| (g, b))) {
                    let out = tonemap(curve, DVec3::new(r, g, b));
                    assert!(out.min_element() >= 0.0, "{curve} of {r} {g} {b}: {out}");
                }
            }
        }
    }

    #[test]
    fn negative_light_counts_as_none() {
        for &curve in Tonemap::ALL {
            assert_eq!(tonemap(curve, DVec3::splat(-1.0)), tonemap(curve, DVec3::ZERO));
        }
        assert_eq!(tonemap(Tonemap::Linear, DVec3::new(7.0, 0.5, 0.0)), DVec3::new(7.0, 0.5, 0.0));
    }
}

//! From the display back to the exposed light that a curve made it of.

use glam::{DMat3, DVec3};

use super::tonemap::{ACES_REC709_FROM_ODT, ACES_RRT_FROM_REC709};
use crate::plan::Tonemap;

/// What the brightest displayed value counts as: curves reach 1 at infinity, which the last of 255 sRGB steps shows from its lower
/// half on.
pub const DISPLAY_MOST: f64 = 0.99555;

/// The exposed light that [`tonemap`](super::tonemap::tonemap) turns into `display`: exact for what the curve makes of light of all
/// channels below [`DISPLAY_MOST`], and the least light that looks like it for the rest (what ACES moves out of Rec.709 is cut off
/// there).
pub fn tonemap_inverse(curve: Tonemap, display: DVec3) -> DVec3 {
    if curve == Tonemap::Linear {
        return display.max(DVec3::ZERO);
    }
    let display = display.clamp(DVec3::ZERO, DVec3::splat(DISPLAY_MOST));
    match curve {
        Tonemap::Neutral => inverse_neutral(display),
        Tonemap::Aces => inverse_aces(display),
        Tonemap::Reinhard => display / (1.0 - display),
        Tonemap::Linear => display,
    }
}

/// The three steps of [`tonemap_neutral`](super::tonemap::tonemap_neutral) from the last to the first.
fn inverse_neutral(display: DVec3) -> DVec3 {
    const F90: f64 = 0.04;
    const K_S: f64 = 0.8 - F90;
    const K_D: f64 = 0.15;
    let compressed = display.max_element();
    let mut color = display;
    if compressed > K_S {
        let peak = (1.0 - K_S) * (1.0 - K_S) / (1.0 - compressed) - 1.0 + 2.0 * K_S;
        let g = 1.0 / (K_D * (peak - compressed) + 1.0);
        color = ((display - compressed * (1.0 - g)) / g).max(DVec3::ZERO) * (peak / compressed);
    }
    let low = color.min_element();
    let x = if low < F90 { 2.0 * (F90 * low.max(0.0)).sqrt() } else { low + F90 };
    color + (x - low)
}

/// Each channel's quadratic between the inverted matrices of [`tonemap_aces`](super::tonemap::tonemap_aces).
fn inverse_aces(display: DVec3) -> DVec3 {
    let matrix = |rows: [[f64; 3]; 3]| DMat3::from_cols_array_2d(&rows).transpose().inverse();
    // The fit tends to 1 / 0.983729; what is brighter than this is some 50 times white.
    let y = (matrix(ACES_REC709_FROM_ODT) * display).clamp(DVec3::ZERO, DVec3::splat(0.98));
    let a = 1.0 - 0.983729 * y;
    let b = 0.0245786 - 0.4329510 * y;
    let c = -0.000090537 - 0.238081 * y;
    let root = (b * b - 4.0 * a * c).max(DVec3::ZERO);
    let x = (DVec3::new(root.x.sqrt(), root.y.sqrt(), root.z.sqrt()) - b) / (2.0 * a);
    (matrix(ACES_RRT_FROM_REC709) * x).max(DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::super::tonemap::tonemap;
    use super::*;

    /// There and back, for all colours whose display value is below the most and inside of Rec.709.
    #[test]
    fn what_a_curve_did_is_undone() {
        let levels = [0.002, 0.01, 0.039, 0.05, 0.3, 0.79, 0.9, 1.5, 4.0];
        let mut checked = 0;
        for &curve in Tonemap::ALL {
            for r in levels {
                for (g, b) in levels.into_iter().flat_map(|g| levels.map(|b| (g, b))) {
                    let light = DVec3::new(r, g, b);
                    let display = tonemap(curve, light);
                    if curve != Tonemap::Linear
                        && (display.max_element() > DISPLAY_MOST || display.min_element() <= 0.0)
                    {
                        continue;
                    }
                    let back = tonemap_inverse(curve, display);
                    assert!(
                        (back - light).abs().max_element() < 1e-9 * light.max_element().max(1.0),
                        "{curve} {light}: {back}"
                    );
                    checked += 1;
                }
            }
        }
        assert!(checked > 1500, "{checked}");
    }

    #[test]
    fn the_brightest_is_finite() {
        for &curve in Tonemap::ALL {
            let light = tonemap_inverse(curve, DVec3::ONE);
            assert!(light.is_finite() && light.min_element() >= 1.0, "{curve}: {light}");
        }
    }
}

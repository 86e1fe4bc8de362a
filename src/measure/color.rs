//! Colour spaces of the error metrics that model an eye: linear Rec.709 to CIE XYZ, CIELAB and YCxCz, white D65.

use glam::{DMat3, DVec3};

/// The white point of sRGB in XYZ, as the matrix below gives it.
const D65: DVec3 = DVec3::new(0.950_428_545, 1.0, 1.088_900_371);

/// Columns: the XYZ of red, green and blue (IEC 61966-2-1, with the fractions of the FLIP paper's supplement).
const XYZ_FROM_LINEAR: DMat3 = DMat3::from_cols(
    DVec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
    DVec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
    DVec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
);

/// CIELAB (CIE 015) of linear Rec.709 light, 1 being the display's white: L* from 0 to 100, a*, b*.
pub fn lab_from_linear(linear: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| match t > DELTA * DELTA * DELTA {
        true => t.cbrt(),
        false => t / (3.0 * DELTA * DELTA) + 4.0 / 29.0,
    };
    let DVec3 { x, y, z } = XYZ_FROM_LINEAR * linear / D65;
    let [x, y, z] = [f(x), f(y), f(z)];
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// YCxCz of linear Rec.709 light: CIELAB without its cube roots, so that blurring it blurs light (Flohr et al. 1993).
pub(super) fn ycxcz_from_linear(linear: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = XYZ_FROM_LINEAR * linear / D65;
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// The inverse of [`ycxcz_from_linear`].
pub(super) fn linear_from_ycxcz(color: DVec3) -> DVec3 {
    let y = (color.x + 16.0) / 116.0;
    let xyz = DVec3::new(color.y / 500.0 + y, y, y - color.z / 200.0);
    XYZ_FROM_LINEAR.inverse() * (xyz * D65)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_colours_have_their_coordinates() {
        // White is white, and sRGB's red is (53.24, 80.09, 67.20) in every table.
        assert!(lab_from_linear(DVec3::ONE).abs_diff_eq(DVec3::new(100.0, 0.0, 0.0), 1e-6));
        assert!(lab_from_linear(DVec3::X).abs_diff_eq(DVec3::new(53.24, 80.09, 67.20), 0.02));
        assert!(lab_from_linear(DVec3::ZERO).abs_diff_eq(DVec3::ZERO, 1e-12));
        let color = DVec3::new(0.2, 0.5, 0.01);
        assert!(linear_from_ycxcz(ycxcz_from_linear(color)).abs_diff_eq(color, 1e-12));
    }
}

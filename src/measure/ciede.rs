//! CIEDE2000, the colour difference of CIE 142-2001.

use glam::DVec3;

/// How different two CIELAB colours look: 1 is about what an eye can just tell apart.
///
/// The formula, with its weights kL = kC = kH = 1, is that of Sharma, Wu and Dalal, "The CIEDE2000 color-difference
/// formula: implementation notes, supplementary test data, and mathematical observations" (2005), equations 2 to 22.
pub fn ciede2000(a: DVec3, b: DVec3) -> f64 {
    let chroma = |lab: DVec3| lab.y.hypot(lab.z);
    // x^7 / (x^7 + 25^7), which saturates at high chroma.
    let saturation = |x: f64| (x.powi(7) / (x.powi(7) + 25.0_f64.powi(7))).sqrt();
    let g = 0.5 * (1.0 - saturation(0.5 * (chroma(a) + chroma(b))));
    let polar = |lab: DVec3| {
        let red = (1.0 + g) * lab.y;
        let hue = lab.z.atan2(red).to_degrees().rem_euclid(360.0);
        (red.hypot(lab.z), hue)
    };
    let ((chroma_a, hue_a), (chroma_b, hue_b)) = (polar(a), polar(b));
    let colourless = chroma_a * chroma_b == 0.0;
    let turn = match hue_b - hue_a {
        _ if colourless => 0.0,
        turn if turn > 180.0 => turn - 360.0,
        turn if turn < -180.0 => turn + 360.0,
        turn => turn,
    };
    let d_lightness = b.x - a.x;
    let d_chroma = chroma_b - chroma_a;
    let d_hue = 2.0 * (chroma_a * chroma_b).sqrt() * (0.5 * turn).to_radians().sin();

    let lightness = 0.5 * (a.x + b.x);
    let chroma = 0.5 * (chroma_a + chroma_b);
    let sum = hue_a + hue_b;
    let hue = match (hue_a - hue_b).abs() {
        _ if colourless => sum,
        apart if apart <= 180.0 => 0.5 * sum,
        _ if sum < 360.0 => 0.5 * (sum + 360.0),
        _ => 0.5 * (sum - 360.0),
    };
    let cos = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cos(hue - 30.0) + 0.24 * cos(2.0 * hue) + 0.32 * cos(3.0 * hue + 6.0)
        - 0.20 * cos(4.0 * hue - 63.0);
    let from_grey = (lightness - 50.0).powi(2);
    let s_lightness = 1.0 + 0.015 * from_grey / (20.0 + from_grey).sqrt();
    let s_chroma = 1.0 + 0.045 * chroma;
    let s_hue = 1.0 + 0.015 * chroma * t;
    // Blue turns with chroma.
    let rotated = 30.0 * (-((hue - 275.0) / 25.0).powi(2)).exp();
    let r = -2.0 * saturation(chroma) * (2.0 * rotated).to_radians().sin();
    let [l, c, h] = [d_lightness / s_lightness, d_chroma / s_chroma, d_hue / s_hue];
    (l * l + c * c + h * h + r * c * h).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sharma, Wu and Dalal 2005, Table 1: two colours and their difference. The pairs test every branch.
    const PAIRS: [[f64; 7]; 34] = [
        [50.0, 2.6772, -79.7751, 50.0, 0.0, -82.7485, 2.0425],
        [50.0, 3.1571, -77.2803, 50.0, 0.0, -82.7485, 2.8615],
        [50.0, 2.8361, -74.0200, 50.0, 0.0, -82.7485, 3.4412],
        [50.0, -1.3802, -84.2814, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, -1.1848, -84.8006, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, -0.9009, -85.5211, 50.0, 0.0, -82.7485, 1.0000],
        [50.0, 0.0, 0.0, 50.0, -1.0, 2.0, 2.3669],
        [50.0, -1.0, 2.0, 50.0, 0.0, 0.0, 2.3669],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0009, 7.1792],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0010, 7.1792],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0011, 7.2195],
        [50.0, 2.4900, -0.0010, 50.0, -2.4900, 0.0012, 7.2195],
        [50.0, -0.0010, 2.4900, 50.0, 0.0009, -2.4900, 4.8045],
        [50.0, -0.0010, 2.4900, 50.0, 0.0010, -2.4900, 4.8045],
        [50.0, -0.0010, 2.4900, 50.0, 0.0011, -2.4900, 4.7461],
        [50.0, 2.5000, 0.0, 50.0, 0.0, -2.5000, 4.3065],
        [50.0, 2.5000, 0.0, 73.0, 25.0, -18.0, 27.1492],
        [50.0, 2.5000, 0.0, 61.0, -5.0, 29.0, 22.8977],
        [50.0, 2.5000, 0.0, 56.0, -27.0, -3.0, 31.9030],
        [50.0, 2.5000, 0.0, 58.0, 24.0, 15.0, 19.4535],
        [50.0, 2.5000, 0.0, 50.0, 3.1736, 0.5854, 1.0000],
        [50.0, 2.5000, 0.0, 50.0, 3.2972, 0.0, 1.0000],
        [50.0, 2.5000, 0.0, 50.0, 1.8634, 0.5757, 1.0000],
        [50.0, 2.5000, 0.0, 50.0, 3.2592, 0.3350, 1.0000],
        [60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644],
        [63.0109, -31.0961, -5.8663, 62.8187, -29.7946, -4.0864, 1.2630],
        [61.2901, 3.7196, -5.3901, 61.4292, 2.2480, -4.9620, 1.8731],
        [35.0831, -44.1164, 3.7933, 35.0232, -40.0716, 1.5901, 1.8645],
        [22.7233, 20.0904, -46.6940, 23.0331, 14.9730, -42.5619, 2.0373],
        [36.4612, 47.8580, 18.3852, 36.2715, 50.5065, 21.2231, 1.4146],
        [90.8027, -2.0831, 1.4410, 91.1528, -1.6435, 0.0447, 1.4441],
        [90.9257, -0.5406, -0.9208, 88.6381, -0.8985, -0.7239, 1.5381],
        [6.7747, -0.2908, -2.4247, 5.8714, -0.0985, -2.2286, 0.6377],
        [2.0776, 0.0795, -1.1350, 0.9033, -0.0636, -0.5514, 0.9082],
    ];

    #[test]
    fn the_published_pairs_have_their_differences() {
        /// Half a step of the last digit that the table prints.
        const PRINTED: f64 = 5e-5 + 1e-9;
        for (i, [l1, a1, b1, l2, a2, b2, expected]) in PAIRS.into_iter().enumerate() {
            let (a, b) = (DVec3::new(l1, a1, b1), DVec3::new(l2, a2, b2));
            for found in [ciede2000(a, b), ciede2000(b, a)] {
                assert!((found - expected).abs() <= PRINTED, "pair {}: {found}, not {expected}", i + 1);
            }
        }
    }
}

//! FLIP: how visible the difference of two pictures is to someone who flips between them.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference Evaluator for Alternating
//! Images", HPG 2020, for pictures of display light (LDR). Sections are the paper's.

use std::f64::consts::{PI, SQRT_2};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::color::{lab_from_linear, linear_from_ycxcz, ycxcz_from_linear};

/// Pixels per degree of the paper's viewer: 0.7 m from a monitor 0.7 m and 3840 pixels wide.
pub const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// The error of each pixel, 0 (equal) to 1; rows from the top.
///
/// `reference` and `test` hold linear Rec.709 display light, clamped to \[0, 1\] here, `size[0] * size[1]` pixels each.
/// Exchanging the pictures changes nothing.
///
/// # Panics
/// If a picture does not hold as many pixels as `size` says.
pub fn flip(reference: &[DVec3], test: &[DVec3], size: [u32; 2], pixels_per_degree: f64) -> Vec<f64> {
    let size = size.map(|side| side as usize);
    let eye = Eye::new(pixels_per_degree);
    let [a, b] = [reference, test].map(|picture| {
        assert_eq!(picture.len(), size[0] * size[1], "as many pixels as the size says");
        let color = |&linear: &DVec3| ycxcz_from_linear(linear.clamp(DVec3::ZERO, DVec3::ONE));
        Seen::new(&Plane { size, texels: picture.par_iter().map(color).collect() }, &eye)
    });
    // What green and blue differ by, the most that colours of the display can (section 4.1).
    let most = hyab(hunt_adjusted(DVec3::Y), hunt_adjusted(DVec3::Z)).powf(COLOR_EXPONENT);
    (0..size[0] * size[1])
        .into_par_iter()
        .map(|i| {
            let color = redistributed(hyab(a.colors[i], b.colors[i]).powf(COLOR_EXPONENT), most);
            let [edges, points] = [(a.edges[i], b.edges[i]), (a.points[i], b.points[i])]
                .map(|(a, b)| (a.length() - b.length()).abs());
            // Section 4.3: differences of features make those of colours more visible.
            let features = (edges.max(points) / SQRT_2).powf(FEATURE_EXPONENT);
            color.powf(1.0 - features)
        })
        .collect()
}

/// q_c of section 4.1.
const COLOR_EXPONENT: f64 = 0.7;
/// p_c: differences below this part of the largest ...
const COLOR_KNEE: f64 = 0.4;
/// p_t: ... take this part of the scale.
const COLOR_KNEE_ERROR: f64 = 0.95;
/// q_f of section 4.2.
const FEATURE_EXPONENT: f64 = 0.5;
/// w: the width of what counts as a feature, degrees.
const FEATURE_WIDTH_DEGREES: f64 = 0.082;

/// Small differences take most of the scale (section 4.1).
fn redistributed(error: f64, most: f64) -> f64 {
    let knee = COLOR_KNEE * most;
    if error < knee {
        error * COLOR_KNEE_ERROR / knee
    } else {
        COLOR_KNEE_ERROR + (error - knee) / (most - knee) * (1.0 - COLOR_KNEE_ERROR)
    }
}

/// CIELAB whose colours fade in the dark (Hunt's effect).
fn hunt_adjusted(linear: DVec3) -> DVec3 {
    let lab = lab_from_linear(linear);
    let fade = 0.01 * lab.x;
    DVec3::new(lab.x, lab.y * fade, lab.z * fade)
}

/// The distance of Abasi et al. 2019, which suits large differences.
fn hyab(a: DVec3, b: DVec3) -> f64 {
    (a.x - b.x).abs() + (a.y - b.y).hypot(a.z - b.z)
}

/// One row of weights, its middle in the middle, applied along one axis.
type Weights = Vec<f64>;

/// What an eye at a distance blurs and finds.
struct Eye {
    /// Contrast sensitivity in Y and Cx: one Gaussian each.
    luminance: Weights,
    red_green: Weights,
    /// In Cz: the sum of two, with how much each contributes.
    blue_yellow: [(f64, Weights); 2],
    /// Of features: across them (edges, points), and along.
    edge: Weights,
    point: Weights,
    along: Weights,
}

impl Eye {
    fn new(pixels_per_degree: f64) -> Self {
        // Table 1: a and b of the sensitivity's Gaussians, in the frequency domain; their transforms are Gaussians too.
        const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
        let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let gaussian = |b: f64| {
            let weight = |x: i32| (-(PI * f64::from(x) / pixels_per_degree).powi(2) / b).exp();
            (-radius..=radius).map(weight).collect::<Weights>()
        };
        // The sum of the two-dimensional filter: the square of the one-dimensional one.
        let part = |(a, b): (f64, f64)| {
            let sum: f64 = gaussian(b).iter().sum();
            a * (PI / b).sqrt() * sum * sum
        };
        let whole: f64 = BLUE_YELLOW.into_iter().map(part).sum();
        let sigma = 0.5 * FEATURE_WIDTH_DEGREES * pixels_per_degree;
        let radius = (3.0 * sigma).ceil() as i32;
        let row = |weight: &dyn Fn(f64) -> f64| -> Weights {
            (-radius..=radius)
                .map(|x| weight(f64::from(x) / sigma) * (-0.5 * (f64::from(x) / sigma).powi(2)).exp())
                .collect()
        };
        Self {
            luminance: summing_to_one(gaussian(0.0047)),
            red_green: summing_to_one(gaussian(0.0053)),
            blue_yellow: BLUE_YELLOW.map(|ab| (part(ab) / whole, summing_to_one(gaussian(ab.1)))),
            edge: with_equal_sides(row(&|x| -x)),
            point: with_equal_sides(row(&|x| x * x - 1.0)),
            along: summing_to_one(row(&|_| 1.0)),
        }
    }
}

fn summing_to_one(weights: Weights) -> Weights {
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / sum).collect()
}

/// What is positive sums to 1, what is negative to -1 (section 4.2).
fn with_equal_sides(weights: Weights) -> Weights {
    let sum = |sign: f64| weights.iter().filter(|w| **w * sign > 0.0).sum::<f64>().abs();
    let (above, below) = (sum(1.0), sum(-1.0));
    weights.into_iter().map(|w| w / if w > 0.0 { above } else { below }).collect()
}

/// A picture as the eye has it.
struct Seen {
    /// Blurred, in Hunt-adjusted CIELAB.
    colors: Vec<DVec3>,
    /// Strength of edges and of points along both axes.
    edges: Vec<DVec2>,
    points: Vec<DVec2>,
}

impl Seen {
    fn new(picture: &Plane<DVec3>, eye: &Eye) -> Self {
        let channel = |pick: fn(DVec3) -> f64| picture.map(pick);
        let (y, cx, cz) = (channel(|c| c.x), channel(|c| c.y), channel(|c| c.z));
        let blur = |plane: &Plane<f64>, weights: &Weights| plane.filtered(weights, weights).texels;
        let (blurred_y, blurred_cx) = (blur(&y, &eye.luminance), blur(&cx, &eye.red_green));
        let [narrow, wide] = eye.blue_yellow.each_ref().map(|(part, weights)| (*part, blur(&cz, weights)));
        let color = |i: usize| {
            let cz = narrow.0 * narrow.1[i] + wide.0 * wide.1[i];
            let linear = linear_from_ycxcz(DVec3::new(blurred_y[i], blurred_cx[i], cz));
            hunt_adjusted(linear.clamp(DVec3::ZERO, DVec3::ONE))
        };
        let colors = (0..blurred_y.len()).into_par_iter().map(color).collect();
        // Features are those of lightness, here from 0 to 1.
        let lightness = y.map(|y| (y + 16.0) / 116.0);
        let features = |across: &Weights| {
            let x = lightness.filtered(across, &eye.along).texels;
            let y = lightness.filtered(&eye.along, across).texels;
            x.into_iter().zip(y).map(|(x, y)| DVec2::new(x, y)).collect()
        };
        Self { colors, edges: features(&eye.edge), points: features(&eye.point) }
    }
}

/// Texels, rows from the top.
struct Plane<T> {
    size: [usize; 2],
    texels: Vec<T>,
}

impl<T: Copy + Sync> Plane<T> {
    fn map<U: Send>(&self, f: impl Fn(T) -> U + Sync) -> Plane<U> {
        Plane { size: self.size, texels: self.texels.par_iter().map(|&t| f(t)).collect() }
    }
}

impl Plane<f64> {
    /// Filtered along x, then y; texels beyond the border are those on it.
    fn filtered(&self, along_x: &Weights, along_y: &Weights) -> Self {
        let [width, height] = self.size;
        if width == 0 {
            return Self { size: self.size, texels: Vec::new() };
        }
        let clamped = |place: usize, tap: usize, taps: usize, length: usize| {
            (place + tap).saturating_sub(taps / 2).min(length - 1)
        };
        let mut rows = vec![0.0; self.texels.len()];
        rows.par_chunks_mut(width).zip(self.texels.par_chunks(width)).for_each(|(out, row)| {
            for (x, out) in out.iter_mut().enumerate() {
                let taps = along_x.iter().enumerate();
                *out = taps.map(|(tap, w)| w * row[clamped(x, tap, along_x.len(), width)]).sum();
            }
        });
        let mut texels = vec![0.0; rows.len()];
        texels.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            for (tap, weight) in along_y.iter().enumerate() {
                let from = clamped(y, tap, along_y.len(), height) * width;
                out.iter_mut().zip(&rows[from..from + width]).for_each(|(out, value)| *out += weight * value);
            }
        });
        Self { size: self.size, texels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::texture::linear_from_srgb;

    const SIZE: [u32; 2] = [40, 24];

    fn picture(color: impl Fn(u32, u32) -> [u32; 3]) -> Vec<DVec3> {
        let linear = |code: u32| linear_from_srgb(f64::from(code) / 255.0);
        let places = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
        places.map(|(x, y)| DVec3::from_array(color(x, y).map(linear))).collect()
    }

    /// Structure at all scales, and edges.
    fn first(x: u32, y: u32) -> [u32; 3] {
        let checks = if (x / 5 + y / 4) % 2 == 1 { 255 } else { 20 };
        [(x * 37 + y * 11) % 256, (x * x * 3 + y * 29) % 256, checks]
    }

    fn second(x: u32, y: u32) -> [u32; 3] {
        let [r, g, b] = first(x, y);
        [(r + x % 7 * 6).min(255), if x > 20 { g / 2 } else { g }, if y > 12 { (b + 40) % 256 } else { b }]
    }

    fn mean(errors: &[f64]) -> f64 {
        errors.iter().sum::<f64>() / errors.len() as f64
    }

    /// The authors' own program computes in 32-bit floats.
    const SINGLE_PRECISION: f64 = 2e-4;

    #[test]
    fn errors_are_those_of_the_authors_program() {
        // Printed by `flip_evaluator.evaluate(a, b, "LDR", applyMagma=False, parameters={"ppd": ...})` of the Python
        // package flip-evaluator 1.7, on the same pictures as arrays of code / 255: mean, and pixels by column and row.
        let pixels = [(0, 0), (39, 23), (20, 12), (21, 13), (5, 7), (33, 2)];
        let expected = [
            (PIXELS_PER_DEGREE, 0.640767, [0.058411, 0.663939, 0.514414, 0.697199, 0.205503, 0.873299]),
            (30.0, 0.622530, [0.021619, 0.690220, 0.386894, 0.888093, 0.178854, 0.971169]),
        ];
        for (pixels_per_degree, expected_mean, expected) in expected {
            let errors = flip(&picture(first), &picture(second), SIZE, pixels_per_degree);
            let found = mean(&errors);
            assert!((found - expected_mean).abs() < SINGLE_PRECISION, "mean {found}, not {expected_mean}");
            for ((x, y), expected) in pixels.into_iter().zip(expected) {
                let found = errors[y * SIZE[0] as usize + x];
                assert!((found - expected).abs() < SINGLE_PRECISION, "({x}, {y}): {found}, not {expected}");
            }
        }
    }

    #[test]
    fn plain_colours_differ_as_in_the_authors_program() {
        // As above.
        let expected = [
            ([0, 0, 0], [255, 255, 255], 0.967394),
            ([0, 255, 0], [0, 0, 255], 1.0),
            ([128, 128, 128], [129, 128, 128], 0.024587),
            ([10, 200, 30], [12, 190, 60], 0.381866),
        ];
        for (a, b, expected) in expected {
            let errors = flip(&picture(|_, _| a), &picture(|_, _| b), SIZE, PIXELS_PER_DEGREE);
            let found = mean(&errors);
            assert!((found - expected).abs() < SINGLE_PRECISION, "{a:?}, {b:?}: {found}, not {expected}");
        }
    }

    #[test]
    fn equal_pictures_do_not_differ_and_order_does_not_matter() {
        let (a, b) = (picture(first), picture(second));
        assert!(flip(&a, &a, SIZE, PIXELS_PER_DEGREE).iter().all(|&error| error == 0.0));
        let (there, back) = (flip(&a, &b, SIZE, PIXELS_PER_DEGREE), flip(&b, &a, SIZE, PIXELS_PER_DEGREE));
        assert!(there.iter().zip(&back).all(|(x, y)| (x - y).abs() < 1e-12));
        // A single row, and nothing.
        assert_eq!(flip(&a[..40], &a[..40], [40, 1], PIXELS_PER_DEGREE), vec![0.0; 40]);
        assert_eq!(flip(&[], &[], [0, 0], PIXELS_PER_DEGREE), Vec::<f64>::new());
    }
}

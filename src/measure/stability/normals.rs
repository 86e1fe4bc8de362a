//! Directions in few bits: how far they turn, and what becomes of highlights.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2, TAU};

use glam::{DVec3, Mat4};

use super::{Answer, Bound, Case, Figure, Findings, Lab, Sweep, Worst};
use crate::Result;
use crate::measure::plot::{Axis, Plot};
use crate::picture::{Picture, Pixels};
use crate::plan::{GBuffer, Layout, Normals, Options};
use crate::reference::brdf::{alpha_from_roughness, brdf};
use crate::reference::quantise::normals::half_steps;
use crate::reference::{Attributes, View, quantise};
use crate::scene::{Camera, Projection};

pub const ANGLES: Sweep = Sweep {
    name: "normal-angles",
    title: "Directions after each encoding",
    varies: "direction: spread evenly over the sphere, and at the axes, the octahedron's seams and their neighbourhood down to \
             1e-8",
    about: "Each encoding has places where codes are far apart, and some have places where a small step of the code is a large \
            one of the direction.",
    needs_device: false,
    find: angles,
};

pub const RENORMALISED: Sweep = Sweep {
    name: "normal-length",
    title: "Normals that are not of unit length",
    varies: "direction, evenly over the sphere; a metal of roughness 0.3 seen along the reflected light",
    about: "Rounding changes the length of a normal that is stored by its components. A highlight takes that for an angle.",
    needs_device: false,
    find: renormalised,
};

pub const HIGHLIGHTS: Sweep = Sweep {
    name: "highlights",
    title: "Highlights of rounded normals",
    varies: "perceptual roughness, 1 to 0.045",
    about: "A highlight of width alpha shows steps of the normal as soon as they are no longer much smaller than alpha (Koonce \
            2007, 19.6.2).",
    needs_device: false,
    find: highlights,
};

/// A way of storing a direction.
pub(super) struct Encoding {
    pub name: String,
    /// Of a frame that stores normals so.
    options: Options,
    gbuffer: GBuffer,
    /// What no direction that faces the view plane may be turned by more than, radians.
    pub most: f64,
    /// Where that comes from.
    reason: &'static str,
    /// The same at the picture's corner, where surfaces are seen that face away from the view plane; only of encodings in view
    /// space.
    corner: Option<(f64, &'static str)>,
}

/// Half the diagonal of the square picture of [`view`], radians.
const HALF_DIAGONAL: f64 = 0.6576;

/// What the layouts store, and each choice by itself.
pub(super) fn encodings() -> Result<Vec<Encoding>> {
    let octahedral = |bits| 3.0 / SQRT_2 / half_steps(bits);
    // Half a step along each of two axes.
    let two_axes = |half_step: f64| SQRT_2 * half_step;
    let three_axes = |half_step: f64| 3_f64.sqrt() * half_step;
    let by_axes = "half a step along each of three axes, seen from the origin";
    let by_face = "half a step along each of two axes in the middle of the octahedron's face: sqrt 3 to the face, sqrt 3 to the sphere";
    let by_rim = "half a step along each of two axes where z is 0: sqrt(2 e)";
    let mirrored = (
        2.0 * HALF_DIAGONAL,
        "z is taken to be positive, so what faces away by an angle is turned by twice that",
    );
    let of = |layout: Layout, normals: Option<Normals>, most: f64, reason, corner| {
        let options = Options { layout, normals, ..Options::default() };
        let name = normals.map_or(layout.to_string(), |normals| normals.to_string());
        Ok(Encoding { name, gbuffer: GBuffer::new(&options)?, options, most, reason, corner })
    };
    let choices = Normals::ALL.iter().map(|&normals| {
        let (most, reason, corner) = match normals {
            Normals::Xyz8 => (three_axes(1.0 / 255.0), by_axes, None),
            Normals::Oct8 => (octahedral(8), by_face, None),
            Normals::Oct10 => (octahedral(10), by_face, None),
            Normals::Oct12 => (octahedral(12), by_face, None),
            Normals::Oct16 => (octahedral(16), by_face, None),
            Normals::Sphere12 => {
                // d angle / d radius of Lambert's map is 2 / cos(angle / 2).
                let at = |angle: f64| two_axes(0.5 / half_steps(12)) * 2.0 / (0.5 * angle).cos();
                let reason = "half a step along each of two axes times the map's 2 / cos(angle / 2)";
                (at(FRAC_PI_2), reason, Some((at(FRAC_PI_2 + HALF_DIAGONAL) * 1.01, reason)))
            }
            Normals::View12 => ((2.0 * two_axes(0.5 / half_steps(12))).sqrt(), by_rim, Some(mirrored)),
            Normals::Float => {
                (three_axes((-24_f64).exp2()), "half a step of f32 along each of three axes", None)
            }
        };
        of(Layout::Ontile128, Some(normals), most, reason, corner)
    });
    let layouts = [
        of(Layout::Thibieroz128, None, three_axes(1.0 / 1023.0), by_axes, None),
        of(Layout::Rasa128, None, (2.0 * two_axes(1.0 / 255.0)).sqrt(), by_rim, Some(mirrored)),
        of(Layout::Dissertation192, None, three_axes((-12_f64).exp2()), by_axes, None),
        of(Layout::Metallic256, None, three_axes((-12_f64).exp2()), by_axes, None),
        // Biased to 0 to 1: half steps of 6, 6 and 5 bits of mantissa, doubled.
        of(
            Layout::Specular256,
            None,
            (2.0 * (-7_f64).exp2().powi(2) + (-6_f64).exp2().powi(2)).sqrt(),
            by_axes,
            None,
        ),
        of(Layout::Packed128, None, octahedral(11), by_face, None),
    ];
    choices.chain(layouts).collect()
}

impl Encoding {
    /// A frame that stores normals so.
    pub fn options(&self, options: Options) -> Options {
        Options { layout: self.options.layout, normals: self.options.normals, ..options }
    }

    fn store(&self, view: &View, normal_world: DVec3) -> DVec3 {
        let surface = Attributes { lit: true, depth: 0.5, normal_world, ..Attributes::default() };
        quantise(&self.gbuffer, &surface, view, [0, 0], 1.0).normal_world
    }
}

fn view() -> View {
    let projection = Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None };
    View::new(&Camera { name: String::new(), world_from_view: Mat4::IDENTITY, projection }, [1, 1])
}

/// `count` directions that are spread evenly (Fibonacci's spiral).
fn even(count: usize) -> impl Iterator<Item = DVec3> {
    let golden = PI * (3.0 - 5_f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let (sin, phi) = ((1.0 - z * z).sqrt(), golden * i as f64);
        DVec3::new(sin * phi.cos(), sin * phi.sin(), z)
    })
}

/// The axes, the planes between them (an octahedron's edges), and what is near either.
fn special() -> impl Iterator<Item = DVec3> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let edges = (0..3).flat_map(|k| {
        (0..360).map(move |degree| {
            let angle = f64::from(degree) * TAU / 360.0;
            let mut n = DVec3::ZERO;
            (n[k], n[(k + 1) % 3]) = (angle.cos(), angle.sin());
            n
        })
    });
    axes.chain(edges).flat_map(|n| {
        [0.0, 1e-8, 1e-6, 1e-4, 1e-2].into_iter().flat_map(move |off| {
            [(1.0, 0.3), (-0.7, 1.0), (-0.2, -1.0)]
                .map(|(x, y)| (n + DVec3::new(x, y, x - y) * off).normalize())
        })
    })
}

/// Radians between two directions, accurate for small angles. Not a number if one is zero.
fn angle(a: DVec3, b: DVec3) -> f64 {
    if a == DVec3::ZERO || b == DVec3::ZERO { f64::NAN } else { a.cross(b).length().atan2(a.dot(b)) }
}

/// Beside the highlight of alpha 0.04 (roughness 0.2) this turns a surface by 5 % of its brightness: 1.035 angle / alpha, see
/// [`HIGHLIGHT_SLOPE`].
const GOOD_DEGREES: f64 = 0.11;

fn angles(lab: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let view = view();
    let mut curves = Vec::new();
    for encoding in encodings()? {
        let mut worst = [Worst::new(), Worst::new()];
        let mut by_height = vec![0.0; 90];
        for n in even(lab.pick(20_000, 400_000)).chain(special()) {
            // In view space nobody sees what is further away.
            let away = n.z.clamp(-1.0, 1.0).acos();
            if encoding.corner.is_some() && away > FRAC_PI_2 + HALF_DIAGONAL {
                continue;
            }
            let error = angle(encoding.store(&view, n), n).to_degrees();
            let beyond = encoding.corner.is_some() && n.z < 0.0;
            worst[usize::from(beyond)].add(error, || n);
            let bin = &mut by_height[((away / PI * 90.0) as usize).min(89)];
            *bin = f64::max(*bin, error);
        }
        let facing = (encoding.name.clone(), encoding.most, encoding.reason);
        let corner =
            encoding.corner.map(|(most, reason)| (format!("{}, at the corner", encoding.name), most, reason));
        for ((method, most, reason), worst) in [Some(facing), corner].into_iter().flatten().zip(worst) {
            let at = worst.at.unwrap_or_default();
            findings.cases.push(Case {
                method,
                worst: worst.error,
                at: format!("n = ({:.4}, {:.4}, {:.4})", at.x, at.y, at.z),
                bound: Bound {
                    name: "TURNED",
                    unit: "degrees",
                    good: GOOD_DEGREES.min(most.to_degrees()),
                    most: most.to_degrees() * 1.005,
                    reason,
                },
                answer: None,
                remedy: if most > 0.5 {
                    "floors and walls at the picture's edge are lit from behind: take --normals oct12".into()
                } else {
                    String::new()
                },
            });
        }
        let points = by_height.iter().enumerate().map(|(i, error)| [2.0 * i as f64 + 1.0, *error]);
        curves.push((encoding.name, points.collect()));
    }
    findings.figures.push(Figure::plot(
        "degrees",
        "The largest error on each circle around +z.",
        Plot {
            title: "How far a stored direction is turned".into(),
            x_label: "degrees from +z (of view space for encodings that use it)".into(),
            y_label: "degrees".into(),
            axes: [Axis::Linear, Axis::Logarithmic],
            curves,
            levels: Vec::new(),
        },
    ));
    Ok(findings)
}

/// A white metal.
fn metal(roughness: f64) -> Attributes {
    Attributes { lit: true, roughness, base_color: DVec3::ONE, metallic: 1.0, ..Attributes::default() }
}

fn renormalised(lab: &Lab<'_>) -> Result<Findings> {
    type Read = fn(DVec3) -> DVec3;
    let surface = metal(0.3);
    let shorten = |n: DVec3| {
        let round = |x: f64| ((x * 0.5 + 0.5) * 255.0).round() / 255.0 * 2.0 - 1.0;
        DVec3::new(round(n.x), round(n.y), round(n.z))
    };
    // As stored in 8 bits, the length as it comes; and brought to unit length.
    let methods: [(&str, Read); 2] =
        [("xyz, 8 bits, as read", |n| n), ("xyz, 8 bits, renormalised", |n| n.normalize())];
    let mut findings = Findings::default();
    // 1.035 / alpha per radian; the length's error is as large as the angle's.
    let most = HIGHLIGHT_SLOPE * 3_f64.sqrt() / 255.0 / alpha_from_roughness(surface.roughness);
    for (i, (name, read)) in methods.into_iter().enumerate() {
        let mut worst = Worst::new();
        for n in even(lab.pick(5_000, 100_000)) {
            // The formula as shaders have it from unit vectors: 1 - (n·h)², which a wrong length breaks.
            let alpha2 = alpha_from_roughness(surface.roughness).powi(2);
            let lobe = |n_dot_h: f64| (alpha2 / (n_dot_h * n_dot_h * (alpha2 - 1.0) + 1.0)).powi(2);
            let error = (lobe(read(shorten(n)).dot(n)) - 1.0).abs();
            worst.add(100.0 * error, || n);
        }
        let at = worst.at.unwrap_or_default();
        findings.cases.push(Case {
            method: name.into(),
            worst: worst.error,
            at: format!("n = ({:.3}, {:.3}, {:.3})", at.x, at.y, at.z),
            bound: Bound {
                name: "HIGHLIGHT_OF_LENGTH",
                unit: "% of the peak",
                good: 1.0,
                most: 100.0 * most,
                reason: "what half a step turns the normal by, times the steepest slope of the lobe",
            },
            answer: (i == 0).then_some(Answer::Mended),
            remedy: if i == 0 {
                "normals are brought to unit length when they are read".into()
            } else {
                String::new()
            },
        });
    }
    Ok(findings)
}

/// GGX relative to its peak is (1 + x²)^-2 of x = angle / alpha, whose steepest slope, at x² = 1/5, is 4 x (1 + x²)^-3 =
/// 1.035. The visibility and Fresnel terms change little over a lobe.
const HIGHLIGHT_SLOPE: f64 = 1.035;
/// Where methods are compared: polished stone, brushed metal.
const COMPARED_ROUGHNESS: f64 = 0.3;

/// Brightness relative to the peak's on a ball at `n`, light and viewer in the direction +z.
fn lobe(roughness: f64, n: DVec3) -> f64 {
    let surface = metal(roughness);
    let [at, peak] = [n, DVec3::Z].map(|n| brdf(&surface, n, DVec3::Z, DVec3::Z).x * n.z.max(0.0));
    at / peak
}

fn highlights(lab: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let view = view();
    let mut curves = Vec::new();
    // Away from the axes, where 8 bits are at their best.
    let towards = DVec3::new(0.48, 0.31, 0.82).normalize();
    let side = towards.any_orthonormal_vector();
    let up = towards.cross(side);
    let roughnesses = [1.0, 0.7, 0.5, 0.4, COMPARED_ROUGHNESS, 0.2, 0.15, 0.1, 0.07, 0.045];
    let error_at = |encoding: &Encoding, roughness: f64| {
        let alpha = alpha_from_roughness(roughness);
        let surface = metal(roughness);
        let shade = |n: DVec3| brdf(&surface, n, towards, towards).x * n.dot(towards).max(0.0);
        let peak = shade(towards);
        let mut worst = Worst::new();
        let side_count = lab.pick(40, 300);
        for i in 0..side_count * side_count {
            // Over the lobe, three alphas either way.
            let place = |k: usize| (k as f64 / (side_count - 1) as f64 * 2.0 - 1.0) * 3.0 * alpha;
            let n = (towards + side * place(i % side_count) + up * place(i / side_count)).normalize();
            let error = (shade(encoding.store(&view, n)) - shade(n)).abs() / peak;
            worst.add(100.0 * error, || angle(n, towards).to_degrees());
        }
        worst
    };
    for encoding in encodings()? {
        let mut curve = Vec::new();
        for roughness in roughnesses {
            let worst = error_at(&encoding, roughness);
            curve.push([roughness, worst.error]);
            if roughness == COMPARED_ROUGHNESS {
                let alpha = alpha_from_roughness(roughness);
                findings.cases.push(Case {
                    method: encoding.name.clone(),
                    worst: worst.error,
                    at: format!("roughness {roughness}, {:.2} degrees off the peak", worst.at.unwrap_or_default()),
                    bound: Bound {
                        name: "LOBE_SLOPE",
                        unit: "% of the peak",
                        good: f64::min(1.0, 100.0 * HIGHLIGHT_SLOPE * encoding.most / alpha),
                        most: (100.0 * HIGHLIGHT_SLOPE * encoding.most / alpha * 1.1).min(100.0),
                        reason: "the encoding's largest angle times the steepest slope of the lobe, 1.035 / alpha; 1 % is a step \
                                 that is just seen",
                    },
                    answer: None,
                    remedy: if encoding.most.to_degrees() > GOOD_DEGREES {
                        "on smoother materials take --normals oct12, or keep roughness above 0.5".into()
                    } else {
                        String::new()
                    },
                });
            }
        }
        curve.reverse();
        curves.push((encoding.name, curve));
    }
    findings.figures.push(Figure::plot(
        "percent",
        "The largest error over a highlight, by roughness.",
        Plot {
            title: "Error of a highlight whose normals are stored".into(),
            x_label: "perceptual roughness".into(),
            y_label: "% of the highlight's peak".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("just seen".into(), 1.0)],
        },
    ));
    findings.figures.push(Figure::picture(
        "balls",
        format!(
            "A part of a metal ball under a light, roughness {COMPARED_ROUGHNESS}: with the true normals, then stored as {}.",
            pictured()?.iter().map(|e| e.name.clone()).collect::<Vec<_>>().join("; ")
        ),
        balls(&view, towards)?,
    ));
    Ok(findings)
}

/// Those that a picture has room for.
fn pictured() -> Result<Vec<Encoding>> {
    let mut encodings = encodings()?;
    encodings.retain(|e| ["xyz8", "oct8", "oct12", "rasa128", "specular256"].contains(&e.name.as_str()));
    Ok(encodings)
}

/// The highlight on a gently curved surface, side by side.
fn balls(view: &View, towards: DVec3) -> Result<Picture> {
    const SIDE: usize = 160;
    let encodings = pictured()?;
    let side = towards.any_orthonormal_vector();
    let up = towards.cross(side);
    let width = SIDE * (encodings.len() + 1);
    let mut pixels = Vec::with_capacity(width * SIDE * 4);
    for i in 0..width * SIDE {
        let (x, y) = (i % width, i / width);
        let place = |k: usize| (k as f64 / SIDE as f64 - 0.5) * 0.5;
        let n = (towards + side * place(x % SIDE) + up * place(y)).normalize();
        let n = match (x / SIDE).checked_sub(1) {
            Some(k) => encodings[k].store(view, n),
            None => n,
        };
        // Turned to where the formula has its light.
        let light = lobe(COMPARED_ROUGHNESS, DVec3::new(n.dot(side), n.dot(up), n.dot(towards))) as f32;
        pixels.extend([light, light, light, 1.0]);
    }
    Ok(Picture { width: width as u32, height: SIDE as u32, pixels: Pixels::Rgba32F(pixels) })
}

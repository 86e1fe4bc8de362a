//! Where shading formulas have poles: smooth surfaces, grazing light, lights that touch what they light.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec3, Mat4, Vec3};

use super::bench::{FLOOR, exact, light_of, side_by_side};
use super::normals::encodings;
use super::parts::{add, bulb, camera, floor, plain, sphere, square, sun};
use super::{Answer, Bound, Case, Figure, Findings, Lab, Sweep, Worst, difference};
use crate::Result;
use crate::measure::canvas::short;
use crate::measure::plot::{Axis, Plot};
use crate::plan::{Options, Path};
use crate::reference::Attributes;
use crate::reference::brdf::{MIN_ROUGHNESS, alpha_from_roughness, brdf};
use crate::reference::punctual::MIN_DISTANCE_M;
use crate::scene::{Camera, Projection, Scene};

pub const ROUGHNESS: Sweep = Sweep {
    name: "roughness",
    title: "Roughness to 0",
    varies: "perceptual roughness of a metal and a plastic ball, 1 to 0",
    about: "The peak of a highlight is 1 / (pi alpha²), which is infinite for a mirror, and its width gets smaller than what a \
            float's normal can tell.",
    needs_device: true,
    find: roughness,
};

pub const GRAZING: Sweep = Sweep {
    name: "grazing",
    title: "Grazing angles",
    varies: "angle of the view and of the light from the normal of a plane, 0 to 89.99 degrees",
    about: "Visibility terms divide by the cosines; rounded normals turn them negative.",
    needs_device: true,
    find: grazing,
};

pub const DISTANCE: Sweep = Sweep {
    name: "light-distance",
    title: "Lights that touch surfaces and lights far away",
    varies: "height of a point light above a floor, 0 and 1e-4 to 1e6 m, of an intensity that grows with its square",
    about: "Light falls with the square of a distance that the deferred stage takes from a position, and that from depth: where \
            the distance is no larger than the position's error, light is anything.",
    needs_device: true,
    find: distance,
};

/// The ways that shading is reached; both have all of their values in floats.
const PATHS: [Path; 2] = [Path::Deferred, Path::Forward];

/// What the whole renderer promises for 99.9 % of pixels, here for all.
const ARITHMETIC: Bound = Bound {
    name: "ARITHMETIC",
    unit: "of the light",
    good: 1e-3,
    most: 4e-3,
    reason: "a thousandth is what the renderer promises for 99.9 % of all pixels; the rest are where a step of f32 in the normal \
             is a large part of the highlight's width",
};

fn balls(roughness: f32) -> Scene {
    let mut scene = Scene::default();
    scene.cameras.push(camera(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO));
    for (x, metallic, color) in [(-1.1, 1.0, Vec3::new(1.0, 0.8, 0.4)), (1.1, 0.0, Vec3::new(0.2, 0.4, 0.8))]
    {
        add(
            &mut scene,
            sphere(),
            plain(color, metallic, roughness),
            Mat4::from_translation(Vec3::new(x, 0.0, 0.0)),
        );
    }
    scene.lights.push(sun(1.0, Vec3::new(-0.4, -0.5, -1.0)));
    scene
}

fn roughness(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let mut findings = Findings::default();
    let all = [1.0, 0.7, 0.5, 0.3, 0.2, 0.14, 0.1, 0.07, 0.045, 0.02, 0.01, 1e-3, 0.0];
    let few = [1.0, 0.3, 0.1, 0.045, 0.0];
    let roughnesses = lab.pick(&few[..], &all[..]);
    let size = lab.pick([96, 54], [320, 180]);
    let mut curves = Vec::new();
    for path in PATHS {
        let options = Options { path, ..exact(size) };
        let mut worst = Worst::new();
        let mut curve = Vec::new();
        for &roughness in roughnesses {
            let scene = balls(roughness);
            let (picture, truth) =
                (bench.picture(&scene, options.clone(), 0.0)?, bench.truth(&scene, &options, 0.0));
            let found = difference(&truth, &picture, FLOOR)?;
            curve.push([f64::from(roughness).max(1e-4), found.worst]);
            worst.add(found.worst, || (roughness, found, truth, picture));
        }
        curve.reverse();
        curves.push((path.to_string(), curve));
        let Some((roughness, found, truth, picture)) = worst.at else { continue };
        findings.cases.push(Case {
            method: format!("roughness floor {MIN_ROUGHNESS}, {path}"),
            worst: worst.error,
            at: format!("roughness {roughness}, {}", found.place()),
            bound: ARITHMETIC,
            answer: None,
            remedy: String::new(),
        });
        if path == Path::Deferred {
            let full = worst.error.max(1e-9);
            findings.figures.push(Figure::picture(
                "worst",
                format!("Drawn, true, and the difference (white: {}) at roughness {roughness}.", short(full)),
                side_by_side(&truth.frame, &picture, FLOOR, full)?,
            ));
        }
    }
    findings.cases.push(no_floor());
    findings.cases.push(stored_roughness());
    findings.figures.push(Figure::plot(
        "error",
        "The GPU against f64; roughness 0 is drawn at 1e-4.",
        Plot {
            title: "Relative error of the worst pixel".into(),
            x_label: "perceptual roughness".into(),
            y_label: "relative error of light".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("holds up to".into(), ARITHMETIC.good)],
        },
    ));
    Ok(findings)
}

/// The lobe in f32 as written in papers, 1 - (n·h)² included, down to alpha = 0.
fn no_floor() -> Case {
    let lobe = |n_dot_h: f32, alpha: f32| {
        let alpha2 = alpha * alpha;
        let f = n_dot_h * n_dot_h * (alpha2 - 1.0) + 1.0;
        alpha2 / (std::f32::consts::PI * f * f)
    };
    let mut worst = Worst::new();
    for roughness in [1.0, 0.3, 0.1, 0.045, 0.03, 0.02, 0.01, 0.0] {
        let alpha = roughness * roughness;
        // The mirror direction itself, where all its light is.
        let peak = 1.0 / (std::f64::consts::PI * f64::from(alpha).powi(2));
        let error = (f64::from(lobe(1.0, alpha)) / peak - 1.0).abs();
        worst.add(error, || roughness);
    }
    Case {
        method: "no floor, 1 - (n·h)² in f32".into(),
        worst: worst.error,
        at: format!("roughness {}", worst.at.unwrap_or_default()),
        bound: ARITHMETIC,
        answer: Some(Answer::Guarded),
        remedy: format!(
            "roughness is held to at least {MIN_ROUGHNESS}, where a unit light's highlight is within half floats, and |n × h|² stands \
             for 1 - (n·h)²"
        ),
    }
}

/// What 8 bits of roughness do to the peak: 1 / alpha² = 1 / roughness⁴.
fn stored_roughness() -> Case {
    let mut worst = Worst::new();
    for i in 0..=10_000 {
        let roughness = MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * f64::from(i) / 1e4;
        let stored = (roughness * 255.0).round() / 255.0;
        let ratio = (alpha_from_roughness(roughness) / alpha_from_roughness(stored)).powi(2);
        worst.add((ratio - 1.0).abs(), || roughness);
    }
    Case {
        method: "roughness in 8 bits".into(),
        worst: worst.error,
        at: format!("roughness {:.4}", worst.at.unwrap_or_default()),
        bound: Bound {
            name: "PEAK_OF_ROUGHNESS",
            unit: "of the peak",
            good: 0.05,
            // (1 - x)^-4 - 1 of half a step x.
            most: (1.0 - 0.5 / 255.0 / MIN_ROUGHNESS).powi(-4) - 1.0,
            reason: "the peak goes with the fourth power of roughness, and half a step of 8 bits is 4.4 % of the floor",
        },
        answer: None,
        remedy: "the highlight's total light stays; only how bright its middle is depends on it. Smooth textures should keep away \
                 from the lowest codes"
            .into(),
    }
}

/// Base colour and roughness of [`plane`].
const PLANE: (f64, f64) = (0.8, 0.4);

/// A plane that fills the picture, seen at one angle and lit at another, both in the plane of x.
fn plane(view_degrees: f32, light_degrees: f32) -> Scene {
    let mut scene = Scene::default();
    let towards = |degrees: f32| {
        let angle = degrees.to_radians();
        Vec3::new(angle.sin(), 0.0, angle.cos())
    };
    let eye = towards(view_degrees);
    // The plane is wide enough to fill the picture however slanted it is seen.
    let projection = Projection::Orthographic { xmag_m: 0.5, ymag_m: 0.5, znear_m: 0.1, zfar_m: 1e5 };
    let at = camera(eye * 1e4, Vec3::ZERO).world_from_view;
    scene.cameras.push(Camera { name: "slanted".into(), world_from_view: at, projection });
    let (color, roughness) = (PLANE.0 as f32, PLANE.1 as f32);
    add(&mut scene, square(), plain(Vec3::splat(color), 0.0, roughness), Mat4::from_scale(Vec3::splat(4e4)));
    scene.lights.push(sun(1.0, -Vec3::new(-towards(light_degrees).x, 0.0, towards(light_degrees).z)));
    scene
}

fn grazing(lab: &Lab<'_>) -> Result<Findings> {
    let all = [0.0, 30.0, 60.0, 75.0, 85.0, 88.0, 89.0, 89.5, 89.9, 89.95, 89.99];
    let few = [0.0, 60.0, 89.0, 89.9, 89.99];
    let degrees = lab.pick(&few[..], &all[..]);
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    let paths = PATHS.map(|path| (format!("exact, {path}"), Options { path, ..exact([8, 8]) }, 0.0));
    let encodings = encodings()?.into_iter();
    let encodings = encodings.map(|e| (e.name.clone(), Options { ..e.options(exact([8, 8])) }, e.most));
    // Renderers are made anew for each picture: half of the angles for encodings.
    let some = lab.pick(&[0.0, 89.0, 89.99][..], &[0.0, 60.0, 85.0, 89.0, 89.9, 89.99][..]);
    for (method, options, turned) in paths.into_iter().chain(encodings) {
        let degrees = if turned == 0.0 { degrees } else { some };
        let mut worst = Worst::new();
        let mut curve: Vec<[f64; 2]> = Vec::new();
        for &view in degrees {
            let mut at_view = 0.0;
            for &light in degrees {
                let scene = plane(view, light);
                let picture = lab.bench()?.picture(&scene, options.clone(), 0.0)?;
                let truth = lab.bench()?.truth(&scene, &options, 0.0);
                let arithmetic = ARITHMETIC.most;
                let (error, allowed) = if turned == 0.0 {
                    (difference(&truth, &picture, FLOOR)?.worst, arithmetic)
                } else {
                    let facing = reflected(0.0, 0.0, DVec3::Z);
                    let light_of_pixel = light_of(&picture)?[0].x;
                    (
                        (light_of_pixel - truth.frame.pixels[0].display.x).abs() / facing,
                        grazed(view, light, turned),
                    )
                };
                at_view = f64::max(at_view, error);
                worst.add(error / allowed, || (view, light, error, allowed));
            }
            curve.push([90.0 - f64::from(view), at_view]);
        }
        curve.reverse();
        curves.push((method.clone(), curve));
        let Some((view, light, error, allowed)) = worst.at else { continue };
        let turned_bound = Bound {
            name: "GRAZED",
            unit: "of facing light",
            good: 0.01,
            most: allowed,
            reason: "what a normal that is turned by the encoding's largest angle, any way, changes here by f64, and a twentieth \
                     for the other channels; of the light of the same surface when viewer and light face it",
        };
        findings.cases.push(Case {
            method,
            worst: error,
            at: format!("view at {view}, light at {light} degrees"),
            bound: if turned == 0.0 { ARITHMETIC } else { turned_bound },
            answer: None,
            remedy: if turned > 1e-3 {
                "where light grazes smooth floors take more bits of normal".into()
            } else {
                String::new()
            },
        });
    }
    findings.figures.push(Figure::plot(
        "error",
        "The worst of all angles of light, by the angle that is left between view and plane.",
        Plot {
            title: "Error at grazing angles".into(),
            x_label: "degrees between view and plane".into(),
            y_label: "error (exact: of the pixel's light; others: of facing light)".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("arithmetic holds up to".into(), ARITHMETIC.good)],
        },
    ));
    Ok(findings)
}

/// What the plane of [`plane`] reflects, in f64, if its normal is `n`.
fn reflected(view_degrees: f64, light_degrees: f64, n: DVec3) -> f64 {
    let way = |degrees: f64| DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
    let (v, l) = (way(view_degrees), way(light_degrees) * DVec3::new(-1.0, 1.0, 1.0));
    let surface = Attributes {
        lit: true,
        base_color: DVec3::splat(PLANE.0),
        roughness: PLANE.1,
        ..Attributes::default()
    };
    brdf(&surface, n, v, l).x * n.dot(l).max(0.0)
}

/// How much of facing light a normal that is turned by so much changes at most.
fn grazed(view_degrees: f32, light_degrees: f32, turned: f64) -> f64 {
    let (view, light) = (f64::from(view_degrees), f64::from(light_degrees));
    let truth = reflected(view, light, DVec3::Z);
    let mut most = 0.0;
    for i in 0..128 {
        for part in 1..=32 {
            let part = f64::from(part) / 32.0;
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 128.0).sin_cos();
            let n = DVec3::new(cos * turned * part, sin * turned * part, 1.0).normalize();
            most = f64::max(most, (reflected(view, light, n) - truth).abs());
        }
    }
    (1.05 * most + 0.05 * truth) / reflected(0.0, 0.0, DVec3::Z) + 0.01
}

/// A lamp over a floor of which a camera sees what lies below it.
fn lamp(height_m: f32) -> Scene {
    let mut scene = Scene::default();
    // The picture is as wide as the light's spot, but no nearer than a camera comes.
    let reach = height_m.clamp(0.05, 1e6);
    scene.cameras.push(camera(Vec3::new(0.0, 3.0 * reach, 0.01 * reach), Vec3::ZERO));
    add(&mut scene, square(), plain(Vec3::splat(0.8), 0.0, 0.6), floor(4.0 * reach));
    scene.lights.push(bulb(height_m * height_m, Vec3::new(0.0, height_m, 0.0), None));
    scene
}

fn distance(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let all = [1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6];
    let few = [1e-4, 1e-2, 1.0, 1e6];
    let heights = lab.pick(&few[..], &all[..]);
    let size = lab.pick([33, 33], [129, 129]);
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for path in PATHS {
        let options = Options { path, ..exact(size) };
        let mut worst = Worst::new();
        let mut curve = Vec::new();
        for &height in heights {
            let scene = lamp(height);
            let (picture, truth) =
                (bench.picture(&scene, options.clone(), 0.0)?, bench.truth(&scene, &options, 0.0));
            let brightest = truth.frame.pixels.iter().map(|p| p.display.max_element()).fold(0.0, f64::max);
            // Of the brightest light of the spot: beside it errors are of little light.
            let floor = (0.01 * brightest).max(FLOOR);
            let found = difference(&truth, &picture, floor)?;
            curve.push([f64::from(height), found.worst]);
            worst.add(found.worst / allowed(height), || (height, found, truth, picture, floor));
        }
        curves.push((path.to_string(), curve));
        let Some((height, found, truth, picture, floor)) = worst.at else { continue };
        findings.cases.push(Case {
            method: format!("exact, {path}"),
            worst: found.worst,
            at: format!("{height} m, {}", found.place()),
            bound: Bound {
                name: "NEAR_LIGHT",
                unit: "of the light",
                good: ARITHMETIC.good,
                most: allowed(height),
                reason: "light goes with the square of the distance, and positions a few decimetres from the camera are right to some \
                         1e-7 m: twice that over the light's height, and a thousandth besides",
            },
            answer: None,
            remedy: "lights belong a centimetre off a surface; nearer ones light a spot that is smaller than a pixel".into(),
        });
        if path == Path::Deferred {
            let full = found.worst.max(1e-9);
            findings.figures.push(Figure::picture(
                "worst",
                format!(
                    "Drawn, true, and the difference (white: {}) of a lamp {height} m above the floor.",
                    short(full)
                ),
                side_by_side(&truth.frame, &picture, floor, full)?,
            ));
        }
    }
    findings.cases.push(on_the_surface(lab, size)?);
    findings.figures.push(Figure::plot(
        "error",
        "The GPU against f64, by the lamp's height.",
        Plot {
            title: "Relative error of the worst pixel under a lamp".into(),
            x_label: "height, m".into(),
            y_label: "relative error of light".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("arithmetic holds up to".into(), ARITHMETIC.good)],
        },
    ));
    Ok(findings)
}

/// A lamp of 1 cd in the plane of the floor, which it does not light: n·l is 0, and what is seen is noise.
fn on_the_surface(lab: &Lab<'_>, size: [u32; 2]) -> Result<Case> {
    /// The light that the lamp would give 1 cm above a white floor, cd/m².
    const AT_1_CM: f64 = 1e4 * FRAC_1_PI;
    let mut scene = lamp(0.0);
    scene.lights = vec![bulb(1.0, Vec3::ZERO, None)];
    let options = exact(size);
    let picture = lab.bench()?.picture(&scene, options.clone(), 0.0)?;
    let found = difference(&lab.bench()?.truth(&scene, &options, 0.0), &picture, AT_1_CM)?;
    Ok(Case {
        method: "lamp on the surface".into(),
        worst: found.worst,
        at: format!("0 m, {}", found.place()),
        bound: Bound {
            name: "IN_THE_PLANE",
            unit: "of light at 1 cm",
            good: 1e-3,
            most: POSITION_M / MIN_DISTANCE_M.powi(3) / AT_1_CM * FRAC_1_PI,
            reason: "n·l is a position's error over the distance, and light goes with its square: positions are right to 1e-7 m, and \
                     distances are held to 0.1 mm",
        },
        answer: None,
        remedy: "lights belong a centimetre off a surface: the spot of noise is some pixels wide".into(),
    })
}

/// The error of a position 0.15 m from the camera: two steps of f32 in depth, ray and matrix each.
const POSITION_M: f64 = 1e-7;

/// The error that positions of f32 explain for a light at this height.
fn allowed(height_m: f32) -> f64 {
    ARITHMETIC.good + 2.0 * POSITION_M / f64::from(height_m).max(MIN_DISTANCE_M) * 4.0
}

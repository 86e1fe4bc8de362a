//! Particles that add light, at their limits and against a ball of gas.

use glam::{Mat4, Vec3};

use super::bench::{FLOOR, side_by_side};
use super::parts::{add, camera, floor, plain, sphere, square, sun};
use super::{Bound, Case, Figure, Findings, Lab, Sweep, Worst, difference, exact};
use crate::Result;
use crate::measure::canvas::short;
use crate::measure::plot::{Axis, Plot};
use crate::scene::{Material, Particle, Particles, Projection, Scene};

pub const PARTICLES: Sweep = Sweep {
    name: "particles",
    title: "Particles that surfaces cut, close to the camera, far away, tiny, huge and bright",
    varies: "the soft distance from 0 to 1 km, the distance from the near plane's to 10 km, sides from 0.1 mm to 1 km, light from a \
             millionth to a million times white, and how far in front of a surface a particle is, of its radius",
    about: "A particle is a flat square that is dimmed by how close behind it something is, in place of the gas that it stands for: of \
            that a surface leaves what is in front of it. The fade hides the line of the cut; it takes light away that gas would send. \
            Differences of depths of far surfaces have few bits.",
    needs_device: true,
    find: particles,
};

/// The series beyond what f32 holds.
const TELESCOPE: &str = "through a telescope";

const AT: Vec3 = Vec3::new(0.0, 0.5, 0.0);

/// A ball on a floor.
fn ground() -> Scene {
    let mut scene = Scene { lights: vec![sun(0.5, Vec3::new(-0.3, -1.0, -0.5))], ..Scene::default() };
    scene.cameras.push(camera(Vec3::new(0.0, 1.2, 4.0), AT));
    add(&mut scene, square(), plain(Vec3::splat(0.5), 0.0, 0.9), floor(40.0));
    let place = Mat4::from_translation(Vec3::new(0.4, 0.4, -0.3)) * Mat4::from_scale(Vec3::splat(0.4));
    add(&mut scene, sphere(), plain(Vec3::new(0.2, 0.4, 0.8), 0.0, 0.9), place);
    scene
}

fn with(mut scene: Scene, soft_m: f32, list: Vec<Particle>) -> Scene {
    let emissive_factor = Vec3::new(0.9, 0.5, 0.2);
    scene.materials.push(Material { emissive_factor, ..Material::default() });
    scene.particles = vec![Particles::new(scene.materials.len() - 1, soft_m, list)];
    scene
}

fn spark(position_world: Vec3, size_m: f32) -> Particle {
    Particle { position_world, size_m, rotation_rad: 0.3, color: Vec3::ONE }
}

/// Scenes of a kind, with what was varied.
type Series = (&'static str, Vec<(String, Scene)>);

fn series(all: bool) -> Vec<Series> {
    let numbers = |few: &[f32], more: &[f32]| -> Vec<f32> {
        few.iter().chain(more.iter().filter(|_| all)).copied().collect()
    };
    let soft = numbers(&[0.0, 0.3, 1e3], &[1e-5, 1e-4, 1e-3, 0.03, 3.0, 100.0]);
    let soft =
        soft.into_iter().map(|m| (format!("soft over {m} m"), with(ground(), m, vec![spark(AT, 1.2)])));
    let eye = ground().cameras[0].world_from_view;
    let ahead = |m: f32| eye.transform_point3(Vec3::NEG_Z * m);
    let near = numbers(&[0.1001, 0.11, 0.3], &[0.100001, 0.15, 0.2]).into_iter();
    let near =
        near.map(|m| (format!("{m} m before the camera"), with(ground(), 0.2, vec![spark(ahead(m), 0.1)])));
    let away = |m: f32| {
        let mut scene = ground();
        scene.cameras[0] = camera(Vec3::new(0.0, 0.3 * m, m), AT);
        scene.cameras[0].projection =
            Projection::Perspective { yfov_rad: 4.0 / m, znear_m: 0.1, zfar_m: None };
        (format!("{m} m away"), with(scene, 0.3, vec![spark(AT, 1.2)]))
    };
    let far = numbers(&[100.0], &[30.0, 1e3]).into_iter().map(away);
    let farther = numbers(&[1e4], &[3e3]).into_iter().map(away);
    let sizes = numbers(&[1e-4, 1e3], &[0.0, 1e-2, 30.0]).into_iter();
    let sizes = sizes.map(|m| (format!("a side of {m} m"), with(ground(), 0.3, vec![spark(AT, m)])));
    let bright = numbers(&[1e-6, 1e6], &[1e-3, 1e3]).into_iter().map(|times| {
        let spark = Particle { color: Vec3::splat(times), ..spark(AT, 1.2) };
        (format!("{times} times white"), with(ground(), 0.3, vec![spark]))
    });
    let counts: &[usize] = if all { &[1, 64, 4096] } else { &[256] };
    let many = counts.iter().map(|&count| {
        let list = (0..count).map(|i| spark(AT + Vec3::new(0.0, 0.0, 1e-4 * i as f32), 1.2)).collect();
        (format!("{count} of them"), with(ground(), 0.3, list))
    });
    vec![
        ("soft distance", soft.collect()),
        ("close to the camera", near.collect()),
        ("far away", far.collect()),
        (TELESCOPE, farther.collect()),
        ("size", sizes.collect()),
        ("brightness", bright.collect()),
        ("over each other", many.collect()),
    ]
}

fn particles(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let options = exact(lab.pick([48, 32], [160, 96]));
    let mut findings = Findings::default();
    let mut pictured = -1.0;
    for (name, scenes) in series(lab.pick(false, true)) {
        let mut worst = Worst::new();
        for (varied, scene) in &scenes {
            let (truth, picture) =
                (bench.truth(scene, &options, 0.0), bench.picture(scene, options.clone(), 0.0)?);
            let found = difference(&truth, &picture, FLOOR)?;
            worst.add(found.worst, || format!("{varied}, {}", found.place()));
            if found.worst > pictured {
                pictured = found.worst;
                let caption =
                    format!("{name}, {varied}: drawn, true, and the difference (white: {})", short(pictured));
                let picture = side_by_side(&truth.frame, &picture, FLOOR, pictured.clamp(1e-9, 1e9))?;
                findings.figures = vec![Figure::picture("worst", caption, picture)];
            }
        }
        findings.cases.push(Case {
            method: format!("drawn, {name}"),
            worst: worst.error,
            at: worst.at.unwrap_or_default(),
            bound: if name == TELESCOPE { BY_TELESCOPE } else { LIGHT_OF_SQUARES },
            answer: None,
            remedy: match name == TELESCOPE {
                true => "the world's origin near to what is seen".into(),
                false => "a longer soft distance, or a near plane farther away".into(),
            },
        });
    }
    against_gas(&mut findings);
    Ok(findings)
}

const LIGHT_OF_SQUARES: Bound = Bound {
    name: "LIGHT_OF_SQUARES",
    unit: "of the light",
    good: 2e-3,
    most: 0.02,
    reason: "f32 between depths and fades: where a surface is far behind the near plane, its depth has few bits",
};

const BY_TELESCOPE: Bound = Bound {
    name: "BY_TELESCOPE",
    unit: "of the light",
    good: 2e-3,
    most: 0.25,
    reason: "kilometres from the camera f32 places vertices to millimetres, of which a lens of 0.02 degrees makes a tenth of a pixel: at a \
             silhouette as much of the fade",
};

/// Soft distances, as shares of the ball's radius.
const SOFT_RADII: [f32; 4] = [0.0, 0.5, 1.0, 2.0];

/// Along a ray through the middle of a ball of gas of radius 1 m that a surface cuts `before_m` behind the middle: the share of its
/// light that is in front.
fn of_gas(before_m: f64) -> f64 {
    ((before_m + 1.0) * 0.5).clamp(0.0, 1.0)
}

fn against_gas(findings: &mut Findings) {
    const STEP_M: f64 = 0.01;
    let places = || (-150..=250).map(|i| f64::from(i) * STEP_M);
    let mut curves = vec![("a ball of gas".to_owned(), places().map(|m| [m, of_gas(m)]).collect::<Vec<_>>())];
    for radii in SOFT_RADII {
        let particles = Particles::new(0, radii, Vec::new());
        // What is behind the surface is not drawn.
        let seen = |before_m: f64| if before_m > 0.0 { particles.fade(before_m) } else { 0.0 };
        let (mut off, mut line) = (Worst::new(), Worst::new());
        for m in places() {
            off.add((seen(m) - of_gas(m)).abs(), || format!("{m:.2} radii before a surface"));
            line.add((seen(m + STEP_M) - seen(m)).abs(), || format!("{m:.2} radii before a surface"));
        }
        let case = |what: &str, worst: Worst<String>, bound| Case {
            method: format!("soft over {radii} radii, {what}"),
            worst: worst.error,
            at: worst.at.unwrap_or_default(),
            bound,
            answer: None,
            remedy: "soft over one radius: no line, and hardly more light is lost than without".into(),
        };
        findings.cases.push(case(
            "against gas",
            off,
            Bound {
                name: "NO_VOLUME",
                unit: "of its light",
                good: 0.05,
                most: 1.0,
                reason: "a square before the middle shows nothing where half of the gas is in front of a surface, and a fade longer than the \
                         radius takes more",
            },
        ));
        findings.cases.push(case(
            "over a hundredth of the radius",
            line,
            Bound {
                name: "NO_LINE",
                unit: "of its light",
                good: 0.05,
                most: 1.0,
                reason: "gas changes by 0.005; of squares without a fade all light ends at once, in a line that is seen",
            },
        ));
        curves.push((format!("soft over {radii} radii"), places().map(|m| [m, seen(m)]).collect()));
    }
    let plot = Plot {
        title: "A surface through a particle".into(),
        x_label: "the surface behind the middle, radii".into(),
        y_label: "share of the light that is seen".into(),
        axes: [Axis::Linear; 2],
        curves,
        levels: Vec::new(),
    };
    findings.figures.push(Figure::plot(
        "gas",
        "What a surface leaves of a particle, and of a ball of gas.",
        plot,
    ));
}

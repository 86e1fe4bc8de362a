//! What is blended over each other, by every way, where orders are hard to find.

use glam::{Mat4, Vec3};

use super::bench::light_of;
use super::parts::{add, camera, plain, square, sun};
use super::{Bound, Case, Figure, Findings, Lab, Sweep, Worst, display_steps, exact};
use crate::Result;
use crate::measure::plot::{Axis, Plot};
use crate::plan::{Options, Translucency};
use crate::scene::{AlphaMode, Material, Mesh, Scene};

pub const TRANSLUCENCY: Sweep = Sweep {
    name: "translucency",
    title: "Panes that cross, lie close, and are many",
    varies: "the angle between crossing panes, the distance of nearly coplanar ones from 0.1 m to a ten-millionth of that, 1 to 16 layers, \
             alpha from 0 to 1, and a glow of 1 to 1000 times white behind a dark pane",
    about: "Blending needs an order. Objects that are sorted have one each, so that panes which cross are wrong in half of their pixels; \
            layers that are kept in words have few bits; an average has no order at all; and layers that are peeled off end with the \
            last one that there is a pass for.",
    needs_device: true,
    find: translucency,
};

fn tinted(base_color: Vec3, alpha: f32) -> Material {
    let material =
        Material { alpha_mode: AlphaMode::Blend, double_sided: true, ..plain(base_color, 0.0, 0.8) };
    Material { base_color_factor: base_color.extend(alpha), ..material }
}

const COLORS: [Vec3; 4] = [
    Vec3::new(0.9, 0.1, 0.05),
    Vec3::new(0.1, 0.7, 0.15),
    Vec3::new(0.1, 0.2, 0.9),
    Vec3::new(0.8, 0.7, 0.1),
];

fn before_wall() -> Scene {
    let mut scene = Scene { lights: vec![sun(1.5, Vec3::new(-0.3, -0.4, -1.0))], ..Scene::default() };
    scene.cameras.push(camera(Vec3::new(0.0, 0.1, 3.0), Vec3::ZERO));
    let wall = Mat4::from_translation(Vec3::new(0.0, 0.0, -1.5)) * Mat4::from_scale(Vec3::splat(3.0));
    add(&mut scene, square(), plain(Vec3::splat(0.5), 0.0, 0.8), wall);
    scene
}

/// The square in four pieces: drivers warn of tiny draws.
fn sheet() -> Mesh {
    let mut mesh = Mesh::default();
    for (row, column) in (0..3_u32).flat_map(|row| (0..3).map(move |column| (row, column))) {
        mesh.positions.push(Vec3::new(column as f32 - 1.0, 1.0 - row as f32, 0.0));
        if row < 2 && column < 2 {
            let a = row * 3 + column;
            mesh.indices.extend([a, a + 3, a + 1, a + 1, a + 3, a + 4]);
        }
    }
    mesh.normals = vec![Vec3::Z; 9];
    mesh
}

fn pane(scene: &mut Scene, color: Vec3, alpha: f32, turn: f32, z_m: f32) {
    let place = Mat4::from_translation(Vec3::Z * z_m) * Mat4::from_rotation_y(turn);
    add(scene, sheet(), tinted(color, alpha), place * Mat4::from_scale(Vec3::splat(0.7)));
}

/// One quantity, its values, and the scene of each.
struct Series {
    name: &'static str,
    axis: Axis,
    scenes: Vec<(f64, Scene)>,
}

fn series(all: bool) -> Vec<Series> {
    let made = |few: &[f32], more: &[f32], scene: &dyn Fn(f32) -> Scene| {
        let mut values: Vec<_> = few.iter().chain(more.iter().filter(|_| all)).copied().collect();
        values.sort_by(f32::total_cmp);
        values.into_iter().map(|value| (f64::from(value), scene(value))).collect()
    };
    let crossing = |degrees: f32| {
        let mut scene = before_wall();
        let half = 0.5 * degrees.to_radians();
        for (color, turn) in [(COLORS[0], half), (COLORS[1], -half)] {
            pane(&mut scene, color, 0.6, turn, 0.0);
        }
        scene
    };
    let close = |gap_m: f32| {
        let mut scene = before_wall();
        for (i, color) in COLORS[..2].iter().enumerate() {
            pane(&mut scene, *color, 0.6, 0.0, i as f32 * gap_m);
        }
        scene
    };
    let many = |count: f32| {
        let mut scene = before_wall();
        (0..count as usize).for_each(|i| pane(&mut scene, COLORS[i % 4], 0.4, 0.0, -0.9 + 0.1 * i as f32));
        scene
    };
    let alphas = |alpha: f32| {
        let mut scene = before_wall();
        (0..4).for_each(|i| pane(&mut scene, COLORS[i], alpha, 0.0, 0.2 * i as f32));
        scene
    };
    let glowing = |times: f32| {
        let mut scene = before_wall();
        pane(&mut scene, COLORS[0], 0.5, 0.0, 0.0);
        scene.materials[1].emissive_factor = Vec3::new(1.0, 0.5, 0.1) * times;
        pane(&mut scene, Vec3::splat(0.1), 0.98, 0.0, 0.3);
        pane(&mut scene, COLORS[2], 0.3, 0.0, 0.5);
        scene
    };
    let linear = Axis::Linear;
    let logarithmic = Axis::Logarithmic;
    vec![
        Series {
            name: CROSSING,
            axis: linear,
            scenes: made(&[20.0, 90.0], &[1.0, 5.0, 45.0, 135.0], &crossing),
        },
        Series {
            name: CLOSE,
            axis: logarithmic,
            scenes: made(&[0.1, 1e-4, 1e-8], &[1e-2, 1e-3, 1e-5, 1e-6, 1e-7], &close),
        },
        Series { name: KEPT, axis: linear, scenes: made(&[1.0, 4.0], &[2.0, 3.0], &many) },
        Series { name: MANY, axis: linear, scenes: made(&[8.0], &[5.0, 6.0, 7.0], &many) },
        Series { name: TOO_MANY, axis: linear, scenes: made(&[9.0, 16.0], &[10.0, 12.0], &many) },
        Series {
            name: ALPHA,
            axis: linear,
            scenes: made(&[0.0, 0.5, 1.0], &[1e-3, 0.1, 0.9, 0.999], &alphas),
        },
        Series { name: GLOW, axis: logarithmic, scenes: made(&[1.0, 1000.0], &[10.0, 100.0], &glowing) },
    ]
}

const CROSSING: &str = "degrees between crossing panes";
const CLOSE: &str = "metres between two panes";
const KEPT: &str = "layers, 1 to 4";
const MANY: &str = "layers, 5 to 8";
const TOO_MANY: &str = "layers, 9 to 16";
const ALPHA: &str = "alpha of four panes";
const GLOW: &str = "times white behind a dark pane";

/// What a way may be off by, and why, and what to do about it.
fn bound(way: Translucency, series: &str) -> (Bound, &'static str) {
    let bound =
        |good, most, reason| Bound { name: "IN_ORDER", unit: "steps of 8-bit sRGB", good, most, reason };
    match (way, series) {
        (Translucency::Sorted, CROSSING) => (
            bound(
                0.5,
                255.0,
                "objects are sorted by their centres: where they cross, the wrong one is in front by as much as they differ",
            ),
            "--translucency oit or peeled, or cut objects where they cross",
        ),
        (Translucency::Weighted, _) => (
            bound(0.5, 255.0, "an average in place of an order: told, not promised"),
            "--translucency sorted, oit or peeled",
        ),
        (Translucency::Oit, MANY | TOO_MANY) => (
            bound(
                0.5,
                255.0,
                "four layers are kept; the farthest of more become one, in the order in which they were drawn",
            ),
            "--translucency sorted or peeled",
        ),
        (Translucency::Oit, _) => (
            bound(
                0.5,
                4.0,
                "a layer has 9 bits of its brightest channel and 8 of alpha, and four lie over each other",
            ),
            "--translucency sorted or peeled",
        ),
        (Translucency::Peeled, TOO_MANY) => (
            bound(0.5, 255.0, "eight layers are peeled off; nearer ones are not drawn"),
            "more of them: --translucency-layers 16",
        ),
        _ => (
            bound(0.5, 1.0, "half a step is not seen, and arithmetic is in floats"),
            "report it: nothing but rounding is allowed here",
        ),
    }
}

fn translucency(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let size = lab.pick([64, 48], [192, 144]);
    let ordered = bench.device().limits().ordered_attachment_access;
    let ways = Translucency::ALL.iter().copied().filter(|way| ordered || *way != Translucency::Oit);
    let ways: Vec<_> = ways.collect();
    let mut findings = Findings::default();
    for Series { name, axis, scenes } in series(lab.pick(false, true)) {
        let truths: Vec<_> = scenes.iter().map(|(_, scene)| bench.truth(scene, &exact(size), 0.0)).collect();
        let mut curves = Vec::new();
        for &translucency in &ways {
            let mut worst = Worst::new();
            let mut curve = Vec::new();
            for ((value, scene), truth) in scenes.iter().zip(&truths) {
                let options = Options { translucency, ..exact(size) };
                let found = light_of(&bench.picture(scene, options, 0.0)?)?;
                let mut of_scene = Worst::new();
                for (i, (pixel, found)) in truth.frame.pixels.iter().zip(found).enumerate() {
                    if pixel.edge && found.is_finite() {
                        continue;
                    }
                    let slack = truth.slack(i);
                    let channel = |c: usize| {
                        let off = display_steps(found[c], pixel.display[c]);
                        off - display_steps(pixel.display[c] + slack[c], pixel.display[c])
                    };
                    let error =
                        if found.is_finite() { (0..3).map(channel).fold(0.0, f64::max) } else { f64::NAN };
                    of_scene.add(error, || {
                        format!("{value}, pixel ({}, {})", i as u32 % size[0], i as u32 / size[0])
                    });
                }
                curve.push([*value, of_scene.error.max(1e-3)]);
                worst.add(of_scene.error, || of_scene.at.unwrap_or_default());
            }
            let (bound, remedy) = bound(translucency, name);
            findings.cases.push(Case {
                method: format!("{translucency}, {name}"),
                worst: worst.error,
                at: worst.at.unwrap_or_default(),
                bound,
                answer: None,
                remedy: remedy.into(),
            });
            curves.push((translucency.to_string(), curve));
        }
        let plot = Plot {
            title: "Against exact sorting".into(),
            x_label: name.into(),
            y_label: "steps of 8-bit sRGB".into(),
            axes: [axis, Axis::Logarithmic],
            curves,
            levels: vec![("seen".into(), 1.0)],
        };
        let file: String = name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' })
            .collect();
        findings.figures.push(Figure::plot(file, format!("The worst pixel by {name}, beside edges."), plot));
    }
    Ok(findings)
}

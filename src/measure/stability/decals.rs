//! Decals where projections, boxes and depth tests end.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{Mat4, Vec3};

use super::bench::{FLOOR, side_by_side};
use super::parts::{add, bulb, camera, floor, plain, sphere, square, sun};
use super::{Bound, Case, Figure, Findings, Lab, Sweep, difference, exact};
use crate::Result;
use crate::gpu::View;
use crate::measure::canvas::short;
use crate::plan::{DecalWay, Options};
use crate::scene::{Decal, DecalChannels, Projection, Scene};

pub const DECALS: Sweep = Sweep {
    name: "decals",
    title: "Decals at corners, at grazing projections, around the camera, and many over each other",
    varies: "the box's place, angle, size and shear, opacities from 1e-7 to 1, and 2 to 64 decals over each other",
    about: "A decal is drawn as its box's far side and asks depth where the surface is: what clipping takes away of the box, or \
            rounding of the place, is missing from the picture. Those that overlap have to find what those before have left.",
    needs_device: true,
    find: decals,
};

/// A corner of two walls and a floor, with a ball in it.
fn corner() -> Scene {
    let mut scene = Scene::default();
    let grey = plain(Vec3::splat(0.6), 0.0, 0.5);
    add(&mut scene, square(), grey.clone(), floor(4.0));
    add(
        &mut scene,
        square(),
        grey.clone(),
        Mat4::from_translation(Vec3::new(0.0, 0.0, -1.0)) * Mat4::from_scale(Vec3::splat(4.0)),
    );
    let side = Mat4::from_translation(Vec3::NEG_X) * Mat4::from_rotation_y(FRAC_PI_2);
    add(&mut scene, square(), grey.clone(), side * Mat4::from_scale(Vec3::splat(4.0)));
    let ball = Mat4::from_translation(Vec3::new(0.2, 0.4, 0.0)) * Mat4::from_scale(Vec3::splat(0.4));
    add(&mut scene, sphere(), grey, ball);
    scene
        .materials
        .extend([plain(Vec3::new(0.9, 0.1, 0.05), 0.0, 0.2), plain(Vec3::new(0.1, 0.3, 0.9), 1.0, 0.6)]);
    scene.lights = vec![bulb(6.0, Vec3::new(1.2, 2.0, 1.6), None), sun(0.6, Vec3::new(-0.4, -1.0, -0.6))];
    scene.cameras = vec![camera(Vec3::new(1.6, 1.5, 2.4), Vec3::new(-0.3, 0.4, -0.4))];
    scene
}

/// The scene's last two materials.
const PAINTS: [usize; 2] = [4, 5];

fn paint(place: Mat4) -> Decal {
    Decal { angle_rad: [1.0, 1.5], ..Decal::new(PAINTS[0], place) }
}

/// A box about a point of the floor near the corner.
fn placed(turn: Mat4, size: Vec3) -> Mat4 {
    Mat4::from_translation(Vec3::new(-0.2, 0.2, -0.2)) * turn * Mat4::from_scale(size)
}

/// Scenes of a kind, with what was varied.
type Series = (&'static str, Vec<(String, Scene)>);

fn series(all: bool) -> Vec<Series> {
    let with = |decals: Vec<Decal>| Scene { decals, ..corner() };
    let numbers = |few: &[f32], more: &[f32]| -> Vec<f32> {
        few.iter().chain(more.iter().filter(|_| all)).copied().collect()
    };
    let turned = |x: f32, y: f32| Mat4::from_rotation_y(y) * Mat4::from_rotation_x(x);
    let angles = numbers(&[0.0, 0.7, 1.2, FRAC_PI_2], &[0.2, 1.0, 1.5, 1.57]);
    let grazing = angles.iter().map(|&angle| {
        let decal = paint(placed(turned(-angle, 0.0), Vec3::splat(1.2)));
        (format!("{angle} rad down"), with(vec![decal]))
    });
    let corners = angles.iter().map(|&angle| {
        let decal = paint(placed(turned(-0.6, angle - FRAC_PI_4), Vec3::new(1.5, 1.5, 2.0)));
        (format!("{angle} rad around"), with(vec![decal]))
    });
    let eyes = numbers(&[0.0, 0.999, 1.0, 1.001, 1.5], &[0.5, 0.9, 0.95, 0.9999, 1.05, 1.1]);
    // The camera's distance from the box's centre, of half its depth.
    let around = eyes.iter().map(|&share| {
        let mut scene = corner();
        let eye = scene.cameras[0].world_from_view;
        let depth = 3.0;
        let along = Mat4::from_translation(Vec3::new(0.0, 0.0, -share * 0.5 * depth));
        scene.decals = vec![paint(eye * along * Mat4::from_scale(Vec3::new(2.0, 1.5, depth)))];
        (format!("the camera at {share} of half its depth"), scene)
    });
    let far = numbers(&[3.0, 3.5, 4.0], &[2.8, 3.2, 4.5]).into_iter().map(|far_m| {
        let mut scene = with(vec![paint(placed(turned(-0.6, 0.5), Vec3::splat(2.0)))]);
        scene.cameras[0].projection =
            Projection::Perspective { yfov_rad: 0.7, znear_m: 0.1, zfar_m: Some(far_m) };
        (format!("a far plane at {far_m} m"), scene)
    });
    let opacities = numbers(&[1e-7, 0.5, 1.0], &[1e-3, 0.1, 0.999]).into_iter().map(|opacity| {
        let channels =
            DecalChannels { base_color: opacity, roughness: opacity, metallic: opacity, normal: 0.0 };
        let decal = Decal { channels, ..paint(placed(turned(-0.8, 0.4), Vec3::splat(1.4))) };
        (format!("{opacity}"), with(vec![decal]))
    });
    let sizes = [
        Vec3::new(1e-3, 2.0, 2.0),
        Vec3::new(1.5, 1e-3, 2.0),
        Vec3::new(1e3, 0.7, 1e3),
        Vec3::splat(2e3),
        Vec3::new(1.0, -1.0, 1.0),
    ];
    let shear = Mat4::from_cols_array(&[
        1.0, 0.3, 0.0, 0.0, 0.9, 1.0, 0.2, 0.0, 0.0, -0.8, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    ]);
    let boxes = sizes.into_iter().map(|size| (format!("of {size} m"), placed(turned(-0.6, 0.5), size)));
    let boxes = boxes.chain([("sheared".into(), placed(shear, Vec3::ONE))]);
    let boxes = boxes.map(|(name, place)| (name, with(vec![paint(place)])));
    let counts: &[usize] = if all { &[2, 5, 16, 64] } else { &[2, 16] };
    let over = counts.iter().map(|&count| {
        let one = |i: usize| {
            let turn = turned(-0.7, 0.3 + 0.2 * i as f32);
            let channels = DecalChannels { base_color: 0.6, roughness: 0.3, ..DecalChannels::NONE };
            let place = placed(turn, Vec3::splat(1.6 - 0.01 * i as f32));
            Decal { material: PAINTS[i % 2], channels, priority: (i % 3) as f32, ..paint(place) }
        };
        (format!("{count} of them"), with((0..count).map(one).collect()))
    });
    vec![
        ("grazing", grazing.collect()),
        ("around a corner", corners.collect()),
        ("around the camera", around.collect()),
        ("cut by the far plane", far.collect()),
        ("opacity", opacities.collect()),
        ("boxes of any shape", boxes.collect()),
        ("over each other", over.collect()),
    ]
}

fn decals(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let size = lab.pick([48, 32], [160, 96]);
    let limits = bench.device().limits();
    let ways = [DecalWay::Barrier, DecalWay::RasterOrder];
    let ways = ways.into_iter().filter(|w| *w == DecalWay::Barrier || limits.ordered_attachment_access);
    let mut findings = Findings::default();
    let mut pictured = 0.0;
    for (name, scenes) in series(lab.pick(false, true)) {
        for decals in ways.clone() {
            let options = Options { decals, ..exact(size) };
            let mut worst: Option<(f64, String)> = None;
            for (varied, scene) in &scenes {
                let mut offscreen = bench.offscreen(scene, options.clone())?;
                offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 })?;
                let (picture, truth) = (offscreen.picture(), bench.truth(scene, &options, 0.0));
                let found = difference(&truth, &picture, FLOOR)?;
                if worst.as_ref().is_none_or(|(error, _)| found.worst > *error) {
                    worst = Some((found.worst, format!("{varied}, {}", found.place())));
                }
                if found.worst > pictured || pictured == 0.0 {
                    pictured = found.worst;
                    let caption = format!(
                        "{name}, {decals}, {varied}: drawn, true, and the difference (white: {})",
                        short(pictured)
                    );
                    let picture = side_by_side(&truth.frame, &picture, FLOOR, pictured.clamp(1e-9, 1e9))?;
                    findings.figures = vec![Figure::picture("worst", caption, picture)];
                }
            }
            let (error, at) = worst.unwrap_or_default();
            findings.cases.push(Case {
                method: format!("{decals}, {name}"),
                worst: error,
                at,
                bound: Bound {
                    name: "NO_PAINT_LOST",
                    unit: "of the light",
                    good: 2e-3,
                    most: 0.02,
                    reason: "paint that is lost or too much changes most of a pixel; within the falloff by angle, f32 normals and \
                             places leave some thousandths",
                },
                answer: None,
                remedy: String::new(),
            });
        }
    }
    Ok(findings)
}

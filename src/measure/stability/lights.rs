//! Light volumes around the camera, and lights that move past what stands still.

use glam::{Mat4, Vec3};

use super::bench::{FLOOR, side_by_side, truth};
use super::parts::{add, bulb, camera, floor, plain, sphere, square, sun};
use super::{Bound, Case, Figure, Findings, Lab, Sweep, difference, exact};
use crate::Result;
use crate::gpu::View;
use crate::measure::canvas::short;
use crate::picture::Pixels;
use crate::plan::{LightWay, Options};
use crate::scene::{Light, LightKind, Scene};

pub const VOLUMES: Sweep = Sweep {
    name: "light-volumes",
    title: "The camera inside light volumes and on their border",
    varies: "the camera's distance from a light's centre, of its range: 0 to 2, and 1 to within 1e-7",
    about: "A volume is a mesh: where the camera or its near plane cuts it, faces are clipped away, and a pixel that loses its \
            face loses the light.",
    needs_device: true,
    find: volumes,
};

pub const STEADY: Sweep = Sweep {
    name: "steady",
    title: "Pixels that nothing reaches, while lights move elsewhere",
    varies: "frames, each with a light moved and turned on and off, up to 2000",
    about: "What stands still under lights that do must not change by a bit: lists are built anew in each frame, and sums may \
            change their order.",
    needs_device: true,
    find: steady,
};

const WAYS: [LightWay; 4] = [LightWay::Fullscreen, LightWay::Volumes, LightWay::Stencil, LightWay::Clusters];

/// A room's floor and a few balls around a light of 2 m range.
fn lit_by(light: Light) -> Scene {
    let mut scene = Scene::default();
    add(
        &mut scene,
        square(),
        plain(Vec3::splat(0.6), 0.0, 0.5),
        Mat4::from_translation(Vec3::NEG_Y) * floor(6.0),
    );
    for i in 0..5 {
        let angle = i as f32 * 1.3;
        let at = Vec3::new(angle.cos() * 1.4, -0.4 + 0.2 * i as f32, angle.sin() * 1.4);
        let place = Mat4::from_translation(at) * Mat4::from_scale(Vec3::splat(0.35));
        add(&mut scene, sphere(), plain(Vec3::new(0.7, 0.5, 0.3), 0.0, 0.4), place);
    }
    scene.lights = vec![light];
    scene
}

const RANGE_M: f32 = 2.0;

/// One of each shape that ends.
fn ending_lights() -> Vec<(&'static str, Light)> {
    let spot = LightKind::Spot { intensity_cd: 8.0, inner_cone_rad: 0.3, outer_cone_rad: 0.8 };
    let wide = LightKind::Spot { intensity_cd: 8.0, inner_cone_rad: 1.0, outer_cone_rad: 1.5 };
    let cube = LightKind::Box { illuminance_lx: 2.0, size_m: Vec3::splat(2.0 * RANGE_M), falloff_m: 0.5 };
    let down = Vec3::new(0.2, -1.0, 0.1);
    let ends = |kind| Light { range_m: Some(RANGE_M), ..Light::new(kind) }.towards(down);
    vec![
        ("point", bulb(4.0, Vec3::ZERO, Some(RANGE_M))),
        ("spot", ends(spot)),
        ("wide spot", ends(wide)),
        ("box", Light::new(cube).towards(down)),
    ]
}

/// Camera distances in ranges: the middle, the near plane on the border, the camera on the border, outside.
fn distances(all: bool) -> Vec<f32> {
    let mut list = vec![0.0, 0.5, 0.95, 1.0 - 1e-7, 1.0, 1.0 + 1e-7, 1.05, 2.0];
    if all {
        list.extend([
            1e-4, 0.05, 0.25, 0.9, 0.949, 0.9499, 0.9501, 0.951, 0.99, 0.999, 1.001, 1.01, 1.02, 1.1, 1.3,
        ]);
    }
    list
}

fn volumes(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let size = lab.pick([48, 32], [160, 96]);
    let distances = distances(lab.pick(false, true));
    let ways = [Vec3::Z, Vec3::new(0.6, 0.5, -0.6).normalize(), Vec3::NEG_Y];
    let ways = lab.pick(&ways[..2], &ways[..]);
    let mut findings = Findings::default();
    let mut pictured = 0.0;
    for (name, light) in ending_lights() {
        let scene = lit_by(light);
        for lights in &WAYS[1..] {
            let options = Options { lights: *lights, ..exact(size) };
            let mut offscreen = bench.offscreen(&scene, options.clone())?;
            let mut worst: Option<(f64, String)> = None;
            for &way in ways {
                for &distance in &distances {
                    // Towards the light, past it where the camera is inside.
                    let eye = way * (distance * RANGE_M);
                    let mut scene = scene.clone();
                    scene.cameras = vec![camera(eye, eye - way)];
                    offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 })?;
                    let (picture, truth) = (offscreen.picture(), bench.truth(&scene, &options, 0.0));
                    let found = difference(&truth, &picture, FLOOR)?;
                    if worst.as_ref().is_none_or(|(error, _)| found.worst > *error) {
                        worst =
                            Some((found.worst, format!("{distance} ranges along {way}, {}", found.place())));
                    }
                    if found.worst > pictured {
                        pictured = found.worst;
                        let caption = format!(
                            "{name}, {lights}, {distance} ranges away: drawn, true, and the difference (white: {})",
                            short(pictured)
                        );
                        let picture = side_by_side(&truth.frame, &picture, FLOOR, pictured.min(1e9))?;
                        findings.figures = vec![Figure::picture("worst", caption, picture)];
                    }
                }
            }
            let (error, at) = worst.unwrap_or_default();
            findings.cases.push(Case {
                method: format!("{lights}, {name}"),
                worst: error,
                at,
                bound: Bound {
                    name: "NO_LIGHT_LOST",
                    unit: "of the light",
                    good: 2e-3,
                    most: 0.02,
                    reason: "a lost face costs all of the light; at the very border, where light fades to nothing, what is near the \
                             display's first step is a matter of f32",
                },
                answer: None,
                remedy: String::new(),
            });
        }
    }
    Ok(findings)
}

fn steady(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let frames = lab.pick(60, 2000);
    let mut findings = Findings::default();
    let mut scene = lit_by(bulb(4.0, Vec3::new(-4.0, 0.5, 0.0), Some(1.5)));
    scene.cameras.push(camera(Vec3::new(0.0, 2.5, 6.0), Vec3::ZERO));
    // Lights that stand still over the left and the middle, one more that stays dark until it is moved.
    scene.lights.extend([
        bulb(3.0, Vec3::new(-1.0, 0.8, 1.0), Some(2.5)),
        bulb(2.0, Vec3::new(-1.5, 1.0, 0.0), Some(3.0)),
    ]);
    scene.lights.push(sun(0.3, Vec3::new(-0.3, -1.0, -0.2)));
    // It moves within 1.38 m of (3, 0, 0) and reaches 1 m.
    const MOVING: usize = 0;
    let place = |frame: usize| {
        let t = frame as f32 * 0.37;
        Vec3::new(3.0 + t.sin(), 0.3 * (1.7 * t).cos(), (0.9 * t).cos() * 0.9)
    };
    const REACH_M: f32 = 1.0;
    scene.lights[MOVING] = bulb(4.0, place(0), Some(REACH_M));
    let size = lab.pick([64, 40], [128, 80]);
    for lights in WAYS {
        let options = Options { lights, ..exact(size) };
        let positions: Vec<_> =
            truth(&scene, &options, 0.0).pixels.iter().map(|p| p.attributes.position_world).collect();
        // A metre around all places, and a margin.
        let reached =
            |i: usize| (positions[i].as_vec3() - Vec3::new(3.0, 0.0, 0.0)).length() < 1.4 + 1.1 * REACH_M;
        let mut offscreen = bench.offscreen(&scene, options.clone())?;
        let (mut changed, mut moved, mut first, mut at) = (0, false, None::<Vec<u32>>, String::new());
        for frame in 0..frames {
            let mut light = bulb(4.0, place(frame), Some(REACH_M));
            if frame % 5 == 4 {
                light.color = Vec3::ZERO;
            }
            offscreen.renderer_mut().set_light(MOVING, &light)?;
            offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 })?;
            let Pixels::Rgba32F(channels) = offscreen.picture().pixels else {
                unreachable!("floats were asked for")
            };
            let bits: Vec<u32> = channels.iter().map(|c| c.to_bits()).collect();
            let Some(first) = &first else {
                first = Some(bits);
                continue;
            };
            let differs = |i: usize| bits[4 * i..4 * i + 4] != first[4 * i..4 * i + 4];
            let here = (0..positions.len()).filter(|&i| !reached(i) && differs(i)).count();
            moved |= (0..positions.len()).any(|i| reached(i) && differs(i));
            if here > changed {
                (changed, at) = (here, format!("frame {frame}"));
            }
        }
        let still = (0..positions.len()).filter(|&i| !reached(i)).count();
        findings.cases.push(Case {
            method: lights.to_string(),
            // If the light changes nothing, nothing was shown.
            worst: if moved { changed as f64 } else { f64::NAN },
            at: if changed > 0 { at } else { format!("{frames} frames, {still} pixels that stand still") },
            bound: Bound {
                name: "NOT_A_BIT",
                unit: "pixels",
                good: 0.0,
                most: 0.0,
                reason: "what nothing reaches is computed from the same numbers in the same order",
            },
            answer: None,
            remedy: String::new(),
        });
    }
    Ok(findings)
}

//! Shadows counted in the stencil, where counting is hard.

use glam::{Mat4, Vec3};

use super::bench::light_of;
use super::parts::{add, bulb, camera, floor, plain, sphere, square, sun};
use super::shadows::marked;
use super::{Bound, Case, Figure, Findings, Lab, Sweep, Truth, Worst, exact};
use crate::Result;
use crate::picture::Picture;
use crate::plan::{COUNT_BITS, Options};
use crate::scene::{Light, Material, Mesh, Projection, Scene, Shadow};

pub const SHADOW_VOLUMES: Sweep = Sweep {
    name: "shadow-volumes",
    title: "Shadows that are counted",
    varies: "where the planes of the view cut the volumes, how open casters are, how near casters are to receivers and to the light, and \
             how many volumes are around a point",
    about: "A volume whose wall or end is missing leaves a wrong count in all pixels behind it: cut off by the near plane or the far \
            one, left out where a mesh is open, or rounded away where a caster touches something. Seven bits count up to 127.",
    needs_device: true,
    find: shadow_volumes,
};

/// A ball over a floor and before a wall.
fn room() -> Scene {
    let mut scene = Scene::default();
    scene.cameras.push(camera(Vec3::new(0.4, 1.1, 3.2), Vec3::new(0.0, 0.5, 0.0)));
    let grey = plain(Vec3::splat(0.6), 0.0, 0.9);
    add(&mut scene, square(), grey.clone(), floor(4.0));
    let wall = Mat4::from_translation(Vec3::new(0.0, 2.0, -1.5)) * Mat4::from_scale(Vec3::splat(4.0));
    add(&mut scene, square(), grey.clone(), wall);
    add(&mut scene, sphere(), grey, ball(0.6));
    scene
}

/// The ball's place, by the height of its centre: its radius is 0.4 m.
fn ball(height_m: f32) -> Mat4 {
    Mat4::from_translation(Vec3::new(0.0, height_m, 0.0)) * Mat4::from_scale(Vec3::splat(0.4))
}

const BALL: usize = 2;

fn lit_by(light: Light) -> Scene {
    Scene { lights: vec![Light { shadow: Some(Shadow::default()), ..light }], ..room() }
}

fn slanted() -> Light {
    sun(2.0, Vec3::new(-0.6, -1.0, -0.4))
}

fn with_ball(light: Light, change: impl FnOnce(&mut Mesh, &mut Material)) -> Scene {
    let mut scene = lit_by(light);
    let mesh = &mut scene.meshes[BALL];
    change(mesh, &mut scene.materials[mesh.material]);
    scene
}

/// Thin sheets over each other, so close that most of their shadow lies under all.
fn sheets(count: u32) -> Scene {
    let mut scene = lit_by(sun(2.0, Vec3::new(-0.5, -1.0, 0.1)));
    scene.instances.pop();
    let mesh = scene.meshes.len();
    let sheet = |i: u32| Mat4::from_translation(Vec3::new(0.5, 0.6 + 0.001 * i as f32, 0.0)) * floor(0.4);
    add(&mut scene, square(), plain(Vec3::splat(0.6), 0.0, 0.9), sheet(0));
    scene.instances.extend((1..count).map(|i| crate::scene::Instance::new(mesh, sheet(i))));
    scene
}

/// What is varied, and the scenes.
struct Series {
    name: &'static str,
    scenes: Vec<(String, Scene)>,
}

fn series(all: bool) -> Vec<Series> {
    let some = |few: &[f32], more: &[f32]| -> Vec<f32> {
        few.iter().chain(more.iter().filter(|_| all)).copied().collect()
    };
    let over = |values: Vec<f32>, unit: &str, scene: &dyn Fn(f32) -> Scene| {
        values.into_iter().map(|value| (format!("{value} {unit}"), scene(value))).collect()
    };
    let spotted = |x: f32| {
        // Across the ball's shadow, a hand's breadth over the floor: the near plane is cut by both of its walls.
        let mut scene = lit_by(slanted());
        scene.cameras[0] = camera(Vec3::new(x, 0.12, 0.3), Vec3::new(x - 0.5, 0.1, -1.5));
        scene
    };
    let near = |znear_m: f32| {
        let mut scene = spotted(-0.3);
        scene.cameras[0].projection = Projection::Perspective { yfov_rad: 0.7, znear_m, zfar_m: None };
        scene
    };
    let far = |far_m: f32| {
        let mut scene = lit_by(slanted());
        let zfar_m = Some(far_m);
        scene.cameras[0].projection = Projection::Perspective { yfov_rad: 0.7, znear_m: 0.1, zfar_m };
        scene
    };
    let holes = |share: f32| {
        with_ball(slanted(), |mesh, material| {
            material.double_sided = true;
            let left = |(i, _): &(usize, &[u32])| (i * 37 % 100) as f32 >= 100.0 * share;
            let triangles = mesh.indices.chunks(3).enumerate().filter(left);
            mesh.indices = triangles.flat_map(|(_, triangle)| triangle.to_vec()).collect();
        })
    };
    let touching = |height_m: f32| {
        let mut scene = lit_by(slanted());
        scene.instances[BALL].world_from_object = ball(0.4 + height_m);
        scene
    };
    let lamp = |distance_m: f32| lit_by(bulb(4.0, Vec3::new(0.0, 1.0 + distance_m, 0.0), Some(9.0)));
    let inside = |double_sided: f32| {
        let bulb = bulb(4.0, Vec3::new(0.1, 0.7, 0.0), Some(9.0));
        with_ball(bulb, |_, material| material.double_sided = double_sided != 0.0)
    };
    let grazing = |angle: f32| lit_by(sun(2.0, Vec3::new(-angle.cos(), -angle.sin(), -0.1)));
    let wrapped = COUNT_BITS as f32 + 1.0;
    vec![
        Series {
            name: "the camera across a shadow",
            scenes: over(some(&[-0.7, -0.3, 0.1], &[-0.5, -0.1, 0.3]), "m", &spotted),
        },
        Series { name: "near planes", scenes: over(some(&[1e-3, 0.5], &[0.01, 0.1, 1.0]), "m", &near) },
        Series { name: "far planes", scenes: over(some(&[3.0, 6.0], &[2.6, 3.5, 4.0, 10.0]), "m", &far) },
        Series {
            name: "holes in a two-sided ball",
            scenes: over(some(&[0.1, 0.9], &[0.02, 0.3, 0.6]), "of its triangles", &holes),
        },
        Series {
            name: "a ball over the floor and in it",
            scenes: over(some(&[-0.2, 0.0, 1e-4], &[-0.4, -1e-4, 1e-6, 1e-2]), "m", &touching),
        },
        Series {
            name: "a lamp over a ball",
            scenes: over(some(&[0.1, 1e-3], &[1.0, 0.01, 1e-4, 1e-5]), "m", &lamp),
        },
        Series {
            name: "a lamp in a ball, one-sided (0) and two-sided (1)",
            scenes: over(vec![0.0, 1.0], "", &inside),
        },
        Series {
            name: "light that grazes the floor",
            scenes: over(some(&[0.1, 1e-3], &[0.3, 0.01, 1e-4]), "rad", &grazing),
        },
        Series {
            name: "sheets over each other",
            scenes: over(some(&[2.0, wrapped - 1.0], &[16.0, 64.0]), "of them", &|n| sheets(n as u32)),
        },
        Series {
            name: WRAPPED,
            scenes: over(some(&[wrapped], &[wrapped + 1.0, 2.0 * wrapped]), "of them", &|n| sheets(n as u32)),
        },
    ]
}

const WRAPPED: &str = "more sheets than are counted";

/// Of the true light, or a twentieth of white: shadow or not is a matter of all of it.
const TOLERANCE: f64 = 0.02;

/// Which pixels are light and should be dark or the other way round, beside edges of surfaces, and of shadows as far as the rasteriser's
/// lattice moves them; and how many are in shadow or lit, whichever are fewer.
fn wrong(truth: &Truth, picture: &Picture) -> Result<(Vec<bool>, usize)> {
    let found = light_of(picture)?;
    let pixels = truth.frame.pixels.iter().enumerate();
    let marks: Vec<_> = pixels
        .map(|(i, pixel)| {
            let allowed = TOLERANCE * pixel.display.max_element().max(0.05) + truth.slack(i).max_element();
            !pixel.edge && ((found[i] - pixel.display).abs().max_element() > allowed || !found[i].is_finite())
        })
        .collect();
    let shadowed = truth.frame.pixels.iter().filter(|pixel| pixel.shadowed != 0).count();
    Ok((marks, shadowed))
}

fn shadow_volumes(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let size = lab.pick([96, 64], [320, 200]);
    let options = Options { shadow_volumes: true, ..exact(size) };
    let mut findings = Findings::default();
    for (index, Series { name, scenes }) in series(lab.pick(false, true)).into_iter().enumerate() {
        let (mut worst, mut pictured, mut figure) = (Worst::new(), 0.0, None);
        for (varied, scene) in scenes {
            let (picture, truth) =
                (bench.picture(&scene, options.clone(), 0.0)?, bench.truth(&scene, &options, 0.0));
            let (marks, shadowed) = wrong(&truth, &picture)?;
            let share = 100.0 * marks.iter().filter(|wrong| **wrong).count() as f64 / marks.len() as f64;
            worst.add(share, || {
                format!("{varied}; {:.1} % are in shadow", 100.0 * shadowed as f64 / marks.len() as f64)
            });
            if share > pictured {
                pictured = share;
                let caption =
                    format!("{name}, {varied}: in red what is lit and should not be, or the other way round");
                let picture = marked(size, &light_of(&picture)?, &marks);
                figure = Some(Figure::picture(format!("worst-{}", index + 1), caption, picture));
            }
        }
        findings.figures.extend(figure);
        let (most, reason) = match name {
            WRAPPED => (
                100.0,
                "128 volumes around a point are none in seven bits, and what lies under exactly so many is lit",
            ),
            _ => (
                0.1,
                "shadows end where the rasteriser's edges do: f32 moves single pixels at their ends, a missing wall changes many",
            ),
        };
        findings.cases.push(Case {
            method: name.into(),
            worst: worst.error,
            at: worst.at.unwrap_or_default(),
            bound: Bound { name: "LIT_OR_NOT", unit: "% of all pixels", good: 0.02, most, reason },
            answer: None,
            remedy: "a map for the light: \"shadow\": {\"volume\": false}".into(),
        });
    }
    Ok(findings)
}

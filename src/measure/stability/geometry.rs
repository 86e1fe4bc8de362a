//! Triangles without area, directions without length, mirrored texture coordinates, and targets of any shape.

use glam::{Mat4, Vec2, Vec3, Vec4};

use super::bench::{FLOOR, side_by_side};
use super::parts::{add, bulb, camera, floor, plain, sphere, square, sun};
use super::{Bound, Case, Figure, Findings, Lab, Sweep, difference, exact};
use crate::Result;
use crate::measure::canvas::short;
use crate::plan::{LightWay, Options, Path};
use crate::scene::{Image, Mesh, Sampler, Scene, Texture, TextureRef};

pub const GEOMETRY: Sweep = Sweep {
    name: "geometry",
    title: "Meshes that are not as they should be",
    varies: "kind of flaw",
    about: "Exporters write triangles of no area, normals and tangents of no length, and texture coordinates that run backwards.",
    needs_device: true,
    find: geometry,
};

pub const TARGETS: Sweep = Sweep {
    name: "targets",
    title: "Targets of any shape",
    varies: "width and height in pixels: 1 x 1 to 16384 x 1, odd sizes, aspects of 1 : 16384 to 16384 : 1",
    about: "Clusters, tiles, derivatives and projections have sizes of their own that a target need not be a multiple of.",
    needs_device: true,
    find: targets,
};

/// As other sweeps of arithmetic.
const LIKE_THE_TRUTH: Bound = Bound {
    name: "LIKE_THE_TRUTH",
    unit: "of the light",
    good: 1e-3,
    most: 4e-3,
    reason: "what the renderer promises for 99.9 % of pixels and what f32 needs for the rest",
};

/// A ball over a floor; the ball's normals are mapped.
fn scene(ball: Mesh) -> Scene {
    let mut scene = Scene::default();
    scene.cameras.push(camera(Vec3::new(0.3, 1.2, 4.0), Vec3::ZERO));
    // One texel: what a filter makes of it is the same everywhere.
    let rgba8 = [150, 110, 240, 255].to_vec();
    scene.images = vec![Image { name: "slope".into(), width: 1, height: 1, texels: rgba8.into() }];
    scene.textures = vec![Texture { image: 0, sampler: Sampler::default() }];
    let mut material = plain(Vec3::new(0.7, 0.5, 0.4), 0.3, 0.5);
    material.normal_texture =
        Some(TextureRef { texture: 0, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY });
    add(&mut scene, ball, material, Mat4::IDENTITY);
    add(
        &mut scene,
        square(),
        plain(Vec3::splat(0.5), 0.0, 0.6),
        Mat4::from_translation(Vec3::NEG_Y) * floor(4.0),
    );
    scene.lights =
        vec![sun(1.0, Vec3::new(-0.5, -1.0, -0.6)), bulb(3.0, Vec3::new(-1.5, 1.0, 1.5), Some(6.0))];
    scene
}

/// The ball with a flaw.
fn flawed() -> Vec<(&'static str, Scene)> {
    let with = |change: fn(&mut Mesh)| {
        let mut ball = sphere();
        change(&mut ball);
        scene(ball)
    };
    let mut flat = scene(sphere());
    flat.instances[0].world_from_object = Mat4::from_scale(Vec3::new(1.0, 1.0, 0.0));
    let mut point = scene(sphere());
    point.instances[0].world_from_object = Mat4::ZERO;
    point.instances[0].world_from_object.w_axis.w = 1.0;
    let mut mirrored = scene(sphere());
    mirrored.instances[0].world_from_object = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    vec![
        (
            "triangles of one point or a line",
            with(|ball| {
                for triangle in 0..200 {
                    let [a, b] = [triangle * 5 % 900, triangle * 7 % 900];
                    ball.indices.extend([a, a, a, a, b, a, b, b, a]);
                }
            }),
        ),
        (
            "triangles of 1e-20 m",
            with(|ball| {
                let first = ball.positions.len() as u32;
                for (x, y) in [(0.0, 0.0), (1e-20, 0.0), (0.0, 1e-20)] {
                    ball.positions.push(Vec3::new(0.2 + x, 0.1 + y, 1.05));
                    ball.normals.push(Vec3::Z);
                    ball.tangents.push(Vec3::X.extend(1.0));
                    ball.texcoords[0].push(Vec2::ZERO);
                }
                ball.indices.extend([first, first + 1, first + 2]);
            }),
        ),
        (
            "normals of no length at every third vertex",
            with(|ball| {
                ball.normals.iter_mut().step_by(3).for_each(|n| *n = Vec3::ZERO);
            }),
        ),
        ("no normal has a length", with(|ball| ball.normals.fill(Vec3::ZERO))),
        (
            "tangents of no length at every third vertex",
            with(|ball| {
                ball.tangents.iter_mut().step_by(3).for_each(|t| *t = Vec4::new(0.0, 0.0, 0.0, 1.0));
            }),
        ),
        ("no tangent has a length", with(|ball| ball.tangents.fill(Vec4::W))),
        (
            "tangents along normals",
            with(|ball| {
                ball.tangents = ball.normals.iter().map(|n| n.extend(1.0)).collect();
            }),
        ),
        (
            "mirrored texture coordinates",
            with(|ball| {
                ball.texcoords[0].iter_mut().for_each(|uv| uv.x = 1.0 - uv.x);
                ball.tangents.iter_mut().for_each(|t| *t = (-t.truncate()).extend(-t.w));
            }),
        ),
        ("a mirrored instance", mirrored),
        ("an instance squeezed flat", flat),
        ("an instance squeezed to a point", point),
    ]
}

fn geometry(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let size = lab.pick([64, 36], [320, 180]);
    let mut findings = Findings::default();
    let mut pictured = 0.0;
    for (method, scene) in flawed() {
        let mut case = None;
        for path in [Path::Deferred, Path::Forward] {
            let options = Options { path, ..exact(size) };
            let (picture, truth) =
                (bench.picture(&scene, options.clone(), 0.0)?, bench.truth(&scene, &options, 0.0));
            let found = difference(&truth, &picture, FLOOR)?;
            if found.worst > pictured {
                pictured = found.worst;
                let caption =
                    format!("{method}: drawn, true, and the difference (white: {})", short(pictured));
                let picture = side_by_side(&truth.frame, &picture, FLOOR, pictured.min(1e9))?;
                findings.figures = vec![Figure::picture("worst", caption, picture)];
            }
            let this = Case {
                method: method.into(),
                worst: found.worst,
                at: format!("{path}, {}", found.place()),
                bound: LIKE_THE_TRUTH,
                answer: None,
                remedy: String::new(),
            };
            case = Some(match case {
                Some(other) if is_worse(&other, &this) => other,
                _ => this,
            });
        }
        findings.cases.extend(case);
    }
    Ok(findings)
}

/// Whether the first is at least as bad; not a number is worst.
fn is_worse(a: &Case, b: &Case) -> bool {
    a.worst.is_nan() || a.worst >= b.worst
}

fn targets(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let largest = bench.device().caps().limits().max_image_size.min(16384);
    let few = [[1, 1], [largest, 1], [1, largest / 16], [3, 5], [127, 61]];
    let all = [
        [1, 1],
        [2, 1],
        [1, 2],
        [largest, 1],
        [1, largest],
        [largest, 3],
        [3, 5],
        [17, 1],
        [63, 65],
        [127, 61],
        [129, 64],
        [641, 359],
    ];
    let mut findings = Findings::default();
    let mut scene = scene(sphere());
    // In the middle of every picture, however narrow, are edges; what is large enough is compared.
    scene.materials[0].normal_texture = None;
    let mut pictured = 0.0;
    for lights in [LightWay::Fullscreen, LightWay::Volumes, LightWay::Clusters] {
        let mut worst: Option<(f64, String)> = None;
        let mut compared = 0;
        for &size in lab.pick(&few[..], &all[..]) {
            let options = Options { lights, ..exact(size) };
            let (picture, truth) =
                (bench.picture(&scene, options.clone(), 0.0)?, bench.truth(&scene, &options, 0.0));
            let found = difference(&truth, &picture, FLOOR)?;
            compared += found.compared;
            if worst.as_ref().is_none_or(|(error, _)| found.worst.is_nan() || found.worst > *error) {
                worst = Some((found.worst, format!("{} x {}, {}", size[0], size[1], found.place())));
            }
            if found.worst > pictured && size[0].min(size[1]) > 1 {
                pictured = found.worst;
                let caption = format!(
                    "{} x {}, {lights}: drawn, true, and the difference (white: {})",
                    size[0],
                    size[1],
                    short(pictured)
                );
                findings.figures = vec![Figure::picture(
                    "worst",
                    caption,
                    side_by_side(&truth.frame, &picture, FLOOR, pictured)?,
                )];
            }
        }
        let (error, at) = worst.unwrap_or_default();
        findings.cases.push(Case {
            method: lights.to_string(),
            // A sweep that compared nothing has shown nothing.
            worst: if compared > 0 { error } else { f64::NAN },
            at,
            bound: LIKE_THE_TRUTH,
            answer: None,
            remedy: "pixels are square: a picture's width follows from its height and the camera's angle"
                .into(),
        });
    }
    Ok(findings)
}

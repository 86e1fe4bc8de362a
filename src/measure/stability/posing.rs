//! Meshes that bend, by joints and by morph targets that are not as they should be.

use std::f32::consts::PI;

use glam::{Mat4, Vec3};

use super::bench::{FLOOR, side_by_side};
use super::parts::{add, bulb, camera, floor, plain, sphere, square, sun};
use super::{Answer, Bound, Case, Figure, Findings, Lab, Sweep, difference, exact};
use crate::Result;
use crate::measure::canvas::short;
use crate::scene::{Deformation, Influence, MorphTarget, Pose, Scene};

pub const POSING: Sweep = Sweep {
    name: "posing",
    title: "Joints and morph targets at their limits",
    varies: "kind of flaw: joints of next to no size, flat, stretched, turned against each other, far away; weights of any sum; targets that cancel",
    about: "A vertex goes by the mean of its joints' transforms, and a mean of turns may have no extent; a normal goes by its inverse \
            transpose, which may not exist. Compute does it in f32, the reference in f64.",
    needs_device: true,
    find: posing,
};

/// As other sweeps of arithmetic.
const LIKE_THE_TRUTH: Bound = Bound {
    name: "LIKE_THE_TRUTH",
    unit: "of the light",
    good: 1e-3,
    most: 4e-3,
    reason: "what the renderer promises for 99.9 % of pixels and what f32 needs for the rest",
};

/// Where terms cancel, of 24 bits those are left that the sum is smaller by.
const CANCELLED: Bound = Bound {
    name: "CANCELLED",
    unit: "of the light",
    good: 1e-3,
    most: 0.1,
    reason: "displacements of 100 times the ball leave 1e-5 of its size to rounding, and highlights follow normals",
};

/// A ball over a floor whose lower half goes by one joint, the upper by another, and what is between by both.
fn scene() -> Scene {
    let mut scene = Scene { name: "posing".into(), ..Scene::default() };
    scene.cameras.push(camera(Vec3::new(0.3, 1.2, 4.0), Vec3::ZERO));
    let mut ball = sphere();
    ball.tangents.clear();
    ball.texcoords = Default::default();
    let share = |p: &Vec3| (p.y * 0.8 + 0.5).clamp(0.0, 1.0);
    let influence =
        |p: &Vec3| Influence { joints: [0, 1, 0, 0], weights: [1.0 - share(p), share(p), 0.0, 0.0] };
    let influences = ball.positions.iter().map(influence).collect();
    let target = |by: f32| MorphTarget {
        positions: ball.positions.iter().map(|p| *p * by).collect(),
        normals: ball.normals.iter().map(|n| *n * by).collect(),
        tangents: Vec::new(),
    };
    let targets = vec![target(1.0), target(-1.0)];
    let pose = Pose { object_from_bind: vec![Mat4::IDENTITY; 2], weights: vec![0.0; 2] };
    ball.deformation = Some(Deformation { influences, targets, pose });
    add(&mut scene, ball, plain(Vec3::new(0.7, 0.5, 0.4), 0.3, 0.5), Mat4::IDENTITY);
    let ground = Mat4::from_translation(Vec3::NEG_Y) * floor(4.0);
    add(&mut scene, square(), plain(Vec3::splat(0.5), 0.0, 0.6), ground);
    scene.lights =
        vec![sun(1.0, Vec3::new(-0.5, -1.0, -0.6)), bulb(3.0, Vec3::new(-1.5, 1.0, 1.5), Some(6.0))];
    scene
}

/// The scene with its upper joint so, and changed.
fn with(upper: Mat4, change: impl FnOnce(&mut Deformation)) -> Scene {
    let mut scene = scene();
    if let Some(deformation) = &mut scene.meshes[0].deformation {
        deformation.pose.object_from_bind[1] = upper;
        change(deformation);
    }
    scene
}

/// Everything as far away, the camera beside it.
fn far(metres: f32) -> Scene {
    let mut scene = with(Mat4::from_rotation_z(0.6), |_| ());
    let there = Mat4::from_translation(Vec3::new(metres, 0.0, -metres));
    scene.instances.iter_mut().for_each(|i| i.world_from_object = there * i.world_from_object);
    scene.cameras.iter_mut().for_each(|c| c.world_from_view = there * c.world_from_view);
    scene.lights.iter_mut().for_each(|l| l.position_world = there.transform_point3(l.position_world));
    scene
}

type Flaw = (&'static str, Scene, Bound, Option<Answer>, &'static str);

fn flaws() -> Vec<Flaw> {
    let scaled = |x: f32, y: f32, z: f32| with(Mat4::from_scale(Vec3::new(x, y, z)), |_| ());
    let turned = |angle: f32| with(Mat4::from_rotation_y(angle), |_| ());
    let small = |scale: f32| {
        with(Mat4::from_scale(Vec3::splat(scale)), |d| {
            d.pose.object_from_bind[0] = d.pose.object_from_bind[1]
        })
    };
    let weights = |factor: f32| {
        with(Mat4::from_rotation_z(0.6), |d| {
            d.influences.iter_mut().for_each(|i| i.weights = i.weights.map(|w| w * factor));
        })
    };
    let near = |name, scene| (name, scene, LIKE_THE_TRUTH, None, "");
    vec![
        near("a joint that is turned by 0.6", with(Mat4::from_rotation_z(0.6), |_| ())),
        near("joints of 1 : 1000", scaled(1.0, 1e-3, 1.0)),
        near("a joint of 1e-6", scaled(1e-6, 1e-6, 1e-6)),
        near("a joint that is flat", scaled(1.0, 0.0, 1.0)),
        near("a joint that is a point", scaled(0.0, 0.0, 0.0)),
        near("a joint that is mirrored", scaled(1.0, 1.0, -1.0)),
        near("all joints of 0.3", small(0.3)),
        (
            "normals of joints of 1e-15",
            {
                // Only normals are so: the ball keeps its size by a morph target.
                let scale = 1e-15_f32;
                with(Mat4::from_scale(Vec3::splat(scale)), |d| {
                    d.pose.object_from_bind[0] = d.pose.object_from_bind[1];
                    d.targets[0].positions.iter_mut().for_each(|p| *p *= 1e15);
                    d.targets[0].normals.clear();
                    d.pose.weights[0] = 1.0;
                })
            },
            LIKE_THE_TRUTH,
            Some(Answer::Mended),
            "cofactors are of rows as long as 1, whatever the joints' size",
        ),
        near("a turn of 170 degrees between joints", turned(170.0 * PI / 180.0)),
        near("a half turn between joints", turned(PI)),
        near("weights that add up to 1e-30", weights(1e-30)),
        near("weights that add up to 1e30", weights(1e30)),
        near("weights that add up to 3", weights(3.0)),
        near("1 km from the origin", far(1e3)),
        (
            "morph targets of 100 that cancel",
            with(Mat4::IDENTITY, |d| d.pose.weights = vec![100.0, 100.0]),
            CANCELLED,
            None,
            "give targets that need not cancel",
        ),
    ]
}

fn posing(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let size = lab.pick([64, 36], [320, 180]);
    let mut findings = Findings::default();
    let mut pictured = 0.0;
    for (method, scene, bound, answer, remedy) in flaws() {
        let options = exact(size);
        let (picture, truth) =
            (bench.picture(&scene, options.clone(), 0.0)?, bench.truth(&scene, &options, 0.0));
        let found = difference(&truth, &picture, FLOOR)?;
        if found.worst > pictured {
            pictured = found.worst;
            let caption = format!("{method}: drawn, true, and the difference (white: {})", short(pictured));
            let picture = side_by_side(&truth.frame, &picture, FLOOR, pictured.min(1e9))?;
            findings.figures = vec![Figure::picture("worst", caption, picture)];
        }
        findings.cases.push(Case {
            method: method.into(),
            worst: found.worst,
            at: found.place(),
            bound,
            answer,
            remedy: remedy.into(),
        });
    }
    Ok(findings)
}

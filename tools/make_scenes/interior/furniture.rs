//! What stands, hangs and lies in the hall: 32 instances.

use super::super::glb::{Glb, Pose};
use super::super::mesh::{Mesh, Vertex};
use super::super::noise::pick;
use super::super::shape::{circle, cuboid, lathe, tube};
use super::palette::Palette;
use super::{GENERATORS_M, HEIGHT_M, LAMP_HEIGHT_M, POINTS_M, SPOTS_M, inward, part};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::FRAC_1_SQRT_2;

/// Turns +Y into +Z.
const LYING: Quat = Quat::from_xyzw(FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2);

/// 2 generators, 4 pipes, 7 crates, 4 barrels, 2 consoles with their screens, 3 lamps with their bulbs, 5 fixtures.
pub fn build(glb: &mut Glb, palette: &Palette) {
    let machine = part(glb, "generator", &generator(), palette.casing);
    for [x_m, z_m] in GENERATORS_M {
        glb.place("generator", machine, Pose::at(x_m, 0.0, z_m));
    }
    pipes(glb, palette);
    let crate_mesh = part(glb, "crate", &crate_shape(), palette.wood);
    for (i, [x_m, y_m, z_m, edge_m]) in [
        [5.6, 0.0, 4.3, 1.0],
        [6.75, 0.0, 4.5, 0.85],
        [5.75, 1.0, 4.4, 0.75],
        [6.6, 0.0, 3.2, 0.7],
        [-6.6, 0.0, 1.3, 1.1],
        [-6.75, 0.0, 0.1, 0.8],
        [-6.7, 1.1, 1.2, 0.65],
    ]
    .into_iter()
    .enumerate()
    {
        let pose = Pose::at(x_m, y_m + edge_m / 2.0, z_m).turned(0.08 * (pick(i, 201) - 0.5));
        glb.place("crate", crate_mesh, pose.scaled(edge_m, edge_m, edge_m));
    }
    let barrel = part(glb, "barrel", &barrel(), palette.casing);
    for (i, [x_m, z_m]) in [[-0.35, 4.9], [0.42, 5.15], [0.05, 4.2], [3.1, 1.9]].into_iter().enumerate() {
        glb.place("barrel", barrel, Pose::at(x_m, 0.0, z_m).turned(pick(i, 202)));
    }
    let [desk, screen] = [("console", console(), palette.steel), ("screen", screen(), palette.screen)]
        .map(|(name, shape, material)| part(glb, name, &shape, material));
    for (x_m, z_m, turns) in [(-4.9, -4.9, 0.02), (4.9, -4.9, -0.02)] {
        glb.place("console", desk, Pose::at(x_m, 0.0, z_m).turned(turns));
        glb.place("screen", screen, Pose::at(x_m, 0.0, z_m).turned(turns));
    }
    let [shade, bulb] = [("shade", shade(), palette.steel), ("bulb", bulb(), palette.lamp)]
        .map(|(name, shape, material)| part(glb, name, &shape, material));
    for [x_m, z_m] in SPOTS_M {
        glb.place("shade", shade, Pose::at(x_m, LAMP_HEIGHT_M, z_m));
        glb.place("bulb", bulb, Pose::at(x_m, LAMP_HEIGHT_M, z_m));
    }
    let tube_light = part(glb, "fixture", &cuboid(Vec3::new(1.1, 0.12, 0.12), 0.03), palette.fixture);
    for at in POINTS_M {
        // Its back to the wall.
        let turns = if inward(at).x == 0.0 { 0.0 } else { 0.25 };
        glb.place("fixture", tube_light, Pose::at(at[0], at[1], at[2]).turned(turns));
    }
}

fn pipes(glb: &mut Glb, palette: &Palette) {
    // A quarter circle between two straight runs.
    let bend = |corner: Vec3, from: Vec3, to: Vec3, radius_m: f32| {
        (0..=6).map(move |i| {
            let turn = circle(i as f32 / 24.0);
            corner - from * radius_m * (1.0 - turn.y) + to * radius_m * (1.0 - turn.x)
        })
    };
    let along_wall = |height_m: f32, z_m: f32| {
        let mut path = vec![Vec3::new(-8.0, height_m, z_m)];
        path.extend(bend(Vec3::new(6.6, height_m, z_m), Vec3::X, Vec3::NEG_Y, 0.35));
        path.push(Vec3::new(6.6, 0.0, z_m));
        path
    };
    let from_machine = |x_m: f32| {
        let corner = Vec3::new(x_m, 3.3, -1.6);
        let mut path = vec![Vec3::new(x_m, 1.9, -1.6)];
        path.extend(bend(corner, Vec3::Y, Vec3::NEG_Z, 0.5));
        path.push(Vec3::new(x_m, 3.3, -6.0));
        path
    };
    for (path, radius_m) in [
        (along_wall(4.3, -5.75), 0.14),
        (along_wall(3.95, -5.8), 0.08),
        (from_machine(GENERATORS_M[0][0]), 0.2),
        (from_machine(GENERATORS_M[1][0]), 0.2),
    ] {
        let mesh = part(glb, "pipe", &tube(&path, radius_m, 20), palette.steel);
        glb.place("pipe", mesh, Pose::origin());
    }
}

/// A lying drum with flanges on a base, a vent on top.
fn generator() -> Mesh {
    let half = [
        (0.0, -1.45),
        (0.34, -1.45),
        (0.4, -1.4),
        (0.42, -1.2),
        (0.82, -1.2),
        (0.9, -1.12),
        (0.9, -0.72),
        (1.0, -0.7),
        (1.0, -0.52),
        (0.9, -0.5),
    ];
    let mirrored = half.iter().rev().map(|&(radius, height)| (radius, -height));
    let profile: Vec<Vec2> = half.iter().copied().chain(mirrored).map(Vec2::from).collect();
    let drum = lathe(&profile, 40, 5.5).transformed(Affine3A::from_quat(LYING)).at(0.0, 1.25, 0.0);
    Mesh::merged([
        drum,
        cuboid(Vec3::new(2.1, 0.3, 2.7), 0.03).at(0.0, 0.15, 0.0),
        cuboid(Vec3::new(1.5, 0.5, 0.22), 0.02).at(0.0, 0.5, 0.85),
        cuboid(Vec3::new(1.5, 0.5, 0.22), 0.02).at(0.0, 0.5, -0.85),
        cuboid(Vec3::new(0.75, 0.4, 0.75), 0.04).at(0.0, 2.2, 0.0),
    ])
}

/// A metre each way; its texture shows one side of a crate.
fn crate_shape() -> Mesh {
    let mut mesh = cuboid(Vec3::ONE, 0.015);
    mesh.texcoords.iter_mut().for_each(|t| *t += 0.5);
    mesh
}

fn barrel() -> Mesh {
    let profile = [
        (0.0, 0.0),
        (0.27, 0.0),
        (0.29, 0.02),
        (0.29, 0.28),
        (0.305, 0.3),
        (0.29, 0.32),
        (0.29, 0.58),
        (0.305, 0.6),
        (0.29, 0.62),
        (0.29, 0.88),
        (0.27, 0.9),
        (0.27, 0.87),
        (0.0, 0.87),
    ];
    lathe(&profile.map(Vec2::from), 32, 2.0)
}

/// How a console's screen leans.
fn leaning() -> Affine3A {
    let half = circle(-0.04);
    Affine3A::from_rotation_translation(
        Quat::from_xyzw(half.y, 0.0, 0.0, half.x),
        Vec3::new(0.0, 1.32, -0.05),
    )
}

fn console() -> Mesh {
    Mesh::merged([
        cuboid(Vec3::new(1.5, 0.85, 0.7), 0.03).at(0.0, 0.425, 0.0),
        cuboid(Vec3::new(1.6, 0.06, 0.95), 0.02).at(0.0, 0.88, 0.08),
        cuboid(Vec3::new(1.4, 0.8, 0.12), 0.03).transformed(leaning()),
    ])
}

/// One picture on the console's front.
fn screen() -> Mesh {
    Mesh::patch(1, 1, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * 1.26, (v - 0.5) * 0.66, 0.064),
        normal: Vec3::Z,
        texcoord: Vec2::new(u, 1.0 - v),
    })
    .transformed(leaning())
}

/// A reflector and the rod that it hangs from; open below, at y = 0.
fn shade() -> Mesh {
    let top_m = HEIGHT_M - LAMP_HEIGHT_M;
    let profile = [
        (0.33, 0.0),
        (0.34, 0.0),
        (0.3, 0.1),
        (0.12, 0.26),
        (0.05, 0.3),
        (0.02, 0.32),
        (0.02, top_m),
        (0.0, top_m),
    ];
    let inside = [(0.0, 0.28), (0.11, 0.25), (0.29, 0.09), (0.33, 0.0)];
    Mesh::merged([
        lathe(&profile.map(Vec2::from), 32, 2.0),
        // Downward, so that it faces inward.
        lathe(&inside.map(Vec2::from), 32, 2.0),
    ])
}

fn bulb() -> Mesh {
    const STEPS: usize = 12;
    // The right half of a circle, from its lowest point to its highest.
    let profile: Vec<_> = (0..=STEPS)
        .map(|i| Vec2::new(0.0, 0.16) + 0.085 * circle(0.5 * i as f32 / STEPS as f32 - 0.25))
        .map(|p| Vec2::new(p.x.max(0.0), p.y))
        .collect();
    lathe(&profile, 24, 0.5)
}

/// Front at z = 0, facing +z; on the floor.
pub fn wall_panel(width_m: f32, height_m: f32) -> Mesh {
    cuboid(Vec3::new(width_m, height_m, 0.2), 0.012).at(0.0, height_m / 2.0, -0.1)
}

/// A frame with two leaves, facing +z.
pub fn door() -> Mesh {
    let leaf = |x_m: f32| cuboid(Vec3::new(1.08, 2.7, 0.1), 0.04).at(x_m, 1.38, 0.0);
    let post = |x_m: f32| cuboid(Vec3::new(0.28, 3.1, 0.34), 0.04).at(x_m, 1.55, 0.06);
    Mesh::merged([
        leaf(-0.55),
        leaf(0.55),
        post(-1.24),
        post(1.24),
        cuboid(Vec3::new(2.76, 0.32, 0.38), 0.04).at(0.0, 2.96, 0.06),
        cuboid(Vec3::new(2.3, 0.14, 0.16), 0.04).at(0.0, 1.4, 0.04),
    ])
}

/// A beam of I section, upright.
pub fn column(height_m: f32) -> Mesh {
    let middle_m = height_m / 2.0;
    Mesh::merged([
        cuboid(Vec3::new(0.06, height_m, 0.3), 0.01).at(0.0, middle_m, 0.0),
        cuboid(Vec3::new(0.36, height_m, 0.05), 0.012).at(0.0, middle_m, 0.17),
        cuboid(Vec3::new(0.36, height_m, 0.05), 0.012).at(0.0, middle_m, -0.17),
        cuboid(Vec3::new(0.5, 0.16, 0.5), 0.03).at(0.0, 0.08, 0.0),
    ])
}

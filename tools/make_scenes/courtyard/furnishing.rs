//! Lanterns, festoons, banners, the shop, plants: what makes the courtyard lived in.

use super::super::glb::{Glb, Pose};
use super::super::mesh::{Mesh, Vertex};
use super::super::noise::{pick, smoothstep};
use super::super::shape::{circle, cuboid, lathe, round_profile, sphere, tube};
use super::super::texture::linear;
use super::palette::Palette;
use super::{FESTOONS, Festoon, LANTERNS_M, POSTS_M, SHOP_Z_M};
use glam::{Affine3A, Vec2, Vec3};

use super::architecture::{ARCADE_X_M, BAY_M, PORTAL_Z_M, SPRING_M, TERRACE_M};

/// Puts everything in its place.
pub fn build(glb: &mut Glb, palette: &Palette) {
    lanterns(glb, palette);
    festoons(glb, palette);
    banners(glb, palette);
    shop(glb, palette);
    plants(glb, palette);
}

pub fn points(profile: &[(f32, f32)]) -> Vec<Vec2> {
    profile.iter().copied().map(Vec2::from).collect()
}

fn lanterns(glb: &mut Glb, palette: &Palette) {
    // A six-sided lantern about its flame; it hangs from its ring.
    let glass = lathe(&points(&[(0.0, -0.2), (0.085, -0.2), (0.13, 0.16), (0.0, 0.16)]), 6, 1.0).faceted();
    let mut cage = vec![
        lathe(
            &points(&[(0.15, 0.15), (0.17, 0.165), (0.1, 0.24), (0.06, 0.3), (0.03, 0.31), (0.0, 0.36)]),
            6,
            1.0,
        )
        .faceted(),
        lathe(
            &points(&[
                (0.0, -0.29),
                (0.02, -0.27),
                (0.03, -0.24),
                (0.1, -0.215),
                (0.105, -0.19),
                (0.08, -0.19),
            ]),
            6,
            1.0,
        )
        .faceted(),
        lathe(&round_profile(Vec2::new(0.04, 0.0), 0.008, 6), 12, 0.25)
            .transformed(Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2))
            .at(0.0, 0.39, 0.0),
    ];
    for i in 0..6 {
        let around = circle(i as f32 / 6.0);
        let corner =
            |radius_m: f32, height_m: f32| Vec3::new(around.x * radius_m, height_m, -around.y * radius_m);
        cage.push(tube(&[corner(0.092, -0.2), corner(0.14, 0.16)], 0.009, 5));
    }
    let (glass, cage) = (glb.geometry(&glass.untextured()), glb.geometry(&Mesh::merged(cage)));
    let lantern = glb.mesh("lantern", &[(&glass, palette.lantern_glass), (&cage, palette.iron)]);
    let chain = Mesh::merged((0..7).map(|i| {
        let link = lathe(&round_profile(Vec2::new(0.026, 0.0), 0.006, 4), 6, 0.25);
        let upright = Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2 * (i % 2) as f32)
            * Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
        link.transformed(upright).at(0.0, 0.44 + 0.045 * i as f32, 0.0)
    }));
    let chain = glb.geometry(&chain);
    let chain = glb.mesh("chain", &[(&chain, palette.iron)]);
    for (i, position_m) in LANTERNS_M.into_iter().enumerate() {
        let pose = Pose { position_m, ..Pose::origin() };
        let parts =
            [glb.place("lantern", lantern, Pose::origin()), glb.place("chain", chain, Pose::origin())];
        glb.group(&format!("hanging lantern {i}"), &parts, pose.turned(pick(i, 131)));
    }
    let post = Mesh::merged([
        lathe(
            &points(&[
                (0.2, 0.0),
                (0.2, 0.08),
                (0.16, 0.12),
                (0.1, 0.2),
                (0.06, 0.34),
                (0.045, 0.4),
                (0.04, 1.5),
                (0.055, 1.53),
                (0.055, 1.57),
                (0.035, 1.6),
                (0.03, 2.05),
                (0.07, 2.1),
                (0.09, 2.12),
                (0.0, 2.14),
            ]),
            16,
            1.0,
        ),
        lathe(&round_profile(Vec2::new(0.05, 0.9), 0.018, 8), 16, 0.5),
    ]);
    let post = glb.geometry(&post);
    let post = glb.mesh("post", &[(&post, palette.iron)]);
    for (i, [x_m, z_m]) in POSTS_M.into_iter().enumerate() {
        let parts = [
            glb.place("post", post, Pose::origin()),
            glb.place("lantern", lantern, Pose::at(0.0, 2.42, 0.0)),
        ];
        glb.group(&format!("lantern post {i}"), &parts, Pose::at(x_m, 0.0, z_m));
    }
}

fn festoons(glb: &mut Glb, palette: &Palette) {
    let bulb = lathe(
        &points(&[(0.0, -0.085), (0.03, -0.078), (0.05, -0.05), (0.053, -0.03), (0.04, 0.01), (0.024, 0.03)]),
        12,
        1.0,
    );
    let socket = lathe(&points(&[(0.026, 0.02), (0.03, 0.03), (0.026, 0.07), (0.0, 0.085)]), 10, 0.25);
    let (bulb, socket) = (glb.geometry(&bulb.untextured()), glb.geometry(&socket));
    let bulbs = palette.bulbs.map(|glass| glb.mesh("bulb", &[(&bulb, glass), (&socket, palette.iron)]));
    for (i, festoon) in FESTOONS.iter().enumerate() {
        let path: Vec<Vec3> = (0..=32).map(|k| festoon.point_m(k as f32 / 32.0)).collect();
        let cable = glb.geometry(&tube(&path, 0.008, 4));
        let cable = glb.mesh("festoon cable", &[(&cable, palette.iron)]);
        let mut parts = vec![glb.place("cable", cable, Pose::origin())];
        for k in 0..Festoon::BULBS {
            let p = festoon.bulb_m(k);
            parts.push(glb.place("bulb", bulbs[festoon.color(k)], Pose::at(p.x, p.y - 0.075, p.z)));
        }
        glb.group(&format!("festoon {i}"), &parts, Pose::origin());
    }
}

/// A strip of hanging cloth, 1 m wide and `length_m` long from y = 0 down, in folds; pointed at its end.
fn hanging(length_m: f32, phase: f32) -> Mesh {
    Mesh::smooth_patch(16, 20, |u, v| {
        let down = 1.0 - v;
        let fold = (u * 15.0 + phase + 0.8 * down).sin() * (0.3 + 0.7 * down) * 0.035;
        let sway = 0.05 * down * (down * 4.0 + phase).sin();
        let point = 0.22 * (1.0 - (2.0 * u - 1.0).abs()) * smoothstep(0.7, 1.0, down);
        let position = Vec3::new(u - 0.5, -(down * (length_m - 0.22) + point), fold + sway);
        (position, Vec2::new(u, down))
    })
}

fn banners(glb: &mut Glb, palette: &Palette) {
    let cloth = [hanging(2.25, 0.0), hanging(2.25, 2.0)].map(|cloth| glb.geometry(&cloth.with_tangents()));
    let rod = Mesh::merged([
        tube(&[Vec3::new(-0.58, 0.0, 0.0), Vec3::new(0.58, 0.0, 0.0)], 0.018, 8),
        sphere(0.04, 8, 6).at(-0.6, 0.0, 0.0),
        sphere(0.04, 8, 6).at(0.6, 0.0, 0.0),
    ]);
    let rod = glb.geometry(&rod);
    let banner =
        [0, 1].map(|i| glb.mesh("banner", &[(&cloth[i], palette.banners[i]), (&rod, palette.bronze)]));
    for side in [-1.0_f32, 1.0] {
        for (i, z_m) in [-4.8, -1.6, 1.6, 4.8].into_iter().enumerate() {
            let turns = -0.25 * side;
            let which = (i + usize::from(side > 0.0)) % 2;
            let pose = Pose::at(side * (ARCADE_X_M - 0.6), TERRACE_M - 0.12, z_m).turned(turns);
            glb.place(&format!("arcade banner {i}"), banner[which], pose.scaled(0.78, 0.78, 0.78));
        }
        for (i, x_m) in [2.85_f32, 4.35].into_iter().enumerate() {
            let pose = Pose::at(side * x_m, TERRACE_M - 0.35, PORTAL_Z_M + 0.22);
            glb.place(&format!("portal banner {i}"), banner[i], pose.scaled(1.05, 1.35, 1.0));
        }
    }
}

/// An awning over a bay of the west arcade, and a table of copper vessels under it.
fn shop(glb: &mut Glb, palette: &Palette) {
    const STRIPES: usize = 12;
    let (width_m, reach_m) = (BAY_M - 0.3, 1.7);
    let (cream, red) = (linear(0xe6d8b8), linear(0xa8382c));
    let stripe = |i: usize| {
        let cloth = Mesh::smooth_patch(4, 16, |u, v| {
            let x = (i as f32 + u) / STRIPES as f32;
            let out = 1.0 - v;
            let slope = (out / 0.88).min(1.0);
            let sag = 0.1 * (slope * std::f32::consts::PI).sin() * (0.6 + 0.4 * (x * 18.85).cos());
            // Below the front edge hangs a valance of scallops.
            let valance = (out - 0.88).max(0.0) / 0.12 * (0.2 + 0.1 * (u * std::f32::consts::PI).sin());
            let position = Vec3::new((x - 0.5) * width_m, -0.75 * slope - sag - valance, slope * reach_m);
            (position, Vec2::new(position.x, out * 2.0) / 1.5)
        });
        cloth.colored(move |_, _| if i.is_multiple_of(2) { cream } else { red })
    };
    let canvas = Mesh::merged((0..STRIPES).map(stripe));
    let pole = |side: f32| {
        let x_m = side * (width_m / 2.0 - 0.04);
        tube(&[Vec3::new(x_m, -0.04, 0.0), Vec3::new(x_m, -0.78, reach_m - 0.02)], 0.016, 8)
    };
    let bar = tube(
        &[Vec3::new(-width_m / 2.0, -0.77, reach_m - 0.03), Vec3::new(width_m / 2.0, -0.77, reach_m - 0.03)],
        0.016,
        8,
    );
    let poles = Mesh::merged([pole(-1.0), pole(1.0), bar]);
    let (canvas, poles) = (glb.geometry(&canvas), glb.geometry(&poles));
    let awning = glb.mesh("awning", &[(&canvas, palette.awning), (&poles, palette.iron)]);
    let front_x_m = -ARCADE_X_M + 0.3;
    glb.place("awning", awning, Pose::at(front_x_m, SPRING_M + 0.35, SHOP_Z_M).turned(0.25));

    let board = |x: f32, y: f32, z: f32, size: [f32; 3]| cuboid(Vec3::from(size), 0.012).at(x, y, z);
    let mut table = vec![board(0.0, 0.86, 0.0, [2.2, 0.06, 0.8]), board(0.0, 0.3, 0.0, [1.9, 0.04, 0.6])];
    for (x_m, z_m) in [(-1.0, -0.3), (1.0, -0.3), (-1.0, 0.3), (1.0, 0.3)] {
        table.push(board(x_m, 0.42, z_m, [0.09, 0.84, 0.09]));
    }
    for (x_m, y_m, turn_rad) in [(1.75, 0.26, 0.3), (1.7, 0.76, -0.1), (-1.7, 0.26, 0.15)] {
        let crate_box =
            cuboid(Vec3::new(0.56, 0.48, 0.5), 0.02).transformed(Affine3A::from_rotation_y(turn_rad));
        table.push(crate_box.at(x_m, y_m, 0.1));
    }
    let table = glb.geometry(&Mesh::merged(table));
    let table = glb.mesh("table", &[(&table, palette.wood)]);
    let vase = points(&[
        (0.0, 0.0),
        (0.07, 0.0),
        (0.08, 0.015),
        (0.06, 0.04),
        (0.1, 0.1),
        (0.135, 0.18),
        (0.12, 0.26),
        (0.06, 0.33),
        (0.05, 0.37),
        (0.08, 0.41),
        (0.07, 0.41),
        (0.04, 0.36),
    ]);
    let bowl = points(&[
        (0.0, 0.0),
        (0.06, 0.0),
        (0.06, 0.015),
        (0.12, 0.06),
        (0.18, 0.13),
        (0.19, 0.14),
        (0.17, 0.13),
        (0.1, 0.06),
        (0.0, 0.03),
    ]);
    let (vase, bowl) = (glb.geometry(&lathe(&vase, 32, 1.0)), glb.geometry(&lathe(&bowl, 32, 1.0)));
    let copper_vase = glb.mesh("copper vase", &[(&vase, palette.copper)]);
    let clay_vase = glb.mesh("clay vase", &[(&vase, palette.terracotta)]);
    let bronze_bowl = glb.mesh("bronze bowl", &[(&bowl, palette.bronze)]);
    let copper_bowl = glb.mesh("copper bowl", &[(&bowl, palette.copper)]);
    let mut parts = vec![glb.place("table", table, Pose::origin())];
    let wares = [
        (copper_vase, -0.85, 0.05, 1.0),
        (bronze_bowl, -0.45, -0.1, 1.0),
        (clay_vase, -0.1, 0.12, 0.8),
        (copper_bowl, 0.3, 0.0, 0.8),
        (copper_vase, 0.62, -0.14, 1.25),
        (clay_vase, 0.9, 0.14, 1.0),
    ];
    for (mesh, x_m, z_m, scale) in wares {
        let pose = Pose::at(x_m, 0.89, z_m).scaled(scale, scale, scale);
        parts.push(glb.place("ware", mesh, pose));
    }
    glb.group("shop", &parts, Pose::at(front_x_m + 0.75, 0.0, SHOP_Z_M).turned(0.25));
}

/// Terracotta urns with bushes of leaf cards.
fn plants(glb: &mut Glb, palette: &Palette) {
    let urn = lathe(
        &points(&[
            (0.24, 0.0),
            (0.25, 0.05),
            (0.22, 0.08),
            (0.26, 0.2),
            (0.33, 0.38),
            (0.36, 0.52),
            (0.34, 0.58),
            (0.39, 0.62),
            (0.4, 0.66),
            (0.36, 0.67),
            (0.32, 0.6),
            (0.0, 0.58),
        ]),
        32,
        2.0,
    );
    const BUSH_CARDS: usize = 150;
    let bush = Mesh::merged((0..BUSH_CARDS).map(|i| {
        // A spiral of directions over most of the sphere.
        let height = 0.95 - 1.5 * (i as f32 + 0.5) / BUSH_CARDS as f32;
        let around = circle(i as f32 * 0.381_966);
        let out = Vec3::new(around.x, 0.0, around.y) * (1.0 - height * height).sqrt() + Vec3::Y * height;
        let size_m = 0.3 + 0.14 * pick(i, 141);
        let lift = (out + Vec3::Y * 0.5).normalize();
        let side = lift.cross(Vec3::Y).normalize();
        let (side, front) = (side * size_m * 0.5, lift.cross(side.normalize()));
        let stem = out * (0.16 + 0.22 * pick(i, 142)) + Vec3::Y * 1.05;
        Mesh::patch(1, 3, |u, v| {
            let droop = front * (0.15 * v * v * size_m);
            let position = stem + side * (2.0 * u - 1.0) + lift * (v * size_m) - droop;
            // Normals bend outward from the bush's middle, so that it shades as one soft mass.
            let normal = (out + lift * (v - 0.3)).normalize();
            Vertex { position, normal, texcoord: Vec2::new(u, 1.0 - v) }
        })
    }));
    let bush = bush.colored(|p, _| Vec3::splat(smoothstep(0.0, 0.62, (p - Vec3::Y * 1.05).length())));
    let (urn, bush) = (glb.geometry(&urn), glb.geometry(&bush));
    let plant = glb.mesh("potted plant", &[(&urn, palette.terracotta), (&bush, palette.leaves)]);
    let places =
        [(-2.35, -7.1, 1.0), (2.35, -7.1, 1.0), (4.3, -1.6, 0.95), (-4.35, -7.1, 0.9), (4.35, -7.1, 0.9)];
    for (i, (x_m, z_m, scale)) in places.into_iter().enumerate() {
        let pose = Pose::at(x_m, 0.0, z_m).turned(pick(i, 143)).scaled(scale, scale, scale);
        glb.place(&format!("potted plant {i}"), plant, pose);
    }
}

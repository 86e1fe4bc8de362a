//! Fountain, armillary sphere, lanterns, banners, the shop, plants: what makes the courtyard lived in.

use super::super::glb::{Glb, Pose};
use super::super::mesh::{Mesh, planar_texcoord};
use super::super::noise::{pick, smoothstep};
use super::super::shape::{circle, cuboid, lathe, ring_profile, round_profile, sphere, tube};
use super::super::texture::linear;
use super::palette::Palette;
use super::{FESTOONS, FOUNTAIN, Festoon, LANTERNS_M, POSTS_M, SHOP_Z_M};
use glam::{Affine3A, Quat, Vec2, Vec3};

use super::architecture::{ARCADE_X_M, BAY_M, PORTAL_Z_M, SPRING_M, TERRACE_M};

/// Puts everything in its place.
pub fn build(glb: &mut Glb, palette: &Palette) {
    fountain(glb, palette);
    armillary(glb, palette);
    lanterns(glb, palette);
    festoons(glb, palette);
    banners(glb, palette);
    shop(glb, palette);
}

pub fn points(profile: &[(f32, f32)]) -> Vec<Vec2> {
    profile.iter().copied().map(Vec2::from).collect()
}

fn fountain(glb: &mut Glb, palette: &Palette) {
    let basin = points(&[
        (1.62, 0.28),
        (1.66, 0.3),
        (1.7, 0.36),
        (1.66, 0.42),
        (1.58, 0.46),
        (1.55, 0.56),
        (1.58, 0.72),
        (1.68, 0.86),
        (1.8, 0.93),
        (1.84, 0.98),
        (1.84, 1.03),
        (1.8, 1.07),
        (1.62, 1.07),
        (1.58, 1.04),
        (1.55, 0.98),
        (1.5, 0.7),
    ]);
    let pedestal = points(&[
        (0.5, 0.7),
        (0.5, 1.0),
        (0.46, 1.05),
        (0.34, 1.1),
        (0.26, 1.2),
        (0.22, 1.35),
        (0.24, 1.46),
        (0.3, 1.52),
        (0.5, 1.6),
        (0.72, 1.72),
        (0.78, 1.8),
        (0.77, 1.84),
        (0.7, 1.84),
        (0.5, 1.76),
        (0.24, 1.74),
        (0.2, 1.8),
        (0.16, 1.95),
        (0.2, 2.02),
        (0.24, 2.06),
        (0.22, 2.1),
        (0.0, 2.12),
    ]);
    // The basin's rim bulges in sixteen lobes.
    let mut basin = lathe(&basin, 96, 10.0);
    for p in &mut basin.positions {
        let lobe = 0.5 + 0.5 * (p.z.atan2(p.x) * 16.0).cos();
        let bulge = 1.0 + 0.018 * lobe * smoothstep(0.5, 0.8, p.y);
        *p *= Vec3::new(bulge, 1.0, bulge);
    }
    let stone = Mesh::merged([basin, lathe(&pedestal, 48, 3.0)])
        .colored(|p, _| Vec3::splat(0.62 + 0.38 * smoothstep(0.2, 0.9, p.y)));
    let disc = |radius_m: f32, height_m: f32| {
        let mut disc = lathe(&[Vec2::new(radius_m, height_m), Vec2::new(0.02, height_m)], 48, 1.0);
        disc.texcoords = disc.positions.iter().map(|p| planar_texcoord(*p, Vec3::Y)).collect();
        disc
    };
    let water = Mesh::merged([disc(1.56, 0.95), disc(0.71, 1.82)]);
    let (stone, water) = (glb.geometry(&stone), glb.geometry(&water.with_tangents()));
    let mesh = glb.mesh("fountain", &[(&stone, palette.limestone), (&water, palette.water)]);
    glb.place("fountain", mesh, FOUNTAIN);
}

/// Nested bronze rings about a copper sun, pierced by an iron axis with an arrow's head.
fn armillary(glb: &mut Glb, palette: &Palette) {
    let ring = |radius_m: f32, width_m: f32, thick_m: f32, tilt: Quat| {
        let profile = ring_profile(radius_m - thick_m..radius_m, -width_m / 2.0..width_m / 2.0);
        lathe(&profile, 80, (radius_m * 12.0).round() / 2.0).transformed(Affine3A::from_quat(tilt))
    };
    let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let axis_tilt = Quat::from_rotation_z(-0.42);
    let turned = |angle_rad: f32| axis_tilt * Quat::from_rotation_y(angle_rad) * upright;
    let mut rings = vec![
        ring(0.88, 0.07, 0.04, upright),
        ring(0.83, 0.06, 0.035, turned(0.75)),
        ring(0.79, 0.05, 0.03, turned(2.1)),
        ring(0.82, 0.09, 0.03, axis_tilt),
        ring(0.74, 0.14, 0.02, axis_tilt * Quat::from_rotation_x(0.41)),
        ring(0.56, 0.04, 0.03, axis_tilt * Quat::from_rotation_x(-0.9)),
    ];
    for side in [-1.0, 1.0] {
        let tropic = ring(0.72, 0.035, 0.025, Quat::IDENTITY).at(0.0, 0.36 * side, 0.0);
        rings.push(tropic.transformed(Affine3A::from_quat(axis_tilt)));
    }
    // Hour marks on the equator.
    for i in 0..24 {
        let angle_rad = i as f32 / 24.0 * std::f32::consts::TAU;
        let mark = cuboid(Vec3::new(0.03, 0.12, 0.02), 0.004).at(0.83, 0.0, 0.0);
        rings.push(mark.transformed(Affine3A::from_quat(axis_tilt * Quat::from_rotation_y(angle_rad))));
    }
    let stand =
        points(&[(0.2, -1.06), (0.14, -1.02), (0.07, -0.98), (0.06, -0.93), (0.1, -0.9), (0.0, -0.86)]);
    rings.push(lathe(&stand, 24, 0.5));
    let axis = Mesh::merged([
        tube(&[Vec3::NEG_Y * 1.12, Vec3::Y * 1.05], 0.018, 10),
        lathe(&points(&[(0.0, 1.02), (0.07, 1.03), (0.0, 1.3)]), 12, 0.5),
        lathe(&points(&[(0.0, -1.2), (0.045, -1.15), (0.045, -1.1), (0.0, -1.05)]), 12, 0.5),
    ])
    .transformed(Affine3A::from_quat(axis_tilt));
    let planets = [(0.74, 0.1, 0.05), (0.56, 2.2, 0.06), (0.74, 3.9, 0.045)].map(
        |(orbit_m, angle_rad, radius_m): (f32, f32, f32)| {
            let place = Affine3A::from_quat(axis_tilt * Quat::from_rotation_y(angle_rad))
                * Affine3A::from_translation(Vec3::X * orbit_m);
            sphere(radius_m, 16, 10).transformed(place)
        },
    );
    let sun = Mesh::merged([sphere(0.21, 40, 24)].into_iter().chain(planets));
    let parts = [(Mesh::merged(rings), palette.bronze), (axis, palette.iron), (sun, palette.copper)];
    let parts = parts.map(|(mesh, material)| (glb.geometry(&mesh), material));
    let mesh = glb.mesh("armillary", &parts.each_ref().map(|(geometry, material)| (geometry, *material)));
    let pose = Pose { position_m: FOUNTAIN.position_m + Vec3::Y * 3.12, ..Pose::origin().turned(0.06) };
    glb.place("armillary", mesh, pose);
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
        let link = lathe(&round_profile(Vec2::new(0.026, 0.0), 0.006, 5), 10, 0.25);
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
    Mesh::smooth_patch(20, 30, |u, v| {
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
        sphere(0.04, 12, 8).at(-0.6, 0.0, 0.0),
        sphere(0.04, 12, 8).at(0.6, 0.0, 0.0),
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

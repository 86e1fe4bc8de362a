//! Floor, arcades, walls and what stands beyond them.

use super::super::glb::{Glb, Pose};
use super::super::mesh::{Mesh, Vertex};
use super::super::noise::{fractal, smoothstep};
use super::super::shape::{
    arch_wall, archivolt, circle, cuboid, flipped_if_inward, lathe, moulding, ring_profile, sphere, tube,
};
use super::palette::Palette;
use glam::{IVec2, Vec2, Vec3};

/// From column to column.
pub const BAY_M: f32 = 3.2;
/// Columns' middle lines, left and right of the axis.
pub const ARCADE_X_M: f32 = 5.2;
/// Where arches spring.
pub const SPRING_M: f32 = 2.9;
/// Radius of the arcades' arches.
pub const ARCH_RADIUS_M: f32 = 1.26;
/// Top of the terrace above the arcades.
pub const TERRACE_M: f32 = 5.25;
/// Front face of the wall with the portal.
pub const PORTAL_Z_M: f32 = -7.98;
/// The middles of the arcades' bays.
pub const BAYS_Z_M: [f32; 5] = [-6.4, -3.2, 0.0, 3.2, 6.4];
/// From the columns' middle line to the wall behind.
const ARCADE_DEPTH_M: f32 = 2.6;
const OUTER_X_M: f32 = ARCADE_X_M + ARCADE_DEPTH_M;
/// Top of the walls behind the arcades.
const WALL_TOP_M: f32 = 7.6;
/// Top of the wall with the portal.
const PORTAL_TOP_M: f32 = 6.3;

/// Builds everything that does not move.
pub fn build(glb: &mut Glb, palette: &Palette) {
    floor(glb, palette);
    let meshes = [bay(glb, palette), railing(glb, palette), column(glb, palette)];
    let west = arcade(glb, meshes);
    glb.group("west", &west, Pose::at(-ARCADE_X_M, 0.0, 0.0).turned(0.25));
    // The east side is the west side's mirror image: a negative scale, as the arcade is not symmetric.
    let east = arcade(glb, meshes);
    let east = glb.group("east arcade", &east, Pose::at(-ARCADE_X_M, 0.0, 0.0).turned(0.25));
    glb.group("east", &[east], Pose::origin().scaled(-1.0, 1.0, 1.0));
    portal(glb, palette);
}

/// Dirt gathers where walls meet the ground: what vertex colours make of a height above it.
fn grime(height_m: f32) -> Vec3 {
    Vec3::new(0.5, 0.47, 0.42).lerp(Vec3::ONE, smoothstep(-0.1, 1.3, height_m))
}

fn floor(glb: &mut Glb, palette: &Palette) {
    let (width_m, depth_m, back_m) = (2.0 * OUTER_X_M, 24.8, -12.2);
    let court = Mesh::patch(24, 38, |u, v| {
        let position = Vec3::new((u - 0.5) * width_m, 0.0, back_m + (1.0 - v) * depth_m);
        Vertex { position, normal: Vec3::Y, texcoord: Vec2::new(position.x, position.z) }
    });
    let court = court.with_tangents().colored(|p, _| {
        let to_wall_m = (ARCADE_X_M + 0.2 - p.x.abs()).abs().min(p.z - PORTAL_Z_M);
        let stain = fractal(Vec2::new(p.x, p.z) / 16.0 + 0.5, IVec2::splat(5), 3, 101);
        Vec3::splat((0.6 + 0.4 * smoothstep(0.0, 1.2, to_wall_m)) * (1.0 + 0.15 * stain)).min(Vec3::ONE)
    });
    let court = glb.geometry(&court);
    let court = glb.mesh("court", &[(&court, palette.paving)]);
    glb.place("court", court, Pose::origin());
    // Two steps around the fountain.
    let step = |radius_m: f32, low_m: f32, high_m: f32| {
        let edge = 0.025;
        let profile = [
            (radius_m, low_m),
            (radius_m, high_m - edge),
            (radius_m - edge, high_m),
            (radius_m - 0.8, high_m),
        ];
        lathe(&profile.map(Vec2::from), 64, (radius_m * std::f32::consts::TAU).round())
    };
    let steps = Mesh::merged([step(3.0, 0.0, 0.14), step(2.55, 0.14, 0.28)]);
    let steps = glb.geometry(&steps.colored(|p, _| grime(p.y * 2.0 + 0.5)));
    let steps = glb.mesh("steps", &[(&steps, palette.limestone)]);
    glb.place("steps", steps, super::FOUNTAIN);
}

/// One side's five bays in its own frame: +Z towards the court, X along the arcade.
fn arcade(glb: &mut Glb, [bay, railing, column]: [usize; 3]) -> Vec<usize> {
    let mut nodes = Vec::new();
    for (i, z_m) in BAYS_Z_M.into_iter().enumerate() {
        let x_m = -z_m;
        nodes.push(glb.place(&format!("bay {i}"), bay, Pose::at(x_m, 0.0, 0.0)));
        nodes.push(glb.place(&format!("railing {i}"), railing, Pose::at(x_m, TERRACE_M, 0.42)));
        nodes.push(glb.place(&format!("column {i}"), column, Pose::at(x_m + BAY_M / 2.0, 0.0, 0.0)));
    }
    nodes.push(glb.place("column 5", column, Pose::at(-BAYS_Z_M[4] - BAY_M / 2.0, 0.0, 0.0)));
    nodes
}

fn bay(glb: &mut Glb, palette: &Palette) -> usize {
    let thickness_m = 0.5;
    let front = arch_wall(BAY_M, 4.95 - SPRING_M, ARCH_RADIUS_M, thickness_m, 22).at(0.0, SPRING_M, 0.0);
    let vault_radius_m = (ARCADE_DEPTH_M - thickness_m / 2.0) / 2.0;
    let vault_z_m = -thickness_m / 2.0 - vault_radius_m;
    let vault = flipped_if_inward(Mesh::patch(16, 4, |u, v| {
        let around = circle(0.5 * u);
        let position = Vec3::new((v - 0.5) * BAY_M, around.y * vault_radius_m, around.x * vault_radius_m);
        let texcoord = Vec2::new(u * vault_radius_m * std::f32::consts::PI, position.x);
        Vertex { position, normal: -Vec3::new(0.0, around.y, around.x), texcoord }
    }))
    .at(0.0, SPRING_M, vault_z_m)
    .colored(|_, n| Vec3::splat(0.8 + 0.2 * n.y));
    let wall_z_m = -ARCADE_DEPTH_M;
    let back = Mesh::patch(8, 12, |u, v| {
        let position = Vec3::new((u - 0.5) * BAY_M, v * WALL_TOP_M, wall_z_m);
        Vertex { position, normal: Vec3::Z, texcoord: Vec2::new(position.x, -position.y) }
    })
    .colored(|p, _| grime(p.y) * if p.y < TERRACE_M { 1.0 } else { 0.92 });
    let walls = Mesh::merged([front.colored(|_, _| Vec3::ONE), vault, back]);
    // Dressed stone: the arch's mouldings, cornice, string course, coping, ribs, plinth, window frame.
    let (r, f) = (ARCH_RADIUS_M, thickness_m / 2.0);
    let arch_profile = [
        (r + 0.26, f),
        (r + 0.26, f + 0.05),
        (r + 0.2, f + 0.07),
        (r + 0.18, f + 0.04),
        (r + 0.1, f + 0.04),
        (r + 0.08, f + 0.08),
        (r, f + 0.08),
        (r - 0.03, f + 0.04),
        (r - 0.03, f - 0.1),
    ]
    .map(Vec2::from);
    let cornice = [
        (f, 4.88),
        (f + 0.06, 4.92),
        (f + 0.06, 4.98),
        (f + 0.2, 5.1),
        (f + 0.2, 5.13),
        (f + 0.26, 5.16),
        (f + 0.26, TERRACE_M),
        (wall_z_m, TERRACE_M),
    ]
    .map(Vec2::from);
    let coping = [
        (wall_z_m, 7.4),
        (wall_z_m + 0.14, 7.5),
        (wall_z_m + 0.2, 7.58),
        (wall_z_m + 0.2, 7.7),
        (wall_z_m - 0.2, 7.7),
    ]
    .map(Vec2::from);
    let rib_radius_m = vault_radius_m - 0.1;
    let rib = Mesh::merged([archivolt(&ring_profile(rib_radius_m..vault_radius_m + 0.02, -0.16..0.16), 16)])
        .transformed(glam::Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2))
        .at(-BAY_M / 2.0, SPRING_M, vault_z_m);
    let pilaster = cuboid(Vec3::new(0.42, SPRING_M, 0.3), 0.02).at(-BAY_M / 2.0, SPRING_M / 2.0, wall_z_m);
    let cap = cuboid(Vec3::new(0.52, 0.14, 0.4), 0.03).at(-BAY_M / 2.0, SPRING_M - 0.07, wall_z_m);
    let keystone = cuboid(Vec3::new(0.24, 0.5, 0.22), 0.03).at(0.0, SPRING_M + r + 0.16, f + 0.02);
    let sill = cuboid(Vec3::new(1.1, 0.1, 0.24), 0.02).at(0.0, 5.78, wall_z_m + 0.08);
    let surround = archivolt(&ring_profile(0.36..0.5, -0.02..0.1), 16).at(0.0, 6.5, wall_z_m);
    let jamb = |x_m: f32| cuboid(Vec3::new(0.14, 0.7, 0.12), 0.015).at(x_m, 6.16, wall_z_m + 0.04);
    let mullion = cuboid(Vec3::new(0.05, 1.05, 0.06), 0.01).at(0.0, 6.33, wall_z_m + 0.04);
    let dressed = Mesh::merged([
        archivolt(&arch_profile, 22).at(0.0, SPRING_M, 0.0),
        moulding(&cornice, BAY_M),
        moulding(&coping, BAY_M),
        rib,
        pilaster,
        cap,
        keystone,
        sill,
        surround,
        jamb(-0.43),
        jamb(0.43),
        mullion,
    ])
    .colored(|p, _| if p.y < SPRING_M { grime(p.y) } else { Vec3::ONE });
    let pane = Mesh::merged([
        lathe(&[(0.36, 0.0), (0.0, 0.0)].map(Vec2::from), 24, 1.0)
            .transformed(glam::Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2))
            .at(0.0, 6.5, wall_z_m + 0.012),
        cuboid(Vec3::new(0.74, 0.7, 0.02), 0.0).at(0.0, 6.16, wall_z_m),
    ]);
    let parts = [(walls, palette.wall), (dressed, palette.limestone), (pane.untextured(), palette.window)];
    let parts = parts.map(|(mesh, material)| (glb.geometry(&mesh), material));
    glb.mesh("bay", &parts.each_ref().map(|(geometry, material)| (geometry, *material)))
}

/// A fluted column on a plinth, 2.9 m high.
fn column(glb: &mut Glb, palette: &Palette) -> usize {
    const FLUTES: f32 = 12.0;
    let shaft = Mesh::smooth_patch(60, 4, |u, v| {
        let around = circle(u);
        let flute = 0.5 - 0.5 * circle(u * FLUTES).x;
        // Entasis: the shaft swells a little below its middle and tapers upward.
        let radius_m = 0.2 - 0.035 * v * v + 0.008 * (v * std::f32::consts::PI).sin() - 0.022 * flute;
        let position = Vec3::new(around.x * radius_m, 0.44 + v * 1.96, -around.y * radius_m);
        (position, Vec2::new(u * 2.0, -position.y))
    });
    let base = [
        (0.3, 0.2),
        (0.32, 0.22),
        (0.335, 0.255),
        (0.32, 0.29),
        (0.29, 0.31),
        (0.262, 0.33),
        (0.262, 0.35),
        (0.275, 0.365),
        (0.275, 0.395),
        (0.25, 0.42),
        (0.215, 0.43),
        (0.2, 0.46),
    ];
    let capital = [
        (0.175, 2.38),
        (0.2, 2.4),
        (0.205, 2.425),
        (0.19, 2.44),
        (0.185, 2.5),
        (0.2, 2.58),
        (0.25, 2.66),
        (0.31, 2.71),
        (0.315, 2.74),
        (0.27, 2.76),
    ];
    let column = Mesh::merged([
        shaft,
        lathe(&base.map(Vec2::from), 20, 2.0),
        lathe(&capital.map(Vec2::from), 20, 2.0),
        cuboid(Vec3::new(0.72, 0.2, 0.72), 0.02).at(0.0, 0.1, 0.0),
        cuboid(Vec3::new(0.68, 0.15, 0.68), 0.03).at(0.0, 2.825, 0.0),
    ]);
    let column = column.with_tangents().colored(|p, _| grime(p.y + 0.2));
    let geometry = glb.geometry(&column);
    glb.mesh("column", &[(&geometry, palette.limestone)])
}

/// One bay of railing, 0.95 m high: iron bars with rings, bronze knobs.
fn railing(glb: &mut Glb, palette: &Palette) -> usize {
    let rail = |height_m: f32| cuboid(Vec3::new(BAY_M, 0.035, 0.05), 0.008).at(0.0, height_m, 0.0);
    let mut bars = vec![rail(0.93), rail(0.74), rail(0.1)];
    let post = cuboid(Vec3::new(0.06, 1.0, 0.06), 0.01).at(-BAY_M / 2.0, 0.5, 0.0);
    bars.push(post);
    for i in 1..12 {
        let x_m = (i as f32 / 12.0 - 0.5) * BAY_M;
        bars.push(tube(&[Vec3::new(x_m, 0.1, 0.0), Vec3::new(x_m, 0.75, 0.0)], 0.011, 5));
    }
    for i in 0..12 {
        let x_m = ((i as f32 + 0.5) / 12.0 - 0.5) * BAY_M;
        let ring = upright_ring(0.07, 0.09);
        bars.push(ring.at(x_m, 0.835, 0.0));
    }
    let knob = sphere(0.065, 12, 8).at(-BAY_M / 2.0, 1.05, 0.0);
    let (bars, knob) = (glb.geometry(&Mesh::merged(bars)), glb.geometry(&knob));
    glb.mesh("railing", &[(&bars, palette.iron), (&knob, palette.bronze)])
}

/// A thin upright ring.
fn upright_ring(inner_m: f32, outer_m: f32) -> Mesh {
    lathe(&ring_profile(inner_m..outer_m, -0.012..0.012), 10, 0.5)
        .transformed(glam::Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2))
}

/// The north wall with its gate, and the passage behind it.
fn portal(glb: &mut Glb, palette: &Palette) {
    const RADIUS_M: f32 = 1.5;
    const SPRING_PORTAL_M: f32 = 2.4;
    let thickness_m = 0.7;
    let gate_width_m = 2.0 * RADIUS_M + 1.4;
    let arch = arch_wall(gate_width_m, PORTAL_TOP_M - SPRING_PORTAL_M, RADIUS_M, thickness_m, 40).at(
        0.0,
        SPRING_PORTAL_M,
        0.0,
    );
    let pier_x_m = (RADIUS_M + gate_width_m / 2.0) / 2.0;
    let pier = |side: f32| {
        cuboid(Vec3::new(0.7, SPRING_PORTAL_M, thickness_m), 0.0).at(
            side * pier_x_m,
            SPRING_PORTAL_M / 2.0,
            0.0,
        )
    };
    let side_width_m = OUTER_X_M - gate_width_m / 2.0;
    let flank = |side: f32| {
        let middle_m = side * (gate_width_m / 2.0 + side_width_m / 2.0);
        Mesh::patch(10, 14, |u, v| {
            let position =
                Vec3::new(middle_m + (u - 0.5) * side_width_m, v * PORTAL_TOP_M, thickness_m / 2.0);
            Vertex { position, normal: Vec3::Z, texcoord: Vec2::new(position.x, -position.y) }
        })
    };
    let passage_end = cuboid(Vec3::new(4.0, 5.0, 0.2), 0.0).at(0.0, 2.5, -3.6);
    let passage_side =
        |side: f32| cuboid(Vec3::new(0.2, 2.6, 3.4), 0.0).at(side * (RADIUS_M + 0.1), 1.3, -2.0);
    let passage_vault = flipped_if_inward(Mesh::patch(20, 3, |u, v| {
        let around = circle(0.5 * u);
        let position = (around * RADIUS_M).extend(-0.3 - 3.2 * v);
        let texcoord = Vec2::new(u * RADIUS_M * std::f32::consts::PI, position.z);
        Vertex { position, normal: -around.extend(0.0), texcoord }
    }))
    .at(0.0, SPRING_PORTAL_M, 0.0);
    let walls = Mesh::merged([
        arch,
        pier(-1.0),
        pier(1.0),
        flank(-1.0),
        flank(1.0),
        passage_end,
        passage_side(-1.0),
        passage_side(1.0),
        passage_vault,
    ])
    .colored(|p, _| grime(p.y));
    let f = thickness_m / 2.0;
    let arch_profile = [
        (RADIUS_M + 0.42, f),
        (RADIUS_M + 0.42, f + 0.08),
        (RADIUS_M + 0.34, f + 0.12),
        (RADIUS_M + 0.3, f + 0.06),
        (RADIUS_M + 0.18, f + 0.06),
        (RADIUS_M + 0.15, f + 0.14),
        (RADIUS_M + 0.02, f + 0.14),
        (RADIUS_M - 0.05, f + 0.06),
        (RADIUS_M - 0.05, f - 0.1),
    ]
    .map(Vec2::from);
    let coping =
        [(f, 6.05), (f + 0.16, 6.16), (f + 0.24, 6.25), (f + 0.24, 6.4), (f - 0.7, 6.4)].map(Vec2::from);
    let band = [(f, 5.0), (f + 0.1, 5.06), (f + 0.1, 5.18), (f, TERRACE_M)].map(Vec2::from);
    let jamb = |side: f32| {
        cuboid(Vec3::new(0.36, SPRING_PORTAL_M, 0.16), 0.03).at(
            side * (RADIUS_M + 0.2),
            SPRING_PORTAL_M / 2.0,
            f + 0.05,
        )
    };
    let impost = |side: f32| {
        cuboid(Vec3::new(0.56, 0.18, 0.3), 0.04).at(side * (RADIUS_M + 0.2), SPRING_PORTAL_M, f + 0.06)
    };
    let dressed = Mesh::merged([
        archivolt(&arch_profile, 40).at(0.0, SPRING_PORTAL_M, 0.0),
        moulding(&coping, 2.0 * OUTER_X_M),
        moulding(&band, 2.0 * OUTER_X_M),
        jamb(-1.0),
        jamb(1.0),
        impost(-1.0),
        impost(1.0),
        cuboid(Vec3::new(0.4, 0.8, 0.36), 0.05).at(0.0, SPRING_PORTAL_M + RADIUS_M + 0.25, f + 0.04),
        cuboid(Vec3::new(4.4, 0.14, 1.6), 0.02).at(0.0, 0.07, f + 0.3),
    ])
    .colored(|p, _| grime(p.y + 0.3));
    // The gate's grille fills the arch; its texture discards what is between the bars.
    let grille = Mesh::patch(24, 1, |u, v| {
        let x_m = (2.0 * u - 1.0) * (RADIUS_M - 0.02);
        let top_m = SPRING_PORTAL_M + (RADIUS_M * RADIUS_M - x_m * x_m).max(0.0).sqrt();
        let position = Vec3::new(x_m, 0.14 + v * (top_m - 0.14), 0.05);
        Vertex { position, normal: Vec3::Z, texcoord: Vec2::new(position.x, -position.y) }
    });
    let parts = [(walls, palette.wall), (dressed, palette.limestone), (grille, palette.lattice)];
    let parts = parts.map(|(mesh, material)| (glb.geometry(&mesh), material));
    let mesh = glb.mesh("portal", &parts.each_ref().map(|(geometry, material)| (geometry, *material)));
    glb.place("portal", mesh, Pose::at(0.0, 0.0, PORTAL_Z_M - f));
}

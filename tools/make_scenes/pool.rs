//! A pool of water beside a fire in a walled garden at night: steps lead down into it, stones and a column stand in it, steam lies
//! over it and sparks rise from the fire. What is blended, added and refracted after lighting, in one place.

use super::glb::{Glb, Light, LightKind, Material, Medium, Pose, Slot, place};
use super::mesh::{Mesh, planar_texcoord};
use super::noise::{cellular, fractal, gradient_noise, pick, smoothstep};
use super::shape::{circle, cuboid, lathe, sphere};
use super::texture::{linear, picture, srgb};
use glam::{IVec2, Vec2, Vec3};
use serde_json::json;

/// Of the basin, across.
const WIDTH_M: f32 = 3.4;
/// Of the basin, from back to front.
const LENGTH_M: f32 = 2.2;
/// Of the water, below the paving.
const WATER_M: f32 = -0.09;
/// Of the basin's floor at its deep end.
const FLOOR_M: f32 = -1.25;
/// Where the fire is.
const FIRE: Vec3 = Vec3::new(-1.15, 0.62, -1.62);

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    let stone = glb.texture("stone", &picture(112, stone));
    let tiles = glb.texture("tiles", &picture(128, tiles));
    garden(&mut glb, stone);
    basin(&mut glb, tiles);
    things(&mut glb, stone);
    water(&mut glb);
    fire(&mut glb);
    steam(&mut glb);
    lights(&mut glb);
    glb.perspective("main", 41.0, Pose::looking(Vec3::new(2.1, 1.75, 3.0), Vec3::new(-0.12, 0.02, -0.2)));
    glb.perspective("low", 44.0, Pose::looking(Vec3::new(0.9, 0.42, 2.3), Vec3::new(-0.5, -0.05, -0.4)));
    glb.finish("pool")
}

/// Rough flags with mortar between them.
fn stone(uv: Vec2) -> Vec3 {
    let cell = cellular(uv, IVec2::splat(4), 11);
    let mortar = smoothstep(0.02, 0.09, cell.second - cell.nearest);
    let grain = fractal(uv, IVec2::splat(8), 4, 3);
    let flag = srgb(0x8c8478).lerp(srgb(0x6e6a64), 0.5 + 0.5 * fractal(uv, IVec2::splat(3), 2, 5));
    (srgb(0x45413c).lerp(flag, mortar) * (1.0 + 0.18 * grain)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Small square tiles of glazed blue and white.
fn tiles(uv: Vec2) -> Vec3 {
    let at = uv * 8.0;
    let cell = at.floor().as_ivec2();
    let within = (at - at.floor() - 0.5).abs().max_element();
    let shade = super::noise::unit(cell, 9);
    let glaze = srgb(0x3f86a0).lerp(srgb(0xcfe2dc), smoothstep(0.35, 0.9, shade));
    let glaze = glaze * (0.92 + 0.16 * super::noise::unit(cell, 21));
    glaze.lerp(srgb(0xa8a498), smoothstep(0.43, 0.47, within)).clamp(Vec3::ZERO, Vec3::ONE)
}

fn of(texture: Slot, per_m: f32, roughness: f32) -> Material {
    Material { base_color_texture: Some(texture.scaled(per_m)), roughness, ..Material::default() }
}

/// A block with texture coordinates of its place.
fn block(size_m: Vec3, at: Vec3, bevel_m: f32) -> Mesh {
    let mut mesh = cuboid(size_m, bevel_m).at(at.x, at.y, at.z);
    let coordinates =
        mesh.positions.iter().zip(&mesh.normals).map(|(p, n)| planar_texcoord(*p, *n)).collect();
    mesh.texcoords = coordinates;
    mesh
}

/// Paving around the basin, and a wall behind.
fn garden(glb: &mut Glb, texture: Slot) {
    // A little behind the faces of the basin.
    let (half_width, half_length) = (WIDTH_M * 0.5 + 0.03, LENGTH_M * 0.5 + 0.03);
    let slab = |x: [f32; 2], z: [f32; 2]| {
        let size = Vec3::new(x[1] - x[0], 0.2, z[1] - z[0]);
        block(size, Vec3::new((x[0] + x[1]) * 0.5, -0.1, (z[0] + z[1]) * 0.5), 0.02)
    };
    let paving = Mesh::merged([
        slab([-4.6, 4.6], [-3.4, -half_length]),
        slab([-4.6, 4.6], [half_length, 3.8]),
        slab([-4.6, -half_width], [-half_length, half_length]),
        slab([half_width, 4.6], [-half_length, half_length]),
    ]);
    place(glb, "paving", &paving, &of(texture, 0.8, 0.8), Pose::origin());
    let wall = Mesh::merged([
        block(Vec3::new(9.2, 2.6, 0.3), Vec3::new(0.0, 1.3, -3.3), 0.03),
        block(Vec3::new(0.3, 2.6, 6.0), Vec3::new(-4.5, 1.3, -0.2), 0.03),
    ]);
    place(glb, "wall", &wall, &of(texture, 0.5, 0.9), Pose::origin());
    // A kerb that stands a little over the paving.
    let kerb = Mesh::merged([
        block(Vec3::new(WIDTH_M + 0.44, 0.12, 0.22), Vec3::new(0.0, 0.01, -half_length - 0.1), 0.025),
        block(Vec3::new(WIDTH_M + 0.44, 0.12, 0.22), Vec3::new(0.0, 0.01, half_length + 0.1), 0.025),
        block(Vec3::new(0.22, 0.12, LENGTH_M - 0.02), Vec3::new(-half_width - 0.1, 0.01, 0.0), 0.025),
        block(Vec3::new(0.22, 0.12, LENGTH_M - 0.02), Vec3::new(half_width + 0.1, 0.01, 0.0), 0.025),
    ]);
    let pale = Material { base_color: linear(0xd8ccb4), ..of(texture, 1.3, 0.55) };
    place(glb, "kerb", &kerb, &pale, Pose::origin());
}

/// Walls, a floor, and steps that lead down from the left.
fn basin(glb: &mut Glb, texture: Slot) {
    let (half_width, half_length) = (WIDTH_M * 0.5, LENGTH_M * 0.5);
    // Their tops are below the paving.
    let middle = FLOOR_M * 0.5 - 0.065;
    let height = -FLOOR_M + 0.07;
    let mut parts = vec![
        block(Vec3::new(WIDTH_M + 0.4, 0.2, LENGTH_M + 0.4), Vec3::new(0.0, FLOOR_M - 0.1, 0.0), 0.01),
        block(Vec3::new(WIDTH_M + 0.4, height, 0.2), Vec3::new(0.0, middle, -half_length - 0.1), 0.01),
        block(Vec3::new(WIDTH_M + 0.4, height, 0.2), Vec3::new(0.0, middle, half_length + 0.1), 0.01),
        block(Vec3::new(0.2, height, LENGTH_M), Vec3::new(-half_width - 0.1, middle, 0.0), 0.01),
        block(Vec3::new(0.2, height, LENGTH_M), Vec3::new(half_width + 0.1, middle, 0.0), 0.01),
    ];
    for (i, top) in [-0.2_f32, -0.42, -0.66, -0.92].into_iter().enumerate() {
        let (from, tread) = (-half_width, 0.38);
        let to = from + tread * (i as f32 + 1.0);
        let size = Vec3::new(to - from, top - FLOOR_M, LENGTH_M - 0.01);
        parts.push(block(size, Vec3::new((from + to) * 0.5, (top + FLOOR_M) * 0.5, 0.0), 0.015));
    }
    place(glb, "basin", Mesh::merged(parts), &of(texture, 1.1, 0.35), Pose::origin());
}

/// What stands in the water, and what stands beside it.
fn things(glb: &mut Glb, texture: Slot) {
    let column = lathe(
        &[
            (0.0, 0.0),
            (0.13, 0.0),
            (0.13, 0.06),
            (0.1, 0.1),
            (0.085, 1.5),
            (0.12, 1.58),
            (0.12, 1.66),
            (0.0, 1.66),
        ]
        .map(Vec2::from),
        40,
        1.0,
    );
    let marble = Material { base_color: linear(0xe8e0d0), roughness: 0.35, ..Material::default() };
    place(glb, "column", column.untextured(), &marble, Pose::at(0.75, FLOOR_M, -0.55));
    let brass =
        Material { base_color: linear(0xe0b860), metallic: 1.0, roughness: 0.22, ..Material::default() };
    place(glb, "ball", sphere(0.12, 40, 20).untextured(), &brass, Pose::at(0.75, FLOOR_M + 1.78, -0.55));
    let red = Material { base_color: linear(0xb03020), roughness: 0.4, ..Material::default() };
    place(glb, "buoy", sphere(0.16, 40, 20).untextured(), &red, Pose::at(0.15, WATER_M + 0.02, 0.35));
    let jar = lathe(
        &[
            (0.0, 0.0),
            (0.1, 0.0),
            (0.2, 0.16),
            (0.21, 0.28),
            (0.12, 0.44),
            (0.08, 0.5),
            (0.1, 0.56),
            (0.08, 0.56),
            (0.06, 0.5),
        ]
        .map(Vec2::from),
        40,
        1.0,
    );
    let clay =
        Material { base_color: linear(0xc07848), roughness: 0.6, double_sided: true, ..Material::default() };
    let jar = jar.untextured();
    place(glb, "jar", &jar, &clay, Pose::at(2.25, 0.0, -1.0));
    place(
        glb,
        "sunken jar",
        &jar,
        &clay,
        Pose::at(1.2, FLOOR_M + 0.17, 0.45).turned(0.12).rotated(Vec3::X, 0.22),
    );
    for (i, (x, z, size)) in
        [(0.35, -0.1, 0.5), (1.05, 0.2, 0.42), (1.45, -0.25, 0.46)].into_iter().enumerate()
    {
        let top = WATER_M + 0.06 - 0.24 * i as f32;
        let height = top - FLOOR_M;
        let stone = block(Vec3::new(size, height, size * 0.8), Vec3::ZERO, 0.05);
        place(
            glb,
            "stepping stone",
            &stone,
            &of(texture, 1.0, 0.7),
            Pose::at(x - 0.35, top - height * 0.5, z - 0.45).turned(0.05 * i as f32),
        );
    }
}

/// A surface that small waves cross.
fn water(glb: &mut Glb) {
    let (columns, rows) = (56, 36);
    let surface = Mesh::smooth_patch(columns, rows, |u, v| {
        let place = Vec2::new((u - 0.5) * WIDTH_M, (0.5 - v) * LENGTH_M);
        let long = gradient_noise(Vec2::new(u * 5.0, v * 4.0), IVec2::new(5, 4), 17);
        let short = gradient_noise(Vec2::new(u * 13.0, v * 9.0), IVec2::new(13, 9), 29);
        (Vec3::new(place.x, WATER_M + 0.012 * long + 0.004 * short, place.y), Vec2::ZERO)
    });
    // Clear water would need a sea to be seen: this has some clay in it.
    let medium = Medium {
        transmission: 0.96,
        ior: 1.333,
        thickness_m: 12.0,
        color: linear(0x54c0bc),
        distance_m: 1.1,
    };
    let water = Material {
        base_color: linear(0xe8f4f2),
        roughness: 0.06,
        medium: Some(medium),
        ..Material::default()
    };
    place(glb, "water", surface.untextured(), &water, Pose::origin());
}

/// A bowl of coals on a foot, and sparks over it.
fn fire(glb: &mut Glb) {
    let iron = Material {
        base_color: linear(0x4a4644),
        metallic: 1.0,
        roughness: 0.5,
        double_sided: true,
        ..Material::default()
    };
    let bowl = lathe(
        &[
            (0.0, 0.0),
            (0.16, 0.0),
            (0.16, 0.03),
            (0.04, 0.06),
            (0.035, 0.38),
            (0.12, 0.42),
            (0.27, 0.52),
            (0.31, 0.62),
            (0.29, 0.62),
            (0.25, 0.54),
            (0.0, 0.5),
        ]
        .map(Vec2::from),
        48,
        1.0,
    );
    place(glb, "brazier", bowl.untextured(), &iron, Pose::at(FIRE.x, 0.0, FIRE.z));
    let coals = Material {
        base_color: Vec3::splat(0.05),
        roughness: 0.9,
        emissive: Vec3::new(1.0, 0.34, 0.07),
        emissive_strength: 5.0,
        ..Material::default()
    };
    let heap = (0..11).map(|i| {
        let around = circle(pick(i, 3)) * (0.19 * pick(i, 4).sqrt());
        sphere(0.05 + 0.03 * pick(i, 5), 12, 6).at(around.x, 0.02 * pick(i, 6), around.y)
    });
    place(glb, "coals", Mesh::merged(heap).untextured(), &coals, Pose::at(FIRE.x, FIRE.y - 0.06, FIRE.z));
    let glow = glb.texture(
        "glow",
        &picture(32, |uv| {
            let from_middle = (uv * 2.0 - 1.0).length();
            Vec3::splat(smoothstep(1.0, 0.0, from_middle))
        }),
    );
    let flame = glb.material(&Material {
        name: "flame",
        base_color: Vec3::ZERO,
        emissive: Vec3::new(1.0, 0.42, 0.1),
        emissive_texture: Some(glow),
        emissive_strength: 2.5,
        ..Material::default()
    });
    let flames: Vec<_> = (0..26)
        .map(|i| {
            let height = pick(i, 31);
            let around = circle(pick(i, 32)) * (0.16 * (1.0 - height) * pick(i, 33).sqrt());
            let cooler = Vec3::new(1.0, 1.0 - 0.5 * height, 1.0 - 0.8 * height) * (0.5 - 0.4 * height);
            (Vec3::new(around.x, 0.5 * height, around.y), cooler, 0.34 - 0.16 * height, 0.0)
        })
        .collect();
    particles(glb, "flames", &flames, flame, 0.12, FIRE);
    let spark = glb.material(&Material {
        name: "spark",
        base_color: Vec3::ZERO,
        emissive: Vec3::new(1.0, 0.5, 0.15),
        emissive_texture: Some(glow),
        emissive_strength: 30.0,
        ..Material::default()
    });
    let sparks: Vec<_> = (0..90)
        .map(|i| {
            let height = pick(i, 41);
            let drift = Vec2::new(0.9 * height * height, 0.2 * height);
            let around = circle(pick(i, 42)) * (0.12 + 0.42 * height) * pick(i, 43).sqrt() + drift;
            (
                Vec3::new(around.x, 0.15 + 1.7 * height, around.y),
                Vec3::splat(1.0 - 0.85 * height),
                0.012 + 0.016 * pick(i, 44),
                0.0,
            )
        })
        .collect();
    particles(glb, "sparks", &sparks, spark, 0.02, FIRE);
}

/// Wisps that lie on the water and thin out above it.
fn steam(glb: &mut Glb) {
    let wisp = glb.texture(
        "wisp",
        &picture(64, |uv| {
            let p = uv * 2.0 - 1.0;
            let cloud = 0.55 + 0.6 * fractal(uv, IVec2::splat(4), 4, 77);
            Vec3::splat((cloud * smoothstep(1.0, 0.1, p.length())).clamp(0.0, 1.0))
        }),
    );
    let steam = glb.material(&Material {
        name: "steam",
        base_color: Vec3::ZERO,
        emissive: Vec3::new(0.5, 0.56, 0.62),
        emissive_texture: Some(wisp),
        emissive_strength: 0.42,
        ..Material::default()
    });
    let wisps: Vec<_> = (0..56)
        .map(|i| {
            let height = pick(i, 61) * pick(i, 62);
            let place =
                Vec2::new((pick(i, 63) - 0.5) * (WIDTH_M - 0.5), (pick(i, 64) - 0.5) * (LENGTH_M - 0.4));
            // Lit by the fire where it is near.
            let near = smoothstep(2.6, 0.3, place.distance(Vec2::new(FIRE.x, FIRE.z)));
            let color =
                Vec3::new(0.45, 0.5, 0.55).lerp(Vec3::new(1.0, 0.55, 0.3), near) * (1.0 - 0.7 * height);
            (
                Vec3::new(place.x, 0.06 + 0.62 * height, place.y),
                color,
                0.5 + 0.5 * pick(i, 65),
                std::f32::consts::TAU * pick(i, 66),
            )
        })
        .collect();
    particles(glb, "steam", &wisps, steam, 0.3, Vec3::ZERO);
}

fn particles(
    glb: &mut Glb,
    name: &str,
    points: &[(Vec3, Vec3, f32, f32)],
    material: usize,
    soft_m: f32,
    at: Vec3,
) {
    let mesh = glb.points(name, points, material);
    let node = glb.place(name, mesh, Pose::at(at.x, at.y, at.z));
    glb.extras(node, json!({"particles": {"size": 1, "soft": soft_m}}));
}

fn lights(glb: &mut Glb) {
    let point = |name, color, intensity_cd, range_m| Light {
        name,
        color,
        kind: LightKind::Point { intensity_cd, range_m },
    };
    glb.light(
        point("fire", Vec3::new(1.0, 0.5, 0.2), 9.0, 9.0),
        Pose::at(FIRE.x + 0.1, FIRE.y + 0.5, FIRE.z + 0.1),
    );
    glb.light(point("pool lamp", Vec3::new(0.75, 0.95, 1.0), 2.2, 4.0), Pose::at(1.5, -0.75, 0.95));
    let moon = Light {
        name: "moon",
        color: Vec3::new(0.6, 0.75, 1.0),
        kind: LightKind::Directional { illuminance_lx: 1.5 },
    };
    glb.light(moon, Pose::looking(Vec3::new(1.6, 4.0, 2.4), Vec3::new(-0.2, 0.0, -0.2)));
}

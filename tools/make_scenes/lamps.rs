//! A still life of lamps: what shines by itself, vertex colours, an unlit sign, a mirrored instance, a
//! double-sided leaf. No textures.

use super::glb::{Glb, Light, LightKind, Material, Pose};
use super::mesh::{Mesh, Vertex};
use super::noise::smoothstep;
use super::shape::{circle, cuboid, lathe, round_profile, sphere, tube};
use super::texture::linear;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Top of the table.
const TABLE_M: f32 = 0.75;
const WARM: Vec3 = Vec3::new(1.0, 0.6, 0.26);
const CYAN: Vec3 = Vec3::new(0.12, 0.75, 0.9);

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    room(&mut glb);
    table_lamp(&mut glb);
    crystal(&mut glb);
    vase(&mut glb);
    horns(&mut glb);
    sign(&mut glb);
    lights(&mut glb);
    let target = Vec3::new(0.0, TABLE_M + 0.3, 0.0);
    glb.perspective("main", 34.0, Pose::looking(Vec3::new(0.35, 1.5, 2.55), target));
    glb.perspective(
        "close",
        30.0,
        Pose::looking(Vec3::new(1.05, 1.3, 1.25), target - Vec3::new(-0.12, 0.1, 0.0)),
    );
    glb.finish("lamps")
}

fn points<const N: usize>(profile: [(f32, f32); N]) -> [Vec2; N] {
    profile.map(Vec2::from)
}

/// One part of one material at a place.
fn place(glb: &mut Glb, name: &'static str, mesh: Mesh, material: &Material, pose: Pose) {
    let geometry = glb.geometry(&mesh.untextured());
    let material = glb.material(&Material { name, ..material.clone() });
    let mesh = glb.mesh(name, &[(&geometry, material)]);
    glb.place(name, mesh, pose);
}

fn room(glb: &mut Glb) {
    let wood = Material { base_color: linear(0x9a6440), roughness: 0.42, ..Material::default() };
    let top = lathe(
        &points([(0.0, -0.05), (1.08, -0.05), (1.1, -0.03), (1.1, -0.02), (1.08, 0.0), (0.0, 0.0)]),
        48,
        1.0,
    );
    place(glb, "table", top, &wood, Pose::at(0.0, TABLE_M, 0.0));
    // The wall's colours fade upward.
    let wall = Mesh::patch(8, 8, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * 8.0, v * 4.8 - 1.8, -1.3),
        normal: Vec3::Z,
        texcoord: Vec2::ZERO,
    })
    .colored(|p, _| linear(0x8a5a6e).lerp(linear(0x34506e), smoothstep(0.4, 2.6, p.y)));
    place(glb, "wall", wall, &Material::default(), Pose::origin());
}

/// A brass foot under a glowing shade; its emission is past 1.
fn table_lamp(glb: &mut Glb) {
    let brass =
        Material { base_color: linear(0xe8c878), metallic: 1.0, roughness: 0.28, ..Material::default() };
    let foot = lathe(
        &points([
            (0.13, 0.0),
            (0.135, 0.012),
            (0.11, 0.03),
            (0.04, 0.05),
            (0.022, 0.09),
            (0.05, 0.15),
            (0.055, 0.19),
            (0.025, 0.25),
            (0.018, 0.36),
            (0.03, 0.38),
            (0.0, 0.39),
        ]),
        32,
        1.0,
    );
    let at = Pose::at(-0.42, TABLE_M, -0.18);
    place(glb, "lamp foot", foot, &brass, at);
    let profile: Vec<_> =
        (0..=10).map(|i| circle(i as f32 / 20.0 - 0.25) * Vec2::new(0.17, 0.13) + Vec2::Y * 0.5).collect();
    let glow = Material {
        base_color: Vec3::splat(0.1),
        roughness: 0.4,
        emissive: WARM,
        emissive_strength: 3.0,
        ..Material::default()
    };
    place(glb, "lamp globe", lathe(&profile, 32, 1.0), &glow, at);
    let ring = lathe(&round_profile(Vec2::new(0.172, 0.5), 0.012, 6), 32, 1.0);
    place(glb, "lamp ring", ring, &brass, at);
}

/// A faceted stone that glows faintly.
fn crystal(glb: &mut Glb) {
    let stone = Material {
        base_color: linear(0x2a6f80),
        roughness: 0.2,
        emissive: CYAN * 0.35,
        ..Material::default()
    };
    let shape = lathe(&points([(0.0, 0.0), (0.1, 0.06), (0.12, 0.16), (0.0, 0.4)]), 6, 1.0).faceted();
    place(glb, "crystal", shape, &stone, Pose::at(0.34, TABLE_M, 0.28).turned(0.04));
    let chip = sphere(0.06, 6, 4).faceted();
    place(glb, "chip", chip, &stone, Pose::at(0.56, TABLE_M + 0.045, 0.36).turned(0.1));
}

/// A glazed vase, its colours per vertex, with leaves that are seen from both sides.
fn vase(glb: &mut Glb) {
    let glaze = Material { roughness: 0.22, ..Material::default() };
    let profile = [
        (0.0, 0.0),
        (0.07, 0.0),
        (0.08, 0.01),
        (0.11, 0.08),
        (0.125, 0.15),
        (0.115, 0.22),
        (0.07, 0.29),
        (0.05, 0.34),
        (0.06, 0.39),
        (0.05, 0.385),
        (0.04, 0.33),
    ];
    let vase = lathe(&points(profile), 32, 1.0)
        .colored(|p, _| linear(0x7a2340).lerp(linear(0xf0c890), smoothstep(0.06, 0.36, p.y)));
    let at = Pose::at(0.12, TABLE_M, -0.3);
    place(glb, "vase", vase, &glaze, at);
    let leaf = Mesh::smooth_patch(6, 12, |u, v| {
        let half_width_m = 0.07 * (v * PI).sin().powf(0.8).max(0.0) + 0.003;
        let across_m = (2.0 * u - 1.0) * half_width_m;
        // A fold along the middle, and a tip that bends over.
        let position = Vec3::new(across_m, 0.36 * v - 0.12 * v * v, 0.3 * v * v + across_m.abs() * 0.5);
        (position, Vec2::ZERO)
    })
    .colored(|p, _| linear(0x2f6b34).lerp(linear(0x9cc24e), smoothstep(0.0, 0.3, p.length())));
    let leaf = glb.geometry(&leaf.untextured());
    let green = Material { name: "leaf", roughness: 0.5, double_sided: true, ..Material::default() };
    let green = glb.material(&green);
    let leaf = glb.mesh("leaf", &[(&leaf, green)]);
    for i in 0..7 {
        let pose = Pose::at(at.position_m.x, TABLE_M + 0.34, at.position_m.z).turned(i as f32 * 0.381_966);
        let size = 1.15 - 0.07 * i as f32;
        glb.place("leaf", leaf, pose.rotated(Vec3::X, 0.03 * (i % 3) as f32).scaled(size, size, size));
    }
}

/// A curled horn, and the same mesh mirrored.
fn horns(glb: &mut Glb) {
    let path: Vec<_> = (0..=40)
        .map(|i| {
            let t = i as f32 / 40.0;
            let around = circle(0.2 - 1.35 * t) * (0.15 - 0.11 * t);
            Vec3::new(around.x, around.y + 0.16, 0.14 * t)
        })
        .collect();
    // The tube has 41 rings of 13 vertices; each ring shrinks towards the tip.
    let mut horn = tube(&path, 0.04, 12);
    for (ring, center) in path.iter().enumerate() {
        let scale = 1.05 - 0.95 * ring as f32 / 40.0;
        for position in &mut horn.positions[ring * 13..(ring + 1) * 13] {
            *position = *center + (*position - *center) * scale;
        }
    }
    let horn = horn.colored(|p, _| linear(0xe8d8b0).lerp(linear(0x6a4630), smoothstep(0.02, 0.14, p.z)));
    let horn = glb.geometry(&horn.untextured());
    let bone = glb.material(&Material { name: "horn", roughness: 0.3, ..Material::default() });
    let horn = glb.mesh("horn", &[(&horn, bone)]);
    glb.place("horn", horn, Pose::at(-0.22, TABLE_M, 0.32));
    glb.place("mirrored horn", horn, Pose::at(-0.66, TABLE_M, 0.32).scaled(-1.0, 1.0, 1.0));
}

/// A board with a star that looks the same in any light.
fn sign(glb: &mut Glb) {
    let slate = Material { base_color: linear(0x2c2f3a), roughness: 0.7, ..Material::default() };
    let at = Pose::at(0.66, TABLE_M + 0.31, -0.28).turned(-0.06);
    place(glb, "board", cuboid(Vec3::new(0.5, 0.62, 0.04), 0.01), &slate, at);
    let mut star = Mesh::default();
    let mut corner = |position: Vec3| star.push(Vertex { position, normal: Vec3::Z, texcoord: Vec2::ZERO });
    let center = corner(Vec3::Z * 0.024);
    let tips: Vec<_> = (0..10)
        .map(|i| {
            let radius_m = if i % 2 == 0 { 0.2 } else { 0.085 };
            corner((circle(0.25 + i as f32 / 10.0) * radius_m).extend(0.024))
        })
        .collect();
    for i in 0..10 {
        star.triangle([center, tips[i], tips[(i + 1) % 10]]);
    }
    let star = star.colored(|p, _| {
        linear(0xfff0a0).lerp(linear(0xff8a3c), smoothstep(0.05, 0.2, p.truncate().length()))
    });
    place(glb, "star", star, &Material { unlit: true, ..Material::default() }, at);
}

fn lights(glb: &mut Glb) {
    let point = |name, color, intensity_cd, range_m| Light {
        name,
        color,
        kind: LightKind::Point { intensity_cd, range_m },
    };
    glb.light(point("lamp light", WARM, 2.4, 5.0), Pose::at(-0.42, TABLE_M + 0.5, 0.1));
    glb.light(point("crystal light", CYAN, 0.35, 1.6), Pose::at(0.42, TABLE_M + 0.22, 0.5));
    glb.light(point("rose light", Vec3::new(1.0, 0.4, 0.55), 3.0, 4.0), Pose::at(1.2, TABLE_M + 0.7, -0.5));
    glb.light(
        point("violet light", Vec3::new(0.5, 0.45, 1.0), 5.0, 5.0),
        Pose::at(-1.4, TABLE_M + 1.0, -0.3),
    );
    let kind = LightKind::Spot { intensity_cd: 16.0, range_m: 6.0, inner_rad: 0.2, outer_rad: 0.5 };
    let spot = Light { name: "spot", color: Vec3::new(1.0, 0.92, 0.8), kind };
    glb.light(spot, Pose::looking(Vec3::new(0.9, 2.6, 1.6), Vec3::new(0.05, TABLE_M, 0.0)));
}

//! Coloured panes in a rack and bottles on a table, before a lamp whose light is past white: what is blended over what.

use super::glb::{Glb, Light, LightKind, Material, Pose};
use super::mesh::{Mesh, Vertex};
use super::noise::smoothstep;
use super::shape::{cuboid, lathe, sphere};
use super::texture::linear;
use glam::{Vec2, Vec3};

/// Top of the table.
const TABLE_M: f32 = 0.75;

/// Of the panes in the rack, from the farthest.
const PANES: [u32; 5] = [0xd8283a, 0xf0a020, 0x38a848, 0x2a6ae0, 0x9038c8];

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    room(&mut glb);
    lamp(&mut glb);
    panes(&mut glb);
    bottles(&mut glb);
    lights(&mut glb);
    let target = Vec3::new(0.0, TABLE_M + 0.27, 0.0);
    glb.perspective("main", 34.0, Pose::looking(Vec3::new(0.75, 1.45, 2.2), target));
    glb.perspective("along", 30.0, Pose::looking(Vec3::new(-0.25, 1.12, 2.4), target));
    glb.finish("glass")
}

fn place(glb: &mut Glb, name: &'static str, mesh: Mesh, material: &Material, pose: Pose) {
    let geometry = glb.geometry(&mesh.untextured());
    let material = glb.material(&Material { name, ..material.clone() });
    let mesh = glb.mesh(name, &[(&geometry, material)]);
    glb.place(name, mesh, pose);
}

fn tinted(color: u32, alpha: f32) -> Material {
    Material { base_color: linear(color), roughness: 0.12, blend_alpha: Some(alpha), ..Material::default() }
}

fn room(glb: &mut Glb) {
    let oak = Material { base_color: linear(0x8a6a4a), roughness: 0.5, ..Material::default() };
    place(glb, "table", cuboid(Vec3::new(2.4, 0.06, 1.5), 0.02), &oak, Pose::at(0.0, TABLE_M - 0.03, 0.0));
    let wall = Mesh::patch(8, 8, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * 8.0, v * 4.8 - 1.8, -1.2),
        normal: Vec3::Z,
        texcoord: Vec2::ZERO,
    })
    .colored(|p, _| linear(0xb8a890).lerp(linear(0x4a5a70), smoothstep(0.3, 2.4, p.y)));
    place(glb, "wall", wall, &Material::default(), Pose::origin());
    let brass =
        Material { base_color: linear(0xe0c070), metallic: 1.0, roughness: 0.3, ..Material::default() };
    place(glb, "ball", sphere(0.09, 32, 16), &brass, Pose::at(0.62, TABLE_M + 0.09, 0.05));
    let rack = Material { base_color: linear(0x3a3430), roughness: 0.6, ..Material::default() };
    place(
        glb,
        "rack",
        cuboid(Vec3::new(0.62, 0.04, 0.86), 0.01),
        &rack,
        Pose::at(-0.2, TABLE_M + 0.02, 0.05),
    );
}

/// A globe that glows three times brighter than white.
fn lamp(glb: &mut Glb) {
    let glow = Material {
        base_color: Vec3::splat(0.1),
        roughness: 0.5,
        emissive: Vec3::new(1.0, 0.75, 0.45),
        emissive_strength: 3.0,
        ..Material::default()
    };
    place(glb, "lamp", sphere(0.15, 32, 16), &glow, Pose::at(-0.28, TABLE_M + 0.36, -0.62));
}

/// One behind the other, so that most are seen through others.
fn panes(glb: &mut Glb) {
    let pane = glb.geometry(&cuboid(Vec3::new(0.42, 0.5, 0.012), 0.004).untextured());
    for (i, color) in PANES.into_iter().enumerate() {
        let material = glb.material(&Material { name: "pane", ..tinted(color, 0.42) });
        let mesh = glb.mesh("pane", &[(&pane, material)]);
        let along = i as f32 * 0.17 - 0.3;
        let pose = Pose::at(-0.32 + 0.06 * i as f32, TABLE_M + 0.29, along);
        glb.place("pane", mesh, pose.turned(0.02 - 0.012 * i as f32));
    }
}

fn bottles(glb: &mut Glb) {
    let profile = [
        (0.0, 0.0),
        (0.08, 0.0),
        (0.088, 0.012),
        (0.09, 0.24),
        (0.08, 0.29),
        (0.03, 0.35),
        (0.028, 0.43),
        (0.034, 0.44),
        (0.026, 0.45),
    ];
    let bottle = glb.geometry(&lathe(&profile.map(Vec2::from), 40, 1.0).untextured());
    let places = [(0x2a8a5a, 0.36, 0.5), (0x9a5a1a, 0.62, 0.38), (0x4a90c8, 0.84, 0.12)];
    for (color, x, z) in places {
        let material = glb.material(&Material { name: "bottle", ..tinted(color, 0.45) });
        let mesh = glb.mesh("bottle", &[(&bottle, material)]);
        glb.place("bottle", mesh, Pose::at(x, TABLE_M, z));
    }
    let bowl =
        lathe(&[(0.0, 0.0), (0.06, 0.0), (0.12, 0.05), (0.16, 0.12), (0.155, 0.12)].map(Vec2::from), 40, 1.0);
    let bowl_glass = Material { double_sided: true, ..tinted(0xd0e8f0, 0.3) };
    place(glb, "bowl", bowl, &bowl_glass, Pose::at(0.05, TABLE_M, 0.56));
}

fn lights(glb: &mut Glb) {
    let point = |name, color, intensity_cd, range_m| Light {
        name,
        color,
        kind: LightKind::Point { intensity_cd, range_m },
    };
    let warm = Vec3::new(1.0, 0.75, 0.45);
    glb.light(point("lamp light", warm, 2.2, 5.0), Pose::at(-0.28, TABLE_M + 0.8, -0.55));
    glb.light(point("window", Vec3::new(0.6, 0.75, 1.0), 5.0, 6.0), Pose::at(1.5, TABLE_M + 1.2, 0.9));
    let kind = LightKind::Spot { intensity_cd: 14.0, range_m: 6.0, inner_rad: 0.2, outer_rad: 0.5 };
    let spot = Light { name: "spot", color: Vec3::new(1.0, 0.95, 0.88), kind };
    glb.light(spot, Pose::looking(Vec3::new(-1.1, 2.5, 1.7), Vec3::new(0.1, TABLE_M, 0.1)));
}

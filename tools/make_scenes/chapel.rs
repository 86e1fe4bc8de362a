//! A corner of a chapel at night, under one light of each kind: moonlight in a box through a stained-glass window, a
//! projected rose, a star lantern, a hemisphere, and a lamp with a back colour.

use super::glb::{Glb, Light, LightKind, Material, Pose, place};
use super::mesh::{Mesh, Vertex};
use super::noise::{hash, pick, smoothstep};
use super::shape::{circle, cuboid, lathe, round_profile, sphere};
use super::texture::{linear, picture, srgb};
use glam::{IVec2, Vec2, Vec3};
use serde_json::json;

/// The left wall.
const WALL_X_M: f32 = -2.6;
/// The back wall.
const BACK_Z_M: f32 = -2.4;
/// Middle of the window and its width (along Z) and height.
const WINDOW: Vec3 = Vec3::new(WALL_X_M, 2.2, -0.6);
const WINDOW_M: Vec2 = Vec2::new(1.5, 2.2);
const LANTERN: Vec3 = Vec3::new(1.75, 2.15, -1.2);

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    walls(&mut glb);
    window(&mut glb);
    lantern(&mut glb);
    things(&mut glb);
    lights(&mut glb);
    let eye = Vec3::new(1.7, 1.75, 4.6);
    glb.perspective("main", 42.0, Pose::looking(eye, Vec3::new(-0.15, 1.35, -1.0)));
    glb.perspective("floor", 40.0, Pose::looking(Vec3::new(0.3, 3.4, 2.6), Vec3::new(-0.1, 0.2, -0.7)));
    glb.finish("chapel")
}

/// A rectangle whose middle is at `center`, as wide and high as `right` and `up` are long.
fn panel(center: Vec3, right: Vec3, up: Vec3) -> Mesh {
    let normal = right.cross(up).normalize();
    Mesh::patch(8, 8, |u, v| Vertex {
        position: center + right * (u - 0.5) + up * (v - 0.5),
        normal,
        texcoord: Vec2::new(u, 1.0 - v),
    })
}

fn walls(glb: &mut Glb) {
    let plaster = Material { base_color: linear(0xcfc4b4), roughness: 0.85, ..Material::default() };
    let back = panel(Vec3::new(0.6, 2.2, BACK_Z_M), Vec3::X * 6.4, Vec3::Y * 4.4);
    place(glb, "back wall", back.untextured(), &plaster, Pose::origin());
    let side = panel(Vec3::new(WALL_X_M, 2.2, 0.6), Vec3::NEG_Z * 6.0, Vec3::Y * 4.4);
    place(glb, "side wall", side.untextured(), &plaster, Pose::origin());
    // Slabs of two greys.
    let stone = Material { roughness: 0.45, ..Material::default() };
    let slabs = (0..9).flat_map(|i| (0..9).map(move |j| (i, j))).map(|(i, j)| {
        let center = Vec3::new(WALL_X_M + 0.36 + 0.72 * i as f32, 0.0, BACK_Z_M + 0.36 + 0.72 * j as f32);
        let shade = 0.75 + 0.25 * (hash(IVec2::new(i, j), 7) % 256) as f32 / 255.0;
        let gray = linear(if (i + j) % 2 == 0 { 0xb4b0aa } else { 0x8f8b88 }) * shade;
        panel(center, Vec3::X * 0.715, Vec3::NEG_Z * 0.715).colored(move |_, _| gray)
    });
    place(glb, "floor", Mesh::merged(slabs).untextured(), &stone, Pose::origin());
}

/// A pointed arch, half a unit wide and one high: whether a place in it (x from -0.5 to 0.5, y from 0 to 1) is inside.
fn in_arch(p: Vec2) -> f32 {
    const SPRING: f32 = 0.55;
    let edge = |outside: f32| smoothstep(0.012, -0.012, outside);
    if p.y < SPRING {
        return edge(p.x.abs() - 0.46) * edge(0.03 - p.y);
    }
    // Two arcs that meet above the middle.
    let width = 0.92;
    let from_far_foot = Vec2::new(p.x.abs() + 0.46, (p.y - SPRING) * 1.9);
    edge(from_far_foot.length() - width)
}

/// Leaded panes: lozenges of glass, a medallion in the middle.
fn stained_glass(uv: Vec2) -> Vec3 {
    const GLASS: [u32; 6] = [0xc8102e, 0x1b4fd0, 0xf2b705, 0x128a4a, 0x7a1fa2, 0xe86a10];
    let p = Vec2::new(uv.x - 0.5, 1.0 - uv.y);
    let medallion = Vec2::new(p.x, (p.y - 0.52) * 1.45);
    let radius = medallion.length();
    let (lead, color) = if radius < 0.27 {
        let turns = medallion.y.atan2(medallion.x) / std::f32::consts::TAU + 0.5;
        let petal = (turns * 8.0).fract();
        let ring = (radius - 0.12).abs().min((radius - 0.255).abs());
        let spoke = if radius > 0.12 { (petal - 0.5).abs() - 0.5 } else { -1.0 };
        let lead = (ring < 0.012) || spoke.abs() * radius < 0.012;
        let index = if radius < 0.12 { 2 } else { (turns * 8.0) as usize % 2 };
        (lead, srgb(GLASS[index]))
    } else {
        let q = Vec2::new(p.x + p.y * 1.45, p.x - p.y * 1.45) * 5.0;
        let (cell, f) = (q.floor().as_ivec2(), q - q.floor());
        let lead = f.x.min(f.y).min(1.0 - f.x).min(1.0 - f.y) < 0.05;
        (lead, srgb(GLASS[hash(cell, 3) as usize % GLASS.len()]))
    };
    let glass = if lead { Vec3::splat(0.03) } else { color };
    glass * in_arch(p)
}

/// A rose window: petals around an eye.
fn rose(uv: Vec2) -> Vec3 {
    let p = (uv - 0.5) * 2.0;
    let (radius, turns) = (p.length(), p.y.atan2(p.x) / std::f32::consts::TAU + 0.5);
    let petal = ((turns * 12.0).fract() - 0.5).abs() * 2.0;
    let outer = smoothstep(0.0, 0.06, 0.95 - radius) * smoothstep(0.0, 0.06, radius - 0.42);
    // Round at the outer end.
    let round = Vec2::new(petal * radius * 0.26, (radius - 0.74).max(0.0)).length();
    let open = outer * smoothstep(0.0, 0.03, 0.2 * radius - round);
    let color = if ((turns * 12.0) as u32).is_multiple_of(2) { srgb(0xffd9a0) } else { srgb(0xff8fb0) };
    let eye = smoothstep(0.0, 0.04, 0.28 - radius) * smoothstep(0.0, 0.04, (radius - 0.14).abs() - 0.02);
    color * open + srgb(0x90c8ff) * eye
}

/// One side of the lantern: stars punched through its wall; the other sides are turned copies.
fn stars(uv: Vec2, side: usize) -> Vec3 {
    let mut light = 0.02_f32;
    // One in each of three by three fields.
    for field in 0..9 {
        let random = |n: usize| pick(field * 4 + n, 11 + side as u32);
        let corner = Vec2::new((field % 3) as f32, (field / 3) as f32);
        let d = uv - (corner + 0.3 + 0.4 * Vec2::new(random(0), random(1))) / 3.0;
        let turns = d.y.atan2(d.x) / std::f32::consts::TAU + random(2);
        // Between a tip and the next notch the edge is straight.
        let angle = ((turns * 5.0).rem_euclid(1.0) - 0.5).abs() * std::f32::consts::TAU / 5.0;
        let size = 0.035 + 0.045 * random(3);
        let (tip, notch) = (circle(0.1) * size, Vec2::X * size * 0.42);
        let normal = (tip - notch).perp().normalize();
        let at = Vec2::from_angle(angle) * d.length();
        light = light.max(smoothstep(0.006, -0.006, -normal.dot(at - notch)));
    }
    srgb(0xffe6b8) * light
}

fn window(glb: &mut Glb) {
    let glass = glb.texture("stained glass", &picture(256, stained_glass));
    let pane = Material {
        base_color: Vec3::splat(0.02),
        roughness: 0.3,
        emissive: Vec3::ONE,
        emissive_strength: 0.5,
        emissive_texture: Some(glass),
        ..Material::default()
    };
    let center = WINDOW + Vec3::X * 0.01;
    place(
        glb,
        "window",
        panel(center, Vec3::NEG_Z * WINDOW_M.x, Vec3::Y * WINDOW_M.y),
        &pane,
        Pose::origin(),
    );
    let sill = Material { base_color: linear(0xa89a86), roughness: 0.7, ..Material::default() };
    let ledge = cuboid(Vec3::new(0.16, 0.09, WINDOW_M.x + 0.2), 0.012).untextured();
    place(
        glb,
        "ledge",
        ledge,
        &sill,
        Pose::at(WINDOW.x + 0.08, WINDOW.y - 0.5 * WINDOW_M.y - 0.05, WINDOW.z),
    );
    // Moonlight in the shape of the window. It shines down into the room; the picture's up is the light's.
    let aim = Vec3::new(1.0, -0.95, 0.12);
    let down = aim.normalize();
    let up = (Vec3::Y - down * down.y).normalize();
    // The window as the light sees it is less high than it is.
    let size = [WINDOW_M.x, WINDOW_M.y * up.y, 12.0];
    let moon = Light {
        name: "moonlight",
        color: Vec3::new(0.85, 0.92, 1.0),
        kind: LightKind::Directional { illuminance_lx: 4.5 },
    };
    let node = glb.light(moon, Pose::looking(WINDOW, WINDOW + aim));
    glb.extras(
        node,
        json!({
            "box": {"size": size, "falloff": 0.02},
            "globe_map": {"texture": glass.texture},
            "shadow": false,
            "priority": 2,
        }),
    );
}

fn lantern(glb: &mut Glb) {
    let sides: Vec<_> = (0..6)
        .map(|i| glb.texture(&format!("stars {i}"), &picture(128, move |uv| stars(uv, i))).texture)
        .collect();
    let iron =
        Material { base_color: linear(0x57524c), metallic: 1.0, roughness: 0.5, ..Material::default() };
    let [x, y, z] = LANTERN.to_array();
    let cap =
        lathe(&[(0.0, 0.2), (0.16, 0.11), (0.16, 0.1), (0.0, 0.1)].map(Vec2::from).map(|p| p * 1.0), 24, 1.0);
    place(glb, "lantern cap", cap.untextured(), &iron, Pose::at(x, y, z));
    let rod = lathe(&[(0.0, 0.19), (0.012, 0.19), (0.012, 2.4), (0.0, 2.4)].map(Vec2::from), 8, 1.0);
    place(glb, "lantern rod", rod.untextured(), &iron, Pose::at(x, y, z));
    let glow = Material {
        base_color: Vec3::splat(0.2),
        emissive: Vec3::new(1.0, 0.75, 0.4),
        emissive_strength: 1.5,
        ..Material::default()
    };
    place(glb, "lantern globe", sphere(0.1, 24, 16).untextured(), &glow, Pose::at(x, y, z));
    let kind = LightKind::Point { intensity_cd: 6.0, range_m: 6.0 };
    let light = Light { name: "star lantern", color: Vec3::new(1.0, 0.8, 0.5), kind };
    let node = glb.light(light, Pose::at(x, y, z).turned(0.06));
    glb.extras(node, json!({"globe_map": {"textures": sides, "rotation": 20}, "shadow": false}));
}

/// What stands on the floor.
fn things(glb: &mut Glb) {
    let stone = Material { base_color: linear(0xc9bfae), roughness: 0.75, ..Material::default() };
    for (name, x, z, height) in [
        ("pedestal", -0.75, -1.1, 0.8),
        ("low pedestal", 0.45, -0.35, 0.45),
        ("high pedestal", 1.2, -1.7, 1.05),
    ] {
        let shaft = cuboid(Vec3::new(0.5, height, 0.5), 0.02).at(0.0, 0.5 * height, 0.0);
        let plinth = cuboid(Vec3::new(0.62, 0.1, 0.62), 0.015).at(0.0, 0.05, 0.0);
        place(glb, name, Mesh::merged([shaft, plinth]).untextured(), &stone, Pose::at(x, 0.0, z));
    }
    let porcelain = Material { base_color: linear(0xf4f0ea), roughness: 0.25, ..Material::default() };
    place(glb, "ball", sphere(0.3, 40, 24).untextured(), &porcelain, Pose::at(-0.75, 1.1, -1.1));
    let gold =
        Material { base_color: linear(0xf0c060), metallic: 1.0, roughness: 0.3, ..Material::default() };
    let cup = [
        (0.0, 0.0),
        (0.13, 0.0),
        (0.13, 0.02),
        (0.03, 0.06),
        (0.025, 0.2),
        (0.06, 0.23),
        (0.15, 0.3),
        (0.17, 0.46),
        (0.155, 0.46),
        (0.13, 0.32),
        (0.0, 0.26),
    ];
    place(
        glb,
        "chalice",
        lathe(&cup.map(Vec2::from), 40, 1.0).untextured(),
        &gold,
        Pose::at(0.45, 0.45, -0.35),
    );
    let clay = Material { base_color: linear(0xd8cfc4), roughness: 0.6, ..Material::default() };
    let ring = lathe(&round_profile(Vec2::new(0.24, 0.0), 0.08, 12), 40, 1.0).untextured();
    place(glb, "ring", ring, &clay, Pose::at(1.2, 1.37, -1.7).rotated(Vec3::X, 0.2));
    let cone: Vec<_> = (0..=6).map(|i| circle(0.25 * i as f32 / 6.0) * Vec2::new(0.34, 0.62)).collect();
    let stone = Material { base_color: linear(0x9fb4c8), roughness: 0.5, ..Material::default() };
    place(
        glb,
        "boulder",
        lathe(&[&[Vec2::ZERO], &cone[..]].concat(), 32, 1.0).untextured(),
        &stone,
        Pose::at(-1.6, 0.0, 0.75),
    );
}

fn lights(glb: &mut Glb) {
    let rose = glb.texture("rose", &picture(256, rose)).texture;
    let kind = LightKind::Spot { intensity_cd: 70.0, range_m: 12.0, inner_rad: 0.19, outer_rad: 0.2 };
    let projector = Light { name: "projector", color: Vec3::ONE, kind };
    let node = glb.light(projector, Pose::looking(Vec3::new(0.6, 2.6, 4.0), Vec3::new(0.25, 2.75, BACK_Z_M)));
    glb.extras(node, json!({"globe_map": {"texture": rose, "rotation": 15}, "shadow": false}));

    let night = Light {
        name: "night",
        color: Vec3::new(0.35, 0.45, 0.8),
        kind: LightKind::Directional { illuminance_lx: 0.5 },
    };
    let node = glb.light(night, Pose::looking(Vec3::Y * 4.0, Vec3::ZERO));
    glb.extras(node, json!({"ground_color": [0.3, 0.2, 0.12]}));

    let door = Light {
        name: "door",
        color: Vec3::new(1.0, 0.72, 0.45),
        kind: LightKind::Directional { illuminance_lx: 0.25 },
    };
    let node = glb.light(door, Pose::looking(Vec3::new(3.0, 1.6, 2.2), Vec3::new(0.0, 1.2, 0.0)));
    glb.extras(node, json!({"back_color": [0.12, 0.2, 0.5], "shadow": false}));

    let kind = LightKind::Point { intensity_cd: 0.8, range_m: 2.5 };
    let candle = Light { name: "candle", color: Vec3::new(1.0, 0.6, 0.25), kind };
    glb.light(candle, Pose::at(-0.15, 0.75, 0.35));
}

//! Everything that moves: a snake of seven joints rises from a basket, a ball bounces and is squashed where it does, a lantern swings.
//! `ontile render assets/charmer.glb --time 1.3`; without a time the snake stands still.

use super::glb::moving::Track;
use super::glb::{Glb, Light, LightKind, Material, Pose, place};
use super::mesh::{Mesh, Vertex};
use super::noise::smoothstep;
use super::shape::{circle, cuboid, lathe, sphere, tube};
use super::texture::linear;
use glam::{Mat4, Quat, Vec2, Vec3};
use serde_json::json;

/// Between joints.
const LINK_M: f32 = 0.19;
const JOINTS: usize = 7;
const BALL_M: f32 = 0.17;

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    stage(&mut glb);
    let mut tracks = snake(&mut glb);
    tracks.extend(ball(&mut glb));
    tracks.push(lantern(&mut glb));
    let tracks: Vec<_> = tracks.iter().map(|(node, keys)| (*node, keys.track())).collect();
    glb.animation("dance", &tracks);
    let fill =
        Light { name: "moon", color: linear(0xa8c0ff), kind: LightKind::Directional { illuminance_lx: 3.0 } };
    let moon = glb.light(fill, Pose::looking(Vec3::new(2.0, 3.0, 3.0), Vec3::ZERO));
    glb.extras(moon, json!({"shadow": false}));
    glb.perspective("main", 38.0, Pose::looking(Vec3::new(0.35, 1.15, 3.0), Vec3::new(0.12, 0.62, 0.0)));
    glb.finish("charmer")
}

/// What a track is made of.
enum Keys {
    Spline(Vec<(f32, Vec3, Vec3)>),
    Turns(Vec<(f32, Quat)>),
    Weights(Vec<(f32, f32)>),
}

impl Keys {
    fn track(&self) -> Track<'_> {
        match self {
            Self::Spline(keys) => Track::Spline(keys),
            Self::Turns(keys) => Track::Turns(keys),
            Self::Weights(keys) => Track::Weights(keys),
        }
    }
}

fn turn(axis: Vec3, turns: f32) -> Quat {
    Pose::origin().rotated(axis, turns).rotation
}

fn stage(glb: &mut Glb) {
    let sand = Material { base_color: linear(0xc2925a), roughness: 0.85, ..Material::default() };
    let ground = Mesh::patch(12, 12, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * 8.0, 0.0, (0.5 - v) * 8.0),
        normal: Vec3::Y,
        texcoord: Vec2::new(u, v),
    });
    place(glb, "sand", ground.untextured(), &sand, Pose::origin());
    let plaster = Material { base_color: linear(0x7d4f3f), roughness: 0.9, ..Material::default() };
    place(
        glb,
        "wall",
        cuboid(Vec3::new(8.0, 4.0, 0.2), 0.0).untextured(),
        &plaster,
        Pose::at(0.0, 2.0, -1.6),
    );
    let wicker = Material { base_color: linear(0x8a5a2b), roughness: 0.6, ..Material::default() };
    let profile: Vec<Vec2> = (0..=16)
        .map(|i| {
            let v = i as f32 / 16.0;
            Vec2::new(0.26 + 0.1 * circle(v * 0.5).y - 0.05 * v, 0.36 * v)
        })
        .chain([Vec2::new(0.18, 0.36), Vec2::new(0.22, 0.04), Vec2::new(0.0, 0.04)])
        .collect();
    place(glb, "basket", lathe(&profile, 32, 1.0).untextured(), &wicker, Pose::at(-0.35, 0.0, 0.0));
}

/// A tapering tube along its joints, each of which sways a little later than the one below, and a head on the last.
fn snake(glb: &mut Glb) -> Vec<(usize, Keys)> {
    let length_m = LINK_M * JOINTS as f32;
    let skin = Material { base_color: linear(0x2f8f5b), roughness: 0.35, ..Material::default() };
    let body = Mesh::patch(20, 56, |u, v| {
        let (around, radius_m) = (circle(u), 0.085 - 0.05 * smoothstep(0.5, 1.0, v));
        let normal = Vec3::new(around.x, 0.0, -around.y);
        Vertex { position: normal * radius_m + Vec3::Y * (v * length_m), normal, texcoord: Vec2::new(u, v) }
    });
    let joints: Vec<(u8, f32)> = body
        .positions
        .iter()
        .map(|p| {
            let place = (p.y / LINK_M - 0.5).clamp(0.0, (JOINTS - 1) as f32 - 1e-4);
            (place as u8, smoothstep(0.0, 1.0, place - place.floor()))
        })
        .collect();
    let mut geometry = glb.geometry(&body.untextured());
    glb.bend(&mut geometry, &joints);
    let scales = glb.material(&Material { name: "scales", ..skin.clone() });
    let mesh = glb.mesh("snake", &[(&geometry, scales)]);
    let snake = glb.place("snake", mesh, Pose::origin());

    // From the head down: a node names its children.
    let eye =
        Material { name: "eye", base_color: linear(0xffd24a), emissive: linear(0x806010), ..skin.clone() };
    let head = glb.geometry(&sphere(0.085, 20, 12).untextured());
    let head = glb.mesh("head", &[(&head, scales)]);
    let pupil = glb.geometry(&sphere(0.02, 10, 6).untextured());
    let eye = glb.material(&eye);
    let pupil = glb.mesh("eye", &[(&pupil, eye)]);
    let eyes = [-0.05, 0.05].map(|x| glb.place("eye", pupil, Pose::at(x, 0.035, 0.07)));
    let face = glb.place("head", head, Pose::origin().scaled(1.0, 0.75, 1.35));
    let mut child = glb.group("face", &[face, eyes[0], eyes[1]], Pose::at(0.0, LINK_M, 0.03));
    let mut nodes = Vec::new();
    for i in (0..JOINTS).rev() {
        let pose = if i == 0 { Pose::at(-0.35, 0.05, 0.0) } else { Pose::at(0.0, LINK_M, 0.0) };
        child = glb.group("joint", &[child], pose);
        nodes.push(child);
    }
    nodes.reverse();
    let bind: Vec<_> = (0..JOINTS).map(|i| Mat4::from_translation(Vec3::Y * (-LINK_M * i as f32))).collect();
    glb.skin(snake, &nodes, &bind);

    let mut tracks: Vec<_> = nodes[1..]
        .iter()
        .enumerate()
        .map(|(i, &node)| {
            let keys = (0..=8).map(|key| {
                let phase = key as f32 / 8.0 - i as f32 * 0.11;
                let sway = turn(Vec3::Z, 0.045 * circle(phase).y);
                // The neck is bent forwards.
                let nod = turn(Vec3::X, if i > 3 { 0.07 } else { -0.015 } + 0.02 * circle(phase * 2.0).x);
                (key as f32 * 0.5, sway * nod)
            });
            (node, Keys::Turns(keys.collect()))
        })
        .collect();
    let rise = |y: f32| Vec3::new(-0.35, y, 0.0);
    let none = Vec3::ZERO;
    let heights = vec![
        (0.0, rise(-0.9), none),
        (1.2, rise(0.05), none),
        (3.2, rise(0.05), none),
        (4.0, rise(-0.9), none),
    ];
    tracks.push((nodes[0], Keys::Spline(heights)));
    tracks
}

/// It is flat where it touches the ground, at every whole second.
fn ball(glb: &mut Glb) -> Vec<(usize, Keys)> {
    let rubber = Material { base_color: linear(0xc8352b), roughness: 0.4, ..Material::default() };
    let mesh = sphere(BALL_M, 28, 16).untextured();
    let squashed: Vec<_> =
        mesh.positions.iter().map(|p| Vec3::new(p.x * 0.35, -p.y * 0.4, p.z * 0.35)).collect();
    // Normals of the ellipsoid, less those of the ball.
    let normals: Vec<_> =
        mesh.normals.iter().map(|n| Vec3::new(n.x / 1.35, n.y / 0.6, n.z / 1.35).normalize() - *n).collect();
    let geometry = glb.geometry(&mesh);
    let material = glb.material(&Material { name: "rubber", ..rubber });
    let mesh = glb.mesh("ball", &[(&geometry, material)]);
    glb.target(mesh, &squashed, &normals);
    let node = glb.place("ball", mesh, Pose::at(0.75, BALL_M * 0.6, 0.35));
    let low = Vec3::new(0.75, BALL_M * 0.6, 0.35);
    let mut places = Vec::new();
    for second in 0..4 {
        let start = second as f32;
        places.push((start, low, Vec3::Y * if second == 0 { 2.6 } else { 0.0 }));
        places.push((start + 0.08, low + Vec3::Y * 0.1, Vec3::Y * 2.6));
        places.push((start + 0.5, low + Vec3::Y * 0.75, Vec3::ZERO));
        places.push((start + 0.92, low + Vec3::Y * 0.1, Vec3::NEG_Y * 2.6));
    }
    places.push((4.0, low, Vec3::ZERO));
    let squash = (0..4).flat_map(|s| [(s as f32, 1.0), (s as f32 + 0.08, 0.0), (s as f32 + 0.92, 0.0)]);
    vec![(node, Keys::Spline(places)), (node, Keys::Weights(squash.chain([(4.0, 1.0)]).collect()))]
}

/// A spot in a cage on a rope, which swings.
fn lantern(glb: &mut Glb) -> (usize, Keys) {
    let iron =
        Material { base_color: linear(0x303038), metallic: 1.0, roughness: 0.5, ..Material::default() };
    let rope = tube(&[Vec3::ZERO, Vec3::Y * -0.45, Vec3::Y * -0.9], 0.012, 8);
    let parts = Mesh::merged([rope, cuboid(Vec3::new(0.16, 0.03, 0.16), 0.0).at(0.0, -0.9, 0.0)]);
    let geometry = glb.geometry(&parts.untextured());
    let material = glb.material(&Material { name: "iron", ..iron });
    let cage = glb.mesh("lantern", &[(&geometry, material)]);
    let cage = glb.place("lantern", cage, Pose::origin());
    let glow = glb.geometry(&sphere(0.05, 16, 10).untextured());
    let flame = Material {
        name: "flame",
        base_color: Vec3::ZERO,
        emissive: linear(0xffb060),
        emissive_strength: 3.0,
        ..Material::default()
    };
    let flame = glb.material(&flame);
    let glow = glb.mesh("flame", &[(&glow, flame)]);
    let glow = glb.place("flame", glow, Pose::at(0.0, -0.95, 0.0));
    let light = Light {
        name: "lantern",
        color: linear(0xffc890),
        kind: LightKind::Spot { intensity_cd: 18.0, range_m: 9.0, inner_rad: 0.5, outer_rad: 0.85 },
    };
    let below = Pose::looking(Vec3::new(0.0, -1.02, 0.0), Vec3::new(0.0, -2.0, -0.12));
    let light = glb.light(light, below);
    // It never hangs still: a map of its shadows would be drawn anew for every frame.
    glb.extras(light, json!({"shadow": {"volume": true}}));
    let pivot = glb.group("pivot", &[cage, glow, light], Pose::at(0.25, 2.45, 0.25));
    let swing = (0..=8).map(|i| {
        let t = i as f32 / 8.0;
        (4.0 * t, turn(Vec3::Z, 0.03 * circle(t * 2.0).y))
    });
    (pivot, Keys::Turns(swing.collect()))
}

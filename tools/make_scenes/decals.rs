//! A corner of a workshop that has seen use: everything that makes it look so is a decal. Plain walls, a floor, a drum and a crate
//! are painted, dented, polished and stained; one sign reaches around the corner, and what was painted later covers what was before.

use super::glb::{Glb, Light, LightKind, Material, Pose, Slot, paint, place};
use super::mesh::{Mesh, Vertex};
use super::noise::{fractal, smoothstep};
use super::shape::{circle, cuboid, lathe};
use super::texture::{Surface, Texel, linear, masked_picture, srgb};
use glam::{IVec2, Vec2, Vec3};
use serde_json::json;

/// Where the walls meet.
const CORNER_M: Vec2 = Vec2::new(-1.6, -1.5);

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    room(&mut glb);
    drum(&mut glb);
    crate_(&mut glb);
    on_walls(&mut glb);
    on_floor(&mut glb);
    on_things(&mut glb);
    lights(&mut glb);
    let target = Vec3::new(-0.12, 0.66, -0.6);
    glb.perspective("main", 41.0, Pose::looking(Vec3::new(1.8, 1.85, 2.75), target));
    glb.perspective("corner", 34.0, Pose::looking(Vec3::new(0.1, 1.5, 0.5), Vec3::new(-1.5, 1.35, -1.4)));
    glb.perspective("grazing", 40.0, Pose::looking(Vec3::new(0.9, 0.22, 1.6), Vec3::new(-0.5, 0.1, -0.9)));
    glb.finish("decals")
}

/// A rectangle whose texture runs in metres.
fn sheet(width_m: f32, height_m: f32) -> Mesh {
    Mesh::patch(8, 8, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * width_m, v * height_m, 0.0),
        normal: Vec3::Z,
        texcoord: Vec2::new(u * width_m, (1.0 - v) * height_m),
    })
}

/// Bricks under old whitewash, 1 m of them.
fn bricks() -> Surface {
    Surface::sample(256, 1.0, |uv| {
        let course = (uv.y * 8.0).floor();
        let x = uv.x * 4.0 + 0.5 * (course as i32 % 2) as f32;
        let (along, up) = (x - x.floor(), uv.y * 8.0 - course);
        let edge_m = (along.min(1.0 - along) * 0.25).min(up.min(1.0 - up) * 0.125);
        let grain = fractal(uv, IVec2::splat(12), 3, 5);
        Texel {
            albedo: Vec3::ONE,
            height_m: 0.008 * smoothstep(0.002, 0.016, edge_m) + 0.0012 * grain,
            roughness: 1.0,
            metallic: 0.0,
        }
    })
}

fn room(glb: &mut Glb) {
    let bumps = glb.texture("bricks", &bricks().normal());
    let washed = Material {
        base_color: linear(0xb9b4a8),
        roughness: 0.82,
        normal_texture: Some(bumps),
        normal_scale: 0.8,
        ..Material::default()
    };
    let [x, z] = CORNER_M.to_array();
    place(glb, "back wall", sheet(4.4, 2.6), &washed, Pose::at(x + 2.2, 0.0, z));
    place(glb, "side wall", sheet(4.4, 2.6), &washed, Pose::at(x, 0.0, z + 2.2).turned(0.25));
    let concrete = Material { base_color: linear(0x77777a), roughness: 0.66, ..Material::default() };
    let floor = sheet(4.4, 4.4).at(0.0, -2.2, 0.0);
    place(glb, "floor", floor, &concrete, Pose::at(x + 2.2, 0.0, z + 2.2).rotated(Vec3::X, -0.25));
}

fn drum(glb: &mut Glb) {
    let rings = [
        (0.0, 0.0),
        (0.285, 0.0),
        (0.3, 0.012),
        (0.3, 0.03),
        (0.285, 0.045),
        (0.285, 0.28),
        (0.3, 0.295),
        (0.3, 0.305),
        (0.285, 0.32),
        (0.285, 0.57),
        (0.3, 0.585),
        (0.3, 0.595),
        (0.285, 0.61),
        (0.285, 0.845),
        (0.3, 0.86),
        (0.3, 0.885),
        (0.275, 0.885),
        (0.27, 0.87),
        (0.0, 0.87),
    ];
    let blue = Material { base_color: linear(0x2b5d86), roughness: 0.38, ..Material::default() };
    let drum = lathe(&rings.map(Vec2::from), 48, 1.0).untextured();
    place(glb, "drum", drum, &blue, Pose::at(-0.75, 0.0, -0.85));
}

fn crate_(glb: &mut Glb) {
    let wood = Material { base_color: linear(0xa67c4e), roughness: 0.7, ..Material::default() };
    let shape = cuboid(Vec3::new(0.62, 0.5, 0.5), 0.012).untextured();
    place(glb, "crate", shape, &wood, Pose::at(0.42, 0.25, -0.95).turned(-0.06));
}

/// What a decal's material paints; its alpha is in the picture.
fn ink(glb: &mut Glb, name: &'static str, mask: Slot) -> usize {
    glb.material(&Material { name, base_color_texture: Some(mask), roughness: 0.55, ..Material::default() })
}

/// Worn away in spots: 1 is whole.
fn worn(uv: Vec2, seed: u32) -> f32 {
    smoothstep(-0.42, -0.22, fractal(uv, IVec2::splat(9), 3, seed))
}

fn inside(uv: Vec2) -> f32 {
    let edge = (uv - 0.5).abs().max_element();
    1.0 - smoothstep(0.47, 0.49, edge)
}

fn on_walls(glb: &mut Glb) {
    let [x, z] = CORNER_M.to_array();
    // A ring and a bolt, sprayed through a stencil, across the corner of both walls.
    let sign = masked_picture(256, |uv| {
        let p = (uv - 0.5) * 2.0;
        let ring = smoothstep(0.03, 0.0, (p.length() - 0.74).abs() - 0.1);
        let bolt = {
            let q = Vec2::new(p.x + 0.32 * p.y, p.y);
            let half = 0.26 - 0.2 * q.y.abs();
            let step = if q.y < 0.0 { q.x - 0.1 } else { q.x + 0.1 };
            smoothstep(0.02, 0.0, step.abs() - half.max(0.0)) * smoothstep(0.62, 0.58, q.y.abs())
        };
        let spray = 1.0 - 0.35 * fractal(uv, IVec2::splat(40), 2, 3).abs();
        (srgb(0xd8a313), ring.max(bolt) * worn(uv, 21) * spray * inside(uv))
    });
    let sign = glb.texture("warning", &sign);
    let sign = ink(glb, "warning", sign);
    let pose = Pose::at(x, 1.55, z).turned(0.125);
    let color = json!({"base_color": 0.95, "roughness": 0.6});
    let across = json!({"channels": color, "angle": [55, 75]});
    paint(glb, "warning around the corner", sign, pose, Vec3::new(1.15, 1.15, 1.4), across);

    // A notice, and another one pasted over it later.
    let notice = |hue: u32, lines: u32, seed: u32| {
        masked_picture(128, move |uv| {
            let row = (uv.y * 16.0).floor() as i32;
            let is_line = row >= 5 && (row as u32) < 5 + lines && row % 2 == 1;
            let end = 0.86 - 0.3 * super::noise::unit(IVec2::new(row, 0), seed);
            let ink = is_line && uv.x > 0.14 && uv.x < end;
            let head = uv.y > 0.1 && uv.y < 0.24 && uv.x > 0.14 && uv.x < 0.86;
            let paper = srgb(0xe9e2cf) * (0.94 + 0.06 * fractal(uv, IVec2::splat(8), 2, seed));
            let color = if head {
                srgb(hue)
            } else if ink {
                srgb(0x3a3a40)
            } else {
                paper
            };
            let torn = uv.x + uv.y > 0.12 + 0.05 * fractal(uv, IVec2::splat(10), 2, seed + 1);
            (color, if torn { inside(uv) } else { 0.0 })
        })
    };
    for (name, hue, lines, at, turns, priority) in [
        ("older notice", 0x1f5f3f, 9, Vec3::new(0.05, 1.5, z), 0.008, 0),
        ("newer notice", 0xa82a1c, 7, Vec3::new(0.33, 1.38, z), -0.012, 1),
    ] {
        let picture = glb.texture(name, &notice(hue, lines, 31 + priority as u32));
        let paper = ink(glb, name, picture);
        let pose = Pose { position_m: at, ..Pose::origin() }.rotated(Vec3::Z, turns);
        let size = Vec3::new(0.42, 0.56, 0.2);
        paint(glb, name, paper, pose, size, json!({"priority": priority}));
    }

    // Dents: normals alone, over the bricks' own.
    let dents = Surface::sample(128, 1.0, |uv| {
        let holes =
            [(0.3, 0.32, 0.1), (0.62, 0.25, 0.07), (0.5, 0.6, 0.12), (0.75, 0.68, 0.08), (0.24, 0.72, 0.07)];
        let depth = |(x, y, r): (f32, f32, f32)| {
            let d = uv.distance(Vec2::new(x, y)) / r;
            -0.028 * smoothstep(1.0, 0.35, d) + 0.008 * smoothstep(1.45, 1.0, d) * smoothstep(0.8, 1.0, d)
        };
        let height_m = holes.map(depth).into_iter().sum();
        Texel { albedo: Vec3::ONE, height_m, roughness: 1.0, metallic: 0.0 }
    });
    let dents = glb.texture("dents", &dents.normal());
    let dented =
        glb.material(&Material { name: "dents", normal_texture: Some(dents), ..Material::default() });
    let normal = json!({"channels": {"normal": 1.0}});
    let wall = Pose::at(0.95, 1.2, z);
    paint(glb, "dents in the wall", dented, wall, Vec3::new(0.9, 0.9, 0.3), normal.clone());
    let side = Pose::at(-0.75, 0.45, -0.6);
    paint(glb, "dents in the drum", dented, side, Vec3::new(0.42, 0.42, 0.3), normal);

    // Damp that rises from the floor: darker, and smoother.
    let damp = masked_picture(128, |uv| {
        let wave = fractal(Vec2::new(uv.x, 0.3), IVec2::splat(6), 3, 71);
        let rise = smoothstep(0.42, 0.75, uv.y + 0.2 * wave) * smoothstep(0.985, 0.95, uv.y);
        (srgb(0x4a463c), 0.8 * rise * inside(Vec2::new(uv.x, 0.5)))
    });
    let damp = glb.texture("damp", &damp);
    let damp = glb.material(&Material {
        name: "damp",
        base_color_texture: Some(damp),
        roughness: 0.3,
        ..Material::default()
    });
    let rising = json!({"channels": {"base_color": 0.75, "roughness": 0.8}, "falloff": [0.3, 0, 0]});
    paint(glb, "damp", damp, Pose::at(x + 2.3, 0.32, z), Vec3::new(3.4, 0.75, 0.2), rising);
}

fn on_floor(glb: &mut Glb) {
    let down = |x: f32, z: f32, turns: f32| Pose::at(x, 0.0, z).turned(turns).rotated(Vec3::X, -0.25);
    let stripes = masked_picture(128, |uv| {
        let band = (uv.x * 10.0 + uv.y * 2.0).rem_euclid(2.0) < 1.0;
        let color = if band { srgb(0xd9a21b) } else { srgb(0x1d1c1a) };
        (color, worn(uv * 0.7, 41) * (1.0 - smoothstep(0.44, 0.49, (uv.y - 0.5).abs())))
    });
    let stripes = glb.texture("stripes", &stripes);
    let stripes = ink(glb, "stripes", stripes);
    let flat = json!({"channels": {"base_color": 0.9, "roughness": 0.5}});
    paint(glb, "stripes", stripes, down(0.2, 0.3, 0.02), Vec3::new(3.2, 0.24, 0.2), flat);

    // Water: nothing but roughness, and what little it darkens; over the stripes.
    let puddle = masked_picture(128, |uv| {
        let p = (uv - 0.5) * 2.0;
        let edge = 0.72 + 0.24 * fractal(uv, IVec2::splat(3), 3, 51);
        (srgb(0x40444a), smoothstep(edge, edge - 0.1, p.length()))
    });
    let puddle = glb.texture("puddle", &puddle);
    let water = glb.material(&Material {
        name: "water",
        base_color_texture: Some(puddle),
        roughness: 0.11,
        ..Material::default()
    });
    let gloss = json!({"channels": {"roughness": 1.0}, "priority": 2});
    paint(glb, "puddle", water, down(0.5, 0.35, 0.1), Vec3::new(1.7, 1.5, 0.15), gloss);
    let oil = json!({"channels": {"base_color": 0.8, "roughness": 0.9}, "priority": 1});
    paint(glb, "oil", water, down(-0.75, -0.45, 0.4), Vec3::new(0.8, 0.75, 0.15), oil);
}

fn on_things(glb: &mut Glb) {
    // Bare metal where the drum's paint has rubbed off: colour, metallicness and roughness at once.
    let rubbed = masked_picture(128, |uv| {
        let p = (uv - 0.5) * 2.0;
        let patch = smoothstep(0.95, 0.55, p.length() + 0.55 * fractal(uv, IVec2::splat(6), 4, 61));
        (srgb(0xc9c4ba), patch * inside(uv))
    });
    let rubbed = glb.texture("bare metal", &rubbed);
    let bare = glb.material(&Material {
        name: "bare metal",
        base_color_texture: Some(rubbed),
        metallic: 1.0,
        roughness: 0.58,
        ..Material::default()
    });
    let whole = json!({"channels": {"base_color": 1, "metallic": 1, "roughness": 1}, "angle": [50, 80]});
    let pose = Pose::at(-0.58, 0.64, -0.62).turned(0.09);
    paint(glb, "bare metal", bare, pose, Vec3::new(0.5, 0.42, 0.4), whole.clone());
    let lid = Pose::at(-0.72, 0.87, -0.82).rotated(Vec3::X, -0.25);
    paint(glb, "bare lid", bare, lid, Vec3::new(0.45, 0.4, 0.1), whole);

    // A stencilled arrow on the crate's face and over its edge to the top, where the angle ends it.
    let arrow = masked_picture(128, |uv| {
        let p = (uv - 0.5) * 2.0;
        let shaft = p.x.abs() < 0.16 && p.y > -0.1 && p.y < 0.75;
        let head = p.y < 0.0 && p.y > -0.7 && p.x.abs() < 0.7 + p.y;
        let bar = p.y > 0.82 && p.y < 0.92 && p.x.abs() < 0.6;
        (srgb(0x2a1c10), if shaft || head || bar { worn(uv, 81) } else { 0.0 })
    });
    let arrow = glb.texture("arrow", &arrow);
    let arrow = ink(glb, "arrow", arrow);
    let face = circle(-0.06 - 0.25) * Vec2::new(1.0, 1.0);
    let at = Pose::at(0.42 - 0.25 * face.x, 0.3, -0.95 - 0.25 * face.y).turned(-0.06);
    let color = json!({"channels": {"base_color": 0.9}});
    paint(glb, "arrow", arrow, at, Vec3::new(0.42, 0.42, 0.3), color);
}

fn lights(glb: &mut Glb) {
    let kind = LightKind::Spot { intensity_cd: 26.0, range_m: 7.0, inner_rad: 0.35, outer_rad: 0.75 };
    let lamp = Light { name: "lamp", color: Vec3::new(1.0, 0.86, 0.66), kind };
    glb.light(lamp, Pose::looking(Vec3::new(0.9, 2.7, 1.1), Vec3::new(-0.3, 0.4, -0.8)));
    let kind = LightKind::Point { intensity_cd: 2.2, range_m: 5.0 };
    let window = Light { name: "window", color: Vec3::new(0.55, 0.72, 1.0), kind };
    glb.light(window, Pose::at(1.7, 1.5, -0.9));
    // The puddle mirrors it.
    let kind = LightKind::Spot { intensity_cd: 5.0, range_m: 5.0, inner_rad: 0.35, outer_rad: 0.65 };
    let lantern = Light { name: "lantern", color: Vec3::new(0.8, 1.0, 0.9), kind };
    glb.light(lantern, Pose::looking(Vec3::new(-0.2, 1.15, -1.3), Vec3::new(0.6, 0.0, 0.35)));
    // From all around, as light that decals are lit by too.
    let kind = LightKind::Directional { illuminance_lx: 0.9 };
    let sky = glb.light(
        Light { name: "fill", color: Vec3::new(0.75, 0.85, 1.0), kind },
        Pose::origin().rotated(Vec3::X, -0.25),
    );
    glb.extras(sky, json!({"ground_color": [0.5, 0.42, 0.35]}));
}

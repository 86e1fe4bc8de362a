//! A tram stop at dusk: all that can be on the tile at once. Setts with normal maps, a hedge and a fence with alpha masks, decals on
//! ground, wall and bench, panes before each other, a lit poster, the low sun and a string of bulbs, a sky.

use super::glb::{Glb, Light, LightKind, Material, Pose, paint, place};
use super::mesh::{Mesh, Vertex};
use super::noise::{cellular, fractal, pick, smoothstep, unit};
use super::shape::{cuboid, lathe, sphere};
use super::texture::{Surface, Texel, linear, masked_picture, picture, srgb};
use glam::{IVec2, Vec2, Vec3};
use serde_json::json;

/// The sky's file beside the scene's.
pub const SKY: &str = "dusk.hdr";

/// The sky's picture, rows.
const SKY_ROWS: u32 = 96;

/// Where the sun is.
const SUN: Vec3 = Vec3::new(-0.78, 0.3, 0.42);

/// How many bulbs hang under the roof's edge.
const BULBS: usize = 14;

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    ground(&mut glb);
    shelter(&mut glb);
    plants(&mut glb);
    on_ground(&mut glb);
    on_wall(&mut glb);
    lights(&mut glb);
    glb.scene_extras(json!({"environment": {"file": SKY}, "background": "environment"}));
    let target = Vec3::new(-0.1, 0.8, 0.0);
    glb.perspective("main", 42.0, Pose::looking(Vec3::new(1.75, 2.05, 4.75), target));
    glb.perspective("through", 36.0, Pose::looking(Vec3::new(-2.9, 1.3, 1.6), Vec3::new(0.1, 0.9, -0.5)));
    glb.finish("stop")
}

/// The sky's bytes: a warm band over the horizon, brightest towards the sun, under blue; dim ground below.
pub fn sky() -> Vec<u8> {
    let size = [SKY_ROWS * 2, SKY_ROWS];
    let texel = |x: u32, y: u32| {
        let turns = (x as f32 + 0.5) / size[0] as f32;
        let up = super::shape::circle(0.25 - 0.5 * (y as f32 + 0.5) / size[1] as f32);
        // Texel columns run from -Z over +X, as environments are read.
        let around = super::shape::circle(turns);
        let d = Vec3::new(around.y * up.x, up.y, -around.x * up.x);
        let near = d.dot(SUN.normalize()).max(0.0);
        let high = smoothstep(-0.02, 0.55, d.y);
        let sky = Vec3::new(0.62, 0.36, 0.24).lerp(Vec3::new(0.10, 0.17, 0.36), high);
        let glow = Vec3::new(2.6, 1.2, 0.45) * near.powi(12) + Vec3::new(0.5, 0.25, 0.1) * near.powi(3);
        let ground = Vec3::new(0.07, 0.06, 0.055);
        let light = ground.lerp(sky + glow, smoothstep(-0.06, 0.02, d.y));
        image::Rgb(light.to_array())
    };
    let pixels: Vec<_> = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| texel(x, y))).collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes)
        .encode(&pixels, size[0] as usize, size[1] as usize)
        .expect("memory is writable and sizes agree");
    bytes
}

/// An upright rectangle that stands on y = 0, its texture in metres, or (`once`) once over it.
fn sheet(width_m: f32, height_m: f32, once: bool) -> Mesh {
    let scale = if once { Vec2::ONE } else { Vec2::new(width_m, height_m) };
    Mesh::patch(4, 4, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * width_m, v * height_m, 0.0),
        normal: Vec3::Z,
        texcoord: Vec2::new(u, 1.0 - v) * scale,
    })
}

/// Setts in staggered courses, 1 m of them.
fn setts() -> Surface {
    Surface::sample(128, 1.0, |uv| {
        let course = (uv.y * 6.0).floor();
        let x = uv.x * 5.0 + 0.5 * (course as i32 % 2) as f32;
        let cell = IVec2::new((x.floor() as i32).rem_euclid(5), course as i32);
        let (along, up) = (x - x.floor(), uv.y * 6.0 - course);
        let edge_m = (along.min(1.0 - along) * 0.2).min(up.min(1.0 - up) * 0.166);
        let stone = smoothstep(0.004, 0.026, edge_m);
        let grain = fractal(uv, IVec2::splat(16), 2, 5);
        let tone = 0.30 + 0.12 * unit(cell, 3) + 0.05 * grain;
        let color = srgb(0x4a4036).lerp(Vec3::new(1.02, 1.0, 0.97) * tone, stone);
        Texel {
            albedo: color,
            height_m: 0.02 * stone + 0.004 * (unit(cell, 9) - 0.5) + 0.002 * grain,
            roughness: 0.95 - 0.35 * stone,
            metallic: 0.0,
        }
    })
}

fn ground(glb: &mut Glb) {
    let setts = glb.textured("setts", &setts(), 1.0);
    let lying = Pose::at(0.0, 0.0, 0.0).rotated(Vec3::X, -0.25);
    let floor = sheet(26.0, 24.0, false).at(0.0, -9.0, 0.0).with_tangents();
    place(glb, "setts", floor, &setts, lying);
    let stone = Material { base_color: linear(0x9a948a), roughness: 0.7, ..Material::default() };
    let platform = cuboid(Vec3::new(4.6, 0.14, 1.9), 0.02).untextured();
    place(glb, "platform", platform, &stone, Pose::at(0.0, 0.07, -0.55));
    let plaster = Material { base_color: linear(0xb3a894), roughness: 0.85, ..Material::default() };
    let wall = cuboid(Vec3::new(2.2, 1.9, 0.2), 0.015).untextured();
    place(glb, "wall", wall, &plaster, Pose::at(-2.5, 0.95, -1.75));
    let rail =
        Material { base_color: linear(0xb8bcc0), metallic: 1.0, roughness: 0.28, ..Material::default() };
    for (name, z) in [("near rail", 2.1), ("far rail", 1.1)] {
        let bar = cuboid(Vec3::new(26.0, 0.03, 0.07), 0.01).untextured();
        place(glb, name, bar, &rail, Pose::at(0.0, 0.012, z));
    }
}

fn shelter(glb: &mut Glb) {
    let steel =
        Material { base_color: linear(0x2c4a44), metallic: 0.0, roughness: 0.35, ..Material::default() };
    let post = glb.geometry(&cuboid(Vec3::new(0.06, 2.2, 0.06), 0.008).untextured());
    let steel = glb.material(&Material { name: "painted steel", ..steel });
    let post = glb.mesh("post", &[(&post, steel)]);
    for x in [-1.5, -0.5, 0.5, 1.5] {
        glb.place("back post", post, Pose::at(x, 1.24, -1.25));
    }
    for x in [-1.5, 1.5] {
        glb.place("front post", post, Pose::at(x, 1.24, 0.05));
    }
    let beam = glb.geometry(&cuboid(Vec3::new(3.3, 0.09, 0.07), 0.01).untextured());
    let beam = glb.mesh("beam", &[(&beam, steel)]);
    for z in [-1.25, 0.05] {
        glb.place("beam", beam, Pose::at(0.0, 2.37, z));
    }
    let tinted = |name, color, alpha| Material {
        name,
        base_color: linear(color),
        roughness: 0.08,
        blend_alpha: Some(alpha),
        double_sided: true,
        ..Material::default()
    };
    let clear = glb.material(&tinted("glass", 0x9fc4bc, 0.22));
    let amber = glb.material(&tinted("amber glass", 0xe39a2e, 0.45));
    let rose = glb.material(&tinted("rose glass", 0xc23a50, 0.45));
    let pane = glb.geometry(&cuboid(Vec3::new(0.92, 1.7, 0.014), 0.003).untextured());
    for (x, material) in [(-1.0, amber), (0.0, clear), (1.0, rose)] {
        let mesh = glb.mesh("back pane", &[(&pane, material)]);
        glb.place("back pane", mesh, Pose::at(x, 1.25, -1.25));
    }
    let side = glb.geometry(&cuboid(Vec3::new(1.1, 1.7, 0.014), 0.003).untextured());
    let side = glb.mesh("side pane", &[(&side, clear)]);
    for x in [-1.5, 1.5] {
        glb.place("side pane", side, Pose::at(x, 1.25, -0.6).turned(0.25));
    }
    let roof = glb.geometry(&cuboid(Vec3::new(3.3, 0.02, 1.5), 0.004).untextured());
    let roof = glb.mesh("roof", &[(&roof, clear)]);
    glb.place("roof", roof, Pose::at(0.0, 2.44, -0.6));

    let wood = Material { base_color: linear(0x8a5f38), roughness: 0.55, ..Material::default() };
    for (index, z) in [-0.98, -0.86, -0.74].into_iter().enumerate() {
        let slat = cuboid(Vec3::new(1.9, 0.035, 0.1), 0.008).untextured();
        place(glb, ["back slat", "middle slat", "front slat"][index], slat, &wood, Pose::at(-0.3, 0.6, z));
    }
    let leg = glb.geometry(&cuboid(Vec3::new(0.06, 0.45, 0.3), 0.006).untextured());
    let leg = glb.mesh("leg", &[(&leg, steel)]);
    for x in [-1.0, 0.4] {
        glb.place("leg", leg, Pose::at(x, 0.36, -0.86));
    }
    poster(glb, steel);
}

/// A poster lit from behind, and its case.
fn poster(glb: &mut Glb, steel: usize) {
    let case = glb.geometry(&cuboid(Vec3::new(0.86, 1.36, 0.12), 0.012).untextured());
    let case = glb.mesh("case", &[(&case, steel)]);
    glb.place("case", case, Pose::at(2.15, 0.98, -0.75).turned(-0.055));
    let print = picture(96, |uv| {
        let hill = 0.62 + 0.09 * super::shape::circle(uv.x * 1.1 + 0.15).x;
        let sun = smoothstep(0.17, 0.16, uv.distance(Vec2::new(0.62, 0.42)));
        let sky = srgb(0xf2b84b).lerp(srgb(0xd9503a), uv.y * 1.5);
        let band = srgb(0x1f4f5c).lerp(srgb(0x0f2b3a), smoothstep(hill, 1.0, uv.y));
        let scene = if uv.y > hill { band } else { sky.lerp(srgb(0xfff2cf), sun) };
        let letters = uv.y > 0.84 && uv.y < 0.92 && (uv.x * 13.0).fract() < 0.66 && (uv.x - 0.5).abs() < 0.38;
        if letters { srgb(0xf6ead0) } else { scene }
    });
    let print = glb.texture("poster", &print);
    let lit = Material {
        base_color: Vec3::splat(0.05),
        roughness: 0.3,
        emissive: Vec3::ONE,
        emissive_texture: Some(print),
        emissive_strength: 1.4,
        ..Material::default()
    };
    let pose = Pose::at(2.13, 0.38, -0.685).turned(-0.055);
    place(glb, "poster", sheet(0.76, 1.2, true), &lit, pose);
}

/// Leaves on twigs, which an alpha mask cuts out.
fn leaves() -> super::texture::Encoded {
    let leaf = |i: usize| {
        let at = Vec2::new(pick(i, 1), pick(i, 2)) * 0.86 + 0.07;
        (at, super::shape::circle(pick(i, 3)), 0.055 + 0.03 * pick(i, 4), pick(i, 5))
    };
    let all: Vec<_> = (0..90).map(leaf).collect();
    masked_picture(128, |uv| {
        let over = all.iter().rev().find(|(at, along, size, _)| {
            let d = uv - *at;
            let (x, y) = (d.dot(*along) / *size, d.perp_dot(*along) / *size);
            x.abs() < 1.0 && y.abs() < 0.48 * (1.0 - x * x)
        });
        match over {
            Some((_, _, _, tone)) => (srgb(0x35541f).lerp(srgb(0x86a13c), *tone), 1.0),
            None => (srgb(0x4a6a2a), 0.0),
        }
    })
}

fn plants(glb: &mut Glb) {
    let leaves = glb.texture("leaves", &leaves());
    let leaf = Material {
        name: "hedge",
        base_color_texture: Some(leaves),
        roughness: 0.6,
        alpha_cutoff: Some(0.5),
        double_sided: true,
        ..Material::default()
    };
    let leaf = glb.material(&leaf);
    let card = glb.geometry(&sheet(0.8, 0.75, true));
    let card = glb.mesh("hedge", &[(&card, leaf)]);
    for i in 0..11 {
        let x = -1.35 + 0.27 * i as f32;
        let z = -2.15 + 0.16 * pick(i, 7);
        let turns = 0.12 * (pick(i, 8) - 0.5) + 0.5 * (i % 2) as f32;
        glb.place("hedge", card, Pose::at(x, 0.02 + 0.25 * pick(i, 9), z).turned(turns));
    }
    let pot = lathe(
        &[(0.0, 0.0), (0.17, 0.0), (0.2, 0.02), (0.26, 0.4), (0.28, 0.42), (0.24, 0.42), (0.22, 0.36)]
            .map(Vec2::from),
        32,
        1.0,
    );
    let clay = Material { base_color: linear(0xa85a36), roughness: 0.75, ..Material::default() };
    place(glb, "pot", pot.untextured(), &clay, Pose::at(-1.95, 0.0, 0.55));
    let bush = glb.geometry(&sheet(0.75, 0.7, true));
    let bush = glb.mesh("bush", &[(&bush, leaf)]);
    for i in 0..4 {
        let turns = i as f32 / 8.0;
        glb.place("bush", bush, Pose::at(-1.95, 0.34, 0.55).turned(turns));
    }

    // Wire that is thinner than a pixel from afar.
    let wire = masked_picture(64, |uv| {
        let near = |t: f32| (t - t.round()).abs();
        let line = near(uv.x + uv.y).min(near(uv.x - uv.y));
        (srgb(0x8d9396), smoothstep(0.13, 0.09, line))
    });
    let wire = glb.texture("wire", &wire).scaled(9.0);
    let mesh = Material {
        base_color_texture: Some(wire),
        metallic: 0.0,
        roughness: 0.4,
        alpha_cutoff: Some(0.5),
        double_sided: true,
        ..Material::default()
    };
    place(glb, "fence", sheet(2.4, 1.3, false), &mesh, Pose::at(3.0, 0.0, -1.9).turned(-0.03));
}

/// What a decal's material paints; its alpha is in the picture.
fn ink(glb: &mut Glb, name: &'static str, image: super::texture::Encoded, roughness: f32) -> usize {
    let mask = glb.texture(name, &image);
    glb.material(&Material { name, base_color_texture: Some(mask), roughness, ..Material::default() })
}

fn on_ground(glb: &mut Glb) {
    let down = |x: f32, y: f32, z: f32, turns: f32| Pose::at(x, y, z).turned(turns).rotated(Vec3::X, -0.25);
    let worn = |uv: Vec2, seed| smoothstep(-0.45, -0.2, fractal(uv, IVec2::splat(9), 3, seed));
    let line = masked_picture(64, |uv| {
        let across = (uv.y - 0.5).abs();
        (srgb(0xe3b423), worn(uv, 11) * smoothstep(0.46, 0.42, across))
    });
    let line = ink(glb, "yellow line", line, 0.5);
    let color = json!({"channels": {"base_color": 0.9, "roughness": 0.5}});
    paint(glb, "yellow line", line, down(0.0, 0.14, 0.27, 0.0), Vec3::new(4.4, 0.12, 0.1), color.clone());
    let stripe = masked_picture(64, |uv| (srgb(0xd9d6cc), worn(uv * 0.8, 17)));
    let stripe = ink(glb, "crossing", stripe, 0.6);
    for i in 0..4 {
        let pose = down(0.75 + 0.5 * i as f32, 0.0, 1.6, 0.0);
        paint(glb, "crossing", stripe, pose, Vec3::new(0.27, 1.7, 0.12), color.clone());
    }

    // A lid of cast iron: colour, bumps, metallicness and roughness at once.
    let lid = Surface::sample(128, 0.7, |uv| {
        let p = (uv - 0.5) * 2.0;
        let ring = smoothstep(0.06, 0.02, (p.length() - 0.86).abs());
        let studs = (uv * 12.0).fract() - 0.5;
        let stud = smoothstep(0.36, 0.26, studs.abs().max_element()) * smoothstep(0.78, 0.74, p.length());
        Texel { albedo: Vec3::ONE, height_m: 0.012 * ring.max(stud), roughness: 1.0, metallic: 0.0 }
    });
    let bumps = glb.texture("lid bumps", &lid.normal());
    let iron = masked_picture(64, |uv| {
        let r = (uv - 0.5).length() * 2.0;
        let tone = 0.9 + 0.1 * fractal(uv, IVec2::splat(8), 2, 23);
        (srgb(0x6b6763) * tone, smoothstep(0.98, 0.94, r))
    });
    let iron = glb.texture("iron", &iron);
    let lid = glb.material(&Material {
        name: "lid",
        base_color_texture: Some(iron),
        normal_texture: Some(bumps),
        metallic: 1.0,
        roughness: 0.42,
        ..Material::default()
    });
    let all =
        json!({"channels": {"base_color": 1, "normal": 1, "metallic": 1, "roughness": 1}, "priority": 1});
    paint(glb, "lid", lid, down(-0.95, 0.0, 1.62, 0.06), Vec3::new(0.72, 0.72, 0.12), all);

    let puddle = masked_picture(128, |uv| {
        let p = (uv - 0.5) * 2.0;
        let edge = 0.7 + 0.26 * fractal(uv, IVec2::splat(3), 3, 51);
        (srgb(0x24262a), smoothstep(edge, edge - 0.12, p.length()))
    });
    let puddle = glb.texture("puddle", &puddle);
    let water = glb.material(&Material {
        name: "water",
        base_color_texture: Some(puddle),
        roughness: 0.06,
        ..Material::default()
    });
    let wet = json!({"channels": {"roughness": 1.0, "base_color": 0.55}, "priority": 2});
    paint(glb, "puddle", water, down(-0.1, 0.0, 1.05, 0.1), Vec3::new(2.3, 1.1, 0.12), wet.clone());
    paint(glb, "small puddle", water, down(-2.2, 0.0, 1.75, 0.3), Vec3::new(1.3, 0.9, 0.12), wet);
}

fn on_wall(glb: &mut Glb) {
    let tag = masked_picture(128, |uv| {
        let p = (uv - 0.5) * 2.0;
        let wave = |x: f32, k: f32| 0.34 * super::shape::circle(x * k).x;
        let stroke = |offset: f32, k: f32| (p.y - offset - wave(p.x, k)).abs();
        let line = stroke(-0.1, 0.55).min(stroke(0.25, 0.8)).min((p.length() - 0.62).abs());
        let spray = 1.0 - 0.3 * fractal(uv, IVec2::splat(30), 2, 3).abs();
        let ends = smoothstep(0.95, 0.8, p.abs().max_element());
        (srgb(0x2a55b8), smoothstep(0.11, 0.05, line) * spray * ends)
    });
    let tag = ink(glb, "tag", tag, 0.45);
    // Over the edge to the wall's side.
    let pose = Pose::at(-1.62, 1.15, -1.62).turned(0.06);
    let wrap = json!({"channels": {"base_color": 0.95, "roughness": 0.6}, "angle": [60, 85]});
    paint(glb, "tag", tag, pose, Vec3::new(0.95, 0.95, 0.6), wrap);
    let plaster = masked_picture(128, |uv| {
        let cell = cellular(uv, IVec2::splat(3), 77);
        let edge = 0.5 + 0.14 * fractal(uv, IVec2::splat(8), 3, 78);
        let brick = (uv.y * 9.0).fract() > 0.16 && (uv.x * 4.0 + 0.5 * (uv.y * 9.0).floor()).fract() > 0.08;
        let color = if brick { srgb(0x9a4a34) } else { srgb(0x8d8378) };
        let ends = smoothstep(0.5, 0.4, (uv - 0.5).abs().max_element());
        (color, smoothstep(edge, edge - 0.05, cell.nearest) * ends)
    });
    let plaster = ink(glb, "fallen plaster", plaster, 0.9);
    let back = Pose::at(-2.75, 0.95, -1.65);
    paint(
        glb,
        "fallen plaster",
        plaster,
        back,
        Vec3::new(1.2, 1.3, 0.2),
        json!({"channels": {"base_color": 1, "roughness": 1}}),
    );
    let damp = masked_picture(64, |uv| {
        let wave = fractal(Vec2::new(uv.x, 0.3), IVec2::splat(6), 3, 71);
        (srgb(0x3d3a30), 0.8 * smoothstep(0.35, 0.85, uv.y + 0.2 * wave))
    });
    let damp = ink(glb, "damp", damp, 0.35);
    let rising = json!({"channels": {"base_color": 0.7, "roughness": 0.7}, "priority": 1});
    paint(glb, "damp", damp, Pose::at(-2.5, 0.3, -1.65), Vec3::new(2.18, 0.62, 0.2), rising);
}

fn lights(glb: &mut Glb) {
    let sun = LightKind::Directional { illuminance_lx: 2.6 };
    let sun = Light { name: "sun", color: Vec3::new(1.0, 0.62, 0.34), kind: sun };
    glb.light(sun, Pose::looking(SUN * 10.0, Vec3::ZERO));
    let kind = LightKind::Spot { intensity_cd: 7.0, range_m: 6.0, inner_rad: 0.3, outer_rad: 0.85 };
    let lamp = Light { name: "street lamp", color: Vec3::new(0.85, 0.93, 1.0), kind };
    glb.light(lamp, Pose::looking(Vec3::new(2.9, 3.3, 1.2), Vec3::new(1.6, 0.0, 0.6)));
    let kind = LightKind::Spot { intensity_cd: 3.5, range_m: 4.0, inner_rad: 0.2, outer_rad: 0.7 };
    let lantern = Light { name: "lantern", color: Vec3::new(1.0, 0.8, 0.55), kind };
    glb.light(lantern, Pose::looking(Vec3::new(-0.3, 2.3, -0.3), Vec3::new(-0.3, 0.5, -0.95)));
    let kind = LightKind::Point { intensity_cd: 0.5, range_m: 2.2 };
    let poster = Light { name: "poster light", color: Vec3::new(1.0, 0.62, 0.4), kind };
    let poster = glb.light(poster, Pose::at(2.05, 1.0, -0.4));
    glb.extras(poster, json!({"shadow": false}));

    let colors = [0xffb45a, 0xff6a4a, 0x7ad0a0, 0x6ab0ff];
    let bulb = glb.geometry(&sphere(0.028, 12, 8).untextured());
    let bulbs = colors.map(|color| {
        let glow = Material {
            name: "bulb",
            base_color: Vec3::splat(0.2),
            emissive: linear(color),
            emissive_strength: 2.5,
            ..Material::default()
        };
        let glow = glb.material(&glow);
        glb.mesh("bulb", &[(&bulb, glow)])
    });
    for i in 0..BULBS {
        let t = i as f32 / (BULBS - 1) as f32;
        let sag = 0.1 * (1.0 - (4.0 * (t * 2.0).fract() - 2.0).abs() * 0.5);
        let pose = Pose::at(-1.45 + 2.9 * t, 2.3 - sag, 0.1);
        glb.place("bulb", bulbs[i % 4], pose);
        let kind = LightKind::Point { intensity_cd: 0.16, range_m: 1.6 };
        let color = linear(colors[i % 4]).lerp(Vec3::ONE, 0.2);
        let light = glb.light(Light { name: "bulb", color, kind }, pose);
        glb.extras(light, json!({"shadow": false}));
    }
}

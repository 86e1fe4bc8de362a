//! Wholly unlit: a poster and solids in the colours of their vertices and textures. No lights.

use super::glb::{Glb, Material, Pose};
use super::mesh::{Mesh, Vertex};
use super::noise::{pick, smoothstep};
use super::shape::{circle, cuboid, lathe, round_profile, sphere};
use super::texture::{linear, picture, srgb};
use glam::{IVec2, Vec2, Vec3};

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    let unlit = Material { unlit: true, ..Material::default() };
    let colored = glb.material(&Material { name: "vertex colours", ..unlit.clone() });
    backdrop(&mut glb, colored);
    solids(&mut glb, colored);
    let poster = glb.texture("poster", &picture(256, poster));
    let poster =
        glb.material(&Material { name: "poster", base_color_texture: Some(poster), ..unlit.clone() });
    let checks = glb.texture("checks", &picture(64, checks));
    let checks = Some(checks.scaled(0.8));
    let checks = glb.material(&Material { name: "checks", base_color_texture: checks, ..unlit });

    let sheet = Mesh::patch(1, 1, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * 1.7, (v - 0.5) * 1.7, 0.031),
        normal: Vec3::Z,
        texcoord: Vec2::new(u, 1.0 - v),
    });
    let frame = cuboid(Vec3::new(1.86, 1.86, 0.06), 0.02).untextured().colored(|_, normal| {
        // No light falls on it, so its faces are painted apart.
        linear(0x5c3a26) * (0.75 + 0.35 * normal.y)
    });
    let (sheet, frame) = (glb.geometry(&sheet), glb.geometry(&frame));
    let mesh = glb.mesh("poster", &[(&sheet, poster), (&frame, colored)]);
    glb.place("poster", mesh, Pose::at(-0.75, 1.45, -0.4).turned(0.03));

    let drum = lathe(&[(0.0, 0.0), (0.36, 0.0), (0.36, 0.5), (0.0, 0.5)].map(Vec2::from), 40, 2.5);
    let drum = glb.geometry(&drum);
    let mesh = glb.mesh("drum", &[(&drum, checks)]);
    glb.place("drum", mesh, Pose::at(0.85, 0.0, -0.15));
    glb.perspective("main", 36.0, Pose::looking(Vec3::new(0.25, 1.5, 4.6), Vec3::new(0.0, 1.1, 0.0)));
    glb.finish("unlit")
}

/// Evening sky into floor.
fn backdrop(glb: &mut Glb, material: usize) {
    let wall = Mesh::patch(1, 16, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * 14.0, v * 6.0, -2.5),
        normal: Vec3::Z,
        texcoord: Vec2::ZERO,
    });
    let wall = wall.colored(|p, _| linear(0xf2c79a).lerp(linear(0x4a6fa5), smoothstep(0.0, 3.6, p.y)));
    let floor = Mesh::patch(1, 12, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * 14.0, 0.0, 4.5 - 7.0 * v),
        normal: Vec3::Y,
        texcoord: Vec2::ZERO,
    });
    let floor = floor.colored(|p, _| linear(0x39485c).lerp(linear(0xb08a78), smoothstep(2.5, -2.5, p.z)));
    let geometry = glb.geometry(&Mesh::merged([wall, floor]).untextured());
    let mesh = glb.mesh("backdrop", &[(&geometry, material)]);
    glb.place("backdrop", mesh, Pose::origin());
}

fn solids(glb: &mut Glb, material: usize) {
    let mut place = |name, mesh: Mesh, pose| {
        let geometry = glb.geometry(&mesh.untextured());
        let mesh = glb.mesh(name, &[(&geometry, material)]);
        glb.place(name, mesh, pose);
    };
    // The colour cube: red, green and blue along x, y and z.
    let cube = cuboid(Vec3::splat(0.6), 0.0).colored(|p, _| p / 0.6 + 0.5);
    place("colour cube", cube, Pose::at(0.85, 0.8, -0.15).turned(0.09));
    let ring = lathe(&round_profile(Vec2::new(0.34, 0.0), 0.1, 16), 64, 1.0).colored(|p, normal| {
        let turn = p.z.atan2(p.x) / std::f32::consts::TAU;
        wheel(turn) * (0.8 + 0.3 * normal.y)
    });
    place("colour wheel", ring, Pose::at(0.85, 1.6, -0.15).turned(-0.04).rotated(Vec3::X, 0.25));
    let ball = sphere(0.3, 40, 24).colored(|p, _| {
        let stripe = smoothstep(-0.15, 0.15, circle(p.y * 5.0).x);
        linear(0xe0503c).lerp(linear(0xf6e7c4), stripe) * (0.85 + p.y * 0.5)
    });
    place("ball", ball, Pose::at(0.05, 0.3, 0.75).rotated(Vec3::Z, 0.07));
}

/// Linear Rec.709 of a hue.
fn wheel(turn: f32) -> Vec3 {
    Vec3::from([0.0, 1.0, 2.0].map(|third| 0.5 + 0.48 * circle(turn - third / 3.0).x))
}

/// Sun, hills and a little boat on water: sRGB.
fn poster(uv: Vec2) -> Vec3 {
    const EDGE: f32 = 0.004;
    let p = Vec2::new(uv.x, 1.0 - uv.y);
    let over =
        |under: Vec3, color: u32, distance: f32| under.lerp(srgb(color), smoothstep(EDGE, -EDGE, distance));
    let mut color = srgb(0xf7a65a).lerp(srgb(0x2d5d8f), smoothstep(0.35, 1.0, p.y));
    color = over(color, 0xfdf0c8, p.distance(Vec2::new(0.62, 0.6)) - 0.15);
    let hill = |base: f32, height: f32, waves: f32, phase: f32| base + height * circle(p.x * waves + phase).y;
    color = over(color, 0xb0586a, p.y - hill(0.46, 0.07, 0.9, 0.1));
    color = over(color, 0x6d3f63, p.y - hill(0.4, 0.05, 1.4, 0.55));
    let ripple = 0.03 * circle(p.y * 22.0 + 0.3 * circle(p.x * 3.0).y).x;
    if p.y < 0.33 {
        let glitter = smoothstep(0.16, 0.02, (p.x - 0.62).abs() + ripple.abs() * 2.0);
        color = srgb(0x1d4664).lerp(srgb(0xf0a868), 0.75 * glitter) + ripple;
    }
    // Hull and sail.
    let hull = (p.y - 0.25).abs() - 0.025;
    let hull = hull.max((p.x - 0.3).abs() - 0.1 - 0.8 * (p.y - 0.25));
    color = over(color, 0x2a1c24, hull);
    let sail = (0.285 - p.y).max(p.y - 0.52 + 2.0 * (p.x - 0.3).abs()).max(0.29 - p.x);
    color = over(color, 0xf5ead2, sail);
    let border = (p - 0.5).abs().max_element();
    over(color, 0xf5ead2, 0.465 - border)
}

/// Four by four tinted squares: sRGB.
fn checks(uv: Vec2) -> Vec3 {
    let cell: IVec2 = (uv * 4.0).as_ivec2();
    let tint = srgb(0xffffff).lerp(srgb(0xf3d9a8), pick((cell.y * 4 + cell.x) as usize, 5));
    if (cell.x + cell.y) % 2 == 0 { tint } else { srgb(0x2f7f86) }
}

//! Dusk, stars, and the town's roofs beyond the walls.

use super::super::glb::{Glb, Pose};
use super::super::mesh::Mesh;
use super::super::noise::{pick, smoothstep};
use super::super::shape::{circle, cuboid, flipped_if_inward, lathe, sphere};
use super::super::texture::linear;
use super::palette::Palette;
use glam::{Vec2, Vec3};

/// Builds the sky's dome and the town.
pub fn build(glb: &mut Glb, palette: &Palette) {
    const SKY_RADIUS_M: f32 = 90.0;
    let sunset = Vec3::new(0.0, 0.0, -1.0);
    let dome = flipped_inward(sphere(SKY_RADIUS_M, 32, 40)).untextured().colored(|p, _| {
        let direction = p.normalize();
        let towards_sunset = 0.5 + 0.5 * direction.dot(sunset);
        let glow = linear(0x4a4a78).lerp(linear(0xf0935a), towards_sunset.powi(4));
        let middle = linear(0x2c3a72).lerp(linear(0x8a6a90), towards_sunset.powi(3));
        let low = glow.lerp(middle, smoothstep(0.24, 0.4, direction.y));
        low.lerp(linear(0x101f4e), smoothstep(0.36, 0.7, direction.y))
    });
    let mut stars = Vec::new();
    for i in 0..140 {
        let (turns, height) = (pick(i, 111), 0.25 + 0.7 * pick(i, 112));
        let around = circle(turns) * (1.0 - height * height).sqrt();
        let center = Vec3::new(around.x, height, around.y) * (SKY_RADIUS_M * 0.97);
        let size_m = 0.05 + 0.09 * pick(i, 113).powi(3);
        let brightness = Vec3::new(0.75, 0.8, 1.0) * (0.25 + 0.75 * pick(i, 114));
        let star = sphere(size_m, 4, 2).untextured().colored(move |_, _| brightness);
        stars.push(star.at(center.x, center.y, center.z));
    }
    let (dome, stars) = (glb.geometry(&dome), glb.geometry(&Mesh::merged(stars)));
    let sky = glb.mesh("sky", &[(&dome, palette.sky), (&stars, palette.sky)]);
    glb.place("sky", sky, Pose::origin());

    let tower = Mesh::merged([
        cuboid(Vec3::new(3.2, 14.0, 3.2), 0.05).at(-5.4, 7.0, -22.0),
        cuboid(Vec3::new(3.8, 0.4, 3.8), 0.1).at(-5.4, 14.0, -22.0),
        cuboid(Vec3::new(2.4, 2.6, 2.4), 0.05).at(-5.4, 15.4, -22.0),
        cuboid(Vec3::new(2.9, 0.3, 2.9), 0.08).at(-5.4, 16.8, -22.0),
    ]);
    let spire = lathe(&[(1.3, 16.9), (0.9, 18.0), (0.35, 20.0), (0.0, 22.5)].map(Vec2::from), 16, 1.0)
        .at(-5.4, 0.0, -22.0);
    let dome_profile: Vec<Vec2> =
        (0..=12).map(|i| circle(i as f32 / 48.0) * Vec2::new(4.2, 4.6) + Vec2::Y * 9.4).collect();
    let church = Mesh::merged([
        lathe(&[(4.2, 0.0), (4.2, 9.0), (4.5, 9.1), (4.5, 9.4), (4.2, 9.4)].map(Vec2::from), 32, 1.0),
        lathe(&dome_profile, 32, 1.0),
        lathe(&[(0.6, 13.8), (0.6, 15.0), (0.75, 15.1), (0.0, 16.2)].map(Vec2::from), 16, 1.0),
    ])
    .at(7.5, 0.0, -27.0);
    let (mut houses, mut panes) = (Vec::new(), Vec::new());
    for i in 0..9 {
        let size_m = Vec3::new(4.0 + 3.0 * pick(i, 121), 9.4 + 2.6 * pick(i, 122), 5.0);
        let (x_m, z_m) = (-18.0 + 4.5 * i as f32, -19.0 - 4.0 * pick(i, 123));
        houses.push(cuboid(size_m, 0.1).at(x_m, size_m.y / 2.0, z_m));
        for window in 0..2 {
            let across_m = (pick(2 * i + window, 124) - 0.5) * (size_m.x - 1.0);
            let pane = cuboid(Vec3::new(0.3, 0.5, 0.05), 0.0);
            panes.push(pane.at(x_m + across_m, size_m.y - 0.7, z_m + size_m.z / 2.0));
        }
    }
    houses.extend([tower, spire, church]);
    let town = glb.geometry(&Mesh::merged(houses).untextured());
    panes.push(cuboid(Vec3::new(0.5, 1.1, 0.1), 0.0).at(-5.4, 15.4, -20.78));
    let panes = glb.geometry(&Mesh::merged(panes).untextured());
    let town = glb.mesh("town", &[(&town, palette.distant), (&panes, palette.window)]);
    glb.place("town", town, Pose::origin());
}

/// The same surface seen from inside.
fn flipped_inward(mut mesh: Mesh) -> Mesh {
    mesh.normals.iter_mut().for_each(|n| *n = -*n);
    flipped_if_inward(mesh)
}

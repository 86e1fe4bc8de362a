//! The material grid: spheres from plastic to metal (bottom to top), from glossy to matt (left to right).

use super::glb::{Glb, Light, LightKind, Material, Pose};
use super::shape::{cuboid, sphere};
use super::texture::linear;
use glam::Vec3;

const COLUMNS: usize = 7;
const ROWS: usize = 5;
const RADIUS_M: f32 = 0.42;
/// From centre to centre, sideways and upward.
const PITCH_M: f32 = 1.06;
const LOWEST_M: f32 = 0.72;
const SHELF_M: f32 = 0.05;
/// Front face of the wall behind the spheres.
const WALL_Z_M: f32 = -0.75;

/// Reflectance of metals at normal incidence: iron, silver, aluminium, brass, gold, bronze, copper.
const METALS: [u32; COLUMNS] = [0xc4c0ba, 0xf7f4ee, 0xe6e9ec, 0xeed9a0, 0xffe29b, 0xd8a878, 0xfad0b8];
const PLASTICS: [u32; COLUMNS] = [0xd8303a, 0xe8762a, 0xe3bf35, 0x4fa64b, 0x23a0a6, 0x3767c8, 0x8c4bb8];

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    spheres(&mut glb);
    room(&mut glb);
    lights(&mut glb);
    let middle = Vec3::new(0.0, height_m(ROWS / 2) - 0.05, 0.0);
    glb.perspective("main", 28.5, Pose::looking(Vec3::new(2.3, 3.9, 11.2), middle));
    glb.orthographic("front", 2.95, 30.0, Pose::looking(middle + Vec3::Z * 12.0, middle));
    glb.finish("grid")
}

fn height_m(row: usize) -> f32 {
    LOWEST_M + row as f32 * PITCH_M
}

fn spheres(glb: &mut Glb) {
    let ball = glb.geometry(&sphere(RADIUS_M, 48, 32).untextured());
    for row in 0..ROWS {
        let metallic = row as f32 / (ROWS - 1) as f32;
        for column in 0..COLUMNS {
            let roughness = 0.1 + 0.9 * column as f32 / (COLUMNS - 1) as f32;
            let material = glb.material(&Material {
                base_color: linear(PLASTICS[column]).lerp(linear(METALS[column]), metallic),
                metallic,
                roughness,
                ..Material::default()
            });
            let name = format!("metallic {metallic:.2} roughness {roughness:.2}");
            let mesh = glb.mesh(&name, &[(&ball, material)]);
            let x_m = (column as f32 - (COLUMNS - 1) as f32 / 2.0) * PITCH_M;
            glb.place(&name, mesh, Pose::at(x_m, height_m(row), 0.0));
        }
    }
}

/// Floor, wall and a shelf under each row.
fn room(glb: &mut Glb) {
    let matt = |name, hex| Material { name, base_color: linear(hex), ..Material::default() };
    let mut slab = |name, hex, size_m: [f32; 3], center_m: &[[f32; 3]]| {
        let size_m = Vec3::from(size_m);
        // Only the shelves show their edges.
        let bevel_m = if size_m.min_element() < 0.1 { 0.01 } else { 0.0 };
        let geometry = glb.geometry(&cuboid(size_m, bevel_m).untextured());
        let material = glb.material(&matt(name, hex));
        let mesh = glb.mesh(name, &[(&geometry, material)]);
        for &[x, y, z] in center_m {
            glb.place(name, mesh, Pose::at(x, y, z));
        }
    };
    slab("floor", 0x8d8478, [26.0, 0.2, 16.0], &[[0.0, -0.1, WALL_Z_M + 7.9]]);
    slab("wall", 0x8b919b, [26.0, 12.0, 0.2], &[[0.0, 6.0, WALL_Z_M - 0.1]]);
    let width_m = COLUMNS as f32 * PITCH_M + 0.1;
    let depth_m = 0.5 - WALL_Z_M;
    let shelves =
        [0, 1, 2, 3, 4].map(|row| [0.0, height_m(row) - RADIUS_M - SHELF_M / 2.0, WALL_Z_M + depth_m / 2.0]);
    slab("shelf", 0x6b5642, [width_m, SHELF_M, depth_m], &shelves);
}

fn lights(glb: &mut Glb) {
    let sun = LightKind::Directional { illuminance_lx: 2.7 };
    let sun = Light { name: "sun", color: Vec3::new(1.0, 0.96, 0.9), kind: sun };
    glb.light(sun, Pose::looking(Vec3::new(-0.75, 0.9, 1.25), Vec3::ZERO));
    let colored = [
        ("warm light", Vec3::new(1.0, 0.62, 0.3), [-4.3, 4.9, 2.0]),
        ("rose light", Vec3::new(1.0, 0.45, 0.55), [4.5, 1.0, 2.0]),
        ("blue light", Vec3::new(0.35, 0.55, 1.0), [4.3, 5.2, 2.2]),
        ("green light", Vec3::new(0.4, 1.0, 0.65), [-4.4, 0.9, 2.2]),
    ];
    for (name, color, [x, y, z]) in colored {
        let kind = LightKind::Point { intensity_cd: 10.0, range_m: 7.0 };
        glb.light(Light { name, color, kind }, Pose::at(x, y, z));
    }
    let middle = Vec3::new(0.0, height_m(ROWS / 2), 0.0);
    let kind = LightKind::Spot { intensity_cd: 60.0, range_m: 14.0, inner_rad: 0.15, outer_rad: 0.5 };
    let spot = Light { name: "spot", color: Vec3::new(1.0, 0.93, 0.82), kind };
    glb.light(spot, Pose::looking(Vec3::new(1.5, 5.8, 5.0), middle));
}

//! A scene to measure with: any number of objects and lights on a floor.

use super::glb::{Geometry, Glb, Light, LightKind, Material, Pose};
use super::mesh::{Mesh, Vertex};
use super::noise::{pick, unit};
use super::shape::{circle, cuboid, sphere};
use super::texture::picture;
use glam::{IVec2, Vec2, Vec3};

const FLOOR_M: f32 = 24.0;
/// From the floor's edge to the outermost objects and lights.
const MARGIN_M: f32 = 0.8;
/// Objects share this many materials unless each has its own.
const MATERIALS: usize = 8;
const NOISE_SIZE_PX: u32 = 512;

/// What the scene has.
pub struct Options {
    /// Point lights.
    pub lights: usize,
    /// Spheres and boxes.
    pub objects: usize,
    /// Where each light ends.
    pub range_m: f32,
    /// Bytes of noise to add, to the nearest texture.
    pub padding_bytes: usize,
    /// Every object has a material of its own.
    pub distinct: bool,
}

/// The file's bytes.
pub fn glb(options: &Options) -> Vec<u8> {
    let mut glb = Glb::default();
    floor(&mut glb, options.padding_bytes);
    objects(&mut glb, options);
    for i in 0..options.lights {
        let kind = LightKind::Point { intensity_cd: 4.0, range_m: options.range_m };
        let (x_m, z_m) = scattered_m(i, 7);
        let height_m = 0.9 + 0.8 * pick(i, 9);
        glb.light(Light { name: "light", color: hue(i), kind }, Pose::at(x_m, height_m, z_m));
    }
    glb.perspective("main", 46.0, Pose::looking(Vec3::new(0.0, 13.0, 19.5), Vec3::new(0.0, 0.0, 1.4)));
    glb.finish("bench")
}

/// Square tiles, one for each texture of noise; without noise a single one.
fn floor(glb: &mut Glb, padding_bytes: usize) {
    let plain =
        Material { name: "floor", base_color: Vec3::splat(0.5), roughness: 0.8, ..Material::default() };
    let mut materials = Vec::new();
    let mut remaining_bytes = padding_bytes;
    while remaining_bytes > 0 {
        let seed = materials.len() as u32;
        let noise = picture(NOISE_SIZE_PX, |uv| {
            let cell = (uv * NOISE_SIZE_PX as f32).as_ivec2();
            Vec3::from([0, 1, 2].map(|channel| unit(cell + IVec2::Y * 10_000 * channel, seed)))
        });
        if !materials.is_empty() && remaining_bytes < noise.bytes.len() / 2 {
            break;
        }
        remaining_bytes = remaining_bytes.saturating_sub(noise.bytes.len());
        let texture = glb.texture("noise", &noise);
        materials.push(glb.material(&Material { base_color_texture: Some(texture), ..plain.clone() }));
    }
    if materials.is_empty() {
        materials.push(glb.material(&plain));
    }
    let side = (materials.len() as f32).sqrt().ceil() as usize;
    let tile_m = FLOOR_M / side as f32;
    let tile = glb.geometry(&Mesh::patch(1, 1, |u, v| Vertex {
        position: Vec3::new((u - 0.5) * tile_m, 0.0, (0.5 - v) * tile_m),
        normal: Vec3::Y,
        texcoord: Vec2::new(u, 1.0 - v),
    }));
    let meshes: Vec<_> = materials.iter().map(|&material| glb.mesh("floor", &[(&tile, material)])).collect();
    for i in 0..side * side {
        let [x_m, z_m] = [i % side, i / side].map(|cell| (cell as f32 + 0.5) * tile_m - FLOOR_M / 2.0);
        glb.place("floor", meshes[i % meshes.len()], Pose::at(x_m, 0.0, z_m));
    }
}

/// Spheres and boxes in the cells of a square grid, a node each.
fn objects(glb: &mut Glb, options: &Options) {
    if options.objects == 0 {
        return;
    }
    let side = (options.objects as f32).sqrt().ceil();
    let pitch_m = (FLOOR_M - 2.0 * MARGIN_M) / side;
    let size_m = (0.6 * pitch_m).min(1.2);
    let shapes = [
        glb.geometry(&sphere(size_m / 2.0, 32, 20).untextured()),
        glb.geometry(&cuboid(Vec3::splat(size_m * 0.86), size_m * 0.04).untextured()),
    ];
    let count = if options.distinct { options.objects } else { options.objects.min(MATERIALS) };
    let meshes: Vec<_> = (0..count).map(|i| object_mesh(glb, &shapes[i % 2], i)).collect();
    for i in 0..options.objects {
        let cell = Vec2::new(i as f32 % side, (i as f32 / side).floor()) - (side - 1.0) / 2.0;
        let pose = Pose::at(cell.x * pitch_m, size_m / 2.0, cell.y * pitch_m).turned(pick(i, 3));
        glb.place(&format!("object {i}"), meshes[i % count], pose);
    }
}

fn object_mesh(glb: &mut Glb, shape: &Geometry, i: usize) -> usize {
    let material = glb.material(&Material {
        name: "object",
        base_color: Vec3::splat(0.25) + 0.6 * hue(3 * i + 1),
        metallic: if pick(i, 1) < 0.3 { 1.0 } else { 0.0 },
        roughness: 0.15 + 0.7 * pick(i, 2),
        ..Material::default()
    });
    glb.mesh("object", &[(shape, material)])
}

/// A place on the floor, evenly but not regularly spread.
fn scattered_m(i: usize, seed: u32) -> (f32, f32) {
    let extent_m = FLOOR_M - 2.0 * MARGIN_M;
    ((pick(i, seed) - 0.5) * extent_m, (pick(i, seed + 1) - 0.5) * extent_m)
}

/// Linear Rec.709, saturated; successive ones are far apart (multiples of the golden ratio around the wheel).
fn hue(i: usize) -> Vec3 {
    let turn = (i as f32 * 0.618_034).fract();
    Vec3::from([0.0, 1.0, 2.0].map(|third| (0.55 + 0.45 * circle(turn - third / 3.0).x).max(0.0)))
}

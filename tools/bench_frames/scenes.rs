//! The scenes that are measured: spheres and boxes on a floor of 24 m by 24 m under a grid of coloured lights.

use std::f32::consts::PI;

use glam::{Mat4, Vec3, vec3};
use ontile::glam;
use ontile::scene::{Camera, Instance, Light, LightKind, Material, Mesh, Projection, Scene};

pub const FLOOR_M: f32 = 24.0;
const LIGHT_RANGE_M: f32 = 4.0;
/// Rings and segments of a sphere: 24 * 48 * 2 triangles.
const RINGS: u32 = 24;

/// `objects` spheres and boxes of a few materials, `lights` point lights of 4 m range, one camera. With `distinct`,
/// every object has a mesh of its own, so that none can share a draw call.
pub fn floor(objects: usize, lights: usize, distinct: bool) -> Scene {
    let materials: Vec<_> = (0..8).map(material).collect();
    let mut scene =
        Scene { name: format!("{objects} objects, {lights} lights"), materials, ..Scene::default() };
    add(&mut scene, cuboid(vec3(FLOOR_M / 2.0, 0.1, FLOOR_M / 2.0), 0), vec3(0.0, -0.1, 0.0));
    let shape = |i: usize| match i % 2 {
        0 => sphere(0.6, i % 8),
        _ => cuboid(Vec3::splat(0.5), i % 8),
    };
    for (i, [x, z]) in grid(objects).enumerate() {
        let at = vec3(x, 0.6, z);
        if distinct || i < 8 {
            add(&mut scene, shape(i), at);
        } else {
            // Meshes 1 to 8 are the first eight objects'.
            let world_from_object = Mat4::from_translation(at);
            scene.instances.push(Instance::new(1 + i % 8, world_from_object));
        }
    }
    scene.lights = grid(lights).enumerate().map(|(i, [x, z])| light(i, vec3(x, 1.8, z))).collect();
    let world_from_view = Mat4::from_translation(vec3(0.0, 9.0, 17.0)) * Mat4::from_rotation_x(-0.5);
    let projection = Projection::Perspective { yfov_rad: 0.9, znear_m: 0.1, zfar_m: Some(100.0) };
    scene.cameras = vec![Camera { name: "bench".into(), world_from_view, projection }];
    scene
}

/// The centres of at least `count` equal cells of the floor, the first `count` of them.
pub fn grid(count: usize) -> impl Iterator<Item = [f32; 2]> {
    let side = (count as f32).sqrt().ceil() as usize;
    let center = move |cell: usize| ((cell as f32 + 0.5) / side as f32 - 0.5) * (FLOOR_M - 2.0);
    (0..count).map(move |i| [center(i % side), center(i / side)])
}

pub fn add(scene: &mut Scene, mesh: Mesh, at: Vec3) {
    scene.instances.push(Instance::new(scene.meshes.len(), Mat4::from_translation(at)));
    scene.meshes.push(mesh);
}

/// Of a golden-ratio sequence, so that neighbours differ.
pub fn hue(i: usize) -> Vec3 {
    let turn = i as f32 * 0.618_034;
    Vec3::from([0.0, 1.0 / 3.0, 2.0 / 3.0].map(|phase| 0.55 + 0.45 * ((turn + phase) * 2.0 * PI).cos()))
}

fn material(i: usize) -> Material {
    Material {
        name: format!("material {i}"),
        base_color_factor: (hue(i) * 0.8).extend(1.0),
        metallic_factor: (i % 3 == 1) as u8 as f32,
        roughness_factor: 0.2 + 0.1 * i as f32,
        ..Material::default()
    }
}

fn light(i: usize, position_world: Vec3) -> Light {
    Light {
        name: format!("light {i}"),
        color: hue(i + 3),
        position_world,
        range_m: Some(LIGHT_RANGE_M),
        ..Light::new(LightKind::Point { intensity_cd: 8.0 })
    }
}

fn sphere(radius_m: f32, material: usize) -> Mesh {
    let segments = RINGS * 2;
    let mut mesh = Mesh { name: "sphere".into(), material, ..Mesh::default() };
    for ring in 0..=RINGS {
        for segment in 0..=segments {
            let (polar, turn) =
                (PI * ring as f32 / RINGS as f32, 2.0 * PI * segment as f32 / segments as f32);
            let normal = vec3(polar.sin() * turn.sin(), polar.cos(), polar.sin() * turn.cos());
            mesh.normals.push(normal);
            mesh.positions.push(normal * radius_m);
        }
    }
    for ring in 0..RINGS {
        for segment in 0..segments {
            let a = ring * (segments + 1) + segment;
            let b = a + segments + 1;
            mesh.indices.extend([a, b, a + 1, a + 1, b, b + 1]);
        }
    }
    mesh
}

fn cuboid(half_m: Vec3, material: usize) -> Mesh {
    let mut mesh = Mesh { name: "box".into(), material, ..Mesh::default() };
    for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
        // Any vector across gives a right-handed frame with the normal, so the winding is right.
        let across = normal.any_orthonormal_vector();
        let up = normal.cross(across);
        let first = mesh.positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            mesh.positions.push((normal + across * x + up * y) * half_m);
            mesh.normals.push(normal);
        }
        mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
    }
    mesh
}

//! What the sweeps' scenes are put together from.

use std::f32::consts::{PI, TAU};

use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::scene::{Camera, Instance, Light, LightKind, Material, Mesh, Projection, Scene};

/// At `eye`, looking at `target`, a field of view of 40 degrees, near plane at 0.1 m, no far plane.
pub fn camera(eye: Vec3, target: Vec3) -> Camera {
    let up = if (target - eye).normalize().y.abs() > 0.999 { Vec3::NEG_Z } else { Vec3::Y };
    let projection = Projection::Perspective { yfov_rad: 0.7, znear_m: 0.1, zfar_m: None };
    Camera { name: "camera".into(), world_from_view: look_at_mat4(eye, target, up).inverse(), projection }
}

/// A square of half extent 1 in z = 0 that faces +z.
pub fn square() -> Mesh {
    let corners = [Vec2::new(-1.0, 1.0), Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0)];
    Mesh {
        positions: corners.map(|c| c.extend(0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        tangents: vec![Vec3::X.extend(1.0); 4],
        texcoords: [corners.map(|c| (c * Vec2::new(1.0, -1.0) + 1.0) * 0.5).to_vec(), Vec::new()],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    }
}

/// A sphere of radius 1, by latitude and longitude.
pub fn sphere() -> Mesh {
    const RINGS: u32 = 24;
    const SECTORS: u32 = 48;
    let mut mesh = Mesh::default();
    for ring in 0..=RINGS {
        for sector in 0..=SECTORS {
            let uv = Vec2::new(sector as f32 / SECTORS as f32, ring as f32 / RINGS as f32);
            let (theta, phi) = (PI * uv.y, TAU * uv.x);
            mesh.positions.push(Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()));
            mesh.tangents.push(Vec4::new(phi.cos(), 0.0, -phi.sin(), 1.0));
            mesh.texcoords[0].push(uv);
            if ring < RINGS && sector < SECTORS {
                let a = ring * (SECTORS + 1) + sector;
                let b = a + SECTORS + 1;
                mesh.indices.extend([a, b, a + 1, a + 1, b, b + 1]);
            }
        }
    }
    mesh.normals = mesh.positions.clone();
    mesh
}

/// A material of one colour.
pub fn plain(base_color: Vec3, metallic: f32, roughness: f32) -> Material {
    Material {
        base_color_factor: base_color.extend(1.0),
        metallic_factor: metallic,
        roughness_factor: roughness,
        ..Material::default()
    }
}

/// Adds a mesh of one material at one place.
pub fn add(scene: &mut Scene, mesh: Mesh, material: Material, world_from_object: Mat4) {
    scene.instances.push(Instance::new(scene.meshes.len(), world_from_object));
    scene.meshes.push(Mesh { material: scene.materials.len(), ..mesh });
    scene.materials.push(material);
}

/// The square laid down at height 0, facing up, so many metres in half extent.
pub fn floor(half_m: f32) -> Mat4 {
    Mat4::from_rotation_x(-PI / 2.0) * Mat4::from_scale(Vec3::splat(half_m))
}

/// Light from everywhere along one direction.
pub fn sun(illuminance_lx: f32, towards: Vec3) -> Light {
    Light::new(LightKind::Directional { illuminance_lx }).towards(towards)
}

/// A lamp.
pub fn bulb(intensity_cd: f32, position_world: Vec3, range_m: Option<f32>) -> Light {
    Light { position_world, range_m, ..Light::new(LightKind::Point { intensity_cd }) }
}

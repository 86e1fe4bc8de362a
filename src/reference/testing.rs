//! Scenes and integrals that several tests share.

use std::f64::consts::TAU;

use glam::{DVec3, Mat4, Vec3};

use super::brdf::{alpha_from_roughness, brdf};
use super::gbuffer::Attributes;
use crate::scene::{Camera, Instance, Material, Mesh, Projection, Scene};

pub fn perspective(yfov_rad: f32, znear_m: f32, zfar_m: Option<f32>) -> Projection {
    Projection::Perspective { yfov_rad, znear_m, zfar_m }
}

pub fn orthographic() -> Projection {
    Projection::Orthographic { xmag_m: 2.0, ymag_m: 2.0, znear_m: 0.5, zfar_m: 20.0 }
}

/// A camera at `eye` that looks at `target`, +Y up.
pub fn camera_at(eye: Vec3, target: Vec3, projection: Projection) -> Camera {
    let world_from_view = glam::camera::rh::view::look_at_mat4(eye, target, Vec3::Y).inverse();
    Camera { name: "test".into(), world_from_view, projection }
}

/// One instance of each mesh, all with one material.
pub fn scene_of(material: Material, meshes: Vec<(Mesh, Mat4)>) -> Scene {
    let instances = (0..meshes.len()).map(|mesh| Instance::new(mesh, meshes[mesh].1)).collect();
    let meshes = meshes.into_iter().map(|(mesh, _)| mesh).collect();
    Scene { meshes, instances, materials: vec![material], ..Scene::default() }
}

/// A square of half extent `half` in z = 0 that faces +Z, texcoord (0, 0) at its upper left.
pub fn square(half: f32) -> Mesh {
    let corners = [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
    Mesh {
        positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0) * half).to_vec(),
        normals: vec![Vec3::Z; 4],
        tangents: vec![Vec3::X.extend(1.0); 4],
        texcoords: [corners.map(|(x, y)| glam::Vec2::new(x + 1.0, 1.0 - y) * 0.5).to_vec(), Vec::new()],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    }
}

/// Unit vector at this cosine from +Z and this azimuth.
pub fn direction(cos: f64, azimuth: f64) -> DVec3 {
    let sin = (1.0 - cos * cos).sqrt();
    DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

/// The part of light from a uniform environment that a *metal* reflects towards a viewer at this cosine:
/// the integral of BRDF n·l, over half vectors placed where the microfacets are (Walter et al. 2007, eq. 35).
pub fn directional_albedo(surface: &Attributes, n_dot_v: f64) -> DVec3 {
    const RINGS: u32 = 400;
    const SECTORS: u32 = 200;
    let v = direction(n_dot_v, 0.0);
    let alpha = alpha_from_roughness(surface.roughness);
    let mut sum = DVec3::ZERO;
    for ring in 0..RINGS {
        let u = (f64::from(ring) + 0.5) / f64::from(RINGS);
        let tan2 = alpha * alpha * u / (1.0 - u);
        let cos = (1.0 / (1.0 + tan2)).sqrt();
        // The density of h per solid angle, and of l = reflect(v, h): dω_h = dω_l / (4 v·h).
        let d = 1.0
            / (std::f64::consts::PI * alpha * alpha * cos.powi(4) * (1.0 + tan2 / (alpha * alpha)).powi(2));
        for sector in 0..SECTORS {
            let h = direction(cos, TAU * (f64::from(sector) + 0.5) / f64::from(SECTORS));
            let v_dot_h = v.dot(h);
            let l = h * (2.0 * v_dot_h) - v;
            if v_dot_h > 0.0 && l.z > 0.0 {
                sum += brdf(surface, DVec3::Z, v, l) * (l.z * 4.0 * v_dot_h / (d * cos));
            }
        }
    }
    sum / f64::from(RINGS * SECTORS)
}

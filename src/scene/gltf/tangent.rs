//! Normals and tangents that a file leaves out, as glTF 2.0 section 3.7.2.1 asks for.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::scene::{Mesh, TextureRef};

/// Gives every triangle vertices of its own.
pub fn unweld(mesh: &mut Mesh) {
    let indices = std::mem::take(&mut mesh.indices);
    fn pick<T: Copy>(list: &mut Vec<T>, indices: &[u32]) {
        if !list.is_empty() {
            *list = indices.iter().map(|&i| list[i as usize]).collect();
        }
    }
    pick(&mut mesh.positions, &indices);
    pick(&mut mesh.normals, &indices);
    pick(&mut mesh.tangents, &indices);
    mesh.texcoords.iter_mut().for_each(|list| pick(list, &indices));
    pick(&mut mesh.colors, &indices);
    mesh.indices = (0..indices.len() as u32).collect();
}

/// Makes vertices that agree in every bit one.
fn weld(mesh: &mut Mesh) {
    let mut known = HashMap::with_capacity(mesh.positions.len());
    let mut kept = Vec::new();
    let new_index: Vec<u32> = (0..mesh.positions.len())
        .map(|i| {
            *known.entry(vertex_bits(mesh, i)).or_insert_with(|| {
                kept.push(i as u32);
                kept.len() as u32 - 1
            })
        })
        .collect();
    drop(known);
    let indices = mesh.indices.iter().map(|&i| new_index[i as usize]).collect();
    mesh.indices = kept;
    unweld(mesh);
    mesh.indices = indices;
}

fn vertex_bits(mesh: &Mesh, i: usize) -> [u32; 18] {
    fn copy<const N: usize>(bits: &mut [u32], values: Option<[f32; N]>) {
        bits.iter_mut().zip(values.iter().flatten()).for_each(|(bit, value)| *bit = value.to_bits());
    }
    let mut bits = [0; 18];
    copy(&mut bits[0..3], Some(mesh.positions[i].to_array()));
    copy(&mut bits[3..6], mesh.normals.get(i).map(Vec3::to_array));
    copy(&mut bits[6..10], mesh.tangents.get(i).map(Vec4::to_array));
    copy(&mut bits[10..12], mesh.texcoords[0].get(i).map(Vec2::to_array));
    copy(&mut bits[12..14], mesh.texcoords[1].get(i).map(Vec2::to_array));
    copy(&mut bits[14..18], mesh.colors.get(i).map(Vec4::to_array));
    bits
}

/// The sum of the normals of the triangles around each vertex, weighted by area; of any length.
fn area_normals(mesh: &Mesh) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[triangle[k] as usize].as_dvec3());
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|&i| sums[i as usize] += normal);
    }
    sums
}

/// Unit length however short; +Z where there is no direction.
fn unit(v: DVec3) -> Vec3 {
    let longest = v.abs().max_element();
    (v / longest).try_normalize().map_or(Vec3::Z, |v| v.as_vec3().normalize())
}

/// Unwelds the mesh and gives each triangle its geometric normal.
pub fn make_flat_normals(mesh: &mut Mesh) {
    unweld(mesh);
    mesh.normals = area_normals(mesh).into_iter().map(unit).collect();
}

/// Makes all normals unit length. One without a direction becomes that of the triangles around it; returns how
/// many did.
pub fn normalize_normals(mesh: &mut Mesh) -> usize {
    let lost = mesh.normals.iter().filter(|n| **n == Vec3::ZERO).count();
    let flat = if lost > 0 { area_normals(mesh) } else { Vec::new() };
    for (i, n) in mesh.normals.iter_mut().enumerate() {
        *n = if *n == Vec3::ZERO { unit(flat[i]) } else { unit(n.as_dvec3()) };
    }
    lost
}

/// Makes all tangents unit length and their signs ±1. One without a direction becomes any that is square to
/// the normal.
pub fn normalize_tangents(mesh: &mut Mesh) {
    for (t, n) in mesh.tangents.iter_mut().zip(&mesh.normals) {
        let direction = t.truncate();
        let direction = match direction.is_finite() && direction != Vec3::ZERO {
            true => unit(direction.as_dvec3()),
            false => n.any_orthonormal_vector(),
        };
        *t = direction.extend(if t.w < 0.0 { -1.0 } else { 1.0 });
    }
}

/// Tangents by MikkTSpace, on vertices that are split where they must be. They follow the coordinates that the
/// normal texture is sampled with; a mesh without these gets any tangents, for the texture is not sampled.
pub fn make_tangents(mesh: &mut Mesh, normal_texture: &TextureRef) {
    mesh.tangents.clear();
    if !mesh.texcoords[normal_texture.texcoord].is_empty() {
        unweld(mesh);
        mesh.tangents = mikktspace_tangents(mesh, normal_texture).unwrap_or_default();
    }
    let done = !mesh.tangents.is_empty();
    mesh.tangents.resize(mesh.positions.len(), Vec4::W);
    normalize_tangents(mesh);
    if done {
        weld(mesh);
    }
}

/// The tangents of an unwelded mesh; `None` if the algorithm gives up.
fn mikktspace_tangents(mesh: &Mesh, normal_texture: &TextureRef) -> Option<Vec<Vec4>> {
    // The algorithm recurses once per triangle around a vertex: a large fan needs a deep stack.
    let stack_bytes = (4 << 20) + mesh.indices.len() / 3 * 1024;
    let tangents = vec![Vec4::W; mesh.positions.len()];
    let mut geometry = Unwelded { mesh, normal_texture, tangents };
    std::thread::scope(|scope| {
        let run = || mikktspace::generate_tangents(&mut geometry).then_some(geometry.tangents);
        std::thread::Builder::new().stack_size(stack_bytes).spawn_scoped(scope, run).ok()?.join().ok()?
    })
}

struct Unwelded<'a> {
    mesh: &'a Mesh,
    normal_texture: &'a TextureRef,
    tangents: Vec<Vec4>,
}

impl mikktspace::Geometry for Unwelded<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.positions.len() / 3
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.positions[face * 3 + vert].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.normals[face * 3 + vert].to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        let texcoord = self.mesh.texcoords[self.normal_texture.texcoord][face * 3 + vert];
        self.normal_texture.uv(texcoord).to_array()
    }

    fn set_tangent_encoded(&mut self, [x, y, z, sign]: [f32; 4], face: usize, vert: usize) {
        // MikkTSpace's bitangent follows growing v; glTF's points up in the picture, where v falls.
        self.tangents[face * 3 + vert] = Vec4::new(x, y, z, -sign);
    }
}

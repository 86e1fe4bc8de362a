//! Normals and tangents that a file leaves out, as glTF 2.0 section 3.7.2.1 asks for.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::scene::{Mesh, MorphTarget, TextureRef};

/// Gives every triangle vertices of its own.
pub fn unweld(mesh: &mut Mesh) {
    let indices = std::mem::take(&mut mesh.indices);
    let sets = mesh.deformation.as_ref().map_or(0, |d| d.sets(mesh.positions.len()));
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
    if let Some(deformation) = &mut mesh.deformation {
        if sets > 0 {
            let old = std::mem::take(&mut deformation.influences);
            let of = |&i: &u32| &old[i as usize * sets..(i as usize + 1) * sets];
            deformation.influences = indices.iter().flat_map(of).copied().collect();
        }
        for MorphTarget { positions, normals, tangents } in &mut deformation.targets {
            [positions, normals, tangents].into_iter().for_each(|list| pick(list, &indices));
        }
    }
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

/// All that makes a vertex what it is; the second part is of what bends the mesh.
fn vertex_bits(mesh: &Mesh, i: usize) -> ([u32; 18], Vec<u32>) {
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
    let more = mesh.deformation.as_ref().map(|d| d.vertex_bits(i, mesh.positions.len()));
    (bits, more.unwrap_or_default())
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

/// MikkTSpace takes quadratic time, and its recursion that deep a stack, in the number of triangles around a
/// vertex and in the number of vertices at a position.
const MAX_VALENCE: u32 = 4096;
/// Enough for a recursion over [`MAX_VALENCE`] triangles.
const STACK_BYTES: usize = 8 << 20;

/// Tangents by MikkTSpace, on vertices that are split where they must be. They follow the coordinates that the
/// normal texture is sampled with; a mesh without these gets any tangents, for the texture is not sampled.
///
/// # Errors
/// Why the tangents are not MikkTSpace's although the texture is sampled; they are then any that are square to
/// the normals.
pub fn make_tangents(mesh: &mut Mesh, normal_texture: &TextureRef) -> Result<(), &'static str> {
    mesh.tangents.clear();
    let mut outcome = Ok(());
    if !mesh.texcoords[normal_texture.texcoord].is_empty() {
        weld(mesh);
        if max_valence(mesh) > MAX_VALENCE {
            outcome = Err("too many triangles meet in one point");
        } else {
            unweld(mesh);
            match mikktspace_tangents(mesh, normal_texture) {
                Some(tangents) => mesh.tangents = tangents,
                None => outcome = Err("MikkTSpace failed"),
            }
        }
    }
    let split = !mesh.tangents.is_empty();
    mesh.tangents.resize(mesh.positions.len(), Vec4::W);
    normalize_tangents(mesh);
    if split {
        weld(mesh);
    }
    outcome
}

/// The greatest number of triangles around a vertex or of vertices at a position.
fn max_valence(mesh: &Mesh) -> u32 {
    let mut triangles = vec![0; mesh.positions.len()];
    mesh.indices.iter().for_each(|&i| triangles[i as usize] += 1);
    let mut vertices = HashMap::with_capacity(mesh.positions.len());
    for p in &mesh.positions {
        // Adding zero makes -0 and 0 one.
        *vertices.entry((*p + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert(0) += 1;
    }
    triangles.into_iter().chain(vertices.into_values()).max().unwrap_or(0)
}

/// The tangents of an unwelded mesh; `None` if the algorithm gives up.
fn mikktspace_tangents(mesh: &Mesh, normal_texture: &TextureRef) -> Option<Vec<Vec4>> {
    let texcoords = &mesh.texcoords[normal_texture.texcoord];
    let mut geometry = Unwelded {
        positions: into_unit_box(mesh.positions.iter().map(Vec3::to_array)),
        texcoords: into_unit_box(texcoords.iter().map(|t| normal_texture.uv(*t).to_array())),
        normals: &mesh.normals,
        tangents: vec![Vec4::W; mesh.positions.len()],
    };
    std::thread::scope(|scope| {
        let run = || mikktspace::generate_tangents(&mut geometry).then_some(geometry.tangents);
        std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, run).ok()?.join().ok()?
    })
}

/// Moved and scaled (by one factor for all axes) into [0, 1]: MikkTSpace's directions do not depend on either,
/// but its arithmetic overflows for large values and takes small ones for zero.
fn into_unit_box<const N: usize>(points: impl Iterator<Item = [f32; N]> + Clone) -> Vec<[f32; N]> {
    let (mut min, mut max) = ([f64::INFINITY; N], [f64::NEG_INFINITY; N]);
    for point in points.clone() {
        for axis in 0..N {
            min[axis] = min[axis].min(f64::from(point[axis]));
            max[axis] = max[axis].max(f64::from(point[axis]));
        }
    }
    let extent = (0..N).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
    let scale = if extent > 0.0 { 1.0 / extent } else { 1.0 };
    let map = |point: [f32; N]| {
        std::array::from_fn(|axis| {
            let value = ((f64::from(point[axis]) - min[axis]) * scale) as f32;
            if value.is_finite() { value } else { 0.0 }
        })
    };
    points.map(map).collect()
}

struct Unwelded<'a> {
    positions: Vec<[f32; 3]>,
    texcoords: Vec<[f32; 2]>,
    normals: &'a [Vec3],
    tangents: Vec<Vec4>,
}

impl mikktspace::Geometry for Unwelded<'_> {
    fn num_faces(&self) -> usize {
        self.positions.len() / 3
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.positions[face * 3 + vert]
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.normals[face * 3 + vert].to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.texcoords[face * 3 + vert]
    }

    fn set_tangent_encoded(&mut self, [x, y, z, sign]: [f32; 4], face: usize, vert: usize) {
        // MikkTSpace's bitangent follows growing v; glTF's points up in the picture, where v falls.
        self.tangents[face * 3 + vert] = Vec4::new(x, y, z, -sign);
    }
}

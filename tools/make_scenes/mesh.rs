//! Triangle lists and the operations that all shapes share.
//!
//! Texture coordinates are in metres along the surface (u to the right, v down, as seen from outside), so that
//! one KHR_texture_transform per material gives every object the same grain.

use glam::{Affine3A, Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Indexed triangles, counter-clockwise seen from outside. Lists are empty or as long as `positions`.
#[derive(Clone, Default)]
pub struct Mesh {
    /// Object space, metres.
    pub positions: Vec<Vec3>,
    /// Unit length.
    pub normals: Vec<Vec3>,
    /// Unit length and the bitangent's sign.
    pub tangents: Vec<Vec4>,
    /// Metres, or a picture's own [0, 1].
    pub texcoords: Vec<Vec2>,
    /// Linear Rec.709 and alpha.
    pub colors: Vec<Vec4>,
    /// Three per triangle.
    pub indices: Vec<u32>,
}

/// One vertex of a smooth surface.
#[derive(Clone, Copy)]
pub struct Vertex {
    pub position: Vec3,
    pub normal: Vec3,
    pub texcoord: Vec2,
}

impl Mesh {
    /// Adds a vertex and returns its index.
    pub fn push(&mut self, vertex: Vertex) -> u32 {
        self.positions.push(vertex.position);
        self.normals.push(vertex.normal);
        self.texcoords.push(vertex.texcoord);
        self.positions.len() as u32 - 1
    }

    /// Adds a triangle unless two of its corners coincide.
    pub fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|i| self.positions[i as usize]);
        if (b - a).cross(c - a).length_squared() > 1e-16 {
            self.indices.extend(corners);
        }
    }

    /// Adds a flat convex polygon that faces `normal`, whichever way round its points are given.
    pub fn polygon(&mut self, points: &[Vec3], normal: Vec3) {
        let turn = (points[1] - points[0]).cross(points[2] - points[0]).dot(normal);
        let start = self.positions.len() as u32;
        for &position in points {
            self.push(Vertex { position, normal, texcoord: planar_texcoord(position, normal) });
        }
        for i in 2..points.len() as u32 {
            let (b, c) = if turn > 0.0 { (i - 1, i) } else { (i, i - 1) };
            self.triangle([start, start + b, start + c]);
        }
    }

    /// A `columns` by `rows` grid of quads; `surface` gets (0..1 to the right, 0..1 upward) as seen from outside.
    pub fn patch(columns: usize, rows: usize, surface: impl Fn(f32, f32) -> Vertex) -> Self {
        let mut mesh = Self::default();
        for j in 0..=rows {
            for i in 0..=columns {
                mesh.push(surface(i as f32 / columns as f32, j as f32 / rows as f32));
            }
        }
        let index = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
        for j in 0..rows {
            for i in 0..columns {
                let (a, b, c, d) = (index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
                mesh.triangle([a, b, c]);
                mesh.triangle([a, c, d]);
            }
        }
        mesh
    }

    /// A patch whose normals are averaged from its triangles.
    pub fn smooth_patch(columns: usize, rows: usize, surface: impl Fn(f32, f32) -> (Vec3, Vec2)) -> Self {
        let mut mesh = Self::patch(columns, rows, |u, v| {
            let (position, texcoord) = surface(u, v);
            Vertex { position, normal: Vec3::ZERO, texcoord }
        });
        for corners in mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[corners[k] as usize]);
            let area_normal = (b - a).cross(c - a);
            for &i in corners {
                mesh.normals[i as usize] += area_normal;
            }
        }
        mesh.normals.iter_mut().for_each(|n| *n = n.normalize());
        mesh
    }

    /// The same triangles with flat normals and no shared vertices.
    pub fn faceted(&self) -> Self {
        let mut mesh = Self::default();
        for corners in self.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| self.positions[corners[k] as usize]);
            let normal = (b - a).cross(c - a).normalize();
            for (k, &i) in corners.iter().enumerate() {
                let texcoord = self.texcoords[i as usize];
                mesh.push(Vertex { position: [a, b, c][k], normal, texcoord });
                mesh.indices.push(mesh.indices.len() as u32);
            }
        }
        mesh
    }

    /// Moves the mesh rigidly; scales must be uniform and positive.
    pub fn transformed(mut self, transform: Affine3A) -> Self {
        self.positions.iter_mut().for_each(|p| *p = transform.transform_point3(*p));
        self.normals.iter_mut().for_each(|n| *n = transform.transform_vector3(*n).normalize());
        self
    }

    /// Moves the mesh.
    pub fn at(self, x_m: f32, y_m: f32, z_m: f32) -> Self {
        self.transformed(Affine3A::from_translation(Vec3::new(x_m, y_m, z_m)))
    }

    /// Several meshes as one. All have the same lists.
    pub fn merged(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut whole = Self::default();
        for part in parts {
            let base = whole.positions.len() as u32;
            whole.positions.extend(part.positions);
            whole.normals.extend(part.normals);
            whole.tangents.extend(part.tangents);
            whole.texcoords.extend(part.texcoords);
            whole.colors.extend(part.colors);
            whole.indices.extend(part.indices.iter().map(|i| i + base));
        }
        whole
    }

    /// Vertices that agree in position, normal and texture coordinate become one.
    pub fn welded(&self) -> Self {
        let mut mesh = Self::default();
        let mut known = HashMap::new();
        let merged: Vec<u32> = (0..self.positions.len())
            .map(|i| {
                let vertex = Vertex {
                    position: self.positions[i],
                    normal: self.normals[i],
                    texcoord: self.texcoords[i],
                };
                let bits = |v: &[f32]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                let key = [
                    bits(&vertex.position.to_array()),
                    bits(&vertex.normal.to_array()),
                    bits(&vertex.texcoord.to_array()),
                ];
                *known.entry(key).or_insert_with(|| mesh.push(vertex))
            })
            .collect();
        mesh.indices = self.indices.iter().map(|&i| merged[i as usize]).collect();
        mesh
    }

    /// Vertex colours from position and normal.
    pub fn colored(mut self, color: impl Fn(Vec3, Vec3) -> Vec3) -> Self {
        self.colors =
            self.positions.iter().zip(&self.normals).map(|(p, n)| color(*p, *n).extend(1.0)).collect();
        self
    }

    /// Leaves texture coordinates out, for untextured materials.
    pub fn untextured(mut self) -> Self {
        self.texcoords.clear();
        self
    }

    /// Tangents along +u, averaged over triangles by area. The bitangent's sign makes
    /// `cross(normal, tangent) * w` point to -v, the picture's top, as glTF 2.0 section 3.9.3 wants it.
    pub fn with_tangents(mut self) -> Self {
        let mut along_u = vec![Vec3::ZERO; self.positions.len()];
        let mut along_up = along_u.clone();
        for corners in self.indices.chunks_exact(3) {
            let p = [0, 1, 2].map(|k| self.positions[corners[k] as usize]);
            let t = [0, 1, 2].map(|k| self.texcoords[corners[k] as usize]);
            let (e1, e2, d1, d2) = (p[1] - p[0], p[2] - p[0], t[1] - t[0], t[2] - t[0]);
            // Solves e = d.x * dp/du + d.y * dp/dv; the determinant's sign is kept, its size weighs by area.
            let sign = d1.perp_dot(d2).signum();
            for &i in corners {
                along_u[i as usize] += (e1 * d2.y - e2 * d1.y) * sign;
                along_up[i as usize] += (e1 * d2.x - e2 * d1.x) * sign;
            }
        }
        self.tangents = (0..self.positions.len())
            .map(|i| {
                let normal = self.normals[i];
                let tangent = (along_u[i] - normal * normal.dot(along_u[i]))
                    .try_normalize()
                    .unwrap_or_else(|| normal.any_orthonormal_vector());
                let mirrored = normal.cross(tangent).dot(along_up[i]) < 0.0;
                tangent.extend(if mirrored { -1.0 } else { 1.0 })
            })
            .collect();
        self
    }
}

/// Texture coordinates in metres on a flat face: upright on walls, the top towards -z on floors.
pub fn planar_texcoord(position: Vec3, normal: Vec3) -> Vec2 {
    let (n, p) = (normal.abs(), position);
    if n.y >= n.x && n.y >= n.z {
        Vec2::new(p.x, p.z * normal.y.signum())
    } else if n.x >= n.z {
        Vec2::new(-p.z * normal.x.signum(), -p.y)
    } else {
        Vec2::new(p.x * normal.z.signum(), -p.y)
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape;
    use super::*;

    fn shapes() -> Vec<Mesh> {
        let ring = [(0.5, 0.0), (0.6, 0.0), (0.6, 0.1), (0.5, 0.1), (0.5, 0.0)].map(Vec2::from);
        vec![
            shape::cuboid(Vec3::new(1.0, 2.0, 3.0), 0.1),
            shape::sphere(0.5, 12, 8),
            shape::lathe(&ring, 12, 1.0),
            shape::tube(&[Vec3::ZERO, Vec3::Y, Vec3::new(1.0, 1.5, 0.0)], 0.05, 6),
        ]
    }

    #[test]
    fn triangles_face_the_way_of_their_normals() {
        for (which, mesh) in shapes().iter().enumerate() {
            for corners in mesh.indices.chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[corners[k] as usize]);
                let face = (b - a).cross(c - a);
                for &i in corners {
                    assert!(face.dot(mesh.normals[i as usize]) > 0.0, "shape {which}, vertex {i}");
                }
            }
        }
    }

    #[test]
    fn closed_shapes_enclose_their_volume() {
        // Divergence theorem: the volume is a sixth of the sum of the corners' triple products.
        let volume = |mesh: &Mesh| -> f32 {
            let corner = |i: &u32| mesh.positions[*i as usize];
            let triple = |t: &[u32]| corner(&t[0]).dot(corner(&t[1]).cross(corner(&t[2])));
            mesh.indices.chunks_exact(3).map(triple).sum::<f32>() / 6.0
        };
        let sharp = volume(&shape::cuboid(Vec3::new(1.0, 2.0, 3.0), 0.0));
        assert!((sharp - 6.0).abs() < 1e-4, "{sharp}");
        // An inscribed polyhedron is a little smaller than the sphere.
        let ball = volume(&shape::sphere(1.0, 64, 32)) / (4.0 / 3.0 * std::f32::consts::PI);
        assert!((0.98..1.0).contains(&ball), "{ball}");
    }

    #[test]
    fn tangents_point_along_u_and_bitangents_to_the_top() {
        let wall = Mesh::patch(1, 1, |u, v| Vertex {
            position: Vec3::new(u, v, 0.0),
            normal: Vec3::Z,
            texcoord: Vec2::new(u, 1.0 - v),
        });
        assert!(
            wall.clone()
                .with_tangents()
                .tangents
                .iter()
                .all(|t| t.distance(Vec4::new(1.0, 0.0, 0.0, 1.0)) < 1e-6)
        );
        let mut mirrored = wall;
        mirrored.texcoords.iter_mut().for_each(|t| t.x = -t.x);
        let expected = Vec4::new(-1.0, 0.0, 0.0, -1.0);
        assert!(mirrored.with_tangents().tangents.iter().all(|t| t.distance(expected) < 1e-6));
    }
}

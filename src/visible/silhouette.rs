//! What shadow volumes are made of: the triangles of a mesh, and its edges with the triangles on either side.
//!
//! A light's shadow is what is behind the triangles that face it (Crow, "Shadow Algorithms for Computer Graphics", 1977; counted
//! behind surfaces, as Everitt and Kilgard, "Practical and Robust Stenciled Shadow Volumes", 2002): between each of them and its image
//! at an infinite distance from the light. Where two of them share an edge, the walls between them cancel; walls are left along
//! edges of which one side faces the light. That holds for any mesh, closed or not, and for edges of more than two triangles,
//! since each half of an edge is paired at most once and by itself otherwise.

use std::collections::HashMap;
use std::hash::Hash;

use glam::Vec3;

/// A mesh as shadow volumes see it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CasterMesh {
    /// Distinct places, object space, metres.
    pub positions: Vec<Vec3>,
    /// The first vertex at each of them.
    pub sources: Vec<u32>,
    /// Three different places each, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// From place to place as the first triangle goes round, the first triangle, and the one on the other side, which goes round the
    /// other way; [`Self::NONE`] if there is none.
    pub edges: Vec<[u32; 4]>,
}

impl CasterMesh {
    /// There is no triangle.
    pub const NONE: u32 = u32::MAX;

    /// Of a mesh's triangles: vertices at one place are one, whatever else sets them apart. `indices` are below the number of
    /// positions, three a triangle.
    pub fn new(positions: &[Vec3], indices: &[u32]) -> Self {
        Self::by(positions, indices, |_| ())
    }

    /// Likewise where vertices must have more in common than their place to be one: of what bends, what bends them.
    pub fn by<K: Hash + Eq>(positions: &[Vec3], indices: &[u32], key: impl Fn(usize) -> K) -> Self {
        let mut mesh = Self::default();
        let mut places: HashMap<([u32; 3], K), u32> = HashMap::new();
        let mut welded = Vec::with_capacity(positions.len());
        for (vertex, position) in positions.iter().enumerate() {
            // Adding 0 makes the two zeros one.
            let key = ((*position + Vec3::ZERO).to_array().map(f32::to_bits), key(vertex));
            let next = mesh.positions.len() as u32;
            let index = *places.entry(key).or_insert(next);
            if index == next {
                mesh.positions.push(*position);
                mesh.sources.push(vertex as u32);
            }
            welded.push(index);
        }
        // Halves of edges that wait for their other half, by their ends: indices into `edges`.
        let mut open: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
        for corners in indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| welded[corners[i] as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            let triangle = mesh.triangles.len() as u32;
            mesh.triangles.push([a, b, c]);
            for [from, to] in [[a, b], [b, c], [c, a]] {
                match open.get_mut(&[to, from]).and_then(Vec::pop) {
                    Some(edge) => mesh.edges[edge][3] = triangle,
                    None => {
                        open.entry([from, to]).or_default().push(mesh.edges.len());
                        mesh.edges.push([from, to, triangle, Self::NONE]);
                    }
                }
            }
        }
        mesh
    }

    /// Vertices that draw its shadow volume: two triangles an edge, and both ends of each triangle's.
    pub fn vertex_count(&self) -> u32 {
        6 * (self.edges.len() + self.triangles.len()) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> (Vec<Vec3>, Vec<u32>) {
        // Four vertices a side, so that none is shared.
        let mut positions = Vec::new();
        let mut indices = Vec::new();
        for axis in 0..3 {
            for sign in [-1.0_f32, 1.0] {
                let first = positions.len() as u32;
                for [u, v] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
                    let mut p = [0.0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, u * sign, v);
                    positions.push(Vec3::from_array(p));
                }
                indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
            }
        }
        (positions, indices)
    }

    #[test]
    fn a_closed_mesh_has_two_triangles_at_each_edge() {
        let (positions, indices) = cube();
        let mesh = CasterMesh::new(&positions, &indices);
        assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.edges.len()), (8, 12, 18));
        assert!(mesh.edges.iter().all(|edge| edge[3] != CasterMesh::NONE));
        assert_eq!(mesh.vertex_count(), 180);
    }

    /// An open mesh, one with an edge of three triangles, and triangles without area.
    #[test]
    fn halves_without_another_stay_alone() {
        let (positions, mut indices) = cube();
        indices.truncate(30);
        let open = CasterMesh::new(&positions, &indices).edges;
        assert_eq!(open.iter().filter(|edge| edge[3] == CasterMesh::NONE).count(), 4);
        let fan = [Vec3::ZERO, Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z];
        let mesh = CasterMesh::new(&fan, &[0, 1, 2, 1, 0, 3, 0, 1, 4, 2, 2, 3]);
        assert_eq!(mesh.triangles.len(), 3);
        let shared = mesh.edges.iter().filter(|edge| edge[..2] == [0, 1]);
        assert_eq!(shared.map(|edge| edge[3] == CasterMesh::NONE).collect::<Vec<_>>(), [false, true]);
    }

    #[test]
    fn the_two_zeros_are_one_place() {
        let mesh = CasterMesh::new(&[Vec3::ZERO, -Vec3::ZERO, Vec3::X, Vec3::Y], &[0, 2, 3, 2, 1, 3]);
        assert_eq!((mesh.positions.len(), mesh.edges.len()), (3, 3));
    }
}

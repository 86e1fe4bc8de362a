//! Triangles and where they stand.

use glam::{Mat4, Vec2, Vec3, Vec4};

use super::deformation::PosedBounds;
use super::{Deformation, LightmapRect};

/// Indexed triangles in object space with one material.
///
/// Every attribute list is either empty (absent) or as long as `positions`.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// A name for messages.
    pub name: String,
    /// Object space, metres.
    pub positions: Vec<Vec3>,
    /// Object space, unit length. Present whenever the material is lit.
    pub normals: Vec<Vec3>,
    /// Object space, xyz of unit length, w = ±1 the bitangent's sign as glTF defines it
    /// (`bitangent = cross(normal, tangent) * w`). Present whenever the material has a normal texture.
    pub tangents: Vec<Vec4>,
    /// TEXCOORD_0 and TEXCOORD_1; (0, 0) is the first texel's corner.
    pub texcoords: [Vec<Vec2>; 2],
    /// COLOR_0, linear Rec.709 and alpha; multiplies the base colour.
    pub colors: Vec<Vec4>,
    /// Three per triangle; each is below `positions.len()`.
    pub indices: Vec<u32>,
    /// Index into `Scene::materials`.
    pub material: usize,
    /// What bends it; `None`: nothing does.
    pub deformation: Option<Deformation>,
}

impl Mesh {
    /// What is wrong with the lists' lengths and indices.
    pub(crate) fn lists_problem(&self) -> Option<String> {
        let vertices = self.positions.len();
        let [first, second] = &self.texcoords;
        let lengths = [self.normals.len(), self.tangents.len(), first.len(), second.len(), self.colors.len()];
        if lengths.iter().any(|&n| n != 0 && n != vertices) {
            Some(format!("{vertices} positions, but other attributes of lengths {lengths:?}"))
        } else if let Some(index) = self.indices.iter().find(|&&i| i as usize >= vertices) {
            Some(format!("{vertices} vertices, but an index {index}"))
        } else if !self.indices.len().is_multiple_of(3) {
            Some(format!("{} indices, which is not three a triangle", self.indices.len()))
        } else {
            let deformation = self.deformation.as_ref();
            deformation.and_then(|d| d.problem([vertices, self.normals.len(), self.tangents.len()]))
        }
    }

    /// The bounds in object space; `None` without vertices. Of what bends they hold all of it as it is posed, and may be larger.
    pub fn bounds(&self) -> Option<Aabb> {
        if let (Some(bounds), Some(deformation)) = (PosedBounds::new(self), &self.deformation) {
            return Some(bounds.of(&deformation.pose));
        }
        let (first, rest) = self.positions.split_first()?;
        let start = Aabb { min: *first, max: *first };
        Some(rest.iter().fold(start, |b, p| Aabb { min: b.min.min(*p), max: b.max.max(*p) }))
    }
}

/// One placement of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index into `Scene::meshes`.
    pub mesh: usize,
    /// Affine; a negative determinant mirrors (triangle winding flips).
    pub world_from_object: Mat4,
    /// Whether it will move: nothing that depends on its place is kept from frame to frame. What is not dynamic may be
    /// moved too, but then all that was kept (static shadow maps) is made anew.
    pub dynamic: bool,
    /// Its part of the scene's lightmap, if it has one; the mesh then has TEXCOORD_1.
    pub lightmap: Option<LightmapRect>,
    /// Neither drawn nor casting a shadow, as if it were not there.
    pub hidden: bool,
}

impl Instance {
    /// One that stays where it is.
    pub fn new(mesh: usize, world_from_object: Mat4) -> Self {
        Self { mesh, world_from_object, dynamic: false, lightmap: None, hidden: false }
    }

    /// Whether the transform turns the triangles' winding round.
    pub fn is_mirrored(&self) -> bool {
        self.world_from_object.determinant() < 0.0
    }
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The corner of least coordinates.
    pub min: Vec3,
    /// The corner of greatest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The smallest box around both.
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The middle.
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Half the diagonal: the radius of the sphere around the box.
    pub fn radius(&self) -> f32 {
        (self.max - self.min).length() * 0.5
    }

    /// The box around this box after an affine transform.
    pub fn transformed(&self, transform: &Mat4) -> Self {
        let center = transform.transform_point3(self.center());
        let half = (self.max - self.min) * 0.5;
        let extent = transform.x_axis.truncate().abs() * half.x
            + transform.y_axis.truncate().abs() * half.y
            + transform.z_axis.truncate().abs() * half.z;
        Self { min: center - extent, max: center + extent }
    }
}

//! Meshes that bend: by joints (skins) and by morph targets. Poses them in f64.

use std::borrow::Cow;

use glam::{DMat3, DMat4, DVec3, Mat4, Vec3};

use super::{Aabb, Mesh};

/// What bends a mesh. The mesh's own lists are as it is before: in its bind pose, without morph targets.
///
/// Positions, normals and tangents get the targets' displacements, each times its weight (glTF 2.0, section 3.7.2.2), and then go by the
/// mean of their joints' transforms (section 3.7.3.3): positions and tangents by that, normals by its inverse transpose. The mesh is posed once
/// a frame; every instance shows it as it is posed. Triangles keep their winding, whatever joints do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deformation {
    /// Which joints move each vertex: as many of these for each, side by side. Empty: none, the mesh has morph targets alone.
    pub influences: Vec<Influence>,
    /// What is added to the mesh.
    pub targets: Vec<MorphTarget>,
    /// How the mesh stands.
    pub pose: Pose,
}

/// Joints that move a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influence {
    /// Indices into [`Pose::object_from_bind`].
    pub joints: [u16; 4],
    /// At least 0, and more than 0 in all; what counts is each one's share of all weights of the vertex.
    pub weights: [f32; 4],
}

/// Displacements of vertices. Each list is empty (none) or as long as the mesh's, which has one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Object space, metres.
    pub positions: Vec<Vec3>,
    /// Object space.
    pub normals: Vec<Vec3>,
    /// Object space.
    pub tangents: Vec<Vec3>,
}

/// How a mesh stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// Where each joint takes the bind pose; affine.
    pub object_from_bind: Vec<Mat4>,
    /// How much there is of each morph target.
    pub weights: Vec<f32>,
}

/// Vertices of a mesh as its pose has them, object space.
#[derive(Clone, Debug, Default)]
pub(crate) struct Posed {
    /// Metres.
    pub positions: Vec<DVec3>,
    /// Unit length.
    pub normals: Vec<DVec3>,
    /// Unit length, and the bitangent's sign.
    pub tangents: Vec<(DVec3, f64)>,
}

impl Mesh {
    /// As its pose has it, if it has one.
    pub fn posed(&self) -> Cow<'_, Mesh> {
        let Some(posed) = self.posed_vertices() else { return Cow::Borrowed(self) };
        let Posed { positions, normals, tangents } = posed;
        Cow::Owned(Mesh {
            positions: positions.into_iter().map(|p| p.as_vec3()).collect(),
            normals: normals.into_iter().map(|n| n.as_vec3()).collect(),
            tangents: tangents.into_iter().map(|(t, sign)| t.as_vec3().extend(sign as f32)).collect(),
            deformation: None,
            ..self.clone()
        })
    }

    /// The same before it is rounded; `None` if nothing bends the mesh.
    pub(crate) fn posed_vertices(&self) -> Option<Posed> {
        let deformation = self.deformation.as_ref()?;
        let mut posed = Posed {
            positions: self.positions.iter().map(|p| p.as_dvec3()).collect(),
            normals: self.normals.iter().map(|n| n.as_dvec3()).collect(),
            tangents: self.tangents.iter().map(|t| (t.truncate().as_dvec3(), f64::from(t.w))).collect(),
        };
        let Deformation { targets, pose, .. } = deformation;
        for (target, weight) in targets.iter().zip(&pose.weights).filter(|(_, weight)| **weight != 0.0) {
            let weight = f64::from(*weight);
            let add = |to: &mut DVec3, by: &Vec3| *to += by.as_dvec3() * weight;
            posed.positions.iter_mut().zip(&target.positions).for_each(|(to, by)| add(to, by));
            posed.normals.iter_mut().zip(&target.normals).for_each(|(to, by)| add(to, by));
            posed.tangents.iter_mut().zip(&target.tangents).for_each(|((to, _), by)| add(to, by));
        }
        let blended: Vec<_> = (0..self.positions.len()).map(|v| self.object_from_vertex(v)).collect();
        for (position, m) in posed.positions.iter_mut().zip(&blended) {
            *position = m.transform_point3(*position);
        }
        for (normal, m) in posed.normals.iter_mut().zip(&blended) {
            // The cofactor matrix is the inverse transpose times the determinant, and never fails.
            let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate());
            let cofactor = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
            *normal = (cofactor * *normal).normalize_or_zero() * handedness(m);
        }
        for ((tangent, sign), m) in posed.tangents.iter_mut().zip(&blended) {
            *tangent = m.transform_vector3(*tangent).normalize_or_zero();
            *sign *= handedness(m);
        }
        Some(posed)
    }

    /// Whether joints turn this vertex inside out.
    pub(super) fn is_mirrored_at(&self, vertex: u32) -> bool {
        handedness(&self.object_from_vertex(vertex as usize)) < 0.0
    }

    /// The mean of a vertex's joints' transforms.
    fn object_from_vertex(&self, vertex: usize) -> DMat4 {
        let Some(deformation) = self.deformation.as_ref().filter(|d| !d.influences.is_empty()) else {
            return DMat4::IDENTITY;
        };
        let (mut sum, mut total) = (DMat4::ZERO, 0.0);
        for (joint, weight) in deformation.of_vertex(vertex, self.positions.len()) {
            sum += deformation.pose.object_from_bind[usize::from(joint)].as_dmat4() * f64::from(weight);
            total += f64::from(weight);
        }
        let mut mean = sum * (1.0 / total);
        mean.w_axis.w = 1.0;
        mean
    }
}

fn handedness(m: &DMat4) -> f64 {
    if DMat3::from_mat4(*m).determinant() < 0.0 { -1.0 } else { 1.0 }
}

impl Deformation {
    /// How many [`Influence`]s each of so many vertices has.
    pub(crate) fn sets(&self, vertices: usize) -> usize {
        self.influences.len() / vertices.max(1)
    }

    /// The joints that move one of so many vertices, with their weights, which are above 0.
    fn of_vertex(&self, vertex: usize, vertices: usize) -> impl Iterator<Item = (u16, f32)> {
        let sets = self.sets(vertices);
        let own = self.influences[vertex * sets..(vertex + 1) * sets].iter();
        let pairs = own.flat_map(|Influence { joints, weights }| joints.iter().copied().zip(*weights));
        pairs.filter(|(_, weight)| *weight != 0.0)
    }

    /// All that decides where one of so many vertices goes.
    pub(crate) fn vertex_bits(&self, vertex: usize, vertices: usize) -> Vec<u32> {
        let sets = self.sets(vertices);
        let mut bits = Vec::new();
        for Influence { joints, weights } in &self.influences[vertex * sets..(vertex + 1) * sets] {
            bits.extend(joints.map(u32::from));
            bits.extend(weights.map(f32::to_bits));
        }
        for MorphTarget { positions, normals, tangents } in &self.targets {
            let own = [positions, normals, tangents].into_iter().filter_map(|list| list.get(vertex));
            bits.extend(own.flat_map(|v| v.to_array().map(f32::to_bits)));
        }
        bits
    }

    /// What is wrong with the numbers, beside a mesh with so many positions, normals and tangents.
    pub(super) fn problem(&self, [vertices, normals, tangents]: [usize; 3]) -> Option<String> {
        let Self { influences, targets, pose } = self;
        let joints = pose.object_from_bind.len();
        let lengths = |target: &MorphTarget| {
            let fits = |list: &[Vec3], of_mesh: usize| list.is_empty() || list.len() == of_mesh;
            fits(&target.positions, vertices)
                && fits(&target.normals, normals)
                && fits(&target.tangents, tangents)
        };
        let numbers = |target: &MorphTarget| {
            let MorphTarget { positions, normals, tangents } = target;
            positions.iter().chain(normals).chain(tangents).all(|v| v.is_finite())
        };
        if !influences.len().is_multiple_of(vertices.max(1)) {
            return Some(format!(
                "{} influences are not alike many for {vertices} vertices",
                influences.len()
            ));
        }
        for vertex in (0..vertices).filter(|_| !influences.is_empty()) {
            let sets = self.sets(vertices);
            let all = influences[vertex * sets..(vertex + 1) * sets].iter().flat_map(|i| i.weights);
            if !all.clone().all(|w| w.is_finite() && w >= 0.0) || all.sum::<f32>() <= 0.0 {
                return Some(format!(
                    "the weights of vertex {vertex} are not finite, negative, or add up to 0"
                ));
            }
            let mut beyond =
                self.of_vertex(vertex, vertices).filter(|(joint, _)| usize::from(*joint) >= joints);
            if let Some((joint, _)) = beyond.next() {
                return Some(format!("vertex {vertex} uses joint {joint}, and there are {joints}"));
            }
        }
        if let Some(target) = targets.iter().position(|target| !lengths(target)) {
            return Some(format!("morph target {target} has lists of other lengths than the mesh"));
        }
        if let Some(target) = targets.iter().position(|target| !numbers(target)) {
            return Some(format!("morph target {target} has a number that is not finite"));
        }
        self.pose_problem(pose)
    }

    /// What is wrong with a pose for this.
    pub(crate) fn pose_problem(&self, pose: &Pose) -> Option<String> {
        let joints = self.pose.object_from_bind.len();
        if (pose.object_from_bind.len(), pose.weights.len()) != (joints, self.targets.len()) {
            let (given, weights) = (pose.object_from_bind.len(), pose.weights.len());
            let targets = self.targets.len();
            Some(format!("a pose of {given} joints and {weights} weights, not of {joints} and {targets}"))
        } else if !pose.object_from_bind.iter().all(|m| m.is_finite() && m.row(3) == glam::Vec4::W) {
            Some("a joint's transform is not affine and finite".into())
        } else {
            (!pose.weights.iter().all(|w| w.is_finite())).then(|| "a weight is not finite".into())
        }
    }
}

/// What bounds a mesh in any pose: a vertex is a mean of where its joints take it, so that it is in the box around the boxes that each
/// joint moves; displacements grow these.
#[derive(Clone, Debug, Default)]
pub(crate) struct PosedBounds {
    /// Of each joint, around the vertices that it moves; one where there are no joints.
    joints: Vec<Option<Aabb>>,
    /// Of each morph target, around its displacements and none at all.
    targets: Vec<Aabb>,
}

impl PosedBounds {
    /// What f32 may round away, as a share of the numbers that are added up.
    const ROUNDING: f32 = 1e-5;

    /// `None` without vertices, or if nothing bends the mesh.
    pub(crate) fn new(mesh: &Mesh) -> Option<Self> {
        let deformation = mesh.deformation.as_ref()?;
        let grow = |to: &mut Option<Aabb>, p: Vec3| {
            let own = Aabb { min: p, max: p };
            *to = Some(to.map_or(own, |b| b.union(&own)));
        };
        let mut joints = vec![None; deformation.pose.object_from_bind.len().max(1)];
        for (vertex, position) in mesh.positions.iter().enumerate() {
            if deformation.influences.is_empty() {
                grow(&mut joints[0], *position);
            } else {
                let own = deformation.of_vertex(vertex, mesh.positions.len());
                own.for_each(|(joint, _)| grow(&mut joints[usize::from(joint)], *position));
            }
        }
        let around = |target: &MorphTarget| {
            let none = Aabb { min: Vec3::ZERO, max: Vec3::ZERO };
            target.positions.iter().fold(none, |b, p| Aabb { min: b.min.min(*p), max: b.max.max(*p) })
        };
        let targets = deformation.targets.iter().map(around).collect();
        (!mesh.positions.is_empty()).then_some(Self { joints, targets })
    }

    /// Around the mesh in a pose, object space; no allocation.
    pub(crate) fn of(&self, pose: &Pose) -> Aabb {
        let (mut less, mut more) = (Vec3::ZERO, Vec3::ZERO);
        for (target, &weight) in self.targets.iter().zip(&pose.weights) {
            let (a, b) = (target.min * weight, target.max * weight);
            less += a.min(b);
            more += a.max(b);
        }
        let mut all: Option<Aabb> = None;
        for (joint, bounds) in self.joints.iter().enumerate() {
            let Some(Aabb { min, max }) = *bounds else { continue };
            let morphed = Aabb { min: min + less, max: max + more };
            let matrix = pose.object_from_bind.get(joint).copied().unwrap_or(Mat4::IDENTITY);
            let moved = morphed.transformed(&matrix);
            let linear = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.abs().max_element());
            let largest = morphed.min.abs().max(morphed.max.abs()).max_element();
            let scale = linear[0].max(linear[1]).max(linear[2]) * largest;
            let room = (scale + matrix.w_axis.truncate().abs().max_element()) * Self::ROUNDING;
            let moved = Aabb { min: moved.min - room, max: moved.max + room };
            all = Some(all.map_or(moved, |all| all.union(&moved)));
        }
        all.unwrap_or(Aabb { min: Vec3::ZERO, max: Vec3::ZERO })
    }
}

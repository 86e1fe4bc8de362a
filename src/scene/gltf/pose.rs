//! Morph targets and skins: what bends a mesh.

use std::collections::HashMap;

use glam::{DMat4, Mat4, Vec3};
use gltf::json;
use gltf::json::validation::Checked;
use gltf::json::{Index, mesh::Semantic};

use super::accessor::{Format, Reader};
use super::document::Document;
use super::node::NodeTree;
use crate::Result;
use crate::scene::{Deformation, Influence, Mesh, MorphTarget, Pose};

/// The weights that apply to a mesh on a node: the node's, else the mesh's, else zeros.
pub fn morph_weights<'a>(
    doc: &'a Document,
    node: usize,
    mesh: Index<json::Mesh>,
) -> Result<Option<&'a [f32]>> {
    let (weights, element) = match &doc.root.nodes[node].weights {
        Some(weights) => (weights, format!("nodes[{node}].weights")),
        None => match &doc.root.meshes[mesh.value()].weights {
            Some(weights) => (weights, format!("meshes[{}].weights", mesh.value())),
            None => return Ok(None),
        },
    };
    for &weight in weights {
        doc.finite([weight], &element)?;
    }
    Ok(Some(weights))
}

/// How many morph targets a mesh has, by its first primitive; each one's own number is checked when it is read.
pub fn target_count(doc: &Document, mesh: Index<json::Mesh>) -> usize {
    let primitives = doc.root.meshes.get(mesh.value()).map(|mesh| &mesh.primitives[..]).unwrap_or_default();
    primitives.first().and_then(|p| p.targets.as_ref()).map_or(0, Vec::len)
}

/// The joints of a skin as they are without animations.
pub struct Skin {
    pub index: usize,
    /// Nodes.
    pub joints: Vec<usize>,
    pub joint_from_bind: Vec<Mat4>,
    world_from_bind: Vec<DMat4>,
}

impl Skin {
    pub fn read(doc: &Document, tree: &NodeTree, index: Index<json::Skin>, element: &str) -> Result<Self> {
        let skin = doc.get(&doc.root.skins, "skins", index, element)?;
        let name = format!("skins[{}]", index.value());
        if skin.joints.is_empty() {
            return Err(doc.bad(format!("{name}.joints"), "is empty", "list at least one node"));
        }
        let inverse_binds = match skin.inverse_bind_matrices {
            Some(accessor) => {
                let element = format!("{name}.inverseBindMatrices");
                let reader = Reader::new(doc, accessor, &element, Format::MAT4)?;
                if reader.count < skin.joints.len() {
                    let problem = format!("has {} matrices for {} joints", reader.count, skin.joints.len());
                    return Err(doc.bad(element, problem, "export the file again"));
                }
                reader.floats::<16>(doc)?
            }
            None => vec![Mat4::IDENTITY.to_cols_array(); skin.joints.len()],
        };
        let (mut joints, mut joint_from_bind) = (Vec::new(), Vec::new());
        let mut world_from_bind = Vec::with_capacity(skin.joints.len());
        for (j, (&joint, inverse_bind)) in skin.joints.iter().zip(&inverse_binds).enumerate() {
            doc.get(&doc.root.nodes, "nodes", joint, format!("{name}.joints[{j}]"))?;
            let mut matrix = Mat4::from_cols_array(inverse_bind);
            // Exporters round the row that says that it is affine.
            (matrix.x_axis.w, matrix.y_axis.w, matrix.z_axis.w, matrix.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
            world_from_bind.push(tree.world_from_node[joint.value()] * matrix.as_dmat4());
            joints.push(joint.value());
            joint_from_bind.push(matrix);
        }
        Ok(Self { index: index.value(), joints, joint_from_bind, world_from_bind })
    }

    /// Where the first joint is: the origin of meshes that move with it.
    pub fn origin(&self, tree: &NodeTree) -> Vec3 {
        tree.world_from_node[self.joints[0]].w_axis.truncate().as_vec3()
    }

    /// The joints' transforms, to a space of the world's axes with this origin.
    pub fn object_from_bind(&self, origin: Vec3) -> Vec<Mat4> {
        let object_from_world = DMat4::from_translation(-origin.as_dvec3());
        self.world_from_bind.iter().map(|m| (object_from_world * *m).as_mat4()).collect()
    }

    /// Which joints move each vertex.
    fn influences(
        &self,
        doc: &Document,
        vertices: usize,
        primitive: &json::mesh::Primitive,
        element: &str,
    ) -> Result<Vec<Influence>> {
        let mut sets: Vec<Vec<Influence>> = Vec::new();
        for set in 0.. {
            let find = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
            let (joints, weights) = (find(Semantic::Joints(set)), find(Semantic::Weights(set)));
            let joints_element = format!("{element}.attributes.JOINTS_{set}");
            let weights_element = format!("{element}.attributes.WEIGHTS_{set}");
            let (joints, weights) = match (joints, weights) {
                (Some(joints), Some(weights)) => (joints, weights),
                (None, None) if set > 0 => break,
                (None, _) => {
                    return Err(doc.bad(joints_element, "is missing", "export the file again"));
                }
                (_, None) => {
                    return Err(doc.bad(weights_element, "is missing", "export the file again"));
                }
            };
            let joints = Reader::new(doc, joints, &joints_element, Format::JOINTS)?.integers::<4>();
            let weights = Reader::new(doc, weights, &weights_element, Format::WEIGHTS)?.floats::<4>(doc)?;
            let mut own = Vec::with_capacity(vertices);
            for (vertex, (joints, weights)) in joints.iter().zip(weights).enumerate() {
                if let Some(weight) = weights.into_iter().find(|weight| *weight < 0.0) {
                    let problem = format!("a weight of vertex {vertex} is {weight}");
                    return Err(doc.bad(weights_element, problem, "give weights of at least 0"));
                }
                let unused = |(&joint, weight): (&u32, f32)| if weight == 0.0 { 0 } else { joint };
                let mut used = joints.iter().zip(weights).map(unused);
                let count = self.joints.len();
                if let Some(joint) = used.clone().find(|joint| *joint as usize >= count) {
                    let problem =
                        format!("vertex {vertex} uses joint {joint}, but skins[{}] has {count}", self.index);
                    return Err(doc.bad(&joints_element, problem, "export the file again"));
                }
                let joints = std::array::from_fn(|_| used.next().unwrap_or(0) as u16);
                own.push(Influence { joints, weights });
            }
            sets.push(own);
        }
        for vertex in 0..vertices {
            let weights = sets.iter().flat_map(|set| set[vertex].weights);
            let total = weights.map(f64::from).sum::<f64>();
            if total <= 0.0 {
                let problem = format!("the weights of vertex {vertex} add up to {total}");
                let remedy = "give every vertex weights that add up to 1";
                return Err(doc.bad(format!("{element}.attributes.WEIGHTS_0"), problem, remedy));
            }
        }
        Ok((0..vertices).flat_map(|vertex| sets.iter().map(move |set| set[vertex])).collect())
    }
}

/// How a mesh on a node is bent.
pub struct Bend<'a> {
    pub weights: Option<&'a [f32]>,
    /// With the origin of what is posed.
    pub skin: Option<(&'a Skin, Vec3)>,
    /// It will be bent otherwise.
    pub moves: bool,
}

impl Bend<'_> {
    /// What bends the primitive that `mesh` was read from; morph targets without weight only where they may get one.
    pub fn read(
        &self,
        doc: &Document,
        mesh: &Mesh,
        primitive: &json::mesh::Primitive,
        element: &str,
    ) -> Result<Option<Deformation>> {
        let targets = primitive.targets.as_deref().unwrap_or_default();
        let weights = match self.weights {
            Some(weights) => weights.to_vec(),
            None if self.moves => vec![0.0; targets.len()],
            None => Vec::new(),
        };
        if self.skin.is_none() && weights.is_empty() && self.weights.is_none() {
            return Ok(None);
        }
        if targets.len() != weights.len() && (self.weights.is_some() || self.moves) {
            let problem = format!("has {} targets, but there are {} weights", targets.len(), weights.len());
            return Err(doc.bad(format!("{element}.targets"), problem, "give each target one weight"));
        }
        let targets = targets.iter().zip(&weights).enumerate().map(|(i, (target, &weight))| {
            match weight == 0.0 && !self.moves {
                true => Ok(MorphTarget::default()),
                false => read_target(doc, mesh, target, &format!("{element}.targets[{i}]")),
            }
        });
        let targets = targets.collect::<Result<_>>()?;
        let mut deformation =
            Deformation { targets, pose: Pose { weights, ..Pose::default() }, ..Deformation::default() };
        if let Some((skin, origin)) = self.skin {
            deformation.influences = skin.influences(doc, mesh.positions.len(), primitive, element)?;
            deformation.pose.object_from_bind = skin.object_from_bind(origin);
        }
        Ok(Some(deformation))
    }
}

fn read_target(
    doc: &Document,
    mesh: &Mesh,
    target: &json::mesh::MorphTarget,
    element: &str,
) -> Result<MorphTarget> {
    let read = |index: Option<Index<json::Accessor>>, name: &str, wanted: usize| match index {
        Some(index) if wanted > 0 => {
            let element = format!("{element}.{name}");
            let reader = Reader::new(doc, index, &element, Format::VEC3)?;
            if reader.count != wanted {
                let problem = format!("has {} elements for {wanted} vertices", reader.count);
                return Err(doc.bad(element, problem, "export the file again"));
            }
            Ok(reader.floats::<3>(doc)?.into_iter().map(Vec3::from_array).collect())
        }
        _ => Ok(Vec::new()),
    };
    Ok(MorphTarget {
        positions: read(target.positions, "POSITION", mesh.positions.len())?,
        normals: read(target.normals, "NORMAL", mesh.normals.len())?,
        tangents: read(target.tangents, "TANGENT", mesh.tangents.len())?,
    })
}

/// Turns round triangles that joints turn inside out: no instance's transform tells that they are mirrored.
pub fn turn_mirrored(mesh: &mut Mesh) {
    let mut known: HashMap<u32, bool> = HashMap::new();
    let mut indices = std::mem::take(&mut mesh.indices);
    for triangle in indices.chunks_exact_mut(3) {
        if triangle.iter().all(|&i| *known.entry(i).or_insert_with(|| mesh.is_mirrored_at(i))) {
            triangle.swap(1, 2);
        }
    }
    mesh.indices = indices;
}

//! Morph targets and skins at the pose that a file shows without its animations.

use glam::{DMat3, DMat4, Mat4, Vec3, Vec4};
use gltf::json;
use gltf::json::validation::Checked;
use gltf::json::{Index, mesh::Semantic};

use super::accessor::{Format, Reader};
use super::document::Document;
use super::node::NodeTree;
use crate::Result;
use crate::scene::Mesh;

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

/// Adds the weighted targets to positions, normals and tangents (glTF 2.0 section 3.7.2.2).
pub fn apply_morph(
    doc: &Document,
    mesh: &mut Mesh,
    primitive: &json::mesh::Primitive,
    element: &str,
    weights: &[f32],
) -> Result<()> {
    let targets = primitive.targets.as_deref().unwrap_or_default();
    if targets.len() != weights.len() {
        let problem = format!("has {} targets, but there are {} weights", targets.len(), weights.len());
        return Err(doc.bad(format!("{element}.targets"), problem, "give each target one weight"));
    }
    for (i, (target, &weight)) in targets.iter().zip(weights).enumerate() {
        if weight == 0.0 {
            continue;
        }
        let read = |index: Option<Index<json::Accessor>>, name: &str, wanted: usize| match index {
            Some(index) if wanted > 0 => {
                let element = format!("{element}.targets[{i}].{name}");
                let reader = Reader::new(doc, index, &element, Format::VEC3)?;
                if reader.count != wanted {
                    let problem = format!("has {} elements for {wanted} vertices", reader.count);
                    return Err(doc.bad(element, problem, "export the file again"));
                }
                reader.floats::<3>(doc)
            }
            _ => Ok(Vec::new()),
        };
        let positions = read(target.positions, "POSITION", mesh.positions.len())?;
        for (p, [x, y, z]) in mesh.positions.iter_mut().zip(positions) {
            *p += Vec3::new(x, y, z) * weight;
        }
        let normals = read(target.normals, "NORMAL", mesh.normals.len())?;
        for (n, [x, y, z]) in mesh.normals.iter_mut().zip(normals) {
            *n += Vec3::new(x, y, z) * weight;
        }
        let tangents = read(target.tangents, "TANGENT", mesh.tangents.len())?;
        for (t, [x, y, z]) in mesh.tangents.iter_mut().zip(tangents) {
            *t += Vec4::new(x, y, z, 0.0) * weight;
        }
    }
    Ok(())
}

/// The joints of a skin at rest.
pub struct Skin {
    index: usize,
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
        let mut world_from_bind = Vec::with_capacity(skin.joints.len());
        for (j, (&joint, inverse_bind)) in skin.joints.iter().zip(&inverse_binds).enumerate() {
            doc.get(&doc.root.nodes, "nodes", joint, format!("{name}.joints[{j}]"))?;
            let joint_from_bind = Mat4::from_cols_array(inverse_bind).as_dmat4();
            world_from_bind.push(tree.world_from_node[joint.value()] * joint_from_bind);
        }
        Ok(Self { index: index.value(), world_from_bind })
    }

    /// Moves a mesh from its bind pose into world space (glTF 2.0 section 3.7.3.3).
    pub fn apply(
        &self,
        doc: &Document,
        mesh: &mut Mesh,
        primitive: &json::mesh::Primitive,
        element: &str,
    ) -> Result<()> {
        let blended = self.blended(doc, mesh.positions.len(), primitive, element)?;
        let mirrored: Vec<bool> = blended.iter().map(|m| DMat3::from_mat4(*m).determinant() < 0.0).collect();
        for (p, world_from_bind) in mesh.positions.iter_mut().zip(&blended) {
            *p = world_from_bind.transform_point3(p.as_dvec3()).as_vec3();
        }
        for ((n, m), &mirrored) in mesh.normals.iter_mut().zip(&blended).zip(&mirrored) {
            // The cofactor matrix is the inverse transpose times the determinant, and never fails.
            let (x, y, z) = (m.x_axis.truncate(), m.y_axis.truncate(), m.z_axis.truncate());
            let cofactor = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
            let normal = (cofactor * n.as_dvec3()).normalize_or_zero().as_vec3();
            *n = if mirrored { -normal } else { normal };
        }
        for ((t, m), &mirrored) in mesh.tangents.iter_mut().zip(&blended).zip(&mirrored) {
            let sign = if mirrored { -t.w } else { t.w };
            let direction = m.transform_vector3(t.truncate().as_dvec3()).normalize_or_zero();
            *t = direction.as_vec3().extend(sign);
        }
        // No instance transform will tell that these triangles are mirrored.
        for triangle in mesh.indices.chunks_exact_mut(3) {
            if triangle.iter().all(|&i| mirrored[i as usize]) {
                triangle.swap(1, 2);
            }
        }
        Ok(())
    }

    /// For each vertex, the mean of its joints' transforms.
    fn blended(
        &self,
        doc: &Document,
        vertices: usize,
        primitive: &json::mesh::Primitive,
        element: &str,
    ) -> Result<Vec<DMat4>> {
        let mut sums = vec![(DMat4::ZERO, 0.0); vertices];
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
            for (vertex, ((sum, total), (joints, weights))) in
                sums.iter_mut().zip(joints.iter().zip(&weights)).enumerate()
            {
                for (&joint, &weight) in joints.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
                    let matrix = self.world_from_bind.get(joint as usize).ok_or_else(|| {
                        let (skin, count) = (self.index, self.world_from_bind.len());
                        let problem =
                            format!("vertex {vertex} uses joint {joint}, but skins[{skin}] has {count}");
                        doc.bad(&joints_element, problem, "export the file again")
                    })?;
                    *sum += *matrix * f64::from(weight);
                    *total += f64::from(weight);
                }
            }
        }
        let mut blended = Vec::with_capacity(vertices);
        for (vertex, (sum, total)) in sums.into_iter().enumerate() {
            if total <= 0.0 {
                let problem = format!("the weights of vertex {vertex} add up to {total}");
                let remedy = "give every vertex weights that add up to 1";
                return Err(doc.bad(format!("{element}.attributes.WEIGHTS_0"), problem, remedy));
            }
            let mut mean = sum * (1.0 / total);
            mean.w_axis.w = 1.0;
            blended.push(mean);
        }
        Ok(blended)
    }
}

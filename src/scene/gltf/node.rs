//! The node tree, and the cameras that hang from it.

use glam::{DMat4, DVec4, Mat4, Quat, Vec3, Vec4};
use gltf::json;
use gltf::json::camera::Type as CameraType;

use super::document::Document;
use super::extras::{self, Extra, Extras};
use crate::Result;
use crate::scene::camera::rigid;
use crate::scene::{Camera, NodeTransform, Projection};

const REPAIR_TREE: &str = "give each node one parent at most, and list only nodes without a parent in scenes";

/// The nodes of a file, known to form trees.
pub struct NodeTree {
    /// By node.
    pub parents: Vec<Option<usize>>,
    /// All nodes, parents before their children.
    pub order: Vec<usize>,
    /// By node; f64 keeps long chains exact enough.
    pub world_from_node: Vec<DMat4>,
    /// By node: whether it will move, because its extras or those of a node above it say `"dynamic": true`.
    pub dynamic: Vec<bool>,
    /// Nodes of the default scene, in ascending order.
    pub all: Vec<usize>,
    /// Those of them that nothing hides.
    pub drawn: Vec<usize>,
}

impl NodeTree {
    pub fn read(doc: &Document) -> Result<Self> {
        let parents = parents(doc)?;
        let roots = (0..parents.len()).filter(|&i| parents[i].is_none());
        let order = descendants(doc, roots.collect());
        if order.len() < parents.len() {
            let mut reached = vec![false; parents.len()];
            order.iter().for_each(|&i| reached[i] = true);
            let in_cycle = reached.iter().position(|r| !r).unwrap_or_default();
            let problem = "is its own ancestor, or a descendant of such a node";
            return Err(doc.bad(format!("nodes[{in_cycle}]"), problem, REPAIR_TREE));
        }
        let mut world_from_node = vec![DMat4::IDENTITY; parents.len()];
        let mut dynamic = vec![false; parents.len()];
        for &i in &order {
            let local = local_transform(doc, i)?.matrix();
            let world = parents[i].map_or(local, |parent| world_from_node[parent] * local);
            if !world.as_mat4().is_finite() {
                let problem = "its transform in world space exceeds what f32 can hold";
                return Err(doc.bad(format!("nodes[{i}]"), problem, "scale the scene down"));
            }
            world_from_node[i] = world;
            // What hangs from something that moves, moves.
            let own = extras(doc, i)?.get("dynamic").map_or(Ok(false), Extra::bool)?;
            dynamic[i] = own || parents[i].is_some_and(|parent| dynamic[parent]);
        }
        let mut all = descendants(doc, scene_roots(doc, &parents)?);
        all.sort_unstable();
        all.dedup();
        let mut hidden = doc.hidden.clone();
        for &i in &order {
            hidden[i] |= parents[i].is_some_and(|parent| hidden[parent]);
        }
        let drawn = all.iter().copied().filter(|&i| !hidden[i]).collect();
        Ok(Self { parents, order, world_from_node, dynamic, all, drawn })
    }
}

fn children<'a>(doc: &'a Document, node: usize) -> impl Iterator<Item = usize> + 'a {
    doc.root.nodes[node].children.iter().flatten().map(|child| child.value())
}

fn parents(doc: &Document) -> Result<Vec<Option<usize>>> {
    let mut parents = vec![None; doc.root.nodes.len()];
    for (i, node) in doc.root.nodes.iter().enumerate() {
        for (j, &child) in node.children.iter().flatten().enumerate() {
            let element = || format!("nodes[{i}].children[{j}]");
            doc.get(&doc.root.nodes, "nodes", child, element())?;
            if let Some(first) = parents[child.value()].replace(i) {
                let problem = format!("nodes[{}] already is a child of nodes[{first}]", child.value());
                return Err(doc.bad(element(), problem, REPAIR_TREE));
            }
        }
    }
    Ok(parents)
}

/// `from` and everything below, parents first. Every node has one parent at most, so this ends.
fn descendants(doc: &Document, from: Vec<usize>) -> Vec<usize> {
    let mut order = from;
    let mut next = 0;
    while next < order.len() {
        let node = order[next];
        order.extend(children(doc, node));
        next += 1;
    }
    order
}

/// The roots of the default scene; of scene 0 if none is the default; all roots if there are no scenes.
fn scene_roots(doc: &Document, parents: &[Option<usize>]) -> Result<Vec<usize>> {
    let scenes = &doc.root.scenes;
    let (scene, index) = match doc.root.scene {
        Some(index) => (doc.get(scenes, "scenes", index, "scene")?, index.value()),
        None => match scenes.first() {
            Some(first) => (first, 0),
            None => return Ok((0..parents.len()).filter(|&i| parents[i].is_none()).collect()),
        },
    };
    let mut roots = Vec::with_capacity(scene.nodes.len());
    for (j, &node) in scene.nodes.iter().enumerate() {
        let element = || format!("scenes[{index}].nodes[{j}]");
        doc.get(&doc.root.nodes, "nodes", node, element())?;
        if let Some(parent) = parents[node.value()] {
            let problem = format!("nodes[{}] is a child of nodes[{parent}], not a root", node.value());
            return Err(doc.bad(element(), problem, REPAIR_TREE));
        }
        roots.push(node.value());
    }
    roots.sort_unstable();
    roots.dedup();
    Ok(roots)
}

/// Where a node is within its parent.
pub fn local_transform(doc: &Document, index: usize) -> Result<NodeTransform> {
    let node = &doc.root.nodes[index];
    let at = |field: &str| format!("nodes[{index}].{field}");
    if let Some(matrix) = node.matrix {
        let matrix = Mat4::from_cols_array(&doc.finite(matrix, at("matrix"))?);
        if matrix.row(3) != Vec4::W {
            let problem = "its last row is not 0, 0, 0, 1";
            return Err(doc.bad(at("matrix"), problem, "use an affine matrix"));
        }
        return Ok(NodeTransform::Matrix(matrix));
    }
    let vector = |v: Option<[f32; 3]>, default: Vec3, field: &str| match v {
        Some(v) => Ok(Vec3::from_array(doc.finite(v, at(field))?)),
        None => Ok(default),
    };
    let translation = vector(node.translation, Vec3::ZERO, "translation")?;
    let scale = vector(node.scale, Vec3::ONE, "scale")?;
    let rotation = match node.rotation {
        Some(rotation) => {
            let q = Quat::from_array(doc.finite(rotation.0, at("rotation"))?);
            if DVec4::from(q.as_dquat()).try_normalize().is_none() {
                let problem = "is a quaternion of length 0";
                return Err(doc.bad(at("rotation"), problem, "use a unit quaternion, e.g. [0, 0, 0, 1]"));
            }
            q
        }
        None => Quat::IDENTITY,
    };
    Ok(NodeTransform::Parts { translation, rotation, scale })
}

/// What the extras of the scene that is drawn say: see [`super::environment`] and [`super::around`].
pub fn extras_of_scene<'a>(doc: &'a Document<'a>) -> Result<Extras<'a>> {
    let index = doc.root.scene.map_or(0, |scene| scene.value());
    // Easily put there, and then missed.
    if extras::is_ours(&doc.root.extras) {
        let remedy = format!("move it to scenes[{index}].extras");
        return Err(doc.bad("extras.ontile", "is said of the file, but belongs to a scene", remedy));
    }
    let scene = doc.root.scenes.get(index).map(|scene| (&scene.extras, format!("scenes[{index}]")));
    Extras::read(doc, scene.as_slice(), &extras::OF_SCENES)
}

/// What the extras of a node say: see [`super::light`] and [`super::around`].
pub fn extras<'a>(doc: &'a Document<'a>, node: usize) -> Result<Extras<'a>> {
    Extras::read(doc, &[(&doc.root.nodes[node].extras, format!("nodes[{node}]"))], &extras::OF_NODES)
}

/// The nodes that have a camera, be they hidden or not, in the order of [`read_cameras`].
pub fn with_cameras<'a>(doc: &'a Document, tree: &'a NodeTree) -> impl Iterator<Item = usize> + 'a {
    tree.all.iter().copied().filter(|&i| doc.root.nodes[i].camera.is_some())
}

/// The cameras of the scene's nodes.
pub fn read_cameras(doc: &Document, tree: &NodeTree) -> Result<Vec<Camera>> {
    let mut cameras = Vec::new();
    for &i in &tree.all {
        let node = &doc.root.nodes[i];
        let Some(index) = node.camera else { continue };
        let camera = doc.get(&doc.root.cameras, "cameras", index, format!("nodes[{i}].camera"))?;
        let name = camera.name.clone().or_else(|| node.name.clone());
        let world_from_view = rigid(&tree.world_from_node[i]).ok_or_else(|| {
            let problem = "has a camera, but its scale of 0 leaves no direction to look in";
            doc.bad(format!("nodes[{i}]"), problem, "give the node a scale other than 0")
        })?;
        cameras.push(Camera {
            name: name.unwrap_or_else(|| format!("camera {}", index.value())),
            world_from_view,
            projection: projection(doc, camera, index.value())?,
        });
    }
    Ok(cameras)
}

fn projection(doc: &Document, camera: &json::Camera, index: usize) -> Result<Projection> {
    let check = |value: f32, field: &str, rule: &str, holds: bool| match holds && value.is_finite() {
        true => Ok(value),
        false => Err(doc.bad(
            format!("cameras[{index}].{field}"),
            format!("is {value}, but must be {rule}"),
            "correct the camera",
        )),
    };
    let missing = |field: &str| doc.bad(format!("cameras[{index}].{field}"), "is missing", "add it");
    Ok(match doc.valid(camera.type_, format!("cameras[{index}].type"))? {
        CameraType::Perspective => {
            let p = camera.perspective.as_ref().ok_or_else(|| missing("perspective"))?;
            let yfov_ok = p.yfov > 0.0 && p.yfov < std::f32::consts::PI;
            Projection::Perspective {
                yfov_rad: check(p.yfov, "perspective.yfov", "above 0 and below pi", yfov_ok)?,
                znear_m: check(p.znear, "perspective.znear", "above 0", p.znear > 0.0)?,
                zfar_m: match p.zfar {
                    Some(far) => Some(check(far, "perspective.zfar", "above znear", far > p.znear)?),
                    None => None,
                },
            }
        }
        CameraType::Orthographic => {
            let o = camera.orthographic.as_ref().ok_or_else(|| missing("orthographic"))?;
            Projection::Orthographic {
                xmag_m: check(o.xmag, "orthographic.xmag", "above 0", o.xmag > 0.0)?,
                ymag_m: check(o.ymag, "orthographic.ymag", "above 0", o.ymag > 0.0)?,
                znear_m: check(o.znear, "orthographic.znear", "at least 0", o.znear >= 0.0)?,
                zfar_m: check(o.zfar, "orthographic.zfar", "above znear", o.zfar > o.znear)?,
            }
        }
    })
}

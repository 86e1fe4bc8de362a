//! Skins, morph targets and animations.

use super::{Geometry, Glb, number};
use glam::{Mat4, Quat, Vec3};
use serde_json::{Value, json};

/// A property of a node between keys.
pub enum Track<'a> {
    /// By a spline through places, with the same tangent (metres a second) before and after each.
    Spline(&'a [(f32, Vec3, Vec3)]),
    /// At a constant speed from turn to turn.
    Turns(&'a [(f32, Quat)]),
    /// Of one morph target.
    Weights(&'a [(f32, f32)]),
}

fn bytes(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

impl Glb {
    /// Has each vertex go by two joints: the first one's number, and the share of the next.
    pub fn bend(&mut self, geometry: &mut Geometry, joints: &[(u8, f32)]) {
        let numbers: Vec<u8> = joints.iter().flat_map(|(first, _)| [*first, first + 1, 0, 0]).collect();
        let weights = bytes(joints.iter().flat_map(|(_, share)| [1.0 - share, *share, 0.0, 0.0]));
        geometry.attributes["JOINTS_0"] = json!(self.accessor(&numbers, 4, 5121, "VEC4"));
        geometry.attributes["WEIGHTS_0"] = json!(self.accessor(&weights, 16, 5126, "VEC4"));
    }

    /// Gives a mesh a morph target: displacements of positions and normals.
    pub fn target(&mut self, mesh: usize, positions: &[Vec3], normals: &[Vec3]) {
        let mut list = |list: &[Vec3]| {
            let floats = bytes(list.iter().flat_map(Vec3::to_array));
            self.accessor(&floats, 12, 5126, "VEC3")
        };
        let target = json!({"POSITION": list(positions), "NORMAL": list(normals)});
        let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let accessors = self.lists.get_mut("accessors").expect("just added");
        let accessor = &mut accessors[target["POSITION"].as_u64().expect("an index") as usize];
        (accessor["min"], accessor["max"]) = (json!(low.to_array()), json!(high.to_array()));
        let mesh = &mut self.lists.get_mut("meshes").expect("the mesh exists")[mesh];
        mesh["weights"] = json!([0.0]);
        mesh["primitives"][0]["targets"] = json!([target]);
    }

    /// Bends a node's mesh by joints, which take the bind pose into their space like this.
    pub fn skin(&mut self, node: usize, joints: &[usize], joint_from_bind: &[Mat4]) {
        let matrices = bytes(joint_from_bind.iter().flat_map(Mat4::to_cols_array));
        let view = self.view(&matrices, None);
        let count = joint_from_bind.len();
        let matrices = json!({"bufferView": view, "componentType": 5126, "count": count, "type": "MAT4"});
        let matrices = self.add("accessors", matrices);
        let skin = self.add("skins", json!({"joints": joints, "inverseBindMatrices": matrices}));
        self.lists.get_mut("nodes").expect("the node exists")[node]["skin"] = json!(skin);
    }

    /// Moves nodes.
    pub fn animation(&mut self, name: &str, tracks: &[(usize, Track<'_>)]) {
        let (mut samplers, mut channels): (Vec<Value>, Vec<Value>) = (Vec::new(), Vec::new());
        for (node, track) in tracks {
            let (path, shape, width) = match track {
                Track::Spline(_) => ("translation", "VEC3", 3),
                Track::Turns(_) => ("rotation", "VEC4", 4),
                Track::Weights(_) => ("weights", "SCALAR", 1),
            };
            let (times, values): (Vec<f32>, Vec<f32>) = match track {
                Track::Spline(keys) => keys
                    .iter()
                    .map(|(t, v, d)| (t, [*d, *v, *d].map(|v| v.to_array()).concat()))
                    .flatten_keys(),
                Track::Turns(keys) => keys.iter().map(|(t, v)| (t, v.to_array().to_vec())).flatten_keys(),
                Track::Weights(keys) => keys.iter().map(|(t, v)| (t, vec![*v])).flatten_keys(),
            };
            let (first, last) = (times[0], times[times.len() - 1]);
            let mut add = |values: &[f32], width: usize, shape: &str| {
                let view = self.view(&bytes(values.iter().copied()), None);
                let count = values.len() / width;
                self.add(
                    "accessors",
                    json!({"bufferView": view, "componentType": 5126, "count": count, "type": shape}),
                )
            };
            let (input, output) = (add(&times, 1, "SCALAR"), add(&values, width, shape));
            let accessor = &mut self.lists.get_mut("accessors").expect("just added")[input];
            (accessor["min"], accessor["max"]) = (json!([number(first)]), json!([number(last)]));
            let interpolation = if matches!(track, Track::Spline(_)) { "CUBICSPLINE" } else { "LINEAR" };
            channels.push(json!({"sampler": samplers.len(), "target": {"node": node, "path": path}}));
            samplers.push(json!({"input": input, "output": output, "interpolation": interpolation}));
        }
        self.add("animations", json!({"name": name, "channels": channels, "samplers": samplers}));
    }
}

/// Times, and all values one after the other.
trait Keys {
    fn flatten_keys(self) -> (Vec<f32>, Vec<f32>);
}

impl<'a, I: Iterator<Item = (&'a f32, Vec<f32>)>> Keys for I {
    fn flatten_keys(self) -> (Vec<f32>, Vec<f32>) {
        let (times, values): (Vec<f32>, Vec<Vec<f32>>) = self.map(|(t, v)| (*t, v)).unzip();
        (times, values.concat())
    }
}

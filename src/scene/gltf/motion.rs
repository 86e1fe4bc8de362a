//! Animations, the nodes that they move, and what goes with these.

use std::collections::{HashMap, HashSet};

use glam::{DMat4, Mat4};
use gltf::json;
use gltf::json::animation::{Interpolation as JsonInterpolation, Property as JsonProperty};

use super::accessor::{Format, Reader};
use super::document::Document;
use super::node::{self, NodeTree};
use super::pose::{self, Skin};
use super::{decal, light};
use crate::Result;
use crate::scene::{
    Animation, Channel, Follower, Follows, Interpolation, Motion, Node, NodeTransform, Property, Scene,
};

/// Which nodes animations move.
#[derive(Default)]
pub struct Moving {
    /// By node: whether its place in the world changes; empty: nothing does.
    places: Vec<bool>,
    /// Nodes whose weights change.
    weights: HashSet<usize>,
}

impl Moving {
    pub fn read(doc: &Document, tree: &mut NodeTree) -> Result<Self> {
        let mut moving = Self { places: vec![false; tree.parents.len()], weights: HashSet::new() };
        for (i, animation) in doc.root.animations.iter().enumerate() {
            for (j, channel) in animation.channels.iter().enumerate() {
                let (node, property) = target(doc, channel, &format!("animations[{i}].channels[{j}]"))?;
                match property {
                    JsonProperty::MorphTargetWeights => drop(moving.weights.insert(node)),
                    _ => moving.places[node] = true,
                }
            }
        }
        for &i in &tree.order {
            moving.places[i] |= tree.parents[i].is_some_and(|parent| moving.places[parent]);
            // Nothing of it is kept from frame to frame.
            tree.dynamic[i] |= moving.places[i];
        }
        Ok(moving)
    }

    /// Whether a node's place changes.
    pub fn place(&self, node: usize) -> bool {
        self.places.get(node).is_some_and(|moves| *moves)
    }

    /// Whether a node's weights change.
    pub fn weights(&self, node: usize) -> bool {
        self.weights.contains(&node)
    }

    /// Whether a skin's joints move.
    pub fn bends(&self, skin: &Skin) -> bool {
        skin.joints.iter().any(|&joint| self.place(joint))
    }
}

/// The node that a channel moves, and what of it.
fn target(
    doc: &Document,
    channel: &json::animation::Channel,
    element: &str,
) -> Result<(usize, JsonProperty)> {
    let node = channel.target.node;
    doc.get(&doc.root.nodes, "nodes", node, format!("{element}.target.node"))?;
    Ok((node.value(), doc.valid(channel.target.path, format!("{element}.target.path"))?))
}

/// What goes with nodes of the file, in the making.
#[derive(Default)]
pub struct Followers {
    /// By node of the file.
    pub list: Vec<(usize, Follows)>,
    /// Instances with places in a node's space that are not its own: node of the file, place, instance.
    pub instances: Vec<(usize, Mat4, usize)>,
    /// Those that bend something, by their number in the file.
    skins: Vec<(usize, crate::scene::Skin)>,
}

impl Followers {
    /// A skin's number among those that bend something. Its joints are nodes of the file.
    pub fn skin(&mut self, skin: &Skin) -> usize {
        let known = self.skins.iter().position(|(index, _)| *index == skin.index);
        known.unwrap_or_else(|| {
            let Skin { joints, joint_from_bind, .. } = skin;
            let new = crate::scene::Skin { joints: joints.clone(), joint_from_bind: joint_from_bind.clone() };
            self.skins.push((skin.index, new));
            self.skins.len() - 1
        })
    }

    /// Adds what instances, meshes and particles have not, and makes a motion of it; `None` if nothing moves.
    pub fn finish(
        mut self,
        doc: &Document,
        tree: &NodeTree,
        moving: &Moving,
        scene: &mut Scene,
    ) -> Result<Option<Motion>> {
        let mut add = |nodes: &mut dyn Iterator<Item = usize>, follows: &dyn Fn(usize) -> Follows| {
            let moved = nodes.enumerate().filter(|(_, node)| moving.place(*node));
            self.list.extend(moved.map(|(index, node)| (node, follows(index))));
        };
        add(&mut light::nodes(doc, tree), &Follows::Light);
        add(&mut node::with_cameras(doc, tree), &Follows::Camera);
        let mut decals = 0;
        for &i in &tree.drawn {
            if let Some(size) = decal::size(doc, i)? {
                let node_from_decal = DMat4::from_scale(size.as_dvec3()).as_mat4();
                self.list.extend(
                    moving.place(i).then_some((i, Follows::Decal { decal: decals, node_from_decal })),
                );
                decals += 1;
            }
            if moving.place(i) && node::extras(doc, i)?.get("probe").is_some() {
                let what = "probes do not follow animated nodes; it stays where it is";
                scene.warnings.push(format!("nodes[{i}]: {what}"));
            }
        }
        if self.list.is_empty() && self.instances.is_empty() {
            return Ok(None);
        }
        // What follows, what bends it, and what these hang from.
        let mut kept: HashSet<usize> = self.list.iter().map(|(node, _)| *node).collect();
        kept.extend(self.instances.iter().map(|(node, ..)| *node));
        kept.extend(self.skins.iter().flat_map(|(_, skin)| &skin.joints));
        for &i in tree.order.iter().rev() {
            if kept.contains(&i) {
                kept.extend(tree.parents[i]);
            }
        }
        let order: Vec<usize> = tree.order.iter().copied().filter(|i| kept.contains(i)).collect();
        let place: HashMap<usize, usize> = order.iter().enumerate().map(|(new, &old)| (old, new)).collect();
        let mut nodes = order.iter().map(|&i| read_node(doc, tree, &place, i)).collect::<Result<Vec<_>>>()?;
        let skins = self.skins.into_iter().map(|(_, mut skin)| {
            skin.joints.iter_mut().for_each(|joint| *joint = place[joint]);
            skin
        });
        let followers = self.list.into_iter().map(|(node, what)| Follower { node: place[&node], what });
        let mut followers: Vec<Follower> = followers.collect();
        for (node, node_from_object, instance) in self.instances {
            let name = format!("{} (instance {instance})", nodes[place[&node]].name);
            let transform = NodeTransform::Matrix(node_from_object);
            followers.push(Follower { node: nodes.len(), what: Follows::Instance(instance) });
            nodes.push(Node { name, parent: Some(place[&node]), transform, weights: Vec::new() });
        }
        let mut motion = Motion {
            skins: skins.collect(),
            followers,
            nodes,
            animations: Vec::with_capacity(doc.root.animations.len()),
        };
        for index in 0..doc.root.animations.len() {
            motion.animations.push(read_animation(doc, &place, &motion.nodes, index)?);
        }
        Ok(Some(motion))
    }
}

fn read_node(doc: &Document, tree: &NodeTree, place: &HashMap<usize, usize>, i: usize) -> Result<Node> {
    let node = &doc.root.nodes[i];
    let weights = match node.mesh {
        Some(mesh) => match pose::morph_weights(doc, i, mesh)? {
            Some(weights) => weights.to_vec(),
            None => vec![0.0; pose::target_count(doc, mesh)],
        },
        None => Vec::new(),
    };
    Ok(Node {
        name: node.name.clone().unwrap_or_else(|| format!("nodes[{i}]")),
        parent: tree.parents[i].map(|parent| place[&parent]),
        transform: node::local_transform(doc, i)?,
        weights,
    })
}

/// An animation, as far as it moves what there is.
fn read_animation(
    doc: &Document,
    place: &HashMap<usize, usize>,
    nodes: &[Node],
    index: usize,
) -> Result<Animation> {
    let json = &doc.root.animations[index];
    let mut channels: Vec<Channel> = Vec::new();
    let mut targets = HashSet::new();
    for (j, channel) in json.channels.iter().enumerate() {
        let element = format!("animations[{index}].channels[{j}]");
        let (node, property) = target(doc, channel, &element)?;
        if !targets.insert((node, property as u8)) {
            let problem = format!("moves what another channel moves: the {property:?} of nodes[{node}]");
            return Err(doc.bad(element, problem, "keep one channel for each property of a node"));
        }
        let sampler_element = format!("animations[{index}].samplers[{}]", channel.sampler.value());
        let sampler = doc.get(&json.samplers, "samplers", channel.sampler, format!("{element}.sampler"))?;
        let Some(&place) = place.get(&node) else { continue };
        if property != JsonProperty::MorphTargetWeights
            && matches!(nodes[place].transform, NodeTransform::Matrix(_))
        {
            let problem = format!("moves nodes[{node}], which has a matrix");
            return Err(doc.bad(element, problem, "give the node translation, rotation and scale instead"));
        }
        if property == JsonProperty::MorphTargetWeights && nodes[place].weights.is_empty() {
            let problem = format!("changes the weights of nodes[{node}], whose mesh has no morph targets");
            return Err(doc.bad(element, problem, "remove the channel"));
        }
        let channel = read_channel(doc, sampler, &sampler_element, (place, property))?;
        if let Some(problem) = channel.problem(nodes) {
            return Err(doc.bad(sampler_element, problem, "correct the keys, or export the file again"));
        }
        channels.push(channel);
    }
    let name = json.name.clone().unwrap_or_else(|| format!("animation {index}"));
    Ok(Animation { name, channels })
}

fn read_channel(
    doc: &Document,
    sampler: &json::animation::Sampler,
    element: &str,
    (node, property): (usize, JsonProperty),
) -> Result<Channel> {
    let input = Reader::new(doc, sampler.input, format!("{element}.input"), Format::SCALAR)?;
    let times_s = input.floats::<1>(doc)?.into_iter().flatten().collect();
    let output = |format| Reader::new(doc, sampler.output, format!("{element}.output"), format);
    let places = || -> Result<Vec<f32>> {
        Ok(output(Format::PLACES)?.floats::<3>(doc)?.into_iter().flatten().collect())
    };
    let (property, values) = match property {
        JsonProperty::Translation => (Property::Translation, places()?),
        JsonProperty::Scale => (Property::Scale, places()?),
        JsonProperty::Rotation => {
            let values = output(Format::ROTATIONS)?.floats::<4>(doc)?.into_iter().flatten();
            (Property::Rotation, values.collect())
        }
        JsonProperty::MorphTargetWeights => {
            let values = output(Format::SHARES)?.floats::<1>(doc)?.into_iter().flatten();
            (Property::Weights, values.collect())
        }
    };
    let interpolation = match doc.valid(sampler.interpolation, format!("{element}.interpolation"))? {
        JsonInterpolation::Step => Interpolation::Step,
        JsonInterpolation::Linear => Interpolation::Linear,
        JsonInterpolation::CubicSpline => Interpolation::CubicSpline,
    };
    Ok(Channel { node, property, interpolation, times_s, values })
}

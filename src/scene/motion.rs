//! What moves by itself: a tree of nodes, animations of it, and what follows its nodes.

mod follow;
mod sample;

use glam::{Mat4, Quat, Vec3};

use super::world::Kind;
use super::{Deformation, Scene};
use crate::{Error, Result};
pub(super) use follow::Posture;

/// Nodes, how animations move them, and what of a scene goes with them.
///
/// A scene that stands still has none: what its file's nodes placed is placed once and for all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Parents before their children.
    pub nodes: Vec<Node>,
    /// What bends meshes.
    pub skins: Vec<Skin>,
    /// What goes with the nodes.
    pub followers: Vec<Follower>,
    /// Each moves some of the nodes.
    pub animations: Vec<Animation>,
}

/// A place in the tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// A name for messages.
    pub name: String,
    /// Index into [`Motion::nodes`], below its own; `None`: the world.
    pub parent: Option<usize>,
    /// Where it is within its parent while nothing moves it.
    pub transform: NodeTransform,
    /// How much there is of each morph target of its mesh while nothing moves it.
    pub weights: Vec<f32>,
}

/// Where a node is within its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeTransform {
    /// Affine; no animation moves it.
    Matrix(Mat4),
    /// First scaled, then turned, then moved.
    Parts {
        /// Metres.
        translation: Vec3,
        /// Made unit length.
        rotation: Quat,
        /// Along the node's own axes.
        scale: Vec3,
    },
}

impl NodeTransform {
    /// As its parent is.
    pub const IDENTITY: Self =
        Self::Parts { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };
}

/// The joints of a skeleton (glTF 2.0, section 3.7.3).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Indices into [`Motion::nodes`].
    pub joints: Vec<usize>,
    /// Of each joint, what takes the bind pose into its space.
    pub joint_from_bind: Vec<Mat4>,
}

/// Something that goes with a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Follower {
    /// Index into [`Motion::nodes`].
    pub node: usize,
    /// What.
    pub what: Follows,
}

/// What goes with a node. Indices are into the lists of [`super::Scene`].
#[derive(Clone, Debug, PartialEq)]
pub enum Follows {
    /// An instance stands where the node is.
    Instance(usize),
    /// A light is there and shines along its -Z.
    Light(usize),
    /// A camera is there and looks along its -Z.
    Camera(usize),
    /// A decal.
    Decal {
        /// Which.
        decal: usize,
        /// Its box in the node's space.
        node_from_decal: Mat4,
    },
    /// A list of particles stands where the node is. Sizes and turns on the image are as they were, and particles beyond these places
    /// stay where they are.
    Particles {
        /// Which.
        particles: usize,
        /// Where each is in the node's space, metres.
        positions_node: Vec<Vec3>,
    },
    /// A mesh takes the node's weights of its morph targets.
    Weights {
        /// Which.
        mesh: usize,
    },
    /// A mesh is bent by joints, wherever the node itself may be. Its object space becomes that of the world with its origin in the
    /// first joint, so that what is far from the world's origin is no less accurate than what does not bend.
    Skin {
        /// Which mesh.
        mesh: usize,
        /// Its only instance.
        instance: usize,
        /// Index into [`Motion::skins`].
        skin: usize,
    },
}

/// What moves nodes in the course of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// A name to choose it by.
    pub name: String,
    /// No two of one node and property.
    pub channels: Vec<Channel>,
}

impl Animation {
    /// The time of the last key: from there on nothing moves.
    pub fn duration_s(&self) -> f32 {
        self.channels.iter().filter_map(|channel| channel.times_s.last()).fold(0.0, |most, t| most.max(*t))
    }
}

/// How a property of a node changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Index into [`Motion::nodes`].
    pub node: usize,
    /// What changes.
    pub property: Property,
    /// What is between keys.
    pub interpolation: Interpolation,
    /// When its keys are: from 0, each later than the one before. Before the first the value is the first's, after the last the last's.
    pub times_s: Vec<f32>,
    /// The value of each key; for [`Interpolation::CubicSpline`] the tangent that arrives, per second, the value, and the tangent that leaves.
    /// A value is three numbers, four (x, y, z, w) of a rotation, or one for each morph target.
    pub values: Vec<f32>,
}

/// What of a node changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Property {
    /// [`NodeTransform::Parts::translation`]
    Translation,
    /// [`NodeTransform::Parts::rotation`]
    Rotation,
    /// [`NodeTransform::Parts::scale`]
    Scale,
    /// [`Node::weights`]
    Weights,
}

/// What is between two keys (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// The first one's value.
    Step,
    /// A straight line; of rotations the shorter way round at a constant speed.
    #[default]
    Linear,
    /// A cubic Hermite spline; rotations are made unit length.
    CubicSpline,
}

/// An animation at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Play {
    /// Index into [`Motion::animations`].
    pub animation: usize,
    /// Seconds from its begin. Nothing repeats: for a loop, give the rest of a division by [`Animation::duration_s`].
    pub time_s: f64,
}

impl Motion {
    /// The animation with this index or name.
    ///
    /// # Errors
    /// [`Error::Unsupported`] that lists those there are.
    pub fn animation(&self, wanted: &str) -> Result<usize> {
        let by_index = wanted.parse().ok().filter(|i| *i < self.animations.len());
        let by_name = || self.animations.iter().position(|a| a.name == wanted);
        by_index.or_else(by_name).ok_or_else(|| {
            let known: Vec<_> =
                self.animations.iter().enumerate().map(|(i, a)| format!("{i} ({})", a.name)).collect();
            let problem = format!("there is no animation '{wanted}'");
            Error::unsupported(problem, format!("use one of: {}", known.join(", ")))
        })
    }

    /// What is wrong with it in a scene.
    pub(super) fn problem(&self, scene: &Scene) -> Option<String> {
        let count = self.nodes.len();
        let nodes = self.nodes.iter().enumerate().find_map(|(i, node)| {
            let problem = node.problem(i)?;
            Some(format!("nodes[{i}] ('{}'): {problem}", node.name))
        });
        let skins = self.skins.iter().enumerate().find_map(|(i, skin)| {
            let Skin { joints, joint_from_bind } = skin;
            let holds = !joints.is_empty()
                && joints.len() == joint_from_bind.len()
                && joints.iter().all(|&joint| joint < count)
                && joint_from_bind.iter().all(is_affine);
            (!holds).then(|| format!("skins[{i}] has no joints, others than there are, or bad matrices"))
        });
        let followers = self.followers.iter().enumerate().find_map(|(i, Follower { node, what })| {
            let holds = *node < count && self.is_there(scene, *node, what);
            (!holds).then(|| format!("followers[{i}] or what it follows is not there, or does not fit it"))
        });
        let animations = self.animations.iter().enumerate().find_map(|(i, animation)| {
            let bad = |(j, channel): (usize, &Channel)| Some((j, channel.problem(&self.nodes)?));
            let (j, problem) = animation.channels.iter().enumerate().find_map(bad)?;
            Some(format!("animations[{i}].channels[{j}] {problem}"))
        });
        nodes.or(skins).or(followers).or(animations)
    }
}

impl Motion {
    fn is_there(&self, scene: &Scene, node: usize, what: &Follows) -> bool {
        let bends = |mesh: usize, fits: &dyn Fn(&Deformation) -> bool| {
            scene.meshes.get(mesh).is_some_and(|mesh| mesh.deformation.as_ref().is_some_and(fits))
        };
        match what {
            &Follows::Instance(index) => index < scene.instances.len(),
            &Follows::Light(index) => index < scene.lights.len(),
            &Follows::Camera(index) => index < scene.cameras.len(),
            &Follows::Decal { decal, node_from_decal } => {
                decal < scene.decals.len() && is_affine(&node_from_decal)
            }
            Follows::Particles { particles, positions_node } => {
                *particles < scene.particles.len() && positions_node.iter().all(|p| p.is_finite())
            }
            &Follows::Weights { mesh } => {
                bends(mesh, &|d| d.pose.weights.len() == self.nodes[node].weights.len())
            }
            &Follows::Skin { mesh, instance, skin } => {
                let joints = self.skins.get(skin).map(|skin| skin.joints.len());
                let of_mesh = scene.instances.get(instance).is_some_and(|i| i.mesh == mesh);
                of_mesh && bends(mesh, &|d| Some(d.pose.object_from_bind.len()) == joints)
            }
        }
    }

    /// Lets go of lights that are not kept, and finds the others at their places after that.
    pub(super) fn keep_lights(&mut self, keep: &[bool]) {
        self.followers.retain_mut(|follower| {
            let Follows::Light(index) = &mut follower.what else { return true };
            let is_kept = keep[*index];
            *index = keep[..*index].iter().filter(|keep| **keep).count();
            is_kept
        });
    }

    /// Lets go of an element of a scene.
    pub(super) fn leave(&mut self, kind: Kind, index: usize) {
        self.followers.retain(|follower| match follower.what {
            Follows::Instance(i) => (kind, index) != (Kind::Instance, i),
            Follows::Light(i) => (kind, index) != (Kind::Light, i),
            Follows::Camera(i) => (kind, index) != (Kind::Camera, i),
            Follows::Decal { decal, .. } => (kind, index) != (Kind::Decal, decal),
            Follows::Particles { particles, .. } => (kind, index) != (Kind::Particles, particles),
            Follows::Weights { mesh } => (kind, index) != (Kind::Mesh, mesh),
            Follows::Skin { mesh, instance, .. } => {
                ![(Kind::Mesh, mesh), (Kind::Instance, instance)].contains(&(kind, index))
            }
        });
    }
}

fn is_affine(matrix: &Mat4) -> bool {
    matrix.is_finite() && matrix.row(3) == glam::Vec4::W
}

impl Node {
    fn problem(&self, index: usize) -> Option<&'static str> {
        const ZERO: Quat = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0);
        let placed = match self.transform {
            NodeTransform::Matrix(matrix) => is_affine(&matrix),
            NodeTransform::Parts { translation, rotation, scale } => {
                translation.is_finite() && rotation.is_finite() && rotation != ZERO && scale.is_finite()
            }
        };
        if self.parent.is_some_and(|parent| parent >= index) {
            Some("its parent does not come before it")
        } else if !placed {
            Some("its transform is not finite, or its rotation has no length")
        } else {
            (!self.weights.iter().all(|w| w.is_finite())).then_some("a weight is not finite")
        }
    }
}

impl Channel {
    /// How many numbers a value has.
    pub(super) fn width(&self, nodes: &[Node]) -> usize {
        match self.property {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::Weights => nodes[self.node].weights.len(),
        }
    }

    /// The rotations of its keys, tangents left out.
    fn rotations(&self) -> impl Iterator<Item = glam::Vec4> {
        let (step, first) = (self.values_a_key(), self.values_a_key() / 2);
        self.values.chunks_exact(4).skip(first).step_by(step).map(glam::Vec4::from_slice)
    }

    /// How many values a key has.
    pub(super) fn values_a_key(&self) -> usize {
        if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 }
    }

    /// What is wrong with it.
    pub(super) fn problem(&self, nodes: &[Node]) -> Option<String> {
        let Some(node) = nodes.get(self.node) else {
            return Some(format!("moves nodes[{}], and there are {}", self.node, nodes.len()));
        };
        let wanted = self.times_s.len() * self.values_a_key() * self.width(nodes);
        let is_later = |pair: &[f32]| pair[0] < pair[1];
        if self.times_s.is_empty() {
            Some("has no keys".into())
        } else if !self.times_s.iter().all(|t| t.is_finite() && *t >= 0.0) {
            Some("has a key before 0, or at no finite time".into())
        } else if let Some(at) = self.times_s.windows(2).position(|pair| !is_later(pair)) {
            let (a, b) = (self.times_s[at], self.times_s[at + 1]);
            Some(format!("has key {at} at {a} s and the next at {b} s, which is not later"))
        } else if self.values.len() != wanted {
            Some(format!("has {} numbers for its keys, not {wanted}", self.values.len()))
        } else if !self.values.iter().all(|v| v.is_finite()) {
            Some("has a value that is not finite".into())
        } else if self.property == Property::Rotation && self.rotations().any(|q| q == glam::Vec4::ZERO) {
            Some("has a rotation that is a quaternion of length 0".into())
        } else if self.property != Property::Weights && matches!(node.transform, NodeTransform::Matrix(_)) {
            Some("moves a node whose transform is a matrix".into())
        } else {
            None
        }
    }
}

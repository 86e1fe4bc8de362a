//! Nodes at a time, and everything where its node is.

use glam::{DMat4, DQuat, DVec3, DVec4};

use super::{Follower, Follows, Motion, NodeTransform, Play, Property};
use crate::scene::decal::has_volume;
use crate::scene::light::up_of;
use crate::scene::world::Listed;
use crate::scene::{Changes, LightKind, Scene};
use crate::{Error, Result};

/// Where the nodes of a motion are; kept, so that later times need no memory.
#[derive(Clone, Debug, Default)]
pub struct Posture {
    parts: Vec<Parts>,
    /// By node, in the place that `first_weight` says.
    weights: Vec<f64>,
    first_weight: Vec<usize>,
    world_from_node: Vec<DMat4>,
}

#[derive(Clone, Copy, Debug)]
struct Parts {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
}

impl Parts {
    /// A matrix has none.
    fn new(transform: &NodeTransform) -> Self {
        let NodeTransform::Parts { translation, rotation, scale } = *transform else {
            return Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };
        };
        let rotation = rotation.as_dquat().normalize();
        Self { translation: translation.as_dvec3(), rotation, scale: scale.as_dvec3() }
    }

    fn matrix(&self) -> DMat4 {
        DMat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

impl NodeTransform {
    /// As a matrix.
    pub(in crate::scene) fn matrix(&self) -> DMat4 {
        match self {
            Self::Matrix(matrix) => matrix.as_dmat4(),
            Self::Parts { .. } => Parts::new(self).matrix(),
        }
    }
}

impl Posture {
    fn set(&mut self, motion: &Motion, playing: &[Play]) -> Result<()> {
        let Self { parts, weights, first_weight, world_from_node } = self;
        parts.clear();
        weights.clear();
        first_weight.clear();
        world_from_node.clear();
        for node in &motion.nodes {
            parts.push(Parts::new(&node.transform));
            first_weight.push(weights.len());
            weights.extend(node.weights.iter().map(|w| f64::from(*w)));
        }
        for play in playing {
            let Some(animation) = motion.animations.get(play.animation) else {
                let known = motion.animations.len();
                return Err(Error::unsupported(
                    format!("there is no animation {} to play", play.animation),
                    format!("use an index below {known}, the number of the scene's animations"),
                ));
            };
            if !play.time_s.is_finite() {
                let problem = format!("animation '{}' has no moment {} s", animation.name, play.time_s);
                return Err(Error::unsupported(problem, "give a finite time"));
            }
            for channel in &animation.channels {
                let node = channel.node;
                if channel.property == Property::Weights {
                    let first = first_weight[node];
                    let width = motion.nodes[node].weights.len();
                    channel.sample(play.time_s, &mut weights[first..first + width]);
                    continue;
                }
                let mut value = [0.0; 4];
                channel.sample(play.time_s, &mut value[..channel.width(&motion.nodes)]);
                let [x, y, z, w] = value;
                let parts = &mut parts[node];
                match channel.property {
                    Property::Translation => parts.translation = DVec3::new(x, y, z),
                    Property::Scale => parts.scale = DVec3::new(x, y, z),
                    _ => {
                        let rotation = DVec4::new(x, y, z, w).try_normalize().ok_or_else(|| {
                            let name = &motion.nodes[node].name;
                            let problem =
                                format!("the rotation of node '{name}' is a quaternion of length 0");
                            Error::unsupported(problem, "correct the spline's tangents")
                        })?;
                        parts.rotation = DQuat::from_vec4(rotation);
                    }
                }
            }
        }
        for (node, parts) in motion.nodes.iter().zip(parts) {
            let local = match node.transform {
                NodeTransform::Matrix(matrix) => matrix.as_dmat4(),
                NodeTransform::Parts { .. } => parts.matrix(),
            };
            let world = node.parent.map_or(local, |parent| world_from_node[parent] * local);
            if !world.as_mat4().is_finite() {
                let problem = format!("the place of node '{}' exceeds what f32 can hold", node.name);
                return Err(Error::unsupported(problem, "scale the scene down"));
            }
            world_from_node.push(world);
        }
        Ok(())
    }

    fn weights(&self, motion: &Motion, node: usize) -> impl Iterator<Item = f32> {
        let first = self.first_weight[node];
        self.weights[first..first + motion.nodes[node].weights.len()].iter().map(|w| *w as f32)
    }
}

impl Scene {
    /// Moves everything to where these animations have it, each at its time; of a property that several move the last counts. What none of
    /// them moves is as it is without animations.
    ///
    /// A light or camera whose node's scale of 0 leaves no direction keeps that which it had, and so does a decal without volume.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has no such animation, a time is not finite, or something would move farther than f32 can
    /// say. Nothing is changed then.
    pub fn animate(&mut self, playing: &[Play]) -> Result<()> {
        self.animate_with(playing, &mut Posture::default(), &mut Changes::default())
    }

    /// The same, noting what it changes.
    pub(in crate::scene) fn animate_with(
        &mut self,
        playing: &[Play],
        posture: &mut Posture,
        changes: &mut Changes,
    ) -> Result<()> {
        let Some(motion) = self.motion.take() else {
            return Err(Error::unsupported(
                format!("nothing of scene '{}' is animated", self.name),
                "load a file that has animations as one that moves (load_moving), or give the scene a motion",
            ));
        };
        let posed = posture.set(&motion, playing);
        if posed.is_ok() {
            motion.followers.iter().for_each(|follower| self.follow(&motion, posture, follower, changes));
        }
        self.motion = Some(motion);
        posed
    }

    fn follow(&mut self, motion: &Motion, posture: &Posture, follower: &Follower, changes: &mut Changes) {
        let world = &posture.world_from_node[follower.node];
        match &follower.what {
            &Follows::Instance(index) => self.place_instance(index, world, changes),
            &Follows::Light(index) => {
                let light = &mut self.lights[index];
                let direction = match ((-world.z_axis.truncate()).try_normalize(), light.kind) {
                    (Some(direction), _) => direction,
                    (None, LightKind::Point { .. }) => light.direction_world.as_dvec3(),
                    (None, _) => return,
                };
                let position = world.w_axis.truncate().as_vec3();
                let up = up_of(direction, world.y_axis.truncate()).as_vec3();
                let direction = direction.as_vec3();
                if (light.position_world, light.direction_world, light.up_world) != (position, direction, up)
                {
                    (light.position_world, light.direction_world, light.up_world) = (position, direction, up);
                    Changes::note(&mut changes.lights, index);
                }
            }
            &Follows::Camera(index) => {
                if let Some(world_from_view) = crate::scene::camera::rigid(world) {
                    self.cameras[index].world_from_view = world_from_view;
                }
            }
            &Follows::Decal { decal: index, node_from_decal } => {
                let world_from_decal = *world * node_from_decal.as_dmat4();
                let decal = &mut self.decals[index];
                let place = world_from_decal.as_mat4();
                if has_volume(&world_from_decal) && decal.world_from_decal != place {
                    let old = decal.clone();
                    decal.world_from_decal = place;
                    decal.note(Some(&old), index, changes);
                }
            }
            Follows::Particles { particles: index, positions_node } => {
                let mut has_moved = false;
                for (particle, at) in self.particles[*index].list.iter_mut().zip(positions_node) {
                    let place = world.transform_point3(at.as_dvec3()).as_vec3();
                    has_moved |= particle.position_world != place;
                    particle.position_world = place;
                }
                if has_moved {
                    Changes::note(&mut changes.particles, *index);
                }
            }
            &Follows::Weights { mesh } => {
                let Some(deformation) = &mut self.meshes[mesh].deformation else { return };
                let old = &mut deformation.pose.weights;
                if !old.iter().copied().eq(posture.weights(motion, follower.node)) {
                    old.clear();
                    old.extend(posture.weights(motion, follower.node));
                    Changes::note(&mut changes.poses, mesh);
                }
            }
            &Follows::Skin { mesh, instance, skin } => {
                let skin = &motion.skins[skin];
                let origin = posture.world_from_node[skin.joints[0]].w_axis.truncate().as_vec3();
                let world_from_object = DMat4::from_translation(origin.as_dvec3());
                self.place_instance(instance, &world_from_object, changes);
                let Some(deformation) = &mut self.meshes[mesh].deformation else { return };
                let object_from_world = DMat4::from_translation(-origin.as_dvec3());
                let mut has_changed = false;
                let joints = skin.joints.iter().zip(&skin.joint_from_bind);
                for (old, (&joint, joint_from_bind)) in
                    deformation.pose.object_from_bind.iter_mut().zip(joints)
                {
                    let world_from_bind = posture.world_from_node[joint] * joint_from_bind.as_dmat4();
                    let new = (object_from_world * world_from_bind).as_mat4();
                    has_changed |= *old != new;
                    *old = new;
                }
                if has_changed {
                    Changes::note(&mut changes.poses, mesh);
                }
            }
        }
    }

    fn place_instance(&mut self, index: usize, world_from_object: &DMat4, changes: &mut Changes) {
        let instance = &mut self.instances[index];
        let place = world_from_object.as_mat4();
        if instance.world_from_object != place {
            instance.world_from_object = place;
            Changes::note(&mut changes.instances, index);
        }
    }
}

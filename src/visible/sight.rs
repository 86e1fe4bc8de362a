//! A view, as far as it decides what is drawn and in which order.

use glam::{Mat4, Vec3};

use super::Frustum;
use crate::scene::Aabb;

/// What a view shows, and from where.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// What it shows.
    pub frustum: Frustum,
    /// World space, metres.
    pub eye_world: Vec3,
    /// The way the view looks, unit length.
    pub forward_world: Vec3,
}

impl Sight {
    /// As a shader sees it that transforms by this matrix.
    pub fn new(clip_from_world: &Mat4, world_from_view: &Mat4) -> Self {
        Self {
            frustum: Frustum::new(clip_from_world),
            eye_world: world_from_view.w_axis.truncate(),
            forward_world: -world_from_view.z_axis.truncate(),
        }
    }

    /// The depth of a box's centre along the view, metres: what is blended goes by it, so that of two panes that face the
    /// viewer the farther is drawn first, wherever their edges are.
    pub fn depth(&self, bounds: &Aabb) -> f32 {
        (bounds.center() - self.eye_world).dot(self.forward_world)
    }

    /// From the eye to the farthest corner of a box, metres: what a draw order goes by. By their nearest points or centres,
    /// floors and walls, which reach past the eye, would come before what stands on and in front of them.
    pub fn distance(&self, bounds: &Aabb) -> f32 {
        (bounds.min - self.eye_world).abs().max((bounds.max - self.eye_world).abs()).length()
    }
}

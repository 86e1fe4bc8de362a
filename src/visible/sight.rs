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
}

impl Sight {
    /// As a shader sees it that transforms by this matrix.
    pub fn new(clip_from_world: &Mat4, eye_world: Vec3) -> Self {
        Self { frustum: Frustum::new(clip_from_world), eye_world }
    }

    /// From the eye to the farthest corner of a box, metres: what a draw order goes by. By their nearest points or centres,
    /// floors and walls, which reach past the eye, would come before what stands on and in front of them.
    pub fn distance(&self, bounds: &Aabb) -> f32 {
        (bounds.min - self.eye_world).abs().max((bounds.max - self.eye_world).abs()).length()
    }
}

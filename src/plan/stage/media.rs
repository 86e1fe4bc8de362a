//! Surfaces that light goes through, over what is opaque and below all that is blended.

use super::depth::Depth;
use super::{Asked, Frame, Use};

/// The name of the stage.
pub const NAME: &str = "media";

/// Adds the stage where a material transmits light. `lights` are the targets that hold light so far.
pub(super) fn add(frame: &mut Frame, asked: &Asked, lights: &[usize], depth: &Depth) {
    let Some(first) = &asked.needs.transmits else { return };
    let over = lights.iter().map(|&light| (light, Use::Blend));
    let behind = depth.resource.map(|depth| (depth, Use::Read));
    let test = depth.resource.map(|depth| (depth, Use::DepthTest));
    let way = if behind.is_some() { " by the depth of the same pixel" } else { "" };
    let why =
        format!("{first} absorbs light that comes from behind it{way}, then adds its own, from far to near");
    frame.add_stage(NAME, over.chain(behind).chain(test), why);
}

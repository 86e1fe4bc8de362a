//! Surfaces that light goes through, over what is opaque and below all that is blended.

use super::depth::Depth;
use super::{Asked, Frame, Resource, Use};
use crate::plan::Refraction;
use crate::plan::layout::{Target, Tells};

/// The name of the stage.
pub const NAME: &str = "media";

/// Of the one before it that copies what they bend.
pub const BACKDROP: &str = "backdrop";

/// Light and depth of a pass that begins with copies.
const REFRACTED: &str = "refracted_light";
const REFRACTED_DEPTH: &str = "refracted_depth";

/// What later stages draw over.
pub(super) struct Behind {
    /// The targets that hold light.
    pub(super) lights: Vec<usize>,
    /// The depth attachment, where a frame has one.
    pub(super) depth: Option<usize>,
}

/// Adds the stage where a material transmits light. `lights` are the targets that hold light so far.
pub(super) fn add(frame: &mut Frame, asked: &Asked, lights: &[usize], depth: &Depth) -> Behind {
    let before = Behind { lights: lights.to_vec(), depth: depth.resource };
    let Some(first) = &asked.needs.transmits else { return before };
    let test = depth.resource.map(|depth| (depth, Use::DepthTest));
    if let Some(refracts) = refracting(frame, asked, lights) {
        return add_refracting(frame, (refracts, lights[0]), depth.resource);
    }
    let over = lights.iter().map(|&light| (light, Use::Blend));
    let behind = depth.resource.map(|depth| (depth, Use::Read));
    let way = if behind.is_some() { " by the depth of the same pixel" } else { "" };
    let why =
        format!("{first} absorbs light that comes from behind it{way}, then adds its own, from far to near");
    frame.add_stage(NAME, over.chain(behind).chain(test), why);
    before
}

/// The first material that bends light, where that is asked for and something is behind it.
fn refracting<'a>(frame: &Frame, asked: &'a Asked, lights: &[usize]) -> Option<&'a str> {
    let uses_light = |s: &super::Stage| s.uses.iter().any(|(r, _)| lights.contains(r));
    let wanted = asked.options.refraction == Refraction::Pass && frame.stages.iter().any(uses_light);
    asked.needs.refracts.as_deref().filter(|_| wanted)
}

/// What is sampled cannot be drawn to, so media draw to a copy. To store light twice and load one of both would cost more: a store of all
/// its bytes, where the copy lives on the tile and costs one sample a pixel, as the load would. Depth that was loaded would have to
/// be dropped or stored again while neighbours sample it.
fn add_refracting(frame: &mut Frame, (first, light): (&str, usize), depth: Option<usize>) -> Behind {
    let copy = |frame: &mut Frame, resource: usize, name| {
        let Resource { format, holds, .. } = frame.resources[resource];
        let (used_bits, tells) = (format.bits(), Tells::Surface);
        let target = Target { name, format, holds, used_bits, clear: None, tells };
        frame.resources[resource].why += "; media sample it where they bend its way";
        frame.add_target(&target, false, format!("{first} is drawn over a copy of what it samples"))
    };
    let over = copy(frame, light, REFRACTED);
    let tested = depth.map(|depth| copy(frame, depth, REFRACTED_DEPTH));
    let sampled = || [light].into_iter().chain(depth).map(|resource| (resource, Use::Sample));
    let drawn = |how| [(over, Use::Write)].into_iter().chain(tested.map(|depth| (depth, how)));
    let why = "media sample what is opaque, and are drawn to a copy of it";
    frame.add_stage(BACKDROP, drawn(Use::Depth).chain(sampled()), why.into());
    let why = format!(
        "{first} shows what is behind it where its light comes from, in neighbouring pixels, absorbs it on its way, and adds its own; the \
         nearest of several"
    );
    let read = tested.map(|depth| (depth, Use::Read));
    frame.add_stage(NAME, drawn(Use::DepthTest).chain(read).chain(sampled()), why);
    Behind { lights: vec![over], depth: tested }
}

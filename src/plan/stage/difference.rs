//! How far the picture is from another one.

use super::{Asked, Frame, Resource, Use};

/// The name of the stage.
pub const NAME: &str = "difference";

/// What drew the output draws a picture that stays on the tile, from which the output is made.
pub(super) fn add(frame: &mut Frame, asked: &Asked) {
    if asked.options.difference.is_none() {
        return;
    }
    let output = &mut frame.resources[Frame::OUTPUT];
    let picture = Resource {
        name: "picture",
        holds: "the picture that is compared",
        clear: output.clear.take(),
        kept: false,
        why: "its difference from another one is wanted".into(),
        ..output.clone()
    };
    output.holds = "how far the picture is from another one";
    let index = frame.resources.len();
    frame.resources.push(picture);
    let drawn = frame.stages.iter_mut().flat_map(|stage| &mut stage.uses).filter(|u| u.0 == Frame::OUTPUT);
    drawn.for_each(|(resource, _)| *resource = index);
    let why = "the options ask for the difference from another picture, which is sampled".into();
    frame.add_stage(NAME, [(Frame::OUTPUT, Use::Write), (index, Use::Read)], why);
}

//! Several samples a pixel.

use super::{Frame, Resource, Use};

/// Gives all that the stages so far draw this many samples; the last stage that draws the picture resolves it, when its subpass
/// ends, to the output, which alone keeps one.
pub(in crate::plan) fn add(frame: &mut Frame, samples: u32) {
    if samples == 1 {
        return;
    }
    frame.resources.iter_mut().skip(1).for_each(|resource| resource.samples = samples);
    let output = &mut frame.resources[Frame::OUTPUT];
    let drawn = Resource {
        name: "output_samples",
        holds: "display light of each sample",
        clear: output.clear.take(),
        kept: false,
        samples,
        why: "what is drawn has several samples a pixel; their mean is stored".into(),
        ..output.clone()
    };
    let index = frame.resources.len();
    frame.resources.push(drawn);
    let drawn = frame.stages.iter_mut().flat_map(|stage| &mut stage.uses).filter(|u| u.0 == Frame::OUTPUT);
    drawn.for_each(|(resource, _)| *resource = index);
    let draws = |(resource, how): &(usize, Use)| *resource == index && how.writes();
    if let Some(stage) = frame.stages.iter_mut().rev().find(|stage| stage.uses.iter().any(draws)) {
        let at = stage.uses.iter().position(draws).unwrap_or(0);
        stage.uses.insert(at + 1, (Frame::OUTPUT, Use::Resolve));
    }
}

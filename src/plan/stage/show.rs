//! What the G-buffer holds, in place of the picture.

use super::depth::Depth;
use super::{Asked, Frame, Use};
use crate::plan::{Edges, Show, show};

/// Adds the stage. `targets` are all that geometry writes, and depth where it is read.
pub(super) fn add(frame: &mut Frame, asked: &Asked, depth: &Depth, targets: &[usize], folded: bool) {
    let Asked { needs, options, gbuffer, .. } = *asked;
    let marks = options.show == Show::Edges;
    let told = show::told_by(options.show, needs, gbuffer, folded);
    // What marks edges compares all that lighting reads, unless triangles' outlines tell of all of them.
    let compares = asked.edges == Edges::Compare || needs.kinds.iter().any(|need| need.kind.alpha_mask);
    let of_lighting = |name: &str| name == "edge" || compares && !matches!(name, "light" | "specular_light");
    let is_read = |r: &&usize| {
        let name = frame.resources[**r].name;
        if marks { of_lighting(name) } else { told.contains(&name) }
    };
    let read: Vec<_> = targets.iter().filter(is_read).copied().collect();
    for &r in &read {
        // Where nothing is it must say so.
        if frame.resources[r].name == "depth" {
            frame.resources[r].clear = Some([0.0; 4]);
        }
    }
    let stencil = depth.resource.filter(|_| marks).map(|depth| (depth, Use::Stencil));
    let uses = [(Frame::OUTPUT, Use::Write)].into_iter().chain(read.into_iter().map(|r| (r, Use::Read)));
    let why = format!("the options ask to show {} in place of the picture", options.show);
    frame.add_stage(show::NAME, uses.chain(stencil), why);
}

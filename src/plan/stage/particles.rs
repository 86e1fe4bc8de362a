//! Light that is added once surfaces are lit and before the tone curve.

use super::{Asked, Frame, Use};

/// The name of the stage.
pub const NAME: &str = "particles";

/// Adds the stage where the scene has particles. `lights` are the targets that hold light so far.
pub(super) fn add(frame: &mut Frame, asked: &Asked, lights: &[usize], depth: Option<usize>) {
    let Some(first) = asked.needs.particles.first() else { return };
    let count = asked.needs.particles.iter().map(|need| need.particles).sum::<usize>();
    let added = lights.iter().map(|&light| (light, Use::Blend));
    let soft = depth.map(|depth| (depth, Use::Read));
    let test = depth.map(|depth| (depth, Use::DepthTest));
    let fade =
        if soft.is_some() { "; they fade by the depth of what is behind them in the same pixel" } else { "" };
    let why = format!("up to {count} particles (first {}) add light, in any order{fade}", first.why);
    frame.add_stage(NAME, added.chain(soft).chain(test), why);
}

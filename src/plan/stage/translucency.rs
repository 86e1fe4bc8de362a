//! Surfaces that are blended over what is behind them, once that is lit and before the tone curve.

use super::{Asked, Frame, Use};

/// The stage's name.
pub const NAME: &str = "translucency";

/// Adds the stage where a surface is blended. `lights` are the targets that hold light so far, `depth` what surfaces are tested
/// against, and `positions` what tells fog where the G-buffer's surfaces are.
pub(super) fn add(
    frame: &mut Frame,
    asked: &Asked,
    lights: &[usize],
    depth: Option<usize>,
    positions: &[usize],
) {
    let Some(blended) = &asked.needs.blended else { return };
    let drawn = lights.iter().map(|&light| (light, Use::Blend));
    let read = positions.iter().map(|&position| (position, Use::Read));
    let test = depth.map(|depth| (depth, Use::DepthTest));
    let why = format!("{blended} is blended over what is lit behind it, from far to near");
    let fog = if positions.is_empty() { "" } else { "; what is behind is fogged before" };
    frame.add_stage(NAME, drawn.chain(read).chain(test), why + fog);
}

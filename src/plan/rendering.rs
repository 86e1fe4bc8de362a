//! A pass as one dynamic rendering: what is other than in a render pass of the same stages.
//!
//! A rendering has all of its attachments from begin to end, each in one state, and changes none of them by itself: what a
//! render pass does by its dependencies on the outside, barriers before and after a rendering do.

use super::derive::Order;
use super::{Pass, State, Store, Transition};

/// An attachment of a rendering.
pub(super) struct Rendered {
    /// The state that it is in throughout.
    pub(super) during: State,
    /// What orders it with what came before.
    pub(super) before: Order,
    /// Likewise with what follows.
    pub(super) after: Option<Order>,
}

/// Turns a render pass into a rendering. `held` tells of each of its attachments whether it is depth, and bits a pixel.
pub(super) fn of(mut pass: Pass, all: Vec<Rendered>, held: &dyn Fn(usize) -> (bool, u32)) -> Pass {
    let during: Vec<_> = all.iter().map(|a| a.during).collect();
    for (attachment, Rendered { during, before, after }) in all.into_iter().enumerate() {
        let used = &pass.attachments[attachment];
        let transition =
            |from, to, (before, after): Order| Transition { attachment, from, to, before, after };
        pass.enter.push(transition(used.initial, during, before));
        if used.store == Store::Store && (after.is_some() || used.last != during) {
            pass.leave.push(transition(during, used.last, after.unwrap_or_default()));
        }
    }
    let on_tile = (0..pass.attachments.len()).filter(|&i| pass.is_on_tile(i));
    let on_tile: Vec<_> = on_tile.map(|i| held(pass.attachments[i].attachment)).collect();
    let bits = |depth: bool| on_tile.iter().filter(|(is_depth, _)| *is_depth == depth).map(|(_, n)| n).sum();
    let (color_bits, depth_bits) = (bits(false), bits(true));
    for s in &mut pass.subpasses {
        s.color_states = s.colors.iter().map(|&i| during[i]).collect();
        s.input_states = s.inputs.iter().map(|&i| during[i]).collect();
        s.depth_state = s.depth.map(|i| during[i]);
        s.resolve.iter_mut().for_each(|resolve| resolve.state = during[resolve.to]);
        // Nothing has to be named that stays.
        s.preserve.clear();
        (s.live_color_bits, s.live_depth_bits) = (color_bits, depth_bits);
    }
    pass
}

//! What orders the attachments of a pass with what comes before and after it.

use super::super::access::{Access, Scope};
use super::super::stage::{Frame, Resource};
use super::super::{Load, Options, Store};
use super::Touch;

/// What must be finished and visible, and what waits for it.
pub(in crate::plan) type Order = (Scope, Scope);

/// Orders a pass's first touch after earlier passes and frames, and after what the host did since.
pub(super) fn order_after_outside(
    first: &Touch,
    is_only: bool,
    depth: bool,
    load: Load,
    host: Scope,
) -> Order {
    let mut after = Access::of(&first.uses);
    after.insert(Access::load(depth, load));
    if is_only {
        after.insert(Access::store(depth));
    }
    let mut before: Scope = [Access::store(depth), Access::InputRead].into();
    before.extend(host);
    (before, after)
}

/// Orders what is done `outside` with the attachment, or later passes with what is stored, after the last touch; and says why.
pub(super) fn order_before_outside(
    depth: bool,
    store: Store,
    outside: Option<(Access, &'static str)>,
    next_samples: bool,
) -> Option<(Order, &'static str)> {
    let before = [Access::store(depth)].into();
    match outside {
        Some((access, why)) => Some(((before, [access].into()), why)),
        None if store == Store::Store => {
            let (after, why): (Scope, _) = match next_samples {
                true => ([Access::SampledRead].into(), "later passes sample what is stored"),
                false => (
                    [Access::InputRead, Access::load(depth, Load::Load), Access::TransferRead].into(),
                    "later passes load what is stored",
                ),
            };
            Some(((before, after), why))
        }
        None => None,
    }
}

/// What reads a resource after the frame's own passes.
pub(super) fn after_frame(frame: &Frame, options: &Options, resource: usize) -> Scope {
    let Resource { kept, sampled, .. } = frame.resources[resource];
    let host = match resource {
        // The host's image is another one.
        Frame::OUTPUT if options.edge_filter => None,
        Frame::OUTPUT => Access::after_frame(options.output_use),
        _ => kept.then_some(Access::TransferRead),
    };
    host.into_iter().chain(sampled.then_some(Access::SampledRead)).collect()
}

//! What finished frames tell.

use super::Renderer;
use crate::Result;
use crate::gpu::{DrawCount, Queries, QueryResults};

impl Renderer {
    /// Whether frames recorded from now on have queries of their own: timestamps, statistics, counted fragments. At first they have; without, what
    /// a slot's queries say is that of the frame before.
    ///
    /// Frames under a [`CounterQuery`](crate::gpu::CounterQuery) want none: they would be counted too, and the validation layer (seen up to 1.4.363)
    /// takes the index of the counters' pass for one of theirs and writes where it should not.
    pub fn set_queries(&mut self, are_recorded: bool) {
        self.has_queries = are_recorded;
    }

    pub(super) fn queries(&self) -> Option<&Queries> {
        self.has_queries.then_some(&*self.queries)
    }

    /// Timestamps and statistics of a frame slot that the GPU has finished: nanoseconds since the frame's begin after
    /// each stage (with [`RendererConfig::stage_timestamps`](super::RendererConfig::stage_timestamps)) and at its end.
    ///
    /// # Errors
    /// [`Error::Vulkan`](crate::Error::Vulkan), e.g. when the device was lost.
    pub fn query_results(&self, slot: usize) -> Result<QueryResults> {
        self.queries.results(slot as u32)
    }

    /// How many fragments each draw brought of the frame recorded with this slot, shadow maps aside, in the order of
    /// recording; the GPU has finished it. Empty without [`RendererConfig::count_fragments`](super::RendererConfig::count_fragments).
    ///
    /// # Errors
    /// [`Error::Vulkan`](crate::Error::Vulkan), e.g. when the device was lost.
    pub fn draw_counts(&self, slot: usize) -> Result<Vec<DrawCount>> {
        self.fragments.as_ref().map_or(Ok(Vec::new()), |fragments| fragments.results(slot))
    }
}

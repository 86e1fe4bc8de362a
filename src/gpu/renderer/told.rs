//! What finished frames tell.

use super::Renderer;
use crate::Result;
use crate::gpu::{DrawCount, QueryResults};

impl Renderer {
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

//! How many fragments the draws of a frame bring, counted by the GPU.

use ash::vk;

use super::{Device, Owned, Recorder};
use crate::plan::Plan;
use crate::{Error, Result};

/// What was drawn in one go, and how many of its fragments passed the depth test and were not discarded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawCount {
    /// The stage, as [`Plan::subpass`] knows it.
    pub stage: usize,
    /// Index into [`Plan::pipelines`].
    pub pipeline: usize,
    /// What of the scene was drawn; `None` of what covers the screen, and of lights' volumes.
    pub drawn: Option<DrawnMesh>,
    /// Samples that passed all tests.
    pub fragments: u64,
}

/// Instances of a mesh that were drawn in one go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawnMesh {
    /// Index into `Scene::meshes`.
    pub mesh: usize,
    /// Index into `Scene::materials`.
    pub material: usize,
    /// How many of its instances.
    pub instances: u32,
}

/// One precise occlusion query for each draw of a frame.
pub(super) struct FragmentQueries {
    pool: Owned<vk::QueryPool>,
    per_slot: u32,
    /// By slot, in the order of queries; the counts are 0 until they are read.
    drawn: Vec<Vec<DrawCount>>,
    slot: usize,
    device: Device,
}

impl FragmentQueries {
    /// Room for the frames of `slots`, each of which draws at most `batches` of surfaces in each stage.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device does not count precisely; [`Error::Vulkan`].
    pub(super) fn new(device: &Device, plan: &Plan, batches: usize, slots: usize) -> Result<Self> {
        if !device.features().occlusion_precise {
            return Err(Error::unsupported(
                format!("'{}' does not count fragments (occlusionQueryPrecise)", device.caps().name),
                "count on another device, such as lavapipe: what passes depends on the scene, not on the device",
            ));
        }
        let most = plan.stage_count() * batches + plan.pipelines.len() + plan.needs.most_local_lights;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::OCCLUSION)
            .query_count((most * slots).max(1) as u32);
        // SAFETY: the count is above 0.
        let pool = unsafe { device.create_query_pool(&info, "fragments") }?;
        let drawn = vec![Vec::with_capacity(most); slots];
        Ok(Self { pool, per_slot: most as u32, drawn, slot: 0, device: device.clone() })
    }

    /// Records the reset of a frame slot, which [`Self::begin`] counts for from now on; outside of a render pass.
    pub(super) fn reset(&mut self, recorder: &Recorder<'_>, slot: usize) {
        self.slot = slot;
        self.drawn[slot].clear();
        let first = slot as u32 * self.per_slot;
        // SAFETY: the queries are of this pool; recording, outside of a render pass.
        unsafe {
            self.device.raw().cmd_reset_query_pool(recorder.raw(), self.pool.raw(), first, self.per_slot)
        };
    }

    /// Records the begin of counting what follows.
    pub(super) fn begin(
        &mut self,
        recorder: &Recorder<'_>,
        stage: usize,
        pipeline: usize,
        drawn: Option<DrawnMesh>,
    ) {
        let query = self.next();
        self.drawn[self.slot].push(DrawCount { stage, pipeline, drawn, fragments: 0 });
        let precise = vk::QueryControlFlags::PRECISE;
        // SAFETY: the query is of this pool and was reset, the feature is enabled, and no other of its type is active.
        unsafe { self.device.raw().cmd_begin_query(recorder.raw(), self.pool.raw(), query, precise) };
    }

    /// Records the end of counting, in the subpass of the begin.
    pub(super) fn end(&mut self, recorder: &Recorder<'_>) {
        let query = self.next() - 1;
        // SAFETY: `begin` began it in this subpass.
        unsafe { self.device.raw().cmd_end_query(recorder.raw(), self.pool.raw(), query) };
    }

    /// What a frame slot's draws brought; the GPU has finished the frame.
    ///
    /// # Errors
    /// [`Error::Vulkan`], e.g. when the device was lost.
    pub(super) fn results(&self, slot: usize) -> Result<Vec<DrawCount>> {
        let mut all = self.drawn[slot].clone();
        let mut counts = vec![0_u64; all.len()];
        if !counts.is_empty() {
            let first = slot as u32 * self.per_slot;
            let flags = vk::QueryResultFlags::TYPE_64;
            // SAFETY: one element holds one query's value.
            unsafe { self.device.raw().get_query_pool_results(self.pool.raw(), first, &mut counts, flags) }
                .map_err(|result| Error::Vulkan { call: "vkGetQueryPoolResults", result })?;
        }
        all.iter_mut().zip(counts).for_each(|(draw, fragments)| draw.fragments = fragments);
        Ok(all)
    }

    fn next(&self) -> u32 {
        self.slot as u32 * self.per_slot + self.drawn[self.slot].len() as u32
    }
}

//! GPU times and counts of a frame, where the device has them.

use super::{Device, Owned, Recorder};
use crate::{Error, Result};
use ash::vk;

/// Timestamps and pipeline statistics for several frames in flight.
///
/// Each frame slot is reset and filled by one command buffer at a time; its results are there once that has
/// been executed, and reading them never waits.
#[derive(Debug)]
pub struct Queries {
    timestamps: Option<Owned<vk::QueryPool>>,
    statistics: Option<Owned<vk::QueryPool>>,
    per_frame: u32,
    frames: u32,
    device: Device,
}

/// What a frame's queries say; `None` where the device has no such queries or the GPU has not finished.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QueryResults {
    /// Nanoseconds from the frame's first timestamp to each of its timestamps.
    pub timestamps_ns: Option<Vec<f64>>,
    /// Counts between [`Queries::begin_statistics`] and [`Queries::end_statistics`].
    pub statistics: Option<PipelineStatistics>,
}

/// What the pipelines did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct PipelineStatistics {
    /// Vertex shader invocations.
    pub vertex_invocations: u64,
    /// Primitives that clipping put out.
    pub clipping_primitives: u64,
    /// Fragment shader invocations.
    pub fragment_invocations: u64,
}

impl Queries {
    /// Makes pools for `timestamps_per_frame` timestamps and one set of statistics in each of `frames` frame
    /// slots.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn new(device: &Device, timestamps_per_frame: u32, frames: u32) -> Result<Self> {
        let pool = |wanted: bool, ty, count, statistics, name| {
            if !wanted || count == 0 {
                return Ok(None);
            }
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(ty)
                .query_count(count)
                .pipeline_statistics(statistics);
            // SAFETY: the count is above 0, and the feature is enabled where it is needed.
            unsafe { device.create_query_pool(&info, name) }.map(Some)
        };
        Ok(Self {
            timestamps: pool(
                device.caps().timestamp_valid_bits > 0,
                vk::QueryType::TIMESTAMP,
                timestamps_per_frame * frames,
                vk::QueryPipelineStatisticFlags::empty(),
                "timestamps",
            )?,
            statistics: pool(
                device.features().pipeline_statistics,
                vk::QueryType::PIPELINE_STATISTICS,
                frames,
                // The results come in the order of the bits.
                vk::QueryPipelineStatisticFlags::VERTEX_SHADER_INVOCATIONS
                    | vk::QueryPipelineStatisticFlags::CLIPPING_PRIMITIVES
                    | vk::QueryPipelineStatisticFlags::FRAGMENT_SHADER_INVOCATIONS,
                "pipeline statistics",
            )?,
            per_frame: timestamps_per_frame,
            frames,
            device: device.clone(),
        })
    }

    /// Timestamps a frame.
    pub(super) fn per_frame(&self) -> u32 {
        self.per_frame
    }

    /// Records the reset of a frame slot; once before its other commands, outside of a render pass.
    pub fn reset(&self, recorder: &Recorder<'_>, frame: u32) {
        let frame = frame % self.frames.max(1);
        for (pool, count) in [(&self.timestamps, self.per_frame), (&self.statistics, 1)] {
            if let Some(pool) = pool {
                let first = frame * count;
                // SAFETY: the queries are of this pool; recording, outside of a render pass.
                unsafe { self.device.raw().cmd_reset_query_pool(recorder.raw(), pool.raw(), first, count) };
            }
        }
    }

    /// Records timestamp `index` of a frame slot: the time when all earlier commands have passed `stage`. An
    /// index beyond the slot's count records nothing.
    pub fn timestamp(&self, recorder: &Recorder<'_>, frame: u32, index: u32, stage: vk::PipelineStageFlags) {
        let Some(pool) = self.timestamps.as_ref().filter(|_| index < self.per_frame) else { return };
        let query = (frame % self.frames) * self.per_frame + index;
        // SAFETY: the query is of this pool, which the queue family supports; `reset` came before.
        unsafe { self.device.raw().cmd_write_timestamp(recorder.raw(), stage, pool.raw(), query) };
    }

    /// Records the begin of the statistics; outside of a render pass, after [`Self::reset`].
    pub fn begin_statistics(&self, recorder: &Recorder<'_>, frame: u32) {
        let Some(pool) = &self.statistics else { return };
        let none = vk::QueryControlFlags::empty();
        // SAFETY: the query is of this pool, and `reset` came before.
        unsafe { self.device.raw().cmd_begin_query(recorder.raw(), pool.raw(), frame % self.frames, none) };
    }

    /// Records the end of the statistics; outside of a render pass.
    pub fn end_statistics(&self, recorder: &Recorder<'_>, frame: u32) {
        let Some(pool) = &self.statistics else { return };
        // SAFETY: the query is of this pool, and `begin_statistics` came before.
        unsafe { self.device.raw().cmd_end_query(recorder.raw(), pool.raw(), frame % self.frames) };
    }

    /// What a frame slot's queries say so far; every timestamp of the slot must have been recorded for any to
    /// be told.
    ///
    /// # Errors
    /// [`Error::Vulkan`], e.g. when the device was lost.
    pub fn results(&self, frame: u32) -> Result<QueryResults> {
        let frame = frame % self.frames.max(1);
        let mut results = QueryResults::default();
        if let Some(pool) = &self.timestamps {
            let mut ticks = vec![0_u64; self.per_frame as usize];
            if self.read(pool, frame * self.per_frame, &mut ticks)? {
                let caps = self.device.caps();
                results.timestamps_ns =
                    Some(nanoseconds(&ticks, caps.timestamp_valid_bits, caps.timestamp_period_ns));
            }
        }
        if let Some(pool) = &self.statistics {
            let mut counts = [[0_u64; 3]];
            if self.read(pool, frame, &mut counts)? {
                let [[vertex_invocations, clipping_primitives, fragment_invocations]] = counts;
                results.statistics = Some(PipelineStatistics {
                    vertex_invocations,
                    clipping_primitives,
                    fragment_invocations,
                });
            }
        }
        Ok(results)
    }

    /// Whether the queries are available; one element of `data` each.
    fn read<T>(&self, pool: &Owned<vk::QueryPool>, first: u32, data: &mut [T]) -> Result<bool> {
        let flags = vk::QueryResultFlags::TYPE_64;
        // SAFETY: one element holds all values of one query.
        match unsafe { self.device.raw().get_query_pool_results(pool.raw(), first, data, flags) } {
            Ok(()) => Ok(true),
            Err(vk::Result::NOT_READY) => Ok(false),
            Err(result) => Err(Error::Vulkan { call: "vkGetQueryPoolResults", result }),
        }
    }
}

/// From ticks with `valid_bits` meaningful bits, which may wrap round, to nanoseconds since the first.
fn nanoseconds(ticks: &[u64], valid_bits: u32, period_ns: f32) -> Vec<f64> {
    let mask = if valid_bits >= 64 { u64::MAX } else { (1 << valid_bits) - 1 };
    let first = ticks.first().copied().unwrap_or_default();
    ticks.iter().map(|t| (t.wrapping_sub(first) & mask) as f64 * f64::from(period_ns)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_wrap_round() {
        // With 8 valid bits 250 -> 4 is 10 ticks; the bits above are noise.
        assert_eq!(nanoseconds(&[250, 0xab00 | 4], 8, 2.0), [0.0, 20.0]);
        assert_eq!(nanoseconds(&[u64::MAX, 2], 64, 1.0), [0.0, 3.0]);
        assert!(nanoseconds(&[], 64, 1.0).is_empty());
    }
}

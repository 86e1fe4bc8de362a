//! One query of several counters.

use std::sync::atomic::Ordering;
use std::time::Duration;

use ash::khr::performance_query::DeviceFn;
use ash::vk;

use super::super::rendering::device_functions;
use super::super::{Called, Device, Owned, Recorder};
use super::{Counter, Counters};
use crate::plan::{CounterFigure, CounterFigures, Figure};
use crate::{Error, Result};

/// How long another program may keep the profiling lock.
const PATIENCE: Duration = Duration::from_secs(5);

/// What some counters count in one command buffer.
///
/// 1. [`CounterQuery::new`] takes the device's profiling lock, and dropping gives it back.
/// 2. [`CounterQuery::reset`] goes into a command buffer of its own, submitted before each series of passes.
/// 3. The same work is recorded and submitted [`CounterQuery::passes`] times, one after the other: in each command buffer, which is
///    begun after the query was made, [`CounterQuery::begin`] is the first command and [`CounterQuery::end`] the last, and to each
///    submission the next [`CounterQuery::submit_info`] is chained.
/// 4. When all have finished, [`CounterQuery::results`] are there, and the query may be dropped.
pub struct CounterQuery {
    // In order of destruction.
    pool: Owned<vk::QueryPool>,
    _lock: ProfilingLock,
    counters: Vec<(Counter, vk::PerformanceCounterStorageKHR)>,
    passes: u32,
}

impl CounterQuery {
    /// A query of the counters with these indices into [`Counters::all`].
    ///
    /// # Errors
    /// [`Error::Unsupported`] without indices, with one that is of no counter, if another query of the device is alive, or if
    /// another program keeps the profiling lock; [`Error::Vulkan`].
    pub fn new(counters: &Counters, chosen: &[usize]) -> Result<Self> {
        let Counters { all, storages, calls, device } = counters;
        if chosen.is_empty() || chosen.iter().any(|&index| index >= all.len()) {
            return Err(Error::unsupported(
                format!("{chosen:?} are not indices of the {} performance counters", all.len()),
                "choose by `Counters::choose`",
            ));
        }
        let indices: Vec<_> = chosen.iter().map(|&index| index as u32).collect();
        let mut performance = vk::QueryPoolPerformanceCreateInfoKHR::default()
            .queue_family_index(device.queue_family())
            .counter_indices(&indices);
        let mut passes = 0;
        let ask = calls.get_physical_device_queue_family_performance_query_passes_khr;
        // SAFETY: the device has the extension, and the indices are of its counters.
        unsafe { ask(device.physical_device(), &performance, &mut passes) };
        let lock = ProfilingLock::new(device)?;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::PERFORMANCE_QUERY_KHR)
            .query_count(1)
            .push_next(&mut performance);
        // SAFETY: the feature is enabled, and the indices are of the family's counters.
        let pool = unsafe { device.create_query_pool(&info, "performance counters") }?;
        let counters = chosen.iter().map(|&index| (all[index].clone(), storages[index])).collect();
        Ok(Self { pool, _lock: lock, counters, passes })
    }

    /// How often the work is done until all counters have counted.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Records the reset.
    pub fn reset(&self, recorder: &Recorder<'_>) {
        // SAFETY: recording, outside of a render pass; the pool has one query.
        unsafe { recorder.device().raw().cmd_reset_query_pool(recorder.raw(), self.pool.raw(), 0, 1) };
    }

    /// Records the begin: the first command of its command buffer.
    pub fn begin(&self, recorder: &Recorder<'_>) {
        let none = vk::QueryControlFlags::empty();
        // SAFETY: the lock was taken before, and `reset` is executed before.
        unsafe { recorder.device().raw().cmd_begin_query(recorder.raw(), self.pool.raw(), 0, none) };
    }

    /// Records the end, once all before has finished: the last command of its command buffer.
    pub fn end(&self, recorder: &Recorder<'_>) {
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let all = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        let none = vk::DependencyFlags::empty();
        // SAFETY: recording, outside of a render pass; `begin` began the query.
        unsafe {
            device.cmd_pipeline_barrier(raw, all, all, none, &[], &[], &[]);
            device.cmd_end_query(raw, self.pool.raw(), 0);
        }
    }

    /// What is chained to the submission of a pass, of which the first is 0.
    pub fn submit_info(&self, pass: u32) -> vk::PerformanceQuerySubmitInfoKHR<'static> {
        vk::PerformanceQuerySubmitInfoKHR::default().counter_pass_index(pass)
    }

    /// What was counted, after all passes; without values where the driver has none although the GPU has finished.
    ///
    /// # Errors
    /// [`Error::Vulkan`], e.g. when the device was lost.
    pub fn results(&self) -> Result<CounterFigures> {
        let device = self.pool.device().raw();
        let mut values = vec![vk::PerformanceCounterResultKHR::default(); self.counters.len()];
        let bytes = size_of_val(&values[..]);
        let none = vk::QueryResultFlags::empty();
        // SAFETY: there is room for a value of each counter, which is what one query holds.
        let result = unsafe {
            let get = device.fp_v1_0().get_query_pool_results;
            let (pool, values) = (self.pool.raw(), values.as_mut_ptr().cast());
            get(device.handle(), pool, 0, 1, bytes, values, bytes as vk::DeviceSize, none)
        };
        let are_there = match result {
            vk::Result::SUCCESS => true,
            vk::Result::NOT_READY => false,
            result => return Err(Error::Vulkan { call: "vkGetQueryPoolResults", result }),
        };
        let figure = |((counter, storage), value): (&(Counter, _), _)| CounterFigure {
            name: counter.name.clone(),
            category: counter.category.clone(),
            unit: counter.unit.clone(),
            value: are_there.then(|| number(*storage, value)).flatten().map(Figure::driver),
        };
        let counters = self.counters.iter().zip(values).map(figure).collect();
        Ok(CounterFigures { passes: self.passes, counters })
    }
}

/// A value as a number; 64 bits of an integer are rounded to the 53 of one.
fn number(storage: vk::PerformanceCounterStorageKHR, value: vk::PerformanceCounterResultKHR) -> Option<f64> {
    use vk::PerformanceCounterStorageKHR as Storage;
    // SAFETY: all of the union's 8 bytes were initialised, and any bits are a number of any of its types.
    unsafe {
        Some(match storage {
            Storage::INT32 => value.int32.into(),
            Storage::INT64 => value.int64 as f64,
            Storage::UINT32 => value.uint32.into(),
            Storage::UINT64 => value.uint64 as f64,
            Storage::FLOAT32 => value.float32.into(),
            Storage::FLOAT64 => value.float64,
            _ => return None,
        })
    }
    .filter(|number| number.is_finite())
}

/// The device's profiling lock, held until it is dropped.
struct ProfilingLock {
    calls: DeviceFn,
    device: Device,
}

impl ProfilingLock {
    fn new(device: &Device) -> Result<Self> {
        if device.profiling().swap(true, Ordering::AcqRel) {
            return Err(Error::unsupported(
                "a device's performance counters can be queried by one query at a time",
                "drop the other `CounterQuery` before",
            ));
        }
        let taken = Self::take(device);
        if taken.is_err() {
            device.profiling().store(false, Ordering::Release);
        }
        taken
    }

    fn take(device: &Device) -> Result<Self> {
        // SAFETY: the device belongs to the instance.
        let find = unsafe { device_functions(device.instance(), device.raw().handle()) };
        let calls = DeviceFn::load(find);
        let info = vk::AcquireProfilingLockInfoKHR::default().timeout(PATIENCE.as_nanos() as u64);
        // SAFETY: the feature is enabled, and no other query of this crate holds the lock.
        match unsafe { (calls.acquire_profiling_lock_khr)(device.raw().handle(), &info) } {
            vk::Result::TIMEOUT => Err(Error::unsupported(
                format!("'{}' does not hand out its profiling lock", device.caps().name),
                "end other programs that profile it, and see that the system allows it (for Intel on Linux: sysctl dev.i915.perf_stream_paranoid=0)",
            )),
            result => {
                result.result().called("vkAcquireProfilingLockKHR")?;
                Ok(Self { calls, device: device.clone() })
            }
        }
    }
}

impl Drop for ProfilingLock {
    fn drop(&mut self) {
        // SAFETY: `take` has taken it; what was recorded under it has finished, as users promise.
        unsafe { (self.calls.release_profiling_lock_khr)(self.device.raw().handle()) };
        self.device.profiling().store(false, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_storage_is_read_as_it_is() {
        use vk::{PerformanceCounterResultKHR as Value, PerformanceCounterStorageKHR as Storage};
        let read = |storage, value| number(storage, value);
        assert_eq!(read(Storage::INT32, Value { int64: 0x7fff_ffff_ffff_ffff }), Some(-1.0));
        assert_eq!(read(Storage::INT64, Value { int64: -(1 << 40) }), Some(-1_099_511_627_776.0));
        assert_eq!(read(Storage::UINT32, Value { uint64: u64::MAX }), Some(4_294_967_295.0));
        assert_eq!(read(Storage::UINT64, Value { uint64: 1 << 63 }), Some(9_223_372_036_854_775_808.0));
        assert_eq!(read(Storage::FLOAT32, Value { float32: 0.5 }), Some(0.5));
        assert_eq!(read(Storage::FLOAT64, Value { float64: -0.1 }), Some(-0.1));
        assert_eq!(read(Storage::FLOAT32, Value { float32: f32::NAN }), None);
        assert_eq!(read(Storage::from_raw(77), Value { float32: 0.5 }), None);
    }
}

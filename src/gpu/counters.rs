//! Performance counters of a device (VK_KHR_performance_query): which there are, and what they counted.
//!
//! A counter has a scope: commands, whole render passes or whole command buffers. A query that is begun by the first command of
//! a command buffer and ended by the last one suits all three, so that is what is asked of hosts, and done here.

mod query;

use std::ffi::{CStr, c_char};

use ash::khr::performance_query::InstanceFn;
use ash::vk;
use serde::Serialize;

use super::{Called, Device};
use crate::{Error, Result};
pub use query::CounterQuery;

/// A performance counter, in the driver's words; its kinds are Vulkan's names in lower case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Counter {
    /// Name; drivers need not keep names apart.
    pub name: String,
    /// Category.
    pub category: String,
    /// What it counts.
    pub description: String,
    /// `VkPerformanceCounterUnitKHR`: "generic" (a plain number), "percentage", "nanoseconds", "bytes", "cycles" and so on.
    pub unit: String,
    /// `VkPerformanceCounterScopeKHR`: the smallest thing that can be counted, "command", "render_pass" or "command_buffer".
    pub scope: String,
    /// `VkPerformanceCounterStorageKHR`: "int32", "uint64", "float32" and so on.
    pub storage: String,
    /// Counting may make the work slower.
    pub performance_impacting: bool,
    /// What goes on beside it may be counted too.
    pub concurrently_impacted: bool,
}

/// The performance counters of a device's queue family.
pub struct Counters {
    all: Vec<Counter>,
    storages: Vec<vk::PerformanceCounterStorageKHR>,
    calls: InstanceFn,
    device: Device,
}

impl Counters {
    /// Lists the counters of a host's device.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it was made without [`Features::performance_counters`](super::Features::performance_counters);
    /// [`Error::Vulkan`].
    ///
    /// # Safety
    /// The device's instance was made with `entry`.
    pub unsafe fn from_host(entry: &ash::Entry, device: &Device) -> Result<Self> {
        if !device.features().performance_counters {
            return Err(Error::unsupported(
                format!("'{}' was made without performance counters", device.caps().name),
                "enable performanceCounterQueryPools of VK_KHR_performance_query and say so in `Features`",
            ));
        }
        let (instance, family) = (device.instance(), device.queue_family());
        // SAFETY: the caller's promise; the device has the extension, since its feature is enabled.
        unsafe {
            let calls = instance_calls(entry, instance);
            let (all, storages) = list(&calls, device.physical_device(), family)?;
            Ok(Self { all, storages, calls, device: device.clone() })
        }
    }

    /// All of them, in the driver's order.
    pub fn all(&self) -> &[Counter] {
        &self.all
    }

    /// Indices into [`Self::all`] of those that are named, each once: by their name (whatever its case), of which several may
    /// be, by their index, or all of them by `all`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if a name is that of none.
    pub fn choose(&self, names: &[impl AsRef<str>]) -> Result<Vec<usize>> {
        let device = &self.device.caps().name;
        choose(&self.all, names).map_err(|name| match self.all.len() {
            0 => Error::unsupported(
                format!("the driver of '{device}' has VK_KHR_performance_query, but no counter"),
                "see what it wants for that (Mesa's Turnip on Adreno 6xx: TU_DEBUG=perfcraw), or do without --counters",
            ),
            _ => Error::unsupported(
                format!("'{device}' has no performance counter '{name}'"),
                "'ontile info --counters' lists those that it has; or take all",
            ),
        })
    }
}

/// The indices, or the first name that is of no counter.
fn choose<'a>(all: &[Counter], names: &'a [impl AsRef<str>]) -> Result<Vec<usize>, &'a str> {
    let mut chosen = Vec::new();
    for name in names.iter().map(|name| name.as_ref().trim()) {
        let before = chosen.len();
        let is_meant = |(index, counter): (usize, &Counter)| {
            name.eq_ignore_ascii_case("all")
                || counter.name.eq_ignore_ascii_case(name)
                || name.parse() == Ok(index)
        };
        chosen.extend((0..all.len()).filter(|&index| is_meant((index, &all[index]))));
        if chosen.len() == before {
            return Err(name);
        }
    }
    let mut seen = vec![false; all.len()];
    chosen.retain(|&index| !std::mem::replace(&mut seen[index], true));
    Ok(chosen)
}

/// What physical devices are asked with.
///
/// # Safety
/// The instance was made with `entry`.
pub(super) unsafe fn instance_calls(entry: &ash::Entry, instance: &ash::Instance) -> InstanceFn {
    InstanceFn::load(|name| {
        // SAFETY: the caller's promise; names end with a NUL.
        let found = unsafe { entry.get_instance_proc_addr(instance.handle(), name.as_ptr()) };
        found.map_or(std::ptr::null(), |function| function as *const std::ffi::c_void)
    })
}

type Listed = (Vec<Counter>, Vec<vk::PerformanceCounterStorageKHR>);

/// All counters of a queue family.
///
/// # Safety
/// The functions are of the physical device's instance, and the device has VK_KHR_performance_query and the family.
pub(super) unsafe fn list(
    calls: &InstanceFn,
    physical_device: vk::PhysicalDevice,
    queue_family: u32,
) -> Result<Listed> {
    const CALL: &str = "vkEnumeratePhysicalDeviceQueueFamilyPerformanceQueryCountersKHR";
    let enumerate = calls.enumerate_physical_device_queue_family_performance_query_counters_khr;
    let mut count = 0;
    let (none, nothing) = (std::ptr::null_mut(), std::ptr::null_mut());
    // SAFETY: the caller's promise; without arrays only the count is written.
    unsafe { enumerate(physical_device, queue_family, &mut count, none, nothing) }.result().called(CALL)?;
    let mut counters = vec![vk::PerformanceCounterKHR::default(); count as usize];
    let mut descriptions = vec![vk::PerformanceCounterDescriptionKHR::default(); count as usize];
    let (first, described) = (counters.as_mut_ptr(), descriptions.as_mut_ptr());
    // SAFETY: as above; both arrays have room for the count.
    unsafe { enumerate(physical_device, queue_family, &mut count, first, described) }
        .result()
        .called(CALL)?;
    let told = || counters.iter().zip(&descriptions).take(count as usize);
    let all = told().map(|(counter, description)| counter_of(counter, description)).collect();
    Ok((all, told().map(|(counter, _)| counter.storage).collect()))
}

fn counter_of(
    counter: &vk::PerformanceCounterKHR<'_>,
    description: &vk::PerformanceCounterDescriptionKHR<'_>,
) -> Counter {
    use vk::PerformanceCounterDescriptionFlagsKHR as Flags;
    let scope = match counter.scope {
        vk::PerformanceCounterScopeKHR::COMMAND_BUFFER => "command_buffer".into(),
        vk::PerformanceCounterScopeKHR::RENDER_PASS => "render_pass".into(),
        vk::PerformanceCounterScopeKHR::COMMAND => "command".into(),
        other => format!("{other:?}").to_lowercase(),
    };
    Counter {
        name: text(&description.name),
        category: text(&description.category),
        description: text(&description.description),
        unit: format!("{:?}", counter.unit).to_lowercase(),
        scope,
        storage: format!("{:?}", counter.storage).to_lowercase(),
        performance_impacting: description.flags.contains(Flags::PERFORMANCE_IMPACTING),
        concurrently_impacted: description.flags.contains(Flags::CONCURRENTLY_IMPACTED),
    }
}

/// A driver's text, as far as it goes where no NUL ends it.
fn text(characters: &[c_char]) -> String {
    let bytes: Vec<u8> = characters.iter().map(|&c| c as u8).collect();
    let ended = CStr::from_bytes_until_nul(&bytes).map(CStr::to_bytes).unwrap_or(&bytes);
    String::from_utf8_lossy(ended).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_are_chosen_by_name_or_index() {
        let counter = |name: &str| Counter {
            name: name.into(),
            category: String::new(),
            description: String::new(),
            unit: "generic".into(),
            scope: "command".into(),
            storage: "uint32".into(),
            performance_impacting: false,
            concurrently_impacted: false,
        };
        let all = ["Reads", "Writes, all", "Reads", "Cycles"].map(counter);
        assert_eq!(choose(&all, &["cycles", "reads", "CYCLES"]), Ok(vec![3, 0, 2]));
        assert_eq!(choose(&all, &["1", " Cycles "]), Ok(vec![1, 3]));
        assert_eq!(choose(&all, &["cycles", "all"]), Ok(vec![3, 0, 1, 2]));
        assert_eq!(choose(&all, &["reads", "4"]), Err("4"));
        assert_eq!(choose(&all, &["Cycle"]), Err("Cycle"));
        assert_eq!(choose(&all, &[""]), Err(""));
    }

    #[test]
    fn a_text_need_not_end() {
        assert_eq!(text(&[b'a' as c_char; 256]).len(), 256);
        assert_eq!(text(&[b'a' as c_char, 0, b'b' as c_char]), "a");
    }
}

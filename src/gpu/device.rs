//! The device that everything is made from: ours or a host engine's.

use super::caps::{Caps, lazy_types, types_with};
use super::headless::OwnedDevice;
use super::owned::{Counters, Live};
use super::rendering::RenderingCalls;
use crate::plan::{Limits, Merging};
use crate::{Error, Result};
use ash::vk::{self, Handle};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a host engine lends. Nothing in it is destroyed by this crate.
///
/// The host keeps instance and device alive until the last [`Device`] clone and everything made from it is
/// dropped. It created both for Vulkan 1.1 or later.
pub struct HostDevice {
    /// The host's instance, with its function table.
    pub instance: ash::Instance,
    /// The device that `device` was created from.
    pub physical_device: vk::PhysicalDevice,
    /// The host's device, with its function table.
    pub device: ash::Device,
    /// A family with graphics support; command buffers given to this crate come from it.
    pub queue_family: u32,
    /// A queue of that family. Only [`Commands`](super::Commands) submits to it; a host that uses those
    /// synchronises its own submissions with them. Recording into the host's command buffers submits nothing.
    pub queue: vk::Queue,
    /// Passed to every Vulkan call that creates or destroys an object. Memory follows them only if
    /// `allocator` is `None` and it is lazily allocated: gpu-allocator calls without callbacks.
    pub callbacks: Option<vk::AllocationCallbacks<'static>>,
    /// The host's allocator, to share its memory blocks; otherwise this crate makes one of its own.
    pub allocator: Option<Arc<Mutex<Allocator>>>,
    /// What the host enabled.
    pub features: Features,
}

/// Optional features that are enabled on a device; all may be off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// VK_EXT_debug_utils on the instance: names and labels are set.
    pub debug_utils: bool,
    /// `pipelineStatisticsQuery`.
    pub pipeline_statistics: bool,
    /// `imageCubeArray`: scenes with probes want it.
    pub image_cube_array: bool,
    /// `occlusionQueryPrecise`: fragments can be counted.
    pub occlusion_precise: bool,
    /// `rasterizationOrderColorAttachmentAccess` of VK_EXT_rasterization_order_attachment_access or of Arm's original: layouts
    /// that hold light in words want it where lights are added one by one.
    pub ordered_attachment_access: bool,
    /// `dynamicRenderingLocalRead` and `dynamicRendering`, of VK_KHR_dynamic_rendering_local_read and VK_KHR_dynamic_rendering or
    /// of Vulkan 1.4, and `independentBlend`: the strategy local-read wants them.
    pub local_read: bool,
    /// `subpassMergeFeedback` of VK_EXT_subpass_merge_feedback: reports say what the driver makes of subpasses.
    pub subpass_merge_feedback: bool,
    /// `performanceCounterQueryPools` of VK_KHR_performance_query: [`Counters`](super::Counters) can be read.
    pub performance_counters: bool,
    /// `sampleRateShading`: G-buffers of several samples a pixel want it.
    pub sample_rate_shading: bool,
    /// `depthClamp` and `shaderClipDistance`: shadow volumes want both.
    pub depth_clamp: bool,
    /// `samplerAnisotropy`: samplers that ask for it do without otherwise.
    pub sampler_anisotropy: bool,
    /// `textureCompressionBC`. Compressed pictures of a kind that is not enabled are decoded when they are uploaded.
    pub texture_compression_bc: bool,
    /// `textureCompressionETC2`.
    pub texture_compression_etc2: bool,
    /// `textureCompressionASTC_LDR`.
    pub texture_compression_astc: bool,
}

/// A Vulkan device and what is needed to use it. Clones are cheap and share everything.
#[derive(Clone)]
pub struct Device {
    shared: Arc<Shared>,
}

/// Fields are dropped in this order: the allocator frees its blocks before the device goes.
struct Shared {
    allocator: Arc<Mutex<Allocator>>,
    instance: ash::Instance,
    physical_device: vk::PhysicalDevice,
    raw: ash::Device,
    queue_family: u32,
    queue: Mutex<vk::Queue>,
    callbacks: Option<vk::AllocationCallbacks<'static>>,
    debug_utils: Option<ash::ext::debug_utils::Device>,
    rendering_calls: Option<RenderingCalls>,
    features: Features,
    caps: Caps,
    memory: vk::PhysicalDeviceMemoryProperties,
    counters: Counters,
    profiling: AtomicBool,
    _owned: Option<OwnedDevice>,
}

impl Device {
    /// Uses a host engine's device.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the allocator cannot be made, or a function of a feature is missing.
    ///
    /// # Safety
    /// The handles belong together, the features named are enabled, and the host keeps all of it alive until
    /// this device, its clones and all objects made from them are dropped.
    pub unsafe fn from_host(host: HostDevice) -> Result<Self> {
        // SAFETY: the caller's promise.
        unsafe { Self::new(host, None) }
    }

    /// # Safety
    /// As [`Self::from_host`]; `owned`, if given, owns `host.device` and `host.instance`.
    pub(super) unsafe fn new(host: HostDevice, owned: Option<OwnedDevice>) -> Result<Self> {
        let HostDevice { instance, physical_device, device, queue_family, queue, callbacks, .. } = host;
        // SAFETY: the caller's promise.
        let caps = unsafe { Caps::query(&instance, physical_device, queue_family) };
        // SAFETY: the caller's promise.
        let memory = unsafe { instance.get_physical_device_memory_properties(physical_device) };
        let allocator = match host.allocator {
            Some(allocator) => allocator,
            None => Arc::new(Mutex::new(own_allocator(&instance, &device, physical_device)?)),
        };
        let debug_utils =
            host.features.debug_utils.then(|| ash::ext::debug_utils::Device::new(&instance, &device));
        let rendering_calls = host.features.local_read.then(|| {
            // SAFETY: the caller's promise.
            unsafe { RenderingCalls::load(&instance, device.handle()) }
        });
        let rendering_calls = rendering_calls.transpose()?;
        let shared = Shared {
            allocator,
            instance,
            physical_device,
            raw: device,
            queue_family,
            queue: Mutex::new(queue),
            callbacks,
            debug_utils,
            rendering_calls,
            features: host.features,
            caps,
            memory,
            counters: Counters::default(),
            profiling: AtomicBool::new(false),
            _owned: owned,
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// The function table of the device.
    pub fn raw(&self) -> &ash::Device {
        &self.shared.raw
    }

    /// The function table of the instance.
    pub fn instance(&self) -> &ash::Instance {
        &self.shared.instance
    }

    /// The physical device.
    pub fn physical_device(&self) -> vk::PhysicalDevice {
        self.shared.physical_device
    }

    /// The family that command buffers come from.
    pub fn queue_family(&self) -> u32 {
        self.shared.queue_family
    }

    /// The queue, locked against this crate's other submissions as Vulkan demands.
    pub fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.shared.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What the device can do.
    pub fn caps(&self) -> &Caps {
        &self.shared.caps
    }

    /// What plans for this device may ask of it: what it can do, less what was not enabled.
    pub fn limits(&self) -> Limits {
        let Features { ordered_attachment_access, sample_rate_shading, local_read, depth_clamp, .. } =
            self.features();
        let mut limits = self.caps().limits();
        limits.ordered_attachment_access &= ordered_attachment_access;
        limits.sample_shading &= sample_rate_shading;
        limits.depth_clamp &= depth_clamp;
        if !local_read && limits.merging.local_read.is_ok() {
            let reason = "the device was made without dynamicRenderingLocalRead";
            limits.merging = Merging { local_read: Err(reason), ..Merging::default() };
        }
        limits
    }

    /// What is enabled.
    pub fn features(&self) -> Features {
        self.shared.features
    }

    /// What this crate has alive on the device.
    pub fn live(&self) -> Live {
        self.shared.counters.live()
    }

    /// The objects of [`Self::live`] one by one: how many there are of each name, by kind. Most have the name of what they hold.
    pub fn live_by_name(&self) -> BTreeMap<String, BTreeMap<String, usize>> {
        self.shared.counters.named()
    }

    /// Names an object for debuggers and validation messages; nothing happens without VK_EXT_debug_utils.
    pub fn set_name(&self, handle: impl Handle, name: &str) {
        let Some(debug_utils) = &self.shared.debug_utils else { return };
        let Ok(name) = CString::new(name) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // A name that cannot be set changes no result, so failure is ignored.
        // SAFETY: the handle is alive: callers hold its owner.
        let _ = unsafe { debug_utils.set_debug_utils_object_name(&info) };
    }

    pub(crate) fn debug_utils(&self) -> Option<&ash::ext::debug_utils::Device> {
        self.shared.debug_utils.as_ref()
    }

    /// What renderings are recorded with, where local reads are enabled.
    pub(crate) fn rendering_calls(&self) -> Option<&RenderingCalls> {
        self.shared.rendering_calls.as_ref()
    }

    pub(crate) fn callbacks(&self) -> Option<&vk::AllocationCallbacks<'static>> {
        self.shared.callbacks.as_ref()
    }

    pub(crate) fn counters(&self) -> &Counters {
        &self.shared.counters
    }

    /// Whether the profiling lock is held.
    pub(super) fn profiling(&self) -> &AtomicBool {
        &self.shared.profiling
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.shared.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The set of memory types that are lazily allocated.
    pub(crate) fn lazy_memory_types(&self) -> u32 {
        lazy_types(&self.shared.memory)
    }

    /// The set of memory types that are the device's own.
    pub(crate) fn device_local_memory_types(&self) -> u32 {
        types_with(&self.shared.memory, vk::MemoryPropertyFlags::DEVICE_LOCAL)
    }

    /// How many clones of this device exist, those inside its objects counted in.
    pub(crate) fn owners(&self) -> usize {
        Arc::strong_count(&self.shared)
    }
}

impl std::fmt::Debug for Device {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Device").field(&self.caps().name).finish()
    }
}

/// Blocks that grow from 16 MiB (8 MiB host-visible) to gpu-allocator's fixed default, so that a small scene
/// does not take 256 MiB.
fn own_allocator(
    instance: &ash::Instance,
    device: &ash::Device,
    physical_device: vk::PhysicalDevice,
) -> Result<Allocator> {
    const MIB: u64 = 1 << 20;
    Allocator::new(&AllocatorCreateDesc {
        instance: instance.clone(),
        device: device.clone(),
        physical_device,
        debug_settings: AllocatorDebugSettings::default(),
        buffer_device_address: false,
        allocation_sizes: AllocationSizes::new(16 * MIB, 8 * MIB)
            .with_max_device_memblock_size(256 * MIB)
            .with_max_host_memblock_size(64 * MIB),
    })
    .map_err(|e| {
        Error::unsupported(format!("no memory allocator for this device: {e}"), "use another device")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Buffer, BufferDesc, Headless, HeadlessOptions, MemoryUse};

    #[test]
    fn a_hosts_device_stays_the_hosts() {
        let options = HeadlessOptions { validate: true, ..Default::default() };
        let host = match Headless::new(&options) {
            Ok(host) => host,
            Err(e) => return println!("ignored: no Vulkan device with validation: {e}"),
        };
        let theirs = host.device();
        let desc = BufferDesc {
            name: "test",
            bytes: 256,
            usage: vk::BufferUsageFlags::STORAGE_BUFFER,
            memory: MemoryUse::Device,
        };
        for allocator in [None, Some(theirs.shared.allocator.clone())] {
            let lent = HostDevice {
                instance: theirs.instance().clone(),
                physical_device: theirs.physical_device(),
                device: theirs.raw().clone(),
                queue_family: theirs.queue_family(),
                queue: *theirs.queue(),
                callbacks: None,
                allocator,
                features: theirs.features(),
            };
            // SAFETY: the handles are of one device, which outlives `ours`.
            let ours = unsafe { Device::from_host(lent) }.unwrap();
            let buffer = Buffer::new(&ours, &desc).unwrap();
            assert_eq!(ours.caps(), theirs.caps());
            assert_eq!(ours.limits(), theirs.limits());
            assert_eq!(ours.live().objects["buffer"], 1);
            assert_eq!(theirs.live(), Live::default());
            drop((buffer, ours));
        }
        // Still usable: nothing of it was destroyed.
        drop(Buffer::new(theirs, &desc).unwrap());
        assert_eq!(host.finish(), Vec::<String>::new());
    }
}

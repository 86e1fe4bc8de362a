//! The host's device, and what is kept of it.

use ash::vk;

use super::call::{Failure, OntileResult, Outcome, call, copy_out, destroy, get, give, list, put};
use crate::gpu::{Device, Features, HostDevice, PipelineCache};

type VkInstance = vk::Instance;
type VkPhysicalDevice = vk::PhysicalDevice;
type VkDevice = vk::Device;
type VkQueue = vk::Queue;
type VkAllocationCallbacks = vk::AllocationCallbacks<'static>;
#[allow(non_camel_case_types, reason = "Vulkan's name")]
type PFN_vkGetInstanceProcAddr = Option<vk::PFN_vkGetInstanceProcAddr>;

/// VK_EXT_debug_utils is enabled on the instance: objects get names.
pub const ONTILE_FEATURE_DEBUG_UTILS: u32 = 1 << 0;
/// pipelineStatisticsQuery.
pub const ONTILE_FEATURE_PIPELINE_STATISTICS: u32 = 1 << 1;
/// imageCubeArray: worlds with probes want it.
pub const ONTILE_FEATURE_IMAGE_CUBE_ARRAY: u32 = 1 << 2;
/// occlusionQueryPrecise.
pub const ONTILE_FEATURE_OCCLUSION_PRECISE: u32 = 1 << 3;
/// rasterizationOrderColorAttachmentAccess of VK_EXT_rasterization_order_attachment_access: some layouts, decals and ways of
/// translucency want it.
pub const ONTILE_FEATURE_ORDERED_ATTACHMENT_ACCESS: u32 = 1 << 4;
/// dynamicRenderingLocalRead, dynamicRendering and independentBlend: the strategy local-read wants them.
pub const ONTILE_FEATURE_LOCAL_READ: u32 = 1 << 5;
/// subpassMergeFeedback of VK_EXT_subpass_merge_feedback.
pub const ONTILE_FEATURE_SUBPASS_MERGE_FEEDBACK: u32 = 1 << 6;
/// sampleRateShading: several samples a pixel want it.
pub const ONTILE_FEATURE_SAMPLE_RATE_SHADING: u32 = 1 << 7;
/// depthClamp and shaderClipDistance: shadow volumes want both.
pub const ONTILE_FEATURE_DEPTH_CLAMP: u32 = 1 << 8;
/// `samplerAnisotropy`: samplers that ask for it do without otherwise.
pub const ONTILE_FEATURE_SAMPLER_ANISOTROPY: u32 = 1 << 9;
/// `textureCompressionBC`. Compressed pictures of a kind that is not enabled are decoded when they are uploaded.
pub const ONTILE_FEATURE_TEXTURE_COMPRESSION_BC: u32 = 1 << 10;
/// `textureCompressionETC2`.
pub const ONTILE_FEATURE_TEXTURE_COMPRESSION_ETC2: u32 = 1 << 11;
/// `textureCompressionASTC_LDR`.
pub const ONTILE_FEATURE_TEXTURE_COMPRESSION_ASTC: u32 = 1 << 12;

/// What a host lends. It was created for Vulkan 1.1 or later and stays the host's: it must live until all objects of ontile that were
/// made with it are destroyed, and is not destroyed by ontile.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileHost {
    /// The loader's vkGetInstanceProcAddr.
    pub get_instance_proc_addr: PFN_vkGetInstanceProcAddr,
    /// The instance.
    pub instance: VkInstance,
    /// Of the instance.
    pub physical_device: VkPhysicalDevice,
    /// Created from the physical device.
    pub device: VkDevice,
    /// A family with graphics support, which command buffers come from.
    pub queue_family_index: u32,
    /// A queue of it. Nothing is submitted to it by the functions of this interface.
    pub queue: VkQueue,
    /// Null, or what every call that makes or destroys an object gets.
    pub allocation_callbacks: *const VkAllocationCallbacks,
    /// Sum of ONTILE_FEATURE_*: what is enabled on the device.
    pub features: u32,
}

/// A host's device as ontile knows it.
pub struct OntileDevice {
    pub(super) device: Device,
}

/// Compiled pipelines, kept for the next run.
pub struct OntilePipelineCache {
    pub(super) cache: PipelineCache,
}

/// Takes note of a host's device.
///
/// # Safety
/// The handles belong together and are alive, the features named are enabled, and `host` and `device` are valid pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_device_create(
    host: *const OntileHost,
    device: *mut *mut OntileDevice,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise, for all that follows.
        unsafe { give(device, "device", || Ok(OntileDevice { device: device_of(get(host, "host")?)? })) }
    })
}

/// # Safety
/// As [`ontile_device_create`].
unsafe fn device_of(host: &OntileHost) -> Outcome<Device> {
    let null = || Failure::Argument("host.get_instance_proc_addr is null".into());
    let get_instance_proc_addr = host.get_instance_proc_addr.ok_or_else(null)?;
    let has = |bit: u32| host.features & bit != 0;
    let entry = ash::StaticFn { get_instance_proc_addr };
    // SAFETY: the caller's promise: the handles are alive and belong together, and the features are enabled.
    unsafe {
        let instance = ash::Instance::load(&entry, host.instance);
        let device = ash::Device::load(instance.fp_v1_0(), host.device);
        Ok(Device::from_host(HostDevice {
            instance,
            physical_device: host.physical_device,
            device,
            queue_family: host.queue_family_index,
            queue: host.queue,
            callbacks: host.allocation_callbacks.as_ref().copied(),
            allocator: None,
            features: Features {
                debug_utils: has(ONTILE_FEATURE_DEBUG_UTILS),
                pipeline_statistics: has(ONTILE_FEATURE_PIPELINE_STATISTICS),
                image_cube_array: has(ONTILE_FEATURE_IMAGE_CUBE_ARRAY),
                occlusion_precise: has(ONTILE_FEATURE_OCCLUSION_PRECISE),
                ordered_attachment_access: has(ONTILE_FEATURE_ORDERED_ATTACHMENT_ACCESS),
                local_read: has(ONTILE_FEATURE_LOCAL_READ),
                subpass_merge_feedback: has(ONTILE_FEATURE_SUBPASS_MERGE_FEEDBACK),
                // A C host begins and ends queries of its own around a frame.
                performance_counters: false,
                sample_rate_shading: has(ONTILE_FEATURE_SAMPLE_RATE_SHADING),
                depth_clamp: has(ONTILE_FEATURE_DEPTH_CLAMP),
                sampler_anisotropy: has(ONTILE_FEATURE_SAMPLER_ANISOTROPY),
                texture_compression_bc: has(ONTILE_FEATURE_TEXTURE_COMPRESSION_BC),
                texture_compression_etc2: has(ONTILE_FEATURE_TEXTURE_COMPRESSION_ETC2),
                texture_compression_astc: has(ONTILE_FEATURE_TEXTURE_COMPRESSION_ASTC),
            },
        })?)
    }
}

/// Forgets a device; null is none. The objects made with it go first.
///
/// # Safety
/// `device` came from ontile_device_create and was not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_device_destroy(device: *mut OntileDevice) {
    // SAFETY: the caller's promise.
    unsafe { destroy(device) }
}

/// How many Vulkan objects and bytes of device memory ontile has on a device.
///
/// # Safety
/// All pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_device_live(
    device: *const OntileDevice,
    objects: *mut u64,
    bytes: *mut u64,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            let live = get(device, "device")?.device.live();
            put(objects, "objects", live.objects.values().map(|&count| count as u64).sum())?;
            put(bytes, "bytes", live.bytes)
        }
    })
}

/// Makes a cache from what ontile_pipeline_cache_blob gave in an earlier run, or from nothing. Content that is damaged, or of another
/// device or driver, counts as nothing.
///
/// # Safety
/// `blob` has `size` bytes, or is null; the other pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_pipeline_cache_create(
    device: *const OntileDevice,
    blob: *const u8,
    size: usize,
    cache: *mut *mut OntilePipelineCache,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            give(cache, "cache", || {
                let blob = list(blob, size, "blob")?;
                Ok(OntilePipelineCache { cache: PipelineCache::new(&get(device, "device")?.device, blob)? })
            })
        }
    })
}

/// The content of a cache. With `blob` null it writes its size; else as much as `size` has room for, and how much that was.
///
/// # Safety
/// All pointers are valid, and `blob` has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_pipeline_cache_blob(
    cache: *const OntilePipelineCache,
    size: *mut usize,
    blob: *mut u8,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe { copy_out(&get(cache, "cache")?.cache.blob()?, size, blob) }
    })
}

/// Destroys a cache; null is none.
///
/// # Safety
/// `cache` came from ontile_pipeline_cache_create and was not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_pipeline_cache_destroy(cache: *mut OntilePipelineCache) {
    // SAFETY: the caller's promise.
    unsafe { destroy(cache) }
}

//! The drop owner of every Vulkan object, and the count of those alive.

use super::{Called, Device};
use crate::Result;
use ash::vk::{self, Handle};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A kind of Vulkan object that a device creates and destroys.
pub trait Object: Handle + Copy + std::fmt::Debug {
    /// Destroys the object.
    ///
    /// # Safety
    /// The object was created by this device with its allocation callbacks, nothing on the GPU uses it any
    /// more, and it is not used afterwards.
    unsafe fn destroy(self, device: &Device);
}

/// A Vulkan object that is destroyed when its owner is dropped.
///
/// The owner does not know whether the GPU still uses the object; whoever submits work keeps it alive long
/// enough.
#[derive(Debug)]
pub struct Owned<H: Object> {
    raw: H,
    name: Box<str>,
    device: Device,
}

impl<H: Object> Owned<H> {
    /// Takes ownership of an object that `device` has just created with its own allocation callbacks.
    pub(crate) fn new(device: &Device, raw: H, name: &str) -> Self {
        device.counters().add(H::TYPE, name);
        let owned = Self { raw, name: name.into(), device: device.clone() };
        device.set_name(raw, name);
        owned
    }

    /// The handle, valid as long as this owner.
    pub fn raw(&self) -> H {
        self.raw
    }

    /// The device it belongs to.
    pub fn device(&self) -> &Device {
        &self.device
    }
}

impl<H: Object> Drop for Owned<H> {
    fn drop(&mut self) {
        // SAFETY: `new` took the only ownership of an object of this device, and its users promise (see the
        // module's essay) that the GPU has finished with it.
        unsafe { self.raw.destroy(&self.device) };
        self.device.counters().remove(H::TYPE, &self.name);
    }
}

macro_rules! objects {
    ($($handle:ident: $create:ident($info:ident) $call:literal, $destroy:ident;)+) => {
        $(
            impl Object for vk::$handle {
                unsafe fn destroy(self, device: &Device) {
                    // SAFETY: the caller's promise is exactly what the call needs.
                    unsafe { device.raw().$destroy(self, device.callbacks()) }
                }
            }
        )+

        #[allow(dead_code, reason = "one table for all kinds; not every kind needs its creation function")]
        impl Device {
            $(
                #[doc = concat!("Calls `", $call, "` and names the object.")]
                ///
                /// # Safety
                /// `info` is valid usage in the sense of the Vulkan specification.
                pub(crate) unsafe fn $create(
                    &self, info: &vk::$info<'_>, name: &str,
                ) -> Result<Owned<vk::$handle>> {
                    // SAFETY: the caller's promise.
                    let raw = unsafe { self.raw().$create(info, self.callbacks()) }.called($call)?;
                    Ok(Owned::new(self, raw, name))
                }
            )+
        }
    };
}

objects! {
    Buffer: create_buffer(BufferCreateInfo) "vkCreateBuffer", destroy_buffer;
    Image: create_image(ImageCreateInfo) "vkCreateImage", destroy_image;
    ImageView: create_image_view(ImageViewCreateInfo) "vkCreateImageView", destroy_image_view;
    Sampler: create_sampler(SamplerCreateInfo) "vkCreateSampler", destroy_sampler;
    DeviceMemory: allocate_memory(MemoryAllocateInfo) "vkAllocateMemory", free_memory;
    RenderPass: create_render_pass(RenderPassCreateInfo) "vkCreateRenderPass", destroy_render_pass;
    Framebuffer: create_framebuffer(FramebufferCreateInfo) "vkCreateFramebuffer", destroy_framebuffer;
    ShaderModule: create_shader_module(ShaderModuleCreateInfo) "vkCreateShaderModule", destroy_shader_module;
    PipelineLayout: create_pipeline_layout(PipelineLayoutCreateInfo) "vkCreatePipelineLayout", destroy_pipeline_layout;
    PipelineCache: create_pipeline_cache(PipelineCacheCreateInfo) "vkCreatePipelineCache", destroy_pipeline_cache;
    DescriptorSetLayout: create_descriptor_set_layout(DescriptorSetLayoutCreateInfo)
        "vkCreateDescriptorSetLayout", destroy_descriptor_set_layout;
    DescriptorPool: create_descriptor_pool(DescriptorPoolCreateInfo)
        "vkCreateDescriptorPool", destroy_descriptor_pool;
    QueryPool: create_query_pool(QueryPoolCreateInfo) "vkCreateQueryPool", destroy_query_pool;
    CommandPool: create_command_pool(CommandPoolCreateInfo) "vkCreateCommandPool", destroy_command_pool;
    Fence: create_fence(FenceCreateInfo) "vkCreateFence", destroy_fence;
    Semaphore: create_semaphore(SemaphoreCreateInfo) "vkCreateSemaphore", destroy_semaphore;
}

impl Object for vk::Pipeline {
    unsafe fn destroy(self, device: &Device) {
        // SAFETY: the caller's promise is exactly what the call needs.
        unsafe { device.raw().destroy_pipeline(self, device.callbacks()) }
    }
}

/// What exists, by kind and name, and the memory behind it.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    objects: Mutex<BTreeMap<vk::ObjectType, BTreeMap<String, usize>>>,
    allocations: AtomicUsize,
    bytes: AtomicU64,
}

impl Counters {
    fn objects(&self) -> MutexGuard<'_, BTreeMap<vk::ObjectType, BTreeMap<String, usize>>> {
        self.objects.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn add(&self, ty: vk::ObjectType, name: &str) {
        *self.objects().entry(ty).or_default().entry(name.to_owned()).or_default() += 1;
    }

    pub(super) fn remove(&self, ty: vk::ObjectType, name: &str) {
        let mut objects = self.objects();
        let of_type = objects.entry(ty).or_default();
        of_type.entry(name.to_owned()).and_modify(|count| *count -= 1);
        of_type.retain(|_, count| *count > 0);
    }

    pub(crate) fn add_memory(&self, bytes: u64) {
        self.allocations.fetch_add(1, Ordering::Relaxed);
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    pub(crate) fn remove_memory(&self, bytes: u64) {
        self.allocations.fetch_sub(1, Ordering::Relaxed);
        self.bytes.fetch_sub(bytes, Ordering::Relaxed);
    }

    pub(crate) fn named(&self) -> BTreeMap<String, BTreeMap<String, usize>> {
        let objects = self.objects();
        let named = objects.iter().filter(|(_, names)| !names.is_empty());
        named.map(|(ty, names)| (format!("{ty:?}").to_lowercase(), names.clone())).collect()
    }

    pub(crate) fn live(&self) -> Live {
        let objects = self.named().into_iter().map(|(kind, names)| (kind, names.values().sum()));
        Live {
            objects: objects.collect(),
            allocations: self.allocations.load(Ordering::Relaxed),
            bytes: self.bytes.load(Ordering::Relaxed),
        }
    }
}

/// What this crate has alive on a device.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Live {
    /// The number of objects by kind (`buffer`, `image_view`, ...); kinds without any are left out.
    pub objects: BTreeMap<String, usize>,
    /// The number of memory allocations behind buffers and images.
    pub allocations: usize,
    /// Their size, lazily allocated ones counted in full.
    pub bytes: u64,
}

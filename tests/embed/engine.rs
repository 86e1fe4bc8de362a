//! An engine that knows nothing of this crate's own hosts: its instance, device, memory, images and submissions are
//! made with plain Vulkan calls.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

use ash::{ext, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use ontile::gpu::{Device, Features, HostDevice};

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
pub const FRAMES_IN_FLIGHT: usize = 2;
/// Of each of the engine's two blocks of memory.
const BLOCK_BYTES: u64 = 8 << 20;

type Messages = Mutex<Vec<String>>;

pub struct Engine {
    entry: ash::Entry,
    instance: ash::Instance,
    debug_utils: ext::debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    /// Leaked: the layer holds its address, also while a failed test unwinds.
    messages: &'static Messages,
    physical_device: vk::PhysicalDevice,
    pub device: ash::Device,
    queue: vk::Queue,
    frames: [FrameInFlight; FRAMES_IN_FLIGHT],
    images: Block,
    readback: Block,
    readback_buffer: vk::Buffer,
    made: Vec<(vk::Image, vk::ImageView)>,
}

#[derive(Clone, Copy)]
struct FrameInFlight {
    pool: vk::CommandPool,
    buffer: vk::CommandBuffer,
    /// Signalled at first.
    fence: vk::Fence,
}

/// Memory that is handed out from its start.
struct Block {
    memory: vk::DeviceMemory,
    used: u64,
}

/// The engine's image.
#[derive(Clone, Copy)]
pub struct EngineImage {
    pub image: vk::Image,
    pub view: vk::ImageView,
    pub size: [u32; 2],
}

impl Engine {
    /// On lavapipe, under validation; the reason if that cannot be.
    pub fn new() -> Result<Self, String> {
        // SAFETY: the system's Vulkan library is loaded; every structure lives until its call has returned, and every
        // handle comes from the call before.
        unsafe {
            let entry = ash::Entry::load().map_err(|e| e.to_string())?;
            let layers = entry.enumerate_instance_layer_properties().map_err(|e| e.to_string())?;
            if !layers.iter().any(|l| l.layer_name_as_c_str() == Ok(LAYER)) {
                return Err("the validation layer is not installed".into());
            }
            let messages: &'static Messages = Box::leak(Box::default());
            let enables = [
                vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION,
                vk::ValidationFeatureEnableEXT::BEST_PRACTICES,
            ];
            let mut validation = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enables);
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_1);
            let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
            let layers = [LAYER.as_ptr()];
            let info = vk::InstanceCreateInfo::default()
                .application_info(&application)
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut validation);
            let instance = entry.create_instance(&info, None).map_err(|e| e.to_string())?;
            let debug_utils = ext::debug_utils::Instance::new(&entry, &instance);
            let messenger =
                debug_utils.create_debug_utils_messenger(&messenger_info(messages), None).unwrap();
            let is_lavapipe = |d: &vk::PhysicalDevice| {
                let name = instance.get_physical_device_properties(*d);
                name.device_name_as_c_str().is_ok_and(|n| n.to_string_lossy().contains("llvmpipe"))
            };
            let physical_device =
                instance.enumerate_physical_devices().unwrap().into_iter().find(is_lavapipe);
            let Some(physical_device) = physical_device else {
                debug_utils.destroy_debug_utils_messenger(messenger, None);
                instance.destroy_instance(None);
                return Err("there is no lavapipe".into());
            };
            // Lavapipe has one family, which does everything.
            let queues =
                [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
            let device = instance.create_device(physical_device, &info, None).unwrap();
            let queue = device.get_device_queue(0, 0);
            let frames = [0; FRAMES_IN_FLIGHT].map(|_| {
                let info = vk::CommandPoolCreateInfo::default().flags(vk::CommandPoolCreateFlags::TRANSIENT);
                let pool = device.create_command_pool(&info, None).unwrap();
                let info =
                    vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
                let buffer = device.allocate_command_buffers(&info).unwrap()[0];
                let signalled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
                FrameInFlight { pool, buffer, fence: device.create_fence(&signalled, None).unwrap() }
            });
            // Lavapipe's only memory type serves the GPU and is mapped, coherent and cached.
            let block = || {
                let info = vk::MemoryAllocateInfo::default().allocation_size(BLOCK_BYTES);
                Block { memory: device.allocate_memory(&info, None).unwrap(), used: 0 }
            };
            let (images, readback) = (block(), block());
            let info =
                vk::BufferCreateInfo::default().size(BLOCK_BYTES).usage(vk::BufferUsageFlags::TRANSFER_DST);
            let readback_buffer = device.create_buffer(&info, None).unwrap();
            assert!(device.get_buffer_memory_requirements(readback_buffer).size <= BLOCK_BYTES);
            device.bind_buffer_memory(readback_buffer, readback.memory, 0).unwrap();
            Ok(Self {
                entry,
                instance,
                debug_utils,
                messenger,
                messages,
                physical_device,
                device,
                queue,
                frames,
                images,
                readback,
                readback_buffer,
                made: Vec::new(),
            })
        }
    }

    /// What the engine lends; with an allocator of its own if `allocator`.
    pub fn lend(&self, allocator: bool) -> (Device, Option<Arc<Mutex<Allocator>>>) {
        let allocator = allocator.then(|| {
            let desc = AllocatorCreateDesc {
                instance: self.instance.clone(),
                device: self.device.clone(),
                physical_device: self.physical_device,
                debug_settings: Default::default(),
                buffer_device_address: false,
                allocation_sizes: Default::default(),
            };
            Arc::new(Mutex::new(Allocator::new(&desc).unwrap()))
        });
        let host = HostDevice {
            instance: self.instance.clone(),
            physical_device: self.physical_device,
            device: self.device.clone(),
            queue_family: 0,
            queue: self.queue,
            callbacks: None,
            allocator: allocator.clone(),
            features: Features { debug_utils: true, ..Features::default() },
        };
        // SAFETY: the handles are of one device without optional features, which `finish` destroys: that takes the
        // engine, after the tests have dropped what they made of the device.
        (unsafe { Device::from_host(host) }.unwrap(), allocator)
    }

    /// An image to draw to and copy from, as swapchains give them.
    pub fn image(&mut self, format: vk::Format, usage: vk::ImageUsageFlags, size: [u32; 2]) -> EngineImage {
        let [width, height] = size;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage | vk::ImageUsageFlags::TRANSFER_SRC);
        // SAFETY: the block has room, which is checked; the image is bound once, before its view is made.
        unsafe {
            let image = self.device.create_image(&info, None).unwrap();
            let needed = self.device.get_image_memory_requirements(image);
            let offset = self.images.used.next_multiple_of(needed.alignment);
            self.images.used = offset + needed.size;
            assert!(self.images.used <= BLOCK_BYTES);
            self.device.bind_image_memory(image, self.images.memory, offset).unwrap();
            let range = vk::ImageSubresourceRange {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                level_count: 1,
                layer_count: 1,
                ..Default::default()
            };
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(range);
            let view = self.device.create_image_view(&info, None).unwrap();
            self.made.push((image, view));
            EngineImage { image, view, size }
        }
    }

    /// Waits until the slot's last submission has finished, then records and submits another; does not wait for it.
    pub fn submit(&self, slot: usize, record: impl FnOnce(vk::CommandBuffer)) {
        let FrameInFlight { pool, buffer, fence } = self.frames[slot];
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let buffers = [buffer];
        // SAFETY: the fence tells that the GPU has finished with the buffer.
        unsafe {
            self.device.wait_for_fences(&[fence], true, u64::MAX).unwrap();
            self.device.reset_fences(&[fence]).unwrap();
            self.device.reset_command_pool(pool, vk::CommandPoolResetFlags::empty()).unwrap();
            self.device.begin_command_buffer(buffer, &begin).unwrap();
            record(buffer);
            self.device.end_command_buffer(buffer).unwrap();
            let submits = [vk::SubmitInfo::default().command_buffers(&buffers)];
            self.device.queue_submit(self.queue, &submits, fence).unwrap();
        }
    }

    /// Waits for all submissions.
    pub fn wait(&self) {
        let fences = self.frames.map(|frame| frame.fence);
        // SAFETY: the fences are signalled or submitted.
        unsafe { self.device.wait_for_fences(&fences, true, u64::MAX) }.unwrap();
    }

    /// Records the copy of an image that is in `layout` to bytes from `at` on that [`Self::read`] gives. No barrier comes
    /// before: what drew the image promises that.
    pub fn copy(&self, buffer: vk::CommandBuffer, image: EngineImage, layout: vk::ImageLayout, at: u64) {
        let [width, height] = image.size;
        let region = vk::BufferImageCopy::default()
            .buffer_offset(at)
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: 1,
                ..Default::default()
            })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        let to_host = vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ);
        // SAFETY: the command buffer is recording, and the region lies in the buffer: the copy is validated.
        unsafe {
            let device = &self.device;
            device.cmd_copy_image_to_buffer(buffer, image.image, layout, self.readback_buffer, &[region]);
            let (from, to) = (vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::HOST);
            device.cmd_pipeline_barrier(buffer, from, to, Default::default(), &[to_host], &[], &[]);
        }
    }

    /// Bytes that were copied, after [`Self::wait`].
    pub fn read(&self, at: u64, count: usize) -> Vec<u8> {
        // SAFETY: the memory is mappable and coherent, and no submission is pending.
        unsafe {
            let data = self.device.map_memory(self.readback.memory, 0, vk::WHOLE_SIZE, Default::default());
            let bytes = data.unwrap().cast::<u8>().add(at as usize);
            let bytes = std::slice::from_raw_parts(bytes, count).to_vec();
            self.device.unmap_memory(self.readback.memory);
            bytes
        }
    }

    /// Destroys everything and returns what the validation layer said. With `loads`, Arm's and IMG's advice against
    /// loading attachments is left out: that is what separate passes are there to do.
    pub fn finish(self, loads: bool) -> Vec<String> {
        self.wait();
        // SAFETY: the GPU has finished, and each handle is destroyed once.
        unsafe {
            for (image, view) in &self.made {
                self.device.destroy_image_view(*view, None);
                self.device.destroy_image(*image, None);
            }
            self.device.destroy_buffer(self.readback_buffer, None);
            for block in [&self.images, &self.readback] {
                self.device.free_memory(block.memory, None);
            }
            for frame in self.frames {
                self.device.destroy_fence(frame.fence, None);
                self.device.destroy_command_pool(frame.pool, None);
            }
            self.device.destroy_device(None);
            self.debug_utils.destroy_debug_utils_messenger(self.messenger, None);
            self.instance.destroy_instance(None);
        }
        drop(self.entry);
        let mut messages = std::mem::take(&mut *self.messages.lock().unwrap());
        messages.retain(|m| !(loads && m.contains("attachment-needs-readback")));
        messages
    }
}

fn messenger_info(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type};
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Type::VALIDATION | Type::PERFORMANCE)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast())
}

unsafe extern "system" fn collect(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // Recording tests count what the renderer allocates, not what this function does.
    allocation_counter::opt_out(|| {
        // SAFETY: the messages are never freed; the layer passes valid data, whose texts are null or end in NUL.
        let (messages, [id, text]) = unsafe {
            let texts = [(*data).p_message_id_name, (*data).p_message].map(|s| match s.is_null() {
                true => String::new(),
                false => CStr::from_ptr(s).to_string_lossy().into_owned(),
            });
            (&*user_data.cast_const().cast::<Messages>(), texts)
        };
        messages.lock().unwrap().push(format!("{id}: {text}"));
    });
    vk::FALSE
}

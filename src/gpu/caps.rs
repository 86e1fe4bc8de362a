//! What a device can do, as plain data.

use ash::{khr, vk};
use serde::{Deserialize, Serialize};
use std::ffi::CStr;

use super::quirks;
use crate::plan::Format;

/// A device's properties as far as they matter here.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Caps {
    /// The device's name.
    pub name: String,
    /// The driver's name and version as the driver words them; only the packed version where it does not say.
    pub driver: String,
    /// `VkDriverId`; 0 where the driver does not say.
    pub driver_id: i32,
    /// Vulkan version as major, minor, patch.
    pub api_version: [u32; 3],
    /// PCI vendor, or Khronos' number of the vendor.
    pub vendor_id: u32,
    /// The vendor's number of the device.
    pub device_id: u32,
    /// Changes whenever pipeline caches become useless.
    pub pipeline_cache_uuid: [u8; 16],
    /// Kind of device.
    pub device_type: DeviceType,
    /// Whether a memory type exists whose pages are committed only when needed.
    pub lazily_allocated_memory: bool,
    /// `maxImageDimension2D`, texels.
    pub max_image_dimension_2d: u32,
    /// `maxFramebufferWidth` and `maxFramebufferHeight`, pixels.
    pub max_framebuffer_size: [u32; 2],
    /// `maxPerStageDescriptorInputAttachments`.
    pub max_per_stage_descriptor_input_attachments: u32,
    /// `maxDescriptorSetInputAttachments`.
    pub max_descriptor_set_input_attachments: u32,
    /// `maxColorAttachments` of one subpass.
    pub max_color_attachments: u32,
    /// `maxFragmentOutputAttachments`.
    pub max_fragment_output_attachments: u32,
    /// `maxPerStageDescriptorSampledImages`.
    pub max_per_stage_descriptor_sampled_images: u32,
    /// `maxBoundDescriptorSets`.
    pub max_bound_descriptor_sets: u32,
    /// `maxPushConstantsSize`, bytes.
    pub max_push_constants_bytes: u32,
    /// `minUniformBufferOffsetAlignment`, bytes.
    pub min_uniform_buffer_offset_alignment: u64,
    /// `minStorageBufferOffsetAlignment`, bytes.
    pub min_storage_buffer_offset_alignment: u64,
    /// `optimalBufferCopyOffsetAlignment`, bytes.
    pub optimal_buffer_copy_offset_alignment: u64,
    /// `maxSamplerAnisotropy`; 1 without the feature.
    pub max_sampler_anisotropy: f32,
    /// `subPixelPrecisionBits`: vertices are rounded to this many binary places of a pixel.
    pub sub_pixel_precision_bits: u32,
    /// Sample counts that colour, depth and stencil attachments all support, input attachments included.
    pub sample_counts: Vec<u32>,
    /// Those that attachments of integers support too.
    pub integer_sample_counts: Vec<u32>,
    /// The `sampleRateShading` feature.
    pub sample_rate_shading: bool,
    /// `depthClamp` and `shaderClipDistance`.
    #[serde(default)]
    pub depth_clamp: bool,
    /// The `textureCompressionBC` feature.
    #[serde(default)]
    pub texture_compression_bc: bool,
    /// The `textureCompressionETC2` feature.
    #[serde(default)]
    pub texture_compression_etc2: bool,
    /// The `textureCompressionASTC_LDR` feature.
    #[serde(default)]
    pub texture_compression_astc: bool,
    /// Nanoseconds per timestamp step.
    pub timestamp_period_ns: f32,
    /// Meaningful bits of a timestamp on the queue family in use; 0 without timestamps.
    pub timestamp_valid_bits: u32,
    /// Whether D32_SFLOAT_S8_UINT can be a depth attachment; where it cannot, D24_UNORM_S8_UINT can.
    pub d32_s8: bool,
    /// The `pipelineStatisticsQuery` feature.
    pub pipeline_statistics: bool,
    /// The `imageCubeArray` feature.
    pub image_cube_array: bool,
    /// The `occlusionQueryPrecise` feature.
    pub occlusion_precise: bool,
    /// VK_KHR_dynamic_rendering_local_read, with the extensions that it builds on and `independentBlend`.
    pub local_read: bool,
    /// VK_EXT_rasterization_order_attachment_access (or Arm's original) for colour.
    pub rasterization_order_attachment_access: bool,
    /// VK_EXT_subpass_merge_feedback.
    pub subpass_merge_feedback: bool,
    /// `performanceCounterQueryPools` of VK_KHR_performance_query.
    #[serde(default)]
    pub performance_counters: bool,
    /// Memory types in the driver's order.
    pub memory_types: Vec<MemoryType>,
}

/// Kind of device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceType {
    /// Memory and power of its own.
    Discrete,
    /// Part of the processor.
    Integrated,
    /// Shared with other virtual machines.
    Virtual,
    /// A program on the processor.
    Cpu,
    /// None of these.
    #[default]
    Other,
}

/// A memory type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MemoryType {
    /// Device-local, host-visible and so on, in lower case.
    pub properties: Vec<String>,
    /// The size of its heap.
    pub heap_bytes: u64,
    /// Index of its heap.
    pub heap: u32,
}

impl Caps {
    /// The part that a plan depends on.
    pub fn limits(&self) -> crate::plan::Limits {
        let [width, height] = self.max_framebuffer_size;
        crate::plan::Limits {
            max_color_attachments: self.max_color_attachments.min(self.max_fragment_output_attachments),
            max_input_attachments: self
                .max_per_stage_descriptor_input_attachments
                .min(self.max_descriptor_set_input_attachments),
            max_image_size: self.max_image_dimension_2d.min(width).min(height),
            gbuffer_on_chip: self.lazily_allocated_memory || self.device_type == DeviceType::Cpu,
            ordered_attachment_access: self.rasterization_order_attachment_access,
            merging: quirks::merging(self),
            sample_counts: self.sample_counts.iter().sum(),
            word_sample_counts: self.integer_sample_counts.iter().sum(),
            sample_shading: self.sample_rate_shading,
            depth_clamp: self.depth_clamp,
            depth_stencil: if self.d32_s8 { Format::D32FloatS8 } else { Format::D24UnormS8 },
        }
    }

    /// Asks the driver.
    ///
    /// # Safety
    /// `physical_device` belongs to `instance`, which (like the device) is of Vulkan 1.1 at least; the device has
    /// the queue family.
    pub(crate) unsafe fn query(
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        queue_family: u32,
    ) -> Self {
        // SAFETY: the caller's promise covers this and the queries below.
        let extensions =
            unsafe { instance.enumerate_device_extension_properties(physical_device) }.unwrap_or_default();
        let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));

        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default();
        if has(khr::driver_properties::NAME) {
            properties = properties.push_next(&mut driver);
        }
        // SAFETY: as above; the chained structure's extension is there.
        unsafe { instance.get_physical_device_properties2(physical_device, &mut properties) };
        let properties = properties.properties;

        let of_local_read = [
            khr::dynamic_rendering_local_read::NAME,
            khr::dynamic_rendering::NAME,
            khr::depth_stencil_resolve::NAME,
            khr::create_renderpass2::NAME,
        ];
        let has_local_read = of_local_read.into_iter().all(has);
        let has_order = has(ash::ext::rasterization_order_attachment_access::NAME)
            || has(ash::arm::rasterization_order_attachment_access::NAME);
        let has_feedback = has(ash::ext::subpass_merge_feedback::NAME) && has(khr::create_renderpass2::NAME);
        let has_counters = has(khr::performance_query::NAME);
        let mut local_read = vk::PhysicalDeviceDynamicRenderingLocalReadFeaturesKHR::default();
        let mut order = vk::PhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT::default();
        let mut feedback = vk::PhysicalDeviceSubpassMergeFeedbackFeaturesEXT::default();
        let mut counters = vk::PhysicalDevicePerformanceQueryFeaturesKHR::default();
        let mut features = vk::PhysicalDeviceFeatures2::default();
        if has_local_read {
            features = features.push_next(&mut local_read);
        }
        if has_order {
            features = features.push_next(&mut order);
        }
        if has_feedback {
            features = features.push_next(&mut feedback);
        }
        if has_counters {
            features = features.push_next(&mut counters);
        }
        // SAFETY: as above; each chained structure's extension is there.
        unsafe { instance.get_physical_device_features2(physical_device, &mut features) };
        let features = features.features;

        // SAFETY: as above.
        let memory = unsafe { instance.get_physical_device_memory_properties(physical_device) };
        // SAFETY: as above.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical_device) };

        let limits = &properties.limits;
        let version = properties.api_version;
        // Input attachments are sampled images as far as sample counts go.
        let sample_counts = limits.framebuffer_color_sample_counts
            & limits.framebuffer_depth_sample_counts
            & limits.framebuffer_stencil_sample_counts
            & limits.sampled_image_color_sample_counts
            & limits.sampled_image_depth_sample_counts;
        // Before Vulkan 1.2 no limit says it of attachments.
        // SAFETY: as above.
        let of_integers = unsafe {
            instance.get_physical_device_image_format_properties(
                physical_device,
                vk::Format::R32G32B32A32_UINT,
                vk::ImageType::TYPE_2D,
                vk::ImageTiling::OPTIMAL,
                vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::INPUT_ATTACHMENT,
                vk::ImageCreateFlags::empty(),
            )
        };
        let integer_sample_counts = of_integers.map_or(vk::SampleCountFlags::TYPE_1, |p| p.sample_counts);
        let counts = |counts: vk::SampleCountFlags| {
            (0..7).map(|bit| 1 << bit).filter(|n| counts.as_raw() & n != 0).collect()
        };
        Self {
            name: text(properties.device_name_as_c_str()),
            driver: match (text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())) {
                (name, _) if name.is_empty() => format!("version {:#x}", properties.driver_version),
                (name, info) if info.is_empty() => name,
                (name, info) => format!("{name} {info}"),
            },
            driver_id: driver.driver_id.as_raw(),
            api_version: [
                vk::api_version_major(version),
                vk::api_version_minor(version),
                vk::api_version_patch(version),
            ],
            vendor_id: properties.vendor_id,
            device_id: properties.device_id,
            pipeline_cache_uuid: properties.pipeline_cache_uuid,
            device_type: match properties.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => DeviceType::Discrete,
                vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceType::Integrated,
                vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceType::Virtual,
                vk::PhysicalDeviceType::CPU => DeviceType::Cpu,
                _ => DeviceType::Other,
            },
            lazily_allocated_memory: lazy_types(&memory) != 0,
            max_image_dimension_2d: limits.max_image_dimension2_d,
            max_framebuffer_size: [limits.max_framebuffer_width, limits.max_framebuffer_height],
            max_per_stage_descriptor_input_attachments: limits.max_per_stage_descriptor_input_attachments,
            max_descriptor_set_input_attachments: limits.max_descriptor_set_input_attachments,
            max_color_attachments: limits.max_color_attachments,
            max_fragment_output_attachments: limits.max_fragment_output_attachments,
            max_per_stage_descriptor_sampled_images: limits.max_per_stage_descriptor_sampled_images,
            max_bound_descriptor_sets: limits.max_bound_descriptor_sets,
            max_push_constants_bytes: limits.max_push_constants_size,
            min_uniform_buffer_offset_alignment: limits.min_uniform_buffer_offset_alignment,
            min_storage_buffer_offset_alignment: limits.min_storage_buffer_offset_alignment,
            optimal_buffer_copy_offset_alignment: limits.optimal_buffer_copy_offset_alignment,
            sub_pixel_precision_bits: limits.sub_pixel_precision_bits,
            max_sampler_anisotropy: match features.sampler_anisotropy {
                vk::TRUE => limits.max_sampler_anisotropy,
                _ => 1.0,
            },
            sample_counts: counts(sample_counts),
            integer_sample_counts: counts(sample_counts & integer_sample_counts),
            sample_rate_shading: features.sample_rate_shading == vk::TRUE,
            depth_clamp: features.depth_clamp == vk::TRUE && features.shader_clip_distance == vk::TRUE,
            texture_compression_bc: features.texture_compression_bc == vk::TRUE,
            texture_compression_etc2: features.texture_compression_etc2 == vk::TRUE,
            texture_compression_astc: features.texture_compression_astc_ldr == vk::TRUE,
            timestamp_period_ns: limits.timestamp_period,
            timestamp_valid_bits: families.get(queue_family as usize).map_or(0, |f| f.timestamp_valid_bits),
            d32_s8: {
                // SAFETY: as above.
                let format = unsafe {
                    let format = vk::Format::D32_SFLOAT_S8_UINT;
                    instance.get_physical_device_format_properties(physical_device, format)
                };
                format.optimal_tiling_features.contains(vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT)
            },
            pipeline_statistics: features.pipeline_statistics_query == vk::TRUE,
            image_cube_array: features.image_cube_array == vk::TRUE,
            occlusion_precise: features.occlusion_query_precise == vk::TRUE,
            local_read: local_read.dynamic_rendering_local_read == vk::TRUE
                && features.independent_blend == vk::TRUE,
            rasterization_order_attachment_access: order.rasterization_order_color_attachment_access
                == vk::TRUE,
            subpass_merge_feedback: feedback.subpass_merge_feedback == vk::TRUE,
            performance_counters: counters.performance_counter_query_pools == vk::TRUE,
            memory_types: memory
                .memory_types_as_slice()
                .iter()
                .map(|ty| MemoryType {
                    properties: memory_property_names(ty.property_flags),
                    heap_bytes: memory.memory_heaps[ty.heap_index as usize].size,
                    heap: ty.heap_index,
                })
                .collect(),
        }
    }
}

/// The set of memory types (bit `i` for type `i`) that are lazily allocated.
pub(crate) fn lazy_types(memory: &vk::PhysicalDeviceMemoryProperties) -> u32 {
    types_with(memory, vk::MemoryPropertyFlags::LAZILY_ALLOCATED)
}

/// The set of memory types that have these properties.
pub(crate) fn types_with(
    memory: &vk::PhysicalDeviceMemoryProperties,
    properties: vk::MemoryPropertyFlags,
) -> u32 {
    memory
        .memory_types_as_slice()
        .iter()
        .enumerate()
        .filter(|(_, ty)| ty.property_flags.contains(properties))
        .fold(0, |set, (i, _)| set | 1 << i)
}

fn memory_property_names(flags: vk::MemoryPropertyFlags) -> Vec<String> {
    // Debug prints the set flags as `DEVICE_LOCAL | HOST_VISIBLE`.
    let printed = format!("{flags:?}").to_lowercase();
    printed.split(" | ").filter(|s| !s.is_empty()).map(str::to_owned).collect()
}

fn text(name: Result<&CStr, std::ffi::FromBytesUntilNulError>) -> String {
    name.map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lazy_types_are_found_by_their_flag() {
        let mut memory = vk::PhysicalDeviceMemoryProperties { memory_type_count: 3, ..Default::default() };
        let lazy = vk::MemoryPropertyFlags::LAZILY_ALLOCATED | vk::MemoryPropertyFlags::DEVICE_LOCAL;
        memory.memory_types[0].property_flags = vk::MemoryPropertyFlags::DEVICE_LOCAL;
        memory.memory_types[2].property_flags = lazy;
        // Beyond the count: must not be looked at.
        memory.memory_types[3].property_flags = lazy;
        assert_eq!(lazy_types(&memory), 0b100);
        assert_eq!(memory_property_names(lazy), ["device_local", "lazily_allocated"]);
        assert!(memory_property_names(vk::MemoryPropertyFlags::empty()).is_empty());
    }
}

//! Two-dimensional images with their memory and a view of the whole.

use super::memory::Memory;
use super::{Called, Device, MemoryUse, Owned};
use crate::{Error, Result};
use ash::vk;
use gpu_allocator::vulkan::AllocationScheme;

/// Whether the layers of an image are faces of cubes, six each, and how its view shows them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cubes {
    /// They are not.
    None,
    /// One cube.
    One,
    /// An array of cubes, also if it is one (feature `imageCubeArray`).
    Array,
}

/// What an [`Image`] is made from.
#[derive(Clone, Copy, Debug)]
pub struct ImageDesc<'a> {
    /// For debuggers and messages.
    pub name: &'a str,
    /// Texel format.
    pub format: vk::Format,
    /// Width and height, texels.
    pub size: [u32; 2],
    /// Mip levels, at least 1.
    pub levels: u32,
    /// Array layers, at least 1; more than one makes the view an array.
    pub layers: u32,
    /// Whether layers are faces of cubes.
    pub cubes: Cubes,
    /// Samples per texel.
    pub samples: vk::SampleCountFlags,
    /// Everything it is used for.
    pub usage: vk::ImageUsageFlags,
}

impl<'a> ImageDesc<'a> {
    /// One level, one layer, one sample.
    pub fn new(name: &'a str, format: vk::Format, size: [u32; 2], usage: vk::ImageUsageFlags) -> Self {
        Self {
            name,
            format,
            size,
            levels: 1,
            layers: 1,
            cubes: Cubes::None,
            samples: vk::SampleCountFlags::TYPE_1,
            usage,
        }
    }
}

/// An image of optimal tiling, its memory, and a view of all of it.
#[derive(Debug)]
pub struct Image {
    /// Absent if no usage is one that a view can serve.
    view: Option<Owned<vk::ImageView>>,
    raw: Owned<vk::Image>,
    memory: Memory,
    format: vk::Format,
    size: [u32; 2],
    levels: u32,
    layers: u32,
    cubes: Cubes,
    samples: vk::SampleCountFlags,
    usage: vk::ImageUsageFlags,
}

/// The usages of which a view needs at least one (VUID-VkImageViewCreateInfo-image-04441).
const VIEW_USAGES: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::SAMPLED.as_raw()
        | vk::ImageUsageFlags::STORAGE.as_raw()
        | vk::ImageUsageFlags::COLOR_ATTACHMENT.as_raw()
        | vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT.as_raw()
        | vk::ImageUsageFlags::INPUT_ATTACHMENT.as_raw()
        | vk::ImageUsageFlags::TRANSIENT_ATTACHMENT.as_raw(),
);

/// Drivers ask for dedicated memory for any attachment; below this size sharing a block is better.
const LEAST_PREFERRED_DEDICATED_BYTES: u64 = 1 << 20;

impl Image {
    /// Makes an image with undefined content, in layout UNDEFINED, in ordinary device memory.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device has no such images; [`Error::Vulkan`], e.g. when memory runs out.
    pub fn new(device: &Device, desc: &ImageDesc<'_>) -> Result<Self> {
        Self::with_memory(device, desc, false)
    }

    /// Makes an attachment whose content never outlives its render pass: TRANSIENT_ATTACHMENT usage, and
    /// lazily allocated memory where the device has it, so that a tiler need not back it by any memory.
    ///
    /// With `capture` it is an ordinary image with the same content: frame debuggers copy from images, which
    /// neither lazily allocated memory nor TRANSIENT_ATTACHMENT usage allows.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn transient(device: &Device, desc: &ImageDesc<'_>, capture: bool) -> Result<Self> {
        if capture {
            return Self::new(device, desc);
        }
        let usage = desc.usage | vk::ImageUsageFlags::TRANSIENT_ATTACHMENT;
        Self::with_memory(device, &ImageDesc { usage, ..*desc }, true)
    }

    fn with_memory(device: &Device, desc: &ImageDesc<'_>, lazy: bool) -> Result<Self> {
        check_support(device, desc)?;
        let info = vk::ImageCreateInfo::default()
            .flags(create_flags(desc))
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D { width: desc.size[0], height: desc.size[1], depth: 1 })
            .mip_levels(desc.levels)
            .array_layers(desc.layers)
            .samples(desc.samples)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(desc.usage);
        // SAFETY: `check_support` asked the device for exactly this.
        let raw = unsafe { device.create_image(&info, desc.name) }?;
        let memory = image_memory(device, raw.raw(), lazy, desc.name)?;
        let (block, offset) = memory.binding();
        // SAFETY: neither is bound yet, and the memory was allocated for this image.
        unsafe { device.raw().bind_image_memory(raw.raw(), block, offset) }.called("vkBindImageMemory")?;
        let mut image = Self {
            view: None,
            raw,
            memory,
            format: desc.format,
            size: desc.size,
            levels: desc.levels,
            layers: desc.layers,
            cubes: desc.cubes,
            samples: desc.samples,
            usage: desc.usage,
        };
        if desc.usage.intersects(VIEW_USAGES) {
            image.view = Some(image.create_view(0..desc.levels, desc.name)?);
        }
        Ok(image)
    }

    /// A view of some mip levels and all layers. Shaders see depth, not stencil, of a combined format's image
    /// only through a view of one aspect, so attachments get a view of both and all other uses one of depth.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn create_view(&self, levels: std::ops::Range<u32>, name: &str) -> Result<Owned<vk::ImageView>> {
        let attachment = self.usage.contains(vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT)
            && !self.usage.intersects(vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::INPUT_ATTACHMENT);
        let aspects = aspects(self.format);
        let aspect_mask = match aspects.contains(vk::ImageAspectFlags::DEPTH) && !attachment {
            true => vk::ImageAspectFlags::DEPTH,
            false => aspects,
        };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw())
            .view_type(match (self.cubes, self.layers) {
                (Cubes::One, _) => vk::ImageViewType::CUBE,
                (Cubes::Array, _) => vk::ImageViewType::CUBE_ARRAY,
                (Cubes::None, 1) => vk::ImageViewType::TYPE_2D,
                (Cubes::None, _) => vk::ImageViewType::TYPE_2D_ARRAY,
            })
            .format(self.format)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask,
                base_mip_level: levels.start,
                level_count: levels.end - levels.start,
                base_array_layer: 0,
                layer_count: self.layers,
            });
        // SAFETY: the image is alive and bound, and the format its own.
        unsafe { self.raw.device().create_image_view(&info, name) }
    }

    /// The handle, valid as long as this owner.
    pub fn raw(&self) -> vk::Image {
        self.raw.raw()
    }

    /// A view of all levels and layers; null if the usage is of transfers only.
    pub fn view(&self) -> vk::ImageView {
        self.view.as_ref().map_or(vk::ImageView::null(), Owned::raw)
    }

    /// Texel format.
    pub fn format(&self) -> vk::Format {
        self.format
    }

    /// Width and height of level 0, texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Mip levels.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Array layers.
    pub fn layers(&self) -> u32 {
        self.layers
    }

    /// Samples per texel.
    pub fn samples(&self) -> vk::SampleCountFlags {
        self.samples
    }

    /// What it is used for, TRANSIENT_ATTACHMENT included.
    pub fn usage(&self) -> vk::ImageUsageFlags {
        self.usage
    }

    /// All of it, for barriers.
    pub fn range(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask: aspects(self.format),
            base_mip_level: 0,
            level_count: self.levels,
            base_array_layer: 0,
            layer_count: self.layers,
        }
    }

    /// The size of the memory behind it, whether committed or not.
    pub fn allocated_bytes(&self) -> u64 {
        self.memory.bytes()
    }

    /// What the driver has committed to lazily allocated memory so far (vkGetDeviceMemoryCommitment); `None`
    /// for ordinary memory, which is committed in full.
    pub fn committed_bytes(&self) -> Option<u64> {
        self.memory.committed_bytes()
    }
}

fn image_memory(device: &Device, image: vk::Image, lazy: bool, name: &str) -> Result<Memory> {
    let mut dedicated = vk::MemoryDedicatedRequirements::default();
    let mut requirements = vk::MemoryRequirements2::default().push_next(&mut dedicated);
    let info = vk::ImageMemoryRequirementsInfo2::default().image(image);
    // SAFETY: the image is alive, and the device of Vulkan 1.1.
    unsafe { device.raw().get_image_memory_requirements2(&info, &mut requirements) };
    let requirements = requirements.memory_requirements;
    let required = dedicated.requires_dedicated_allocation == vk::TRUE;
    let preferred = dedicated.prefers_dedicated_allocation == vk::TRUE
        && requirements.size >= LEAST_PREFERRED_DEDICATED_BYTES;
    if lazy && let Some(memory) = Memory::lazy(device, requirements, required.then_some(image), name)? {
        return Ok(memory);
    }
    let scheme = (required || preferred).then_some(AllocationScheme::DedicatedImage(image));
    Memory::new(device, requirements, MemoryUse::Device, false, scheme, name)
}

/// Fails, with the device's own limits, for an image that must not even be asked for.
fn check_support(device: &Device, desc: &ImageDesc<'_>) -> Result<()> {
    let [width, height] = desc.size;
    let what = || format!("image '{}' ({width}x{height}, {:?}, {:?})", desc.name, desc.format, desc.usage);
    let unsupported = || {
        Error::unsupported(
            format!("{} is of a format that the device does not support for this use", what()),
            "choose another format or device",
        )
    };
    let (instance, physical_device) = (device.instance(), device.physical_device());
    // Asked first, because the second question about a format without support is an error in itself.
    // SAFETY: the physical device is alive.
    let properties = unsafe { instance.get_physical_device_format_properties(physical_device, desc.format) };
    if !properties.optimal_tiling_features.contains(features_for(desc.usage)) {
        return Err(unsupported());
    }
    // SAFETY: as above.
    let limits = unsafe {
        instance.get_physical_device_image_format_properties(
            physical_device,
            desc.format,
            vk::ImageType::TYPE_2D,
            vk::ImageTiling::OPTIMAL,
            desc.usage,
            create_flags(desc),
        )
    };
    let limits = match limits {
        Err(vk::Result::ERROR_FORMAT_NOT_SUPPORTED) => return Err(unsupported()),
        other => other.called("vkGetPhysicalDeviceImageFormatProperties")?,
    };
    // The least that it can take; unknown formats count as nothing.
    let bytes =
        [width, height, desc.layers, desc.samples.as_raw(), super::texel_bytes(desc.format).unwrap_or(0)]
            .into_iter()
            .map(u64::from)
            .fold(1, u64::saturating_mul);
    let max = limits.max_extent;
    let fits = (1..=max.width).contains(&width)
        && (1..=max.height).contains(&height)
        && (1..=limits.max_mip_levels).contains(&desc.levels)
        && (1..=limits.max_array_layers).contains(&desc.layers)
        && limits.sample_counts.contains(desc.samples)
        && bytes <= limits.max_resource_size;
    if fits {
        return Ok(());
    }
    Err(Error::unsupported(
        format!(
            "{}, {} levels, {} layers, {:?} samples: beyond the device's limits",
            what(),
            desc.levels,
            desc.layers,
            desc.samples
        ),
        format!(
            "stay within 1x1 to {}x{}, {} levels, {} layers, {:?} samples, {} bytes",
            max.width,
            max.height,
            limits.max_mip_levels,
            limits.max_array_layers,
            limits.sample_counts,
            limits.max_resource_size
        ),
    ))
}

fn create_flags(desc: &ImageDesc<'_>) -> vk::ImageCreateFlags {
    match desc.cubes {
        Cubes::None => vk::ImageCreateFlags::empty(),
        Cubes::One | Cubes::Array => vk::ImageCreateFlags::CUBE_COMPATIBLE,
    }
}

/// What a format must support to be used like this (Vulkan 1.3, 48.1.1, "Potential Format Features").
fn features_for(usage: vk::ImageUsageFlags) -> vk::FormatFeatureFlags {
    use vk::{FormatFeatureFlags as F, ImageUsageFlags as U};
    let table = [
        (U::SAMPLED, F::SAMPLED_IMAGE),
        (U::STORAGE, F::STORAGE_IMAGE),
        (U::COLOR_ATTACHMENT, F::COLOR_ATTACHMENT),
        (U::DEPTH_STENCIL_ATTACHMENT, F::DEPTH_STENCIL_ATTACHMENT),
        (U::TRANSFER_SRC, F::TRANSFER_SRC),
        (U::TRANSFER_DST, F::TRANSFER_DST),
    ];
    table.iter().filter(|(u, _)| usage.contains(*u)).fold(F::empty(), |all, (_, f)| all | *f)
}

/// The aspects of a format.
pub(crate) fn aspects(format: vk::Format) -> vk::ImageAspectFlags {
    use vk::{Format as F, ImageAspectFlags as A};
    match format {
        F::D16_UNORM | F::X8_D24_UNORM_PACK32 | F::D32_SFLOAT => A::DEPTH,
        F::S8_UINT => A::STENCIL,
        F::D16_UNORM_S8_UINT | F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => A::DEPTH | A::STENCIL,
        _ => A::COLOR,
    }
}

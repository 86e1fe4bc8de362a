//! From images of the GPU to host memory.

use super::image::aspects;
use super::{Buffer, BufferDesc, Device, Image, MemoryUse, Recorder};
use crate::{Error, Result};
use ash::vk;

/// A mapped buffer that receives one level of an image, rows tightly packed from the top.
#[derive(Debug)]
pub struct Readback {
    buffer: Buffer,
    size: [u32; 2],
    format: vk::Format,
}

impl Readback {
    /// Makes room for an image of this format and size (texels).
    ///
    /// # Errors
    /// [`Error::Unsupported`] for formats that [`texel_bytes`] does not know; [`Error::Vulkan`].
    pub fn new(device: &Device, format: vk::Format, size: [u32; 2]) -> Result<Self> {
        let bytes = u64::from(texel_bytes(format)?) * u64::from(size[0]) * u64::from(size[1]);
        let buffer = Buffer::new(
            device,
            &BufferDesc {
                name: "readback",
                bytes,
                usage: vk::BufferUsageFlags::TRANSFER_DST,
                memory: MemoryUse::Readback,
            },
        )?;
        Ok(Self { buffer, size, format })
    }

    /// Records the copy of one mip level of an image's first layer. It waits for all that writes attachments
    /// or copies, takes the image from layout `from` and leaves it in `to`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the image's format or the level's size is another than this was made for, or
    /// the image lacks the usage TRANSFER_SRC.
    pub fn record(
        &self,
        recorder: &Recorder<'_>,
        image: &Image,
        level: u32,
        from: vk::ImageLayout,
        to: vk::ImageLayout,
    ) -> Result<()> {
        let size = image.size().map(|n| n.checked_shr(level).unwrap_or(0).max(1));
        let agrees = image.format() == self.format && size == self.size && level < image.levels();
        if !agrees || !image.usage().contains(vk::ImageUsageFlags::TRANSFER_SRC) {
            return Err(Error::unsupported(
                format!(
                    "level {level} of a {:?} image of {:?} texels with usage {:?} cannot be read back as {:?} of {:?}",
                    image.format(),
                    image.size(),
                    image.usage(),
                    self.format,
                    self.size
                ),
                "make the readback for this format and size, and the image with the usage TRANSFER_SRC",
            ));
        }
        let range = vk::ImageSubresourceRange {
            base_mip_level: level,
            level_count: 1,
            layer_count: 1,
            ..image.range()
        };
        self.record_raw(recorder, image.raw(), range, (from, to));
        Ok(())
    }

    /// As [`Self::record`], of one level of an image with the usage TRANSFER_SRC that is of this format and size.
    pub(super) fn record_raw(
        &self,
        recorder: &Recorder<'_>,
        image: vk::Image,
        range: vk::ImageSubresourceRange,
        (from, to): (vk::ImageLayout, vk::ImageLayout),
    ) {
        let size = self.size;
        let _label = recorder.label("readback");
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let source_layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        let barrier = |from, to, src, dst| {
            vk::ImageMemoryBarrier::default()
                .src_access_mask(src)
                .dst_access_mask(dst)
                .old_layout(from)
                .new_layout(to)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(image)
                .subresource_range(range)
        };
        let before = barrier(from, source_layout, access_in(from), vk::AccessFlags::TRANSFER_READ);
        let after = barrier(source_layout, to, vk::AccessFlags::empty(), access_in(to));
        let after = if to == source_layout { &[][..] } else { &[after] };
        let to_host = vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ);
        let region = vk::BufferImageCopy {
            image_subresource: vk::ImageSubresourceLayers {
                // One aspect a copy: depth of combined formats.
                aspect_mask: match aspects(self.format) {
                    all if all.contains(vk::ImageAspectFlags::DEPTH) => vk::ImageAspectFlags::DEPTH,
                    all => all,
                },
                mip_level: range.base_mip_level,
                base_array_layer: 0,
                layer_count: 1,
            },
            image_extent: vk::Extent3D { width: size[0], height: size[1], depth: 1 },
            ..Default::default()
        };
        let none = vk::DependencyFlags::empty();
        let copy = vk::PipelineStageFlags::TRANSFER;
        // SAFETY: recording, outside of a render pass; the region lies in the image, the buffer was made for it.
        unsafe {
            device.cmd_pipeline_barrier(raw, WRITERS, copy, none, &[], &[], &[before]);
            device.cmd_copy_image_to_buffer(raw, image, source_layout, self.buffer.raw(), &[region]);
            let later = vk::PipelineStageFlags::HOST | WRITERS;
            device.cmd_pipeline_barrier(raw, copy, later, none, &[to_host], &[], after);
        }
    }

    /// The texels, once the copy has been executed and waited for: `height` rows of `width` texels.
    pub fn texels(&self) -> &[u8] {
        self.buffer.mapped()
    }

    /// Width and height, texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The texels' format.
    pub fn format(&self) -> vk::Format {
        self.format
    }
}

/// All stages that write images, or read what a layout transition must not overtake.
const WRITERS: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT.as_raw()
        | vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS.as_raw()
        | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS.as_raw()
        | vk::PipelineStageFlags::FRAGMENT_SHADER.as_raw()
        | vk::PipelineStageFlags::TRANSFER.as_raw(),
);

/// What those stages may do to an image in this layout.
fn access_in(layout: vk::ImageLayout) -> vk::AccessFlags {
    use vk::{AccessFlags as A, ImageLayout as L};
    match layout {
        L::COLOR_ATTACHMENT_OPTIMAL => A::COLOR_ATTACHMENT_READ | A::COLOR_ATTACHMENT_WRITE,
        L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL => {
            A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE
        }
        L::DEPTH_STENCIL_READ_ONLY_OPTIMAL => A::DEPTH_STENCIL_ATTACHMENT_READ | A::SHADER_READ,
        L::SHADER_READ_ONLY_OPTIMAL => A::SHADER_READ,
        L::TRANSFER_SRC_OPTIMAL => A::TRANSFER_READ,
        L::TRANSFER_DST_OPTIMAL => A::TRANSFER_WRITE,
        L::GENERAL => {
            A::COLOR_ATTACHMENT_WRITE | A::DEPTH_STENCIL_ATTACHMENT_WRITE | A::TRANSFER_WRITE | A::SHADER_READ
        }
        // Presentation is ordered by semaphores, and an undefined content by nothing.
        _ => A::empty(),
    }
}

/// The size of one texel in a tightly packed copy of the format's first aspect.
///
/// # Errors
/// [`Error::Unsupported`] for a format that this crate does not use.
pub fn texel_bytes(format: vk::Format) -> Result<u32> {
    use vk::Format as F;
    Ok(match format {
        F::R8_UNORM | F::R8_UINT | F::S8_UINT => 1,
        F::R8G8_UNORM | F::R16_SFLOAT | F::R16_UNORM | F::R16_UINT | F::D16_UNORM => 2,
        F::R8G8B8A8_UNORM
        | F::R8G8B8A8_SRGB
        | F::R8G8B8A8_UINT
        | F::B8G8R8A8_UNORM
        | F::B8G8R8A8_SRGB
        | F::A2B10G10R10_UNORM_PACK32
        | F::A2R10G10B10_UNORM_PACK32
        | F::B10G11R11_UFLOAT_PACK32
        | F::E5B9G9R9_UFLOAT_PACK32
        | F::R16G16_SFLOAT
        | F::R16G16_UNORM
        | F::R32_SFLOAT
        | F::R32_UINT
        | F::D32_SFLOAT
        | F::D32_SFLOAT_S8_UINT
        | F::D24_UNORM_S8_UINT
        | F::X8_D24_UNORM_PACK32 => 4,
        F::R16G16B16A16_SFLOAT | F::R16G16B16A16_UNORM | F::R32G32_SFLOAT | F::R32G32_UINT => 8,
        F::R32G32B32_SFLOAT => 12,
        F::R32G32B32A32_SFLOAT | F::R32G32B32A32_UINT => 16,
        other => {
            return Err(Error::unsupported(
                format!("texels of format {other:?} cannot be copied"),
                "use one of the formats of the layouts and outputs",
            ));
        }
    })
}

//! The globe maps of a scene on the device.

use ash::vk;

use super::around::edge_sampler;
use super::descriptor::Content;
use super::{Device, Image, ImageDesc, Owned, Upload};
use crate::Result;
use crate::scene::GlobeLayers;

/// One array of pictures, and how it is sampled: linearly, edges going on.
pub(super) struct GlobeMaps {
    /// An array even of one layer.
    view: Owned<vk::ImageView>,
    sampler: Owned<vk::Sampler>,
    image: Image,
}

impl GlobeMaps {
    pub(super) fn new(device: &Device, upload: &mut Upload, layers: &GlobeLayers) -> Result<Self> {
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let format = vk::Format::R8G8B8A8_SRGB;
        let desc = ImageDesc {
            layers: layers.count(),
            ..ImageDesc::new("globe maps", format, [layers.side; 2], usage)
        };
        let image = Image::new(device, &desc)?;
        upload.image(&image, &[&layers.texels])?;
        let info = vk::ImageViewCreateInfo::default()
            .image(image.raw())
            .view_type(vk::ImageViewType::TYPE_2D_ARRAY)
            .format(format)
            .subresource_range(image.range());
        // SAFETY: the image is alive and bound, and format and range are its own.
        let view = unsafe { device.create_image_view(&info, "globe maps") }?;
        Ok(Self { view, sampler: edge_sampler(device, "globe maps")?, image })
    }

    /// What the binding is written with.
    pub(super) fn content(&self) -> Content<'static> {
        let info = vk::DescriptorImageInfo::default()
            .image_view(self.view.raw())
            .sampler(self.sampler.raw())
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        Content::Images(vec![info])
    }

    /// Device memory of the pictures.
    pub(super) fn allocated_bytes(&self) -> u64 {
        self.image.allocated_bytes()
    }
}

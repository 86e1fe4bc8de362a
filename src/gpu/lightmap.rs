//! The scene's lightmap on the GPU.

use ash::vk;

use super::{Device, Image, ImageDesc, SamplerCache, Upload};
use crate::scene::{Lightmap, Sampler, Wrap};
use crate::{Error, Result};

/// Colour and scale of [`Lightmap`], as stored: R8G8B8A8_UNORM and R8_UNORM, one level each, sampled bilinearly.
pub(super) struct LightmapTextures {
    images: [Image; 2],
    samplers: SamplerCache,
}

impl LightmapTextures {
    /// Makes the images and gathers their content in `upload`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the map's lists do not fit its size, or the device has no images of that size;
    /// [`Error::Vulkan`].
    pub(super) fn new(device: &Device, upload: &mut Upload, map: &Lightmap) -> Result<Self> {
        let size = [map.width, map.height];
        let texels = map.width as usize * map.height as usize;
        if texels == 0 || map.color_rgba8.len() != texels * 4 || map.scale8.len() != texels {
            return Err(Error::unsupported(
                format!(
                    "the lightmap has {} and {} bytes for {}x{} texels",
                    map.color_rgba8.len(),
                    map.scale8.len(),
                    size[0],
                    size[1]
                ),
                "give four bytes of colour and one of scale a texel",
            ));
        }
        let mut image = |name, format, content: &[u8]| -> Result<Image> {
            let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
            let image = Image::new(device, &ImageDesc::new(name, format, size, usage))?;
            upload.image(&image, &[content])?;
            Ok(image)
        };
        Ok(Self {
            images: [
                image("lightmap colour", vk::Format::R8G8B8A8_UNORM, &map.color_rgba8)?,
                image("lightmap scale", vk::Format::R8_UNORM, &map.scale8)?,
            ],
            samplers: SamplerCache::new(device),
        })
    }

    /// Colour, then scale, in layout SHADER_READ_ONLY_OPTIMAL.
    pub(super) fn descriptors(&mut self) -> Result<[vk::DescriptorImageInfo; 2]> {
        let (wrap_u, wrap_v) = (Wrap::ClampToEdge, Wrap::ClampToEdge);
        let sampler = self.samplers.get(Sampler { mip_linear: None, wrap_u, wrap_v, ..Sampler::default() })?;
        Ok([0, 1].map(|i| {
            vk::DescriptorImageInfo::default()
                .image_view(self.images[i].view())
                .sampler(sampler)
                .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
        }))
    }

    /// Size of the memory.
    pub(super) fn allocated_bytes(&self) -> u64 {
        self.images.iter().map(Image::allocated_bytes).sum()
    }
}

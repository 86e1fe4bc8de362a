//! From host memory to buffers and images of the GPU.

use super::image::aspects;
use super::readback::texel_bytes;
use super::{Buffer, BufferDesc, Device, Image, MemoryUse, Recorder, conv};
use crate::scene::TextureFormat;
use crate::{Error, Result};
use ash::vk;

/// Gathers contents in staging memory, then records their copies into a command buffer.
///
/// It must live until the GPU has executed what was recorded; then drop it, which frees the staging memory.
/// The buffers and images that it fills must be alive when the commands run.
#[derive(Debug)]
pub struct Upload {
    device: Device,
    chunks: Vec<Buffer>,
    /// Bytes used of the last chunk.
    used: u64,
    buffer_copies: Vec<BufferCopy>,
    image_copies: Vec<ImageCopy>,
    /// Images that become readable, each once.
    images: Vec<(vk::Image, vk::ImageSubresourceRange)>,
    /// Copied to, though nothing else needs them any more.
    kept: Vec<Image>,
    /// What the buffers are used for.
    buffer_usage: vk::BufferUsageFlags,
}

#[derive(Debug)]
struct BufferCopy {
    chunk: usize,
    target: vk::Buffer,
    region: vk::BufferCopy,
}

#[derive(Debug)]
struct ImageCopy {
    chunk: usize,
    target: vk::Image,
    region: vk::BufferImageCopy,
}

/// Staging memory comes in pieces of this size; larger contents are cut up.
const CHUNK_BYTES: u64 = 8 << 20;

/// A multiple of all texel sizes (up to 16 bytes) and of the 4 that copies demand.
const COPY_ALIGNMENT: u64 = 16;

impl Upload {
    /// An empty upload.
    pub fn new(device: &Device) -> Self {
        Self {
            device: device.clone(),
            chunks: Vec::new(),
            used: 0,
            buffer_copies: Vec::new(),
            image_copies: Vec::new(),
            images: Vec::new(),
            kept: Vec::new(),
            buffer_usage: vk::BufferUsageFlags::empty(),
        }
    }

    /// Fills a part of a buffer. Parts given before one [`Self::record`] must not overlap.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it does not fit or the buffer is no transfer target; [`Error::Vulkan`]
    /// without staging memory.
    pub fn buffer(&mut self, target: &Buffer, offset_bytes: u64, content: &[u8]) -> Result<()> {
        let end = offset_bytes.checked_add(content.len() as u64);
        let fits = end.is_some_and(|end| end <= target.size_bytes());
        if !fits || !target.usage().contains(vk::BufferUsageFlags::TRANSFER_DST) {
            return Err(Error::unsupported(
                format!(
                    "{} bytes at {offset_bytes} cannot be copied to a buffer of {} bytes with usage {:?}",
                    content.len(),
                    target.size_bytes(),
                    target.usage()
                ),
                "make the buffer larger, or give it the usage TRANSFER_DST",
            ));
        }
        let mut offset = offset_bytes;
        for piece in content.chunks(CHUNK_BYTES as usize) {
            let (chunk, src_offset) = self.stage(piece)?;
            let region = vk::BufferCopy { src_offset, dst_offset: offset, size: piece.len() as u64 };
            self.buffer_copies.push(BufferCopy { chunk, target: target.raw(), region });
            offset += piece.len() as u64;
        }
        self.buffer_usage |= target.usage();
        Ok(())
    }

    /// Fills all mip levels of an image, level 0 first, in each all layers, rows of texels or blocks tightly packed; the image
    /// becomes SHADER_READ_ONLY_OPTIMAL. What it held before is lost.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if levels or sizes are not the image's; [`Error::Vulkan`] without staging
    /// memory.
    pub fn image(&mut self, target: &Image, levels: &[impl AsRef<[u8]>]) -> Result<()> {
        let Block { size: block, bytes } = Block::of(target.format())?;
        let size = |level: u32| target.size().map(|n| (n >> level).max(1));
        let blocks = |level| {
            let [width, height] = size(level);
            [width.div_ceil(block[0]), height.div_ceil(block[1])]
        };
        let layer_bytes = |level| blocks(level).iter().map(|&n| u64::from(n)).product::<u64>() * bytes;
        let layers = u64::from(target.layers());
        let levels: Vec<&[u8]> = levels.iter().map(AsRef::as_ref).collect();
        let sizes_agree = levels.len() == target.levels() as usize
            && (0..).zip(&levels).all(|(level, content)| content.len() as u64 == layer_bytes(level) * layers);
        if !sizes_agree || !target.usage().contains(vk::ImageUsageFlags::TRANSFER_DST) {
            return Err(Error::unsupported(
                format!(
                    "{} mip levels of {:?} bytes cannot be copied to a {:?} image of {:?} texels, {} levels and {} layers with usage {:?}",
                    levels.len(),
                    levels.iter().map(|l| l.len()).collect::<Vec<_>>(),
                    target.format(),
                    target.size(),
                    target.levels(),
                    target.layers(),
                    target.usage()
                ),
                "give every level in full, and the image the usage TRANSFER_DST",
            ));
        }
        for (level, content) in (0..).zip(&levels) {
            let ([width, height], [across, down]) = (size(level), blocks(level));
            let row_bytes = u64::from(across) * bytes;
            // A row of the largest image (2^15 texels of 16 bytes) fits into a chunk many times.
            let rows_per_piece = (CHUNK_BYTES / row_bytes).clamp(1, u64::from(down));
            for (layer, content) in (0..).zip(content.chunks(layer_bytes(level) as usize)) {
                let mut y = 0;
                for piece in content.chunks((rows_per_piece * row_bytes) as usize) {
                    let rows = (piece.len() as u64 / row_bytes) as u32 * block[1];
                    let (chunk, buffer_offset) = self.stage(piece)?;
                    let region = vk::BufferImageCopy {
                        buffer_offset,
                        buffer_row_length: 0,
                        buffer_image_height: 0,
                        image_subresource: vk::ImageSubresourceLayers {
                            aspect_mask: aspects(target.format()),
                            mip_level: level,
                            base_array_layer: layer,
                            layer_count: 1,
                        },
                        image_offset: vk::Offset3D { x: 0, y: y as i32, z: 0 },
                        // The last row of blocks may reach beyond the level.
                        image_extent: vk::Extent3D { width, height: rows.min(height - y), depth: 1 },
                    };
                    self.image_copies.push(ImageCopy { chunk, target: target.raw(), region });
                    y += rows;
                }
            }
        }
        self.images.push((target.raw(), target.range()));
        Ok(())
    }

    /// The size of the staging memory in use.
    pub fn staged_bytes(&self) -> u64 {
        self.chunks.iter().map(Buffer::size_bytes).sum()
    }

    /// Keeps an image that is copied to until the copies have finished, which is when this is dropped.
    pub(super) fn keep(&mut self, image: Image) {
        self.kept.push(image);
    }

    /// Records the copies gathered so far, with the barriers around them: earlier reads of the buffers and
    /// images are waited for, and later vertex, index, indirect and shader reads (as their usage allows) see
    /// the new content.
    ///
    /// Further contents may be gathered and recorded afterwards.
    pub fn record(&mut self, recorder: &Recorder<'_>) {
        if self.buffer_copies.is_empty() && self.image_copies.is_empty() {
            return;
        }
        let _label = recorder.label("upload");
        let (stages, access) = self.readers();
        // Writes after reads need the order of execution only; writes after earlier copies also visibility.
        self.barrier(
            recorder,
            (stages | vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE),
            (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE),
            (vk::ImageLayout::UNDEFINED, vk::ImageLayout::TRANSFER_DST_OPTIMAL),
        );
        self.copy(recorder);
        self.barrier(
            recorder,
            (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE),
            (stages, access),
            (vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL),
        );
        self.buffer_copies.clear();
        self.image_copies.clear();
        self.images.clear();
        self.buffer_usage = vk::BufferUsageFlags::empty();
    }

    fn copy(&self, recorder: &Recorder<'_>) {
        let (raw, device) = (recorder.raw(), self.device.raw());
        for copy in &self.buffer_copies {
            let source = self.chunks[copy.chunk].raw();
            // SAFETY: the region was checked against both buffers when it was gathered; the caller keeps the target
            // alive, this owner the source.
            unsafe { device.cmd_copy_buffer(raw, source, copy.target, &[copy.region]) };
        }
        for copy in &self.image_copies {
            let source = self.chunks[copy.chunk].raw();
            let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
            // SAFETY: as above; `record` moved the image to this layout.
            unsafe { device.cmd_copy_buffer_to_image(raw, source, copy.target, layout, &[copy.region]) };
        }
    }

    fn barrier(
        &self,
        recorder: &Recorder<'_>,
        (src_stages, src_access): (vk::PipelineStageFlags, vk::AccessFlags),
        (dst_stages, dst_access): (vk::PipelineStageFlags, vk::AccessFlags),
        (old_layout, new_layout): (vk::ImageLayout, vk::ImageLayout),
    ) {
        let images: Vec<_> = self
            .images
            .iter()
            .map(|&(image, range)| {
                vk::ImageMemoryBarrier::default()
                    .src_access_mask(src_access)
                    .dst_access_mask(dst_access & !BUFFER_ACCESS)
                    .old_layout(old_layout)
                    .new_layout(new_layout)
                    .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .image(image)
                    .subresource_range(range)
            })
            .collect();
        let all = [vk::MemoryBarrier::default().src_access_mask(src_access).dst_access_mask(dst_access)];
        let memory = if self.buffer_copies.is_empty() { &[] } else { &all[..] };
        // SAFETY: recording, outside of a render pass; the images are alive.
        unsafe {
            self.device.raw().cmd_pipeline_barrier(
                recorder.raw(),
                src_stages,
                dst_stages,
                vk::DependencyFlags::empty(),
                memory,
                &[],
                &images,
            );
        }
    }

    /// The stages and accesses that may read what is uploaded.
    fn readers(&self) -> (vk::PipelineStageFlags, vk::AccessFlags) {
        let (mut stages, mut access) = readers_of(self.buffer_usage);
        if !self.images.is_empty() {
            stages |= SHADERS;
            access |= vk::AccessFlags::SHADER_READ;
        }
        (stages, access)
    }

    /// Copies into staging memory: the chunk's index and the offset in it.
    fn stage(&mut self, content: &[u8]) -> Result<(usize, u64)> {
        let alignment = COPY_ALIGNMENT.max(self.device.caps().optimal_buffer_copy_offset_alignment);
        let offset = self.used.next_multiple_of(alignment);
        let bytes = content.len() as u64;
        let fits = self.chunks.last().is_some_and(|c| offset + bytes <= c.size_bytes());
        let offset = if fits {
            offset
        } else {
            self.chunks.push(Buffer::new(
                &self.device,
                &BufferDesc {
                    name: "upload staging",
                    bytes: bytes.max(CHUNK_BYTES),
                    usage: vk::BufferUsageFlags::TRANSFER_SRC,
                    memory: MemoryUse::Upload,
                },
            )?);
            0
        };
        let chunk = self.chunks.len() - 1;
        let place = offset as usize..(offset + bytes) as usize;
        self.chunks[chunk].mapped_mut()[place].copy_from_slice(content);
        self.used = offset + bytes;
        Ok((chunk, offset))
    }
}

/// What a format's content is made of.
struct Block {
    /// Texels, across and down.
    size: [u32; 2],
    bytes: u64,
}

impl Block {
    fn of(format: vk::Format) -> Result<Self> {
        let texture = TextureFormat::COMPRESSED.into_iter().find(|&compressed| {
            [false, true].into_iter().any(|srgb| conv::texture_format(compressed, srgb) == format)
        });
        Ok(match texture {
            Some(texture) => Self { size: texture.block(), bytes: texture.block_bytes().into() },
            None => Self { size: [1, 1], bytes: texel_bytes(format)?.into() },
        })
    }
}

/// The shader stages of this renderer.
const SHADERS: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::VERTEX_SHADER.as_raw() | vk::PipelineStageFlags::FRAGMENT_SHADER.as_raw(),
);

/// Accesses that only buffers have.
const BUFFER_ACCESS: vk::AccessFlags = vk::AccessFlags::from_raw(
    vk::AccessFlags::VERTEX_ATTRIBUTE_READ.as_raw()
        | vk::AccessFlags::INDEX_READ.as_raw()
        | vk::AccessFlags::INDIRECT_COMMAND_READ.as_raw()
        | vk::AccessFlags::UNIFORM_READ.as_raw()
        | vk::AccessFlags::TRANSFER_READ.as_raw(),
);

/// The stages and accesses that read buffers of this usage.
fn readers_of(usage: vk::BufferUsageFlags) -> (vk::PipelineStageFlags, vk::AccessFlags) {
    use vk::{AccessFlags as A, BufferUsageFlags as U, PipelineStageFlags as S};
    let table = [
        (U::VERTEX_BUFFER, S::VERTEX_INPUT, A::VERTEX_ATTRIBUTE_READ),
        (U::INDEX_BUFFER, S::VERTEX_INPUT, A::INDEX_READ),
        (U::INDIRECT_BUFFER, S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ),
        (U::UNIFORM_BUFFER, SHADERS, A::UNIFORM_READ),
        (U::STORAGE_BUFFER, SHADERS, A::SHADER_READ),
        (U::TRANSFER_SRC, S::TRANSFER, A::TRANSFER_READ),
    ];
    // A buffer that nothing reads still gets a valid barrier.
    let nothing = (S::TRANSFER, A::empty());
    let used = table.iter().filter(|(u, ..)| usage.contains(*u));
    used.map(|&(_, s, a)| (s, a)).reduce(|x, y| (x.0 | y.0, x.1 | y.1)).unwrap_or(nothing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_follow_from_usage() {
        use vk::{AccessFlags as A, BufferUsageFlags as U, PipelineStageFlags as S};
        assert_eq!(readers_of(U::TRANSFER_DST), (S::TRANSFER, A::empty()));
        assert_eq!(
            readers_of(U::TRANSFER_DST | U::VERTEX_BUFFER | U::INDEX_BUFFER),
            (S::VERTEX_INPUT, A::VERTEX_ATTRIBUTE_READ | A::INDEX_READ)
        );
        assert_eq!(readers_of(U::STORAGE_BUFFER), (S::VERTEX_SHADER | S::FRAGMENT_SHADER, A::SHADER_READ));
    }
}

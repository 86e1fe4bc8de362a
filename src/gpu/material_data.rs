//! The numbers of a scene's materials on the device.

use ash::vk;

use super::descriptor::Content;
use super::shared::MaterialData;
use super::{Buffer, BufferDesc, Device, MemoryUse, Upload, convert};
use crate::Result;
use crate::scene::Scene;

/// All materials' uniform blocks in one buffer.
pub(super) struct Materials {
    buffer: Buffer,
    /// From one block to the next: the block's size, rounded up to what the device aligns blocks to.
    stride_bytes: u64,
}

impl Materials {
    /// `None` without materials.
    pub(super) fn new(device: &Device, upload: &mut Upload, scene: &Scene) -> Result<Option<Self>> {
        if scene.materials.is_empty() {
            return Ok(None);
        }
        let alignment = device.caps().min_uniform_buffer_offset_alignment.max(1);
        let stride_bytes = (size_of::<MaterialData>() as u64).next_multiple_of(alignment);
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let bytes = stride_bytes * scene.materials.len() as u64;
        let desc = BufferDesc { name: "materials", bytes, usage, memory: MemoryUse::Device };
        let buffer = Buffer::new(device, &desc)?;
        let mut content = vec![0; bytes as usize];
        for (block, material) in content.chunks_exact_mut(stride_bytes as usize).zip(&scene.materials) {
            let data = convert::material(material);
            block[..size_of::<MaterialData>()].copy_from_slice(bytemuck::bytes_of(&data));
        }
        upload.buffer(&buffer, 0, &content)?;
        Ok(Some(Self { buffer, stride_bytes }))
    }

    /// A material's block, to write a descriptor with.
    pub(super) fn content(&self, material: usize) -> Content<'_> {
        Content::Buffer(&self.buffer, self.stride_bytes * material as u64, size_of::<MaterialData>() as u64)
    }

    /// Device memory of the buffer.
    pub(super) fn allocated_bytes(&self) -> u64 {
        self.buffer.allocated_bytes()
    }
}

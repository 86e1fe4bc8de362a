//! The numbers of a scene's materials on the device.

use std::collections::BTreeSet;

use ash::vk;

use super::descriptor::Content;
use super::shared::MaterialData;
use super::{Buffer, BufferDesc, Device, MemoryUse, Upload, convert};
use crate::Result;
use crate::scene::Scene;

/// The uniform blocks of materials that are drawn, in one buffer.
pub(super) struct Materials {
    buffer: Buffer,
    /// Index into `Scene::materials`, in the order of blocks.
    materials: Vec<usize>,
    /// From one block to the next: the block's size, rounded up to what the device aligns blocks to.
    stride_bytes: u64,
}

impl Materials {
    /// Of these materials of the scene; `None` if there are none.
    pub(super) fn new(
        device: &Device,
        upload: &mut Upload,
        scene: &Scene,
        materials: &BTreeSet<usize>,
    ) -> Result<Option<Self>> {
        if materials.is_empty() {
            return Ok(None);
        }
        let alignment = device.caps().min_uniform_buffer_offset_alignment.max(1);
        let stride_bytes = (size_of::<MaterialData>() as u64).next_multiple_of(alignment);
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let bytes = stride_bytes * materials.len() as u64;
        let desc = BufferDesc { name: "materials", bytes, usage, memory: MemoryUse::Device };
        let buffer = Buffer::new(device, &desc)?;
        let mut content = vec![0; bytes as usize];
        for (block, &material) in content.chunks_exact_mut(stride_bytes as usize).zip(materials) {
            let data = convert::material(&scene.materials[material]);
            block[..size_of::<MaterialData>()].copy_from_slice(bytemuck::bytes_of(&data));
        }
        upload.buffer(&buffer, 0, &content)?;
        Ok(Some(Self { buffer, materials: materials.iter().copied().collect(), stride_bytes }))
    }

    /// A drawn material's block, to write a descriptor with.
    pub(super) fn content(&self, material: usize) -> Content<'_> {
        let block = self.materials.binary_search(&material).expect("only what is drawn has descriptors");
        Content::Buffer(&self.buffer, self.stride_bytes * block as u64, size_of::<MaterialData>() as u64)
    }

    /// Device memory of the buffer.
    pub(super) fn allocated_bytes(&self) -> u64 {
        self.buffer.allocated_bytes()
    }
}

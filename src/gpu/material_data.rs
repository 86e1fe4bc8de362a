//! The numbers of a scene's materials on the device.

use std::collections::BTreeSet;
use std::marker::PhantomData;

use ash::vk;
use bytemuck::Pod;

use super::descriptor::Content;
use super::{Buffer, BufferDesc, Device, MemoryUse, Upload};
use crate::Result;

/// Uniform blocks of materials that are drawn, in one buffer.
pub(super) struct Blocks<T> {
    buffer: Buffer,
    /// Index into `Scene::materials`, in the order of blocks.
    materials: Vec<usize>,
    /// From one block to the next: the block's size, rounded up to what the device aligns blocks to.
    stride_bytes: u64,
    of: PhantomData<T>,
}

impl<T: Pod> Blocks<T> {
    /// Of these materials of the scene; `None` if there are none.
    pub(super) fn new(
        device: &Device,
        upload: &mut Upload,
        name: &'static str,
        materials: &BTreeSet<usize>,
        data: impl Fn(usize) -> T,
    ) -> Result<Option<Self>> {
        if materials.is_empty() {
            return Ok(None);
        }
        let alignment = device.caps().min_uniform_buffer_offset_alignment.max(1);
        let stride_bytes = (size_of::<T>() as u64).next_multiple_of(alignment);
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let bytes = stride_bytes * materials.len() as u64;
        let buffer = Buffer::new(device, &BufferDesc { name, bytes, usage, memory: MemoryUse::Device })?;
        let mut content = vec![0; bytes as usize];
        for (block, &material) in content.chunks_exact_mut(stride_bytes as usize).zip(materials) {
            block[..size_of::<T>()].copy_from_slice(bytemuck::bytes_of(&data(material)));
        }
        upload.buffer(&buffer, 0, &content)?;
        Ok(Some(Self {
            buffer,
            materials: materials.iter().copied().collect(),
            stride_bytes,
            of: PhantomData,
        }))
    }

    /// A drawn material's block, to write a descriptor with.
    pub(super) fn content(&self, material: usize) -> Content<'_> {
        let block = self.materials.binary_search(&material).expect("only what is drawn has descriptors");
        Content::Buffer(&self.buffer, self.stride_bytes * block as u64, size_of::<T>() as u64)
    }

    /// Device memory of the buffer.
    pub(super) fn allocated_bytes(&self) -> u64 {
        self.buffer.allocated_bytes()
    }
}

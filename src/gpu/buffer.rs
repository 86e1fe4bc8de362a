//! Buffers with their memory.

use super::memory::Memory;
use super::{Called, Device, MemoryUse, Owned, Recorder};
use crate::{Error, Result};
use ash::vk;

/// What a [`Buffer`] is made from.
#[derive(Clone, Copy, Debug)]
pub struct BufferDesc<'a> {
    /// For debuggers and messages.
    pub name: &'a str,
    /// Size; above 0.
    pub bytes: u64,
    /// Everything it is used for. What an [`Upload`](super::Upload) makes it visible to follows from this.
    pub usage: vk::BufferUsageFlags,
    /// Whether it is mapped, and for what.
    pub memory: MemoryUse,
}

/// A buffer and its sub-allocated memory.
#[derive(Debug)]
pub struct Buffer {
    raw: Owned<vk::Buffer>,
    memory: Memory,
    bytes: u64,
    usage: vk::BufferUsageFlags,
}

impl Buffer {
    /// Makes a buffer with undefined content.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a size of 0; [`Error::Vulkan`], e.g. when memory runs out.
    pub fn new(device: &Device, desc: &BufferDesc<'_>) -> Result<Self> {
        if desc.bytes == 0 {
            return Err(Error::unsupported(
                format!("buffer '{}' has a size of 0", desc.name),
                "leave out what is empty",
            ));
        }
        let info = vk::BufferCreateInfo::default().size(desc.bytes).usage(desc.usage);
        // SAFETY: the size is above 0, and sharing is exclusive.
        let raw = unsafe { device.create_buffer(&info, desc.name) }?;
        // SAFETY: the buffer is alive.
        let requirements = unsafe { device.raw().get_buffer_memory_requirements(raw.raw()) };
        let memory = match desc.memory {
            MemoryUse::Device if desc.usage.contains(vk::BufferUsageFlags::INDEX_BUFFER) => {
                Memory::unmapped(device, requirements, desc.name)?
            }
            memory_use => Memory::new(device, requirements, memory_use, true, None, desc.name)?,
        };
        let (block, offset) = memory.binding();
        // SAFETY: neither is bound yet, and the memory was allocated for these requirements.
        unsafe { device.raw().bind_buffer_memory(raw.raw(), block, offset) }.called("vkBindBufferMemory")?;
        Ok(Self { raw, memory, bytes: desc.bytes, usage: desc.usage })
    }

    /// The handle, valid as long as this owner.
    pub fn raw(&self) -> vk::Buffer {
        self.raw.raw()
    }

    /// The size that was asked for.
    pub fn size_bytes(&self) -> u64 {
        self.bytes
    }

    /// What it is used for.
    pub fn usage(&self) -> vk::BufferUsageFlags {
        self.usage
    }

    /// The size of the memory behind it.
    pub fn allocated_bytes(&self) -> u64 {
        self.memory.bytes()
    }

    /// The content of a mapped buffer, `size_bytes` long; empty if it is not mapped. What the GPU wrote is
    /// seen after its fence was waited for and a barrier made it visible to the host.
    pub fn mapped(&self) -> &[u8] {
        self.memory.mapped().map_or(&[], |bytes| &bytes[..self.bytes as usize])
    }

    /// The content of a mapped buffer, to write; empty if it is not mapped. The GPU must not be reading the
    /// parts that are written.
    pub fn mapped_mut(&mut self) -> &mut [u8] {
        let size = self.bytes as usize;
        self.memory.mapped_mut().map_or(&mut [], |bytes| &mut bytes[..size])
    }

    /// Records the copy of all of it into a mapped buffer of the same size. It waits for earlier uploads and
    /// shader writes; the host sees the content once the commands were waited for.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the sizes differ or a buffer lacks its transfer usage.
    pub fn record_copy(&self, recorder: &Recorder<'_>, target: &Buffer) -> Result<()> {
        let usable = self.usage.contains(vk::BufferUsageFlags::TRANSFER_SRC)
            && target.usage.contains(vk::BufferUsageFlags::TRANSFER_DST);
        if !usable || self.bytes != target.bytes {
            return Err(Error::unsupported(
                format!(
                    "a buffer of {} bytes with usage {:?} cannot be copied to one of {} bytes with usage {:?}",
                    self.bytes, self.usage, target.bytes, target.usage
                ),
                "make both of one size, with the usages TRANSFER_SRC and TRANSFER_DST",
            ));
        }
        use vk::{AccessFlags as A, PipelineStageFlags as S};
        let barrier = |src, dst| [vk::MemoryBarrier::default().src_access_mask(src).dst_access_mask(dst)];
        let before = barrier(A::TRANSFER_WRITE | A::SHADER_WRITE, A::TRANSFER_READ);
        let after = barrier(A::TRANSFER_WRITE, A::HOST_READ);
        let writers = S::TRANSFER | S::VERTEX_SHADER | S::FRAGMENT_SHADER;
        let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: self.bytes }];
        let (device, raw, none) = (recorder.device().raw(), recorder.raw(), vk::DependencyFlags::empty());
        // SAFETY: recording, outside of a render pass; both buffers hold the region.
        unsafe {
            device.cmd_pipeline_barrier(raw, writers, S::TRANSFER, none, &before, &[], &[]);
            device.cmd_copy_buffer(raw, self.raw(), target.raw(), &region);
            device.cmd_pipeline_barrier(raw, S::TRANSFER, S::HOST, none, &after, &[], &[]);
        }
        Ok(())
    }
}

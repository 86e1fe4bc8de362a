//! The one place where memory is allocated and counted.

use super::{Device, Owned};
use crate::{Error, Result};
use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use gpu_allocator::{AllocationError, MemoryLocation};

/// Who touches memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryUse {
    /// The GPU only.
    Device,
    /// Mapped: the CPU writes, the GPU reads.
    Upload,
    /// Mapped: the GPU writes, the CPU reads.
    Readback,
}

/// Memory behind one buffer or image.
#[derive(Debug)]
pub(crate) struct Memory {
    block: Block,
    bytes: u64,
    device: Device,
}

#[derive(Debug)]
enum Block {
    /// A part of one of gpu-allocator's blocks.
    Shared(Allocation),
    /// All of a lazily allocated memory object.
    Lazy(Owned<vk::DeviceMemory>),
    /// The beginning of a memory object that is never mapped.
    Unmapped(Owned<vk::DeviceMemory>),
}

/// Best practice checks report memory objects below this size. For lazily allocated ones the rounding costs
/// addresses only, no pages.
pub(super) const LEAST_OWN_BLOCK_BYTES: u64 = 1 << 20;

impl Memory {
    /// Sub-allocates; `linear` for buffers. `dedicated` asks for a memory object of the resource's own.
    pub(crate) fn new(
        device: &Device,
        requirements: vk::MemoryRequirements,
        memory_use: MemoryUse,
        linear: bool,
        dedicated: Option<AllocationScheme>,
        name: &str,
    ) -> Result<Self> {
        let location = match memory_use {
            MemoryUse::Device => MemoryLocation::GpuOnly,
            MemoryUse::Upload => MemoryLocation::CpuToGpu,
            MemoryUse::Readback => MemoryLocation::GpuToCpu,
        };
        // Lazily allocated types must be asked for, never hit by accident: they hide from frame captures.
        let memory_type_bits = requirements.memory_type_bits & !device.lazy_memory_types();
        let allocation = device.allocator().allocate(&AllocationCreateDesc {
            name,
            requirements: vk::MemoryRequirements { memory_type_bits, ..requirements },
            location,
            linear,
            allocation_scheme: dedicated.unwrap_or(AllocationScheme::GpuAllocatorManaged),
        });
        let allocation = allocation.map_err(|e| allocation_error(&e, name, requirements.size))?;
        Ok(Self::counted(device, Block::Shared(allocation), requirements.size))
    }

    /// Lazily allocated memory of its own; `None` if the device or the resource does not go with it.
    pub(crate) fn lazy(
        device: &Device,
        requirements: vk::MemoryRequirements,
        dedicated_image: Option<vk::Image>,
        name: &str,
    ) -> Result<Option<Self>> {
        let types = requirements.memory_type_bits & device.lazy_memory_types();
        if types == 0 {
            return Ok(None);
        }
        // A dedicated allocation must be of exactly the required size.
        let bytes = match dedicated_image {
            Some(_) => requirements.size,
            None => requirements.size.max(LEAST_OWN_BLOCK_BYTES),
        };
        let mut dedicated =
            vk::MemoryDedicatedAllocateInfo::default().image(dedicated_image.unwrap_or_default());
        let mut info = vk::MemoryAllocateInfo::default()
            .allocation_size(bytes)
            .memory_type_index(types.trailing_zeros());
        if dedicated_image.is_some() {
            info = info.push_next(&mut dedicated);
        }
        // SAFETY: the type exists, and the size is not zero: it is an image's.
        let memory = unsafe { device.allocate_memory(&info, name) }?;
        Ok(Some(Self::counted(device, Block::Lazy(memory), bytes)))
    }

    /// A memory object that nothing ever maps, for index buffers. gpu-allocator maps every block that can be mapped, and
    /// 1.3 validation layers then scan index data at the block's start instead of at the buffer's offset: they judge, and
    /// may crash on, whatever lies there.
    pub(crate) fn unmapped(
        device: &Device,
        requirements: vk::MemoryRequirements,
        name: &str,
    ) -> Result<Self> {
        let possible = requirements.memory_type_bits & !device.lazy_memory_types();
        let local = possible & device.device_local_memory_types();
        let types = if local == 0 { possible } else { local };
        let bytes = requirements.size.max(LEAST_OWN_BLOCK_BYTES);
        let info = vk::MemoryAllocateInfo::default()
            .allocation_size(bytes)
            .memory_type_index(types.trailing_zeros());
        // SAFETY: every buffer has a type that is not lazily allocated (Vulkan specification,
        // "Resource Memory Association"), and the size is not zero.
        let memory = unsafe { device.allocate_memory(&info, name) }?;
        Ok(Self::counted(device, Block::Unmapped(memory), bytes))
    }

    fn counted(device: &Device, block: Block, bytes: u64) -> Self {
        device.counters().add_memory(bytes);
        Self { block, bytes, device: device.clone() }
    }

    /// The memory object and the offset in it, for binding.
    pub(crate) fn binding(&self) -> (vk::DeviceMemory, u64) {
        match &self.block {
            // SAFETY: the handle is used to bind a resource that is destroyed before this owner.
            Block::Shared(allocation) => (unsafe { allocation.memory() }, allocation.offset()),
            Block::Lazy(memory) | Block::Unmapped(memory) => (memory.raw(), 0),
        }
    }

    /// What was asked of the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// What the driver has committed to lazily allocated memory; `None` for ordinary memory.
    pub(crate) fn committed_bytes(&self) -> Option<u64> {
        match &self.block {
            Block::Shared(_) | Block::Unmapped(_) => None,
            Block::Lazy(memory) => {
                // SAFETY: the memory is alive and of a lazily allocated type.
                Some(unsafe { self.device.raw().get_device_memory_commitment(memory.raw()) })
            }
        }
    }

    /// The bytes, if mapped.
    pub(crate) fn mapped(&self) -> Option<&[u8]> {
        match &self.block {
            Block::Shared(allocation) => allocation.mapped_slice(),
            Block::Lazy(_) | Block::Unmapped(_) => None,
        }
    }

    /// The bytes, if mapped.
    pub(crate) fn mapped_mut(&mut self) -> Option<&mut [u8]> {
        match &mut self.block {
            Block::Shared(allocation) => allocation.mapped_slice_mut(),
            Block::Lazy(_) | Block::Unmapped(_) => None,
        }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        if let Block::Shared(allocation) = &mut self.block {
            // It fails only for an allocation of another allocator.
            if let Err(e) = self.device.allocator().free(std::mem::take(allocation)) {
                log::error!("memory was not freed: {e}");
            }
        }
        self.device.counters().remove_memory(self.bytes);
    }
}

fn allocation_error(error: &AllocationError, name: &str, bytes: u64) -> Error {
    let result = match error {
        AllocationError::OutOfMemory => vk::Result::ERROR_OUT_OF_DEVICE_MEMORY,
        AllocationError::FailedToMap(_) => {
            return Error::Vulkan { call: "vkMapMemory", result: vk::Result::ERROR_MEMORY_MAP_FAILED };
        }
        // gpu-allocator keeps other results of vkAllocateMemory only as text.
        AllocationError::Internal(text) if text.contains("ERROR_OUT_OF_HOST_MEMORY") => {
            vk::Result::ERROR_OUT_OF_HOST_MEMORY
        }
        AllocationError::Internal(text) if text.contains("ERROR_TOO_MANY_OBJECTS") => {
            vk::Result::ERROR_TOO_MANY_OBJECTS
        }
        other => {
            return Error::unsupported(
                format!("no memory for '{name}' ({bytes} bytes): {other}"),
                "use another device",
            );
        }
    };
    Error::Vulkan { call: "vkAllocateMemory", result }
}

//! Descriptor sets: allocated once, exactly as many as are needed, every binding written.

use ash::vk;

use super::{Buffer, Called, Device, Owned};
use crate::Result;

/// One binding of a set layout: number, type, array size, stages.
pub(super) type Binding = (u32, vk::DescriptorType, u32, vk::ShaderStageFlags);

/// A layout of these bindings, whose numbers are distinct.
pub(super) fn set_layout(
    device: &Device,
    bindings: &[Binding],
    name: &str,
) -> Result<Owned<vk::DescriptorSetLayout>> {
    let bindings: Vec<_> = bindings
        .iter()
        .map(|&(binding, ty, count, stages)| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(ty)
                .descriptor_count(count)
                .stage_flags(stages)
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the bindings outlive the call, and the caller gives each number once.
    unsafe { device.create_descriptor_set_layout(&info, name) }
}

/// Sets with the pool that they live in.
pub(super) struct DescriptorSets {
    pool: Owned<vk::DescriptorPool>,
    sets: Vec<vk::DescriptorSet>,
}

/// What a binding is written with.
pub(super) enum Content<'a> {
    /// A part of a buffer: offset and length in bytes.
    Buffer(&'a Buffer, u64, u64),
    /// Images, one per array element.
    Images(Vec<vk::DescriptorImageInfo>),
}

impl DescriptorSets {
    /// Allocates one set per layout, in order; `None` if there is none to allocate.
    pub(super) fn new(
        device: &Device,
        layouts: &[(vk::DescriptorSetLayout, &[Binding])],
        name: &str,
    ) -> Result<Option<Self>> {
        if layouts.is_empty() {
            return Ok(None);
        }
        let bindings = || layouts.iter().flat_map(|(_, bindings)| bindings.iter());
        let mut sizes: Vec<vk::DescriptorPoolSize> = Vec::new();
        for &(_, ty, count, _) in bindings() {
            match sizes.iter_mut().find(|s| s.ty == ty) {
                Some(size) => size.descriptor_count += count,
                None => sizes.push(vk::DescriptorPoolSize { ty, descriptor_count: count }),
            }
        }
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(layouts.len() as u32).pool_sizes(&sizes);
        // SAFETY: counts are above 0, since every layout has a binding.
        let pool = unsafe { device.create_descriptor_pool(&info, name) }?;
        let raw: Vec<_> = layouts.iter().map(|(layout, _)| *layout).collect();
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool.raw()).set_layouts(&raw);
        // SAFETY: the pool was sized for exactly these layouts.
        let sets =
            unsafe { device.raw().allocate_descriptor_sets(&info) }.called("vkAllocateDescriptorSets")?;
        Ok(Some(Self { pool, sets }))
    }

    /// The set of the n-th layout.
    pub(super) fn raw(&self, index: usize) -> vk::DescriptorSet {
        self.sets[index]
    }

    /// Writes one binding of one set. The GPU must not be using the set.
    pub(super) fn write(&self, index: usize, binding: u32, ty: vk::DescriptorType, content: &Content<'_>) {
        let buffer;
        let write = vk::WriteDescriptorSet::default()
            .dst_set(self.sets[index])
            .dst_binding(binding)
            .descriptor_type(ty);
        let write = match content {
            Content::Buffer(b, offset, bytes) => {
                buffer = [vk::DescriptorBufferInfo::default().buffer(b.raw()).offset(*offset).range(*bytes)];
                write.buffer_info(&buffer)
            }
            Content::Images(images) => write.image_info(images),
        };
        // SAFETY: set and objects are alive, and the caller promises that the set is idle.
        unsafe { self.pool.device().raw().update_descriptor_sets(&[write], &[]) };
    }
}

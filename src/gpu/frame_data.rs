//! What changes from frame to frame: mapped buffers, one set of them for each frame slot.

use ash::vk;

use super::lights::Lights;
use super::objects::Objects;
use super::shared::{FrameUniforms, InstanceData, LightData};
use super::{Buffer, BufferDesc, Device, MemoryUse, View};
use crate::Result;
use crate::plan::Plan;
use crate::visible::Frustum;

/// A frame slot's buffers, large enough for all of the scene.
pub(super) struct FrameData {
    pub(super) uniforms: Buffer,
    /// `None` if nothing is drawn.
    pub(super) instances: Option<Buffer>,
    pub(super) lights: Buffer,
}

/// How much of a scene a view saw.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    pub(super) objects: usize,
    pub(super) lights: usize,
}

impl FrameData {
    pub(super) fn new(device: &Device, objects: usize, lights: usize) -> Result<Self> {
        let buffer = |name, bytes: usize, usage| {
            Buffer::new(device, &BufferDesc { name, bytes: bytes as u64, usage, memory: MemoryUse::Upload })
        };
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let instances =
            (objects > 0).then(|| buffer("instances", objects * size_of::<InstanceData>(), storage));
        Ok(Self {
            uniforms: buffer("frame", size_of::<FrameUniforms>(), uniform)?,
            instances: instances.transpose()?,
            // A buffer cannot be empty, but a scene can be without lights; then no shader reads what is here.
            lights: buffer("lights", lights.max(1) * size_of::<LightData>(), storage)?,
        })
    }

    /// Writes what the view sees; all of the scene without `cull`. The GPU has finished with the slot.
    pub(super) fn write(
        &mut self,
        view: &View<'_>,
        plan: &Plan,
        size: [u32; 2],
        (objects, lights): (&mut Objects, &Lights),
        ambient_nt: glam::Vec3,
        cull: bool,
    ) -> Seen {
        let mut uniforms = view.uniforms(plan, size, ambient_nt);
        let frustum = cull.then(|| Frustum::new(&glam::Mat4::from_cols_array_2d(&uniforms.clip_from_world)));
        let instances = self.instances.as_mut().map(|b| bytemuck::cast_slice_mut(b.mapped_mut()));
        let seen_objects = objects.write_visible(frustum.as_ref(), instances.unwrap_or_default());
        let light_list = bytemuck::cast_slice_mut(self.lights.mapped_mut());
        let [directional, point, spot, boxes, hemispheres] =
            lights.write_visible(frustum.as_ref(), light_list);
        uniforms.light_counts = [directional, point, spot, boxes];
        self.uniforms.mapped_mut().copy_from_slice(bytemuck::bytes_of(&uniforms));
        Seen { objects: seen_objects, lights: (directional + point + spot + boxes + hemispheres) as usize }
    }

    /// Size of the memory.
    pub(super) fn allocated_bytes(&self) -> u64 {
        let buffers = [&self.uniforms, &self.lights].into_iter().chain(&self.instances);
        buffers.map(Buffer::allocated_bytes).sum()
    }
}

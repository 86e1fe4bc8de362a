//! What changes from frame to frame: mapped buffers, one set of them for each frame slot.

use std::time::{Duration, Instant};

use ash::vk;

use super::decals::Decals;
use super::light_lists::LightLists;
use super::lights::Lights;
use super::objects::Objects;
use super::particles::SceneParticles;
use super::shader::shared;
use super::shared::{DecalData, FrameUniforms, InstanceData, LightData, ParticleData};
use super::{Buffer, BufferDesc, Device, MemoryUse, View};
use crate::Result;
use crate::plan::{Plan, Seen};
use crate::scene::PreRotation;
use crate::visible::Sight;

/// A frame slot's buffers, large enough for all of the scene.
pub(super) struct FrameData {
    /// `None` if there is no pipeline.
    pub(super) uniforms: Option<Buffer>,
    /// `None` if nothing is drawn.
    pub(super) instances: Option<Buffer>,
    /// The parts of the lightmap of `instances`; `None` if the plan has no lightmap.
    pub(super) lightmap_rects: Option<Buffer>,
    /// `None` if nothing is lit by lights that are listed.
    pub(super) lights: Option<Buffer>,
    /// `None` if the plan's way of lights has no lists.
    pub(super) light_lists: Option<Buffer>,
    /// `None` if nothing is painted.
    pub(super) decals: Option<Buffer>,
    /// `None` if there are no particles.
    pub(super) particles: Option<Buffer>,
}

/// How much of a scene was written for a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Written {
    pub(super) objects: Seen,
    pub(super) lights: Seen,
    /// The time that listing the lights took.
    pub(super) light_lists: Duration,
}

/// What there is to see.
pub(super) struct Everything<'a> {
    pub(super) objects: &'a mut Objects,
    pub(super) lights: &'a mut Lights,
    pub(super) light_lists: &'a mut LightLists,
    pub(super) decals: &'a mut Decals,
    pub(super) particles: &'a mut SceneParticles,
    pub(super) ambient_nt: glam::Vec3,
}

impl FrameData {
    /// Makes what pipelines read: bit `n` of `read` is binding `n` of `SET_FRAME`. There are so many objects, lights,
    /// decals and particles.
    pub(super) fn new(
        device: &Device,
        plan: &Plan,
        read: u32,
        [objects, lights, decals, particles]: [usize; 4],
    ) -> Result<Self> {
        let is_read = |binding: u32| read & (1 << binding) != 0;
        let buffer = |name, bytes: usize, usage| {
            Buffer::new(device, &BufferDesc { name, bytes: bytes as u64, usage, memory: MemoryUse::Upload })
        };
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let instances =
            (objects > 0).then(|| buffer("instances", objects * size_of::<InstanceData>(), storage));
        let rects =
            plan.needs.lightmap.map(|_| buffer("lightmap parts", objects * size_of::<[f32; 4]>(), storage));
        let light_lists = LightLists::bytes(plan).map(|bytes| buffer("light lists", bytes as usize, storage));
        Ok(Self {
            uniforms: is_read(const { shared("BINDING_FRAME") })
                .then(|| buffer("frame", size_of::<FrameUniforms>(), uniform))
                .transpose()?,
            instances: instances.transpose()?,
            lightmap_rects: rects.transpose()?,
            lights: is_read(const { shared("BINDING_LIGHTS") })
                .then(|| buffer("lights", lights.max(1) * size_of::<LightData>(), storage))
                .transpose()?,
            light_lists: light_lists.transpose()?,
            decals: (decals > 0)
                .then(|| buffer("decals", decals * size_of::<DecalData>(), storage))
                .transpose()?,
            particles: (particles > 0)
                .then(|| buffer("particles", particles * size_of::<ParticleData>(), storage))
                .transpose()?,
        })
    }

    /// Writes what the view sees; all of the scene without `cull`. The GPU has finished with the slot.
    pub(super) fn write(
        &mut self,
        view: &View<'_>,
        plan: &Plan,
        (size, pre_rotation): ([u32; 2], PreRotation),
        scene: Everything<'_>,
        cull: bool,
        [share, factor]: [f32; 2],
    ) -> Written {
        let Everything { objects, lights, light_lists, decals, particles, ambient_nt } = scene;
        let mut uniforms = view.uniforms(plan, size, ambient_nt);
        let clip_from_world = glam::Mat4::from_cols_array_2d(&uniforms.clip_from_world);
        let sight = Sight::new(&clip_from_world, &view.camera.world_from_view);
        let frustum = cull.then_some(&sight.frustum);
        let instances = self.instances.as_mut().map(|b| bytemuck::cast_slice_mut(b.mapped_mut()));
        let instances = instances.unwrap_or_default();
        let rects = self.lightmap_rects.as_mut().map(|b| bytemuck::cast_slice_mut(b.mapped_mut()));
        let seen_objects = objects.write_visible(&sight, cull, instances, rects.unwrap_or_default());
        let light_list = self.lights.as_mut().map(|b| bytemuck::cast_slice_mut(b.mapped_mut()));
        let light_list = light_list.unwrap_or_default();
        let counts = lights.write_visible(frustum, light_list, light_lists.reaches_mut());
        uniforms.light_counts = counts;
        uniforms.hemispheres = lights.hemispheres();
        if let Some(buffer) = &mut self.decals {
            let out = bytemuck::cast_slice_mut(buffer.mapped_mut());
            decals.write_visible(&clip_from_world, frustum, view.camera, out);
        }
        if let Some(buffer) = &mut self.particles {
            particles.write_visible(frustum, pre_rotation, bytemuck::cast_slice_mut(buffer.mapped_mut()));
        }
        uniforms.bloom = [share, factor, 0.0, 0.0];
        if let Some(buffer) = &mut self.uniforms {
            buffer.mapped_mut().copy_from_slice(bytemuck::bytes_of(&uniforms));
        }
        let start = Instant::now();
        let all = counts.iter().sum::<u32>();
        if let Some(lists) = &mut self.light_lists {
            light_lists.write(view.camera, size, counts[0]..all, lists.mapped_mut());
        }
        Written {
            objects: Seen::of(seen_objects, objects.count()),
            lights: Seen::of(all as usize, lights.lit()),
            light_lists: start.elapsed(),
        }
    }

    /// Size of the memory.
    pub(super) fn allocated_bytes(&self) -> u64 {
        let Self { uniforms, instances, lightmap_rects, lights, light_lists, decals, particles } = self;
        let buffers = [uniforms, instances, lightmap_rects, lights, light_lists, decals, particles];
        buffers.into_iter().flatten().map(Buffer::allocated_bytes).sum()
    }
}

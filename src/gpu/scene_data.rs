//! A scene on the device: buffers, textures, descriptor sets, and the order in which it is drawn.

use std::collections::BTreeSet;
use std::ops::Range;

use ash::vk;

use super::descriptor::{Content, DescriptorSets};
use super::material_data::Materials;
use super::pipeline::{Family, Pipelines};
use super::shader::shared;
use super::shared::{FrameUniforms, InstanceData, LightData};
use super::{
    Buffer, BufferDesc, ColorEncoding, Device, Geometry, MemoryUse, Recorder, Streams, TextureKey, Textures,
    Upload, View, convert,
};
use crate::Result;
use crate::plan::{Pipeline, Plan, SLOTS, SurfaceKind};
use crate::scene::Scene;

/// Instances of one mesh that one draw call draws.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch {
    /// Index into `Plan::pipelines`.
    pub(super) pipeline: usize,
    /// The material's descriptor set: index for [`SceneData::material_set`].
    pub(super) material_set: usize,
    /// Index into `Scene::meshes`.
    mesh: usize,
    /// Index into `Scene::materials`.
    material: usize,
    first_instance: u32,
    instance_count: u32,
}

/// A scene on the device.
pub(super) struct SceneData {
    frame_sets: Option<DescriptorSets>,
    material_sets: Option<DescriptorSets>,
    families: Vec<Family>,
    batches: Vec<Batch>,
    /// Of each pipeline, its part of `batches`.
    batches_of: Vec<Range<usize>>,
    uniforms: Vec<Buffer>,
    instances: Option<Buffer>,
    materials: Option<Materials>,
    lights: Buffer,
    geometry: Geometry,
    textures: Textures,
    ambient_nt: glam::Vec3,
    light_counts: [u32; 3],
}

impl SceneData {
    pub(super) fn new(
        device: &Device,
        scene: &Scene,
        plan: &Plan,
        pipelines: &Pipelines,
        slots: usize,
        upload: &mut Upload,
    ) -> Result<Self> {
        let (batches, instances) = batches(scene, plan);
        let geometry = Geometry::new(device, upload, &scene.meshes, &streams(scene, plan, &batches))?;
        let textures = Textures::new(
            device,
            upload,
            &scene.images,
            &scene.textures,
            &texture_keys(scene, plan, &batches),
        )?;
        let (lights, light_counts) = convert::lights(&scene.lights);
        let uniforms = (0..slots).map(|_| {
            let bytes = size_of::<FrameUniforms>() as u64;
            let usage = vk::BufferUsageFlags::UNIFORM_BUFFER;
            Buffer::new(device, &BufferDesc { name: "frame", bytes, usage, memory: MemoryUse::Upload })
        });
        let mut data = Self {
            frame_sets: None,
            material_sets: None,
            families: pipelines.layouts.keys().copied().collect(),
            batches_of: (0..plan.pipelines.len()).map(|p| range_of(&batches, p)).collect(),
            batches,
            uniforms: uniforms.collect::<Result<_>>()?,
            instances: storage(device, upload, "instances", &instances)?,
            materials: Materials::new(device, upload, scene)?,
            lights: lights_buffer(device, upload, lights)?,
            geometry,
            textures,
            ambient_nt: scene.ambient_nt,
            light_counts,
        };
        data.write_frame_sets(device, pipelines)?;
        data.write_material_sets(device, scene, plan, pipelines)?;
        Ok(data)
    }

    /// The batches that a pipeline draws, those of one material and of one mesh side by side.
    pub(super) fn batches_of(&self, pipeline: usize) -> &[Batch] {
        &self.batches[self.batches_of[pipeline].clone()]
    }

    /// The buffers that pipelines of this family read, for a frame slot.
    pub(super) fn frame_set(&self, slot: usize, family: Family) -> vk::DescriptorSet {
        let index =
            self.families.iter().position(|f| *f == family).expect("families come from the pipelines");
        let sets = self.frame_sets.as_ref().expect("every plan has a pipeline or draws nothing");
        sets.raw(slot * self.families.len() + index)
    }

    /// A material's numbers and textures.
    pub(super) fn material_set(&self, index: usize) -> vk::DescriptorSet {
        self.material_sets.as_ref().expect("the index comes from a batch").raw(index)
    }

    /// Device memory of buffers and textures.
    pub(super) fn allocated_bytes(&self) -> u64 {
        let buffers = self.uniforms.iter().chain(&self.instances).chain([&self.lights]);
        buffers.map(Buffer::allocated_bytes).sum::<u64>()
            + self.materials.as_ref().map_or(0, Materials::allocated_bytes)
            + self.geometry.allocated_bytes()
            + self.textures.allocated_bytes()
    }

    /// Fills the slot's uniform block; the GPU has finished with the slot.
    pub(super) fn write_frame(&mut self, slot: usize, view: &View<'_>, plan: &Plan, size: [u32; 2]) {
        let uniforms = view.uniforms(plan, size, self.ambient_nt, self.light_counts);
        self.uniforms[slot].mapped_mut().copy_from_slice(bytemuck::bytes_of(&uniforms));
    }

    /// Binds what a batch's draw reads, unless `bound` says that it is bound already.
    pub(super) fn bind_mesh(&self, recorder: &Recorder<'_>, batch: &Batch, bound: &mut BoundMesh) -> usize {
        const MOST_STREAMS: usize = 5;
        let range = &self.geometry.meshes()[batch.mesh];
        let (Some(vertices), Some(indices)) = (self.geometry.vertices(), self.geometry.indices()) else {
            return 0;
        };
        let mut changes = 0;
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        if bound.group != Some(range.group) {
            let offsets = &self.geometry.groups()[range.group].offsets_bytes;
            let buffers = [vertices.raw(); MOST_STREAMS];
            // SAFETY: both lists are of one length, and offsets lie inside the buffer.
            unsafe { device.cmd_bind_vertex_buffers(raw, 0, &buffers[..offsets.len()], offsets) };
            bound.group = Some(range.group);
            changes += 1;
        }
        if bound.index_width != Some(range.index_width) {
            let offset = self.geometry.index_offset_bytes(range.index_width);
            // SAFETY: the offset lies inside the buffer and is a multiple of the index size.
            unsafe {
                device.cmd_bind_index_buffer(raw, indices.raw(), offset, range.index_width.index_type())
            };
            bound.index_width = Some(range.index_width);
            changes += 1;
        }
        changes
    }

    pub(super) fn draw(&self, recorder: &Recorder<'_>, batch: &Batch) {
        let range = &self.geometry.meshes()[batch.mesh];
        // SAFETY: `bind_mesh` bound the buffers, and the ranges lie inside them.
        unsafe {
            recorder.device().raw().cmd_draw_indexed(
                recorder.raw(),
                range.index_count,
                batch.instance_count,
                range.first_index,
                range.vertex_offset,
                batch.first_instance,
            );
        }
    }

    /// One set per frame slot and family.
    fn write_frame_sets(&mut self, device: &Device, pipelines: &Pipelines) -> Result<()> {
        let layouts = pipelines.layouts.values().map(|l| (l.sets[0].raw(), l.bindings[0].as_slice()));
        let slots = self.uniforms.len();
        let wanted: Vec<_> = (0..slots).flat_map(|_| layouts.clone()).collect();
        let Some(sets) = DescriptorSets::new(device, &wanted, "frame")? else { return Ok(()) };
        for (index, (_, bindings)) in wanted.iter().enumerate() {
            for &(binding, ty, ..) in *bindings {
                let buffer = match binding {
                    _ if ty == vk::DescriptorType::UNIFORM_BUFFER => {
                        Some(&self.uniforms[index / self.families.len()])
                    }
                    b if b == const { shared("BINDING_INSTANCES") } => self.instances.as_ref(),
                    _ => Some(&self.lights),
                };
                // Surface pipelines exist only for instances, and so do these buffers.
                if let Some(buffer) = buffer {
                    sets.write(index, binding, ty, &Content::Buffer(buffer, 0, buffer.size_bytes()));
                }
            }
        }
        self.frame_sets = Some(sets);
        Ok(())
    }

    /// One set per material and pipeline; batches learn theirs.
    fn write_material_sets(
        &mut self,
        device: &Device,
        scene: &Scene,
        plan: &Plan,
        pipelines: &Pipelines,
    ) -> Result<()> {
        let mut keys: Vec<(usize, usize)> = Vec::new();
        for batch in &mut self.batches {
            let key = (batch.pipeline, batch.material);
            if keys.last() != Some(&key) {
                keys.push(key);
            }
            batch.material_set = keys.len() - 1;
        }
        let wanted: Vec<_> = keys
            .iter()
            .map(|(pipeline, _)| {
                let layout = pipelines.layout_of(*pipeline);
                (layout.sets[1].raw(), layout.bindings[1].as_slice())
            })
            .collect();
        let Some(sets) = DescriptorSets::new(device, &wanted, "materials")? else { return Ok(()) };
        for (index, &(pipeline, material)) in keys.iter().enumerate() {
            let Some(materials) = &self.materials else { continue };
            let numbers = materials.content(material);
            sets.write(
                index,
                const { shared("BINDING_MATERIAL") },
                vk::DescriptorType::UNIFORM_BUFFER,
                &numbers,
            );
            let images: Vec<_> = material_textures(scene, surface(plan, pipeline), material)
                .map(|key| {
                    let (view, sampler) = self.textures.get(key).expect("uploaded by the same list");
                    vk::DescriptorImageInfo::default()
                        .image_view(view)
                        .sampler(sampler)
                        .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
                })
                .collect();
            if !images.is_empty() {
                let ty = vk::DescriptorType::COMBINED_IMAGE_SAMPLER;
                sets.write(index, const { shared("BINDING_TEXTURES") }, ty, &Content::Images(images));
            }
        }
        self.material_sets = Some(sets);
        Ok(())
    }
}

/// What is bound while surfaces are drawn.
#[derive(Default)]
pub(super) struct BoundMesh {
    group: Option<usize>,
    index_width: Option<super::IndexWidth>,
}

fn surface(plan: &Plan, pipeline: usize) -> &SurfaceKind {
    match &plan.pipelines[pipeline].1 {
        Pipeline::Surface(kind) => kind,
        other => unreachable!("batches are made for surfaces, not for {other:?}"),
    }
}

/// Sorts instances by pipeline, material and mesh, so that state changes are few and equal meshes become one draw.
fn batches(scene: &Scene, plan: &Plan) -> (Vec<Batch>, Vec<InstanceData>) {
    let ambient = scene.ambient_nt != glam::Vec3::ZERO;
    let mut order: Vec<_> = scene
        .drawn_instances()
        .map(|instance| {
            let mesh = &scene.meshes[instance.mesh];
            let kind =
                SurfaceKind::new(mesh, &scene.materials[mesh.material], instance.is_mirrored(), ambient);
            let wanted = Pipeline::Surface(kind);
            let pipeline = plan.pipelines.iter().position(|(_, p)| *p == wanted);
            (pipeline.expect("the plan was made for this scene"), mesh.material, instance.mesh, instance)
        })
        .collect();
    order.sort_by_key(|&(pipeline, material, mesh, _)| (pipeline, material, mesh));
    let mut batches: Vec<Batch> = Vec::new();
    let mut data = Vec::with_capacity(order.len());
    for (pipeline, material, mesh, instance) in order {
        let first_instance = data.len() as u32;
        data.push(convert::instance(instance));
        match batches.last_mut() {
            Some(last) if (last.pipeline, last.mesh) == (pipeline, mesh) => last.instance_count += 1,
            _ => batches.push(Batch {
                pipeline,
                material_set: 0,
                mesh,
                material,
                first_instance,
                instance_count: 1,
            }),
        }
    }
    (batches, data)
}

fn range_of(batches: &[Batch], pipeline: usize) -> Range<usize> {
    batches.partition_point(|b| b.pipeline < pipeline)..batches.partition_point(|b| b.pipeline <= pipeline)
}

/// What each mesh's pipelines read. A mesh has one material, so its pipelines differ in winding only.
fn streams(scene: &Scene, plan: &Plan, batches: &[Batch]) -> Vec<Streams> {
    let mut streams = vec![Streams::default(); scene.meshes.len()];
    for batch in batches {
        streams[batch.mesh] = vertex_streams(surface(plan, batch.pipeline));
    }
    streams
}

/// The vertex attributes that a kind of surface reads.
pub(super) fn vertex_streams(kind: &SurfaceKind) -> Streams {
    Streams {
        normals: !kind.unlit,
        tangents: kind.needs_tangents(),
        texcoords: kind.texcoord_sets(),
        colors: kind.vertex_color,
    }
}

/// The textures of a material in the order of its descriptors.
fn material_textures<'a>(
    scene: &'a Scene,
    kind: &'a SurfaceKind,
    material: usize,
) -> impl Iterator<Item = TextureKey> + 'a {
    let textures = SurfaceKind::textures_of(&scene.materials[material]);
    (0..SLOTS.len()).filter(|&slot| kind.samples(slot)).map(move |slot| TextureKey {
        texture: textures[slot].expect("only present textures are sampled").texture,
        encoding: if SurfaceKind::is_srgb(slot) { ColorEncoding::Srgb } else { ColorEncoding::Linear },
    })
}

/// Every texture that some pipeline samples, once.
fn texture_keys(scene: &Scene, plan: &Plan, batches: &[Batch]) -> Vec<TextureKey> {
    let used: BTreeSet<(usize, usize)> = batches.iter().map(|b| (b.pipeline, b.material)).collect();
    let keys = used.into_iter().flat_map(|(p, m)| material_textures(scene, surface(plan, p), m));
    let mut seen = Vec::new();
    for key in keys {
        if !seen.contains(&key) {
            seen.push(key);
        }
    }
    seen
}

/// A storage buffer with this content; `None` if there is none.
fn storage<T: bytemuck::Pod>(
    device: &Device,
    upload: &mut Upload,
    name: &str,
    content: &[T],
) -> Result<Option<Buffer>> {
    if content.is_empty() {
        return Ok(None);
    }
    let bytes = bytemuck::cast_slice(content);
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
    let desc = BufferDesc { name, bytes: bytes.len() as u64, usage, memory: MemoryUse::Device };
    let buffer = Buffer::new(device, &desc)?;
    upload.buffer(&buffer, 0, bytes)?;
    Ok(Some(buffer))
}

/// A buffer cannot be empty, but a scene can be without lights; then no shader reads the one light that is dark.
fn lights_buffer(device: &Device, upload: &mut Upload, lights: Vec<LightData>) -> Result<Buffer> {
    let lights = if lights.is_empty() { vec![LightData::default()] } else { lights };
    Ok(storage(device, upload, "lights", &lights)?.expect("there is at least one"))
}

//! A scene on the device: buffers, textures, descriptor sets, and the order in which it is drawn.

#[cfg(feature = "view")]
mod seen;
mod wanted;

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use ash::vk;

use super::around::AroundData;
use super::convert;
use super::decals::Decals;
use super::descriptor::{Content, DescriptorSets};
use super::frame_data::{Everything, FrameData, Written};
use super::globe_maps::GlobeMaps;
use super::light_lists::LightLists;
use super::lights::{Lights, VolumeLight};
use super::material_data::Blocks;
use super::meshes::Meshes;
use super::objects::{Batch, Objects};
use super::particles::SceneParticles;
use super::pipeline::{Family, Pipelines};
use super::poses::Poses;
use super::shader::shared;
use super::shadow::ShadowResources;
use super::shared::{MaterialData, MediumData};
use super::volume_casters::VolumeCasters;
use super::{ColorEncoding, Device, PipelineCache, Recorder, TextureKey, Textures, Upload, View};
use crate::Result;
use crate::plan::{FrameCounts, Plan, StateChanges, VolumeShape};
use crate::scene::{Aabb, Changes, Pose, PreRotation, Scene};
use crate::visible::Reach;
use wanted::{frame_layouts, material_kind, material_textures, media, texture_keys};
pub(super) use wanted::{streams, surface, texture_bytes, vertex_streams};

/// A scene on the device.
pub(super) struct SceneData {
    frame_sets: Option<DescriptorSets>,
    material_sets: Option<DescriptorSets>,
    /// What pipelines read of a frame: each [`Family::frame`] once.
    frame_kinds: Vec<u32>,
    objects: Objects,
    lights: Lights,
    light_lists: LightLists,
    decals: Decals,
    particles: SceneParticles,
    /// One a frame slot.
    frames: Vec<FrameData>,
    materials: Option<Blocks<MaterialData>>,
    media: Option<Blocks<MediumData>>,
    meshes: Meshes,
    textures: Textures,
    globe_maps: Option<GlobeMaps>,
    volume_casters: Option<VolumeCasters>,
    poses: Option<Poses>,
    around: Arc<AroundData>,
    ambient_nt: glam::Vec3,
}

impl SceneData {
    pub(super) fn new(
        device: &Device,
        scene: &Scene,
        plan: &Plan,
        pipelines: &Pipelines,
        shadows: Option<&ShadowResources>,
        slots: usize,
        (upload, cache, kept): (&mut Upload, &PipelineCache, Option<(&Self, &Changes)>),
    ) -> Result<Self> {
        let objects = Objects::new(scene, plan);
        let globes = (plan.needs.globe_maps > 0).then(|| scene.globe_layers()).transpose()?;
        let globe_layers = globes.as_ref().map(|g| g.first_of_light.as_slice());
        let lights = Lights::new(&scene.lights, plan.shadow_map.as_ref(), globe_layers, &plan.volume_lights);
        let decals = Decals::new(scene, plan);
        let particles = SceneParticles::new(scene, plan);
        let others: Vec<_> = decals.materials().chain(particles.materials()).collect();
        let of_objects = objects.batches().iter().map(|batch| batch.material);
        let materials: BTreeSet<_> = of_objects.chain(others.iter().map(|(_, m)| *m)).collect();
        let streams = streams(scene, plan, objects.batches());
        let old = kept.map(|(old, changes)| (&old.meshes, &changes.meshes[..]));
        let meshes = Meshes::new(device, upload, &scene.meshes, &streams, old)?;
        let keys = texture_keys(scene, plan, objects.batches(), &others);
        let old = kept.map(|(old, changes)| (&old.textures, &changes.images[..]));
        let textures = Textures::new(device, upload, &scene.images, &scene.textures, &keys, old)?;
        let same_around =
            |(old, changes): &(&Self, &Changes)| !changes.surroundings && old.around.is_of(plan);
        let around = match kept.filter(same_around) {
            Some((old, _)) => Arc::clone(&old.around),
            None => Arc::new(AroundData::new(device, upload, scene, plan)?),
        };
        let frame_kinds: Vec<u32> = frame_layouts(pipelines).into_keys().collect();
        let read = frame_kinds.iter().fold(0, |all, kind| all | kind);
        let counts = [objects.count(), lights.count(), decals.count(), particles.most()];
        let frames = (0..slots).map(|_| FrameData::new(device, plan, read, counts));
        let volume_casters = match plan.volume_lights.is_empty() {
            true => None,
            false => VolumeCasters::new(device, upload, scene, slots)?,
        };
        let posed = (&meshes, volume_casters.as_ref());
        let poses = Poses::new(device, scene, plan.needs.posed.as_ref(), posed, slots, (upload, cache))?;
        let mut data = Self {
            frame_sets: None,
            material_sets: None,
            frames: frames.collect::<Result<_>>()?,
            frame_kinds,
            objects,
            decals,
            particles,
            light_lists: LightLists::new(plan, lights.count()),
            lights,
            materials: Blocks::new(device, upload, "materials", &materials, |i| {
                convert::material(&scene.materials[i])
            })?,
            media: Blocks::new(device, upload, "media", &media(scene, &materials), |i| {
                convert::medium(&scene.materials[i].transmission.unwrap_or_default())
            })?,
            meshes,
            textures,
            globe_maps: globes.map(|layers| GlobeMaps::new(device, upload, &layers)).transpose()?,
            volume_casters,
            poses,
            around,
            ambient_nt: scene.ambient_nt,
        };
        data.write_frame_sets(device, pipelines, shadows)?;
        data.write_material_sets(device, scene, plan, pipelines)?;
        Ok(data)
    }

    /// What is drawn.
    pub(super) fn objects(&self) -> &Objects {
        &self.objects
    }

    /// Where the lights of the last frame written reach, in their order.
    pub(super) fn light_reaches(&self) -> &[Reach] {
        self.light_lists.reaches()
    }

    /// What is painted.
    pub(super) fn decals(&self) -> &Decals {
        &self.decals
    }

    /// What is painted, to change it.
    pub(super) fn decals_mut(&mut self) -> &mut Decals {
        &mut self.decals
    }

    /// Light without surfaces.
    pub(super) fn particles(&self) -> &SceneParticles {
        &self.particles
    }

    /// The same, to change it.
    pub(super) fn particles_mut(&mut self) -> &mut SceneParticles {
        &mut self.particles
    }

    /// Moves an element of `Scene::instances`.
    pub(super) fn set_instance(&mut self, index: usize, world_from_object: &glam::Mat4) -> Result<()> {
        self.objects.set(index, world_from_object)?;
        if let Some(casters) = &mut self.volume_casters {
            casters.set(index, world_from_object);
        }
        Ok(())
    }

    /// Poses a mesh; where it is then, object space, if it bends and is drawn.
    pub(super) fn set_pose(&mut self, mesh: usize, pose: &Pose) -> Result<Option<Aabb>> {
        let bounds = self.poses.as_mut().map_or(Ok(None), |poses| poses.set(mesh, pose))?;
        if let Some(bounds) = &bounds {
            self.objects.set_bounds(mesh, bounds);
            self.volume_casters.iter_mut().for_each(|casters| casters.set_bounds(mesh, bounds));
        }
        Ok(bounds)
    }

    /// What poses meshes, if some bend.
    pub(super) fn poses_mut(&mut self) -> Option<&mut Poses> {
        self.poses.as_mut()
    }

    /// What casts shadows by volumes.
    pub(super) fn volume_casters(&self) -> Option<&VolumeCasters> {
        self.volume_casters.as_ref()
    }

    /// Lights with shadow volumes that the frame written last sees.
    pub(super) fn volume_lights(&self) -> &[VolumeLight] {
        self.lights.volumes()
    }

    /// The lights, to change them.
    pub(super) fn lights_mut(&mut self) -> &mut Lights {
        &mut self.lights
    }

    /// All meshes.
    pub(super) fn meshes(&self) -> &Meshes {
        &self.meshes
    }

    /// A material's uniform block.
    pub(super) fn material_numbers(&self, material: usize) -> Option<Content<'_>> {
        self.materials.as_ref().map(|materials| materials.content(material))
    }

    /// The base colour texture of a material that has one and is drawn.
    pub(super) fn base_color_image(&self, scene: &Scene, material: usize) -> vk::DescriptorImageInfo {
        let texture = scene.materials[material].base_color_texture.expect("the plan says that it is sampled");
        self.image(TextureKey { texture: texture.texture, encoding: ColorEncoding::Srgb })
    }

    fn image(&self, key: TextureKey) -> vk::DescriptorImageInfo {
        let (view, sampler) = self.textures.get(key).expect("uploaded by the same list");
        vk::DescriptorImageInfo::default()
            .image_view(view)
            .sampler(sampler)
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
    }

    /// The instances that draw the lights of a shape, of the frame written last.
    pub(super) fn light_volumes(&self, shape: VolumeShape) -> Range<u32> {
        self.light_lists.volumes(shape)
    }

    /// The buffers that pipelines of this family read, for a frame slot. Families that read the same share the set.
    pub(super) fn frame_set(&self, slot: usize, family: Family) -> vk::DescriptorSet {
        let index =
            self.frame_kinds.binary_search(&family.frame()).expect("families come from the pipelines");
        let sets = self.frame_sets.as_ref().expect("every plan has a pipeline or draws nothing");
        sets.raw(slot * self.frame_kinds.len() + index)
    }

    /// A material's numbers and textures.
    pub(super) fn material_set(&self, index: usize) -> vk::DescriptorSet {
        self.material_sets.as_ref().expect("the index comes from a batch").raw(index)
    }

    /// Device memory of buffers and textures.
    pub(super) fn allocated_bytes(&self) -> u64 {
        self.frames.iter().map(FrameData::allocated_bytes).sum::<u64>()
            + self.materials.as_ref().map_or(0, Blocks::allocated_bytes)
            + self.media.as_ref().map_or(0, Blocks::allocated_bytes)
            + self.volume_casters.as_ref().map_or(0, VolumeCasters::allocated_bytes)
            + self.poses.as_ref().map_or(0, Poses::allocated_bytes)
            + self.meshes.allocated_bytes()
            + self.textures.allocated_bytes()
            + self.globe_maps.as_ref().map_or(0, GlobeMaps::allocated_bytes)
            + self.around.allocated_bytes()
    }

    /// Fills the slot's buffers with what the view sees, or with all there is; the GPU has finished with the slot.
    pub(super) fn write_frame(
        &mut self,
        slot: usize,
        view: &View<'_>,
        plan: &Plan,
        images: ([u32; 2], PreRotation),
        cull: bool,
        scattered: [f32; 2],
    ) -> Written {
        if let Some(casters) = &mut self.volume_casters {
            casters.write(slot);
        }
        let Self { objects, lights, light_lists, decals, particles, ambient_nt, .. } = self;
        let scene = Everything { objects, lights, light_lists, decals, particles, ambient_nt: *ambient_nt };
        self.frames[slot].write(view, plan, images, scene, cull, scattered)
    }

    /// Binds what a batch's draw reads, unless `bound` says that it is bound already.
    pub(super) fn bind_mesh(
        &self,
        recorder: &Recorder<'_>,
        batch: &Batch,
        bound: &mut BoundMesh,
        changes: &mut StateChanges,
    ) {
        const MOST_STREAMS: usize = 5;
        let (piece, geometry, range) = self.meshes.drawn(batch.mesh);
        let (Some(vertices), Some(indices)) = (geometry.vertices(), geometry.indices()) else { return };
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        if bound.group != Some((piece, range.group)) {
            let offsets = &geometry.groups()[range.group].offsets_bytes;
            let buffers = [vertices.raw(); MOST_STREAMS];
            // SAFETY: both lists are of one length, and offsets lie inside the buffer.
            unsafe { device.cmd_bind_vertex_buffers(raw, 0, &buffers[..offsets.len()], offsets) };
            bound.group = Some((piece, range.group));
            changes.vertex_buffers += 1;
        }
        if bound.indices != Some((piece, range.index_width)) {
            let offset = geometry.index_offset_bytes(range.index_width);
            // SAFETY: the offset lies inside the buffer and is a multiple of the index size.
            unsafe {
                device.cmd_bind_index_buffer(raw, indices.raw(), offset, range.index_width.index_type())
            };
            bound.indices = Some((piece, range.index_width));
            changes.index_buffers += 1;
        }
    }

    /// Draws some of the visible instances of a batch.
    pub(super) fn draw(
        &self,
        recorder: &Recorder<'_>,
        batch: &Batch,
        instances: Range<u32>,
        counts: &mut FrameCounts,
    ) {
        let (.., range) = self.meshes.drawn(batch.mesh);
        // SAFETY: `bind_mesh` bound the buffers, and the ranges lie inside them.
        unsafe {
            recorder.device().raw().cmd_draw_indexed(
                recorder.raw(),
                range.index_count,
                instances.len() as u32,
                range.first_index,
                range.vertex_offset,
                instances.start,
            );
        }
        counts.draws += 1;
        counts.triangles += u64::from(range.index_count / 3) * instances.len() as u64;
    }

    /// One set per frame slot and kind.
    fn write_frame_sets(
        &mut self,
        device: &Device,
        pipelines: &Pipelines,
        shadows: Option<&ShadowResources>,
    ) -> Result<()> {
        let layouts = frame_layouts(pipelines);
        let layouts = layouts.values().map(|l| (l.sets[0].raw(), l.bindings[0].as_slice()));
        let slots = self.frames.len();
        let wanted: Vec<_> = (0..slots).flat_map(|_| layouts.clone()).collect();
        let Some(sets) = DescriptorSets::new(device, &wanted, "frame")? else { return Ok(()) };
        for (index, (_, bindings)) in wanted.iter().enumerate() {
            for &(binding, ty, ..) in *bindings {
                let globe_maps = self.globe_maps.as_ref();
                let globe_maps = globe_maps.filter(|_| binding == const { shared("BINDING_GLOBE_MAPS") });
                let images = globe_maps.map(GlobeMaps::content);
                if let Some(content) = images.or_else(|| self.around.content(binding)) {
                    sets.write(index, binding, ty, &content);
                    continue;
                }
                let slot = index / self.frame_kinds.len();
                let frame = &self.frames[slot];
                if let Some(shadows) = shadows.filter(|_| binding == const { shared("BINDING_SHADOW_MAP") }) {
                    sets.write(index, binding, ty, &Content::Images(vec![shadows.map()]));
                    continue;
                }
                let buffer = match binding {
                    b if b == const { shared("BINDING_FRAME") } => frame.uniforms.as_ref(),
                    b if b == const { shared("BINDING_INSTANCES") } => frame.instances.as_ref(),
                    b if b == const { shared("BINDING_LIGHTMAPS") } => frame.lightmap_rects.as_ref(),
                    b if b == const { shared("BINDING_LIGHTS") } => frame.lights.as_ref(),
                    b if b == const { shared("BINDING_DECALS") } => frame.decals.as_ref(),
                    b if b == const { shared("BINDING_PARTICLES") } => frame.particles.as_ref(),
                    b if b == const { shared("BINDING_SHADOW_VIEWS") } => shadows.map(|s| s.views(slot)),
                    b if b == const { shared("BINDING_CASTERS") } => {
                        self.volume_casters.as_ref().map(VolumeCasters::meshes)
                    }
                    b if b == const { shared("BINDING_CASTER_INSTANCES") } => {
                        self.volume_casters.as_ref().map(|casters| casters.instances(slot))
                    }
                    _ => frame.light_lists.as_ref(),
                };
                // What a pipeline reads exists.
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
        for batch in self.objects.batches_mut() {
            let key = (batch.pipeline, batch.material);
            if keys.last() != Some(&key) {
                keys.push(key);
            }
            batch.material_set = keys.len() - 1;
        }
        for key in self.decals.materials().chain(self.particles.materials()) {
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
        let set_of = |key| keys.iter().position(|known| *known == key).expect("all were put there");
        self.decals.set_material_sets(set_of);
        self.particles.set_material_sets(set_of);
        let wanted: Vec<_> = keys
            .iter()
            .map(|(pipeline, _)| {
                let layout = pipelines.layout_of(*pipeline);
                let set = pipelines.families[*pipeline].material_set();
                (layout.sets[set].raw(), layout.bindings[set].as_slice())
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
            let medium = self.media.as_ref().filter(|_| material_kind(plan, pipeline).transmits);
            if let Some(media) = medium {
                let binding = const { shared("BINDING_MEDIUM") };
                sets.write(index, binding, vk::DescriptorType::UNIFORM_BUFFER, &media.content(material));
            }
            let images: Vec<_> = material_textures(scene, &material_kind(plan, pipeline), material)
                .map(|key| self.image(key))
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
    /// By piece of the meshes.
    group: Option<(usize, usize)>,
    /// Likewise.
    indices: Option<(usize, super::IndexWidth)>,
}

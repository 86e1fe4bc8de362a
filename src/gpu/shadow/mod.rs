//! Shadow maps: one depth image in tiles, drawn before the main pass where something changed, sampled by what lights surfaces.
//!
//! Tiles are kept from frame to frame. One is drawn again when its view is another (the light was changed, or the camera has
//! left a cascade's lattice cell) or what stands still was moved, and then all of it: a tiler clears it on the tile, loads
//! nothing and stores it once. Where only dynamic casters have moved, no more is drawn than the part of the tile that they
//! have left or entered: it begins as a copy of the static map, and has nothing but them drawn into it.

mod casters;
mod draw;
mod lights;
mod pipelines;
mod static_map;
mod tiles;

use std::sync::Arc;

use ash::vk;
use glam::Mat4;

use super::descriptor::{Content, DescriptorSets};
use super::meshes::Meshes;
use super::scene_data::SceneData;
use super::shader::shared;
use super::shared::{InstanceData, ShadowViewData};
use super::{
    Buffer, BufferDesc, Device, Image, ImageDesc, MemoryUse, Owned, PipelineCache, StreamKind, conv,
};
use crate::plan::{Plan, ShadowFigures, ShadowMap, ShadowOptions, planned_bytes};
use crate::scene::{Aabb, Light, Scene};
use crate::visible::ShadowShape;
use crate::{Error, Result};
#[cfg(feature = "view")]
use crate::{scene::Camera, visible::ShadowView};
use casters::{Batch, Casters};
use lights::LightViews;
use pipelines::{CasterPipelines, TilePipelines};
pub(super) use pipelines::{caster_bindings, caster_input, caster_modules};
use static_map::StaticMap;
use tiles::{Moves, Tiles};

/// What lighting reads: the map and where its tiles are.
pub(super) struct ShadowResources {
    sampler: Owned<vk::Sampler>,
    image: Image,
    /// One per frame slot.
    views: Vec<Buffer>,
}

/// What recording a frame's shadows took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecordedShadows {
    /// Tiles that were drawn; the others were kept.
    pub tiles: usize,
    /// Of these, tiles of which no more was drawn than where dynamic casters moved, over a copy of what stands still.
    pub composed: usize,
    /// Tiles of the static map that were drawn.
    pub static_tiles: usize,
    /// Tiles that should have been drawn, but had to wait ([`super::RendererConfig::shadow_tiles_per_frame`]).
    pub waiting: usize,
    /// Draw calls.
    pub draws: usize,
    /// Casters drawn, once for each tile.
    pub casters: usize,
    /// Casters that were not, because they are out of a tile's view or beyond its light's range.
    pub culled: usize,
    /// Triangles of the casters drawn.
    pub triangles: u64,
    /// Vertices of the casters' meshes, once for each draw call.
    pub vertices: u64,
    /// Bytes of the map, and of the static one, that were stored.
    pub stored_bytes: u64,
    /// Bytes of the static map that were copied.
    pub copied_bytes: u64,
}

impl RecordedShadows {
    pub(super) fn figures(self) -> ShadowFigures {
        ShadowFigures {
            tiles_drawn: self.tiles,
            tiles_composed: self.composed,
            static_tiles_drawn: self.static_tiles,
            tiles_waiting: self.waiting,
            draws: self.draws,
            casters: self.casters,
            casters_culled: self.culled,
            stored_bytes: planned_bytes(self.stored_bytes),
            copied_bytes: planned_bytes(self.copied_bytes),
        }
    }
}

impl ShadowResources {
    /// Makes the map's image; with `capture` it can be read back.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] if the device has no such depth images to sample; [`crate::Error::Vulkan`].
    pub(super) fn new(device: &Device, map: &ShadowMap, slots: usize, capture: bool) -> Result<Self> {
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        // Some GPUs leave images uncompressed that can be copied from.
        let usage = if capture { usage | vk::ImageUsageFlags::TRANSFER_SRC } else { usage };
        let format = conv::format(map.format);
        let image = Image::new(device, &ImageDesc::new("shadow map", format, map.size, usage))?;
        let views = (0..slots).map(|_| {
            let bytes = (map.tiles.len() * size_of::<ShadowViewData>()) as u64;
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
            Buffer::new(device, &BufferDesc { name: "shadow views", bytes, usage, memory: MemoryUse::Upload })
        });
        Ok(Self { sampler: sampler(device, format)?, image, views: views.collect::<Result<_>>()? })
    }

    /// Where a slot's tiles are.
    pub(super) fn views(&self, slot: usize) -> &Buffer {
        &self.views[slot]
    }

    /// The map, as it is while surfaces are lit.
    pub(super) fn map(&self) -> vk::DescriptorImageInfo {
        vk::DescriptorImageInfo::default()
            .image_view(self.image.view())
            .sampler(self.sampler.raw())
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
    }

    pub(super) fn allocated_bytes(&self) -> u64 {
        self.image.allocated_bytes() + self.views.iter().map(Buffer::allocated_bytes).sum::<u64>()
    }
}

/// Compares a depth with the four texels around a place, and interpolates where the device can.
fn sampler(device: &Device, format: vk::Format) -> Result<Owned<vk::Sampler>> {
    // SAFETY: the physical device is alive.
    let properties =
        unsafe { device.instance().get_physical_device_format_properties(device.physical_device(), format) };
    let linear = vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
    let filter = match properties.optimal_tiling_features.contains(linear) {
        true => vk::Filter::LINEAR,
        false => vk::Filter::NEAREST,
    };
    let info = vk::SamplerCreateInfo::default()
        .mag_filter(filter)
        .min_filter(filter)
        .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .compare_enable(true)
        // Depth is reversed: lit is what is at least as near as the map's depth.
        .compare_op(vk::CompareOp::GREATER_OR_EQUAL)
        .max_lod(vk::LOD_CLAMP_NONE);
    // SAFETY: the structure uses no feature and no extension.
    unsafe { device.create_sampler(&info, "shadow map") }
}

/// Draws the shadow map of one scene.
pub(super) struct Shadows {
    // In order of destruction.
    instance_sets: DescriptorSets,
    material_sets: Option<DescriptorSets>,
    static_map: Option<StaticMap>,
    framebuffer: Owned<vk::Framebuffer>,
    pipelines: Arc<TilePipelines>,
    /// What areas of the pass are best multiples of, texels.
    granularity: [u32; 2],
    /// One a frame slot, with the moves that it knows of.
    instances: Vec<(Buffer, Option<Moves>)>,
    resources: ShadowResources,
    /// Of each batch of casters, its set among `material_sets`.
    material_set_of: Vec<Option<usize>>,
    map: ShadowMap,
    /// In the map's order.
    lights: Vec<LightViews>,
    /// Of each batch of casters, where the streams that it reads begin in the vertex buffer, and how many they are.
    stream_offsets: Vec<([u64; MOST_STREAMS], usize)>,
    casters: Casters,
    bounds_world: Aabb,
    tiles: Tiles,
    most_tiles: usize,
    options: ShadowOptions,
    /// Whether the image has content, and so a layout.
    in_use: bool,
}

impl Shadows {
    pub(super) fn new(
        device: &Device,
        scene: &Scene,
        (plan, map): (&Plan, &ShadowMap),
        (resources, data): (ShadowResources, &SceneData),
        most_tiles: usize,
        (cache, old): (&PipelineCache, Option<&Self>),
    ) -> Result<Self> {
        let pipelines = match old.filter(|old| TilePipelines::serve(&old.map, map)) {
            Some(old) => Arc::clone(&old.pipelines),
            None => Arc::new(TilePipelines::new(device, map, cache)?),
        };
        // SAFETY: the pass is alive.
        let granularity = unsafe { device.raw().get_render_area_granularity(pipelines.pass.raw()) };
        let static_map = StaticMap::new(device, map, &pipelines)?;
        let framebuffer = pipelines.framebuffer(device, &resources.image, map.size)?;
        let casters = Casters::new(scene, map);
        let bytes = (casters.count() * size_of::<InstanceData>()) as u64;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let buffer =
            |_| Buffer::new(device, &BufferDesc { name: "casters", bytes, usage, memory: MemoryUse::Upload });
        let instances: Vec<_> = (0..resources.views.len()).map(buffer).collect::<Result<_>>()?;
        let first = &pipelines.casters.layouts[0];
        let wanted = vec![(first.sets[0].raw(), first.bindings[0].as_slice()); instances.len()];
        let instance_sets =
            DescriptorSets::new(device, &wanted, "shadow casters")?.expect("there is a slot at least");
        let binding = const { shared("BINDING_INSTANCES") };
        for (slot, buffer) in instances.iter().enumerate() {
            let content = Content::Buffer(buffer, 0, buffer.size_bytes());
            instance_sets.write(slot, binding, vk::DescriptorType::STORAGE_BUFFER, &content);
        }
        let (material_sets, material_set_of) =
            material_sets(device, scene, &pipelines.casters, &casters.batches, data)?;
        let bounds_world = lit_bounds(scene).expect("shadows are planned only where something is lit");
        Ok(Self {
            instance_sets,
            material_sets,
            static_map,
            framebuffer,
            pipelines,
            granularity: [granularity.width, granularity.height],
            instances: instances.into_iter().map(|buffer| (buffer, None)).collect(),
            resources,
            material_set_of,
            map: map.clone(),
            lights: LightViews::of(scene, &plan.options.shadows, map),
            stream_offsets: casters.batches.iter().map(|b| stream_offsets(data.meshes(), map, b)).collect(),
            casters,
            bounds_world,
            tiles: Tiles::new(map.tiles.len()),
            most_tiles,
            options: plan.options.shadows.clone(),
            in_use: false,
        })
    }

    /// Moves an element of `Scene::instances`.
    pub(super) fn set_instance(&mut self, index: usize, world_from_object: &Mat4) {
        if let Some(bounds) = self.casters.set(index, world_from_object).copied() {
            self.hold(&bounds);
        }
    }

    /// A mesh has these bounds now, and other vertices.
    pub(super) fn set_bounds(&mut self, mesh: usize, bounds_object: &Aabb) {
        if let Some(bounds) = self.casters.set_bounds(mesh, bounds_object) {
            self.hold(&bounds);
        }
    }

    /// Cascades reach this too.
    fn hold(&mut self, bounds: &Aabb) {
        let all = self.bounds_world.union(bounds);
        if all != self.bounds_world {
            // More than now is needed, because all cascades' depths change with it.
            let more = (all.max - all.min) * 0.25;
            self.bounds_world = Aabb { min: all.min - more, max: all.max + more };
        }
    }

    /// Whether a light's shadow can become that of another light.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if that takes other tiles.
    pub(super) fn check_light(&self, index: usize, light: &Light) -> Result<()> {
        let mapped = self.lights.iter().find(|l| l.index() == index);
        let shape = ShadowShape::of(light);
        match mapped.filter(|l| shape.is_some_and(|shape| shape != l.shape())) {
            Some(mapped) => Err(Error::unsupported(
                format!(
                    "light {index} ('{}') would need a shadow of shape {shape:?}, and the plan has {:?}",
                    light.name,
                    mapped.shape()
                ),
                "make a plan and a renderer of the scene with the new light",
            )),
            None => Ok(()),
        }
    }

    /// Changes an element of `Scene::lights`, which [`Self::check_light`] has checked.
    pub(super) fn set_light(&mut self, index: usize, light: &Light) {
        let Self { lights, options, .. } = self;
        if let Some(mapped) = lights.iter_mut().find(|l| l.index() == index) {
            mapped.set(light, options);
        }
    }

    /// Hands out the views that a frame's directional lights take.
    #[cfg(feature = "view")]
    pub(super) fn cascades(&self, camera: &Camera, aspect: f64, mut add: impl FnMut(ShadowView)) {
        for light in self.lights.iter().filter(|light| light.shape() == ShadowShape::Cascades) {
            light.views(camera, aspect, &self.bounds_world, |_, view| view.into_iter().for_each(&mut add));
        }
    }

    /// Keeps nothing of what was drawn.
    pub(super) fn redraw(&mut self) {
        self.tiles.forget();
        self.in_use = false;
        self.static_map.iter_mut().for_each(|map| map.in_use = false);
    }

    /// The map, which is in SHADER_READ_ONLY_OPTIMAL between frames if something was drawn.
    pub(super) fn image(&self) -> Option<&Image> {
        self.in_use.then_some(&self.resources.image)
    }

    /// Whether both are drawn with the same pipelines.
    pub(super) fn shares_pipelines(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.pipelines, &other.pipelines)
    }

    /// Device memory of the map and of what it is drawn with.
    pub(super) fn allocated_bytes(&self) -> u64 {
        self.resources.allocated_bytes()
            + self.static_map.as_ref().map_or(0, StaticMap::allocated_bytes)
            + self.instances.iter().map(|(b, _)| b.allocated_bytes()).sum::<u64>()
    }
}

/// How many casters a map is drawn from.
pub(super) fn caster_count(scene: &Scene, map: &ShadowMap) -> usize {
    Casters::new(scene, map).count()
}

/// Compiles the pipelines that a map is drawn with.
pub(super) fn prepare_casters(device: &Device, map: &ShadowMap, cache: &PipelineCache) -> Result<()> {
    TilePipelines::new(device, map, cache).map(drop)
}

/// Positions, texture coordinates, colours.
const MOST_STREAMS: usize = 3;

fn stream_offsets(meshes: &Meshes, map: &ShadowMap, batch: &Batch) -> ([u64; MOST_STREAMS], usize) {
    let mask = map.casters[batch.pipeline].mask;
    let (_, geometry, range) = meshes.drawn(batch.mesh);
    let group = &geometry.groups()[range.group];
    let read = |kind| match kind {
        StreamKind::Position => true,
        StreamKind::Texcoords => mask.is_some_and(|m| m.textured),
        StreamKind::Color => mask.is_some_and(|m| m.vertex_color),
        StreamKind::Normal | StreamKind::Tangent => false,
    };
    let streams = group.streams.list();
    let offsets = streams.iter().zip(&group.offsets_bytes).filter(|((kind, _), _)| read(*kind));
    let mut all = [0; MOST_STREAMS];
    let mut count = 0;
    for (to, (_, offset)) in all.iter_mut().zip(offsets) {
        *to = *offset;
        count += 1;
    }
    (all, count)
}

/// Sets of the materials that masks need, one for each material and pipeline, and which of them a batch uses.
fn material_sets(
    device: &Device,
    scene: &Scene,
    pipelines: &CasterPipelines,
    batches: &[Batch],
    data: &SceneData,
) -> Result<(Option<DescriptorSets>, Vec<Option<usize>>)> {
    let mut keys: Vec<(usize, usize)> = Vec::new();
    let mut set_of = Vec::with_capacity(batches.len());
    for batch in batches {
        let key = batch.material.map(|material| (batch.pipeline, material));
        keys.extend(key.filter(|key| keys.last() != Some(key)));
        set_of.push(key.map(|_| keys.len() - 1));
    }
    let wanted: Vec<_> = keys
        .iter()
        .map(|&(pipeline, _)| {
            let layout = &pipelines.layouts[pipeline];
            (layout.sets[1].raw(), layout.bindings[1].as_slice())
        })
        .collect();
    let Some(sets) = DescriptorSets::new(device, &wanted, "shadow materials")? else {
        return Ok((None, set_of));
    };
    for (index, &(pipeline, material)) in keys.iter().enumerate() {
        for &(binding, ty, ..) in &pipelines.layouts[pipeline].bindings[1] {
            let content = match ty {
                vk::DescriptorType::UNIFORM_BUFFER => data.material_numbers(material),
                _ => Some(Content::Images(vec![data.base_color_image(scene, material)])),
            };
            if let Some(content) = content {
                sets.write(index, binding, ty, &content);
            }
        }
    }
    Ok((Some(sets), set_of))
}

/// The bounds of what shadows can be seen on.
fn lit_bounds(scene: &Scene) -> Option<Aabb> {
    let lit = scene.drawn_instances().filter(|i| !scene.materials[scene.meshes[i.mesh].material].unlit);
    lit.filter_map(|i| Some(scene.meshes[i.mesh].bounds()?.transformed(&i.world_from_object)))
        .reduce(|a, b| a.union(&b))
}

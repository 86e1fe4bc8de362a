//! The static map: what stands still, beside the shadow map, for tiles in which something else moves.
//!
//! A tile in which only dynamic casters have moved begins as a copy of the static map and gets those drawn over it. The copy
//! is a triangle that writes the depths it reads, so that it stays on the tile: nothing is loaded, and a texel is read
//! once and stored once. (A transfer and LOAD would read and write everything twice; sampling both maps and taking the
//! darker saves the copy, but doubles what every lit pixel samples in every frame, moved or not.)

use std::sync::Arc;

use ash::vk;

use super::super::descriptor::{Binding, Content, DescriptorSets, set_layout};
use super::super::shader::{Module, shared};
use super::super::{Device, Image, ImageDesc, Owned, Recorder, conv};
use super::pipelines::{Builder, TilePipelines};
use crate::Result;
use crate::plan::ShadowMap;

/// Draws the copy.
pub(super) struct Compose {
    // In order of destruction.
    pipeline: Owned<vk::Pipeline>,
    layout: Owned<vk::PipelineLayout>,
    set_layout: Owned<vk::DescriptorSetLayout>,
}

/// The map that is copied, of [`Compose::bindings`].
const BINDING: (u32, vk::DescriptorType) = (shared("BINDING_SHADOW_MAP"), vk::DescriptorType::SAMPLED_IMAGE);

impl Compose {
    pub(super) fn new(builder: &Builder<'_>) -> Result<Self> {
        let device = builder.device;
        let set_layout = set_layout(device, &Self::bindings(), "static shadow map")?;
        let raw = [set_layout.raw()];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&raw);
        // SAFETY: the set layout is alive.
        let layout = unsafe { device.create_pipeline_layout(&info, "static shadow map") }?;
        let pipeline = builder.base(Some(Module::ShadowCompose), &layout, "shadow compose")?;
        Ok(Self { pipeline, layout, set_layout })
    }

    fn bindings() -> [Binding; 1] {
        [(BINDING.0, BINDING.1, 1, vk::ShaderStageFlags::FRAGMENT)]
    }
}

pub(super) struct StaticMap {
    // In order of destruction.
    sets: DescriptorSets,
    pub(super) framebuffer: Owned<vk::Framebuffer>,
    pub(super) image: Image,
    /// Whether the image has content, and so a layout.
    pub(super) in_use: bool,
    /// What its copy is drawn with.
    pipelines: Arc<TilePipelines>,
}

impl StaticMap {
    /// `None` if the map has none.
    pub(super) fn new(
        device: &Device,
        map: &ShadowMap,
        pipelines: &Arc<TilePipelines>,
    ) -> Result<Option<Self>> {
        let Some(compose) = &pipelines.compose else { return Ok(None) };
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let desc = ImageDesc::new("static shadow map", conv::format(map.format), map.size, usage);
        let image = Image::new(device, &desc)?;
        let framebuffer = pipelines.framebuffer(device, &image, map.size)?;
        let wanted = [(compose.set_layout.raw(), &Compose::bindings()[..])];
        let sets = DescriptorSets::new(device, &wanted, "static shadow map")?.expect("one set is asked for");
        let info = vk::DescriptorImageInfo::default()
            .image_view(image.view())
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        sets.write(0, BINDING.0, BINDING.1, &Content::Images(vec![info]));
        Ok(Some(Self { sets, framebuffer, image, in_use: false, pipelines: Arc::clone(pipelines) }))
    }

    /// Draws the copy over the render area of the pass that is being recorded.
    pub(super) fn draw_copy(&self, recorder: &Recorder<'_>) {
        let Some(compose) = &self.pipelines.compose else { return };
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the pipeline was made for this pass, the set with its layout; the triangle reads no vertices.
        unsafe {
            device.cmd_bind_pipeline(raw, point, compose.pipeline.raw());
            device.cmd_bind_descriptor_sets(raw, point, compose.layout.raw(), 0, &[self.sets.raw(0)], &[]);
            device.cmd_draw(raw, 3, 1, 0, 0);
        }
    }

    pub(super) fn allocated_bytes(&self) -> u64 {
        self.image.allocated_bytes()
    }
}

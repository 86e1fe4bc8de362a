//! Pipelines and their layouts, exactly those that the plan lists.

mod family;
mod modules;
mod parts;
mod state;

use std::collections::BTreeMap;
use std::ffi::CStr;

use ash::vk;

pub(super) use family::{BEHIND_DEPTH, BEHIND_LIGHT, Family, FamilyLayout, OTHER};
pub(super) use modules::gbuffer_constants;
use modules::modules;
pub use parts::PipelineParts;
use state::{FixedState, VertexInput};

use super::descriptor::Binding;
use super::pass::VulkanPass;
use super::post::PostParts;
use super::shader::AttachmentPlaces;
use super::{Called, Device, Owned, PipelineCache};
use crate::plan::{Pipeline, Plan};
use crate::{Error, Result};

const ENTRY: &CStr = c"main";

/// Everything that a frame binds.
pub(super) struct Pipelines {
    /// In the order of `Plan::pipelines`.
    pub(super) pipelines: Vec<Owned<vk::Pipeline>>,
    /// Likewise.
    pub(super) families: Vec<Family>,
    /// By stage and pipeline: which pipeline of the stage draws what that pipeline of surfaces draws.
    drawn_by: Vec<Vec<Option<usize>>>,
    pub(super) layouts: BTreeMap<Family, FamilyLayout>,
}

impl Pipelines {
    /// The layout of the n-th pipeline's descriptor sets.
    pub(super) fn layout_of(&self, pipeline: usize) -> &FamilyLayout {
        &self.layouts[&self.families[pipeline]]
    }

    /// The pipeline that draws, in this stage, the surfaces of a [`Pipeline::Surface`].
    pub(super) fn drawing(&self, stage: usize, surface: usize) -> Option<usize> {
        self.drawn_by[stage][surface]
    }

    pub(super) fn new(
        device: &Device,
        plan: &Plan,
        passes: &[VulkanPass],
        cache: &PipelineCache,
    ) -> Result<Self> {
        if !plan.volume_lights.is_empty() && !device.features().depth_clamp {
            return Err(Error::unsupported(
                "the plan has shadow volumes, and the device was made without depthClamp and shaderClipDistance",
                "enable both and say so in `Features`, or leave `Options::shadow_volumes` out",
            ));
        }
        let families: Vec<_> =
            plan.pipelines.iter().map(|(stage, pipeline)| Family::of(plan, *stage, pipeline)).collect();
        let mut layouts = BTreeMap::new();
        let of_post = plan.post.passes.iter().map(|pass| PostParts::of(plan, pass).family);
        for family in families.iter().copied().chain(of_post) {
            if let std::collections::btree_map::Entry::Vacant(entry) = layouts.entry(family) {
                entry.insert(FamilyLayout::new(device, family)?);
            }
        }
        let builder = Builder { device, plan, cache };
        let pipelines = plan
            .pipelines
            .iter()
            .zip(&families)
            .map(|((stage, pipeline), family)| {
                let (pass, subpass, _) = plan.subpass(*stage);
                let layout = layouts[family].layout.raw();
                let place = Place { pass: &passes[pass], subpass, layout };
                builder.build(*stage, pipeline, place)
            })
            .collect::<Result<_>>()?;
        let drawn_by = (0..plan.stage_count()).map(|stage| drawn_by(plan, stage)).collect();
        Ok(Self { pipelines, families, drawn_by, layouts })
    }
}

fn drawn_by(plan: &Plan, stage: usize) -> Vec<Option<usize>> {
    let of = |(_, pipeline): &(usize, Pipeline)| {
        let Pipeline::Surface(kind) = pipeline else { return None };
        let draws = |(s, p): &(usize, Pipeline)| *s == stage && p.draws(kind);
        plan.pipelines.iter().position(draws)
    };
    plan.pipelines.iter().map(of).collect()
}

struct Place<'a> {
    pass: &'a VulkanPass,
    subpass: usize,
    layout: vk::PipelineLayout,
}

struct Builder<'a> {
    device: &'a Device,
    plan: &'a Plan,
    cache: &'a PipelineCache,
}

impl Builder<'_> {
    fn build(&self, index: usize, pipeline: &Pipeline, place: Place<'_>) -> Result<Owned<vk::Pipeline>> {
        let plan = self.plan;
        let (vertex, fragment, constants) = modules(plan, pipeline);
        let places = AttachmentPlaces::of(plan.subpass(index).2)?;
        let shaders = self.cache.modules().shaders(vertex, fragment, &constants, &places)?;
        let name = plan.pipeline_text(pipeline);
        let module = |spirv: &Vec<u32>| shader_module(self.device, spirv, &name);
        let vertex = module(&shaders.vertex)?;
        let fragment = shaders.fragment.as_ref().map(module).transpose()?;
        let stage = |stage, module: &Owned<vk::ShaderModule>| {
            vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module.raw()).name(ENTRY)
        };
        let vertex = stage(vk::ShaderStageFlags::VERTEX, &vertex);
        let fragment = fragment.as_ref().map(|module| stage(vk::ShaderStageFlags::FRAGMENT, module));
        let stages: Vec<_> = std::iter::once(vertex).chain(fragment).collect();
        let input = VertexInput::new(pipeline, &shaders.attributes)?;
        let state = FixedState::new(plan, index, pipeline);
        self.create(&stages, &input, &state, place, &name)
    }

    fn create(
        &self,
        stages: &[vk::PipelineShaderStageCreateInfo<'_>],
        input: &VertexInput,
        state: &FixedState,
        place: Place<'_>,
        name: &str,
    ) -> Result<Owned<vk::Pipeline>> {
        let input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&input.bindings)
            .vertex_attribute_descriptions(&input.attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let (mut rendering, blend) = match place.pass {
            VulkanPass::RenderPass(..) => (None, None),
            VulkanPass::Rendering(r) => {
                (Some(r.parts(place.subpass)), Some(r.blend(place.subpass, &state.blend)))
            }
        };
        let multisample =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(state.samples);
        let blend = vk::PipelineColorBlendStateCreateInfo::default()
            .flags(state.blend_flags)
            .attachments(blend.as_ref().unwrap_or(&state.blend));
        let dynamic = vk::PipelineDynamicStateCreateInfo::default()
            .dynamic_states(&[vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR]);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&state.raster)
            .multisample_state(&multisample)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(place.layout);
        // Of a rendering's attachments each pipeline knows, depth included.
        let unused_depth = vk::PipelineDepthStencilStateCreateInfo::default();
        let info = match (&state.depth, &rendering) {
            (Some(depth), _) => info.depth_stencil_state(depth),
            (None, Some(_)) => info.depth_stencil_state(&unused_depth),
            (None, None) => info,
        };
        let info = match (place.pass, &mut rendering) {
            (VulkanPass::RenderPass(pass, _), _) => {
                info.render_pass(pass.raw()).subpass(place.subpass as u32)
            }
            (_, Some(parts)) => info
                .push_next(&mut parts.formats)
                .push_next(&mut parts.locations)
                .push_next(&mut parts.inputs),
            (_, None) => info,
        };
        // SAFETY: everything that `info` points to outlives the call, and the modules match the layouts (a test
        // compares them).
        let created = unsafe {
            self.device.raw().create_graphics_pipelines(self.cache.raw(), &[info], self.device.callbacks())
        };
        let raw = created.map_err(|(_, result)| result).called("vkCreateGraphicsPipelines")?;
        Ok(Owned::new(self.device, raw[0], name))
    }
}

pub(super) fn shader_module(device: &Device, spirv: &[u32], name: &str) -> Result<Owned<vk::ShaderModule>> {
    let info = vk::ShaderModuleCreateInfo::default().code(spirv);
    // SAFETY: the words are SPIR-V that the shader compiler made, and what `prune` leaves of it stays valid; tests validate
    // both.
    unsafe { device.create_shader_module(&info, name) }
}

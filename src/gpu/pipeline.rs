//! Pipelines and their layouts, exactly those that the plan lists.

use std::collections::BTreeMap;
use std::ffi::CStr;

use ash::vk;

use super::shader::{self, bindings};
use super::{Called, Device, Owned, PipelineCache, VertexInput};
use crate::Result;
use crate::plan::{Pipeline, Plan, SurfaceKind};

const ENTRY: &CStr = c"main";

/// One binding of a descriptor set layout: number, type, array size, stages.
type Binding = (u32, vk::DescriptorType, u32, vk::ShaderStageFlags);

/// Pipelines that take the same descriptor sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Family {
    /// Frame, instances, materials; and this many textures.
    Surface { textures: usize },
    /// Frame, lights; and the G-buffer.
    Lighting,
    /// Frame; and the light target.
    Tonemap,
}

impl Family {
    pub(super) fn of(pipeline: &Pipeline) -> Self {
        match pipeline {
            Pipeline::Surface(kind) => Self::Surface { textures: kind.textures.count_ones() as usize },
            Pipeline::Lighting => Self::Lighting,
            Pipeline::Tonemap => Self::Tonemap,
        }
    }

    /// The bindings of `SET_FRAME`, and of `SET_MATERIAL` or `SET_INPUTS` where there is one.
    fn sets(self) -> [Vec<Binding>; 2] {
        use vk::{DescriptorType as T, ShaderStageFlags as S};
        let uniforms = |stages| (bindings::BINDING_FRAME, T::UNIFORM_BUFFER, 1, stages);
        let buffer = |binding, stages| (binding, T::STORAGE_BUFFER, 1, stages);
        let inputs = |count: u32| (0..count).map(|i| (i, T::INPUT_ATTACHMENT, 1, S::FRAGMENT)).collect();
        match self {
            Self::Surface { textures } => [
                vec![
                    uniforms(S::VERTEX | S::FRAGMENT),
                    buffer(bindings::BINDING_INSTANCES, S::VERTEX),
                    buffer(bindings::BINDING_MATERIALS, S::FRAGMENT),
                ],
                match textures as u32 {
                    0 => Vec::new(),
                    n => vec![(bindings::BINDING_TEXTURES, T::COMBINED_IMAGE_SAMPLER, n, S::FRAGMENT)],
                },
            ],
            Self::Lighting => {
                [vec![uniforms(S::FRAGMENT), buffer(bindings::BINDING_LIGHTS, S::FRAGMENT)], inputs(3)]
            }
            Self::Tonemap => [vec![uniforms(S::FRAGMENT)], inputs(1)],
        }
    }
}

/// Descriptor set layouts and pipeline layout of a [`Family`].
pub(super) struct FamilyLayout {
    pub(super) sets: Vec<Owned<vk::DescriptorSetLayout>>,
    pub(super) layout: Owned<vk::PipelineLayout>,
    pub(super) bindings: [Vec<Binding>; 2],
}

impl FamilyLayout {
    fn new(device: &Device, family: Family) -> Result<Self> {
        let bindings = family.sets();
        let sets = bindings.iter().filter(|b| !b.is_empty());
        let sets: Vec<_> = sets.map(|b| set_layout(device, family, b)).collect::<Result<_>>()?;
        let raw: Vec<_> = sets.iter().map(Owned::raw).collect();
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&raw);
        // SAFETY: the set layouts are alive and belong to this device.
        let layout = unsafe { device.create_pipeline_layout(&info, &format!("{family:?}")) }?;
        Ok(Self { sets, layout, bindings })
    }
}

fn set_layout(device: &Device, family: Family, bindings: &[Binding]) -> Result<Owned<vk::DescriptorSetLayout>> {
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
    // SAFETY: binding numbers are distinct by `Family::sets`.
    unsafe { device.create_descriptor_set_layout(&info, &format!("{family:?}")) }
}

/// Everything that a frame binds.
pub(super) struct Pipelines {
    /// In the order of `Plan::pipelines`.
    pub(super) pipelines: Vec<Owned<vk::Pipeline>>,
    pub(super) layouts: BTreeMap<Family, FamilyLayout>,
}

impl Pipelines {
    pub(super) fn new(
        device: &Device,
        plan: &Plan,
        passes: &[Owned<vk::RenderPass>],
        cache: &PipelineCache,
    ) -> Result<Self> {
        let mut layouts = BTreeMap::new();
        for (_, pipeline) in &plan.pipelines {
            let family = Family::of(pipeline);
            if let std::collections::btree_map::Entry::Vacant(entry) = layouts.entry(family) {
                entry.insert(FamilyLayout::new(device, family)?);
            }
        }
        let builder = Builder { device, plan, cache };
        let pipelines = plan
            .pipelines
            .iter()
            .map(|(stage, pipeline)| {
                let (pass, subpass, _) = plan.subpass(*stage);
                let layout = layouts[&Family::of(pipeline)].layout.raw();
                let place = Place { pass: passes[pass].raw(), subpass: subpass as u32, layout };
                builder.build(*stage, pipeline, place)
            })
            .collect::<Result<_>>()?;
        Ok(Self { pipelines, layouts })
    }
}

struct Place {
    pass: vk::RenderPass,
    subpass: u32,
    layout: vk::PipelineLayout,
}

struct Builder<'a> {
    device: &'a Device,
    plan: &'a Plan,
    cache: &'a PipelineCache,
}

impl Builder<'_> {
    fn build(&self, stage: usize, pipeline: &Pipeline, place: Place) -> Result<Owned<vk::Pipeline>> {
        let plan = self.plan;
        let options = &plan.options;
        let output = shader::OutputConstants { tonemap: options.tonemap, dither: options.dither };
        let (vertex, fragment, constants) = match pipeline {
            Pipeline::Surface(kind) => {
                let textured = kind.textures != 0;
                let fragment = match plan.needs.lit {
                    None => shader::unlit(textured),
                    Some(_) => shader::geometry_fragment(options.layout, plan.has_light_target(), textured),
                };
                let output = plan.needs.lit.is_none().then_some(output);
                (shader::geometry_vertex(kind), fragment, shader::surface_constants(kind, output))
            }
            Pipeline::Lighting => {
                let constants = shader::LightingConstants {
                    directional: plan.needs.directional_lights > 0,
                    point: plan.needs.point_lights > 0,
                    spot: plan.needs.spot_lights > 0,
                    fold: plan.folded,
                    output,
                };
                (shader::fullscreen(), shader::lighting(options.layout), constants.specialization())
            }
            Pipeline::Tonemap => (shader::fullscreen(), shader::tonemap(), output.specialization()),
        };
        let vertex = self.module(vertex)?;
        let fragment = self.module(fragment)?;
        let entries: Vec<_> = constants.entries().collect();
        let data = constants.bytes();
        let special = vk::SpecializationInfo::default().map_entries(&entries).data(data);
        let stages = [
            vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::VERTEX)
                .module(vertex.raw())
                .name(ENTRY),
            vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::FRAGMENT)
                .module(fragment.raw())
                .name(ENTRY)
                .specialization_info(&special),
        ];
        let kind = match pipeline {
            Pipeline::Surface(kind) => Some(kind),
            _ => None,
        };
        let input = kind.map(VertexInput::of).unwrap_or_default();
        let state = FixedState::new(plan.subpass(stage).2, kind);
        self.create(&stages, &input, &state, place, &plan.pipeline_text(pipeline))
    }

    fn create(
        &self,
        stages: &[vk::PipelineShaderStageCreateInfo<'_>],
        input: &VertexInput,
        state: &FixedState,
        place: Place,
        name: &str,
    ) -> Result<Owned<vk::Pipeline>> {
        let input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&input.bindings)
            .vertex_attribute_descriptions(&input.attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let multisample = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&state.blend);
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
            .layout(place.layout)
            .render_pass(place.pass)
            .subpass(place.subpass);
        let info = match &state.depth {
            Some(depth) => info.depth_stencil_state(depth),
            None => info,
        };
        // SAFETY: everything that `info` points to outlives the call, and the modules match the layouts (a test
        // compares both with the shared header).
        let created = unsafe {
            self.device.raw().create_graphics_pipelines(self.cache.raw(), &[info], self.device.callbacks())
        };
        let raw = created.map_err(|(_, result)| result).called("vkCreateGraphicsPipelines")?;
        Ok(Owned::new(self.device, raw[0], name))
    }

    fn module(&self, module: &shader::Module) -> Result<Owned<vk::ShaderModule>> {
        let info = vk::ShaderModuleCreateInfo::default().code(module.words());
        // SAFETY: the words are SPIR-V that the shader compiler made and a test validates.
        unsafe { self.device.create_shader_module(&info, module.name()) }
    }
}

/// Fixed-function state of a subpass's pipelines.
struct FixedState {
    raster: vk::PipelineRasterizationStateCreateInfo<'static>,
    depth: Option<vk::PipelineDepthStencilStateCreateInfo<'static>>,
    blend: Vec<vk::PipelineColorBlendAttachmentState>,
}

impl FixedState {
    fn new(subpass: &crate::plan::Subpass, kind: Option<&SurfaceKind>) -> Self {
        let cull = match kind {
            Some(kind) if !kind.double_sided => vk::CullModeFlags::BACK,
            _ => vk::CullModeFlags::NONE,
        };
        // Clip space has y down, so triangles that are counter-clockwise in the world stay so on the image.
        let front = match kind {
            Some(kind) if kind.mirrored => vk::FrontFace::CLOCKWISE,
            _ => vk::FrontFace::COUNTER_CLOCKWISE,
        };
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(cull)
            .front_face(front)
            .line_width(1.0);
        let depth = subpass.depth.map(|_| {
            vk::PipelineDepthStencilStateCreateInfo::default()
                .depth_test_enable(true)
                .depth_write_enable(true)
                .depth_compare_op(vk::CompareOp::GREATER)
        });
        let all = vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
        let one = if subpass.blend {
            all.blend_enable(true)
                .src_color_blend_factor(vk::BlendFactor::ONE)
                .dst_color_blend_factor(vk::BlendFactor::ONE)
                .color_blend_op(vk::BlendOp::ADD)
                .src_alpha_blend_factor(vk::BlendFactor::ONE)
                .dst_alpha_blend_factor(vk::BlendFactor::ONE)
                .alpha_blend_op(vk::BlendOp::ADD)
        } else {
            all
        };
        Self { raster, depth, blend: vec![one; subpass.colors.len()] }
    }
}

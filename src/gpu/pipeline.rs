//! Pipelines and their layouts, exactly those that the plan lists.

use std::collections::BTreeMap;
use std::ffi::CStr;

use ash::vk;

use super::shader::{
    GeometryConstants, LightingConstants, Module, OutputConstants, Specialization, TextureSlot, shared,
};
use super::{Called, Device, Owned, PipelineCache, StreamKind, texel_bytes};
use crate::Result;
use crate::plan::{Pipeline, Plan, SurfaceKind};

use super::descriptor::Binding;
use super::scene_data::vertex_streams;

const ENTRY: &CStr = c"main";

/// Pipelines that take the same descriptor sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Family {
    /// Frame, instances; and a material with this many textures.
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
        let uniforms = |stages| (const { shared("BINDING_FRAME") }, T::UNIFORM_BUFFER, 1, stages);
        let buffer = |binding, stages| (binding, T::STORAGE_BUFFER, 1, stages);
        let inputs = |count: u32| (0..count).map(|i| (i, T::INPUT_ATTACHMENT, 1, S::FRAGMENT)).collect();
        match self {
            Self::Surface { textures } => [
                vec![
                    uniforms(S::VERTEX | S::FRAGMENT),
                    buffer(const { shared("BINDING_INSTANCES") }, S::VERTEX),
                ],
                std::iter::once((const { shared("BINDING_MATERIAL") }, T::UNIFORM_BUFFER, 1, S::FRAGMENT))
                    .chain((textures > 0).then(|| {
                        let count = textures as u32;
                        (const { shared("BINDING_TEXTURES") }, T::COMBINED_IMAGE_SAMPLER, count, S::FRAGMENT)
                    }))
                    .collect(),
            ],
            Self::Lighting => [
                vec![uniforms(S::FRAGMENT), buffer(const { shared("BINDING_LIGHTS") }, S::FRAGMENT)],
                inputs(3),
            ],
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

fn set_layout(
    device: &Device,
    family: Family,
    bindings: &[Binding],
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
        let (vertex, fragment, constants) = modules(plan, pipeline);
        let vertex = self.module(vertex)?;
        let fragment = self.module(fragment)?;
        let entries: Vec<_> = constants.ids.iter().enumerate().map(|(i, &id)| map_entry(id, i)).collect();
        let special = vk::SpecializationInfo::default()
            .map_entries(&entries)
            .data(bytemuck::cast_slice(&constants.data));
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
        let input = kind.map(VertexInput::new).transpose()?.unwrap_or_default();
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

    fn module(&self, module: Module) -> Result<Owned<vk::ShaderModule>> {
        let info = vk::ShaderModuleCreateInfo::default().code(module.spirv()?);
        // SAFETY: the words are SPIR-V that the shader compiler made and a test validates.
        unsafe { self.device.create_shader_module(&info, &module.name()) }
    }
}

/// Vertex and fragment shader of a pipeline, and what the latter is specialised with.
fn modules(plan: &Plan, pipeline: &Pipeline) -> (Module, Module, Specialization) {
    let layout = plan.options.layout;
    let output = OutputConstants { tonemap: plan.options.tonemap, dither: plan.options.dither };
    match pipeline {
        Pipeline::Surface(kind) => {
            let textured = kind.textures != 0;
            let constants = surface_constants(kind).specialization();
            let vertex = vertex_module(kind);
            match plan.needs.lit {
                None => (vertex, Module::Unlit { textured }, constants.and(output.specialization())),
                Some(_) => {
                    let light_target = plan.has_light_target();
                    (vertex, Module::GeometryFragment { layout, light_target, textured }, constants)
                }
            }
        }
        Pipeline::Lighting => {
            let constants = LightingConstants {
                has_directional: plan.needs.directional_lights > 0,
                has_point: plan.needs.point_lights > 0,
                has_spot: plan.needs.spot_lights > 0,
                fold: plan.folded.then_some(output),
            };
            (Module::Fullscreen, Module::Lighting { layout }, constants.specialization())
        }
        Pipeline::Tonemap => (Module::Fullscreen, Module::Tonemap, output.specialization()),
    }
}

fn vertex_module(kind: &SurfaceKind) -> Module {
    Module::GeometryVertex {
        normal: !kind.unlit,
        texcoord: kind.textures != 0,
        tangent: kind.needs_tangents(),
        color: kind.vertex_color,
    }
}

fn surface_constants(kind: &SurfaceKind) -> GeometryConstants {
    let slot = |slot: usize| {
        kind.texture_index(slot).map(|index| TextureSlot {
            slot: index as u32,
            second_texcoord: kind.second_texcoord & (1 << slot) != 0,
            transformed: kind.transformed & (1 << slot) != 0,
        })
    };
    GeometryConstants {
        textures: std::array::from_fn(slot),
        alpha_mask: kind.alpha_mask,
        double_sided: kind.double_sided,
        unlit: kind.unlit,
        vertex_color: kind.vertex_color,
        emissive: kind.emissive,
        ambient: kind.ambient,
    }
}

/// Vertex attributes in the order of their streams.
#[derive(Default)]
struct VertexInput {
    bindings: Vec<vk::VertexInputBindingDescription>,
    attributes: Vec<vk::VertexInputAttributeDescription>,
}

impl VertexInput {
    fn new(kind: &SurfaceKind) -> Result<Self> {
        let mut input = Self::default();
        for (binding, (stream, format)) in (0..).zip(vertex_streams(kind).list()) {
            let location = match stream {
                StreamKind::Position => const { shared("ATTRIBUTE_POSITION") },
                StreamKind::Normal => const { shared("ATTRIBUTE_NORMAL") },
                StreamKind::Tangent => const { shared("ATTRIBUTE_TANGENT") },
                StreamKind::Texcoords => const { shared("ATTRIBUTE_TEXCOORD") },
                StreamKind::Color => const { shared("ATTRIBUTE_COLOR") },
            };
            let stride = texel_bytes(format)?;
            let input_rate = vk::VertexInputRate::VERTEX;
            input.bindings.push(vk::VertexInputBindingDescription { binding, stride, input_rate });
            input.attributes.push(vk::VertexInputAttributeDescription {
                location,
                binding,
                format,
                offset: 0,
            });
        }
        Ok(input)
    }
}

fn map_entry(id: u32, index: usize) -> vk::SpecializationMapEntry {
    let size = size_of::<u32>();
    vk::SpecializationMapEntry { constant_id: id, offset: (index * size) as u32, size }
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
        let all =
            vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
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

//! The pass that draws one tile of the shadow map, and its pipelines.

use ash::vk;

use super::super::descriptor::{Binding, set_layout};
use super::super::pipeline::shader_module;
use super::super::shader::{
    AttachmentPlaces, GeometryConstants, Module, Specialization, TextureSlot, shared,
};
use super::super::shared::ShadowPush;
use super::super::{Called, Device, Image, Owned, PipelineCache, conv, texel_bytes};
use super::static_map::Compose;
use crate::Result;
use crate::plan::{CasterKind, CasterMask, ShadowMap};

/// How far casters are pushed away from the light at least, in steps of the depth's precision, for surfaces that face it.
pub(super) const CONSTANT_BIAS: f32 = 2.0;

/// Draws a tile: the render area, of which nothing is loaded, and all is stored. The image is in
/// DEPTH_STENCIL_ATTACHMENT_OPTIMAL before and after; who draws tiles moves it there once for all of them, and tiles do not
/// overlap, so the pass has nothing to wait for.
///
/// A triangle clears the tile. The pass could do it, but then an image of several tiles is cleared several times in a row, in
/// which the checks of Arm and IMG, who do not look at areas, see useless stores.
fn tile_pass(device: &Device, format: vk::Format) -> Result<Owned<vk::RenderPass>> {
    let layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    let attachments = [vk::AttachmentDescription::default()
        .format(format)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::DONT_CARE)
        .store_op(vk::AttachmentStoreOp::STORE)
        .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
        .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
        .initial_layout(layout)
        .final_layout(layout)];
    let depth = vk::AttachmentReference { attachment: 0, layout };
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .depth_stencil_attachment(&depth)];
    let info = vk::RenderPassCreateInfo::default().attachments(&attachments).subpasses(&subpasses);
    // SAFETY: every array outlives the call; the only reference is to the only attachment.
    unsafe { device.create_render_pass(&info, "shadow tile") }
}

/// What tiles are drawn with, wherever in the map they lie.
pub(super) struct TilePipelines {
    // In order of destruction.
    pub(super) casters: CasterPipelines,
    /// `None` without a static map.
    pub(super) compose: Option<Compose>,
    pub(super) pass: Owned<vk::RenderPass>,
}

impl TilePipelines {
    pub(super) fn new(device: &Device, map: &ShadowMap, cache: &PipelineCache) -> Result<Self> {
        let pass = tile_pass(device, conv::format(map.format))?;
        let builder = Builder { device, pass: &pass, cache };
        let casters = CasterPipelines::new(map, &builder)?;
        let compose = map.has_static_map.then(|| Compose::new(&builder)).transpose()?;
        Ok(Self { casters, compose, pass })
    }

    /// Whether those of one map serve another.
    pub(super) fn serve(one: &ShadowMap, other: &ShadowMap) -> bool {
        let of = |map: &ShadowMap| (map.format, map.casters.clone(), map.has_static_map);
        of(one) == of(other)
    }

    pub(super) fn framebuffer(
        &self,
        device: &Device,
        image: &Image,
        size: [u32; 2],
    ) -> Result<Owned<vk::Framebuffer>> {
        let views = [image.view()];
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(self.pass.raw())
            .attachments(&views)
            .width(size[0])
            .height(size[1])
            .layers(1);
        // SAFETY: the view is alive and of the format that the pass was made from.
        unsafe { device.create_framebuffer(&info, "shadow map") }
    }
}

/// Pipelines of one layout: solid casters', or those of masks that are textured or not.
pub(super) struct CasterLayout {
    pub(super) sets: Vec<Owned<vk::DescriptorSetLayout>>,
    pub(super) bindings: Vec<Vec<Binding>>,
    pub(super) layout: Owned<vk::PipelineLayout>,
}

/// One pipeline per kind of caster, in the order of `ShadowMap::casters`.
pub(super) struct CasterPipelines {
    pub(super) pipelines: Vec<Owned<vk::Pipeline>>,
    /// One triangle over the whole tile, as far away as can be.
    pub(super) clear: Owned<vk::Pipeline>,
    pub(super) layouts: Vec<CasterLayout>,
}

impl CasterPipelines {
    pub(super) fn new(map: &ShadowMap, builder: &Builder<'_>) -> Result<Self> {
        let layout = |kind| CasterLayout::new(builder.device, kind);
        let layouts: Vec<_> = map.casters.iter().map(layout).collect::<Result<_>>()?;
        let all = map.casters.iter().zip(&layouts);
        let pipelines = all.map(|(kind, layout)| builder.caster(kind, layout)).collect::<Result<_>>()?;
        Ok(Self { pipelines, clear: builder.base(None, &layouts[0].layout, "shadow clear")?, layouts })
    }
}

impl CasterLayout {
    fn new(device: &Device, kind: &CasterKind) -> Result<Self> {
        let bindings = caster_bindings(kind);
        let sets: Vec<_> =
            bindings.iter().map(|b| set_layout(device, b, "shadow caster")).collect::<Result<_>>()?;
        let raw: Vec<_> = sets.iter().map(Owned::raw).collect();
        let push = [vk::PushConstantRange {
            stage_flags: vk::ShaderStageFlags::VERTEX,
            offset: 0,
            size: size_of::<ShadowPush>() as u32,
        }];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&raw).push_constant_ranges(&push);
        // SAFETY: the set layouts are alive; the push constants are fewer than the 128 bytes of every device.
        let layout = unsafe { device.create_pipeline_layout(&info, &format!("shadow caster, {kind}")) }?;
        Ok(Self { sets, bindings, layout })
    }
}

/// Makes what the pass needs.
pub(super) struct Builder<'a> {
    pub(super) device: &'a Device,
    pub(super) pass: &'a Owned<vk::RenderPass>,
    pub(super) cache: &'a PipelineCache,
}

impl Builder<'_> {
    fn caster(&self, kind: &CasterKind, layout: &CasterLayout) -> Result<Owned<vk::Pipeline>> {
        // As the main pass draws it: faces that point away from the light cast no shadow, unless both sides exist. Depth is
        // reversed, so away from the light is down.
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(if kind.double_sided { vk::CullModeFlags::NONE } else { vk::CullModeFlags::BACK })
            .front_face(match kind.mirrored {
                true => vk::FrontFace::CLOCKWISE,
                false => vk::FrontFace::COUNTER_CLOCKWISE,
            })
            .depth_bias_enable(true)
            // Each tile sets its own; the checks of Arm look here.
            .depth_bias_constant_factor(-CONSTANT_BIAS)
            .line_width(1.0);
        let input = caster_input(kind.mask.as_ref())?;
        let (compare, name) = (vk::CompareOp::GREATER, format!("shadow caster, {kind}"));
        self.build(&caster_modules(kind), &input, &raster, compare, &layout.layout, &name)
    }

    /// What a tile begins with: one triangle that is as far away as can be, or where its fragment shader says.
    pub(super) fn base(
        &self,
        fragment: Option<Module>,
        layout: &Owned<vk::PipelineLayout>,
        name: &str,
    ) -> Result<Owned<vk::Pipeline>> {
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(vk::CullModeFlags::NONE)
            .line_width(1.0);
        let (input, always) = (VertexInput::default(), vk::CompareOp::ALWAYS);
        let modules = (Module::Fullscreen, fragment, Specialization::default());
        self.build(&modules, &input, &raster, always, layout, name)
    }

    #[allow(clippy::too_many_arguments, reason = "what sets the two kinds of pipelines apart")]
    fn build(
        &self,
        (vertex, fragment, constants): &(Module, Option<Module>, Specialization),
        (bindings, attributes): &VertexInput,
        raster: &vk::PipelineRasterizationStateCreateInfo<'_>,
        compare: vk::CompareOp,
        layout: &Owned<vk::PipelineLayout>,
        name: &str,
    ) -> Result<Owned<vk::Pipeline>> {
        let shaders =
            self.cache.modules().shaders(*vertex, *fragment, constants, &AttachmentPlaces::default())?;
        let module = |spirv: &Vec<u32>| shader_module(self.device, spirv, name);
        let vertex = module(&shaders.vertex)?;
        let fragment = shaders.fragment.as_ref().map(module).transpose()?;
        let stage = |stage, module: &Owned<vk::ShaderModule>| {
            vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module.raw()).name(c"main")
        };
        let fragment = fragment.as_ref().map(|module| stage(vk::ShaderStageFlags::FRAGMENT, module));
        let vertex = stage(vk::ShaderStageFlags::VERTEX, &vertex);
        let stages: Vec<_> = std::iter::once(vertex).chain(fragment).collect();
        let input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(bindings)
            .vertex_attribute_descriptions(attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let multisample = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(true)
            .depth_write_enable(true)
            .depth_compare_op(compare);
        let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR, vk::DynamicState::DEPTH_BIAS];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(raster)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth)
            .dynamic_state(&dynamic)
            .layout(layout.raw())
            .render_pass(self.pass.raw())
            .subpass(0);
        let device = self.device;
        // SAFETY: everything that `info` points to outlives the call, and the modules match the layout (a test compares
        // them).
        let created =
            unsafe { device.raw().create_graphics_pipelines(self.cache.raw(), &[info], device.callbacks()) };
        let raw = created.map_err(|(_, result)| result).called("vkCreateGraphicsPipelines")?;
        Ok(Owned::new(device, raw[0], name))
    }
}

/// Vertex and fragment shader of a caster, the latter for masks, and what they are specialised with. The first and only
/// texture of a mask's descriptors is the base colour.
pub(in crate::gpu) fn caster_modules(kind: &CasterKind) -> (Module, Option<Module>, Specialization) {
    let Some(mask) = &kind.mask else { return (Module::ShadowVertex, None, Specialization::default()) };
    let base_color = mask.textured.then_some(TextureSlot {
        slot: 0,
        second_texcoord: mask.second_texcoord,
        transformed: mask.transformed,
    });
    let constants = GeometryConstants {
        textures: [base_color, None, None, None, None],
        alpha_mask: true,
        vertex_color: mask.vertex_color,
        ..GeometryConstants::default()
    };
    (Module::ShadowVertex, Some(Module::Mask), constants.specialization())
}

/// What a caster's shaders read: the instances, and a mask's material.
pub(in crate::gpu) fn caster_bindings(kind: &CasterKind) -> Vec<Vec<Binding>> {
    use vk::{DescriptorType as T, ShaderStageFlags as S};
    let instances = (const { shared("BINDING_INSTANCES") }, T::STORAGE_BUFFER, 1, S::VERTEX);
    let mut bindings = vec![vec![instances]];
    if let Some(mask) = kind.mask {
        let numbers = (const { shared("BINDING_MATERIAL") }, T::UNIFORM_BUFFER, 1, S::FRAGMENT);
        let texture = (const { shared("BINDING_TEXTURES") }, T::COMBINED_IMAGE_SAMPLER, 1, S::FRAGMENT);
        bindings.push(std::iter::once(numbers).chain(mask.textured.then_some(texture)).collect());
    }
    bindings
}

pub(in crate::gpu) type VertexInput =
    (Vec<vk::VertexInputBindingDescription>, Vec<vk::VertexInputAttributeDescription>);

/// Positions, and what a mask reads, each a stream of its own.
pub(in crate::gpu) fn caster_input(mask: Option<&CasterMask>) -> Result<VertexInput> {
    const POSITION: (u32, vk::Format) = (shared("ATTRIBUTE_POSITION"), vk::Format::R32G32B32_SFLOAT);
    let texcoords = mask.filter(|m| m.textured).map(|m| {
        let both = m.both_texcoords;
        let format = if both { vk::Format::R32G32B32A32_SFLOAT } else { vk::Format::R32G32_SFLOAT };
        (const { shared("ATTRIBUTE_TEXCOORD") }, format)
    });
    let colors = mask
        .filter(|m| m.vertex_color)
        .map(|_| (const { shared("ATTRIBUTE_COLOR") }, vk::Format::R32G32B32A32_SFLOAT));
    let mut input = VertexInput::default();
    for (binding, (location, format)) in (0..).zip([Some(POSITION), texcoords, colors].into_iter().flatten())
    {
        let (stride, input_rate) = (texel_bytes(format)?, vk::VertexInputRate::VERTEX);
        input.0.push(vk::VertexInputBindingDescription { binding, stride, input_rate });
        input.1.push(vk::VertexInputAttributeDescription { location, binding, format, offset: 0 });
    }
    Ok(input)
}

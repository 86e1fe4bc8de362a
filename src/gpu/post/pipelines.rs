//! Render passes, pipelines and samplers of passes after the frame's own.

use ash::vk;

use super::super::pipeline::shader_module;
use super::super::shader::{AttachmentPlaces, Module, Specialization, shared};
use super::super::{Called, Device, Owned, PipelineCache, conv};
use crate::Result;
use crate::plan::{Access, Plan, PostPass, PostPlace, State};

/// One attachment: drawn to and stored. What it samples was stored by passes before it, which say so.
pub(super) fn render_pass(device: &Device, plan: &Plan, pass: &PostPass) -> Result<Owned<vk::RenderPass>> {
    use vk::{AccessFlags as A, ImageLayout as L, PipelineStageFlags as S};
    let (format, after) = match pass.target {
        PostPlace::Image(image) => (plan.post.images[image].format, State::Sampled),
        _ => (plan.options.output.into(), State::after_frame(plan.options.output_use)),
    };
    let attachments = [vk::AttachmentDescription::default()
        .format(conv::format(format))
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::DONT_CARE)
        .store_op(vk::AttachmentStoreOp::STORE)
        .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
        .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
        .initial_layout(L::UNDEFINED)
        .final_layout(conv::layout(after))];
    let color = [vk::AttachmentReference { attachment: 0, layout: L::COLOR_ATTACHMENT_OPTIMAL }];
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&color)];
    let host = match pass.target {
        PostPlace::Image(_) => Some(Access::SampledRead),
        _ => Access::after_frame(plan.options.output_use),
    };
    let (host_stages, host_access) = conv::scope(&host.into_iter().collect());
    let dependencies = [
        // Who sampled or copied what was there before.
        vk::SubpassDependency::default()
            .src_subpass(vk::SUBPASS_EXTERNAL)
            .dst_subpass(0)
            .src_stage_mask(S::FRAGMENT_SHADER | S::COLOR_ATTACHMENT_OUTPUT | S::TRANSFER | host_stages)
            .src_access_mask(A::COLOR_ATTACHMENT_WRITE)
            .dst_stage_mask(S::COLOR_ATTACHMENT_OUTPUT)
            .dst_access_mask(A::COLOR_ATTACHMENT_WRITE),
        vk::SubpassDependency::default()
            .src_subpass(0)
            .dst_subpass(vk::SUBPASS_EXTERNAL)
            .src_stage_mask(S::COLOR_ATTACHMENT_OUTPUT)
            .src_access_mask(A::COLOR_ATTACHMENT_WRITE)
            .dst_stage_mask(match host {
                Some(_) => host_stages,
                // Presenting waits for a semaphore.
                None => S::BOTTOM_OF_PIPE,
            })
            .dst_access_mask(host_access),
    ];
    let info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(&subpasses)
        .dependencies(&dependencies);
    // SAFETY: every array outlives the call; the only reference is to the only attachment.
    unsafe { device.create_render_pass(&info, &pass.name) }
}

/// Where the only attachment is.
pub(in crate::gpu) fn places() -> AttachmentPlaces {
    AttachmentPlaces { targets: vec![const { shared("TARGET_OUTPUT") }], inputs: Vec::new() }
}

/// Covers the image.
pub(super) fn pipeline(
    device: &Device,
    cache: &PipelineCache,
    (fragment, constants): (Module, &Specialization),
    layout: vk::PipelineLayout,
    pass: &Owned<vk::RenderPass>,
    name: &str,
) -> Result<Owned<vk::Pipeline>> {
    let places = places();
    let shaders = cache.modules().shaders(Module::Fullscreen, Some(fragment), constants, &places)?;
    let vertex = shader_module(device, &shaders.vertex, name)?;
    let fragment = shader_module(device, shaders.fragment.as_deref().unwrap_or_default(), name)?;
    let stage = |stage, module: &Owned<vk::ShaderModule>| {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module.raw()).name(c"main")
    };
    let stages =
        [stage(vk::ShaderStageFlags::VERTEX, &vertex), stage(vk::ShaderStageFlags::FRAGMENT, &fragment)];
    let input = vk::PipelineVertexInputStateCreateInfo::default();
    let assembly =
        vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .cull_mode(vk::CullModeFlags::NONE)
        .line_width(1.0);
    let multisample =
        vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let blend =
        [vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA)];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blend);
    let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&multisample)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .render_pass(pass.raw())
        .subpass(0);
    // SAFETY: everything that `info` points to outlives the call, and the modules match the layout (a test compares them).
    let created = unsafe { device.raw().create_graphics_pipelines(cache.raw(), &[info], device.callbacks()) };
    let raw = created.map_err(|(_, result)| result).called("vkCreateGraphicsPipelines")?;
    Ok(Owned::new(device, raw[0], name))
}

/// Ends at the edge of the image.
pub(super) fn sampler(device: &Device, filter: vk::Filter) -> Result<Owned<vk::Sampler>> {
    let info = vk::SamplerCreateInfo::default()
        .mag_filter(filter)
        .min_filter(filter)
        .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .max_lod(vk::LOD_CLAMP_NONE);
    // SAFETY: the structure uses no feature and no extension.
    unsafe { device.create_sampler(&info, "post") }
}

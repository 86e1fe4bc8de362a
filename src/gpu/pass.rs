//! Vulkan render passes from the plan's.

use ash::vk;

use super::{Device, Owned, conv};
use crate::plan::{Dependency, Pass, Plan, Subpass};
use crate::{Error, Result};

/// Creates what the plan says, nothing more.
///
/// # Errors
/// [`Error::Vulkan`]; [`Error::Unsupported`] if the plan needs a feature that the device was made without.
pub fn create_render_pass(device: &Device, plan: &Plan, pass: &Pass) -> Result<Owned<vk::RenderPass>> {
    if pass.subpasses.iter().any(|s| s.ordered) && !device.features().ordered_attachment_access {
        return Err(Error::unsupported(
            "the plan adds light or decals in the shader, and the device was made without \
             rasterizationOrderColorAttachmentAccess (VK_EXT_rasterization_order_attachment_access)",
            "enable it and say so in `Features`, or use --lights clusters, --layout ontile128 or --decals barrier",
        ));
    }
    let attachments: Vec<_> = pass
        .attachments
        .iter()
        .map(|a| {
            let format = plan.attachments[a.attachment].format;
            vk::AttachmentDescription::default()
                .format(conv::format(format))
                .samples(conv::samples(plan.attachments[a.attachment].samples))
                .load_op(conv::load_op(a.load))
                .store_op(conv::store_op(a.store))
                .stencil_load_op(conv::load_op(a.stencil.0))
                .stencil_store_op(conv::store_op(a.stencil.1))
                .initial_layout(conv::layout(a.initial))
                .final_layout(conv::layout(a.last))
        })
        .collect();
    let references: Vec<_> = pass.subpasses.iter().map(References::new).collect();
    let subpasses: Vec<_> = references.iter().map(References::description).collect();
    let dependencies: Vec<_> = pass.dependencies.iter().map(dependency).collect();
    let info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(&subpasses)
        .dependencies(&dependencies);
    // SAFETY: every array outlives the call; indices are positions in `pass.attachments` by the plan.
    unsafe { device.create_render_pass(&info, &pass.name) }
}

/// Attachment references of one subpass, kept alive while Vulkan reads them.
struct References {
    colors: Vec<vk::AttachmentReference>,
    /// As many, or none.
    resolves: Vec<vk::AttachmentReference>,
    inputs: Vec<vk::AttachmentReference>,
    depth: Option<vk::AttachmentReference>,
    preserve: Vec<u32>,
    flags: vk::SubpassDescriptionFlags,
}

impl References {
    fn new(subpass: &Subpass) -> Self {
        let reference =
            |&i: &usize, state| vk::AttachmentReference { attachment: i as u32, layout: conv::layout(state) };
        let colors = subpass.colors.iter().zip(&subpass.color_states);
        let inputs = subpass.inputs.iter().zip(&subpass.input_states);
        Self {
            colors: colors.map(|(i, &state)| reference(i, state)).collect(),
            resolves: subpass.resolve.map_or(Vec::new(), |resolve| {
                let unused = vk::AttachmentReference {
                    attachment: vk::ATTACHMENT_UNUSED,
                    layout: vk::ImageLayout::UNDEFINED,
                };
                let mut resolves = vec![unused; subpass.colors.len()];
                resolves[resolve.from] = reference(&resolve.to, resolve.state);
                resolves
            }),
            inputs: inputs.map(|(i, &state)| reference(i, state)).collect(),
            depth: subpass.depth.as_ref().zip(subpass.depth_state).map(|(i, state)| reference(i, state)),
            preserve: subpass.preserve.iter().map(|&i| i as u32).collect(),
            flags: match subpass.ordered {
                true => vk::SubpassDescriptionFlags::RASTERIZATION_ORDER_ATTACHMENT_COLOR_ACCESS_EXT,
                false => vk::SubpassDescriptionFlags::empty(),
            },
        }
    }

    fn description(&self) -> vk::SubpassDescription<'_> {
        let description = vk::SubpassDescription::default()
            .flags(self.flags)
            .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
            .color_attachments(&self.colors)
            .input_attachments(&self.inputs)
            .preserve_attachments(&self.preserve);
        let description = match self.resolves.is_empty() {
            true => description,
            false => description.resolve_attachments(&self.resolves),
        };
        match &self.depth {
            Some(depth) => description.depth_stencil_attachment(depth),
            None => description,
        }
    }
}

fn dependency(d: &Dependency) -> vk::SubpassDependency {
    let end = |s: Option<usize>| s.map_or(vk::SUBPASS_EXTERNAL, |s| s as u32);
    let (src_stages, src_access) = conv::scope(&d.before);
    let (dst_stages, dst_access) = conv::scope(&d.after);
    vk::SubpassDependency::default()
        .src_subpass(end(d.from))
        .dst_subpass(end(d.to))
        .src_stage_mask(src_stages)
        .src_access_mask(src_access)
        .dst_stage_mask(dst_stages)
        .dst_access_mask(dst_access)
        .dependency_flags(if d.by_region {
            vk::DependencyFlags::BY_REGION
        } else {
            vk::DependencyFlags::empty()
        })
}

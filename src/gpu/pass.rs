//! The plan's passes in Vulkan: as render passes, or as renderings.

use ash::vk;

use super::rendering::{Rendering, RenderingTarget};
use super::{Device, Owned, Recorder, conv, merge_feedback};
use crate::plan::{Dependency, Load, MergeReport, Pass, PassAttachment, Plan, Strategy, Subpass};
use crate::{Error, Result};

/// A pass of the plan.
pub enum VulkanPass {
    /// A render pass, whose subpasses are the stages; and what the driver makes of them, where it says so.
    RenderPass(Owned<vk::RenderPass>, Option<MergeReport>),
    /// A dynamic rendering with local reads.
    Rendering(Rendering),
}

/// What a pass draws to.
pub enum PassTarget {
    /// With a value for each attachment up to the last that is cleared.
    Framebuffer(Owned<vk::Framebuffer>, Vec<vk::ClearValue>),
    /// Images.
    Rendering(RenderingTarget),
}

impl VulkanPass {
    /// Creates what the plan says, nothing more.
    ///
    /// # Errors
    /// [`Error::Vulkan`]; [`Error::Unsupported`] if the plan needs a feature that the device was made without.
    pub fn new(device: &Device, plan: &Plan, pass: &Pass) -> Result<Self> {
        check_features(device, pass)?;
        match plan.strategy {
            Strategy::LocalRead => Rendering::new(device, plan, pass).map(Self::Rendering),
            _ => create_render_pass(device, plan, pass),
        }
    }

    /// What the driver says it makes of subpasses.
    pub fn merge_report(&self) -> Option<&MergeReport> {
        match self {
            Self::RenderPass(_, report) => report.as_ref(),
            Self::Rendering(_) => None,
        }
    }

    /// The pass's target. `of` gives image and view of each of [`Plan::attachments`].
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn target(
        &self,
        device: &Device,
        plan: &Plan,
        pass: &Pass,
        extent: vk::Extent2D,
        of: &dyn Fn(usize) -> (vk::Image, vk::ImageView),
    ) -> Result<PassTarget> {
        let raw = match self {
            Self::RenderPass(raw, _) => raw.raw(),
            Self::Rendering(rendering) => return Ok(PassTarget::Rendering(rendering.target(plan, pass, of))),
        };
        let views: Vec<_> = pass.attachments.iter().map(|a| of(a.attachment).1).collect();
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(raw)
            .attachments(&views)
            .width(extent.width)
            .height(extent.height)
            .layers(1);
        // SAFETY: views are alive and of the formats that the pass was made from.
        let framebuffer = unsafe { device.create_framebuffer(&info, &pass.name) }?;
        Ok(PassTarget::Framebuffer(framebuffer, clear_values(plan, pass)))
    }

    /// Begins the pass, at its first stage.
    pub fn begin(&self, recorder: &Recorder<'_>, target: &PassTarget, area: vk::Rect2D) {
        match (self, target) {
            (Self::RenderPass(raw, _), PassTarget::Framebuffer(framebuffer, clear_values)) => {
                let info = vk::RenderPassBeginInfo::default()
                    .render_pass(raw.raw())
                    .framebuffer(framebuffer.raw())
                    .render_area(area)
                    .clear_values(clear_values);
                let contents = vk::SubpassContents::INLINE;
                // SAFETY: the framebuffer was made for this pass, with the clear values that it takes.
                unsafe { recorder.device().raw().cmd_begin_render_pass(recorder.raw(), &info, contents) };
            }
            (Self::Rendering(rendering), PassTarget::Rendering(target)) => {
                rendering.begin(recorder, target, area);
            }
            _ => unreachable!("a target is made by its pass"),
        }
    }

    /// Goes on to a stage after the first.
    pub fn next(&self, recorder: &Recorder<'_>, stage: usize) {
        match self {
            // SAFETY: the command buffer is recording this pass, which has another subpass.
            Self::RenderPass(..) => unsafe {
                let device = recorder.device().raw();
                device.cmd_next_subpass(recorder.raw(), vk::SubpassContents::INLINE);
            },
            Self::Rendering(rendering) => rendering.next(recorder, stage),
        }
    }

    /// What a clear within a stage calls the colour output at a location.
    pub fn color_attachment(&self, stage: usize, location: usize) -> u32 {
        match self {
            Self::RenderPass(..) => location as u32,
            Self::Rendering(rendering) => rendering.color_attachment(stage, location) as u32,
        }
    }

    /// Ends the pass.
    pub fn end(&self, recorder: &Recorder<'_>, target: &PassTarget) {
        match (self, target) {
            (Self::Rendering(rendering), PassTarget::Rendering(target)) => rendering.end(recorder, target),
            // SAFETY: the pass is being recorded and its last subpass was entered.
            _ => unsafe { recorder.device().raw().cmd_end_render_pass(recorder.raw()) },
        }
    }
}

fn clear_values(plan: &Plan, pass: &Pass) -> Vec<vk::ClearValue> {
    let is_cleared = |a: &PassAttachment| a.load == Load::Clear || a.stencil.0 == Load::Clear;
    let cleared = pass.attachments.iter().rposition(is_cleared).map_or(0, |last| last + 1);
    pass.attachments[..cleared].iter().map(|a| conv::clear_value(&plan.attachments[a.attachment])).collect()
}

fn check_features(device: &Device, pass: &Pass) -> Result<()> {
    if pass.subpasses.iter().any(|s| s.ordered) && !device.features().ordered_attachment_access {
        return Err(Error::unsupported(
            "the plan has fragments read the attachments that they write, and the device was made without \
             rasterizationOrderColorAttachmentAccess (VK_EXT_rasterization_order_attachment_access)",
            "enable it and say so in `Features`; or use --lights clusters, --layout ontile128, --decals barrier and \
             --translucency weighted",
        ));
    }
    Ok(())
}

fn create_render_pass(device: &Device, plan: &Plan, pass: &Pass) -> Result<VulkanPass> {
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
    let dependencies: Vec<_> = pass.dependencies.iter().map(dependency).collect();
    if device.features().subpass_merge_feedback {
        let made = merge_feedback::create_render_pass(device, pass, &attachments, &references, &dependencies);
        return made.map(|(raw, report)| VulkanPass::RenderPass(raw, Some(report)));
    }
    let subpasses: Vec<_> = references.iter().map(References::description).collect();
    let info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(&subpasses)
        .dependencies(&dependencies);
    // SAFETY: every array outlives the call; indices are positions in `pass.attachments` by the plan.
    let raw = unsafe { device.create_render_pass(&info, &pass.name) }?;
    Ok(VulkanPass::RenderPass(raw, None))
}

/// Attachment references of one subpass, kept alive while Vulkan reads them.
pub(super) struct References {
    pub(super) colors: Vec<vk::AttachmentReference>,
    /// As many, or none.
    pub(super) resolves: Vec<vk::AttachmentReference>,
    pub(super) inputs: Vec<vk::AttachmentReference>,
    pub(super) depth: Option<vk::AttachmentReference>,
    pub(super) preserve: Vec<u32>,
    pub(super) flags: vk::SubpassDescriptionFlags,
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
        .dependency_flags(conv::by_region(d.by_region))
}

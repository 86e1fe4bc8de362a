//! Passes after the frame's own: a draw each that covers an image and samples what was stored before.

mod pipelines;
mod target;

use ash::vk;

use super::pipeline::{Family, Pipelines, gbuffer_constants};
use super::shader::{Module, Specialization, shared, shared_names};
use super::{Device, Owned, PipelineCache};
use crate::Result;
use crate::plan::{Plan, PostKind, PostPass, PostPlace};
pub(super) use pipelines::places;
use pipelines::{pipeline, render_pass, sampler};
pub(super) use target::PostTarget;

/// Render passes and pipelines of a plan's passes.
pub(super) struct PostPasses {
    families: Vec<Family>,
    /// By pass.
    passes: Vec<Owned<vk::RenderPass>>,
    pipelines: Vec<(PostKind, Owned<vk::Pipeline>)>,
    /// For pictures and light: interpolates, and ends at the edge.
    linear: Owned<vk::Sampler>,
    /// For what has no values in between.
    nearest: Option<Owned<vk::Sampler>>,
}

/// What such a pass reads, by binding, and what its shaders are.
pub(super) struct PostParts {
    pub(super) family: Family,
    /// In the order of what it samples.
    pub(super) bindings: Vec<u32>,
    pub(super) fragment: Module,
    pub(super) constants: Specialization,
}

impl PostParts {
    pub(super) fn of(plan: &Plan, pass: &PostPass) -> Self {
        if pass.kind == PostKind::EdgeFilter {
            return Self::of_edge_filter(plan, pass);
        }
        let bindings: Vec<_> = (const { shared("BINDING_POST_COLOR") }..).take(pass.samples.len()).collect();
        let bits = bindings.iter().fold(0, |bits, b| bits | 1 << b);
        let step = match pass.kind {
            PostKind::EdgeFilter | PostKind::BloomFirst { .. } => const { shared("BLOOM_STEP_FIRST") },
            PostKind::BloomDown => const { shared("BLOOM_STEP_DOWN") },
            PostKind::BloomUp => const { shared("BLOOM_STEP_UP") },
        };
        let displayed = matches!(pass.kind, PostKind::BloomFirst { displayed: true });
        Self {
            family: Family::of_post(bits, false),
            bindings,
            fragment: Module::Bloom,
            constants: Specialization::bloom(step, displayed.then_some(plan.options.tonemap)),
        }
    }

    /// The picture comes first; depth and normals are where stages of the frame's own find them.
    fn of_edge_filter(plan: &Plan, pass: &PostPass) -> Self {
        let attachment = |place: &PostPlace| match place {
            PostPlace::Attachment(a) => Some(&plan.attachments[*a]),
            _ => None,
        };
        let sampled = pass.samples.iter().skip(1).filter_map(attachment);
        let binding = |name: &str, is_depth: bool| match is_depth {
            true => const { shared("INPUT_DEPTH") },
            false => {
                let name = name.to_uppercase();
                shared_names("INPUT_").find(|(known, _)| *known == name).map_or(0, |(_, number)| number)
            }
        };
        let inputs = sampled.clone().map(|a| binding(&a.name, a.format.is_depth()));
        let bindings: Vec<_> = [const { shared("BINDING_EDGE_COLOR") }].into_iter().chain(inputs).collect();
        let bits = bindings.iter().fold(0, |bits, b| bits | 1 << b);
        let step = sampled.map(|a| a.format.depth_step()).fold(0.0, f32::max);
        Self {
            family: Family::of_post(bits, true),
            bindings,
            fragment: Module::EdgeFilter,
            constants: gbuffer_constants(plan).specialization().and(Specialization::edge_filter(step)),
        }
    }
}

impl PostPasses {
    /// `None` if the plan has no such passes.
    pub(super) fn new(
        device: &Device,
        plan: &Plan,
        pipelines: &Pipelines,
        cache: &PipelineCache,
    ) -> Result<Option<Self>> {
        if plan.post.passes.is_empty() {
            return Ok(None);
        }
        let passes = plan.post.passes.iter().map(|pass| render_pass(device, plan, pass));
        let passes: Vec<_> = passes.collect::<Result<_>>()?;
        let mut made = Vec::new();
        for pass in plan.post.kinds() {
            let raw = plan.post.passes.iter().zip(&passes).find(|(p, _)| p.kind == pass.kind);
            let Some((_, raw)) = raw else { continue };
            let PostParts { family, fragment, constants, .. } = PostParts::of(plan, pass);
            let layout = pipelines.layouts[&family].layout.raw();
            let shader = (fragment, &constants);
            made.push((pass.kind, pipeline(device, cache, shader, layout, raw, &pass.name)?));
        }
        let uses_nearest = plan.post.passes.iter().any(|pass| pass.kind == PostKind::EdgeFilter);
        let nearest = uses_nearest.then(|| sampler(device, vk::Filter::NEAREST)).transpose()?;
        let linear = sampler(device, vk::Filter::LINEAR)?;
        let families = plan.post.passes.iter().map(|pass| PostParts::of(plan, pass).family).collect();
        Ok(Some(Self { families, passes, pipelines: made, linear, nearest }))
    }

    pub(super) fn family(&self, index: usize) -> Family {
        self.families[index]
    }

    pub(super) fn pass(&self, index: usize) -> vk::RenderPass {
        self.passes[index].raw()
    }

    pub(super) fn pipeline(&self, kind: PostKind) -> vk::Pipeline {
        let made = self.pipelines.iter().find(|(own, _)| *own == kind);
        made.map_or(vk::Pipeline::null(), |(_, pipeline)| pipeline.raw())
    }

    /// What is bound there: pictures and light are interpolated.
    pub(super) fn sampled_at(&self, binding: u32, view: vk::ImageView) -> vk::DescriptorImageInfo {
        let nearest = self.nearest.as_ref().filter(|_| binding < const { shared("BINDING_BLOOM") });
        vk::DescriptorImageInfo::default()
            .sampler(nearest.unwrap_or(&self.linear).raw())
            .image_view(view)
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
    }
}

//! What passes after the frame's own draw to and sample, for one size of picture.

use std::sync::atomic::{AtomicU32, Ordering};

use ash::vk;

use super::super::descriptor::{Content, DescriptorSets};
use super::super::pipeline::Pipelines;
use super::super::{Device, Image, ImageDesc, OutputImage, Owned, Recorder, conv};
use super::{PostParts, PostPasses};
use crate::Result;
use crate::plan::{Access, Plan, PostPlace, State};

/// Images of a target, and what binds them.
pub(in crate::gpu) struct PostTarget {
    outputs: Vec<PostOutput>,
    /// In the order of `Post::images`.
    images: Vec<Image>,
    /// Bits of the exposure that scattered light was made with; [`NONE`] before the first frame.
    exposure: AtomicU32,
}

/// What depends on the host's image.
struct PostOutput {
    image: vk::Image,
    /// By pass.
    framebuffers: Vec<Owned<vk::Framebuffer>>,
    /// By pass.
    sets: DescriptorSets,
}

/// No exposure has these bits, which are not a number.
const NONE: u32 = u32::MAX;

impl PostTarget {
    /// The images for a picture of this size in pixels.
    pub(in crate::gpu) fn images(device: &Device, plan: &Plan, size: [u32; 2]) -> Result<Vec<Image>> {
        use vk::ImageUsageFlags as U;
        let of_frame = plan.post.scattered();
        let image = |(index, image): (usize, &crate::plan::PostImage)| {
            // What the frame samples is cleared once, before there is any.
            let cleared = if of_frame == Some(index) { U::TRANSFER_DST } else { U::empty() };
            let usage = U::COLOR_ATTACHMENT | U::SAMPLED | cleared;
            let desc = ImageDesc::new(&image.name, conv::format(image.format), image.size(size), usage);
            Image::new(device, &desc)
        };
        plan.post.images.iter().enumerate().map(image).collect()
    }

    /// `view` gives the view of an attachment of the frame's own for the n-th of the host's images.
    pub(in crate::gpu) fn new(
        device: &Device,
        plan: &Plan,
        passes: &PostPasses,
        pipelines: &Pipelines,
        images: Vec<Image>,
        (outputs, size): (&[OutputImage], [u32; 2]),
        view: &dyn Fn(usize, usize) -> vk::ImageView,
    ) -> Result<Self> {
        let output = |(index, output): (usize, &OutputImage)| {
            let place = |place| match place {
                PostPlace::Attachment(attachment) => view(index, attachment),
                PostPlace::Image(image) => images[image].view(),
                PostPlace::Output => output.view,
            };
            let framebuffer = |(n, pass): (usize, &crate::plan::PostPass)| {
                let [width, height] = match pass.target {
                    PostPlace::Image(image) => images[image].size(),
                    _ => size,
                };
                let views = [place(pass.target)];
                let info = vk::FramebufferCreateInfo::default()
                    .render_pass(passes.pass(n))
                    .attachments(&views)
                    .width(width)
                    .height(height)
                    .layers(1);
                // SAFETY: the view is alive and of the format that the pass was made from.
                unsafe { device.create_framebuffer(&info, &pass.name) }
            };
            let framebuffers = plan.post.passes.iter().enumerate().map(framebuffer).collect::<Result<_>>()?;
            let parts: Vec<_> = plan.post.passes.iter().map(|pass| PostParts::of(plan, pass)).collect();
            let wanted = parts.iter().map(|parts| {
                let layout = &pipelines.layouts[&parts.family];
                let last = layout.sets.last().expect("a pass samples something");
                (last.raw(), layout.bindings[1].as_slice())
            });
            let wanted: Vec<_> = wanted.collect();
            let sets = DescriptorSets::new(device, &wanted, "post")?.expect("there are passes");
            for (set, (pass, parts)) in plan.post.passes.iter().zip(&parts).enumerate() {
                for (&from, &binding) in pass.samples.iter().zip(&parts.bindings) {
                    let info = passes.sampled_at(binding, place(from));
                    let ty = vk::DescriptorType::COMBINED_IMAGE_SAMPLER;
                    sets.write(set, binding, ty, &Content::Images(vec![info]));
                }
            }
            Ok(PostOutput { image: output.image, framebuffers, sets })
        };
        let outputs = outputs.iter().enumerate().map(output).collect::<Result<_>>()?;
        Ok(Self { outputs, images, exposure: AtomicU32::new(NONE) })
    }

    pub(in crate::gpu) fn framebuffer(&self, output: usize, pass: usize) -> vk::Framebuffer {
        self.outputs[output].framebuffers[pass].raw()
    }

    pub(in crate::gpu) fn set(&self, output: usize, pass: usize) -> vk::DescriptorSet {
        self.outputs[output].sets.raw(pass)
    }

    /// Size of what a pass draws to, where that is one of these images.
    pub(in crate::gpu) fn size(&self, place: PostPlace) -> Option<[u32; 2]> {
        match place {
            PostPlace::Image(image) => Some(self.images[image].size()),
            _ => None,
        }
    }

    /// The share of light that is scattered in a frame of this exposure, and by what to multiply what is stored of it.
    pub(in crate::gpu) fn scattered(&self, plan: &Plan, exposure: f32) -> [f32; 2] {
        match self.exposure.load(Ordering::Relaxed) {
            NONE => [0.0; 2],
            bits => {
                // What is stored is the sum of all sizes.
                let sizes = plan.post.images.iter().map(|image| image.halvings).max().unwrap_or(1);
                [plan.options.bloom_strength, exposure / (f32::from_bits(bits) * sizes as f32)]
            }
        }
    }

    /// A frame of this exposure was recorded.
    pub(in crate::gpu) fn recorded(&self, exposure: f32) {
        self.exposure.store(exposure.to_bits(), Ordering::Relaxed);
    }

    /// Before the first frame: what it samples of scattered light is none.
    pub(in crate::gpu) fn prepare(&self, recorder: &Recorder<'_>, plan: &Plan) {
        use vk::{AccessFlags as A, ImageLayout as L, PipelineStageFlags as S};
        let Some(image) = plan.post.scattered().map(|i| &self.images[i]) else { return };
        if self.exposure.load(Ordering::Relaxed) != NONE {
            return;
        }
        let barrier = |from: (A, L), to: (A, L)| {
            vk::ImageMemoryBarrier::default()
                .src_access_mask(from.0)
                .dst_access_mask(to.0)
                .old_layout(from.1)
                .new_layout(to.1)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(image.raw())
                .subresource_range(image.range())
        };
        let (none, clear, read) = (
            (A::empty(), L::UNDEFINED),
            (A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL),
            (A::SHADER_READ, L::SHADER_READ_ONLY_OPTIMAL),
        );
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let flags = vk::DependencyFlags::empty();
        let black = vk::ClearColorValue::default();
        // SAFETY: the image is alive, has the usage, and is in no render pass.
        unsafe {
            let before = [barrier(none, clear)];
            device.cmd_pipeline_barrier(raw, S::TOP_OF_PIPE, S::TRANSFER, flags, &[], &[], &before);
            device.cmd_clear_color_image(raw, image.raw(), clear.1, &black, &[image.range()]);
            let after = [barrier(clear, read)];
            device.cmd_pipeline_barrier(raw, S::TRANSFER, S::FRAGMENT_SHADER, flags, &[], &[], &after);
        }
    }

    /// Hands the host's image over, if these passes have sampled it.
    pub(in crate::gpu) fn release(&self, recorder: &Recorder<'_>, plan: &Plan, output: usize) {
        let wanted = State::after_frame(plan.options.output_use);
        let mut left = plan.passes.iter().rev().flat_map(|pass| &pass.attachments);
        let left = left.find(|a| a.attachment == 0 && plan.attachments[0].is_output).map(|a| a.last);
        if left != Some(State::Sampled) || wanted == State::Sampled {
            return;
        }
        let host = Access::after_frame(plan.options.output_use);
        let (stages, access) = conv::scope(&host.into_iter().collect());
        // Presenting waits for a semaphore.
        let stages = if stages.is_empty() { vk::PipelineStageFlags::BOTTOM_OF_PIPE } else { stages };
        let barrier = vk::ImageMemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::empty())
            .dst_access_mask(access)
            .old_layout(conv::layout(State::Sampled))
            .new_layout(conv::layout(wanted))
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(self.outputs[output].image)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                base_mip_level: 0,
                level_count: 1,
                base_array_layer: 0,
                layer_count: 1,
            });
        let none = vk::DependencyFlags::empty();
        let sampled = vk::PipelineStageFlags::FRAGMENT_SHADER;
        // SAFETY: the host keeps its image alive, and the frame left it sampled.
        unsafe {
            let device = recorder.device().raw();
            device.cmd_pipeline_barrier(recorder.raw(), sampled, stages, none, &[], &[], &[barrier]);
        }
    }
}

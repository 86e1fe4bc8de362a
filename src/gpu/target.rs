//! What a frame is drawn to: the host's images, and the attachments that exist only while a pass runs.

use std::sync::Arc;

use ash::vk;

use super::descriptor::{Content, DescriptorSets};
use super::pass::{PassTarget, VulkanPass};
use super::pipeline::{BEHIND_DEPTH, BEHIND_LIGHT, OTHER, Pipelines};
use super::post::{PostPasses, PostTarget};
use super::shader::shared;
use super::{Device, Image, ImageDesc, conv};
use crate::plan::{Format, Plan, State, check_size};
use crate::scene::{Camera, PreRotation};
use crate::{Error, Result};

/// A host's image that frames are drawn to: of the target's size, one sample, one level, of the format
/// [`Renderer::output_format`](super::Renderer::output_format), with at least the usage
/// [`Renderer::output_usage`](super::Renderer::output_usage). The host keeps image and view alive as long as the
/// [`Target`].
#[derive(Clone, Copy, Debug)]
pub struct OutputImage {
    /// The image.
    pub image: vk::Image,
    /// A 2D view of it with identity swizzle.
    pub view: vk::ImageView,
}

/// Attachments, framebuffers (or what stands for them) and input descriptors for one or more output images of one size, e.g. those of a
/// swapchain. The images share the other attachments, so frames to them must not overlap on the GPU: submitted to one
/// queue they do not, because the passes' dependencies order them.
pub struct Target {
    outputs: Vec<OutputTarget>,
    /// In the order of `Plan::attachments`; the output's place is empty.
    attachments: Vec<Option<Image>>,
    /// `None` if the plan has no passes after the frame's own.
    post: Option<PostTarget>,
    extent: vk::Extent2D,
    pre_rotation: PreRotation,
    /// Its renderer's.
    passes: Arc<[VulkanPass]>,
}

/// What depends on the output image.
struct OutputTarget {
    /// One per pass.
    passes: Vec<PassTarget>,
    sets: Option<DescriptorSets>,
    /// By stage: the index of its set among `sets`.
    set_of_stage: Vec<Option<usize>>,
}

impl Target {
    #[allow(
        clippy::too_many_arguments,
        reason = "the parts of a renderer, apart so that they can be borrowed"
    )]
    pub(super) fn new(
        device: &Device,
        plan: &Plan,
        passes: &Arc<[VulkanPass]>,
        pipelines: &Pipelines,
        post: Option<&PostPasses>,
        size: [u32; 2],
        (outputs, other): (&[OutputImage], Option<vk::ImageView>),
        capture: bool,
    ) -> Result<Self> {
        if plan.options.difference.is_some() && other.is_none() {
            return Err(Error::unsupported(
                "the plan is for the difference from another picture",
                "use `Renderer::create_target_beside`, or leave `Options::difference` out",
            ));
        }
        check_size(size, &device.limits())?;
        let attachments = plan
            .attachments
            .iter()
            .map(|a| {
                if a.is_output {
                    return Ok(None);
                }
                let samples = conv::samples(a.samples);
                let desc = ImageDesc::new(&a.name, conv::format(a.format), size, conv::usage(a.usage));
                let desc = ImageDesc { samples, ..desc };
                let image = match a.transient {
                    true => Image::transient(device, &desc, capture),
                    false => Image::new(device, &desc),
                };
                image.map(Some)
            })
            .collect::<Result<Vec<_>>>()?;
        let extent = vk::Extent2D { width: size[0], height: size[1] };
        let images = PostTarget::images(device, plan, size)?;
        let bloom = post.zip(plan.post.scattered()).map(|(post, image)| {
            let binding = const { shared("BINDING_BLOOM") };
            post.sampled_at(binding, images[image].view())
        });
        let build = OutputBuilder {
            device,
            plan,
            passes,
            pipelines,
            attachments: &attachments,
            extent,
            bloom,
            other,
        };
        let hosts = outputs;
        let outputs = hosts.iter().map(|o| build.build(o)).collect::<Result<_>>()?;
        let view = |output: usize, attachment: usize| build.view(&hosts[output], attachment);
        let post =
            post.map(|post| PostTarget::new(device, plan, post, pipelines, images, (hosts, size), &view));
        let post = post.transpose()?;
        let passes = Arc::clone(passes);
        Ok(Self { outputs, attachments, post, extent, pre_rotation: PreRotation::Identity, passes })
    }

    /// Has pictures drawn turned from now on, as the screen shows the images ([`Swapchain::pre_rotation`](super::Swapchain::pre_rotation)).
    /// Cameras and overlays stay those of the upright picture, whose size is [`PreRotation::size`] of the target's. It costs nothing.
    pub fn pre_rotate(&mut self, pre_rotation: PreRotation) {
        self.pre_rotation = pre_rotation;
    }

    /// How pictures are turned.
    pub fn pre_rotation(&self) -> PreRotation {
        self.pre_rotation
    }

    /// The image of one of the plan's attachments; `None` for the output, which is the host's.
    pub fn attachment(&self, index: usize) -> Option<&Image> {
        self.attachments.get(index)?.as_ref()
    }

    /// How many output images it has.
    pub fn output_count(&self) -> usize {
        self.outputs.len()
    }

    /// The camera that draws to the images what another one shows, unless that is the same.
    pub(super) fn pre_rotated_camera(&self, camera: &Camera) -> Option<Camera> {
        let [width, height] = self.pre_rotation.size([self.extent.width, self.extent.height]);
        let turned = || self.pre_rotation.camera(camera, width as f32 / height as f32);
        (self.pre_rotation != PreRotation::Identity).then(turned)
    }

    /// Whether the renderer with these passes created it.
    pub(super) fn is_of(&self, passes: &Arc<[VulkanPass]>) -> bool {
        Arc::ptr_eq(&self.passes, passes)
    }

    pub(super) fn post(&self) -> Option<&PostTarget> {
        self.post.as_ref()
    }

    pub(crate) fn extent(&self) -> vk::Extent2D {
        self.extent
    }

    pub(super) fn pass(&self, output: usize, pass: usize) -> &PassTarget {
        &self.outputs[output].passes[pass]
    }

    /// The input attachments of a stage.
    pub(super) fn inputs(&self, output: usize, stage: usize) -> Option<vk::DescriptorSet> {
        let output = &self.outputs[output];
        Some(output.sets.as_ref()?.raw(output.set_of_stage[stage]?))
    }
}

struct OutputBuilder<'a> {
    device: &'a Device,
    plan: &'a Plan,
    passes: &'a [VulkanPass],
    pipelines: &'a Pipelines,
    attachments: &'a [Option<Image>],
    extent: vk::Extent2D,
    /// Scattered light.
    bloom: Option<vk::DescriptorImageInfo>,
    /// The picture that this one is compared with.
    other: Option<vk::ImageView>,
}

impl OutputBuilder<'_> {
    fn view(&self, output: &OutputImage, attachment: usize) -> vk::ImageView {
        self.attachments[attachment].as_ref().map_or(output.view, Image::view)
    }

    fn build(&self, output: &OutputImage) -> Result<OutputTarget> {
        let of = |attachment: usize| {
            let image = self.attachments[attachment].as_ref().map_or(output.image, Image::raw);
            (image, self.view(output, attachment))
        };
        let passes = self.plan.passes.iter().zip(self.passes);
        let passes = passes
            .map(|(pass, vulkan)| vulkan.target(self.device, self.plan, pass, self.extent, &of))
            .collect::<Result<_>>()?;
        let view = |attachment| self.view(output, attachment);
        let (sets, set_of_stage) = self.input_sets(&view)?;
        Ok(OutputTarget { passes, sets, set_of_stage })
    }

    fn input_sets(
        &self,
        view: &dyn Fn(usize) -> vk::ImageView,
    ) -> Result<(Option<DescriptorSets>, Vec<Option<usize>>)> {
        let mut set_of_stage = vec![None; self.plan.stage_count()];
        let mut wanted = Vec::new();
        for (index, (stage, _)) in self.plan.pipelines.iter().enumerate() {
            // A stage's pipelines that read inputs read the same ones.
            let Some(set) = self.pipelines.families[index].inputs_set() else { continue };
            if set_of_stage[*stage].is_some() {
                continue;
            }
            let family = self.pipelines.layout_of(index);
            set_of_stage[*stage] = Some(wanted.len());
            wanted.push((family.sets[set].raw(), family.bindings[set].as_slice()));
        }
        let Some(sets) = DescriptorSets::new(self.device, &wanted, "input attachments")? else {
            return Ok((None, set_of_stage));
        };
        for (stage, set) in set_of_stage.iter().enumerate().filter_map(|(s, set)| Some((s, (*set)?))) {
            let (pass, _, subpass) = self.plan.subpass(stage);
            for (binding, &input) in subpass.inputs.iter().enumerate() {
                let attachment = self.plan.passes[pass].attachments[input].attachment;
                let image = vk::DescriptorImageInfo::default()
                    .image_view(view(attachment))
                    .image_layout(conv::layout(subpass.input_states[binding]));
                let ty = vk::DescriptorType::INPUT_ATTACHMENT;
                sets.write(set, binding as u32, ty, &Content::Images(vec![image]));
            }
            for sampled in &subpass.samples {
                let is_depth = self.plan.attachments[sampled.attachment].format.is_depth();
                let image = vk::DescriptorImageInfo::default()
                    .image_view(view(sampled.attachment))
                    .image_layout(conv::layout(State::Sampled));
                let binding = if is_depth { BEHIND_DEPTH } else { BEHIND_LIGHT };
                let ty = vk::DescriptorType::SAMPLED_IMAGE;
                sets.write(set, binding, ty, &Content::Images(vec![image]));
            }
            if let Some(other) = self.other.filter(|_| subpass.name == "difference") {
                let image = vk::DescriptorImageInfo::default()
                    .image_view(other)
                    .image_layout(conv::layout(State::Sampled));
                let ty = vk::DescriptorType::SAMPLED_IMAGE;
                sets.write(set, OTHER, ty, &Content::Images(vec![image]));
            }
            if let Some(bloom) = self.bloom.filter(|_| self.plan.applies_curve(stage)) {
                let ty = vk::DescriptorType::COMBINED_IMAGE_SAMPLER;
                sets.write(set, const { shared("BINDING_BLOOM") }, ty, &Content::Images(vec![bloom]));
            }
        }
        Ok((Some(sets), set_of_stage))
    }
}

/// Checks that the device has every format for what the plan does with it.
pub fn check_formats(device: &Device, plan: &Plan) -> Result<()> {
    for a in &plan.attachments {
        // SAFETY: the physical device is alive.
        let properties = unsafe {
            device
                .instance()
                .get_physical_device_format_properties(device.physical_device(), conv::format(a.format))
        };
        let missing = conv::format_features(a.usage) & !properties.optimal_tiling_features;
        if !missing.is_empty() {
            return Err(Error::unsupported(
                format!(
                    "attachment {} needs format {} with {missing:?}, which '{}' lacks",
                    a.name,
                    a.format,
                    device.caps().name
                ),
                instead_of(a.format),
            ));
        }
    }
    Ok(())
}

/// What to choose where a device lacks a format.
fn instead_of(format: Format) -> &'static str {
    match format {
        Format::Rgba16Unorm => "use --normals oct12",
        Format::B10g11r11Float => "use --light-target rgba16f",
        Format::D24Unorm => "use --depth d32",
        Format::Rgba32Uint => "use --layout packed128",
        _ => "choose another --layout or output format",
    }
}

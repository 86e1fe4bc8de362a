//! What a driver says it makes of subpasses (VK_EXT_subpass_merge_feedback).
//!
//! No driver was seen that has the extension: only how its answers are read is tested.

use ash::vk;

use super::pass::References;
use super::rendering::device_functions;
use super::{Called, Device, Owned};
use crate::Result;
use crate::plan::{MergeReport, Pass, SubpassMerge};

/// Creates a render pass and asks what becomes of its subpasses.
pub fn create_render_pass(
    device: &Device,
    pass: &Pass,
    attachments: &[vk::AttachmentDescription],
    references: &[References],
    dependencies: &[vk::SubpassDependency],
) -> Result<(Owned<vk::RenderPass>, MergeReport)> {
    let attachments: Vec<_> = attachments.iter().map(attachment).collect();
    let dependencies: Vec<_> = dependencies.iter().map(dependency).collect();
    let lists: Vec<_> = references.iter().map(|r| Lists::new(r, &attachments)).collect();
    let mut answers = vec![vk::RenderPassSubpassFeedbackInfoEXT::default(); references.len()];
    let mut questions: Vec<_> = (answers.iter_mut())
        .map(|answer| vk::RenderPassSubpassFeedbackCreateInfoEXT::default().subpass_feedback(answer))
        .collect();
    let subpasses = references.iter().zip(&lists).zip(&mut questions);
    let subpasses: Vec<_> =
        subpasses.map(|((r, lists), question)| lists.description(r).push_next(question)).collect();
    let mut whole = vk::RenderPassCreationFeedbackInfoEXT::default();
    let mut of_whole =
        vk::RenderPassCreationFeedbackCreateInfoEXT::default().render_pass_feedback(&mut whole);
    let info = vk::RenderPassCreateInfo2::default()
        .attachments(&attachments)
        .subpasses(&subpasses)
        .dependencies(&dependencies)
        .push_next(&mut of_whole);
    // SAFETY: the device belongs to the instance.
    let find = unsafe { device_functions(device.instance(), device.raw().handle()) };
    let calls = ash::khr::create_renderpass2::DeviceFn::load(find);
    let mut raw = vk::RenderPass::null();
    let callbacks = device.callbacks().map_or(std::ptr::null(), |callbacks| callbacks as *const _);
    // SAFETY: all that `info` points to outlives the call; indices are positions in `attachments` by the plan.
    let result =
        unsafe { (calls.create_render_pass2_khr)(device.raw().handle(), &info, callbacks, &mut raw) };
    result.result().called("vkCreateRenderPass2")?;
    let raw = Owned::new(device, raw, &pass.name);
    Ok((raw, report(pass, whole.post_merge_subpass_count, &answers)))
}

/// The driver's answer in words.
fn report(pass: &Pass, subpasses_left: u32, answers: &[vk::RenderPassSubpassFeedbackInfoEXT]) -> MergeReport {
    let subpass = |(subpass, answer): (&crate::plan::Subpass, &vk::RenderPassSubpassFeedbackInfoEXT)| {
        let description = answer.description_as_c_str().map(|text| text.to_string_lossy().into_owned());
        SubpassMerge {
            name: subpass.name,
            status: format!("{:?}", answer.subpass_merge_status).to_lowercase(),
            description: description.unwrap_or_default(),
            part: answer.post_merge_index,
        }
    };
    let subpasses = pass.subpasses.iter().zip(answers).map(subpass).collect();
    MergeReport { pass: pass.name.clone(), subpasses_left, subpasses }
}

/// References of a subpass in their second version.
struct Lists {
    colors: Vec<vk::AttachmentReference2<'static>>,
    resolves: Vec<vk::AttachmentReference2<'static>>,
    inputs: Vec<vk::AttachmentReference2<'static>>,
    depth: Option<vk::AttachmentReference2<'static>>,
}

impl Lists {
    fn new(references: &References, attachments: &[vk::AttachmentDescription2<'_>]) -> Self {
        let list = |list: &[vk::AttachmentReference]| {
            let aspects = |r: &vk::AttachmentReference| {
                let format = attachments.get(r.attachment as usize).map(|a| a.format);
                // Shaders read depth, not stencil.
                match super::image::aspects(format.unwrap_or_default()) {
                    aspects if aspects.contains(vk::ImageAspectFlags::DEPTH) => vk::ImageAspectFlags::DEPTH,
                    aspects => aspects,
                }
            };
            let reference = |r: &vk::AttachmentReference| {
                vk::AttachmentReference2::default()
                    .attachment(r.attachment)
                    .layout(r.layout)
                    .aspect_mask(aspects(r))
            };
            list.iter().map(reference).collect::<Vec<_>>()
        };
        Self {
            colors: list(&references.colors),
            resolves: list(&references.resolves),
            inputs: list(&references.inputs),
            depth: list(references.depth.as_slice()).first().copied(),
        }
    }

    fn description<'a>(&'a self, references: &'a References) -> vk::SubpassDescription2<'a> {
        let description = vk::SubpassDescription2::default()
            .flags(references.flags)
            .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
            .color_attachments(&self.colors)
            .input_attachments(&self.inputs)
            .preserve_attachments(&references.preserve);
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

fn attachment(a: &vk::AttachmentDescription) -> vk::AttachmentDescription2<'static> {
    vk::AttachmentDescription2::default()
        .flags(a.flags)
        .format(a.format)
        .samples(a.samples)
        .load_op(a.load_op)
        .store_op(a.store_op)
        .stencil_load_op(a.stencil_load_op)
        .stencil_store_op(a.stencil_store_op)
        .initial_layout(a.initial_layout)
        .final_layout(a.final_layout)
}

fn dependency(d: &vk::SubpassDependency) -> vk::SubpassDependency2<'static> {
    vk::SubpassDependency2::default()
        .src_subpass(d.src_subpass)
        .dst_subpass(d.dst_subpass)
        .src_stage_mask(d.src_stage_mask)
        .dst_stage_mask(d.dst_stage_mask)
        .src_access_mask(d.src_access_mask)
        .dst_access_mask(d.dst_access_mask)
        .dependency_flags(d.dependency_flags)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Limits, Needs, Options, Plan};
    use crate::scene::Scene;

    #[test]
    fn an_answer_is_told_by_subpass() {
        let lamps = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/lamps.glb");
        let needs = Needs::of(&Scene::load(&lamps).unwrap());
        let plan = Plan::new(needs, Options::default(), &Limits::default()).unwrap();
        let mut answers = [vk::RenderPassSubpassFeedbackInfoEXT::default(); 3];
        for (answer, letter) in answers.iter_mut().zip(*b"abc") {
            answer.description[0] = letter as std::ffi::c_char;
        }
        answers[2].subpass_merge_status = vk::SubpassMergeStatusEXT::NOT_MERGED_INSUFFICIENT_STORAGE;
        answers[2].post_merge_index = 1;
        let report = report(&plan.passes[0], 2, &answers);
        assert_eq!((report.subpasses_left, report.pass.as_str()), (2, "geometry+lighting+tonemap"));
        let told = |s: &SubpassMerge| (s.name, s.status.clone(), s.description.clone(), s.part);
        assert_eq!(told(&report.subpasses[0]), ("geometry", "merged".into(), "a".into(), 0));
        let expected = ("tonemap", "not_merged_insufficient_storage".into(), "c".into(), 1);
        assert_eq!(told(&report.subpasses[2]), expected);
    }
}

//! Passes of the plan as dynamic renderings with local reads (VK_KHR_dynamic_rendering_local_read).
//!
//! A rendering has all colour attachments of its stages at once. Which of them a stage writes, by output location, and which it
//! reads, by input attachment index, is state of the command buffer, and must be what the stage's pipelines were made with.

use std::ffi::{CStr, CString};

use ash::vk;

use super::{Device, Recorder, conv};
use crate::plan::{Dependency, Pass, Plan, Scope, Transition};
use crate::{Error, Result};

/// What renderings are recorded with.
#[derive(Clone)]
pub struct RenderingCalls {
    dynamic: ash::khr::dynamic_rendering::DeviceFn,
    local_read: ash::khr::dynamic_rendering_local_read::DeviceFn,
}

impl RenderingCalls {
    /// # Errors
    /// [`Error::Unsupported`] if the device was made without one of them.
    ///
    /// # Safety
    /// The device belongs to the instance.
    pub(super) unsafe fn load(instance: &ash::Instance, device: vk::Device) -> Result<Self> {
        // SAFETY: the caller's promise.
        let mut find = unsafe { device_functions(instance, device) };
        let mut missing = None;
        let mut find = |name: &CStr| {
            let found = find(name);
            if found.is_null() {
                missing.get_or_insert_with(|| name.to_string_lossy().into_owned());
            }
            found
        };
        let dynamic = ash::khr::dynamic_rendering::DeviceFn::load(&mut find);
        let local_read = ash::khr::dynamic_rendering_local_read::DeviceFn::load(&mut find);
        match missing {
            None => Ok(Self { dynamic, local_read }),
            Some(name) => Err(Error::unsupported(
                format!(
                    "the device has no {name}, although `Features::local_read` says that local reads are enabled"
                ),
                "enable VK_KHR_dynamic_rendering and VK_KHR_dynamic_rendering_local_read (or Vulkan 1.4's features), or say `false`",
            )),
        }
    }
}

/// Finds functions of a device by the names that extensions give them, or by those of later versions of Vulkan; null where the
/// device was made without.
///
/// # Safety
/// The device belongs to the instance.
pub unsafe fn device_functions(
    instance: &ash::Instance,
    device: vk::Device,
) -> impl FnMut(&CStr) -> *const std::ffi::c_void {
    move |name| {
        // SAFETY: the caller's promise; names end with a NUL.
        let get = |name: &CStr| unsafe { instance.get_device_proc_addr(device, name.as_ptr()) };
        let core = name.to_string_lossy().trim_end_matches("KHR").to_owned();
        let found = get(name).or_else(|| get(&CString::new(core).ok()?));
        found.map_or(std::ptr::null(), |function| function as *const std::ffi::c_void)
    }
}

/// What is the same for all targets of a pass.
pub struct Rendering {
    calls: RenderingCalls,
    /// Positions of colour attachments in [`Pass::attachments`], in their order.
    colors: Vec<usize>,
    depth: Option<usize>,
    /// Formats of `colors`.
    color_formats: Vec<vk::Format>,
    depth_format: vk::Format,
    stencil_format: vk::Format,
    stages: Vec<RenderingStage>,
    /// Stages that the barriers before and after it order.
    enter: [vk::PipelineStageFlags; 2],
    leave: [vk::PipelineStageFlags; 2],
}

/// What one stage writes and reads, and what it waits for.
struct RenderingStage {
    /// Output location of each colour attachment.
    locations: Vec<u32>,
    /// Input attachment index of each colour attachment.
    inputs: Vec<u32>,
    /// The same of depth.
    depth_input: u32,
    stencil_input: u32,
    waits: Vec<Wait>,
}

/// A dependency between two stages.
struct Wait {
    stages: [vk::PipelineStageFlags; 2],
    barrier: vk::MemoryBarrier<'static>,
    flags: vk::DependencyFlags,
}

/// What a pipeline of a stage is made with.
pub struct RenderingParts<'a> {
    pub(super) formats: vk::PipelineRenderingCreateInfo<'a>,
    pub(super) locations: vk::RenderingAttachmentLocationInfoKHR<'a>,
    pub(super) inputs: vk::RenderingInputAttachmentIndexInfoKHR<'a>,
}

/// A rendering to certain images.
pub struct RenderingTarget {
    colors: Vec<vk::RenderingAttachmentInfo<'static>>,
    depth: Option<vk::RenderingAttachmentInfo<'static>>,
    stencil: Option<vk::RenderingAttachmentInfo<'static>>,
    enter: Vec<vk::ImageMemoryBarrier<'static>>,
    leave: Vec<vk::ImageMemoryBarrier<'static>>,
}

impl Rendering {
    /// What the plan says of a pass.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device was made without local reads.
    pub fn new(device: &Device, plan: &Plan, pass: &Pass) -> Result<Self> {
        let calls = device.rendering_calls().ok_or_else(|| {
            Error::unsupported(
                "the plan's strategy is local-read, and the device was made without dynamicRenderingLocalRead \
                 (VK_KHR_dynamic_rendering_local_read)",
                "enable it and say so in `Features`, or use --strategy subpasses",
            )
        })?;
        let format = |i: usize| plan.attachments[pass.attachments[i].attachment].format;
        // What samples are only resolved to belongs to the attachment that has them.
        let (depth, colors): (Vec<_>, Vec<_>) =
            (0..pass.attachments.len()).filter(|&i| pass.is_on_tile(i)).partition(|&i| format(i).is_depth());
        let depth = depth.first().copied();
        let depth_format = depth.map_or(vk::Format::UNDEFINED, |i| conv::format(format(i)));
        let has_stencil = pass.subpasses.iter().any(|s| s.stencil);
        let stages = (0..pass.subpasses.len()).map(|s| RenderingStage::new(pass, s, &colors, depth));
        Ok(Self {
            calls: calls.clone(),
            stages: stages.collect(),
            color_formats: colors.iter().map(|&i| conv::format(format(i))).collect(),
            colors,
            depth,
            depth_format,
            stencil_format: if has_stencil { depth_format } else { vk::Format::UNDEFINED },
            enter: ordered(&pass.enter),
            leave: ordered(&pass.leave),
        })
    }

    /// A stage's blending by colour attachment, from that by output location: what the stage does not write is masked, and
    /// not blended, which its format may not allow (hence `independentBlend`).
    pub fn blend(
        &self,
        stage: usize,
        by_location: &[vk::PipelineColorBlendAttachmentState],
    ) -> Vec<vk::PipelineColorBlendAttachmentState> {
        let of = |&location: &u32| by_location.get(location as usize).copied().unwrap_or_default();
        self.stages[stage].locations.iter().map(of).collect()
    }

    /// A colour attachment of the rendering, by the output location that a stage has it at.
    pub fn color_attachment(&self, stage: usize, location: usize) -> usize {
        let has = |&of: &u32| of as usize == location;
        self.stages[stage].locations.iter().position(has).expect("the stage writes there")
    }

    /// For a pipeline of a stage.
    pub fn parts(&self, stage: usize) -> RenderingParts<'_> {
        let stage = &self.stages[stage];
        RenderingParts {
            formats: vk::PipelineRenderingCreateInfo::default()
                .color_attachment_formats(&self.color_formats)
                .depth_attachment_format(self.depth_format)
                .stencil_attachment_format(self.stencil_format),
            locations: stage.location_info(),
            inputs: stage.input_info(),
        }
    }

    /// The rendering to images: `of` gives image and view of each of [`Plan::attachments`].
    pub fn target(
        &self,
        plan: &Plan,
        pass: &Pass,
        of: &dyn Fn(usize) -> (vk::Image, vk::ImageView),
    ) -> RenderingTarget {
        let attached = |i: usize| &pass.attachments[i];
        let info = |i: usize, load, store| {
            vk::RenderingAttachmentInfo::default()
                .image_view(of(attached(i).attachment).1)
                .image_layout(conv::layout(pass.enter[i].to))
                .load_op(conv::load_op(load))
                .store_op(conv::store_op(store))
                .clear_value(conv::clear_value(&plan.attachments[attached(i).attachment]))
        };
        let resolves: Vec<_> = (pass.subpasses.iter())
            .filter_map(|s| s.resolve.map(|resolve| (s.colors[resolve.from], resolve.to)))
            .collect();
        let color = |&i: &usize| {
            let info = info(i, attached(i).load, attached(i).store);
            match resolves.iter().find(|(from, _)| *from == i) {
                None => info,
                Some(&(_, to)) => info
                    .resolve_mode(vk::ResolveModeFlags::AVERAGE)
                    .resolve_image_view(of(attached(to).attachment).1)
                    .resolve_image_layout(conv::layout(pass.enter[to].to)),
            }
        };
        let stencil = self.depth.filter(|_| self.stencil_format != vk::Format::UNDEFINED);
        let barrier = |t: &Transition| {
            let attachment = attached(t.attachment).attachment;
            let aspect_mask = super::image::aspects(conv::format(plan.attachments[attachment].format));
            vk::ImageMemoryBarrier::default()
                .src_access_mask(conv::scope(&t.before).1 & accessed(conv::layout(t.from)))
                .dst_access_mask(conv::scope(&t.after).1)
                .old_layout(conv::layout(t.from))
                .new_layout(conv::layout(t.to))
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(of(attachment).0)
                .subresource_range(vk::ImageSubresourceRange {
                    aspect_mask,
                    level_count: 1,
                    layer_count: 1,
                    ..Default::default()
                })
        };
        RenderingTarget {
            colors: self.colors.iter().map(color).collect(),
            depth: self.depth.map(|i| info(i, attached(i).load, attached(i).store)),
            stencil: stencil.map(|i| info(i, attached(i).stencil.0, attached(i).stencil.1)),
            enter: pass.enter.iter().map(barrier).collect(),
            leave: pass.leave.iter().map(barrier).collect(),
        }
    }

    /// Begins the rendering, at its first stage.
    pub fn begin(&self, recorder: &Recorder<'_>, target: &RenderingTarget, area: vk::Rect2D) {
        transition(recorder, self.enter, &target.enter);
        let info =
            vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&target.colors);
        let info = match &target.depth {
            Some(depth) => info.depth_attachment(depth),
            None => info,
        };
        let info = match &target.stencil {
            Some(stencil) => info.stencil_attachment(stencil),
            None => info,
        };
        // SAFETY: the views are alive and, by the barrier above, in the layouts that `info` names.
        unsafe { (self.calls.dynamic.cmd_begin_rendering_khr)(recorder.raw(), &info) };
        self.map(recorder, 0);
    }

    /// Goes on to a stage after the first.
    pub fn next(&self, recorder: &Recorder<'_>, stage: usize) {
        for Wait { stages: [before, after], barrier, flags } in &self.stages[stage].waits {
            // SAFETY: the command buffer is in a rendering that the device allows barriers of attachments in.
            unsafe {
                let device = recorder.device().raw();
                device.cmd_pipeline_barrier(recorder.raw(), *before, *after, *flags, &[*barrier], &[], &[]);
            }
        }
        self.map(recorder, stage);
    }

    /// Ends the rendering.
    pub fn end(&self, recorder: &Recorder<'_>, target: &RenderingTarget) {
        // SAFETY: `begin` began it.
        unsafe { (self.calls.dynamic.cmd_end_rendering_khr)(recorder.raw()) };
        transition(recorder, self.leave, &target.leave);
    }

    fn map(&self, recorder: &Recorder<'_>, stage: usize) {
        let (calls, stage) = (&self.calls.local_read, &self.stages[stage]);
        // SAFETY: the rendering has as many colour attachments, and no two have one location or index.
        unsafe {
            let (locations, inputs) = (stage.location_info(), stage.input_info());
            (calls.cmd_set_rendering_attachment_locations_khr)(recorder.raw(), &locations);
            (calls.cmd_set_rendering_input_attachment_indices_khr)(recorder.raw(), &inputs);
        }
    }
}

impl RenderingStage {
    fn new(pass: &Pass, index: usize, colors: &[usize], depth: Option<usize>) -> Self {
        let subpass = &pass.subpasses[index];
        let place = |list: &[usize], attachment: usize| {
            let place = list.iter().position(|&a| a == attachment);
            place.map_or(vk::ATTACHMENT_UNUSED, |place| place as u32)
        };
        let by_color = |list: &[usize]| colors.iter().map(|&attachment| place(list, attachment)).collect();
        // A stage's dependency on itself is for whoever draws it.
        let waits =
            pass.dependencies.iter().filter(|d| d.to == Some(index) && d.from.is_some_and(|f| f < index));
        Self {
            locations: by_color(&subpass.colors),
            inputs: by_color(&subpass.inputs),
            depth_input: depth.map_or(vk::ATTACHMENT_UNUSED, |depth| place(&subpass.inputs, depth)),
            stencil_input: vk::ATTACHMENT_UNUSED,
            waits: waits.map(Wait::new).collect(),
        }
    }

    fn location_info(&self) -> vk::RenderingAttachmentLocationInfoKHR<'_> {
        vk::RenderingAttachmentLocationInfoKHR::default().color_attachment_locations(&self.locations)
    }

    fn input_info(&self) -> vk::RenderingInputAttachmentIndexInfoKHR<'_> {
        vk::RenderingInputAttachmentIndexInfoKHR::default()
            .color_attachment_input_indices(&self.inputs)
            .depth_input_attachment_index(&self.depth_input)
            .stencil_input_attachment_index(&self.stencil_input)
    }
}

impl Wait {
    fn new(dependency: &Dependency) -> Self {
        let (before, from) = conv::scope(&dependency.before);
        let (after, to) = conv::scope(&dependency.after);
        Self {
            stages: [before, after],
            barrier: vk::MemoryBarrier::default().src_access_mask(from).dst_access_mask(to),
            flags: conv::by_region(dependency.by_region),
        }
    }
}

/// How what has a layout can have been accessed. What was written before it got a layout to be read in is available since then.
fn accessed(layout: vk::ImageLayout) -> vk::AccessFlags {
    match layout {
        vk::ImageLayout::TRANSFER_SRC_OPTIMAL => vk::AccessFlags::TRANSFER_READ,
        _ => !vk::AccessFlags::empty(),
    }
}

/// The stages that transitions order.
fn ordered(all: &[Transition]) -> [vk::PipelineStageFlags; 2] {
    let stages = |scope: fn(&Transition) -> &Scope| {
        all.iter().fold(vk::PipelineStageFlags::empty(), |stages, t| stages | conv::scope(scope(t)).0)
    };
    [stages(|t| &t.before), stages(|t| &t.after)]
}

fn transition(
    recorder: &Recorder<'_>,
    [before, after]: [vk::PipelineStageFlags; 2],
    barriers: &[vk::ImageMemoryBarrier<'_>],
) {
    if barriers.is_empty() {
        return;
    }
    let (device, flags) = (recorder.device().raw(), vk::DependencyFlags::empty());
    // SAFETY: the images are alive, and the command buffer is outside of a pass.
    unsafe { device.cmd_pipeline_barrier(recorder.raw(), before, after, flags, &[], &[], barriers) };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Limits, Merging, Needs, Options, Strategy};
    use crate::scene::Scene;

    #[test]
    fn stages_write_read_and_wait_for_what_the_plan_says() {
        let lamps = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/lamps.glb");
        let merging = Merging { local_read: Ok(()), ..Merging::default() };
        let options = Options { strategy: Strategy::LocalRead, ..Options::default() };
        let limits = Limits { merging, ..Limits::default() };
        let plan = Plan::new(Needs::of(&Scene::load(&lamps).unwrap()), options, &limits).unwrap();
        let pass = &plan.passes[0];
        let is_depth = |i: &usize| plan.attachments[pass.attachments[*i].attachment].format.is_depth();
        let (depth, colors): (Vec<_>, Vec<_>) = (0..pass.attachments.len()).partition(is_depth);
        for (index, subpass) in pass.subpasses.iter().enumerate() {
            let stage = RenderingStage::new(pass, index, &colors, depth.first().copied());
            let at = |places: &[u32], wanted: usize| {
                let place = places.iter().position(|&place| place as usize == wanted);
                place.map(|place| colors[place])
            };
            for (location, &color) in subpass.colors.iter().enumerate() {
                assert_eq!(at(&stage.locations, location), Some(color));
            }
            for (input, &read) in subpass.inputs.iter().enumerate() {
                assert!(at(&stage.inputs, input) == Some(read) || stage.depth_input as usize == input);
            }
            let used =
                |places: &[u32]| places.iter().filter(|&&place| place != vk::ATTACHMENT_UNUSED).count();
            assert_eq!(used(&stage.locations), subpass.colors.len());
            let waits = pass.dependencies.iter().filter(|d| d.to == Some(index)).count();
            assert_eq!((stage.waits.len(), index > 0), (waits, waits > 0));
            assert!(stage.waits.iter().all(|wait| wait.flags == vk::DependencyFlags::BY_REGION));
        }
        assert_eq!(pass.subpasses.len(), 3);
    }
}

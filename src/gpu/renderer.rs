//! The renderer: a plan made of Vulkan objects, and frames recorded with them.

use std::ops::Range;
use std::sync::Arc;

use ash::vk;
use glam::Mat4;

use super::pass::create_render_pass;
use super::pipeline::Pipelines;
use super::scene_data::{BoundMesh, SceneData};
use super::target::check_formats;
use super::{
    Device, OutputImage, Owned, PipelineCache, Queries, QueryResults, Recorder, Target, Upload, View, conv,
};
use crate::plan::{FrameCounts, Needs, Pipeline, Plan, State, VolumeShape};
use crate::scene::{Light, Scene};
use crate::{Error, Result};

/// How a [`Renderer`] is set up.
#[derive(Clone, Copy, Debug)]
pub struct RendererConfig {
    /// Frames that the host may have on the GPU at the same time, at least 1.
    pub frames_in_flight: usize,
    /// Give transient attachments ordinary memory, so that frame debuggers can read them. Same pixels.
    pub capture: bool,
    /// Take a timestamp after every subpass, not only around the frame. On tilers only the ones around the
    /// frame mean anything, since subpasses of different tiles interleave.
    pub stage_timestamps: bool,
    /// Leave out objects and lights that the view cannot see. Same pixels.
    pub cull: bool,
}

impl Default for RendererConfig {
    fn default() -> Self {
        Self { frames_in_flight: 2, capture: false, stage_timestamps: false, cull: true }
    }
}

/// Draws one scene by one plan.
///
/// The host owns command buffers, queue submissions and output images; the renderer records and never waits.
///
/// 1. [`Renderer::new`] makes all objects and stages the scene's data.
/// 2. [`Renderer::record_upload`] goes into a command buffer that the host submits before the first frame; once that
///    has finished, [`Renderer::finish_upload`] frees the staging memory.
/// 3. [`Renderer::create_target`] wraps the host's images, again after each resize.
/// 4. [`Renderer::record`] records a frame. Frame slot `n` may be recorded again once the host knows that the GPU has
///    finished the frame recorded with it before (a fence or timeline semaphore).
///
/// Renderer and targets must be dropped only when no frame that uses them is on the GPU. Several renderers on one
/// device are independent of each other.
pub struct Renderer {
    // In order of destruction.
    upload: Option<Upload>,
    queries: Queries,
    scene: SceneData,
    pipelines: Pipelines,
    /// Shared with the targets: their framebuffers are of these passes.
    passes: Arc<[Owned<vk::RenderPass>]>,
    plan: Plan,
    config: RendererConfig,
    device: Device,
    recorded: Recorded,
}

/// What recording a frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Recorded {
    /// What it put into the command buffer.
    pub counts: FrameCounts,
    /// CPU time of listing the lights of each part of the view; 0 where the plan has no light lists.
    pub light_lists: std::time::Duration,
}

impl Renderer {
    /// Makes everything that the plan lists.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device lacks a format or the plan was made for another scene;
    /// [`Error::Vulkan`].
    pub fn new(
        device: &Device,
        scene: &Scene,
        plan: Plan,
        config: RendererConfig,
        cache: &PipelineCache,
    ) -> Result<Self> {
        if plan.needs != Needs::of(scene) {
            return Err(Error::unsupported(
                format!("the plan does not match what scene '{}' needs", scene.name),
                "make the plan from this scene's `Needs`, after the last change to the scene",
            ));
        }
        check_formats(device, &plan)?;
        let passes = plan
            .passes
            .iter()
            .map(|pass| create_render_pass(device, &plan, pass))
            .collect::<Result<Arc<[_]>>>()?;
        let pipelines = Pipelines::new(device, &plan, &passes, cache)?;
        let mut upload = Upload::new(device);
        let slot_count = config.frames_in_flight.max(1);
        let scene = SceneData::new(device, scene, &plan, &pipelines, slot_count, &mut upload)?;
        let timestamps = if config.stage_timestamps { plan.stage_count() + 1 } else { 2 };
        let queries = Queries::new(device, timestamps as u32, slot_count as u32)?;
        Ok(Self {
            upload: Some(upload),
            queries,
            scene,
            pipelines,
            passes,
            plan,
            config,
            device: device.clone(),
            recorded: Recorded::default(),
        })
    }

    /// Records the copies that bring the scene to the device; does nothing after [`Self::finish_upload`].
    pub fn record_upload(&mut self, recorder: &Recorder<'_>) {
        if let Some(upload) = &mut self.upload {
            upload.record(recorder);
        }
    }

    /// Frees the staging memory. The commands of [`Self::record_upload`] must have finished on the GPU.
    pub fn finish_upload(&mut self) {
        self.upload = None;
    }

    /// Makes the attachments that go with the host's images, which are of this size in pixels. A renderer can have
    /// targets of several sizes; the plan's own size is only the one that reports speak of.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device has no images of that size; [`Error::Vulkan`].
    pub fn create_target(&self, size: [u32; 2], outputs: &[OutputImage]) -> Result<Target> {
        let Self { device, plan, passes, pipelines, config, .. } = self;
        Target::new(device, plan, passes, pipelines, size, outputs, config.capture)
    }

    /// The format that output images must have.
    pub fn output_format(&self) -> vk::Format {
        conv::format(self.plan.attachments[0].format)
    }

    /// The usage that output images must have at least.
    pub fn output_usage(&self) -> vk::ImageUsageFlags {
        conv::usage(self.plan.attachments[0].usage)
    }

    /// The layout that a frame leaves its output image in; what it is in before does not matter.
    pub fn output_layout(&self) -> vk::ImageLayout {
        conv::layout(State::after_frame(self.plan.options.output_use))
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// What the last [`Self::record`] recorded.
    pub fn recorded(&self) -> Recorded {
        self.recorded
    }

    /// Timestamps and statistics of a frame slot that the GPU has finished: nanoseconds since the frame's begin after
    /// each stage (with [`RendererConfig::stage_timestamps`]) and at its end.
    ///
    /// # Errors
    /// [`Error::Vulkan`], e.g. when the device was lost.
    pub fn query_results(&self, slot: usize) -> Result<QueryResults> {
        self.queries.results(slot as u32)
    }

    /// Device memory of the scene's buffers and textures.
    pub fn scene_bytes(&self) -> u64 {
        self.scene.allocated_bytes()
    }

    /// Moves the scene's instance `index` for the frames recorded from now on. Those on the GPU go on as they are.
    ///
    /// Moving what is not [dynamic](crate::scene::Instance::dynamic) costs more: what was kept of static objects is
    /// made anew.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has no such instance, the matrix is not affine and finite, or the instance would
    /// become mirrored or cease to be (its determinant's sign): that takes another pipeline. Nothing is changed then.
    pub fn set_instance(&mut self, index: usize, world_from_object: &Mat4) -> Result<()> {
        self.scene.objects_mut().set(index, world_from_object)
    }

    /// How often an instance that is not dynamic was moved so far.
    pub fn static_moves(&self) -> u64 {
        self.scene.objects().static_moves()
    }

    /// Changes the scene's light `index` for the frames recorded from now on: place, direction, colour, intensity, range
    /// and cone. It may become dark and light up again.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has no such light, a number is not finite, or it takes what the plan does not
    /// have: another kind, or light of a kind of which the scene had none that was not dark. Nothing is changed then.
    pub fn set_light(&mut self, index: usize, light: &Light) -> Result<()> {
        self.scene.lights_mut().set(index, light)
    }

    /// Records a frame: no allocation, no wait, no submission.
    ///
    /// `slot` is below [`RendererConfig::frames_in_flight`], and the GPU has finished the frame that was recorded with it
    /// before. `target` comes from this renderer's [`Self::create_target`], and `output` is an index into its images.
    /// The render pass orders earlier accesses to the output image on the same queue if they are colour writes or of
    /// the plan's [`OutputUse`](crate::plan::OutputUse); a swapchain's semaphore is waited for at the stage
    /// COLOR_ATTACHMENT_OUTPUT. Afterwards the image is in [`Self::output_layout`].
    ///
    /// # Panics
    /// If `slot` or `output` is out of range, or the target is another renderer's.
    pub fn record(
        &mut self,
        recorder: &Recorder<'_>,
        slot: usize,
        target: &Target,
        output: usize,
        view: &View<'_>,
    ) {
        assert!(target.is_of(&self.passes), "the target was created by another renderer");
        let vk::Extent2D { width, height } = target.extent();
        let seen = self.scene.write_frame(slot, view, &self.plan, [width, height], self.config.cull);
        let counts = FrameCounts { objects: seen.objects, lights: seen.lights, ..FrameCounts::default() };
        let mut frame = Frame { renderer: self, recorder, slot, target, output, counts };
        frame.record();
        self.recorded = Recorded { counts: frame.counts, light_lists: seen.light_lists };
    }
}

/// One frame while it is recorded.
struct Frame<'a> {
    renderer: &'a Renderer,
    recorder: &'a Recorder<'a>,
    slot: usize,
    target: &'a Target,
    output: usize,
    counts: FrameCounts,
}

impl Frame<'_> {
    fn record(&mut self) {
        let Renderer { plan, passes, config, queries, .. } = self.renderer;
        let (recorder, slot) = (self.recorder, self.slot as u32);
        let _label = recorder.label("ontile frame");
        queries.reset(recorder, slot);
        queries.begin_statistics(recorder, slot);
        queries.timestamp(recorder, slot, 0, vk::PipelineStageFlags::TOP_OF_PIPE);
        let stages = plan.stage_count();
        let mut stage = 0;
        for (index, pass) in plan.passes.iter().enumerate() {
            self.begin_pass(index, passes[index].raw());
            for (subpass, planned) in pass.subpasses.iter().enumerate() {
                if subpass > 0 {
                    // SAFETY: the command buffer is recording this pass, which has another subpass.
                    unsafe {
                        let device = recorder.device().raw();
                        device.cmd_next_subpass(recorder.raw(), vk::SubpassContents::INLINE);
                    }
                }
                let _label = recorder.label(planned.name);
                self.draw_stage(stage);
                stage += 1;
                if config.stage_timestamps && stage < stages {
                    let index = stage as u32;
                    queries.timestamp(recorder, slot, index, vk::PipelineStageFlags::BOTTOM_OF_PIPE);
                }
            }
            // SAFETY: the pass is being recorded and its last subpass was entered.
            unsafe { recorder.device().raw().cmd_end_render_pass(recorder.raw()) };
        }
        let last = if config.stage_timestamps { stages } else { 1 };
        queries.timestamp(recorder, slot, last as u32, vk::PipelineStageFlags::BOTTOM_OF_PIPE);
        queries.end_statistics(recorder, slot);
    }

    fn begin_pass(&self, index: usize, pass: vk::RenderPass) {
        let extent = self.target.extent();
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(pass)
            .framebuffer(self.target.framebuffer(self.output, index))
            .render_area(area)
            .clear_values(self.target.clear_values(index));
        let viewport = vk::Viewport {
            x: 0.0,
            y: 0.0,
            width: extent.width as f32,
            height: extent.height as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        // SAFETY: the framebuffer was made for this pass, with one clear value per attachment.
        unsafe {
            device.cmd_begin_render_pass(raw, &info, vk::SubpassContents::INLINE);
            device.cmd_set_viewport(raw, 0, &[viewport]);
            device.cmd_set_scissor(raw, 0, &[area]);
        }
    }

    fn draw_stage(&mut self, stage: usize) {
        self.draw_surfaces(stage);
        let plan = &self.renderer.plan;
        let of_stage =
            plan.pipelines.iter().enumerate().filter(|(_, (s, p))| *s == stage && !p.is_of_surfaces());
        for (index, (_, pipeline)) in of_stage {
            match pipeline {
                Pipeline::LightVolume(shape) => self.draw_volumes(stage, index, *shape),
                // Drawn in turns with the pipeline that follows it.
                Pipeline::LightMask(_) => {}
                _ => {
                    self.bind_with_inputs(stage, index);
                    self.draw_generated(3, 0..1);
                }
            }
        }
    }

    /// Draws the lights of a shape: all at once, or each after its mask.
    fn draw_volumes(&mut self, stage: usize, pipeline: usize, shape: VolumeShape) {
        let Renderer { plan, scene, .. } = self.renderer;
        let vertices = match shape {
            VolumeShape::Screen => 3,
            VolumeShape::Sphere => 60,
            VolumeShape::Cone => 48,
            VolumeShape::Box => 36,
        };
        let lights = scene.light_volumes(shape);
        let mask = pipeline.checked_sub(1).filter(|&p| plan.pipelines[p].1 == Pipeline::LightMask(shape));
        match mask {
            _ if lights.is_empty() => {}
            None => {
                self.bind_with_inputs(stage, pipeline);
                self.draw_generated(vertices, lights);
            }
            Some(mask) => {
                for light in lights {
                    self.bind_pipeline(mask);
                    self.draw_generated(vertices, light..light + 1);
                    self.bind_with_inputs(stage, pipeline);
                    self.draw_generated(vertices, light..light + 1);
                }
            }
        }
    }

    /// Draws without vertex buffers.
    fn draw_generated(&mut self, vertices: u32, instances: Range<u32>) {
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        // SAFETY: the bound pipeline makes its vertices from their indices.
        unsafe { device.cmd_draw(raw, vertices, instances.len() as u32, 0, instances.start) };
        self.counts.draws += 1;
        self.counts.triangles += u64::from(vertices / 3) * instances.len() as u64;
    }

    /// Binds a pipeline, the frame's buffers and the stage's input attachments.
    fn bind_with_inputs(&mut self, stage: usize, index: usize) {
        let layout = self.bind_pipeline(index);
        if let Some(inputs) = self.target.inputs(self.output, stage) {
            self.bind_set(layout, 1, inputs);
        }
    }

    /// Draws what the view sees of all surfaces that the stage draws.
    fn draw_surfaces(&mut self, stage: usize) {
        let Renderer { pipelines, scene, .. } = self.renderer;
        let mut bound_mesh = BoundMesh::default();
        let (mut bound_pipeline, mut bound_material) = (None, None);
        for batch in scene.objects().visible_batches() {
            let Some(index) = pipelines.drawing(stage, batch.pipeline) else { continue };
            let layout = match bound_pipeline {
                Some((bound, layout)) if bound == index => layout,
                _ => {
                    bound_material = None;
                    self.bind_pipeline(index)
                }
            };
            bound_pipeline = Some((index, layout));
            if pipelines.families[index].has_material() && bound_material != Some(batch.material_set) {
                self.bind_set(layout, 1, scene.material_set(batch.material_set));
                bound_material = Some(batch.material_set);
            }
            scene.bind_mesh(self.recorder, batch, &mut bound_mesh, &mut self.counts.state_changes);
            scene.draw(self.recorder, batch, &mut self.counts);
        }
    }

    /// Binds the n-th of `Plan::pipelines` and what its frame has once.
    fn bind_pipeline(&mut self, index: usize) -> vk::PipelineLayout {
        let Renderer { pipelines, scene, .. } = self.renderer;
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        let pipeline = pipelines.pipelines[index].raw();
        // SAFETY: the pipeline was made for this subpass and is kept alive by the renderer.
        unsafe { device.cmd_bind_pipeline(raw, vk::PipelineBindPoint::GRAPHICS, pipeline) };
        self.counts.state_changes.pipelines += 1;
        let layout = pipelines.layout_of(index).layout.raw();
        self.bind_set(layout, 0, scene.frame_set(self.slot, pipelines.families[index]));
        layout
    }

    fn bind_set(&mut self, layout: vk::PipelineLayout, index: u32, set: vk::DescriptorSet) {
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the set was allocated with the layout's n-th set layout, and all its bindings are written.
        unsafe { device.cmd_bind_descriptor_sets(raw, point, layout, index, &[set], &[]) };
        self.counts.state_changes.descriptor_sets += 1;
    }
}

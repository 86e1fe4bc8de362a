//! Recording a frame: passes, subpasses and their draws.

use std::ops::Range;

use ash::vk;

use super::super::conv;
use super::super::fragments::{DrawnMesh, FragmentQueries};
use super::super::objects::Batch;
use super::super::scene_data::BoundMesh;
use super::super::shared::LightPush;
use super::super::{Recorder, Target};
use super::Renderer;
use crate::plan::{FrameCounts, Pipeline, VolumeShape};

/// One frame while it is recorded.
pub(super) struct Frame<'a> {
    pub(super) renderer: &'a Renderer,
    pub(super) recorder: &'a Recorder<'a>,
    pub(super) slot: usize,
    pub(super) target: &'a Target,
    pub(super) output: usize,
    /// What is drawn of the picture.
    pub(super) area: vk::Rect2D,
    pub(super) counts: FrameCounts,
    /// What is bound as `SET_FRAME`, and whether by a layout with push constants: only layouts that agree in them share it.
    pub(super) bound_frame: Option<(vk::DescriptorSet, bool)>,
    pub(super) fragments: Option<FragmentQueries>,
}

/// What draws of surfaces have bound.
#[derive(Default)]
struct Bound {
    mesh: BoundMesh,
    pipeline: Option<(usize, vk::PipelineLayout)>,
    material: Option<usize>,
}

impl Frame<'_> {
    pub(super) fn record(&mut self) {
        let Renderer { plan, passes, config, .. } = self.renderer;
        let queries = self.renderer.queries();
        let (recorder, slot) = (self.recorder, self.slot as u32);
        let stages = plan.stage_count();
        let mut stage = 0;
        for (index, pass) in plan.passes.iter().enumerate() {
            self.begin_pass(index);
            for (subpass, planned) in pass.subpasses.iter().enumerate() {
                if subpass > 0 {
                    passes[index].next(recorder, subpass);
                }
                let _label = recorder.label(planned.name);
                self.draw_stage(stage);
                stage += 1;
                if stage == stages {
                    self.draw_overlay();
                }
                if let Some(queries) = queries.filter(|_| config.stage_timestamps && stage < stages) {
                    let index = stage as u32;
                    queries.timestamp(recorder, slot, index, vk::PipelineStageFlags::BOTTOM_OF_PIPE);
                }
            }
            passes[index].end(recorder, self.target.pass(self.output, index));
        }
        self.record_post();
        let last = if config.stage_timestamps { stages } else { 1 };
        if let Some(queries) = queries {
            queries.timestamp(recorder, slot, last as u32, vk::PipelineStageFlags::BOTTOM_OF_PIPE);
            queries.end_statistics(recorder, slot);
        }
    }

    /// Begins a pass over the frame's part of the picture, with a viewport of the whole.
    fn begin_pass(&self, index: usize) {
        let whole = vk::Rect2D { offset: vk::Offset2D::default(), extent: self.target.extent() };
        let area = self.area;
        self.renderer.passes[index].begin(self.recorder, self.target.pass(self.output, index), area);
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        // SAFETY: the command buffer is recording.
        unsafe {
            device.cmd_set_viewport(raw, 0, &[conv::viewport(whole)]);
            device.cmd_set_scissor(raw, 0, &[area]);
        }
    }

    fn draw_stage(&mut self, stage: usize) {
        self.clear_attachments(stage);
        if self.renderer.plan.draws_blended(stage) {
            self.draw_whole(stage);
            self.draw_blended(stage);
        } else {
            self.draw_surfaces(stage);
            self.draw_whole(stage);
        }
    }

    /// Clears what the stage begins with and the pass could not clear, since it held something else then.
    fn clear_attachments(&self, stage: usize) {
        let (pass, stage_of_pass, subpass) = self.renderer.plan.subpass(stage);
        let rect = vk::ClearRect { rect: self.area, base_array_layer: 0, layer_count: 1 };
        for &(position, value) in &subpass.clears {
            let location = subpass.colors.iter().position(|&color| color == position);
            let clear = match location {
                Some(location) => vk::ClearAttachment {
                    aspect_mask: vk::ImageAspectFlags::COLOR,
                    color_attachment: self.renderer.passes[pass].color_attachment(stage_of_pass, location),
                    // Words are cleared to 0, which has the same bits.
                    clear_value: vk::ClearValue { color: vk::ClearColorValue { float32: value } },
                },
                None => vk::ClearAttachment {
                    aspect_mask: vk::ImageAspectFlags::DEPTH,
                    color_attachment: 0,
                    clear_value: vk::ClearValue {
                        depth_stencil: vk::ClearDepthStencilValue { depth: value[0], stencil: 0 },
                    },
                },
            };
            let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
            // SAFETY: the subpass is being recorded, has this attachment, and the rectangle is the render area.
            unsafe { device.cmd_clear_attachments(raw, &[clear], &[rect]) };
        }
    }

    /// Draws what is not surfaces: over the whole image, or lights' volumes.
    fn draw_whole(&mut self, stage: usize) {
        let plan = &self.renderer.plan;
        if plan.subpass(stage).2.name == "decals" {
            return self.draw_decals(stage);
        }
        let of_stage =
            plan.pipelines.iter().enumerate().filter(|(_, (s, p))| *s == stage && !p.is_of_surfaces());
        for (index, (_, pipeline)) in of_stage {
            match pipeline {
                Pipeline::LightVolume(shape) => self.draw_volumes(stage, index, *shape),
                // Drawn in turns with the volumes between them.
                Pipeline::LightMask(_)
                | Pipeline::EdgeVolume(_)
                | Pipeline::ShadowNearEnds
                | Pipeline::ShadowVolume => {}
                // After all else.
                Pipeline::Overlay => {}
                Pipeline::ShadowedLight => self.draw_shadowed_lights(stage, index),
                Pipeline::Particles(_) => self.draw_particles(stage, index),
                _ => self.counted(stage, index, None, |frame| {
                    frame.bind_with_inputs(stage, index);
                    frame.draw_generated(3, 0..1);
                }),
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
        // The same for the samples of edges.
        let edges = Some(pipeline + 1)
            .filter(|&p| plan.pipelines.get(p).is_some_and(|(_, next)| *next == Pipeline::EdgeVolume(shape)));
        let mask = pipeline.checked_sub(1).filter(|&p| plan.pipelines[p].1 == Pipeline::LightMask(shape));
        match mask {
            _ if lights.is_empty() => {}
            None => {
                for pipeline in [pipeline].into_iter().chain(edges) {
                    self.counted(stage, pipeline, None, |frame| {
                        frame.bind_with_inputs(stage, pipeline);
                        frame.draw_generated(vertices, lights.clone());
                    });
                }
            }
            Some(mask) => {
                for light in lights {
                    self.bind_pipeline(mask);
                    self.draw_generated(vertices, light..light + 1);
                    for pipeline in edges.into_iter().chain([pipeline]) {
                        self.counted(stage, pipeline, None, |frame| {
                            frame.bind_with_inputs(stage, pipeline);
                            frame.draw_generated(vertices, light..light + 1);
                        });
                    }
                }
            }
        }
    }

    /// Draws what the host has over the picture.
    fn draw_overlay(&mut self) {
        let Some(overlay) = self.renderer.overlay.as_ref().filter(|o| !o.is_empty(self.slot)) else { return };
        let layout = self.bind_pipeline(overlay.pipeline());
        self.bind_set(layout, 0, overlay.set_of_image());
        let (extent, pre_rotation) = (self.target.extent(), self.target.pre_rotation());
        let counts = overlay.draw(self.recorder, self.slot, layout, extent, pre_rotation, self.area);
        self.counts.draws += counts.draws;
        self.counts.triangles += counts.triangles;
    }

    /// Draws without vertex buffers.
    pub(super) fn draw_generated(&mut self, vertices: u32, instances: Range<u32>) {
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        // SAFETY: the bound pipeline makes its vertices from their indices.
        unsafe { device.cmd_draw(raw, vertices, instances.len() as u32, 0, instances.start) };
        self.counts.draws += 1;
        self.counts.triangles += u64::from(vertices / 3) * instances.len() as u64;
    }

    /// Binds a pipeline, the frame's buffers and the stage's input attachments.
    pub(super) fn bind_with_inputs(&mut self, stage: usize, index: usize) {
        let layout = self.bind_pipeline(index);
        let reads = self.renderer.pipelines.families[index].inputs_set().is_some();
        if let Some(inputs) = self.target.inputs(self.output, stage).filter(|_| reads) {
            self.bind_set(layout, 1, inputs);
        }
    }

    /// Draws what the view sees of all surfaces that the stage draws.
    fn draw_surfaces(&mut self, stage: usize) {
        let Renderer { pipelines, scene, .. } = self.renderer;
        let mut bound = Bound::default();
        for batch in scene.objects().visible_batches() {
            if let Some(index) = pipelines.drawing(stage, batch.pipeline) {
                self.draw_run(stage, index, batch, batch.visible.clone(), &mut bound);
            }
        }
    }

    /// Draws what the view sees of what is blended, from far to near.
    fn draw_blended(&mut self, stage: usize) {
        let Renderer { plan, pipelines, scene, .. } = self.renderer;
        let mut bound = Bound::default();
        for (batch, run) in scene.objects().blended_runs() {
            let Some(index) = pipelines.drawing(stage, batch.pipeline) else { continue };
            // What is behind is multiplied before light is added.
            let absorbs = |&before: &usize| matches!(plan.pipelines[before].1, Pipeline::Absorb(_));
            if let Some(before) = index.checked_sub(1).filter(absorbs) {
                self.draw_run(stage, before, batch, run.clone(), &mut bound);
            }
            self.draw_run(stage, index, batch, run, &mut bound);
        }
    }

    /// Draws some of a batch's visible instances with the n-th of `Plan::pipelines`.
    fn draw_run(&mut self, stage: usize, index: usize, batch: &Batch, run: Range<u32>, bound: &mut Bound) {
        let Renderer { plan, pipelines, scene, .. } = self.renderer;
        let layout = match bound.pipeline {
            Some((same, layout)) if same == index => layout,
            _ => {
                bound.material = None;
                let layout = self.bind_pipeline(index);
                if let Some(set) = pipelines.families[index].inputs_set()
                    && let Some(inputs) = self.target.inputs(self.output, stage)
                {
                    self.bind_set(layout, set as u32, inputs);
                }
                layout
            }
        };
        bound.pipeline = Some((index, layout));
        if pipelines.families[index].has_material() && bound.material != Some(batch.material_set) {
            self.bind_set(layout, 1, scene.material_set(batch.material_set));
            bound.material = Some(batch.material_set);
        }
        scene.bind_mesh(self.recorder, batch, &mut bound.mesh, &mut self.counts.state_changes);
        let Batch { mesh, material, .. } = *batch;
        let drawn = DrawnMesh { mesh, material, instances: run.len() as u32 };
        self.counted(stage, index, Some(drawn), |frame| match plan.pipelines[index].1 {
            Pipeline::Light(_) => frame.draw_for_each_light(batch, layout),
            _ => frame.draw_instances(batch, run),
        });
    }

    /// Draws, and counts the fragments if that is asked for.
    pub(super) fn counted(
        &mut self,
        stage: usize,
        pipeline: usize,
        drawn: Option<DrawnMesh>,
        draw: impl FnOnce(&mut Self),
    ) {
        let recorder = self.recorder;
        self.fragments.iter_mut().for_each(|f| f.begin(recorder, stage, pipeline, drawn));
        draw(self);
        self.fragments.iter_mut().for_each(|f| f.end(recorder));
    }

    /// Draws of a batch what each light reaches, or all of it where the plan has no illumination sets. The lights take
    /// turns within a batch, not the batches within a light, so that state changes once; a pixel gets them in the same
    /// order either way.
    fn draw_for_each_light(&mut self, batch: &Batch, layout: vk::PipelineLayout) {
        let scene = &self.renderer.scene;
        for (light, reach) in (0..).zip(scene.light_reaches()) {
            let mut rest = batch.visible.clone();
            let push = LightPush { light };
            let mut pushed = false;
            loop {
                let run = scene.objects().first_lit(rest.clone(), reach);
                if run.is_empty() {
                    break;
                }
                if !pushed {
                    let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
                    let stages = vk::ShaderStageFlags::FRAGMENT;
                    // SAFETY: the layout has these bytes for this stage.
                    unsafe { device.cmd_push_constants(raw, layout, stages, 0, bytemuck::bytes_of(&push)) };
                    pushed = true;
                }
                self.draw_instances(batch, run.clone());
                rest.start = run.end;
            }
        }
    }

    fn draw_instances(&mut self, batch: &Batch, instances: Range<u32>) {
        self.renderer.scene.draw(self.recorder, batch, instances, &mut self.counts);
    }

    /// Binds the n-th of `Plan::pipelines` and what its frame has once.
    pub(super) fn bind_pipeline(&mut self, index: usize) -> vk::PipelineLayout {
        let Renderer { pipelines, scene, .. } = self.renderer;
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        let pipeline = pipelines.pipelines[index].raw();
        // SAFETY: the pipeline was made for this subpass and is kept alive by the renderer.
        unsafe { device.cmd_bind_pipeline(raw, vk::PipelineBindPoint::GRAPHICS, pipeline) };
        self.counts.state_changes.pipelines += 1;
        let layout = pipelines.layout_of(index).layout.raw();
        let family = pipelines.families[index];
        if family.frame() == 0 {
            // Its layout is another one's from the first set on.
            self.bound_frame = None;
            return layout;
        }
        let set = scene.frame_set(self.slot, family);
        let bound = Some((set, family.has_push_constants()));
        if self.bound_frame != bound {
            self.bind_set(layout, 0, set);
            self.bound_frame = bound;
        }
        layout
    }

    pub(super) fn bind_set(&mut self, layout: vk::PipelineLayout, index: u32, set: vk::DescriptorSet) {
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the set was allocated with the layout's n-th set layout, and all its bindings are written.
        unsafe { device.cmd_bind_descriptor_sets(raw, point, layout, index, &[set], &[]) };
        self.counts.state_changes.descriptor_sets += 1;
    }
}

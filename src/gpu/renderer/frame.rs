//! Recording a frame: its interface.

use ash::vk;

use super::record::Frame;
use super::{Recorded, Renderer};
use crate::gpu::overlay::scissor;
use crate::gpu::{Recorder, Target, View};
use crate::plan::FrameCounts;

impl Renderer {
    /// Records a frame: no allocation, no wait, no submission.
    ///
    /// `slot` is below [`RendererConfig::frames_in_flight`](crate::gpu::RendererConfig::frames_in_flight), and the GPU has finished the frame that was recorded with it
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
        let vk::Extent2D { width, height } = target.extent();
        let [width, height] = target.pre_rotation().size([width, height]);
        self.record_part(recorder, slot, target, output, view, [0, 0, width, height]);
    }

    /// As [`Self::record`], of a part of the picture, upright: left, top, right and bottom, pixels. Tiles beyond it are neither drawn nor stored.
    ///
    /// What is elsewhere in the output image is lost, unless the plan [keeps it](crate::plan::Options::output_is_kept); then the image
    /// is in [`Self::output_layout`] before. So two renderers share an image: one draws its part of it, then one that keeps what is
    /// there draws the rest. Passes after the frame's own draw the whole picture.
    ///
    /// # Panics
    /// As [`Self::record`]; if nothing of the part lies in the picture.
    pub fn record_part(
        &mut self,
        recorder: &Recorder<'_>,
        slot: usize,
        target: &Target,
        output: usize,
        view: &View<'_>,
        part_px: [u32; 4],
    ) {
        assert!(
            self.created(target),
            "the target was created by another renderer, or before an update that asked for new targets"
        );
        let vk::Extent2D { width, height } = target.extent();
        let picture = target.pre_rotation().size([width, height]);
        let area = scissor(part_px, picture, target.pre_rotation());
        let area = area.expect("a part of the picture has pixels");
        self.retired.recording(slot);
        let turned = target.pre_rotated_camera(view.camera);
        let view = &View { camera: turned.as_ref().unwrap_or(view.camera), ..*view };
        let exposure = view.exposure();
        let scattered = target.post().map_or([0.0; 2], |post| post.scattered(&self.plan, exposure));
        let (size, cull) = ([width, height], self.config.cull);
        let seen =
            self.scene.write_frame(slot, view, &self.plan, (size, target.pre_rotation()), cull, scattered);
        let _label = recorder.label("ontile frame");
        if let Some(queries) = self.queries() {
            queries.reset(recorder, slot as u32);
            queries.begin_statistics(recorder, slot as u32);
            queries.timestamp(recorder, slot as u32, 0, vk::PipelineStageFlags::TOP_OF_PIPE);
        }
        let aspect = f64::from(width) / f64::from(height);
        if let Some(post) = target.post() {
            post.prepare(recorder, &self.plan);
            post.recorded(exposure);
        }
        self.scene.poses_mut().into_iter().for_each(|poses| poses.record(recorder, slot));
        let shadows = self.shadows.as_mut().map(|s| s.record(recorder, slot, view, aspect, &self.scene));
        let shadows = shadows.unwrap_or_default();
        let counts = FrameCounts { objects: seen.objects, lights: seen.lights, ..FrameCounts::default() };
        let mut fragments = self.fragments.take_if(|_| self.has_queries);
        fragments.iter_mut().for_each(|fragments| fragments.reset(recorder, slot));
        let mut frame = Frame {
            renderer: self,
            recorder,
            slot,
            target,
            output,
            area,
            counts,
            bound_frame: None,
            fragments,
        };
        frame.record();
        let Frame { counts, fragments, .. } = frame;
        self.fragments = fragments.or(self.fragments.take());
        self.recorded = Recorded { counts, light_lists: seen.light_lists, shadows };
    }
}

//! Recording the passes after the frame's own.

use ash::vk;

use super::super::conv;
use super::super::post::{PostPasses, PostTarget};
use super::record::Frame;
use crate::plan::PostPass;

impl Frame<'_> {
    pub(super) fn record_post(&mut self) {
        let (Some(passes), Some(target)) = (&self.renderer.post, self.target.post()) else { return };
        for (index, pass) in self.renderer.plan.post.passes.iter().enumerate() {
            let _label = self.recorder.label(&pass.name);
            self.draw_post(passes, target, index, pass);
        }
        target.release(self.recorder, &self.renderer.plan, self.output);
    }

    fn draw_post(&mut self, passes: &PostPasses, target: &PostTarget, index: usize, pass: &PostPass) {
        let extent = target
            .size(pass.target)
            .map_or(self.target.extent(), |[width, height]| vk::Extent2D { width, height });
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(passes.pass(index))
            .framebuffer(target.framebuffer(self.output, index))
            .render_area(area);
        let family = passes.family(index);
        let layout = self.renderer.pipelines.layouts[&family].layout.raw();
        let own = target.set(self.output, index);
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: framebuffer, pipeline and sets were made for this pass and its layout; all dynamic state is set.
        unsafe {
            device.cmd_begin_render_pass(raw, &info, vk::SubpassContents::INLINE);
            device.cmd_set_viewport(raw, 0, &[conv::viewport(area)]);
            device.cmd_set_scissor(raw, 0, &[area]);
            device.cmd_bind_pipeline(raw, point, passes.pipeline(pass.kind));
            if family.frame() == 0 {
                device.cmd_bind_descriptor_sets(raw, point, layout, 0, &[own], &[]);
            } else {
                let frame = self.renderer.scene.frame_set(self.slot, family);
                device.cmd_bind_descriptor_sets(raw, point, layout, 0, &[frame, own], &[]);
            }
            device.cmd_draw(raw, 3, 1, 0, 0);
            device.cmd_end_render_pass(raw);
        }
        self.counts.draws += 1;
        self.counts.triangles += 1;
        self.counts.state_changes.pipelines += 1;
        self.counts.state_changes.descriptor_sets += 1;
    }
}

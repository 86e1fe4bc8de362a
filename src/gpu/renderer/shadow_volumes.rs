//! Recording lights whose shadows are volumes: each after its shadows were counted in the stencil.

use ash::vk;

use super::record::Frame;

impl Frame<'_> {
    /// Draws each light of this kind that the view sees: first the space behind what faces it, then its light where that is not.
    pub(super) fn draw_shadowed_lights(&mut self, stage: usize, pipeline: usize) {
        let renderer = self.renderer;
        // The plan lists them before it.
        let [near, others] = [2, 1].map(|before| pipeline.checked_sub(before));
        let (Some(near), Some(others)) = (near, others) else { return };
        let Some(casters) = renderer.scene.volume_casters() else { return };
        for light in renderer.scene.volume_lights() {
            for (count, near_ends) in [(near, true), (others, false)] {
                let layout = self.bind_pipeline(count);
                casters.in_reach(light.light, &light.reach, near_ends, |push, vertices, instances| {
                    let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
                    let stages = vk::ShaderStageFlags::VERTEX;
                    // SAFETY: the layout has these bytes for this stage.
                    unsafe { device.cmd_push_constants(raw, layout, stages, 0, bytemuck::bytes_of(push)) };
                    self.draw_generated(vertices, instances);
                });
            }
            self.counted(stage, pipeline, None, |frame| {
                frame.bind_with_inputs(stage, pipeline);
                frame.draw_generated(3, light.index..light.index + 1);
            });
        }
    }
}

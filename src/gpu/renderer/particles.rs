//! Recording particles.

use super::record::Frame;

impl Frame<'_> {
    /// Adds the light of what the view sees of one pipeline's particles.
    pub(super) fn draw_particles(&mut self, stage: usize, pipeline: usize) {
        /// Two triangles.
        const VERTICES: u32 = 6;
        let renderer = self.renderer;
        let own = renderer.scene.particles().runs().iter().filter(|run| run.pipeline == pipeline);
        for (number, run) in own.enumerate() {
            self.counted(stage, pipeline, None, |frame| {
                let layout = renderer.pipelines.layout_of(pipeline).layout.raw();
                if number == 0 {
                    frame.bind_pipeline(pipeline);
                    if let Some(set) = renderer.pipelines.families[pipeline].inputs_set()
                        && let Some(inputs) = frame.target.inputs(frame.output, stage)
                    {
                        frame.bind_set(layout, set as u32, inputs);
                    }
                }
                frame.bind_set(layout, 1, renderer.scene.material_set(run.material_set));
                frame.draw_generated(VERTICES, run.instances.clone());
            });
        }
    }
}

//! Recording decals.

use ash::vk;

use super::super::conv;
use super::record::Frame;
use crate::plan::{Access, DecalWay};

impl Frame<'_> {
    /// Paints what the view sees of the scene's decals.
    pub(super) fn draw_decals(&mut self, stage: usize) {
        /// Two triangles for each side of a box.
        const VERTICES: u32 = 36;
        let renderer = self.renderer;
        let barriers = renderer.plan.decal_way == Some(DecalWay::Barrier);
        let mut bound = None;
        let mut level = 0;
        for run in renderer.scene.decals().runs() {
            if barriers && run.level > level {
                self.wait_for_earlier_draws();
            }
            level = run.level;
            self.counted(stage, run.pipeline, None, |frame| {
                let is_bound = bound.is_some_and(|(pipeline, _)| pipeline == run.pipeline);
                if !is_bound {
                    frame.bind_with_inputs(stage, run.pipeline);
                }
                if bound != Some((run.pipeline, run.material_set)) {
                    let layout = renderer.pipelines.layout_of(run.pipeline).layout.raw();
                    frame.bind_set(layout, 2, renderer.scene.material_set(run.material_set));
                }
                frame.draw_generated(VERTICES, run.instances.clone());
            });
            bound = Some((run.pipeline, run.material_set));
        }
    }

    /// What was drawn to a pixel in this subpass is there to be read by what is drawn next.
    fn wait_for_earlier_draws(&self) {
        let [(src_stages, src_access), (dst_stages, dst_access)] = Access::BETWEEN_DRAWS.map(conv::access);
        let barrier = vk::MemoryBarrier::default().src_access_mask(src_access).dst_access_mask(dst_access);
        let (device, raw) = (self.recorder.device().raw(), self.recorder.raw());
        // SAFETY: the subpass has a dependency on itself of just these scopes, by region as here.
        unsafe {
            device.cmd_pipeline_barrier(
                raw,
                src_stages,
                dst_stages,
                vk::DependencyFlags::BY_REGION,
                &[barrier],
                &[],
                &[],
            );
        }
    }
}

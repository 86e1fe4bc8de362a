//! A scene and what draws it.

use std::sync::Arc;

use crate::Result;
use crate::gpu::{
    Commands, Device, Explanation, PipelineCache, Renderer, RendererConfig, Swapchain, Target,
    expected_advice,
};
use crate::plan::{Needs, Options, OutputUse, Plan, Report};
use crate::scene::{PreRotation, Scene};

/// A scene, its renderer and, where there is a window to draw to, the target of its images. Dropped when no frame is on the GPU.
pub(super) struct Shown {
    // In order of destruction.
    pub(super) target: Option<Target>,
    pub(super) renderer: Renderer,
    pub(super) scene: Arc<Scene>,
    /// Whether a frame was recorded with each slot.
    pub(super) recorded: Vec<bool>,
    pub(super) explanation: Explanation,
    pub(super) report: Report,
    /// What the validation layer may say of the plan.
    pub(super) excused: Vec<&'static str>,
}

impl Shown {
    /// Makes all that draws a scene to a window, and uploads it.
    pub(super) fn new(
        device: &Device,
        cache: &PipelineCache,
        scene: &Arc<Scene>,
        options: &Options,
        (swapchain, pre_rotation): (&Swapchain, PreRotation),
        frames_in_flight: usize,
    ) -> Result<Self> {
        let options = of_window(options, swapchain);
        let plan = Plan::new(Needs::of(scene), options, &device.limits())?;
        let excused = expected_advice(&plan);
        let (explanation, report) = (Explanation::new(scene, &plan)?, plan.report(scene));
        // On a tiler the stages of one pass interleave, so times between them would be of nothing.
        let interleaved = device.caps().lazily_allocated_memory && plan.passes.len() == 1;
        let stage_timestamps = plan.options.overlay && !interleaved;
        let config = RendererConfig { frames_in_flight, stage_timestamps, ..RendererConfig::default() };
        let mut renderer = Renderer::new(device, scene, plan, config, cache)?;
        Commands::run(device, "upload", |recorder| {
            renderer.record_upload(recorder);
            Ok(())
        })?;
        renderer.finish_upload();
        let recorded = vec![false; renderer.frames_in_flight()];
        let scene = Arc::clone(scene);
        let mut shown = Self { target: None, renderer, scene, recorded, explanation, report, excused };
        shown.fit(swapchain, pre_rotation)?;
        Ok(shown)
    }

    /// Whether its plan is for images like these.
    pub(super) fn suits(&self, swapchain: &Swapchain) -> bool {
        let options = &self.renderer.plan().options;
        (options.output, options.output_is_input_attachment)
            == (swapchain.format(), swapchain.is_input_attachment())
    }

    /// Makes the target of these images; no frame to the former one is on the GPU.
    pub(super) fn fit(&mut self, swapchain: &Swapchain, pre_rotation: PreRotation) -> Result<()> {
        self.target = None;
        let mut target = self.renderer.create_target(swapchain.size(), &swapchain.outputs())?;
        target.pre_rotate(pre_rotation);
        self.target = Some(target);
        Ok(())
    }
}

/// The options as the window has them.
fn of_window(options: &Options, swapchain: &Swapchain) -> Options {
    Options {
        size: swapchain.size(),
        output: swapchain.format(),
        output_use: OutputUse::Present,
        output_is_input_attachment: swapchain.is_input_attachment(),
        ..options.clone()
    }
}

//! A scene and what draws it.

use crate::Result;
use crate::gpu::{
    Commands, Device, Explanation, Image, ImageDesc, OutputImage, PipelineCache, Renderer, RendererConfig,
    Swapchain, Target, expected_advice,
};
use crate::plan::{Needs, Options, OutputUse, Plan, Report};
use crate::scene::{PreRotation, Scene};

/// A scene, its renderer and, where there is a window to draw to, the target of its images. Dropped when no frame is on the GPU.
pub(super) struct Shown {
    // In order of destruction.
    pub(super) target: Option<Target>,
    /// What it draws to in the window's place, if another picture is compared with it.
    own: Option<Image>,
    pub(super) renderer: Renderer,
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
        scene: &Scene,
        options: &Options,
        (swapchain, pre_rotation): (&Swapchain, PreRotation),
        frames_in_flight: usize,
        before: Option<&Self>,
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
        let mut shown = Self { target: None, own: None, renderer, recorded, explanation, report, excused };
        shown.fit((swapchain, pre_rotation), before)?;
        Ok(shown)
    }

    /// Whether its plan is for images like these.
    pub(super) fn suits(&self, swapchain: &Swapchain) -> bool {
        let options = &self.renderer.plan().options;
        (options.output, options.output_is_input_attachment)
            == (swapchain.format(), swapchain.is_input_attachment())
    }

    /// Makes the target of these images, which has none: see [`Self::take_images`]. `before` draws what this is compared with.
    pub(super) fn fit(
        &mut self,
        (swapchain, pre_rotation): (&Swapchain, PreRotation),
        before: Option<&Self>,
    ) -> Result<()> {
        self.target = None;
        let renderer = &self.renderer;
        let size = swapchain.size();
        let other = before.and_then(|before| before.own.as_ref());
        let mut target = match (renderer.plan().options.output_use, other) {
            (OutputUse::Present, None) => renderer.create_target(size, &swapchain.outputs())?,
            (OutputUse::Present, Some(other)) => {
                renderer.create_target_beside(size, &swapchain.outputs(), other.view())?
            }
            _ => {
                let own = match self.own.take().filter(|own| own.size() == size) {
                    Some(own) => own,
                    None => {
                        let (format, usage) = (renderer.output_format(), renderer.output_usage());
                        Image::new(renderer.device(), &ImageDesc::new("compared", format, size, usage))?
                    }
                };
                let own = self.own.insert(own);
                renderer.create_target(size, &[OutputImage { image: own.raw(), view: own.view() }])?
            }
        };
        target.pre_rotate(pre_rotation);
        self.target = Some(target);
        Ok(())
    }

    /// Takes what goes with the window's images, of which frames may be on the GPU.
    pub(super) fn take_images(&mut self) -> (Option<Target>, Option<Image>) {
        (self.target.take(), self.own.take())
    }

    /// The image among the target's that the window's n-th is drawn to, or from.
    pub(super) fn output(&self, image: usize) -> usize {
        if self.own.is_some() { 0 } else { image }
    }
}

/// The options as the window has them.
fn of_window(options: &Options, swapchain: &Swapchain) -> Options {
    Options {
        size: swapchain.size(),
        output: swapchain.format(),
        output_use: match options.output_use {
            OutputUse::Sample => OutputUse::Sample,
            _ => OutputUse::Present,
        },
        output_is_input_attachment: swapchain.is_input_attachment(),
        ..options.clone()
    }
}

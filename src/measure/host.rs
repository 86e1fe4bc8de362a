//! A host that renders and measures frames, without reading them back.

use std::time::Instant;

use crate::Result;
use crate::gpu::{
    Commands, Device, Image, ImageDesc, OutputImage, PipelineCache, Renderer, RendererConfig, Target, View,
};
use crate::plan::{Needs, Options, Plan};
use crate::scene::Scene;

/// One way to render a scene.
pub struct Host {
    // In order of destruction; `commands` waits for the GPU first.
    commands: Commands,
    target: Target,
    _output: Image,
    /// What draws.
    pub renderer: Renderer,
}

/// What one frame took.
pub struct FrameTimes {
    /// From the first timestamp to the last; `None` if the device has none.
    pub gpu_ms: Option<f64>,
    /// Of each stage, by timestamps.
    pub stages_ms: Vec<f64>,
    /// Recording, by the CPU.
    pub record_ms: f64,
    /// Submission and waiting.
    pub wall_ms: f64,
}

impl Host {
    /// Makes everything and uploads the scene; `stage_timestamps` as in [`RendererConfig`].
    ///
    /// # Errors
    /// As [`Plan::new`] and [`Renderer::new`].
    pub fn new(device: &Device, scene: &Scene, options: &Options, stage_timestamps: bool) -> Result<Self> {
        let plan = Plan::new(Needs::of(scene), options.clone(), &device.limits())?;
        // Empty: every variant compiles its own pipelines.
        let cache = PipelineCache::new(device, &[])?;
        let config = RendererConfig { frames_in_flight: 1, stage_timestamps, ..Default::default() };
        let mut host = Self::with_renderer(device, Renderer::new(device, scene, plan, config, &cache)?)?;
        host.upload()?;
        Ok(host)
    }

    /// With a renderer of the caller's; [`Self::upload`] is to follow.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn with_renderer(device: &Device, renderer: Renderer) -> Result<Self> {
        let size = renderer.plan().options.size;
        let output = Image::new(
            device,
            &ImageDesc::new("output", renderer.output_format(), size, renderer.output_usage()),
        )?;
        let images = [OutputImage { image: output.raw(), view: output.view() }];
        let target = renderer.create_target(size, &images)?;
        let commands = Commands::new(device, "frame")?;
        Ok(Self { commands, target, _output: output, renderer })
    }

    /// Brings the scene to the device.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn upload(&mut self) -> Result<()> {
        let Self { commands, renderer, .. } = self;
        commands.record(|recorder| {
            renderer.record_upload(recorder);
            Ok(())
        })?;
        commands.submit()?;
        commands.wait()?;
        renderer.finish_upload();
        Ok(())
    }

    /// Records a frame; what it took the CPU, in milliseconds.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn record(&mut self, view: &View<'_>) -> Result<f64> {
        let Self { commands, renderer, target, .. } = self;
        commands.record(|recorder| {
            let start = Instant::now();
            renderer.record(recorder, 0, target, 0, view);
            Ok(start.elapsed().as_secs_f64() * 1e3)
        })
    }

    /// Records and runs a frame.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn frame(&mut self, view: &View<'_>) -> Result<FrameTimes> {
        let record_ms = self.record(view)?;
        let start = Instant::now();
        self.commands.submit()?;
        self.commands.wait()?;
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        let stamps_ms: Vec<f64> = self.renderer.query_results(0)?.timestamps_ns.unwrap_or_default();
        let stamps_ms: Vec<f64> = stamps_ms.into_iter().map(|ns| ns * 1e-6).collect();
        Ok(FrameTimes {
            gpu_ms: stamps_ms.last().copied(),
            stages_ms: stamps_ms.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            record_ms,
            wall_ms,
        })
    }

    /// The names of the stages, in the order of [`FrameTimes::stages_ms`].
    pub fn stages(&self) -> Vec<&'static str> {
        let plan = self.renderer.plan();
        (0..plan.stage_count()).map(|stage| plan.subpass(stage).2.name).collect()
    }
}

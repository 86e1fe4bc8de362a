//! How many pixels are lit sample by sample.

use crate::Result;
use crate::gpu::{Device, Offscreen, PipelineCache, RendererConfig, View};
use crate::plan::{Pipeline, Plan};
use crate::scene::Scene;

/// The share of a view's pixels that edges mark in the stencil, counted by the GPU in a frame of its own; `None` if the plan marks none
/// (one sample a pixel, or every sample lit) or the device does not count precisely.
///
/// # Errors
/// Those of [`Offscreen`].
pub fn lit_by_sample(
    device: &Device,
    scene: &Scene,
    plan: &Plan,
    view: &View<'_>,
    cache: &PipelineCache,
) -> Result<Option<f64>> {
    let edges = plan.pipelines.iter().position(|(_, pipeline)| *pipeline == Pipeline::Edges);
    let Some(edges) = edges.filter(|_| device.features().occlusion_precise) else { return Ok(None) };
    let config = RendererConfig { frames_in_flight: 1, count_fragments: true, ..RendererConfig::default() };
    let mut offscreen = Offscreen::new(device, scene, plan.clone(), config, cache)?;
    offscreen.render(view)?;
    let counts = offscreen.renderer().draw_counts(0)?;
    let samples: u64 = counts.iter().filter(|c| c.pipeline == edges).map(|c| c.fragments).sum();
    let [width, height] = plan.options.size.map(f64::from);
    Ok(Some(samples as f64 / (width * height * f64::from(plan.options.samples))))
}

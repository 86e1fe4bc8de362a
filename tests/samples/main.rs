//! Several samples a pixel: the same picture however it is arranged, edges that are as smooth as they should be, and refusals.

#[path = "../common/mod.rs"]
mod common;

mod arrangements;
mod edges;
mod refusals;
mod translucent;
mod truth;

use common::render::Gpu;
use ontile::glam::DVec3;
use ontile::picture::Pixels;
use ontile::plan::{Layout, Options, OutputFormat};
use ontile::scene::Scene;

/// The display light of a picture whose surfaces are stored as exactly as can be.
fn light_of(gpu: &Gpu<'_>, scene: &Scene, options: Options) -> Vec<DVec3> {
    let options = Options { layout: Layout::Exact, output: OutputFormat::Rgba32Float, ..options };
    let picture = gpu.picture(scene, gpu.plan(scene, options), 0.0);
    let Pixels::Rgba32F(channels) = picture.pixels else { unreachable!("the output is of floats") };
    channels.chunks(4).map(|c| DVec3::new(c[0].into(), c[1].into(), c[2].into())).collect()
}

/// Root of the mean squared difference.
fn error(a: &[DVec3], b: &[DVec3]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (*a - *b).length_squared()).sum();
    (squares / a.len() as f64).sqrt()
}

//! What the 128 bits of `metallic128` cost, and that they cost no more than their formats say.

use ontile::measure::metrics::{ErrorStats, psnr_db};
use ontile::plan::{Layout, OutputFormat, Tonemap};
use ontile::reference::{Frame, Settings, render, shade_gbuffer};

use crate::gpu::{Ask, Gpu};
use crate::scenes;

const METALLIC128: Ask = Ask {
    layout: Layout::Metallic128,
    tonemap: Tonemap::Neutral,
    exposure_ev: 0.0,
    output: OutputFormat::Rgba8Srgb,
};

/// Differences of 8-bit codes over the covered pixels that are not at edges.
struct CodeErrors {
    stats: ErrorStats,
    /// The greatest channel's of each pixel, largest first.
    sorted: Vec<u8>,
}

impl CodeErrors {
    fn new(expected: &Frame, found: &[[u8; 3]]) -> Self {
        let codes = expected.to_rgba8_srgb();
        let (mut stats, mut sorted) = (ErrorStats::default(), Vec::new());
        let pixels = expected.pixels.iter().zip(codes.chunks_exact(4)).zip(found);
        for ((_, expected), found) in pixels.filter(|((p, _), _)| p.covered && !p.edge) {
            expected.iter().zip(found).for_each(|(&a, &b)| stats.add(f64::from(a), f64::from(b)));
            sorted.extend(expected.iter().zip(found).map(|(a, b)| a.abs_diff(*b)).max());
        }
        sorted.sort_by(|a, b| b.cmp(a));
        Self { stats, sorted }
    }

    fn quantile(&self, part: f64) -> u8 {
        self.sorted[((1.0 - part) * self.sorted.len() as f64) as usize]
    }

    fn psnr_db(&self) -> f64 {
        psnr_db(self.stats.mse(), 255.0)
    }
}

impl std::fmt::Display for CodeErrors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [q50, q90, q99, q999, all] = [0.5, 0.9, 0.99, 0.999, 1.0].map(|part| self.quantile(part));
        write!(
            f,
            "PSNR {:.1} dB; steps of 255: 50 % within {q50}, 90 % {q90}, 99 % {q99}, 99.9 % {q999}, all {all}",
            self.psnr_db()
        )
    }
}

/// The same frame with the layout's formats in it.
fn quantised(settings: &Settings) -> Settings {
    Settings { layout: Some(Layout::Metallic128), ..settings.clone() }
}

#[test]
fn the_error_is_what_the_bits_cost() {
    let Some(gpu) = Gpu::open() else { return };
    for scene in scenes::all() {
        for camera in &scene.cameras {
            let (rendered, gbuffer) = gpu.render_with_gbuffer(&scene, camera, METALLIC128);
            let codes = rendered.codes();
            let against = |frame: &Frame| CodeErrors::new(frame, &codes);
            let exact_frame = render(&scene, camera, &rendered.settings);
            let exact = against(&exact_frame);
            let same_bits = against(&render(&scene, camera, &quantised(&rendered.settings)));
            let mut own = shade_gbuffer(&scene, camera, &quantised(&rendered.settings), &gbuffer);
            for (own, exact) in own.pixels.iter_mut().zip(&exact_frame.pixels) {
                (own.covered, own.edge) = (exact.covered, exact.edge);
            }
            let own_bits = against(&own);
            let name = format!("{}, {}", scene.name, camera.name);
            println!("{name}: against f64        {exact}");
            println!("{name}: against its formats {same_bits}");
            println!("{name}: against its G-buffer {own_bits}");
        }
    }
    gpu.finish();
}

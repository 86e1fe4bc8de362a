//! What the 128 bits of `metallic128` cost, and that they cost no more than their formats say.

use ontile::glam::DVec3;
use ontile::measure::metrics::{ErrorStats, psnr_db};
use ontile::plan::{GBuffer, Layout, OutputFormat, Path, Tonemap};
use ontile::reference::texture::srgb_from_linear;
use ontile::reference::{Attributes, Frame, Settings, Stored, View, encode, render, shade_gbuffer};
use ontile::scene::{Camera, Scene};

use crate::SIZE;
use crate::error::PROMISED_PART;
use crate::gpu::{Ask, Gpu, Rendered};
use crate::scenes;

const METALLIC128: Ask = Ask {
    layout: Layout::Metallic128,
    path: Path::Deferred,
    tonemap: Tonemap::Neutral,
    exposure_ev: 0.0,
    output: OutputFormat::Rgba8Srgb,
    ..Ask::EXACT
};

fn metallic128() -> GBuffer {
    GBuffer::new(&METALLIC128.options()).expect("it is complete")
}

/// The least PSNR (dB) and the greatest 99th percentile (steps of 255) by scene, against f64.
///
/// Eight bits turn a normal by up to 0.39 degrees, 7e-3 rad. Light at 45 degrees then changes by 0.7 %, which is 0.8
/// steps of the output; base colour and output round by half a step each: 1 to 2 steps (lights, placements). A lobe
/// of small roughness is narrower than that angle, and moves as a whole (materials). The light target's step, 2 / 1023,
/// is 3 steps of the output at a linear value of 0.01 (surfaces). A sun 6 degrees high changes by 7 % (grazing).
const COST: [(&str, f64, u8); 6] = [
    ("lights", 52.0, 2),
    ("materials", 45.0, 7),
    ("placements", 52.0, 2),
    ("surfaces", 45.0, 4),
    ("grazing", 40.0, 10),
    ("along light", 50.0, 3),
];

/// Differences of 8-bit codes over the covered pixels that are not at edges.
struct CodeErrors {
    stats: ErrorStats,
    /// The greatest channel's of each pixel, largest first.
    sorted: Vec<f64>,
}

impl CodeErrors {
    fn new(expected: &Frame, found: &[[u8; 3]]) -> Self {
        let codes = expected.to_rgba8_srgb();
        let (mut stats, mut sorted) = (ErrorStats::default(), Vec::new());
        let pixels = expected.pixels.iter().zip(codes.chunks_exact(4)).zip(found);
        for ((_, expected), found) in pixels.filter(|((p, _), _)| p.covered && !p.edge) {
            let pairs = || expected.iter().zip(found).map(|(&a, &b)| (f64::from(a), f64::from(b)));
            pairs().for_each(|(a, b)| stats.add(a, b));
            sorted.push(pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max));
        }
        sorted.sort_by(|a, b| b.total_cmp(a));
        Self { stats, sorted }
    }

    fn psnr_db(&self) -> f64 {
        psnr_db(self.stats.mse(), 255.0)
    }
}

/// The value that `part` of the sorted ones do not exceed.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    sorted[((1.0 - part) * sorted.len() as f64) as usize]
}

fn describe(sorted: &[f64]) -> String {
    let [q50, q90, q99, q999, all] = [0.5, 0.9, 0.99, PROMISED_PART, 1.0].map(|part| quantile(sorted, part));
    format!("50 % within {q50:.2}, 90 % {q90:.2}, 99 % {q99:.2}, 99.9 % {q999:.2}, all {all:.2}")
}

#[test]
fn the_error_against_f64_is_what_the_bits_cost() {
    let Some(gpu) = Gpu::open() else { return };
    let mut failed = Vec::new();
    // Kinds of lights change nothing in what a G-buffer stores, so their scenes have no bounds here.
    for (scene, (name, least_psnr_db, most_steps)) in scenes::all().into_iter().zip(COST) {
        assert_eq!(scene.name, name, "the bounds are in the order of the scenes");
        for camera in &scene.cameras {
            let rendered = gpu.render(&scene, camera, METALLIC128);
            let errors = CodeErrors::new(&render(&scene, camera, &rendered.settings), &rendered.codes());
            let (psnr_db, text) = (errors.psnr_db(), describe(&errors.sorted));
            println!("{}, {}: PSNR {psnr_db:.1} dB; steps of 255: {text}", scene.name, camera.name);
            if !(psnr_db >= least_psnr_db && quantile(&errors.sorted, 0.99) <= f64::from(most_steps)) {
                failed.push(format!("{}, {}: PSNR {psnr_db:.1} dB, {text}", scene.name, camera.name));
            }
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// A frame whose coarsest step is also the unit of its errors: 8-bit codes where light goes straight to the output;
/// linear floats in steps of the light target where there is one, whose 10 bits of light are coarser than the codes.
struct InSteps<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    rendered: Rendered,
    gbuffer: Vec<Stored>,
    /// The reference's frame without formats.
    exact: Frame,
}

impl<'a> InSteps<'a> {
    fn new(gpu: &Gpu, scene: &'a Scene, camera: &'a Camera) -> Self {
        let (mut rendered, mut gbuffer) = gpu.render_with_gbuffer(scene, camera, METALLIC128);
        if rendered.settings.light_target {
            let linear = Ask { tonemap: Tonemap::Linear, output: OutputFormat::Rgba32Float, ..METALLIC128 };
            (rendered, gbuffer) = gpu.render_with_gbuffer(scene, camera, linear);
        }
        let exact = render(scene, camera, &rendered.settings);
        Self { scene, camera, rendered, gbuffer, exact }
    }

    /// The reference's settings with the layout's formats in them.
    fn settings(&self) -> Settings {
        Settings { gbuffer: Some(metallic128()), ..self.rendered.settings.clone() }
    }

    /// Everything from the scene; pixels whose surface the GPU rounded to other codes count as edges.
    fn given_scene(&self, settings: &Settings) -> Frame {
        let mut frame = render(self.scene, self.camera, settings);
        for (pixel, alike) in frame.pixels.iter_mut().zip(self.like_codes()) {
            pixel.edge |= !alike;
        }
        frame
    }

    /// Whether the GPU's codes are the nearest to the surface that the reference's ray finds.
    fn like_codes(&self) -> Vec<bool> {
        /// Half a code is 2e-3 (sRGB in the dark: 1.5e-4); f32 reads codes back to 1e-7.
        const SAME: f64 = 1e-5;
        let (gbuffer, view) = (metallic128(), View::new(self.camera, SIZE));
        let alike = |(pixel, stored): (&ontile::reference::Pixel, &Stored)| {
            let nearest = encode(&gbuffer, &pixel.attributes, &view, 1.0);
            let [normal_roughness, base_metallic] = [0, 1].map(|t| (nearest.targets[t], stored.targets[t]));
            !pixel.covered
                || (normal_roughness.0.abs_diff_eq(normal_roughness.1, SAME)
                    && base_metallic.0.truncate().abs_diff_eq(base_metallic.1.truncate(), SAME))
        };
        self.exact.pixels.iter().zip(&self.gbuffer).map(alike).collect()
    }

    /// Lighting and tonemap only, from the bits that the GPU wrote.
    fn given_gbuffer(&self, settings: &Settings) -> Frame {
        let mut frame = shade_gbuffer(self.scene, self.camera, settings, &self.gbuffer);
        for (pixel, seen) in frame.pixels.iter_mut().zip(&self.exact.pixels) {
            (pixel.covered, pixel.edge) = (seen.covered, seen.edge);
        }
        frame
    }

    /// The differences in steps, largest first.
    fn errors(&self, expected: &Frame) -> Vec<f64> {
        if !self.rendered.settings.light_target {
            return CodeErrors::new(expected, &self.rendered.codes()).sorted;
        }
        let step = 1.0 / (1023.0 * self.rendered.settings.light_scale);
        let pixels = expected.pixels.iter().zip(self.rendered.light());
        let mut sorted: Vec<f64> = pixels
            .filter(|(p, _)| p.covered && !p.edge)
            .map(|(p, found)| ((found - p.display) / step).abs().max_element())
            .collect();
        sorted.sort_by(|a, b| b.total_cmp(a));
        sorted
    }
}

/// A step, and the rounding of the float that it is read from.
const ONE_STEP: f64 = 1.001;
/// Vulkan lets a conversion to UNORM take either of the two nearest codes, and lavapipe takes the lower one in the
/// light target, once when geometry writes and once when lighting blends.
const TWO_STEPS: f64 = 2.001;

/// Whether all are whole steps, as between light that was rounded on both sides; else one side did not round.
fn are_whole(errors: &[f64]) -> bool {
    /// What reading a step as f32 leaves of it, some roundings of 2^-24 of 1023 steps.
    const ROUNDING: f64 = 1e-3;
    errors.iter().all(|error| (error - error.round()).abs() <= ROUNDING)
}

/// UNORM channels round to the nearest code, but for what f32 leaves of normals (4e-6 of 127 codes).
const UNORM_CODE_ERROR: f64 = 0.5 + 1e-2;
/// Vulkan lets a conversion take either of the two nearest codes: sRGB encoders are approximations (lavapipe's is up to
/// 0.14 codes off).
const SRGB_CODE_ERROR: f64 = 1.0;
/// Where a value lies near a tie, as 0.3, 0.5 and 0.9 of 255 do, GPU and reference may take different neighbours, and
/// either is right. Some pixels must be left to compare.
const LEAST_PART_OF_LIKE_CODES: f64 = 0.25;

/// How far a pixel's codes are from the surface that the reference's ray finds, in codes: the farthest UNORM channel's,
/// and the farthest sRGB channel's.
fn code_errors(exact: &Attributes, stored: &Stored) -> [f64; 2] {
    let encoded = |c: DVec3| DVec3::from_array(c.to_array().map(srgb_from_linear));
    let [normal_roughness, base_metallic, ..] = stored.targets;
    let base = encoded(base_metallic.truncate()) - encoded(exact.base_color);
    let surface = (exact.normal_world * 0.5 + 0.5).extend(exact.roughness);
    let surface = if exact.lit { normal_roughness - surface } else { normal_roughness };
    let metallic = if exact.lit { base_metallic.w - exact.metallic } else { 0.0 };
    [surface.abs().max_element().max(metallic.abs()), base.abs().max_element()].map(|error| error * 255.0)
}

#[test]
fn nothing_but_the_formats_is_lost() {
    let Some(gpu) = Gpu::open() else { return };
    let mut failed = Vec::new();
    // Turned: the code of a normal's component of 0 is a tie, 127.5, which either side may round its own way.
    for scene in scenes::all().into_iter().map(scenes::turned) {
        for camera in &scene.cameras {
            let frame = InSteps::new(&gpu, &scene, camera);
            let from_gbuffer = frame.errors(&frame.given_gbuffer(&frame.settings()));
            let from_scene = frame.errors(&frame.given_scene(&frame.settings()));
            let part = from_scene.len() as f64 / from_gbuffer.len() as f64;
            let text = format!(
                "{}, {}: steps, given its G-buffer: {}; given the scene, {part:.3} of the pixels: {}",
                scene.name,
                camera.name,
                describe(&from_gbuffer),
                describe(&from_scene)
            );
            println!("{text}");
            let bound = if frame.rendered.settings.light_target { TWO_STEPS } else { ONE_STEP };
            let covered = frame.exact.pixels.iter().zip(&frame.gbuffer).filter(|(p, _)| p.covered && !p.edge);
            let codes: Vec<_> = covered.map(|(p, stored)| code_errors(&p.attributes, stored)).collect();
            let [unorm, srgb] = [0, 1].map(|k| {
                let mut sorted: Vec<f64> = codes.iter().map(|errors| errors[k]).collect();
                sorted.sort_by(|a, b| b.total_cmp(a));
                quantile(&sorted, PROMISED_PART)
            });
            println!("{}, {}: codes, UNORM {unorm:.3}, sRGB {srgb:.3}", scene.name, camera.name);
            let kept = unorm <= UNORM_CODE_ERROR
                && srgb <= SRGB_CODE_ERROR
                && are_whole(&from_gbuffer)
                && are_whole(&from_scene)
                && quantile(&from_gbuffer, PROMISED_PART) <= ONE_STEP
                && quantile(&from_scene, PROMISED_PART) <= bound
                && part >= LEAST_PART_OF_LIKE_CODES;
            if !kept {
                failed.push(text);
            }
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn every_fault_is_caught() {
    let Some(gpu) = Gpu::open() else { return };
    for (scene, bound) in [(scenes::grazing(), ONE_STEP), (scenes::surfaces(), TWO_STEPS)] {
        let scene = scenes::turned(scene);
        let frame = InSteps::new(&gpu, &scene, &scene.cameras[0]);
        let right = frame.settings();
        let faults = [
            ("exposure off by 0.1 EV", Settings { exposure_ev: 0.1, ..right.clone() }),
            ("another curve", Settings { tonemap: Tonemap::Aces, ..right.clone() }),
        ];
        for (name, fault) in faults {
            let errors = frame.errors(&frame.given_scene(&fault));
            let caught = quantile(&errors, PROMISED_PART) > bound;
            assert!(caught, "{}, {name}: not caught, {}", scene.name, describe(&errors));
            let errors = frame.errors(&frame.given_gbuffer(&fault));
            let caught = quantile(&errors, PROMISED_PART) > ONE_STEP;
            assert!(caught, "{}, {name}, G-buffer: not caught, {}", scene.name, describe(&errors));
        }
        let other = Settings { gbuffer: Some(GBuffer::exact()), ..right.clone() };
        let errors = frame.errors(&frame.given_scene(&other));
        let caught = quantile(&errors, PROMISED_PART) > bound || !are_whole(&errors);
        assert!(caught, "{}: layout not caught, {}", scene.name, describe(&errors));
        let mut brighter = scene.clone();
        brighter.lights.iter_mut().for_each(|l| l.color *= 1.05);
        let errors = frame.errors(&render(&brighter, frame.camera, &right));
        assert!(
            quantile(&errors, PROMISED_PART) > bound,
            "{}: pi not caught, {}",
            scene.name,
            describe(&errors)
        );
    }
    gpu.finish();
}

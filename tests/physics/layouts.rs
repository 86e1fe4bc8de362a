//! Every layout and every choice of encoding: geometry writes what the reference's counterpart writes, and lighting makes of it
//! what the reference makes of it.

use ontile::plan::{DepthStore, Format, GBuffer, Gamma, Layout, LightFormat, LightPlace, Normals, Target};
use ontile::reference::{Attributes, Frame, Settings, Stored, View, decode, quantise, render, shade_gbuffer};
use ontile::scene::{Camera, Scene};

use crate::SIZE;
use crate::error::PROMISED_PART;
use crate::gpu::{Ask, Gpu};
use crate::scenes;

/// All layouts as they are, and those that store reflectance also without the device's sRGB decoder.
pub fn layouts() -> Vec<(String, Ask)> {
    let plain = Layout::ALL.iter().map(|&layout| (layout.to_string(), Ask { layout, ..Ask::EXACT }));
    let power = [Layout::Specular160, Layout::Rasa128]
        .map(|layout| (format!("{layout}, 2.0"), Ask { layout, gamma: Some(Gamma::Power20), ..Ask::EXACT }));
    plain.chain(power).collect()
}

/// Each choice alone, on a layout that leaves it.
pub fn choices() -> Vec<(String, Ask)> {
    let mut asks = Vec::new();
    let base = Ask { layout: Layout::Ontile128, ..Ask::EXACT };
    asks.extend(Normals::ALL.iter().map(|&n| (n.to_string(), Ask { normals: Some(n), ..base })));
    asks.extend(Gamma::ALL.iter().map(|&g| (g.to_string(), Ask { gamma: Some(g), ..base })));
    asks.extend(LightFormat::ALL.iter().map(|&l| (l.to_string(), Ask { light_target: Some(l), ..base })));
    asks.extend(DepthStore::ALL.iter().map(|&d| (d.to_string(), Ask { depth: Some(d), ..base })));
    let specular = Ask { layout: Layout::Specular160, normals: Some(Normals::Oct16), ..Ask::EXACT };
    let floats = Ask { light_target: Some(LightFormat::Rgba32f), ..base };
    asks.extend(Gamma::ALL.iter().map(|&g| (format!("{g}, rgba32f"), Ask { gamma: Some(g), ..floats })));
    asks.push(("specular160, oct16, d32".into(), Ask { depth: Some(DepthStore::D32), ..specular }));
    asks
}

/// How far a surface that was stored is from the exact one: position as a share of the distance, normal, colours, roughness,
/// light.
pub fn lost(kept: &Attributes, exact: &Attributes, view: &View) -> [f64; 5] {
    let distance = (exact.position_world - view.position_world).length();
    [
        (kept.position_world - exact.position_world).length() / distance,
        (kept.normal_world - exact.normal_world).length(),
        (kept.diffuse() - exact.diffuse()).abs().max((kept.f0() - exact.f0()).abs()).max_element(),
        (kept.roughness - exact.roughness).abs(),
        (kept.prelit - exact.prelit).abs().max_element(),
    ]
}

/// The quantile of the promised part, of each kind.
pub fn typical(mut all: Vec<[f64; 5]>) -> [f64; 5] {
    let beyond = ((1.0 - PROMISED_PART) * all.len() as f64) as usize;
    std::array::from_fn(|k| {
        all.sort_by(|a, b| b[k].total_cmp(&a[k]));
        all[beyond][k]
    })
}

/// What GPU and reference may differ by besides, where a format rounds the same value: `crate::gbuffer`'s bounds of what geometry
/// interpolates, which may also tip a code over.
pub const INTERPOLATED: [f64; 5] = [2e-5, 4e-4, 1e-5, 1e-5, 1e-4];

/// Either neighbour is right where a value lies between two codes (Vulkan's conversions), so that the error may be twice half a
/// step.
const EITHER_NEIGHBOUR: f64 = 2.0;

/// Of values below 1.
pub const STEP_OF_HALF: f64 = 1.0 / 2048.0;

/// What was written, if it is not what the formats can hold.
fn written_wrong(
    gbuffer: &GBuffer,
    exact: &Frame,
    stored: &[Stored],
    view: &View,
    factor: f64,
) -> Option<String> {
    let (mut found, mut allowed) = (Vec::new(), Vec::new());
    let pixels = exact.pixels.iter().zip(stored).enumerate();
    for (index, (pixel, stored)) in pixels.filter(|(_, (p, _))| p.covered && !p.edge) {
        let place = [index as u32 % SIZE[0], index as u32 / SIZE[0]];
        let kept = decode(gbuffer, stored, view, place, factor);
        if kept.lit != pixel.attributes.lit {
            return Some(format!("lit is {} at {place:?}", kept.lit));
        }
        if !kept.lit {
            continue;
        }
        found.push(lost(&kept, &pixel.attributes, view));
        let by_reference = quantise(gbuffer, &pixel.attributes, view, place, factor);
        allowed.push(lost(&by_reference, &pixel.attributes, view));
    }
    let found = typical(found);
    let allowed =
        allowed.iter().fold([0.0; 5], |most: [f64; 5], one| std::array::from_fn(|k| most[k].max(one[k])));
    let kinds = ["position", "normal", "colour", "roughness", "light"];
    // Half floats may be cut off instead of rounded, and what is cut off may be much more than what rounding to nearest adds.
    let is_half = |t: &Target| matches!(t.format, Format::Rgba16Float | Format::Rg16Float);
    let cut = if gbuffer.surface.iter().any(is_half) { STEP_OF_HALF } else { 0.0 };
    let wrong = (0..5).find(|&k| {
        let most = EITHER_NEIGHBOUR * allowed[k] + INTERPOLATED[k] + cut;
        found[k].is_nan() || found[k] > most
    });
    wrong.map(|k| format!("{}: off by {:.2e}, the formats by {:.2e}", kinds[k], found[k], allowed[k]))
}

/// What remains between the pictures that either side makes of the same G-buffer: f32 arithmetic, a step or two of the light
/// target, and of positions that are stored.
fn tolerance(gbuffer: &GBuffer, has_light_target: bool) -> f64 {
    /// As `tests/physics/exact.rs` finds it, doubled.
    const ARITHMETIC: f64 = 5e-4;
    /// Vulkan leaves a device an approximation when it decodes sRGB. lavapipe's is off by up to 0.2 % of white, and by 0.6 % of
    /// a dielectric's reflectance, which highlights are proportional to.
    const SRGB_DECODER: f64 = 2e-3;
    const SRGB_DECODER_IN_THE_DARK: f64 = 6e-3;
    let has_srgb = gbuffer.surface.iter().any(|t| t.format == Format::Rgba8Srgb);
    let format = match gbuffer.light {
        LightPlace::Added { sum, .. } if has_light_target => sum.target.format.name(),
        _ => "",
    };
    // Of linear light relative to 1 and more. Written and added, each may take either neighbour; diffuse light and other light
    // apart have both steps.
    ARITHMETIC
        + match (has_srgb, gbuffer.surface.iter().any(|t| t.name == "specular")) {
            (true, true) => SRGB_DECODER_IN_THE_DARK,
            (true, false) => SRGB_DECODER,
            (false, _) => 0.0,
        }
        + match format {
            "rgb10a2" => 3.0 * 2.0 / 1023.0,
            "b10g11r11" => 2.0 / 32.0,
            "rgba16f" => 2.0 / 1024.0,
            _ => 0.0,
        }
}

fn read_wrong(
    gbuffer: &GBuffer,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    (exact, stored, found): (&Frame, &[Stored], &[ontile::glam::DVec3]),
) -> Option<String> {
    let settings = Settings { gbuffer: Some(gbuffer.clone()), ..settings.clone() };
    let expected = shade_gbuffer(scene, camera, &settings, stored);
    let pixels = expected.pixels.iter().zip(found).zip(&exact.pixels);
    let mut errors: Vec<f64> = pixels
        .filter(|(_, seen)| seen.covered && !seen.edge)
        .map(|((p, found), _)| {
            ((found - p.display).abs() / p.display.abs().max(ontile::glam::DVec3::ONE)).max_element()
        })
        .collect();
    errors.sort_by(|a, b| b.total_cmp(a));
    let error = errors[((1.0 - PROMISED_PART) * errors.len() as f64) as usize];
    let most = tolerance(gbuffer, settings.light_target);
    (error.is_nan() || error > most).then(|| format!("picture off by {error:.2e}, at most {most:.2e}"))
}

fn check(gpu: &Gpu, asks: &[(String, Ask)], scenes: &[Scene]) {
    let mut failed = Vec::new();
    for scene in scenes {
        let camera = &scene.cameras[0];
        let mut exact = None;
        for (name, ask) in asks {
            let gbuffer = GBuffer::new(&ask.options()).expect("it makes sense");
            let Some((rendered, stored)) = gpu.try_with_gbuffer(scene, camera, *ask) else {
                assert_eq!(gbuffer.light, LightPlace::Nowhere, "{name}, {}: not planned", scene.name);
                continue;
            };
            let exact = exact.get_or_insert_with(|| render(scene, camera, &rendered.settings));
            let (factor, view) = (rendered.settings.light_scale, View::new(camera, SIZE));
            let wrong = [
                written_wrong(&gbuffer, exact, &stored, &view, factor),
                read_wrong(&gbuffer, scene, camera, &rendered.settings, (exact, &stored, &rendered.light())),
            ];
            failed.extend(wrong.into_iter().flatten().map(|w| format!("{name}, {}: {w}", scene.name)));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn every_layout_is_written_and_read_as_the_reference_does() {
    let Some(gpu) = Gpu::open() else { return };
    check(&gpu, &layouts(), &[scenes::surfaces(), scenes::materials(), scenes::lights()]);
    gpu.finish();
}

#[test]
fn every_choice_is_written_and_read_as_the_reference_does() {
    let Some(gpu) = Gpu::open() else { return };
    check(&gpu, &choices(), &[scenes::surfaces()]);
    gpu.finish();
}

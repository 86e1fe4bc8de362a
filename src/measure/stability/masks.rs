//! Alpha masks under several samples a pixel.

use glam::Vec3;

use super::bench::light_of;
use super::parts::{add, camera, floor, plain, square, sun};
use super::{Bound, Case, Figure, Findings, Lab, Sweep, Worst, display_steps, exact};
use crate::Result;
use crate::measure::plot::{Axis, Plot};
use crate::plan::{Edges, Options};
use crate::reference::samples::{grid, supersampled};
use crate::reference::{Pixel, Settings};
use crate::scene::{AlphaMode, Image, Material, Sampler, Scene, Texture, TextureRef};

pub const MASKS: Sweep = Sweep {
    name: "masks",
    title: "Edges that an alpha mask cuts, at four samples a pixel",
    varies: "holes across a pane: 2 to 128, so that a hole is from a quarter of the picture to less than a pixel wide",
    about: "A triangle covers all samples of a pixel through which its mask's edge goes, so that coverage alone (the centroid trick) takes \
            it for the inside of a surface and lights it once. Where a mask was, `coverage` compares samples too.",
    needs_device: true,
    find: masks,
};

/// A pane with round holes before a floor of another colour.
fn pierced(holes: f32) -> Scene {
    const TEXELS: u32 = 64;
    let mut scene = Scene { lights: vec![sun(2.0, Vec3::new(-0.3, -0.8, -0.6))], ..Scene::default() };
    scene.cameras.push(camera(Vec3::new(0.2, 0.9, 2.6), Vec3::ZERO));
    add(&mut scene, square(), plain(Vec3::new(0.1, 0.4, 0.9), 0.0, 0.9), floor(4.0));
    let alpha = |i: u32| {
        let from_middle = |at: u32| (at as f32 + 0.5) / TEXELS as f32 - 0.5;
        let radius = from_middle(i % TEXELS).hypot(from_middle(i / TEXELS));
        (255.0 * (0.5 + 8.0 * (radius - 0.3)).clamp(0.0, 1.0)) as u8
    };
    let rgba8 = (0..TEXELS * TEXELS).flat_map(|i| [255, 255, 255, alpha(i)]).collect();
    scene.images.push(Image { name: "holes".into(), width: TEXELS, height: TEXELS, texels: rgba8 });
    scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    let uv_from_texcoord = [Vec3::X * holes, Vec3::Y * holes];
    let mask = Material {
        base_color_texture: Some(TextureRef { texture: 0, texcoord: 0, uv_from_texcoord }),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..plain(Vec3::new(0.9, 0.5, 0.1), 0.0, 0.9)
    };
    add(&mut scene, square(), mask, glam::Mat4::from_translation(Vec3::Y * 0.2));
    scene
}

fn masks(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let size = lab.pick([64, 48], [160, 120]);
    let holes = lab.pick(&[2.0, 16.0][..], &[2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0][..]);
    let ways = [Edges::Compare, Edges::Coverage];
    let mut worst = ways.map(|_| Worst::new());
    let names = ["1 sample", "4 samples, all", "4 samples, compare", "4 samples, coverage"];
    let mut curves = names.map(|_| Vec::new());
    for &count in holes {
        let scene = pierced(count);
        let settings = Settings { size, tonemap: exact(size).tonemap, ..Settings::default() };
        let truth =
            supersampled(&scene, &scene.cameras[0], &settings, &grid(8), |pixel: &Pixel| pixel.display);
        let light = |samples, edges| {
            light_of(&bench.picture(&scene, Options { samples, edges, ..exact(size) }, 0.0)?)
        };
        let all = light(4, Edges::All)?;
        let pictures = [light(1, Edges::Auto)?, all.clone(), light(4, ways[0])?, light(4, ways[1])?];
        for (curve, picture) in curves.iter_mut().zip(&pictures) {
            let squares: f64 = picture.iter().zip(&truth).map(|(a, b)| (*a - *b).length_squared()).sum();
            curve.push([f64::from(count), (squares / truth.len() as f64).sqrt()]);
        }
        for (worst, picture) in worst.iter_mut().zip(&pictures[2..]) {
            for (i, (once, each)) in picture.iter().zip(&all).enumerate() {
                let error = (0..3).map(|c| display_steps(once[c], each[c])).fold(0.0, f64::max);
                worst.add(error, || {
                    format!("{count} holes, pixel ({}, {})", i as u32 % size[0], i as u32 / size[0])
                });
            }
        }
    }
    let cases = ways.iter().zip(worst).map(|(way, worst)| Case {
        method: format!("{way}, against every sample lit"),
        worst: worst.error,
        at: worst.at.unwrap_or_default(),
        bound: Bound {
            name: "EDGES_COMPLETE",
            unit: "steps of 8-bit sRGB",
            good: 0.0,
            most: 0.5,
            reason: "pixels that are lit once have samples of one surface, or nobody would see that they have not",
        },
        answer: None,
        remedy: "--edges all lights every sample".into(),
    });
    let plot = Plot {
        title: "Edges of a mask, against 64 samples in f64".into(),
        x_label: "holes across the pane".into(),
        y_label: "root of the mean squared error, 1 is white".into(),
        axes: [Axis::Logarithmic, Axis::Linear],
        curves: names.iter().map(|name| (*name).to_owned()).zip(curves).collect(),
        levels: Vec::new(),
    };
    let caption =
        "What is left of the error: a mask is looked up for each sample, its texture filtered for the pixel.";
    Ok(Findings { cases: cases.collect(), figures: vec![Figure::plot("error", caption, plot)] })
}

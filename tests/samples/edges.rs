//! Which pixels are lit by sample, and that the others lose nothing by it.

use super::common::render::{Gpu, difference, on_device};
use super::common::scenes;
use ontile::gpu::{RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Edges, Layout, LightWay, Needs, Options, Pipeline, Plan, Show, Strategy};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [96, 54];

/// Depth that differs by sample puts each of them in a place of its own within the pixel, where light differs a little; the centre
/// stands for them. As a share of the light of a white surface.
const MAX_WITHIN_PIXEL: f32 = 0.05;

/// A frame, and how many samples were marked as edges.
fn frame(gpu: &Gpu<'_>, scene: &Scene, options: Options) -> (Picture, u64) {
    let config = RendererConfig { count_fragments: true, ..RendererConfig::default() };
    let plan = gpu.plan(scene, options);
    let edges = plan.pipelines.iter().position(|(_, pipeline)| *pipeline == Pipeline::Edges);
    let mut offscreen = gpu.offscreen(scene, plan, config);
    offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 }).unwrap();
    let counts = offscreen.renderer().draw_counts(0).unwrap();
    let marked =
        counts.iter().filter(|count| Some(count.pipeline) == edges).map(|count| count.fragments).sum();
    (offscreen.picture(), marked)
}

/// The largest difference of a channel, and how many pixels differ.
fn differences(a: &Picture, b: &Picture) -> (f32, usize) {
    let channels = |picture: &Picture| match &picture.pixels {
        Pixels::Rgba32F(channels) => channels.clone(),
        Pixels::Rgba8(_) => unreachable!("outputs are floats"),
    };
    let (a, b) = (channels(a), channels(b));
    let of_pixel = |(a, b): (&[f32], &[f32])| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let all: Vec<_> = a.chunks(4).zip(b.chunks(4)).map(of_pixel).collect();
    (all.iter().copied().fold(0.0, f32::max), all.iter().filter(|d| **d > 0.0).count())
}

fn base() -> Options {
    Options { size: SIZE, samples: 4, output: ontile::plan::OutputFormat::Rgba32Float, ..Options::default() }
}

#[test]
fn pixels_that_are_lit_once_are_as_if_each_sample_had_been() {
    on_device(None, |gpu| {
        let scene = scenes::every_feature();
        for (index, &layout) in Layout::ALL.iter().enumerate() {
            let lights = LightWay::ALL[index % 4];
            let all = Options { layout, lights, edges: Edges::All, ..base() };
            if Plan::new(Needs::of(&scene), all.clone(), &gpu.device().limits()).is_err() {
                continue;
            }
            let compare = Options { edges: Edges::Compare, ..all.clone() };
            let is_by_sample = gpu.plan(&scene, all.clone()).gbuffer.reads_depth_attachment();
            let (expected, none) = frame(gpu, &scene, all);
            let (picture, marked) = frame(gpu, &scene, compare);
            let (most, pixels) = differences(&expected, &picture);
            let share = marked as f32 / (SIZE[0] * SIZE[1] * 4) as f32;
            println!(
                "{layout}, {lights}: {:.1} % edges; {pixels} pixels differ, by {most} at most",
                share * 100.0
            );
            assert_eq!(none, 0);
            let most_allowed = if is_by_sample { MAX_WITHIN_PIXEL } else { 0.0 };
            assert!(most <= most_allowed, "{layout}, {lights}: {pixels} pixels differ, by {most} at most");
        }
    });
}

#[test]
fn edges_are_a_part_of_the_picture_and_not_none_of_it() {
    on_device(None, |gpu| {
        for scene in [scenes::every_feature(), scenes::before_sky()] {
            let marked = [Edges::Compare, Edges::Coverage]
                .map(|edges| frame(gpu, &scene, Options { edges, ..base() }).1);
            let pixels = u64::from(SIZE[0] * SIZE[1] * 4);
            println!("{}: {marked:?} of {pixels} samples", scene.name);
            assert!(
                marked.iter().all(|m| (pixels / 200..pixels / 2).contains(m)),
                "{}: {marked:?}",
                scene.name
            );
        }
    });
}

/// `--show edges` is white where the frame lights sample by sample, as often as its marks are counted, and black elsewhere; strategies
/// agree.
#[test]
fn edges_that_are_shown_are_those_that_are_lit_by_sample() {
    on_device(None, |gpu| {
        for (scene, edges) in [
            (scenes::every_feature(), Edges::Compare),
            (scenes::every_feature(), Edges::Coverage),
            (scenes::before_sky(), Edges::Compare),
        ] {
            for layout in [Layout::Metallic128, Layout::Packed128, Layout::Thibieroz128] {
                let options = Options { edges, layout, ..base() };
                // Shadow volumes and words in order would have all lit.
                let marked =
                    frame(gpu, &scene, Options { lights: LightWay::Fullscreen, ..options.clone() }).1;
                let shown = |strategy| {
                    let options = Options { show: Show::Edges, strategy, ..options.clone() };
                    gpu.picture(&scene, gpu.plan(&scene, options), 0.0)
                };
                let [merged, separate] = Strategy::EVERYWHERE.map(shown);
                assert_eq!(difference(&merged, &separate), None, "{}, {edges}, {layout}", scene.name);
                let Pixels::Rgba32F(channels) = &merged.pixels else { unreachable!("outputs are floats") };
                let white = channels.chunks(4).filter(|c| *c == [1.0; 4]).count() as u64;
                let black = channels.chunks(4).filter(|c| *c == [0.0, 0.0, 0.0, 1.0]).count() as u64;
                assert_eq!(white + black, u64::from(SIZE[0] * SIZE[1]), "{}, {edges}, {layout}", scene.name);
                assert_eq!(white * 4, marked, "{}, {edges}, {layout}", scene.name);
            }
        }
    });
}

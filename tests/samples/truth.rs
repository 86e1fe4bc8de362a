//! Against f64 with 64 samples a pixel.

use super::common::render::on_device;
use super::common::scenes;
use ontile::glam::DVec3;
use ontile::picture::Pixels;
use ontile::plan::{Edges, Layout, Options, OutputFormat};
use ontile::reference::{Settings, supersampled};

const SIZE: [u32; 2] = [96, 54];

/// Samples along each side of a pixel.
const SIDE: u32 = 8;

/// What 4 samples leave at most of the error of 1. Were all error that of outlines, and of samples without order, it would be a half;
/// what changes within a triangle, textures above all, is looked at once a pixel either way.
const MOST_LEFT: f64 = 0.8;

#[test]
fn four_samples_are_nearer_to_the_truth_than_one() {
    on_device(None, |gpu| {
        for scene in [scenes::every_feature(), scenes::lights_only()] {
            let camera = &scene.cameras[0];
            let settings = Settings { size: SIZE, ..Settings::default() };
            let truth = supersampled(&scene, camera, &settings, SIDE, |pixel| pixel.display);
            let base = Options {
                size: SIZE,
                layout: Layout::Exact,
                output: OutputFormat::Rgba32Float,
                ..Options::default()
            };
            let error = |samples, edges| {
                let plan = gpu.plan(&scene, Options { samples, edges, ..base.clone() });
                let picture = gpu.picture(&scene, plan, 0.0);
                let Pixels::Rgba32F(channels) = picture.pixels else {
                    unreachable!("the output is of floats")
                };
                let pixels = channels.chunks(4).map(|c| DVec3::new(c[0].into(), c[1].into(), c[2].into()));
                let squares = pixels.zip(&truth).map(|(a, b)| (a - *b).length_squared());
                (squares.sum::<f64>() / truth.len() as f64).sqrt()
            };
            let one = error(1, Edges::Auto);
            let [all, compare, coverage] =
                [Edges::All, Edges::Compare, Edges::Coverage].map(|edges| error(4, edges));
            println!(
                "{}: RMS error 1x {one:.5}, 4x all {all:.5}, compare {compare:.5}, coverage {coverage:.5}",
                scene.name
            );
            assert!(all < one * MOST_LEFT, "{}: {one} becomes {all}", scene.name);
            assert_eq!(compare, all, "{}", scene.name);
            assert!(coverage < one * MOST_LEFT, "{}: {one} becomes {coverage}", scene.name);
        }
    });
}

//! Against f64 with many samples a pixel.

use super::common::render::{Gpu, on_device};
use super::common::scenes;
use super::{error, light_of};
use ontile::glam::DVec3;
use ontile::plan::{Edges, Options};
use ontile::reference::samples::{STANDARD_4, grid, supersampled};
use ontile::reference::{Pixel, Settings};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [96, 54];

/// What 4 samples leave at most of the error of 1, against 64. Were all error that of outlines, and of samples without order, it would
/// be a half; what changes within a triangle, textures above all, is looked at once a pixel either way.
const MOST_LEFT: f64 = 0.8;

/// The same against samples in the device's own places: outlines are then the same, and shading within a pixel is left.
const MOST_LEFT_IN_PLACE: f64 = 0.5;

fn light(gpu: &Gpu<'_>, scene: &Scene, samples: u32, edges: Edges) -> Vec<DVec3> {
    light_of(gpu, scene, Options { size: SIZE, samples, edges, ..Options::default() })
}

#[test]
fn four_samples_are_nearer_to_the_truth_than_one() {
    on_device(None, |gpu| {
        // Shadows of maps have edges of their own, which samples of a pixel share.
        for (scene, in_place) in [(scenes::lights_only(), true), (scenes::every_feature(), false)] {
            let scene = scene.without_shadows();
            let settings = Settings { size: SIZE, ..Settings::default() };
            let shown = |pixel: &Pixel| pixel.display;
            let truth = supersampled(&scene, &scene.cameras[0], &settings, &grid(8), shown);
            let four = supersampled(&scene, &scene.cameras[0], &settings, &STANDARD_4, shown);
            let one = light(gpu, &scene, 1, Edges::Auto);
            let ways = [Edges::All, Edges::Compare, Edges::Coverage];
            let [all, compare, coverage] = ways.map(|edges| light(gpu, &scene, 4, edges));
            let errors = [&one, &all, &compare, &coverage].map(|light| error(light, &truth));
            let errors_in_place = [&one, &all].map(|light| error(light, &four));
            println!(
                "{}: RMS error to 64 samples: 1x {:.5}, 4x all {:.5}, compare {:.5}, coverage {:.5}; of 4x to the same places {:.5}",
                scene.name, errors[0], errors[1], errors[2], errors[3], errors_in_place[1]
            );
            assert!(errors[1..].iter().all(|e| *e < errors[0] * MOST_LEFT), "{}: {errors:?}", scene.name);
            assert_eq!(compare, all, "{}", scene.name);
            if in_place {
                assert!(
                    errors_in_place[1] < errors_in_place[0] * MOST_LEFT_IN_PLACE,
                    "{}: {errors_in_place:?}",
                    scene.name
                );
            }
        }
    });
}

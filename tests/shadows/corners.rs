//! No shadow where surfaces meet, or faces of the cube around a light, and nothing stands in the way.

use crate::common::render::on_device;
use crate::common::scenes::shadow_scenes::one_light_each;
use crate::rays::{expected, light_of};
use crate::{SIZE, options};
use ontile::plan::{Layout, Options, ShadowFilter};

/// A filter's samples weigh a 25th at least, grid3's a 9th; what is darker by less is rounding.
const DARKER: f64 = 0.93;
/// Filters soften edges of shadows over so many pixels at most.
const REACH_PX: u32 = 5;
/// Of the 57600 pixels: where a post meets the floor, whose shadow begins within a pixel.
const MOST_WRONG: usize = 4;

#[test]
fn corners_and_seams_are_as_light_as_without_shadows() {
    on_device(None, |gpu| {
        let mut failures = Vec::new();
        for scene in one_light_each() {
            let frame = expected(&scene);
            let [width, height] = SIZE;
            let far_from_shadow = |x: u32, y: u32| {
                let range = |n: u32, size: u32| n.saturating_sub(REACH_PX)..(n + REACH_PX + 1).min(size);
                range(y, height).all(|y| range(x, width).all(|x| frame.pixel(x, y).shadowed == 0))
            };
            let bare = scene.clone().without_shadows();
            for layout in [Layout::Exact, Layout::Metallic128] {
                for &filter in ShadowFilter::ALL {
                    let picture = |scene| {
                        let options = Options { layout, ..options(filter) };
                        light_of(&gpu.picture(scene, gpu.plan(scene, options), 0.0))
                    };
                    let (shadowed, lit) = (picture(&scene), picture(&bare));
                    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
                    let wrong: Vec<_> = pixels
                        .filter(|&(x, y)| {
                            let i = (y * width + x) as usize;
                            shadowed[i].y < DARKER * lit[i].y && far_from_shadow(x, y)
                        })
                        .collect();
                    println!("{}, {layout}, {filter}: {} {wrong:?}", scene.name, wrong.len());
                    if wrong.len() > MOST_WRONG {
                        failures.push(format!("{}, {layout}, {filter}: {}", scene.name, wrong.len()));
                    }
                }
            }
        }
        assert!(failures.is_empty(), "pixels in shadow that no ray is: {failures:?}");
    });
}

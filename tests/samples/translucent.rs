//! Blended surfaces of several samples a pixel, in every way.

use super::common::ignored;
use super::common::render::{Gpu, difference, on_device};
use super::common::scenes::decal_scenes::decals_behind_glass;
use super::common::scenes::glass_scenes::{crossing, glass, glass_alone, glass_in_fog};
use super::common::scenes::media_scenes::{water, water_in_fog};
use super::{error, light_of};
use ontile::glam::DVec3;
use ontile::plan::{Layout, Needs, Options, Plan, Refraction, Strategy, Translucency};
use ontile::reference::samples::{STANDARD_4, supersampled};
use ontile::reference::{Behind, Frame, Pixel, Settings, render};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [96, 54];

/// What 4 samples leave of the error of 1 where the way is exact but for its order: outlines are the reference's, what is shaded once
/// a pixel is not.
const MOST_LEFT: f64 = 0.5;

/// Of a pixel without edges all samples hold the same light, which is rounded once more as they are resolved.
const MOST_WITHIN_PIXEL: f64 = 1e-5;

/// Where it is summed in half floats, of each addend by half a unit in the last place.
const MOST_WITHIN_HALF_FLOATS: f64 = 1.0 / 2048.0;

/// The ways that the device has.
fn ways(gpu: &Gpu<'_>) -> Vec<Translucency> {
    let ordered = gpu.device().limits().ordered_attachment_access;
    if !ordered {
        ignored("oit: no rasterization-order attachment access");
    }
    Translucency::ALL.iter().copied().filter(|way| ordered || *way != Translucency::Oit).collect()
}

#[test]
fn arrangements_do_not_change_the_pixels_of_any_translucency() {
    on_device(None, |gpu| {
        let layouts = [Layout::Metallic128, Layout::Packed128, Layout::Metallic256, Layout::Rasa128];
        for (index, scene) in [glass_in_fog(), decals_behind_glass(), glass_alone()].into_iter().enumerate() {
            let scene = scene.without_shadows();
            for (turn, translucency) in ways(gpu).into_iter().enumerate() {
                let layout = layouts[(index + turn) % layouts.len()];
                let options = Options { size: SIZE, samples: 4, layout, translucency, ..Options::default() };
                let expected = gpu.picture(&scene, gpu.plan(&scene, options.clone()), 0.0);
                for other in [
                    Options { strategy: Strategy::Separate, ..options.clone() },
                    Options { recycle: false, ..options.clone() },
                ] {
                    let picture = gpu.picture(&scene, gpu.plan(&scene, other.clone()), 0.0);
                    let name = format!("{}, {other:?}", scene.name);
                    assert_eq!(difference(&expected, &picture), None, "{name}");
                }
            }
        }
    });
}

/// [`glass_alone`] of what is flat.
fn panes() -> Scene {
    let mut scene = Scene { name: "panes".into(), ..glass_alone() };
    let of = |scene: &Scene, mesh: usize| scene.materials[scene.meshes[mesh].material].name.clone();
    let flat: Vec<_> = (0..scene.meshes.len()).map(|mesh| of(&scene, mesh) != "ball").collect();
    scene.instances.retain(|instance| flat[instance.mesh]);
    scene
}

fn light(gpu: &Gpu<'_>, scene: &Scene, samples: u32, translucency: Translucency) -> Vec<DVec3> {
    light_of(gpu, scene, Options { size: SIZE, samples, translucency, ..Options::default() })
}

/// The most that pixels without edges differ by, relative to the brighter.
fn most_within(frame: &Frame, a: &[DVec3], b: &[DVec3]) -> f64 {
    const LEAST: f64 = 1e-3;
    let inner = (0..a.len()).filter(|&i| !frame.pixels[i].edge);
    let apart = |i: usize| ((a[i] - b[i]).abs() / a[i].max(b[i]).max(DVec3::splat(LEAST))).max_element();
    inner.map(apart).fold(0.0, f64::max)
}

#[test]
fn samples_are_sorted_each_by_itself() {
    on_device(None, |gpu| {
        for scene in [panes(), glass(), crossing()] {
            let settings = Settings { size: SIZE, ..Settings::default() };
            let shown = |pixel: &Pixel| pixel.display;
            let truth = supersampled(&scene, &scene.cameras[0], &settings, &STANDARD_4, shown);
            let centre = render(&scene, &scene.cameras[0], &settings);
            for translucency in ways(gpu) {
                let [one, four] = [1, 4].map(|samples| light(gpu, &scene, samples, translucency));
                let errors = [&one, &four].map(|light| error(light, &truth));
                let within = most_within(&centre, &one, &four);
                println!(
                    "{}, {translucency}: RMS error to exact sorting of the same samples: 1x {:.5}, 4x {:.5}; {within:.1e} \
                     between them where no edge is",
                    scene.name, errors[0], errors[1]
                );
                let exact = match translucency {
                    Translucency::Peeled | Translucency::Oit => true,
                    Translucency::Sorted => scene.name != "crossing",
                    Translucency::Weighted => false,
                };
                let name = format!("{}, {translucency}: {errors:?}", scene.name);
                assert!(!exact || errors[1] < errors[0] * MOST_LEFT, "{name}");
                assert!(errors[1] < errors[0], "{name}");
                // Layers are shaded sample by sample, and curved surfaces at the centre of each of their triangles in a pixel.
                let same = translucency != Translucency::Oit && scene.name == "panes";
                let most = match translucency {
                    Translucency::Weighted => MOST_WITHIN_HALF_FLOATS,
                    _ => MOST_WITHIN_PIXEL,
                };
                assert!(!same || within <= most, "{name}: {within}");
            }
        }
    });
}

/// Each sample sees what is behind it in the picture of the samples at its place.
#[test]
fn light_is_bent_for_each_sample() {
    on_device(None, |gpu| {
        for scene in [water(), water_in_fog()] {
            let left = [(Refraction::None, Behind::Straight), (Refraction::Pass, Behind::Picture)].map(
                |(refraction, behind)| {
                    let settings = Settings { size: SIZE, behind, ..Settings::default() };
                    let shown = |pixel: &Pixel| pixel.display;
                    let truth = supersampled(&scene, &scene.cameras[0], &settings, &STANDARD_4, shown);
                    let errors = [1, 4].map(|samples| {
                        let options = Options { size: SIZE, samples, refraction, ..Options::default() };
                        error(&light_of(gpu, &scene, options), &truth)
                    });
                    println!(
                        "{}, {refraction}: RMS error to the same samples, 1x and 4x: {errors:.5?}",
                        scene.name
                    );
                    errors[1] / errors[0]
                },
            );
            assert!(scene.name != "water" || left[1] < MOST_LEFT, "{}: {left:?}", scene.name);
            // What else differs, as fog that is laid over pixels, differs without too.
            assert!(left[1] < left[0] * 1.05, "{}: {left:?}", scene.name);
        }
    });
}

#[test]
fn layers_of_samples_are_refused_where_words_have_none() {
    let limits = ontile::plan::Limits {
        ordered_attachment_access: true,
        word_sample_counts: 1,
        ..ontile::plan::Limits::default()
    };
    let options = Options { samples: 4, translucency: Translucency::Oit, ..Options::default() };
    let error = Plan::new(Needs::of(&glass()), options, &limits).unwrap_err().to_string();
    assert!(error.contains("cannot have 4 samples") && error.contains("--translucency weighted"), "{error}");
}

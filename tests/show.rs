//! What is shown in place of the picture: in one pass that loads nothing, where there is something to show; else why not.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes;
use ontile::picture::Pixels;
use ontile::plan::{BloomWay, Edges, Layout, LightWay, Limits, Needs, Options, Path, Plan, Show, Strategy};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [160, 90];

fn limits() -> Limits {
    Limits { max_color_attachments: 8, max_input_attachments: 8, ..Limits::default() }
}

fn planned(scene: &Scene, options: Options) -> ontile::Result<Plan> {
    Plan::new(Needs::of(scene), options, &limits())
}

/// Of every scene, layout and number of samples: whatever is shown costs no byte that the picture does not, and nothing is drawn for it
/// that the picture does without but one stage.
#[test]
fn all_is_shown_in_one_pass_that_stores_the_output_alone() {
    let mut seen = std::collections::BTreeMap::<Show, usize>::new();
    for scene in scenes::built() {
        for (&layout, samples) in Layout::ALL.iter().flat_map(|layout| [(layout, 1), (layout, 4)]) {
            for &show in &Show::ALL[1..] {
                let options = Options { layout, samples, show, ..Options::default() };
                let Ok(plan) = planned(&scene, options) else { continue };
                let what = format!("{}, {layout}, {samples}, {show}", scene.name);
                let totals = plan.report(&scene).totals;
                assert_eq!((plan.passes.len(), totals.loaded_bytes_per_pixel.value), (1, 0.0), "{what}");
                assert_eq!(totals.stored_bytes_per_pixel.value, 4.0, "{what}");
                let stages: Vec<_> = plan.passes[0].subpasses.iter().map(|s| s.name).collect();
                let known = ["depth", "geometry", "decals", "show"];
                assert!(stages.iter().all(|stage| known.contains(stage)), "{what}: {stages:?}");
                assert!(plan.shadow_map.is_none() && plan.volume_lights.is_empty(), "{what}");
                assert!(plan.clusters.is_none() || show == Show::Lights, "{what}");
                *seen.entry(show).or_default() += 1;
            }
        }
    }
    assert!(Show::ALL[1..].iter().all(|show| seen.contains_key(show)), "{seen:?}");
}

#[test]
fn what_is_not_there_is_refused() {
    let of = |scene: &Scene, show, change: fn(&mut Options)| {
        let mut options = Options { show, ..Options::default() };
        change(&mut options);
        planned(scene, options).map(|_| String::new()).unwrap_or_else(|error| error.to_string())
    };
    let (lit, all) = (scenes::lights_only(), scenes::every_feature());
    let none: fn(&mut Options) = |_| ();
    let cases = [
        (of(&all, Show::Normal, none), ""),
        (of(&all, Show::Normal, |o| o.path = Path::Auto), ""),
        (of(&all, Show::Normal, |o| o.path = Path::Forward), "the path forward has not; use --path deferred"),
        (of(&all, Show::Light, |o| o.path = Path::ForwardMultipass), "use --path deferred"),
        (of(&scenes::wholly_unlit(), Show::Depth, none), "no surface that is lit and opaque"),
        (of(&scenes::no_lights(), Show::Lights, none), "no lights to count"),
        (of(&scenes::no_lights(), Show::Depth, none), ""),
        (of(&all, Show::Edges, none), "with 1 sample a pixel there are no edges to mark; use --samples 4"),
        (of(&all, Show::Edges, |o| (o.samples, o.edges) = (4, Edges::All)), "where every sample is lit"),
        (
            of(&all, Show::Metallic, |o| o.layout = Layout::Specular160),
            "does not store metallic; use --show diffuse",
        ),
        (
            of(&all, Show::Roughness, |o| o.layout = Layout::Thibieroz96),
            "thibieroz96 does not store roughness",
        ),
        (of(&lit, Show::Light, none), "no light exists before lighting"),
        (of(&lit, Show::Light, |o| o.fold = false), ""),
        (of(&all, Show::Light, none), ""),
        (of(&all, Show::Occlusion, none), "holds no occlusion"),
        (of(&all, Show::Normal, |o| o.bloom = BloomWay::Previous), "leave --bloom and --edge-filter out"),
        (of(&all, Show::Normal, |o| o.edge_filter = true), "leave --bloom and --edge-filter out"),
        (of(&lit, Show::Lights, |o| o.lights = LightWay::Stencil), ""),
    ];
    for (error, expected) in cases {
        assert!(error.contains(expected) && error.is_empty() == expected.is_empty(), "{expected}: {error}");
    }
}

type Variant = fn(Options) -> Options;

/// Arrangements that must not change what is shown.
const VARIANTS: [Variant; 6] = [
    |o| Options { strategy: Strategy::Separate, ..o },
    |o| Options { recycle: false, ..o },
    |o| Options { output_is_input_attachment: false, ..o },
    |o| Options { keep_gbuffer: o.samples == 1, ..o },
    |o| Options { depth_prepass: true, ..o },
    |o| Options { strategy: Strategy::LocalRead, ..o },
];

fn check_variants(gpu: &Gpu<'_>, scene: &Scene, options: &Options) {
    let expected = gpu.picture(scene, gpu.plan(scene, options.clone()), 0.0);
    for change in VARIANTS {
        let options = change(options.clone());
        let local_read = gpu.device().limits().merging.local_read.is_ok();
        if options.strategy == Strategy::LocalRead && !local_read {
            continue;
        }
        let picture = gpu.picture(scene, gpu.plan(scene, options.clone()), 0.0);
        assert_eq!(difference(&expected, &picture), None, "{}: {options:?}", scene.name);
    }
}

/// Quantities in strips of all layouts, and each by itself of one; the strips are the quantities' own pixels.
#[test]
fn arrangements_do_not_change_the_pixels_of_what_is_shown() {
    on_device(None, |gpu| {
        // With a depth pre-pass the scenes have more than ten draws of few triangles.
        gpu.excuse("many-small-indexed-drawcalls");
        let limits = gpu.device().limits();
        let all = [scenes::every_feature(), scenes::decal_scenes::decals()];
        for (scene, &layout) in all.iter().flat_map(|s| Layout::ALL.iter().map(move |l| (s, l))) {
            let base = Options { size: SIZE, layout, ..Options::default() };
            let show = |show| Options { show, ..base.clone() };
            if Plan::new(Needs::of(scene), show(Show::Channels), &limits).is_err() {
                assert_eq!(layout, Layout::Ontile64, "{}", scene.name);
                continue;
            }
            check_variants(gpu, scene, &show(Show::Channels));
            let strips = gpu.plan(scene, show(Show::Channels)).strips();
            let whole = gpu.picture(scene, gpu.plan(scene, show(Show::Channels)), 0.0);
            for (strip, &channel) in strips.iter().enumerate() {
                if layout == Layout::Packed128 {
                    check_variants(gpu, scene, &show(channel));
                }
                let one = gpu.picture(scene, gpu.plan(scene, show(channel)), 0.0);
                let (Pixels::Rgba8(whole), Pixels::Rgba8(one)) = (&whole.pixels, &one.pixels) else {
                    panic!()
                };
                for (index, (whole, one)) in whole.chunks(4).zip(one.chunks(4)).enumerate() {
                    let x = index as u32 % SIZE[0];
                    if ((x as f32 + 0.5) * strips.len() as f32 / SIZE[0] as f32) as usize == strip {
                        assert_eq!(whole, one, "{}, {layout}, {channel} at {x}", scene.name);
                    }
                }
            }
        }
    });
}

/// The same with several samples, and of lights and edges.
#[test]
fn arrangements_do_not_change_the_pixels_of_what_is_shown_of_samples() {
    on_device(None, |gpu| {
        let scene = scenes::every_feature();
        for layout in [Layout::Metallic128, Layout::Packed128, Layout::Dissertation192] {
            for show in [Show::Channels, Show::Lights, Show::Edges] {
                let base = Options { size: SIZE, layout, show, samples: 4, ..Options::default() };
                check_variants(gpu, &scene, &Options { lights: LightWay::Clusters, ..base.clone() });
                check_variants(gpu, &scene, &Options { edges: Edges::Coverage, ..base });
            }
        }
    });
}

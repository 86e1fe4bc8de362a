//! What engines leave the tile for: decals, bloom, several samples a pixel.

use super::child::{Case, Fault};
use super::common::turnip;
use super::{ALL_STAGES, commitments, frames, local_read, metallic, on_tile, shadow_tiles};
use ontile::measure::tiler::{TilerTrace, Verdict};
use ontile::plan::{
    BloomWay, DecalWay, Edges, Layout, LightWay, Path as LightPath, Refraction, Show, Translucency,
};

/// Each way of ordering decals, in layouts of every kind.
#[test]
fn decals_stay_on_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    let painted = |decals, scene, layout| Case { decals, ..Case::new(scene, layout) };
    let mut cases = vec![(3, painted(DecalWay::Fixed, "color_decals", Layout::Metallic128))];
    for decals in [DecalWay::RasterOrder, DecalWay::Barrier] {
        cases.extend([
            (4, painted(decals, "decals", Layout::Metallic128)),
            (4, painted(decals, "decals", Layout::Rasa128)),
            (4, painted(decals, "decals", Layout::Ontile128)),
            (3, painted(decals, "decals", Layout::Metallic256)),
            (3, painted(decals, "decals", Layout::Packed128)),
            (3, painted(decals, "color_decals", Layout::Ontile64)),
        ]);
        let lights = LightWay::Stencil;
        cases.push((4, Case { lights, ..painted(decals, "decals", Layout::Ontile128) }));
        cases.push((4, local_read(painted(decals, "decals", Layout::Ontile128))));
        cases.push((3, local_read(painted(decals, "decals", Layout::Packed128))));
    }
    cases.push((3, local_read(painted(DecalWay::Fixed, "color_decals", Layout::Metallic128))));
    for (subpasses, case) in &cases {
        frames(&turnip, case, |gpu, frame| on_tile(gpu, case, *subpasses, frame));
    }
}

/// What poses meshes runs before the pass, and leaves it as it is.
#[test]
fn what_bends_stays_on_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    for (subpasses, scene, layout) in [
        (2, "bending", Layout::Metallic128),
        (2, "bending", Layout::Ontile128),
        (4, "bending_mapped", Layout::Metallic128),
    ] {
        let case = Case::new(scene, layout);
        frames(&turnip, &case, |gpu, frame| on_tile(gpu, &case, subpasses, frame));
    }
}

/// Barriers within a subpass need its dependency on itself, and that by region.
#[test]
fn a_wrong_dependency_of_decals_is_found_out() {
    let Some(turnip) = turnip::find() else { return };
    let spoilt = |fault| {
        let decals = DecalWay::Barrier;
        Case { fault: Some(fault), decals, ..Case::new("decals", Layout::Metallic128) }
    };
    for fault in [Fault::ItselfNotByRegion, Fault::ItselfDropped] {
        frames(&turnip, &spoilt(fault), |_, frame| frame.expect_objection("validation: "));
    }
}

/// What bloom needs is stored once more or not at all, and its own passes load nothing either.
#[test]
fn bloom_leaves_the_pass_whole() {
    let Some(turnip) = turnip::find() else { return };
    for (bloom, stored) in [(BloomWay::Previous, 4), (BloomWay::Store, 8)] {
        frames(&turnip, &Case { bloom, ..metallic(ALL_STAGES) }, |gpu, frame| {
            let report = &frame.told.report;
            let TilerTrace { mut passes, warnings } = frame.trace.after(shadow_tiles(report));
            let after = passes.split_off(1);
            assert_eq!(TilerTrace { passes, warnings }.verdict(stored), Verdict::OnTile, "{bloom} on {gpu}");
            assert_eq!(after.len(), report["post_passes"].as_array().unwrap().len());
            for pass in &after {
                let bytes = [pass.load_bytes_per_pixel, pass.store_bytes_per_pixel];
                assert_eq!((bytes, pass.attachments), ([0, 4], 1), "{bloom} on {gpu}: {pass:?}");
            }
            let mut objections = commitments(report);
            objections.retain(|o| !o.starts_with("\"bloom_light\""));
            objections.extend(frame.told.messages.iter().cloned());
            assert_eq!(objections, Vec::<String>::new(), "{bloom} on {gpu}");
            assert_eq!(report["totals"]["stored_bytes_per_pixel"]["value"], f64::from(stored));
        });
    }
}

/// What media sample is stored once, no tile is loaded, and all else stays on the tile.
#[test]
fn refraction_stores_what_it_samples() {
    let Some(turnip) = turnip::find() else { return };
    let bent = |scene, layout| Case { refraction: Refraction::Pass, ..Case::new(scene, layout) };
    let cases = [
        bent("water", Layout::Metallic128),
        bent("water_in_fog", Layout::Ontile128),
        bent("water_and_more", Layout::Packed128),
        Case { path: LightPath::Forward, ..bent("water", Layout::Metallic128) },
        local_read(bent("water_and_more", Layout::Metallic128)),
        Case { samples: 4, edges: Edges::All, ..bent("water", Layout::Metallic128) },
    ];
    for case in &cases {
        frames(&turnip, case, |gpu, frame| {
            let report = &frame.told.report;
            let TilerTrace { passes, warnings } = frame.trace.after(shadow_tiles(report));
            // Light in half floats and depth, of each sample; the picture.
            let sampled = 12 * case.samples;
            for (pass, stored) in passes.iter().zip([sampled, 4]) {
                let alone = TilerTrace { passes: vec![pass.clone()], warnings: warnings.clone() };
                assert_eq!(alone.verdict(stored), Verdict::OnTile, "{case:?} on {gpu}");
            }
            assert_eq!(passes.len(), 2, "{case:?} on {gpu}");
            let totals = &report["totals"];
            assert_eq!(totals["stored_bytes_per_pixel"]["value"], f64::from(sampled + 4));
            assert_eq!(totals["loaded_bytes_per_pixel"]["value"], f64::from(sampled));
            let mut objections = commitments(report);
            objections.retain(|o| {
                !["\"light\" ", "\"depth\" ", "\"depth_test\" "].iter().any(|n| o.starts_with(n))
            });
            objections.extend(frame.told.messages.iter().cloned());
            assert_eq!(objections, Vec::<String>::new(), "{case:?} on {gpu}");
        });
    }
}

#[test]
fn several_samples_stay_on_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    let of = |layout, samples, edges| Case { samples, edges, ..Case::new(ALL_STAGES, layout) };
    let of_glass = |translucency, layout| Case { samples: 4, translucency, ..Case::new("glass", layout) };
    let cases = [
        (3, of(Layout::Metallic128, 4, Edges::All)),
        (3, of(Layout::Metallic128, 4, Edges::Compare)),
        (3, of(Layout::Ontile128, 4, Edges::Compare)),
        (3, of(Layout::Ontile128, 4, Edges::Coverage)),
        (3, Case { lights: LightWay::Stencil, ..of(Layout::Ontile96, 4, Edges::Compare) }),
        (2, of(Layout::Packed128, 4, Edges::Compare)),
        (3, of(Layout::Metallic128, 2, Edges::Auto)),
        (1, Case { path: LightPath::Forward, ..of(Layout::Metallic128, 4, Edges::Auto) }),
        (5, of_glass(Translucency::Oit, Layout::Metallic128)),
        (5, of_glass(Translucency::Oit, Layout::Packed128)),
        (5, of_glass(Translucency::Weighted, Layout::Metallic128)),
        (19, of_glass(Translucency::Peeled, Layout::Metallic128)),
    ];
    for (subpasses, case) in &cases {
        frames(&turnip, case, |gpu, frame| on_tile(gpu, case, *subpasses, frame));
    }
}

/// Decals, four samples a pixel and blended surfaces at once; and, in place of these, shadow volumes.
#[test]
fn all_together_stays_on_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    let of = |scene, layout| Case { samples: 4, ..Case::new(scene, layout) };
    let oit = Translucency::Oit;
    let cases = [
        (5, of("stop", Layout::Metallic128)),
        (5, of("stop", Layout::Ontile128)),
        (5, Case { decals: DecalWay::Barrier, ..of("stop", Layout::Packed128) }),
        (5, Case { lights: LightWay::Clusters, edges: Edges::Coverage, ..of("stop", Layout::Metallic128) }),
        (6, Case { translucency: oit, ..of("stop", Layout::Metallic128) }),
        (5, local_read(of("stop", Layout::Metallic128))),
        (4, Case { shadow_volumes: true, ..of("decals", Layout::Metallic128) }),
    ];
    for (subpasses, case) in &cases {
        frames(&turnip, case, |gpu, frame| on_tile(gpu, case, *subpasses, frame));
    }
}

/// What is drawn over the picture costs no byte.
#[test]
fn an_overlay_stays_on_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    let over = |case: Case| Case { overlay: true, ..case };
    let cases = [
        (3, over(metallic(ALL_STAGES))),
        (3, over(Case { samples: 4, ..metallic(ALL_STAGES) })),
        (1, over(Case { path: LightPath::Forward, ..metallic(ALL_STAGES) })),
        (3, over(local_read(metallic(ALL_STAGES)))),
    ];
    for (subpasses, case) in &cases {
        frames(&turnip, case, |gpu, frame| on_tile(gpu, case, *subpasses, frame));
    }
}

/// What is shown in place of the picture is read on the tile, and the pass still loads nothing and stores the output alone.
#[test]
fn what_is_shown_stays_on_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    let of = |show, layout| Case { show, ..Case::new(ALL_STAGES, layout) };
    let sampled = |show, edges| Case { samples: 4, edges, ..of(show, Layout::Metallic128) };
    let cases = [
        (2, of(Show::BaseColor, Layout::Metallic128)),
        (2, of(Show::Normal, Layout::Packed128)),
        (2, of(Show::Depth, Layout::Ontile128)),
        (2, of(Show::Channels, Layout::Metallic128)),
        (2, of(Show::Channels, Layout::Packed128)),
        (2, of(Show::Channels, Layout::Rasa128)),
        (2, Case { lights: LightWay::Clusters, ..of(Show::Lights, Layout::Ontile128) }),
        (2, sampled(Show::Edges, Edges::Compare)),
        (2, sampled(Show::Edges, Edges::Coverage)),
        (2, sampled(Show::Channels, Edges::Auto)),
        (3, Case { show: Show::Channels, ..Case::new("decals", Layout::Metallic128) }),
        (2, local_read(of(Show::Channels, Layout::Metallic128))),
    ];
    for (subpasses, case) in &cases {
        frames(&turnip, case, |gpu, frame| on_tile(gpu, case, *subpasses, frame));
    }
}

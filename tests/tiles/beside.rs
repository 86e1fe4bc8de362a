//! Two frames to one image: each in its part of it, or the one sampled by the other.

use ash::vk;
use ontile::gpu::{
    Commands, Headless, Image, ImageDesc, OutputImage, PipelineCache, Renderer, RendererConfig, View,
    expected_advice,
};
use ontile::plan::{Adreno, Figure, Layout, Options, OutputUse, Path as LightPath, Plan};
use ontile::scene::Scene;
use std::path::Path;

use super::child::{Beside, Case, SIZE, Told};
use super::common::turnip;
use super::{ALL_STAGES, OUTPUT_BYTES_PER_PIXEL, commitments, frames, local_read, metallic};

/// Draws two frames of equal plans and writes a [`Told`] of the second.
pub fn run(host: Headless, scene: &Scene, planned: impl Fn(Options) -> Plan, beside: Beside, told: &Path) {
    let device = host.device();
    let cache = PipelineCache::new(device, &[]).unwrap();
    let (first, second) = match beside {
        Beside::Split(_) => (Options::default(), Options { output_is_kept: true, ..Options::default() }),
        Beside::Difference => (
            Options { output_use: OutputUse::Sample, ..Options::default() },
            Options { difference: Some(8.0), ..Options::default() },
        ),
    };
    let (first, second) = (planned(first), planned(second));
    let mut expected: Vec<_> = [&first, &second].into_iter().flat_map(expected_advice).collect();
    // The second clears what the first has stored, outside of its part alone.
    expected.push("redundant");
    let bins = Adreno::ALL.map(|adreno| (adreno.id, None)).into();
    let mut report = second.report(scene);
    let renderer = |plan: Plan| {
        let mut renderer = Renderer::new(device, scene, plan, RendererConfig::default(), &cache).unwrap();
        Commands::run(device, "upload", |recorder| {
            renderer.record_upload(recorder);
            Ok(())
        })
        .unwrap();
        renderer.finish_upload();
        renderer
    };
    let (mut a, mut b) = (renderer(first), renderer(second));
    let image = |usage: vk::ImageUsageFlags, format| {
        Image::new(device, &ImageDesc::new("output", format, SIZE, usage)).unwrap()
    };
    let output = |image: &Image| [OutputImage { image: image.raw(), view: image.view() }];
    let own = image(a.output_usage() | b.output_usage(), a.output_format());
    let shown = image(b.output_usage(), b.output_format());
    let [width, height] = SIZE;
    let (parts, targets) = match beside {
        Beside::Split(at) => (
            [[0, 0, at, height], [at, 0, width, height]],
            [&a, &b].map(|renderer| renderer.create_target(SIZE, &output(&own)).unwrap()),
        ),
        Beside::Difference => (
            [[0, 0, width, height]; 2],
            [
                a.create_target(SIZE, &output(&own)).unwrap(),
                b.create_target_beside(SIZE, &output(&shown), own.view()).unwrap(),
            ],
        ),
    };
    let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
    Commands::run(device, "frame", |recorder| {
        for ((renderer, target), part) in [&mut a, &mut b].into_iter().zip(&targets).zip(parts) {
            renderer.record_part(recorder, 0, target, 0, &view, part);
        }
        Ok(())
    })
    .unwrap();
    for (index, attachment) in report.attachments.iter_mut().enumerate() {
        let Some(image) = targets[1].attachment(index) else { continue };
        let committed = image.committed_bytes();
        attachment.lazily_allocated = Some(committed.is_some());
        attachment.committed_bytes = committed.map(|bytes| Figure::driver(bytes as f64));
    }
    let report = serde_json::to_value(report).unwrap();
    drop((targets, a, b, own, shown, cache));
    let mut messages = host.finish();
    messages.retain(|message| !expected.iter().any(|part| message.contains(part)));
    let told_now = Told { report, bins, queries: false, messages };
    std::fs::write(told, serde_json::to_vec(&told_now).unwrap()).unwrap();
}

/// Each frame is one tiled pass that loads nothing and stores the picture, its part of it alone where there are two parts.
#[test]
fn what_is_compared_stays_on_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    let all = || {
        [
            metallic(ALL_STAGES),
            Case { samples: 4, ..metallic(ALL_STAGES) },
            Case::new(ALL_STAGES, Layout::Packed128),
            Case { path: LightPath::Forward, ..metallic(ALL_STAGES) },
            local_read(metallic(ALL_STAGES)),
        ]
    };
    // In the middle, and near both edges, not on the edge of a tile.
    let splits = [960, 37, 1901].map(Beside::Split);
    let of = |beside| all().into_iter().map(move |case| Case { beside: Some(beside), ..case });
    let cases = of(splits[0])
        .chain(splits[1..].iter().map(|&beside| Case { beside: Some(beside), ..metallic(ALL_STAGES) }));
    for case in cases.chain(of(Beside::Difference)) {
        frames(&turnip, &case, |gpu, frame| {
            assert_eq!(frame.told.messages, [""; 0], "{case:?} on {gpu}");
            assert_eq!(commitments(&frame.told.report), [""; 0], "{case:?} on {gpu}");
            let [first, second] = &frame.trace.passes[..] else {
                panic!("{case:?} on {gpu}: {:?}", frame.trace)
            };
            for pass in [first, second] {
                let bytes = [pass.load_bytes_per_pixel, pass.store_bytes_per_pixel];
                assert_eq!(bytes, [0, OUTPUT_BYTES_PER_PIXEL], "{case:?} on {gpu}: {pass:?}");
                assert!(
                    pass.tiled && pass.loads.is_empty() && pass.stores.len() == 1,
                    "{case:?} on {gpu}: {pass:?}"
                );
            }
            let totals = &frame.told.report["totals"];
            assert_eq!(totals["loaded_bytes_per_pixel"]["value"], 0.0);
            assert_eq!(totals["stored_bytes_per_pixel"]["value"], f64::from(OUTPUT_BYTES_PER_PIXEL));
        });
    }
}

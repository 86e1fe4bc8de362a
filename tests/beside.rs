//! Two renderers and one picture: each draws its part of it, or one of them how far its picture is from the other's.

mod common;

use ash::vk;
use common::render::{Gpu, difference, on_device};
use common::scenes;
use ontile::gpu::{
    Commands, Image, ImageDesc, OutputImage, Readback, Renderer, RendererConfig, Target, View,
};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{
    BloomWay, Layout, LightWay, Limits, Needs, Options, OutputUse, Path, Plan, State, Strategy, Translucency,
};
use ontile::scene::{PreRotation, Scene};

const SIZE: [u32; 2] = [160, 90];

fn renderer(gpu: &Gpu<'_>, scene: &Scene, options: &Options) -> Renderer {
    let plan = gpu.plan(scene, options.clone());
    let config = RendererConfig::default();
    let mut renderer = Renderer::new(gpu.device(), scene, plan, config, gpu.cache()).unwrap();
    Commands::run(gpu.device(), "upload", |recorder| {
        renderer.record_upload(recorder);
        Ok(())
    })
    .unwrap();
    renderer.finish_upload();
    renderer
}

fn image(gpu: &Gpu<'_>, of: &[&Renderer]) -> Image {
    image_of_size(gpu, of, SIZE)
}

fn image_of_size(gpu: &Gpu<'_>, of: &[&Renderer], size: [u32; 2]) -> Image {
    let usage = of.iter().fold(vk::ImageUsageFlags::empty(), |all, renderer| all | renderer.output_usage());
    Image::new(gpu.device(), &ImageDesc::new("output", of[0].output_format(), size, usage)).unwrap()
}

fn output(image: &Image) -> [OutputImage; 1] {
    [OutputImage { image: image.raw(), view: image.view() }]
}

type Drawn<'a> = (&'a mut Renderer, &'a Target, [u32; 4]);

/// The picture in an image when all of them have drawn their parts, twice.
fn read(gpu: &Gpu<'_>, scene: &Scene, image: &Image, mut drawn: Vec<Drawn<'_>>) -> Picture {
    let [width, height] = image.size();
    let readback = Readback::new(gpu.device(), image.format(), [width, height]).unwrap();
    let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
    for _ in 0..2 {
        Commands::run(gpu.device(), "frame", |recorder| {
            for (renderer, target, part) in &mut drawn {
                renderer.record_part(recorder, 0, target, 0, &view, *part);
            }
            readback.record(recorder, image, 0, layout, layout)
        })
        .unwrap();
    }
    let pixels = Pixels::Rgba8(readback.texels().to_vec());
    Picture { width, height, pixels }
}

/// The left of one picture beside the right of another.
fn joined(a: &Picture, b: &Picture, at: u32) -> Picture {
    let (Pixels::Rgba8(left), Pixels::Rgba8(right)) = (&a.pixels, &b.pixels) else { panic!("bytes") };
    let pixel =
        |(i, (a, b)): (usize, (&[u8], &[u8]))| if i as u32 % SIZE[0] < at { a.to_vec() } else { b.to_vec() };
    let pixels = left.chunks(4).zip(right.chunks(4)).enumerate().flat_map(pixel).collect();
    Picture { pixels: Pixels::Rgba8(pixels), ..a.clone() }
}

/// Options that differ in all that may touch the output, and in what is cleared within a pass.
fn sides() -> Vec<Options> {
    let base = || Options { size: SIZE, ..Options::default() };
    vec![
        base(),
        Options { layout: Layout::Packed128, samples: 4, ..base() },
        Options { strategy: Strategy::Separate, lights: LightWay::Stencil, ..base() },
        Options { path: Path::Forward, ..base() },
        Options { strategy: Strategy::Separate, path: Path::Forward, samples: 4, ..base() },
        Options { translucency: Translucency::Weighted, output_is_input_attachment: false, ..base() },
        Options { strategy: Strategy::LocalRead, layout: Layout::Ontile128, ..base() },
    ]
}

#[test]
fn halves_are_the_halves_of_both_pictures() {
    on_device(None, |gpu| {
        // The second clears what the first has stored, outside of its part alone.
        gpu.excuse("redundant");
        let local_read = gpu.device().limits().merging.local_read.is_ok();
        let sides: Vec<_> =
            sides().into_iter().filter(|o| local_read || o.strategy != Strategy::LocalRead).collect();
        for scene in [scenes::every_feature(), scenes::glass_scenes::glass_in_fog()] {
            let whole: Vec<_> =
                sides.iter().map(|o| gpu.picture(&scene, gpu.plan(&scene, o.clone()), 0.0)).collect();
            for (i, at) in (0..sides.len()).zip([80, 1, 159, 37, 64, 100, 80]) {
                let j = (i + 1) % sides.len();
                let kept = Options { output_is_kept: true, ..sides[j].clone() };
                let (mut a, mut b) = (renderer(gpu, &scene, &sides[i]), renderer(gpu, &scene, &kept));
                let image = image(gpu, &[&a, &b]);
                let [left, right] =
                    [&a, &b].map(|renderer| renderer.create_target(SIZE, &output(&image)).unwrap());
                let [width, height] = SIZE;
                let parts =
                    vec![(&mut a, &left, [0, 0, at, height]), (&mut b, &right, [at, 0, width, height])];
                let found = read(gpu, &scene, &image, parts);
                let expected = joined(&whole[i], &whole[j], at);
                assert_eq!(difference(&found, &expected), None, "{}, {i} beside {j} at {at}", scene.name);
            }
        }
    });
}

/// On a turned screen parts are those of the upright picture, and the difference is of pictures that lie alike.
#[test]
fn so_it_is_on_turned_screens() {
    on_device(None, |gpu| {
        gpu.excuse("redundant");
        let scene = scenes::every_feature();
        let [width, height] = SIZE;
        let whole = [0, 0, width, height];
        let sides = sides();
        for (pre_rotation, at) in PreRotation::ALL[1..].iter().zip([37, 80, 159]) {
            let size = pre_rotation.size(SIZE);
            let turned = |options: &Options| Options { size, ..options.clone() };
            let target = |renderer: &Renderer, image: &Image, other: Option<&Image>| {
                let mut target = match other {
                    None => renderer.create_target(size, &output(image)).unwrap(),
                    Some(other) => renderer.create_target_beside(size, &output(image), other.view()).unwrap(),
                };
                target.pre_rotate(*pre_rotation);
                target
            };
            let alone = |options: &Options| {
                let mut renderer = renderer(gpu, &scene, &turned(options));
                let image = image_of_size(gpu, &[&renderer], size);
                let target = target(&renderer, &image, None);
                read(gpu, &scene, &image, vec![(&mut renderer, &target, whole)]).upright(*pre_rotation)
            };
            for (a, b) in [(&sides[0], &sides[1]), (&sides[1], &sides[3]), (&sides[2], &sides[0])] {
                let [whole_a, whole_b] = [a, b].map(alone);
                let kept = Options { output_is_kept: true, ..turned(b) };
                let (mut left, mut right) = (renderer(gpu, &scene, &turned(a)), renderer(gpu, &scene, &kept));
                let image = image_of_size(gpu, &[&left, &right], size);
                let targets = [&left, &right].map(|renderer| target(renderer, &image, None));
                let parts = vec![
                    (&mut left, &targets[0], [0, 0, at, height]),
                    (&mut right, &targets[1], [at, 0, width, height]),
                ];
                let found = read(gpu, &scene, &image, parts).upright(*pre_rotation);
                let expected = joined(&whole_a, &whole_b, at);
                assert_eq!(difference(&found, &expected), None, "{pre_rotation:?}: {a:?} beside {b:?}");
            }
            for a in [&sides[1], &sides[0]] {
                let [whole_a, whole_b] = [a, &sides[1]].map(alone);
                let sampled = Options { output_use: OutputUse::Sample, ..turned(a) };
                let compared = Options { difference: Some(4.0), ..turned(&sides[1]) };
                let (mut a, mut b) = (renderer(gpu, &scene, &sampled), renderer(gpu, &scene, &compared));
                let (own, image) = (image_of_size(gpu, &[&a], size), image_of_size(gpu, &[&b], size));
                let (first, second) = (target(&a, &own, None), target(&b, &image, Some(&own)));
                let drawn = vec![(&mut a, &first, whole), (&mut b, &second, whole)];
                let found = read(gpu, &scene, &image, drawn).upright(*pre_rotation);
                let bytes = [&found, &whole_a, &whole_b].map(|picture| match &picture.pixels {
                    Pixels::Rgba8(bytes) => bytes.clone(),
                    Pixels::Rgba32F(_) => panic!("bytes"),
                });
                for (at, found) in bytes[0].iter().enumerate().filter(|(at, _)| at % 4 < 3) {
                    let apart = f32::from(bytes[1][at].abs_diff(bytes[2][at]));
                    let off = (f32::from(*found) - (4.0 * apart).min(255.0)).abs();
                    assert!(
                        off <= if apart == 0.0 { 0.0 } else { 4.5 },
                        "{pre_rotation:?}: {found}, {apart}"
                    );
                }
            }
        }
    });
}

#[test]
fn a_difference_is_that_of_both_pictures_and_none_of_equal_ones() {
    const GAIN: f32 = 4.0;
    on_device(None, |gpu| {
        let local_read = gpu.device().limits().merging.local_read.is_ok();
        let scene = scenes::every_feature();
        for (i, b) in sides().into_iter().enumerate() {
            if b.strategy == Strategy::LocalRead && !local_read {
                continue;
            }
            for a in [b.clone(), Options { layout: Layout::Thibieroz96, size: SIZE, ..Options::default() }] {
                let is_same = a == b;
                let [whole_a, whole_b] =
                    [&a, &b].map(|o| gpu.picture(&scene, gpu.plan(&scene, o.clone()), 0.0));
                let mut a = renderer(gpu, &scene, &Options { output_use: OutputUse::Sample, ..a });
                let mut b = renderer(gpu, &scene, &Options { difference: Some(GAIN), ..b.clone() });
                assert!(b.create_target(SIZE, &[]).is_err(), "without another picture");
                let (own, image) = (image(gpu, &[&a]), image(gpu, &[&b]));
                let first = a.create_target(SIZE, &output(&own)).unwrap();
                let second = b.create_target_beside(SIZE, &output(&image), own.view()).unwrap();
                let part = [0, 0, SIZE[0], SIZE[1]];
                let found = read(gpu, &scene, &image, vec![(&mut a, &first, part), (&mut b, &second, part)]);
                let bytes = |picture: &Picture| match &picture.pixels {
                    Pixels::Rgba8(bytes) => bytes.clone(),
                    Pixels::Rgba32F(_) => panic!("bytes"),
                };
                let (found, whole_a, whole_b) = (bytes(&found), bytes(&whole_a), bytes(&whole_b));
                let mut most = 0;
                for (at, found) in found.iter().enumerate().filter(|(at, _)| at % 4 < 3) {
                    let apart = f32::from(whole_a[at].abs_diff(whole_b[at]));
                    most = most.max(whole_a[at].abs_diff(whole_b[at]));
                    let expected = (apart * GAIN).min(255.0);
                    // Both pictures are decoded by the device's approximation, each off by up to half a step of bytes.
                    let off = (f32::from(*found) - expected).abs();
                    assert!(off <= if apart == 0.0 { 0.0 } else { GAIN + 0.5 }, "{i}: {found}, {expected}");
                }
                assert_eq!(most == 0, is_same, "{i}");
            }
        }
    });
}

/// One pass each: what is kept is not loaded, and the other picture is sampled once.
#[test]
fn plans_say_what_both_cost() {
    let scene = scenes::every_feature();
    let limits = Limits { max_color_attachments: 8, max_input_attachments: 8, ..Limits::default() };
    let plan = |options: Options| Plan::new(Needs::of(&scene), options, &limits);
    for samples in [1, 4] {
        let base = || Options { samples, ..Options::default() };
        for (options, sampled) in [
            (Options { output_is_kept: true, ..base() }, 0.0),
            (Options { difference: Some(8.0), ..base() }, 4.0),
        ] {
            let plan = plan(options).unwrap();
            let first = |kept: bool| if kept { State::CopySource } else { State::Undefined };
            let output =
                plan.passes[0].attachments.iter().find(|used| plan.attachments[used.attachment].is_output);
            assert_eq!(output.unwrap().initial, first(plan.options.output_is_kept));
            let totals = plan.report(&scene).totals;
            assert_eq!((totals.passes, totals.loaded_bytes_per_pixel.value), (1, 0.0));
            assert_eq!(totals.stored_bytes_per_pixel.value, 4.0);
            assert_eq!(totals.post_loaded_bytes_per_pixel.value, sampled);
            assert_eq!(sampled > 0.0, plan.notes.iter().any(|note| note.starts_with("difference: ")));
        }
    }
    for (options, told) in [
        (Options { difference: Some(0.0), ..Options::default() }, "amplified by 0; give a number above 0"),
        (Options { difference: Some(f32::NAN), ..Options::default() }, "amplified by NaN"),
        (
            Options { difference: Some(1.0), edge_filter: true, ..Options::default() },
            "leave --bloom and --edge-filter out",
        ),
        (
            Options { output_is_kept: true, bloom: BloomWay::Previous, ..Options::default() },
            "a part of it is another frame's",
        ),
    ] {
        let error = plan(options).unwrap_err().to_string();
        assert!(error.contains(told), "{told}: {error}");
    }
}

//! Passes after the frame's own: they do what the f64 reference does to the same light, however the frame is made, and leave its
//! own pass as it is.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes;
use ontile::glam::DVec3;
use ontile::gpu::{RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{
    BloomWay, DepthStore, Layout, Limits, Needs, Options, OutputFormat, OutputUse, Path, Plan, Strategy,
    Tonemap, bloom_levels,
};
use ontile::reference::bloom::{Light, mixed, scattered};
use ontile::reference::edge_filter::{Place, edge_filter};
use ontile::reference::tonemap::tonemap;
use ontile::reference::tonemap_inverse::tonemap_inverse;
use ontile::scene::Scene;

const SIZE: [u32; 2] = [160, 90];

/// Neither way leaves anything out.
const WAYS: [BloomWay; 2] = [BloomWay::Store, BloomWay::Previous];

fn bloom(way: BloomWay) -> Options {
    Options { size: SIZE, bloom: way, bloom_strength: 0.3, bloom_radius: 0.2, ..Options::default() }
}

/// The last of so many frames.
fn frames(gpu: &Gpu<'_>, scene: &Scene, plan: Plan, exposures_ev: &[f32]) -> Picture {
    let mut offscreen = gpu.offscreen(scene, plan, RendererConfig::default());
    for &exposure_ev in exposures_ev {
        offscreen.render(&View { camera: &scene.cameras[0], exposure_ev }).unwrap();
    }
    offscreen.picture()
}

fn light(picture: &Picture) -> Light {
    let Pixels::Rgba32F(channels) = &picture.pixels else { panic!("a float picture was asked for") };
    let pixel = |p: &[f32]| DVec3::new(p[0].into(), p[1].into(), p[2].into());
    let size = [picture.width as usize, picture.height as usize];
    Light { size, pixels: channels.chunks_exact(4).map(pixel).collect() }
}

fn map(light: &Light, pixel: impl Fn(DVec3) -> DVec3) -> Light {
    Light { size: light.size, pixels: light.pixels.iter().map(|&p| pixel(p)).collect() }
}

/// B10G11R11 keeps 6 bits of red and green after the first and 5 of blue, to the nearest: half of 1 / 32 at most. Light of the
/// widest of four sizes is rounded seven times, that of the others less often; errors of either sign are averaged by each filter, so
/// that twice the worst of one rounding holds.
const ROUNDED: f64 = 2.0 * 0.5 / 32.0;

/// What interpolation in 8 bits may make of dark pixels beside bright ones.
const FLOOR: f64 = 2e-4;

/// `scattered` is the part of the expected light that was stored in few bits.
#[track_caller]
fn expect_near(what: &str, picture: &Light, expected: &Light, scattered: impl Fn(usize) -> DVec3) {
    let mut worst = 0.0_f64;
    let pairs = picture.pixels.iter().zip(&expected.pixels);
    for (i, (actual, expected)) in pairs.enumerate() {
        let tolerance = scattered(i).abs() * ROUNDED + DVec3::splat(FLOOR);
        let error = ((*actual - *expected).abs() / tolerance).max_element();
        worst = worst.max(error);
        let place = [i % picture.size[0], i / picture.size[0]];
        assert!(error <= 1.0, "{what} at {place:?}: {actual} instead of {expected}, tolerance {tolerance}");
    }
    println!("{what}: {:.0} % of the tolerance", 100.0 * worst);
}

/// Stored light is scattered once; a stored picture is scattered again and again, until it is what the sum of the series is.
#[test]
fn light_is_scattered_as_the_reference_says() {
    let exact = |way| Options { layout: Layout::Exact, output: OutputFormat::Rgba32Float, ..bloom(way) };
    on_device(None, |gpu| {
        for scene in [scenes::every_feature(), scenes::lights_only()] {
            for &curve in Tonemap::ALL {
                let off = Options { bloom: BloomWay::Off, tonemap: Tonemap::Linear, ..exact(BloomWay::Off) };
                let own = light(&gpu.picture(&scene, gpu.plan(&scene, off), 0.0));
                for way in WAYS {
                    let options = Options { tonemap: curve, ..exact(way) };
                    let (share, levels) =
                        (f64::from(options.bloom_strength), bloom_levels(&options) as usize);
                    assert!(levels >= 4);
                    let plan = gpu.plan(&scene, options);
                    let turns = plan.frames_to_settle() as usize;
                    let picture = light(&frames(gpu, &scene, plan, &vec![0.0; turns]));
                    let mut expected = own.clone();
                    for _ in 1..turns {
                        let source = match way {
                            BloomWay::Previous => {
                                map(&expected, |l| tonemap_inverse(curve, tonemap(curve, l)))
                            }
                            _ => own.clone(),
                        };
                        expected = mixed(&own, &scattered(&source, levels), share);
                    }
                    // Compared as light: curves stretch and squeeze errors.
                    let seen = |l| tonemap_inverse(curve, l);
                    let (picture, expected) =
                        (map(&picture, seen), map(&expected, |l| seen(tonemap(curve, l))));
                    let part = |i: usize| expected.pixels[i] - own.pixels[i] * (1.0 - share);
                    expect_near(&format!("{}, {way}, {curve}", scene.name), &picture, &expected, part);
                }
            }
        }
    });
}

/// The first frame has nothing to scatter, and each later one scatters light as bright as its own exposure makes it.
#[test]
fn scattered_light_is_a_frame_late_and_follows_the_exposure() {
    on_device(None, |gpu| {
        let scene = scenes::every_feature();
        let off = gpu.picture(&scene, gpu.plan(&scene, bloom(BloomWay::Off)), 0.0);
        for way in WAYS {
            let float = |o: Options| Options {
                output: OutputFormat::Rgba32Float,
                tonemap: Tonemap::Linear,
                layout: Layout::Exact,
                ..o
            };
            let first = frames(gpu, &scene, gpu.plan(&scene, bloom(way)), &[0.0]);
            assert_eq!(difference(&off, &first), None, "{way}");
            let plan = gpu.plan(&scene, float(bloom(way)));
            let steady = light(&frames(gpu, &scene, plan.clone(), &[1.0, 1.0]));
            let changed = light(&frames(gpu, &scene, plan, &[-1.0, 1.0]));
            expect_near(&format!("{way}, exposure"), &changed, &steady, |i| steady.pixels[i]);
        }
    });
}

/// Both strategies, all layouts, and sizes down to a pixel give one picture; nothing is left from target to target.
#[test]
fn arrangements_do_not_change_what_is_scattered() {
    on_device(None, |gpu| {
        let limits = gpu.device().limits();
        let mut checked = 0;
        let check = |scene: &Scene, options: Options| {
            let turns = [0.0; 3];
            let expected = frames(gpu, scene, gpu.plan(scene, options.clone()), &turns);
            for variant in [
                Options { strategy: Strategy::Separate, ..options.clone() },
                Options { recycle: false, ..options.clone() },
                Options { output_is_input_attachment: false, ..options.clone() },
            ] {
                let picture = frames(gpu, scene, gpu.plan(scene, variant.clone()), &turns);
                assert_eq!(difference(&expected, &picture), None, "{}: {variant:?}", scene.name);
            }
        };
        for way in WAYS {
            for scene in [scenes::every_feature(), scenes::lights_only(), scenes::before_sky()] {
                for &layout in Layout::ALL {
                    let options = Options { layout, ..bloom(way) };
                    if Plan::new(Needs::of(&scene), options.clone(), &limits).is_ok() {
                        check(&scene, options);
                        checked += 1;
                    }
                }
            }
            for size in [[127, 73], [1, 1], [1, 64], [3, 2]] {
                check(&scenes::every_feature(), Options { size, ..bloom(way) });
            }
            if way == BloomWay::Previous {
                check(&scenes::before_sky(), Options { samples: 4, ..bloom(way) });
                check(&scenes::lights_only(), Options { samples: 4, ..bloom(way) });
            }
            check(&scenes::foggy(), bloom(way));
            check(&scenes::every_feature(), Options { path: Path::ForwardMultipass, ..bloom(way) });
        }
        assert!(checked >= 2 * 3 * 12, "{checked}");
    });
}

/// What the host gets is as it asked, whatever these passes did with it before.
#[test]
fn the_output_is_left_as_the_host_wants_it() {
    on_device(None, |gpu| {
        let scene = scenes::lights_only();
        for way in WAYS {
            let copied = frames(gpu, &scene, gpu.plan(&scene, bloom(way)), &[0.0; 2]);
            let plan = gpu.plan(&scene, Options { output_use: OutputUse::Draw, ..bloom(way) });
            assert_eq!(difference(&copied, &frames(gpu, &scene, plan, &[0.0; 2])), None, "{way}");
        }
    });
}

#[test]
fn the_price_is_known_before_anything_runs() {
    let scene = scenes::every_feature();
    let plan = |options: Options| Plan::new(Needs::of(&scene), options, &Limits::default()).unwrap();
    let stored = |plan: &Plan| -> u32 { (0..plan.attachments.len()).map(|a| plan.traffic(a)[1]).sum() };
    for (way, bytes) in [(BloomWay::Off, 4), (BloomWay::Previous, 4), (BloomWay::Store, 8)] {
        let options = Options { bloom: way, ..Options::default() };
        let plan = plan(options);
        assert_eq!((plan.passes.len(), stored(&plan)), (1, bytes), "{way}");
        assert!((0..plan.attachments.len()).all(|a| plan.traffic(a)[0] == 0), "{way}");
        // 4 bytes are read whole, and again at half the size in both directions and by the next frame; a quarter of that, and so
        // on: 4 + (1 + 1 + 1 / 4) (1 + 1 / 4 + ...) + 1 with six sizes, of which the last has no smaller one.
        let [loaded, stored] = plan.post_totals();
        let expected = if way == BloomWay::Off { [0.0; 2] } else { [8.0, 8.0 / 3.0] };
        assert!(
            (loaded - expected[0]).abs() < 0.01 && (stored - expected[1]).abs() < 0.01,
            "{loaded} {stored}"
        );
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |scene: &Scene, options: Options| {
        let plan = Plan::new(Needs::of(scene), options.clone(), &Limits::default());
        plan.err().map(|e| e.to_string()).unwrap_or_else(|| panic!("{options:?} has a plan"))
    };
    let lit = scenes::lights_only();
    let said = refused(&lit, Options { path: Path::Forward, ..bloom(BloomWay::Store) });
    assert!(said.contains("--path deferred"), "{said}");
    let said = refused(&scenes::wholly_unlit(), bloom(BloomWay::Previous));
    assert!(said.contains("leave --bloom out"), "{said}");
    let said = refused(&lit, Options { samples: 4, ..bloom(BloomWay::Store) });
    assert!(said.contains("--bloom previous"), "{said}");
    for number in [-0.1, 1.1, f32::NAN, f32::INFINITY] {
        let said = refused(&lit, Options { bloom_strength: number, ..bloom(BloomWay::Store) });
        assert!(said.contains("--bloom-strength"), "{said}");
        let said = refused(&lit, Options { bloom_radius: number, ..bloom(BloomWay::Store) });
        assert!(said.contains("--bloom-radius"), "{said}");
    }
    let plan = Plan::new(
        Needs::of(&lit),
        Options { path: Path::Auto, ..bloom(BloomWay::Store) },
        &Limits::default(),
    );
    assert_eq!(plan.unwrap().path, Path::Deferred);
}

/// The depth attachment, and all that a layout stores normals in.
fn stored_places(gpu: &Gpu<'_>, scene: &Scene, options: &Options) -> Vec<Place> {
    // The G-buffer of a frame that keeps it: the same pixels.
    let options = Options { edge_filter: false, keep_gbuffer: true, ..options.clone() };
    let offscreen = {
        let mut offscreen = gpu.offscreen(scene, gpu.plan(scene, options), RendererConfig::default());
        offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 }).unwrap();
        offscreen
    };
    let [p, q, r, s] = scene.cameras[0].projection.distance_from_depth().map(f64::from);
    let distance = |depth: f64| (p + q * depth.max(1e-7)) / (r + s * depth.max(1e-7));
    let texels = |name: &str| offscreen.attachment(name).unwrap();
    let (depths, normals) = (texels("depth"), texels("normal_roughness"));
    let place = |(depth, normal): (&[f64], &[f64])| Place {
        distance_m: distance(depth[0]),
        step_m: 0.0,
        normal: DVec3::new(normal[0], normal[1], normal[2]),
    };
    depths.chunks_exact(4).zip(normals.chunks_exact(4)).map(place).collect()
}

/// Given the same depths and normals, the same pixels are on edges, and they become the same mean.
#[test]
fn edges_are_smoothed_as_the_reference_says() {
    /// Of what is interpolated in 8 bits between neighbours, as a share of the brightest of them.
    const TOLERANCE: f64 = 1.0 / 256.0;
    /// Where a change is just as large as makes an edge, rounding decides.
    const UNDECIDED: usize = 2;
    on_device(None, |gpu| {
        for scene in [scenes::every_feature(), scenes::lights_only()] {
            let options = Options {
                size: SIZE,
                layout: Layout::Exact,
                // The depth attachment itself, which says where nothing is.
                depth: Some(DepthStore::D32),
                output: OutputFormat::Rgba32Float,
                ..Options::default()
            };
            let plain = light(&gpu.picture(&scene, gpu.plan(&scene, options.clone()), 0.0));
            let places = stored_places(gpu, &scene, &options);
            let smoothed = Options { edge_filter: true, ..options };
            let smoothed = light(&gpu.picture(&scene, gpu.plan(&scene, smoothed), 0.0));
            let expected = edge_filter(&plain, &places);
            let most = |l: &Light| l.pixels.iter().fold(0.0, |m: f64, p| m.max(p.max_element()));
            let tolerance = TOLERANCE * most(&plain);
            let pairs = smoothed.pixels.iter().zip(&expected.pixels);
            let wrong = pairs.filter(|(a, e)| (**a - **e).abs().max_element() > tolerance).count();
            let moved = plain.pixels.iter().zip(&smoothed.pixels).filter(|(a, b)| a != b).count();
            println!("{}: {moved} pixels smoothed, {wrong} otherwise than expected", scene.name);
            assert!(wrong <= UNDECIDED && moved > plain.pixels.len() / 50, "{}", scene.name);
        }
    });
}

/// Depth and normals are found in every layout, and neither strategy nor bloom change what is done with them.
#[test]
fn arrangements_do_not_change_smoothed_edges() {
    on_device(None, |gpu| {
        let limits = gpu.device().limits();
        let scene = scenes::every_feature();
        let options = |layout| Options { size: SIZE, layout, edge_filter: true, ..Options::default() };
        let mut checked = 0;
        for &layout in Layout::ALL {
            let options = options(layout);
            if Plan::new(Needs::of(&scene), options.clone(), &limits).is_err() {
                continue;
            }
            checked += 1;
            for bloom in [BloomWay::Off, BloomWay::Store] {
                let options = Options { bloom, ..options.clone() };
                let expected = frames(gpu, &scene, gpu.plan(&scene, options.clone()), &[0.0; 2]);
                for variant in [
                    Options { strategy: Strategy::Separate, ..options.clone() },
                    Options { recycle: false, ..options.clone() },
                ] {
                    let picture = frames(gpu, &scene, gpu.plan(&scene, variant), &[0.0; 2]);
                    assert_eq!(difference(&expected, &picture), None, "{layout}, {bloom}");
                }
            }
        }
        assert_eq!(checked, Layout::ALL.len() - 1, "all but the one without a place for light");
        let plan = gpu.plan(&scene, options(Layout::Metallic128));
        let [loaded, stored] = plan.post_totals();
        // Colour, depth and normals are read, the picture is written.
        assert_eq!(([loaded, stored], plan.bytes_moved()), ([12.0, 4.0], 12));
        let refused = Options { samples: 4, ..options(Layout::Metallic128) };
        assert!(Plan::new(Needs::of(&scene), refused, &limits).is_err());
    });
}

//! Lit as they are drawn, surfaces look as they do when they are lit from a G-buffer that rounds nothing.

mod common;

use common::render::{Gpu, difference, on_device, on_device_with_faults};
use common::scenes;
use ontile::glam::{Mat4, Vec3};
use ontile::gpu::{RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Layout, Limits, Needs, Options, OutputFormat, Path, Plan, Strategy, Tonemap};
use ontile::scene::{Instance, Scene};

const SIZE: [u32; 2] = [160, 90];

/// Room for arithmetic in 32-bit floats that compilers contract and reorder: some hundred roundings of 2^-24, relative
/// to the pixel's brightest channel, since tone curves take the channels' differences ...
const MOST_RELATIVE: f32 = 128.0 / (1 << 24) as f32;
/// ... or to this: a tenth of the first step of 8 bits in sRGB.
const FLOOR: f32 = 3.0e-5;
/// The same difference may fall to either side of a step of 8 bits.
const MOST_STEPS: u8 = 1;

fn options(path: Path) -> Options {
    Options { size: SIZE, layout: Layout::Exact, path, ..Options::default() }
}

/// Decals want a G-buffer.
fn without_decals(mut scenes: Vec<Scene>) -> Vec<Scene> {
    scenes.retain(|scene| scene.decals.is_empty());
    scenes
}

fn built() -> Vec<Scene> {
    without_decals(scenes::built())
}

fn shipped() -> Vec<Scene> {
    without_decals(scenes::shipped())
}

/// What casts shadows is among the built ones; the maps of large scenes take most of their time.
fn all_scenes() -> Vec<Scene> {
    let shipped = shipped().into_iter().map(Scene::without_shadows);
    built().into_iter().chain(shipped).collect()
}

fn picture(gpu: &Gpu<'_>, scene: &Scene, options: Options) -> Picture {
    gpu.picture(scene, gpu.plan(scene, options), 0.0)
}

/// What is further apart than rounding takes it: not one pixel may be.
fn beyond_rounding(a: &Picture, b: &Picture) -> Option<String> {
    let far: Vec<bool> = match (&a.pixels, &b.pixels) {
        (Pixels::Rgba32F(a), Pixels::Rgba32F(b)) => {
            let brightest = |pixel: &[f32]| pixel[..3].iter().fold(FLOOR, |most, c| c.abs().max(most));
            let far = |(a, b): (&[f32], &[f32])| {
                let most = MOST_RELATIVE * brightest(a).max(brightest(b));
                [0, 1, 2, 3].map(|c| (a[c] - b[c]).abs() > most)
            };
            a.chunks(4).zip(b.chunks(4)).flat_map(far).collect()
        }
        (Pixels::Rgba8(a), Pixels::Rgba8(b)) => {
            a.iter().zip(b).map(|(a, b)| a.abs_diff(*b) > MOST_STEPS).collect()
        }
        _ => panic!("pictures of two formats"),
    };
    let count = far.iter().filter(|&&far| far).count();
    let first = far.iter().position(|&far| far)? as u32 / 4;
    Some(format!("{count} channels differ, the first at {}, {}", first % a.width, first / a.width))
}

fn each_case(mut check: impl FnMut(Tonemap, OutputFormat)) {
    for &tonemap in Tonemap::ALL {
        for output in [OutputFormat::Rgba8Srgb, OutputFormat::Rgba32Float] {
            check(tonemap, output);
        }
    }
}

const FORWARD: [Path; 2] = [Path::Forward, Path::ForwardMultipass];

#[test]
fn forward_looks_like_deferred() {
    on_device(None, |gpu| {
        let check = |scene: &Scene, tonemap, output| {
            let of = |path| picture(gpu, scene, Options { tonemap, output, ..options(path) });
            let deferred = of(Path::Deferred);
            for path in FORWARD {
                let far = beyond_rounding(&deferred, &of(path));
                assert_eq!(far, None, "{}, {path}, {tonemap}, {output}", scene.name);
            }
        };
        // Surfaces do not know the tone curve: what ends in tonemap, in folded lighting and in fog has all of them.
        let all_curves =
            [scenes::every_feature(), scenes::lights_only(), scenes::foggy(), scenes::foggy_unlit()];
        all_curves.iter().for_each(|scene| each_case(|tonemap, output| check(scene, tonemap, output)));
        for (scene, &tonemap) in built().iter().zip(Tonemap::ALL.iter().cycle()) {
            check(scene, tonemap, OutputFormat::Rgba8Srgb);
            check(scene, tonemap, OutputFormat::Rgba32Float);
        }
        let exact = (Tonemap::Neutral, OutputFormat::Rgba32Float);
        for mut scene in shipped() {
            // Shadow volumes need a G-buffer, and maps are not equal to them.
            scene.lights.iter_mut().filter_map(|l| l.shadow.as_mut()).for_each(|s| s.volume = None);
            check(&scene, exact.0, exact.1);
        }
    });
}

#[test]
fn arrangements_of_forward_do_not_change_the_pixels() {
    type Change = fn(Options) -> Options;
    const CHANGES: [(&str, Change); 5] = [
        ("separate", |o| Options { strategy: Strategy::Separate, ..o }),
        ("depth pre-pass", |o| Options { depth_prepass: true, ..o }),
        ("separate, depth pre-pass", |o| Options { strategy: Strategy::Separate, depth_prepass: true, ..o }),
        ("not recycled", |o| Options { recycle: false, ..o }),
        ("output not an input attachment", |o| Options { output_is_input_attachment: false, ..o }),
    ];
    on_device(None, |gpu| {
        for (scene, path) in all_scenes().iter().flat_map(|s| FORWARD.map(|path| (s, path))) {
            let expected = picture(gpu, scene, options(path));
            let same = |name: &str, options| {
                let changed = picture(gpu, scene, options);
                assert_eq!(difference(&expected, &changed), None, "{}, {path}, {name}", scene.name);
            };
            for (name, change) in CHANGES {
                same(name, change(options(path)));
            }
            match path {
                // What lies over light does so over the layout's light target.
                Path::Forward if Needs::of(scene).over_light().is_some() => {}
                Path::Forward => same("layout", Options { layout: Layout::Metallic128, ..options(path) }),
                _ => same("no illumination sets", Options { illumination_sets: false, ..options(path) }),
            }
        }
    });
}

/// Small lights over the floor and the objects of [`scenes::every_feature`], among balls of one mesh, which one draw would
/// draw: each reaches few of them, and of some only the rim.
fn many_lights() -> Scene {
    let mut scene = Scene { name: "many_lights".into(), ..scenes::every_feature() };
    let ball = scene.meshes.iter().position(|mesh| mesh.name == "bumpy").unwrap();
    for i in 0..40 {
        let mut light = scene.lights[1 + i % 2].clone();
        let [x, z] = [i % 8, i / 8].map(|c| c as f32 * 0.7 - 2.4);
        light.position_world = Vec3::new(x, 0.3, z);
        light.range_m = Some(0.5);
        scene.lights.push(light);
        let place = Vec3::new(x + 0.13 * (i % 4) as f32, 0.1, z + 0.09 * (i % 5) as f32);
        let small = Mat4::from_translation(place) * Mat4::from_scale(Vec3::splat(0.1));
        scene.instances.push(Instance::new(ball, small));
    }
    scene
}

#[test]
fn illumination_sets_save_draws_and_no_pixel_changes() {
    on_device(None, |gpu| {
        let scene = many_lights();
        let draw = |path, illumination_sets| {
            let plan = gpu.plan(&scene, Options { illumination_sets, ..options(path) });
            let mut offscreen = gpu.offscreen(&scene, plan, RendererConfig::default());
            offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 }).unwrap();
            (offscreen.picture(), offscreen.renderer().recorded())
        };
        let (deferred, _) = draw(Path::Deferred, true);
        let (with, few) = draw(Path::ForwardMultipass, true);
        let (without, all) = draw(Path::ForwardMultipass, false);
        assert_eq!(difference(&with, &without), None);
        assert_eq!(beyond_rounding(&deferred, &with), None);
        // 7 materials make 7 draws, of which 6 are lit, and tonemap makes one; without sets each light adds those 6.
        assert_eq!(all.counts.draws, 7 + 6 * all.counts.lights.visible + 1, "{all:?}");
        println!("{:?} with illumination sets, {:?} without", few.counts, all.counts);
        // A light draws its part of a batch by one draw for each run of neighbours.
        assert!(
            few.counts.draws < all.counts.draws && few.counts.triangles * 4 < all.counts.triangles,
            "{few:?} of {all:?}"
        );
    });
}

#[test]
fn what_rounding_does_not_explain_is_seen() {
    on_device_with_faults(|gpu| {
        let scene = scenes::every_feature();
        each_case(|tonemap, output| {
            let of = |scene: &Scene, path| picture(gpu, scene, Options { tonemap, output, ..options(path) });
            let deferred = of(&scene, Path::Deferred);
            for light in 0..scene.lights.len() {
                let mut fewer = scene.clone();
                fewer.lights.remove(light);
                for path in FORWARD {
                    let far = beyond_rounding(&deferred, &of(&fewer, path));
                    assert!(far.is_some(), "{path}, {tonemap}, {output}: light {light} is not missed");
                }
            }
            let dark = Scene { ambient_nt: Vec3::ZERO, ..scene.clone() };
            for path in FORWARD {
                assert!(beyond_rounding(&deferred, &of(&dark, path)).is_some(), "{path}: ambient light");
            }
        });
    });
}

#[test]
fn forward_holds_the_output_and_nothing_else() {
    for scene in built().into_iter().filter(|s| Needs::of(s).over_light().is_none()) {
        let plan = Plan::new(Needs::of(&scene), options(Path::Forward), &Limits::default()).unwrap();
        let colors: Vec<_> = plan.attachments.iter().filter(|a| !a.format.is_depth()).collect();
        assert_eq!(colors.len(), 1, "{}", scene.name);
        assert!(colors[0].is_output && colors[0].format.bits() == 32);
        assert_eq!((plan.passes.len(), plan.stage_count()), (1, 1));
    }
}

#[test]
fn multipass_adds_lights_on_the_tile() {
    let is_lit = |s: &Scene| Needs::of(s).listed_lights() > 0 && Needs::of(s).lit_opaque.is_some();
    for scene in built().into_iter().filter(is_lit) {
        let Needs { blended, transmits, particles, .. } = Needs::of(&scene);
        let over = [blended.is_some(), transmits.is_some(), !particles.is_empty()];
        let stages = 3 + over.into_iter().filter(|is_there| *is_there).count();
        let plan = Plan::new(Needs::of(&scene), options(Path::ForwardMultipass), &Limits::default()).unwrap();
        assert_eq!((plan.passes.len(), plan.stage_count()), (1, stages), "{}", scene.name);
        assert!(plan.attachments.iter().all(|a| a.is_output || a.transient));
    }
    // Nothing to add, nothing to add to.
    let plan =
        Plan::new(Needs::of(&scenes::no_lights()), options(Path::ForwardMultipass), &Limits::default());
    assert_eq!(plan.unwrap().path, Path::Forward);
}

#[test]
fn a_gbuffer_that_does_not_exist_cannot_be_kept() {
    let kept = Options { keep_gbuffer: true, ..options(Path::Forward) };
    let error = Plan::new(Needs::of(&scenes::lights_only()), kept, &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("no G-buffer"), "{error}");
}

//! One picture, however lights reach pixels: every way against `fullscreen`, where each pixel looks at all lights.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes;
use ontile::glam::{Mat4, Vec3};
use ontile::picture::Pixels;
use ontile::plan::{Layout, LightWay, Needs, Options, OutputFormat, Path, Strategy, Tonemap};
use ontile::scene::{Camera, Light, LightKind, Projection, Scene};
use std::f32::consts::FRAC_PI_2;

const SIZE: [u32; 2] = [192, 108];

/// How far apart two ways may be: relative to the brighter of the two values, or to the smallest that matters. Both sum
/// the same products in the same order, which compilers may round differently: the sums of up to a hundred lights take
/// as many roundings of half an epsilon, the terms some 30 more.
const MOST_RELATIVE: f32 = 64.0 * f32::EPSILON;
const LEAST_VALUE: f32 = 1e-4;

/// Small lights of all kinds with a place, over the floor of [`scenes::lights_only`].
fn many_lights() -> Scene {
    let mut scene = Scene { name: "many_lights".into(), ..scenes::lights_only() };
    for i in 0..90 {
        let [x, z] = [i % 10, i / 10].map(|c| c as f32 * 0.6 - 2.7);
        let mut light = scene.lights[1 + i % 2].clone();
        light.position_world = Vec3::new(x, 0.2 + 0.05 * (i % 7) as f32, z);
        light.range_m = Some(0.4 + 0.1 * (i % 5) as f32);
        scene.lights.push(light.towards(Vec3::new((i as f32).sin(), -1.0, (i as f32).cos())));
    }
    scene
}

/// Lights where a proxy or a list is most easily wrong: around the camera, across the near plane, behind the camera,
/// beyond the far plane, touching the image's edge, without an end, with hardly any, and cones up to a half space.
fn awkward_lights() -> Scene {
    let mut scene = Scene { name: "awkward_lights".into(), ..many_lights() };
    scene.lights.truncate(1);
    let near_far = Projection::Perspective { yfov_rad: 0.7, znear_m: 0.3, zfar_m: Some(6.0) };
    scene.cameras[0].projection = near_far;
    let eye = scene.cameras[0].world_from_view.transform_point3(Vec3::ZERO);
    let ahead = scene.cameras[0].world_from_view.transform_vector3(Vec3::NEG_Z);
    let point = LightKind::Point { intensity_cd: 0.6 };
    let spot = |outer_cone_rad| LightKind::Spot { intensity_cd: 2.0, inner_cone_rad: 0.0, outer_cone_rad };
    let mut add = |kind, position_world, range_m| {
        let light = Light { position_world, range_m, color: Vec3::new(1.0, 0.8, 0.6), ..Light::new(kind) };
        scene.lights.push(light.towards(Vec3::new(0.1, -1.0, -0.2)));
    };
    add(point, eye, Some(5.0));
    add(point, eye + ahead * 0.3, Some(0.2));
    add(point, eye - ahead, Some(4.5));
    add(point, eye + ahead * 6.0, Some(2.0));
    add(point, Vec3::new(-2.4, 0.2, 0.0), Some(0.5));
    add(point, Vec3::new(0.0, 0.001, 0.5), Some(1e-3));
    add(point, Vec3::new(0.5, 0.4, 0.4), Some(0.0));
    add(point, Vec3::new(0.5, 3.0, 0.4), None);
    for cone in [0.02, 0.4, 0.8, 1.2, FRAC_PI_2] {
        add(spot(cone), Vec3::new(cone - 0.8, 0.9, 0.6), Some(1.5));
        add(spot(cone), eye + ahead * 0.1, Some(5.0));
    }
    let crate_of = |size| LightKind::Box { illuminance_lx: 0.4, size_m: size, falloff_m: 0.1 };
    add(crate_of(Vec3::new(1.0, 0.6, 0.8)), Vec3::new(0.9, 0.3, 0.3), None);
    add(crate_of(Vec3::new(2.0, 1.0, 9.0)), eye, None);
    add(crate_of(Vec3::splat(4.0)), eye + ahead * 6.0, None);
    add(spot(0.3), Vec3::new(0.0, 4.0, 0.0), None);
    add(spot(FRAC_PI_2), Vec3::new(0.0, 4.0, 0.0), None);
    scene
}

fn all_scenes() -> Vec<Scene> {
    let mut all = scenes::built();
    all.extend([many_lights(), awkward_lights()]);
    let parallel = Projection::Orthographic { xmag_m: 2.6, ymag_m: 1.5, znear_m: 0.1, zfar_m: 20.0 };
    for mut scene in [many_lights(), awkward_lights()] {
        scene.name += "_parallel";
        scene.cameras[0].projection = parallel;
        all.push(scene);
    }
    all
}

fn floats(gpu: &Gpu<'_>, scene: &Scene, options: Options) -> Vec<f32> {
    let output = OutputFormat::Rgba32Float;
    let plan = gpu.plan(scene, Options { output, size: SIZE, ..options });
    let Pixels::Rgba32F(channels) = gpu.picture(scene, plan, 0.0).pixels else { unreachable!() };
    channels
}

/// Where all that is lit is blended, there is no G-buffer to add lights to.
fn scenes_with_a_gbuffer() -> Vec<Scene> {
    let has_one = |scene: &Scene| {
        let needs = Needs::of(scene);
        needs.lit.is_none() || needs.lit_opaque.is_some()
    };
    all_scenes().into_iter().filter(has_one).collect()
}

/// The most that one is from the other, as a share of the brighter.
fn most_relative(a: &[f32], b: &[f32]) -> f32 {
    let relative = |(a, b): (&f32, &f32)| (a - b).abs() / a.max(*b).max(LEAST_VALUE);
    a.iter().zip(b).map(relative).fold(0.0, f32::max)
}

const WAYS: [LightWay; 3] = [LightWay::Clusters, LightWay::Volumes, LightWay::Stencil];

#[test]
fn ways_give_one_picture() {
    on_device(None, |gpu| {
        for scene in scenes_with_a_gbuffer() {
            for &fold in &[true, false] {
                let options = Options { layout: Layout::Exact, fold, ..Options::default() };
                let expected = floats(gpu, &scene, options.clone());
                for lights in WAYS {
                    let most =
                        most_relative(&expected, &floats(gpu, &scene, Options { lights, ..options.clone() }));
                    println!("{}, {lights}, fold {fold}: {most:.2e}", scene.name);
                    assert!(most <= MOST_RELATIVE, "{}, {lights}, fold {fold}: {most:.2e} apart", scene.name);
                }
            }
        }
    });
}

#[test]
fn ways_are_alike_in_one_pass_and_in_several() {
    on_device(None, |gpu| {
        for scene in [scenes::every_feature(), scenes::orthographic(), many_lights(), awkward_lights()] {
            let layouts = [Layout::Metallic128, Layout::Exact, Layout::Ontile128, Layout::Rasa128];
            for layout in layouts.into_iter().chain(word_layouts(gpu)) {
                for lights in WAYS {
                    let picture = |strategy| {
                        let options = Options { size: SIZE, layout, lights, strategy, ..Options::default() };
                        gpu.picture(&scene, gpu.plan(&scene, options), 0.0)
                    };
                    let both = [Strategy::Subpasses, Strategy::Separate].map(picture);
                    assert_eq!(difference(&both[0], &both[1]), None, "{}, {layout}, {lights}", scene.name);
                }
            }
        }
    });
}

/// Layouts that hold light in words, which the shader adds to; none where the device lacks what that needs.
fn word_layouts(gpu: &Gpu<'_>) -> Vec<Layout> {
    if !gpu.device().limits().ordered_attachment_access {
        println!("ignored in part: no rasterization-order attachment access");
        return Vec::new();
    }
    vec![Layout::Packed128, Layout::Metallic256, Layout::Specular256]
}

/// Each addition rounds the sum as its format does: half floats by a unit in the last place at most (lavapipe: downwards),
/// 15 bits of mantissa by half of one. What lists add at once was rounded before: in packed128 to e5b9g9r9, by half a step of
/// 9 bits of the brightest channel, which may be all but half of what 9 bits hold.
#[test]
fn words_take_light_by_light() {
    const HALF_UNIT: f32 = 1.0 / 1024.0;
    const SUM_HALF_UNIT: f32 = 1.0 / 65536.0;
    const E5B9G9R9_HALF_STEP: f32 = 1.0 / 512.0;
    on_device(None, |gpu| {
        let mut wrong = Vec::new();
        // What comes over light is blended over it in a target of its own.
        let blends = |scene: &Scene| Needs::of(scene).over_light().is_some();
        for scene in scenes_with_a_gbuffer().into_iter().filter(|scene| !blends(scene)) {
            let at_once = match scene.name.starts_with("many_lights") {
                true => most_lights_at_once(&scene),
                false => scene.lights.len(),
            };
            for layout in word_layouts(gpu) {
                let bound = match layout {
                    Layout::Packed128 => {
                        (at_once + 1) as f32 * SUM_HALF_UNIT + before(&scene) * E5B9G9R9_HALF_STEP
                    }
                    _ => (at_once + 2) as f32 * HALF_UNIT,
                } + MOST_RELATIVE;
                let options = Options { layout, tonemap: Tonemap::Linear, ..Options::default() };
                let of = |lights| floats(gpu, &scene, Options { lights, ..options.clone() });
                let expected = of(LightWay::Clusters);
                let [volumes, stencil] = [LightWay::Volumes, LightWay::Stencil].map(of);
                let Drift { most, mean } = Drift::of(&expected, &volumes);
                let apart = Drift::of(&volumes, &stencil).most;
                let told = format!(
                    "{}, {layout}: {most:.1e} of the brightest channel at most, {mean:.1e} on average, {apart:.1e} from \
                     volumes to stencil; {bound:.1e} allowed",
                    scene.name
                );
                println!("{told}");
                wrong.extend((most > bound || apart > bound).then_some(told));
            }
        }
        assert_eq!(wrong, Vec::<String>::new());
    });
}

/// 1 if there is light before lighting.
fn before(scene: &Scene) -> f32 {
    f32::from(!Needs::of(scene).prelit.is_empty())
}

/// How far pixels are from what they should be, as shares of their brightest channel; on average with the sign.
struct Drift {
    most: f32,
    mean: f32,
}

impl Drift {
    fn of(expected: &[f32], found: &[f32]) -> Self {
        let share = |(a, b): (&[f32], &[f32])| {
            let brightest = a[..3].iter().chain(&b[..3]).fold(LEAST_VALUE, |most, c| most.max(*c));
            [0, 1, 2].map(|c| (b[c] - a[c]) / brightest)
        };
        let all: Vec<f32> = expected.chunks(4).zip(found.chunks(4)).flat_map(share).collect();
        let lit = all.iter().filter(|s| **s != 0.0).count().max(1);
        Self {
            most: all.iter().fold(0.0, |most, s| most.max(s.abs())),
            mean: all.iter().sum::<f32>() / lit as f32,
        }
    }
}

/// Surfaces that are lit as they are drawn find their lights in the same lists.
#[test]
fn forward_gives_the_same_picture() {
    on_device(None, |gpu| {
        // Decals are painted over a G-buffer.
        for scene in all_scenes().into_iter().filter(|scene| scene.decals.is_empty()) {
            let options = Options { path: Path::Forward, ..Options::default() };
            let expected = floats(gpu, &scene, options.clone());
            let most = most_relative(
                &expected,
                &floats(gpu, &scene, Options { lights: LightWay::Clusters, ..options }),
            );
            assert!(most <= MOST_RELATIVE, "{}: {most:.2e} apart", scene.name);
        }
    });
}

/// The most lights that reach one place of the floor or of the balls of [`scenes::lights_only`].
fn most_lights_at_once(scene: &Scene) -> usize {
    let floor =
        (0..60 * 60).map(|i| Vec3::new((i % 60) as f32 * 0.1 - 3.0, 0.0, (i / 60) as f32 * 0.1 - 3.0));
    let ball = |x: f32| {
        (0..30 * 30).map(move |i| {
            let [turn, tilt] = [(i % 30) as f32 * 0.21, (i / 30) as f32 * 0.105];
            let way = Vec3::new(tilt.sin() * turn.cos(), tilt.cos(), tilt.sin() * turn.sin());
            Vec3::new(x, 0.5, 0.0) + way * 0.5
        })
    };
    let reaches = |l: &Light, place: Vec3| l.range_m.is_none_or(|r| l.position_world.distance(place) < r);
    let count = |place: Vec3| scene.lights.iter().filter(|l| reaches(l, place)).count();
    floor.chain(ball(-1.1)).chain(ball(1.1)).map(count).max().unwrap_or(0)
}

/// Lights that are added by themselves are rounded each time, to the 11 bits of a half float: by half a unit in the last place
/// of the sum, or (lavapipe) by all of it downwards. In 10 bits of an exposed light up to 2 these would all be lost.
#[test]
fn many_dim_lights_are_as_bright_one_by_one() {
    const STEP_OF_10_BITS: f32 = 2.0 / 1023.0;
    on_device(None, |gpu| {
        let mut scene = many_lights();
        let lights_at_once = most_lights_at_once(&scene) as f32;
        let options = Options { tonemap: Tonemap::Linear, ..Options::default() };
        let exposed = |scene: &Scene, options| floats(gpu, scene, options);
        let brightest = exposed(&scene, options.clone()).into_iter().fold(0.0, f32::max);
        let dimmer = 0.2 * STEP_OF_10_BITS / brightest * lights_at_once;
        scene.lights.iter_mut().for_each(|light| light.color *= dimmer);
        let expected = exposed(&scene, Options { lights: LightWay::Fullscreen, ..options.clone() });
        let bound = (lights_at_once + 1.0) * f32::EPSILON * 2.0_f32.powi(23 - 10);
        let one_by_one =
            [LightWay::Volumes, LightWay::Stencil].map(|lights| Options { lights, ..options.clone() });
        let multipass = Options { path: Path::ForwardMultipass, ..options.clone() };
        let deferred = one_by_one.map(|options| (options, &expected));
        let forward = exposed(&scene, Options { path: Path::Forward, ..options.clone() });
        for (options, expected) in deferred.into_iter().chain([(multipass, &forward)]) {
            let what = format!("{}, {}", options.path, options.lights);
            let off = most_relative(expected, &exposed(&scene, options));
            println!("{what}: {off:.1e} of the brighter at most, bound {bound:.1e}");
            assert!(off <= bound, "{what}: {off} off, {bound} allowed");
            assert!(off > 1e-6, "{what}: nothing is rounded?");
        }
    });
}

/// Cameras between which lists must not be mixed up.
#[test]
fn frames_in_turn_have_lists_of_their_own() {
    on_device(None, |gpu| {
        let scene = many_lights();
        let turned = |camera: &Camera| Camera {
            world_from_view: camera.world_from_view * Mat4::from_rotation_y(0.4),
            ..camera.clone()
        };
        let cameras = [scene.cameras[0].clone(), turned(&scene.cameras[0])];
        for lights in WAYS {
            let options = Options { size: SIZE, lights, ..Options::default() };
            let alone = cameras.clone().map(|camera| {
                let scene = Scene { cameras: vec![camera], ..scene.clone() };
                gpu.picture(&scene, gpu.plan(&scene, options.clone()), 0.0)
            });
            let mut host = gpu.offscreen(&scene, gpu.plan(&scene, options.clone()), Default::default());
            for turn in [0, 1, 0] {
                host.render(&ontile::gpu::View { camera: &cameras[turn], exposure_ev: 0.0 }).unwrap();
                assert_eq!(difference(&alone[turn], &host.picture()), None, "{lights}");
            }
        }
    });
}

/// Marks that a light left in the stencil would count on: of 8 bits, after so many lights there is none.
#[test]
fn marks_are_gone_before_the_next_light() {
    const MARKS: usize = 256;
    on_device(None, |gpu| {
        let mut scene = scenes::one_lit_triangle();
        let kind = LightKind::Point { intensity_cd: 0.01 };
        let position_world = scene.instances[0].world_from_object.transform_point3(Vec3::new(0.0, 0.0, 0.3));
        scene.lights = vec![Light { position_world, range_m: Some(0.6), ..Light::new(kind) }; MARKS];
        let picture =
            |lights| floats(gpu, &scene, Options { layout: Layout::Exact, lights, ..Options::default() });
        let most = most_relative(&picture(LightWay::Fullscreen), &picture(LightWay::Stencil));
        assert!(most < 0.5 / MARKS as f32, "{most:.2e} apart: more than half a light");
    });
}

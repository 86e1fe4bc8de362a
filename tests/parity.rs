//! One picture, however it is made: passes, attachments and memory are arranged in many ways, and no pixel may change.

mod common;

use ash::vk;
use common::render::{Gpu, difference, on_device, on_device_with_faults};
use common::scenes;
use ontile::glam::{Mat4, Vec3};
use ontile::gpu::{Commands, Image, ImageDesc, OutputImage, Readback, Renderer, RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{
    Choice, Layout, Load, Needs, Options, OutputFormat, Pipeline, Plan, Refraction, Seen, Strategy, Tonemap,
    Translucency,
};
use ontile::scene::{Camera, Projection, Scene};
use std::panic::{AssertUnwindSafe, catch_unwind};

const SIZE: [u32; 2] = [160, 90];

/// A change of the options that must not change the picture.
type Variant = (&'static str, fn(Options) -> Options);

/// All of them, against the default: one pass, recycled attachments, nothing kept.
const VARIANTS: [Variant; 8] = [
    ("separate", |o| Options { strategy: Strategy::Separate, ..o }),
    ("not recycled", |o| Options { recycle: false, ..o }),
    ("output not an input attachment", |o| Options { output_is_input_attachment: false, ..o }),
    ("G-buffer kept", |o| Options { keep_gbuffer: true, ..o }),
    ("separate, not recycled", |o| Options { strategy: Strategy::Separate, recycle: false, ..o }),
    ("depth pre-pass", |o| Options { depth_prepass: true, ..o }),
    ("separate, depth pre-pass", |o| Options { strategy: Strategy::Separate, depth_prepass: true, ..o }),
    ("separate, G-buffer kept", |o| Options { strategy: Strategy::Separate, keep_gbuffer: true, ..o }),
];

/// The layouts with the coarsest and the finest formats; `arrangements_do_not_change_the_pixels_of_any_gbuffer` has all.
const LAYOUTS: [Layout; 2] = [Layout::Metallic128, Layout::Exact];

fn every<T: Copy, U: Copy>(a: &[T], b: &[U]) -> Vec<(T, U)> {
    a.iter().flat_map(|&a| b.iter().map(move |&b| (a, b))).collect()
}

/// Renders every variant with these options and compares it with the default.
fn check_variants(gpu: &Gpu<'_>, scene: &Scene, options: &Options) {
    let plan = gpu.plan(scene, options.clone());
    let (path, expected) = (plan.path, gpu.picture(scene, plan, 0.0));
    // Without lights there is a G-buffer only if it is to be kept, and then light is rounded to its target.
    let is_unlit = scene.lights.iter().all(ontile::scene::Light::is_dark);
    let mut expected_kept = None;
    for (name, change) in VARIANTS {
        let plan = gpu.plan(scene, change(options.clone()));
        let kept_only = plan.path != path;
        assert!(!kept_only || is_unlit, "{}, {name}, {options:?}: another path", scene.name);
        let picture = gpu.picture(scene, plan, 0.0);
        let expected =
            if kept_only { expected_kept.get_or_insert_with(|| picture.clone()) } else { &expected };
        if let Some(difference) = difference(expected, &picture) {
            panic!("{}, {name}, {options:?}: {difference}", scene.name);
        }
    }
    let capture = RendererConfig { capture: true, ..RendererConfig::default() };
    let captured = gpu.picture_with(scene, gpu.plan(scene, options.clone()), 0.0, capture);
    if let Some(difference) = difference(&expected, &captured) {
        panic!("{}, capture, {options:?}: {difference}", scene.name);
    }
}

#[test]
fn arrangements_do_not_change_the_pixels_of_shipped_scenes() {
    on_device(None, |gpu| {
        for scene in scenes::shipped() {
            check_variants(gpu, &scene, &Options { size: SIZE, ..Options::default() });
            // Shadow maps are the same in both layouts, and take most of the time.
            let scene = scene.without_shadows();
            check_variants(gpu, &scene, &Options { size: SIZE, layout: Layout::Exact, ..Options::default() });
        }
    });
}

#[test]
fn arrangements_do_not_change_the_pixels_of_any_kind_of_scene() {
    // A BGRA output takes as many bits as an RGBA one: `output_formats_hold_the_same_picture` has it.
    const OUTPUTS: [OutputFormat; 2] = [OutputFormat::Rgba8Srgb, OutputFormat::Rgba32Float];
    on_device(None, |gpu| {
        for scene in scenes::built() {
            for (layout, output) in every(&LAYOUTS, &OUTPUTS) {
                check_variants(gpu, &scene, &Options { size: SIZE, layout, output, ..Options::default() });
            }
        }
    });
}

#[test]
fn arrangements_do_not_change_the_pixels_of_any_gbuffer() {
    on_device(None, |gpu| {
        for scene in [scenes::every_feature(), scenes::before_sky(), scenes::lights_only()] {
            let mut refused = Vec::new();
            for choice in Choice::one_by_one(Choice::of(Layout::Ontile128)) {
                let options = choice.apply(&Options { size: SIZE, ..Options::default() });
                let limits = gpu.device().limits();
                if Plan::new(Needs::of(&scene), options.clone(), &limits).is_ok() {
                    check_variants(gpu, &scene, &options);
                } else {
                    refused.push(choice.to_string());
                }
            }
            // It has no place for light that exists before lighting.
            let expected: &[&str] = if scene.name == "lights_only" { &[] } else { &["ontile64"] };
            assert_eq!(refused, expected, "{}", scene.name);
        }
    });
}

#[test]
fn arrangements_do_not_change_the_pixels_of_any_translucency() {
    on_device(None, |gpu| {
        let scene = scenes::glass_scenes::glass_in_fog();
        let layouts = [Layout::Packed128, Layout::Metallic256, Layout::Rasa128];
        for (translucency, layout) in every(Translucency::ALL, &layouts) {
            let options = Options { size: SIZE, layout, translucency, ..Options::default() };
            let ordered = gpu.device().limits().ordered_attachment_access;
            if translucency == Translucency::Oit && !ordered {
                common::ignored("no rasterization-order attachment access");
                continue;
            }
            check_variants(gpu, &scene, &options);
        }
    });
}

#[test]
fn arrangements_do_not_change_the_pixels_of_refraction() {
    on_device(None, |gpu| {
        let layouts = [Layout::Metallic128, Layout::Packed128, Layout::Ontile128, Layout::Thibieroz128];
        let bent = Options { size: SIZE, refraction: Refraction::Pass, ..Options::default() };
        for (layout, scene) in
            layouts.into_iter().flat_map(|l| scenes::media_scenes::all().into_iter().map(move |s| (l, s)))
        {
            check_variants(gpu, &scene, &Options { layout, ..bent.clone() });
        }
    });
}

#[test]
fn arrangements_do_not_change_the_pixels_of_any_tone_curve() {
    on_device(None, |gpu| {
        for scene in [scenes::every_feature(), scenes::lights_only()] {
            for (layout, tonemap) in every(&LAYOUTS, Tonemap::ALL) {
                check_variants(gpu, &scene, &Options { size: SIZE, layout, tonemap, ..Options::default() });
            }
        }
    });
}

#[test]
fn arrangements_do_not_change_the_pixels_at_odd_sizes() {
    on_device(None, |gpu| {
        let scene = scenes::every_feature();
        for (layout, size) in every(&LAYOUTS, &[[127, 73], [1, 1], [1, 64]]) {
            check_variants(gpu, &scene, &Options { size, layout, ..Options::default() });
        }
    });
}

/// Where cameras see all, some and none of a scene: as it is, turned to either side and right round, in its middle, far
/// from it with a narrow view, and with an orthographic one that cuts through.
fn cameras(scene: &Scene) -> Vec<Camera> {
    let first = &scene.cameras[0];
    let turned = |y: f32| first.world_from_view * Mat4::from_rotation_y(y);
    let center = scene.bounds_world().map_or(Vec3::ZERO, |b| b.center());
    let perspective = |yfov_rad| Projection::Perspective { yfov_rad, znear_m: 0.05, zfar_m: None };
    let parallel = Projection::Orthographic { xmag_m: 0.7, ymag_m: 0.7, znear_m: 0.0, zfar_m: 1.0 };
    let far = Mat4::from_translation(center + Vec3::new(0.0, 0.0, 300.0));
    let poses = [
        (first.world_from_view, first.projection),
        (turned(0.6), first.projection),
        (turned(-0.6), first.projection),
        (turned(std::f32::consts::PI), first.projection),
        (Mat4::from_translation(center), perspective(2.0)),
        (far, perspective(0.004)),
        (Mat4::from_translation(center), parallel),
    ];
    let camera = |(world_from_view, projection)| Camera { name: "moved".into(), world_from_view, projection };
    poses.map(camera).to_vec()
}

#[test]
fn culling_does_not_change_the_pixels() {
    on_device(None, |gpu| {
        let (mut objects, mut lights) = ([0, 0], [0, 0]);
        for scene in scenes::shipped().into_iter().chain(scenes::built()) {
            let plan = gpu.plan(&scene, Options { size: SIZE, layout: Layout::Exact, ..Options::default() });
            let boxes_or_squares = |p: &Pipeline| matches!(p, Pipeline::Decal(_) | Pipeline::Particles(_));
            let of_screen = |p: &Pipeline| !p.is_of_surfaces() && !boxes_or_squares(p);
            let screens = plan.pipelines.iter().filter(|(_, p)| of_screen(p)).count();
            // Two triangles for each side of a box.
            let decals: usize = plan.needs.decals.iter().map(|need| need.decals).sum();
            let particles: usize = plan.needs.particles.iter().map(|need| need.particles).sum();
            // What light goes through is drawn twice.
            let meshes = scene.instances.iter().map(|instance| &scene.meshes[instance.mesh]);
            let media = meshes.filter(|mesh| scene.materials[mesh.material].transmits().is_some());
            let twice: usize = media.map(|mesh| mesh.indices.len() / 3).sum();
            let screens = (screens + 12 * decals + 2 * particles + twice) as u64;
            let make = |cull| {
                gpu.offscreen(&scene, plan.clone(), RendererConfig { cull, ..RendererConfig::default() })
            };
            let mut ways = [make(false), make(true)];
            for (index, camera) in cameras(&scene).iter().enumerate() {
                let pictures = ways.each_mut().map(|way| {
                    way.render(&View { camera, exposure_ev: 0.0 }).unwrap();
                    way.picture()
                });
                let difference = difference(&pictures[0], &pictures[1]);
                assert_eq!(difference, None, "{}, camera {index}", scene.name);
                let counts = ways.each_ref().map(|way| way.renderer().recorded().counts);
                let all = scene.triangle_count() as u64 + screens;
                // Shadow volumes are as many more as casters have edges.
                let counted = plan.volume_lights.is_empty().then_some(counts[0].triangles);
                assert_eq!(counted.unwrap_or(all), all, "{}, camera {index}", scene.name);
                let every = counts[0].objects.visible;
                assert_eq!(counts[0].objects, Seen::of(every, every));
                assert_eq!(counts[1].objects, Seen::of(counts[1].objects.visible, every));
                for (way, counts) in counts.iter().enumerate() {
                    objects[way] += counts.objects.visible;
                    lights[way] += counts.lights.visible;
                }
            }
        }
        println!("objects {objects:?} and lights {lights:?}, without and with culling");
        assert!(objects[1] * 2 < objects[0] && lights[1] < lights[0], "next to nothing was culled");
    });
}

#[test]
fn output_formats_hold_the_same_picture() {
    /// Steps of 8 bits between what a driver encodes as sRGB and the exact encoding of the float picture: Vulkan lets
    /// it round to either neighbour.
    const ENCODING_STEPS: u8 = 1;
    on_device(None, |gpu| {
        for scene in scenes::built() {
            let picture = |output| {
                let options = Options { size: SIZE, output, ..Options::default() };
                gpu.picture(&scene, gpu.plan(&scene, options), 0.0)
            };
            let rgba = picture(OutputFormat::Rgba8Srgb);
            assert_eq!(difference(&rgba, &picture(OutputFormat::Bgra8Srgb)), None, "{}", scene.name);
            let encoded = picture(OutputFormat::Rgba32Float).to_srgb8();
            let [Pixels::Rgba8(a), Pixels::Rgba8(b)] = [&rgba.pixels, &encoded.pixels] else {
                unreachable!()
            };
            let most = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(most <= Some(ENCODING_STEPS), "{}: {most:?} steps", scene.name);
        }
    });
}

#[test]
fn what_adds_nothing_changes_nothing() {
    on_device(None, |gpu| {
        let same = [
            (scenes::nothing(), scenes::empty_mesh()),
            (scenes::lights_only(), scenes::one_empty_mesh()),
            (scenes::no_lights(), scenes::dark_lights()),
        ];
        for (layout, output) in every(&LAYOUTS, OutputFormat::ALL) {
            let options = Options { size: SIZE, layout, output, ..Options::default() };
            let picture = |scene: &Scene| gpu.picture(scene, gpu.plan(scene, options.clone()), 0.0);
            for (without, with) in &same {
                assert_eq!(difference(&picture(without), &picture(with)), None, "{}, {options:?}", with.name);
            }
        }
    });
}

#[test]
fn a_scene_of_nothing_is_black() {
    on_device(None, |gpu| {
        let scene = scenes::nothing();
        let options = Options { size: SIZE, ..Options::default() };
        let Pixels::Rgba8(channels) = gpu.picture(&scene, gpu.plan(&scene, options), 0.0).pixels else {
            unreachable!()
        };
        assert!(channels.chunks(4).all(|pixel| pixel == [0, 0, 0, 255]));
    });
}

#[test]
fn a_plan_for_another_scene_is_refused() {
    on_device(None, |gpu| {
        let plan = gpu.plan(&scenes::lights_only(), Options { size: SIZE, ..Options::default() });
        let scene = scenes::every_feature();
        let made = Renderer::new(gpu.device(), &scene, plan, RendererConfig::default(), gpu.cache());
        let error = made.err().expect("no pipeline of the plan draws this scene").to_string();
        assert!(error.contains("every_feature"), "{error}");
    });
}

#[test]
fn a_target_of_another_renderer_is_refused() {
    on_device(None, |gpu| {
        let scene = scenes::lights_only();
        let plan = gpu.plan(&scene, Options { size: SIZE, ..Options::default() });
        let config = RendererConfig::default();
        let make = || Renderer::new(gpu.device(), &scene, plan.clone(), config, gpu.cache()).unwrap();
        let [mut one, other] = [make(), make()];
        let target = other.create_target(SIZE, &[]).unwrap();
        let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
        let recorded = Commands::run(gpu.device(), "frame", |recorder| {
            let record = AssertUnwindSafe(|| one.record(recorder, 0, &target, 0, &view));
            Ok(catch_unwind(record).unwrap_err())
        });
        let panic = recorded.unwrap();
        assert!(panic.downcast_ref::<&str>().is_some_and(|text| text.contains("another renderer")));
    });
}

/// Renders one frame a slot, all on the GPU at once, each with an exposure of its own.
fn pictures_in_flight(gpu: &Gpu<'_>, scene: &Scene, plan: Plan, exposures_ev: &[f32]) -> Vec<Picture> {
    let config = RendererConfig { frames_in_flight: exposures_ev.len(), ..RendererConfig::default() };
    let device = gpu.device();
    let mut renderer = Renderer::new(device, scene, plan, config, gpu.cache()).unwrap();
    Commands::run(device, "upload", |recorder| {
        renderer.record_upload(recorder);
        Ok(())
    })
    .unwrap();
    renderer.finish_upload();
    let size = renderer.plan().options.size;
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
        | vk::ImageUsageFlags::INPUT_ATTACHMENT
        | vk::ImageUsageFlags::TRANSFER_SRC;
    let format = vk::Format::R8G8B8A8_SRGB;
    let image = |_| Image::new(device, &ImageDesc::new("output", format, size, usage)).unwrap();
    let images: Vec<_> = exposures_ev.iter().map(image).collect();
    let outputs: Vec<_> = images.iter().map(|i| OutputImage { image: i.raw(), view: i.view() }).collect();
    let target = renderer.create_target(size, &outputs).unwrap();

    let frame = |(slot, &exposure_ev)| {
        let readback = Readback::new(device, format, size).unwrap();
        let mut commands = Commands::new(device, "frame").unwrap();
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        commands
            .record(|recorder| {
                let view = View { camera: &scene.cameras[0], exposure_ev };
                renderer.record(recorder, slot, &target, slot, &view);
                readback.record(recorder, &images[slot], 0, layout, layout)
            })
            .unwrap();
        (commands, readback)
    };
    let mut frames: Vec<_> = exposures_ev.iter().enumerate().map(frame).collect();
    frames.iter_mut().for_each(|(commands, _)| commands.submit().unwrap());
    frames.iter_mut().for_each(|(commands, _)| commands.wait().unwrap());
    let picture = |(_, readback): &(Commands, Readback)| Picture {
        width: size[0],
        height: size[1],
        pixels: Pixels::Rgba8(readback.texels().to_vec()),
    };
    frames.iter().map(picture).collect()
}

#[test]
fn frames_in_flight_are_independent() {
    const EXPOSURES_EV: [f32; 3] = [0.0, -1.5, 1.0];
    on_device(None, |gpu| {
        let scene = scenes::every_feature();
        for (layout, strategy) in every(&LAYOUTS, &Strategy::EVERYWHERE) {
            let plan = gpu.plan(&scene, Options { size: SIZE, layout, strategy, ..Options::default() });
            let alone = EXPOSURES_EV.map(|ev| gpu.picture(&scene, plan.clone(), ev));
            let in_flight = pictures_in_flight(gpu, &scene, plan, &EXPOSURES_EV);
            for (slot, picture) in in_flight.iter().enumerate() {
                for (other, expected) in alone.iter().enumerate() {
                    // A slot that took another's exposure would show that one's picture.
                    let same = difference(expected, picture).is_none();
                    assert_eq!(
                        same,
                        slot == other,
                        "{layout}, {strategy}: slot {slot} against frame {other}"
                    );
                }
            }
        }
    });
}

#[test]
fn a_frame_leaves_nothing_to_the_next() {
    on_device(None, |gpu| {
        let scene = scenes::every_feature();
        for (layout, strategy) in every(&LAYOUTS, &Strategy::EVERYWHERE) {
            let plan = gpu.plan(&scene, Options { size: SIZE, layout, strategy, ..Options::default() });
            let mut offscreen = gpu.offscreen(&scene, plan, RendererConfig::default());
            let mut turned = scene.cameras[0].clone();
            turned.world_from_view *= ontile::glam::Mat4::from_rotation_z(0.5);
            let mut render = |camera| {
                offscreen.render(&View { camera, exposure_ev: 0.0 }).unwrap();
                offscreen.picture()
            };
            let first = render(&scene.cameras[0]);
            assert!(difference(&first, &render(&turned)).is_some(), "the camera does not matter");
            assert_eq!(difference(&first, &render(&scene.cameras[0])), None, "{layout}, {strategy}");
        }
    });
}

/// A mistake in a plan that the comparison must see.
type Fault = (&'static str, Strategy, fn(&mut Plan));

const FAULTS: [Fault; 6] = [
    ("input attachments swapped in one pass", Strategy::Subpasses, |plan| swap_inputs(plan)),
    ("input attachments swapped in separate passes", Strategy::Separate, |plan| swap_inputs(plan)),
    ("G-buffer cleared instead of loaded", Strategy::Separate, |plan| clear_loaded(plan, "normal_roughness")),
    ("light cleared instead of loaded", Strategy::Separate, |plan| clear_loaded(plan, "light")),
    ("two live resources in one attachment", Strategy::Subpasses, |plan| {
        let lighting = &mut stage(plan, "lighting").inputs;
        lighting[2] = lighting[1];
    }),
    ("light replaced instead of added to", Strategy::Subpasses, |plan| stage(plan, "lighting").blend = false),
];

fn stage<'a>(plan: &'a mut Plan, name: &str) -> &'a mut ontile::plan::Subpass {
    plan.passes.iter_mut().flat_map(|p| &mut p.subpasses).find(|s| s.name == name).expect("the stage exists")
}

fn swap_inputs(plan: &mut Plan) {
    stage(plan, "lighting").inputs.swap(1, 2);
}

fn clear_loaded(plan: &mut Plan, name: &str) {
    let index = plan.attachments.iter().position(|a| a.name == name).expect("the attachment exists");
    let mut uses = plan.passes.iter_mut().flat_map(|p| &mut p.attachments);
    uses.find(|a| a.attachment == index && a.load == Load::Load).expect("it is loaded").load = Load::Clear;
}

#[test]
fn a_wrong_arrangement_is_seen() {
    on_device_with_faults(|gpu| {
        let scene = scenes::every_feature();
        for (layout, (name, strategy, fault)) in every(&LAYOUTS, &FAULTS) {
            let options = Options { size: SIZE, layout, ..Options::default() };
            let expected = gpu.picture(&scene, gpu.plan(&scene, options.clone()), 0.0);
            let mut plan = gpu.plan(&scene, Options { strategy, ..options });
            assert_eq!(difference(&expected, &gpu.picture(&scene, plan.clone(), 0.0)), None, "sound: {name}");
            fault(&mut plan);
            assert!(
                difference(&expected, &gpu.picture(&scene, plan, 0.0)).is_some(),
                "{layout}: not seen: {name}"
            );
        }
    });
}

//! What bends and moves from frame to frame: a renderer that goes along draws what a new one draws.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes::moving_scenes::{bending, bending_mapped, frozen, moved, with_lamps_alone, with_sparks};
use common::scenes::sample_files;
use ontile::glam::Mat4;
use ontile::glam::camera::rh::view::look_at_mat4;
use ontile::gpu::{Offscreen, RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Layout, Needs, Options, Path, Strategy};
use ontile::scene::{Camera, Play, Projection, Scene};

const SIZE: [u32; 2] = [192, 108];

fn small() -> Options {
    Options { size: SIZE, ..Options::default() }
}

fn frame(offscreen: &mut Offscreen, camera: &Camera) -> Picture {
    offscreen.render(&View { camera, exposure_ev: 0.0 }).unwrap();
    offscreen.picture()
}

/// Brings a renderer to where the scene is.
fn follow(offscreen: &mut Offscreen, scene: &Scene) {
    let renderer = offscreen.renderer_mut();
    for (index, instance) in scene.instances.iter().enumerate() {
        renderer.set_instance(index, &instance.world_from_object).unwrap();
    }
    for (index, mesh) in scene.meshes.iter().enumerate() {
        let poses = mesh.deformation.iter().map(|deformation| &deformation.pose);
        poses.for_each(|pose| renderer.set_pose(index, pose).unwrap());
    }
    for (index, light) in scene.lights.iter().enumerate() {
        renderer.set_light(index, light).unwrap();
    }
    for (index, particles) in scene.particles.iter().enumerate() {
        renderer.set_particles(index, &particles.list).unwrap();
    }
}

/// Shadows by maps and by volumes, on every path and in every strategy; maps of what stands still stay.
#[test]
fn frames_that_follow_are_those_of_a_new_renderer() {
    const TIMES_S: [f64; 5] = [0.0, 0.7, 1.3, 1.3, 0.2];
    on_device(None, |gpu| {
        let ways = [
            ("maps", with_lamps_alone(bending()), small()),
            ("volumes", bending(), Options { shadow_volumes: true, ..small() }),
            ("normal maps, glass", with_lamps_alone(bending_mapped()), small()),
            ("sparks", with_sparks(with_lamps_alone(bending())), small()),
            (
                "forward",
                with_lamps_alone(bending()),
                Options { path: Path::Forward, depth_prepass: true, ..small() },
            ),
            (
                "separate",
                with_lamps_alone(bending_mapped()),
                Options { strategy: Strategy::Separate, samples: 4, ..small() },
            ),
        ];
        for (what, scene, options) in ways {
            let plan = gpu.plan(&scene, options.clone());
            let mut offscreen = gpu.offscreen(&scene, plan, RendererConfig::default());
            let mut before: Option<Picture> = None;
            for (index, time) in TIMES_S.into_iter().enumerate() {
                let now = moved(scene.clone(), time);
                follow(&mut offscreen, &now);
                let drawn = frame(&mut offscreen, &now.cameras[0]);
                let new = gpu.picture(&now, gpu.plan(&now, options.clone()), 0.0);
                assert_eq!(difference(&drawn, &new), None, "{what}, {time} s");
                let shadows = offscreen.renderer().recorded().shadows;
                assert!(index == 0 || shadows.static_tiles == 0, "{what}, {time} s: {shadows:?}");
                let same = before.is_some_and(|before| difference(&before, &drawn).is_none());
                assert_eq!(same, index == 3, "{what}, {time} s: nothing moves, or what stands does");
                before = Some(drawn);
            }
        }
    });
}

/// A picture's 8-bit colours.
fn colors(picture: &Picture) -> &[u8] {
    match &picture.pixels {
        Pixels::Rgba8(colors) => colors,
        Pixels::Rgba32F(_) => panic!("the output has 8 bits a channel"),
    }
}

/// The share of channels that are more than a step of 8 bits of light apart.
fn unlike(a: &Picture, b: &Picture) -> f64 {
    const STEPS: u8 = 8;
    let pairs = colors(a).iter().zip(colors(b));
    let unlike = pairs.clone().filter(|(a, b)| a.abs_diff(**b) > STEPS).count();
    unlike as f64 / pairs.len() as f64
}

/// The GPU poses as the CPU does: at most outlines, where rounding decides, are other pixels.
const OUTLINES: f64 = 2e-3;

#[test]
fn poses_are_those_of_the_cpu() {
    on_device(None, |gpu| {
        for scene in [moved(bending(), 0.8), moved(bending_mapped(), 1.4)] {
            let bent = gpu.picture(&scene, gpu.plan(&scene, small()), 0.0);
            let still = frozen(scene.clone());
            assert!(Needs::of(&scene).posed.is_some() && Needs::of(&still).posed.is_none());
            let still = gpu.picture(&still, gpu.plan(&still, small()), 0.0);
            let apart = unlike(&bent, &still);
            println!("{}: {apart:.5} of the channels", scene.name);
            assert!(apart < OUTLINES, "{}: {apart}", scene.name);
        }
    });
}

#[test]
fn sample_models_move() {
    let files = sample_files();
    on_device(None, |gpu| {
        let mut animated = 0;
        for file in files {
            let scene = Scene::load_moving(&file).unwrap();
            let still = Scene::load(&file).unwrap();
            let Some(motion) = &scene.motion else {
                assert_eq!(Needs::of(&scene), Needs::of(&still), "{}: nothing moves", scene.name);
                continue;
            };
            animated += 1;
            for animation in 0..motion.animations.len() {
                let end = f64::from(motion.animations[animation].duration_s());
                for time_s in [0.0, 0.4 * end, end] {
                    let mut now = scene.clone();
                    now.animate(&[Play { animation, time_s }]).unwrap();
                    now.check().unwrap();
                    let bent = gpu.picture(&now, gpu.plan(&now, small()), 0.0);
                    let posed = frozen(now.clone());
                    let apart = unlike(&bent, &gpu.picture(&posed, gpu.plan(&posed, small()), 0.0));
                    println!("{}, animation {animation} at {time_s:.2} s: {apart:.5}", scene.name);
                    assert!(apart < OUTLINES, "{} at {time_s} s: {apart}", scene.name);
                }
            }
        }
        println!("{animated} sample models move");
    });
}

/// Looks past each place that sticks out of what bends, from all sides, with views so narrow that everything else is out of sight.
fn close_views(scene: &Scene) -> Vec<Camera> {
    let mut cameras = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        let Some(center) = mesh.bounds().filter(|_| mesh.deformation.is_some()).map(|b| b.center()) else {
            continue;
        };
        let posed = mesh.posed();
        for axis in [0, 1, 2] {
            for sign in [-1.0, 1.0] {
                let reach = |p: &&ontile::glam::Vec3| sign * (p[axis] - center[axis]);
                let tip = posed.positions.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))).unwrap();
                let at = instance.world_from_object.transform_point3(*tip);
                let eye = at + ontile::glam::Vec3::new(0.9, 1.2, 2.0);
                let world_from_view = look_at_mat4(eye, at, ontile::glam::Vec3::Y).inverse();
                let projection = Projection::Perspective { yfov_rad: 0.03, znear_m: 0.1, zfar_m: None };
                cameras.push(Camera { name: String::new(), world_from_view, projection });
            }
        }
    }
    cameras
}

#[test]
fn nothing_that_is_seen_is_culled() {
    on_device(None, |gpu| {
        let scene = with_lamps_alone(bending());
        let options = Options { layout: Layout::Packed128, size: [48, 27], ..Options::default() };
        let plan = gpu.plan(&scene, options);
        let all = RendererConfig { cull: false, ..RendererConfig::default() };
        let mut whole = gpu.offscreen(&scene, plan.clone(), all);
        let mut culled = gpu.offscreen(&scene, plan, RendererConfig::default());
        let (mut left_out, mut views) = (0, 0);
        for time in [0.3, 1.0, 1.7] {
            let now = moved(scene.clone(), time);
            follow(&mut whole, &now);
            follow(&mut culled, &now);
            for camera in close_views(&now) {
                let pictures = [&mut whole, &mut culled].map(|offscreen| frame(offscreen, &camera));
                assert_eq!(difference(&pictures[0], &pictures[1]), None, "at {time} s");
                let objects = culled.renderer().recorded().counts.objects;
                left_out += objects.culled;
                views += 1;
            }
        }
        assert!(left_out > views, "next to nothing is out of sight");
    });
}

/// Bounds hold what is posed, and are of use.
#[test]
fn bounds_hold_what_is_posed() {
    for time in 0..40 {
        let scene = moved(bending(), f64::from(time) * 0.05);
        for mesh in scene.meshes.iter().filter(|mesh| mesh.deformation.is_some()) {
            let (bounds, posed) = (mesh.bounds().unwrap(), mesh.posed());
            let tight = posed.bounds().unwrap();
            assert!(bounds.min.cmple(tight.min).all() && bounds.max.cmpge(tight.max).all(), "{}", mesh.name);
            assert!(bounds.radius() < 2.5 * tight.radius(), "{}: {bounds:?} around {tight:?}", mesh.name);
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    on_device(None, |gpu: &Gpu<'_>| {
        let mut scene = bending();
        let mut offscreen = gpu.offscreen(&scene, gpu.plan(&scene, small()), RendererConfig::default());
        let pose = scene.meshes[1].deformation.as_ref().unwrap().pose.clone();
        let mut fewer = pose.clone();
        fewer.object_from_bind.pop();
        let mut infinite = pose.clone();
        infinite.object_from_bind[1] = Mat4::from_scale(ontile::glam::Vec3::INFINITY);
        for bad in [&fewer, &infinite] {
            let error = offscreen.renderer_mut().set_pose(1, bad).unwrap_err().to_string();
            assert!(error.contains("3 joints"), "{error}");
        }
        scene.meshes[1].deformation.as_mut().unwrap().influences[6].joints[0] = 3;
        let error = scene.check().unwrap_err().to_string();
        assert!(error.contains("uses joint 3, and there are 3"), "{error}");
    });
}

//! Objects and lights move between frames, while earlier ones are on the GPU.

use super::common::scenes::moving_scenes::bending;
use super::*;
use ontile::gpu::Updated;
use ontile::scene::{Play, World};
use std::f32::consts::PI;

/// One square turns and leaves, the other comes along; both stay seen from the front.
fn placements(time: f32) -> [Mat4; 2] {
    let turned = Mat4::from_rotation_z(time) * Mat4::from_scale(Vec3::splat(0.5 + 0.3 * time.sin()));
    [
        Mat4::from_translation(vec3(3.0 * time.sin(), 0.0, 0.0)) * turned,
        Mat4::from_translation(vec3(time.sin(), time.cos(), 0.1)),
    ]
}

/// It goes round, and out once a turn. It lights a small part of the view.
fn light(light: &Light, time: f32) -> Light {
    Light {
        position_world: vec3(time.sin(), time.cos(), 0.7),
        kind: LightKind::Point { intensity_cd: (2.0 + 3.0 * time.cos()).max(0.0) },
        range_m: Some(0.9 + 0.3 * time.sin()),
        ..light.clone()
    }
}

fn at(scene: &Scene, time: f32) -> Scene {
    let mut moved = scene.clone();
    let instances = moved.instances.iter_mut().zip(placements(time));
    instances.for_each(|(instance, world_from_object)| instance.world_from_object = world_from_object);
    moved.lights[0] = light(&scene.lights[0], time);
    moved
}

fn move_to(renderer: &mut Renderer, scene: &Scene, time: f32) {
    for (index, world_from_object) in placements(time).iter().enumerate() {
        renderer.set_instance(index, world_from_object).unwrap();
    }
    renderer.set_light(0, &light(&scene.lights[0], time)).unwrap();
}

/// Everything out of sight, so that nothing of it can be left over in a later frame.
fn away(scene: &Scene) -> Scene {
    let far = vec3(0.0, 500.0, 0.0);
    let mut away = scene.clone();
    away.instances.iter_mut().for_each(|i| i.world_from_object = Mat4::from_translation(far));
    away.lights[0] = Light { position_world: far, range_m: Some(0.1), ..scene.lights[0].clone() };
    away
}

#[test]
fn moved_objects_and_lights_are_drawn_where_they_are() {
    const TIMES: [f32; 5] = [0.0, 0.6, 1.4, PI, 5.0];
    for options in methods() {
        let Some(mut engine) = engine() else { return };
        let (device, _) = engine.lend(false);
        let mut scene = scene(vec3(0.8, 0.4, 0.2));
        scene.instances[1].dynamic = true;
        let mut renderer = renderer(&device, &away(&scene), &options);
        upload(&engine, &device, &mut renderer);
        let size = SIZES[0];
        let bytes = u64::from(size[0] * size[1] * 4);
        let images = images(&mut engine, &renderer, size, 1);
        let target = renderer.create_target(size, &outputs(&images)).unwrap();
        let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
        for (frame, &time) in TIMES.iter().enumerate() {
            let slot = frame % FRAMES_IN_FLIGHT;
            engine.submit(slot, |buffer| {
                move_to(&mut renderer, &scene, time);
                renderer.record(&recorder(&device, buffer), slot, &target, 0, &view);
                engine.copy(buffer, images[0], renderer.output_layout(), frame as u64 * bytes);
            });
        }
        engine.wait();
        let scenes = TIMES.map(|time| at(&scene, time));
        let pictures = expected(&options, &scenes.each_ref().map(|scene| (scene, size, 0.0)));
        assert_ne!(pictures[0], pictures[1], "movement must show, or this test sees nothing");
        for (frame, wanted) in pictures.iter().enumerate() {
            let actual = engine.read(frame as u64 * bytes, wanted.len());
            let Options { path, lights, .. } = options;
            assert_equal(&actual, wanted, &format!("{path}, {lights}, time {}", TIMES[frame]));
        }
        assert_eq!(renderer.static_moves(), TIMES.len() as u64, "of two instances one is dynamic");
        drop((target, renderer));
        assert_eq!(device.live(), Live::default(), "objects are left");
        drop(device);
        assert_eq!(engine.finish(false), Vec::<String>::new());
    }
}

#[test]
fn ten_thousand_frames_of_movement_grow_nothing() {
    const FRAMES: usize = 10_000;
    const SIZE: [u32; 2] = [8, 8];
    let Some(mut engine) = engine() else { return };
    let (device, _) = engine.lend(false);
    let scene = scene(Vec3::ONE);
    let mut renderer = renderer(&device, &scene, &Options::default());
    upload(&engine, &device, &mut renderer);
    let images = images(&mut engine, &renderer, SIZE, 1);
    let target = renderer.create_target(SIZE, &outputs(&images)).unwrap();
    let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
    let lights: Vec<_> = (0..100).map(|i| light(&scene.lights[0], i as f32 * 0.1)).collect();
    let live = device.live();
    let (mut allocations, mut objects) = (0, 0);
    for frame in 0..FRAMES {
        let slot = frame % FRAMES_IN_FLIGHT;
        engine.submit(slot, |buffer| {
            let recorder = recorder(&device, buffer);
            let counted = allocation_counter::measure(|| {
                for (index, world_from_object) in placements(frame as f32 * 0.1).iter().enumerate() {
                    renderer.set_instance(index, world_from_object).unwrap();
                }
                renderer.set_light(0, &lights[frame % lights.len()]).unwrap();
                renderer.record(&recorder, slot, &target, 0, &view);
            });
            allocations += if frame == 0 { 0 } else { counted.count_total };
        });
        objects += renderer.recorded().counts.objects.visible;
    }
    engine.wait();
    assert_eq!(allocations, 0);
    assert_eq!(device.live(), live);
    assert!((1..2 * FRAMES).contains(&objects), "objects must come and go");
    drop((target, renderer, device));
    assert_eq!(engine.finish(false), Vec::<String>::new());
}

/// Of joints, morph targets, nodes, a light with its shadow and a camera, in a world.
#[test]
fn ten_thousand_frames_of_animation_grow_nothing() {
    const FRAMES: usize = 10_000;
    /// All lists have grown then.
    const FIRST: usize = 4;
    const SIZE: [u32; 2] = [8, 8];
    let Some(mut engine) = engine() else { return };
    let (device, _) = engine.lend(false);
    let scene = bending();
    let mut renderer = renderer(&device, &scene, &Options::default());
    upload(&engine, &device, &mut renderer);
    let images = images(&mut engine, &renderer, SIZE, 1);
    let target = renderer.create_target(SIZE, &outputs(&images)).unwrap();
    let mut world = World::from(scene);
    let (mut allocations, mut live) = (0, device.live());
    for frame in 0..FRAMES {
        let slot = frame % FRAMES_IN_FLIGHT;
        engine.submit(slot, |buffer| {
            let recorder = recorder(&device, buffer);
            let counted = allocation_counter::measure(|| {
                let time_s = (frame as f64 * 0.013) % 2.0;
                world.animate(&[Play { animation: 0, time_s }]).unwrap();
                assert_eq!(renderer.update(&world, &recorder).unwrap(), Updated::default());
                world.clear_changes();
                let view = View { camera: &world.scene().cameras[0], exposure_ev: 0.0 };
                renderer.record(&recorder, slot, &target, 0, &view);
            });
            allocations += if frame < FIRST { 0 } else { counted.count_total };
        });
        if frame == FIRST {
            live = device.live();
        }
    }
    engine.wait();
    assert_eq!(allocations, 0);
    assert_eq!(device.live(), live);
    drop((target, renderer, device));
    assert_eq!(engine.finish(false), Vec::<String>::new());
}

#[test]
fn what_the_plan_does_not_know_is_refused() {
    let Some(engine) = engine() else { return };
    let (device, _) = engine.lend(false);
    let scene = scene(Vec3::ONE);
    let mut renderer = renderer(&device, &scene, &Options::default());
    let matrices = [
        (2, Mat4::IDENTITY, "below 2"),
        (0, Mat4::from_scale(vec3(-1.0, 1.0, 1.0)), "mirrored"),
        (0, Mat4::from_translation(vec3(f32::NAN, 0.0, 0.0)), "finite"),
        (0, scene.cameras[0].projection.clip_from_view(1.0), "last row"),
    ];
    for (index, matrix, what) in matrices {
        let error = renderer.set_instance(index, &matrix).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
    let known = &scene.lights[0];
    let point = |intensity_cd| LightKind::Point { intensity_cd };
    let spot = LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.1, outer_cone_rad: 0.2 };
    let lights = [
        (1, known.clone(), "below 1"),
        (0, Light { kind: spot, ..known.clone() }, "a plan and a renderer"),
        (0, Light { position_world: Vec3::splat(f32::INFINITY), ..known.clone() }, "finite"),
        (0, Light { kind: point(f32::NAN), ..known.clone() }, "finite"),
        (0, Light { kind: point(-1.0), ..known.clone() }, "negative"),
    ];
    for (index, light, what) in lights {
        let error = renderer.set_light(index, &light).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
    drop((renderer, device));
    assert_eq!(engine.finish(false), Vec::<String>::new());
}

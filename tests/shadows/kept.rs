//! What was drawn is kept until it changes, and changes no more than it must.

use crate::common::render::{difference, on_device};
use crate::common::scenes::shadow_scenes::{one_light_each, shadows};
use crate::{BALL, offscreen, options, render, taken, three_lights};
use ontile::glam::{Mat4, Vec3};
use ontile::gpu::{Offscreen, RecordedShadows, RendererConfig};
use ontile::plan::{Options, ShadowFilter, ShadowFormat, ShadowOptions};
use ontile::scene::{Light, LightKind};

#[test]
fn maps_are_kept_until_what_they_show_changes() {
    on_device(None, |gpu| {
        let scene = three_lights();
        let mut offscreen = offscreen(gpu, &scene, RendererConfig::default());
        let mut camera = scene.cameras[0].clone();
        let first = render(&mut offscreen, &camera);
        let map = offscreen.renderer().plan().shadow_map.clone().unwrap();
        let all = taken(&offscreen);
        let cascades = map.lights.iter().find(|l| l.name == "sun").unwrap().tiles.len();
        // A cascade may be of no use.
        let used = all.tiles - 1 - 6;
        assert!((1..=cascades).contains(&used), "{all:?}");
        assert!(all.draws >= all.tiles && all.casters >= all.draws && all.waiting == 0, "{all:?}");

        // The same again, and closer by less than a texel: nothing is drawn.
        assert_eq!(difference(&first, &render(&mut offscreen, &camera)), None);
        assert_eq!(taken(&offscreen), RecordedShadows::default());
        for _ in 0..4 {
            camera.world_from_view *= Mat4::from_translation(Vec3::new(1e-4, -1e-4, 2e-4));
            render(&mut offscreen, &camera);
            assert_eq!(taken(&offscreen), RecordedShadows::default());
        }
        // A long way: cascades only, and not the one that holds everything.
        camera.world_from_view *= Mat4::from_translation(Vec3::new(0.5, 0.0, -1.5));
        render(&mut offscreen, &camera);
        assert!(taken(&offscreen).tiles <= used, "{:?}", taken(&offscreen));
        render(&mut offscreen, &scene.cameras[0]);

        // A light that moves has its tiles drawn again, one that changes in strength has not.
        let index = |name: &str| scene.lights.iter().position(|l| l.name == name).unwrap();
        let mut bulb = scene.lights[index("bulb")].clone();
        bulb.color *= 0.5;
        offscreen.renderer_mut().set_light(index("bulb"), &bulb).unwrap();
        render(&mut offscreen, &scene.cameras[0]);
        assert_eq!(taken(&offscreen).tiles, 0);
        bulb.position_world.x += 0.1;
        offscreen.renderer_mut().set_light(index("bulb"), &bulb).unwrap();
        render(&mut offscreen, &scene.cameras[0]);
        assert_eq!(taken(&offscreen).tiles, 6);
        let spot = Light { direction_world: Vec3::NEG_Y, ..scene.lights[index("spot")].clone() };
        offscreen.renderer_mut().set_light(index("spot"), &spot).unwrap();
        render(&mut offscreen, &scene.cameras[0]);
        assert_eq!(taken(&offscreen).tiles, 1);
        // Without a shadow a light needs no map.
        let mut lit = spot.clone();
        lit.shadow = None;
        offscreen.renderer_mut().set_light(index("spot"), &lit).unwrap();
        render(&mut offscreen, &scene.cameras[0]);
        assert_eq!(taken(&offscreen).tiles, 0);
        // A cone too wide for its one view would need others.
        let kind = LightKind::Spot { intensity_cd: 30.0, inner_cone_rad: 0.1, outer_cone_rad: 1.5 };
        let error = offscreen.renderer_mut().set_light(index("spot"), &Light { kind, ..spot }).unwrap_err();
        assert!(error.to_string().contains("spot"), "{error}");
    });
}

#[test]
fn what_moved_casts_the_shadow_of_a_scene_made_so() {
    on_device(None, |gpu| {
        for fresh in one_light_each() {
            let mut moved = fresh.clone();
            let place =
                Mat4::from_translation(Vec3::new(0.4, 0.3, 0.5)) * fresh.instances[BALL].world_from_object;
            let mut there = offscreen(gpu, &moved, RendererConfig::default());
            let before = render(&mut there, &fresh.cameras[0]);
            there.renderer_mut().set_instance(BALL, &place).unwrap();
            let after = render(&mut there, &fresh.cameras[0]);
            assert!(taken(&there).tiles > 0);
            moved.instances[BALL].world_from_object = place;
            let expected = render(&mut offscreen(gpu, &moved, RendererConfig::default()), &moved.cameras[0]);
            assert!(difference(&before, &after).is_some(), "{}: the move is not seen", fresh.name);
            assert_eq!(difference(&expected, &after), None, "{}", fresh.name);
        }
    });
}

/// Tiles that are composed of what stands still and what moves are, bit for bit, those that are drawn whole.
#[test]
fn what_moves_is_drawn_over_what_stands_still() {
    on_device(None, |gpu| {
        for still in one_light_each() {
            let name = still.name.clone();
            let camera = &still.cameras[0];
            let mut moving = still.clone();
            moving.instances[BALL].dynamic = true;
            let [mut composed, mut whole] =
                [&moving, &still].map(|scene| offscreen(gpu, scene, RendererConfig::default()));
            let map = |offscreen: &Offscreen| offscreen.renderer().plan().shadow_map.clone().unwrap();
            assert_eq!(map(&composed).bytes(), 2 * map(&whole).bytes(), "{name}: one more map");
            let mut pictures = Vec::new();
            // Out of sight and back at last.
            for (step, x) in [0.0, 0.4, 0.45, -0.8, 30.0, 0.2].into_iter().enumerate() {
                let shift = Mat4::from_translation(Vec3::new(x, 0.3 * x.abs(), 0.5 * x));
                let place = shift * still.instances[BALL].world_from_object;
                let [a, b] = [&mut composed, &mut whole].map(|offscreen| {
                    offscreen.renderer_mut().set_instance(BALL, &place).unwrap();
                    render(offscreen, camera)
                });
                assert_eq!(difference(&a, &b), None, "{name}: step {step}");
                pictures.push(a);
                let [a, b] = [&composed, &whole].map(taken);
                println!("{name}, step {step}: {a:?}, whole {b:?}");
                assert_eq!((a.tiles, b.composed + b.static_tiles), (b.tiles, 0), "{name}: step {step}");
                match step {
                    // Nothing has stood still yet.
                    0 => assert_eq!(a, b, "{name}"),
                    // A cascade has to be deeper for what is far away.
                    4 if name == "sun" => assert_eq!(a.composed, 0),
                    4 | 5 => {}
                    _ => {
                        assert!(a.tiles > 0 && a.composed == a.tiles, "{name}: {a:?}");
                        assert_eq!(a.static_tiles > 0, step == 1, "{name}: {a:?}");
                    }
                }
                if (2..4).contains(&step) {
                    assert_eq!(a.casters + a.culled, a.tiles, "{name}: one ball each, at most");
                    // The ball's box is around the bulb, and so in every part of every face.
                    assert!(name == "bulb" || a.stored_bytes < b.stored_bytes / 2, "{name}: {a:?}, {b:?}");
                    assert!(
                        a.copied_bytes == a.stored_bytes && a.casters < b.casters,
                        "{name}: {a:?}, {b:?}"
                    );
                }
            }
            assert!(difference(&pictures[1], &pictures[3]).is_some(), "{name}: the move is not seen");
        }
    });
}

#[test]
fn tiles_wait_for_their_frame() {
    on_device(None, |gpu| {
        let scene = three_lights();
        let config = RendererConfig { shadow_tiles_per_frame: 2, ..RendererConfig::default() };
        let [mut slow, mut fast] = [config, RendererConfig::default()].map(|c| offscreen(gpu, &scene, c));
        // Nothing to show yet: the first frame is whole.
        let camera = &scene.cameras[0];
        assert_eq!(difference(&render(&mut slow, camera), &render(&mut fast, camera)), None);
        let place = Mat4::from_translation(Vec3::Y * 0.3) * scene.instances[BALL].world_from_object;
        for renderer in [&mut slow, &mut fast] {
            renderer.renderer_mut().set_instance(BALL, &place).unwrap();
        }
        let expected = render(&mut fast, camera);
        let all = taken(&fast).tiles;
        assert!(all > 4, "{all}");
        let mut drawn = 0;
        while drawn < all {
            let picture = render(&mut slow, camera);
            let RecordedShadows { tiles, waiting, .. } = taken(&slow);
            drawn += tiles;
            assert_eq!((tiles, waiting), (2.min(all + tiles - drawn), all - drawn));
            assert_eq!(difference(&expected, &picture).is_none(), waiting == 0, "{waiting} tiles wait");
        }
        render(&mut slow, camera);
        assert_eq!(taken(&slow), RecordedShadows::default());
    });
}

/// All filters and both formats under validation, with casters of all kinds; and half of them move.
#[test]
fn every_choice_is_valid() {
    on_device(None, |gpu| {
        let still = shadows();
        let mut moving = still.clone();
        moving.instances.iter_mut().step_by(2).for_each(|instance| instance.dynamic = true);
        for &filter in ShadowFilter::ALL {
            for &format in ShadowFormat::ALL {
                let shadows = ShadowOptions { filter, format, most_texels: 1024, ..ShadowOptions::default() };
                let options = Options { shadows, ..options(filter) };
                let [whole, composed] = [&still, &moving].map(|scene| {
                    let plan = gpu.plan(scene, options.clone());
                    let mut offscreen = gpu.offscreen(scene, plan, RendererConfig::default());
                    render(&mut offscreen, &scene.cameras[0]);
                    for (index, instance) in scene.instances.iter().enumerate().step_by(2) {
                        let place = Mat4::from_translation(Vec3::Y * 0.1) * instance.world_from_object;
                        offscreen.renderer_mut().set_instance(index, &place).unwrap();
                    }
                    (render(&mut offscreen, &scene.cameras[0]), taken(&offscreen).composed)
                });
                assert_eq!(difference(&whole.0, &composed.0), None, "{filter}, {format}");
                assert!(composed.1 > 0 && whole.1 == 0, "{filter}, {format}");
            }
        }
    });
}

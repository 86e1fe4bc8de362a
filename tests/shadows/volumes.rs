//! Shadows counted in the stencil: where rays say, to the pixel, wherever the camera and the light are, and however the frame is made.

use crate::common::render::{Gpu, difference, on_device};
use crate::common::scenes::shadow_scenes::{chosen, one_light_each, room, shadows};
use crate::rays::{Disagreement, expected, light_of};
use crate::{BALL, SIZE, options, three_lights};
use ontile::glam::{DVec3, Mat4, Vec3};
use ontile::plan::{Layout, LightWay, Limits, Needs, Options, Path, Plan, ShadowFilter, Store, Strategy};
use ontile::scene::{Light, LightKind, Projection, Scene, Shadow};
use std::collections::BTreeSet;

fn by_volumes() -> Options {
    Options { shadow_volumes: true, ..options(ShadowFilter::Hardware) }
}

/// All pixels that differ, those at edges too.
fn disagreement(gpu: &Gpu<'_>, scene: &Scene, options: Options) -> Disagreement {
    Disagreement::new(&expected(scene), &light_of(&gpu.picture(scene, gpu.plan(scene, options), 0.0)), None)
}

/// Where surfaces end, rays and a rasteriser may see different ones; a shadow's own edge is not among what differs then.
const MOST_WRONG_OF_ALL: f64 = 0.004;

#[test]
fn volumes_fall_where_rays_say() {
    on_device(None, |gpu| {
        println!("light   wrong, volumes    wrong, map (hardware, 1024 texels)");
        for scene in one_light_each().into_iter().filter(|scene| scene.name != "slab") {
            let plan = gpu.plan(&scene, by_volumes());
            assert!(plan.shadow_map.is_none() && plan.volume_lights == [0], "{}", scene.name);
            let [volumes, map] = [by_volumes(), options(ShadowFilter::Hardware)]
                .map(|options| disagreement(gpu, &scene, options));
            let [exact, soft] = [&volumes, &map].map(|d| 100.0 * d.wrong_of_all);
            println!("{:<7} {exact:>12.4} %    {soft:>8.4} %", scene.name);
            assert!(volumes.shadowed > 0.02, "{}: the test sees nothing", scene.name);
            assert_eq!(volumes.wrong, 0.0, "{}: {volumes:?}", scene.name);
            assert!(volumes.wrong_of_all <= MOST_WRONG_OF_ALL, "{}: {volumes:?}", scene.name);
            assert!(volumes.wrong_of_all < 0.5 * map.wrong_of_all, "{}: {map:?}", scene.name);
        }
    });
}

/// A camera's place that looks from one point to another.
fn looking(from: Vec3, to: Vec3) -> Mat4 {
    let back = (from - to).normalize();
    let right = Vec3::Y.cross(back).normalize();
    let axes = [right, back.cross(right), back].map(|axis| axis.extend(0.0));
    Mat4::from_cols(axes[0], axes[1], axes[2], from.extend(1.0))
}

fn bulb_at(position_world: Vec3) -> Light {
    let light = Light::new(LightKind::Point { intensity_cd: 6.0 });
    Light { position_world, range_m: Some(9.0), shadow: Some(Shadow::default()), ..light }
}

/// Where counting goes wrong if anything does.
fn hard_cases() -> Vec<(&'static str, Scene)> {
    let lit_by = |light| Scene { lights: vec![light], ..room() };
    let sun = |towards| {
        let light = Light::new(LightKind::Directional { illuminance_lx: 2.0 });
        Light { shadow: Some(Shadow::default()), ..light.towards(towards) }
    };
    let mut cases = Vec::new();
    // The camera in the ball's shadow, in front of the light.
    let mut inside = lit_by(bulb_at(Vec3::new(-0.3, 2.2, 0.3)));
    inside.cameras[0].world_from_view = looking(Vec3::new(-0.3, 0.15, 0.3), Vec3::new(1.2, 0.3, -1.8));
    cases.push(("camera within a shadow", inside));
    // Seen from below the light, whose shadows come towards the camera and go past it.
    let mut against = lit_by(sun(Vec3::new(0.1, -0.2, 1.0)));
    against.cameras[0].world_from_view = looking(Vec3::new(0.4, 0.5, 3.0), Vec3::new(-0.2, 0.8, -1.0));
    cases.push(("shadows past the camera", against));
    cases.push(("a millimetre from a caster", lit_by(bulb_at(Vec3::new(-0.3, 1.301, 0.3)))));
    cases.push(("grazing", lit_by(sun(Vec3::new(-1.0, -0.02, 0.01)))));
    let mut far_plane = lit_by(sun(Vec3::new(-0.9, -1.0, -0.3)));
    if let Projection::Perspective { zfar_m, .. } = &mut far_plane.cameras[0].projection {
        *zfar_m = Some(9.0);
    }
    cases.push(("a near far plane", far_plane));
    // The wall, which is open, stands free: light from behind passes its back, and light from the front makes its shadow.
    let mut open = lit_by(sun(Vec3::new(0.2, -1.0, -0.6)));
    open.instances[BALL].world_from_object = Mat4::from_translation(Vec3::new(0.0, 0.5, 0.5))
        * Mat4::from_rotation_x(0.4)
        * Mat4::from_scale(Vec3::splat(0.4));
    open.instances[BALL].mesh = open.instances[0].mesh;
    cases.push(("an open caster", open.clone()));
    open.materials[0].double_sided = true;
    open.instances[BALL].world_from_object *= Mat4::from_rotation_x(2.6);
    cases.push(("a double-sided one from behind", open));
    let mut mirrored = lit_by(sun(Vec3::new(-0.9, -1.0, -0.3)));
    mirrored.instances[BALL].world_from_object *= Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    cases.push(("a mirrored one", mirrored));
    cases
}

#[test]
fn volumes_hold_where_counting_is_hard() {
    on_device(None, |gpu| {
        for (name, scene) in hard_cases() {
            let found = disagreement(gpu, &scene, by_volumes());
            println!("{name}: {found:?}");
            assert!(found.shadowed > 0.003, "{name}: the test sees nothing");
            assert_eq!(found.wrong, 0.0, "{name}: {found:?}");
            assert!(found.wrong_of_all <= 3.0 * MOST_WRONG_OF_ALL, "{name}: {found:?}");
        }
    });
}

/// Strategies, layouts, ways of other lights, and what moves.
#[test]
fn arrangements_do_not_change_volumes() {
    on_device(None, |gpu| {
        let limits = gpu.device().limits();
        let check = |scene: &Scene, options: Options| {
            let expected = gpu.picture(scene, gpu.plan(scene, options.clone()), 0.0);
            for variant in [
                Options { strategy: Strategy::Separate, ..options.clone() },
                Options { recycle: false, ..options.clone() },
                Options { depth_prepass: true, ..options.clone() },
            ] {
                let picture = gpu.picture(scene, gpu.plan(scene, variant.clone()), 0.0);
                assert_eq!(difference(&expected, &picture), None, "{variant:?}");
            }
        };
        let scene = three_lights();
        let mut checked = 0;
        for &layout in Layout::ALL {
            let options = Options { size: SIZE, layout, shadow_volumes: true, ..Options::default() };
            if Plan::new(Needs::of(&scene), options.clone(), &limits).is_ok() {
                check(&scene, options);
                checked += 1;
            }
        }
        assert!(checked >= Layout::ALL.len() - 4, "{checked}");
        for lights in [LightWay::Fullscreen, LightWay::Clusters] {
            check(&scene, Options { lights, ..by_volumes() });
        }
        check(&scene, Options { samples: 4, shadow_volumes: true, size: SIZE, ..Options::default() });
        // Masked casters: those lights keep their maps, the others do not.
        check(&shadows(), Options { size: SIZE, shadow_volumes: true, ..Options::default() });
        check(&chosen(), Options { size: SIZE, ..Options::default() });
        check(&chosen(), Options { size: SIZE, layout: Layout::Packed128, samples: 4, ..Options::default() });
        // What has moved casts its shadow from there.
        let mut offscreen = gpu.offscreen(&scene, gpu.plan(&scene, by_volumes()), Default::default());
        let mut moved = scene.clone();
        moved.instances[BALL].world_from_object.w_axis.x += 0.4;
        offscreen.renderer_mut().set_instance(BALL, &moved.instances[BALL].world_from_object).unwrap();
        let picture = crate::render(&mut offscreen, &scene.cameras[0]);
        let expected = gpu.picture(&moved, gpu.plan(&moved, by_volumes()), 0.0);
        assert_eq!(difference(&expected, &picture), None);
    });
}

#[test]
fn the_stencil_never_leaves_the_tile() {
    let limits = Limits { depth_clamp: true, ..Limits::default() };
    let scene = three_lights();
    let plan = |options: Options| Plan::new(Needs::of(&scene), options, &limits);
    let volumes = plan(Options { shadow_volumes: true, ..Options::default() }).unwrap();
    assert_eq!((volumes.passes.len(), volumes.bytes_moved(), volumes.volume_lights.len()), (1, 4, 3));
    assert!(volumes.passes[0].attachments.iter().all(|a| a.stencil.1 == Store::DontCare));
    let maps = plan(Options::default()).unwrap();
    assert!(volumes.shadow_map.is_none() && maps.shadow_map.is_some());
    for (options, remedy) in [
        (Options { path: Path::Forward, ..by_volumes() }, "--path deferred"),
        (Options { lights: LightWay::Stencil, ..by_volumes() }, "--lights auto"),
    ] {
        let refused = plan(options).unwrap_err().to_string();
        assert!(refused.contains(remedy), "{refused}");
    }
    let refused = Plan::new(Needs::of(&scene), by_volumes(), &Limits::default()).unwrap_err().to_string();
    assert!(refused.contains("depthClamp"), "{refused}");
}

/// Of linear light: sums of floats in another order.
const SUM_TOLERANCE: f64 = 1e-5;

/// Each light's picture by itself, added up, is the picture: whatever the others do, a light has the shadow that it asks for.
#[test]
fn lights_choose_for_themselves() {
    on_device(None, |gpu| {
        let scene = chosen();
        let maps = options(ShadowFilter::Hardware);
        let plan = gpu.plan(&scene, maps.clone());
        let of_map = plan.shadow_map.as_ref().unwrap().lights.iter().map(|light| light.name.clone());
        let named = |plan: &Plan| {
            plan.volume_lights.iter().map(|&i| scene.lights[i].name.clone()).collect::<Vec<_>>()
        };
        assert_eq!(named(&plan), ["sun", "bulb"]);
        assert_eq!(of_map.collect::<BTreeSet<_>>(), ["slab", "spot", "wide"].map(String::from).into());
        for told in [
            "light 'sun' counts its shadow as volumes: it asks for one",
            "light 'slab' keeps its shadow map: its light begins at a face of its box",
            "light 'spot' keeps its shadow map: it asks for one",
            "light 'wide' keeps its shadow map: it asks for nothing else",
        ] {
            assert!(plan.notes.iter().any(|note| note.starts_with(told)), "{told}: {:?}", plan.notes);
        }
        // The flag is for lights that do not say, and only it makes a frame without volumes an error.
        assert_eq!(named(&gpu.plan(&scene, by_volumes())), ["sun", "bulb", "wide"]);
        let forward = gpu.plan(&scene, Options { path: Path::Forward, ..maps.clone() });
        assert_eq!((forward.volume_lights.len(), forward.shadow_map.unwrap().lights.len()), (0, 5));
        let told = "light 'sun' keeps its shadow map: shadow volumes need a G-buffer";
        assert!(forward.notes.iter().any(|note| note.starts_with(told)), "{:?}", forward.notes);

        let together = light_of(&gpu.picture(&scene, plan, 0.0));
        let mut sum = vec![DVec3::ZERO; together.len()];
        for light in &scene.lights {
            let by_volume = ["sun", "bulb"].contains(&&*light.name);
            let shadow = Some(Shadow { volume: None, ..Shadow::default() });
            let alone = Scene { lights: vec![Light { shadow, ..light.clone() }], ..scene.clone() };
            let plan = gpu.plan(&alone, Options { shadow_volumes: by_volume, ..maps.clone() });
            assert_eq!(plan.shadow_map.is_none(), by_volume, "{}", light.name);
            let picture = light_of(&gpu.picture(&alone, plan, 0.0));
            sum.iter_mut().zip(picture).for_each(|(sum, light)| *sum += light);
        }
        let far = sum.iter().zip(&together).filter(|(a, b)| (**a - **b).abs().max_element() > SUM_TOLERANCE);
        assert_eq!(far.count(), 0);
    });
}

//! Elements come and go between frames, while earlier ones are on the GPU.

use super::*;
use ontile::gpu::Updated;
use ontile::scene::{AlphaMode, Background, Fog, Id, Image, Sampler, Shadow, Texture, TextureRef, World};

/// What the steps name.
#[derive(Default)]
struct Named {
    textured: Option<(Id<Mesh>, Id<Material>, Id<Instance>)>,
    lamp: Option<Id<Light>>,
}

/// What a step may make anew.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Makes {
    Nothing,
    Objects,
    Pipelines,
    Targets,
}

fn made(updated: Updated) -> Makes {
    match updated {
        Updated { new_targets: true, .. } => Makes::Targets,
        Updated { new_pipelines: true, .. } => Makes::Pipelines,
        Updated { new_objects: true, .. } => Makes::Objects,
        _ => Makes::Nothing,
    }
}

fn checkers(colors: [[u8; 4]; 2]) -> Image {
    let texel = |i: u32| colors[((i / 8 + i % 8) % 2) as usize];
    Image { name: "checkers".into(), width: 8, height: 8, texels: (0..64).flat_map(texel).collect() }
}

fn at(x: f32, y: f32, z: f32) -> Mat4 {
    Mat4::from_translation(vec3(x, y, z))
}

type Step = (&'static str, Makes, fn(&mut World, &mut Named));

const STEPS: [Step; 20] = [
    ("nothing", Makes::Nothing, |_, _| ()),
    ("an instance moves", Makes::Nothing, |world, _| {
        let id = world.ids::<Instance>().nth(1).unwrap();
        world.place(id, at(0.4, 0.2, 0.1)).unwrap();
    }),
    ("a textured mesh comes", Makes::Pipelines, |world, named| {
        let image = world.add(checkers([[255, 40, 40, 255], [250, 250, 250, 255]])).unwrap();
        let texture = world.add(Texture { image: image.index(), sampler: Sampler::default() }).unwrap();
        let base_color_texture = Some(TextureRef {
            texture: texture.index(),
            texcoord: 0,
            uv_from_texcoord: TextureRef::IDENTITY,
        });
        let material = Material { base_color_texture, metallic_factor: 0.0, ..Material::default() };
        let material = world.add(material).unwrap();
        let mesh = world.add(square(0.0, 0.5, material.index())).unwrap();
        let instance = world.add(Instance::new(mesh.index(), at(-0.6, 0.3, 0.4))).unwrap();
        named.textured = Some((mesh, material, instance));
    }),
    ("a second instance of it", Makes::Objects, |world, named| {
        let (mesh, ..) = named.textured.unwrap();
        world.add(Instance::new(mesh.index(), at(0.7, -0.4, 0.4))).unwrap();
    }),
    ("a lamp of a known kind", Makes::Objects, |world, named| {
        let kind = LightKind::Point { intensity_cd: 3.0 };
        let lamp = Light { position_world: vec3(-1.0, -0.5, 1.0), ..Light::new(kind) };
        named.lamp = Some(world.add(lamp).unwrap());
    }),
    ("it changes its colour", Makes::Nothing, |world, named| {
        let id = named.lamp.unwrap();
        let lamp = Light { color: vec3(0.2, 0.9, 0.4), ..world.get(id).unwrap().clone() };
        world.set(id, lamp).unwrap();
    }),
    ("a lamp of another kind", Makes::Pipelines, |world, _| {
        let light = Light::new(LightKind::Directional { illuminance_lx: 1.0 });
        world.add(light.towards(vec3(0.3, -0.2, -1.0))).unwrap();
    }),
    ("a material is another", Makes::Objects, |world, named| {
        let (_, id, _) = named.textured.unwrap();
        let material = Material { roughness_factor: 0.3, ..world.get(id).unwrap().clone() };
        world.set(id, material).unwrap();
    }),
    ("a mesh is another", Makes::Objects, |world, named| {
        let (id, material, _) = named.textured.unwrap();
        world.set(id, square(0.0, 0.35, material.index())).unwrap();
    }),
    ("a picture is another", Makes::Objects, |world, _| {
        let id = world.ids::<Image>().next().unwrap();
        world.set(id, checkers([[10, 90, 255, 255], [240, 240, 20, 255]])).unwrap();
    }),
    ("an instance goes", Makes::Objects, |world, named| {
        let (.., id) = named.textured.unwrap();
        world.remove(id).unwrap();
    }),
    ("another hides", Makes::Targets, |world, _| {
        // The glowing one: without it no light is there before lighting.
        let id = world.ids::<Instance>().nth(1).unwrap();
        world.set(id, Instance { hidden: true, ..*world.get(id).unwrap() }).unwrap();
    }),
    ("and is back, with ambient light", Makes::Targets, |world, _| {
        let id = world.ids::<Instance>().nth(1).unwrap();
        world.set(id, Instance { hidden: false, ..*world.get(id).unwrap() }).unwrap();
        world.set_ambient(vec3(0.1, 0.05, 0.2)).unwrap();
    }),
    ("fog and a background", Makes::Targets, |world, _| {
        world.set_fog(Some(Fog { color_nt: vec3(0.2, 0.2, 0.3), density_per_m: 0.1, height: None })).unwrap();
        world.set_background(Background::Color(vec3(0.1, 0.2, 0.1))).unwrap();
    }),
    ("the sun casts shadows", Makes::Pipelines, |world, _| {
        let id = world.ids::<Light>().last().unwrap();
        let sun = Light { shadow: Some(Shadow::default()), ..world.get(id).unwrap().clone() };
        world.set(id, sun).unwrap();
    }),
    ("another sun casts some too", Makes::Objects, |world, _| {
        let sun = Light {
            shadow: Some(Shadow::default()),
            ..Light::new(LightKind::Directional { illuminance_lx: 0.7 })
        };
        world.add(sun.towards(vec3(-0.5, 0.3, -1.0))).unwrap();
    }),
    ("it gets a name and another colour", Makes::Nothing, |world, _| {
        let id = world.ids::<Light>().last().unwrap();
        let sun = Light { name: "sun".into(), color: vec3(1.0, 0.5, 0.5), ..world.get(id).unwrap().clone() };
        world.set(id, sun).unwrap();
    }),
    ("a material gets a name and another colour", Makes::Objects, |world, _| {
        let id = world.ids::<Material>().next().unwrap();
        let base_color_factor = Vec4::new(0.9, 0.6, 0.1, 1.0);
        let material = Material { name: "brass".into(), base_color_factor, ..world.get(id).unwrap().clone() };
        world.set(id, material).unwrap();
    }),
    ("glass comes", Makes::Targets, |world, _| {
        let glass = Material {
            base_color_factor: Vec4::new(0.3, 0.6, 0.9, 0.4),
            alpha_mode: AlphaMode::Blend,
            ..Material::default()
        };
        let glass = world.add(glass).unwrap();
        let pane = world.add(square(0.0, 0.8, glass.index())).unwrap();
        world.add(Instance::new(pane.index(), at(0.2, 0.1, 1.2))).unwrap();
    }),
    ("nothing again", Makes::Nothing, |_, _| ()),
];

#[test]
fn elements_come_and_go_between_frames() {
    for strategy in [Strategy::Subpasses, Strategy::Separate] {
        let Some(mut engine) = engine() else { return };
        let (device, _) = engine.lend(false);
        let first = scene(vec3(0.8, 0.4, 0.2));
        let camera = first.cameras[0].clone();
        let options = of(strategy);
        let mut renderer = renderer(&device, &first, &options);
        let mut world = World::from(first);
        let size = SIZES[0];
        let images = images(&mut engine, &renderer, size, 1);
        // As an engine does: the first upload goes with the first frame, and old targets wait for the GPU.
        let mut targets = vec![renderer.create_target(size, &outputs(&images)).unwrap()];
        let (mut named, mut states) = (Named::default(), Vec::new());
        let bytes = u64::from(size[0] * size[1] * 4);
        for (frame, (what, makes, step)) in STEPS.iter().enumerate() {
            step(&mut world, &mut named);
            states.push(world.scene().clone());
            let slot = frame % FRAMES_IN_FLIGHT;
            engine.submit(slot, |buffer| {
                let recorder = recorder(&device, buffer);
                if frame == 0 {
                    renderer.record_upload(&recorder);
                }
                let updated = renderer.update(&world, &recorder).unwrap_or_else(|e| panic!("{what}: {e}"));
                world.clear_changes();
                assert_eq!(made(updated), *makes, "{what}");
                if updated.new_targets {
                    targets.push(renderer.create_target(size, &outputs(&images)).unwrap());
                }
                let view = View { camera: &camera, exposure_ev: 0.0 };
                renderer.record(&recorder, slot, targets.last().unwrap(), 0, &view);
                engine.copy(buffer, images[0], renderer.output_layout(), frame as u64 * bytes);
            });
        }
        engine.wait();
        let wanted = expected(&options, &states.iter().map(|scene| (scene, size, 0.0)).collect::<Vec<_>>());
        for (frame, (picture, (what, ..))) in wanted.iter().zip(&STEPS).enumerate() {
            let actual = engine.read(frame as u64 * bytes, picture.len());
            assert_equal(&actual, picture, &format!("{strategy}, {what}"));
            let seen = frame == 0 || what.starts_with("nothing") || *picture != wanted[frame - 1];
            assert!(seen, "{what}: it must show, or this test sees nothing");
        }
        drop((targets, renderer));
        assert_eq!(device.live(), Live::default(), "objects are left");
        drop(device);
        assert_eq!(engine.finish(strategy == Strategy::Separate), Vec::<String>::new());
    }
}

/// Two cameras in one frame, each with a slot and a target of its own; the shadow map follows both.
#[test]
fn several_views_of_a_world_go_into_one_frame() {
    let Some(mut engine) = engine() else { return };
    let (device, _) = engine.lend(false);
    let mut first = scene(vec3(0.3, 0.7, 0.4));
    let sun = Light::new(LightKind::Directional { illuminance_lx: 2.0 }).towards(vec3(0.4, -0.3, -1.0));
    first.lights.push(Light { shadow: Some(Shadow::default()), ..sun });
    let aside = Camera { world_from_view: at(0.8, 0.5, 2.0), ..first.cameras[0].clone() };
    first.cameras.push(aside);
    let mut renderer = renderer(&device, &first, &Options::default());
    upload(&engine, &device, &mut renderer);
    let views: Vec<_> = SIZES
        .iter()
        .map(|&size| {
            let images = images(&mut engine, &renderer, size, 1);
            (renderer.create_target(size, &outputs(&images)).unwrap(), images[0])
        })
        .collect();
    let bytes = SIZES.map(|[w, h]| u64::from(w * h * 4));
    for _ in 0..2 {
        engine.submit(0, |buffer| {
            for (slot, (target, image)) in views.iter().enumerate() {
                let view = View { camera: &first.cameras[slot], exposure_ev: 0.0 };
                renderer.record(&recorder(&device, buffer), slot, target, 0, &view);
                let at = if slot == 0 { 0 } else { bytes[0] };
                engine.copy(buffer, *image, renderer.output_layout(), at);
            }
        });
        engine.wait();
        for (slot, size) in SIZES.iter().enumerate() {
            let alone = Scene { cameras: vec![first.cameras[slot].clone()], ..first.clone() };
            let wanted = expected(&Options::default(), &[(&alone, *size, 0.0)]).remove(0);
            let actual = engine.read(if slot == 0 { 0 } else { bytes[0] }, wanted.len());
            assert_equal(&actual, &wanted, &format!("view {slot}"));
        }
    }
    drop((views, renderer));
    assert_eq!(device.live(), Live::default(), "objects are left");
    drop(device);
    assert_eq!(engine.finish(false), Vec::<String>::new());
}

#[test]
fn hundreds_of_comings_and_goings_grow_nothing() {
    const ROUNDS: usize = 300;
    const SIZE: [u32; 2] = [8, 8];
    let Some(mut engine) = engine() else { return };
    let (device, _) = engine.lend(false);
    let first = scene(Vec3::ONE);
    let camera = first.cameras[0].clone();
    let mut renderer = renderer(&device, &first, &Options::default());
    upload(&engine, &device, &mut renderer);
    let images = images(&mut engine, &renderer, SIZE, 1);
    let target = renderer.create_target(SIZE, &outputs(&images)).unwrap();
    let mut world = World::from(first);
    let material = world.ids::<Material>().next().unwrap();
    let mut here = std::collections::VecDeque::new();
    let (mut most, mut later) = (Live::default(), Live::default());
    for round in 0..ROUNDS {
        let mesh = world.add(square(0.0, 0.1 + round as f32 * 1e-3, material.index())).unwrap();
        let instance = world.add(Instance::new(mesh.index(), at(0.0, 0.0, 0.5))).unwrap();
        here.push_back((mesh, instance));
        if here.len() > 5 {
            let (mesh, instance) = here.pop_front().unwrap();
            world.remove(instance).unwrap();
            world.remove(mesh).unwrap();
        }
        let slot = round % FRAMES_IN_FLIGHT;
        engine.submit(slot, |buffer| {
            let recorder = recorder(&device, buffer);
            let updated = renderer.update(&world, &recorder).unwrap();
            world.clear_changes();
            assert!(!updated.new_targets, "the frame stays");
            renderer.record(&recorder, slot, &target, 0, &View { camera: &camera, exposure_ev: 0.0 });
        });
        let live = device.live();
        let seen = if round < ROUNDS / 3 { &mut most } else { &mut later };
        seen.bytes = seen.bytes.max(live.bytes);
        seen.allocations = seen.allocations.max(live.allocations);
    }
    engine.wait();
    assert!(later.bytes <= most.bytes && later.allocations <= most.allocations, "{most:?}, later {later:?}");
    assert!(world.scene().meshes.len() <= 2 + 6, "places are taken again");
    drop((target, renderer));
    assert_eq!(device.live(), Live::default(), "objects are left");
    drop(device);
    assert_eq!(engine.finish(false), Vec::<String>::new());
}

#[test]
fn what_does_not_go_is_refused_and_changes_nothing() {
    let mut world = World::from(scene(Vec3::ONE));
    let mesh = world.ids::<Mesh>().next().unwrap();
    let instance = world.ids::<Instance>().next().unwrap();
    let message = |error: ontile::Error| error.to_string();
    let used = message(world.remove(mesh).map(drop).unwrap_err());
    assert!(used.contains("meshes[0] cannot be removed: instances[0] uses it"), "{used}");
    let missing = message(world.add(Instance::new(7, Mat4::IDENTITY)).map(drop).unwrap_err());
    assert!(missing.contains("uses meshes[7], which is not there"), "{missing}");
    let nan = message(world.place(instance, at(f32::NAN, 0.0, 0.0)).unwrap_err());
    assert!(nan.contains("not affine and finite"), "{nan}");
    let indices = Mesh { indices: vec![0, 1, 99], ..world.get(mesh).unwrap().clone() };
    let beyond = message(world.set(mesh, indices).unwrap_err());
    assert!(beyond.contains("an index 99"), "{beyond}");
    let dark = Light { range_m: Some(-1.0), ..Light::new(LightKind::Point { intensity_cd: 1.0 }) };
    assert!(message(world.add(dark).map(drop).unwrap_err()).contains("negative"));
    assert!(world.changes().is_empty(), "{:?}", world.changes());

    world.remove(instance).unwrap();
    assert!(message(world.place(instance, Mat4::IDENTITY).unwrap_err()).contains("was removed"));
    let taken = world.add(Instance::new(0, Mat4::IDENTITY)).unwrap();
    assert_eq!(taken.index(), instance.index(), "its place is taken again");
    assert!(world.get(instance).is_none(), "but not its name");
    assert_eq!(Id::<Instance>::from_bits(taken.to_bits()), taken);
    for bits in [0, u64::MAX, taken.to_bits() ^ 1 << 32] {
        assert!(world.get(Id::<Instance>::from_bits(bits)).is_none(), "{bits:x}");
    }
}

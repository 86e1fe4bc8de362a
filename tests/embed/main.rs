//! An engine embeds the renderer: it lends its device, records frames into its own command buffers, draws to its own
//! images, and gets the picture that this crate's own host gets.

mod budget;
#[path = "../common/mod.rs"]
mod common;
mod engine;
mod moving;
mod world;

use engine::{Engine, EngineImage, FRAMES_IN_FLIGHT};
use glam::{Mat4, Vec3, Vec4, vec2, vec3};
use ontile::glam;
use ontile::gpu::{
    Device, Headless, HeadlessOptions, Live, Offscreen, OutputImage, PipelineCache, Recorder, Renderer,
    RendererConfig, View,
};
use ontile::picture::Pixels;
use ontile::plan::{LightWay, Needs, Options, Path, Plan, Refraction, Strategy};
use ontile::scene::{
    Camera, Decal, Instance, Light, LightKind, Material, Mesh, Particle, Particles, Projection, Scene,
    Transmission,
};

const SIZES: [[u32; 2]; 2] = [[160, 96], [72, 120]];

/// Of four by four quads: the layers advise against draws of few triangles.
fn square(z: f32, half: f32, material: usize) -> Mesh {
    let corners = (0..25).map(|i| vec2((i % 5) as f32 - 2.0, (i / 5) as f32 - 2.0) * 0.5);
    let quads = (0..4).flat_map(|y| (0..4).map(move |x| y * 5 + x));
    Mesh {
        positions: corners.clone().map(|corner| (corner * half).extend(z)).collect(),
        normals: vec![Vec3::Z; 25],
        texcoords: [corners.collect(), Vec::new()],
        colors: vec![Vec4::ONE; 25],
        indices: quads.flat_map(|i| [i, i + 1, i + 6, i, i + 6, i + 5]).collect(),
        material,
        ..Mesh::default()
    }
}

/// A lit square and, so that light is summed in a target of its own, a glowing one.
fn scene(color: Vec3) -> Scene {
    let material = |emissive_factor| Material {
        base_color_factor: color.extend(1.0),
        metallic_factor: 0.0,
        roughness_factor: 0.5,
        emissive_factor,
        ..Material::default()
    };
    Scene {
        meshes: vec![square(0.0, 2.0, 0), square(0.5, 0.3, 1)],
        instances: [0, 1].map(|mesh| Instance::new(mesh, Mat4::IDENTITY)).to_vec(),
        materials: vec![material(Vec3::ZERO), material(vec3(0.1, 0.2, 0.3))],
        lights: vec![Light {
            name: "light".into(),
            position_world: vec3(0.5, 0.5, 1.5),
            ..Light::new(LightKind::Point { intensity_cd: 2.0 })
        }],
        cameras: vec![Camera {
            name: "camera".into(),
            world_from_view: Mat4::from_translation(vec3(0.0, 0.0, 3.0)),
            projection: Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None },
        }],
        ..Scene::default()
    }
}

fn of(strategy: Strategy) -> Options {
    Options { strategy, ..Options::default() }
}

/// One of each way in which lights reach pixels: what is recorded for a frame differs among them.
fn methods() -> [Options; 6] {
    let way = |lights| Options { lights, ..Options::default() };
    let path = |path, lights| Options { path, lights, ..Options::default() };
    [
        way(LightWay::Fullscreen),
        way(LightWay::Clusters),
        way(LightWay::Volumes),
        way(LightWay::Stencil),
        path(Path::Forward, LightWay::Clusters),
        path(Path::ForwardMultipass, LightWay::Auto),
    ]
}

fn plan(device: &Device, scene: &Scene, options: &Options, size: [u32; 2]) -> Plan {
    let options = Options { size, ..options.clone() };
    Plan::new(Needs::of(scene), options, &device.limits()).unwrap()
}

fn renderer(device: &Device, scene: &Scene, options: &Options) -> Renderer {
    let config = RendererConfig { frames_in_flight: FRAMES_IN_FLIGHT, ..Default::default() };
    let cache = PipelineCache::new(device, &[]).unwrap();
    Renderer::new(device, scene, plan(device, scene, options, SIZES[0]), config, &cache).unwrap()
}

fn recorder(device: &Device, buffer: ash::vk::CommandBuffer) -> Recorder<'_> {
    // SAFETY: `Engine::submit` gives a buffer that it records, and the tests keep all alive until `Engine::wait`.
    unsafe { Recorder::from_host(device, buffer) }
}

fn upload(engine: &Engine, device: &Device, renderer: &mut Renderer) {
    engine.submit(0, |buffer| renderer.record_upload(&recorder(device, buffer)));
    engine.wait();
    renderer.finish_upload();
}

fn images(engine: &mut Engine, renderer: &Renderer, size: [u32; 2], count: usize) -> Vec<EngineImage> {
    (0..count).map(|_| engine.image(renderer.output_format(), renderer.output_usage(), size)).collect()
}

fn outputs(images: &[EngineImage]) -> Vec<OutputImage> {
    images.iter().map(|i| OutputImage { image: i.image, view: i.view }).collect()
}

/// The pictures of this crate's own host, on a device of its own: one per scene, size and exposure.
fn expected(options: &Options, frames: &[(&Scene, [u32; 2], f32)]) -> Vec<Vec<u8>> {
    let host = Headless::new(&HeadlessOptions {
        device_name_part: Some("llvmpipe".into()),
        ..HeadlessOptions::default()
    })
    .unwrap();
    let device = host.device();
    let cache = PipelineCache::new(device, &[]).unwrap();
    let picture = |&(scene, size, exposure_ev): &(&Scene, [u32; 2], f32)| {
        let plan = plan(device, scene, options, size);
        let mut offscreen = Offscreen::new(device, scene, plan, RendererConfig::default(), &cache).unwrap();
        offscreen.render(&View { camera: &scene.cameras[0], exposure_ev }).unwrap();
        match offscreen.picture().pixels {
            Pixels::Rgba8(bytes) => bytes,
            Pixels::Rgba32F(_) => panic!("the output has 8 bits a channel"),
        }
    };
    frames.iter().map(picture).collect()
}

/// Compares without printing thousands of bytes.
fn assert_equal(actual: &[u8], expected: &[u8], what: &str) {
    assert_eq!(actual.len(), expected.len(), "{what}");
    let different = actual.iter().zip(expected).filter(|(a, b)| a != b).count();
    assert_eq!(different, 0, "{what}: so many bytes differ");
}

fn engine() -> Option<Engine> {
    Engine::new().map_err(|reason| common::ignored_unless_required(&reason)).ok()
}

fn frames_in_flight(strategy: Strategy, own_allocator: bool) {
    let Some(mut engine) = engine() else { return };
    let scene = scene(vec3(0.8, 0.4, 0.2));
    let (device, allocator) = engine.lend(own_allocator);
    let mut renderer = renderer(&device, &scene, &of(strategy));
    upload(&engine, &device, &mut renderer);
    let camera = &scene.cameras[0];

    // As after a resize: the second target is made while frames to the first are on the GPU. Each frame has another
    // exposure, so that a slot's data written too early or too late would show.
    let mut targets = Vec::new();
    let mut frames = Vec::new();
    let layout = renderer.output_layout();
    let mut at = 0;
    for size in SIZES {
        let images = images(&mut engine, &renderer, size, FRAMES_IN_FLIGHT);
        targets.push(renderer.create_target(size, &outputs(&images)).unwrap());
        let target = targets.last().unwrap();
        for image in [0, 1, 0, 1, 0] {
            let slot = frames.len() % FRAMES_IN_FLIGHT;
            let exposure_ev = -0.5 * frames.len() as f32;
            engine.submit(slot, |buffer| {
                let view = View { camera, exposure_ev };
                renderer.record(&recorder(&device, buffer), slot, target, image, &view);
                engine.copy(buffer, images[image], layout, at);
            });
            frames.push((size, exposure_ev, at));
            at += u64::from(size[0] * size[1] * 4);
        }
    }
    engine.wait();

    let wanted: Vec<_> = frames.iter().map(|&(size, exposure_ev, _)| (&scene, size, exposure_ev)).collect();
    let wanted = expected(&of(strategy), &wanted);
    assert_ne!(wanted[0], wanted[1], "exposure must show, or this test sees nothing");
    for (index, (&(.., at), wanted)) in frames.iter().zip(&wanted).enumerate() {
        assert_equal(&engine.read(at, wanted.len()), wanted, &format!("{strategy}, frame {index}"));
    }

    drop((targets, renderer));
    assert_eq!(device.live(), Live::default(), "objects are left");
    drop((device, allocator));
    // The device is still the engine's to use.
    engine.submit(0, |_| ());
    engine.wait();
    assert_eq!(engine.finish(strategy == Strategy::Separate), Vec::<String>::new());
}

#[test]
fn an_engine_gets_the_same_pictures() {
    frames_in_flight(Strategy::Subpasses, false);
}

#[test]
fn an_engine_gets_the_same_pictures_from_separate_passes() {
    frames_in_flight(Strategy::Separate, false);
}

#[test]
fn an_engine_lends_its_allocator() {
    frames_in_flight(Strategy::Subpasses, true);
}

#[test]
fn renderers_share_a_device_and_a_command_buffer() {
    let Some(mut engine) = engine() else { return };
    let (device, _) = engine.lend(false);
    let scenes = [vec3(0.9, 0.1, 0.1), vec3(0.1, 0.1, 0.9)].map(scene);
    let strategies = [Strategy::Subpasses, Strategy::Separate];
    let mut parts: Vec<_> = scenes
        .iter()
        .zip(strategies)
        .map(|(scene, strategy)| {
            let mut renderer = renderer(&device, scene, &of(strategy));
            upload(&engine, &device, &mut renderer);
            let image = images(&mut engine, &renderer, SIZES[0], 1)[0];
            let target = renderer.create_target(SIZES[0], &outputs(&[image])).unwrap();
            (renderer, target, image)
        })
        .collect();
    let bytes = u64::from(SIZES[0][0] * SIZES[0][1] * 4);
    engine.submit(1, |buffer| {
        for (index, (renderer, target, image)) in parts.iter_mut().enumerate() {
            let view = View { camera: &scenes[index].cameras[0], exposure_ev: 0.0 };
            renderer.record(&recorder(&device, buffer), 1, target, 0, &view);
            engine.copy(buffer, *image, renderer.output_layout(), index as u64 * bytes);
        }
    });
    engine.wait();
    for (index, scene) in scenes.iter().enumerate() {
        let wanted = expected(&of(strategies[index]), &[(scene, SIZES[0], 0.0)]).remove(0);
        let actual = engine.read(index as u64 * bytes, wanted.len());
        assert_equal(&actual, &wanted, &format!("renderer {index}"));
    }

    // One goes, the other still renders.
    drop(parts.remove(0));
    let (renderer, target, image) = &mut parts[0];
    let view = View { camera: &scenes[1].cameras[0], exposure_ev: -1.0 };
    engine.submit(0, |buffer| {
        renderer.record(&recorder(&device, buffer), 0, target, 0, &view);
        engine.copy(buffer, *image, renderer.output_layout(), 0);
    });
    engine.wait();
    let wanted = expected(&of(strategies[1]), &[(&scenes[1], SIZES[0], -1.0)]).remove(0);
    assert_equal(&engine.read(0, wanted.len()), &wanted, "the renderer that is left");
    drop(parts);
    assert_eq!(device.live(), Live::default(), "objects are left");
    drop(device);
    assert_eq!(engine.finish(true), Vec::<String>::new());
}

/// The scene behind a pane of water, with sparks before it.
fn under_water(scene: &Scene) -> Scene {
    let mut wet = scene.clone();
    let glow = Material { emissive_factor: Vec3::ONE, ..Material::default() };
    let medium = Transmission { factor: 0.9, thickness_m: 0.5, ..Transmission::default() };
    let water = Material { transmission: Some(medium), ..Material::default() };
    wet.materials.extend([glow, water]);
    let spark = |x: f32| Particle {
        position_world: vec3(x, 0.1, 0.8),
        size_m: 0.3,
        rotation_rad: 0.4,
        color: Vec3::ONE,
    };
    let particles = Particles::new(wet.materials.len() - 2, 0.2, [-0.3, 0.0, 0.4].map(spark).to_vec());
    wet.particles.push(particles);
    wet.meshes.push(square(0.6, 0.8, wet.materials.len() - 1));
    wet.instances.push(Instance::new(wet.meshes.len() - 1, Mat4::IDENTITY));
    wet
}

#[test]
fn recording_allocates_nothing() {
    let Some(mut engine) = engine() else { return };
    let (device, _) = engine.lend(false);
    let mut scene = scene(Vec3::ONE);
    scene.lights[0].range_m = Some(4.0);
    // Over each other, in two levels, and a third beside them.
    let spot = |x: f32| {
        Decal::new(0, Mat4::from_translation(vec3(x, 0.0, 0.0)) * Mat4::from_scale(Vec3::splat(0.6)))
    };
    let painted = Scene { decals: [0.0, 0.2, -0.9].map(spot).to_vec(), ..scene.clone() };
    let bent = Options { refraction: Refraction::Pass, ..Options::default() };
    let cases = methods().map(|options| match options.path {
        Path::Deferred => (options, painted.clone()),
        _ => (options, scene.clone()),
    });
    let wet = under_water(&painted);
    let cases = cases.into_iter().chain([
        (of(Strategy::Separate), painted),
        (Options::default(), wet.clone()),
        (bent, wet),
    ]);
    for (options, scene) in cases {
        let scene = &scene;
        let mut renderer = renderer(&device, scene, &options);
        upload(&engine, &device, &mut renderer);
        let images = images(&mut engine, &renderer, SIZES[0], 1);
        let target = renderer.create_target(SIZES[0], &outputs(&images)).unwrap();
        let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
        for frame in 0..3 {
            let mut allocations = 0;
            engine.submit(frame % FRAMES_IN_FLIGHT, |buffer| {
                let recorder = recorder(&device, buffer);
                let slot = frame % FRAMES_IN_FLIGHT;
                let counted =
                    allocation_counter::measure(|| renderer.record(&recorder, slot, &target, 0, &view));
                allocations = counted.count_total;
                engine.copy(buffer, images[0], renderer.output_layout(), 0);
            });
            // The first frame may; layers and drivers have allocators of their own, which are not counted.
            assert!(frame == 0 || allocations == 0, "{options:?}, frame {frame}: {allocations} allocations");
        }
        engine.wait();
    }
    drop(device);
    assert_eq!(engine.finish(true), Vec::<String>::new());
}

#[test]
fn sizes_that_no_device_has_are_refused() {
    let Some(mut engine) = engine() else { return };
    let (device, _) = engine.lend(false);
    let renderer = renderer(&device, &scene(Vec3::ONE), &Options::default());
    let images = images(&mut engine, &renderer, SIZES[0], 1);
    for size in [[0, 96], [160, 1 << 20]] {
        let error = renderer.create_target(size, &outputs(&images)).map(drop).unwrap_err().to_string();
        assert!(error.contains("choose a size from 1x1"), "{error}");
    }
    drop(renderer);
    assert_eq!(device.live(), Live::default(), "objects are left");
    drop(device);
    assert_eq!(engine.finish(false), Vec::<String>::new());
}

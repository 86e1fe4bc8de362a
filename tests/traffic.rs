//! What frames are counted to consist of, and what follows of it for their traffic.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes;
use ontile::glam::{Mat4, Vec2, Vec3};
use ontile::gpu::{RendererConfig, View};
use ontile::measure::bandwidth::{Counts, FrameTraffic, Traffic, count};
use ontile::plan::{LightWay, Limits, Needs, Options, Path, Plan, Strategy};
use ontile::scene::{
    AlphaMode, Camera, Instance, Light, LightKind, Material, Mesh, Projection, Scene, Shadow,
};

const SIZE: [u32; 2] = [64, 32];
const PIXELS: f64 = 64.0 * 32.0;

fn counted(gpu: &Gpu<'_>, scene: &Scene, options: &Options) -> Counts {
    // Says which of the layer's advice is known, for each plan that is drawn.
    gpu.plan(scene, options.clone());
    gpu.plan(scene, Options { path: Path::Deferred, lights: LightWay::Stencil, ..options.clone() });
    let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
    let counts = count(gpu.device(), scene, options, &view, gpu.cache());
    counts.unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

/// A far square that covers the picture and a near one over its left half, under one light straight from the front that
/// casts shadows. The near one's material decides which is drawn first: the nearer, unless a mask may cut it.
fn two_squares(near: AlphaMode) -> Scene {
    let square = |left: f32, right: f32, material| {
        let corners = [(left, 1.0), (left, -1.0), (right, -1.0), (right, 1.0)];
        Mesh {
            positions: corners.map(|(x, y)| Vec2::new(x, y).extend(0.0)).to_vec(),
            normals: vec![Vec3::Z; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            material,
            ..Mesh::default()
        }
    };
    let at = |mesh, z| Instance::new(mesh, Mat4::from_translation(Vec3::new(0.0, 0.0, z)));
    let light = Light::new(LightKind::Directional { illuminance_lx: 2.0 }).towards(Vec3::NEG_Z);
    let projection = Projection::Orthographic { xmag_m: 1.0, ymag_m: 1.0, znear_m: 0.1, zfar_m: 10.0 };
    Scene {
        name: "two_squares".into(),
        meshes: vec![square(-2.0, 2.0, 0), square(-2.0, 0.0, 1)],
        materials: vec![Material::default(), Material { alpha_mode: near, ..Material::default() }],
        instances: vec![at(0, -4.0), at(1, -2.0)],
        lights: vec![Light { shadow: Some(Shadow::default()), ..light }],
        cameras: vec![Camera { name: String::new(), world_from_view: Mat4::IDENTITY, projection }],
        ..Scene::default()
    }
}

/// By hand: from front to back half of the picture is drawn behind what is there; from back to front none is.
#[test]
fn overdraw_and_order_are_counted() {
    on_device(None, |gpu| {
        for (near, passed) in [(AlphaMode::Opaque, 1.0), (AlphaMode::Mask { cutoff: 0.5 }, 1.5)] {
            for (path, shadowed) in [(Path::Deferred, 1.0), (Path::Forward, 1.0)] {
                let options = Options { size: SIZE, path, ..Options::default() };
                let scene = two_squares(near);
                let counts = counted(gpu, &scene, &options);
                let per_pixel = [counts.rasterized, counts.passed, counts.covered, counts.shadowed];
                assert_eq!(per_pixel.map(|n| n / PIXELS), [1.5, passed, 1.0, shadowed], "{path} {near:?}");
                assert_eq!(counts.lights, 1);

                let limits = gpu.device().limits();
                let traffic = FrameTraffic::new(&scene, &options, &limits, &counts).unwrap();
                let [model] = &traffic.modelled[..] else { panic!("{:?}", traffic.modelled) };
                assert_eq!((model.model.overdraw, model.model.sorting), (1.5, passed));
                // No textures; 3x3 samples of the shadow map, whose light is parallel: 16 bits.
                assert_eq!((model.model.t_b, model.model.t_s, model.model.t_bpp), (0.0, 9.0, 16.0));
                assert_eq!((model.model.n, model.model.n_mrt, model.model.mrt_bpp), (1.0, 3.0, 32.0));
                // Two draws of 6 indices of 2 bytes, each with its vertex of position and normal, and a matrix of 48 bytes.
                assert_eq!(model.model.c_geometry, 2.0 * (6.0 * (2.0 + 24.0) + 48.0));
                let part = |what| traffic.parts.iter().find(|p| p.what == what).unwrap();
                assert_eq!(part("geometry").separate.read, 2.0 * (4.0 * 24.0 + 6.0 * 2.0 + 48.0));
                // Forward, what is hidden later is lit too.
                let lit = if path == Path::Forward { passed } else { 1.0 } * PIXELS;
                let sampled = part("shadow map, sampled");
                assert_eq!(sampled.separate.read, 2.0 * lit);
                assert_eq!(sampled.separate.read + sampled.uncached_read, 9.0 * 2.0 * lit);
            }
        }
    });
}

/// The attachments' part is the ledger's. For one scene: counting changes no pixel, and what is counted of surfaces depends neither
/// on the path nor on how stages become passes.
#[test]
fn shipped_frames_add_up() {
    on_device(None, |gpu| {
        for scene in scenes::shipped() {
            let options = Options { size: [160, 90], ..Options::default() };
            let counts = counted(gpu, &scene, &options);
            let traffic = FrameTraffic::new(&scene, &options, &gpu.device().limits(), &counts).unwrap();
            let ledger = |strategy| {
                let totals = gpu.plan(&scene, Options { strategy, ..options.clone() }).report(&scene).totals;
                let [read, written] =
                    [totals.loaded_bytes_per_pixel, totals.stored_bytes_per_pixel].map(|f| f.value);
                Traffic { read, written } * (160.0 * 90.0)
            };
            let attachments = &traffic.parts[0];
            assert_eq!(attachments.separate, ledger(Strategy::Separate), "{}", scene.name);
            assert_eq!(attachments.subpasses, ledger(Strategy::Subpasses), "{}", scene.name);
            for saved in &traffic.saved {
                let difference = saved.separate.read - saved.subpasses.read;
                let expected = attachments.separate.read - attachments.subpasses.read;
                assert!((difference - expected).abs() <= 1e-9 * saved.separate.read, "{}", scene.name);
            }
            assert!(counts.passed >= counts.covered && counts.rasterized >= counts.passed, "{}", scene.name);
            for model in &traffic.modelled {
                model.model.check().unwrap();
            }
            if scene.name != "lamps" {
                continue;
            }
            for other in [
                Options { path: Path::Forward, ..options.clone() },
                Options { strategy: Strategy::Separate, recycle: false, ..options.clone() },
            ] {
                let again = counted(gpu, &scene, &other);
                let surfaces = |c: &Counts| [c.rasterized, c.passed, c.covered, c.shadowed];
                assert_eq!(surfaces(&again), surfaces(&counts), "{}", scene.name);
            }
            let config = RendererConfig { count_fragments: true, ..RendererConfig::default() };
            let plan = gpu.plan(&scene, options.clone());
            let [with, without] =
                [config, RendererConfig::default()].map(|c| gpu.picture_with(&scene, plan.clone(), 0.0, c));
            assert_eq!(difference(&with, &without), None, "{}", scene.name);
        }
    });
}

/// What merging saves of the attachments is the ledger's business alone, whatever the device: for courtyard 20 bytes read and 20
/// of 24 written a pixel.
#[test]
fn attachments_of_a_separate_frame_cost_what_the_readme_says() {
    let courtyard = scenes::shipped().into_iter().find(|scene| scene.name == "courtyard").unwrap();
    let traffic = |strategy| {
        let options = Options { strategy, ..Options::default() };
        let plan = Plan::new(Needs::of(&courtyard), options, &Limits::default()).unwrap();
        let totals = plan.report(&courtyard).totals;
        [totals.loaded_bytes_per_pixel.value, totals.stored_bytes_per_pixel.value]
    };
    assert_eq!([traffic(Strategy::Separate), traffic(Strategy::Subpasses)], [[20.0, 24.0], [0.0, 4.0]]);
}

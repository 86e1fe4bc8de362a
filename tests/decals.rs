//! Decals: one picture in whatever way they are ordered.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes::decal_scenes::{color_decals, decals};
use ontile::glam::{Mat4, Vec3};
use ontile::gpu::{RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Choice, DecalWay, Layout, LightWay, Needs, Options, Plan, Strategy};
use ontile::scene::{Decal, DecalChannels, Scene};

const SIZE: [u32; 2] = [128, 72];

/// The picture, if the device and the layout allow the way.
fn painted(gpu: &Gpu<'_>, scene: &Scene, options: &Options, decals: DecalWay) -> Option<Picture> {
    let options = Options { decals, ..options.clone() };
    let plan = Plan::new(Needs::of(scene), options.clone(), &gpu.device().limits());
    plan.is_ok().then(|| gpu.picture(scene, gpu.plan(scene, options), 0.0))
}

/// How many steps of 255 pictures are apart at most.
fn steps_apart(a: &Picture, b: &Picture) -> u8 {
    let [Pixels::Rgba8(a), Pixels::Rgba8(b)] = [&a.pixels, &b.pixels] else { panic!("8 bits are compared") };
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// Blending rounds what it mixes as storing what a shader has mixed does, but may mix with fewer bits: half a code of base colour,
/// which in 8 bits without gamma is up to 4 steps of the picture where it is dark.
const BLENDED_STEPS: u8 = 4;

#[test]
fn every_way_gives_the_same_picture() {
    on_device(None, |gpu| {
        let (mut ordered, mut blended, mut most) = (0, 0, 0);
        for scene in [decals().without_shadows(), color_decals().without_shadows()] {
            for choice in Choice::one_by_one(Choice::of(Layout::Ontile128)) {
                for lights in [LightWay::Auto, LightWay::Volumes] {
                    let options = choice.apply(&Options { size: SIZE, lights, ..Options::default() });
                    let Some(expected) = painted(gpu, &scene, &options, DecalWay::Barrier) else { continue };
                    let name = format!("{}, {choice}, {lights}", scene.name);
                    if let Some(picture) = painted(gpu, &scene, &options, DecalWay::RasterOrder) {
                        assert_eq!(difference(&expected, &picture), None, "{name}");
                        ordered += 1;
                    }
                    if let Some(picture) = painted(gpu, &scene, &options, DecalWay::Fixed) {
                        let steps = steps_apart(&expected, &picture);
                        assert!(steps <= BLENDED_STEPS, "{name}: {steps} steps");
                        most = most.max(steps);
                        blended += 1;
                    }
                    let separate = Options { strategy: Strategy::Separate, ..options.clone() };
                    let picture = painted(gpu, &scene, &separate, DecalWay::Barrier).expect("as in one pass");
                    assert_eq!(difference(&expected, &picture), None, "{name}, separate");
                }
            }
        }
        println!("{ordered} in raster order alike; {blended} blended, at most {most} steps of 255 apart");
    });
}

/// A decal that a host changes is painted as if the scene had been made so; what takes another plan is refused.
#[test]
fn decals_change_from_frame_to_frame() {
    on_device(None, |gpu| {
        let mut scene = decals().without_shadows();
        let plan = gpu.plan(&scene, Options { size: SIZE, ..Options::default() });
        let mut offscreen = gpu.offscreen(&scene, plan.clone(), RendererConfig::default());
        let camera = scene.cameras[0].clone();
        let mut frame = |change: &[(usize, Decal)]| {
            for (index, decal) in change {
                offscreen.renderer_mut().set_decal(*index, decal).unwrap();
            }
            offscreen.render(&View { camera: &camera, exposure_ev: 0.0 }).unwrap();
            offscreen.picture()
        };
        let before = frame(&[]);
        let moved = Decal {
            world_from_decal: Mat4::from_translation(Vec3::X * 0.3) * scene.decals[1].world_from_decal,
            ..scene.decals[1].clone()
        };
        let faint = DecalChannels { roughness: 0.2, ..DecalChannels::NONE };
        let fainter = Decal { channels: faint, ..scene.decals[3].clone() };
        let after = frame(&[(1, moved.clone()), (3, fainter.clone())]);
        (scene.decals[1], scene.decals[3]) = (moved, fainter);
        assert!(difference(&before, &after).is_some(), "nothing has changed");
        let made = gpu.picture(&scene, gpu.plan(&scene, plan.options.clone()), 0.0);
        assert_eq!(difference(&made, &after), None);

        let another = scene.decals[3].material - 1;
        type Spoil = fn(&mut Decal, usize);
        let wrong: [(usize, Spoil, &str); 5] = [
            (99, |_, _| (), "no decal 99"),
            (3, |d, _| d.channels.base_color = 1.0, "does not know"),
            (3, |d, another| d.material = another, "does not know"),
            (3, |d, _| d.channels.roughness = f32::NAN, "an opacity"),
            (3, |d, _| d.world_from_decal = Mat4::ZERO, "not affine"),
        ];
        for (index, spoil, part) in wrong {
            let mut decal = scene.decals[3].clone();
            spoil(&mut decal, another);
            let error = offscreen.renderer_mut().set_decal(index, &decal).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    });
}

/// Several samples a pixel: each is painted, in every way alike.
#[test]
fn every_sample_is_painted() {
    on_device(None, |gpu| {
        let scene = decals().without_shadows();
        for layout in [Layout::Metallic128, Layout::Ontile128, Layout::Rasa128] {
            let options = Options { size: SIZE, samples: 4, layout, ..Options::default() };
            let Some(expected) = painted(gpu, &scene, &options, DecalWay::Barrier) else {
                return common::ignored("4 samples a pixel: the device has none");
            };
            if let Some(picture) = painted(gpu, &scene, &options, DecalWay::RasterOrder) {
                assert_eq!(difference(&expected, &picture), None, "{layout}");
            }
            let separate = Options { strategy: Strategy::Separate, ..options.clone() };
            let picture = painted(gpu, &scene, &separate, DecalWay::Barrier).expect("as in one pass");
            assert_eq!(difference(&expected, &picture), None, "{layout}, separate");
            let bare = Scene { decals: Vec::new(), ..scene.clone() };
            let bare = painted(gpu, &bare, &options, DecalWay::Auto).expect("as with decals");
            assert!(difference(&expected, &bare).is_some(), "{layout}: nothing is painted");
        }
    });
}

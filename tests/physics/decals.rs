//! Decals against the reference, which paints the same over the surfaces that its rays find.

use std::f32::consts::FRAC_PI_2;

use ontile::environment::TexelFormat;
use ontile::glam::{Mat4, Vec2, Vec3, Vec4};
use ontile::plan::{Format, GBuffer};
use ontile::reference::{Settings, View, decode, quantise, render};
use ontile::scene::{Decal, DecalChannels, Image, Material, Sampler, Scene, Texture, TextureRef};

use crate::SIZE;
use crate::around::{sky, under_sky};
use crate::error::Errors;
use crate::gpu::{Ask, Gpu};
use crate::layouts::{INTERPOLATED, STEP_OF_HALF, choices, layouts, lost, typical};
use crate::scenes;

/// A picture of one texel, so that no filter's precision shows.
fn texel(scene: &mut Scene, rgba8: [u8; 4]) -> Option<TextureRef> {
    scene.images.push(Image { name: "texel".into(), width: 1, height: 1, texels: rgba8.to_vec().into() });
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler: Sampler::default() });
    let texture = scene.textures.len() - 1;
    Some(TextureRef { texture, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY })
}

/// The materials' scene, with every channel painted by itself and all together, over curved and flat surfaces, across edges, with
/// falloffs and angles, overlapping in either order.
pub fn scene() -> Scene {
    let mut scene = Scene { name: "decals".into(), ..scenes::lights() };
    let bent = texel(&mut scene, [190, 100, 230, 255]);
    let tint = texel(&mut scene, [255, 255, 255, 200]);
    let worn = texel(&mut scene, [255, 100, 255, 255]);
    let paint = Material {
        base_color_factor: Vec4::new(0.9, 0.8, 0.3, 0.9),
        base_color_texture: tint,
        metallic_factor: 0.0,
        roughness_factor: 0.35,
        ..Material::default()
    };
    let first = scene.materials.len();
    scene.materials.extend([
        paint.clone(),
        Material { normal_texture: bent, normal_scale: 1.3, ..paint.clone() },
        Material {
            base_color_factor: Vec4::new(0.2, 0.4, 0.9, 0.9),
            metallic_factor: 1.0,
            metallic_roughness_texture: worn,
            base_color_texture: None,
            ..paint
        },
    ]);
    let none = DecalChannels::NONE;
    let down = Mat4::from_rotation_x(-FRAC_PI_2);
    let place = |x: f32, y: f32, z: f32, turn: Mat4, size: Vec3| {
        Mat4::from_translation(Vec3::new(x, y, z)) * turn * Mat4::from_scale(size)
    };
    let bounds = scene.bounds_world().expect("it has surfaces");
    let (center, size) = (bounds.center(), bounds.max - bounds.min);
    let floor = |x: f32, z: f32, extent: f32| {
        place(center.x + x * size.x, 0.0, center.z + z * size.z, down, Vec3::new(extent, extent, 1.0))
    };
    let decal = |material: usize, channels, world_from_decal| Decal {
        channels,
        ..Decal::new(first + material, world_from_decal)
    };
    let from_front =
        place(center.x, center.y, center.z, Mat4::from_rotation_y(0.3), size * Vec3::new(0.5, 0.33, 1.5));
    scene.decals = vec![
        Decal {
            falloff_m: Vec3::splat(0.3),
            ..decal(0, DecalChannels { base_color: 0.8, ..none }, floor(-0.1, 0.1, 2.0))
        },
        decal(1, DecalChannels { normal: 0.7, ..none }, floor(0.05, 0.15, 1.6)),
        Decal { angle_rad: [0.2, 1.3], ..decal(2, DecalChannels { roughness: 0.9, ..none }, from_front) },
        Decal {
            priority: -1.0,
            ..decal(2, DecalChannels { base_color: 1.0, roughness: 0.5, ..none }, floor(0.0, 0.2, 1.8))
        },
        decal(2, DecalChannels { metallic: 1.0, base_color: 1.0, ..none }, floor(0.2, -0.1, 0.9)),
        Decal {
            angle_rad: [0.1, FRAC_PI_2],
            ..decal(
                1,
                DecalChannels { base_color: 0.5, normal: 1.0, ..none },
                place(center.x, center.y, center.z, Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)), size * 0.6),
            )
        },
    ];
    scene
}

#[test]
fn painted_surfaces_are_lit_as_the_reference_does() {
    let Some(gpu) = Gpu::open() else { return };
    for scene in [scene(), scenes::turned(scene())] {
        for camera in &scene.cameras {
            let rendered = gpu.render(&scene, camera, Ask::EXACT);
            let expected = render(&scene, camera, &rendered.settings);
            let errors = Errors::of_display(&expected, &rendered.light());
            println!("{}: {errors}", camera.name);
            assert_eq!(errors.check(), Ok(()), "{}", camera.name);
            let bare = Scene { decals: Vec::new(), ..scene.clone() };
            let bare = render(&bare, camera, &rendered.settings);
            let painted = bare.pixels.iter().zip(&expected.pixels).filter(|(a, b)| a.display != b.display);
            assert!(painted.count() * 10 > bare.pixels.len(), "next to nothing is painted");
        }
    }
    gpu.finish();
}

/// [`scene`] in light from all around, some of which an occlusion texture keeps off, and with a surface that glows.
fn in_light_from_around() -> Scene {
    let mut scene = Scene { name: "decals around".into(), ambient_nt: Vec3::new(0.2, 0.25, 0.3), ..scene() };
    let occlusion = texel(&mut scene, [120, 255, 255, 255]);
    for mesh in &mut scene.meshes {
        mesh.texcoords[0] = vec![Vec2::ZERO; mesh.positions.len()];
    }
    for (index, material) in scene.materials.iter_mut().enumerate() {
        material.occlusion_texture = occlusion.filter(|_| index % 2 == 0);
        material.emissive_factor = Vec3::splat(if index == 1 { 0.1 } else { 0.0 });
    }
    scene
}

/// What decals paint reflects light from all around as it is painted: colour, normal, roughness and metallicness.
#[test]
fn painted_surfaces_reflect_light_from_all_around() {
    let Some(gpu) = Gpu::open() else { return };
    let under_sky = under_sky(in_light_from_around(), &sky(), TexelFormat::E5B9G9R9);
    for (scene, is_sky) in [(in_light_from_around(), false), (under_sky, true)] {
        let camera = &scene.cameras[0];
        let rendered = gpu.render(&scene, camera, Ask::EXACT);
        let expected = render(&scene, camera, &rendered.settings);
        let errors = Errors::of_display(&expected, &rendered.light());
        println!("{}: {errors}", scene.name);
        assert_eq!(errors.check(), Ok(()), "{}", scene.name);
        // Able to fail: the same decals without each of their channels.
        let forget: [fn(&mut DecalChannels); 4] =
            [|c| c.base_color = 0.0, |c| c.normal = 0.0, |c| c.roughness = 0.0, |c| c.metallic = 0.0];
        for (channel, forget) in forget.into_iter().enumerate() {
            let mut faulty = Scene { lights: Vec::new(), ..scene.clone() };
            let dark = gpu.render(&faulty, camera, Ask::EXACT);
            faulty.decals.iter_mut().for_each(|decal| forget(&mut decal.channels));
            let errors = Errors::of_display(&render(&faulty, camera, &dark.settings), &dark.light());
            // Ambient light comes from everywhere alike: no normal changes much of it.
            assert!(
                errors.check().is_err() || (channel == 1 && !is_sky),
                "channel {channel} does not matter"
            );
        }
    }
    gpu.finish();
}

/// Each of two that are painted over each other may fall to either neighbour of a code (Vulkan's conversions), whose error is half a
/// step.
const EITHER_NEIGHBOUR_TWICE: f64 = 4.0;

/// Half floats may be cut off instead of rounded: a step for each write, of which later paint leaves what it does not cover; of a normal
/// in each of three channels. By kind as [`lost`] has them, for the decals of [`scene`].
const CUT_HALVES: [f64; 4] = [0.0, 2.6 * STEP_OF_HALF, 3.1 * STEP_OF_HALF, 1.7 * STEP_OF_HALF];

/// Of the decal with falloffs: opacity times the steepest slope of a smoothstep over 0.3 m, a metre.
const STEEPEST_PER_M: f64 = 0.8 * 0.9 * (200.0 / 255.0) * 1.5 / 0.3;

/// With decals that cover everything within 1.2 rad: how much is painted depends on no rounded place, and on normals at one angle
/// only, which few pixels have.
fn endless(scene: Scene) -> Scene {
    let mut scene = Scene { name: "endless decals".into(), ..scene };
    for decal in &mut scene.decals {
        decal.falloff_m = Vec3::ZERO;
        decal.angle_rad = [1.2; 2];
        decal.world_from_decal *= Mat4::from_scale(Vec3::splat(30.0));
    }
    scene
}

/// The reference paints what the layout has stored, and stores that again, as the GPU does. Where decals have no end, what a layout may
/// differ by is what its formats round; where they fade, rounded places and normals also decide how much is painted.
#[test]
fn every_layout_is_painted_as_the_reference_does() {
    let Some(gpu) = Gpu::open() else { return };
    let mut failed = Vec::new();
    for (scene, fades) in [(scene(), true), (endless(scene()), false)] {
        let camera = &scene.cameras[0];
        let exact = render(&scene, camera, &gpu.render(&scene, camera, Ask::EXACT).settings);
        for (name, ask) in layouts().into_iter().chain(choices()) {
            let gbuffer = GBuffer::new(&ask.options()).expect("it makes sense");
            let Some((rendered, stored)) = gpu.try_with_gbuffer(&scene, camera, ask) else { continue };
            let settings = Settings { gbuffer: Some(gbuffer.clone()), ..rendered.settings.clone() };
            let (expected, view) = (render(&scene, camera, &settings), View::new(camera, SIZE));
            let (mut found, mut formats, mut farthest_m) = (Vec::new(), [0.0_f64; 5], 0.0_f64);
            let pixels = expected.pixels.iter().zip(&exact.pixels).zip(&stored).enumerate();
            for (index, ((pixel, exact), stored)) in pixels {
                if !exact.covered || exact.edge || !exact.attributes.lit {
                    continue;
                }
                let place = [index as u32 % SIZE[0], index as u32 / SIZE[0]];
                let factor = settings.light_scale;
                let kept = quantise(&gbuffer, &exact.attributes, &view, place, factor);
                let lost_by_formats = lost(&kept, &exact.attributes, &view);
                formats = std::array::from_fn(|k| formats[k].max(lost_by_formats[k]));
                farthest_m = farthest_m.max((exact.attributes.position_world - view.position_world).length());
                let painted = decode(&gbuffer, stored, &view, place, factor);
                found.push(lost(&painted, &pixel.attributes, &view));
            }
            let found = typical(found);
            println!("{}, {name}: {found:?}, formats {formats:?}", scene.name);
            let has_halves = gbuffer.surface.iter().any(|t| t.format == Format::Rgba16Float);
            for (k, what) in ["position", "normal", "colour", "roughness"].into_iter().enumerate() {
                let cut = |k: usize| if has_halves { CUT_HALVES[k] } else { 0.0 };
                // How much is painted goes by the stored normal, about as steeply as by its angle, and by the stored place, of which
                // cut halves may be a whole step from rounded ones: twice what rounding loses.
                let by_end = match fades && k > 0 {
                    true => formats[1] + cut(1) + 2.0 * formats[0] * farthest_m * STEEPEST_PER_M,
                    false => 0.0,
                };
                let most = EITHER_NEIGHBOUR_TWICE * formats[k] + INTERPOLATED[k] + cut(k) + by_end;
                if found[k].is_nan() || found[k] > most {
                    let name = format!("{}, {name}", scene.name);
                    failed.push(format!("{name}: {what} off by {:.2e}, at most {most:.2e}", found[k]));
                }
            }
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn every_fault_is_caught() {
    type Fault = (&'static str, fn(&mut Scene));
    const FAULTS: &[Fault] = &[
        ("opacity off by 0.05", |s| s.decals[0].channels.base_color -= 0.05),
        ("painted in another order", |s| s.decals[3].priority = 1.0),
        ("one forgotten", |s| drop(s.decals.remove(2))),
        ("a normal's other side", |s| s.images[0].rgba8_mut()[1] = 155),
        ("the angle ignored", |s| s.decals[2].angle_rad = [FRAC_PI_2; 2]),
        ("falloff ignored", |s| s.decals[0].falloff_m = Vec3::ZERO),
        ("handedness ignored", |s| s.decals[5].world_from_decal.x_axis *= -1.0),
        ("alpha ignored", |s| s.images[1].rgba8_mut()[3] = 255),
    ];
    let Some(gpu) = Gpu::open() else { return };
    let scene = scene();
    let camera = &scene.cameras[0];
    let rendered = gpu.render(&scene, camera, Ask::EXACT);
    for (name, fault) in FAULTS {
        let mut faulty = scene.clone();
        fault(&mut faulty);
        let errors = Errors::of_display(&render(&faulty, camera, &rendered.settings), &rendered.light());
        assert!(errors.check().is_err(), "{name}: not caught, {errors}");
    }
    gpu.finish();
}

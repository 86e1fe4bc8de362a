//! Textured scenes: filtering is the driver's own, so the reference shades what the GPU's `exact` G-buffer holds.

use ontile::glam::{DVec3, Mat4, Vec2, Vec3};
use ontile::reference::shade_gbuffer;
use ontile::scene::{Image, Material, Mesh, Sampler, Scene, Texture, TextureRef};

use crate::error::Errors;
use crate::gpu::{Ask, Gpu};
use crate::scenes;

/// Smooth noise in all channels, alike on every run.
fn image(name: &str, seed: u32, channel: impl Fn(u32, f32) -> f32) -> Image {
    const SIZE: u32 = 64;
    let wave = |x: u32, y: u32, k: u32| {
        let (u, v) = (x as f32 / SIZE as f32, y as f32 / SIZE as f32);
        let phase = (seed * 7 + k * 3) as f32;
        let turn = std::f32::consts::TAU;
        0.5 + 0.25 * (turn * (3.0 * u + 2.0 * v) + phase).sin() + 0.25 * (turn * (5.0 * v - u) - phase).cos()
    };
    let texel = |i: u32| {
        let (x, y) = (i % SIZE, i / SIZE);
        [0, 1, 2, 3].map(|k| (channel(k, wave(x, y, k)) * 255.0).round() as u8)
    };
    Image { name: name.into(), width: SIZE, height: SIZE, texels: (0..SIZE * SIZE).flat_map(texel).collect() }
}

/// The scene of all that shines by itself, with all five textures on everything that is lit.
fn textured() -> Scene {
    let mut scene = scenes::surfaces();
    scene.name = "textured".into();
    scene.images = vec![
        image("base colour", 1, |k, x| if k == 3 { 1.0 } else { 0.2 + 0.7 * x }),
        image("metallic-roughness", 2, |_, x| x),
        image("normal", 3, |k, x| if k == 2 { 1.0 } else { 0.35 + 0.3 * x }),
        image("occlusion", 4, |_, x| x),
        image("emissive", 5, |_, x| x * x),
    ];
    scene.textures = (0..5).map(|image| Texture { image, sampler: Sampler::default() }).collect();
    let slot = |texture: usize, texcoord: usize, uv_from_texcoord| {
        Some(TextureRef { texture, texcoord, uv_from_texcoord })
    };
    let turned = [Vec3::new(1.5, 0.5, 0.1), Vec3::new(-0.5, 1.5, 0.2)];
    for material in &mut scene.materials {
        *material = Material {
            base_color_texture: slot(0, 0, TextureRef::IDENTITY),
            metallic_roughness_texture: slot(1, 1, TextureRef::IDENTITY),
            normal_texture: slot(2, 0, turned),
            occlusion_texture: slot(3, 1, turned),
            emissive_texture: slot(4, 0, TextureRef::IDENTITY),
            normal_scale: 0.8,
            occlusion_strength: 0.7,
            metallic_factor: 0.8,
            roughness_factor: 0.9,
            ..material.clone()
        };
    }
    for mesh in &mut scene.meshes {
        *mesh = with_texcoords(std::mem::take(mesh));
    }
    // Flat ones too: their texels are stretched most.
    scene.instances[0].world_from_object *= Mat4::from_rotation_y(0.3);
    scene
}

fn with_texcoords(mesh: Mesh) -> Mesh {
    let first: Vec<_> =
        mesh.positions.iter().map(|p| Vec2::new(p.x + 0.3 * p.y, p.z - 0.2 * p.y) * 2.0).collect();
    let second = first.iter().map(|uv| uv.perp() * 0.7 + 0.1).collect();
    let tangents = mesh.normals.iter().map(|n| n.any_orthonormal_vector().extend(-1.0)).collect();
    Mesh { texcoords: [first, second], tangents, ..mesh }
}

/// Leaves the factors only.
pub fn without_textures(scene: &mut Scene) {
    for material in &mut scene.materials {
        *material = Material {
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            occlusion_texture: None,
            emissive_texture: None,
            ..material.clone()
        };
    }
}

/// The GPU's picture against what the reference makes of the GPU's G-buffer.
pub fn compare(gpu: &Gpu, scene: &Scene, reference: &Scene) -> Vec<(String, Errors)> {
    let compare = |camera| {
        let (rendered, gbuffer) = gpu.render_with_gbuffer(scene, camera, Ask::EXACT);
        let mut frame = shade_gbuffer(reference, camera, &rendered.settings, &gbuffer);
        for pixel in &mut frame.pixels {
            // Nothing clears the depth of pixels that no surface covers: it does not tell them.
            pixel.covered = pixel.attributes.lit || pixel.attributes.prelit != DVec3::ZERO;
        }
        // No edges: every pixel shades what it holds.
        let errors = Errors::of_display(&frame, &rendered.light());
        (format!("{}, {}", scene.name, camera.name), errors)
    };
    scene.cameras.iter().map(compare).collect()
}

#[test]
fn what_the_gbuffer_holds_is_shaded_as_the_reference_does() {
    let Some(gpu) = Gpu::open() else { return };
    for scene in scenes::all().into_iter().chain([textured()]) {
        for (name, errors) in compare(&gpu, &scene, &scene) {
            println!("{name}: {errors}");
            assert_eq!(errors.check(), Ok(()), "{name}");
        }
    }
    gpu.finish();
}

#[test]
fn every_fault_is_caught() {
    type Fault = (&'static str, fn(&mut Scene));
    const FAULTS: &[Fault] = &[
        ("pi off by 1 %", |s| s.lights.iter_mut().for_each(|l| l.color *= 1.01)),
        ("a light moved by 5 cm", |s| s.lights[1].position_world.x += 0.05),
        ("a light forgotten", |s| drop(s.lights.pop())),
    ];
    let Some(gpu) = Gpu::open() else { return };
    let scene = textured();
    for (name, fault) in FAULTS {
        let mut faulty = scene.clone();
        fault(&mut faulty);
        for (camera, errors) in compare(&gpu, &scene, &faulty) {
            assert!(errors.check().is_err(), "{name}, {camera}: not caught, {errors}");
        }
    }
    gpu.finish();
}

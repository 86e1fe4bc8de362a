//! What a GPU shows of them.

use super::common::render::{Gpu, on_device};
use super::common::swiftshader::swiftshader_env;
use super::ktx::File;
use super::{BASIS, blocks, halved, ktx_format, read};
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec2, Vec3, Vec4};
use ktx2::Format;
use ontile::gpu::Features;
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Options, Tonemap};
use ontile::scene::{
    AlphaMode, Background, Camera, Image, Instance, Material, Mesh, Projection, Sampler, Scene, Texture,
    TextureFormat, TextureRef,
};
use std::process::Command;

/// BC1 and BC3 blend their colours in thirds, which GPUs round as they like; everything else is exact, and the picture itself is
/// of such steps.
const MOST_STEPS: u8 = 1;
const MOST_STEPS_OF_BC1: u8 = 2;

/// Set for a child that must show these formats without decoding them first.
const NATIVE: &str = "ONTILE_TEST_NATIVE";

const NEAREST: Sampler =
    Sampler { mag_linear: false, min_linear: false, mip_linear: Some(false), ..sampler() };

const fn sampler() -> Sampler {
    use ontile::scene::Wrap::Repeat;
    Sampler {
        mag_linear: true,
        min_linear: true,
        mip_linear: Some(true),
        wrap_u: Repeat,
        wrap_v: Repeat,
        max_anisotropy: 1,
    }
}

/// The picture across the whole view, `times` times in both directions.
fn shown(image: Image, sampler: Sampler, times: f32) -> Scene {
    let corners = [Vec2::new(-1.0, 1.0), Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0)];
    let mesh = Mesh {
        positions: corners.map(|c| c.extend(0.0)).to_vec(),
        texcoords: [corners.map(|c| (c * Vec2::new(0.5, -0.5) + 0.5) * times).to_vec(), Vec::new()],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    };
    let texture = TextureRef { texture: 0, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY };
    let material = Material {
        base_color_factor: Vec4::ONE,
        base_color_texture: Some(texture),
        unlit: true,
        ..Material::default()
    };
    let camera = Camera {
        name: "straight on".into(),
        world_from_view: Mat4::from_translation(Vec3::Z),
        projection: Projection::Orthographic { xmag_m: 1.0, ymag_m: 1.0, znear_m: 0.1, zfar_m: 2.0 },
    };
    Scene {
        name: image.name.clone(),
        // As wide as the view, whatever its aspect ratio.
        instances: vec![Instance::new(
            0,
            Mat4::from_scale(Vec3::new(image.width as f32 / image.height as f32, 1.0, 1.0)),
        )],
        meshes: vec![mesh],
        materials: vec![material],
        textures: vec![Texture { image: 0, sampler }],
        images: vec![image],
        cameras: vec![camera],
        ..Scene::default()
    }
}

fn picture(gpu: &Gpu<'_>, scene: &Scene, size: [u32; 2]) -> Vec<[u8; 4]> {
    let options = Options { size, tonemap: Tonemap::Linear, ..Options::default() };
    let Picture { pixels: Pixels::Rgba8(bytes), .. } = gpu.picture(scene, gpu.plan(scene, options), 0.0)
    else {
        panic!("the output is of bytes")
    };
    bytes.as_chunks::<4>().0.to_vec()
}

fn is_enabled(format: TextureFormat, features: Features) -> bool {
    match format {
        TextureFormat::Rgba8 => true,
        TextureFormat::Etc2 | TextureFormat::Etc2Mask | TextureFormat::Etc2Alpha => {
            features.texture_compression_etc2
        }
        TextureFormat::Astc(_) => features.texture_compression_astc,
        _ => features.texture_compression_bc,
    }
}

/// All formats, on GPUs that have them and on GPUs that have not.
#[test]
fn every_format_is_shown_as_it_decodes() {
    on_device(None, |gpu| {
        let features = gpu.device().features();
        let native = TextureFormat::COMPRESSED.into_iter().filter(|&format| is_enabled(format, features));
        let native: Vec<_> = native.map(|format| format!("{format:?}")).collect();
        println!("native here: {}", native.join(" "));
        for wanted in std::env::var(NATIVE).unwrap_or_default().split_whitespace() {
            assert!(native.iter().any(|format| format == wanted), "{wanted} is not native");
        }
        let ready = TextureFormat::COMPRESSED.map(|format| {
            let size = [23, 14];
            let levels = (0..2).map(|level| blocks(format, halved(size, level.into()), level)).collect();
            let mut image = read("ready", &File::new(ktx_format(format), size, levels).bytes());
            image.name = format!("{format:?}");
            (
                image,
                if matches!(format, TextureFormat::Bc1 | TextureFormat::Bc1Alpha | TextureFormat::Bc3) {
                    MOST_STEPS_OF_BC1
                } else {
                    MOST_STEPS
                },
            )
        });
        for (image, most) in ready {
            let size = [image.width, image.height];
            let expected = image.rgba8().as_chunks::<4>().0.to_vec();
            let name = image.name.clone();
            let mut scene = shown(image, NEAREST, 1.0);
            for (i, (shown, texel)) in picture(gpu, &scene, size).iter().zip(&expected).enumerate() {
                let apart = (0..3).map(|c| shown[c].abs_diff(texel[c])).max().unwrap();
                assert!(apart <= most, "{name}, texel {i}: {shown:?} for {texel:?}");
            }
            // Alpha shows where white is thinned by it: light is then the alpha itself.
            scene.materials[0].alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
            scene.background = Background::Color(Vec3::new(1.0, 0.0, 1.0));
            let cut = picture(gpu, &scene, size);
            let clear = |pixel: &[u8; 4]| *pixel == [255, 0, 255, 255];
            for (i, (shown, texel)) in cut.iter().zip(&expected).enumerate() {
                let unsure = texel[3].abs_diff(128) <= 2;
                assert!(
                    unsure || clear(shown) == (texel[3] < 128),
                    "{name}, texel {i}: {shown:?} for {texel:?}"
                );
            }
        }
    });
}

/// Transcoding to what a GPU has loses as much as BC7 loses: less than 2 steps on average of this smooth picture.
#[test]
fn basis_universal_is_transcoded_to_what_the_gpu_has() {
    on_device(None, |gpu| {
        for (name, file, ..) in BASIS {
            let image = read(name, file);
            let expected = image.rgba8().as_chunks::<4>().0.to_vec();
            let shown = picture(gpu, &shown(image, NEAREST, 1.0), [60, 28]);
            let apart = shown.iter().zip(&expected).flat_map(|(a, b)| (0..3).map(|c| a[c].abs_diff(b[c])));
            let mean = apart.clone().map(f64::from).sum::<f64>() / (expected.len() * 3) as f64;
            println!("{name}: mean {mean:.3}, most {} steps", apart.max().unwrap());
            assert!(mean < 2.0, "{name}: {mean} steps");
        }
    });
}

#[test]
fn swiftshader_has_the_formats_of_phones() {
    let Some(swiftshader) = swiftshader_env() else { return };
    let mut child = Command::new(std::env::current_exe().expect("this program's path"));
    child.args(["--exact", "gpu::every_format_is_shown_as_it_decodes", "--nocapture"]).envs(swiftshader);
    let output = child.env(NATIVE, "Etc2 Etc2Mask Etc2Alpha Astc(B4x4) Astc(B12x12)").output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr) + String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("native here"), "{said}");
}

/// Level `n` is wholly of colour `n`: the one that is seen is the one that was chosen.
#[test]
fn levels_are_those_of_the_file() {
    let colors: [[u8; 4]; 4] = [[250, 0, 0, 255], [0, 250, 0, 255], [0, 0, 250, 255], [250, 250, 0, 255]];
    let file = |format, levels: usize| {
        let level = |level: usize| {
            let texels = halved([32, 32], level as u32).iter().product::<u32>() as usize;
            colors[level].repeat(texels)
        };
        File::new(format, [32, 32], (0..levels).map(level).collect()).bytes()
    };
    on_device(None, |gpu| {
        for levels in [2, 4] {
            for level in 0..5_usize {
                let image = read("levels", &file(Format::R8G8B8A8_SRGB, levels));
                let shown = picture(gpu, &shown(image, NEAREST, (1 << level) as f32), [32, 32]);
                let expected = colors[level.min(levels - 1)];
                assert!(
                    shown.iter().all(|pixel| *pixel == expected),
                    "level {level} of {levels}: {:?}",
                    shown[0]
                );
            }
        }
    });
}

/// Stripes that run away from the viewer over a floor: without anisotropy their mip level is that of the floor's depth, in which
/// they are gone. The truth is the mean of 16 x 16 samples a pixel of level 0.
#[test]
fn anisotropy_keeps_stripes_apart() {
    let stripes = |max_anisotropy, mip_linear| {
        const SIDE: u32 = 256;
        let texel =
            |i: u32| if (i % SIDE / 8).is_multiple_of(2) { [230, 230, 230, 255] } else { [20, 20, 20, 255] };
        let texels = (0..SIDE * SIDE).flat_map(texel).collect();
        let image = Image { name: "stripes".into(), width: SIDE, height: SIDE, texels };
        let mut scene = shown(image, Sampler { max_anisotropy, mip_linear, ..sampler() }, 1.0);
        scene.instances[0].world_from_object = Mat4::from_scale(Vec3::splat(2.0));
        let eye = Vec3::new(0.0, -2.5, 0.25);
        scene.cameras[0].world_from_view = look_at_mat4(eye, Vec3::ZERO, Vec3::Z).inverse();
        scene.cameras[0].projection = Projection::Perspective { yfov_rad: 0.5, znear_m: 0.1, zfar_m: None };
        scene
    };
    let linear = |pixels: &[[u8; 4]]| -> Vec<f64> {
        let light = |v: f64| if v > 0.04045 { ((v + 0.055) / 1.055).powf(2.4) } else { v / 12.92 };
        pixels.iter().map(|p| light(f64::from(p[0]) / 255.0)).collect()
    };
    on_device(None, |gpu| {
        if !gpu.device().features().sampler_anisotropy {
            return super::common::ignored("the device has no anisotropic filter");
        }
        const SIZE: [u32; 2] = [128, 64];
        const FINER: u32 = 16;
        let fine = linear(&picture(gpu, &stripes(1, None), SIZE.map(|n| n * FINER)));
        let truth = |i: usize| {
            let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]];
            let at = |dx, dy| fine[((y * FINER + dy) * SIZE[0] * FINER + x * FINER + dx) as usize];
            let all = (0..FINER * FINER).map(|k| at(k % FINER, k / FINER)).sum::<f64>();
            all / f64::from(FINER * FINER)
        };
        let error = |max_anisotropy| {
            let shown = linear(&picture(gpu, &stripes(max_anisotropy, Some(true)), SIZE));
            let squares = shown.iter().enumerate().map(|(i, v)| (v - truth(i)).powi(2)).sum::<f64>();
            (squares / shown.len() as f64).sqrt()
        };
        let errors = [1, 4, 16].map(error);
        println!("rms errors of light with anisotropy 1, 4, 16: {errors:.4?}");
        assert!(errors[1] < errors[0] * 0.7 && errors[2] < errors[0] * 0.5, "{errors:?}");
    });
}

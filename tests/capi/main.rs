//! The C interface: its header is made of its sources, and a host written in C, with a device of its own, gets the picture that Rust
//! gets.

#[path = "../common/mod.rs"]
mod common;

use std::path::Path;
use std::process::Command;

use ontile::glam::{Mat4, Quat, Vec2, Vec3, vec3};
use ontile::gpu::{
    Headless, HeadlessOptions, Offscreen, OverlayFrame, OverlayPart, OverlayVertex, PipelineCache,
    RendererConfig, View,
};
use ontile::picture::Pixels;
use ontile::plan::{Layout, Needs, Options, Plan};
use ontile::scene::{
    Camera, Environment, Image, Instance, Light, LightKind, Material, Mesh, Play, PreRotation, Probe,
    Projection, Sampler, Scene, Texture, TextureRef, World,
};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

const GUARD: &str = "ONTILE_H";
const ABOUT: &str = "\
/* ontile: deferred shading that never leaves the tile. Generated from src/capi by cbindgen.
 *
 * Objects are used by one thread at a time; several renderers on one device may be used by several threads. Functions that return an
 * OntileResult leave their results untouched when they fail, and ontile_last_error says why. src/embedding.md has the whole of it.
 */";

/// What vulkan.h declares.
const VULKAN: [&str; 12] = [
    "VkInstance",
    "VkPhysicalDevice",
    "VkDevice",
    "VkQueue",
    "VkAllocationCallbacks",
    "PFN_vkGetInstanceProcAddr",
    "VkCommandBuffer",
    "VkImage",
    "VkImageView",
    "VkFormat",
    "VkImageUsageFlags",
    "VkImageLayout",
];

/// Types of values whose fields are plain numbers, since a number that is none of them must be refused and not be undefined.
const VALUES: [&str; 7] = [
    "OntileAlphaMode",
    "OntileKind",
    "OntileLightKind",
    "OntileMips",
    "OntileProjection",
    "OntileShadow",
    "OntileWrap",
];

/// The header as the sources have it now.
fn header() -> String {
    let mut config = cbindgen::Config {
        language: cbindgen::Language::C,
        header: Some(ABOUT.into()),
        include_guard: Some(GUARD.into()),
        no_includes: true,
        sys_includes: ["stdbool.h", "stddef.h", "stdint.h", "vulkan/vulkan.h"].map(String::from).to_vec(),
        cpp_compat: true,
        style: cbindgen::Style::Both,
        line_length: 110,
        usize_is_size_t: true,
        documentation_style: cbindgen::DocumentationStyle::Cxx,
        ..cbindgen::Config::default()
    };
    config.enumeration.prefix_with_name = true;
    config.enumeration.rename_variants = cbindgen::RenameRule::ScreamingSnakeCase;
    config.export.exclude = VULKAN.map(String::from).to_vec();
    config.export.include = VALUES.map(String::from).to_vec();
    let mut builder = cbindgen::Builder::new().with_config(config);
    let folder = std::fs::read_dir(root().join("src/capi")).unwrap();
    let mut files: Vec<_> = folder.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    // mod.rs leads to all others, which would come twice.
    let is_source = |path: &Path| path.extension().is_some_and(|e| e == "rs") && !path.ends_with("mod.rs");
    for file in files.iter().filter(|file| is_source(file)) {
        builder = builder.with_src(file);
    }
    let mut text = Vec::new();
    builder.generate().unwrap_or_else(|e| panic!("{e}")).write(&mut text);
    without_safety(&String::from_utf8(text).unwrap())
}

/// Without the sections that Rust's documentation wants of every function that takes pointers.
fn without_safety(text: &str) -> String {
    let mut kept = Vec::new();
    let mut within = false;
    for line in text.lines() {
        if line == "/// # Safety" {
            within = true;
            kept.pop();
        }
        within &= line.starts_with("///");
        if !within {
            kept.push(line);
        }
    }
    kept.join("\n") + "\n"
}

#[test]
fn the_header_is_that_of_the_sources() {
    let path = root().join("src/capi/ontile.h");
    let fresh = header();
    if std::env::var_os("ONTILE_UPDATE").is_some() {
        std::fs::write(&path, &fresh).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        kept == fresh,
        "{} is not what the sources say: run ONTILE_UPDATE=1 cargo test --test capi",
        path.display()
    );
}

/// The picture on the square.
const KTX2: &str = "tests/textures/uastc.ktx2";
/// What it reflects.
const AROUND: &str = "assets/dusk.hdr";
/// What moves by itself, and when.
const MOVING: &str = "assets/charmer.glb";
const TIME_S: f64 = 1.25;

/// What `host.c` builds.
fn square() -> World {
    let mut world = World::new("square");
    let file = std::fs::read(root().join(KTX2)).unwrap();
    let image = world.add(Image::from_ktx2("tiles", &file).unwrap()).unwrap();
    let texture = world.add(Texture { image: image.index(), sampler: Sampler::default() }).unwrap();
    let material = Material {
        base_color_factor: vec3(0.8, 0.4, 0.2).extend(1.0),
        base_color_texture: Some(TextureRef {
            texture: texture.index(),
            texcoord: 0,
            uv_from_texcoord: TextureRef::IDENTITY,
        }),
        metallic_factor: 0.0,
        roughness_factor: 0.5,
        ..Material::default()
    };
    let material = world.add(material).unwrap();
    let corners = (0..25).map(|i| Vec2::new((i % 5) as f32, (i / 5) as f32) * 0.25 - 0.5);
    let quads = (0..4).flat_map(|y| (0..4).map(move |x| y * 5 + x));
    let mesh = world
        .add(Mesh {
            positions: corners.clone().map(|corner| corner.extend(0.0)).collect(),
            normals: vec![Vec3::Z; 25],
            texcoords: [corners.map(|corner| corner + 0.5).collect(), Vec::new()],
            indices: quads.flat_map(|i| [i, i + 1, i + 6, i, i + 6, i + 5]).collect(),
            material: material.index(),
            ..Mesh::default()
        })
        .unwrap();
    world.add(Instance::new(mesh.index(), Mat4::IDENTITY)).unwrap();
    let lamp = Light::new(LightKind::Point { intensity_cd: 6.0 });
    world.add(Light { position_world: vec3(0.5, 0.5, 1.5), ..lamp }).unwrap();
    let probe = Probe {
        name: String::new(),
        position_world: vec3(0.0, 0.0, 0.5),
        world_from_probe: Quat::IDENTITY,
        half_size_m: vec3(2.0, 1.0, 1.0),
        falloff_m: 0.25,
        environment: Environment::load(&root().join(AROUND)).unwrap(),
    };
    world.set_probes(vec![probe]).unwrap();
    world
}

/// The pictures that Rust gets: the square as it stands, moved and upside down, and what a file's animation moves, before and after.
fn expected() -> Vec<u8> {
    let device_name_part = Some("llvmpipe".into());
    let host = Headless::new(&HeadlessOptions { device_name_part, ..HeadlessOptions::default() }).unwrap();
    let device = host.device();
    let mut world = square();
    let camera = Camera {
        name: String::new(),
        world_from_view: Mat4::from_translation(vec3(0.0, 0.0, 2.0)),
        projection: Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None },
    };
    let mut pictures = Vec::new();
    let mut draw = |world: &World, camera: &Camera, overlay: bool, pre_rotation: PreRotation| {
        let options = Options { size: [160, 96], layout: Layout::Ontile128, overlay, ..Options::default() };
        let plan = Plan::new(Needs::of(world.scene()), options, &device.limits()).unwrap();
        let cache = PipelineCache::new(device, &[]).unwrap();
        let mut frame =
            Offscreen::new(device, world.scene(), plan, RendererConfig::default(), &cache).unwrap();
        frame.pre_rotate(pre_rotation);
        if overlay {
            let corner =
                |position| OverlayVertex { position, texcoord: [0.25, 0.5], color: [0, 128, 0, 128] };
            let part = OverlayPart { clip_px: [0, 0, 160, 96], indices: 0..3 };
            let vertices = [[0.0, 0.0], [30.0, 0.0], [0.0, 20.0]].map(corner);
            let (indices, parts) = (&[0, 1, 2], &[part]);
            let over = OverlayFrame { vertices: &vertices, indices, parts, pixels_per_point: 2.0 };
            let renderer = frame.renderer_mut();
            renderer.set_overlay_image([2, 1], &[255, 255, 255, 255, 255, 0, 0, 255]).unwrap();
            renderer.set_overlay(0, &over).unwrap();
        }
        frame.render(&View { camera, exposure_ev: 0.0 }).unwrap();
        match frame.picture().pixels {
            Pixels::Rgba8(bytes) => pictures.extend(bytes),
            Pixels::Rgba32F(_) => panic!("the output has 8 bits a channel"),
        }
    };
    draw(&world, &camera, true, PreRotation::Identity);
    let instance = world.ids::<Instance>().next().unwrap();
    world.place(instance, Mat4::from_translation(vec3(0.3, 0.1, -0.5))).unwrap();
    draw(&world, &camera, true, PreRotation::Rotate180);
    let mut world = World::from(Scene::load_moving(&root().join(MOVING)).unwrap());
    for time_s in [0.0, TIME_S] {
        world.animate(&[Play { animation: 0, time_s }]).unwrap();
        draw(&world, &world.scene().cameras[0], false, PreRotation::Identity);
    }
    pictures
}

/// Runs a program; what it said if it failed.
fn run(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    match output.status.success() {
        true => Ok(()),
        false => Err(format!("{command:?}: {}\n{}", output.status, String::from_utf8_lossy(&output.stderr))),
    }
}

#[test]
fn a_host_in_c_gets_the_same_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let probe = folder.join("probe.c");
    std::fs::write(&probe, "#include <vulkan/vulkan.h>\n").unwrap();
    if let Err(why) = run(Command::new("cc").arg("-fsyntax-only").arg(&probe)) {
        return common::ignored_unless_required(&format!("no C compiler with Vulkan's headers: {why}"));
    }
    run(Command::new(root().join("tools/capi")).args(["--profile", "dev"]).arg(folder)).unwrap();
    let flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];
    let source = root().join("tests/capi/host.c");
    let (include, library) = (folder.join("include"), folder.join("lib/libontile.a"));
    let loader = ["-l:libvulkan.so.1", "-lm", "-ldl", "-lpthread"];
    let host = folder.join("host");
    let mut compile = Command::new("cc");
    compile.args(flags).arg("-I").arg(&include).arg("-o").arg(&host).arg(&source).arg(&library).args(loader);
    run(&mut compile).unwrap();
    let shared = folder.join("shared");
    let mut compile = Command::new("cc");
    compile
        .args(flags)
        .arg("-I")
        .arg(&include)
        .arg("-o")
        .arg(&shared)
        .arg(&source)
        .arg("-L")
        .arg(folder.join("lib"));
    run(compile.arg("-lontile").args(loader)).unwrap();

    let wanted = expected();
    for (host, what) in [(&host, "static library"), (&shared, "shared library")] {
        let pixels = folder.join("pixels");
        let mut run = Command::new(host);
        run.arg("llvmpipe")
            .arg(&pixels)
            .arg(root().join(KTX2))
            .arg(root().join(MOVING))
            .arg(root().join(AROUND))
            .env("LD_LIBRARY_PATH", folder.join("lib"));
        let output = run.output().unwrap();
        if output.status.code() == Some(77) {
            return common::ignored_unless_required("no lavapipe with a validation layer for a host in C");
        }
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{what}: {}\n{said}", output.status);
        let actual = std::fs::read(&pixels).unwrap();
        assert_eq!(actual.len(), wanted.len());
        let pictures: Vec<_> = wanted.chunks(wanted.len() / 4).collect();
        let differing = |(a, b): (&[u8], &&[u8])| a.iter().zip(*b).filter(|(a, b)| a != b).count();
        let different: Vec<_> = actual.chunks(wanted.len() / 4).zip(&pictures).map(differing).collect();
        assert_eq!(different, [0; 4], "{what}: so many bytes of each picture differ");
        assert!(pictures[0] != pictures[1] && pictures[2] != pictures[3], "frames must differ");
    }
}

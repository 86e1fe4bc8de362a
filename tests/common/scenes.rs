//! Scenes built by hand, small enough to render often; together they use every kind of surface, light and camera.

use ontile::glam::{DVec3, Mat4, Vec2, Vec3, Vec4, camera::rh::view::look_at_mat4};
use ontile::scene::{
    AlphaMode, Background, Camera, Fog, FogHeight, GlobeMap, GlobePicture, Image, Instance, Light, LightKind,
    Lightmap, LightmapRect, Material, Mesh, Projection, Sampler, Scene, Texture, TextureRef,
};
use std::f32::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use super::environments;

mod parts;
use parts::*;

#[path = "decal_scenes.rs"]
pub mod decal_scenes;
#[path = "shadow_scenes.rs"]
pub mod shadow_scenes;

#[path = "glass_scenes.rs"]
pub mod glass_scenes;
#[path = "media_scenes.rs"]
pub mod media_scenes;
#[path = "moving_scenes.rs"]
pub mod moving_scenes;
#[path = "particle_scenes.rs"]
pub mod particle_scenes;

/// The scenes that the repository ships, loaded as the program does, in order of name.
///
/// # Panics
///
/// If there is none, or one does not load.
pub fn shipped() -> Vec<Scene> {
    let scenes: Vec<_> = shipped_files()
        .iter()
        .map(|path| {
            let mut scene = Scene::load(path).unwrap_or_else(|error| panic!("{error}"));
            scene.keep_lights(None, Some(Scene::DEFAULT_SHADOWS));
            scene
        })
        .collect();
    assert!(!scenes.is_empty(), "assets/ ships no scene");
    scenes
}

/// All that can be on the tile together.
pub fn tram_stop() -> Scene {
    shipped().into_iter().find(|scene| scene.name == "stop").expect("assets/ ships it")
}

/// The files of [`shipped`].
pub fn shipped_files() -> Vec<PathBuf> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let entries = std::fs::read_dir(&assets).unwrap_or_else(|e| panic!("{}: {e}", assets.display()));
    let mut files: Vec<_> = entries.map(|entry| entry.expect("assets can be listed").path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "glb"));
    files.sort();
    files
}

/// The Khronos sample models beside the checkout (or in the folder `assets` of `ONTILE_SHARED`), in order of name. Empty
/// where they are absent, which is said.
pub fn sample_files() -> Vec<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let models = std::env::var_os("ONTILE_SHARED").map_or_else(beside, PathBuf::from).join("assets/models");
    let Ok(entries) = std::fs::read_dir(&models) else {
        super::ignored(&format!("sample models: {} absent", models.display()));
        return Vec::new();
    };
    let mut files = Vec::new();
    for folder in entries.map(|entry| entry.expect("models can be listed").path()) {
        let name = folder.file_name().expect("a folder has a name");
        let both = ["glb", "gltf"].map(|extension| folder.join(name).with_extension(extension));
        files.extend(both.into_iter().find(|file| file.is_file()));
    }
    files.sort();
    files
}

/// All scenes that are built by hand.
pub fn built() -> Vec<Scene> {
    let mut all = vec![
        every_feature(),
        orthographic(),
        lights_only(),
        extents(),
        hemisphere_only(),
        globes(),
        lit_textures(),
        emissive(),
        no_lights(),
        wholly_unlit(),
        one_unlit_triangle(),
        one_lit_triangle(),
        nothing(),
        empty_mesh(),
        one_empty_mesh(),
        dark_lights(),
        inside(),
        shadow_scenes::shadows(),
        foggy(),
        foggy_lights(),
        foggy_unlit(),
        lightmapped(),
        lightmapped_alone(),
        before_sky(),
        sky_unlit(),
        sky_alone(),
        decal_scenes::decals(),
        decal_scenes::color_decals(),
        decal_scenes::decals_behind_glass(),
    ];
    all.extend(environments::all());
    all.extend(glass_scenes::all());
    all.extend(particle_scenes::all());
    all.extend(media_scenes::all());
    all.extend(moving_scenes::all());
    all
}

/// All kinds of lights; emissive, unlit and lit surfaces; ambient light with an occlusion texture; normal map, vertex
/// colours, alpha mask, double-sided, mirrored, TEXCOORD_1, texture transform.
pub fn every_feature() -> Scene {
    let mut scene = lit_textures();
    scene.name = "every_feature".into();
    scene.ambient_nt = Vec3::new(0.10, 0.12, 0.15);
    scene.materials[FLOOR].occlusion_texture = Some(texture(0));
    let lamp = Material {
        name: "lamp".into(),
        emissive_factor: Vec3::new(1.5, 0.9, 0.3),
        emissive_texture: Some(texture(0)),
        ..rough("lamp", Vec3::splat(0.2))
    };
    add(&mut scene, sphere(), lamp, &[at(0.0, 1.3, 0.0) * Mat4::from_scale(Vec3::splat(0.3))]);
    let sign = Material {
        name: "sign".into(),
        base_color_factor: Vec4::new(0.1, 0.6, 0.3, 1.0),
        unlit: true,
        ..Material::default()
    };
    add(&mut scene, square(), sign, &[at(1.5, 1.2, -0.6) * Mat4::from_scale(Vec3::splat(0.4))]);
    scene
}

/// [`every_feature`] in parallel projection.
pub fn orthographic() -> Scene {
    let mut scene = every_feature();
    scene.name = "orthographic".into();
    scene.cameras[0].projection =
        Projection::Orthographic { xmag_m: 2.6, ymag_m: 1.5, znear_m: 0.1, zfar_m: 20.0 };
    scene
}

/// All kinds of lights on surfaces without textures; nothing needs the light target.
pub fn lights_only() -> Scene {
    let mut scene = Scene { name: "lights_only".into(), cameras: vec![camera()], ..Scene::default() };
    let placed = [at(-1.1, 0.5, 0.0), at(1.1, 0.5, 0.0)].map(|t| t * Mat4::from_scale(Vec3::splat(0.5)));
    add(&mut scene, sphere(), rough("clay", Vec3::new(0.7, 0.35, 0.2)), &placed[..1]);
    let gold =
        Material { metallic_factor: 1.0, roughness_factor: 0.3, ..rough("gold", Vec3::new(1.0, 0.78, 0.34)) };
    add(&mut scene, sphere(), gold, &placed[1..]);
    let floor = Mat4::from_rotation_x(-PI / 2.0) * Mat4::from_scale(Vec3::splat(3.0));
    add(&mut scene, square(), rough("floor", Vec3::splat(0.5)), &[floor]);
    scene.lights = lights();
    scene
}

/// Boxes, hemispheres and back colours beside [`lights_only`]'s.
pub fn extents() -> Scene {
    let mut scene = Scene { name: "extents".into(), ..lights_only() };
    let light = |kind, color, position_world, towards| {
        Light { color, position_world, ..Light::new(kind) }.towards(towards)
    };
    let cube = |illuminance_lx, size_m, falloff_m| LightKind::Box { illuminance_lx, size_m, falloff_m };
    scene.lights[0].back_color = Vec3::new(0.1, 0.2, 0.4);
    let red = Vec3::new(1.0, 0.3, 0.2);
    let soft = cube(2.0, Vec3::new(1.5, 1.0, 2.0), 0.4);
    let soft = light(soft, red, Vec3::new(-1.0, 0.6, 0.2), Vec3::new(0.2, -1.0, 0.1));
    scene.lights.push(Light { back_color: Vec3::new(0.0, 0.3, 0.0), ..soft });
    let sharp = cube(1.0, Vec3::new(0.9, 4.0, 1.5), 0.0);
    scene.lights.push(light(sharp, Vec3::ONE, Vec3::new(1.0, 0.5, 0.5), Vec3::new(1.0, -1.0, -0.3)));
    let sky = LightKind::Hemisphere { illuminance_lx: 0.4 };
    let sky = light(sky, Vec3::new(0.5, 0.7, 1.0), Vec3::ZERO, Vec3::NEG_Y);
    scene.lights.push(Light { back_color: Vec3::new(0.4, 0.3, 0.2), ..sky });
    scene
}

/// [`lights_only`] under nothing but a hemisphere: no light has a place in a buffer.
pub fn hemisphere_only() -> Scene {
    let mut scene = Scene { name: "hemisphere_only".into(), ..lights_only() };
    let sky = Light {
        color: Vec3::new(0.3, 0.6, 1.0),
        ..Light::new(LightKind::Hemisphere { illuminance_lx: 2.0 })
    };
    scene.lights = vec![sky.towards(Vec3::new(0.3, -1.0, 0.0))];
    scene
}

/// [`extents`], where most lights shine through globe maps: pictures of two sizes, one used twice.
pub fn globes() -> Scene {
    let mut scene = Scene { name: "globes".into(), ..extents() };
    let small = Image { width: 16, rgba8: bumps().rgba8[..16 * 32 * 4].to_vec(), ..bumps() };
    scene.images = vec![tiles(), small];
    let flat = |image| GlobePicture::Flat { image };
    let map = |picture, rotation_rad| Some(GlobeMap { picture, rotation_rad });
    scene.lights[1].globe_map = map(GlobePicture::Cube { images: [0, 1, 0, 1, 1, 0] }, 0.3);
    scene.lights[2].globe_map = map(flat(0), 0.5);
    scene.lights[3].globe_map = map(flat(0), -0.2);
    scene
}

/// The index of the textured floor's material in [`lit_textures`] and [`every_feature`].
const FLOOR: usize = 0;

/// Lit surfaces with textures; nothing needs the light target.
pub fn lit_textures() -> Scene {
    let mut scene = Scene { name: "lit_textures".into(), cameras: vec![camera()], ..Scene::default() };
    scene.images = vec![tiles(), bumps()];
    scene.textures = [0, 1].map(|image| Texture { image, sampler: Sampler::default() }).to_vec();
    let thrice =
        TextureRef { uv_from_texcoord: [Vec3::new(3.0, 0.5, 0.1), Vec3::new(-0.5, 3.0, 0.2)], ..texture(0) };
    let floor = Material { base_color_texture: Some(thrice), ..rough("floor", Vec3::splat(0.9)) };
    let flat = Mat4::from_rotation_x(-PI / 2.0) * Mat4::from_scale(Vec3::splat(3.0));
    add(&mut scene, square(), floor, &[flat]);
    let bumpy = Material {
        metallic_factor: 1.0,
        roughness_factor: 0.8,
        metallic_roughness_texture: Some(texture(0)),
        normal_texture: Some(texture(1)),
        normal_scale: 0.7,
        ..rough("bumpy", Vec3::new(0.9, 0.6, 0.5))
    };
    let half = Vec3::splat(0.5);
    let mirrored = at(1.1, 0.5, 0.0) * Mat4::from_scale(half * Vec3::new(-1.0, 1.0, 1.0));
    add(&mut scene, sphere(), bumpy, &[at(-1.1, 0.5, 0.0) * Mat4::from_scale(half), mirrored]);
    let banner = Material { double_sided: true, ..rough("banner", Vec3::ONE) };
    let corners = [
        Vec4::new(1.0, 0.1, 0.1, 1.0),
        Vec4::new(0.1, 1.0, 0.1, 1.0),
        Vec4::new(0.1, 0.1, 1.0, 1.0),
        Vec4::ONE,
    ];
    let colored = Mesh { colors: corners.to_vec(), ..square() };
    // Turned away: its back is seen.
    let away = at(-0.4, 0.5, 0.6) * Mat4::from_rotation_y(0.8 * PI) * Mat4::from_scale(Vec3::splat(0.3));
    add(&mut scene, colored, banner, &[away]);
    let lattice = Material {
        base_color_texture: Some(TextureRef { texcoord: 1, ..texture(0) }),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        double_sided: true,
        ..rough("lattice", Vec3::new(0.8, 0.8, 0.4))
    };
    add(&mut scene, square(), lattice, &[at(0.5, 0.5, 0.5) * Mat4::from_scale(Vec3::splat(0.35))]);
    scene.lights = lights();
    scene
}

/// [`lights_only`], where one of the surfaces glows.
pub fn emissive() -> Scene {
    let mut scene = lights_only();
    scene.name = "emissive".into();
    scene.materials[0].emissive_factor = Vec3::new(0.2, 0.5, 1.2);
    scene
}

/// [`emissive`] in the dark.
pub fn no_lights() -> Scene {
    Scene { name: "no_lights".into(), lights: Vec::new(), ..emissive() }
}

/// Textured unlit surfaces that hide each other.
pub fn wholly_unlit() -> Scene {
    let mut scene = lit_textures();
    scene.name = "wholly_unlit".into();
    scene.lights.clear();
    for material in &mut scene.materials {
        material.unlit = true;
    }
    scene
}

/// The least that can be drawn.
pub fn one_unlit_triangle() -> Scene {
    let mut scene = one_lit_triangle();
    scene.name = "one_unlit_triangle".into();
    scene.materials[0].unlit = true;
    scene.lights.clear();
    scene
}

/// The least that can be lit.
pub fn one_lit_triangle() -> Scene {
    let mut scene = Scene { name: "one_lit_triangle".into(), cameras: vec![camera()], ..Scene::default() };
    let triangle = Mesh { indices: vec![0, 1, 2], ..square() };
    add(&mut scene, triangle, rough("paper", Vec3::new(0.2, 0.5, 0.8)), &[at(0.0, 1.0, 0.0)]);
    scene.lights = lights();
    scene
}

/// No instance, mesh, material or light; the picture is the background.
pub fn nothing() -> Scene {
    Scene { name: "nothing".into(), cameras: vec![camera()], ..Scene::default() }
}

/// The only instance has no triangles: [`nothing`]'s picture.
pub fn empty_mesh() -> Scene {
    let mut scene = Scene { name: "empty_mesh".into(), lights: lights(), ..nothing() };
    add(&mut scene, Mesh::default(), rough("void", Vec3::ONE), &[at(0.0, 0.5, 0.0)]);
    scene
}

/// [`lights_only`] beside an instance without triangles, whose material would need a light target.
pub fn one_empty_mesh() -> Scene {
    let mut scene = Scene { name: "one_empty_mesh".into(), ..lights_only() };
    let glow = Material { emissive_factor: Vec3::ONE, ..rough("void", Vec3::ONE) };
    add(&mut scene, Mesh::default(), glow, &[at(0.0, 0.5, 0.0)]);
    scene
}

/// [`emissive`] with lights of all kinds that add nothing: their intensity or their range is 0.
pub fn dark_lights() -> Scene {
    let dark = |light: &Light| {
        let kind = match light.kind {
            LightKind::Directional { .. } => LightKind::Directional { illuminance_lx: 0.0 },
            LightKind::Point { .. } => LightKind::Point { intensity_cd: 0.0 },
            LightKind::Spot { inner_cone_rad, outer_cone_rad, .. } => {
                LightKind::Spot { intensity_cd: 0.0, inner_cone_rad, outer_cone_rad }
            }
            LightKind::Box { size_m, falloff_m, .. } => {
                LightKind::Box { illuminance_lx: 0.0, size_m, falloff_m }
            }
            LightKind::Hemisphere { .. } => LightKind::Hemisphere { illuminance_lx: 0.0 },
        };
        Light { kind, ..light.clone() }
    };
    let near = |light: &Light| Light { range_m: Some(0.0), ..light.clone() };
    let all = lights();
    let lights = all.iter().map(dark).chain(all[1..].iter().map(near)).collect();
    Scene { name: "dark_lights".into(), lights, ..emissive() }
}

/// [`every_feature`] from within a sphere, with a light at the very camera.
pub fn inside() -> Scene {
    let mut scene = Scene { name: "inside".into(), ..every_feature() };
    let eye = scene.cameras[0].world_from_view.transform_point3(Vec3::ZERO);
    let shell = Material { double_sided: true, ..rough("shell", Vec3::new(0.6, 0.5, 0.4)) };
    add(&mut scene, sphere(), shell, &[Mat4::from_translation(eye)]);
    scene.lights[1].position_world = eye;
    scene
}

/// [`every_feature`] in a layer of fog, before a colour.
pub fn foggy() -> Scene {
    in_fog("foggy", every_feature())
}

/// [`lights_only`], where the lighting stage writes the picture, likewise.
pub fn foggy_lights() -> Scene {
    in_fog("foggy_lights", lights_only())
}

/// [`wholly_unlit`] likewise.
pub fn foggy_unlit() -> Scene {
    in_fog("foggy_unlit", wholly_unlit())
}

/// [`environment`] with a lightmap on the floor, a lattice and one of the spheres: textured, masked and plain; the sphere's mesh
/// has instances with and without.
pub fn lightmapped() -> Scene {
    let mut scene = Scene { name: "lightmapped".into(), ..environments::environment() };
    add_lightmap(&mut scene, |name| ["floor", "lattice", "bumpy", "banner"].contains(&name));
    scene
}

/// [`lights_only`] with a lightmap on everything and no light besides.
pub fn lightmapped_alone() -> Scene {
    let mut scene = Scene { name: "lightmapped_alone".into(), ..lights_only() };
    scene.lights.iter_mut().for_each(|light| light.baked = true);
    add_lightmap(&mut scene, |_| true);
    scene
}

/// Gives a part of a smooth lightmap to the first instance of each mesh of these names.
fn add_lightmap(scene: &mut Scene, wanted: impl Fn(&str) -> bool) {
    const SIDE: u32 = 64;
    let texel = |i: u32| {
        let (x, y) = (f64::from(i % SIDE) * 0.1, f64::from(i / SIDE) * 0.07);
        DVec3::new(x.sin() + 1.2, (x + y).cos() + 1.1, (y * 1.3).sin() + 1.05) * 0.6
    };
    let light: Vec<_> = (0..SIDE * SIDE).map(texel).collect();
    scene.lightmap = Some(Lightmap::encode(SIDE, SIDE, &light));
    let mut seen = Vec::new();
    for instance in &mut scene.instances {
        let mesh = &mut scene.meshes[instance.mesh];
        if !wanted(&mesh.name) || seen.contains(&instance.mesh) {
            continue;
        }
        if mesh.texcoords[1].is_empty() {
            mesh.texcoords[1] = mesh.positions.iter().map(|p| p.truncate() * 0.5 + 0.5).collect();
        }
        let origin = Vec2::new(0.05 + 0.2 * seen.len() as f32, 0.1);
        instance.lightmap = Some(LightmapRect { origin, size: Vec2::new(0.1, 0.35) });
        seen.push(instance.mesh);
    }
}

/// [`environment`] before its own picture, in fog that does not reach it.
pub fn before_sky() -> Scene {
    let background = Background::Environment;
    Scene { name: "before_sky".into(), background, ..in_fog("", environments::environment()) }
}

/// [`wholly_unlit`] before an environment.
pub fn sky_unlit() -> Scene {
    let (environment, background) = (environments::environment().environment, Background::Environment);
    Scene { name: "sky_unlit".into(), environment, background, ..wholly_unlit() }
}

/// Nothing but the environment.
pub fn sky_alone() -> Scene {
    let (environment, background) = (environments::environment().environment, Background::Environment);
    Scene { name: "sky_alone".into(), environment, background, ..nothing() }
}

fn in_fog(name: &str, scene: Scene) -> Scene {
    let height = Some(FogHeight { base_m: 0.2, scale_m: 0.7 });
    let fog = Fog { color_nt: Vec3::new(0.3, 0.4, 0.5), density_per_m: 0.3, height };
    let background = Background::Color(Vec3::new(0.05, 0.2, 0.6));
    Scene { name: name.into(), fog: Some(fog), background, ..scene }
}

//! What features cost: by hand, from what a renderer of that feature cannot do without.

use super::super::common::environments;
use ontile::glam::{DVec3, Mat4, Vec2, Vec3, Vec4};
use ontile::scene::{
    AlphaMode, Background, Decal, DecalChannels, Fog, FogHeight, GlobeMap, GlobePicture, Image, Instance,
    Light, LightKind, Lightmap, LightmapRect, Material, Mesh, Particle, Particles, Sampler, Scene, Shadow,
    Texture, TextureRef, Transmission,
};

pub const UNLIT: &str = "attachment output, subpass geometry, pipeline surface unlit, surface unlit: attribute position, \
                     surface unlit: binding frame, surface unlit: binding instances, surface unlit: binding material, \
                     buffer vertices, buffer indices, buffer materials, buffer frame, buffer instances";

/// By the sun.
pub const LIT: &str = "attachment output, attachment depth, attachment normal_roughness, attachment base_metallic, \
                   subpass geometry, subpass lighting, pipeline surface lit, surface lit: attribute position, \
                   surface lit: attribute normal, surface lit: binding frame, surface lit: binding instances, \
                   surface lit: binding material, pipeline lighting, lighting: binding frame, lighting: binding lights, \
                   lighting: input depth, lighting: input normal_roughness, lighting: input base_metallic, \
                   lighting: HAS_DIRECTIONAL, lighting: FOLD, surface lit: DEPTH_TARGET, \
                   buffer vertices, buffer indices, buffer materials, buffer frame, buffer instances, buffer lights";

/// Light that exists before lighting: it is summed, and lighting does not write the output itself.
const SUMMED: &str = "attachment light, subpass tonemap, pipeline tonemap, tonemap: binding frame, tonemap: input light, \
                      surface lit: LIGHT_TARGET";
const FOLDED: &str = "lighting: FOLD";

const TEXTURED: &str = "lit: attribute texture coordinates, lit: binding textures, image picture";
const LISTED: &str = "lighting: binding light lists, buffer light lists, lighting: CLUSTERS";

const DECAL: &str = "subpass decals, pipeline decal, decal: binding frame, decal: binding decals, decal: binding material, \
                     decal: input depth, decal: input normal_roughness, buffer decals";

fn decal(scene: &mut Scene, channels: DecalChannels) {
    let material = scene.materials.len();
    scene.materials.push(Material { name: "paint".into(), ..Material::default() });
    scene.decals.push(Decal { name: "spot".into(), channels, ..Decal::new(material, Mat4::IDENTITY) });
}

const MEDIUM: &str = "attachment depth_test, subpass media, buffer media, pipeline absorption, absorption: attribute position, \
                      absorption: attribute normal, absorption: binding frame, absorption: binding instances, \
                      absorption: binding material, absorption: binding medium, absorption: input depth_test, \
                      absorption: HAS_BEHIND, absorption: ABSORBS, pipeline medium, medium: attribute position, \
                      medium: attribute normal, medium: binding frame, medium: binding instances, medium: binding material, \
                      medium: binding medium, medium: binding lights, medium: HAS_DIRECTIONAL";

const SPARKS: &str = "subpass particles, pipeline particles, particles: binding frame, particles: binding particles, \
                      particles: binding material, particles: HAS_BEHIND, particles: input depth_test, \
                      attachment depth_test, buffer particles";

fn particles(scene: &mut Scene, textured: bool) {
    let material = scene.materials.len();
    let emissive_texture = if textured { picture(scene) } else { None };
    let emissive_factor = Vec3::ONE;
    scene.materials.push(Material { emissive_factor, emissive_texture, ..Material::default() });
    let spark = Particle { position_world: Vec3::ZERO, size_m: 1.0, rotation_rad: 0.0, color: Vec3::ONE };
    scene.particles.push(Particles { name: "sparks".into(), ..Particles::new(material, 0.1, vec![spark]) });
}

/// Something that a scene may have.
pub struct Feature {
    /// Its name.
    pub name: &'static str,
    /// Adds it to a base.
    pub add: fn(&mut Scene),
    /// What it adds to the base, and what it takes away; `lit:` is the base's pipeline of surfaces.
    pub cost: &'static [&'static str],
    /// See `cost`.
    pub instead_of: &'static str,
}

const fn feature(name: &'static str, add: fn(&mut Scene), cost: &'static [&'static str]) -> Feature {
    Feature { name, add, cost, instead_of: "" }
}

const fn summed(name: &'static str, add: fn(&mut Scene), cost: &'static [&'static str]) -> Feature {
    Feature { name, add, cost, instead_of: FOLDED }
}

fn picture(scene: &mut Scene) -> Option<TextureRef> {
    if scene.images.is_empty() {
        scene.images.push(Image { name: "picture".into(), width: 1, height: 1, rgba8: vec![255; 4] });
        scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    }
    Some(TextureRef { texture: 0, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY })
}

fn light(scene: &mut Scene, kind: LightKind, range_m: Option<f32>) {
    let light =
        Light { name: "added".into(), range_m, position_world: Vec3::new(0.0, 1.0, 1.0), ..Light::new(kind) };
    scene.lights.push(light.towards(Vec3::NEG_Z));
}

fn second_triangle(scene: &mut Scene) {
    scene.instances.push(Instance::new(0, Mat4::from_translation(Vec3::new(0.2, 1.0, -0.5))));
}

fn fog(scene: &mut Scene) {
    scene.fog = Some(Fog { color_nt: Vec3::ONE, density_per_m: 0.1, height: None });
}

fn sky(scene: &mut Scene) {
    scene.environment = environments::environment_alone().environment;
}

fn neighbour(scene: &mut Scene, material: Material) {
    let mesh = Mesh { material: scene.materials.len(), colors: Vec::new(), ..scene.meshes[0].clone() };
    scene.materials.push(material);
    scene.meshes.push(mesh);
}

/// A mesh of a material and a picture of its own that no instance shows.
fn unused(scene: &mut Scene) {
    picture(scene);
    let reference = TextureRef { texture: 0, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY };
    neighbour(scene, Material { base_color_texture: Some(reference), ..Material::default() });
}

const POINT: LightKind = LightKind::Point { intensity_cd: 3.0 };
const SPOT: LightKind = LightKind::Spot { intensity_cd: 3.0, inner_cone_rad: 0.2, outer_cone_rad: 0.4 };

/// What costs the same whether or not the surface is lit; the rest depends.
pub const OF_BOTH: &[Feature] = &[
    feature(
        "base colour texture",
        |s| s.materials[0].base_color_texture = picture(s),
        &[TEXTURED, "lit: SLOT_BASE_COLOR"],
    ),
    feature(
        "base colour at TEXCOORD_1",
        |s| s.materials[0].base_color_texture = picture(s).map(|t| TextureRef { texcoord: 1, ..t }),
        &[TEXTURED, "lit: SLOT_BASE_COLOR, lit: TEXCOORD_BITS"],
    ),
    feature(
        "base colour, transformed",
        |s| {
            let uv_from_texcoord = [Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0)];
            s.materials[0].base_color_texture = picture(s).map(|t| TextureRef { uv_from_texcoord, ..t });
        },
        &[TEXTURED, "lit: SLOT_BASE_COLOR, lit: TRANSFORM_BITS"],
    ),
    feature(
        "vertex colours",
        |s| s.meshes[0].colors = vec![Vec4::ONE; 4],
        &["lit: attribute colour, lit: VERTEX_COLOR"],
    ),
    feature(
        "alpha mask",
        |s| s.materials[0].alpha_mode = AlphaMode::Mask { cutoff: 0.5 },
        &["lit: ALPHA_MASK"],
    ),
    feature("second triangle", second_triangle, &["attachment depth_test"]),
    feature(
        "mirrored",
        |s| s.instances[0].world_from_object *= Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)),
        &[],
    ),
    feature("a dark light", |s| light(s, LightKind::Point { intensity_cd: 0.0 }, None), &[]),
    feature("an unused mesh", unused, &[]),
    feature(
        "occlusion without light from all around",
        |s| s.materials[0].occlusion_texture = picture(s),
        &[],
    ),
    feature("emissive texture without emission", |s| s.materials[0].emissive_texture = picture(s), &[]),
    feature(
        "normal map without tangents",
        |s| {
            s.meshes[0].tangents.clear();
            s.materials[0].normal_texture = picture(s);
        },
        &[],
    ),
    feature(
        "texture without texture coordinates",
        |s| {
            s.meshes[0].texcoords = [Vec::new(), Vec::new()];
            s.materials[0].base_color_texture = picture(s);
        },
        &[],
    ),
    feature(
        "clear air",
        |s| s.fog = Some(Fog { color_nt: Vec3::ONE, density_per_m: 0.0, height: None }),
        &[],
    ),
];

/// Where nothing is lit.
pub const OF_UNLIT: &[Feature] = &[
    feature("double-sided", |s| s.materials[0].double_sided = true, &[]),
    feature("a sun", |s| light(s, LightKind::Directional { illuminance_lx: 2.0 }, None), &[]),
    feature("a lamp", |s| light(s, POINT, Some(3.0)), &[]),
    feature(
        "a lamp with a picture and a shadow",
        |s| {
            light(s, SPOT, Some(3.0));
            picture(s);
            let lamp = s.lights.last_mut().unwrap();
            lamp.globe_map = Some(GlobeMap { picture: GlobePicture::Flat { image: 0 }, rotation_rad: 0.0 });
            lamp.shadow = Some(Shadow::default());
        },
        &[],
    ),
    feature("ambient light", |s| s.ambient_nt = Vec3::ONE, &[]),
    feature("an environment that is not seen", sky, &[]),
    feature("probes", |s| s.probes = environments::rooms(), &[]),
    feature("metallic-roughness", |s| s.materials[0].metallic_roughness_texture = picture(s), &[]),
    feature("normal map", |s| s.materials[0].normal_texture = picture(s), &[]),
    feature("emission", |s| s.materials[0].emissive_factor = Vec3::ONE, &[]),
    // The clear value.
    feature("background colour", |s| s.background = Background::Color(Vec3::new(0.1, 0.2, 0.3)), &[]),
    feature("fog", fog, &["lit: FOG, lit: FOG_RED, lit: FOG_GREEN, lit: FOG_BLUE, lit: FOG_DENSITY"]),
    feature(
        "sky",
        |s| {
            sky(s);
            s.background = Background::Environment;
        },
        &[
            "attachment depth_test, pipeline sky, sky: binding frame, sky: binding environment, sky: binding radiance, \
          image radiance, buffer environment",
        ],
    ),
];

/// Where the sun lights.
pub const OF_LIT: &[Feature] = &[
    feature("double-sided", |s| s.materials[0].double_sided = true, &["lit: DOUBLE_SIDED"]),
    feature("a lamp without an end", |s| light(s, POINT, None), &["lighting: HAS_POINT"]),
    feature("a lamp", |s| light(s, POINT, Some(3.0)), &[LISTED, "lighting: HAS_POINT"]),
    feature("a spot", |s| light(s, SPOT, Some(3.0)), &[LISTED, "lighting: HAS_SPOT"]),
    feature(
        "a spot with a picture",
        |s| {
            light(s, SPOT, Some(3.0));
            picture(s);
            let map = GlobeMap { picture: GlobePicture::Flat { image: 0 }, rotation_rad: 0.0 };
            s.lights.last_mut().unwrap().globe_map = Some(map);
        },
        &[LISTED, "lighting: HAS_SPOT, lighting: GLOBE_MAPS, lighting: binding globe maps, image globe maps"],
    ),
    feature(
        "a hemisphere",
        |s| light(s, LightKind::Hemisphere { illuminance_lx: 1.0 }, None),
        &["lighting: HAS_HEMISPHERE"],
    ),
    feature("light from behind", |s| s.lights[0].back_color = Vec3::ONE, &["lighting: HAS_BACK"]),
    feature("a shadow on nothing", |s| s.lights[0].shadow = Some(Shadow::default()), &[]),
    feature(
        "a shadow",
        |s| {
            second_triangle(s);
            s.lights[0].shadow = Some(Shadow::default());
        },
        &[
            "attachment depth_test, lighting: binding shadow views, lighting: binding shadow map, lighting: SHADOWS, \
          image shadow map, buffer shadow views, buffer casters, pipeline shadow caster, pipeline shadow clear, \
          shadow caster: attribute position, shadow caster: binding instances, shadow caster: push constants",
        ],
    ),
    summed(
        "a shadow volume",
        |s| {
            second_triangle(s);
            s.lights[0].shadow = Some(Shadow { volume: Some(true), ..Shadow::default() });
        },
        &[
            SUMMED,
            "attachment depth_stencil_test, buffer volume casters, buffer volume caster instances, lighting: SHADOW_VOLUMES, \
          pipeline shadow volume, shadow volume: binding frame, shadow volume: binding volume caster instances, \
          shadow volume: binding volume casters, shadow volume: push constants, pipeline shadowed light, shadowed light: HAS_DIRECTIONAL, \
          shadowed light: ONE_LIGHT, shadowed light: VOLUME_SHAPE, shadowed light: binding frame, shadowed light: binding lights, \
          shadowed light: input base_metallic, shadowed light: input depth, shadowed light: input normal_roughness",
        ],
    ),
    feature(
        "a mesh that bends",
        |s| s.meshes[0].deformation = Some(Default::default()),
        &["pipeline poses, buffer rest poses, buffer poses"],
    ),
    feature(
        "metallic-roughness",
        |s| s.materials[0].metallic_roughness_texture = picture(s),
        &[TEXTURED, "lit: SLOT_METALLIC_ROUGHNESS"],
    ),
    feature(
        "normal map",
        |s| s.materials[0].normal_texture = picture(s),
        &[TEXTURED, "lit: SLOT_NORMAL, lit: attribute tangent"],
    ),
    feature(
        "background colour",
        |s| s.background = Background::Color(Vec3::new(0.1, 0.2, 0.3)),
        &[
            "lighting: BACKGROUND, lighting: BACKGROUND_RED, lighting: BACKGROUND_GREEN, lighting: BACKGROUND_BLUE",
        ],
    ),
    feature(
        "fog",
        fog,
        &["lighting: FOG, lighting: FOG_RED, lighting: FOG_GREEN, lighting: FOG_BLUE, lighting: FOG_DENSITY"],
    ),
    feature(
        "fog by height",
        |s| {
            fog(s);
            s.fog.as_mut().unwrap().height = Some(FogHeight { base_m: 1.0, scale_m: 2.0 });
        },
        &[
            "lighting: FOG, lighting: FOG_RED, lighting: FOG_GREEN, lighting: FOG_BLUE, lighting: FOG_DENSITY, \
          lighting: FOG_BASE, lighting: FOG_INVERSE_HEIGHT",
        ],
    ),
    feature("a colour decal", |s| decal(s, DecalChannels::COLOR), &[DECAL, "decal: DECAL_BLENDED"]),
    feature(
        "a decal of two channels",
        |s| decal(s, DecalChannels { base_color: 1.0, roughness: 1.0, ..DecalChannels::NONE }),
        &[
            DECAL,
            "decal: input base_metallic, decal: DECAL_BASE_COLOR, decal: DECAL_ROUGHNESS, decal: DECAL_TARGETS",
        ],
    ),
    feature("a decal of which nothing is left", |s| decal(s, DecalChannels::NONE), &[]),
    summed("emission", |s| s.materials[0].emissive_factor = Vec3::ONE, &[SUMMED, "lit: EMISSIVE"]),
    summed(
        "emission by a texture",
        |s| {
            s.materials[0].emissive_factor = Vec3::ONE;
            s.materials[0].emissive_texture = picture(s);
        },
        &[SUMMED, TEXTURED, "lit: EMISSIVE, lit: SLOT_EMISSIVE"],
    ),
    summed(
        "ambient light",
        |s| s.ambient_nt = Vec3::ONE,
        &[SUMMED, "lit: AMBIENT, lit: binding split sum, image split sum"],
    ),
    summed(
        "ambient light and occlusion",
        |s| {
            s.ambient_nt = Vec3::ONE;
            s.materials[0].occlusion_texture = picture(s);
        },
        &[SUMMED, TEXTURED, "lit: AMBIENT, lit: SLOT_OCCLUSION, lit: binding split sum, image split sum"],
    ),
    summed(
        "an environment that is not seen",
        sky,
        &[
            SUMMED,
            "lit: AMBIENT, lit: ENVIRONMENT, lit: binding split sum, \
          lit: binding environment, lit: binding radiance, image split sum, image radiance, buffer environment",
        ],
    ),
    summed(
        "probes",
        |s| s.probes = environments::rooms(),
        &[
            SUMMED,
            "lit: AMBIENT, lit: ENVIRONMENT, lit: PROBES, \
          lit: binding split sum, lit: binding environment, lit: binding radiance, lit: binding probes, image split sum, \
          image radiance, buffer environment, buffer probes",
        ],
    ),
    summed(
        "a lightmap",
        |s| {
            s.lightmap = Some(Lightmap::encode(4, 4, &[DVec3::splat(0.7); 16]));
            s.instances[0].lightmap = Some(LightmapRect { origin: Vec2::ZERO, size: Vec2::ONE });
        },
        &[
            SUMMED,
            "lit: attribute texture coordinates, lit: LIGHTMAP, lit: LIGHTMAP_UNIT, lit: binding lightmap, \
          lit: binding lightmap parts, image lightmap, buffer lightmap parts",
        ],
    ),
    summed(
        "an unlit neighbour",
        |s| {
            neighbour(s, Material { unlit: true, name: "sign".into(), ..Material::default() });
            s.instances
                .push(Instance::new(s.meshes.len() - 1, Mat4::from_translation(Vec3::new(0.2, 1.0, -0.5))));
        },
        &[
            SUMMED,
            "attachment depth_test, pipeline surface unlit, surface unlit: attribute position, surface unlit: binding frame, \
          surface unlit: binding instances, surface unlit: binding material, surface unlit: UNLIT, surface unlit: LIGHT_TARGET, surface unlit: DEPTH_TARGET",
        ],
    ),
    summed(
        "a blended neighbour",
        |s| {
            let alpha_mode = AlphaMode::Blend;
            neighbour(s, Material { unlit: true, alpha_mode, name: "film".into(), ..Material::default() });
            s.instances
                .push(Instance::new(s.meshes.len() - 1, Mat4::from_translation(Vec3::new(0.2, 1.0, -0.5))));
        },
        &[
            SUMMED,
            "attachment depth_test, subpass translucency, pipeline blended surface, blended surface: attribute position, \
          blended surface: binding frame, blended surface: binding instances, blended surface: binding material, \
          blended surface: UNLIT, blended surface: BLEND, blended surface: LIGHT_TARGET",
        ],
    ),
    summed(
        "light that goes through a neighbour",
        |s| {
            let transmission =
                Some(Transmission { factor: 0.5, thickness_m: 1.0, ..Transmission::default() });
            neighbour(s, Material { transmission, name: "water".into(), ..Material::default() });
            s.instances
                .push(Instance::new(s.meshes.len() - 1, Mat4::from_translation(Vec3::new(0.2, 1.0, -0.5))));
        },
        &[SUMMED, MEDIUM],
    ),
    summed("particles", |s| particles(s, false), &[SUMMED, SPARKS]),
    summed(
        "particles with a texture",
        |s| particles(s, true),
        &[SUMMED, SPARKS, "particles: binding textures, particles: SLOT_EMISSIVE, image picture"],
    ),
];

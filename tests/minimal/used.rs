//! Nothing exists for a scene that no element of it uses: each kind of object, with what must be in the scene for it to exist.
//! What is in a scene is read off the scene itself.

use std::collections::BTreeMap;

use super::common::scenes;
use super::features::objects;
use ontile::glam::Vec3;
use ontile::gpu::{ExplainedKind, Explanation};
use ontile::plan::{Needs, Options, Plan};
use ontile::scene::{AlphaMode, Background, Decal, LightKind, Material, Mesh, Particles, Scene, TextureRef};

/// Meshes that are drawn, with their materials.
fn drawn(scene: &Scene) -> impl Iterator<Item = (&Mesh, &Material)> {
    let shown = scene.instances.iter().map(|instance| &scene.meshes[instance.mesh]);
    shown.filter(|mesh| !mesh.indices.is_empty()).map(|mesh| (mesh, &scene.materials[mesh.material]))
}

/// Decals of which something is seen, with their materials.
fn painted(scene: &Scene) -> impl Iterator<Item = (&Decal, &Material)> {
    let all = scene.decals.iter().map(|decal| (decal, &scene.materials[decal.material]));
    all.filter(|(decal, material)| decal.paints(material))
}

/// Particles of which something is seen, with their materials.
fn shone(scene: &Scene) -> impl Iterator<Item = (&Particles, &Material)> {
    let all = scene.particles.iter().map(|particles| (particles, &scene.materials[particles.material]));
    all.filter(|(particles, material)| particles.shine(material))
}

fn has_sky_light(scene: &Scene) -> bool {
    scene.environment.as_ref().is_some_and(|environment| environment.intensity > 0.0)
}

/// Whether something arrives from all around.
fn has_around(scene: &Scene) -> bool {
    scene.ambient_nt != Vec3::ZERO || has_sky_light(scene) || !scene.probes.is_empty()
}

/// The textures that change how a mesh of this material looks, in the order of the shader's slots.
fn textures(scene: &Scene, mesh: &Mesh, material: &Material) -> [Option<TextureRef>; 5] {
    let lit = !material.unlit;
    let shaped = lit && !mesh.tangents.is_empty();
    let occluded = lit && material.occlusion_strength != 0.0 && has_around(scene);
    let glows = lit && material.emissive_factor != Vec3::ZERO;
    let there = |texture: Option<TextureRef>, used| {
        texture.filter(|texture| used && !mesh.texcoords[texture.texcoord].is_empty())
    };
    [
        there(material.base_color_texture, true),
        there(material.metallic_roughness_texture, lit),
        there(material.normal_texture, shaped),
        there(material.occlusion_texture, occluded),
        there(material.emissive_texture, glows),
    ]
}

/// What has to be true for objects whose names begin like this.
fn rules(scene: &Scene) -> Vec<(&'static str, bool)> {
    let any = |wanted: &dyn Fn(&Mesh, &Material) -> bool| {
        drawn(scene).any(|(mesh, material)| wanted(mesh, material))
    };
    let is_drawn = any(&|_, _| true);
    let bends = any(&|mesh, _| mesh.deformation.is_some());
    let lit = any(&|_, material| !material.unlit);
    let is_medium = |material: &Material| material.transmits().is_some();
    let is_blended = |material: &Material| material.alpha_mode == AlphaMode::Blend && !is_medium(material);
    let media = any(&|_, material| is_medium(material));
    let blended = any(&|_, material| is_blended(material));
    let sparks = shone(scene).next().is_some();
    let over = blended || sparks || media;
    let lit_opaque = any(&|_, material| !material.unlit && !material.shows_behind());
    let unlit = any(&|_, material| material.unlit && !material.shows_behind());
    let slot = |slot: usize| any(&|mesh, material| textures(scene, mesh, material)[slot].is_some());
    let texture = |wanted: fn(&TextureRef) -> bool| {
        any(&|mesh, material| textures(scene, mesh, material).iter().flatten().any(wanted))
    };
    let textured = (0..5).any(slot);
    let colored = any(&|mesh, _| !mesh.colors.is_empty());
    let masked = any(&|_, material| matches!(material.alpha_mode, AlphaMode::Mask { .. }));
    let glows = any(&|_, material| !material.unlit && material.emissive_factor != Vec3::ZERO);
    let shining = || scene.lights.iter().filter(|light| lit && !light.is_dark());
    let light = |wanted: fn(&LightKind) -> bool| shining().any(|light| wanted(&light.kind));
    let directional = light(|kind| matches!(kind, LightKind::Directional { .. }));
    let hemisphere = light(|kind| matches!(kind, LightKind::Hemisphere { .. }));
    let local = light(|kind| {
        matches!(kind, LightKind::Point { .. } | LightKind::Spot { .. } | LightKind::Box { .. })
    });
    let lights = directional || local || hemisphere;
    let triangles: usize = drawn(scene).map(|(mesh, _)| mesh.indices.len() / 3).sum();
    let opaque = drawn(scene).filter(|(_, material)| !material.shows_behind());
    let opaque: usize = opaque.map(|(mesh, _)| mesh.indices.len() / 3).sum();
    let hides = opaque > 1 || (opaque == 1 && over);
    let shadow = opaque > 0 && triangles > 1 && shining().any(|light| light.shadow.is_some());
    let volumes = shadow && shining().any(|l| l.shadow.is_some_and(|shadow| shadow.volume == Some(true)));
    let moves = scene.instances.iter().any(|instance| instance.dynamic);
    let globe = shining().any(|light| light.globe_map.is_some());
    let sky = has_sky_light(scene) && scene.background == Background::Environment;
    let around = lit && has_around(scene);
    let environment = lit && has_sky_light(scene);
    let probes = lit && !scene.probes.is_empty();
    let lightmap = lit && scene.lightmap.is_some() && scene.instances.iter().any(|i| i.lightmap.is_some());
    let deferred = lit_opaque && lights;
    let summed = over || (deferred && (glows || unlit || around || lightmap || sky));
    let paints = |channel: fn(&Decal, &Material) -> bool| lit && painted(scene).any(|(d, m)| channel(d, m));
    let decals = paints(|_, _| true);
    let color = matches!(scene.background, Background::Color(_));
    let fog = is_drawn && scene.fog.is_some_and(|fog| fog.density_per_m > 0.0);
    vec![
        ("attachment output", true),
        ("attachment depth_test", hides || (sky && opaque > 0)),
        ("attachment depth", deferred),
        ("attachment normal_roughness", deferred),
        ("attachment base_metallic", deferred),
        ("attachment light", summed),
        // What decals leave of a surface is lit from all around after them.
        ("attachment occlusion", decals && around && slot(3)),
        ("subpass geometry", true),
        ("subpass forward", lit && !deferred),
        ("subpass lighting", deferred),
        ("subpass tonemap", summed),
        ("pipeline surface unlit", unlit),
        ("pipeline surface lit", lit_opaque),
        ("pipeline lighting", deferred),
        ("pipeline tonemap", summed),
        ("pipeline sky", sky),
        ("subpass translucency", blended),
        ("pipeline blended surface", blended),
        ("blended surface:", blended),
        ("blended surface: UNLIT", any(&|_, material| material.unlit && is_blended(material))),
        ("blended surface: binding lights", directional || local),
        ("blended surface: binding light lists", local),
        ("blended surface: binding shadow", shadow),
        ("blended surface: FOG", fog),
        ("pipeline fog", fog && over && deferred),
        ("fog:", fog && over && deferred),
        ("pipeline shadow", shadow),
        ("pipeline shadow compose", shadow && moves),
        ("surface unlit:", unlit),
        ("surface unlit: UNLIT", unlit && (lit || over)),
        ("surface unlit: binding radiance", false),
        ("surface unlit: attribute normal", false),
        ("surface unlit: attribute tangent", false),
        ("surface unlit: attribute colour", colored),
        ("surface unlit: attribute texture coordinates", textured),
        ("surface unlit: binding textures", textured),
        ("surface unlit: SLOT_", slot(0)),
        ("surface unlit: TEXCOORD_BITS", texture(|texture| texture.texcoord == 1)),
        ("surface unlit: TRANSFORM_BITS", texture(|t| t.uv_from_texcoord != TextureRef::IDENTITY)),
        ("surface unlit: VERTEX_COLOR", colored),
        ("surface unlit: ALPHA_MASK", masked),
        ("surface unlit: FOG", fog),
        ("surface unlit: LIGHT_TARGET", summed),
        ("surface lit:", lit_opaque),
        ("surface lit: attribute colour", colored),
        ("surface lit: attribute tangent", slot(2)),
        ("surface lit: attribute texture coordinates", textured || lightmap),
        ("surface lit: binding textures", textured),
        ("surface lit: binding split sum", around),
        ("surface lit: binding environment", environment || probes),
        ("surface lit: binding radiance", environment || probes),
        ("surface lit: binding probes", probes),
        ("surface lit: binding lightmap", lightmap),
        ("surface lit: binding lights", !deferred),
        ("surface lit: SLOT_BASE_COLOR", slot(0)),
        ("surface lit: SLOT_METALLIC_ROUGHNESS", slot(1)),
        ("surface lit: SLOT_NORMAL", slot(2)),
        ("surface lit: SLOT_OCCLUSION", slot(3)),
        ("surface lit: SLOT_EMISSIVE", slot(4)),
        ("surface lit: TEXTURE_COUNT", (0..5).filter(|&s| slot(s)).count() > 1),
        ("surface lit: TEXCOORD_BITS", texture(|texture| texture.texcoord == 1)),
        ("surface lit: TRANSFORM_BITS", texture(|t| t.uv_from_texcoord != TextureRef::IDENTITY)),
        ("surface lit: VERTEX_COLOR", colored),
        ("surface lit: ALPHA_MASK", masked),
        ("surface lit: DOUBLE_SIDED", any(&|_, material| material.double_sided)),
        ("surface lit: EMISSIVE", glows),
        ("surface lit: AMBIENT", around),
        ("surface lit: ENVIRONMENT", environment || probes),
        ("surface lit: PROBES", probes),
        ("surface lit: HAS_ENVIRONMENT", probes && environment),
        ("surface lit: LIGHTMAP", lightmap),
        ("surface lit: LIGHT_TARGET", summed),
        ("surface lit: FOG", fog && !deferred),
        ("lighting:", deferred),
        ("lighting: binding lights", directional || local),
        ("lighting: binding light lists", local),
        ("lighting: binding shadow", shadow),
        ("lighting: binding globe maps", globe),
        ("lighting: CLUSTERS", local),
        ("lighting: HAS_DIRECTIONAL", directional),
        ("lighting: HAS_POINT", light(|kind| matches!(kind, LightKind::Point { .. }))),
        ("lighting: HAS_SPOT", light(|kind| matches!(kind, LightKind::Spot { .. }))),
        ("lighting: HAS_BOX", light(|kind| matches!(kind, LightKind::Box { .. }))),
        ("lighting: HAS_HEMISPHERE", hemisphere),
        ("lighting: HAS_BACK", shining().any(|light| light.back_color != Vec3::ZERO)),
        ("lighting: SHADOW", shadow),
        ("lighting: GLOBE_MAPS", globe),
        ("lighting: FOLD", !summed),
        ("lighting: FOG", fog && !summed),
        ("lighting: BACKGROUND", color && !summed),
        ("tonemap:", summed),
        ("tonemap: input depth", fog && !over),
        ("tonemap: FOG", fog && !over),
        ("tonemap: BACKGROUND", color),
        ("tonemap: TRANSLUCENCY", over && color),
        ("sky:", sky),
        ("sky: PROBES", probes),
        ("sky: LIGHT_TARGET", summed),
        ("shadow c", shadow),
        ("subpass fog", fog && deferred && (media || sparks && !blended)),
        ("subpass media", media),
        ("pipeline medium", media),
        ("medium:", media),
        ("medium: binding lights", media && (directional || local)),
        ("medium: binding light lists", media && local),
        ("medium: binding shadow", media && shadow),
        ("medium: FOG", media && fog),
        ("medium: input depth", media && fog && opaque > 0),
        ("medium: HAS_BEHIND", media && fog && opaque > 0),
        ("pipeline absorption", media),
        ("absorption:", media),
        ("absorption: input depth", media && opaque > 0),
        ("absorption: HAS_BEHIND", media && opaque > 0),
        ("buffer media", media),
        ("subpass particles", sparks),
        ("pipeline particles", sparks),
        ("buffer particles", sparks),
        ("particles:", sparks),
        ("particles: HAS_BEHIND", sparks && opaque > 0),
        ("particles: BEHIND_OPAQUE", false),
        ("particles: binding textures", shone(scene).any(|(_, m)| m.emissive_texture.is_some())),
        ("particles: SLOT_EMISSIVE", shone(scene).any(|(_, m)| m.emissive_texture.is_some())),
        ("particles: FOG", sparks && fog),
        ("decal:", decals),
        ("decal: binding textures", paints(|d, m| d.textures(m).iter().any(Option::is_some))),
        ("decal: SLOT_BASE_COLOR", paints(|d, m| d.textures(m)[0].is_some())),
        ("decal: SLOT_METALLIC_ROUGHNESS", paints(|d, m| d.textures(m)[1].is_some())),
        ("decal: SLOT_NORMAL", paints(|d, m| d.textures(m)[2].is_some())),
        (
            "decal: TRANSFORM_BITS",
            paints(|d, m| d.textures(m).iter().flatten().any(|t| t.uv_from_texcoord != TextureRef::IDENTITY)),
        ),
        ("decal: DECAL_BASE_COLOR", paints(|d, _| d.channels.base_color > 0.0)),
        ("decal: DECAL_NORMAL", paints(|d, m| d.textures(m)[2].is_some())),
        ("decal: DECAL_ROUGHNESS", paints(|d, _| d.channels.roughness > 0.0)),
        ("decal: DECAL_METALLIC", paints(|d, _| d.channels.metallic > 0.0)),
        ("subpass decals", decals),
        ("pipeline decal", decals),
        ("buffer decals", decals),
        (
            "image ",
            textured
                || shone(scene).any(|(_, m)| m.emissive_texture.is_some())
                || paints(|d, m| d.textures(m).iter().any(Option::is_some)),
        ),
        ("image split sum", around),
        ("image radiance", environment || probes || sky),
        ("image lightmap", lightmap),
        ("image globe maps", globe),
        ("image shadow map", shadow),
        ("image static shadow map", shadow && moves),
        ("pipeline poses", bends),
        ("buffer rest poses", bends),
        ("buffer poses", bends),
        ("buffer vertices", is_drawn),
        ("buffer indices", is_drawn),
        ("buffer materials", is_drawn || sparks),
        ("buffer instances", is_drawn),
        ("buffer frame", is_drawn || sky || sparks),
        ("buffer lights", directional || local),
        ("buffer light lists", local),
        ("buffer lightmap parts", lightmap),
        ("buffer environment", environment || probes || sky),
        ("buffer probes", probes),
        ("buffer shadow views", shadow),
        ("buffer casters", shadow),
        ("buffer volume caster", volumes),
        ("shadow volume:", volumes),
        ("shadowed light:", volumes),
    ]
}

/// Pictures that should be on the device: once as colour and once as data, by name.
fn pictures(scene: &Scene) -> BTreeMap<String, usize> {
    let mut used = std::collections::BTreeSet::new();
    for (mesh, material) in drawn(scene) {
        for (slot, texture) in textures(scene, mesh, material).into_iter().enumerate() {
            let is_color = slot == 0 || slot == 4;
            used.extend(texture.map(|texture| (scene.textures[texture.texture].image, is_color)));
        }
    }
    for (decal, material) in painted(scene) {
        for (slot, texture) in decal.textures(material).into_iter().enumerate() {
            used.extend(texture.map(|texture| (scene.textures[texture.texture].image, slot == 0)));
        }
    }
    for (_, material) in shone(scene) {
        used.extend(material.emissive_texture.map(|t| (scene.textures[t.texture].image, true)));
    }
    let mut names = BTreeMap::new();
    used.iter().for_each(|(image, _)| *names.entry(scene.images[*image].name.clone()).or_default() += 1);
    names
}

fn problems(scene: &Scene) -> Vec<String> {
    let options = Options::default();
    let rules = rules(scene);
    let unused = |object: &String| {
        let known =
            rules.iter().filter(|(begin, _)| object.starts_with(begin)).max_by_key(|(begin, _)| begin.len());
        !known.is_some_and(|(_, holds)| *holds)
    };
    let mut problems: Vec<_> = objects(scene, &options)
        .into_iter()
        .filter(unused)
        .map(|object| format!("{}: nothing uses '{object}'", scene.name))
        .collect();
    let plan = Plan::new(Needs::of(scene), options, &super::features::limits()).unwrap();
    let around: Vec<_> = plan.around.iter().map(|image| image.name.replace('_', " ")).collect();
    let others = ["globe maps", "shadow map", "static shadow map"];
    let mut uploaded: BTreeMap<String, usize> = BTreeMap::new();
    for object in Explanation::new(scene, &plan).unwrap().objects {
        let is_picture = !around.contains(&object.name) && !others.contains(&object.name.as_str());
        if object.kind == ExplainedKind::Image && is_picture {
            *uploaded.entry(object.name).or_default() += 1;
        }
    }
    if uploaded != pictures(scene) {
        problems.push(format!("{}: pictures {uploaded:?}, used {:?}", scene.name, pictures(scene)));
    }
    problems
}

#[test]
fn no_scene_has_what_nothing_in_it_uses() {
    let samples = scenes::sample_files().into_iter().map(|file| Scene::load(&file).unwrap());
    let all = scenes::built().into_iter().chain(scenes::shipped()).chain(samples);
    let problems: Vec<_> = all.flat_map(|scene| problems(&scene)).collect();
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

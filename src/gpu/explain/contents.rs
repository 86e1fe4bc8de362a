//! Images and buffers, and why they exist; by the names that they have on the device.

use std::collections::BTreeMap;

use super::super::pipeline::PipelineParts;
use super::super::shader::shared;
use super::elements::{Elements, is_local};
use crate::Result;
use crate::plan::{DecalKind, ParticleKind, Pipeline, SLOTS, SceneKinds, SurfaceKind, element};

impl Elements<'_> {
    /// Pipelines beside the plan's and those of casters: what poses meshes, and what tiles of the shadow map begin with.
    pub(super) fn other_pipelines(&self) -> Vec<(&'static str, String)> {
        let posed = self.plan.needs.posed.as_ref().map(|need| ("poses", format!("{} bends", need.why)));
        posed.into_iter().chain(self.tile_pipelines()).collect()
    }

    fn tile_pipelines(&self) -> Vec<(&'static str, String)> {
        let Some(map) = &self.plan.shadow_map else { return Vec::new() };
        let clear = ("shadow clear", self.shadow_lights());
        let compose = map.has_static_map.then(|| ("shadow compose", self.moving()));
        std::iter::once(clear).chain(compose).collect()
    }

    fn moving(&self) -> String {
        let lights = self.plan.shadow_map.iter().flat_map(|map| &map.lights);
        let mut lights = lights.filter(|light| light.keeps_static);
        let light = lights.next().map(|light| element("light", &light.name, light.light)).unwrap_or_default();
        format!("instances move in the reach of {light}, beside others that stand still")
    }

    /// Images that are sampled, in order of their kinds: pictures, what is around, globe maps, shadow maps.
    pub(super) fn images(&self) -> Result<Vec<(String, String)>> {
        let (scene, plan) = (self.scene, self.plan);
        let kinds = SceneKinds::new(scene);
        // A picture that is both colour and data is there twice.
        let mut pictures: BTreeMap<(usize, bool), String> = BTreeMap::new();
        for instance in scene.drawn_instances() {
            let index = scene.meshes[instance.mesh].material;
            let material = &scene.materials[index];
            let kind = SurfaceKind::new(&kinds, instance);
            for (slot, texture) in SurfaceKind::textures_of(material).into_iter().enumerate() {
                let Some(texture) = texture.filter(|_| kind.samples(slot)) else { continue };
                let key = (scene.textures[texture.texture].image, SurfaceKind::is_srgb(slot));
                let why = || format!("{} of {}", SLOTS[slot], element("material", &material.name, index));
                pictures.entry(key).or_insert_with(why);
            }
        }
        for decal in scene.decals.iter().filter(|_| plan.decal_way.is_some()) {
            let Some(kind) = DecalKind::new(scene, decal) else { continue };
            let index = decal.material;
            let material = &scene.materials[index];
            for (slot, texture) in decal.textures(material).into_iter().enumerate() {
                let Some(texture) = texture.filter(|_| kind.surface().samples(slot)) else { continue };
                let key = (scene.textures[texture.texture].image, SurfaceKind::is_srgb(slot));
                let why = || format!("{} of {}", SLOTS[slot], element("material", &material.name, index));
                pictures.entry(key).or_insert_with(why);
            }
        }
        for particles in &scene.particles {
            let index = particles.material;
            let material = &scene.materials[index];
            let shown = ParticleKind::new(scene, particles).and(material.emissive_texture);
            if let Some(texture) = shown {
                let key = (scene.textures[texture.texture].image, true);
                let why = || format!("emissive of {}", element("material", &material.name, index));
                pictures.entry(key).or_insert_with(why);
            }
        }
        let pictures = pictures.into_iter().map(|((image, _), why)| (scene.images[image].name.clone(), why));
        let mut images: Vec<_> = pictures.collect();
        // What a plan calls by one word has two on the device.
        images.extend(plan.around.iter().map(|image| (image.name.replace('_', " "), image.why.clone())));
        if plan.needs.globe_maps > 0 {
            images.push(("globe maps".into(), self.globe_light()));
        }
        images.extend(plan.post.images.iter().map(|image| (image.name.clone(), image.why.into())));
        if plan.options.overlay {
            images.push(("overlay".into(), "the options ask for an overlay".into()));
        }
        if let Some(map) = &plan.shadow_map {
            images.push(("shadow map".into(), self.shadow_lights()));
            images.extend(map.has_static_map.then(|| ("static shadow map".into(), self.moving())));
        }
        Ok(images)
    }

    /// Buffers of the scene, and of each frame slot.
    pub(super) fn buffers(&self, parts: &[PipelineParts]) -> Vec<(&'static str, String)> {
        let plan = self.plan;
        let set_frame = const { shared("SET_FRAME") };
        let of_plan = &parts[..plan.pipelines.len()];
        let reads = |set: u32, binding: u32| of_plan.iter().any(|p| p.bindings.contains_key(&(set, binding)));
        let frame = |binding| reads(set_frame, binding);
        let first = plan.needs.kinds.first().map_or_else(String::new, |need| need.why.clone());
        let sparks = plan.needs.particles.first().map_or_else(String::new, |need| need.why.clone());
        let drawn = !plan.needs.kinds.is_empty();
        let materials = const { (shared("SET_MATERIAL"), shared("BINDING_MATERIAL")) };
        let is_surface = |index: usize| {
            let pipeline = &plan.pipelines[index].1;
            pipeline.is_of_surfaces() || matches!(pipeline, Pipeline::Particles(_))
        };
        let bends =
            || plan.needs.posed.as_ref().map_or_else(String::new, |need| format!("{} bends", need.why));
        let has_materials =
            (0..of_plan.len()).any(|i| is_surface(i) && of_plan[i].bindings.contains_key(&materials));
        let all = [
            (drawn, "vertices", format!("{first} is drawn")),
            (drawn, "indices", format!("{first} is drawn")),
            (
                has_materials,
                "materials",
                format!("factors of {}", if drawn { first.clone() } else { sparks.clone() }),
            ),
            (!plan.pipelines.is_empty(), "frame", "camera and exposure of the frame".into()),
            (drawn, "instances", format!("{first} is placed")),
            (frame(const { shared("BINDING_LIGHTS") }), "lights", self.light(|_| true)),
            (plan.clusters.is_some(), "light lists", format!("{} has a place", self.light(is_local))),
            (
                plan.light_way.is_one_by_one(),
                "light lists",
                format!("{} is drawn as a volume", self.light(is_local)),
            ),
            (plan.needs.lightmap.is_some(), "lightmap parts", "instances have parts of the lightmap".into()),
            (frame(const { shared("BINDING_ENVIRONMENT") }), "environment", self.around()),
            (!plan.needs.probes.is_empty(), "probes", self.around()),
            (!plan.volume_lights.is_empty(), "volume casters", self.volume_lights()),
            (!plan.volume_lights.is_empty(), "volume caster instances", self.volume_lights()),
            (plan.shadow_map.is_some(), "shadow views", self.shadow_lights()),
            (
                plan.decal_way.is_some(),
                "decals",
                plan.needs.decals.first().map_or_else(String::new, |need| format!("{} is painted", need.why)),
            ),
            (!plan.needs.particles.is_empty(), "particles", format!("{sparks} shine")),
            (
                plan.needs.transmits.is_some(),
                "media",
                format!("{} lets light through", plan.needs.transmits.as_deref().unwrap_or_default()),
            ),
            (plan.shadow_map.is_some(), "casters", self.shadow_lights()),
            (plan.options.overlay, "overlay vertices", "the options ask for an overlay".into()),
            (plan.options.overlay, "overlay indices", "the options ask for an overlay".into()),
            (plan.needs.posed.is_some(), "rest poses", bends()),
            (plan.needs.posed.is_some(), "poses", bends()),
        ];
        all.into_iter().filter(|(exists, ..)| *exists).map(|(_, name, why)| (name, why)).collect()
    }
}

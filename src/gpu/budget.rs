//! What a renderer will take of device memory, before there is one.

use std::collections::BTreeSet;

use super::decals::Decals;
use super::light_lists::LightLists;
use super::lights::Lights;
use super::objects::Objects;
use super::particles::SceneParticles;
use super::poses::Poses;
use super::scene_data::{streams, texture_bytes};
use super::shadow::caster_count;
use super::shared::{
    DecalData, FrameUniforms, InstanceData, LightData, MaterialData, MediumData, ParticleData, ShadowViewData,
};
use super::volume_casters::VolumeCasters;
use super::{Features, Geometry, RendererConfig};
use crate::Result;
use crate::plan::Plan;
use crate::scene::Scene;

/// Bytes of device memory by use, as sums of contents: a device adds what it aligns and rounds to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MemoryBudget {
    /// Of a renderer, whatever it draws to.
    pub renderer: Vec<(&'static str, u64)>,
    /// Of a target: its attachments, and whether they are transient. Those take no memory on a tiler with lazily allocated memory.
    pub target: Vec<(String, u64, bool)>,
}

impl MemoryBudget {
    /// What [`Renderer::new`](super::Renderer::new) and [`Renderer::create_target`](super::Renderer::create_target) will make for this
    /// scene, of which the plan was made, on a device with these features, and for an output of this size in pixels.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] if a mesh's lists contradict each other, or an image's size is not that of its bytes.
    pub fn new(
        scene: &Scene,
        plan: &Plan,
        config: &RendererConfig,
        features: Features,
        size: [u32; 2],
    ) -> Result<Self> {
        let slots = config.frames_in_flight.max(1) as u64;
        let objects = Objects::new(scene, plan);
        let decals = Decals::new(scene, plan);
        let map = plan.shadow_map.as_ref();
        let lights = Lights::new(&scene.lights, map, None, &plan.volume_lights);
        let particles = SceneParticles::new(scene, plan);
        let others: Vec<_> = decals.materials().chain(particles.materials()).collect();
        let of_objects = objects.batches().iter().map(|batch| batch.material);
        let materials: BTreeSet<_> = of_objects.chain(others.iter().map(|(_, m)| *m)).collect();
        let media = materials.iter().filter(|&&m| scene.materials[m].transmits().is_some()).count();
        let streams = streams(scene, plan, objects.batches());
        let globes = (plan.needs.globe_maps > 0).then(|| scene.globe_layers()).transpose()?;
        let volumes = match plan.volume_lights.is_empty() {
            true => [0; 2],
            false => VolumeCasters::bytes(scene),
        };
        let poses = Poses::bytes(scene, &streams, !plan.volume_lights.is_empty());
        let of = |count: usize, bytes: usize| (count * bytes) as u64;
        let instances = of(objects.count(), size_of::<InstanceData>());
        let rects =
            if plan.needs.lightmap.is_some() { of(objects.count(), size_of::<[f32; 4]>()) } else { 0 };
        let lists = LightLists::bytes(plan).unwrap_or(0) + of(lights.count(), size_of::<LightData>());
        let frame = size_of::<FrameUniforms>() as u64
            + instances
            + rects
            + lists
            + of(decals.count(), size_of::<DecalData>())
            + of(particles.most(), size_of::<ParticleData>());
        let texels = |map: &crate::plan::ShadowMap| {
            map.size.iter().map(|&n| u64::from(n)).product::<u64>() * u64::from(map.format.bytes())
        };
        let shadows = map.map_or(0, |map| {
            let images = texels(map) * if map.has_static_map { 2 } else { 1 };
            let views = of(map.tiles.len(), size_of::<ShadowViewData>());
            images + slots * (views + of(caster_count(scene, map), size_of::<InstanceData>()))
        });
        let renderer = [
            ("meshes", Geometry::bytes(&scene.meshes, &streams)?),
            ("textures", texture_bytes(scene, plan, &objects, &others, features)?),
            (
                "materials",
                of(materials.len(), size_of::<MaterialData>()) + of(media, size_of::<MediumData>()),
            ),
            ("frame data", slots * frame),
            ("shadow maps", shadows),
            ("shadow volumes", volumes[0] + slots * volumes[1]),
            ("poses", poses[0] + slots * poses[1]),
            ("surroundings", plan.around.iter().map(|image| image.bytes).sum()),
            ("globe maps", globes.map_or(0, |layers| layers.texels.len() as u64)),
        ];
        let pixels = |[w, h]: [u32; 2]| u64::from(w) * u64::from(h);
        let attachments = plan.attachments.iter().filter(|a| !a.is_output).map(|a| {
            // Depth with stencil has 40 bits, which most drivers pad to 64.
            let bits = u64::from(a.format.bits().next_power_of_two());
            let bytes = pixels(size) * bits / 8 * u64::from(a.samples);
            (a.name.clone(), bytes, a.transient && !config.capture)
        });
        let post = plan.post.images.iter().map(|image| {
            (image.name.clone(), pixels(image.size(size)) * u64::from(image.format.bytes()), false)
        });
        Ok(Self {
            renderer: renderer.into_iter().filter(|(_, bytes)| *bytes > 0).collect(),
            target: attachments.chain(post).collect(),
        })
    }

    /// Of the renderer.
    pub fn renderer_bytes(&self) -> u64 {
        self.renderer.iter().map(|(_, bytes)| bytes).sum()
    }

    /// Of a target; `lazily` if the device has lazily allocated memory and keeps transient attachments on the tile.
    pub fn target_bytes(&self, lazily: bool) -> u64 {
        let taken = self.target.iter().filter(|(.., transient)| !(lazily && *transient));
        taken.map(|(_, bytes, _)| bytes).sum()
    }
}

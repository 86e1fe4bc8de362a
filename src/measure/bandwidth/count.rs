//! What a frame consists of, as a device counts it.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::Result;
use crate::gpu::shared::InstanceData;
use crate::gpu::{
    Device, DrawCount, IndexWidth, Offscreen, PipelineCache, PipelineParts, RecordedShadows, RendererConfig,
    View,
};
use crate::plan::{Around, LightWay, Load, Needs, Options, Path, Pipeline, Plan, SLOTS, SurfaceKind};
use crate::scene::{Image, Scene, Texels, TextureFormat};

/// Lookups of each fragment of a draw.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lookup {
    /// Where: a name in [`Counts::images`].
    pub image: String,
    /// How many, on average.
    pub times: f64,
    /// Of these, lookups that a neighbour has not made already: the samples of a filter overlap.
    pub new_times: f64,
    /// Bytes of a texel.
    pub texel_bytes: f64,
}

/// What was drawn in one go.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Draw {
    /// The stage.
    pub stage: &'static str,
    /// Surfaces of the scene, not the screen or the volume of a light.
    pub of_surfaces: bool,
    /// Fragments that passed all tests; told by the driver.
    pub fragments: f64,
    /// Bytes of the vertices and indices that the draw refers to and of its instances, each once.
    pub geometry_once: f64,
    /// The same where each index of each instance fetches its vertex.
    pub geometry_each: f64,
    /// What each fragment looks up.
    pub lookups: Vec<Lookup>,
}

/// A frame as counted.
#[derive(Clone, Debug, Serialize)]
pub struct Counts {
    /// Pixels.
    pub size: [u32; 2],
    /// Pixels that surfaces cover; coincident surfaces count twice. Told by the driver.
    pub covered: f64,
    /// Fragments of surfaces that reach the depth test; told by the driver.
    pub rasterized: f64,
    /// Of these, fragments that pass it where surfaces are shaded; told by the driver.
    pub passed: f64,
    /// Pairs of a pixel and a light with a shadow whose volume holds the pixel's surface; told by the driver.
    pub shadowed: f64,
    /// Lights in view that are not dark, hemispheres aside.
    pub lights: usize,
    /// The draws.
    pub draws: Vec<Draw>,
    /// What lighting a pixel looks up for all lights, if each reaches every pixel.
    pub light_lookups: Vec<Lookup>,
    /// Bytes of each image that is sampled, with all its levels.
    pub images: BTreeMap<String, f64>,
    /// Shadow casters when all tiles are drawn: bytes of geometry, as of [`Draw::geometry_once`] and
    /// [`Draw::geometry_each`].
    pub casters: [f64; 2],
}

/// What shadows are looked up in.
pub(super) const SHADOW_MAP: &str = "shadow map";
/// What lights shine through.
const GLOBE_MAPS: &str = "globe maps";

/// A picture of the scene; colours are decoded, so one used as both exists twice.
fn picture(image: usize, srgb: bool) -> String {
    format!("image {image} {}", if srgb { "colour" } else { "data" })
}

/// Draws frames and counts fragments: as planned, without a depth test, with all depth known before, and where there are
/// shadows, with the lights that cast them alone, each where its volume is.
///
/// Fragments that a mask discards are not counted.
///
/// # Errors
/// Those of [`Plan::new`] and [`Offscreen`]; [`crate::Error::Unsupported`] if the device does not count precisely.
pub fn count(
    device: &Device,
    scene: &Scene,
    options: &Options,
    view: &View<'_>,
    cache: &PipelineCache,
) -> Result<Counts> {
    let limits = device.limits();
    let plan = Plan::new(Needs::of(scene), options.clone(), &limits)?;
    let frame = |scene: &Scene, plan: Plan| -> Result<(Vec<DrawCount>, Offscreen)> {
        let config =
            RendererConfig { frames_in_flight: 1, count_fragments: true, ..RendererConfig::default() };
        let mut offscreen = Offscreen::new(device, scene, plan, config, cache)?;
        offscreen.render(view)?;
        Ok((offscreen.renderer().draw_counts(0)?, offscreen))
    };
    let shades =
        |draw: &DrawCount, plan: &Plan| matches!(plan.pipelines[draw.pipeline].1, Pipeline::Surface(_));
    let surfaces = |draws: &[DrawCount], plan: &Plan| -> f64 {
        draws.iter().filter(|d| shades(d, plan)).map(|d| d.fragments as f64).sum()
    };
    let (draws, offscreen) = frame(scene, plan.clone())?;
    let recorded = offscreen.renderer().recorded();
    drop(offscreen);
    let mut untested = plan.clone();
    for pass in &mut untested.passes {
        pass.subpasses.iter_mut().for_each(|subpass| subpass.depth = None);
        // What is read of it is nothing that could be cleared.
        let of_depth =
            pass.attachments.iter_mut().filter(|a| plan.attachments[a.attachment].format.is_depth());
        of_depth.for_each(|attachment| attachment.load = Load::DontCare);
    }
    let (all_draws, _) = frame(scene, untested)?;
    let known = Plan::new(Needs::of(scene), Options { depth_prepass: true, ..options.clone() }, &limits)?;
    let (nearest, _) = frame(scene, known.clone())?;

    let shadowed = match &plan.shadow_map {
        Some(map) => {
            let lights = map.lights.iter().map(|light| scene.lights[light.light].clone()).collect();
            let only = Scene { lights, ..scene.clone() }.without_shadows();
            // What a volume holds is the same whatever the G-buffer, and not every one can have lights added to it.
            let lights = LightWay::Stencil;
            let one_by_one =
                Options { size: options.size, path: Path::Deferred, lights, ..Options::default() };
            let plan = Plan::new(Needs::of(&only), one_by_one, &limits)?;
            let (draws, _) = frame(&only, plan.clone())?;
            let lights = |draw: &DrawCount| match plan.pipelines[draw.pipeline].1 {
                Pipeline::LightVolume(_) => 1,
                Pipeline::Lighting => plan.needs.directional_lights,
                _ => 0,
            };
            draws.iter().map(|draw| draw.fragments as f64 * lights(draw) as f64).sum()
        }
        None => 0.0,
    };
    let covered = surfaces(&nearest, &known);
    // Forward, what is not in front of all is lit too.
    let lights_something = |draw: &&DrawCount| lights(&plan, &plan.pipelines[draw.pipeline].1);
    let lit: f64 = draws.iter().filter(lights_something).map(|draw| draw.fragments as f64).sum();
    let one_by_one = plan.light_way.is_one_by_one() || plan.path == Path::ForwardMultipass;
    let repeated = if one_by_one { 1.0 } else { lit / covered.max(1.0) };
    let lookups = Lookups { scene, plan: &plan, shadowed: shadowed * repeated / lit.max(1.0) };
    let parts = PipelineParts::of(&plan)?;
    let read = |draw: &DrawCount| {
        let (_, pipeline) = &plan.pipelines[draw.pipeline];
        let mut read = Draw {
            stage: plan.subpass(draw.stage).2.name,
            of_surfaces: draw.drawn.is_some(),
            fragments: draw.fragments as f64,
            geometry_once: 0.0,
            geometry_each: 0.0,
            lookups: lookups.of(pipeline, draw.drawn.map(|d| d.material)),
        };
        if let Some(drawn) = draw.drawn {
            let mesh = &scene.meshes[drawn.mesh];
            let [vertices, indices] = [mesh.positions.len(), mesh.indices.len()].map(|n| n as f64);
            let vertex = f64::from(parts[draw.pipeline].vertex_bytes);
            let index = IndexWidth::for_vertices(mesh.positions.len()).bytes() as f64;
            let instances = f64::from(drawn.instances);
            let placed = instances * size_of::<InstanceData>() as f64;
            read.geometry_once = vertices * vertex + indices * index + placed;
            read.geometry_each = instances * indices * (vertex + index) + placed;
        }
        read
    };
    Ok(Counts {
        size: options.size,
        covered,
        rasterized: surfaces(&all_draws, &plan),
        passed: surfaces(&draws, &plan),
        shadowed,
        lights: recorded.counts.lights.visible,
        draws: draws.iter().map(read).collect(),
        light_lookups: lookups.lights(plan.shadow_map.as_ref().map_or(0, |map| map.lights.len()) as f64),
        images: lookups.images()?,
        casters: casters(&recorded.shadows),
    })
}

/// Casters are solid or masked; of the latter, what is read beside positions is left out.
fn casters(recorded: &RecordedShadows) -> [f64; 2] {
    const POSITION_BYTES: f64 = 12.0;
    const INDEX_BYTES: f64 = 4.0;
    let placed = recorded.casters as f64 * size_of::<InstanceData>() as f64;
    let [triangles, vertices] = [recorded.triangles, recorded.vertices].map(|n| n as f64);
    let indices = 3.0 * triangles * INDEX_BYTES;
    [vertices * POSITION_BYTES + indices + placed, 3.0 * triangles * POSITION_BYTES + indices + placed]
}

/// What pipelines look up.
struct Lookups<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    /// Lights with shadows that reach what is lit, on average.
    shadowed: f64,
}

/// Bytes of a texel, in the format that loses least.
fn texel_bytes(image: &Image) -> f64 {
    let format = match &image.texels {
        Texels::Rgba8(_) => TextureFormat::Rgba8,
        Texels::Stored(stored) => stored.formats()[0],
    };
    f64::from(format.block_bytes()) / f64::from(format.block().iter().product::<u32>())
}

/// Whether a pipeline lights something by lights that may have shadows.
fn lights(plan: &Plan, pipeline: &Pipeline) -> bool {
    match &pipeline.per_pixel() {
        Pipeline::Surface(kind) => !kind.unlit && !plan.has_gbuffer() && !plan.has_light_target(),
        Pipeline::Light(_) | Pipeline::LightVolume(_) => true,
        Pipeline::Lighting => !plan.light_way.is_one_by_one() || plan.needs.directional_lights > 0,
        _ => false,
    }
}

impl Lookups<'_> {
    /// Lookups of a fragment, which belongs to this material if it is of a surface.
    fn of(&self, pipeline: &Pipeline, material: Option<usize>) -> Vec<Lookup> {
        let textures = |kind: &SurfaceKind, wanted: &dyn Fn(usize) -> bool| -> Vec<Lookup> {
            let Some(material) = material else { return Vec::new() };
            let all = SurfaceKind::textures_of(&self.scene.materials[material]);
            let sampled = (0..SLOTS.len()).filter(|&slot| kind.samples(slot) && wanted(slot));
            let lookup = |slot: usize| {
                let image = self.scene.textures[all[slot]?.texture].image;
                let texel_bytes = texel_bytes(&self.scene.images[image]);
                let image = picture(image, SurfaceKind::is_srgb(slot));
                Some(Lookup { image, times: 1.0, new_times: 1.0, texel_bytes })
            };
            sampled.filter_map(lookup).collect()
        };
        let of_lights = if lights(self.plan, pipeline) { self.lights(self.shadowed) } else { Vec::new() };
        match pipeline {
            Pipeline::Depth(kind) => textures(kind, &|slot| slot == 0),
            Pipeline::Surface(kind) => {
                let mut all = textures(kind, &|_| true);
                all.extend(self.around(kind));
                all.extend(of_lights);
                all
            }
            // Base colour, metallic-roughness and normal are what reflects.
            Pipeline::Light(kind) => {
                let mut all = textures(kind, &|slot| slot < 3);
                all.extend(of_lights);
                all
            }
            Pipeline::Sky => self.around_image("radiance"),
            _ => of_lights,
        }
    }

    fn around(&self, kind: &SurfaceKind) -> Vec<Lookup> {
        let mut all = Vec::new();
        if kind.around.any() {
            all.extend(self.around_image("split_sum"));
        }
        if kind.around >= Around::Environment {
            all.extend(self.around_image("radiance"));
        }
        if kind.has_lightmap() {
            all.extend(self.around_image("lightmap"));
        }
        all
    }

    fn around_image(&self, name: &str) -> Vec<Lookup> {
        let image = self.plan.around.iter().find(|image| image.name == name);
        let texel = |image: &crate::plan::AroundImage| {
            let [width, height] = image.size.map(f64::from);
            let faces = f64::from(if image.cubes == 0 { 1 } else { 6 * image.cubes });
            let levels = (0..image.levels).map(|l| 0.25_f64.powi(l as i32)).sum::<f64>();
            (image.bytes as f64 / (width * height * faces * levels)).round()
        };
        let lookup = |i| Lookup { image: name.into(), times: 1.0, new_times: 1.0, texel_bytes: texel(i) };
        image.map(lookup).into_iter().collect()
    }

    /// Lookups of what so many lights with shadows reach on average, and every light with a globe map.
    fn lights(&self, shadowed: f64) -> Vec<Lookup> {
        let globes = self.plan.needs.globe_maps as f64;
        let globe_maps = (globes > 0.0).then(|| Lookup {
            image: GLOBE_MAPS.into(),
            times: globes,
            new_times: globes,
            texel_bytes: 4.0,
        });
        let shadows = self.plan.shadow_map.as_ref().map(|map| Lookup {
            image: SHADOW_MAP.into(),
            times: shadowed * f64::from(self.plan.options.shadows.filter.samples()),
            new_times: shadowed,
            texel_bytes: f64::from(map.format.bytes()),
        });
        globe_maps.into_iter().chain(shadows).collect()
    }

    /// Bytes of every image.
    fn images(&self) -> Result<BTreeMap<String, f64>> {
        const WITH_MIPS: f64 = 4.0 / 3.0;
        let mut all = BTreeMap::new();
        for (image, found) in self.scene.images.iter().enumerate() {
            let bytes = f64::from(found.width) * f64::from(found.height) * texel_bytes(found) * WITH_MIPS;
            for srgb in [false, true] {
                all.insert(picture(image, srgb), bytes);
            }
        }
        for image in &self.plan.around {
            all.insert(image.name.into(), image.bytes as f64);
        }
        if let Some(map) = &self.plan.shadow_map {
            all.insert(SHADOW_MAP.into(), map.bytes() as f64);
        }
        if self.plan.needs.globe_maps > 0 {
            all.insert(GLOBE_MAPS.into(), self.scene.globe_layers()?.texels.len() as f64 * WITH_MIPS);
        }
        Ok(all)
    }
}

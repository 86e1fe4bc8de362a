//! Which descriptor sets a pipeline takes.

use ash::vk;

use super::super::descriptor::{Binding, set_layout};
use super::super::shader::{LightLoop, shared};
use super::super::shared::{LightPush, OverlayPush, VolumePush};
use super::super::{Device, Owned};
use super::modules::lighting_constants;
use crate::Result;
use crate::plan::{Around, Brdf, Pipeline, Plan, Show, reads_frame};

/// Pipelines that take the same descriptor sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::gpu) struct Family {
    frame: u32,
    second: SecondSet,
    push: Push,
    /// With `SET_DECAL_MATERIAL`: the material's number of textures.
    decal_textures: Option<u32>,
    /// `SET_LAYERS`: input attachments beside a material.
    layers: u32,
    /// What is sampled of earlier passes' attachments, beside input attachments: bit `n` is binding `n`.
    sampled: u32,
}

/// Push constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::gpu) enum Push {
    /// There are none.
    Nothing,
    /// `LightPush`, for fragments.
    Light,
    /// `VolumePush`, for vertices.
    Volume,
    /// `OverlayPush`, for vertices.
    Overlay,
}

/// The set beside `SET_FRAME`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::gpu) enum SecondSet {
    /// `SET_MATERIAL`: a material with this many textures.
    Material {
        /// How many.
        textures: u32,
        /// Whether a block says what fills the space behind.
        medium: bool,
    },
    /// `SET_INPUTS`: this many input attachments.
    Inputs {
        /// How many.
        count: u32,
        /// Whether scattered light is sampled beside them.
        bloom: bool,
    },
    /// What a pass after the frame's own samples: bit `n` is binding `n`.
    Samplers { bindings: u32 },
    /// There is none.
    Nothing,
}

const FRAME: u32 = shared("BINDING_FRAME");
const INSTANCES: u32 = shared("BINDING_INSTANCES");
const LIGHTS: u32 = shared("BINDING_LIGHTS");
const CLUSTERS: u32 = shared("BINDING_CLUSTERS");
const SHADOW_VIEWS: u32 = shared("BINDING_SHADOW_VIEWS");
const SHADOW_MAP: u32 = shared("BINDING_SHADOW_MAP");
const GLOBE_MAPS: u32 = shared("BINDING_GLOBE_MAPS");
const SPLIT_SUM: u32 = shared("BINDING_SPLIT_SUM");
const ENVIRONMENT: u32 = shared("BINDING_ENVIRONMENT");
const RADIANCE: u32 = shared("BINDING_RADIANCE");
const LIGHTMAPS: u32 = shared("BINDING_LIGHTMAPS");
const LIGHTMAP: u32 = shared("BINDING_LIGHTMAP");
const PROBES: u32 = shared("BINDING_PROBES");
const VOLUMES: u32 = shared("BINDING_VOLUMES");
const DECALS: u32 = shared("BINDING_DECALS");
const CASTERS: u32 = shared("BINDING_CASTERS");
const CASTER_INSTANCES: u32 = shared("BINDING_CASTER_INSTANCES");
const PARTICLES: u32 = shared("BINDING_PARTICLES");
/// Of what stages sample of earlier passes' attachments.
pub(in crate::gpu) const BEHIND_LIGHT: u32 = shared("BINDING_BEHIND_LIGHT");
pub(in crate::gpu) const BEHIND_DEPTH: u32 = shared("BINDING_BEHIND_DEPTH");

/// Type and readers of each binding of `SET_FRAME`.
const FRAME_BINDINGS: [(u32, vk::DescriptorType, vk::ShaderStageFlags); 18] = {
    use vk::{DescriptorType as T, ShaderStageFlags as S};
    let both = S::from_raw(S::VERTEX.as_raw() | S::FRAGMENT.as_raw());
    [
        (FRAME, T::UNIFORM_BUFFER, both),
        (INSTANCES, T::STORAGE_BUFFER, S::VERTEX),
        (LIGHTS, T::STORAGE_BUFFER, both),
        (CLUSTERS, T::STORAGE_BUFFER, S::FRAGMENT),
        (SHADOW_VIEWS, T::STORAGE_BUFFER, S::FRAGMENT),
        (SHADOW_MAP, T::COMBINED_IMAGE_SAMPLER, S::FRAGMENT),
        (GLOBE_MAPS, T::COMBINED_IMAGE_SAMPLER, S::FRAGMENT),
        (SPLIT_SUM, T::COMBINED_IMAGE_SAMPLER, S::FRAGMENT),
        (ENVIRONMENT, T::UNIFORM_BUFFER, S::FRAGMENT),
        (RADIANCE, T::COMBINED_IMAGE_SAMPLER, S::FRAGMENT),
        (LIGHTMAPS, T::STORAGE_BUFFER, S::VERTEX),
        (LIGHTMAP, T::COMBINED_IMAGE_SAMPLER, S::FRAGMENT),
        (PROBES, T::STORAGE_BUFFER, S::FRAGMENT),
        (VOLUMES, T::STORAGE_BUFFER, S::VERTEX),
        (DECALS, T::STORAGE_BUFFER, both),
        (CASTERS, T::STORAGE_BUFFER, S::VERTEX),
        (CASTER_INSTANCES, T::STORAGE_BUFFER, S::VERTEX),
        (PARTICLES, T::STORAGE_BUFFER, S::VERTEX),
    ]
};

/// Whether edges are looked for in the depth attachment.
fn reads_depth(plan: &Plan) -> bool {
    plan.gbuffer.reads_depth_attachment() && plan.compares_samples()
}

/// What of the lights is read to count them.
fn counted(plan: &Plan) -> Vec<u32> {
    match plan.clusters {
        _ if plan.options.show != Show::Lights || plan.needs.local_lights() == 0 => Vec::new(),
        Some(_) => vec![CLUSTERS],
        None => vec![LIGHTS],
    }
}

impl Family {
    /// What a pipeline of this stage reads.
    pub(in crate::gpu) fn of(plan: &Plan, stage: usize, pipeline: &Pipeline) -> Self {
        // What shading reads of the lights.
        let constants = lighting_constants(plan, pipeline);
        let of_lighting = [
            (constants.has_listed(), LIGHTS),
            (constants.scan == LightLoop::Cluster, CLUSTERS),
            (constants.shadow_filter.is_some(), SHADOW_VIEWS),
            (constants.shadow_filter.is_some(), SHADOW_MAP),
            (constants.globe_maps, GLOBE_MAPS),
        ];
        let lighting = of_lighting.into_iter().filter_map(|(is_read, binding)| is_read.then_some(binding));
        let of_lights: Vec<u32> = match pipeline {
            Pipeline::LightMask(_) => vec![LIGHTS, VOLUMES],
            Pipeline::ShadowNearEnds | Pipeline::ShadowVolume => vec![CASTERS, CASTER_INSTANCES],
            Pipeline::LightVolume(_) | Pipeline::EdgeVolume(_) => lighting.chain([VOLUMES]).collect(),
            Pipeline::Depth(_) | Pipeline::Sky | Pipeline::Tonemap | Pipeline::Fog | Pipeline::Edges => {
                Vec::new()
            }
            Pipeline::Peel { .. }
            | Pipeline::Composite
            | Pipeline::Absorb(_)
            | Pipeline::Overlay
            | Pipeline::ShowEdges
            | Pipeline::Backdrop => Vec::new(),
            // It looks at no light but to see whether it reaches a surface.
            Pipeline::Show => counted(plan),
            Pipeline::Decal(_) => vec![DECALS],
            Pipeline::Particles(_) => vec![PARTICLES],
            Pipeline::Surface(kind) if kind.unlit || !plan.lights_as_drawn(kind) => Vec::new(),
            Pipeline::Surface(_)
            | Pipeline::Light(_)
            | Pipeline::Lighting
            | Pipeline::EdgeLighting
            | Pipeline::ShadowedLight => lighting.collect(),
        };
        let has_table = plan.options.brdf != Brdf::Fitted;
        let received = match pipeline {
            Pipeline::Surface(kind) => kind.around,
            Pipeline::Lighting | Pipeline::EdgeLighting => plan.needs.painted_around,
            _ => Around::Nothing,
        };
        let around: &[u32] = match received {
            Around::Nothing if *pipeline == Pipeline::Sky => &[ENVIRONMENT, RADIANCE],
            Around::Nothing => &[],
            Around::Ambient => &[SPLIT_SUM],
            Around::Environment => &[SPLIT_SUM, ENVIRONMENT, RADIANCE],
            Around::Probes => &[SPLIT_SUM, ENVIRONMENT, RADIANCE, PROBES],
        };
        let lightmap: &[u32] = match pipeline {
            Pipeline::Surface(kind) if kind.has_lightmap() => &[LIGHTMAPS, LIGHTMAP],
            _ => &[],
        };
        let around = around.iter().filter(|&&binding| has_table || binding != SPLIT_SUM);
        let of_surfaces: &[u32] = if pipeline.is_of_surfaces() { &[INSTANCES] } else { &[] };
        // Where samples lie, if only depth tells.
        let reads_frame = match pipeline {
            Pipeline::Edges => reads_depth(plan),
            Pipeline::Backdrop | Pipeline::Overlay => false,
            Pipeline::Show | Pipeline::ShowEdges => reads_frame(plan.options.show, &plan.gbuffer),
            _ => true,
        };
        let own: &[u32] = if reads_frame { &[FRAME] } else { &[] };
        let frame = own.iter().chain(of_surfaces).chain(&of_lights).chain(around).chain(lightmap);
        let second = match pipeline {
            Pipeline::Depth(kind) if !kind.alpha_mask => SecondSet::Nothing,
            Pipeline::LightMask(_) | Pipeline::ShadowNearEnds | Pipeline::ShadowVolume | Pipeline::Sky => {
                SecondSet::Nothing
            }
            Pipeline::Show | Pipeline::ShowEdges if plan.options.show == Show::Edges => SecondSet::Nothing,
            Pipeline::Peel { .. } if plan.subpass(stage).2.inputs.is_empty() => SecondSet::Nothing,
            Pipeline::Overlay => {
                SecondSet::Samplers { bindings: 1 << const { shared("BINDING_POST_COLOR") } }
            }
            Pipeline::Surface(kind)
            | Pipeline::Depth(kind)
            | Pipeline::Light(kind)
            | Pipeline::Absorb(kind) => {
                SecondSet::Material { textures: kind.textures.count_ones(), medium: kind.transmits }
            }
            Pipeline::Particles(kind) => {
                SecondSet::Material { textures: u32::from(kind.texture), medium: false }
            }
            Pipeline::Lighting
            | Pipeline::LightVolume(_)
            | Pipeline::ShadowedLight
            | Pipeline::Tonemap
            | Pipeline::Fog
            | Pipeline::Decal(_)
            | Pipeline::Edges
            | Pipeline::EdgeLighting
            | Pipeline::EdgeVolume(_)
            | Pipeline::Composite
            | Pipeline::Backdrop
            | Pipeline::Show
            | Pipeline::ShowEdges
            | Pipeline::Peel { .. } => SecondSet::Inputs {
                count: plan.subpass(stage).2.inputs.len() as u32,
                bloom: plan.post.scattered().is_some() && plan.applies_curve(stage),
            },
        };
        let push = match pipeline {
            Pipeline::Light(_) => Push::Light,
            Pipeline::ShadowNearEnds | Pipeline::ShadowVolume => Push::Volume,
            Pipeline::Overlay => Push::Overlay,
            _ => Push::Nothing,
        };
        let decal_textures = match pipeline {
            Pipeline::Decal(kind) => Some(kind.textures.count_ones()),
            _ => None,
        };
        let subpass = plan.subpass(stage).2;
        let collects = pipeline.is_of_blended() && subpass.ordered;
        let reads_both = collects
            || matches!(pipeline, Pipeline::Particles(_) | Pipeline::Absorb(_))
            || matches!(pipeline, Pipeline::Surface(kind) if kind.transmits && (plan.needs.fog.is_some() || plan.refracts()));
        let layers = if reads_both { subpass.inputs.len() as u32 } else { 0 };
        let frame = frame.fold(0, |bits, binding| bits | 1 << binding);
        let sampled = subpass.samples.iter().map(|sampled| {
            let is_depth = plan.attachments[sampled.attachment].format.is_depth();
            if is_depth { BEHIND_DEPTH } else { BEHIND_LIGHT }
        });
        let sampled = sampled.fold(0, |bits, binding| bits | 1 << binding);
        Self { frame, second, push, decal_textures, layers, sampled }
    }

    /// What a pass after the frame's own reads: bits of its samplers' bindings, and whether the camera.
    pub(in crate::gpu) fn of_post(bindings: u32, camera: bool) -> Self {
        let frame = if camera { 1 << FRAME } else { 0 };
        let second = SecondSet::Samplers { bindings };
        Self { frame, second, push: Push::Nothing, decal_textures: None, layers: 0, sampled: 0 }
    }

    /// Whether its pipelines have push constants.
    pub(in crate::gpu) fn has_push_constants(self) -> bool {
        self.push != Push::Nothing
    }

    /// Whether the second set is a material's.
    pub(in crate::gpu) fn has_material(self) -> bool {
        matches!(self.second, SecondSet::Material { .. })
    }

    /// The number of the set that holds the stage's input attachments, if one does.
    pub(in crate::gpu) fn inputs_set(self) -> Option<usize> {
        match self.second {
            SecondSet::Inputs { .. } => Some(1),
            _ => (self.layers > 0 || self.sampled != 0).then_some(const { shared("SET_LAYERS") } as usize),
        }
    }

    /// The number of the set that holds the material, if one does: decals have input attachments before it.
    pub(in crate::gpu) fn material_set(self) -> usize {
        let decal = const { shared("SET_DECAL_MATERIAL") };
        (if self.decal_textures.is_some() { decal } else { const { shared("SET_MATERIAL") } }) as usize
    }

    /// The bindings of `SET_FRAME`: bit `n` is binding `n`. Families with the same ones share the set, and a set that is
    /// bound stays so while their pipelines take turns.
    pub(in crate::gpu) fn frame(self) -> u32 {
        self.frame
    }

    /// [`Self::sets`] as a pipeline's layout has them: empty ones are left out, but for one before inputs, which are the second
    /// set in any case.
    pub(super) fn laid_out(self) -> Vec<Vec<Binding>> {
        let is_second = matches!(self.second, SecondSet::Inputs { .. });
        let sets = self.sets().into_iter().enumerate();
        sets.filter(|(i, b)| !b.is_empty() || *i == 0 && is_second).map(|(_, b)| b).collect()
    }

    /// The bindings of `SET_FRAME`, of the second set, and of a third: a decal's material, or `SET_LAYERS`.
    pub(super) fn sets(self) -> [Vec<Binding>; 3] {
        use vk::{DescriptorType as T, ShaderStageFlags as S};
        let material = |textures: u32, medium: bool| -> Vec<Binding> {
            let numbers = (const { shared("BINDING_MATERIAL") }, T::UNIFORM_BUFFER, 1, S::FRAGMENT);
            let images = const { shared("BINDING_TEXTURES") };
            let images = (textures > 0).then_some((images, T::COMBINED_IMAGE_SAMPLER, textures, S::FRAGMENT));
            let block = (const { shared("BINDING_MEDIUM") }, T::UNIFORM_BUFFER, 1, S::FRAGMENT);
            std::iter::once(numbers).chain(images).chain(medium.then_some(block)).collect()
        };
        let in_frame = FRAME_BINDINGS.iter().filter(|(binding, ..)| self.frame & (1 << binding) != 0);
        let inputs = |count: u32| -> Vec<Binding> {
            let inputs = (0..count).map(|i| (i, T::INPUT_ATTACHMENT, 1, S::FRAGMENT));
            let sampled = (0..u32::BITS).filter(|b| self.sampled & (1 << b) != 0);
            inputs.chain(sampled.map(|b| (b, T::SAMPLED_IMAGE, 1, S::FRAGMENT))).collect()
        };
        let second = match self.second {
            SecondSet::Material { textures, medium } => material(textures, medium),
            SecondSet::Nothing => Vec::new(),
            SecondSet::Inputs { count, bloom } => {
                let scattered = const { shared("BINDING_BLOOM") };
                let inputs = inputs(count).into_iter();
                inputs
                    .chain(bloom.then_some((scattered, T::COMBINED_IMAGE_SAMPLER, 1, S::FRAGMENT)))
                    .collect()
            }
            SecondSet::Samplers { bindings } => {
                let bound = (0..u32::BITS).filter(|b| bindings & (1 << b) != 0);
                bound.map(|b| (b, T::COMBINED_IMAGE_SAMPLER, 1, S::FRAGMENT)).collect()
            }
        };
        let frame = in_frame.map(|&(binding, ty, stages)| (binding, ty, 1, stages)).collect();
        let third =
            self.decal_textures.map_or_else(|| inputs(self.layers), |textures| material(textures, false));
        [frame, second, third]
    }
}

/// Descriptor set layouts and pipeline layout of a [`Family`].
pub(in crate::gpu) struct FamilyLayout {
    pub(in crate::gpu) sets: Vec<Owned<vk::DescriptorSetLayout>>,
    pub(in crate::gpu) layout: Owned<vk::PipelineLayout>,
    pub(in crate::gpu) bindings: [Vec<Binding>; 3],
}

impl FamilyLayout {
    pub(super) fn new(device: &Device, family: Family) -> Result<Self> {
        let bindings = family.sets();
        let laid_out = family.laid_out();
        let sets = laid_out.iter().map(|b| set_layout(device, b, &format!("{family:?}")));
        let sets: Vec<_> = sets.collect::<Result<_>>()?;
        let raw: Vec<_> = sets.iter().map(Owned::raw).collect();
        let range =
            |stages, bytes: usize| vk::PushConstantRange::default().stage_flags(stages).size(bytes as u32);
        let push = match family.push {
            Push::Nothing => None,
            Push::Light => Some(range(vk::ShaderStageFlags::FRAGMENT, size_of::<LightPush>())),
            Push::Overlay => Some(range(vk::ShaderStageFlags::VERTEX, size_of::<OverlayPush>())),
            Push::Volume => Some(range(vk::ShaderStageFlags::VERTEX, size_of::<VolumePush>())),
        };
        let pushes = push.as_slice();
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&raw).push_constant_ranges(pushes);
        // SAFETY: the set layouts are alive and belong to this device, and every device has 128 bytes to push.
        let layout = unsafe { device.create_pipeline_layout(&info, &format!("{family:?}")) }?;
        Ok(Self { sets, layout, bindings })
    }
}

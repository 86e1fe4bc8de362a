//! Which descriptor sets a pipeline takes.

use ash::vk;

use super::super::descriptor::Binding;
use super::super::shader::shared;
use super::super::{Device, Owned};
use crate::Result;
use crate::plan::{Around, Pipeline, Plan};

/// Pipelines that take the same descriptor sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::gpu) struct Family {
    /// The bindings of `SET_FRAME`: bit `n` is binding `n`.
    frame: u32,
    second: SecondSet,
}

/// The set beside `SET_FRAME`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::gpu) enum SecondSet {
    /// `SET_MATERIAL`: a material with this many textures.
    Material { textures: u32 },
    /// `SET_INPUTS`: this many input attachments.
    Inputs { count: u32 },
    /// There is none.
    Nothing,
}

const FRAME: u32 = shared("BINDING_FRAME");
const INSTANCES: u32 = shared("BINDING_INSTANCES");
const LIGHTS: u32 = shared("BINDING_LIGHTS");
const CLUSTERS: u32 = shared("BINDING_CLUSTERS");
const SPLIT_SUM: u32 = shared("BINDING_SPLIT_SUM");
const ENVIRONMENT: u32 = shared("BINDING_ENVIRONMENT");
const RADIANCE: u32 = shared("BINDING_RADIANCE");
const PROBES: u32 = shared("BINDING_PROBES");
const VOLUMES: u32 = shared("BINDING_VOLUMES");

/// Type and readers of each binding of `SET_FRAME`.
const FRAME_BINDINGS: [(u32, vk::DescriptorType, vk::ShaderStageFlags); 9] = {
    use vk::{DescriptorType as T, ShaderStageFlags as S};
    let both = S::from_raw(S::VERTEX.as_raw() | S::FRAGMENT.as_raw());
    [
        (FRAME, T::UNIFORM_BUFFER, both),
        (INSTANCES, T::STORAGE_BUFFER, S::VERTEX),
        (LIGHTS, T::STORAGE_BUFFER, both),
        (CLUSTERS, T::STORAGE_BUFFER, S::FRAGMENT),
        (SPLIT_SUM, T::COMBINED_IMAGE_SAMPLER, S::FRAGMENT),
        (ENVIRONMENT, T::UNIFORM_BUFFER, S::FRAGMENT),
        (RADIANCE, T::COMBINED_IMAGE_SAMPLER, S::FRAGMENT),
        (PROBES, T::STORAGE_BUFFER, S::FRAGMENT),
        (VOLUMES, T::STORAGE_BUFFER, S::VERTEX),
    ]
};

impl Family {
    /// What a pipeline of this stage reads.
    pub(in crate::gpu) fn of(plan: &Plan, stage: usize, pipeline: &Pipeline) -> Self {
        let clusters = plan.clusters.is_some();
        let frame: &[u32] = match pipeline {
            Pipeline::Depth(_) => &[FRAME, INSTANCES],
            Pipeline::Surface(kind) if kind.unlit || plan.has_gbuffer() => &[FRAME, INSTANCES],
            Pipeline::Surface(_) if clusters => &[FRAME, INSTANCES, LIGHTS, CLUSTERS],
            Pipeline::Surface(_) => &[FRAME, INSTANCES, LIGHTS],
            Pipeline::Lighting if clusters => &[FRAME, LIGHTS, CLUSTERS],
            Pipeline::Lighting => &[FRAME, LIGHTS],
            Pipeline::LightMask(_) | Pipeline::LightVolume(_) => &[FRAME, LIGHTS, VOLUMES],
            Pipeline::Tonemap => &[FRAME],
        };
        let around: &[u32] = match pipeline {
            Pipeline::Surface(kind) => match kind.around {
                Around::Nothing => &[],
                Around::Ambient => &[SPLIT_SUM],
                Around::Environment => &[SPLIT_SUM, ENVIRONMENT, RADIANCE],
                Around::Probes => &[SPLIT_SUM, ENVIRONMENT, RADIANCE, PROBES],
            },
            _ => &[],
        };
        let second = match pipeline {
            Pipeline::Depth(kind) if !kind.alpha_mask => SecondSet::Nothing,
            Pipeline::LightMask(_) => SecondSet::Nothing,
            Pipeline::Surface(kind) | Pipeline::Depth(kind) => {
                SecondSet::Material { textures: kind.textures.count_ones() }
            }
            Pipeline::Lighting | Pipeline::LightVolume(_) | Pipeline::Tonemap => {
                SecondSet::Inputs { count: plan.subpass(stage).2.inputs.len() as u32 }
            }
        };
        Self { frame: frame.iter().chain(around).fold(0, |bits, binding| bits | 1 << binding), second }
    }

    /// Whether the second set is a material's.
    pub(in crate::gpu) fn has_material(self) -> bool {
        matches!(self.second, SecondSet::Material { .. })
    }

    /// The bindings of `SET_FRAME`, and of the second set.
    fn sets(self) -> [Vec<Binding>; 2] {
        use vk::{DescriptorType as T, ShaderStageFlags as S};
        let in_frame = FRAME_BINDINGS.iter().filter(|(binding, ..)| self.frame & (1 << binding) != 0);
        let second = match self.second {
            SecondSet::Material { textures } => {
                let numbers = (const { shared("BINDING_MATERIAL") }, T::UNIFORM_BUFFER, 1, S::FRAGMENT);
                let images = const { shared("BINDING_TEXTURES") };
                let images =
                    (textures > 0).then_some((images, T::COMBINED_IMAGE_SAMPLER, textures, S::FRAGMENT));
                std::iter::once(numbers).chain(images).collect()
            }
            SecondSet::Nothing => Vec::new(),
            SecondSet::Inputs { count } => {
                (0..count).map(|i| (i, T::INPUT_ATTACHMENT, 1, S::FRAGMENT)).collect()
            }
        };
        [in_frame.map(|&(binding, ty, stages)| (binding, ty, 1, stages)).collect(), second]
    }
}

/// Descriptor set layouts and pipeline layout of a [`Family`].
pub(in crate::gpu) struct FamilyLayout {
    pub(in crate::gpu) sets: Vec<Owned<vk::DescriptorSetLayout>>,
    pub(in crate::gpu) layout: Owned<vk::PipelineLayout>,
    pub(in crate::gpu) bindings: [Vec<Binding>; 2],
}

impl FamilyLayout {
    pub(super) fn new(device: &Device, family: Family) -> Result<Self> {
        let bindings = family.sets();
        let sets = bindings.iter().filter(|b| !b.is_empty());
        let sets: Vec<_> = sets.map(|b| set_layout(device, family, b)).collect::<Result<_>>()?;
        let raw: Vec<_> = sets.iter().map(Owned::raw).collect();
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&raw);
        // SAFETY: the set layouts are alive and belong to this device.
        let layout = unsafe { device.create_pipeline_layout(&info, &format!("{family:?}")) }?;
        Ok(Self { sets, layout, bindings })
    }
}

fn set_layout(
    device: &Device,
    family: Family,
    bindings: &[Binding],
) -> Result<Owned<vk::DescriptorSetLayout>> {
    let bindings: Vec<_> = bindings
        .iter()
        .map(|&(binding, ty, count, stages)| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(ty)
                .descriptor_count(count)
                .stage_flags(stages)
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: binding numbers are distinct by `Family::sets`.
    unsafe { device.create_descriptor_set_layout(&info, &format!("{family:?}")) }
}

//! What pipelines are made of, as far as it follows from the plan alone.

use std::collections::{BTreeMap, BTreeSet};

use super::super::post::{PostParts, places};
use super::super::shader::{AttachmentPlaces, Module, Shaders, Specialization, declared, shared_names};
use super::super::shadow::{caster_bindings, caster_input, caster_modules};
use super::{Family, VertexInput, modules};
use crate::Result;
use crate::plan::Plan;

/// One pipeline: its shaders, and what it provides them with. Shaders mention what they are provided with, and a pipeline
/// provides no more than they mention.
#[derive(Clone, Debug)]
pub struct PipelineParts {
    /// As the plan prints it.
    pub name: String,
    /// What runs.
    pub shaders: Shaders,
    /// How many descriptors there are, by set and binding.
    pub bindings: BTreeMap<(u32, u32), u32>,
    /// Locations of vertex attributes.
    pub attributes: BTreeSet<u32>,
    /// Bytes of these that a vertex has.
    pub vertex_bytes: u32,
    /// How many colour attachments the fragment shader writes.
    pub targets: u32,
    /// Whether there are push constants.
    pub push_constants: bool,
    /// Vertex and fragment shader before they were specialised.
    pub modules: (Module, Option<Module>),
    /// What they were specialised with, whether they know it or not.
    pub specialization: Specialization,
    /// Where the subpass has its attachments.
    pub places: AttachmentPlaces,
}

impl PipelineParts {
    /// Every pipeline of a plan, then those of casters of shadows, then those of passes after the frame's own.
    ///
    /// # Errors
    /// As of [`Shaders::new`].
    pub fn of(plan: &Plan) -> Result<Vec<Self>> {
        let of_plan = plan.pipelines.iter().map(|(stage, pipeline)| {
            let (vertex, fragment, constants) = modules(plan, pipeline);
            let family = Family::of(plan, *stage, pipeline);
            let places = AttachmentPlaces::of(plan.subpass(*stage).2)?;
            let shaders = Shaders::new(vertex, fragment, &constants, &places)?;
            let input = VertexInput::new(pipeline, &shaders.attributes)?;
            Ok(Self {
                name: plan.pipeline_text(pipeline),
                bindings: counts(&family.laid_out()),
                attributes: input.attributes.iter().map(|a| a.location).collect(),
                vertex_bytes: input.bindings.iter().map(|b| b.stride).sum(),
                targets: fragment.map_or(0, |_| plan.subpass(*stage).2.colors.len() as u32),
                push_constants: family.has_push_constants(),
                shaders,
                modules: (vertex, fragment),
                specialization: constants,
                places,
            })
        });
        let casters = plan.shadow_map.iter().flat_map(|map| &map.casters).map(|kind| {
            let (vertex, fragment, constants) = caster_modules(kind);
            let (streams, attributes) = caster_input(kind.mask.as_ref())?;
            Ok(Self {
                name: format!("shadow caster, {kind}"),
                shaders: Shaders::new(vertex, fragment, &constants, &AttachmentPlaces::default())?,
                bindings: counts(&caster_bindings(kind)),
                attributes: attributes.iter().map(|a| a.location).collect(),
                vertex_bytes: streams.iter().map(|b| b.stride).sum(),
                targets: 0,
                push_constants: true,
                modules: (vertex, fragment),
                specialization: constants,
                places: AttachmentPlaces::default(),
            })
        });
        let post = plan.post.kinds().map(|pass| {
            let PostParts { family, fragment, constants, .. } = PostParts::of(plan, pass);
            let places = places();
            Ok(Self {
                name: pass.name.clone(),
                shaders: Shaders::new(Module::Fullscreen, Some(fragment), &constants, &places)?,
                bindings: counts(&family.laid_out()),
                attributes: BTreeSet::new(),
                vertex_bytes: 0,
                targets: 1,
                push_constants: false,
                modules: (Module::Fullscreen, Some(fragment)),
                specialization: constants,
                places,
            })
        });
        of_plan.chain(casters).chain(post).collect()
    }

    /// The specialisation constants that the shaders would be others without: name, as `ID_*` of `glsl/shared.h`, and value. All
    /// other constants may as well have their defaults.
    ///
    /// # Errors
    /// As of [`Shaders::new`].
    pub fn constants(&self) -> Result<BTreeMap<&'static str, u32>> {
        let (vertex, fragment) = self.modules;
        let mut needed = BTreeMap::new();
        let mut defaults = declared(vertex.spirv()?);
        if let Some(fragment) = fragment {
            defaults.extend(declared(fragment.spirv()?));
        }
        for (index, id) in self.specialization.ids.iter().enumerate() {
            if defaults.get(id).is_none_or(|default| *default == self.specialization.data[index]) {
                continue;
            }
            let mut without = self.specialization.clone();
            without.ids.remove(index);
            let value = without.data.remove(index);
            // Without the G-buffer's form the shaders have targets that the subpass has not.
            let same = Shaders::new(vertex, fragment, &without, &self.places).is_ok_and(|shaders| {
                (&shaders.vertex, &shaders.fragment) == (&self.shaders.vertex, &self.shaders.fragment)
            });
            if !same {
                let name = shared_names("ID_").find(|(_, number)| number == id);
                needed.insert(name.map_or("(without a name)", |(name, _)| name), value);
            }
        }
        Ok(needed)
    }
}

fn counts(sets: &[Vec<super::Binding>]) -> BTreeMap<(u32, u32), u32> {
    let numbered = (0..).zip(sets);
    numbered
        .flat_map(|(set, bindings)| {
            bindings.iter().map(move |&(binding, _, count, _)| ((set, binding), count))
        })
        .collect()
}

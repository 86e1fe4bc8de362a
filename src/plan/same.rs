//! What plans of two states of a scene have in common.

use super::{AroundImage, Attachment, Needs, Pass, Plan, ShadowNeeds};
use crate::visible::ShadowShape;

impl Plan {
    /// Whether render passes, attachments and the passes after them serve both plans: reasons aside, they are the same.
    pub(crate) fn shares_passes(&self, other: &Self) -> bool {
        let of = |plan: &Self| (bare_passes(&plan.passes), bare_attachments(&plan.attachments));
        self.options == other.options && self.post == other.post && of(self) == of(other)
    }

    /// Whether all pipelines serve both plans: what differs are reasons, and how often there is what there is.
    pub(crate) fn shares_pipelines(&self, other: &Self) -> bool {
        (self.bare(), self.mapped_shapes()) == (other.bare(), other.mapped_shapes())
    }

    /// All that pipelines know of the shadow map; those that draw it are not among them.
    fn mapped_shapes(&self) -> Option<[bool; 4]> {
        let map = self.shadow_map.as_ref()?;
        let has = |shape| map.lights.iter().any(|light| light.shape == shape);
        Some([ShadowShape::Cascades, ShadowShape::Slab, ShadowShape::Cone, ShadowShape::Cube].map(has))
    }

    fn bare(&self) -> Self {
        let mut needs = bare_needs(&self.needs);
        // Of shadows, pipelines look at the kinds of lights that have volumes.
        if self.volume_lights.is_empty() {
            needs.shadows = ShadowNeeds::default();
        }
        Self {
            needs,
            attachments: bare_attachments(&self.attachments),
            passes: bare_passes(&self.passes),
            shadow_map: None,
            around: self.around.iter().map(|a| AroundImage { why: String::new(), ..a.clone() }).collect(),
            notes: Vec::new(),
            warnings: Vec::new(),
            ..self.clone()
        }
    }
}

fn bare_passes(passes: &[Pass]) -> Vec<Pass> {
    let mut passes = passes.to_vec();
    passes.iter_mut().flat_map(|pass| &mut pass.subpasses).for_each(|subpass| subpass.why.clear());
    passes
}

fn bare_attachments(attachments: &[Attachment]) -> Vec<Attachment> {
    attachments.iter().map(|a| Attachment { why: Vec::new(), ..a.clone() }).collect()
}

/// Shaders know whether there is something, not how much of it.
fn bare_needs(needs: &Needs) -> Needs {
    let mut bare = needs.clone();
    for kind in &mut bare.kinds {
        kind.instances = kind.instances.min(1);
        kind.why.clear();
    }
    for decals in &mut bare.decals {
        decals.decals = decals.decals.min(1);
        decals.why.clear();
    }
    for name in [
        &mut bare.lit,
        &mut bare.lit_opaque,
        &mut bare.blended,
        &mut bare.transmits,
        &mut bare.refracts,
        &mut bare.occlusion,
    ]
    .into_iter()
    .flatten()
    {
        name.clear();
    }
    bare.prelit.clear();
    // Posed vertices are vertices like others.
    bare.posed = None;
    bare.shadows.lights.iter_mut().for_each(|light| light.name.clear());
    bare.environment.iter_mut().chain(&mut bare.probes).for_each(|environment| environment.name.clear());
    bare.particles.iter_mut().for_each(|particles| {
        particles.why.clear();
        particles.particles = particles.particles.min(1);
    });
    for count in [
        &mut bare.directional_lights,
        &mut bare.point_lights,
        &mut bare.spot_lights,
        &mut bare.box_lights,
        &mut bare.hemisphere_lights,
        &mut bare.back_colors,
        &mut bare.endless_lights,
        &mut bare.globe_maps,
        &mut bare.most_local_lights,
        &mut bare.triangles,
        &mut bare.blended_triangles,
    ] {
        *count = (*count).min(1);
    }
    bare.lights_at_a_point = 0.0;
    bare
}

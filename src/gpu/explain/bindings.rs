//! Why pipelines read vertex attributes and descriptors.

use super::super::shader::{shared, shared_names};
use super::elements::{Elements, is_local};
use crate::plan::{Pipeline, SLOTS};

const SET_FRAME: u32 = shared("SET_FRAME");
const SET_INPUTS: u32 = shared("SET_INPUTS");
const MATERIAL: u32 = shared("BINDING_MATERIAL");

impl Elements<'_> {
    /// Name of, and reason for, the vertex attribute at a location, of a pipeline that exists for `element`.
    pub(super) fn attribute(&self, location: u32, element: &str) -> (&'static str, String) {
        match location {
            l if l == const { shared("ATTRIBUTE_POSITION") } => ("position", format!("{element} is drawn")),
            l if l == const { shared("ATTRIBUTE_NORMAL") } => ("normal", format!("{element} is lit")),
            l if l == const { shared("ATTRIBUTE_TEXCOORD") } => {
                ("texture coordinates", format!("{element} has a texture or a part of the lightmap"))
            }
            l if l == const { shared("ATTRIBUTE_TANGENT") } => {
                ("tangent", format!("{element} has a normal map"))
            }
            _ => ("colour", format!("the mesh of {element} has vertex colours")),
        }
    }

    /// Name of, and reason for, a binding of the n-th pipeline, which exists for `element`.
    pub(super) fn binding(
        &self,
        pipeline: usize,
        set: u32,
        binding: u32,
        count: u32,
        element: &str,
    ) -> (String, String) {
        let found = self.plan.pipelines.get(pipeline);
        let name = shared_names("BINDING_").find(|(_, number)| *number == binding).map(|(name, _)| name);
        if binding >= const { shared("BINDING_BLOOM") } {
            let name = name.unwrap_or("(without a name)").to_lowercase().replace('_', " ");
            let why = match binding {
                b if b == const { shared("BINDING_EDGE_COLOR") } => "the option edge filter".into(),
                b if b == const { shared("BINDING_OTHER") } => "the options ask for a difference".into(),
                b if b >= const { shared("BINDING_BEHIND_LIGHT") } => {
                    format!("the option refraction is {}", self.plan.options.refraction)
                }
                _ => format!("the option bloom is {}", self.plan.options.bloom),
            };
            return (name, why);
        }
        if set != SET_FRAME {
            return match found {
                Some((stage, Pipeline::Decal(_))) if set == SET_INPUTS => self.input(*stage, binding),
                Some((stage, _)) if self.reads_both(pipeline) && set == const { shared("SET_LAYERS") } => {
                    self.input(*stage, binding)
                }
                Some((stage, pipeline)) if pipeline.reads_attachments() => self.input(*stage, binding),
                _ if binding == const { shared("BINDING_MEDIUM") } => {
                    ("medium".into(), format!("{element} lets light through"))
                }
                _ if binding == MATERIAL => ("material".into(), format!("factors of {element}")),
                _ => {
                    let slots = found.map_or_else(Vec::new, |(_, pipeline)| slots(pipeline));
                    let textures = if slots.is_empty() { "base colour".into() } else { slots.join(", ") };
                    (format!("textures[{count}]"), format!("{element} has textures: {textures}"))
                }
            };
        }
        let (name, why) = match binding {
            b if b == const { shared("BINDING_FRAME") } => {
                ("frame", "camera and exposure of the frame".into())
            }
            b if b == const { shared("BINDING_INSTANCES") } => ("instances", format!("{element} is placed")),
            b if b == const { shared("BINDING_LIGHTS") } => ("lights", self.light(|_| true)),
            b if b == const { shared("BINDING_CLUSTERS") } => (
                "light lists",
                format!("{} has a place: the way of lights is clusters", self.light(is_local)),
            ),
            b if b == const { shared("BINDING_VOLUMES") } => {
                ("volumes", format!("{} is drawn as a volume", self.light(is_local)))
            }
            b if b == const { shared("BINDING_PARTICLES") } => ("particles", format!("{element} shine")),
            b if b == const { shared("BINDING_DECALS") } => ("decals", format!("{element} is painted")),
            b if b == const { shared("BINDING_SHADOW_VIEWS") } => ("shadow views", self.shadow_lights()),
            b if b == const { shared("BINDING_SHADOW_MAP") } => ("shadow map", self.shadow_lights()),
            b if b == const { shared("BINDING_GLOBE_MAPS") } => ("globe maps", self.globe_light()),
            b if b == const { shared("BINDING_SPLIT_SUM") } => {
                ("split sum", format!("{element} reflects {}", self.around()))
            }
            b if b == const { shared("BINDING_ENVIRONMENT") } => ("environment", self.around()),
            b if b == const { shared("BINDING_RADIANCE") } => ("radiance", self.around()),
            b if b == const { shared("BINDING_PROBES") } => ("probes", self.around()),
            b if b == const { shared("BINDING_LIGHTMAPS") } => {
                ("lightmap parts", format!("instances of {element} have parts of the lightmap"))
            }
            b if b == const { shared("BINDING_LIGHTMAP") } => {
                ("lightmap", format!("{element} is lit by the lightmap"))
            }
            b if b == const { shared("BINDING_CASTERS") } => ("volume casters", self.volume_lights()),
            b if b == const { shared("BINDING_CASTER_INSTANCES") } => {
                ("volume caster instances", self.volume_lights())
            }
            _ => ("(without a name)", element.into()),
        };
        (name.into(), why)
    }

    /// Whether the n-th pipeline has input attachments beside a material.
    fn reads_both(&self, pipeline: usize) -> bool {
        let found = self.plan.pipelines.get(pipeline);
        found.is_some_and(|(_, p)| p.is_of_blended() || matches!(p, Pipeline::Particles(_)))
    }

    pub(super) fn globe_light(&self) -> String {
        self.light(|light| light.shown_globe_map().is_some()) + " shines through a picture"
    }

    fn input(&self, stage: usize, index: u32) -> (String, String) {
        let (pass, _, subpass) = self.plan.subpass(stage);
        let attachment = subpass.inputs.get(index as usize).map(|&i| {
            let attachment = self.plan.passes[pass].attachments[i].attachment;
            &self.plan.attachments[attachment]
        });
        let name = attachment.map_or_else(String::new, |a| a.name.clone());
        (format!("input {name}"), format!("{} reads what earlier stages left there", subpass.name))
    }
}

/// The texture slots of what a pipeline draws.
fn slots(pipeline: &Pipeline) -> Vec<&'static str> {
    let kind = match pipeline {
        Pipeline::Surface(kind) | Pipeline::Absorb(kind) | Pipeline::Light(kind) | Pipeline::Depth(kind) => {
            *kind
        }
        Pipeline::Decal(kind) => kind.surface(),
        Pipeline::Particles(kind) => kind.surface(),
        _ => return Vec::new(),
    };
    SLOTS.iter().enumerate().filter(|(slot, _)| kind.samples(*slot)).map(|(_, name)| *name).collect()
}

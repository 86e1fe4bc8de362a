//! Everything that exists for a scene, each with the element of the scene or the option that needs it. Needs no device: it follows
//! from scene and plan, by the functions that the objects are made with.

mod bindings;
mod constants;
mod contents;
mod elements;

use std::fmt::{Display, Formatter};

use serde::Serialize;

use super::pipeline::PipelineParts;
use crate::Result;
use crate::plan::{Pipeline, Plan, Strategy};
use crate::scene::Scene;
use elements::Elements;

/// What kind of thing exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ExplainedKind {
    /// What a render pass draws to.
    Attachment,
    /// A render pass.
    Pass,
    /// A part of one.
    Subpass,
    /// A graphics pipeline.
    Pipeline,
    /// A vertex attribute that a pipeline reads.
    Attribute,
    /// A descriptor binding of a pipeline.
    Binding,
    /// Push constants of a pipeline.
    Push,
    /// A specialisation constant of a pipeline that changes its shaders.
    Constant,
    /// An image that is sampled.
    Image,
    /// A buffer.
    Buffer,
}

/// Something that exists.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Explained {
    /// What kind of thing.
    pub kind: ExplainedKind,
    /// Its name; images and buffers have it on the device too.
    pub name: String,
    /// The pipeline that it is a part of.
    pub of: Option<String>,
    /// The scene element or the option that needs it.
    pub why: String,
}

/// All of it.
#[derive(Clone, Debug, Serialize)]
#[serde(transparent)]
pub struct Explanation {
    /// Attachments, passes with their subpasses, pipelines with their parts, images, buffers.
    pub objects: Vec<Explained>,
}

impl Explanation {
    /// Of what a renderer of this scene by this plan creates.
    ///
    /// # Errors
    /// As of [`PipelineParts::of`].
    pub fn new(scene: &Scene, plan: &Plan) -> Result<Self> {
        let elements = Elements::new(scene, plan);
        let mut objects = Vec::new();
        let mut add = |kind, name: String, of: Option<&str>, why: String| {
            objects.push(Explained { kind, name, of: of.map(str::to_owned), why });
        };
        for attachment in &plan.attachments {
            add(ExplainedKind::Attachment, attachment.name.clone(), None, attachment.why.join("; "));
        }
        for pass in &plan.passes {
            let why = match (plan.strategy, pass.subpasses.len()) {
                (_, 1) if plan.passes.len() == 1 => "a frame is at least one pass".into(),
                (Strategy::Separate, _) => "the strategy separate has a pass for each stage".into(),
                (_, stages) => format!("its {stages} stages need no more of each other than the same pixel"),
            };
            add(ExplainedKind::Pass, pass.name.clone(), None, why);
            for subpass in &pass.subpasses {
                add(ExplainedKind::Subpass, subpass.name.into(), None, subpass.why.clone());
            }
        }
        for pass in &plan.post.passes {
            add(ExplainedKind::Pass, pass.name.clone(), None, pass.why.into());
        }
        let parts = PipelineParts::of(plan)?;
        for (index, part) in parts.iter().enumerate() {
            let of = Some(part.name.as_str());
            let pipeline = plan.pipelines.get(index);
            let (element, more) = elements.of_pipeline(index);
            let why = [Some(element.clone()), more].into_iter().flatten().collect::<Vec<_>>().join("; ");
            add(ExplainedKind::Pipeline, part.name.clone(), None, why);
            for &location in &part.attributes {
                let (name, why) = elements.attribute(location, &element);
                add(ExplainedKind::Attribute, name.into(), of, why);
            }
            for (&(set, binding), &count) in &part.bindings {
                let (name, why) = elements.binding(index, set, binding, count, &element);
                add(ExplainedKind::Binding, name, of, why);
            }
            if part.push_constants {
                let why = match pipeline {
                    Some((_, Pipeline::Light(_))) => "says which light is added",
                    Some((_, Pipeline::Overlay)) => "the image's size in points",
                    Some((_, Pipeline::ShadowVolume)) => "says whose shadow is counted, and of which mesh",
                    _ => "the view of the tile that is drawn",
                };
                add(ExplainedKind::Push, "push constants".into(), of, why.into());
            }
            for (name, value) in part.constants()? {
                let shown = constants::shown(name, value);
                add(
                    ExplainedKind::Constant,
                    format!("{name} = {shown}"),
                    of,
                    elements.constant(name, value, &element),
                );
            }
        }
        for (name, why) in elements.other_pipelines() {
            add(ExplainedKind::Pipeline, name.into(), None, why);
        }
        for (name, why) in elements.images()? {
            add(ExplainedKind::Image, name, None, why);
        }
        for (name, why) in elements.buffers(&parts) {
            add(ExplainedKind::Buffer, name.into(), None, why);
        }
        Ok(Self { objects })
    }
}

impl Display for Explanation {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let mut last = None;
        for object in &self.objects {
            let group = match object.kind {
                ExplainedKind::Attachment => "attachments",
                ExplainedKind::Pass | ExplainedKind::Subpass => "passes",
                ExplainedKind::Image => "images that are sampled",
                ExplainedKind::Buffer => "buffers",
                _ => "pipelines",
            };
            if last != Some(group) {
                writeln!(f, "{}{group}:", if last.is_some() { "\n" } else { "" })?;
                last = Some(group);
            }
            let kind = match object.kind {
                ExplainedKind::Attribute => "    attribute ",
                ExplainedKind::Binding => "    binding   ",
                ExplainedKind::Push => "    ",
                ExplainedKind::Constant => "    constant  ",
                ExplainedKind::Subpass => "    subpass ",
                _ => "  ",
            };
            // Names of pipelines of surfaces say it.
            let why = if object.name.contains(&object.why) { "" } else { &object.why };
            let named = format!("{kind}{}", object.name);
            match why {
                "" => writeln!(f, "{named}")?,
                why => writeln!(f, "{named:<44}  {why}")?,
            }
        }
        Ok(())
    }
}

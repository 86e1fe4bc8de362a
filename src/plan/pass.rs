//! Render passes: attachments, subpasses and what orders them.

use serde::Serialize;

use super::{Format, Scope, State};

/// A physical attachment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attachment {
    /// The names of the resources that live in it, in order of lifetime, joined by `/`.
    pub name: String,
    /// How a sample is stored.
    pub format: Format,
    /// Samples a pixel.
    pub samples: u32,
    /// What the channels hold, one entry a resource.
    pub holds: Vec<&'static str>,
    /// The value that clearing gives, if it is cleared.
    pub clear: Option<[f32; 4]>,
    /// The host's image.
    pub is_output: bool,
    /// Never loaded and never stored: needs no memory on a tiler.
    pub transient: bool,
    /// What it is used for.
    pub usage: Usage,
    /// First and last stage.
    pub lifetime: (usize, usize),
    /// What needs it, one entry a resource.
    pub why: Vec<String>,
}

/// Uses of an attachment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Usage {
    /// Colour output.
    pub color: bool,
    /// Depth test.
    pub depth: bool,
    /// Input attachment.
    pub input: bool,
    /// Sampled by later passes.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub sampled: bool,
    /// Copied from.
    pub copy_source: bool,
    /// Colour output with fixed-function blending.
    pub blend: bool,
}

/// What happens to an attachment's content when a pass begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// Read from memory.
    Load,
    /// Set to the clear value, on the tile.
    Clear,
    /// Undefined.
    DontCare,
}

/// What happens to an attachment's content when a pass ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Store {
    /// Written to memory.
    Store,
    /// Dropped.
    DontCare,
}

/// An attachment as one pass sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PassAttachment {
    /// Index into [`Plan::attachments`](super::Plan::attachments).
    pub attachment: usize,
    /// At the pass's begin.
    pub load: Load,
    /// At the pass's end.
    pub store: Store,
    /// The same for the stencil beside depth, if the format has one.
    pub stencil: (Load, Store),
    /// State before the pass.
    pub initial: State,
    /// State after the pass.
    pub last: State,
}

/// One render pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pass {
    /// The stages' names joined by `+`.
    pub name: String,
    /// Attachments; subpasses refer to them by position here.
    pub attachments: Vec<PassAttachment>,
    /// In order of execution.
    pub subpasses: Vec<Subpass>,
    /// Between subpasses, and to the outside.
    pub dependencies: Vec<Dependency>,
    /// What a barrier before the pass does to each of its attachments; a render pass does it itself and has none.
    pub enter: Vec<Transition>,
    /// Likewise what a barrier after the pass does, to those that something waits for.
    pub leave: Vec<Transition>,
}

/// An attachment gets from one state to another, outside of a pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Transition {
    /// Position in [`Pass::attachments`].
    pub attachment: usize,
    /// The state before.
    pub from: State,
    /// The state after.
    pub to: State,
    /// What must be finished and visible.
    pub before: Scope,
    /// What waits for it.
    pub after: Scope,
}

impl Pass {
    /// Whether an attachment lies in tile memory: all do but those that samples are only resolved to.
    pub fn is_on_tile(&self, attachment: usize) -> bool {
        let uses = |s: &Subpass| {
            s.colors.contains(&attachment) || s.inputs.contains(&attachment) || s.depth == Some(attachment)
        };
        self.subpasses.iter().any(uses)
    }
}

/// One subpass; all lists hold positions in [`Pass::attachments`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Subpass {
    /// The stage's name.
    pub name: &'static str,
    /// Why it exists.
    pub why: String,
    /// What colour outputs are of, by location.
    pub color_names: Vec<&'static str>,
    /// By colour output location.
    pub colors: Vec<usize>,
    /// Whether colour outputs are added to what is there.
    pub blend: bool,
    /// Whether colour outputs are input attachments too, which each fragment finds as the one before it has left them.
    pub ordered: bool,
    /// The same, but a barrier is recorded between draws of which one finds what the other has left.
    pub barriers: bool,
    /// The state that each colour output is in.
    pub color_states: Vec<State>,
    /// What becomes of a colour output's samples when the subpass ends.
    pub resolve: Option<Resolve>,
    /// What input attachments are of, by index.
    pub input_names: Vec<&'static str>,
    /// By input attachment index.
    pub inputs: Vec<usize>,
    /// The state that each of them is in.
    pub input_states: Vec<State>,
    /// Depth test.
    pub depth: Option<usize>,
    /// The state that depth is in.
    pub depth_state: Option<State>,
    /// Whether it also writes depth.
    pub depth_write: bool,
    /// Whether depth is that of a layer which was peeled: only that layer passes.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub tests_peeled: bool,
    /// Whether the stencil of the depth attachment is written and tested.
    pub stencil: bool,
    /// What it sets to a value as it begins, as positions; all of it is colour outputs or depth.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub clears: Vec<(usize, [f32; 4])>,
    /// What it samples of what earlier passes have stored, neighbours too.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub samples: Vec<SampledAttachment>,
    /// Not used here, but needed later.
    pub preserve: Vec<usize>,
    /// Colour bits a pixel that the tile must hold during this subpass.
    pub live_color_bits: u32,
    /// Depth bits a pixel that the tile must hold during this subpass.
    pub live_depth_bits: u32,
}

/// What a subpass samples: it is no attachment of the pass, and in [`State::Sampled`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SampledAttachment {
    /// What it is of.
    pub name: &'static str,
    /// Index into [`Plan::attachments`](super::Plan::attachments).
    pub attachment: usize,
}

/// How the samples of a colour output become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Resolve {
    /// The colour output's location.
    pub from: usize,
    /// Position in [`Pass::attachments`] of what gets the mean.
    pub to: usize,
    /// The state that it is in.
    pub state: State,
}

/// An execution and memory dependency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dependency {
    /// Subpass that comes first; `None` is what happened before the pass.
    pub from: Option<usize>,
    /// Subpass that waits; `None` is what follows the pass.
    pub to: Option<usize>,
    /// What must be finished and visible.
    pub before: Scope,
    /// What waits for it.
    pub after: Scope,
    /// Only the same pixel matters: tilers may stay on the tile.
    pub by_region: bool,
    /// What orders them.
    pub why: Vec<String>,
}

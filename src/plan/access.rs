//! How memory is accessed, and the state that an attachment is in between accesses.

use std::collections::BTreeSet;

use serde::Serialize;

use super::stage::Use;
use super::{Load, OutputUse};

/// A kind of memory access; the pipeline stages in which it happens follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Access {
    /// Blending or loading a colour attachment.
    ColorRead,
    /// Writing, clearing or storing a colour attachment.
    ColorWrite,
    /// Depth or stencil test.
    DepthRead,
    /// Depth or stencil write, clear or store.
    DepthWrite,
    /// A fragment shader reads its own pixel.
    InputRead,
    /// A fragment shader samples.
    SampledRead,
    /// A copy reads.
    TransferRead,
}

/// A set of accesses.
pub type Scope = BTreeSet<Access>;

impl Access {
    /// The accesses that uses in one stage make.
    pub fn of(uses: &[Use]) -> Scope {
        uses.iter().flat_map(|how| Self::of_one(*how)).collect()
    }

    fn of_one(how: Use) -> Scope {
        match how {
            Use::Write | Use::Resolve => [Self::ColorWrite].into(),
            Use::Blend => [Self::ColorRead, Self::ColorWrite].into(),
            Use::Depth | Use::Stencil => [Self::DepthRead, Self::DepthWrite].into(),
            Use::DepthTest => [Self::DepthRead].into(),
            Use::Read => [Self::InputRead].into(),
            Use::Sample => [Self::SampledRead].into(),
            Use::Modify | Use::Rewrite => [Self::InputRead, Self::ColorWrite].into(),
        }
    }

    /// What a barrier within a stage orders: what a draw has written is read by one over it.
    pub const BETWEEN_DRAWS: [Self; 2] = [Self::ColorWrite, Self::InputRead];

    /// The access that a store operation makes, a discarding one included.
    pub const fn store(depth: bool) -> Self {
        if depth { Self::DepthWrite } else { Self::ColorWrite }
    }

    /// The access that a load operation makes: clearing and not caring count as writes.
    pub const fn load(depth: bool, load: Load) -> Self {
        match (depth, load) {
            (false, Load::Load) => Self::ColorRead,
            (true, Load::Load) => Self::DepthRead,
            (depth, _) => Self::store(depth),
        }
    }

    /// What the host does with the final image; presenting is ordered by a semaphore instead.
    pub const fn after_frame(output: OutputUse) -> Option<Self> {
        match output {
            OutputUse::Copy => Some(Self::TransferRead),
            OutputUse::Sample => Some(Self::SampledRead),
            OutputUse::Draw => Some(Self::ColorWrite),
            OutputUse::Present => None,
        }
    }
}

/// The arrangement in which an attachment's memory is left between accesses (an image layout).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// No content to keep.
    Undefined,
    /// Colour output.
    Color,
    /// Depth and stencil test.
    Depth,
    /// Input attachment.
    Input,
    /// Input attachment and colour output at once.
    InputColor,
    /// Depth as an input attachment, and tested if need be, but not written.
    DepthInput,
    /// The same while the stencil beside it is written.
    DepthInputStencil,
    /// All that the stages of one rendering do: output, tests, input attachment.
    LocalRead,
    /// Source of copies.
    CopySource,
    /// Sampled.
    Sampled,
    /// Ready to be presented.
    Present,
}

impl State {
    /// The state that the uses in one stage want of a colour or depth attachment.
    pub fn of(uses: &[Use], depth: bool) -> Self {
        let read = uses.contains(&Use::Read);
        match (depth, read) {
            (false, _) if uses.iter().any(|how| matches!(how, Use::Modify | Use::Rewrite)) => {
                Self::InputColor
            }
            (true, true) if uses.contains(&Use::Stencil) => Self::DepthInputStencil,
            (true, true) => Self::DepthInput,
            (true, false) => Self::Depth,
            (false, true) => Self::Input,
            (false, false) => Self::Color,
        }
    }

    /// The one state of an attachment in a rendering whose stages use it like this.
    pub fn throughout(uses: &[Use], depth: bool) -> Self {
        let reads = uses.iter().any(|how| matches!(how, Use::Read | Use::Modify | Use::Rewrite));
        match (reads, depth) {
            (true, _) => Self::LocalRead,
            (false, true) => Self::Depth,
            (false, false) => Self::Color,
        }
    }

    /// The state in which the host gets the final image.
    pub const fn after_frame(output: OutputUse) -> Self {
        match output {
            OutputUse::Copy => Self::CopySource,
            OutputUse::Present => Self::Present,
            OutputUse::Sample => Self::Sampled,
            OutputUse::Draw => Self::Color,
        }
    }
}

//! A G-buffer as it is chosen: a layout, and what is chosen besides.

use serde::{Deserialize, Serialize};

use super::{Layout, Options};

/// The part of [`Options`] that says how surfaces and light are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Choice {
    /// The layout.
    pub layout: Layout,
}

impl Choice {
    /// A layout as it is.
    pub const fn of(layout: Layout) -> Self {
        Self { layout }
    }

    /// What these options choose.
    pub fn in_options(options: &Options) -> Self {
        Self { layout: options.layout }
    }

    /// The options with this choice in place of their own.
    pub fn apply(self, options: &Options) -> Options {
        Options { layout: self.layout, ..options.clone() }
    }

    /// Every layout as it is, then each single other choice over `base`.
    pub fn one_by_one(base: Self) -> Vec<Self> {
        let _ = base;
        Layout::ALL.iter().map(|&layout| Self::of(layout)).collect()
    }

    /// What [`crate::measure::choose`] chooses from.
    pub fn candidates() -> Vec<Self> {
        Layout::ALL.iter().filter(|&&l| l != Layout::Exact).map(|&layout| Self::of(layout)).collect()
    }

    /// Every combination, whether it makes sense or not: [`super::Plan::new`] refuses what does not.
    pub fn every() -> Vec<Self> {
        Layout::ALL.iter().map(|&layout| Self::of(layout)).collect()
    }

    /// Whether the layout is taken as it is.
    pub fn is_plain(&self) -> bool {
        *self == Self::of(self.layout)
    }

    /// The flags of the command line that make this choice.
    pub fn flags(&self) -> Vec<String> {
        vec!["--layout".into(), self.layout.name().into()]
    }
}

impl std::fmt::Display for Choice {
    /// The layout, and what is chosen besides after plus signs.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.layout.name())
    }
}

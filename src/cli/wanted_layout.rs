//! A layout by its name, or by what a scene makes of them.

use std::fmt::Display;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use ontile::plan::Layout;

/// A layout, or the wish that one be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WantedLayout {
    Named(Layout),
    Auto,
}

impl WantedLayout {
    const AUTO: &'static str = "auto";

    pub fn named(self) -> Option<Layout> {
        match self {
            Self::Named(layout) => Some(layout),
            Self::Auto => None,
        }
    }

    pub fn parser() -> impl TypedValueParser<Value = Self> {
        let names = Layout::ALL.iter().map(|layout| layout.name()).chain([Self::AUTO]);
        PossibleValuesParser::new(names).try_map(|typed| match typed.as_str() {
            Self::AUTO => Ok(Self::Auto),
            name => name.parse().map(Self::Named),
        })
    }
}

impl Display for WantedLayout {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.named().map_or(Self::AUTO, Layout::name))
    }
}

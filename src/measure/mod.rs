//! How far pictures are from each other, where methods fail, and what frames cost.

pub mod bandwidth;
#[cfg(feature = "cli")]
mod compare;
mod false_color;
pub mod metrics;
mod pairs;
#[cfg(feature = "cli")]
pub mod plot;
pub mod tiler;

#[cfg(feature = "cli")]
pub use compare::{ChannelError, Comparison, Unit, compare};
pub use false_color::{NON_FINITE_RGB, false_color, magma};

//! How far pictures are from each other, and where methods fail.

#[cfg(feature = "cli")]
mod compare;
mod false_color;
pub mod metrics;
mod pairs;
#[cfg(feature = "cli")]
pub mod plot;
#[cfg(feature = "cli")]
pub mod stability;
pub mod tiler;

#[cfg(feature = "cli")]
pub use compare::{ChannelError, Comparison, Unit, compare};
pub use false_color::{NON_FINITE_RGB, false_color, magma};

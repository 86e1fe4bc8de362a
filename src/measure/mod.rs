//! How far pictures are from each other, where methods fail, and what frames cost.

pub mod bandwidth;
mod ciede;
mod color;
#[cfg(feature = "cli")]
mod compare;
mod false_color;
mod flip;
pub mod metrics;
mod pairs;
#[cfg(feature = "cli")]
pub mod plot;
pub mod tiler;

pub use ciede::ciede2000;
pub use color::lab_from_linear;
#[cfg(feature = "cli")]
pub use compare::{ChannelError, Comparison, RELATIVE_FLOOR, Unit, compare};
pub use false_color::{NON_FINITE_RGB, false_color, magma};
pub use flip::{PIXELS_PER_DEGREE, flip};

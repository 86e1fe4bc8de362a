//! How far pictures are from each other, where methods fail, and what frames cost.

pub mod bandwidth;
#[cfg(feature = "cli")]
pub mod canvas;
#[cfg(feature = "cli")]
pub mod chart;
mod choose;
mod ciede;
mod color;
#[cfg(feature = "cli")]
mod compare;
#[cfg(feature = "cli")]
mod edges;
mod false_color;
mod flip;
#[cfg(feature = "cli")]
mod host;
pub mod metrics;
mod pairs;
#[cfg(feature = "cli")]
pub mod plot;
mod probe;
#[cfg(feature = "cli")]
mod race;
#[cfg(feature = "cli")]
pub mod stability;
mod stats;
mod stored;
pub mod tiler;
#[cfg(feature = "cli")]
pub mod turnip;
#[cfg(feature = "cli")]
pub mod ways;

pub use choose::{Chosen, ErrorMetric, Goal, candidates_for, choose};
pub use ciede::ciede2000;
pub use color::lab_from_linear;
#[cfg(feature = "cli")]
pub use compare::{ChannelError, Comparison, RELATIVE_FLOOR, Unit, compare};
#[cfg(feature = "cli")]
pub use edges::lit_by_sample;
pub use false_color::{NON_FINITE_RGB, false_color, magma};
pub use flip::{PIXELS_PER_DEGREE, flip};
#[cfg(feature = "cli")]
pub use host::{FrameTimes, Host};
pub use probe::{Content, Predicted, Probe};
#[cfg(feature = "cli")]
pub use race::{Clock, Effort, Racer, race, rounded_ms};
pub use stats::Summary;
pub use stored::stored;

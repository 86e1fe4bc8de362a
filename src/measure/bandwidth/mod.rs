//! What a frame moves between GPU and memory.
//!
//! [`Thibieroz`] is a formula for deferred shading that leaves the chip, as GPUs without tiles do it. [`count`] counts what
//! it is fed with, and [`FrameTraffic`] puts its answer beside what this renderer asks of the driver, and adds up whole frames:
//!
//! - Attachments are planned: their load and store operations, times the pixels. Compression, which many GPUs have, is not
//!   counted.
//! - Textures, shadow maps and geometry are modelled between two bounds. One is caches without an end: of an image no
//!   more is read than it has, and no more than a texel a lookup; a draw reads each vertex once. The other is none: each lookup
//!   fetches one texel, as the formula has it, and each index its vertex. A light with a shadow samples the map where its volume
//!   holds a surface; lights with globe maps are taken to reach every pixel that is lit.
//! - Fragments are counted by the driver.
//! - What a tiler writes to sort triangles into tiles is left out: it is alike for both.

mod count;
mod frame;
mod thibieroz;

pub use count::{Counts, Draw, Lookup, count};
pub use frame::{FrameTraffic, ModelledFrame, PUBLISHED, Part, Saved};
pub use thibieroz::{Table2, Thibieroz, Traffic, table_2};

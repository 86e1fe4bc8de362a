//! What a frame moves between GPU and memory.
//!
//! [`Thibieroz`] is a formula for deferred shading that leaves the chip, as GPUs without tiles do it.

mod thibieroz;

pub use thibieroz::{Table2, Thibieroz, Traffic, table_2};

//! The C interface, `src/capi/ontile.h`: what [`crate::gpu`] and [`crate::scene::World`] offer an engine, as C functions.
//!
//! Objects are opaque and owned by whoever made them; descriptions are structs of plain numbers; every function returns a result
//! code, with the message in [`ontile_last_error`]. No panic crosses the border. The header is made of these files (a test compares
//! them), so their comments are what C programmers read. [`crate::embedding`] takes them through it.

mod ahead;
mod call;
mod elements;
mod frame;
mod host;
mod motion;
mod options;
mod over;
mod probes;
mod read;
mod told;
mod world;

pub use ahead::*;
pub use call::*;
pub use elements::*;
pub use frame::*;
pub use host::*;
pub use motion::*;
pub use options::*;
pub use over::*;
pub use probes::*;
pub use told::*;
pub use world::*;

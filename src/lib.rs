//! Deferred shading that never leaves the tile.

#![deny(missing_docs)]

mod error;
pub mod file;
pub mod gpu;
pub mod measure;
pub mod picture;
pub mod plan;
pub mod reference;
pub mod scene;

pub use error::{Error, Result};
pub use glam;

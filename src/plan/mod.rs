//! What a frame consists of, decided from what the scene needs; pure data that names no Vulkan type.

mod options;

pub use options::{Layout, Options, OutputFormat, OutputUse, Strategy, Tonemap};

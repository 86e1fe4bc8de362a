//! The plan made of Vulkan objects, and the frame recorded with them.

pub mod shader;
pub mod shared;

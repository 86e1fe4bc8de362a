//! Vulkan, and the only `unsafe` code of the crate but for the C interface.
//!
//! Ownership follows four rules:
//!
//! - Every handle lives in a drop owner ([`Owned`], [`Buffer`], [`Image`], ...) from the statement after its creation,
//!   before anything else can fail, so `?` never leaks. An owner keeps a [`Device`] clone: the device outlives
//!   everything made from it.
//! - Fields are declared in the order in which they must be destroyed (a buffer before its memory).
//! - Owners know nothing about the GPU's progress. Whoever submits keeps them alive until the work has
//!   finished; [`Commands`] waits on its own.
//! - What a host passes in through [`HostDevice`] stays the host's: it is used and never destroyed.
//!
//! Memory comes from one place (`memory.rs`) and every object is counted, so [`Device::live`] tells at any
//! time what exists. Commands are recorded through a [`Recorder`], which stands for a command buffer in the
//! recording state, a host's or our own. Nothing here waits for the GPU except [`Commands`].
//!
//! [`crate::embedding`] takes an engine through it.

mod around;
mod budget;
mod buffer;
mod cache;
mod caps;
mod command;
mod conv;
mod convert;
mod counters;
mod decals;
mod descriptor;
mod device;
mod explain;
mod fragments;
mod frame_data;
mod geometry;
mod globe_maps;
mod headless;
mod image;
mod info;
mod light_lists;
mod lights;
mod material_data;
mod memory;
mod merge_feedback;
mod meshes;
mod objects;
mod offscreen;
mod overlay;
mod owned;
mod particles;
mod pass;
mod pipeline;
mod poses;
mod post;
#[cfg(feature = "view")]
mod presenter;
mod query;
mod quirks;
mod readback;
mod renderer;
mod rendering;
mod scene_data;
// For tests and tools: no part of the interface.
#[doc(hidden)]
pub mod shader;
mod shadow;
#[doc(hidden)]
pub mod shared;
#[cfg(feature = "view")]
mod swapchain;
mod target;
mod texture;
mod upload;
mod validation;
mod view;
mod volume_casters;
#[cfg(feature = "view")]
mod window;

pub use ash;
pub use gpu_allocator;

pub use budget::MemoryBudget;
pub use buffer::{Buffer, BufferDesc};
pub use cache::PipelineCache;
pub use caps::{Caps, DeviceType, MemoryType};
pub use command::{Commands, Label, Recorder};
pub use counters::{Counter, CounterQuery, Counters};
pub use device::{Device, Features, HostDevice};
pub use explain::{Explained, ExplainedKind, Explanation};
pub use fragments::{DrawCount, DrawnMesh};
pub use geometry::{Geometry, IndexWidth, MeshRange, StreamGroup, StreamKind, Streams};
pub use headless::{Headless, HeadlessOptions};
pub use image::{Cubes, Image, ImageDesc};
pub use info::{devices, devices_with_counters};
pub use memory::MemoryUse;
pub use offscreen::Offscreen;
pub use overlay::{OverlayFrame, OverlayPart, OverlayVertex};
pub use owned::{Live, Object, Owned};
pub use pipeline::PipelineParts;
pub use query::{PipelineStatistics, Queries, QueryResults};
pub use readback::{Readback, texel_bytes};
pub use renderer::{Recorded, Renderer, RendererConfig, Updated};
#[cfg(feature = "view")]
pub(crate) use renderer::{SeenLight, SeenLights};
pub use shadow::RecordedShadows;
pub use target::{OutputImage, Target, check_formats};
pub use texture::{ColorEncoding, SamplerCache, TextureKey, Textures};
pub use upload::Upload;
pub use validation::expected_advice;
pub use view::View;
#[cfg(feature = "view")]
pub use {
    presenter::{Presented, Presenter},
    swapchain::{PresentMode, Swapchain},
    window::{Surface, WindowHandles, WindowHost},
};

use crate::{Error, Result};
use ash::vk;

/// Names the Vulkan call in the error of a failed one.
pub(crate) trait Called<T> {
    /// [`Error::Vulkan`] with the function's name.
    fn called(self, call: &'static str) -> Result<T>;
}

impl<T> Called<T> for Result<T, vk::Result> {
    fn called(self, call: &'static str) -> Result<T> {
        self.map_err(|result| Error::Vulkan { call, result })
    }
}

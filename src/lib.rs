//! Deferred shading that never leaves the tile.
//!
//! Deferred renderers write a G-buffer and read it back to light it. On the GPUs of phones and tablets, which draw an
//! image tile by tile in memory on the chip, that traffic is avoidable: when G-buffer, lighting and tonemap are subpasses
//! of one Vulkan render pass, joined by input attachments, only the final image has to leave the chip. This crate plans
//! such a pass for a scene, records it, counts what it costs, and knows what the picture should be.
//!
//! # The flow
//!
//! ```text
//! scene --> needs --> plan --> Vulkan objects --> recorded commands --> picture and report
//!                      | |
//!                      | `--> ledger: bytes per pixel, bits on the tile, a verdict per family of GPUs
//!                      `----> reference: the same frame in f64 on the CPU
//! ```
//!
//! Data flows one way, and every arrow is one call:
//!
//! ```no_run
//! use ontile::gpu::{Headless, HeadlessOptions, Offscreen, PipelineCache, RendererConfig, View};
//! use ontile::plan::{Needs, Options, Plan};
//! use ontile::scene::Scene;
//!
//! # fn main() -> ontile::Result<()> {
//! let scene = Scene::load("scene.glb".as_ref())?;
//! let host = Headless::new(&HeadlessOptions::default())?;
//! let device = host.device();
//! let plan = Plan::new(Needs::of(&scene), Options::default(), &device.limits())?;
//! println!("{plan}");
//! let cache = PipelineCache::load(device)?;
//! let mut frame = Offscreen::new(device, &scene, plan, RendererConfig::default(), &cache)?;
//! frame.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 })?;
//! frame.picture().write("scene.png".as_ref())?;
//! # Ok(())
//! # }
//! ```
//!
//! An engine puts its own device, images and command buffers in the place of `Headless` and `Offscreen`: [`embedding`] has the
//! whole example, in Rust and in C, and says who owns and who synchronises what.
//!
//! # What always holds
//!
//! - A [`plan`] is data. It names no Vulkan type and opens no device, prints itself with its reasons, and is the same for
//!   the same needs, options and limits.
//! - Vulkan is named in [`gpu`] and the C interface alone, where all `unsafe` code is too; glTF in the loader of [`scene`] alone.
//! - The [`mod@reference`] reads scene and plan and nothing of [`gpu`], so the two can be compared.
//! - What a scene does not need does not exist: without textures nothing is sampled; without emission, ambient light or
//!   unlit surfaces there is no light target, and lighting writes the final image itself.
//! - Load and store operations, lifetimes, transience and dependencies follow from who reads and who writes what.
//! - Reports come from the structs that the Vulkan objects were made from. Every figure says whether it was planned,
//!   modelled, or told by a driver.
//! - One plan runs as subpasses, as one rendering with local reads or as separate passes, with attachments shared or not, and gives the same pixels.
//!
//! # Conventions
//!
//! World space is right-handed with +Y up, in metres. Matrices say both spaces (`clip_from_world`), quantities their unit
//! (`range_m`, `intensity_cd`). Light is linear Rec.709 until the output. Depth is reversed: 1 at the near plane, 0 at the
//! far one.

#![deny(missing_docs)]

#[cfg(feature = "capi")]
pub mod capi;
/// How an engine embeds the renderer, in Rust and in C.
///
#[doc = include_str!("embedding.md")]
pub mod embedding {}
pub mod environment;
mod error;
pub mod file;
pub mod gpu;
#[cfg(feature = "measure")]
pub mod lightmap;
#[cfg(feature = "measure")]
pub mod measure;
pub mod picture;
pub mod plan;
#[cfg(feature = "measure")]
pub mod reference;
pub mod scene;
#[cfg(feature = "view")]
pub mod view;
pub mod visible;

pub use error::{Error, Result};
pub use glam;

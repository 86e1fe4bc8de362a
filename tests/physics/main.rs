//! The GPU's pictures against the f64 reference: with the `exact` layout the shaders are all that can differ, with
//! `metallic128` the error is what its bits cost. Every check is shown to fail on a fault.

#[path = "../common/mod.rs"]
mod common;

mod around;
mod brdf;
mod decals;
mod error;
mod exact;
mod files;
mod finite;
mod gbuffer;
mod gpu;
mod layouts;
mod light_scenes;
mod media;
mod moving;
mod over_light;
mod particles;
mod quantised;
mod scenes;
mod show;
mod surroundings;
mod textured;
mod translucent;

/// Sixteen to nine, large enough for highlights and cones, small enough for a software rasteriser.
const SIZE: [u32; 2] = [256, 144];

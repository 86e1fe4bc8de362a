//! The same frame in f64 on the CPU: what the renderer's pictures are measured against.
//!
//! Everything here is computed from [`scene`](crate::scene) and the choices in [`plan`](crate::plan), and from
//! nothing that a GPU does: visibility by rays through pixel centres ([`visibility`]), surfaces by
//! interpolation at the hit ([`gbuffer`]), light by the formulas of glTF 2.0 ([`brdf`], [`punctual`],
//! [`around`], [`mod@shade`]), fog between it and the viewer ([`fog`]), the display by the curve's own definition
//! ([`mod@tonemap`]). Functions carry the
//! names of their counterparts in `glsl/`, and each term names its source, so that the two can be read side by
//! side.
//!
//! The frame can be had in two ways. Without a layout it is the true one: f64 from the scene's f32 data to the
//! picture. With a [`Layout`](crate::plan::Layout) each pixel passes through that layout's stored formats
//! ([`mod@quantise`]), so that what a G-buffer's bits cost can be told apart from what a shader gets wrong.
//!
//! Guards against division by zero and the clamped roughness are part of the shading's definition, and the same
//! on both sides. Three things are *not* the GPU's own: a rasteriser snaps vertices to a subpixel grid and
//! breaks ties at edges ([`Pixel::edge`] says where that can show); textures are read bilinearly from level 0,
//! without mip levels or a driver's filter precision ([`texture`]), which [`shade_gbuffer`] avoids by shading
//! attributes that a GPU wrote; and shadows have hard edges, which lie where rays say and not on a lattice of texels
//! ([`shadow`], [`Pixel::shadowed`]).

pub mod around;
pub mod bloom;
pub mod brdf;
mod bvh;
mod decals;
pub mod edge_filter;
mod edges;
pub mod environment;
pub mod fog;
pub mod frame;
pub mod gbuffer;
pub mod globe;
mod layers;
pub mod lightmap;
mod media;
mod particles;
pub mod path;
pub mod punctual;
pub mod quantise;
mod refraction;
pub mod samples;
mod settings;
pub mod shade;
pub mod shadow;
pub mod texture;
mod through;
pub mod tonemap;
pub mod tonemap_inverse;
pub mod view;
pub mod visibility;

#[cfg(test)]
mod testing;

pub use frame::{Frame, Pixel, Tracer, render, shade_gbuffer};
pub use gbuffer::Attributes;
pub use quantise::{Stored, decode, encode, quantise};
pub(crate) use refraction::refract;
pub use settings::{Behind, Settings};
pub use shade::shade;
pub use shadow::Occlusion;
pub use view::{View, Window};
pub use visibility::Visibility;

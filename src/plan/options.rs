//! What the user may choose about a frame.

mod set;

use serde::Serialize;

use super::{
    BloomWay, Brdf, DecalWay, DepthStore, Edges, Gamma, Layout, LightFormat, LightWay, Normals, OutputFormat,
    OutputUse, Path, Refraction, ResolveWay, ShadowFilter, ShadowFormat, Show, Strategy, Tonemap,
    Translucency,
};
use crate::environment::TexelFormat;

/// How shadows are made, where lights cast them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShadowOptions {
    /// Samples a pixel.
    pub filter: ShadowFilter,
    /// Of the map.
    pub format: ShadowFormat,
    /// The longest side that the map may have, 128 to 16384 texels, rounded down to a power of two; it has no more than its
    /// tiles need.
    pub most_texels: u32,
    /// Side of a directional, box or spot light's tiles, from 128 texels to the map's side, rounded down to a power of two; a
    /// point light's have half of it. `None`: a texel a pixel
    /// if a tile fills the picture.
    pub tile_texels: Option<u32>,
    /// Cascades of a directional light at most.
    pub cascades: u32,
    /// Cascades follow the camera in steps of whole texels, so that the shadows of what stands still do too. Without, their
    /// edges swim with every movement of the camera: to show what the steps are for.
    pub stable: bool,
}

impl Default for ShadowOptions {
    fn default() -> Self {
        Self {
            filter: ShadowFilter::Grid3,
            format: ShadowFormat::Auto,
            most_texels: 4096,
            tile_texels: None,
            cascades: 3,
            stable: true,
        }
    }
}

/// The user's choices for a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Options {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// How stages become render passes.
    pub strategy: Strategy,
    /// G-buffer layout.
    pub layout: Layout,
    /// How normals are encoded; `None`: the layout's way.
    pub normals: Option<Normals>,
    /// How colours are encoded, likewise.
    pub gamma: Option<Gamma>,
    /// What light is summed in, likewise.
    pub light_target: Option<LightFormat>,
    /// Where depth is read, likewise.
    pub depth: Option<DepthStore>,
    /// How reflection is evaluated.
    pub brdf: Brdf,
    /// When surfaces are lit.
    pub path: Path,
    /// How lights reach pixels.
    pub lights: LightWay,
    /// Shadow maps.
    pub shadows: ShadowOptions,
    /// Tone curve.
    pub tonemap: Tonemap,
    /// The final image's format.
    pub output: OutputFormat,
    /// What the host does with the final image.
    pub output_use: OutputUse,
    /// Whether the final image may be read as an input attachment, so that it can stand in for another
    /// attachment until it is written. A host whose image lacks that usage says `false`.
    pub output_is_input_attachment: bool,
    /// Share physical attachments between lifetimes that do not overlap.
    pub recycle: bool,
    /// Merge lighting and tonemap where nothing needs the light target.
    pub fold: bool,
    /// Add half a step of ordered noise before rounding the output to 8 bits; no choice with a float output.
    pub dither: bool,
    /// Draw the depth of all surfaces first, so that each pixel is shaded once. Pays where shading a pixel costs more than
    /// drawing its triangles twice. Of surfaces that coincide the last drawn is seen, without it the first.
    pub depth_prepass: bool,
    /// On the path forward-multipass: draw for each light only the objects that its reach touches, its illumination set.
    pub illumination_sets: bool,
    /// Store the G-buffer too, so that it can be read back (for debugging and tests).
    pub keep_gbuffer: bool,
    /// How an environment's radiance is stored, unless it was filtered already.
    pub environment_format: TexelFormat,
    /// How a lightmap's light is stored.
    pub lightmap_format: TexelFormat,
    /// Why the G-buffer is what it is, where nobody named it (`measure::choose`); the plan's notes begin with it.
    pub gbuffer_why: Vec<String>,
    /// How what is blended comes over each other.
    pub translucency: Translucency,
    /// How many layers of a pixel are kept (oit: 1 to 4, by default 4) or peeled (1 to 16, by default 8).
    pub translucency_layers: Option<u32>,
    /// Samples a pixel: 1, 2, 4 or 8, as the device allows.
    pub samples: u32,
    /// Which pixels are lit sample by sample.
    pub edges: Edges,
    /// How samples become one.
    pub resolve: ResolveWay,
    /// How decals that overlap are painted.
    pub decals: DecalWay,
    /// Light that lens and eye scatter around bright places.
    pub bloom: BloomWay,
    /// The share of light that is scattered, 0 to 1.
    pub bloom_strength: f32,
    /// How far it is scattered: the size of the widest step's pixels as a share of the picture's shorter side, above 0 to 1.
    pub bloom_radius: f32,
    /// Smooth edges, found by depth and normals of neighbours (Koonce 2007, listing 19-3), in a pass after the frame's own.
    pub edge_filter: bool,
    /// Shadows by counting, in the stencil, the spaces behind what faces a light, in place of shadow maps: directional, point and spot
    /// lights, each added by itself. [`crate::scene::Shadow::volume`] says so of one light, and wins.
    pub shadow_volumes: bool,
    /// Whether media bend what is behind them.
    pub refraction: Refraction,
    /// Leave room for triangles over the picture, drawn at the end of the stage that writes it: a program's own interface.
    pub overlay: bool,
    /// What is drawn: the picture, or what the G-buffer holds.
    pub show: Show,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            size: [1280, 720],
            strategy: Strategy::Subpasses,
            layout: Layout::Metallic128,
            normals: None,
            gamma: None,
            light_target: None,
            depth: None,
            brdf: Brdf::Exact,
            path: Path::Deferred,
            lights: LightWay::Auto,
            shadows: ShadowOptions::default(),
            tonemap: Tonemap::Neutral,
            output: OutputFormat::Rgba8Srgb,
            output_use: OutputUse::Copy,
            output_is_input_attachment: true,
            recycle: true,
            fold: true,
            dither: false,
            depth_prepass: false,
            illumination_sets: true,
            keep_gbuffer: false,
            environment_format: TexelFormat::E5B9G9R9,
            lightmap_format: TexelFormat::E5B9G9R9,
            gbuffer_why: Vec::new(),
            translucency: Translucency::Sorted,
            translucency_layers: None,
            samples: 1,
            edges: Edges::Auto,
            resolve: ResolveWay::Tonemapped,
            decals: DecalWay::Auto,
            bloom: BloomWay::Off,
            bloom_strength: 0.05,
            bloom_radius: 0.1,
            edge_filter: false,
            shadow_volumes: false,
            refraction: Refraction::None,
            overlay: false,
            show: Show::Picture,
        }
    }
}

impl Options {
    /// How many layers of a pixel what is blended is kept or peeled in.
    pub fn layers(&self) -> u32 {
        let default = if self.translucency == Translucency::Peeled { 8 } else { 4 };
        self.translucency_layers.unwrap_or(default)
    }
}

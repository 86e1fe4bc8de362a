//! The shadow map in the ledger.

use serde::Serialize;

use super::{Figure, Format, Origin, ShadowFilter, ShadowMap};
use crate::visible::ShadowShape;

/// The shadow map as it was planned.
#[derive(Clone, Debug, Serialize)]
pub struct ShadowMapReport {
    /// How a depth is stored.
    pub format: Format,
    /// Width and height in texels.
    pub size: [u32; 2],
    /// Whether a second image of this size holds what stands still, for tiles in which something else moves.
    pub has_static_map: bool,
    /// Bytes of memory of both.
    pub bytes: Figure,
    /// Bytes that a frame stores which draws all tiles, as the first one does; nothing is loaded.
    pub stored_bytes: Figure,
    /// Texels that a pixel reads for each light whose shadow it may be in, at most: four a sample.
    pub sampled_texels: Figure,
    /// The lights that have a part of it, most important first.
    pub lights: Vec<ShadowLightReport>,
    /// Kinds of casters, as text; one pipeline each.
    pub casters: Vec<String>,
}

/// A light's part of the shadow map.
#[derive(Clone, Debug, Serialize)]
pub struct ShadowLightReport {
    /// The light's name.
    pub name: String,
    /// What views its shadow takes.
    pub shape: ShadowShape,
    /// How many tiles it has.
    pub tiles: usize,
    /// Side of each, texels.
    pub texels: u32,
    /// Bytes stored when all of them are drawn.
    pub stored_bytes: Figure,
}

/// What the last frame did about shadows.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ShadowFigures {
    /// Tiles that were drawn; all others that are of use were kept.
    pub tiles_drawn: usize,
    /// Of these, tiles of which no more was drawn than where dynamic casters moved, over a copy of what stands still.
    pub tiles_composed: usize,
    /// Tiles of the static map that were drawn, beside these.
    pub static_tiles_drawn: usize,
    /// Tiles that have to wait for a later frame.
    pub tiles_waiting: usize,
    /// Draw calls, beside those of the main pass.
    pub draws: usize,
    /// Instances drawn, once for each tile that they are in.
    pub casters: usize,
    /// Instances that were not, because they are out of a tile's view or beyond its light's range.
    pub casters_culled: usize,
    /// Bytes stored to the map, and to the static one; nothing is loaded.
    pub stored_bytes: Figure,
    /// Bytes that copies read of the latter.
    pub copied_bytes: Figure,
}

/// A figure of bytes; they are far fewer than the 2^53 up to which an f64 counts.
pub(crate) fn planned_bytes(bytes: u64) -> Figure {
    Figure { value: bytes as f64, origin: Origin::Planned }
}

impl ShadowFilter {
    /// How often a pixel samples the map for one light.
    pub const fn samples(self) -> u32 {
        match self {
            Self::Hardware => 1,
            Self::Grid3 => 9,
            Self::Grid5 => 25,
            Self::Jittered => 12,
        }
    }
}

impl ShadowMap {
    /// The ledger's part on the map.
    pub(super) fn report(&self, filter: ShadowFilter) -> ShadowMapReport {
        let stored = |tiles: std::ops::Range<usize>| planned_bytes(tiles.map(|t| self.tile_bytes(t)).sum());
        let lights = self.lights.iter().map(|light| ShadowLightReport {
            name: light.name.clone(),
            shape: light.shape,
            tiles: light.tiles.len(),
            texels: light.size.texels,
            stored_bytes: stored(light.tiles.clone()),
        });
        ShadowMapReport {
            format: self.format,
            size: self.size,
            has_static_map: self.has_static_map,
            bytes: planned_bytes(self.bytes()),
            stored_bytes: stored(0..self.tiles.len()),
            sampled_texels: Figure::planned(filter.samples() * 4),
            lights: lights.collect(),
            casters: self.casters.iter().map(ToString::to_string).collect(),
        }
    }
}

//! What a view sees: geometry on the CPU, for whoever decides what is worth drawing. Knows the scene alone.

mod cascades;
mod clusters;
mod decal_levels;
mod frustum;
mod illumination;
mod order;
mod reach;
mod shadow_views;
mod sight;
mod silhouette;
mod texel_area;

#[cfg(test)]
mod tests;

pub use cascades::{Cascades, MOST_CASCADES, Sphere};
pub use clusters::{Clusters, Grid};
pub use decal_levels::DecalLevels;
pub use frustum::Frustum;
pub use order::{Distances, DrawOrder, sort_key, sorted_index};
pub use reach::Reach;
pub use shadow_views::{ShadowShape, ShadowView, ShadowVolume, TileSize};
pub use sight::Sight;
pub use silhouette::CasterMesh;
pub use texel_area::TexelArea;

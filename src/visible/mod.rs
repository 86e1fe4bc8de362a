//! What a view sees: geometry on the CPU, for whoever decides what is worth drawing. Knows the scene alone.

mod cascades;
mod clusters;
mod frustum;
mod reach;
mod shadow_views;

#[cfg(test)]
mod tests;

pub use cascades::{Cascades, MOST_CASCADES, Sphere};
pub use clusters::{Clusters, Grid};
pub use frustum::Frustum;
pub use reach::Reach;
pub use shadow_views::{ShadowShape, ShadowView, TileSize};

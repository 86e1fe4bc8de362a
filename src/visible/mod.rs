//! What a view sees: geometry on the CPU, for whoever decides what is worth drawing. Knows the scene alone.

mod cascades;
mod frustum;
mod reach;
mod shadow_views;

#[cfg(test)]
mod tests;

pub use cascades::{Cascades, MOST_CASCADES, Sphere};
pub use frustum::Frustum;
pub use reach::Reach;
pub use shadow_views::{ShadowShape, ShadowView, TileSize};

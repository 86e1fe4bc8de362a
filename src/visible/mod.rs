//! What a view sees: geometry on the CPU, for whoever decides what is worth drawing. Knows the scene alone.

mod clusters;
mod frustum;
mod order;
mod reach;
mod sight;

#[cfg(test)]
mod tests;

pub use clusters::{Clusters, Grid};
pub use frustum::Frustum;
pub use order::{Distances, DrawOrder, sort_key, sorted_index};
pub use reach::Reach;
pub use sight::Sight;

//! What a view sees: geometry on the CPU, for whoever decides what is worth drawing. Knows the scene alone.

mod clusters;
mod frustum;
mod illumination;
mod reach;

#[cfg(test)]
mod tests;

pub use clusters::{Clusters, Grid};
pub use frustum::Frustum;
pub use reach::Reach;

//! What a view sees: geometry on the CPU, for whoever decides what is worth drawing. Knows the scene alone.

mod frustum;
mod reach;

#[cfg(test)]
mod tests;

pub use frustum::Frustum;
pub use reach::Reach;

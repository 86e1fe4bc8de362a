//! No more exists than the scene needs.

mod common;

#[path = "minimal/created.rs"]
mod created;
#[path = "minimal/features.rs"]
mod features;
#[path = "minimal/used.rs"]
mod used;

//! No more exists than the scene needs.

mod common;

#[path = "minimal/created.rs"]
mod created;

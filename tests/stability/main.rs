//! Where methods fail: every sweep of `ontile stability` at a small size, each within its bounds.

#[path = "../common/mod.rs"]
mod common;

mod sweeps;

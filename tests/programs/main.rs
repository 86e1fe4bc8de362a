//! The programs of `tools/` that are written in Rust: they make scenes, and measure. Their own unit tests run here too.

#[path = "../../tools/bench_frames/main.rs"]
#[allow(dead_code, reason = "its main function and what measures for long")]
mod bench;

mod comparison;
mod flight;
mod scenes;

//! Several samples a pixel: the same picture however it is arranged, edges that are as smooth as they should be, and refusals.

#[path = "../common/mod.rs"]
mod common;

mod arrangements;
mod edges;
mod refusals;
mod translucent;
mod truth;

//! Scenes out of glTF files: one test for each thing that a file can say.

mod decals;
mod defaults;
mod environments;
mod extensions;
#[path = "../common/gltf_build.rs"]
#[allow(dead_code, reason = "each test file uses some of this")]
mod gltf_build;
mod lights;
mod materials;
mod meshes;
mod meshopt;
mod motion;
mod nodes;
mod particles;
mod samples;
mod surroundings;

/// Sums and products of a few f32 of about 1.
const F32_ROUNDING: f32 = 1e-5;

fn close(a: ontile::glam::Vec3, b: [f32; 3]) -> bool {
    a.abs_diff_eq(b.into(), F32_ROUNDING)
}

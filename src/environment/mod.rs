//! Light from an environment, prepared for shading.

mod cube;
mod irradiance;
mod panorama;
mod specular;

pub use cube::{Cube, FACES, Pyramid, center, direction, place, solid_angle};
pub use irradiance::{evaluate, project};
pub use panorama::{MAX_WIDTH, MIN_WIDTH, Panorama, direction_from_uv, uv_from_direction};
pub use specular::*;
#[cfg(test)]
mod experiment;

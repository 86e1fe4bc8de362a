//! Light from far away: panoramas of radiance, and what shading takes from them.
//!
//! ```text
//! Panorama (.hdr, .exr) --Prefiltered::new--> Prefiltered <--write, read--> .ktx2
//!                                                |  `--> textures of the GPU
//!                                                `-----> Lookup: the same look-ups on the CPU
//! ```
//!
//! A surface needs two things of its environment. What a diffuse one reflects, irradiance, varies so slowly that nine
//! spherical harmonics hold it ([`Prefiltered::irradiance`]). What a glossy one reflects is radiance blurred by a lobe
//! that depends on roughness: a cube map, one level per roughness (`specular`, the first factor of Karis' split sum).
//! The second factor, the lobe's own albedo, depends on no environment: a table ([`split_sum`]).
//!
//! Everything here is pure and the same whatever the number of threads; [`cached`] alone looks at the disk.

mod cache;
mod cube;
mod file;
mod header;
mod irradiance;
mod panorama;
mod prefiltered;
mod specular;
pub mod split_sum;
mod texel;

pub use cache::{Cache, cached};
pub use file::{Content, read};
pub use irradiance::{basis, evaluate};
pub use panorama::{MAX_RADIANCE_NT, MAX_WIDTH, MIN_WIDTH, Panorama, direction_from_uv, uv_from_direction};
pub use prefiltered::{DEFAULT_FACE_SIZE, FACE_SIZES, Lookup, Prefiltered};
pub use specular::{level_count, level_from_roughness, roughness_from_level};
pub use texel::TexelFormat;

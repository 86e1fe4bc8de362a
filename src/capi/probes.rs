//! What surroundings look like from inside rooms.

use std::ffi::c_char;
use std::path::Path;

use glam::{Quat, Vec3};

use super::call::{OntileResult, call, get_mut, list, text};
use super::world::OntileWorld;
use crate::scene::{Environment, Probe};

/// A box, and what glossy surfaces inside it reflect: the radiance that was captured at its centre.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileProbe {
    /// For messages.
    pub name: *const c_char,
    /// The box's centre, metres.
    pub position: [f32; 3],
    /// A quaternion (x, y, z, w) of unit length: turns the box's axes, which are also those of the picture, into the world's.
    pub rotation: [f32; 4],
    /// Half the box's size along its axes, metres, above 0.
    pub half_size: [f32; 3],
    /// How far inside each face the probe's weight reaches 1, metres, at least 0.
    pub falloff: f32,
    /// A picture of all directions (.hdr; twice as wide as high).
    pub path: *const c_char,
}

/// Puts others in the place of all probes of a world. Each pixel looks at all of them, so they should be few. The device has the feature
/// imageCubeArray.
///
/// # Safety
/// `world` is valid; there are `count` probes, whose texts end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_probes(
    world: *mut OntileWorld,
    probes: *const OntileProbe,
    count: usize,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (world, probes) = unsafe { (get_mut(world, "world")?, list(probes, count, "probes")?) };
        let mut all = Vec::with_capacity(probes.len());
        for probe in probes {
            // SAFETY: the caller's promise.
            let (name, path) = unsafe { (text(probe.name, "name")?, text(probe.path, "path")?) };
            all.push(Probe {
                name: name.into(),
                position_world: Vec3::from_array(probe.position),
                world_from_probe: Quat::from_array(probe.rotation),
                half_size_m: Vec3::from_array(probe.half_size),
                falloff_m: probe.falloff,
                environment: Environment::load(Path::new(path))?,
            });
        }
        Ok(world.world.set_probes(all)?)
    })
}

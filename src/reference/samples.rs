//! Several samples a pixel, each a ray of its own: what multisampling is measured against.

use glam::{DVec2, DVec3};

use super::{Pixel, Settings, Tracer};
use crate::scene::{Camera, Scene};

/// Places of `side * side` samples in a pixel, relative to its centre, pixels: the middles of as many equal squares.
pub fn grid(side: u32) -> Vec<DVec2> {
    let part = |index| DVec2::new(f64::from(index % side), f64::from(index / side));
    (0..side * side).map(|index| (part(index) + 0.5) / f64::from(side) - 0.5).collect()
}

/// Where devices with `standardSampleLocations` have four (Vulkan specification, "Multisampling"), relative to the centre, pixels.
pub const STANDARD_4: [DVec2; 4] = [
    DVec2::new(-0.125, -0.375),
    DVec2::new(0.375, -0.125),
    DVec2::new(-0.375, 0.125),
    DVec2::new(0.125, 0.375),
];

/// The mean of what samples at these places of each pixel show, rows from the top. Every one is looked at, shaded and given to the
/// curve by itself; `shown` says what counts of it, e.g. [`Pixel::display`].
///
/// # Panics
/// As [`super::render`].
pub fn supersampled(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    places: &[DVec2],
    shown: impl Fn(&Pixel) -> DVec3,
) -> Vec<DVec3> {
    let tracer = Tracer::new(scene, settings);
    let [width, height] = settings.size;
    let mut sums = vec![DVec3::ZERO; (width * height) as usize];
    for place in places {
        let shift_px = settings.shift_px + *place;
        let frame = tracer.render(camera, &Settings { shift_px, ..settings.clone() });
        sums.iter_mut().zip(&frame.pixels).for_each(|(sum, pixel)| *sum += shown(pixel));
    }
    sums.into_iter().map(|sum| sum / places.len() as f64).collect()
}

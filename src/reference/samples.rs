//! Several samples a pixel, each a ray of its own: what multisampling is measured against.

use glam::DVec2;

use super::{Pixel, Settings, Tracer};
use crate::scene::{Camera, Scene};
use glam::DVec3;

/// The mean display light of `side * side` samples of each pixel, rows from the top. They lie evenly: where lines cross that divide the
/// pixel into so many equal parts each way, in the middle of each part. Every sample is looked at, shaded and given to the curve by
/// itself; `resolved` says what is left of its display light, e.g. what an output holds.
///
/// # Panics
/// As [`super::render`].
pub fn supersampled(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    side: u32,
    resolved: impl Fn(&Pixel) -> DVec3,
) -> Vec<DVec3> {
    let tracer = Tracer::new(scene, settings);
    let [width, height] = settings.size;
    let mut sums = vec![DVec3::ZERO; (width * height) as usize];
    for index in 0..side * side {
        let part = DVec2::new(f64::from(index % side), f64::from(index / side));
        let shift_px = settings.shift_px + (part + 0.5) / f64::from(side) - 0.5;
        let frame = tracer.render(camera, &Settings { shift_px, ..settings.clone() });
        sums.iter_mut().zip(&frame.pixels).for_each(|(sum, pixel)| *sum += resolved(pixel));
    }
    let samples = f64::from(side * side);
    sums.into_iter().map(|sum| sum / samples).collect()
}

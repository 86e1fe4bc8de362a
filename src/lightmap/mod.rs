//! Baking: static diffuse light into a [`Lightmap`], with the reference's path tracer.
//!
//! ```text
//! file -> unwrap (charts, or its own TEXCOORD_1) -> lay out (a rectangle for each node) -> bake -> file with lightmap
//! ```
//!
//! [`prepare`] does the first steps and gives a scene whose instances know their part of the map; [`bake`] computes the light;
//! [`Prepared::write`] puts the map into a copy of the file. What counts as static, and what the picture then adds, is
//! said at [`Light::baked`](crate::scene::Light::baked) and [`Scene::lightmap`].

mod charts;
mod overlap;
mod pack;
mod prepare;
mod texels;
mod unwrap;

pub use prepare::{Density, Prepared, prepare};

use glam::DVec3;
use rayon::prelude::*;

use crate::reference::path::{Paths, Random, quasi_random};
use crate::scene::{Light, Lightmap, Scene};
use crate::{Error, Result};
use texels::{Texel, Texels};

/// How light is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width and height of the map in texels.
    pub size: [u32; 2],
    /// Paths a texel; noise goes with one over its square root.
    pub samples: u32,
    /// How often light is reflected on its way to the surface.
    pub bounces: u32,
}

/// What a texel received.
#[derive(Clone, Copy, Debug)]
struct Received {
    irradiance_lx: DVec3,
    /// Most of its paths began inside something.
    is_enclosed: bool,
}

/// Computes the light that static lights, emissive and unlit surfaces and the surroundings bring to every surface that has a
/// part of the map. `progress` is called after every row of texels, from several threads. The result depends on the
/// arguments alone, not on the number of threads.
///
/// Every texel is the mean over what the map's coordinates put into it; where they put nothing, of the nearest point that a
/// bilinear filter mixes it with. Texels that lie inside something else take their neighbours' light.
///
/// # Errors
/// [`Error::Unsupported`] if nothing in the scene sends light that is static.
///
/// # Panics
/// If an instance with a part of the map has a mesh without TEXCOORD_1.
pub fn bake(scene: &Scene, settings: &Settings, progress: impl Fn() + Sync) -> Result<Lightmap> {
    let [width, height] = settings.size;
    let paths = Paths::new(scene, static_lights(scene), settings.bounces);
    if paths.are_dark() {
        return Err(Error::unsupported(
            format!(
                "scene '{}' has no light to bake: no static lights, nothing that glows, and none around",
                scene.name
            ),
            "add lights or an emissive surface, or ask for ambient light or an environment",
        ));
    }
    let texels = Texels::new(scene, settings.size);
    let rows = (0..height).into_par_iter().map(|y| {
        let row: Vec<_> = (0..width)
            .map(|x| {
                let texel = texels.at(x, y);
                (!texel.is_empty()).then(|| receive(&paths, &texel, u64::from(y * width + x), settings))
            })
            .collect();
        progress();
        row
    });
    let mut received: Vec<Option<Received>> = rows.flatten_iter().collect();
    fill_enclosed(&texels, &mut received, settings.size);
    let irradiances: Vec<_> =
        received.into_iter().map(|r| r.map_or(DVec3::ZERO, |r| r.irradiance_lx)).collect();
    Ok(Lightmap::encode(width, height, &irradiances))
}

/// The lights that a lightmap holds: those that shine and do not move.
pub fn static_lights(scene: &Scene) -> Vec<&Light> {
    scene.lights.iter().filter(|light| light.shines() && !light.dynamic).collect()
}

fn receive(paths: &Paths, texel: &Texel, seed: u64, settings: &Settings) -> Received {
    let mut random = Random::new(seed);
    let starts = [[random.next(), random.next()], [random.next(), random.next()]];
    let (mut sum, mut enclosed) = (DVec3::ZERO, 0);
    for i in 0..settings.samples {
        let (triangle, barycentric) = texel.place(quasi_random(i, starts[0]));
        let receiver = paths.receiver_on(triangle, barycentric);
        let sample = paths.sample(&receiver, quasi_random(i, starts[1]), &mut random);
        sum += sample.irradiance;
        enclosed += u32::from(sample.is_enclosed);
    }
    let samples = settings.samples.max(1);
    Received { irradiance_lx: sum / f64::from(samples), is_enclosed: enclosed * 2 > samples }
}

/// Gives texels inside something the mean of their neighbours on the same chart, from the border inwards as far as a
/// filter can reach.
fn fill_enclosed(texels: &Texels, received: &mut [Option<Received>], [width, height]: [u32; 2]) {
    const REACH: usize = 2;
    for _ in 0..REACH {
        let before = received.to_vec();
        for (index, texel) in received.iter_mut().enumerate() {
            let Some(texel) = texel.as_mut().filter(|t| t.is_enclosed) else { continue };
            let (x, y) = (index as u32 % width, index as u32 / width);
            let chart = texels.at(x, y).chart();
            let (columns, rows) = (x.saturating_sub(1)..=x + 1, y.saturating_sub(1)..=y + 1);
            let around = rows.flat_map(|j| columns.clone().map(move |i| (i, j)));
            let (mut sum, mut count) = (DVec3::ZERO, 0.0);
            for (i, j) in around.filter(|&(i, j)| i < width && j < height) {
                let Some(other) = before[(j * width + i) as usize].filter(|t| !t.is_enclosed) else {
                    continue;
                };
                if texels.at(i, j).chart() == chart {
                    sum += other.irradiance_lx;
                    count += 1.0;
                }
            }
            if count > 0.0 {
                *texel = Received { irradiance_lx: sum / count, is_enclosed: false };
            }
        }
    }
}

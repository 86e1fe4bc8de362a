//! An environment as shading looks it up.

use std::fmt;
use std::ops::RangeInclusive;

use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::cube::{Cube, FACES, center, direction};
use super::irradiance;
use super::panorama::Panorama;
use super::specular::{Tree, level_count, level_from_roughness, roughness_from_level};
use super::texel::TexelFormat;

/// Texels along the edge of a face that can be asked for: powers of two in this range.
pub const FACE_SIZES: RangeInclusive<u32> = 16..=1024;

/// Enough for a mirror to show a panorama of 1024 columns.
pub const DEFAULT_FACE_SIZE: u32 = 256;

/// Radiance by roughness, and irradiance: all that shading needs of an environment.
#[derive(Clone, PartialEq)]
pub struct Prefiltered {
    pub(super) format: TexelFormat,
    pub(super) face_size: u32,
    pub(super) scale: f32,
    pub(super) levels: Vec<Vec<u8>>,
    pub(super) irradiance: [Vec3; 9],
}

impl Prefiltered {
    /// Filters a panorama.
    ///
    /// # Panics
    /// If `face_size` is none of [`FACE_SIZES`].
    pub fn new(panorama: &Panorama, face_size: u32, format: TexelFormat) -> Self {
        assert!(is_face_size(face_size), "{face_size} is no power of two in {FACE_SIZES:?}");
        let levels = filter(panorama, face_size);
        let brightest = levels.iter().flatten().map(|texel| texel.max_element()).fold(0.0, f32::max);
        let scale = scale(brightest, format);
        let encode = |texels: &Vec<Vec3>| {
            let mut bytes = Vec::with_capacity(texels.len() * format.bytes());
            for texel in texels {
                // Division may round up.
                format.encode((*texel / scale).min(Vec3::splat(format.max())), &mut bytes);
            }
            bytes
        };
        let levels = levels.par_iter().map(encode).collect();
        Self { format, face_size, scale, levels, irradiance: irradiance::project(panorama) }
    }

    /// The largest value of a channel of the sharpest level, in cd/m².
    pub fn brightest_nt(&self) -> f32 {
        let decode = |texel| self.format.decode(self.format.load(texel)).max_element() * self.scale;
        self.levels[0].chunks_exact(self.format.bytes()).map(decode).fold(0.0, f32::max)
    }

    /// How texels are stored.
    pub fn format(&self) -> TexelFormat {
        self.format
    }

    /// Texels along the edge of the largest level's faces.
    pub fn face_size(&self) -> u32 {
        self.face_size
    }

    /// What stored values are multiplied by to give cd/m².
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// The levels from the largest, each half as large as the one before; texels by face (in Vulkan's order: +X, -X, +Y,
    /// -Y, +Z, -Z), row and column.
    pub fn levels(&self) -> &[Vec<u8>] {
        &self.levels
    }

    /// Irradiance over pi in cd/m², coefficients of [`super::basis`].
    pub fn irradiance(&self) -> &[Vec3; 9] {
        &self.irradiance
    }

    /// The bytes of all texels.
    pub fn bytes(&self) -> u64 {
        self.levels.iter().map(|level| level.len() as u64).sum()
    }
}

/// Without texels, which would fill books.
impl fmt::Debug for Prefiltered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { format, face_size, scale, irradiance, .. } = self;
        let mut parts = f.debug_struct("Prefiltered");
        parts.field("format", format).field("face_size", face_size).field("scale", scale);
        parts.field("irradiance", irradiance).finish_non_exhaustive()
    }
}

pub(super) fn is_face_size(size: u32) -> bool {
    size.is_power_of_two() && FACE_SIZES.contains(&size)
}

/// All levels, in floats.
fn filter(panorama: &Panorama, face_size: u32) -> Vec<Vec<Vec3>> {
    let sharp = resample(panorama, face_size);
    let tree = Tree::new(face_size, &sharp);
    let count = level_count(face_size);
    let blurred = (1..count).map(|i| tree.filter(face_size >> i, roughness_from_level(i, count)));
    let blurred: Vec<_> = blurred.collect();
    std::iter::once(sharp).chain(blurred).collect()
}

/// The panorama as a cube: each texel the mean of samples no further apart than the panorama's texels at its equator.
fn resample(panorama: &Panorama, face_size: u32) -> Vec<Vec3> {
    let size = face_size as usize;
    let steps = panorama.width().div_ceil(4 * face_size).max(2) as usize;
    let texel = |index: usize| {
        let (face, y, x) = (index / (size * size), index / size % size, index % size);
        let place = |i: usize, j: usize| {
            direction(face, center(x * steps + i, size * steps), center(y * steps + j, size * steps))
        };
        let radiance = |k: usize| panorama.radiance(place(k % steps, k / steps));
        let sum: DVec3 = (0..steps * steps).map(radiance).sum();
        (sum / (steps * steps) as f64).as_vec3()
    };
    (0..FACES * size * size).into_par_iter().map(texel).collect()
}

/// Brings the brightest value just into the format's range. Suns exceed it (109,568 cd/m² in a sample panorama), and
/// what is far below it has few bits. Floats keep theirs if the scale is a power of two.
fn scale(brightest: f32, format: TexelFormat) -> f32 {
    let least = brightest / format.max();
    if !least.is_normal() {
        return 1.0;
    }
    match format {
        TexelFormat::Rgbm => least,
        _ => least.log2().ceil().exp2(),
    }
}

/// Look-ups as the GPU makes them, in f32 texels and f64 weights.
#[derive(Clone, Debug)]
pub struct Lookup {
    format: TexelFormat,
    scale: f64,
    levels: Vec<Cube>,
    irradiance: [Vec3; 9],
}

impl Lookup {
    /// Of all levels.
    pub fn new(prefiltered: &Prefiltered) -> Self {
        let format = prefiltered.format;
        let cube = |(level, bytes): (usize, &Vec<u8>)| {
            let texels: Vec<Vec4> =
                bytes.chunks_exact(format.bytes()).map(|texel| format.load(texel)).collect();
            Cube::new(prefiltered.face_size as usize >> level, &texels)
        };
        Self {
            format,
            scale: f64::from(prefiltered.scale),
            levels: prefiltered.levels.iter().enumerate().map(cube).collect(),
            irradiance: prefiltered.irradiance,
        }
    }

    /// Radiance around a direction in the environment's own space, blurred for this roughness, cd/m². Texels are blended
    /// as stored, between texel centres and between levels, then decoded.
    pub fn radiance(&self, direction: DVec3, roughness: f64) -> DVec3 {
        let level = level_from_roughness(roughness.clamp(0.0, 1.0), self.levels.len() as u32);
        let (first, between) = (level as usize, level.fract() as f32);
        let near = self.levels[first].sample(direction);
        let filtered = match self.levels.get(first + 1) {
            Some(next) => near.lerp(next.sample(direction), between),
            None => near,
        };
        self.format.decode(filtered).as_dvec3() * self.scale
    }

    /// Irradiance over pi for a normal of unit length in the environment's own space, cd/m².
    pub fn irradiance(&self, normal: DVec3) -> DVec3 {
        irradiance::evaluate(&self.irradiance, normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::direction_from_uv;
    use std::path::{Path, PathBuf};

    /// A gentle sky over a dark floor, with a sun of a texel or two.
    fn sky(width: u32, sun: f32) -> Panorama {
        let texel = |i: u32| {
            let (u, v) = (f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
            let d = direction_from_uv([u / f64::from(width), v / f64::from(width / 2)]);
            let base = if d.y > 0.0 { Vec3::new(0.4, 0.6, 1.0) } else { Vec3::new(0.1, 0.08, 0.06) };
            let towards_sun = d.dot(DVec3::new(0.5, 0.6, 0.62).normalize());
            base * (1.2 + d.x as f32) + if towards_sun > 0.999 { Vec3::splat(sun) } else { Vec3::ZERO }
        };
        Panorama::new(width, width / 2, (0..width * width / 2).map(texel).collect()).unwrap()
    }

    /// Irradiance over pi by the sum over all texels.
    fn diffuse(panorama: &Panorama, normal: DVec3) -> DVec3 {
        let (w, h) = (f64::from(panorama.width()), f64::from(panorama.height()));
        let term = |(i, texel): (usize, &Vec3)| {
            let (x, y) = ((i as u32 % panorama.width()) as f64, (i as u32 / panorama.width()) as f64);
            let d = direction_from_uv([(x + 0.5) / w, (y + 0.5) / h]);
            let edge = |y: f64| (std::f64::consts::PI * y / h).cos();
            texel.as_dvec3() * (normal.dot(d).max(0.0) * (edge(y) - edge(y + 1.0)) * 2.0 / w)
        };
        panorama.texels().iter().enumerate().map(term).sum()
    }

    fn directions() -> Vec<DVec3> {
        (0..200)
            .map(|i| direction_from_uv([f64::from(i) * 0.618 % 1.0, (f64::from(i) + 0.5) / 200.0]))
            .collect()
    }

    #[test]
    fn nine_harmonics_hold_irradiance_as_well_as_their_paper_says() {
        // Ramamoorthi and Hanrahan, section 3.2: 1 % on average over all environments, at most 9 % of the peak for one
        // light in one direction; its ringing is what the clamp at zero cuts.
        for (sun, mean_bound, worst_bound) in [(0.0, 0.01, 0.04), (3000.0, 0.03, 0.09)] {
            let panorama = sky(128, sun);
            let lookup = Lookup::new(&Prefiltered::new(&panorama, 16, TexelFormat::Rgba16F));
            let truths: Vec<_> = directions().iter().map(|n| diffuse(&panorama, *n)).collect();
            let peak = truths.iter().map(|t| t.max_element()).fold(0.0, f64::max);
            let errors: Vec<_> = directions()
                .iter()
                .zip(&truths)
                .map(|(n, t)| (lookup.irradiance(*n) - t).abs().max_element() / peak)
                .collect();
            let worst = errors.iter().fold(0.0, |a, b| f64::max(a, *b));
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            println!("harmonics, sun {sun}: mean {mean:.4}, worst {worst:.4} of the peak");
            assert!(mean < mean_bound && worst < worst_bound, "sun {sun}: {mean} {worst}");
            assert!(directions().iter().all(|n| lookup.irradiance(*n).min_element() >= 0.0));
        }
    }

    /// What each format costs against floats: relative errors of look-ups at all roughnesses, and what the largest error would
    /// be seen as.
    #[test]
    fn formats_cost_what_they_are_said_to() {
        // Mean relative error of a look-up, and the error that one in a hundred exceeds.
        let bounds = [
            (TexelFormat::Rgbm, 0.2, 1.0),
            (TexelFormat::B10G11R11, 0.006, 0.02),
            (TexelFormat::E5B9G9R9, 0.001, 0.006),
            (TexelFormat::Rgba16F, 3e-4, 1e-3),
        ];
        const SIZE: u32 = 64;
        let mut panoramas = vec![("sky and sun".to_owned(), sky(128, 3000.0))];
        let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
        let folder = std::env::var_os("ONTILE_SHARED").map_or(shared, PathBuf::from).join("assets/hdri");
        for file in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let panorama = Panorama::read(&file.path()).unwrap();
            panoramas.push((file.file_name().to_string_lossy().into_owned(), panorama));
        }
        if panoramas.len() == 1 {
            println!("ignored: sample panoramas: {} absent", folder.display());
        }
        println!(
            "{:<40} {:<10} {:>8} {:>9} {:>9} {:>9} {:>6}",
            "relative error", "", "bytes", "mean", "99 %", "most", "dB"
        );
        for (name, panorama) in &panoramas {
            let levels = filter(panorama, SIZE);
            let cube = |level: &Vec<Vec3>| {
                let texels: Vec<_> = level.iter().map(|t| t.extend(1.0)).collect();
                Cube::new((level.len() / FACES).isqrt(), &texels)
            };
            let floats = Lookup {
                format: TexelFormat::Rgba16F,
                scale: 1.0,
                levels: levels.iter().map(cube).collect(),
                irradiance: [Vec3::ZERO; 9],
            };
            for (format, mean_bound, most_bound) in bounds {
                let prefiltered = Prefiltered::new(panorama, SIZE, format);
                let lookup = Lookup::new(&prefiltered);
                let mut errors = Vec::new();
                let (mut noise, mut signal) = (0.0, 0.0);
                for (i, d) in (0..50).flat_map(|_| directions()).enumerate() {
                    let d = (d + DVec3::splat(0.013 * (i / 200) as f64)).normalize();
                    let roughness = (i as f64 * 0.7548) % 1.0;
                    let (truth, found) = (floats.radiance(d, roughness), lookup.radiance(d, roughness));
                    errors.push((found - truth).abs().max_element() / truth.max_element().max(1e-9));
                    noise += (found - truth).length_squared();
                    signal += truth.length_squared();
                }
                errors.sort_by(f64::total_cmp);
                let mean = errors.iter().sum::<f64>() / errors.len() as f64;
                let part = |part: f64| errors[(part * (errors.len() - 1) as f64) as usize];
                println!(
                    "{name:<40} {format:<10} {:>8} {mean:>9.5} {:>9.5} {:>9.5} {:>6.1}",
                    prefiltered.bytes(),
                    part(0.99),
                    part(1.0),
                    10.0 * f64::log10(signal / noise)
                );
                assert!(
                    mean < mean_bound && part(0.99) < most_bound,
                    "{name}, {format}: {mean} {}",
                    part(0.99)
                );
            }
        }
    }

    #[test]
    fn uniform_light_comes_back_in_every_format() {
        let white = Panorama::new(16, 8, vec![Vec3::ONE; 128]).unwrap();
        for &format in TexelFormat::ALL {
            let lookup = Lookup::new(&Prefiltered::new(&white, 32, format));
            for d in directions() {
                assert!((lookup.irradiance(d) - 1.0).abs().max_element() < 1e-6, "{format}");
                for roughness in [0.0, 0.3, 1.0] {
                    // Powers of two are stored as they are; RGBM has steps of 1/255, twice, squared.
                    let bound = if format == TexelFormat::Rgbm { 4.0 / 255.0 } else { 1e-9 };
                    let radiance = lookup.radiance(d, roughness);
                    assert!((radiance - 1.0).abs().max_element() < bound, "{format} {roughness}: {radiance}");
                }
            }
        }
    }

    #[test]
    fn a_rough_look_up_is_the_mean_that_it_stands_for() {
        // Of the lobe's own integral over all texels, at the roughness of each level.
        const RELATIVE: f64 = 0.03;
        let panorama = sky(128, 3000.0);
        let prefiltered = Prefiltered::new(&panorama, 64, TexelFormat::Rgba16F);
        let lookup = Lookup::new(&prefiltered);
        let levels = level_count(64);
        for level in 1..levels {
            let roughness = roughness_from_level(level, levels);
            let alpha2 = roughness.powi(4);
            let size = 64 >> level as usize;
            for index in (0..FACES * size * size).step_by(size * size / 8 + 1) {
                let (face, y, x) = (index / (size * size), index / size % size, index % size);
                let axis = direction(face, center(x, size), center(y, size)).normalize();
                let mut sums = (DVec3::ZERO, 0.0);
                for i in 0..512 * 256 {
                    let (u, v) = ((f64::from(i % 512) + 0.5) / 512.0, (f64::from(i / 512) + 0.5) / 256.0);
                    let l = direction_from_uv([u, v]);
                    let n_dot_l = axis.dot(l);
                    if n_dot_l > 0.0 {
                        let f = alpha2 + (1.0 - alpha2) * (1.0 - n_dot_l) / 2.0;
                        let weight = n_dot_l / (f * f) * (std::f64::consts::PI * v).sin();
                        sums = (sums.0 + panorama.radiance(l) * weight, sums.1 + weight);
                    }
                }
                let (found, truth) = (lookup.radiance(axis, roughness), sums.0 / sums.1);
                let error = (found - truth).length() / truth.length();
                assert!(error < RELATIVE, "level {level}, texel {index}: {found} {truth}");
            }
        }
    }
}

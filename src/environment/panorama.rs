//! Equirectangular pictures of radiance.

use std::f64::consts::{PI, TAU};
use std::fmt;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use glam::{DVec3, Vec3};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use super::header::{self, RADIANCE};
use crate::{Error, Result};

/// Columns of the largest panorama that is read: 33 million texels. More neither a prefiltered cube nor a background shows.
pub const MAX_WIDTH: u32 = 8192;

/// Columns of the smallest.
pub const MIN_WIDTH: u32 = 4;

/// The largest radiance that is supported, in cd/m²: some hundred times the sun's. Sums of it, and exposures of up to 64 stops,
/// stay far from the end of f32.
pub const MAX_RADIANCE_NT: f32 = 1e12;

/// A file is not believed to be larger.
const MAX_FILE_BYTES: u64 = 1 << 30;

const MAKE_IT_HDR: &str = "give a Radiance (.hdr) or OpenEXR (.exr) picture of linear radiance";

/// Radiance from all directions, as an equirectangular picture of linear Rec.709 in cd/m², twice as wide as high.
///
/// Rows go from straight up (+Y) to straight down, in equal steps of the angle. Seen from inside, columns go clockwise
/// around +Y: the left edge lies towards -Z, a quarter of the width towards +X, the centre towards +Z and three quarters
/// towards -X, as in Filament and Mitsuba. Texels are point samples at their centres; between them radiance is
/// interpolated bilinearly, around the seam and up to the first and last row, whose texels hold for the rest.
#[derive(Clone, PartialEq)]
pub struct Panorama {
    width: u32,
    height: u32,
    texels: Vec<Vec3>,
}

impl Panorama {
    /// From rows of texels, top row first.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the size is not 2:1 or not from 4 x 2 to 8192 x 4096, if there is not one texel for
    /// every place, and for values that are negative, above [`MAX_RADIANCE_NT`] or not numbers.
    pub fn new(width: u32, height: u32, texels: Vec<Vec3>) -> Result<Self> {
        let panorama = Self { width, height, texels };
        match panorama.problem() {
            None => Ok(panorama),
            Some((element, problem, remedy)) => {
                Err(Error::unsupported(format!("the panorama's {element} {problem}"), remedy))
            }
        }
    }

    /// Reads a Radiance file, or an OpenEXR file where the crate's feature `cli` is on; alpha is left out.
    ///
    /// The content decides the format, not the name.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read; [`Error::Input`] if it is no such picture, is damaged, or breaks the
    /// rules of [`Self::new`].
    pub fn read(path: &Path) -> Result<Self> {
        Self::decode(path, read_bytes(path)?)
    }

    /// As [`Self::read`], from the content of the file.
    pub(super) fn decode(path: &Path, bytes: Vec<u8>) -> Result<Self> {
        let bad = |element: &str, problem: String, remedy: &str| Error::input(path, element, problem, remedy);
        if bytes.starts_with(RADIANCE) {
            header::check(&bytes).map_err(|(element, problem, remedy)| bad(&element, problem, remedy))?;
        }
        let mut reader = ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|e| Error::io(path, "read", e))?;
        match reader.format() {
            Some(ImageFormat::Hdr | ImageFormat::OpenExr) => {}
            Some(other) => {
                let problem = format!("is {other:?}, whose channels cannot hold radiance");
                return Err(bad("environment", problem, MAKE_IT_HDR));
            }
            None => {
                let problem = "is no picture that is known here".into();
                return Err(bad("environment", problem, MAKE_IT_HDR));
            }
        }
        let undecodable = |e: ImageError| {
            let (problem, remedy) = header::undecodable(&e);
            Error::input(path, "environment", problem, remedy)
        };
        let mut limits = image::Limits::default();
        // Four floats a texel, and as much again for the decoder's own buffers.
        limits.max_alloc = Some(u64::from(MAX_WIDTH) * u64::from(MAX_WIDTH / 2) * 16 * 2);
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(undecodable)?;
        let (width, height) = decoder.dimensions();
        // Before the texels take memory.
        if let Some((element, problem, remedy)) = size_problem(width.into(), height.into()) {
            return Err(bad(&element, problem, remedy));
        }
        let picture = DynamicImage::from_decoder(decoder).map_err(undecodable)?.into_rgb32f();
        let texels = bytemuck::allocation::cast_vec(picture.into_raw().as_chunks::<3>().0.to_vec());
        let panorama = Self { width, height, texels };
        match panorama.problem() {
            None => Ok(panorama),
            Some((element, problem, remedy)) => Err(bad(&element, problem, remedy)),
        }
    }

    /// The first thing that is wrong: where, what, and what to do.
    fn problem(&self) -> Option<(String, String, &'static str)> {
        let Self { width, height, texels } = self;
        if let Some(problem) = size_problem((*width).into(), (*height).into()) {
            return Some(problem);
        }
        if texels.len() as u64 != u64::from(*width) * u64::from(*height) {
            let problem = format!("has {} texels for {width} x {height} places", texels.len());
            return Some(("list".into(), problem, "give one texel for every place"));
        }
        let fine = |t: &Vec3| t.is_finite() && t.min_element() >= 0.0 && t.max_element() <= MAX_RADIANCE_NT;
        let index = texels.iter().position(|t| !fine(t))?;
        let at = format!("texel {}, {}", index as u32 % width, index as u32 / width);
        let rule = format!("radiance is finite, not negative, and at most {MAX_RADIANCE_NT:e} cd/m²");
        let problem = format!("is {:?}, but {rule}", texels[index].to_array());
        Some((at, problem, "repair the picture, e.g. clamp its channels"))
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows: half as many as columns.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Rows from the top, texels from the left.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// The largest value of a channel, in cd/m².
    pub fn brightest_nt(&self) -> f32 {
        self.texels.iter().map(|texel| texel.max_element()).fold(0.0, f32::max)
    }

    /// The radiance from a direction of unit length in the environment's own space.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let [u, v] = uv_from_direction(direction);
        let (x, y) = (u * f64::from(self.width) - 0.5, v * f64::from(self.height) - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (s, t) = (x - left, y - top);
        let column = |i: i64| i.rem_euclid(i64::from(self.width)) as usize;
        let row = |j: i64| j.clamp(0, i64::from(self.height) - 1) as usize;
        let texel = |i, j| self.texels[row(j) * self.width as usize + column(i)].as_dvec3();
        let (i, j) = (left as i64, top as i64);
        texel(i, j).lerp(texel(i + 1, j), s).lerp(texel(i, j + 1).lerp(texel(i + 1, j + 1), s), t)
    }
}

/// Without texels, which would fill books.
impl fmt::Debug for Panorama {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, height, .. } = self;
        f.debug_struct("Panorama").field("width", width).field("height", height).finish_non_exhaustive()
    }
}

/// The direction of a place in the picture: u from the left, v from the top, both 0 to 1.
pub fn direction_from_uv([u, v]: [f64; 2]) -> DVec3 {
    let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (((u - 0.5) * TAU).sin_cos(), (v * PI).sin_cos());
    DVec3::new(-sin_phi * sin_theta, cos_theta, cos_phi * sin_theta)
}

/// The inverse of [`direction_from_uv`], for unit length.
pub fn uv_from_direction(direction: DVec3) -> [f64; 2] {
    let u = f64::atan2(-direction.x, direction.z) / TAU + 0.5;
    // atan2 keeps its precision at the poles, where acos loses it.
    let v = f64::atan2(direction.x.hypot(direction.z), direction.y) / PI;
    [u, v]
}

/// The content of a regular file that is not absurdly large.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let found = fs::metadata(path).map_err(|e| Error::io(path, "read", e))?;
    // Pipes may never say anything and devices never end.
    if !found.is_file() {
        return Err(Error::input(path, "file", "is not a regular file", MAKE_IT_HDR));
    }
    if found.len() > MAX_FILE_BYTES {
        let problem = format!("has {} bytes, more than {MAX_FILE_BYTES}", found.len());
        return Err(Error::input(path, "file", problem, "scale the picture down"));
    }
    fs::read(path).map_err(|e| Error::io(path, "read", e))
}

/// As [`Panorama::problem`], of sizes as files say them.
pub(super) fn size_problem(width: u64, height: u64) -> Option<(String, String, &'static str)> {
    let problem = |text: String, remedy| Some(("size".to_owned(), text, remedy));
    if width == 0 || height == 0 {
        let text = format!("is {width} x {height} texels: there is no picture");
        return problem(text, "export the picture again");
    }
    if width != height.saturating_mul(2) {
        let text =
            format!("is {width} x {height} texels, but an equirectangular picture is twice as wide as high");
        return problem(text, "give a full panorama in that projection");
    }
    if !(MIN_WIDTH.into()..=MAX_WIDTH.into()).contains(&width) {
        let text =
            format!("is {width} x {height} texels, but {MIN_WIDTH} to {MAX_WIDTH} columns are supported");
        let too_small = width < MIN_WIDTH.into();
        return problem(text, if too_small { "give a larger picture" } else { "scale the picture down" });
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_lies_towards_z_and_the_right_half_towards_minus_x() {
        for (uv, direction) in [
            ([0.5, 0.5], DVec3::Z),
            ([0.75, 0.5], DVec3::NEG_X),
            ([0.25, 0.5], DVec3::X),
            ([0.0, 0.5], DVec3::NEG_Z),
            ([0.5, 0.0], DVec3::Y),
            ([0.5, 1.0], DVec3::NEG_Y),
        ] {
            assert!((direction_from_uv(uv) - direction).length() < 1e-15, "{uv:?}");
        }
        for uv in [[0.1, 0.2], [0.6, 0.9], [0.99, 0.5], [0.3, 1e-9]] {
            let back = uv_from_direction(direction_from_uv(uv));
            assert!((back[0] - uv[0]).abs() < 1e-7 && (back[1] - uv[1]).abs() < 1e-15, "{uv:?} {back:?}");
        }
    }

    #[test]
    fn radiance_is_bilinear_around_the_seam_and_constant_beyond_the_first_row() {
        let texel = |i: u32| Vec3::new((i % 8) as f32, (i / 8) as f32, 1.0);
        let panorama = Panorama::new(8, 4, (0..32).map(texel).collect()).unwrap();
        let at = |x: f64, y: f64| panorama.radiance(direction_from_uv([x / 8.0, y / 4.0]));
        let close = |a: DVec3, b: [f64; 3]| assert!((a - DVec3::from(b)).length() < 1e-9, "{a} {b:?}");
        close(at(2.5, 1.5), [2.0, 1.0, 1.0]);
        close(at(2.75, 2.0), [2.25, 1.5, 1.0]);
        close(at(0.0, 1.5), [3.5, 1.0, 1.0]);
        close(at(4.5, 0.1), [4.0, 0.0, 1.0]);
        close(at(4.5, 3.9), [4.0, 3.0, 1.0]);
    }

    #[test]
    fn what_is_no_radiance_is_refused() {
        let with = |value: f32| {
            let mut texels = vec![Vec3::ONE; 8];
            texels[6].y = value;
            Panorama::new(4, 2, texels).unwrap_err().to_string()
        };
        for value in [f32::NAN, f32::INFINITY, -1e-3] {
            let message = with(value);
            assert!(message.contains("texel 2, 1") && message.contains("not negative"), "{message}");
        }
        for (width, height, count, part) in [
            (4, 4, 16, "twice as wide"),
            (2, 1, 2, "4 to 8192"),
            (16384, 8192, 0, "4 to 8192"),
            (4, 2, 7, "7 texels"),
        ] {
            let message = Panorama::new(width, height, vec![Vec3::ONE; count]).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}

//! Pictures in memory and in files.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ExtendedColorType, ImageFormat, ImageReader};

use crate::scene::PreRotation;
use crate::{Error, Result, file};

/// A picture: rows from top to bottom, pixels from left to right, four channels (red, green, blue, alpha).
///
/// `pixels` holds exactly `4 * width * height` values. Colours are not multiplied by alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// The channels of all pixels, interleaved.
    pub pixels: Pixels,
}

/// The channels of a [`Picture`]; alpha is linear in both.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// 8 bits a channel, colours sRGB-encoded.
    Rgba8(Vec<u8>),
    /// Floats, colours linear Rec.709, not clamped.
    Rgba32F(Vec<f32>),
}

/// The largest picture that most devices can draw: 16384 x 16384 pixels, four 32-bit floats each.
const MAX_DECODED_BYTES: u64 = 1 << 32;

/// The kinds of picture file that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// 8 bits a channel, sRGB.
    Png,
    /// OpenEXR: 32-bit floats, linear.
    Exr,
}

impl FileFormat {
    /// The format that the extension of `path` names, in either case.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it names none of them.
    pub fn from_path(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Error::unsupported(
                format!("{}: the extension names no known picture format", path.display()),
                "use .png (8 bits, sRGB) or .exr (floats, linear)",
            )),
        }
    }
}

impl Picture {
    /// Reads a PNG or JPEG file, or an OpenEXR file where the crate's feature `cli` is on.
    ///
    /// The content decides the format, not the name. Grey and palette become RGBA; a missing alpha is 1.
    /// PNGs of 16 bits become linear floats, so that no precision is lost.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read, [`Error::Input`] if it is no picture of these formats.
    pub fn read(path: &Path) -> Result<Self> {
        // Pipes may never say anything and devices never end.
        if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            return Err(Error::input(path, "file", "is not a regular file", "name a picture file"));
        }
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
        let undecodable = |e: image::ImageError| {
            Error::input(path, "picture", e.to_string(), "give a complete PNG, JPEG or OpenEXR file")
        };
        let mut reader = ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|e| Error::io(path, "read", e))?;
        let mut limits = image::Limits::default();
        limits.max_alloc = Some(MAX_DECODED_BYTES);
        reader.limits(limits);
        let decoded = reader.decode().map_err(undecodable)?;
        let (width, height) = (decoded.width(), decoded.height());
        let pixels = match decoded {
            DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
                Pixels::Rgba32F(decoded.into_rgba32f().into_raw())
            }
            DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_) => {
                let mut channels = decoded.into_rgba32f().into_raw();
                for pixel in channels.as_chunks_mut::<4>().0 {
                    let [r, g, b, a] = *pixel;
                    *pixel = [linear_from_srgb(r), linear_from_srgb(g), linear_from_srgb(b), a];
                }
                Pixels::Rgba32F(channels)
            }
            other => Pixels::Rgba8(other.into_rgba8().into_raw()),
        };
        Ok(Self { width, height, pixels })
    }

    /// Writes 8-bit pictures as PNG and floats as OpenEXR (unclamped, alpha kept, 32 bits a channel).
    ///
    /// The file is complete or not there: see [`file::write_whole`].
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the extension and the pixels do not go together or the pixels do not fill the
    /// picture; [`Error::Io`] if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.stage(path)?.commit()
    }

    /// As [`Self::write`], but the file gets its name later.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn stage(&self, path: &Path) -> Result<file::Staged> {
        self.validate()?;
        let (bytes, color, format): (&[u8], _, _) = match (FileFormat::from_path(path)?, &self.pixels) {
            (FileFormat::Png, Pixels::Rgba8(p)) => (p, ExtendedColorType::Rgba8, ImageFormat::Png),
            (FileFormat::Exr, Pixels::Rgba32F(p)) => {
                (bytemuck::cast_slice(p), ExtendedColorType::Rgba32F, ImageFormat::OpenExr)
            }
            (FileFormat::Png, Pixels::Rgba32F(_)) => {
                return Err(Error::unsupported(
                    format!("{}: PNG holds 8 bits a channel and the picture holds floats", path.display()),
                    "write it as .exr, or convert it to 8 bits first",
                ));
            }
            (FileFormat::Exr, Pixels::Rgba8(_)) => {
                return Err(Error::unsupported(
                    format!(
                        "{}: OpenEXR holds floats and the picture holds 8 bits a channel",
                        path.display()
                    ),
                    "write it as .png, or convert it to linear floats first",
                ));
            }
        };
        let mut encoded = Cursor::new(Vec::new());
        image::write_buffer_with_format(&mut encoded, bytes, self.width, self.height, color, format)
            .map_err(|e| Error::unsupported(format!("{}: {e}", path.display()), "write another format"))?;
        file::stage(path, encoded.get_ref())
    }

    /// The same picture as linear floats.
    pub fn to_linear(&self) -> Self {
        let channels = match &self.pixels {
            Pixels::Rgba32F(p) => p.clone(),
            Pixels::Rgba8(p) => {
                let linear: [f32; 256] = std::array::from_fn(|step| linear_from_srgb(step as f32 / 255.0));
                let to_linear = |&[r, g, b, a]: &[u8; 4]| {
                    [linear[r as usize], linear[g as usize], linear[b as usize], f32::from(a) / 255.0]
                };
                p.as_chunks::<4>().0.iter().flat_map(to_linear).collect()
            }
        };
        Self { pixels: Pixels::Rgba32F(channels), ..*self }
    }

    /// The same picture in 8 bits, sRGB-encoded: clamped to 0..=1 and rounded to the nearest step; not a
    /// number becomes 0.
    pub fn to_srgb8(&self) -> Self {
        let channels = match &self.pixels {
            Pixels::Rgba8(p) => p.clone(),
            Pixels::Rgba32F(p) => {
                // `as u8` saturates, and takes NaN to 0.
                let quantise = |v: f32| (v * 255.0).round() as u8;
                let encode = |v: f32| quantise(srgb_from_linear(v));
                let to_srgb = |&[r, g, b, a]: &[f32; 4]| [encode(r), encode(g), encode(b), quantise(a)];
                p.as_chunks::<4>().0.iter().flat_map(to_srgb).collect()
            }
        };
        Self { pixels: Pixels::Rgba8(channels), ..*self }
    }

    /// The picture that an image shows which was drawn turned.
    #[must_use]
    pub fn upright(&self, pre_rotation: PreRotation) -> Self {
        let pixels = match &self.pixels {
            Pixels::Rgba8(p) => Pixels::Rgba8(upright(p, [self.width, self.height], pre_rotation)),
            Pixels::Rgba32F(p) => Pixels::Rgba32F(upright(p, [self.width, self.height], pre_rotation)),
        };
        let [width, height] = pre_rotation.size([self.width, self.height]);
        Self { width, height, pixels }
    }

    /// Checks that the pixels fill the picture exactly.
    pub(crate) fn validate(&self) -> Result<()> {
        let held = match &self.pixels {
            Pixels::Rgba8(p) => p.len(),
            Pixels::Rgba32F(p) => p.len(),
        };
        if held as u128 != 4 * u128::from(self.width) * u128::from(self.height) {
            return Err(Error::unsupported(
                format!("a picture of {}x{} pixels holds {held} values", self.width, self.height),
                "give four values for every pixel",
            ));
        }
        Ok(())
    }
}

fn upright<C: Copy>(channels: &[C], size: [u32; 2], pre_rotation: PreRotation) -> Vec<C> {
    let [width, height] = size.map(|n| n as usize);
    let [across, down] = pre_rotation.size(size).map(|n| n as usize);
    let mut out = Vec::with_capacity(channels.len());
    for y in 0..down {
        for x in 0..across {
            let (x, y) = match pre_rotation {
                PreRotation::Identity => (x, y),
                PreRotation::Rotate90 => (width - 1 - y, x),
                PreRotation::Rotate180 => (width - 1 - x, height - 1 - y),
                PreRotation::Rotate270 => (y, height - 1 - x),
            };
            out.extend_from_slice(&channels[4 * (y * width + x)..][..4]);
        }
    }
    out
}

/// The sRGB encoding of a linear value (IEC 61966-2-1): 0 to 1 for 0 to 1, and the curve's continuation above.
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_from_linear`].
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests;

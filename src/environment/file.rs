//! Prefiltered environments in files.
//!
//! A file is KTX 2.0: an uncompressed cube map with the levels of [`Prefiltered::levels`], in `VkFormat`
//! R8G8B8A8_UNORM (RGBM), B10G11R11_UFLOAT_PACK32, E5B9G9R9_UFLOAT_PACK32 or R16G16B16A16_SFLOAT. Metadata entries,
//! little-endian, hold the rest:
//!
//! | key | value |
//! |---|---|
//! | `ontileVersion` | u32: [`VERSION`], which changes with the meaning of the texels |
//! | `ontileRadianceScale` | f32: cd/m² of a stored 1 |
//! | `ontileIrradiance` | 27 f32: red, green and blue of the nine coefficients |
//! | `ontileChecksum` | the first 16 bytes of the SHA-256 of both values above and of all levels from the largest |

use std::path::Path;

use glam::Vec3;
use ktx2::dfd::{Basic, Block};
use ktx2::{Format, Header, Index, LevelIndex, Reader};
use sha2::{Digest, Sha256};

use super::cube::FACES;
use super::panorama::{MAX_RADIANCE_NT, Panorama, read_bytes};
use super::prefiltered::{FACE_SIZES, Prefiltered, is_face_size};
use super::specular::level_count;
use super::texel::TexelFormat;
use crate::{Error, Result, file};

/// Of the mapping from roughness to levels, of RGBM, and of the coefficients' order.
pub(super) const VERSION: u32 = 1;

const KEY_VERSION: &str = "ontileVersion";
const KEY_SCALE: &str = "ontileRadianceScale";
const KEY_IRRADIANCE: &str = "ontileIrradiance";
const KEY_CHECKSUM: &str = "ontileChecksum";

const BAKE_AGAIN: &str = "make it again with 'ontile bake environment'";

/// What a file of an environment holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A picture.
    Panorama(Panorama),
    /// What was made of one.
    Prefiltered(Prefiltered),
}

/// Reads either kind of file; its content decides.
///
/// # Errors
/// As [`Panorama::read`]; [`Error::Input`] also for KTX files that [`Prefiltered::write`] has not made.
pub fn read(path: &Path) -> Result<Content> {
    let bytes = read_bytes(path)?;
    if bytes.starts_with(&ktx2::MAGIC) {
        let parsed = Prefiltered::from_ktx2(&bytes);
        return parsed
            .map(Content::Prefiltered)
            .map_err(|problem| Error::input(path, "environment", problem, BAKE_AGAIN));
    }
    Panorama::decode(path, bytes).map(Content::Panorama)
}

impl Prefiltered {
    /// Writes a KTX 2.0 file that [`read`] reads. It is complete or not there.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write(&self, path: &Path) -> Result<()> {
        file::write_whole(path, &self.to_ktx2())
    }

    /// The content of the file.
    pub(super) fn to_ktx2(&self) -> Vec<u8> {
        let format = vk_format(self.format);
        let (descriptor, type_size) =
            Basic::from_format(format).expect("the library describes these formats");
        let descriptor = Block::Basic(descriptor).to_vec();
        let metadata = self.metadata();
        // KTX 2.0, section 3.1: header, level index, data format descriptor, metadata, levels from the smallest.
        let index_end = Header::LENGTH + self.levels.len() * LevelIndex::LENGTH;
        let metadata_start = index_end + 4 + descriptor.len();
        let levels_start = (metadata_start + metadata.len()).next_multiple_of(self.format.bytes());
        let header = Header {
            format: Some(format),
            type_size,
            pixel_width: self.face_size,
            pixel_height: self.face_size,
            pixel_depth: 0,
            layer_count: 0,
            face_count: FACES as u32,
            level_count: self.levels.len() as u32,
            supercompression_scheme: None,
            index: Index {
                dfd_byte_offset: index_end as u32,
                dfd_byte_length: 4 + descriptor.len() as u32,
                kvd_byte_offset: metadata_start as u32,
                kvd_byte_length: metadata.len() as u32,
                sgd_byte_offset: 0,
                sgd_byte_length: 0,
            },
        };
        let mut bytes = header.as_bytes().to_vec();
        for (i, level) in self.levels.iter().enumerate() {
            let smaller: usize = self.levels[i + 1..].iter().map(Vec::len).sum();
            let entry = LevelIndex {
                byte_offset: (levels_start + smaller) as u64,
                byte_length: level.len() as u64,
                uncompressed_byte_length: level.len() as u64,
            };
            bytes.extend(entry.as_bytes());
        }
        bytes.extend((4 + descriptor.len() as u32).to_le_bytes());
        bytes.extend(descriptor);
        bytes.extend(metadata);
        bytes.resize(levels_start, 0);
        self.levels.iter().rev().for_each(|level| bytes.extend(level));
        bytes
    }

    /// Keys and values, sorted by key and padded to four bytes each.
    fn metadata(&self) -> Vec<u8> {
        let writer = concat!("ontile ", env!("CARGO_PKG_VERSION"), "\0");
        let entries: [(&str, Vec<u8>); 5] = [
            ("KTXwriter", writer.into()),
            (KEY_CHECKSUM, self.checksum().into()),
            (KEY_IRRADIANCE, self.irradiance_bytes()),
            (KEY_SCALE, self.scale.to_le_bytes().into()),
            (KEY_VERSION, VERSION.to_le_bytes().into()),
        ];
        let mut bytes = Vec::new();
        for (key, value) in entries {
            bytes.extend((key.len() as u32 + 1 + value.len() as u32).to_le_bytes());
            bytes.extend(key.as_bytes());
            bytes.push(0);
            bytes.extend(value);
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        bytes
    }

    fn irradiance_bytes(&self) -> Vec<u8> {
        self.irradiance.iter().flat_map(|c| c.to_array()).flat_map(f32::to_le_bytes).collect()
    }

    fn checksum(&self) -> [u8; 16] {
        let mut hash = Sha256::new();
        hash.update(self.scale.to_le_bytes());
        hash.update(self.irradiance_bytes());
        self.levels.iter().for_each(|level| hash.update(level));
        std::array::from_fn({
            let hash = hash.finalize();
            move |i| hash[i]
        })
    }

    /// The inverse of [`Self::to_ktx2`]; says what is wrong otherwise.
    pub(super) fn from_ktx2(bytes: &[u8]) -> Result<Self, String> {
        let reader = Reader::new(bytes).map_err(|e| format!("is a damaged KTX file: {e}"))?;
        let value = |wanted: &str| {
            let found = reader.key_value_data().find(|(key, _)| *key == wanted);
            found.map(|(_, value)| value).ok_or_else(|| format!("is a KTX file without the entry {wanted}"))
        };
        let version = u32::from_le_bytes(exact(value(KEY_VERSION)?, KEY_VERSION)?);
        if version != VERSION {
            return Err(format!("is of version {version}, but only {VERSION} is known"));
        }
        let header = reader.header();
        let format = TexelFormat::ALL.iter().copied().find(|f| Some(vk_format(*f)) == header.format);
        let format = format
            .ok_or_else(|| format!("holds texels of {:?}, which is no format of radiance", header.format))?;
        let size = header.pixel_width;
        let is_cube = header.pixel_height == size
            && header.face_count == FACES as u32
            && header.pixel_depth == 0
            && header.layer_count <= 1;
        if !is_cube || !is_face_size(size) || header.supercompression_scheme.is_some() {
            let (least, most) = FACE_SIZES.into_inner();
            return Err(format!("is not one uncompressed cube of a power of two from {least} to {most}"));
        }
        let levels: Vec<Vec<u8>> = reader.levels().map(|level| level.data.to_vec()).collect();
        let expected = |level: usize| FACES * ((size >> level) as usize).pow(2) * format.bytes();
        let fits = levels.len() == level_count(size) as usize
            && levels.iter().enumerate().all(|(i, level)| level.len() == expected(i));
        if !fits {
            return Err(format!("does not hold the {} levels of a cube of {size}", level_count(size)));
        }
        let scale = f32::from_le_bytes(exact(value(KEY_SCALE)?, KEY_SCALE)?);
        if !scale.is_normal() || scale < 0.0 {
            return Err(format!("has the entry {KEY_SCALE} = {scale}, which must be finite and above 0"));
        }
        let irradiance: [u8; 27 * 4] = exact(value(KEY_IRRADIANCE)?, KEY_IRRADIANCE)?;
        let floats: Vec<f32> =
            irradiance.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let irradiance = std::array::from_fn(|i| Vec3::from_slice(&floats[3 * i..]));
        // A coefficient is the mean over all directions of radiance times at most 4 (Ramamoorthi and Hanrahan 2001, 3.2).
        if !irradiance.iter().all(|c: &Vec3| c.is_finite() && c.abs().max_element() <= 8.0 * MAX_RADIANCE_NT)
        {
            return Err(format!(
                "has values in {KEY_IRRADIANCE} that are not finite, or exceed all radiance"
            ));
        }
        let most = MAX_RADIANCE_NT * 1.01;
        let valid = |texel: &[u8]| {
            let radiance = format.decode(format.load(texel)) * scale;
            // Rounding may have added a little.
            radiance.is_finite() && radiance.min_element() >= 0.0 && radiance.max_element() <= most
        };
        if !levels.iter().all(|level| level.chunks_exact(format.bytes()).all(valid)) {
            return Err(format!(
                "holds radiance that is negative, above {MAX_RADIANCE_NT:e} cd/m² or not a number"
            ));
        }
        let parsed = Self { format, face_size: size, scale, levels, irradiance };
        match parsed.checksum() == exact(value(KEY_CHECKSUM)?, KEY_CHECKSUM)? {
            true => Ok(parsed),
            false => Err("is damaged: its checksum differs".into()),
        }
    }
}

fn exact<const N: usize>(value: &[u8], key: &str) -> Result<[u8; N], String> {
    value.try_into().map_err(|_| format!("has an entry {key} of {} bytes instead of {N}", value.len()))
}

fn vk_format(format: TexelFormat) -> Format {
    match format {
        TexelFormat::Rgbm => Format::R8G8B8A8_UNORM,
        TexelFormat::B10G11R11 => Format::B10G11R11_UFLOAT_PACK32,
        TexelFormat::E5B9G9R9 => Format::E5B9G9R9_UFLOAT_PACK32,
        TexelFormat::Rgba16F => Format::R16G16B16A16_SFLOAT,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prefiltered(format: TexelFormat) -> Prefiltered {
        let texels = (0..32 * 16).map(|i| Vec3::new(i as f32, 3.0, 1e5 / (i + 1) as f32)).collect();
        Prefiltered::new(&Panorama::new(32, 16, texels).unwrap(), 16, format)
    }

    #[test]
    fn files_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        for &format in TexelFormat::ALL {
            let path = folder.path().join("e.ktx2");
            let made = prefiltered(format);
            made.write(&path).unwrap();
            assert_eq!(read(&path).unwrap(), Content::Prefiltered(made));
        }
    }

    /// A file whose size is right, with other bytes in place of a metadata value.
    fn with_value(key: &str, value: &[u8]) -> Vec<u8> {
        let mut bytes = prefiltered(TexelFormat::Rgba16F).to_ktx2();
        let needle = [key.as_bytes(), &[0]].concat();
        let at = bytes.windows(needle.len()).position(|w| w == needle).unwrap() + needle.len();
        bytes[at..at + value.len()].copy_from_slice(value);
        bytes
    }

    #[test]
    fn no_damage_goes_unnoticed() {
        let good = prefiltered(TexelFormat::Rgba16F).to_ktx2();
        let problem = |bytes: &[u8]| Prefiltered::from_ktx2(bytes).unwrap_err();
        assert!(problem(&with_value(KEY_VERSION, &7_u32.to_le_bytes())).contains("version 7"));
        assert!(problem(&with_value(KEY_SCALE, &f32::NAN.to_le_bytes())).contains(KEY_SCALE));
        assert!(problem(&with_value(KEY_SCALE, &1e13_f32.to_le_bytes())).contains("above 1e12 cd/m²"));
        assert!(problem(&with_value(KEY_IRRADIANCE, &f32::INFINITY.to_le_bytes())).contains("not finite"));
        assert!(problem(&with_value(KEY_CHECKSUM, &[0; 16])).contains("checksum"));
        let mut negative = good.clone();
        let last = negative.len() - 7;
        negative[last] |= 0x80;
        assert!(problem(&negative).contains("negative"));
        let mut other_format = good.clone();
        other_format[12] = 37;
        assert!(problem(&other_format).contains("levels"));
        other_format[12] = 43;
        assert!(problem(&other_format).contains("R8G8B8A8_SRGB"));
        for cut in 0..good.len().min(700) {
            problem(&good[..cut]);
        }
        // Any byte of the head: nothing panics, and what is accepted is what was written.
        for at in 0..good.len().min(700) {
            for bit in [0x01, 0x80] {
                let mut changed = good.clone();
                changed[at] ^= bit;
                if let Ok(accepted) = Prefiltered::from_ktx2(&changed) {
                    assert_eq!(accepted, prefiltered(TexelFormat::Rgba16F), "byte {at}");
                }
            }
        }
    }
}

//! KTX 2.0 files of material textures: Basis Universal as KHR_texture_basisu has it, and ready-made BC, ETC2 and ASTC.

use std::io::Read;

use ktx2::{ColorModel, Format, Reader, SupercompressionScheme};

use super::texels::{AstcBlock, Stored, TextureFormat, level_size};
use super::{Image, Texels, mip_level_count};

/// Texels along a side: what Vulkan devices offer at most.
pub(super) const MAX_SIDE: u32 = 16384;

impl Image {
    /// Reads a KTX 2.0 file with one two-dimensional picture: Basis Universal (ETC1S or UASTC), or BC1, BC3, BC7, ETC2, ASTC or
    /// RGBA8 blocks, plain or compressed by Zstandard. It is sampled with the levels that the file has; RGBA8 with one level
    /// gets the rest as other pictures do.
    ///
    /// # Errors
    /// What is wrong with the file, as the end of a sentence that begins with its name.
    pub fn from_ktx2(name: &str, bytes: &[u8]) -> Result<Self, String> {
        let reader = Reader::new(bytes).map_err(|e| format!("is a damaged KTX file: {e}"))?;
        let header = reader.header();
        let size = [header.pixel_width, header.pixel_height];
        let is_plain = header.pixel_depth == 0 && header.layer_count <= 1 && header.face_count == 1;
        if !is_plain || size.contains(&0) {
            return Err(
                "is a KTX file of a volume, an array, a cube map or a line, not of one picture".into()
            );
        }
        if size.iter().any(|&side| side > MAX_SIDE) {
            return Err(format!("is {} x {} texels", size[0], size[1]));
        }
        check_metadata(&reader)?;
        let levels = header.level_count.max(1);
        if levels > mip_level_count(size[0], size[1]) {
            return Err(format!(
                "has {levels} levels, more than {} x {} texels halve into",
                size[0], size[1]
            ));
        }
        let image = |texels| Self { name: name.into(), width: size[0], height: size[1], texels };
        let is_basis = matches!(reader.color_model(), Some(ColorModel::ETC1S | ColorModel::UASTC));
        if is_basis && header.format.is_none() {
            check_basis(&reader, size)?;
            return Ok(image(Texels::Stored(Stored::from_basis(bytes, size)?)));
        }
        let format = header.format.and_then(texel_format).ok_or_else(|| {
            let found = header.format.map_or("an unknown format".into(), |f| format!("{f:?}"));
            format!(
                "holds texels of {found}; Basis Universal, BC1, BC3, BC7, ETC2, ASTC and RGBA8 can be read"
            )
        })?;
        let scheme = header.supercompression_scheme;
        let read = |(level, found): (u32, ktx2::Level)| match scheme {
            None => Ok(found.data.to_vec()),
            Some(SupercompressionScheme::Zstandard) => {
                inflate(found.data, format.level_bytes(level_size(size, level)))
                    .map_err(|problem| format!("has a damaged level {level}: {problem}"))
            }
            Some(other) => Err(format!("is compressed by {other:?}; Zstandard and none can be read")),
        };
        let mut contents = (0..).zip(reader.levels()).map(read).collect::<Result<Vec<_>, _>>()?;
        if (format, contents.len()) == (TextureFormat::Rgba8, 1) {
            let plain = image(Texels::Rgba8(contents.remove(0)));
            return plain.problem().map_or(Ok(plain), Err);
        }
        Ok(image(Texels::Stored(Stored::from_levels(format, size, contents)?)))
    }
}

/// Lengths that the transcoder allocates without asking: UASTC has 16 bytes for 4x4 texels, and of BasisLZ none is said.
fn check_basis(reader: &Reader<&[u8]>, size: [u32; 2]) -> Result<(), String> {
    let is_uastc = reader.color_model() == Some(ColorModel::UASTC);
    for (level, found) in (0..).zip(reader.levels()) {
        let expected = match is_uastc {
            true => TextureFormat::Astc(AstcBlock::B4x4).level_bytes(level_size(size, level)),
            false => 0,
        };
        if found.uncompressed_byte_length != expected {
            let bytes = found.uncompressed_byte_length;
            return Err(format!("has {bytes} bytes in level {level}, not {expected}"));
        }
    }
    Ok(())
}

/// Refuses what would be seen mirrored or in wrong channels.
fn check_metadata(reader: &Reader<&[u8]>) -> Result<(), String> {
    let value = |key: &str| reader.key_value_data().find(|(k, _)| *k == key).map(|(_, value)| value);
    let differs = |found: Option<&[u8]>, usual: &[u8]| found.is_some_and(|v| !v.starts_with(usual));
    if differs(value("KTXorientation"), b"rd") {
        return Err("has its first texel elsewhere than at the top left (KTXorientation)".into());
    }
    if differs(value("KTXswizzle"), b"rgba") {
        return Err("has its channels in another order (KTXswizzle)".into());
    }
    Ok(())
}

/// Exactly so many bytes; what is longer is not read to its end.
fn inflate(compressed: &[u8], bytes: u64) -> Result<Vec<u8>, String> {
    let decoder = ruzstd::StreamingDecoder::new(compressed).map_err(|e| e.to_string())?;
    let mut content = Vec::new();
    decoder.take(bytes + 1).read_to_end(&mut content).map_err(|e| e.to_string())?;
    Ok(content)
}

fn texel_format(format: Format) -> Option<TextureFormat> {
    use AstcBlock as A;
    use TextureFormat as T;
    Some(match format {
        Format::R8G8B8A8_UNORM | Format::R8G8B8A8_SRGB => T::Rgba8,
        Format::BC1_RGB_UNORM_BLOCK | Format::BC1_RGB_SRGB_BLOCK => T::Bc1,
        Format::BC1_RGBA_UNORM_BLOCK | Format::BC1_RGBA_SRGB_BLOCK => T::Bc1Alpha,
        Format::BC3_UNORM_BLOCK | Format::BC3_SRGB_BLOCK => T::Bc3,
        Format::BC7_UNORM_BLOCK | Format::BC7_SRGB_BLOCK => T::Bc7,
        Format::ETC2_R8G8B8_UNORM_BLOCK | Format::ETC2_R8G8B8_SRGB_BLOCK => T::Etc2,
        Format::ETC2_R8G8B8A1_UNORM_BLOCK | Format::ETC2_R8G8B8A1_SRGB_BLOCK => T::Etc2Mask,
        Format::ETC2_R8G8B8A8_UNORM_BLOCK | Format::ETC2_R8G8B8A8_SRGB_BLOCK => T::Etc2Alpha,
        Format::ASTC_4x4_UNORM_BLOCK | Format::ASTC_4x4_SRGB_BLOCK => T::Astc(A::B4x4),
        Format::ASTC_5x4_UNORM_BLOCK | Format::ASTC_5x4_SRGB_BLOCK => T::Astc(A::B5x4),
        Format::ASTC_5x5_UNORM_BLOCK | Format::ASTC_5x5_SRGB_BLOCK => T::Astc(A::B5x5),
        Format::ASTC_6x5_UNORM_BLOCK | Format::ASTC_6x5_SRGB_BLOCK => T::Astc(A::B6x5),
        Format::ASTC_6x6_UNORM_BLOCK | Format::ASTC_6x6_SRGB_BLOCK => T::Astc(A::B6x6),
        Format::ASTC_8x5_UNORM_BLOCK | Format::ASTC_8x5_SRGB_BLOCK => T::Astc(A::B8x5),
        Format::ASTC_8x6_UNORM_BLOCK | Format::ASTC_8x6_SRGB_BLOCK => T::Astc(A::B8x6),
        Format::ASTC_8x8_UNORM_BLOCK | Format::ASTC_8x8_SRGB_BLOCK => T::Astc(A::B8x8),
        Format::ASTC_10x5_UNORM_BLOCK | Format::ASTC_10x5_SRGB_BLOCK => T::Astc(A::B10x5),
        Format::ASTC_10x6_UNORM_BLOCK | Format::ASTC_10x6_SRGB_BLOCK => T::Astc(A::B10x6),
        Format::ASTC_10x8_UNORM_BLOCK | Format::ASTC_10x8_SRGB_BLOCK => T::Astc(A::B10x8),
        Format::ASTC_10x10_UNORM_BLOCK | Format::ASTC_10x10_SRGB_BLOCK => T::Astc(A::B10x10),
        Format::ASTC_12x10_UNORM_BLOCK | Format::ASTC_12x10_SRGB_BLOCK => T::Astc(A::B12x10),
        Format::ASTC_12x12_UNORM_BLOCK | Format::ASTC_12x12_SRGB_BLOCK => T::Astc(A::B12x12),
        _ => return None,
    })
}

//! What a picture's texels are stored as, and which of it a GPU can be given.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use super::block_decoder::decode;
use basisu::{DecodeFlags, TargetFormat, Transcoder};

/// The texels of an [`Image`](super::Image).
#[derive(Clone, Debug)]
pub enum Texels {
    /// `width * height * 4` bytes, rows from the top: red, green, blue, alpha, as encoded in the file. Smaller levels are made of
    /// them where a sampler wants some.
    Rgba8(Vec<u8>),
    /// Compressed, with the mip levels that the file has; see [`Image::from_ktx2`](super::Image::from_ktx2).
    Stored(Stored),
}

impl FromIterator<u8> for Texels {
    fn from_iter<I: IntoIterator<Item = u8>>(rgba8: I) -> Self {
        Self::Rgba8(rgba8.into_iter().collect())
    }
}

impl From<Vec<u8>> for Texels {
    fn from(rgba8: Vec<u8>) -> Self {
        Self::Rgba8(rgba8)
    }
}

/// Formats of texels that a GPU can be given. Whether colours are sRGB-encoded follows from the material slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureFormat {
    /// Four bytes a texel.
    Rgba8,
    /// BC1 without alpha: 8 bytes for 4x4 texels.
    Bc1,
    /// BC1 with one bit of alpha.
    Bc1Alpha,
    /// BC3: 16 bytes for 4x4 texels.
    Bc3,
    /// BC7: 16 bytes for 4x4 texels.
    Bc7,
    /// ETC2 without alpha, ETC1 included: 8 bytes for 4x4 texels.
    Etc2,
    /// ETC2 with one bit of alpha.
    Etc2Mask,
    /// ETC2 with EAC alpha: 16 bytes for 4x4 texels.
    Etc2Alpha,
    /// ASTC of the LDR profile: 16 bytes for a block.
    Astc(AstcBlock),
}

/// Texels of an ASTC block, across and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names say it")]
pub enum AstcBlock {
    B4x4,
    B5x4,
    B5x5,
    B6x5,
    B6x6,
    B8x5,
    B8x6,
    B8x8,
    B10x5,
    B10x6,
    B10x8,
    B10x10,
    B12x10,
    B12x12,
}

impl AstcBlock {
    /// Width and height, texels.
    pub fn size(self) -> [u32; 2] {
        match self {
            Self::B4x4 => [4, 4],
            Self::B5x4 => [5, 4],
            Self::B5x5 => [5, 5],
            Self::B6x5 => [6, 5],
            Self::B6x6 => [6, 6],
            Self::B8x5 => [8, 5],
            Self::B8x6 => [8, 6],
            Self::B8x8 => [8, 8],
            Self::B10x5 => [10, 5],
            Self::B10x6 => [10, 6],
            Self::B10x8 => [10, 8],
            Self::B10x10 => [10, 10],
            Self::B12x10 => [12, 10],
            Self::B12x12 => [12, 12],
        }
    }
}

impl TextureFormat {
    /// All but RGBA8.
    pub const COMPRESSED: [Self; 21] = [
        Self::Bc1,
        Self::Bc1Alpha,
        Self::Bc3,
        Self::Bc7,
        Self::Etc2,
        Self::Etc2Mask,
        Self::Etc2Alpha,
        Self::Astc(AstcBlock::B4x4),
        Self::Astc(AstcBlock::B5x4),
        Self::Astc(AstcBlock::B5x5),
        Self::Astc(AstcBlock::B6x5),
        Self::Astc(AstcBlock::B6x6),
        Self::Astc(AstcBlock::B8x5),
        Self::Astc(AstcBlock::B8x6),
        Self::Astc(AstcBlock::B8x8),
        Self::Astc(AstcBlock::B10x5),
        Self::Astc(AstcBlock::B10x6),
        Self::Astc(AstcBlock::B10x8),
        Self::Astc(AstcBlock::B10x10),
        Self::Astc(AstcBlock::B12x10),
        Self::Astc(AstcBlock::B12x12),
    ];

    /// Width and height of a block, texels.
    pub fn block(self) -> [u32; 2] {
        match self {
            Self::Rgba8 => [1, 1],
            Self::Astc(block) => block.size(),
            _ => [4, 4],
        }
    }

    /// Bytes of a block.
    pub fn block_bytes(self) -> u32 {
        match self {
            Self::Rgba8 => 4,
            Self::Bc1 | Self::Bc1Alpha | Self::Etc2 | Self::Etc2Mask => 8,
            Self::Bc3 | Self::Bc7 | Self::Etc2Alpha | Self::Astc(_) => 16,
        }
    }

    /// Bytes of a level of this size.
    pub fn level_bytes(self, [width, height]: [u32; 2]) -> u64 {
        let [across, down] = self.block();
        u64::from(width.div_ceil(across)) * u64::from(height.div_ceil(down)) * u64::from(self.block_bytes())
    }
}

/// Compressed levels, or what is transcoded to such.
#[derive(Clone)]
pub struct Stored {
    content: Content,
    /// Of level 0, texels.
    size: [u32; 2],
    /// Level 0 as RGBA8, once somebody has asked.
    decoded: OnceLock<Vec<u8>>,
}

#[derive(Clone)]
enum Content {
    /// Level 0 first; each as long as its size demands.
    Levels { format: TextureFormat, levels: Arc<[Vec<u8>]> },
    /// A whole KTX 2.0 file of Basis Universal, all of whose levels could be transcoded.
    Basis { file: Arc<[u8]>, codec: Codec, has_alpha: bool, levels: u32 },
}

/// The two codecs of Basis Universal that KHR_texture_basisu knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Codec {
    /// A subset of ETC1.
    Etc1s,
    /// A subset of ASTC 4x4.
    Uastc,
}

/// Texels as they were encoded: by default edges between blocks of ETC1S are smoothed on the way to BC7.
const FLAGS: DecodeFlags = DecodeFlags::NO_ETC1S_CHROMA_FILTERING;

impl Stored {
    /// Of ready-made levels, level 0 first.
    pub(super) fn from_levels(
        format: TextureFormat,
        size: [u32; 2],
        levels: Vec<Vec<u8>>,
    ) -> Result<Self, String> {
        for (level, content) in (0..).zip(&levels) {
            let expected = format.level_bytes(level_size(size, level));
            if content.len() as u64 != expected {
                return Err(format!("has {} bytes in level {level}, not {expected}", content.len()));
            }
        }
        Ok(Self {
            content: Content::Levels { format, levels: levels.into() },
            size,
            decoded: OnceLock::new(),
        })
    }

    /// Of a KTX 2.0 file of Basis Universal.
    pub(super) fn from_basis(file: &[u8], size: [u32; 2]) -> Result<Self, String> {
        let transcoder = Transcoder::new(file).map_err(|e| format!("is damaged Basis Universal: {e:?}"))?;
        let codec = match transcoder.source_format() {
            basisu::SourceFormat::Etc1s => Codec::Etc1s,
            basisu::SourceFormat::UastcLdr => Codec::Uastc,
            other => {
                return Err(format!("is Basis Universal of the codec {other:?}, not ETC1S or UASTC LDR"));
            }
        };
        let levels = transcoder.level_count();
        for level in 0..levels {
            let result = transcoder.transcode(level, TargetFormat::Rgba32, FLAGS);
            result.map_err(|e| format!("has a damaged level {level}: {e:?}"))?;
        }
        let has_alpha = transcoder.has_alpha();
        let content = Content::Basis { file: file.into(), codec, has_alpha, levels };
        Ok(Self { content, size, decoded: OnceLock::new() })
    }

    /// How many mip levels there are.
    pub fn levels(&self) -> u32 {
        match &self.content {
            Content::Levels { levels, .. } => levels.len() as u32,
            Content::Basis { levels, .. } => *levels,
        }
    }

    /// What a GPU can be given, what loses least first; RGBA8, which every GPU has, last. The colours of ETC1S
    /// are a subset of ETC2's, and UASTC is one of ASTC, which therefore hold them exactly; alpha of ETC1S is fitted.
    pub fn formats(&self) -> Vec<TextureFormat> {
        let astc = TextureFormat::Astc(AstcBlock::B4x4);
        match &self.content {
            Content::Levels { format, .. } => vec![*format, TextureFormat::Rgba8],
            Content::Basis { codec, has_alpha, .. } => {
                let etc2 = if *has_alpha { TextureFormat::Etc2Alpha } else { TextureFormat::Etc2 };
                match codec {
                    Codec::Etc1s => vec![etc2, TextureFormat::Bc7, astc, TextureFormat::Rgba8],
                    Codec::Uastc => vec![astc, TextureFormat::Bc7, etc2, TextureFormat::Rgba8],
                }
            }
        }
    }

    /// A level in one of [`Self::formats`], rows of blocks tightly packed.
    ///
    /// # Panics
    /// For a level or a format that is none of these.
    pub fn level(&self, level: u32, format: TextureFormat) -> Cow<'_, [u8]> {
        match &self.content {
            Content::Levels { format: stored, levels } => {
                let content = &levels[level as usize];
                match format == *stored {
                    true => Cow::Borrowed(content),
                    false => {
                        assert_eq!(format, TextureFormat::Rgba8, "blocks are decoded only to RGBA8");
                        Cow::Owned(decode(*stored, content, level_size(self.size, level)))
                    }
                }
            }
            Content::Basis { file, .. } => {
                let target = match format {
                    TextureFormat::Rgba8 => TargetFormat::Rgba32,
                    TextureFormat::Bc7 => TargetFormat::Bc7Rgba,
                    TextureFormat::Etc2 => TargetFormat::Etc1Rgb,
                    TextureFormat::Etc2Alpha => TargetFormat::Etc2Rgba,
                    TextureFormat::Astc(AstcBlock::B4x4) => TargetFormat::Astc4x4Rgba,
                    other => panic!("Basis Universal is not transcoded to {other:?}"),
                };
                let transcoded = Transcoder::new(file).and_then(|t| t.transcode(level, target, FLAGS));
                Cow::Owned(transcoded.expect("all levels were transcoded when the file was read"))
            }
        }
    }

    /// Level 0, four bytes a texel; decoded when first asked for.
    pub fn rgba8(&self) -> &[u8] {
        self.decoded.get_or_init(|| self.level(0, TextureFormat::Rgba8).into_owned())
    }

    /// Of level 0, texels.
    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// What is kept of the file.
    fn bytes(&self) -> Vec<&[u8]> {
        match &self.content {
            Content::Levels { levels, .. } => levels.iter().map(Vec::as_slice).collect(),
            Content::Basis { file, .. } => vec![file],
        }
    }
}

impl std::fmt::Debug for Stored {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let bytes: usize = self.bytes().iter().map(|part| part.len()).sum();
        write!(f, "Stored({:?}, {} levels, {bytes} bytes)", self.formats()[0], self.levels())
    }
}

/// Width and height of a mip level, texels.
pub fn level_size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|n| n.checked_shr(level).unwrap_or(0).max(1))
}

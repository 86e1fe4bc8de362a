//! Attachment formats, independent of any graphics API.

use serde::{Deserialize, Serialize};

use super::names::named_enum;

named_enum! {
    /// What one pixel of an attachment looks like.
    Format {
        /// One 32-bit float.
        R32Float = "r32f",
        /// Four 8-bit unsigned normalised channels.
        Rgba8Unorm = "rgba8",
        /// Three 8-bit sRGB-encoded channels and linear alpha.
        Rgba8Srgb = "rgba8_srgb",
        /// The same with red and blue swapped.
        Bgra8Srgb = "bgra8_srgb",
        /// Three 10-bit and one 2-bit unsigned normalised channels.
        Rgb10a2Unorm = "rgb10a2",
        /// Unsigned floats of 11, 11 and 10 bits.
        B10g11r11Float = "b10g11r11",
        /// One half float.
        R16Float = "r16f",
        /// One 8-bit unsigned normalised channel.
        R8Unorm = "r8",
        /// Two half floats.
        Rg16Float = "rg16f",
        /// Two 8-bit unsigned normalised channels.
        Rg8Unorm = "rg8",
        /// Four 16-bit unsigned normalised channels.
        Rgba16Unorm = "rgba16",
        /// One 32-bit word.
        R32Uint = "r32ui",
        /// Two 32-bit words.
        Rg32Uint = "rg32ui",
        /// Four 32-bit words.
        Rgba32Uint = "rgba32ui",
        /// Four half floats.
        Rgba16Float = "rgba16f",
        /// Four 32-bit floats.
        Rgba32Float = "rgba32f",
        /// 32-bit float depth.
        D32Float = "d32f",
        /// 24-bit unsigned normalised depth.
        D24Unorm = "d24",
        /// 16-bit unsigned normalised depth.
        D16Unorm = "d16",
        /// 32-bit float depth and 8 bits of stencil.
        D32FloatS8 = "d32f_s8",
        /// 24-bit unsigned normalised depth and 8 bits of stencil.
        D24UnormS8 = "d24_s8",
    }
}

impl Format {
    /// Bits of one sample.
    pub const fn bits(self) -> u32 {
        match self {
            Self::R32Float
            | Self::Rgba8Unorm
            | Self::Rgba8Srgb
            | Self::Bgra8Srgb
            | Self::Rgb10a2Unorm
            | Self::B10g11r11Float
            | Self::Rg16Float
            | Self::R32Uint
            | Self::D32Float
            | Self::D24Unorm
            | Self::D24UnormS8 => 32,
            Self::R8Unorm => 8,
            Self::D16Unorm | Self::R16Float | Self::Rg8Unorm => 16,
            Self::D32FloatS8 => 40,
            Self::Rgba16Float | Self::Rgba16Unorm | Self::Rg32Uint => 64,
            Self::Rgba32Float | Self::Rgba32Uint => 128,
        }
    }

    /// Bytes of one sample.
    pub const fn bytes(self) -> u32 {
        self.bits() / 8
    }

    /// What lies between two neighbouring values of fixed-point depth; 0 for floats.
    pub const fn depth_step(self) -> f32 {
        match self {
            Self::D16Unorm => 1.0 / 65535.0,
            Self::D24Unorm | Self::D24UnormS8 => 1.0 / 16_777_215.0,
            _ => 0.0,
        }
    }

    /// Whether this is a depth format.
    pub const fn is_depth(self) -> bool {
        matches!(self, Self::D32Float | Self::D24Unorm | Self::D16Unorm) || self.has_stencil()
    }

    /// Whether channels are unsigned integers.
    pub const fn is_uint(self) -> bool {
        matches!(self, Self::R32Uint | Self::Rg32Uint | Self::Rgba32Uint)
    }

    /// Whether it has stencil bits beside depth.
    pub const fn has_stencil(self) -> bool {
        matches!(self, Self::D32FloatS8 | Self::D24UnormS8)
    }
}

impl From<super::OutputFormat> for Format {
    fn from(f: super::OutputFormat) -> Self {
        use super::OutputFormat as O;
        match f {
            O::Rgba8Srgb => Self::Rgba8Srgb,
            O::Bgra8Srgb => Self::Bgra8Srgb,
            O::Rgba16Float => Self::Rgba16Float,
            O::Rgba32Float => Self::Rgba32Float,
        }
    }
}

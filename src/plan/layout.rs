//! G-buffer layouts: one table each; the GLSL side is the file of the same name under `glsl/gbuffer/`.

use super::{Format, Layout};

/// One attachment of a G-buffer.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// The attachment's name in plans and reports.
    pub name: &'static str,
    /// How it is stored.
    pub format: Format,
    /// What each channel holds.
    pub holds: &'static str,
    /// Bits that carry information; the rest is padding.
    pub used_bits: u32,
    /// What pixels that no surface covers must hold; `None` where nothing reads them.
    pub clear: Option<[f32; 4]>,
}

/// A G-buffer layout.
#[derive(Clone, Copy, Debug)]
pub struct LayoutTable {
    /// Where the layout comes from.
    pub source: &'static str,
    /// What geometry writes and lighting reads, in order of colour output and of input attachment index.
    pub surface: [Target; 3],
    /// Where light is summed before the tone curve.
    pub light: Target,
    /// The greatest exposed light that the light target can hold: 1 / the factor it is stored with.
    pub light_range: f32,
}

/// Exposed light above this is clipped by a normalised light target. The neutral curve compresses all that lies
/// above it into the last 4 % of the display's range, while each doubling costs a bit in the dark.
const UNORM_LIGHT_RANGE: f32 = 2.0;

const METALLIC128: LayoutTable = LayoutTable {
    source: "Smith and Einig 2015, listing 2.2",
    surface: [
        Target {
            name: "depth",
            format: Format::R32Float,
            holds: "r: reversed device depth",
            used_bits: 32,
            clear: None,
        },
        Target {
            name: "normal_roughness",
            format: Format::Rgba8Unorm,
            holds: "rgb: world-space normal / 2 + 1/2, a: perceptual roughness; all zero: not lit",
            used_bits: 32,
            clear: Some([0.0; 4]),
        },
        Target {
            name: "base_metallic",
            format: Format::Rgba8Srgb,
            holds: "rgb: albedo or reflectance (sRGB), a: metallicness",
            used_bits: 32,
            clear: None,
        },
    ],
    light: Target {
        name: "light",
        format: Format::Rgb10a2Unorm,
        holds: "rgb: exposed light / range, a: padding",
        used_bits: 30,
        clear: Some([0.0; 4]),
    },
    light_range: UNORM_LIGHT_RANGE,
};

const EXACT: LayoutTable = LayoutTable {
    source: "all channels 32-bit floats, to tell quantisation from arithmetic",
    surface: [
        Target { used_bits: 32, ..METALLIC128.surface[0] },
        Target {
            name: "normal_roughness",
            format: Format::Rgba32Float,
            holds: "rgb: world-space normal, a: perceptual roughness; all zero: not lit",
            used_bits: 128,
            clear: Some([0.0; 4]),
        },
        Target {
            name: "base_metallic",
            format: Format::Rgba32Float,
            holds: "rgb: base colour (linear), a: metallicness",
            used_bits: 128,
            clear: None,
        },
    ],
    light: Target {
        name: "light",
        format: Format::Rgba32Float,
        holds: "rgb: exposed light, a: padding",
        used_bits: 96,
        clear: Some([0.0; 4]),
    },
    light_range: 1.0,
};

impl Layout {
    /// The place of reversed depth among the surface targets of every layout.
    pub(super) const DEPTH: usize = 0;

    /// What the layout consists of.
    pub const fn table(self) -> &'static LayoutTable {
        match self {
            Self::Metallic128 => &METALLIC128,
            Self::Exact => &EXACT,
        }
    }

    /// The factor that exposed light is stored with in the light target.
    pub fn light_scale(self) -> f32 {
        1.0 / self.table().light_range
    }
}

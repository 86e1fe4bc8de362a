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
    /// Where light that surfaces send without light sources is stored, and the sum of all lights is added.
    pub light: LightTarget,
    /// The same where lights are added one by one. Each addition is rounded, so that of many dim lights all that is below
    /// half a step would be lost.
    pub light_one_by_one: LightTarget,
}

/// What light is summed in before the tone curve.
#[derive(Clone, Copy, Debug)]
pub struct LightTarget {
    /// The attachment.
    pub target: Target,
    /// The exposed light that is stored as 1; a normalised format clips what is above.
    pub range: f32,
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
    light: LightTarget {
        target: Target {
            name: "light",
            format: Format::Rgb10a2Unorm,
            holds: "rgb: exposed light / range, a: padding",
            used_bits: 30,
            clear: Some([0.0; 4]),
        },
        range: UNORM_LIGHT_RANGE,
    },
    light_one_by_one: float_light(Format::Rgba16Float, 48),
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
    light: float_light(Format::Rgba32Float, 96),
    light_one_by_one: float_light(Format::Rgba32Float, 96),
};

const fn float_light(format: Format, used_bits: u32) -> LightTarget {
    let holds = "rgb: exposed light, a: padding";
    LightTarget {
        target: Target { name: "light", format, holds, used_bits, clear: Some([0.0; 4]) },
        range: 1.0,
    }
}

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

    /// What light is summed in: all lights at once, or one by one.
    pub(super) fn light(self, one_by_one: bool) -> &'static LightTarget {
        let table = self.table();
        if one_by_one { &table.light_one_by_one } else { &table.light }
    }
}

//! The targets of each form of G-buffer.

use super::layout::{Form, GBuffer, Target, Tells};
use super::{DepthStore, Format, Gamma, Normals};

impl GBuffer {
    /// What geometry writes of surfaces, in order.
    pub(super) fn targets(&self) -> Vec<Target> {
        let depth = (self.form.has_depth() && self.depth == DepthStore::R32f).then_some(DEPTH);
        let base = |holds| self.color("base_metallic", holds, Tells::Albedo);
        let normal_roughness = || normal_roughness(self.normals);
        let half = |name, holds, used_bits, clear, tells| Target {
            name,
            format: Format::Rgba16Float,
            holds,
            used_bits,
            clear,
            tells,
        };
        let word = |name, holds| Target {
            name,
            format: Format::Rgba32Uint,
            holds,
            used_bits: 128,
            clear: NOTHING,
            tells: Tells::Position,
        };
        let metallic = "rgb: base colour, a: metallicness";
        let targets = match self.form {
            Form::Metallic => vec![normal_roughness(), base(metallic)],
            Form::Specular => vec![
                normal_roughness(),
                Target { used_bits: base("").used_bits * 3 / 4, ..base("rgb: diffuse albedo, a: padding") },
                self.specular(),
            ],
            Form::Thibieroz128 => vec![
                half("position", "rgb: world-space position, a: roughness", 64, None, Tells::Position),
                Target {
                    name: "normal",
                    format: Format::Rgb10a2Unorm,
                    holds: "rgb: world-space normal / 2 + 1/2, a: 1 lit",
                    used_bits: 31,
                    clear: NOTHING,
                    tells: Tells::Surface,
                },
                base(metallic),
            ],
            Form::Thibieroz96 => vec![
                Target {
                    name: "position",
                    format: Format::Rg16Float,
                    holds: "rg: world-space x and y",
                    used_bits: 32,
                    clear: None,
                    tells: Tells::Position,
                },
                Target {
                    name: "position_z",
                    format: Format::R16Float,
                    holds: "r: world-space z",
                    used_bits: 16,
                    clear: None,
                    tells: Tells::Position,
                },
                Target { clear: NOTHING, ..base("rgb: base colour, a: normal z / 2 + 1/2") },
                Target {
                    name: "normal_xy",
                    format: Format::Rg8Unorm,
                    holds: "rg: world-space normal x and y / 2 + 1/2",
                    used_bits: 16,
                    clear: NOTHING,
                    tells: Tells::Surface,
                },
            ],
            Form::Rasa128 => vec![
                Target {
                    name: "normal",
                    format: Format::Rgba8Unorm,
                    holds: "rg: view-space normal x and y / 2 + 1/2, b: roughness, a: 1 lit",
                    used_bits: 25,
                    clear: NOTHING,
                    tells: Tells::Surface,
                },
                Target { used_bits: base("").used_bits * 3 / 4, ..base("rgb: diffuse albedo, a: padding") },
                self.specular(),
            ],
            Form::Dissertation192 => vec![
                half("position", "rgb: view-space position, a: roughness", 64, None, Tells::Position),
                half("normal", "rgb: view-space normal, a: 1 lit", 49, NOTHING, Tells::Surface),
                half("base_metallic", "rgb: base colour (linear), a: metallicness", 64, None, Tells::Albedo),
            ],
            Form::Metallic256 => vec![
                word("words", "position x, y, z (float); light r, g (half)"),
                word(
                    "more_words",
                    "light b, normal (half); roughness, metallicness (half); base colour (b10g11r11)",
                ),
            ],
            Form::Specular256 => vec![
                word("words", "position x, y, z (float); light r, g (half)"),
                word(
                    "more_words",
                    "light b, roughness (half); normal / 2 + 1/2, diffuse albedo, reflectance (b10g11r11)",
                ),
            ],
            Form::Packed128 => vec![Target {
                name: "words",
                format: Format::Rg32Uint,
                holds: "octahedral normal 11 + 11, roughness 9; hyperbola of base colour 9 + 9 + 9, metallicness 6",
                used_bits: 64,
                clear: NOTHING,
                tells: Tells::Surface,
            }],
        };
        depth.into_iter().chain(targets).collect()
    }

    /// A colour and something linear in alpha.
    fn color(&self, name: &'static str, what: &'static str, tells: Tells) -> Target {
        let format = match self.gamma {
            Gamma::Srgb => Format::Rgba8Srgb,
            Gamma::Power22 | Gamma::Power20 | Gamma::Linear => Format::Rgba8Unorm,
            Gamma::Float => Format::Rgba32Float,
        };
        Target { name, format, holds: what, used_bits: format.bits(), clear: None, tells }
    }

    fn specular(&self) -> Target {
        let color =
            self.color("specular", "rgb: reflectance at normal incidence, a: padding", Tells::Surface);
        Target { used_bits: color.used_bits * 3 / 4, ..color }
    }
}

/// What is nowhere written.
const NOTHING: Option<[f32; 4]> = Some([0.0; 4]);

const DEPTH: Target = Target {
    name: "depth",
    format: Format::R32Float,
    holds: "r: reversed device depth",
    used_bits: 32,
    clear: None,
    tells: Tells::Position,
};

pub(super) const LIGHT_WORD: Target = Target {
    name: "light_word",
    format: Format::R32Uint,
    holds: "exposed light before lighting (e5b9g9r9)",
    used_bits: 32,
    clear: NOTHING,
    tells: Tells::Surface,
};

fn normal_roughness(normals: Normals) -> Target {
    let (format, holds, used_bits) = match normals {
        Normals::Xyz8 => (
            Format::Rgba8Unorm,
            "rgb: world-space normal / 2 + 1/2, a: perceptual roughness; all zero: not lit",
            32,
        ),
        Normals::Oct8 => (Format::Rgba8Unorm, "rg: octahedral normal, b: roughness, a: 1 lit", 25),
        Normals::Oct10 => (Format::Rgb10a2Unorm, "rg: octahedral normal, b: roughness, a: 1 lit", 31),
        Normals::Oct12 => {
            (Format::Rgba8Unorm, "rgb: octahedral normal 12 + 12, a: roughness; rgb all zero: not lit", 32)
        }
        Normals::Oct16 => (Format::Rgba16Unorm, "rg: octahedral normal, b: roughness, a: 1 lit", 49),
        Normals::Sphere12 => (
            Format::Rgba8Unorm,
            "rgb: equal-area map of the view-space normal 12 + 12, a: roughness; rgb all zero: not lit",
            32,
        ),
        Normals::View12 => (
            Format::Rgba8Unorm,
            "rgb: view-space normal x, y 12 + 12, a: roughness; rgb all zero: not lit",
            32,
        ),
        Normals::Float => {
            (Format::Rgba32Float, "rgb: world-space normal, a: perceptual roughness; all zero: not lit", 128)
        }
    };
    Target { name: "normal_roughness", format, holds, used_bits, clear: NOTHING, tells: Tells::Surface }
}

//! What is around and between the surfaces: background and fog.

use glam::{DVec3, Vec3};
use serde::Serialize;

/// What is seen where there is no surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Background {
    /// No light.
    #[default]
    Black,
    /// A colour as it shall appear: display light in linear Rec.709, 0 to 1. Neither exposure nor tone curve nor fog change it,
    /// and it lights nothing.
    Color(Vec3),
    /// The scene's environment, blurred as little as it is stored; no light if there is none.
    Environment,
}

impl Background {
    /// The colour that is written `#RRGGBB` in sRGB; `None` for any other text.
    pub fn from_hex(text: &str) -> Option<Self> {
        let digits =
            text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
        let code = u32::from_str_radix(digits, 16).ok()?;
        let linear = |shift: u32| {
            // IEC 61966-2-1.
            let encoded = f64::from(code >> shift & 0xff) / 255.0;
            if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
        };
        Some(Self::Color(DVec3::new(linear(16), linear(8), linear(0)).as_vec3()))
    }
}

/// A medium between the surfaces and the viewer, which absorbs their light and sends some of its own, alike everywhere.
///
/// Along a way of length d through density s the share exp(-s d) of light is left (Beer and Lambert), and the rest is the
/// fog's colour. Fog lies before surfaces only: the background stays as it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fog {
    /// Radiance of fog without end, in cd/m², linear Rec.709; at least 0.
    #[serde(serialize_with = "as_list")]
    pub color_nt: Vec3,
    /// Share of light that is lost per metre (at `base_m`, if the fog has a height); above 0.
    pub density_per_m: f32,
    /// Fog that gets thinner with height; `None` is alike everywhere.
    pub height: Option<FogHeight>,
}

/// How fog depends on height: its density falls by a factor e for every `scale_m` upwards (Wenzel, "Real-time
/// Atmospheric Effects in Games", SIGGRAPH 2006 course notes, "Volumetric fog").
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FogHeight {
    /// World y where the density is the stated one, metres.
    pub base_m: f32,
    /// Metres; above 0.
    pub scale_m: f32,
}

fn as_list<S: serde::Serializer>(v: &Vec3, serializer: S) -> Result<S::Ok, S::Error> {
    v.to_array().serialize(serializer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_six_hexadecimal_digits() {
        assert_eq!(Background::from_hex("#ff0000"), Some(Background::Color(Vec3::X)));
        let Some(Background::Color(gray)) = Background::from_hex("#808080") else { panic!("a colour") };
        assert!((gray - 0.215_860_5).abs().max_element() < 1e-6);
        for wrong in ["ff0000", "#ff000", "#ff00000", "#gg0000", "#+f0000", "", "#é0000"] {
            assert_eq!(Background::from_hex(wrong), None, "{wrong}");
        }
    }
}

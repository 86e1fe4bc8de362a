//! Decals: the kinds that a scene has, what they change of a G-buffer, and how that is ordered.

use std::collections::BTreeMap;

use serde::Serialize;

use super::layout::GBuffer;
use super::{DecalWay, Form, Gamma, Limits, Needs, Options, SLOTS, SurfaceKind, element};
use crate::scene::{Decal, Scene};
use crate::{Error, Result};

/// Channels of a surface that decals paint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct Channels {
    /// Base colour.
    pub base_color: bool,
    /// Normal.
    pub normal: bool,
    /// Roughness.
    pub roughness: bool,
    /// Metallicness.
    pub metallic: bool,
}

impl Channels {
    /// What either has.
    pub const fn or(self, other: Self) -> Self {
        Self {
            base_color: self.base_color || other.base_color,
            normal: self.normal || other.normal,
            roughness: self.roughness || other.roughness,
            metallic: self.metallic || other.metallic,
        }
    }

    /// Whether some channel is of both.
    pub const fn meets(self, other: Self) -> bool {
        (self.base_color && other.base_color)
            || (self.normal && other.normal)
            || (self.roughness && other.roughness)
            || (self.metallic && other.metallic)
    }

    /// Whether colour is all there is.
    pub fn is_color_alone(self) -> bool {
        self == Self { base_color: true, ..Self::default() }
    }
}

impl std::fmt::Display for Channels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let all = [
            (self.base_color, "base colour"),
            (self.normal, "normal"),
            (self.roughness, "roughness"),
            (self.metallic, "metallic"),
        ];
        let names: Vec<_> = all.iter().filter(|(on, _)| *on).map(|(_, name)| *name).collect();
        f.write_str(&names.join(", "))
    }
}

/// What sets pipelines of decals apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct DecalKind {
    /// What it paints.
    pub channels: Channels,
    /// Bit n: the material's n-th slot of [`SLOTS`] is sampled.
    pub textures: u8,
    /// Bit n: its texture coordinates are transformed.
    pub transformed: u8,
}

impl DecalKind {
    /// Of a decal; `None` if it paints nothing.
    ///
    /// # Panics
    /// If its material is none of the scene's.
    pub fn new(scene: &Scene, decal: &Decal) -> Option<Self> {
        let material = &scene.materials[decal.material];
        let textures = decal.textures(material);
        let channels = decal.channels;
        let bits = |wanted: &dyn Fn(usize) -> bool| {
            (0..textures.len()).filter(|&slot| wanted(slot)).fold(0, |bits, slot| bits | 1 << slot)
        };
        let transforms = |slot: usize| {
            textures[slot].is_some_and(|t| t.uv_from_texcoord != crate::scene::TextureRef::IDENTITY)
        };
        decal.paints(material).then(|| Self {
            channels: Channels {
                base_color: channels.base_color > 0.0,
                normal: textures[2].is_some(),
                roughness: channels.roughness > 0.0,
                metallic: channels.metallic > 0.0,
            },
            textures: bits(&|slot| textures[slot].is_some()),
            transformed: bits(&transforms),
        })
    }

    /// The same as of a surface whose material is used like this.
    pub fn surface(&self) -> SurfaceKind {
        SurfaceKind::of_decal(self.textures, self.transformed)
    }
}

impl std::fmt::Display for DecalKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.channels)?;
        for (slot, name) in SLOTS.iter().enumerate().filter(|(slot, _)| self.textures & (1 << slot) != 0) {
            write!(f, " +{name} texture")?;
            if self.transformed & (1 << slot) != 0 {
                write!(f, " (transformed)")?;
            }
        }
        Ok(())
    }
}

/// One kind of decal, and the scene elements that need it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DecalNeed {
    /// What the pipeline must do.
    pub kind: DecalKind,
    /// How many decals are of it.
    pub decals: usize,
    /// The first of them.
    pub why: String,
}

/// The kinds of decals of a scene in which something is lit.
pub(super) fn of(scene: &Scene) -> Vec<DecalNeed> {
    let mut kinds: BTreeMap<DecalKind, DecalNeed> = BTreeMap::new();
    for (index, decal) in scene.decals.iter().enumerate() {
        let Some(kind) = DecalKind::new(scene, decal) else { continue };
        let why = || element("decal", &decal.name, index);
        kinds.entry(kind).or_insert_with(|| DecalNeed { kind, decals: 0, why: why() }).decals += 1;
    }
    kinds.into_values().collect()
}

/// What all decals paint.
pub(super) fn channels(needs: &Needs) -> Channels {
    needs.decals.iter().fold(Channels::default(), |all, need| all.or(need.kind.channels))
}

/// Whether a target of this form says where the surface is, and the channels that it holds.
pub(super) fn held(form: Form, target: &str) -> (bool, Channels) {
    let none = Channels::default();
    let color = Channels { base_color: true, metallic: true, ..none };
    let normal = Channels { normal: true, ..none };
    let roughness = Channels { roughness: true, ..none };
    match (target, form) {
        ("position", Form::Thibieroz128 | Form::Dissertation192) => (true, roughness),
        ("depth" | "position" | "position_z", _) => (true, none),
        ("normal_roughness", _) | ("normal", Form::Rasa128) => (false, normal.or(roughness)),
        ("normal" | "normal_xy", _) => (false, normal),
        // There is no room for metallicness, but for a third of the normal.
        ("base_metallic", Form::Thibieroz96) => (false, Channels { base_color: true, ..normal }),
        ("base_metallic" | "specular", _) => (false, color),
        ("words", Form::Packed128) | ("more_words", _) => (false, color.or(normal).or(roughness)),
        ("words", _) => (true, none),
        _ => (false, none),
    }
}

/// How overlapping decals are ordered, never [`DecalWay::Auto`], and why, where nobody asked for it; `None` without decals.
///
/// # Errors
/// [`Error::Unsupported`] if the way that was asked for cannot be.
pub(super) fn resolve(
    needs: &Needs,
    options: &Options,
    gbuffer: &GBuffer,
    limits: &Limits,
) -> Result<Option<(DecalWay, Option<String>)>> {
    if needs.decals.is_empty() {
        return Ok(None);
    }
    let unblended = unblended(needs, gbuffer);
    let way = match (options.decals, unblended) {
        (DecalWay::Auto, None) => {
            let why =
                "decals: fixed, since they paint base colour alone, which this layout's target can blend";
            (DecalWay::Fixed, Some(why.to_owned()))
        }
        (DecalWay::Auto, Some(problem)) => {
            let (way, device) = match limits.ordered_attachment_access {
                true => (DecalWay::RasterOrder, "the device has rasterization-order attachment access"),
                false => (
                    DecalWay::Barrier,
                    "the device has no rasterization-order attachment access, and barriers are everywhere",
                ),
            };
            (way, Some(format!("decals: {way}, since {problem}; {device}")))
        }
        (DecalWay::RasterOrder, _) if !limits.ordered_attachment_access => {
            return Err(Error::unsupported(
                "decals in raster-order need rasterization-order attachment access \
                 (VK_EXT_rasterization_order_attachment_access), which the device has not",
                "use --decals barrier or auto",
            ));
        }
        (DecalWay::Fixed, Some(problem)) => {
            let remedy = match limits.ordered_attachment_access {
                true => "use --decals raster-order, barrier or auto",
                false => "use --decals barrier or auto",
            };
            return Err(Error::unsupported(
                format!("fixed-function blending cannot paint these decals: {problem}"),
                remedy,
            ));
        }
        (asked, _) => (asked, None),
    };
    Ok(Some(way))
}

/// What decals do to light that exists before lighting, where there is any.
pub(super) fn note(needs: &Needs) -> Option<String> {
    if needs.decals.is_empty() {
        return None;
    }
    let stays: Vec<_> = needs.prelit.iter().map(String::as_str).collect();
    let around = needs.painted_around.any();
    let around = around
        .then_some("lighting adds light from all around once decals are painted, so that it follows them");
    let stays = (!stays.is_empty()).then(|| {
        format!(
            "light that exists before lighting stays that of the surface below decals: {}",
            stays.join(", ")
        )
    });
    let both: Vec<_> = around.map(str::to_owned).into_iter().chain(stays).collect();
    (!both.is_empty()).then(|| both.join("; "))
}

/// Why fixed-function blending cannot paint a scene's decals on this G-buffer, if it cannot.
fn unblended(needs: &Needs, gbuffer: &GBuffer) -> Option<String> {
    let other = needs.decals.iter().find(|need| !need.kind.channels.is_color_alone());
    if let Some(DecalNeed { kind, why, .. }) = other {
        let Channels { normal, .. } = kind.channels;
        let reason = match normal {
            true => "normals are turned about those that are there, which blending cannot read",
            false => "alpha holds what is painted, so that it cannot be the opacity",
        };
        return Some(format!("{why} paints {}, and {reason}", kind.channels));
    }
    let layout = gbuffer.layout;
    match gbuffer.form {
        Form::Specular | Form::Rasa128 => Some(format!(
            "layout {layout} stores products of base colour and metallicness, which blending cannot read"
        )),
        Form::Metallic256 | Form::Specular256 | Form::Packed128 => {
            Some(format!("layout {layout} packs base colour into words of integers"))
        }
        Form::Thibieroz96 => Some(format!(
            "layout {layout} has a third of the normal beside base colour, where it has to be read"
        )),
        Form::Metallic | Form::Thibieroz128 | Form::Dissertation192 => match gbuffer.gamma {
            Gamma::Power22 | Gamma::Power20 => Some(format!(
                "base colour is stored to the power of 1 / {}, and blending would mix powers",
                gbuffer.gamma
            )),
            Gamma::Srgb | Gamma::Linear | Gamma::Float => None,
        },
    }
}

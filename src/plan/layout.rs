//! G-buffer layouts: one table each. The GLSL side of a layout's form is the file of the form's name under `glsl/gbuffer/`.

use serde::Serialize;

use super::targets::LIGHT_WORD;
use super::{DepthStore, Format, Gamma, Layout, LightFormat, Normals, Options};
use crate::scene::Projection;
use crate::{Error, Result};

/// What a G-buffer consists of: the channels and their meaning, apart from how normals and colours are encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Depth; normal and roughness; base colour and metallicness.
    Metallic,
    /// Depth; normal and roughness; diffuse albedo; reflectance.
    Specular,
    /// Position and roughness; normal; base colour and metallicness.
    Thibieroz128,
    /// Position; normal; base colour. No roughness, no metallicness.
    Thibieroz96,
    /// Depth; two channels of a view-space normal; diffuse albedo; reflectance. Diffuse and other light apart.
    Rasa128,
    /// The same as [`Self::Thibieroz128`] in view space, all in half floats.
    Dissertation192,
    /// Eight words: position, light, normal, roughness, metallicness, base colour.
    Metallic256,
    /// Eight words: position, light, roughness, normal, diffuse albedo, reflectance.
    Specular256,
    /// Depth; two words of a surface; one of light.
    Packed128,
}

impl Form {
    /// Whether stages after geometry find where surfaces are by their depth; else a target holds positions.
    pub const fn has_depth(self) -> bool {
        matches!(self, Self::Metallic | Self::Specular | Self::Rasa128 | Self::Packed128)
    }

    /// Whether [`Normals`] says how normals are encoded; else the form has its own way.
    pub const fn has_normals(self) -> bool {
        matches!(self, Self::Metallic | Self::Specular)
    }
}

/// One attachment of a G-buffer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// The attachment's name in plans and reports, and, in capitals, in the shaders' list of targets and inputs.
    pub name: &'static str,
    /// How it is stored.
    pub format: Format,
    /// What each channel holds.
    pub holds: &'static str,
    /// Bits that carry information; the rest is padding.
    pub used_bits: u32,
    /// What pixels that no surface covers must hold; `None` where nothing reads them.
    pub clear: Option<[f32; 4]>,
    /// What a later stage than lighting may want of it.
    pub tells: Tells,
}

/// What a target says besides what lighting alone needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tells {
    /// Nothing else.
    Surface,
    /// Where the surface is.
    Position,
    /// Its diffuse albedo.
    Albedo,
}

/// Where light is kept before the tone curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LightPlace {
    /// In a target that every light is added to by fixed-function blending.
    Added {
        /// Where all lights are added at once.
        sum: LightTarget,
        /// The same where they are added one by one. Each addition is rounded, so that of many dim lights all that is below
        /// half a step would be lost.
        one_by_one: LightTarget,
        /// Whether diffuse light is summed by itself, without albedo, beside all other light.
        split: bool,
    },
    /// In the G-buffer. Geometry writes light that exists before lighting, and the stage that adds all other light reads it and
    /// applies the tone curve: nothing is blended. Lights that are added one by one are added in the shader, which reads and
    /// writes these words in the order of drawing ([`Limits::ordered_attachment_access`](super::Limits)). Each addition rounds: of
    /// a hundred equal lights half floats lose up to 3 % where the device cuts off, e5b9g9r9 4.5 %, 21 bits a channel 0.024 %.
    Read(Option<LightWord>),
    /// Nowhere: only light that one stage adds up.
    Nowhere,
}

/// Words of the G-buffer for light alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LightWord {
    /// Where all lights are added at once.
    pub once: Target,
    /// Where they are added one by one, each rounded: a shared exponent leaves 9 bits, and dim lights would be lost.
    pub one_by_one: Target,
}

/// What light is summed in before the tone curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LightTarget {
    /// The attachment.
    pub target: Target,
    /// The exposed light that is stored as 1; a normalised format clips what is above.
    pub range: f32,
}

impl LightTarget {
    /// A light target of this format.
    pub const fn new(format: LightFormat) -> Self {
        let (format, holds, used_bits, range) = match format {
            LightFormat::Rgb10a2 => {
                (Format::Rgb10a2Unorm, "rgb: exposed light / range, a: padding", 30, UNORM_LIGHT_RANGE)
            }
            LightFormat::B10g11r11 => (Format::B10g11r11Float, "rgb: exposed light", 32, 1.0),
            LightFormat::Rgba16f => (Format::Rgba16Float, "rgb: exposed light, a: padding", 48, 1.0),
            LightFormat::Rgba32f => (Format::Rgba32Float, "rgb: exposed light, a: padding", 96, 1.0),
        };
        let clear = Some([0.0; 4]);
        Self {
            target: Target { name: "light", format, holds, used_bits, clear, tells: Tells::Surface },
            range,
        }
    }

    /// Whether surfaces can be told from the background by alpha.
    pub const fn has_alpha(&self) -> bool {
        !matches!(self.target.format, Format::B10g11r11Float)
    }
}

/// Exposed light above this is clipped by a normalised light target. The neutral curve compresses all that lies
/// above it into the last 4 % of the display's range, while each doubling costs a bit in the dark.
const UNORM_LIGHT_RANGE: f32 = 2.0;

/// A layout before the user's choices.
struct Table {
    source: &'static str,
    form: Form,
    depth: DepthStore,
    normals: Normals,
    gamma: Gamma,
    light: TableLight,
}

enum TableLight {
    Added(LightFormat),
    Read,
    Nowhere,
}

const fn table(layout: Layout) -> Table {
    use TableLight::{Added, Nowhere, Read};
    let metallic128 = Table {
        source: "Smith and Einig 2015, listing 2.2",
        form: Form::Metallic,
        depth: DepthStore::R32f,
        normals: Normals::Xyz8,
        gamma: Gamma::Srgb,
        light: Added(LightFormat::Rgb10a2),
    };
    let ontile128 = Table {
        source: "octahedral normals, half-float light, depth from the depth attachment",
        depth: DepthStore::D32,
        normals: Normals::Oct12,
        light: Added(LightFormat::Rgba16f),
        ..metallic128
    };
    match layout {
        Layout::Metallic128 => metallic128,
        Layout::Specular160 => {
            Table { source: "Smith and Einig 2015, listing 2.1", form: Form::Specular, ..metallic128 }
        }
        Layout::Metallic256 => Table {
            source: "Smith and Einig 2015, listing 2.7",
            form: Form::Metallic256,
            light: Read,
            ..metallic128
        },
        Layout::Specular256 => Table {
            source: "Smith and Einig 2015, listing 2.8",
            form: Form::Specular256,
            light: Read,
            ..metallic128
        },
        Layout::Thibieroz128 => {
            Table { source: "Thibieroz 2004, \"Attribute Buffer\"", form: Form::Thibieroz128, ..metallic128 }
        }
        Layout::Thibieroz96 => Table {
            source: "Thibieroz 2004, \"Optimized MRT Configuration\"",
            form: Form::Thibieroz96,
            ..metallic128
        },
        Layout::Rasa128 => {
            Table { source: "Koonce 2007, 19.6.1 and 19.7.3", form: Form::Rasa128, ..metallic128 }
        }
        Layout::Dissertation192 => Table {
            source: "dissertation on deferred and forward shading, 4.5.1",
            form: Form::Dissertation192,
            light: Added(LightFormat::Rgba16f),
            ..metallic128
        },
        Layout::Ontile128 => ontile128,
        Layout::Ontile96 => Table {
            source: "ontile128 with a light target of 32 bits",
            light: Added(LightFormat::B10g11r11),
            ..ontile128
        },
        Layout::Ontile64 => Table { source: "ontile128 without a light target", light: Nowhere, ..ontile128 },
        Layout::Packed128 => Table {
            source: "ontile128 with bits where they count, and light that is read, not blended",
            form: Form::Packed128,
            light: Read,
            ..ontile128
        },
        Layout::Exact => Table {
            source: "all channels 32-bit floats, to tell quantisation from arithmetic",
            normals: Normals::Float,
            gamma: Gamma::Float,
            light: Added(LightFormat::Rgba32f),
            ..metallic128
        },
    }
}

/// A layout with the user's choices applied: what a pixel holds, and where.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GBuffer {
    /// Where it began.
    pub layout: Layout,
    /// The form.
    pub form: Form,
    /// Where depth is stored, for [`Form::has_depth`].
    pub depth: DepthStore,
    /// How normals are encoded, for [`Form::has_normals`].
    pub normals: Normals,
    /// How colours are encoded.
    pub gamma: Gamma,
    /// What geometry writes and lighting reads of surfaces, in order of colour outputs and of input attachment indices. A depth
    /// attachment that is read is not among them.
    pub surface: Vec<Target>,
    /// Where light is kept.
    pub light: LightPlace,
}

impl Layout {
    /// Where the layout comes from.
    pub const fn source(self) -> &'static str {
        table(self).source
    }
}

impl GBuffer {
    /// The layout of the options, with what they choose besides.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the layout has no such choice.
    pub fn new(options: &Options) -> Result<Self> {
        let Table { form, depth, normals, gamma, light, .. } = table(options.layout);
        let layout = options.layout;
        let refused = |what: &str, remedy: &str| {
            Err(Error::unsupported(format!("layout {layout} {what}"), remedy.to_owned()))
        };
        let named = "leave that out, or choose metallic128, specular160 or ontile128";
        if options.depth.is_some() && !form.has_depth() {
            return refused("stores positions, so that --depth has nothing to say", named);
        }
        if options.normals.is_some() && !form.has_normals() {
            return refused("has a fixed encoding of normals (--normals)", named);
        }
        if options.gamma.is_some() && !has_gamma(form) {
            return refused("has a fixed encoding of colours (--gamma)", named);
        }
        let light = match (light, options.light_target) {
            (TableLight::Read, None) => LightPlace::Read((form == Form::Packed128).then_some(LIGHT_WORD)),
            (TableLight::Nowhere, None) => LightPlace::Nowhere,
            (TableLight::Read | TableLight::Nowhere, Some(_)) => {
                return refused("has no light target (--light-target)", named);
            }
            (TableLight::Added(own), wanted) => {
                let sum = LightTarget::new(wanted.unwrap_or(own));
                let one_by_one = LightTarget::new(wanted.unwrap_or(match own {
                    LightFormat::Rgba32f => own,
                    _ => LightFormat::Rgba16f,
                }));
                LightPlace::Added { sum, one_by_one, split: form == Form::Rasa128 }
            }
        };
        let mut gbuffer = Self {
            layout,
            form,
            depth: options.depth.unwrap_or(depth),
            normals: options.normals.unwrap_or(normals),
            gamma: options.gamma.unwrap_or(gamma),
            surface: Vec::new(),
            light,
        };
        gbuffer.surface = gbuffer.targets();
        Ok(gbuffer)
    }

    /// Whether base colour and metallicness are stored as products: diffuse albedo and reflectance.
    pub fn has_products(&self) -> bool {
        matches!(self.form, Form::Specular | Form::Rasa128 | Form::Specular256)
    }

    /// The `exact` layout.
    pub fn exact() -> Self {
        let options = Options { layout: Layout::Exact, ..Options::default() };
        Self::new(&options).expect("it is complete without choices")
    }

    /// The same with a light target over which surfaces can be blended: where light is in words, or nowhere, half floats. Each
    /// layer is rounded, so that a target is the one for lights that are added one by one: 10 bits would be cut off at 2 and
    /// band with every layer.
    pub(super) fn for_blending(self) -> Self {
        let (light, split) =
            self.added_light(true).unwrap_or((LightTarget::new(LightFormat::Rgba16f), false));
        Self { light: LightPlace::Added { sum: light, one_by_one: light, split }, ..self }
    }

    /// Whether its targets are words, four in each.
    pub(super) fn has_four_words(&self) -> bool {
        self.surface.iter().any(|target| target.format == Format::Rgba32Uint)
    }

    /// Whether later stages read the depth attachment itself.
    pub fn reads_depth_attachment(&self) -> bool {
        self.form.has_depth() && self.depth != DepthStore::R32f
    }

    /// Distance along the view axis beyond which stored places mean nothing, metres: fixed-point depth is 0 there, which is the
    /// background's, and half floats end. `None` has no such end.
    pub fn farthest_m(&self, projection: &Projection) -> Option<f32> {
        const MOST_HALF_M: f32 = 65504.0;
        let bits = match self.depth {
            _ if !self.form.has_depth() => return (!self.surface_is_exact()).then_some(MOST_HALF_M),
            DepthStore::R32f | DepthStore::D32 => return None,
            DepthStore::D24 => 24,
            DepthStore::D16 => 16,
        };
        match *projection {
            // Reversed depth is near / distance: half a code above 0.
            Projection::Perspective { znear_m, zfar_m: None, .. } => {
                Some(znear_m * (2.0 * ((1_u32 << bits) - 1) as f32))
            }
            _ => None,
        }
    }

    /// Whether positions are stored in 32-bit floats.
    fn surface_is_exact(&self) -> bool {
        matches!(self.form, Form::Metallic256 | Form::Specular256)
    }

    /// Bits of colour a pixel that its surface targets have.
    pub fn surface_bits(&self) -> u32 {
        self.surface.iter().map(|t| t.format.bits()).sum()
    }

    /// What light is added to by blending, all lights at once or one by one, and whether diffuse light apart.
    pub(super) fn added_light(&self, one_by_one: bool) -> Option<(LightTarget, bool)> {
        match self.light {
            LightPlace::Added { sum, one_by_one: each, split } => {
                Some((if one_by_one { each } else { sum }, split))
            }
            LightPlace::Read(_) | LightPlace::Nowhere => None,
        }
    }
}

const fn has_gamma(form: Form) -> bool {
    matches!(form, Form::Metallic | Form::Specular | Form::Thibieroz128 | Form::Thibieroz96 | Form::Rasa128)
}

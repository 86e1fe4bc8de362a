//! What the last stage writes in place of the picture: the G-buffer as lighting reads it, how many lights there are, edges. The pass
//! stays one: geometry is that of the picture, and what comes after it is replaced.

use serde::{Deserialize, Serialize};

use super::layout::{Form, GBuffer, LightPlace};
use super::names::named_enum;
use super::{BloomWay, Edges, Needs, Normals, Options, Path, ShadowNeeds};
use crate::{Error, Result};

named_enum! {
    /// What is shown. Pixels without a lit surface are black, and blended surfaces, particles, shadows and fog are left out.
    ///
    /// An output of floats gets the values themselves. In one of bytes colours and light look as light does, and each byte of a
    /// number `x` from 0 to 1 is `255 x`.
    #[derive(Default)]
    Show {
        /// The picture.
        #[default]
        Picture = "picture",
        /// Base colour, linear Rec.709, of layouts that store it.
        BaseColor = "base-color",
        /// Metallicness, likewise.
        Metallic = "metallic",
        /// Diffuse albedo, linear Rec.709: stored, or what lighting makes of base colour and metallicness.
        Diffuse = "diffuse",
        /// Reflectance at normal incidence, likewise.
        Reflectance = "reflectance",
        /// The shading normal, world space; in bytes `n / 2 + 1/2`.
        Normal = "normal",
        /// Perceptual roughness.
        Roughness = "roughness",
        /// Metres along the view axis, 0 where nothing is; in bytes `1 / (1 + sqrt(metres))`.
        Depth = "depth",
        /// The share of light from all around that arrives, where decals have lighting add that light.
        Occlusion = "occlusion",
        /// Exposed light that exists before lighting: emission, light from all around, unlit surfaces. In bytes after the tone curve.
        Light = "light",
        /// All that the layout holds of these, side by side: each strip shows its part of the view. (A pixel of the tile is read where it
        /// is, so that pictures cannot be made smaller in the pass.)
        Channels = "channels",
        /// How many lights are evaluated: with clusters those of the pixel's cell, else those that reach the surface; in bytes
        /// [`heat`].
        Lights = "lights",
        /// 1 where the stencil says that a pixel is lit sample by sample, else 0.
        Edges = "edges",
    }
}

/// The name of the stage.
pub const NAME: &str = "show";

impl Show {
    /// The quantities of the G-buffer, in the order of strips.
    pub const CHANNELS: [Self; 9] = [
        Self::BaseColor,
        Self::Metallic,
        Self::Diffuse,
        Self::Reflectance,
        Self::Normal,
        Self::Roughness,
        Self::Depth,
        Self::Occlusion,
        Self::Light,
    ];

    /// Whether it is not the picture.
    pub fn is_debug(self) -> bool {
        self != Self::Picture
    }
}

/// Lights of the legend's end: 2^6 - 1.
const HEAT_DOUBLINGS: f64 = 6.0;

/// The colour that says how many lights there are, as bytes / 255: six steps, evenly over the logarithm of one more than their number,
/// to 63 lights. glsl/show.frag has the same.
pub fn heat(lights: u32) -> [f64; 3] {
    const STEPS: [[f64; 3]; 6] =
        [[0.0; 3], [0.1, 0.2, 0.8], [0.0, 0.7, 0.6], [0.9, 0.9, 0.1], [0.9, 0.2, 0.1], [1.0; 3]];
    let at = ((1.0 + f64::from(lights)).log2() * 5.0 / HEAT_DOUBLINGS).min(5.0);
    let index = (at as usize).min(4);
    let part = at - index as f64;
    std::array::from_fn(|c| STEPS[index][c] + (STEPS[index + 1][c] - STEPS[index][c]) * part)
}

impl Needs {
    /// What is left of them when this is shown: geometry and decals.
    pub(crate) fn shown(self, show: Show) -> Self {
        if !show.is_debug() {
            return self;
        }
        let mut needs = Self {
            triangles: self.opaque_triangles(),
            blended: None,
            blended_triangles: 0,
            transmits: None,
            refracts: None,
            particles: Vec::new(),
            shadows: ShadowNeeds::default(),
            fog: None,
            background: None,
            ..self
        };
        needs.kinds.retain(|need| !need.kind.blend);
        needs
    }
}

/// # Errors
/// [`Error::Unsupported`] where there is no such thing to show.
pub(super) fn check(
    needs: &Needs,
    options: &Options,
    gbuffer: &GBuffer,
    (path, edges): (Path, Edges),
    folded: bool,
) -> Result<()> {
    let show = options.show;
    let refused = |problem: String, remedy: &str| Err(Error::unsupported(problem, remedy.to_owned()));
    if !show.is_debug() {
        return Ok(());
    }
    if options.bloom != BloomWay::Off || options.edge_filter {
        let problem =
            format!("--show {show} makes no picture that passes after the frame's own could work on");
        return refused(problem, "leave --bloom and --edge-filter out, or --show");
    }
    if needs.lit_opaque.is_none() {
        let problem =
            format!("--show {show} reads the G-buffer, and the scene has no surface that is lit and opaque");
        return refused(problem, "leave --show out");
    }
    if path != Path::Deferred {
        let problem = format!("--show {show} reads the G-buffer, which the path {path} has not");
        return refused(problem, "use --path deferred");
    }
    let layout = options.layout;
    let kept = held(needs, gbuffer, folded);
    match show {
        Show::Lights if needs.listed_lights() == 0 => {
            let problem = "the scene has no lights to count".to_owned();
            refused(problem, "leave --show lights out")
        }
        Show::Edges if edges == Edges::All => {
            let problem = match options.samples {
                1 => "with 1 sample a pixel there are no edges to mark".to_owned(),
                _ => "edges are not marked where every sample is lit".to_owned(),
            };
            refused(problem, "use --samples 4, and leave --edges all out")
        }
        Show::Light if !kept.contains(&show) => {
            let problem = "no light exists before lighting, or the layout has no place for it".to_owned();
            refused(problem, "leave --show light out, or use --no-fold with a layout that has a light target")
        }
        Show::Occlusion if !kept.contains(&show) => {
            let problem =
                "the G-buffer holds no occlusion: it does where decals are painted over what is occluded"
                    .to_owned();
            refused(problem, "leave --show occlusion out: it is in --show light")
        }
        show if Show::CHANNELS.contains(&show) && !kept.contains(&show) => {
            let problem = format!("layout {layout} does not store {show}");
            let remedy = match show {
                Show::BaseColor | Show::Metallic if gbuffer.has_products() => {
                    "use --show diffuse or reflectance, or another --layout"
                }
                _ => "use another --layout",
            };
            refused(problem, remedy)
        }
        _ => Ok(()),
    }
}

/// What the G-buffer holds.
pub(super) fn held(needs: &Needs, gbuffer: &GBuffer, folded: bool) -> Vec<Show> {
    let has_light = match gbuffer.light {
        LightPlace::Added { .. } => !folded,
        LightPlace::Read(_) => !needs.prelit.is_empty(),
        LightPlace::Nowhere => false,
    };
    let is_held = |show: &&Show| match show {
        Show::BaseColor => !gbuffer.has_products(),
        Show::Metallic => !gbuffer.has_products() && gbuffer.form != Form::Thibieroz96,
        Show::Roughness | Show::Reflectance => gbuffer.form != Form::Thibieroz96,
        Show::Occlusion => needs.occlusion.is_some(),
        Show::Light => has_light,
        _ => true,
    };
    Show::CHANNELS.iter().filter(is_held).copied().collect()
}

/// Those of which a strip is shown: not what lighting makes of others.
pub fn strips(needs: &Needs, gbuffer: &GBuffer, folded: bool) -> Vec<Show> {
    let mut strips = held(needs, gbuffer, folded);
    if !gbuffer.has_products() {
        strips.retain(|show| !matches!(show, Show::Diffuse | Show::Reflectance));
    }
    strips
}

/// The G-buffer's targets that tell of it, by name.
pub(super) fn told_by(show: Show, needs: &Needs, gbuffer: &GBuffer, folded: bool) -> Vec<&'static str> {
    let form = gbuffer.form;
    let all_words = || vec!["words", "more_words"];
    // What says whether a surface is lit, which is where normals are.
    let lit = match form {
        Form::Metallic | Form::Specular => vec!["normal_roughness"],
        Form::Thibieroz128 | Form::Rasa128 | Form::Dissertation192 => vec!["normal"],
        Form::Thibieroz96 => vec!["base_metallic", "normal_xy"],
        Form::Metallic256 | Form::Specular256 => vec!["more_words"],
        Form::Packed128 => vec!["words"],
    };
    let position = match form {
        Form::Thibieroz128 | Form::Dissertation192 => vec!["position"],
        Form::Thibieroz96 => vec!["position", "position_z"],
        Form::Metallic256 | Form::Specular256 => vec!["words"],
        _ => vec!["depth"],
    };
    let color = match form {
        Form::Metallic256 | Form::Specular256 | Form::Packed128 => Vec::new(),
        _ => vec!["base_metallic"],
    };
    let more = match show {
        Show::Picture | Show::Edges => return Vec::new(),
        Show::BaseColor | Show::Metallic | Show::Diffuse => color,
        Show::Reflectance if matches!(form, Form::Specular | Form::Rasa128) => vec!["specular"],
        Show::Reflectance => color,
        Show::Normal => Vec::new(),
        Show::Roughness if matches!(form, Form::Thibieroz128 | Form::Dissertation192) => vec!["position"],
        Show::Roughness => Vec::new(),
        Show::Depth if form.has_depth() => return position,
        Show::Depth => position,
        Show::Occlusion => vec!["occlusion"],
        Show::Light => {
            return match gbuffer.light {
                LightPlace::Added { split: true, .. } => vec!["specular_light"],
                LightPlace::Added { .. } => vec!["light"],
                LightPlace::Read(Some(_)) => vec!["light_word"],
                _ => all_words(),
            };
        }
        Show::Lights if needs.local_lights() > 0 => position,
        Show::Lights => Vec::new(),
        Show::Channels => {
            let strips = strips(needs, gbuffer, folded);
            return strips.iter().flat_map(|&show| told_by(show, needs, gbuffer, folded)).collect();
        }
    };
    lit.into_iter().chain(more).collect()
}

/// Whether showing it takes the camera.
pub fn reads_frame(show: Show, gbuffer: &GBuffer) -> bool {
    match show {
        Show::Normal => match gbuffer.form {
            Form::Rasa128 | Form::Dissertation192 => true,
            form => form.has_normals() && matches!(gbuffer.normals, Normals::Sphere12 | Normals::View12),
        },
        Show::Depth | Show::Light | Show::Lights | Show::Channels => true,
        _ => false,
    }
}

/// What it leaves out, and what each strip is.
pub(super) fn note(needs: &Needs, options: &Options, gbuffer: &GBuffer, folded: bool) -> Option<String> {
    let show = options.show;
    let strips =
        || strips(needs, gbuffer, folded).iter().map(|show| show.name()).collect::<Vec<_>>().join(", ");
    let what = match show {
        Show::Picture => return None,
        Show::Channels => format!("{show}, from the left: {}", strips()),
        _ => show.to_string(),
    };
    Some(format!(
        "show: {what}; written in the pass in place of the picture, of opaque surfaces as geometry and decals leave them"
    ))
}

//! Shader modules: which exist, what they are compiled from, and their SPIR-V.
//!
//! [`Module::all`] is the one list. `tools/shaders` compiles it into `glsl/spirv/`, this module embeds the result,
//! and a test compares the two.

mod prune;
mod specialization;

pub use prune::prune;
pub use specialization::{
    GeometryConstants, LightingConstants, OutputConstants, Specialization, TextureSlot,
};

use crate::plan::{Around, Layout};
use crate::{Error, Result};

/// The number that `glsl/shared.h` defines for `name`; call it in a `const`, so that a missing name does not compile.
///
/// # Panics
/// If the header has no line `#define name NUMBER`.
pub const fn shared(name: &str) -> u32 {
    let (text, name) = (include_str!("../../glsl/shared.h").as_bytes(), name.as_bytes());
    let mut line = 0;
    while line < text.len() {
        if let Some(at) = skip(text, line, b"#define ")
            && let Some(at) = skip(text, at, name)
            && let Some(mut at) = skip(text, at, b" ")
        {
            let mut number = 0;
            assert!(at < text.len() && text[at].is_ascii_digit(), "shared.h: not a number");
            while at < text.len() && text[at].is_ascii_digit() {
                number = number * 10 + (text[at] - b'0') as u32;
                at += 1;
            }
            return number;
        }
        while line < text.len() && text[line] != b'\n' {
            line += 1;
        }
        line += 1;
    }
    panic!("shared.h does not define this name")
}

/// Where `text` goes on after `prefix` at `at`.
const fn skip(text: &[u8], at: usize, prefix: &[u8]) -> Option<usize> {
    let mut i = 0;
    while i < prefix.len() {
        if at + i >= text.len() || text[at + i] != prefix[i] {
            return None;
        }
        i += 1;
    }
    Some(at + i)
}

/// How many kinds of texture a material can have; their order is that of `KIND_*` in `glsl/shared.h`.
pub const KIND_COUNT: usize = shared("KIND_COUNT") as usize;

/// A pipeline stage that has shader modules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Vertex shader.
    Vertex,
    /// Fragment shader.
    Fragment,
}

/// A shader module, by what sets it apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Module {
    /// Places a mesh that has these attributes besides positions. A tangent needs a normal and a texcoord.
    GeometryVertex {
        /// Normals.
        normal: bool,
        /// One or two texture coordinates.
        texcoord: bool,
        /// Tangents.
        tangent: bool,
        /// Vertex colours.
        color: bool,
    },
    /// Writes the G-buffer.
    GeometryFragment {
        /// How the G-buffer is laid out.
        layout: Layout,
        /// Whether the light target is written too.
        light_target: bool,
        /// Whether the material has any texture.
        textured: bool,
        /// What arrives from all around; nothing without a light target.
        around: Around,
    },
    /// Writes the output directly, where nothing is lit.
    Unlit {
        /// Whether the material has any texture.
        textured: bool,
    },
    /// Lights a surface as it is drawn and writes the output.
    Forward {
        /// Whether the material has any texture.
        textured: bool,
        /// What it reads of the lights.
        lights: LightInputs,
        /// What arrives from all around.
        around: Around,
    },
    /// Writes the light that leaves a surface without light sources to the light target.
    Base {
        /// Whether the material has any texture.
        textured: bool,
        /// What arrives from all around.
        around: Around,
    },
    /// Adds what a surface reflects of one light to the light target.
    Light {
        /// Whether the material has any texture.
        textured: bool,
        /// What it reads of the light.
        lights: LightInputs,
    },
    /// Keeps nothing of a surface but what its alpha mask leaves.
    Mask {
        /// Whether the material has any texture.
        textured: bool,
    },
    /// Shades the G-buffer by punctual lights.
    Lighting {
        /// How the G-buffer is laid out.
        layout: Layout,
        /// What it reads of the lights.
        lights: LightInputs,
    },
    /// Turns the light target into the output.
    Tonemap {
        /// Whether fog lies between, so that depth is read too.
        fog: bool,
    },
    /// One triangle over the whole image.
    Fullscreen,
    /// A mesh around what a light reaches.
    LightVolume,
    /// Places a caster in the shadow map. Coordinates and colours are for masks only.
    ShadowVertex {
        /// Whether an alpha mask cuts the surface.
        masked: bool,
        /// Texture coordinates.
        texcoord: bool,
        /// Vertex colours.
        color: bool,
    },
}

/// The lights that a pixel looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightLoop {
    /// All.
    All,
    /// Those that shine everywhere and those in the list of its cluster.
    Cluster,
    /// The one that is drawn.
    One,
}

/// What shading reads of the lights: descriptors that exist only where they are needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightInputs {
    /// Which lights a pixel looks at.
    pub scan: LightLoop,
    /// Whether they cast shadows.
    pub shadows: bool,
    /// Whether some shine through globe maps.
    pub globe_maps: bool,
}

impl LightInputs {
    /// Without and with each kind of map, for each of these.
    fn of(loops: &[LightLoop]) -> impl Iterator<Item = Self> {
        let maps = [(false, false), (true, false), (false, true), (true, true)];
        let of = move |&scan| maps.map(|(shadows, globe_maps)| Self { scan, shadows, globe_maps });
        loops.iter().flat_map(of)
    }

    /// Its part of a module's name.
    fn suffix(self) -> String {
        let scan = match self.scan {
            LightLoop::All => "",
            LightLoop::Cluster => "_clusters",
            LightLoop::One => "_one",
        };
        let suffix = |has: bool, text: &'static str| if has { text } else { "" };
        format!("{scan}{}{}", suffix(self.shadows, "_shadows"), suffix(self.globe_maps, "_globes"))
    }

    /// Macros, and whether they are defined.
    fn defines(self) -> [(bool, &'static str); 4] {
        [
            (self.scan == LightLoop::Cluster, "CLUSTERS"),
            (self.scan == LightLoop::One, "ONE_LIGHT"),
            (self.shadows, "SHADOWS"),
            (self.globe_maps, "GLOBE_MAPS"),
        ]
    }
}

/// Every kind.
const AROUND: [Around; 3] = [Around::Nothing, Around::Ambient, Around::Environment];

fn around_suffix(around: Around) -> &'static str {
    match around {
        Around::Nothing => "",
        Around::Ambient => "_ambient",
        Around::Environment => "_environment",
    }
}

impl Module {
    /// Every module that exists.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for attributes in 0..16 {
            let has = |bit: u32| attributes >> bit & 1 == 1;
            let (normal, texcoord, tangent, color) = (has(0), has(1), has(2), has(3));
            if !tangent || (normal && texcoord) {
                all.push(Self::GeometryVertex { normal, texcoord, tangent, color });
            }
        }
        for &layout in Layout::ALL {
            for textured in [false, true] {
                let module =
                    |light_target, around| Self::GeometryFragment { layout, light_target, textured, around };
                all.push(module(false, Around::Nothing));
                all.extend(AROUND.map(|around| module(true, around)));
            }
            let loops = [LightLoop::All, LightLoop::Cluster, LightLoop::One];
            all.extend(LightInputs::of(&loops).map(|lights| Self::Lighting { layout, lights }));
        }
        for textured in [false, true] {
            all.push(Self::Unlit { textured });
            for lights in LightInputs::of(&[LightLoop::All, LightLoop::Cluster]) {
                all.extend(AROUND.map(|around| Self::Forward { textured, lights, around }));
            }
        }
        for textured in [false, true] {
            all.extend(AROUND.map(|around| Self::Base { textured, around }));
            all.extend(LightInputs::of(&[LightLoop::One]).map(|lights| Self::Light { textured, lights }));
            all.push(Self::Mask { textured });
        }
        all.extend([false, true].map(|fog| Self::Tonemap { fog }));
        all.extend([Self::Fullscreen, Self::LightVolume]);
        for (masked, texcoord, color) in
            [(false, false, false), (true, true, false), (true, false, true), (true, true, true)]
        {
            all.push(Self::ShadowVertex { masked, texcoord, color });
        }
        all
    }

    /// A name that no other module has: that of its SPIR-V file, without `.spv`.
    pub fn name(self) -> String {
        let suffix = |has: bool, text: &'static str| if has { text } else { "" };
        match self {
            Self::GeometryVertex { normal: false, texcoord: false, tangent: false, color: false } => {
                "geometry_p.vert".into()
            }
            Self::GeometryVertex { normal, texcoord, tangent, color } => format!(
                "geometry_{}{}{}{}.vert",
                suffix(normal, "n"),
                suffix(texcoord, "u"),
                suffix(tangent, "t"),
                suffix(color, "c"),
            ),
            Self::GeometryFragment { layout, light_target, textured, around } => format!(
                "geometry_{layout}{}{}{}.frag",
                suffix(light_target, "_light"),
                suffix(textured, "_textured"),
                around_suffix(around),
            ),
            Self::Unlit { textured } => format!("unlit{}.frag", suffix(textured, "_textured")),
            Self::Base { textured, around } => {
                format!("base{}{}.frag", suffix(textured, "_textured"), around_suffix(around))
            }
            Self::Light { textured, lights } => {
                format!("light{}{}.frag", suffix(textured, "_textured"), lights.suffix())
            }
            Self::Mask { textured } => format!("mask{}.frag", suffix(textured, "_textured")),
            Self::Forward { textured, lights, around } => {
                let (lights, textured) = (lights.suffix(), suffix(textured, "_textured"));
                format!("forward{lights}{textured}{}.frag", around_suffix(around))
            }
            Self::Lighting { layout, lights } => format!("lighting_{layout}{}.frag", lights.suffix()),
            Self::ShadowVertex { masked: false, .. } => "shadow.vert".into(),
            Self::ShadowVertex { texcoord, color, .. } => {
                format!("shadow_masked_{}{}.vert", suffix(texcoord, "u"), suffix(color, "c"))
            }
            Self::Tonemap { fog } => format!("tonemap{}.frag", suffix(fog, "_fog")),
            Self::Fullscreen => "fullscreen.vert".into(),
            Self::LightVolume => "light_volume.vert".into(),
        }
    }

    /// The GLSL file that it is compiled from, relative to `glsl/`.
    pub fn source(self) -> &'static str {
        match self {
            Self::GeometryVertex { .. } => "geometry.vert",
            Self::GeometryFragment { .. } => "geometry.frag",
            Self::Unlit { .. } => "unlit.frag",
            Self::Forward { .. } => "forward.frag",
            Self::Base { .. } => "base.frag",
            Self::Light { .. } => "light.frag",
            Self::Mask { .. } => "mask.frag",
            Self::Lighting { .. } => "lighting.frag",
            Self::Tonemap { .. } => "tonemap.frag",
            Self::Fullscreen => "fullscreen.vert",
            Self::ShadowVertex { .. } => "shadow.vert",
            Self::LightVolume => "light_volume.vert",
        }
    }

    /// The stage that it is for.
    pub fn stage(self) -> Stage {
        match self {
            Self::GeometryVertex { .. }
            | Self::Fullscreen
            | Self::LightVolume
            | Self::ShadowVertex { .. } => Stage::Vertex,
            Self::GeometryFragment { .. }
            | Self::Unlit { .. }
            | Self::Forward { .. }
            | Self::Base { .. }
            | Self::Light { .. }
            | Self::Mask { .. }
            | Self::Lighting { .. }
            | Self::Tonemap { .. } => Stage::Fragment,
        }
    }

    /// The macros that are defined when it is compiled.
    pub fn defines(self) -> Vec<&'static str> {
        let layout_define = |layout| match layout {
            Layout::Metallic128 => "LAYOUT_METALLIC128",
            Layout::Exact => "LAYOUT_EXACT",
        };
        let chosen = |defines: &[(bool, &'static str)]| {
            defines.iter().filter(|(wanted, _)| *wanted).map(|(_, define)| *define).collect()
        };
        match self {
            Self::GeometryVertex { normal, texcoord, tangent, color } => chosen(&[
                (normal, "HAS_NORMAL"),
                (texcoord, "HAS_TEXCOORD"),
                (tangent, "HAS_TANGENT"),
                (color, "HAS_COLOR"),
            ]),
            Self::GeometryFragment { layout, light_target, textured, around } => chosen(&[
                (true, layout_define(layout)),
                (light_target, "LIGHT_TARGET"),
                (textured, "TEXTURED"),
                (around >= Around::Ambient, "AMBIENT"),
                (around >= Around::Environment, "ENVIRONMENT"),
            ]),
            Self::Unlit { textured } | Self::Mask { textured } => chosen(&[(textured, "TEXTURED")]),
            Self::Light { textured, lights } => {
                chosen(&[&[(textured, "TEXTURED")][..], &lights.defines()].concat())
            }
            Self::Base { textured, around } => chosen(&[
                (textured, "TEXTURED"),
                (around >= Around::Ambient, "AMBIENT"),
                (around >= Around::Environment, "ENVIRONMENT"),
            ]),
            Self::Forward { textured, lights, around } => {
                let surface = [
                    (textured, "TEXTURED"),
                    (around >= Around::Ambient, "AMBIENT"),
                    (around >= Around::Environment, "ENVIRONMENT"),
                ];
                chosen(&[&surface[..], &lights.defines()].concat())
            }
            Self::Lighting { layout, lights } => {
                chosen(&[&[(true, layout_define(layout))][..], &lights.defines()].concat())
            }
            Self::ShadowVertex { masked, texcoord, color } => {
                chosen(&[(masked, "MASKED"), (texcoord, "HAS_TEXCOORD"), (color, "HAS_COLOR")])
            }
            Self::Tonemap { fog } => chosen(&[(fog, "WITH_FOG")]),
            Self::Fullscreen | Self::LightVolume => Vec::new(),
        }
    }

    /// The compiled module; its entry point is `main`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a key that [`Self::all`] does not list, and for a module that was not compiled.
    pub fn spirv(self) -> Result<&'static [u32]> {
        let name = self.name();
        let (_, module) = EMBEDDED.iter().find(|(embedded, _)| *embedded == name).ok_or_else(|| {
            Error::unsupported(
                format!("there is no shader module '{name}'"),
                "add it to Module::all and run ./tools/shaders",
            )
        })?;
        Ok(bytemuck::cast_slice(&module.0))
    }
}

/// The names of the modules that this build embeds.
pub fn embedded_names() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().map(|(name, _)| *name)
}

/// Bytes where words may stand.
#[repr(C, align(4))]
struct Aligned<B: ?Sized>(B);

macro_rules! embed {
    ($($name:literal),* $(,)?) => {
        &[$((
            $name,
            &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/glsl/spirv/", $name, ".spv"))),
        )),*]
    };
}

static EMBEDDED: &[(&str, &Aligned<[u8]>)] = include!("../../glsl/spirv/modules.rs");

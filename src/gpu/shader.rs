//! Shader modules: which exist, what they are compiled from, and their SPIR-V.
//!
//! [`Module::ALL`] is the one list. `tools/shaders` compiles it into `glsl/spirv/`, this module embeds the result,
//! and a test compares the two.

mod collected;
#[cfg(feature = "shader-compiler")]
mod compile;
mod declared;
mod modules;
mod numbers;
mod places;
mod post_constants;
mod prune;
mod show_constants;
mod specialization;

#[cfg(feature = "shader-compiler")]
pub use compile::{Compiled, compile};
pub(in crate::gpu) use declared::declared;
pub use modules::Modules;
pub use numbers::{shared, shared_names};
pub use places::AttachmentPlaces;
pub use prune::{Pruned, prune};
pub use specialization::{
    DecalConstants, GBufferConstants, GeometryConstants, LightLoop, LightingConstants, LightmapConstants,
    OutputConstants, SampleConstants, SkyConstants, Specialization, TextureSlot,
};

use std::collections::BTreeSet;

use crate::{Error, Result};

/// How many kinds of texture a material can have; their order is that of `KIND_*` in `glsl/shared.h`.
pub const KIND_COUNT: usize = shared("KIND_COUNT") as usize;

/// A pipeline stage that has shader modules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Vertex shader.
    Vertex,
    /// Fragment shader.
    Fragment,
    /// Compute shader.
    Compute,
}

/// A shader module: one source each. All that sets pipelines apart are specialisation constants, G-buffer layouts included: what
/// a constant leaves without use, targets and inputs too, is removed (`prune`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Module {
    /// Places a mesh.
    GeometryVertex,
    /// Writes the G-buffer.
    GeometryFragment,
    /// Writes the output directly, where nothing is lit.
    Unlit,
    /// Lights a surface as it is drawn and writes the output.
    Forward,
    /// Writes the light that leaves a surface without light sources to the light target.
    Base,
    /// Adds what a surface reflects of one light to the light target.
    Light,
    /// Keeps nothing of a surface but what its alpha mask leaves.
    Mask,
    /// Shades the G-buffer by punctual lights.
    Lighting,
    /// Turns the light target into the output.
    Tonemap,
    /// Marks pixels that are lit sample by sample.
    Edges,
    /// [`Self::Lighting`] of several samples a pixel.
    LightingSamples,
    /// [`Self::Tonemap`] of several samples a pixel.
    TonemapSamples,
    /// Draws the environment where no surface is, and says "not lit" in the G-buffer where there is one.
    Sky,
    /// One triangle over the whole image.
    Fullscreen,
    /// A mesh around what a light reaches.
    LightVolume,
    /// Places a caster in the shadow map.
    ShadowVertex,
    /// Copies a tile of one shadow map to another.
    ShadowCompose,
    /// The box of a decal.
    DecalVertex,
    /// Paints a decal over the G-buffer.
    Decal,
    /// [`Self::Decal`] of several samples a pixel.
    DecalSamples,
    /// Lays fog over surfaces of the G-buffer.
    Fog,
    /// Keeps blended surfaces that are before the last layer.
    Peel,
    /// Lays what was collected of blended surfaces over the light.
    Composite,
    /// [`Self::Fog`] of several samples a pixel.
    FogSamples,
    /// [`Self::Peel`] of several samples a pixel.
    PeelSamples,
    /// [`Self::Composite`] of several samples a pixel.
    CompositeSamples,
    /// [`Self::Forward`] of several samples a pixel, each with layers of its own.
    ForwardSamples,
    /// Spreads light.
    Bloom,
    /// Smooths edges.
    EdgeFilter,
    /// The space behind what faces a light: its walls and far ends.
    ShadowVolumeVertex,
    /// Its near ends.
    ShadowNearEndsVertex,
    /// The square of a particle.
    ParticleVertex,
    /// Multiplies what is behind a surface that light goes through, or adds its own light.
    Medium,
    /// [`Self::Medium`] of several samples a pixel.
    MediumSamples,
    /// Copies what media sample to where they are drawn.
    Backdrop,
    /// [`Self::Backdrop`] of several samples a pixel.
    BackdropSamples,
    /// Adds a particle's light.
    Particle,
    /// [`Self::Particle`] of several samples a pixel.
    ParticleSamples,
    /// Places triangles over the picture.
    OverlayVertex,
    /// Draws them.
    Overlay,
    /// Poses a mesh.
    Pose,
    /// Writes what the G-buffer holds in place of the picture.
    Show,
    /// [`Self::Show`] of several samples a pixel.
    ShowSamples,
    /// Writes how far the picture is from another one.
    Difference,
}

impl Module {
    /// Every module that exists.
    pub const ALL: [Self; 44] = [
        Self::GeometryVertex,
        Self::ShadowVertex,
        Self::LightVolume,
        Self::Fullscreen,
        Self::Unlit,
        Self::Forward,
        Self::Base,
        Self::Light,
        Self::Mask,
        Self::Sky,
        Self::GeometryFragment,
        Self::Lighting,
        Self::Tonemap,
        Self::ShadowCompose,
        Self::Bloom,
        Self::EdgeFilter,
        Self::ShadowVolumeVertex,
        Self::ShadowNearEndsVertex,
        Self::LightingSamples,
        Self::TonemapSamples,
        Self::Edges,
        Self::Fog,
        Self::Peel,
        Self::Composite,
        Self::FogSamples,
        Self::DecalVertex,
        Self::Decal,
        Self::DecalSamples,
        Self::ParticleVertex,
        Self::Medium,
        Self::MediumSamples,
        Self::Particle,
        Self::ParticleSamples,
        Self::PeelSamples,
        Self::CompositeSamples,
        Self::ForwardSamples,
        Self::Backdrop,
        Self::OverlayVertex,
        Self::Overlay,
        Self::Pose,
        Self::BackdropSamples,
        Self::Show,
        Self::ShowSamples,
        Self::Difference,
    ];

    /// The GLSL file that it is compiled from, relative to `glsl/`.
    pub fn source(self) -> &'static str {
        match self {
            Self::GeometryVertex => "geometry.vert",
            Self::GeometryFragment => "geometry.frag",
            Self::Unlit => "unlit.frag",
            Self::Forward | Self::ForwardSamples => "forward.frag",
            Self::Base => "base.frag",
            Self::Light => "light.frag",
            Self::Mask => "mask.frag",
            Self::Lighting | Self::LightingSamples => "lighting.frag",
            Self::Tonemap | Self::TonemapSamples => "tonemap.frag",
            Self::Sky => "sky.frag",
            Self::Edges => "edges.frag",
            Self::Fullscreen => "fullscreen.vert",
            Self::LightVolume => "light_volume.vert",
            Self::ShadowVertex => "shadow.vert",
            Self::ShadowCompose => "shadow_compose.frag",
            Self::DecalVertex => "decal.vert",
            Self::Decal | Self::DecalSamples => "decal.frag",
            Self::Fog | Self::FogSamples => "fog.frag",
            Self::Peel | Self::PeelSamples => "peel.frag",
            Self::Composite | Self::CompositeSamples => "composite.frag",
            Self::Bloom => "bloom.frag",
            Self::Backdrop | Self::BackdropSamples => "backdrop.frag",
            Self::EdgeFilter => "edge_filter.frag",
            Self::ShadowVolumeVertex | Self::ShadowNearEndsVertex => "shadow_volume.vert",
            Self::ParticleVertex => "particle.vert",
            Self::Medium | Self::MediumSamples => "medium.frag",
            Self::Particle | Self::ParticleSamples => "particle.frag",
            Self::OverlayVertex => "overlay.vert",
            Self::Overlay => "overlay.frag",
            Self::Pose => "pose.comp",
            Self::Show | Self::ShowSamples => "show.frag",
            Self::Difference => "difference.frag",
        }
    }

    /// Its name, which no other module has: that of its source or, where it is compiled from that in another way, beside it.
    pub fn name(self) -> &'static str {
        match self {
            Self::ShadowNearEndsVertex => "shadow_near_ends.vert",
            Self::LightingSamples => "lighting_samples.frag",
            Self::TonemapSamples => "tonemap_samples.frag",
            Self::DecalSamples => "decal_samples.frag",
            Self::FogSamples => "fog_samples.frag",
            Self::ParticleSamples => "particle_samples.frag",
            Self::MediumSamples => "medium_samples.frag",
            Self::PeelSamples => "peel_samples.frag",
            Self::CompositeSamples => "composite_samples.frag",
            Self::ForwardSamples => "forward_samples.frag",
            Self::BackdropSamples => "backdrop_samples.frag",
            Self::ShowSamples => "show_samples.frag",
            _ => self.source(),
        }
    }

    /// What is defined when it is compiled.
    pub fn defines(self) -> &'static [&'static str] {
        match self {
            Self::Edges
            | Self::LightingSamples
            | Self::TonemapSamples
            | Self::FogSamples
            | Self::DecalSamples
            | Self::ParticleSamples
            | Self::MediumSamples
            | Self::PeelSamples
            | Self::CompositeSamples
            | Self::BackdropSamples
            | Self::ForwardSamples
            | Self::ShowSamples => &["MULTISAMPLED"],
            Self::ShadowNearEndsVertex => &["NEAR_ENDS"],
            _ => &[],
        }
    }

    /// The module that does the same where it reads input attachments of several samples a pixel: itself, if it never does.
    pub fn multisampled(self) -> Self {
        match self {
            Self::Lighting => Self::LightingSamples,
            Self::Tonemap => Self::TonemapSamples,
            Self::Decal => Self::DecalSamples,
            Self::Fog => Self::FogSamples,
            Self::Particle => Self::ParticleSamples,
            Self::Medium => Self::MediumSamples,
            Self::Peel => Self::PeelSamples,
            Self::Composite => Self::CompositeSamples,
            Self::Forward => Self::ForwardSamples,
            Self::Backdrop => Self::BackdropSamples,
            Self::Show => Self::ShowSamples,
            other => other,
        }
    }

    /// The stage that it is for.
    pub fn stage(self) -> Stage {
        match self.source().rsplit_once('.') {
            Some((_, "vert")) => Stage::Vertex,
            Some((_, "comp")) => Stage::Compute,
            _ => Stage::Fragment,
        }
    }

    /// The compiled module; its entry point is `main`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a module that was not compiled.
    pub fn spirv(self) -> Result<&'static [u32]> {
        let name = self.name();
        let (_, module) = EMBEDDED.iter().find(|(embedded, _)| *embedded == name).ok_or_else(|| {
            Error::unsupported(format!("there is no shader module '{name}'"), "run ./tools/shaders")
        })?;
        Ok(bytemuck::cast_slice(&module.0))
    }
}

/// The shaders of a pipeline: modules as specialisation constants leave them, linked so that a vertex shader writes no more than
/// the fragment shader reads.
#[derive(Clone, Debug)]
pub struct Shaders {
    /// SPIR-V of the vertex shader.
    pub vertex: Vec<u32>,
    /// SPIR-V of the fragment shader; what only tests depth has none.
    pub fragment: Option<Vec<u32>>,
    /// Locations of the vertex attributes that are read.
    pub attributes: BTreeSet<u32>,
}

impl Shaders {
    /// The shaders of a pipeline that consists of these modules.
    ///
    /// # Errors
    /// As of [`Module::spirv`], [`prune`] and [`AttachmentPlaces::apply`].
    pub fn new(
        vertex: Module,
        fragment: Option<Module>,
        constants: &Specialization,
        attachments: &AttachmentPlaces,
    ) -> Result<Self> {
        Modules::default().shaders(vertex, fragment, constants, attachments)
    }
}

/// The number that modules know a colour output by: `TARGET_*` of `glsl/shared.h`.
pub(in crate::gpu) fn target_number(name: &str) -> Option<u32> {
    numbers::find(&format!("TARGET_{}", name.to_uppercase()))
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

//! What a frame consists of, decided from what the scene needs; pure data that names no Vulkan type.
//!
//! ```text
//! Needs::of(scene) -> Frame (stages and resources) -> place (attachments) -> passes (operations, dependencies)
//! ```
//!
//! Same needs, options and limits give the same plan. A plan prints itself (`{plan}`), and everything in it says
//! why it is there.

mod access;
mod around;
mod bins;
mod budget;
mod check;
mod choice;
mod counts;
mod derive;
mod format;
mod layout;
mod ledger;
mod lightmap;
mod lights;
mod needs;
mod notes;
mod options;
mod path;
mod print;
mod shadow;
mod shadow_report;
mod stage;
mod targets;
#[cfg(test)]
mod tests;

pub(crate) use check::check_size;
use check::{check_counts, check_dither, check_light, check_shadows};

pub use access::{Access, Scope, State};
pub use around::{Around, AroundImage, EnvironmentNeed};
pub use bins::{Adreno, Bins, Occupancy};
pub use budget::{Verdict, verdicts};
pub use choice::Choice;
pub use counts::{FrameCounts, Seen, StateChanges};
pub use format::Format;
pub use layout::{Form, GBuffer, LightPlace, LightTarget, Target, Tells};
pub use ledger::{
    AttachmentReport, DeviceFigures, Figure, Origin, PassReport, Report, SubpassReport, Totals,
};
pub use lightmap::{LightmapNeed, LightmapUse, SceneKinds};
pub use lights::{ClusterBudget, VolumeShape};
pub(crate) use needs::element;
pub use needs::{KindNeed, Needs, SLOTS, SurfaceKind};
pub(crate) use options::named_enum;
pub use options::{
    Brdf, DepthStore, Gamma, Layout, LightFormat, LightWay, Normals, Options, OutputFormat, OutputUse, Path,
    ShadowFilter, ShadowFormat, ShadowOptions, Strategy, Tonemap,
};
pub use shadow::{
    CasterKind, CasterMask, ShadowLight, ShadowMap, ShadowNeed, ShadowNeeds, Tile, bias_texels, spread_texels,
};
pub(crate) use shadow_report::planned_bytes;
pub use shadow_report::{ShadowFigures, ShadowLightReport, ShadowMapReport};

use std::collections::BTreeSet;

use serde::Serialize;

use crate::environment::TexelFormat;

/// What a device allows, as far as a plan depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Limits {
    /// Colour outputs of one subpass.
    pub max_color_attachments: u32,
    /// Input attachments of one subpass.
    pub max_input_attachments: u32,
    /// The longer side of an image, pixels.
    pub max_image_size: u32,
    /// For depth where a stencil is needed.
    pub depth_stencil: Format,
    /// Whether a G-buffer that is neither loaded nor stored stays in tile memory or a cache.
    pub gbuffer_on_chip: bool,
}

impl Default for Limits {
    /// What every Vulkan 1.1 device allows (Vulkan specification, table "Required Limits"), and the format for depth and
    /// stencil that nearly every one has: of two, each has one. The G-buffer stays on the chip, as on tilers.
    fn default() -> Self {
        Self {
            max_color_attachments: 4,
            max_input_attachments: 4,
            max_image_size: 4096,
            depth_stencil: Format::D32FloatS8,
            gbuffer_on_chip: true,
        }
    }
}

/// A physical attachment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attachment {
    /// The names of the resources that live in it, in order of lifetime, joined by `/`.
    pub name: String,
    /// How a pixel is stored.
    pub format: Format,
    /// What the channels hold, one entry a resource.
    pub holds: Vec<&'static str>,
    /// The value that clearing gives, if it is cleared.
    pub clear: Option<[f32; 4]>,
    /// The host's image.
    pub is_output: bool,
    /// Never loaded and never stored: needs no memory on a tiler.
    pub transient: bool,
    /// What it is used for.
    pub usage: Usage,
    /// First and last stage.
    pub lifetime: (usize, usize),
    /// What needs it, one entry a resource.
    pub why: Vec<String>,
}

/// Uses of an attachment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Usage {
    /// Colour output.
    pub color: bool,
    /// Depth test.
    pub depth: bool,
    /// Input attachment.
    pub input: bool,
    /// Copied from.
    pub copy_source: bool,
    /// Colour output with fixed-function blending.
    pub blend: bool,
}

/// What happens to an attachment's content when a pass begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// Read from memory.
    Load,
    /// Set to the clear value, on the tile.
    Clear,
    /// Undefined.
    DontCare,
}

/// What happens to an attachment's content when a pass ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Store {
    /// Written to memory.
    Store,
    /// Dropped.
    DontCare,
}

/// An attachment as one pass sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PassAttachment {
    /// Index into [`Plan::attachments`].
    pub attachment: usize,
    /// At the pass's begin.
    pub load: Load,
    /// At the pass's end.
    pub store: Store,
    /// The same for the stencil beside depth, if the format has one.
    pub stencil: (Load, Store),
    /// State before the pass.
    pub initial: State,
    /// State after the pass.
    pub last: State,
}

/// One render pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pass {
    /// The stages' names joined by `+`.
    pub name: String,
    /// Attachments; subpasses refer to them by position here.
    pub attachments: Vec<PassAttachment>,
    /// In order of execution.
    pub subpasses: Vec<Subpass>,
    /// Between subpasses, and to the outside.
    pub dependencies: Vec<Dependency>,
}

/// One subpass; all lists hold positions in [`Pass::attachments`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Subpass {
    /// The stage's name.
    pub name: &'static str,
    /// Why it exists.
    pub why: String,
    /// What colour outputs are of, by location.
    pub color_names: Vec<&'static str>,
    /// By colour output location.
    pub colors: Vec<usize>,
    /// Whether colour outputs are added to what is there.
    pub blend: bool,
    /// What input attachments are of, by index.
    pub input_names: Vec<&'static str>,
    /// By input attachment index.
    pub inputs: Vec<usize>,
    /// The state that each of them is in.
    pub input_states: Vec<State>,
    /// Depth test.
    pub depth: Option<usize>,
    /// The state that depth is in.
    pub depth_state: Option<State>,
    /// Whether it also writes depth.
    pub depth_write: bool,
    /// Whether the stencil of the depth attachment is written and tested.
    pub stencil: bool,
    /// Not used here, but needed later.
    pub preserve: Vec<usize>,
    /// Colour bits a pixel that the tile must hold during this subpass.
    pub live_color_bits: u32,
    /// Depth bits a pixel that the tile must hold during this subpass.
    pub live_depth_bits: u32,
}

/// An execution and memory dependency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dependency {
    /// Subpass that comes first; `None` is what happened before the pass.
    pub from: Option<usize>,
    /// Subpass that waits; `None` is what follows the pass.
    pub to: Option<usize>,
    /// What must be finished and visible.
    pub before: Scope,
    /// What waits for it.
    pub after: Scope,
    /// Only the same pixel matters: tilers may stay on the tile.
    pub by_region: bool,
    /// What orders them.
    pub why: Vec<String>,
}

/// A graphics pipeline that a frame needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pipeline {
    /// Draws one kind of surface: into the G-buffer, or straight to the output where nothing is lit or all is lit at
    /// once (the path `forward`).
    Surface(SurfaceKind),
    /// Draws the depth of surfaces, as [`SurfaceKind::depth`] sorts them.
    Depth(SurfaceKind),
    /// Adds what surfaces of a kind reflect of one light; drawn once for each light.
    Light(SurfaceKind),
    /// Draws the environment where no surface is.
    Sky,
    /// Shades the G-buffer by all lights, or, where those with a place are added one by one, by the others.
    Lighting,
    /// Marks in the stencil what is in a light's volume; for lights of one shape, each before it is added.
    LightMask(VolumeShape),
    /// Adds lights of one shape, each on what its volume holds.
    LightVolume(VolumeShape),
    /// Applies the tone curve.
    Tonemap,
}

impl Pipeline {
    /// Whether it draws surfaces, not all pixels.
    pub fn is_of_surfaces(&self) -> bool {
        matches!(self, Self::Surface(_) | Self::Depth(_) | Self::Light(_))
    }

    /// Whether it draws surfaces of this kind.
    pub fn draws(&self, kind: &SurfaceKind) -> bool {
        match self {
            Self::Surface(own) | Self::Light(own) => own == kind,
            Self::Depth(own) => *own == kind.depth(),
            _ => false,
        }
    }
}

/// Everything that a frame creates and does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// What was asked for.
    pub options: Options,
    /// What the scene needs.
    pub needs: Needs,
    /// Physical attachments; the first is the output.
    pub attachments: Vec<Attachment>,
    /// In order of execution.
    pub passes: Vec<Pass>,
    /// Pipelines with the stage they belong to.
    pub pipelines: Vec<(usize, Pipeline)>,
    /// What surfaces sample to receive light from all around.
    pub around: Vec<AroundImage>,
    /// What a G-buffer of this plan consists of, whether or not the path has one.
    pub gbuffer: GBuffer,
    /// The path taken: never [`Path::Auto`]. Without lit surfaces they are all the same.
    pub path: Path,
    /// Whether the stage that lights applies the tone curve itself, so that there is no light target.
    pub folded: bool,
    /// How lights reach pixels: what [`Options::lights`] comes to for this scene, never [`LightWay::Auto`].
    pub light_way: LightWay,
    /// With [`LightWay::Clusters`]: the lights of each part of the view, listed for every frame.
    pub clusters: Option<ClusterBudget>,
    /// The shadow map, where lights cast shadows; it is drawn before the first pass.
    pub shadow_map: Option<ShadowMap>,
    /// Decisions that a reader may wonder about.
    pub notes: Vec<String>,
    /// What the options or the limits leave out of what the scene asks for; the program tells them.
    pub warnings: Vec<String>,
}

impl Plan {
    /// Decides everything.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] if the limits do not allow the layout or the size, or if the options contradict
    /// each other.
    pub fn new(needs: Needs, options: Options, limits: &Limits) -> crate::Result<Self> {
        check_size(options.size, limits)?;
        check_dither(&options)?;
        check_shadows(&options)?;
        around::check(&needs)?;
        let (path, path_why) = path::resolve(&needs, &options, limits)?;
        let lights::Resolved { way: light_way, clusters, why } = lights::resolve(&needs, &options, path)?;
        let gbuffer = GBuffer::new(&options)?;
        if path == Path::Deferred && needs.lit.is_some() {
            check_light(&gbuffer, &needs, &options, light_way)?;
        }
        let frame = stage::Frame::new(&needs, &options, &gbuffer, path, light_way, limits.depth_stencil);
        let places = derive::place(&frame, &options);
        let passes = derive::passes(&frame, &places, &options);
        let attachments = derive::attachments(&frame, &places, &passes, &options);
        check_counts(&passes, &options, limits)?;
        let (shadow_map, shadows_told) = ShadowMap::new(&needs.shadows, &options, limits);
        let around = around::images(&needs, &options);
        let pipelines = pipelines(&frame, &needs, light_way);
        let folded = frame.folded;
        let mut notes = options.gbuffer_why.clone();
        notes.extend(notes::of(&needs, &options, &gbuffer, path, &attachments, folded));
        notes.extend(path_why);
        notes.extend(why);
        notes.extend(clusters.map(|c| c.to_string()));
        notes.extend(shadows_told.notes);
        let warnings =
            shadows_told.warnings.into_iter().chain(notes::warning(&needs, &options, path, light_way));
        let warnings = warnings.collect();
        Ok(Self {
            options,
            needs,
            attachments,
            passes,
            pipelines,
            around,
            gbuffer,
            path,
            folded,
            light_way,
            clusters,
            shadow_map,
            notes,
            warnings,
        })
    }

    /// Whether surfaces are lit after all are known, from a G-buffer.
    pub fn has_gbuffer(&self) -> bool {
        self.needs.lit.is_some() && self.path == Path::Deferred
    }

    /// How the radiance of environment and probes is stored, and the edge of the largest level in texels.
    pub fn environment_texels(&self) -> Option<(TexelFormat, u32)> {
        around::environment_texels(&self.needs, &self.options)
    }

    /// Whether a light target exists.
    pub fn has_light_target(&self) -> bool {
        self.needs.lit.is_some() && !self.folded
    }

    /// What light is summed in, if it is.
    pub fn light_target(&self) -> Option<LightTarget> {
        let one_by_one = self.path == Path::ForwardMultipass || self.light_way.is_one_by_one();
        self.has_light_target().then(|| stage::added_light(&self.gbuffer, one_by_one).0)
    }

    /// Whether light that exists before lighting is in the G-buffer, where lighting reads it.
    pub fn light_is_read(&self) -> bool {
        let in_gbuffer = matches!(self.gbuffer.light, LightPlace::Read(_));
        in_gbuffer && self.has_gbuffer() && !self.needs.prelit.is_empty()
    }

    /// The factor that exposed light is stored with.
    pub fn light_scale(&self) -> f32 {
        self.light_target().map_or(1.0, |light| 1.0 / light.range)
    }

    /// The number of subpasses in all passes: of stages.
    pub fn stage_count(&self) -> usize {
        self.passes.iter().map(|p| p.subpasses.len()).sum()
    }

    /// Pass, position in it and subpass of a stage.
    pub fn subpass(&self, stage: usize) -> (usize, usize, &Subpass) {
        let all = self.passes.iter().enumerate();
        let mut flat =
            all.flat_map(|(p, pass)| pass.subpasses.iter().enumerate().map(move |(s, sub)| (p, s, sub)));
        flat.nth(stage).expect("stage index comes from this plan")
    }
}

fn pipelines(frame: &stage::Frame, needs: &Needs, way: LightWay) -> Vec<(usize, Pipeline)> {
    let stage = |name| frame.stages.iter().position(|s| s.name == name);
    let depths: BTreeSet<_> = needs.kinds.iter().map(|n| n.kind.depth()).collect();
    let depths =
        stage("depth").into_iter().flat_map(|s| depths.iter().map(move |&k| (s, Pipeline::Depth(k))));
    let surface = stage("geometry").or(stage("forward")).unwrap_or(0);
    let surfaces = needs.kinds.iter().map(|n| (surface, Pipeline::Surface(n.kind)));
    let lights = stage("lights").into_iter().flat_map(|s| {
        let lit = needs.kinds.iter().filter(|n| !n.kind.unlit);
        lit.map(move |n| (s, Pipeline::Light(n.kind)))
    });
    let lighting =
        stage("lighting").into_iter().flat_map(|s| lights::pipelines(needs, way).map(move |p| (s, p)));
    let tonemap = stage("tonemap").map(|s| (s, Pipeline::Tonemap));
    let sky = needs.sky.then_some((surface, Pipeline::Sky));
    depths.chain(surfaces).chain(sky).chain(lights).chain(lighting).chain(tonemap).collect()
}

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
mod counters;
mod counts;
mod decals;
mod derive;
mod difference;
mod edges;
mod format;
mod layout;
mod ledger;
mod lightmap;
mod lights;
mod names;
mod needs;
mod notes;
mod options;
mod overlay;
mod particles;
mod pass;
mod path;
mod pipeline;
mod poses;
mod post;
mod print;
mod refraction;
mod rendering;
mod same;
mod samples;
mod shadow;
mod shadow_report;
mod shadow_volumes;
mod show;
mod stage;
mod strategy;
mod targets;
#[cfg(test)]
mod tests;

pub(crate) use check::check_size;
use check::{check_blended, check_counts, check_dither, check_light, check_shadows};

pub use access::{Access, Scope, State};
pub use around::{Around, AroundImage, EnvironmentNeed};
pub use bins::{Adreno, Bins, Occupancy};
pub use budget::{Verdict, verdicts};
pub use choice::Choice;
pub use counters::{CounterFigure, CounterFigures};
pub use counts::{FrameCounts, Seen, StateChanges};
pub use decals::{Channels, DecalKind, DecalNeed};
pub use format::Format;
pub use layout::{Form, GBuffer, LightPlace, LightTarget, LightWord, Target, Tells};
pub use ledger::{
    AttachmentReport, DeviceFigures, Figure, MergeReport, Origin, PassReport, PostPassReport, Report,
    SubpassMerge, SubpassReport, Totals,
};
pub use lightmap::{LightmapNeed, LightmapUse, SceneKinds};
pub use lights::{ClusterBudget, VolumeShape};
pub(crate) use names::named_enum;
pub use names::{
    BloomWay, Brdf, DecalWay, DepthStore, Edges, Gamma, Layout, LightFormat, LightWay, Normals, OutputFormat,
    OutputUse, Path, Refraction, ResolveWay, ShadowFilter, ShadowFormat, Strategy, Tonemap, Translucency,
};
pub(crate) use needs::element;
pub use needs::{KindNeed, Needs, SLOTS, SurfaceKind};
pub use options::{Options, ShadowOptions};
pub use particles::{ParticleKind, ParticleNeed};
pub use pass::{
    Attachment, Dependency, Load, Pass, PassAttachment, Resolve, SampledAttachment, Store, Subpass,
    Transition, Usage,
};
pub use pipeline::Pipeline;
pub use poses::PosedNeed;
pub use post::{Post, PostImage, PostKind, PostPass, PostPlace, bloom_levels};
pub use shadow::{
    CasterKind, CasterMask, ShadowLight, ShadowMap, ShadowNeed, ShadowNeeds, Tile, bias_texels, spread_texels,
};
pub(crate) use shadow_report::planned_bytes;
pub use shadow_report::{ShadowFigures, ShadowLightReport, ShadowMapReport};
pub use shadow_volumes::COUNT_BITS;
pub use show::{Show, heat};
pub(crate) use show::{reads_frame, strips};
pub use strategy::Merging;

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
    /// Whether fragments can read a colour attachment that they write, each what the one before it has left
    /// (VK_EXT_rasterization_order_attachment_access). Mesa's Turnip keeps such passes on the tile; on Adreno 6xx it draws that
    /// subpass in its single-primitive mode, which waits where primitives overlap.
    pub ordered_attachment_access: bool,
    /// Whether fragments beyond the far plane are kept, and shaders clip (`depthClamp`, `shaderClipDistance`): shadow volumes end nowhere.
    pub depth_clamp: bool,
    /// What the driver makes of each [`Strategy`].
    pub merging: Merging,
    /// Samples a pixel that attachments may have: the sum of the counts.
    pub sample_counts: u32,
    /// Likewise of attachments of words.
    pub word_sample_counts: u32,
    /// Whether a fragment can be a sample (`sampleRateShading`).
    pub sample_shading: bool,
}

impl Default for Limits {
    /// What every Vulkan 1.1 device allows (Vulkan specification, table "Required Limits"), and the format for depth and
    /// stencil that nearly every one has: of two, each has one. As nearly every one, it shades samples, and has words of as many as
    /// all else. The G-buffer stays on the chip, as on tilers.
    fn default() -> Self {
        Self {
            max_color_attachments: 4,
            max_input_attachments: 4,
            max_image_size: 4096,
            depth_stencil: Format::D32FloatS8,
            gbuffer_on_chip: true,
            ordered_attachment_access: false,
            depth_clamp: false,
            merging: Merging::default(),
            sample_counts: 1 | 4,
            word_sample_counts: 1 | 4,
            sample_shading: true,
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
    /// How stages became passes: never [`Strategy::Auto`].
    pub strategy: Strategy,
    /// The path taken: never [`Path::Auto`]. Without lit surfaces they are all the same.
    pub path: Path,
    /// Whether the stage that lights applies the tone curve itself, so that there is no light target.
    pub folded: bool,
    /// How lights reach pixels: what [`Options::lights`] comes to for this scene, never [`LightWay::Auto`].
    pub light_way: LightWay,
    /// Which pixels are lit sample by sample: what [`Options::edges`] comes to, never [`Edges::Auto`].
    pub edges: Edges,
    /// With [`LightWay::Clusters`]: the lights of each part of the view, listed for every frame.
    pub clusters: Option<ClusterBudget>,
    /// The shadow map, where lights cast shadows; it is drawn before the first pass.
    pub shadow_map: Option<ShadowMap>,
    /// Lights whose shadows are counted in the stencil, each added by itself: indices into `Scene::lights`.
    pub volume_lights: Vec<usize>,
    /// Passes after the last one, where pixels' neighbours are needed.
    pub post: Post,
    /// Decisions that a reader may wonder about.
    pub notes: Vec<String>,
    /// How decals are ordered, never [`DecalWay::Auto`]; `None` without decals.
    pub decal_way: Option<DecalWay>,
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
        let (strategy, why) = strategy::resolve(&options, limits)?;
        let is_best = options.strategy == Strategy::Auto && strategy != Strategy::Subpasses;
        match Self::by(strategy, why, needs.clone(), options.clone(), limits) {
            Err(error) if is_best => {
                let why = format!("strategy: subpasses, since {strategy} does not go: {error}");
                Self::by(Strategy::Subpasses, Some(why), needs, options, limits)
            }
            made => made,
        }
    }

    fn by(
        strategy: Strategy,
        strategy_why: Option<String>,
        needs: Needs,
        options: Options,
        limits: &Limits,
    ) -> crate::Result<Self> {
        let needs = needs.shown(options.show);
        check_size(options.size, limits)?;
        check_dither(&options)?;
        difference::check(&options)?;
        check_shadows(&options)?;
        around::check(&needs)?;
        let (path, path_why) = path::resolve(&needs, &options, strategy, limits)?;
        post::check(&options, &needs, path)?;
        let lights::Resolved { way: light_way, clusters, why } = lights::resolve(&needs, &options, path)?;
        let gbuffer = GBuffer::new(&options)?;
        let gbuffer = if needs.over_light().is_some() { gbuffer.for_blending() } else { gbuffer };
        let volumes = shadow_volumes::resolve(&needs, &options, &gbuffer, path, limits)?;
        let by_volume = !volumes.lights.is_empty();
        check_blended(&gbuffer, &needs, &options, strategy, limits)?;
        refraction::check(&needs, &options, &gbuffer, path)?;
        if path == Path::Deferred && needs.lit_opaque.is_some() {
            let one_by_one = light_way.is_one_by_one() || by_volume;
            check_light(&gbuffer, &needs, &options, one_by_one, limits)?;
        }
        let (edges, edges_why) = edges::resolve(&needs, &options, &gbuffer, path, light_way);
        // What is counted is counted for each sample.
        let edges = if by_volume { Edges::All } else { edges };
        let edges_why = edges_why.filter(|_| !by_volume);
        let (decal_way, decals_why) = decals::resolve(&needs, &options, &gbuffer, limits)?.unzip();
        let ways = (light_way, edges, by_volume);
        let frame =
            stage::Frame::new(&needs, &options, &gbuffer, path, ways, limits.depth_stencil, decal_way);
        show::check(&needs, &options, &gbuffer, (path, edges), frame.folded)?;
        samples::check(&options, path, frame.folded)?;
        let places = derive::place(&frame, &options);
        let passes = derive::passes(&frame, &places, &options, strategy);
        let mut attachments = derive::attachments(&frame, &places, &passes, &options);
        overlay::check(&options, &passes)?;
        overlay::blend(&options, &passes, &mut attachments);
        check_counts(&passes, &attachments, strategy, &options, limits)?;
        samples::check_limits(&attachments, &passes, &options, limits)?;
        let sampled_after = |a: usize| places[a].iter().any(|&r| frame.resources[r].sampled);
        let post = Post::new(&options, &attachments, &sampled_after);
        let (shadow_map, shadows_told) =
            ShadowMap::new(&needs.shadows.without(&volumes.lights), &options, limits);
        let around = around::images(&needs, &options);
        let pipelines = pipeline::of(&frame, &needs, options.overlay, ways);
        let folded = frame.folded;
        let mut notes = options.gbuffer_why.clone();
        notes.extend(notes::of(&needs, &options, &gbuffer, path, &attachments, folded));
        notes.extend(overlay::note(&options, &passes));
        notes.extend(difference::note(&options));
        notes.extend(show::note(&needs, &options, &gbuffer, folded));
        notes.extend(strategy_why);
        notes.extend(samples::notes(&options, &attachments));
        notes.extend(edges_why);
        notes.extend(path_why);
        notes.extend(why);
        notes.extend(decals_why.flatten());
        notes.extend(decals::note(&needs));
        notes.extend(clusters.map(|c| c.to_string()));
        notes.extend(volumes.notes);
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
            strategy,
            path,
            folded,
            decal_way,
            light_way,
            edges,
            clusters,
            shadow_map,
            volume_lights: volumes.lights,
            post,
            notes,
            warnings,
        })
    }

    /// Whether surfaces are lit after all are known, from a G-buffer.
    pub fn has_gbuffer(&self) -> bool {
        self.needs.lit_opaque.is_some() && self.path == Path::Deferred
    }

    /// Whether surfaces of this kind are lit as they are drawn, by all lights at once.
    pub fn lights_as_drawn(&self, kind: &SurfaceKind) -> bool {
        let one_by_one = self.path == Path::ForwardMultipass && self.needs.lit_opaque.is_some();
        kind.blend || !(self.has_gbuffer() || one_by_one)
    }

    /// How the radiance of environment and probes is stored, and the edge of the largest level in texels.
    pub fn environment_texels(&self) -> Option<(TexelFormat, u32)> {
        around::environment_texels(&self.needs, &self.options)
    }

    /// Whether a light target exists.
    pub fn has_light_target(&self) -> bool {
        let in_gbuffer = self.has_gbuffer() && matches!(self.gbuffer.light, LightPlace::Read(_));
        (self.needs.lit.is_some() || self.needs.over_light().is_some()) && !self.folded && !in_gbuffer
    }

    /// What light is summed in, if it is.
    pub fn light_target(&self) -> Option<LightTarget> {
        let one_by_one = self.path == Path::ForwardMultipass
            || self.light_way.is_one_by_one()
            || !self.volume_lights.is_empty();
        self.has_light_target().then(|| stage::added_light(&self.gbuffer, one_by_one).0)
    }

    /// Whether light is in the G-buffer, where lighting reads it: light that exists before, or all that is added one by one.
    pub fn light_is_read(&self) -> bool {
        let in_gbuffer = matches!(self.gbuffer.light, LightPlace::Read(_));
        in_gbuffer && self.has_gbuffer() && (!self.folded || !self.needs.prelit.is_empty())
    }

    /// The factor that exposed light is stored with.
    pub fn light_scale(&self) -> f32 {
        self.light_target().map_or(1.0, |light| 1.0 / light.range)
    }

    /// Whether the stage writes the final image, all pixels of it at once.
    pub fn applies_curve(&self, stage: usize) -> bool {
        let last = stage + 1 == self.stage_count();
        last && matches!(self.subpass(stage).2.name, "lighting" | "tonemap")
    }

    /// Of [`Options::show`]: the quantities that are shown in strips, from the left.
    pub fn strips(&self) -> Vec<Show> {
        match self.options.show {
            Show::Channels => strips(&self.needs, &self.gbuffer, self.folded),
            _ => Vec::new(),
        }
    }

    /// The number of subpasses in all passes: of stages.
    pub fn stage_count(&self) -> usize {
        self.passes.iter().map(|p| p.subpasses.len()).sum()
    }

    /// Whether the stage draws what is blended.
    pub fn draws_blended(&self, stage: usize) -> bool {
        self.pipelines.iter().any(|(s, pipeline)| *s == stage && pipeline.is_of_blended())
    }

    /// Samples a pixel of what a stage draws to.
    pub fn samples(&self, stage: usize) -> u32 {
        let (pass, _, subpass) = self.subpass(stage);
        let drawn = subpass.colors.iter().chain(&subpass.depth).next();
        drawn.map_or(1, |&a| self.attachments[self.passes[pass].attachments[a].attachment].samples)
    }

    /// Whether a shader compares samples to find edges: where the outlines of triangles do not tell of all.
    pub fn compares_samples(&self) -> bool {
        match self.edges {
            Edges::Coverage => self.needs.kinds.iter().any(|need| need.kind.alpha_mask),
            edges => edges == Edges::Compare,
        }
    }

    /// Pass, position in it and subpass of a stage.
    pub fn subpass(&self, stage: usize) -> (usize, usize, &Subpass) {
        let all = self.passes.iter().enumerate();
        let mut flat =
            all.flat_map(|(p, pass)| pass.subpasses.iter().enumerate().map(move |(s, sub)| (p, s, sub)));
        flat.nth(stage).expect("stage index comes from this plan")
    }
}

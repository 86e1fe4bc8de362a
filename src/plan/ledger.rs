//! The ledger: what a frame moves and holds, in one schema for `ontile plan --json` and `ontile render --report`.

use serde::Serialize;

use super::{Attachment, Load, Needs, Options, Plan, Store, Verdict, verdicts};

/// Where a figure comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// What this renderer asks the driver for.
    Planned,
    /// A formula from a publication.
    Modelled,
    /// The driver said so.
    Driver,
}

/// A number and where it comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// The number.
    pub value: f64,
    /// Its origin.
    pub origin: Origin,
}

impl Figure {
    /// A planned figure.
    pub fn planned(value: impl Into<f64>) -> Self {
        Self { value: value.into(), origin: Origin::Planned }
    }

    /// A driver's figure.
    pub fn driver(value: impl Into<f64>) -> Self {
        Self { value: value.into(), origin: Origin::Driver }
    }
}

/// One attachment in the ledger.
#[derive(Clone, Debug, Serialize)]
pub struct AttachmentReport {
    /// Names of the resources that live in it.
    pub name: String,
    /// Format.
    pub format: super::Format,
    /// Bits a sample.
    pub bits: u32,
    /// Samples a pixel.
    pub samples: u32,
    /// Whether it needs no memory on a tiler.
    pub transient: bool,
    /// Bytes that all passes of a frame load or sample from memory, a pixel.
    pub loaded_bytes_per_pixel: Figure,
    /// Bytes that all passes of a frame store to memory, a pixel.
    pub stored_bytes_per_pixel: Figure,
    /// Bytes of memory behind it: what the driver committed of lazily allocated memory, all of it otherwise; `null`
    /// where nothing was created, and for the output, which is the host's.
    pub committed_bytes: Option<Figure>,
    /// Whether its memory is lazily allocated; `null` where nothing was created.
    pub lazily_allocated: Option<bool>,
    /// What needs it.
    pub why: Vec<String>,
}

/// One subpass in the ledger.
#[derive(Clone, Debug, Serialize)]
pub struct SubpassReport {
    /// Name.
    pub name: &'static str,
    /// Colour bits a pixel that are live on the tile.
    pub live_color_bits: Figure,
    /// Depth bits a pixel that are live on the tile.
    pub live_depth_bits: Figure,
    /// Names of input attachments.
    pub inputs: Vec<String>,
    /// Names of colour outputs.
    pub outputs: Vec<String>,
    /// Why it exists.
    pub why: String,
}

/// One render pass in the ledger.
#[derive(Clone, Debug, Serialize)]
pub struct PassReport {
    /// Name.
    pub name: String,
    /// In order of execution.
    pub subpasses: Vec<SubpassReport>,
    /// Between subpasses, and to the outside.
    pub dependencies: Vec<super::Dependency>,
    /// By barriers before and after it: of a rendering; a render pass has none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub transitions: Vec<super::Transition>,
}

/// One pass after the frame's own.
#[derive(Clone, Debug, Serialize)]
pub struct PostPassReport {
    /// Name.
    pub name: String,
    /// Bytes a pixel of the picture that it samples or loads.
    pub loaded_bytes_per_pixel: Figure,
    /// Bytes a pixel of the picture that it stores.
    pub stored_bytes_per_pixel: Figure,
    /// Why it exists.
    pub why: &'static str,
}

/// Sums over a frame.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Totals {
    /// Attachment bytes loaded from memory, a pixel.
    pub loaded_bytes_per_pixel: Figure,
    /// Attachment bytes stored to memory, a pixel.
    pub stored_bytes_per_pixel: Figure,
    /// Render passes, beside those of shadow tiles.
    pub passes: usize,
    /// Subpasses in all passes.
    pub subpasses: usize,
    /// Bytes a pixel that passes after these load, and that they themselves sample of scattered light or of a picture that theirs is
    /// compared with.
    pub post_loaded_bytes_per_pixel: Figure,
    /// Bytes a pixel that passes after these store.
    pub post_stored_bytes_per_pixel: Figure,
    /// Render passes before these when all tiles of the shadow map are drawn, as in the first frame: one a tile. Later frames
    /// draw those that have changed.
    pub shadow_tile_passes: usize,
    /// Bytes that these store, in all and not a pixel; nothing is loaded.
    pub shadow_stored_bytes: Figure,
    /// Bytes of memory of the shadow map, the static one included.
    pub shadow_bytes: Figure,
}

/// What a driver says it makes of a render pass's subpasses (VK_EXT_subpass_merge_feedback).
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MergeReport {
    /// The pass's name.
    pub pass: String,
    /// How many subpasses are left when some are merged.
    pub subpasses_left: u32,
    /// In order of execution.
    pub subpasses: Vec<SubpassMerge>,
}

/// One subpass of a [`MergeReport`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SubpassMerge {
    /// Name.
    pub name: &'static str,
    /// `VkSubpassMergeStatusEXT` in lower case: "merged", or why not.
    pub status: String,
    /// In the driver's words.
    pub description: String,
    /// Which of the subpasses that are left it is in.
    pub part: u32,
}

/// What only a device can tell.
#[derive(Clone, Debug, Default, Serialize)]
pub struct DeviceFigures {
    /// Device name.
    pub device: String,
    /// Driver name and version.
    pub driver: String,
    /// Whether a memory type is lazily allocated; where none is, transient attachments take ordinary memory.
    pub has_lazy_memory: bool,
    /// What becomes of the subpasses of each render pass; empty where the driver does not say.
    pub merging: Vec<MergeReport>,
    /// Median GPU time of a frame by timestamps, milliseconds.
    pub gpu_frame_ms: Option<Figure>,
    /// Median GPU time of each stage by timestamps, milliseconds, where the device tells them apart.
    pub gpu_stage_ms: Vec<(String, Figure)>,
    /// Median CPU time of recording a frame, milliseconds.
    pub cpu_record_ms: Option<f64>,
    /// Median CPU time of listing the lights of each part of the view, milliseconds, where that is done; a part of the
    /// above.
    pub cpu_light_lists_ms: Option<f64>,
    /// Pipeline statistics of the last frame: name and count.
    pub statistics: Vec<(String, Figure)>,
    /// What the last frame's commands consist of.
    pub frame: super::FrameCounts,
    /// What the last frame drew into the shadow map; `null` where there is none.
    pub shadows: Option<super::ShadowFigures>,
    /// The share of pixels that are lit sample by sample ([`super::Edges`]), counted by the GPU in another frame; `null` where all are
    /// or none, or where nobody counted.
    pub lit_by_sample: Option<Figure>,
    /// What performance counters counted in another frame of the last view; left out where none was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counters: Option<super::CounterFigures>,
    /// Frames rendered.
    pub frames: usize,
    /// Bytes of device memory that the renderer allocated, transient attachments excluded.
    pub allocated_bytes: u64,
    /// What the validation layer said; `null` when it was not asked.
    pub validation_messages: Option<Vec<String>>,
}

/// The ledger of a plan, and of a frame once a device has drawn it.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of this schema.
    pub schema: &'static str,
    /// Scene name.
    pub scene: String,
    /// What was asked for.
    pub options: Options,
    /// What the scene needs.
    pub needs: Needs,
    /// How stages became passes: never "auto".
    pub strategy: super::Strategy,
    /// Physical attachments.
    pub attachments: Vec<AttachmentReport>,
    /// Render passes.
    pub passes: Vec<PassReport>,
    /// The shadow map, drawn before them; `null` where no light casts shadows.
    pub shadow_map: Option<super::ShadowMapReport>,
    /// Passes after them, which sample what they and those before them have stored.
    pub post_passes: Vec<PostPassReport>,
    /// Pipelines, as text.
    pub pipelines: Vec<String>,
    /// With light lists: their bounds.
    pub clusters: Option<super::ClusterBudget>,
    /// Sums.
    pub totals: Totals,
    /// One per GPU family.
    pub verdicts: Vec<Verdict>,
    /// Decisions that a reader may wonder about.
    pub notes: Vec<String>,
    /// What the scene's loader left out or changed, and what the plan did.
    pub warnings: Vec<String>,
    /// Only after a frame was drawn.
    pub device: Option<DeviceFigures>,
}

impl Plan {
    /// Bytes a pixel that all passes load or sample (first) and store (second) of one attachment.
    pub fn traffic(&self, attachment: usize) -> [u32; 2] {
        let Attachment { format, samples, .. } = self.attachments[attachment];
        let bytes = format.bytes() * samples;
        let uses =
            || self.passes.iter().flat_map(|p| &p.attachments).filter(move |a| a.attachment == attachment);
        let loads = uses().filter(|a| a.load == Load::Load).count() as u32;
        let stores = uses().filter(|a| a.store == Store::Store).count() as u32;
        [loads * bytes + self.sampled_bytes(attachment), stores * bytes]
    }

    /// Bytes a pixel, all its samples, of all attachments of a pass, of the pass that has most: what the tile holds.
    pub fn bytes_on_tile(&self) -> u32 {
        self.most_of_a_pass(super::Format::bytes)
    }

    /// Bits a pixel of all colour attachments of a pass, of the pass that has most.
    pub fn color_bits(&self) -> u32 {
        self.most_of_a_pass(|format| if format.is_depth() { 0 } else { format.bits() })
    }

    fn most_of_a_pass(&self, figure: impl Fn(super::Format) -> u32) -> u32 {
        let of_pass = |pass: &super::Pass| {
            let held = pass.attachments.iter().enumerate().filter(|(index, _)| pass.is_on_tile(*index));
            let held = held.map(|(_, a)| &self.attachments[a.attachment]);
            held.map(|a| figure(a.format) * a.samples).sum()
        };
        self.passes.iter().map(of_pass).max().unwrap_or(0)
    }

    /// Bytes a pixel that all passes load and store.
    pub fn bytes_moved(&self) -> u32 {
        (0..self.attachments.len()).flat_map(|a| self.traffic(a)).sum()
    }

    /// The ledger, without a device's figures.
    pub fn report(&self, scene: &crate::scene::Scene) -> Report {
        let traffic: Vec<_> = (0..self.attachments.len()).map(|a| self.traffic(a)).collect();
        let sum = |way: usize| Figure::planned(traffic.iter().map(|t| t[way]).sum::<u32>());
        let attachments =
            self.attachments.iter().zip(&traffic).map(|(a, [loaded, stored])| AttachmentReport {
                name: a.name.clone(),
                format: a.format,
                bits: a.format.bits(),
                samples: a.samples,
                transient: a.transient,
                loaded_bytes_per_pixel: Figure::planned(*loaded),
                stored_bytes_per_pixel: Figure::planned(*stored),
                committed_bytes: None,
                lazily_allocated: None,
                why: a.why.clone(),
            });
        let shadow_map = self.shadow_map.as_ref().map(|map| map.report(self.options.shadows.filter));
        let [shadow_stored_bytes, shadow_bytes] =
            shadow_map.as_ref().map_or([Figure::planned(0); 2], |map| [map.stored_bytes, map.bytes]);
        Report {
            schema: "ontile-report-1",
            scene: scene.name.clone(),
            options: self.options.clone(),
            needs: self.needs.clone(),
            strategy: self.strategy,
            attachments: attachments.collect(),
            passes: self.passes.iter().map(|p| self.pass_report(p)).collect(),
            shadow_map,
            post_passes: self.post.passes.iter().map(|p| self.post_pass_report(p)).collect(),
            pipelines: self.pipelines.iter().map(|(_, p)| self.pipeline_text(p)).collect(),
            clusters: self.clusters,
            totals: Totals {
                loaded_bytes_per_pixel: sum(0),
                stored_bytes_per_pixel: sum(1),
                passes: self.passes.len(),
                subpasses: self.stage_count(),
                post_loaded_bytes_per_pixel: Figure::planned(self.post_totals()[0]),
                post_stored_bytes_per_pixel: Figure::planned(self.post_totals()[1]),
                shadow_tile_passes: self.shadow_map.as_ref().map_or(0, |map| map.tiles.len()),
                shadow_stored_bytes,
                shadow_bytes,
            },
            verdicts: verdicts(self),
            notes: self.notes.clone(),
            warnings: scene.warnings.iter().chain(&self.warnings).cloned().collect(),
            device: None,
        }
    }

    fn pass_report(&self, pass: &super::Pass) -> PassReport {
        let names = |list: &[usize]| -> Vec<String> {
            list.iter().map(|&i| self.attachments[pass.attachments[i].attachment].name.clone()).collect()
        };
        let subpasses = pass.subpasses.iter().map(|s| SubpassReport {
            name: s.name,
            live_color_bits: Figure::planned(s.live_color_bits),
            live_depth_bits: Figure::planned(s.live_depth_bits),
            inputs: names(&s.inputs),
            outputs: names(&s.colors),
            why: s.why.clone(),
        });
        PassReport {
            name: pass.name.clone(),
            subpasses: subpasses.collect(),
            dependencies: pass.dependencies.clone(),
            transitions: pass.enter.iter().chain(&pass.leave).cloned().collect(),
        }
    }

    fn post_pass_report(&self, pass: &super::PostPass) -> PostPassReport {
        let [loaded, stored] = self.post_traffic(pass).map(Figure::planned);
        PostPassReport {
            name: pass.name.clone(),
            loaded_bytes_per_pixel: loaded,
            stored_bytes_per_pixel: stored,
            why: pass.why,
        }
    }

    /// A pipeline in words.
    pub fn pipeline_text(&self, pipeline: &super::Pipeline) -> String {
        use super::Pipeline as P;
        let fog = if self.needs.fog.is_some() { " +fog" } else { "" };
        let background = if self.needs.background.is_some() { " +background colour" } else { "" };
        let around = format!("{fog}{background}");
        match pipeline {
            P::Surface(kind) => {
                let need = self.needs.kinds.iter().find(|n| n.kind == *kind);
                let why = need.map(|n| match n.instances {
                    1 => format!(" ({})", n.why),
                    instances => format!(" ({instances} instances, first {})", n.why),
                });
                let what = match (kind.transmits, kind.blend) {
                    (true, _) => "medium",
                    (_, true) => "blended surface",
                    _ => "surface",
                };
                format!("{what} {kind}{}", why.unwrap_or_default())
            }
            P::Absorb(kind) => format!("absorption, {kind}"),
            P::Depth(kind) => {
                let flags = [
                    (kind.alpha_mask, " +alpha mask"),
                    (kind.double_sided, " +double-sided"),
                    (kind.mirrored, " +mirrored"),
                ];
                flags.iter().filter(|(on, _)| *on).fold("depth".into(), |text, (_, flag)| text + flag)
            }
            P::Light(kind) => format!("one light on {kind}"),
            P::Lighting if self.folded => format!("lighting, {} tone curve{around}", self.options.tonemap),
            P::Lighting if matches!(self.light_way, super::LightWay::Volumes | super::LightWay::Stencil) => {
                "lighting by what shines everywhere".into()
            }
            P::Lighting => "lighting".into(),
            P::Fog => "fog".into(),
            P::Backdrop => "copy of what is sampled".into(),
            P::Overlay => "overlay".into(),
            P::Composite => format!("composite, {}", self.options.translucency),
            P::Peel { kind, first } => {
                let flags = [(kind.double_sided, " +double-sided"), (kind.mirrored, " +mirrored")];
                let before =
                    if *first { "peel, before what is opaque" } else { "peel, before the last layer" };
                flags.iter().filter(|(on, _)| *on).fold(before.into(), |text: String, (_, flag)| text + flag)
            }
            P::Sky if self.has_gbuffer() => "sky".into(),
            P::Sky => format!("sky, {} curve", self.options.tonemap),
            P::Decal(kind) => {
                let need = self.needs.decals.iter().find(|n| n.kind == *kind);
                let why = need.map(|n| match n.decals {
                    1 => format!(" ({})", n.why),
                    decals => format!(" ({decals} decals, first {})", n.why),
                });
                format!("decal: {kind}{}", why.unwrap_or_default())
            }
            P::Particles(kind) => {
                let need = self.needs.particles.iter().find(|n| n.kind == *kind);
                let why = need.map(|n| format!(" (up to {}, first {})", n.particles, n.why));
                format!("particles, {kind}{}", why.unwrap_or_default())
            }
            P::LightMask(shape) => format!("light mask, {shape}"),
            P::LightVolume(shape) => format!("light, {shape}"),
            P::ShadowNearEnds => "shadow volumes, near ends".into(),
            P::ShadowVolume => "shadow volumes, walls and far ends".into(),
            P::ShadowedLight => "light, where its shadow volumes are not".into(),
            P::Edges => format!("edges, by {}", self.edges),
            P::EdgeLighting | P::EdgeVolume(_) => {
                format!("{}, by sample", self.pipeline_text(&pipeline.per_pixel()))
            }
            P::Show => format!("show {}", self.options.show),
            P::Difference => format!("difference, times {}", self.options.difference.unwrap_or_default()),
            P::ShowEdges => "show edges that are marked".into(),
            P::Tonemap => format!("tonemap, {} curve{around}", self.options.tonemap),
        }
    }
}

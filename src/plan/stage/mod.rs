//! The stages of a frame and the resources that they exchange, before anything is placed in memory.

mod decals;
mod deferred;
mod depth;
mod forward;
mod media;
mod particles;
mod post;
mod samples;
mod show;
mod translucency;

pub use media::{BACKDROP, NAME as MEDIA};
pub use particles::NAME as PARTICLES;
pub(super) use samples::add as multisample;
pub use translucency::{FOG, LAYERS, NAME as TRANSLUCENCY, PEEL};

use super::layout::{GBuffer, LightTarget, Target};
use super::{DecalWay, Edges, Format, LightWay, Needs, Options, Path, ResolveWay};

/// Something that stages write and read, one value a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Resource {
    /// Name in plans and reports.
    pub name: &'static str,
    /// How it is stored.
    pub format: Format,
    /// What each channel holds.
    pub holds: &'static str,
    /// Samples a pixel.
    pub samples: u32,
    /// What pixels that nothing covers must hold; `None` where nothing reads them.
    pub clear: Option<[f32; 4]>,
    /// Outlives the frame: the final image, or a G-buffer that is kept to be read back.
    pub kept: bool,
    /// Passes after the frame's own sample it, neighbours too.
    pub sampled: bool,
    /// The scene element or the stage that needs it.
    pub why: String,
}

/// How a stage uses a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Colour output that replaces what was there.
    Write,
    /// Colour output that is added to what was there.
    Blend,
    /// Depth test and write.
    Depth,
    /// Depth test against what earlier stages wrote.
    DepthTest,
    /// The same, and the stencil is written and tested.
    Stencil,
    /// Input attachment: this pixel of an earlier stage's output.
    Read,
    /// Sampled, neighbours too: an earlier pass has stored it.
    Sample,
    /// Input attachment and colour output at once: each fragment reads what the one before it has left, in the order of
    /// rasterisation.
    Modify,
    /// The mean of the samples of the colour output before it in the stage's uses, made when the stage ends.
    Resolve,
    /// The same, but what overlaps is drawn with a barrier in between.
    Rewrite,
}

impl Use {
    /// Whether earlier content matters.
    pub const fn reads(self) -> bool {
        matches!(
            self,
            Self::Blend
                | Self::Read
                | Self::Sample
                | Self::DepthTest
                | Self::Stencil
                | Self::Modify
                | Self::Rewrite
        )
    }

    /// Whether content changes.
    pub const fn writes(self) -> bool {
        !matches!(self, Self::DepthTest | Self::Read | Self::Sample)
    }
}

/// One step of the frame; becomes a subpass.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// Name in plans, labels and reports.
    pub name: &'static str,
    /// Resources by index, in order of colour output location and of input attachment index.
    pub uses: Vec<(usize, Use)>,
    /// Why the stage exists.
    pub why: String,
}

/// The stages of a frame with their resources. The last stage writes [`Frame::OUTPUT`].
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Indexed by `Stage::uses`.
    pub resources: Vec<Resource>,
    /// In order of execution.
    pub stages: Vec<Stage>,
    /// Whether the stage that lights applies the tone curve itself.
    pub folded: bool,
    /// Resources that a stage, by its number, sets to a value as it begins, since their attachments are used before.
    pub clears: Vec<(usize, usize, [f32; 4])>,
}

impl Frame {
    /// The final image's index in `resources`.
    pub const OUTPUT: usize = 0;

    /// The least number of stages and resources that give the picture on this path and in this way, none of which is
    /// `Auto`. The format is for depth where the way or shadow volumes (`by_volume`) need a stencil; `decals` is how they are
    /// ordered, where there are any.
    pub fn new(
        needs: &Needs,
        options: &Options,
        gbuffer: &GBuffer,
        path: Path,
        (way, edges, by_volume): (LightWay, Edges, bool),
        depth_stencil: Format,
        decals: Option<DecalWay>,
    ) -> Self {
        let mut frame = Self {
            resources: vec![Resource {
                name: "output",
                format: options.output.into(),
                holds: "the final image",
                samples: 1,
                clear: None,
                kept: true,
                sampled: false,
                why: "the picture".into(),
            }],
            stages: Vec::new(),
            folded: false,
            clears: Vec::new(),
        };
        let asked = Asked { needs, options, gbuffer, path, way, edges, depth_stencil, by_volume, decals };
        let depth = depth::add(&mut frame, &asked);
        match (&needs.lit_opaque, path) {
            (Some(lit), Path::Deferred) => deferred::add(&mut frame, &asked, &depth, lit),
            (Some(_), Path::ForwardMultipass) => forward::add_multipass(&mut frame, &asked, &depth),
            _ if needs.lit.is_some() => {
                let fogged = asked.fogged();
                let why = format!("{}; surfaces are lit{fogged} and tone-mapped as drawn", asked.lights());
                forward::add(&mut frame, &asked, &depth, "forward", why);
            }
            _ => {
                let fogged = asked.fogged();
                let why = format!(
                    "nothing in the scene is lit: surfaces are drawn{fogged} and tone-mapped at once"
                );
                forward::add(&mut frame, &asked, &depth, "geometry", why);
            }
        }
        multisample(&mut frame, options.samples);
        post::add(&mut frame, &asked);
        frame
    }

    fn add_target(&mut self, target: &Target, kept: bool, why: String) -> usize {
        self.resources.push(Resource {
            name: target.name,
            format: target.format,
            holds: target.holds,
            samples: 1,
            clear: target.clear,
            kept,
            sampled: false,
            why,
        });
        self.resources.len() - 1
    }

    fn add_stage(&mut self, name: &'static str, uses: impl IntoIterator<Item = (usize, Use)>, why: String) {
        self.stages.push(Stage { name, uses: uses.into_iter().collect(), why });
    }

    /// First and last stage that uses the resource; one that outlives the frame's own passes lives to the last stage.
    pub fn lifetime(&self, resource: usize) -> (usize, usize) {
        let uses = |s: &Stage| s.uses.iter().any(|(r, _)| *r == resource);
        let first = self.stages.iter().position(uses).unwrap_or(0);
        let last = self.stages.iter().rposition(uses).unwrap_or(0);
        let Resource { kept, sampled, .. } = self.resources[resource];
        (first, if kept || sampled { self.stages.len() - 1 } else { last })
    }
}

/// What a frame is made from.
struct Asked<'a> {
    needs: &'a Needs,
    options: &'a Options,
    gbuffer: &'a GBuffer,
    path: Path,
    way: LightWay,
    edges: Edges,
    depth_stencil: Format,
    /// Some lights' shadows are counted in the stencil.
    by_volume: bool,
    decals: Option<DecalWay>,
}

impl Asked<'_> {
    /// What a light target holds where background and surfaces are told apart.
    const LIGHT_AND_BACKGROUND: &'static str = "rgb: exposed light / range, a: 0 background, 1 surface";

    /// Whether lights are added one after the other.
    fn one_by_one(&self) -> bool {
        self.way.is_one_by_one() || self.by_volume
    }

    /// Whether lighting counts in the stencil.
    fn has_stencil(&self) -> bool {
        self.way == LightWay::Stencil || self.by_volume
    }

    /// The scene's lights in words.
    fn lights(&self) -> String {
        let Needs { directional_lights, point_lights, spot_lights, box_lights, .. } = self.needs;
        let more = [
            (*box_lights, "box"),
            (self.needs.hemisphere_lights, "hemisphere (all at the cost of one)"),
            (self.needs.back_colors, "with a back colour"),
            (self.needs.globe_maps, "with a globe map"),
        ];
        let more = more.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!(", {n} {what}"));
        format!(
            "{directional_lights} directional, {point_lights} point and {spot_lights} spot lights{}",
            more.collect::<String>()
        )
    }

    /// Whether what the G-buffer holds is fogged in the last stage; before blended surfaces are laid over it, it is earlier.
    fn fogs_last(&self) -> bool {
        self.needs.fog.is_some() && self.needs.over_light().is_none()
    }

    /// What there is a light target for once surfaces are lit.
    fn over_light(&self) -> Option<String> {
        let over = |blended: &String| format!("{blended} is blended over it");
        let blended = self.needs.transmits.as_ref().or(self.needs.blended.as_ref()).map(over);
        blended.or(self.needs.particles.first().map(|need| format!("{} add to it", need.why)))
    }

    /// Whether the tone curve may be applied where light is made; light that is to be resolved is all made before.
    fn may_fold(&self) -> bool {
        let resolves_light = self.options.samples > 1 && self.options.resolve == ResolveWay::Plain;
        self.options.fold && !resolves_light
    }

    fn fogged(&self) -> &'static str {
        if self.needs.fog.is_some() { ", fogged" } else { "" }
    }
}

/// Where light is added, and whether diffuse light apart. A layout that has no such place gets half floats where a way needs one
/// all the same.
pub fn added_light(gbuffer: &GBuffer, one_by_one: bool) -> (LightTarget, bool) {
    gbuffer.added_light(one_by_one).unwrap_or((LightTarget::new(super::LightFormat::Rgba16f), false))
}

//! The graphics pipelines of a frame.

use std::collections::BTreeSet;

use serde::Serialize;

use super::stage::{BACKDROP, FOG, Frame, LAYERS, MEDIA, PARTICLES, PEEL, TRANSLUCENCY, Use};
use super::{DecalKind, Edges, LightWay, Needs, ParticleKind, SurfaceKind, VolumeShape, lights, show};

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
    /// Counts where the spaces behind what faces a light begin, before each surface: at the triangles themselves, cut by the near
    /// plane as surfaces are. For lights with shadow volumes, each before it is added.
    ShadowNearEnds,
    /// Likewise where these spaces end, at their walls or never, and where those begin whose triangles the far plane would cut off.
    ShadowVolume,
    /// Adds a light where none was counted, and clears the counts.
    ShadowedLight,
    /// Applies the tone curve.
    Tonemap,
    /// Paints decals of one kind over the G-buffer.
    Decal(DecalKind),
    /// Marks in the stencil the pixels that are lit sample by sample.
    Edges,
    /// [`Self::Lighting`] of the samples of marked pixels; that is then for the others.
    EdgeLighting,
    /// [`Self::LightVolume`] likewise.
    EdgeVolume(VolumeShape),
    /// Lays fog over what the G-buffer holds, before blended surfaces are drawn.
    Fog,
    /// Finds the depth of the farthest blended surfaces that are before what was found last, as [`SurfaceKind::depth`] sorts
    /// them.
    Peel {
        /// What they are.
        kind: SurfaceKind,
        /// Whether they are to be before what is opaque, not before another layer.
        first: bool,
    },
    /// Blends what was collected of blended surfaces over the light.
    Composite,
    /// Multiplies what is behind surfaces of a kind by what they let through; drawn before [`Self::Surface`] of each, which adds their
    /// own light.
    Absorb(SurfaceKind),
    /// Copies light and depth that are sampled to where media are drawn.
    Backdrop,
    /// Adds the light of particles of one kind.
    Particles(ParticleKind),
    /// Draws triangles of the host's over the picture, at the end of the last stage.
    Overlay,
    /// Writes what the options ask to show in place of the picture; of edges, those that are none.
    Show,
    /// [`Self::Show`] of marked pixels.
    ShowEdges,
}

impl Pipeline {
    /// Whether it draws surfaces, not all pixels.
    pub fn is_of_surfaces(&self) -> bool {
        matches!(
            self,
            Self::Surface(_) | Self::Depth(_) | Self::Light(_) | Self::Peel { .. } | Self::Absorb(_)
        )
    }

    /// Whether it reads what its stage reads of attachments, and nothing of materials.
    pub fn reads_attachments(&self) -> bool {
        let whole = matches!(
            self,
            Self::Lighting
                | Self::ShadowedLight
                | Self::Tonemap
                | Self::Fog
                | Self::Composite
                | Self::Backdrop
                | Self::Show
        );
        let edges = matches!(self, Self::Edges | Self::EdgeLighting | Self::EdgeVolume(_));
        whole || edges || matches!(self, Self::LightVolume(_) | Self::Peel { .. })
    }

    /// Whether it draws surfaces that are blended.
    pub fn is_of_blended(&self) -> bool {
        matches!(self, Self::Surface(kind) if kind.blend)
            || matches!(self, Self::Peel { .. } | Self::Absorb(_))
    }

    /// The pipeline that does for pixels what this does for samples; itself, if there is none.
    pub fn per_pixel(&self) -> Self {
        match *self {
            Self::EdgeLighting => Self::Lighting,
            Self::EdgeVolume(shape) => Self::LightVolume(shape),
            Self::ShowEdges => Self::Show,
            other => other,
        }
    }

    /// Whether it draws surfaces of this kind.
    pub fn draws(&self, kind: &SurfaceKind) -> bool {
        match self {
            Self::Surface(own) | Self::Light(own) => own == kind,
            Self::Peel { kind: own, .. } => kind.blend && !kind.transmits && *own == kind.depth(),
            Self::Depth(own) => !kind.blend && *own == kind.depth(),
            _ => false,
        }
    }
}

/// Those that draw a frame, with the stage they belong to, in order of drawing.
pub(super) fn of(
    frame: &Frame,
    needs: &Needs,
    has_overlay: bool,
    (way, edges, by_volume): (LightWay, Edges, bool),
) -> Vec<(usize, Pipeline)> {
    let stage = |name| frame.stages.iter().position(|s| s.name == name);
    let opaque = || needs.kinds.iter().filter(|n| !n.kind.blend);
    let depths: BTreeSet<_> = opaque().map(|n| n.kind.depth()).collect();
    let depths =
        stage("depth").into_iter().flat_map(|s| depths.iter().map(move |&k| (s, Pipeline::Depth(k))));
    let surface = stage("geometry").or(stage("forward")).unwrap_or(0);
    let surfaces = opaque().map(|n| (surface, Pipeline::Surface(n.kind)));
    let lights = stage("lights").into_iter().flat_map(|s| {
        let lit = opaque().filter(|n| !n.kind.unlit);
        lit.map(move |n| (s, Pipeline::Light(n.kind)))
    });
    let lighting =
        stage("lighting").into_iter().flat_map(|s| lights::pipelines(needs, way, edges).map(move |p| (s, p)));
    let volumes = stage("lighting").filter(|_| by_volume);
    let volumes = volumes.into_iter().flat_map(|s| {
        [Pipeline::ShadowNearEnds, Pipeline::ShadowVolume, Pipeline::ShadowedLight].map(|p| (s, p))
    });
    let tonemap = stage("tonemap").map(|s| (s, Pipeline::Tonemap));
    let sky = needs.sky.then_some((surface, Pipeline::Sky));
    let decals = stage("decals")
        .into_iter()
        .flat_map(|s| needs.decals.iter().map(move |n| (s, Pipeline::Decal(n.kind))));
    let blended = || needs.kinds.iter().filter(|n| n.kind.blend && !n.kind.transmits);
    let transmits = || needs.kinds.iter().filter(|n| n.kind.transmits).map(|n| n.kind);
    let silhouettes: BTreeSet<_> = blended().map(|n| n.kind.depth()).collect();
    let collected = stage(LAYERS).is_some();
    let mut translucency = Vec::new();
    for (s, at) in frame.stages.iter().enumerate() {
        let reads = at.uses.iter().any(|(_, how)| *how == Use::Read);
        match at.name {
            FOG => translucency.push((s, Pipeline::Fog)),
            BACKDROP => translucency.push((s, Pipeline::Backdrop)),
            TRANSLUCENCY if collected => translucency.push((s, Pipeline::Composite)),
            TRANSLUCENCY | LAYERS => {
                translucency.extend((reads && needs.fog.is_some()).then_some((s, Pipeline::Fog)));
                translucency.extend(blended().map(|n| (s, Pipeline::Surface(n.kind))));
            }
            MEDIA => {
                let refracts = at.uses.iter().any(|(_, how)| *how == Use::Sample);
                let alone = transmits().filter(|_| refracts).map(Pipeline::Surface);
                translucency.extend(alone.map(|pipeline| (s, pipeline)));
                let both = transmits()
                    .filter(|_| !refracts)
                    .flat_map(|kind| [Pipeline::Absorb(kind), Pipeline::Surface(kind)]);
                translucency.extend(both.map(|pipeline| (s, pipeline)));
            }
            PARTICLES => {
                translucency.extend(needs.particles.iter().map(|n| (s, Pipeline::Particles(n.kind))))
            }
            PEEL => {
                let first = stage(PEEL) == Some(s);
                translucency.extend(silhouettes.iter().map(|&kind| (s, Pipeline::Peel { kind, first })));
            }
            _ => {}
        }
    }
    let shaded = depths.chain(surfaces).chain(sky).chain(decals).chain(lights).chain(lighting).chain(volumes);
    let shown = stage(show::NAME).into_iter().flat_map(|s| {
        let marks = edges != Edges::All;
        let all = [(marks, Pipeline::Edges), (true, Pipeline::Show), (marks, Pipeline::ShowEdges)];
        all.into_iter().filter(|(exists, _)| *exists).map(move |(_, p)| (s, p))
    });
    let overlay = has_overlay.then_some((frame.stages.len() - 1, Pipeline::Overlay));
    shaded.chain(translucency).chain(tonemap).chain(shown).chain(overlay).collect()
}

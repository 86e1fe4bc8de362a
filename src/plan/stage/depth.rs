//! The depth attachment, and the stage that fills it first where one does.

use super::{Asked, Frame, Use};
use crate::plan::layout::{Target, Tells};
use crate::plan::{DepthStore, Edges, Format, LightWay, Path};

/// The depth attachment, where a frame has one.
pub(super) struct Depth {
    /// Its resource.
    pub(super) resource: Option<usize>,
    /// How the stage that draws surfaces uses it.
    pub(super) drawn: Option<(usize, Use)>,
    /// Whether later stages read it as an input attachment.
    pub(super) is_read: bool,
}

/// Adds them where something needs them.
pub(super) fn add(frame: &mut Frame, asked: &Asked) -> Depth {
    let Asked { needs, options, gbuffer, path, way, edges, depth_stencil, by_volume, .. } = *asked;
    let one_by_one = asked.one_by_one();
    let opaque = needs.opaque_triangles();
    let before_sky = needs.sky && opaque > 0;
    let hides = opaque > 1 || (opaque == 1 && needs.blended.is_some());
    let is_read = path == Path::Deferred && needs.lit_opaque.is_some() && gbuffer.reads_depth_attachment();
    let marks_edges = edges != Edges::All;
    let fades = opaque > 0 && !needs.particles.is_empty();
    let absorbs = opaque > 0 && needs.transmits.is_some();
    if !(hides
        || fades
        || absorbs
        || one_by_one
        || before_sky
        || is_read
        || marks_edges
        || options.edge_filter)
    {
        return Depth { resource: None, drawn: None, is_read };
    }
    let stencil = asked.has_stencil() || marks_edges;
    let target = Target {
        name: match (is_read, stencil) {
            (true, _) => "depth",
            (false, true) => "depth_stencil_test",
            (false, false) => "depth_test",
        },
        format: match gbuffer.depth {
            _ if stencil => depth_stencil,
            DepthStore::D24 if is_read => Format::D24Unorm,
            DepthStore::D16 if is_read => Format::D16Unorm,
            _ => Format::D32Float,
        },
        holds: match (marks_edges, way) {
            (true, LightWay::Stencil) => {
                "reversed device depth, 0 is far; stencil: 1 bit edges, 7 surfaces in a light's volume"
            }
            (true, _) => "reversed device depth, 0 is far; stencil: edges",
            _ if by_volume => "reversed device depth, 0 is far; stencil: spaces in shadow around a surface",
            _ if stencil => "reversed device depth, 0 is far; stencil: surfaces in a light's volume",
            _ => "reversed device depth, 0 is far",
        },
        used_bits: if stencil { depth_stencil.bits() } else { 32 },
        clear: Some([0.0; 4]),
        tells: Tells::Position,
    };
    let mut why = Vec::new();
    why.extend(hides.then(|| format!("{} triangles hide each other", needs.triangles)));
    why.extend(fades.then(|| "particles fade in front of it".into()));
    why.extend(absorbs.then(|| "light is absorbed on the way to it".into()));
    why.extend(is_read.then(|| "lighting reads it".into()));
    why.extend(way.is_one_by_one().then(|| "a light's volume is tested against it".into()));
    why.extend(by_volume.then(|| "shadow volumes are tested against it".into()));
    why.extend(marks_edges.then(|| "edges are marked beside it".into()));
    why.extend(before_sky.then(|| "the sky is behind them".into()));
    let depth = frame.add_target(&target, options.keep_gbuffer && is_read, why.join("; "));
    let drawn = if options.depth_prepass && opaque > 0 {
        let why = "what is nearest is found first, so that no pixel is shaded twice";
        frame.add_stage("depth", [(depth, Use::Depth)], why.into());
        Use::DepthTest
    } else {
        Use::Depth
    };
    Depth { resource: Some(depth), drawn: Some((depth, drawn)), is_read }
}

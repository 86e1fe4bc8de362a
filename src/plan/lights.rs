//! How lights reach pixels: what was asked for, and what comes of it for a scene.

use serde::Serialize;

use super::{Edges, LightWay, Needs, Options, Path, Pipeline, Show};
use crate::visible::{Clusters, Grid, Reach};

/// The bounds of one frame's light lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ClusterBudget {
    /// Cells of the view.
    pub most_cells: usize,
    /// 32-bit words: where each cell's list begins, and the lists.
    pub most_words: usize,
    /// Memory for each frame in flight, its header included.
    pub bytes: u64,
}

impl ClusterBudget {
    /// Tile size, cells along each axis, scale and bias of slices, 32 bits each.
    const HEADER_BYTES: u64 = 24;

    fn new(lights: usize) -> Self {
        let most_words = Clusters::most_words(lights);
        Self { most_cells: Grid::MOST_CELLS, most_words, bytes: Self::HEADER_BYTES + 4 * most_words as u64 }
    }
}

impl std::fmt::Display for ClusterBudget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { most_cells, bytes, .. } = self;
        write!(
            f,
            "each pixel looks at the lights listed for its part of the view: at most {most_cells} lists in {bytes} bytes \
             for each frame in flight"
        )
    }
}

/// How a light is drawn that is added by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VolumeShape {
    /// A triangle over the whole image, for lights without an end and volumes that the far plane cuts.
    Screen,
    /// An icosahedron around a sphere.
    Sphere,
    /// A pyramid around a cone.
    Cone,
    /// A box.
    Box,
}

impl VolumeShape {
    /// Every shape, in the order in which they are drawn.
    pub const ALL: [Self; 4] = [Self::Screen, Self::Sphere, Self::Cone, Self::Box];

    /// Cones wider than this are taken as spheres, which hold less: half angles of more than 60 degrees.
    const LEAST_CONE_COS: f32 = 0.5;

    /// The shape of what a light reaches.
    pub fn of(reach: &Reach) -> Self {
        match *reach {
            Reach::Cone { cos, range_m, .. } if range_m.is_finite() => {
                if cos >= Self::LEAST_CONE_COS {
                    Self::Cone
                } else {
                    Self::Sphere
                }
            }
            Reach::Sphere { .. } => Self::Sphere,
            Reach::Box { .. } => Self::Box,
            Reach::Everywhere | Reach::Cone { .. } => Self::Screen,
        }
    }

    /// Those that the scene's lights may come to have, as hosts change ranges and cones.
    fn needed(needs: &Needs) -> impl Iterator<Item = Self> {
        let needed = [
            needs.local_lights() > 0,
            needs.point_lights + needs.spot_lights > 0,
            needs.spot_lights > 0,
            needs.box_lights > 0,
        ];
        Self::ALL.into_iter().zip(needed).filter(|(_, needed)| *needed).map(|(shape, _)| shape)
    }
}

impl std::fmt::Display for VolumeShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Screen => "whole image (no end, or cut by the far plane)",
            Self::Sphere => "icosahedron around its sphere",
            Self::Cone => "pyramid around its cone",
            Self::Box => "box",
        })
    }
}

impl LightWay {
    /// Whether lights are added to what is there one after the other.
    pub fn is_one_by_one(self) -> bool {
        matches!(self, Self::Volumes | Self::Stencil)
    }
}

/// What draws the lights of a G-buffer; those of edges by sample, once these are marked.
pub(super) fn pipelines(needs: &Needs, way: LightWay, edges: Edges) -> impl Iterator<Item = Pipeline> {
    let has_edges = edges != Edges::All;
    let one_by_one = way.is_one_by_one();
    let at_once = !one_by_one || needs.global_lights() > 0 || needs.painted_around.any();
    let shapes = VolumeShape::needed(needs).filter(move |_| one_by_one);
    let volumes = shapes.flat_map(move |shape| {
        let masked = way == LightWay::Stencil && shape != VolumeShape::Screen;
        let mask = masked.then_some(Pipeline::LightMask(shape));
        let edges = has_edges.then_some(Pipeline::EdgeVolume(shape));
        mask.into_iter().chain([Pipeline::LightVolume(shape)]).chain(edges)
    });
    let marks = has_edges.then_some(Pipeline::Edges).into_iter();
    let by_sample = (has_edges && at_once).then_some(Pipeline::EdgeLighting);
    marks.chain(at_once.then_some(Pipeline::Lighting)).chain(by_sample).chain(volumes)
}

/// What [`Options::lights`] comes to.
pub(super) struct Resolved {
    /// Never [`LightWay::Auto`].
    pub way: LightWay,
    pub clusters: Option<ClusterBudget>,
    /// Where it is not what was asked for, or a choice was made.
    pub why: Option<String>,
}

/// # Errors
/// [`crate::Error::Unsupported`] for lights that are added one by one to surfaces that are lit as they are drawn.
pub(super) fn resolve(needs: &Needs, options: &Options, path: Path) -> crate::Result<Resolved> {
    let ended = needs.local_lights() - needs.endless_lights;
    let (way, why) = match options.lights {
        // There is nothing to light, whatever was asked for.
        _ if needs.lit.is_none() || !matches!(options.show, Show::Picture | Show::Lights) => {
            (LightWay::Fullscreen, None)
        }
        LightWay::Volumes | LightWay::Stencil if options.show.is_debug() => (LightWay::Fullscreen, None),
        // Lights are added one by one, whatever they could be looked up in.
        LightWay::Clusters | LightWay::Auto if path == Path::ForwardMultipass => (LightWay::Fullscreen, None),
        // From the first light on: on GPUs lists are ahead of all other ways, whatever the number of lights. On llvmpipe
        // volumes are, up to about 30 small lights, but fall behind where lights overlap (assets/comparison).
        LightWay::Auto if ended > 0 => {
            let lights = if ended == 1 { "1 light has".to_owned() } else { format!("{ended} lights have") };
            (LightWay::Clusters, Some(format!("lights: clusters, since {lights} a place and an end")))
        }
        LightWay::Auto => (LightWay::Fullscreen, None),
        LightWay::Fullscreen => (LightWay::Fullscreen, None),
        asked if needs.local_lights() == 0 => {
            (LightWay::Fullscreen, Some(format!("lights: fullscreen, not {asked}: no light has a place")))
        }
        asked @ (LightWay::Volumes | LightWay::Stencil) if path != Path::Deferred => {
            return Err(crate::Error::unsupported(
                format!("{asked} needs a G-buffer to add lights to, which the path {path} has not"),
                "choose the path deferred, or one of the ways fullscreen and clusters",
            ));
        }
        asked => (asked, None),
    };
    let clusters = (way == LightWay::Clusters).then(|| ClusterBudget::new(needs.most_local_lights));
    Ok(Resolved { way, clusters, why })
}

//! How lights reach pixels: what was asked for, and what comes of it for a scene.

use serde::Serialize;

use super::{LightWay, Needs, Options, Path};
use crate::visible::{Clusters, Grid};

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

/// The way, never [`LightWay::Auto`]; what it needs; and why it was chosen, where that is not what was asked for.
pub(super) fn resolve(
    needs: &Needs,
    options: &Options,
    path: Path,
) -> (LightWay, Option<ClusterBudget>, Option<String>) {
    let local = needs.local_lights();
    let (way, why) = match options.lights {
        _ if needs.lit.is_none() || path == Path::ForwardMultipass => (LightWay::Fullscreen, None),
        LightWay::Fullscreen => (LightWay::Fullscreen, None),
        asked if local == 0 => {
            let why = format!("lights: fullscreen, not {asked}: no light has a place");
            (LightWay::Fullscreen, (asked != LightWay::Auto).then_some(why))
        }
        asked => (asked, None),
    };
    let clusters = (way == LightWay::Clusters).then(|| ClusterBudget::new(needs.most_local_lights));
    (way, clusters, why)
}

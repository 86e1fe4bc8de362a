//! Which pixels are lit sample by sample.

use super::layout::LightPlace;
use super::{Edges, GBuffer, LightWay, Needs, Options, Path, Show};

/// What [`Options::edges`] comes to, never [`Edges::Auto`], and why, where that is not what was asked for.
///
/// `auto` compares: the picture is that of all samples to the bit, which `coverage` does not promise where surfaces touch, and a
/// pixel takes a byte a sample less. Neither is faster everywhere: on an H200 `compare` takes 1.03, 0.95 and 1.07 of `coverage`'s time
/// (lamps, courtyard, interior), on llvmpipe 0.9 to 1.0. There both lose to `all`, whose loops are as wide as its vectors; on a GPU `all` takes 1.3
/// to 1.8 times as long.
pub(super) fn resolve(
    needs: &Needs,
    options: &Options,
    gbuffer: &GBuffer,
    path: Path,
    way: LightWay,
) -> (Edges, Option<String>) {
    let shows = matches!(options.show, Show::Picture | Show::Edges);
    if !shows || options.samples == 1 || path != Path::Deferred || needs.lit_opaque.is_none() {
        return (Edges::All, None);
    }
    let in_order = way.is_one_by_one() && matches!(gbuffer.light, LightPlace::Read(_));
    match options.edges {
        Edges::All => (Edges::All, Some("every sample is lit".into())),
        asked if in_order => (
            Edges::All,
            Some(format!("every sample is lit, not only edges ({asked}): the shader adds light to each sample's own words")),
        ),
        Edges::Auto | Edges::Compare => (
            Edges::Compare,
            Some("lit once: pixels whose samples agree in what lighting reads; the others are marked in the stencil and lit by sample".into()),
        ),
        Edges::Coverage => (
            Edges::Coverage,
            Some("lit once: pixels of which no triangle covers a part of the samples only; the others are marked in the stencil and lit by sample".into()),
        ),
    }
}

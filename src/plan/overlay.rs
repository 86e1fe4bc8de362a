//! Triangles over the picture: a draw of its last stage.

use super::{Attachment, BloomWay, Options, Pass};
use crate::{Error, Result};

/// What draws over the picture writes nothing else but what leaves the light that bloom stores as it is.
pub(super) fn check(options: &Options, passes: &[Pass]) -> Result<()> {
    let last = passes.last().and_then(|pass| pass.subpasses.last());
    let stored = usize::from(options.bloom == BloomWay::Store);
    let besides = last.filter(|subpass| options.overlay && subpass.colors.len() > 1 + stored);
    let Some(subpass) = besides else { return Ok(()) };
    Err(Error::unsupported(
        format!(
            "an overlay cannot be drawn at the end of '{}', which writes more than the picture",
            subpass.name
        ),
        "leave the overlay out",
    ))
}

/// Where it goes.
pub(super) fn note(options: &Options, passes: &[Pass]) -> Option<String> {
    let last = passes.last().and_then(|pass| pass.subpasses.last()).filter(|_| options.overlay)?;
    let after = match (options.edge_filter, options.bloom) {
        (true, _) => ", before edges are smoothed, its own too",
        (_, BloomWay::Previous) => "; what it shows is scattered too",
        (_, BloomWay::Store) => "; the light that is stored for bloom is without it",
        _ => "",
    };
    Some(format!(
        "overlay: drawn at the end of '{}', from which nothing is loaded or stored{after}",
        last.name
    ))
}

/// Marks what it is blended over.
pub(super) fn blend(options: &Options, passes: &[Pass], attachments: &mut [Attachment]) {
    let last = passes.last().filter(|_| options.overlay);
    let Some((pass, subpass)) = last.and_then(|pass| Some((pass, pass.subpasses.last()?))) else { return };
    for &color in &subpass.colors {
        attachments[pass.attachments[color].attachment].usage.blend = true;
    }
}

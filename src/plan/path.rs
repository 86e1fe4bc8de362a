//! When surfaces are lit: what was asked for, and what comes of it for a scene.

use super::{Needs, Options, Path};
use crate::{Error, Result};

/// The path, never [`Path::Auto`], and why, where that is not what was asked for.
///
/// # Errors
/// [`Error::Unsupported`] if a G-buffer is to be kept on a path that has none, and for [`Path::Auto`], for which there is no
/// rule yet.
pub(super) fn resolve(needs: &Needs, options: &Options) -> Result<(Path, Option<String>)> {
    let no_lights = needs.listed_lights() == 0;
    let (path, why) = match options.path {
        Path::Auto => {
            return Err(Error::unsupported(
                "the path auto has no rule yet",
                "choose the path deferred, forward or forward-multipass",
            ));
        }
        Path::ForwardMultipass if needs.lit.is_some() && no_lights => {
            (Path::Forward, Some("path: forward, not forward-multipass: there are no lights to add".into()))
        }
        asked => (asked, None),
    };
    if path != Path::Deferred && options.keep_gbuffer {
        return Err(Error::unsupported(
            format!("the path {path} has no G-buffer that could be kept"),
            "choose the path deferred, or leave `keep_gbuffer` out",
        ));
    }
    Ok((path, why))
}

/// What a forward path makes of the options that are meant for deferred shading.
pub(super) fn notes(options: &Options, path: Path) -> Vec<String> {
    let Options { layout, lights, .. } = options;
    match path {
        Path::Deferred | Path::Auto => Vec::new(),
        Path::Forward => vec![format!(
            "surfaces are lit as they are drawn: no G-buffer (the layout {layout} is not used), no light target"
        )],
        Path::ForwardMultipass => {
            let sets = if options.illumination_sets {
                "for each light the objects that its reach touches are drawn again"
            } else {
                "for each light all objects are drawn again: illumination sets are off"
            };
            vec![
                format!("no G-buffer: of the layout {layout} only the light target is used"),
                format!("{sets} (the way of lights {lights} is not used)"),
            ]
        }
    }
}

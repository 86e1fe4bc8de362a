//! When surfaces are lit: what was asked for, and what comes of it for a scene.

use super::{BloomWay, LightWay, Limits, Needs, Options, Path, Strategy};
use crate::{Error, Result};

/// [`Path::Auto`] is forward where a point of the scene is reached by at most so many lights on average. Where the G-buffer
/// stays on the chip, deferred costs no memory traffic, and it lights each pixel once however many surfaces lie behind each
/// other. Measured on llvmpipe, whose G-buffer is in the processor's cache: forward is ahead in the
/// canyon (1 light) and over the floor with 64 small ones (1.7), deferred in the generator hall (2.7).
const MOST_FOR_FORWARD_ON_CHIP: f32 = 2.0;

/// The same where the G-buffer goes to memory and back. Measured on an H200: forward is ahead where 16 lights overlap at each
/// pixel, and level over the floor with 1024 (27.5).
const MOST_FOR_FORWARD_IN_MEMORY: f32 = 20.0;

/// The path, never [`Path::Auto`], and why, where that is not what was asked for.
///
/// # Errors
/// [`Error::Unsupported`] if a G-buffer is to be kept on a path that has none.
pub(super) fn resolve(
    needs: &Needs,
    options: &Options,
    strategy: Strategy,
    limits: &Limits,
) -> Result<(Path, Option<String>)> {
    let no_lights = needs.listed_lights() == 0;
    let only_blended = needs.lit.is_some() && needs.lit_opaque.is_none();
    let wants_gbuffer = options.show.is_debug()
        || options.keep_gbuffer
        || options.edge_filter
        || options.bloom != BloomWay::Off;
    let (path, why) = match options.path {
        Path::Auto if !needs.decals.is_empty() => {
            (Path::Deferred, Some("path: deferred, since decals are painted over its G-buffer".into()))
        }
        _ if only_blended => (Path::Forward, Some("path: forward, since all that is lit is blended".into())),
        Path::Auto if options.keep_gbuffer => {
            (Path::Deferred, Some("path: deferred, since its G-buffer is to be kept".into()))
        }
        Path::Auto if wants_gbuffer && needs.lit.is_some() => (
            Path::Deferred,
            Some(
                "path: deferred, for bloom, the edge filter and --show, which need a stage over all pixels"
                    .into(),
            ),
        ),
        Path::Auto
            if needs.local_lights() > 0
                && matches!(options.lights, LightWay::Volumes | LightWay::Stencil) =>
        {
            (Path::Deferred, Some(format!("path: deferred, since {} need its G-buffer", options.lights)))
        }
        Path::Auto => {
            let (path, why) = choose(needs.lights_at_a_point, strategy, limits);
            (path, Some(why))
        }
        Path::ForwardMultipass if needs.lit.is_some() && no_lights => {
            (Path::Forward, Some("path: forward, not forward-multipass: there are no lights to add".into()))
        }
        Path::Deferred
            if needs.lit.is_some()
                && !wants_gbuffer
                && needs.decals.is_empty()
                && no_lights
                && needs.hemisphere_lights == 0 =>
        {
            (
                Path::Forward,
                Some("path: forward, not deferred: there are no lights to read a G-buffer for".into()),
            )
        }
        asked => (asked, None),
    };
    if let Some(decal) = needs.decals.first().filter(|_| path != Path::Deferred) {
        return Err(Error::unsupported(
            format!("{} is painted over a G-buffer, which the path {path} has not", decal.why),
            "use --path deferred or auto, or take the decals out of the scene",
        ));
    }
    if path != Path::Deferred && options.keep_gbuffer && !only_blended {
        return Err(Error::unsupported(
            format!("the path {path} has no G-buffer that could be kept"),
            "choose the path deferred, or leave `keep_gbuffer` out",
        ));
    }
    Ok((path, why))
}

/// The path where so many lights reach a point, and why.
fn choose(lights: f32, strategy: Strategy, limits: &Limits) -> (Path, String) {
    // What is printed is what was compared.
    let lights = (lights * 10.0).round() / 10.0;
    // Between separate passes it is stored and loaded on every device.
    let on_chip = limits.gbuffer_on_chip && strategy.is_merged();
    let most = if on_chip { MOST_FOR_FORWARD_ON_CHIP } else { MOST_FOR_FORWARD_IN_MEMORY };
    let (path, relation) =
        if lights <= most { (Path::Forward, "at most") } else { (Path::Deferred, "more than") };
    let place = match (on_chip, strategy.is_merged()) {
        (true, _) => "stays on the chip on this device",
        (_, true) => "goes to memory and back on this device",
        (_, false) => "goes to memory and back between separate passes",
    };
    let why = format!(
        "path: {path}, since {lights:.1} lights reach a point of the scene on average, {relation} {most:.0}, and a G-buffer \
         {place}"
    );
    (path, why)
}

/// What a forward path makes of the options that are meant for deferred shading.
pub(super) fn notes(options: &Options, path: Path, folded: bool) -> Vec<String> {
    let Options { layout, lights, .. } = options;
    match path {
        Path::Deferred | Path::Auto => Vec::new(),
        Path::Forward if folded => vec![format!(
            "surfaces are lit as they are drawn: no G-buffer (the layout {layout} is not used), no light target"
        )],
        Path::Forward => vec![format!(
            "surfaces are lit as they are drawn: no G-buffer, and of the layout {layout} only the light target is used"
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

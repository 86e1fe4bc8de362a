//! Lights whose shadows are counted in the stencil, on the tile, in place of being looked up in a map.
//!
//! Thibieroz 2004, "Shadows": with a G-buffer, only the volumes and one full-screen draw a light are needed. They are counted where a
//! surface is in front of them (Carmack; Bilodeau and Songy), so that the camera may be within. The stencil's highest bit is left to
//! others; 128 volumes around one point wrap round to none (`ontile stability --sweep shadow-volumes`).

use super::check::check_light;
use super::layout::GBuffer;
use super::needs::element;
use super::{LightWay, Limits, Needs, Options, Path};
use crate::{Error, Result};

/// Bits of the stencil that count.
pub const COUNT_BITS: u32 = 0x7f;

/// The lights (indices into `Scene::lights`) and what a reader should know of others.
pub(super) struct VolumeLights {
    pub(super) lights: Vec<usize>,
    pub(super) notes: Vec<String>,
}

/// Lights that ask for a volume have one where the frame can; `Options::shadow_volumes` asks for all that do not ask for the map.
///
/// # Errors
/// [`Error::Unsupported`] if the options ask for volumes and leave no G-buffer or ask for another use of the stencil, and where the
/// device cuts volumes off at the far plane.
pub(super) fn resolve(
    needs: &Needs,
    options: &Options,
    gbuffer: &GBuffer,
    path: Path,
    limits: &Limits,
) -> Result<VolumeLights> {
    let mut found = VolumeLights { lights: Vec::new(), notes: Vec::new() };
    let lights = &needs.shadows.lights;
    let any_asks = options.shadow_volumes || lights.iter().any(|light| light.volume == Some(true));
    if !any_asks || needs.lit.is_none() {
        return Ok(found);
    }
    let obstacle = obstacle(needs, options, gbuffer, path, limits);
    if let Some((what, remedy)) = &obstacle
        && options.shadow_volumes
    {
        return Err(Error::unsupported(
            what,
            format!("{remedy}, or leave --shadow-volumes out for shadow maps"),
        ));
    }
    let blended = needs
        .transmits
        .as_ref()
        .or(needs.blended.as_ref())
        .map(|_| "what is blended is lit as it is drawn, when no count is left");
    let in_all = obstacle.as_ref().map(|(what, _)| what.as_str()).or(blended);
    for need in lights {
        let (asks, why) = match need.volume {
            Some(volume) => (volume, "it asks for one"),
            None if options.shadow_volumes => (true, "all are asked to"),
            None => (false, "it asks for nothing else"),
        };
        let refused = need.no_volume.or(in_all).filter(|_| asks);
        let is_volume = asks && refused.is_none();
        found.lights.extend(is_volume.then_some(need.light));
        let has = if is_volume { "counts its shadow as volumes" } else { "keeps its shadow map" };
        let light = element("light", &need.name, need.light);
        found.notes.push(format!("{light} {has}: {}", refused.unwrap_or(why)));
    }
    if !found.lights.is_empty() {
        let lights = match found.lights.len() {
            1 => "1 light".into(),
            n => format!("{n} lights"),
        };
        found.notes.push(format!(
            "shadow volumes: {lights}, each added by itself after its shadows were counted in the stencil, which never leaves the tile"
        ));
    }
    Ok(found)
}

/// What keeps every light of the frame from volumes, and what to do about it.
fn obstacle(
    needs: &Needs,
    options: &Options,
    gbuffer: &GBuffer,
    path: Path,
    limits: &Limits,
) -> Option<(String, String)> {
    if path != Path::Deferred {
        let what = format!("shadow volumes need a G-buffer, which the path {path} has not");
        return Some((what, "use --path deferred".into()));
    }
    if let asked @ (LightWay::Volumes | LightWay::Stencil) = options.lights {
        let what = format!("shadow volumes add their lights by themselves, and '{asked}' would do it again");
        return Some((what, "use --lights auto, clusters or fullscreen".into()));
    }
    if !limits.depth_clamp {
        let what = "the device has no depthClamp or no shaderClipDistance, without which shadow volumes are cut off at the far plane";
        return Some((what.into(), "use another device".into()));
    }
    // Lights with volumes are added one by one.
    match check_light(gbuffer, needs, options, true, limits) {
        Err(Error::Unsupported { what, remedy }) if needs.lit_opaque.is_some() => Some((what, remedy)),
        _ => None,
    }
}

//! Lights whose shadows are counted in the stencil, on the tile, in place of being looked up in a map.
//!
//! Thibieroz 2004, "Shadows": with a G-buffer, only the volumes and one full-screen draw a light are needed. They are counted where a
//! surface is in front of them (Carmack; Bilodeau and Songy), so that the camera may be within. The stencil's highest bit is left to
//! others; more than 127 volumes around one point wrap round.

use super::{LightWay, Limits, Needs, Options, Path};
use crate::{Error, Result};

/// Bits of the stencil that count.
pub const COUNT_BITS: u32 = 0x7f;

/// The lights (indices into `Scene::lights`) and what a reader should know of others.
pub(super) struct VolumeLights {
    pub(super) lights: Vec<usize>,
    pub(super) notes: Vec<String>,
}

/// # Errors
/// [`Error::Unsupported`] if the options leave no G-buffer or ask for another use of the stencil, and where the device cuts volumes
/// off at the far plane.
pub(super) fn resolve(needs: &Needs, options: &Options, path: Path, limits: &Limits) -> Result<VolumeLights> {
    let mut found = VolumeLights { lights: Vec::new(), notes: Vec::new() };
    if !options.shadow_volumes || needs.lit.is_none() {
        return Ok(found);
    }
    let refused = |what: String, remedy: &str| Err(Error::unsupported(what, remedy.to_owned()));
    if path != Path::Deferred {
        let what = format!("shadow volumes need a G-buffer, which the path {path} has not");
        return refused(what, "use --path deferred, or leave --shadow-volumes out for shadow maps");
    }
    if let asked @ (LightWay::Volumes | LightWay::Stencil) = options.lights {
        let what = format!("shadow volumes add their lights by themselves, and '{asked}' would do it again");
        return refused(what, "use --lights auto, clusters or fullscreen");
    }
    if !limits.depth_clamp {
        let what = "the device has no depthClamp, without which the far plane cuts shadow volumes off".into();
        return refused(what, "leave --shadow-volumes out for shadow maps");
    }
    for need in &needs.shadows.lights {
        let blended =
            needs.blended.as_ref().map(|_| "what is blended is lit as it is drawn, when no count is left");
        match need.no_volume.or(blended) {
            None => found.lights.push(need.light),
            Some(why) => found.notes.push(format!("light '{}' keeps its shadow map: {why}", need.name)),
        }
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

//! How far a picture is from another one, in place of it: the picture stays on the tile, the other one was drawn and stored before, and of
//! it each pixel is sampled once.

use super::{BloomWay, Options, Plan};
use crate::{Error, Result};

/// # Errors
/// [`Error::Unsupported`] for an amplification that is none, and where passes after the frame's own would work on it.
pub(super) fn check(options: &Options) -> Result<()> {
    let Some(gain) = options.difference else { return Ok(()) };
    if !(gain > 0.0 && gain.is_finite()) {
        return Err(Error::unsupported(
            format!("a difference cannot be amplified by {gain}"),
            "give a number above 0",
        ));
    }
    if options.bloom != BloomWay::Off || options.edge_filter {
        return Err(Error::unsupported(
            "a difference is no picture that passes after the frame's own could work on",
            "leave --bloom and --edge-filter out",
        ));
    }
    Ok(())
}

/// What it costs.
pub(super) fn note(options: &Options) -> Option<String> {
    let gain = options.difference?;
    let bytes = super::Format::from(options.output).bytes();
    Some(format!(
        "difference: the absolute difference from another picture as displays are told, times {gain}; that one is stored by a pass of \
         its own before ({bytes} bytes a pixel) and sampled here once ({bytes} bytes); this picture stays on the tile"
    ))
}

impl Plan {
    /// Bytes a pixel that are sampled of another picture.
    pub(super) fn compared_bytes(&self) -> f64 {
        let bytes = super::Format::from(self.options.output).bytes();
        if self.options.difference.is_some() { f64::from(bytes) } else { 0.0 }
    }
}

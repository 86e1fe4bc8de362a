//! Specialisation constants of passes after the frame's own.

use super::shared;
use super::specialization::Specialization;
use crate::plan::Tonemap;

impl Specialization {
    /// The constants of [`super::Module::Bloom`]: one of the numbers `BLOOM_STEP_*`, and the curve to undo, if any.
    pub fn bloom(step: u32, displayed: Option<Tonemap>) -> Self {
        Self::from_pairs(&[
            (const { shared("ID_BLOOM_STEP") }, step),
            (const { shared("ID_BLOOM_DISPLAYED") }, displayed.is_some().into()),
            (const { shared("ID_TONEMAP") }, displayed.map_or(0, curve)),
        ])
    }

    /// The constant of [`super::Module::EdgeFilter`] beside those of the G-buffer: what lies between two values of depth.
    pub fn edge_filter(depth_step: f32) -> Self {
        Self::from_pairs(&[(const { shared("ID_DEPTH_STEP") }, depth_step.to_bits())])
    }
}

/// The number of a tone curve.
pub(super) fn curve(tonemap: Tonemap) -> u32 {
    match tonemap {
        Tonemap::Neutral => const { shared("TONEMAP_NEUTRAL") },
        Tonemap::Aces => const { shared("TONEMAP_ACES") },
        Tonemap::Reinhard => const { shared("TONEMAP_REINHARD") },
        Tonemap::Linear => const { shared("TONEMAP_LINEAR") },
    }
}

//! Filters of shadow maps as shaders number them.

use super::shared;
use crate::plan::ShadowFilter;

pub(super) fn shadow_filter(filter: ShadowFilter) -> u32 {
    match filter {
        ShadowFilter::Hardware => const { shared("SHADOW_FILTER_HARDWARE") },
        ShadowFilter::Grid3 => const { shared("SHADOW_FILTER_GRID3") },
        ShadowFilter::Grid5 => const { shared("SHADOW_FILTER_GRID5") },
        ShadowFilter::Jittered => const { shared("SHADOW_FILTER_JITTERED") },
    }
}

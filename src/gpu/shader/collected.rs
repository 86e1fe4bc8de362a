//! Specialisation constants of what collects blended surfaces.

use super::{Specialization, shared};
use crate::plan::Translucency;

impl Specialization {
    /// Constants of the modules that draw what is blended, or compose what is collected of it: the way, how many layers are kept,
    /// and whether two of them share an attachment.
    pub fn translucency(way: Translucency, layers: u32, pairs: bool) -> Self {
        let collected = match way {
            Translucency::Sorted | Translucency::Peeled => const { shared("COLLECTED_NOT") },
            Translucency::Oit => const { shared("COLLECTED_LAYERS") },
            Translucency::Weighted => const { shared("COLLECTED_SUM") },
        };
        Self::from_pairs(&[
            (const { shared("ID_COLLECTED") }, collected),
            (const { shared("ID_LAYER_COUNT") }, layers),
            (const { shared("ID_LAYER_PAIRS") }, pairs.into()),
        ])
    }

    /// The constants of [`super::Module::Medium`]: whether it multiplies what is behind, and whether it samples that.
    pub fn medium(absorbs: bool, refracts: bool) -> Self {
        Self::from_pairs(&[
            (const { shared("ID_ABSORBS") }, absorbs.into()),
            (const { shared("ID_REFRACTS") }, refracts.into()),
        ])
    }

    /// Constants of what reads the depth of what is opaque behind it: whether there is any, and whether lighting reads it too.
    pub fn behind(lighting_reads: Option<bool>) -> Self {
        Self::from_pairs(&[
            (const { shared("ID_HAS_BEHIND") }, lighting_reads.is_some().into()),
            (const { shared("ID_BEHIND_OPAQUE") }, lighting_reads.unwrap_or_default().into()),
        ])
    }
}

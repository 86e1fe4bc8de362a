//! Constants of decals.

use super::{Specialization, shared};
use crate::plan::{Around, Channels};

/// Constants of the module that paints decals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DecalConstants {
    /// What this kind of decal paints.
    pub channels: Channels,
    /// What some decal of the scene changes: bit n is the target of that number.
    pub targets: u32,
    /// Fixed-function blending mixes.
    pub blended: bool,
}

impl DecalConstants {
    /// As ids and values.
    pub fn specialization(&self) -> Specialization {
        let Channels { base_color, normal, roughness, metallic } = self.channels;
        Specialization::from_pairs(&[
            (const { shared("ID_DECAL_BASE_COLOR") }, base_color.into()),
            (const { shared("ID_DECAL_NORMAL") }, normal.into()),
            (const { shared("ID_DECAL_ROUGHNESS") }, roughness.into()),
            (const { shared("ID_DECAL_METALLIC") }, metallic.into()),
            (const { shared("ID_DECAL_TARGETS") }, self.targets),
            (const { shared("ID_DECAL_BLENDED") }, self.blended.into()),
        ])
    }
}

impl Specialization {
    /// Of lighting, which adds what surfaces receive from all around; the rest is as in [`GeometryConstants`].
    pub fn around(around: Around, rgbm: bool, has_environment: bool) -> Self {
        Self::from_pairs(&[
            (const { shared("ID_AMBIENT") }, (around >= Around::Ambient).into()),
            (const { shared("ID_ENVIRONMENT") }, (around >= Around::Environment).into()),
            (const { shared("ID_PROBES") }, (around >= Around::Probes).into()),
            (const { shared("ID_RGBM") }, rgbm.into()),
            (const { shared("ID_HAS_ENVIRONMENT") }, has_environment.into()),
        ])
    }
}

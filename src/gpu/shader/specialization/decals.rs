//! Constants of decals.

use super::{Specialization, shared};
use crate::plan::Channels;

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

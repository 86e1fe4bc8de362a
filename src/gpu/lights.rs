//! The scene's lights as they stand, and what of them a view sees, in the order in which shaders go through them.

use super::convert;
use super::shared::LightData;
use crate::plan::ShadowMap;
use crate::scene::{Light, LightKind};
use crate::visible::{Frustum, Reach};

/// How many kinds of lights shaders tell apart.
const KINDS: usize = 3;

/// All lights that are not dark, by kind.
pub(super) struct Lights {
    of_kind: [Vec<Placed>; KINDS],
}

struct Placed {
    data: LightData,
    reach: Reach,
}

/// Which of [`KINDS`] it is; lights of a kind follow each other in the buffer, in this order.
fn kind_index(kind: &LightKind) -> usize {
    match kind {
        LightKind::Directional { .. } | LightKind::Hemisphere { .. } | LightKind::Box { .. } => 0,
        LightKind::Point { .. } => 1,
        LightKind::Spot { .. } => 2,
    }
}

impl Lights {
    pub(super) fn new(lights: &[Light], shadow_map: Option<&ShadowMap>) -> Self {
        let mut of_kind = [const { Vec::new() }; KINDS];
        for (index, light) in lights.iter().enumerate().filter(|(_, l)| !l.is_dark()) {
            let shadow = shadow_map.map_or(0, |map| map.reference(index));
            let data = LightData { shadow, ..convert::light(light) };
            let placed = Placed { data, reach: Reach::of(light) };
            of_kind[kind_index(&light.kind)].push(placed);
        }
        Self { of_kind }
    }

    /// How many there are: the length of a buffer that can hold all of them.
    pub(super) fn count(&self) -> usize {
        self.of_kind.iter().map(Vec::len).sum()
    }

    /// Writes those that reach something that the view sees (all of them without a view), and returns how many they are
    /// of each kind: directional, point, spot.
    pub(super) fn write_visible(&self, view: Option<&Frustum>, out: &mut [LightData]) -> [u32; KINDS] {
        let mut end = 0;
        self.of_kind.each_ref().map(|lights| {
            let first = end;
            for light in lights {
                if !view.is_some_and(|view| view.misses(&light.reach)) {
                    out[end] = light.data;
                    end += 1;
                }
            }
            (end - first) as u32
        })
    }
}

//! The lights of each part of a view, as shaders find them.

use std::ops::Range;

use super::shared::ClusterGrid;
use crate::plan::Plan;
use crate::scene::Camera;
use crate::visible::{Clusters, Reach};

/// What the CPU remembers while it writes a frame's lists; all frame slots share it.
pub(super) struct LightLists {
    /// Of the lights that the frame sees, in their order.
    reaches: Vec<Reach>,
    /// `None` if the plan has no lists.
    clusters: Option<Clusters>,
}

impl LightLists {
    /// For scenes with so many lights.
    pub(super) fn new(plan: &Plan, lights: usize) -> Self {
        let clusters = plan.clusters.map(|_| Clusters::new(plan.needs.most_local_lights));
        Self { reaches: Vec::with_capacity(lights), clusters }
    }

    /// Of the lights that the frame sees, in their order.
    pub(super) fn reaches(&self) -> &[Reach] {
        &self.reaches
    }

    /// To be filled with what the frame sees.
    pub(super) fn reaches_mut(&mut self) -> &mut Vec<Reach> {
        &mut self.reaches
    }

    /// Lists the lights that have a place, by their part of all.
    pub(super) fn write(&mut self, camera: &Camera, size: [u32; 2], local: Range<u32>, out: &mut [u8]) {
        let Some(clusters) = &mut self.clusters else { return };
        let reaches = &self.reaches[local.start as usize..local.end as usize];
        clusters.build(camera, size, local.start, reaches);
        let grid = clusters.grid();
        let header = ClusterGrid {
            tile_shift: grid.tile_shift,
            columns: grid.columns,
            rows: grid.rows,
            slices: grid.slices,
            slice_scale: grid.slice_scale,
            slice_bias: grid.slice_bias,
        };
        let words: &[u8] = bytemuck::cast_slice(clusters.words());
        let (head, tail) = out.split_at_mut(size_of::<ClusterGrid>());
        head.copy_from_slice(bytemuck::bytes_of(&header));
        tail[..words.len()].copy_from_slice(words);
    }
}

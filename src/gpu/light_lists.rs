//! Which lights reach what, as the plan's way of lights wants it told: the lights of each part of the view, or the shapes
//! of those that are drawn one by one.

use std::ops::Range;

use super::shared::ClusterGrid;
use crate::plan::{LightWay, Plan, VolumeShape};
use crate::scene::{Camera, Projection};
use crate::visible::{Clusters, Reach};

/// What the CPU remembers of a frame while it records it; all frame slots share it.
pub(super) struct LightLists {
    /// Of the lights that the frame sees, in their order.
    reaches: Vec<Reach>,
    way: Way,
}

enum Way {
    /// Nothing is listed.
    Fullscreen,
    Clusters(Clusters),
    /// Of each of [`VolumeShape::ALL`], its part of the list.
    Volumes([Range<u32>; VolumeShape::ALL.len()]),
}

impl LightLists {
    /// For scenes with so many lights.
    pub(super) fn new(plan: &Plan, lights: usize) -> Self {
        let way = match plan.light_way {
            LightWay::Clusters => Way::Clusters(Clusters::new(plan.needs.most_local_lights)),
            LightWay::Volumes | LightWay::Stencil => Way::Volumes(Default::default()),
            LightWay::Fullscreen | LightWay::Auto => Way::Fullscreen,
        };
        Self { reaches: Vec::with_capacity(lights), way }
    }

    /// The size of a frame's lists; `None` if the way has none.
    pub(super) fn bytes(plan: &Plan) -> Option<u64> {
        match plan.light_way {
            LightWay::Clusters => plan.clusters.map(|c| c.bytes),
            LightWay::Volumes | LightWay::Stencil => {
                Some(size_of::<u32>() as u64 * plan.needs.most_local_lights as u64)
            }
            LightWay::Fullscreen | LightWay::Auto => None,
        }
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
        if let Some(clusters) = self.clusters(camera, size, local.clone()) {
            return write_clusters(clusters, out);
        }
        if let Way::Volumes(ranges) = &mut self.way {
            let reaches = &self.reaches[local.start as usize..local.end as usize];
            *ranges = write_volumes(camera, reaches, local.start, bytemuck::cast_slice_mut(out));
        }
    }

    /// Lists the lights of each cell, if the way is that; local ones have a place, by their part of all.
    pub(super) fn clusters(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        local: Range<u32>,
    ) -> Option<&Clusters> {
        let Way::Clusters(clusters) = &mut self.way else { return None };
        let reaches = &self.reaches[local.start as usize..local.end as usize];
        clusters.build(camera, size, local.start, reaches);
        Some(clusters)
    }

    /// The instances that draw the lights of a shape.
    pub(super) fn volumes(&self, shape: VolumeShape) -> Range<u32> {
        let index = VolumeShape::ALL.iter().position(|s| *s == shape);
        match (&self.way, index) {
            (Way::Volumes(ranges), Some(index)) => ranges[index].clone(),
            _ => 0..0,
        }
    }
}

fn write_clusters(clusters: &Clusters, out: &mut [u8]) {
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

/// Writes the lights' numbers, from `first` on, shape by shape.
fn write_volumes(
    camera: &Camera,
    reaches: &[Reach],
    first: u32,
    out: &mut [u32],
) -> [Range<u32>; VolumeShape::ALL.len()] {
    let mut end = 0;
    VolumeShape::ALL.map(|shape| {
        let begin = end;
        for (reach, number) in reaches.iter().zip(first..) {
            if shape_in(camera, reach) == shape {
                out[end as usize] = number;
                end += 1;
            }
        }
        begin..end
    })
}

/// A mesh that the far plane cuts has a hole where its far side should be.
fn shape_in(camera: &Camera, reach: &Reach) -> VolumeShape {
    /// Meshes are somewhat larger than what they hold: at most by a half.
    const ROOM: f32 = 1.5;
    let far = match camera.projection {
        Projection::Perspective { zfar_m, .. } => zfar_m.unwrap_or(f32::INFINITY),
        Projection::Orthographic { zfar_m, .. } => zfar_m,
    };
    let (place, range_m) = match *reach {
        Reach::Sphere { center_world, radius_m } => (center_world, radius_m),
        // A cone of at most 60 degrees, whose mesh is twice as long from the apex to the rim, or a sphere.
        Reach::Cone { apex_world, range_m, .. } => (apex_world, 2.0 * range_m),
        Reach::Box { center_world, half_axes_world } => {
            (center_world, half_axes_world.iter().map(|axis| axis.length()).sum())
        }
        Reach::Everywhere => return VolumeShape::Screen,
    };
    let from_eye = place - camera.world_from_view.w_axis.truncate();
    let distance = from_eye.dot(-camera.world_from_view.z_axis.truncate());
    match distance + ROOM * range_m < far {
        true => VolumeShape::of(reach),
        false => VolumeShape::Screen,
    }
}

//! What casts shadows, in the order in which it is drawn.

use std::ops::Range;

use super::super::convert;
use super::super::shared::InstanceData;
use crate::plan::{CasterKind, ShadowMap, SurfaceKind};
use crate::scene::{Aabb, Scene};
use crate::visible::Frustum;

/// Casters that one draw call can draw: of one mesh, side by side in the instance buffer.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    /// Index into `ShadowMap::casters`.
    pub(super) pipeline: usize,
    /// Index into `Scene::materials`, where a mask needs it.
    pub(super) material: Option<usize>,
    /// Index into `Scene::meshes`.
    pub(super) mesh: usize,
    /// Its part of the casters.
    pub(super) casters: Range<usize>,
}

struct Caster {
    data: InstanceData,
    bounds_world: Aabb,
}

/// All casters of a scene by batch, each batch without gaps in the instance buffer.
pub(super) struct Casters {
    pub(super) batches: Vec<Batch>,
    casters: Vec<Caster>,
}

impl Casters {
    pub(super) fn new(scene: &Scene, map: &ShadowMap) -> Self {
        let mut order: Vec<_> = scene
            .drawn_instances()
            .filter_map(|instance| {
                let mesh = &scene.meshes[instance.mesh];
                let material = &scene.materials[mesh.material];
                let surface = SurfaceKind::new(mesh, material, instance.is_mirrored(), false);
                let kind = CasterKind::new(&surface, material)?;
                let pipeline = map.casters.iter().position(|k| *k == kind);
                let masked = kind.mask.map(|_| mesh.material);
                Some((pipeline.expect("the plan was made for this scene"), masked, instance.mesh, instance))
            })
            .collect();
        order.sort_by_key(|&(pipeline, material, mesh, _)| (pipeline, material, mesh));
        let mut batches: Vec<Batch> = Vec::new();
        let mut casters = Vec::with_capacity(order.len());
        for (pipeline, material, mesh, instance) in order {
            let first = casters.len();
            let bounds = scene.meshes[mesh].bounds().expect("what has triangles has vertices");
            casters.push(Caster {
                data: convert::instance(&instance.world_from_object),
                bounds_world: bounds.transformed(&instance.world_from_object),
            });
            match batches.last_mut() {
                Some(last) if (last.pipeline, last.mesh) == (pipeline, mesh) => last.casters.end += 1,
                _ => batches.push(Batch { pipeline, material, mesh, casters: first..first + 1 }),
            }
        }
        Self { batches, casters }
    }

    pub(super) fn count(&self) -> usize {
        self.casters.len()
    }

    /// What is in the instance buffer.
    pub(super) fn data(&self) -> impl Iterator<Item = InstanceData> {
        self.casters.iter().map(|caster| caster.data)
    }

    /// Calls `draw` with every longest run of casters of a batch (with its index) that may be in the view.
    pub(super) fn in_view(&self, view: &Frustum, mut draw: impl FnMut(usize, &Batch, Range<usize>)) {
        for (index, batch) in self.batches.iter().enumerate() {
            let mut next = batch.casters.start;
            while let Some(run) = self.run(view, next..batch.casters.end) {
                next = run.end;
                draw(index, batch, run);
            }
        }
    }

    /// The first run of casters among these that may be in the view.
    fn run(&self, view: &Frustum, range: Range<usize>) -> Option<Range<usize>> {
        let seen = |i: &usize| !view.misses_aabb(&self.casters[*i].bounds_world);
        let first = range.clone().find(seen)?;
        let end = (first + 1..range.end).find(|i| !seen(i)).unwrap_or(range.end);
        Some(first..end)
    }
}

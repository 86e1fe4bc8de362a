//! What casts shadows, in the order in which it is drawn.

use std::ops::Range;

use glam::Mat4;

use super::super::convert;
use super::super::shared::InstanceData;
use crate::plan::{CasterKind, SceneKinds, ShadowMap, SurfaceKind};
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
    bounds_object: Aabb,
    bounds_world: Aabb,
    /// How often it was moved.
    moves: u64,
}

/// All casters of a scene by batch, each batch without gaps in the instance buffer.
pub(super) struct Casters {
    pub(super) batches: Vec<Batch>,
    casters: Vec<Caster>,
    /// Of each of the scene's instances, its place among `casters`.
    caster_of: Vec<Option<usize>>,
    moves: u64,
}

impl Casters {
    pub(super) fn new(scene: &Scene, map: &ShadowMap) -> Self {
        let kinds = SceneKinds::new(scene);
        let mut order: Vec<_> = scene
            .instances
            .iter()
            .enumerate()
            .filter(|(_, instance)| scene.is_drawn(instance))
            .filter_map(|(index, instance)| {
                let mesh = &scene.meshes[instance.mesh];
                let material = &scene.materials[mesh.material];
                let surface = SurfaceKind::new(&kinds, instance);
                let kind = CasterKind::new(&surface, material)?;
                let pipeline = map.casters.iter().position(|k| *k == kind);
                let masked = kind.mask.map(|_| mesh.material);
                Some((pipeline.expect("the plan was made for this scene"), masked, instance.mesh, index))
            })
            .collect();
        order.sort_unstable();
        let mut batches: Vec<Batch> = Vec::new();
        let mut casters = Vec::with_capacity(order.len());
        let mut caster_of = vec![None; scene.instances.len()];
        for (pipeline, material, mesh, index) in order {
            let first = casters.len();
            let world_from_object = &scene.instances[index].world_from_object;
            let bounds_object = scene.meshes[mesh].bounds().expect("what has triangles has vertices");
            caster_of[index] = Some(first);
            casters.push(Caster {
                data: convert::instance(world_from_object),
                bounds_object,
                bounds_world: bounds_object.transformed(world_from_object),
                moves: 0,
            });
            match batches.last_mut() {
                Some(last) if (last.pipeline, last.mesh) == (pipeline, mesh) => last.casters.end += 1,
                _ => batches.push(Batch { pipeline, material, mesh, casters: first..first + 1 }),
            }
        }
        Self { batches, casters, caster_of, moves: 0 }
    }

    pub(super) fn count(&self) -> usize {
        self.casters.len()
    }

    /// How often any of them was moved.
    pub(super) fn moves(&self) -> u64 {
        self.moves
    }

    /// Moves an element of `Scene::instances`; returns its new bounds if it casts shadows.
    pub(super) fn set(&mut self, instance: usize, world_from_object: &Mat4) -> Option<&Aabb> {
        let caster = &mut self.casters[self.caster_of[instance]?];
        caster.data = convert::instance(world_from_object);
        caster.bounds_world = caster.bounds_object.transformed(world_from_object);
        caster.moves += 1;
        self.moves += 1;
        Some(&caster.bounds_world)
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

    /// A number that differs (but for one chance in 2^64) if other casters are in the view, or one of them was moved: FNV-1a
    /// (Fowler, Noll and Vo 1991) over the casters' numbers and moves.
    pub(super) fn signature(&self, view: &Frustum) -> u64 {
        const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
        const PRIME: u64 = 0x0000_0100_0000_01b3;
        let seen = self.casters.iter().enumerate().filter(|(_, c)| !view.misses_aabb(&c.bounds_world));
        let words = seen.flat_map(|(i, caster)| [i as u64, caster.moves]);
        words
            .flat_map(u64::to_le_bytes)
            .fold(BASIS, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
    }
}

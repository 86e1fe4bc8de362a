//! What casts shadows, in the order in which it is drawn.

use std::ops::Range;

use glam::Mat4;

use super::super::convert;
use super::super::shared::InstanceData;
use super::tiles::{Moves, Signature};
use crate::plan::{CasterKind, SceneKinds, ShadowMap, SurfaceKind};
use crate::scene::{Aabb, Scene};
use crate::visible::{ShadowView, ShadowVolume, TexelArea};

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
    /// Whether they may move.
    dynamic: bool,
}

/// Some of the casters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Which {
    All,
    /// Those that stand still.
    Fixed,
    /// Those that may move.
    Dynamic,
}

impl Which {
    fn has(self, batch: &Batch) -> bool {
        match self {
            Self::All => true,
            Self::Fixed => !batch.dynamic,
            Self::Dynamic => batch.dynamic,
        }
    }
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
    /// Where the dynamic ones begin.
    first_dynamic: usize,
    moves: Moves,
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
                let pipeline = pipeline.expect("the plan was made for this scene");
                Some((instance.dynamic, pipeline, masked, instance.mesh, index))
            })
            .collect();
        order.sort_unstable();
        let mut batches: Vec<Batch> = Vec::new();
        let mut casters = Vec::with_capacity(order.len());
        let mut caster_of = vec![None; scene.instances.len()];
        let first_dynamic = order.partition_point(|&(dynamic, ..)| !dynamic);
        for (dynamic, pipeline, material, mesh, index) in order {
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
                Some(last) if (last.dynamic, last.pipeline, last.mesh) == (dynamic, pipeline, mesh) => {
                    last.casters.end += 1;
                }
                _ => batches.push(Batch { pipeline, material, mesh, casters: first..first + 1, dynamic }),
            }
        }
        Self { batches, casters, caster_of, first_dynamic, moves: Moves::default() }
    }

    pub(super) fn count(&self) -> usize {
        self.casters.len()
    }

    /// How often they were moved.
    pub(super) fn moves(&self) -> Moves {
        self.moves
    }

    /// Moves an element of `Scene::instances`; returns its new bounds if it casts shadows.
    pub(super) fn set(&mut self, instance: usize, world_from_object: &Mat4) -> Option<&Aabb> {
        let index = self.caster_of[instance]?;
        let caster = &mut self.casters[index];
        caster.data = convert::instance(world_from_object);
        caster.bounds_world = caster.bounds_object.transformed(world_from_object);
        caster.moves += 1;
        match index < self.first_dynamic {
            true => self.moves.fixed += 1,
            false => self.moves.dynamic += 1,
        }
        Some(&caster.bounds_world)
    }

    /// A mesh has these bounds now; returns those in the world of its casters.
    pub(super) fn set_bounds(&mut self, mesh: usize, bounds_object: &Aabb) -> Option<Aabb> {
        let mut all: Option<Aabb> = None;
        for batch in self.batches.iter().filter(|batch| batch.mesh == mesh) {
            for caster in &mut self.casters[batch.casters.clone()] {
                caster.bounds_object = *bounds_object;
                caster.bounds_world = bounds_object.transformed(&convert::placement(&caster.data));
                caster.moves += 1;
                all = Some(all.map_or(caster.bounds_world, |all| all.union(&caster.bounds_world)));
            }
            let moves = if batch.dynamic { &mut self.moves.dynamic } else { &mut self.moves.fixed };
            *moves += 1;
        }
        all
    }

    /// How many these are.
    pub(super) fn count_of(&self, which: Which) -> usize {
        match which {
            Which::All => self.casters.len(),
            Which::Fixed => self.first_dynamic,
            Which::Dynamic => self.casters.len() - self.first_dynamic,
        }
    }

    /// The part of a tile that dynamic casters cover in this view.
    pub(super) fn dynamic_area(&self, view: &ShadowView, texels: u32) -> TexelArea {
        let volume = view.volume();
        let seen = self.casters[self.first_dynamic..].iter().filter(|c| !volume.misses(&c.bounds_world));
        let areas = seen.map(|caster| view.area(&caster.bounds_world, texels));
        areas.fold(TexelArea::default(), TexelArea::union)
    }

    /// What is in the instance buffer.
    pub(super) fn data(&self) -> impl Iterator<Item = InstanceData> {
        self.casters.iter().map(|caster| caster.data)
    }

    /// Calls `draw` with every longest run of casters of a batch (with its index) that may be in the view.
    pub(super) fn in_view(
        &self,
        view: &ShadowVolume,
        which: Which,
        mut draw: impl FnMut(usize, &Batch, Range<usize>),
    ) {
        for (index, batch) in self.batches.iter().enumerate().filter(|(_, batch)| which.has(batch)) {
            let mut next = batch.casters.start;
            while let Some(run) = self.run(view, next..batch.casters.end) {
                next = run.end;
                draw(index, batch, run);
            }
        }
    }

    /// The first run of casters among these that may be in the view.
    fn run(&self, view: &ShadowVolume, range: Range<usize>) -> Option<Range<usize>> {
        let seen = |i: &usize| !view.misses(&self.casters[*i].bounds_world);
        let first = range.clone().find(seen)?;
        let end = (first + 1..range.end).find(|i| !seen(i)).unwrap_or(range.end);
        Some(first..end)
    }

    /// What differs (but for one chance in 2^64) if other casters are in the view, or one of them was moved.
    pub(super) fn signature(&self, view: &ShadowVolume) -> Signature {
        let (fixed, _) = self.hash(view, 0..self.first_dynamic);
        let (dynamic, seen) = self.hash(view, self.first_dynamic..self.casters.len());
        Signature { fixed, dynamic: seen.then_some(dynamic) }
    }

    /// FNV-1a (Fowler, Noll and Vo 1991) over the numbers and moves of those of these casters that are in the view, and
    /// whether there are any.
    fn hash(&self, view: &ShadowVolume, range: Range<usize>) -> (u64, bool) {
        const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
        const PRIME: u64 = 0x0000_0100_0000_01b3;
        let seen = range.filter(|&i| !view.misses(&self.casters[i].bounds_world));
        let words = seen.flat_map(|i| [i as u64, self.casters[i].moves]);
        let bytes = words.flat_map(u64::to_le_bytes);
        bytes.fold((BASIS, false), |(hash, _), byte| ((hash ^ u64::from(byte)).wrapping_mul(PRIME), true))
    }
}

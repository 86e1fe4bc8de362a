//! The scene's objects as they stand, and what of them a view sees, in the order in which it is drawn.

use std::ops::Range;

use super::convert;
use super::scene_data::{surface, vertex_streams};
use super::shared::InstanceData;
use crate::plan::{Path, Pipeline, Plan, SceneKinds, SurfaceKind};
use crate::scene::{Aabb, Scene};
use crate::visible::{Distances, DrawOrder, Reach, Sight, sort_key, sorted_index};
use crate::{Error, Result};
use glam::{Mat4, Vec4};

/// Objects of one mesh that one draw call draws.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    /// Index into `Plan::pipelines`: the `Pipeline::Surface` of its kind.
    pub(super) pipeline: usize,
    /// Index into `Scene::materials`.
    pub(super) material: usize,
    /// Index into `Scene::meshes`.
    pub(super) mesh: usize,
    /// The material's descriptor set: index for `SceneData::material_set`.
    pub(super) material_set: usize,
    /// Its part of `Objects::placed`.
    placed: Range<usize>,
    /// Whether it is laid over what is behind it, object by object.
    blended: bool,
    /// The part of the instance buffer that holds what of it is seen.
    pub(super) visible: Range<u32>,
    /// Of what is seen.
    distances: Distances,
}

/// An instance that has triangles.
struct Placed {
    data: InstanceData,
    /// Its part of the lightmap: origin and size.
    lightmap: [f32; 4],
    bounds_world: Aabb,
    bounds_object: Aabb,
    mirrored: bool,
    dynamic: bool,
}

impl Placed {
    fn place(&mut self, world_from_object: &Mat4) {
        self.data = convert::instance(world_from_object);
        self.bounds_world = self.bounds_object.transformed(world_from_object);
    }
}

/// An element of `Scene::instances`.
struct Element {
    /// Index into `Objects::placed`; `None` without triangles.
    placed: Option<usize>,
}

/// All objects that have triangles, by batch.
pub(super) struct Objects {
    batches: Vec<Batch>,
    order: DrawOrder,
    placed: Vec<Placed>,
    /// Where the visible instances are, in the order of the instance buffer; `None` where nobody asks.
    bounds_of_visible: Option<Vec<Aabb>>,
    elements: Vec<Element>,
    static_moves: u64,
    /// Room for the objects of the largest batch while they are sorted.
    sorted: Vec<u64>,
    /// What is blended and seen: where it is in the instance buffer, from far to near, and its batch.
    blended: Vec<(u64, usize)>,
}

impl Objects {
    /// Sorts by state, so that it changes seldom and equal meshes become one draw. What a mask cuts comes after what is
    /// whole: it hides nothing before its shader has run.
    pub(super) fn new(scene: &Scene, plan: &Plan) -> Self {
        let kinds = SceneKinds::new(scene);
        let mut order: Vec<_> = scene
            .instances
            .iter()
            .enumerate()
            .filter(|(_, instance)| scene.is_drawn(instance))
            .map(|(index, instance)| (index, instance, SurfaceKind::new(&kinds, instance)))
            .filter(|(.., kind)| !(kind.blend && plan.options.show.is_debug()))
            .map(|(index, instance, kind)| {
                let mesh = &scene.meshes[instance.mesh];
                let wanted = Pipeline::Surface(kind);
                let pipeline = plan.pipelines.iter().position(|(_, p)| *p == wanted);
                let pipeline = pipeline.expect("the plan was made for this scene");
                let after = (kind.blend, kind.alpha_mask);
                (after, vertex_streams(&kind), pipeline, mesh.material, instance.mesh, index)
            })
            .collect();
        order.sort_unstable();
        let bounds: Vec<_> = scene.meshes.iter().map(|mesh| mesh.bounds()).collect();
        let mut batches: Vec<Batch> = Vec::new();
        let mut placed = Vec::with_capacity(order.len());
        let mut elements: Vec<_> = scene.instances.iter().map(|_| Element { placed: None }).collect();
        for (.., pipeline, material, mesh, index) in order {
            let first = placed.len();
            let instance = &scene.instances[index];
            let bounds_object = bounds[mesh].expect("what has triangles has vertices");
            elements[index].placed = Some(first);
            placed.push(Placed {
                data: convert::instance(&instance.world_from_object),
                lightmap: instance
                    .lightmap
                    .map_or([0.0; 4], |r| [r.origin.x, r.origin.y, r.size.x, r.size.y]),
                bounds_world: bounds_object.transformed(&instance.world_from_object),
                bounds_object,
                mirrored: instance.is_mirrored(),
                dynamic: instance.dynamic,
            });
            match batches.last_mut() {
                Some(last) if (last.pipeline, last.mesh) == (pipeline, mesh) => last.placed.end += 1,
                _ => batches.push(Batch {
                    pipeline,
                    material,
                    mesh,
                    material_set: 0,
                    placed: first..first + 1,
                    blended: surface(plan, pipeline).blend,
                    visible: 0..0,
                    distances: Distances::default(),
                }),
            }
        }
        let asked = plan.path == Path::ForwardMultipass && plan.options.illumination_sets;
        let bounds_of_visible = asked.then(|| Vec::with_capacity(placed.len()));
        let is_blended = |batch: &&Batch| surface(plan, batch.pipeline).blend;
        let most_blended = batches.iter().filter(is_blended).map(|b| b.placed.len()).sum();
        let largest = batches.iter().map(|b| b.placed.len()).max().unwrap_or_default();
        Self {
            order: DrawOrder::new(&states(plan, &batches)),
            sorted: Vec::with_capacity(largest),
            blended: Vec::with_capacity(most_blended),
            batches,
            placed,
            bounds_of_visible,
            elements,
            static_moves: 0,
        }
    }

    /// How many there are: the length of an instance buffer that can hold all of them.
    pub(super) fn count(&self) -> usize {
        self.placed.len()
    }

    /// All batches.
    pub(super) fn batches(&self) -> &[Batch] {
        &self.batches
    }

    /// How many draw calls a stage takes at most: what light goes through is drawn twice.
    pub(super) fn most_runs(&self) -> usize {
        self.batches.len() + 2 * self.blended.capacity()
    }

    /// All batches, to give them their materials.
    pub(super) fn batches_mut(&mut self) -> &mut [Batch] {
        &mut self.batches
    }

    /// The first of these visible instances that a light reaches, and those that follow it without a gap; all where the
    /// plan has no illumination sets.
    pub(super) fn first_lit(&self, within: Range<u32>, reach: &Reach) -> Range<u32> {
        let Some(bounds) = &self.bounds_of_visible else { return within };
        let is_lit = |i: u32| !reach.misses_aabb(&bounds[i as usize]);
        let start = within.clone().find(|&i| is_lit(i)).unwrap_or(within.end);
        let end = (start..within.end).find(|&i| !is_lit(i)).unwrap_or(within.end);
        start..end
    }

    /// Those of which something is seen, in the order in which they are drawn: those of one pipeline side by side, and
    /// within it those of one material.
    pub(super) fn visible_batches(&self) -> impl Iterator<Item = &Batch> {
        self.order.draws().iter().map(|&i| &self.batches[i]).filter(|b| !b.visible.is_empty())
    }

    /// What is blended, from far to near: runs of visible instances that one draw call can draw.
    pub(super) fn blended_runs(&self) -> impl Iterator<Item = (&Batch, Range<u32>)> {
        let mut rest = &self.blended[..];
        std::iter::from_fn(move || {
            let &(key, batch) = rest.first()?;
            let first = sorted_index(key);
            let follows =
                |(i, next): (usize, &(u64, usize))| (sorted_index(next.0), next.1) == (first + i, batch);
            let run = rest.iter().enumerate().take_while(|&next| follows(next)).count();
            rest = &rest[run..];
            Some((&self.batches[batch], first as u32..(first + run) as u32))
        })
    }

    /// Moves an element of `Scene::instances`.
    pub(super) fn set(&mut self, index: usize, world_from_object: &Mat4) -> Result<()> {
        let elements = self.elements.len();
        let element = self.elements.get(index).ok_or_else(|| {
            Error::unsupported(
                format!("there is no instance {index} to move"),
                format!("use an index below {elements}, the number of the scene's instances"),
            )
        })?;
        if !world_from_object.is_finite() || world_from_object.row(3) != Vec4::W {
            return Err(Error::unsupported(
                format!("instance {index} cannot be placed by {world_from_object}"),
                "use a finite matrix whose last row is 0, 0, 0, 1",
            ));
        }
        let Some(placed) = element.placed.map(|placed| &mut self.placed[placed]) else { return Ok(()) };
        // What a flat object shows of itself has no winding.
        let determinant = world_from_object.determinant();
        if determinant != 0.0 && (determinant < 0.0) != placed.mirrored {
            return Err(Error::unsupported(
                format!("instance {index} would be mirrored, which takes another pipeline"),
                "make a plan and a renderer of the scene with the instance mirrored",
            ));
        }
        placed.place(world_from_object);
        self.static_moves += u64::from(!placed.dynamic);
        Ok(())
    }

    /// A mesh has these bounds now.
    pub(super) fn set_bounds(&mut self, mesh: usize, bounds_object: &Aabb) {
        for batch in self.batches.iter().filter(|batch| batch.mesh == mesh) {
            for placed in &mut self.placed[batch.placed.clone()] {
                placed.bounds_object = *bounds_object;
                placed.bounds_world = bounds_object.transformed(&convert::placement(&placed.data));
                self.static_moves += u64::from(!placed.dynamic);
            }
        }
    }

    /// How often an object that is not dynamic was moved: what was made of static objects is out of date when this
    /// has changed.
    pub(super) fn static_moves(&self) -> u64 {
        self.static_moves
    }

    /// Writes what is in sight, batch by batch without gaps and from near to far in each (what is blended: from far to near, by
    /// the centres' depths), and tells each batch where its objects are. Without `cull` the others follow in each batch, so that the order of those in sight is the same.
    /// Returns how many it wrote. `lightmaps` gets their parts of the lightmap, if it is not empty.
    pub(super) fn write_visible(
        &mut self,
        sight: &Sight,
        cull: bool,
        out: &mut [InstanceData],
        lightmaps: &mut [[f32; 4]],
    ) -> usize {
        let Self { batches, order, placed, sorted, bounds_of_visible, blended, .. } = self;
        let mut end = 0;
        blended.clear();
        bounds_of_visible.iter_mut().for_each(Vec::clear);
        for (batch_index, batch) in batches.iter_mut().enumerate() {
            batch.distances = Distances::default();
            sorted.clear();
            for index in batch.placed.clone() {
                let bounds = &placed[index].bounds_world;
                let seen = !sight.frustum.misses_aabb(bounds);
                if batch.blended {
                    if seen || !cull {
                        sorted.push(far_first(sight.depth(bounds), index));
                    }
                } else if seen {
                    let distance_m = sight.distance(bounds);
                    batch.distances.add(distance_m);
                    sorted.push(sort_key(distance_m, index));
                } else if !cull {
                    sorted.push(sort_key(f32::INFINITY, index));
                }
            }
            sorted.sort_unstable();
            let first = end;
            for &key in &*sorted {
                let object = &placed[sorted_index(key)];
                if batch.blended {
                    blended.push(((key & !u64::from(u32::MAX)) | end as u64, batch_index));
                }
                out[end] = object.data;
                bounds_of_visible.iter_mut().for_each(|all| all.push(object.bounds_world));
                if let Some(lightmap) = lightmaps.get_mut(end) {
                    *lightmap = object.lightmap;
                }
                end += 1;
            }
            batch.visible = first as u32..end as u32;
        }
        blended.sort_unstable();
        order.sort(|batch| batches[batch].distances);
        end
    }
}

/// As [`sort_key`], far things first.
fn far_first(distance_m: f32, index: usize) -> u64 {
    sort_key(distance_m.max(0.0), index) ^ !u64::from(u32::MAX)
}

/// What drawing each batch sets, from what to change least often to what costs least.
fn states(plan: &Plan, batches: &[Batch]) -> Vec<[usize; 4]> {
    let kind = |batch: &Batch| surface(plan, batch.pipeline);
    let mut streams: Vec<_> = batches.iter().map(|b| vertex_streams(kind(b))).collect();
    streams.sort_unstable();
    streams.dedup();
    let state = |batch: &Batch| {
        let kind = kind(batch);
        let streams = streams.binary_search(&vertex_streams(kind)).unwrap_or_default();
        [usize::from(kind.alpha_mask) + 2 * usize::from(kind.blend), streams, batch.pipeline, batch.material]
    };
    batches.iter().map(state).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Limits, Needs, Options};
    use crate::scene::{AlphaMode, Camera, Instance, Material, Mesh, Projection};
    use glam::{Vec3, vec3};

    /// What is masked comes last, however near; in front of it the nearest batch first, and in each the nearest object.
    #[test]
    fn opaque_batches_come_first_and_near_objects_before_far_ones() {
        let mesh = |material| Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            indices: vec![0, 1, 2],
            material,
            ..Mesh::default()
        };
        let alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
        let materials = vec![Material { alpha_mode, ..Material::default() }, Material::default()];
        let at = |mesh, z: f32| Instance::new(mesh, Mat4::from_translation(vec3(0.0, 0.0, -z)));
        let projection = Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None };
        let scene = Scene {
            meshes: vec![mesh(0), mesh(1), mesh(1)],
            materials,
            instances: vec![at(0, 1.0), at(1, 9.0), at(1, 8.0), at(2, 4.0), at(2, 3.0), at(2, 5.0)],
            cameras: vec![Camera { name: String::new(), world_from_view: Mat4::IDENTITY, projection }],
            ..Scene::default()
        };
        let plan = Plan::new(Needs::of(&scene), Options::default(), &Limits::default()).unwrap();
        let mut objects = Objects::new(&scene, &plan);
        let sight = Sight::new(&projection.clip_from_view(1.0), &Mat4::IDENTITY);
        let mut out = vec![convert::instance(&Mat4::IDENTITY); objects.count()];
        assert_eq!(objects.write_visible(&sight, true, &mut out, &mut []), 6);
        let drawn = objects.visible_batches().flat_map(|batch| batch.visible.clone());
        let distances: Vec<_> = drawn.map(|i| -out[i as usize].world_from_object_rows[2][3]).collect();
        assert_eq!(distances, [3.0, 4.0, 5.0, 8.0, 9.0, 1.0]);
    }
}

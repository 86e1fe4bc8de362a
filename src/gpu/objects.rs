//! The scene's objects as they stand, and what of them a view sees, in the order in which it is drawn.

use std::ops::Range;

use super::convert;
use super::shared::InstanceData;
use crate::plan::{Pipeline, Plan, SceneKinds, SurfaceKind};
use crate::scene::{Aabb, Instance, Scene};
use crate::visible::Frustum;
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
    /// The part of the instance buffer that holds what of it is seen.
    pub(super) visible: Range<u32>,
}

/// An instance that has triangles.
struct Placed {
    data: InstanceData,
    /// Its part of the lightmap: origin and size.
    lightmap: [f32; 4],
    bounds_world: Aabb,
    bounds_object: Aabb,
    mirrored: bool,
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
    dynamic: bool,
}

/// All objects that have triangles, by batch.
pub(super) struct Objects {
    batches: Vec<Batch>,
    placed: Vec<Placed>,
    elements: Vec<Element>,
    static_moves: u64,
}

impl Objects {
    /// Sorts by pipeline, material and mesh, so that state changes are few and equal meshes become one draw.
    pub(super) fn new(scene: &Scene, plan: &Plan) -> Self {
        let kinds = SceneKinds::new(scene);
        let mut order: Vec<_> = scene
            .instances
            .iter()
            .enumerate()
            .filter(|(_, instance)| scene.is_drawn(instance))
            .map(|(index, instance)| {
                let mesh = &scene.meshes[instance.mesh];
                let wanted = Pipeline::Surface(SurfaceKind::new(&kinds, instance));
                let pipeline = plan.pipelines.iter().position(|(_, p)| *p == wanted);
                (pipeline.expect("the plan was made for this scene"), mesh.material, instance.mesh, index)
            })
            .collect();
        order.sort_unstable();
        let bounds: Vec<_> = scene.meshes.iter().map(|mesh| mesh.bounds()).collect();
        let mut batches: Vec<Batch> = Vec::new();
        let mut placed = Vec::with_capacity(order.len());
        let element = |instance: &Instance| Element { placed: None, dynamic: instance.dynamic };
        let mut elements: Vec<_> = scene.instances.iter().map(element).collect();
        for (pipeline, material, mesh, index) in order {
            let first = placed.len();
            let instance = &scene.instances[index];
            let bounds_object = bounds[mesh].expect("what has triangles has vertices");
            elements[index].placed = Some(first);
            placed.push(Placed {
                data: convert::instance(&instance.world_from_object),
                lightmap: instance.lightmap.map_or([0.0; 4], |r| [r.origin.x, r.origin.y, r.size.x, r.size.y]),
                bounds_world: bounds_object.transformed(&instance.world_from_object),
                bounds_object,
                mirrored: instance.is_mirrored(),
            });
            match batches.last_mut() {
                Some(last) if (last.pipeline, last.mesh) == (pipeline, mesh) => last.placed.end += 1,
                _ => batches.push(Batch {
                    pipeline,
                    material,
                    mesh,
                    material_set: 0,
                    placed: first..first + 1,
                    visible: 0..0,
                }),
            }
        }
        Self { batches, placed, elements, static_moves: 0 }
    }

    /// How many there are: the length of an instance buffer that can hold all of them.
    pub(super) fn count(&self) -> usize {
        self.placed.len()
    }

    /// All batches.
    pub(super) fn batches(&self) -> &[Batch] {
        &self.batches
    }

    /// All batches, to give them their materials.
    pub(super) fn batches_mut(&mut self) -> &mut [Batch] {
        &mut self.batches
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
        self.static_moves += u64::from(!element.dynamic);
        Ok(())
    }

    /// How often an object that is not dynamic was moved: what was made of static objects is out of date when this
    /// has changed.
    pub(super) fn static_moves(&self) -> u64 {
        self.static_moves
    }

    /// Writes what the view sees (everything without a view), batch by batch without gaps, and tells each batch where
    /// its objects are. Returns how many they are. `lightmaps` gets their parts of the lightmap, if it is not empty.
    pub(super) fn write_visible(
        &mut self,
        view: Option<&Frustum>,
        out: &mut [InstanceData],
        lightmaps: &mut [[f32; 4]],
    ) -> usize {
        let mut end = 0;
        for batch in &mut self.batches {
            let first = end;
            for object in &self.placed[batch.placed.clone()] {
                if !view.is_some_and(|view| view.misses_aabb(&object.bounds_world)) {
                    out[end] = object.data;
                    if let Some(lightmap) = lightmaps.get_mut(end) {
                        *lightmap = object.lightmap;
                    }
                    end += 1;
                }
            }
            batch.visible = first as u32..end as u32;
        }
        end
    }
}

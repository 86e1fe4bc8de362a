//! What casts shadows by volumes: meshes with their edges on the device, and instances as they stand.

use std::collections::BTreeMap;
use std::ops::Range;

use ash::vk;
use glam::Mat4;

use super::shared::{InstanceData, VolumePush};
use super::{Buffer, BufferDesc, Device, MemoryUse, Upload, convert};
use crate::Result;
use crate::plan::{CasterKind, SceneKinds, SurfaceKind};
use crate::scene::{Aabb, Scene};
use crate::visible::{CasterMesh, Reach};

/// Casters that one draw call can draw.
struct Batch {
    mesh: usize,
    turned: bool,
    casters: Range<usize>,
}

struct Caster {
    data: InstanceData,
    bounds_object: Aabb,
    bounds_world: Aabb,
}

/// Where a mesh is in the buffer, in elements of 16 bytes, and how many vertices its parts have.
#[derive(Clone, Copy, Default)]
struct Place {
    first_place: u32,
    first_triangle: u32,
    first_edge: u32,
    edge_vertices: u32,
    triangle_vertices: u32,
}

/// All casters of a scene that masks do not cut.
pub(super) struct VolumeCasters {
    /// Places, triangles and edges of each mesh.
    meshes: Buffer,
    places: Vec<Place>,
    batches: Vec<Batch>,
    casters: Vec<Caster>,
    /// Of each of the scene's instances, its places among `casters`: both sides of what has two.
    casters_of: Vec<[Option<usize>; 2]>,
    /// Of meshes that bend, the vertex at each place.
    sources: BTreeMap<usize, Vec<u32>>,
    /// One a frame slot.
    instances: Vec<Buffer>,
}

impl VolumeCasters {
    /// Of the scene's instances; `None` if nothing casts shadows.
    pub(super) fn new(
        device: &Device,
        upload: &mut Upload,
        scene: &Scene,
        slots: usize,
    ) -> Result<Option<Self>> {
        let Listed { words, places, batches, casters, casters_of, sources } = list(scene);
        if casters.is_empty() {
            return Ok(None);
        }
        let bytes: &[u8] = bytemuck::cast_slice(&words);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let usage = storage | vk::BufferUsageFlags::TRANSFER_DST;
        let desc = BufferDesc {
            name: "volume casters",
            bytes: (bytes.len() as u64).max(16),
            usage,
            memory: MemoryUse::Device,
        };
        let meshes = Buffer::new(device, &desc)?;
        upload.buffer(&meshes, 0, bytes)?;
        let size = (casters.len() * size_of::<InstanceData>()) as u64;
        let name = "volume caster instances";
        let desc = BufferDesc { name, bytes: size, usage: storage, memory: MemoryUse::Upload };
        let instances = (0..slots).map(|_| Buffer::new(device, &desc)).collect::<Result<_>>()?;
        Ok(Some(Self { meshes, places, batches, casters, casters_of, sources, instances }))
    }

    /// What the meshes and a slot's instances take.
    pub(super) fn bytes(scene: &Scene) -> [u64; 2] {
        let Listed { words, casters, .. } = list(scene);
        [words.len() * size_of::<[u32; 4]>(), casters.len() * size_of::<InstanceData>()].map(|n| n as u64)
    }

    /// What [`VolumePush`] speaks of.
    pub(super) fn meshes(&self) -> &Buffer {
        &self.meshes
    }

    /// A frame slot's instances.
    pub(super) fn instances(&self, slot: usize) -> &Buffer {
        &self.instances[slot]
    }

    /// Moves an element of `Scene::instances`.
    pub(super) fn set(&mut self, instance: usize, world_from_object: &Mat4) {
        for index in self.casters_of[instance].into_iter().flatten() {
            let caster = &mut self.casters[index];
            caster.data = convert::instance(world_from_object);
            caster.bounds_world = caster.bounds_object.transformed(world_from_object);
        }
    }

    /// A mesh has these bounds now.
    pub(super) fn set_bounds(&mut self, mesh: usize, bounds_object: &Aabb) {
        for batch in self.batches.iter().filter(|batch| batch.mesh == mesh) {
            for caster in &mut self.casters[batch.casters.clone()] {
                caster.bounds_object = *bounds_object;
                caster.bounds_world = bounds_object.transformed(&convert::placement(&caster.data));
            }
        }
    }

    /// Where places are posed of a mesh that bends: the buffer, the first place in it, and the vertex that each is.
    pub(super) fn posed(&self, mesh: usize) -> Option<(&Buffer, u32, &[u32])> {
        Some((&self.meshes, self.places[mesh].first_place, self.sources.get(&mesh)?))
    }

    /// Brings a slot's instances up to date. The GPU has finished with the slot.
    pub(super) fn write(&mut self, slot: usize) {
        let content: &mut [InstanceData] = bytemuck::cast_slice_mut(self.instances[slot].mapped_mut());
        content.iter_mut().zip(&self.casters).for_each(|(to, caster)| *to = caster.data);
    }

    /// Calls `draw` with every longest run of casters of one mesh that the light reaches: what to push, the number of vertices,
    /// and the instances.
    pub(super) fn in_reach(
        &self,
        light: [f32; 4],
        reach: &Reach,
        near_ends: bool,
        mut draw: impl FnMut(&VolumePush, u32, Range<u32>),
    ) {
        for batch in &self.batches {
            let place = self.places[batch.mesh];
            let push = VolumePush {
                light,
                first_place: place.first_place,
                first_triangle: place.first_triangle,
                first_edge: place.first_edge,
                edge_vertices: place.edge_vertices,
                turned: batch.turned.into(),
                unused: [0; 3],
            };
            let vertices = match near_ends {
                true => place.triangle_vertices,
                false => place.edge_vertices + 2 * place.triangle_vertices,
            };
            let is_reached = |i: &usize| !reach.misses_aabb(&self.casters[*i].bounds_world);
            let mut rest = batch.casters.clone();
            while let Some(first) = rest.clone().find(is_reached) {
                let end = (first + 1..rest.end).find(|i| !is_reached(i)).unwrap_or(rest.end);
                draw(&push, vertices, first as u32..end as u32);
                rest.start = end;
            }
        }
    }

    /// Device memory of the buffers.
    pub(super) fn allocated_bytes(&self) -> u64 {
        let slots = self.instances.iter().map(Buffer::allocated_bytes).sum::<u64>();
        slots + self.meshes.allocated_bytes()
    }
}

/// What casts, and what is uploaded of it.
struct Listed {
    words: Vec<[u32; 4]>,
    places: Vec<Place>,
    batches: Vec<Batch>,
    casters: Vec<Caster>,
    casters_of: Vec<[Option<usize>; 2]>,
    sources: BTreeMap<usize, Vec<u32>>,
}

fn list(scene: &Scene) -> Listed {
    let kinds = SceneKinds::new(scene);
    let mut order = Vec::new();
    for (index, instance) in scene.instances.iter().enumerate().filter(|(_, i)| scene.is_drawn(i)) {
        let material = &scene.materials[scene.meshes[instance.mesh].material];
        let kind = CasterKind::new(&SurfaceKind::new(&kinds, instance), material);
        let Some(kind) = kind.filter(|kind| kind.mask.is_none()) else { continue };
        order.push((instance.mesh, kind.mirrored, index));
        // Their backs are surfaces of their own, which go round the other way.
        order.extend(kind.double_sided.then_some((instance.mesh, !kind.mirrored, index)));
    }
    order.sort_unstable();
    let mut words: Vec<[u32; 4]> = Vec::new();
    let mut places = vec![Place::default(); scene.meshes.len()];
    let mut batches: Vec<Batch> = Vec::new();
    let mut casters = Vec::with_capacity(order.len());
    let mut casters_of = vec![[None; 2]; scene.instances.len()];
    let mut sources = BTreeMap::new();
    for (mesh, turned, index) in order {
        if batches.last().is_none_or(|last| last.mesh != mesh) {
            let own = &scene.meshes[mesh];
            let caster = match &own.deformation {
                None => CasterMesh::new(&own.positions, &own.indices),
                Some(bends) => {
                    let key = |vertex| bends.vertex_bits(vertex, own.positions.len());
                    CasterMesh::by(&own.positions, &own.indices, key)
                }
            };
            places[mesh] = place(&caster, &mut words);
            sources.extend(own.deformation.as_ref().map(|_| (mesh, caster.sources)));
        }
        let first = casters.len();
        let bounds_object = scene.meshes[mesh].bounds().expect("what has triangles has vertices");
        let world_from_object = &scene.instances[index].world_from_object;
        let side = usize::from(casters_of[index][0].is_some());
        casters_of[index][side] = Some(first);
        casters.push(Caster {
            data: convert::instance(world_from_object),
            bounds_object,
            bounds_world: bounds_object.transformed(world_from_object),
        });
        match batches.last_mut() {
            Some(last) if (last.mesh, last.turned) == (mesh, turned) => last.casters.end += 1,
            _ => batches.push(Batch { mesh, turned, casters: first..first + 1 }),
        }
    }
    Listed { words, places, batches, casters, casters_of, sources }
}

/// Adds a mesh's places, triangles and edges.
fn place(caster: &CasterMesh, words: &mut Vec<[u32; 4]>) -> Place {
    let first_place = words.len() as u32;
    words.extend(caster.positions.iter().map(|p| p.extend(0.0).to_array().map(f32::to_bits)));
    let first_triangle = words.len() as u32;
    words.extend(caster.triangles.iter().map(|&[a, b, c]| [a, b, c, 0]));
    let first_edge = words.len() as u32;
    words.extend(&caster.edges);
    Place {
        first_place,
        first_triangle,
        first_edge,
        edge_vertices: 6 * caster.edges.len() as u32,
        triangle_vertices: 3 * caster.triangles.len() as u32,
    }
}

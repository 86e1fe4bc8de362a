//! Meshes that bend: a compute pass before all others writes their vertices as they are posed, where the pose has changed.
//!
//! Every pass then reads them as it reads all vertices. Posed in vertex shaders instead they would be posed again in each pass that draws
//! them (depth, geometry, blended surfaces), in each tile of the shadow map, and on tilers in each of these twice, for binning and
//! for drawing, with joints and weights (24 bytes for every four, beside the matrices) as attributes of each; written once, a pass reads
//! no more than of what stands still, and one that draws nothing of it nothing. Poses that have not changed are not written again.

use ash::vk;
use glam::Mat4;

use super::descriptor::{Binding, Content, DescriptorSets, set_layout};
use super::meshes::Meshes;
use super::pipeline::shader_module;
use super::shader::{Module, Specialization, prune, shared};
use super::shared::PosePush;
use super::volume_casters::VolumeCasters;
use super::{
    Buffer, BufferDesc, Called, Device, MemoryUse, Owned, PipelineCache, Recorder, StreamKind, Streams,
    Upload,
};
use crate::plan::PosedNeed;
use crate::scene::{Aabb, Deformation, Mesh, Pose, PosedBounds, Scene};
use crate::{Error, Result};

/// Where there is no list.
const NONE: u32 = u32::MAX;
/// Vertices of a workgroup.
const GROUP: u32 = 64;
/// Workgroups in a row that every device has.
const ROW: u32 = 65_535;
/// Of the elements that [`PosePush::first_joint`] counts.
const ELEMENT_BYTES: usize = 16;

/// Of a mesh that bends.
struct PosedMesh {
    pose: Pose,
    bounds: PosedBounds,
    /// Where in the rest poses the displacements of each morph target are.
    targets: Vec<[u32; 3]>,
    /// The first of its elements in a slot's poses.
    first: usize,
    /// Its vertices, and its places where it casts shadows by volumes: what to push, and the buffer that is written.
    jobs: Vec<(PosePush, usize)>,
    /// Whether the vertices are of another pose.
    is_stale: bool,
}

/// All meshes that bend, and what poses them.
pub(super) struct Poses {
    // In order of destruction.
    sets: DescriptorSets,
    pipeline: PosePipeline,
    /// As scenes have them.
    rest: Buffer,
    /// One a frame slot.
    slots: Vec<Buffer>,
    /// How many buffers are written.
    buffers: usize,
    meshes: Vec<PosedMesh>,
    /// By mesh of the scene.
    of_mesh: Vec<Option<usize>>,
}

struct PosePipeline {
    raw: Owned<vk::Pipeline>,
    layout: Owned<vk::PipelineLayout>,
    set: Owned<vk::DescriptorSetLayout>,
}

const BINDINGS: [Binding; 3] = {
    const fn storage(binding: u32) -> Binding {
        (binding, vk::DescriptorType::STORAGE_BUFFER, 1, vk::ShaderStageFlags::COMPUTE)
    }
    [storage(shared("BINDING_REST")), storage(shared("BINDING_POSES")), storage(shared("BINDING_POSED"))]
};

impl PosePipeline {
    fn new(device: &Device, cache: &PipelineCache) -> Result<Self> {
        let name = "poses";
        let set = set_layout(device, &BINDINGS, name)?;
        let sets = [set.raw()];
        let push = [vk::PushConstantRange {
            stage_flags: vk::ShaderStageFlags::COMPUTE,
            offset: 0,
            size: size_of::<PosePush>() as u32,
        }];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(&push);
        // SAFETY: the set layout is alive; the push constants are fewer than the 128 bytes of every device.
        let layout = unsafe { device.create_pipeline_layout(&info, name) }?;
        let spirv =
            prune(name, cache.modules().spirv(Module::Pose)?, &Specialization::default(), None)?.spirv;
        let module = shader_module(device, &spirv, name)?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw())
            .name(c"main");
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.raw());
        // SAFETY: module and layout are alive, and the layout has what the module mentions (a test compares them).
        let created =
            unsafe { device.raw().create_compute_pipelines(cache.raw(), &[info], device.callbacks()) };
        let raw = created.map_err(|(_, result)| result).called("vkCreateComputePipelines")?;
        Ok(Self { raw: Owned::new(device, raw[0], name), layout, set })
    }
}

/// Compiles what poses meshes.
pub(super) fn prepare_poses(device: &Device, cache: &PipelineCache) -> Result<()> {
    PosePipeline::new(device, cache).map(drop)
}

impl Poses {
    /// Of the meshes of a scene that bend and are drawn; `None` if the plan has none.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device's queue has no compute, or its storage buffers are too small; [`Error::Vulkan`].
    pub(super) fn new(
        device: &Device,
        scene: &Scene,
        need: Option<&PosedNeed>,
        (meshes, casters): (&Meshes, Option<&VolumeCasters>),
        slots: usize,
        (upload, cache): (&mut Upload, &PipelineCache),
    ) -> Result<Option<Self>> {
        let Some(need) = need else { return Ok(None) };
        check_queue(device, need)?;
        let mut words = Vec::new();
        let mut all = Self::list(scene, meshes, &mut words);
        let mut written: Vec<&Buffer> = Vec::new();
        for (index, posed) in &mut all {
            let (_, geometry, _) = meshes.drawn(*index);
            let vertices = geometry.vertices().expect("what is drawn has vertices");
            posed.jobs[0].1 = place_of(vertices, &mut written);
            let Some((buffer, first_place, sources)) = casters.and_then(|c| c.posed(*index)) else {
                continue;
            };
            let push = PosePush {
                vertices: sources.len() as u32,
                first_source: words.len() as u32,
                rest_normal: NONE,
                rest_tangent: NONE,
                position: first_place * 4,
                position_stride: 4,
                ..posed.jobs[0].0
            };
            words.extend(sources);
            posed.jobs.push((push, place_of(buffer, &mut written)));
        }
        // SAFETY: the physical device is alive.
        let properties =
            unsafe { device.instance().get_physical_device_properties(device.physical_device()) };
        let limit = u64::from(properties.limits.max_storage_buffer_range);
        let largest = written.iter().map(|b| b.size_bytes()).chain([words.len() as u64 * 4]).max();
        if let Some(largest) = largest.filter(|largest| *largest > limit) {
            return Err(Error::unsupported(
                format!("{} takes a storage buffer of {largest} bytes, and the device has {limit}", need.why),
                "split the scene, or load it as it stands, by `Scene::load`",
            ));
        }
        let mut elements = 0;
        let mut of_mesh = vec![None; scene.meshes.len()];
        let mut list = Vec::with_capacity(all.len());
        for (index, mut posed) in all {
            posed.first = elements;
            elements += posed.pose.object_from_bind.len() * 3 + posed.targets.len();
            of_mesh[index] = Some(list.len());
            list.push(posed);
        }
        let pipeline = PosePipeline::new(device, cache)?;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let rest = Buffer::new(
            device,
            &BufferDesc {
                name: "rest poses",
                bytes: words.len() as u64 * 4,
                usage: usage | vk::BufferUsageFlags::TRANSFER_DST,
                memory: MemoryUse::Device,
            },
        )?;
        upload.buffer(&rest, 0, bytemuck::cast_slice(&words))?;
        let bytes = (elements.max(1) * ELEMENT_BYTES) as u64;
        let desc = BufferDesc { name: "poses", bytes, usage, memory: MemoryUse::Upload };
        let slots: Vec<_> = (0..slots).map(|_| Buffer::new(device, &desc)).collect::<Result<_>>()?;
        let wanted = vec![(pipeline.set.raw(), &BINDINGS[..]); slots.len() * written.len()];
        let sets = DescriptorSets::new(device, &wanted, "poses")?.expect("the plan has meshes that bend");
        for (set, (slot, target)) in
            slots.iter().flat_map(|slot| written.iter().map(move |target| (slot, *target))).enumerate()
        {
            for ((binding, ty, ..), buffer) in BINDINGS.iter().zip([&rest, slot, target]) {
                sets.write(set, *binding, *ty, &Content::Buffer(buffer, 0, buffer.size_bytes()));
            }
        }
        Ok(Some(Self { sets, pipeline, rest, slots, buffers: written.len(), meshes: list, of_mesh }))
    }

    /// Every mesh that bends and is drawn, and what its vertices are made of.
    fn list(scene: &Scene, meshes: &Meshes, words: &mut Vec<u32>) -> Vec<(usize, PosedMesh)> {
        let bending = scene.meshes.iter().enumerate().filter(|(index, _)| meshes.range(*index).is_some());
        let all = bending.filter_map(|(index, mesh)| {
            let (deformation, bounds) = (mesh.deformation.as_ref()?, PosedBounds::new(mesh)?);
            let (_, geometry, range) = meshes.drawn(index);
            let group = &geometry.groups()[range.group];
            let streams = group.streams;
            let place = |wanted: StreamKind, width: u32| {
                let list = streams.list();
                let stream = list.iter().position(|(kind, _)| *kind == wanted)?;
                Some((group.offsets_bytes[stream] / 4) as u32 + range.vertex_offset as u32 * width)
            };
            let push = PosePush {
                position: place(StreamKind::Position, 3)?,
                position_stride: 3,
                normal: place(StreamKind::Normal, 3).unwrap_or_default(),
                tangent: place(StreamKind::Tangent, 4).unwrap_or_default(),
                ..add_rest(mesh, deformation, streams, words)
            };
            let mut add = |list: &[glam::Vec3], is_read: bool| match is_read && !list.is_empty() {
                true => floats(bytemuck::cast_slice(list), words),
                false => NONE,
            };
            let mut targets = Vec::with_capacity(deformation.targets.len());
            for target in &deformation.targets {
                targets.push([
                    add(&target.positions, true),
                    add(&target.normals, push.rest_normal != NONE),
                    add(&target.tangents, push.rest_tangent != NONE),
                ]);
            }
            let pose = deformation.pose.clone();
            let jobs = vec![(push, 0)];
            Some((index, PosedMesh { pose, bounds, targets, first: 0, jobs, is_stale: true }))
        });
        all.collect()
    }

    /// Poses a mesh of the scene for the frames recorded from now on; where it is then, object space, if it is drawn.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if nothing bends the mesh, or the pose is of another.
    pub(super) fn set(&mut self, mesh: usize, pose: &Pose) -> Result<Option<Aabb>> {
        let Some(index) = self.of_mesh.get(mesh).copied().flatten() else { return Ok(None) };
        let posed = &mut self.meshes[index];
        let counts = |pose: &Pose| (pose.object_from_bind.len(), pose.weights.len());
        let is_sound = |m: &Mat4| m.is_finite() && m.row(3) == glam::Vec4::W;
        if counts(pose) != counts(&posed.pose)
            || !pose.object_from_bind.iter().all(is_sound)
            || !pose.weights.iter().all(|w| w.is_finite())
        {
            let (joints, targets) = counts(&posed.pose);
            return Err(Error::unsupported(
                format!(
                    "mesh {mesh} cannot take a pose that is not of {joints} joints and {targets} morph targets"
                ),
                "give each joint an affine matrix and each morph target a weight, all finite",
            ));
        }
        // Lists that are there already hold them.
        posed.pose.object_from_bind.clone_from(&pose.object_from_bind);
        posed.pose.weights.clone_from(&pose.weights);
        posed.is_stale = true;
        Ok(Some(posed.bounds.of(pose)))
    }

    /// Poses all meshes anew.
    pub(super) fn redo(&mut self) {
        self.meshes.iter_mut().for_each(|mesh| mesh.is_stale = true);
    }

    /// Records what poses meshes anew, outside of a render pass; nothing if all stand as they did. The GPU has finished with the slot.
    pub(super) fn record(&mut self, recorder: &Recorder<'_>, slot: usize) {
        use vk::{AccessFlags as A, PipelineStageFlags as S};
        if !self.meshes.iter().any(|mesh| mesh.is_stale) {
            return;
        }
        let _label = recorder.label("poses");
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let barrier = |src: (S, A), dst: (S, A)| {
            let all = [vk::MemoryBarrier::default().src_access_mask(src.1).dst_access_mask(dst.1)];
            let none = vk::DependencyFlags::empty();
            // SAFETY: recording, outside of a render pass.
            unsafe { device.cmd_pipeline_barrier(raw, src.0, dst.0, none, &all, &[], &[]) };
        };
        // Earlier frames have read what is written, and uploads and earlier poses have written it.
        let before = S::VERTEX_INPUT | S::VERTEX_SHADER | S::TRANSFER | S::COMPUTE_SHADER;
        let written = A::TRANSFER_WRITE | A::SHADER_WRITE;
        barrier((before, written), (S::COMPUTE_SHADER, A::SHADER_READ | A::SHADER_WRITE));
        let point = vk::PipelineBindPoint::COMPUTE;
        // SAFETY: the pipeline is kept alive by this owner.
        unsafe { device.cmd_bind_pipeline(raw, point, self.pipeline.raw.raw()) };
        let Self { sets, pipeline, slots, buffers, meshes, .. } = self;
        let elements: &mut [[f32; 4]] = bytemuck::cast_slice_mut(slots[slot].mapped_mut());
        for mesh in meshes.iter_mut().filter(|mesh| mesh.is_stale) {
            mesh.is_stale = false;
            let targets = mesh.write(elements);
            for (push, buffer) in &mesh.jobs {
                let joints = mesh.pose.object_from_bind.len() * 3;
                let first_joint = mesh.first as u32;
                let push =
                    PosePush { first_joint, first_target: first_joint + joints as u32, targets, ..*push };
                let groups = push.vertices.div_ceil(GROUP);
                let rows = groups.div_ceil(ROW);
                let set = [sets.raw(slot * *buffers + buffer)];
                let layout = pipeline.layout.raw();
                let (stages, bytes) = (vk::ShaderStageFlags::COMPUTE, bytemuck::bytes_of(&push));
                // SAFETY: recording; the set is of the layout, which has these push constants; all that the shader reads and
                // writes lies inside the buffers that it was planned with.
                unsafe {
                    device.cmd_bind_descriptor_sets(raw, point, layout, 0, &set, &[]);
                    device.cmd_push_constants(raw, layout, stages, 0, bytes);
                    device.cmd_dispatch(raw, groups.div_ceil(rows), rows, 1);
                }
            }
        }
        let reads = A::VERTEX_ATTRIBUTE_READ | A::SHADER_READ;
        barrier((S::COMPUTE_SHADER, A::SHADER_WRITE), (S::VERTEX_INPUT | S::VERTEX_SHADER, reads));
    }

    /// What rest poses and a slot's poses will take; with shadow volumes their places too.
    pub(super) fn bytes(scene: &Scene, streams: &[Option<Streams>], has_volumes: bool) -> [u64; 2] {
        let (mut words, mut elements) = (0, 0);
        for (mesh, streams) in scene.meshes.iter().zip(streams) {
            let (Some(deformation), Some(streams)) = (&mesh.deformation, streams) else { continue };
            let of = |n: usize, is_read: bool| if is_read { n } else { 0 };
            words += 3 * mesh.positions.len()
                + of(3 * mesh.normals.len(), streams.normals)
                + of(4 * mesh.tangents.len(), streams.tangents)
                + 6 * deformation.influences.len()
                + of(mesh.positions.len(), has_volumes);
            words += 3 * deformation
                .targets
                .iter()
                .map(|t| {
                    t.positions.len()
                        + of(t.normals.len(), streams.normals)
                        + of(t.tangents.len(), streams.tangents)
                })
                .sum::<usize>();
            elements += 3 * deformation.pose.object_from_bind.len() + deformation.targets.len();
        }
        [words * 4, elements * ELEMENT_BYTES].map(|n| n as u64)
    }

    /// Device memory.
    pub(super) fn allocated_bytes(&self) -> u64 {
        self.rest.allocated_bytes() + self.slots.iter().map(Buffer::allocated_bytes).sum::<u64>()
    }
}

impl PosedMesh {
    /// Writes joints and the morph targets that have a weight; how many these are.
    fn write(&self, elements: &mut [[f32; 4]]) -> u32 {
        let mut end = self.first;
        for matrix in &self.pose.object_from_bind {
            for row in 0..3 {
                elements[end] = matrix.row(row).to_array();
                end += 1;
            }
        }
        let mut targets = 0;
        for (places, weight) in self.targets.iter().zip(&self.pose.weights).filter(|(_, w)| **w != 0.0) {
            let [a, b, c] = places.map(f32::from_bits);
            elements[end] = [*weight, a, b, c];
            end += 1;
            targets += 1;
        }
        targets
    }
}

/// Where a buffer is in the list, which it is in then.
fn place_of<'a>(buffer: &'a Buffer, list: &mut Vec<&'a Buffer>) -> usize {
    list.iter().position(|known| known.raw() == buffer.raw()).unwrap_or_else(|| {
        list.push(buffer);
        list.len() - 1
    })
}

/// Queues of graphics have compute but for those that somebody picked for having none.
fn check_queue(device: &Device, need: &PosedNeed) -> Result<()> {
    let (instance, physical) = (device.instance(), device.physical_device());
    // SAFETY: the physical device is alive.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
    let own = families.get(device.queue_family() as usize);
    match own.is_some_and(|family| family.queue_flags.contains(vk::QueueFlags::COMPUTE)) {
        true => Ok(()),
        false => Err(Error::unsupported(
            format!("{} bends, and the device's queue has no compute", need.why),
            "lend a queue of a family that has graphics and compute, or load the scene as it stands, by `Scene::load`",
        )),
    }
}

fn floats(list: &[f32], words: &mut Vec<u32>) -> u32 {
    let first = words.len() as u32;
    words.extend(list.iter().map(|v| v.to_bits()));
    first
}

/// Adds a mesh's own lists, and its influences, whose weights add up to 1.
fn add_rest(mesh: &Mesh, deformation: &Deformation, streams: Streams, words: &mut Vec<u32>) -> PosePush {
    let vertices = mesh.positions.len();
    let list = |is_read: bool, list: &[f32], words: &mut Vec<u32>| match is_read && !list.is_empty() {
        true => floats(list, words),
        false => NONE,
    };
    PosePush {
        vertices: vertices as u32,
        rest_position: floats(bytemuck::cast_slice(&mesh.positions), words),
        rest_normal: list(streams.normals, bytemuck::cast_slice(&mesh.normals), words),
        rest_tangent: list(streams.tangents, bytemuck::cast_slice(&mesh.tangents), words),
        first_source: NONE,
        influences: deformation.sets(vertices) as u32,
        first_influence: add_influences(deformation, vertices, words),
        ..PosePush::default()
    }
}

fn add_influences(deformation: &Deformation, vertices: usize, words: &mut Vec<u32>) -> u32 {
    let first = words.len() as u32;
    let sets = deformation.sets(vertices);
    for own in deformation.influences.chunks_exact(sets.max(1)) {
        let total: f64 = own.iter().flat_map(|i| i.weights).map(f64::from).sum();
        for influence in own {
            let [a, b, c, d] = influence.joints.map(u32::from);
            words.extend([a | b << 16, c | d << 16]);
            words.extend(influence.weights.map(|w| ((f64::from(w) / total) as f32).to_bits()));
        }
    }
    first
}

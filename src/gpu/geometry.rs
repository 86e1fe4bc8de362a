//! Meshes on the GPU: one vertex buffer and one index buffer for all of them.
//!
//! Attributes are separate streams. Meshes that need the same set of streams form a group; within a group
//! each stream is one array over all its meshes, so a group is bound once and a draw only names its first
//! vertex.

use super::memory::LEAST_OWN_BLOCK_BYTES;
use super::{Buffer, BufferDesc, Device, MemoryUse, Upload};
use crate::scene::Mesh;
use crate::{Error, Result};
use ash::vk;
use std::collections::BTreeMap;

/// A vertex attribute, in the order of binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StreamKind {
    /// Object space, R32G32B32_SFLOAT.
    Position,
    /// Object space, R32G32B32_SFLOAT.
    Normal,
    /// Object space and the bitangent's sign, R32G32B32A32_SFLOAT.
    Tangent,
    /// One set as R32G32_SFLOAT, or both as R32G32B32A32_SFLOAT.
    Texcoords,
    /// Linear Rec.709 and alpha, R32G32B32A32_SFLOAT.
    Color,
}

/// Which attributes a mesh's shaders read; positions always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Streams {
    /// Normals.
    pub normals: bool,
    /// Tangents.
    pub tangents: bool,
    /// Sets of texture coordinates: TEXCOORD_0, and TEXCOORD_1 beside it. The second alone also makes both.
    pub texcoords: [bool; 2],
    /// Vertex colours.
    pub colors: bool,
}

impl Streams {
    /// The streams and their formats, in the order of binding.
    pub fn list(&self) -> Vec<(StreamKind, vk::Format)> {
        const F2: vk::Format = vk::Format::R32G32_SFLOAT;
        const F3: vk::Format = vk::Format::R32G32B32_SFLOAT;
        const F4: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
        let texcoords = if self.texcoords[1] { F4 } else { F2 };
        [
            (true, StreamKind::Position, F3),
            (self.normals, StreamKind::Normal, F3),
            (self.tangents, StreamKind::Tangent, F4),
            (self.texcoords != [false; 2], StreamKind::Texcoords, texcoords),
            (self.colors, StreamKind::Color, F4),
        ]
        .into_iter()
        .filter(|(wanted, ..)| *wanted)
        .map(|(_, kind, format)| (kind, format))
        .collect()
    }
}

/// Width of the indices of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum IndexWidth {
    /// 16 bits: at most 65,535 vertices.
    U16,
    /// 32 bits.
    U32,
}

impl IndexWidth {
    /// For `vkCmdBindIndexBuffer`.
    pub fn index_type(self) -> vk::IndexType {
        match self {
            Self::U16 => vk::IndexType::UINT16,
            Self::U32 => vk::IndexType::UINT32,
        }
    }

    /// Bytes of an index.
    pub fn bytes(self) -> u64 {
        match self {
            Self::U16 => 2,
            Self::U32 => 4,
        }
    }

    /// For a mesh of so many vertices. 16 bits leave out the value that restarts strips.
    pub fn for_vertices(count: usize) -> Self {
        if count <= usize::from(u16::MAX) { Self::U16 } else { Self::U32 }
    }
}

/// Meshes with the same streams.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamGroup {
    /// The streams.
    pub streams: Streams,
    /// Where each begins in the vertex buffer, in the order of [`Streams::list`].
    pub offsets_bytes: Vec<u64>,
}

/// The arguments of a mesh's draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshRange {
    /// Index into [`Geometry::groups`]: what must be bound.
    pub group: usize,
    /// `vertexOffset`: the mesh's first vertex in its group.
    pub vertex_offset: i32,
    /// The number of its vertices.
    pub vertex_count: u32,
    /// Which of the two index ranges must be bound.
    pub index_width: IndexWidth,
    /// `firstIndex` in that range.
    pub first_index: u32,
    /// `indexCount`.
    pub index_count: u32,
}

/// Where everything goes; no Vulkan objects yet.
#[derive(Debug, Default, PartialEq)]
struct Plan {
    groups: Vec<StreamGroup>,
    meshes: Vec<MeshRange>,
    vertex_bytes: u64,
    /// Where the 32-bit indices begin; the 16-bit ones are at 0.
    wide_indices_bytes: u64,
    index_bytes: u64,
}

/// All meshes of a scene on the GPU.
#[derive(Debug)]
pub struct Geometry {
    vertices: Option<Buffer>,
    indices: Option<Buffer>,
    plan: Plan,
}

impl Geometry {
    /// Makes the buffers and gathers their contents in `upload`. `streams[i]` says what `meshes[i]` needs, `None` that it is
    /// not drawn and not to be here; an
    /// attribute that the mesh lacks is filled up as glTF has it: white for colours, zero otherwise.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if attribute lists are of different lengths or a count does not fit 32 bits;
    /// [`Error::Vulkan`].
    pub fn new(
        device: &Device,
        upload: &mut Upload,
        meshes: &[Mesh],
        streams: &[Option<Streams>],
    ) -> Result<Self> {
        let plan = plan(meshes, streams)?;
        let buffer = |name, bytes, usage| match bytes {
            0 => Ok(None),
            _ => {
                let usage = usage | vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC;
                Buffer::new(device, &BufferDesc { name, bytes, usage, memory: MemoryUse::Device }).map(Some)
            }
        };
        let bends = meshes.iter().zip(streams).any(|(mesh, s)| s.is_some() && mesh.deformation.is_some());
        // Those of meshes that bend are written where they are posed.
        let written =
            if bends { vk::BufferUsageFlags::STORAGE_BUFFER } else { vk::BufferUsageFlags::empty() };
        let usage = vk::BufferUsageFlags::VERTEX_BUFFER | written;
        let vertices = buffer("vertices", plan.vertex_bytes, usage)?;
        let indices = buffer("indices", plan.index_bytes, vk::BufferUsageFlags::INDEX_BUFFER)?;
        for ((mesh, range), _) in meshes.iter().zip(&plan.meshes).zip(streams).filter(|(_, s)| s.is_some()) {
            let group = &plan.groups[range.group];
            if let Some(vertices) = &vertices {
                for ((kind, format), start) in group.streams.list().into_iter().zip(&group.offsets_bytes) {
                    let stride = u64::from(super::texel_bytes(format)?);
                    let content = attribute(mesh, kind, group.streams);
                    upload.buffer(vertices, start + range.vertex_offset as u64 * stride, &content)?;
                }
            }
            if let Some(indices) = &indices {
                let first = u64::from(range.first_index);
                match range.index_width {
                    IndexWidth::U16 => {
                        let narrow: Vec<u16> = mesh.indices.iter().map(|&i| i as u16).collect();
                        upload.buffer(indices, first * 2, bytemuck::cast_slice(&narrow))?;
                    }
                    IndexWidth::U32 => {
                        let start = plan.wide_indices_bytes + first * 4;
                        upload.buffer(indices, start, bytemuck::cast_slice(&mesh.indices))?;
                    }
                }
            }
        }
        Ok(Self { vertices, indices, plan })
    }

    /// What both buffers would take; that of indices has a block of its own.
    pub(super) fn bytes(meshes: &[Mesh], streams: &[Option<Streams>]) -> Result<u64> {
        let Plan { vertex_bytes, index_bytes, .. } = plan(meshes, streams)?;
        let block = if index_bytes > 0 { index_bytes.max(LEAST_OWN_BLOCK_BYTES) } else { 0 };
        Ok(vertex_bytes + block)
    }

    /// The vertex buffer; `None` without vertices.
    pub fn vertices(&self) -> Option<&Buffer> {
        self.vertices.as_ref()
    }

    /// The index buffer; `None` without indices.
    pub fn indices(&self) -> Option<&Buffer> {
        self.indices.as_ref()
    }

    /// Where the indices of this width begin in the index buffer, bytes: what to bind.
    pub fn index_offset_bytes(&self, width: IndexWidth) -> u64 {
        match width {
            IndexWidth::U16 => 0,
            IndexWidth::U32 => self.plan.wide_indices_bytes,
        }
    }

    /// The sets of streams.
    pub fn groups(&self) -> &[StreamGroup] {
        &self.plan.groups
    }

    /// The draws, one for each mesh in the scene's order.
    pub fn meshes(&self) -> &[MeshRange] {
        &self.plan.meshes
    }

    /// The size of both buffers' contents.
    pub fn content_bytes(&self) -> u64 {
        self.plan.vertex_bytes + self.plan.index_bytes
    }

    /// The size of both buffers' memory.
    pub fn allocated_bytes(&self) -> u64 {
        self.vertices.iter().chain(&self.indices).map(Buffer::allocated_bytes).sum()
    }
}

fn plan(meshes: &[Mesh], streams: &[Option<Streams>]) -> Result<Plan> {
    let too_much = || {
        Error::unsupported(
            "the scene has more than 2^31 vertices or 2^32 indices",
            "split it into several scenes",
        )
    };
    if meshes.len() != streams.len() {
        return Err(Error::unsupported(
            format!("{} meshes come with {} sets of streams", meshes.len(), streams.len()),
            "give one set for each mesh",
        ));
    }
    meshes.iter().try_for_each(check)?;

    // Sorted by what they hold, so the order of meshes does not decide the order of groups.
    let mut vertex_counts: BTreeMap<Streams, u64> = streams.iter().flatten().map(|s| (*s, 0)).collect();
    let group_of: BTreeMap<Streams, usize> = vertex_counts.keys().zip(0..).map(|(s, i)| (*s, i)).collect();
    let mut index_counts = BTreeMap::from([(IndexWidth::U16, 0_u64), (IndexWidth::U32, 0)]);
    let mut ranges = Vec::with_capacity(meshes.len());
    for (mesh, streams) in meshes.iter().zip(streams) {
        let width = IndexWidth::for_vertices(mesh.positions.len());
        let Some(streams) = streams else {
            ranges.push(MeshRange {
                group: 0,
                vertex_offset: 0,
                vertex_count: 0,
                index_width: width,
                first_index: 0,
                index_count: 0,
            });
            continue;
        };
        let vertices = vertex_counts.entry(*streams).or_default();
        let indices = index_counts.entry(width).or_default();
        ranges.push(MeshRange {
            group: group_of[streams],
            vertex_offset: i32::try_from(*vertices).map_err(|_| too_much())?,
            vertex_count: u32::try_from(mesh.positions.len()).map_err(|_| too_much())?,
            index_width: width,
            first_index: u32::try_from(*indices).map_err(|_| too_much())?,
            index_count: u32::try_from(mesh.indices.len()).map_err(|_| too_much())?,
        });
        *vertices += mesh.positions.len() as u64;
        *indices += mesh.indices.len() as u64;
    }

    let mut end = 0;
    let mut groups = Vec::with_capacity(vertex_counts.len());
    for (streams, vertices) in vertex_counts {
        let mut offsets_bytes = Vec::new();
        for (_, format) in streams.list() {
            offsets_bytes.push(end);
            end += vertices * u64::from(super::texel_bytes(format)?);
        }
        groups.push(StreamGroup { streams, offsets_bytes });
    }
    let bytes = |width: IndexWidth| index_counts[&width] * width.bytes();
    // A bound offset must be a multiple of the index size.
    let wide_indices_bytes = bytes(IndexWidth::U16).next_multiple_of(IndexWidth::U32.bytes());
    let index_bytes = match bytes(IndexWidth::U32) {
        0 => bytes(IndexWidth::U16),
        wide => wide_indices_bytes + wide,
    };
    Ok(Plan { groups, meshes: ranges, vertex_bytes: end, wide_indices_bytes, index_bytes })
}

fn check(mesh: &Mesh) -> Result<()> {
    mesh.lists_problem().map_or(Ok(()), |problem| {
        Err(Error::unsupported(
            format!("mesh '{}' has {problem}", mesh.name),
            "make every attribute list empty or as long as the positions, and keep indices below their number",
        ))
    })
}

fn attribute(mesh: &Mesh, kind: StreamKind, streams: Streams) -> std::borrow::Cow<'_, [u8]> {
    use std::borrow::Cow;
    let count = mesh.positions.len();
    let (bytes, default): (&[u8], &[f32]) = match kind {
        StreamKind::Position => (bytemuck::cast_slice(&mesh.positions), &[0.0; 3]),
        StreamKind::Normal => (bytemuck::cast_slice(&mesh.normals), &[0.0; 3]),
        StreamKind::Tangent => (bytemuck::cast_slice(&mesh.tangents), &[0.0; 4]),
        StreamKind::Color => (bytemuck::cast_slice(&mesh.colors), &[1.0; 4]),
        StreamKind::Texcoords if streams.texcoords[1] => return Cow::Owned(both_texcoords(mesh)),
        StreamKind::Texcoords => (bytemuck::cast_slice(&mesh.texcoords[0]), &[0.0; 2]),
    };
    match bytes.is_empty() {
        true => Cow::Owned(bytemuck::cast_slice(&default.repeat(count)).to_vec()),
        false => Cow::Borrowed(bytes),
    }
}

fn both_texcoords(mesh: &Mesh) -> Vec<u8> {
    let set = |n: usize, i: usize| mesh.texcoords[n].get(i).copied().unwrap_or_default().to_array();
    let both = (0..mesh.positions.len()).flat_map(|i| [set(0, i), set(1, i)]);
    bytemuck::cast_slice(&both.collect::<Vec<[f32; 2]>>()).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    fn mesh(vertices: usize, indices: Vec<u32>) -> Mesh {
        Mesh { positions: vec![Vec3::ONE; vertices], indices, ..Default::default() }
    }

    #[test]
    fn meshes_of_a_group_follow_each_other() {
        let lit = Streams { normals: true, ..Default::default() };
        let meshes =
            [mesh(4, vec![0, 1, 2]), mesh(3, vec![0; 6]), mesh(65_536, vec![65_535; 3]), mesh(5, vec![4; 3])];
        let plan = plan(&meshes, &[Some(lit), Some(Streams::default()), Some(lit), Some(lit)]).unwrap();
        // Groups: positions only (3 vertices: 36 bytes), then positions and normals of 4 + 65,536 + 5
        // vertices.
        let group = |streams, offsets: &[u64]| StreamGroup { streams, offsets_bytes: offsets.to_vec() };
        assert_eq!(plan.groups, [group(Streams::default(), &[0]), group(lit, &[36, 36 + 65_545 * 12])]);
        assert_eq!(plan.vertex_bytes, 36 + 2 * 65_545 * 12);
        let offsets: Vec<_> = plan.meshes.iter().map(|m| (m.group, m.vertex_offset, m.first_index)).collect();
        assert_eq!(offsets, [(1, 0, 0), (0, 0, 3), (1, 4, 0), (1, 65_540, 9)]);
        // 12 narrow indices are 24 bytes; 3 wide ones follow.
        assert_eq!((plan.wide_indices_bytes, plan.index_bytes), (24, 36));
        assert_eq!(plan.meshes[2].index_width, IndexWidth::U32);
    }

    #[test]
    fn what_is_not_drawn_takes_no_memory() {
        let meshes = [mesh(3, vec![0, 1, 2]), mesh(70_000, vec![0, 1, 69_999]), mesh(4, vec![1, 2, 3])];
        let drawn = Some(Streams::default());
        let plan = plan(&meshes, &[drawn, None, drawn]).unwrap();
        assert_eq!((plan.vertex_bytes, plan.index_bytes), (7 * 12, 12));
        assert_eq!((plan.meshes[1].vertex_count, plan.meshes[1].index_count), (0, 0));
        assert_eq!((plan.meshes[2].vertex_offset, plan.meshes[2].first_index), (3, 3));
    }

    #[test]
    fn wide_indices_are_aligned() {
        let meshes = [mesh(3, vec![0, 1, 2]), mesh(70_000, vec![0, 1, 69_999])];
        let plan = plan(&meshes, &[Some(Streams::default()); 2]).unwrap();
        // 3 narrow indices are 6 bytes, rounded up to 8.
        assert_eq!((plan.wide_indices_bytes, plan.index_bytes), (8, 20));
    }

    #[test]
    fn texcoords_interleave_and_default() {
        let mut m = mesh(2, vec![]);
        m.texcoords[1] = vec![Vec2::new(1.0, 2.0), Vec2::new(3.0, 4.0)];
        let both = Streams { texcoords: [true, true], ..Default::default() };
        let bytes = |floats: [f32; 8]| bytemuck::cast::<[f32; 8], [u8; 32]>(floats);
        let interleaved = attribute(&m, StreamKind::Texcoords, both);
        assert_eq!(*interleaved, bytes([0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 3.0, 4.0]));
        assert_eq!(*attribute(&m, StreamKind::Color, both), bytes([1.0; 8]));
    }

    #[test]
    fn broken_meshes_are_refused() {
        let mut short = mesh(3, vec![0, 1, 2]);
        short.normals = vec![Vec3::X; 2];
        for bad in [short, mesh(3, vec![0, 1, 3])] {
            assert!(plan(&[bad], &[Some(Streams::default())]).is_err());
        }
        assert!(plan(&[mesh(3, vec![])], &[]).is_err());
    }
}

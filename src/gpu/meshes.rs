//! A scene's meshes on the device, in pieces that came at different times.

use std::sync::Arc;

use super::{Device, Geometry, MeshRange, Streams, Upload, texel_bytes};
use crate::Result;
use crate::scene::Mesh;

/// A scene's meshes: what came together lies together. Renderers of later states of a scene share what has not changed.
///
/// A piece is kept while more than half of it is used and it is no smaller than all that came after it. So there are few of them
/// (their number grows with the logarithm of what there is), and less than half of the memory holds what is no longer used.
pub(super) struct Meshes {
    pieces: Vec<Arc<Geometry>>,
    /// By mesh, the piece that holds it; `None` of what is not drawn.
    piece_of: Vec<Option<usize>>,
}

impl Meshes {
    /// `streams` says what each mesh needs, `None` that it is not drawn. Meshes that `kept` has as they are wanted, and that are not
    /// among its changed ones, are shared with it.
    ///
    /// # Errors
    /// As [`Geometry::new`].
    pub(super) fn new(
        device: &Device,
        upload: &mut Upload,
        meshes: &[Mesh],
        streams: &[Option<Streams>],
        kept: Option<(&Self, &[usize])>,
    ) -> Result<Self> {
        let mut all = Self { pieces: Vec::new(), piece_of: vec![None; meshes.len()] };
        if let Some((old, changed)) = kept {
            all.keep(old, changed, meshes, streams);
        }
        let is_missing = |mesh: usize| all.piece_of[mesh].is_none();
        let missing: Vec<_> =
            streams.iter().enumerate().map(|(mesh, streams)| streams.filter(|_| is_missing(mesh))).collect();
        if missing.iter().any(Option::is_some) {
            let piece = Geometry::new(device, upload, meshes, &missing)?;
            for mesh in (0..meshes.len()).filter(|&mesh| missing[mesh].is_some()) {
                all.piece_of[mesh] = Some(all.pieces.len());
            }
            all.pieces.push(Arc::new(piece));
        }
        Ok(all)
    }

    /// Takes over what can stay.
    fn keep(&mut self, old: &Self, changed: &[usize], meshes: &[Mesh], streams: &[Option<Streams>]) {
        let size = |mesh: usize| streams[mesh].map_or(0, |streams| bytes(&meshes[mesh], streams));
        let is_same = |mesh: usize| {
            old.range(mesh).is_some_and(|(_, geometry, range)| {
                streams[mesh] == Some(geometry.groups()[range.group].streams) && !changed.contains(&mesh)
            })
        };
        let same: Vec<_> = (0..meshes.len().min(old.piece_of.len())).filter(|&mesh| is_same(mesh)).collect();
        let mut later =
            (0..meshes.len()).filter(|mesh| same.binary_search(mesh).is_err()).map(size).sum::<u64>();
        for (index, piece) in old.pieces.iter().enumerate().rev() {
            let of_piece = || same.iter().copied().filter(|&mesh| old.piece_of[mesh] == Some(index));
            let used: u64 = of_piece().map(size).sum();
            if used >= later && 2 * used > piece.content_bytes() {
                of_piece().for_each(|mesh| self.piece_of[mesh] = Some(self.pieces.len()));
                self.pieces.push(Arc::clone(piece));
            }
            later += used;
        }
    }

    /// The piece that holds a mesh, by its number and itself, and where in it; `None` if the mesh is not drawn.
    pub(super) fn range(&self, mesh: usize) -> Option<(usize, &Geometry, &MeshRange)> {
        let piece = (*self.piece_of.get(mesh)?)?;
        let geometry = &*self.pieces[piece];
        Some((piece, geometry, &geometry.meshes()[mesh]))
    }

    /// The same of a mesh that is drawn.
    pub(super) fn drawn(&self, mesh: usize) -> (usize, &Geometry, &MeshRange) {
        self.range(mesh).expect("batches are made of meshes that are drawn")
    }

    /// Device memory.
    pub(super) fn allocated_bytes(&self) -> u64 {
        self.pieces.iter().map(|piece| piece.allocated_bytes()).sum()
    }
}

/// What a mesh takes on the device.
fn bytes(mesh: &Mesh, streams: Streams) -> u64 {
    let vertices = mesh.positions.len();
    let vertex: u32 = streams.list().iter().map(|(_, format)| texel_bytes(*format).unwrap_or_default()).sum();
    let index = super::IndexWidth::for_vertices(vertices).bytes();
    vertices as u64 * u64::from(vertex) + mesh.indices.len() as u64 * index
}

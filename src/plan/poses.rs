//! Meshes that bend: what posing them takes.

use std::collections::BTreeSet;

use serde::Serialize;

use super::element;
use crate::scene::{Mesh, MorphTarget, Scene};

/// What bends of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PosedNeed {
    /// How many meshes are drawn that bend.
    pub meshes: usize,
    /// Their vertices.
    pub vertices: usize,
    /// Their joints.
    pub joints: usize,
    /// Their morph targets.
    pub targets: usize,
    /// Bytes that posing all of them reads at most: when every morph target has a weight.
    pub read_bytes: usize,
    /// Bytes that it writes.
    pub written_bytes: usize,
    /// The first of them.
    pub why: String,
}

impl PosedNeed {
    /// Of a scene; `None` if nothing that is drawn bends.
    pub(super) fn of(scene: &Scene) -> Option<Self> {
        let drawn: BTreeSet<usize> = scene.drawn_instances().map(|instance| instance.mesh).collect();
        let mut all: Option<Self> = None;
        for (index, mesh) in drawn.into_iter().map(|index| (index, &scene.meshes[index])) {
            let Some(deformation) = &mesh.deformation else { continue };
            let list = all.get_or_insert_with(|| Self {
                meshes: 0,
                vertices: 0,
                joints: 0,
                targets: 0,
                read_bytes: 0,
                written_bytes: 0,
                why: element("mesh", &mesh.name, index),
            });
            let own = vertex_bytes(mesh, scene.materials[mesh.material].unlit);
            let numbers = |MorphTarget { positions, normals, tangents }: &MorphTarget| {
                3 * (positions.len() + normals.len() + tangents.len())
            };
            list.meshes += 1;
            list.vertices += mesh.positions.len();
            list.joints += deformation.pose.object_from_bind.len();
            list.targets += deformation.targets.len();
            list.written_bytes += own;
            list.read_bytes += own
                + 24 * deformation.influences.len()
                + 48 * deformation.pose.object_from_bind.len()
                + 4 * deformation.targets.iter().map(numbers).sum::<usize>();
        }
        all
    }
}

/// Positions, normals and tangents, as far as they are read.
fn vertex_bytes(mesh: &Mesh, unlit: bool) -> usize {
    let normals = if unlit { 0 } else { mesh.normals.len() };
    12 * (mesh.positions.len() + normals) + 16 * mesh.tangents.len()
}

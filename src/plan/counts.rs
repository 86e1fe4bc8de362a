//! What a frame's commands consist of.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

/// What was recorded for a frame, and what was left out of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FrameCounts {
    /// Draw calls, full-screen ones included.
    pub draws: usize,
    /// Triangles that they submit, instances counted.
    pub triangles: u64,
    /// Bindings before them.
    pub state_changes: StateChanges,
    /// Instances that have triangles.
    pub objects: Seen,
    /// Lights that are not dark; hemispheres, which light everything, aside.
    pub lights: Seen,
}

/// Bindings, by what is bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct StateChanges {
    /// Graphics pipelines.
    pub pipelines: usize,
    /// Descriptor sets.
    pub descriptor_sets: usize,
    /// Sets of vertex buffers.
    pub vertex_buffers: usize,
    /// Index buffers.
    pub index_buffers: usize,
}

/// How many of a kind a frame deals with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Seen {
    /// In view.
    pub visible: usize,
    /// Out of view, and so left out.
    pub culled: usize,
}

impl StateChanges {
    /// All of them.
    pub fn total(&self) -> usize {
        self.pipelines + self.descriptor_sets + self.vertex_buffers + self.index_buffers
    }
}

impl Seen {
    /// `visible` of `all`.
    pub fn of(visible: usize, all: usize) -> Self {
        Self { visible, culled: all - visible }
    }
}

impl Display for FrameCounts {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let StateChanges { pipelines, descriptor_sets, vertex_buffers, index_buffers } = self.state_changes;
        let of = |seen: Seen| format!("{} of {}", seen.visible, seen.visible + seen.culled);
        write!(
            f,
            "{} draws of {} triangles; bound: {pipelines} pipelines, {descriptor_sets} descriptor sets, \
             {vertex_buffers} vertex buffers, {index_buffers} index buffers; in view: {} objects, {} lights (hemispheres aside)",
            self.draws,
            self.triangles,
            of(self.objects),
            of(self.lights)
        )
    }
}

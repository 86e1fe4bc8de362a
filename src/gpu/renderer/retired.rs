//! What earlier states of a scene leave behind until the GPU has finished with it.

use super::Renderer;
use crate::gpu::Upload;

/// Things that are kept for the GPU, and what is known of its progress: a slot is recorded again only after its last frame has
/// finished, and frames finish in the order of recording, since all go to one queue.
pub(super) struct Retired {
    left: Vec<Left>,
    /// The number of the last frame recorded with each slot; 0 is none.
    frame_of_slot: Vec<u64>,
    /// How many frames were recorded.
    recorded: u64,
}

/// A renderer of an earlier state, and staging memory.
struct Left {
    /// The number of the last frame that may use it.
    last_frame: u64,
    _renderer: Box<Renderer>,
    _uploads: Vec<Upload>,
}

impl Retired {
    pub(super) fn new(slots: usize) -> Self {
        Self { left: Vec::new(), frame_of_slot: vec![0; slots], recorded: 0 }
    }

    /// A frame is about to be recorded with this slot.
    pub(super) fn recording(&mut self, slot: usize) {
        let finished = self.frame_of_slot[slot];
        self.left.retain(|left| left.last_frame > finished);
        self.recorded += 1;
        self.frame_of_slot[slot] = self.recorded;
    }

    /// Keeps what commands use that are submitted no later than the next frame.
    pub(super) fn leave(&mut self, renderer: Renderer, uploads: Vec<Upload>) {
        let last_frame = self.recorded + 1;
        self.left.push(Left { last_frame, _renderer: Box::new(renderer), _uploads: uploads });
    }
}

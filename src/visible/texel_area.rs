//! Rectangles of texels.

/// A part of a tile, texels from its corner: from `min` to before `max`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TexelArea {
    /// From the left and from the top.
    pub min: [u32; 2],
    /// If not above `min` in both, the area is empty.
    pub max: [u32; 2],
}

impl TexelArea {
    fn is_empty(&self) -> bool {
        (0..2).any(|axis| self.max[axis] <= self.min[axis])
    }

    /// The smallest area that holds both.
    pub fn union(self, other: Self) -> Self {
        match (self.is_empty(), other.is_empty()) {
            (true, _) => other,
            (_, true) => self,
            _ => Self {
                min: [0, 1].map(|axis| self.min[axis].min(other.min[axis])),
                max: [0, 1].map(|axis| self.max[axis].max(other.max[axis])),
            },
        }
    }
}

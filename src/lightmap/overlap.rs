//! Triangles in a plane that must not cover each other.

use std::collections::HashMap;

use glam::{DVec2, IVec2};

/// Triangles may intrude on each other by this share of the smaller one's height: neighbours meet at edges that rounding
/// moves.
const SLACK: f64 = 1e-4;

/// A triangle takes part in this many cells along an axis at most; larger ones are in all of them at once.
const MOST_CELLS: i32 = 64;

/// A set of triangles that can be asked what they cover.
pub struct Flat {
    triangles: Vec<[DVec2; 3]>,
    cell: f64,
    cells: HashMap<IVec2, Vec<u32>>,
    large: Vec<u32>,
}

impl Flat {
    /// An empty set. `cell` is about the size of a triangle.
    pub fn new(cell: f64) -> Self {
        Self { triangles: Vec::new(), cell, cells: HashMap::new(), large: Vec::new() }
    }

    /// Adds a triangle.
    pub fn add(&mut self, corners: [DVec2; 3]) {
        let index = self.triangles.len() as u32;
        self.triangles.push(corners);
        match self.cells_of(&corners) {
            Some([low, high]) => {
                for cell in between(low, high) {
                    self.cells.entry(cell).or_default().push(index);
                }
            }
            None => self.large.push(index),
        }
    }

    /// Whether the triangle covers part of one that was added.
    pub fn overlaps(&self, corners: &[DVec2; 3]) -> bool {
        let hits = |&index: &u32| overlap(&self.triangles[index as usize], corners);
        match self.cells_of(corners) {
            Some([low, high]) => {
                self.large.iter().any(hits)
                    || between(low, high).filter_map(|cell| self.cells.get(&cell)).flatten().any(hits)
            }
            None => (0..self.triangles.len() as u32).any(|index| hits(&index)),
        }
    }

    /// The triangles in the order in which they were added.
    pub fn into_triangles(self) -> Vec<[DVec2; 3]> {
        self.triangles
    }

    fn cells_of(&self, corners: &[DVec2; 3]) -> Option<[IVec2; 2]> {
        let low = corners[0].min(corners[1]).min(corners[2]) / self.cell;
        let high = corners[0].max(corners[1]).max(corners[2]) / self.cell;
        let (low, high) = (low.floor().as_ivec2(), high.floor().as_ivec2());
        let few = high.saturating_sub(low).max_element() < MOST_CELLS;
        few.then_some([low, high])
    }
}

fn between(low: IVec2, high: IVec2) -> impl Iterator<Item = IVec2> {
    (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| IVec2::new(x, y)))
}

/// Whether two triangles of either winding share more than an edge: no edge of either separates them (the separating
/// axis theorem for convex shapes).
fn overlap(a: &[DVec2; 3], b: &[DVec2; 3]) -> bool {
    !separated_by_edge(a, b) && !separated_by_edge(b, a)
}

fn separated_by_edge(of: &[DVec2; 3], other: &[DVec2; 3]) -> bool {
    (0..3).any(|k| {
        let (from, to, apex) = (of[k], of[(k + 1) % 3], of[(k + 2) % 3]);
        let along = to - from;
        let height = along.perp_dot(apex - from);
        if height == 0.0 {
            return false;
        }
        let depth = |p: &DVec2| along.perp_dot(*p - from) * height.signum();
        let (low, high) =
            other.iter().map(depth).fold((f64::MAX, f64::MIN), |(l, h), d| (l.min(d), h.max(d)));
        high <= SLACK * height.abs().min(high - low)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(points: [[f64; 2]; 3]) -> [DVec2; 3] {
        points.map(DVec2::from)
    }

    #[test]
    fn neighbours_touch_and_others_cover() {
        let a = triangle([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        let cases = [
            (triangle([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), false),
            (triangle([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]), false),
            (triangle([[0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]]), false),
            (triangle([[0.5, 0.5], [2.0, 0.5], [2.0, 2.0]]), false),
            (triangle([[0.4, 0.4], [2.0, 0.5], [2.0, 2.0]]), true),
            (triangle([[0.1, 0.1], [0.2, 0.1], [0.1, 0.2]]), true),
            (triangle([[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]]), true),
            (a, true),
            (triangle([[5.0, 5.0], [6.0, 5.0], [5.0, 6.0]]), false),
        ];
        for (b, expected) in cases {
            let mut flat = Flat::new(0.3);
            flat.add(a);
            assert_eq!(flat.overlaps(&b), expected, "{b:?}");
            let mut other = Flat::new(0.01);
            other.add(b);
            assert_eq!(other.overlaps(&a), expected, "{b:?} the other way");
        }
    }
}

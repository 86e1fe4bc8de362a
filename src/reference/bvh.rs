//! A bounding volume hierarchy: which boxes a ray may meet, nearest first.

use glam::DVec3;

use super::view::Ray;

/// Boxes per leaf: below this, splitting costs more than it saves.
const LEAF_SIZE: usize = 4;

/// A binary tree of axis-aligned boxes, split at the median along the longest axis of the centres.
pub(super) struct Bvh {
    nodes: Vec<Node>,
    /// Item indices, grouped by leaf.
    order: Vec<u32>,
}

#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Bounds {
    pub fn of(points: &[DVec3]) -> Self {
        let empty = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        points.iter().fold(empty, |b, p| Self { min: b.min.min(*p), max: b.max.max(*p) })
    }

    fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }
}

struct Node {
    bounds: Bounds,
    /// A leaf's first place in `order`; an inner node's second child (the first one follows the node).
    link: u32,
    /// Items in a leaf; 0 in an inner node.
    count: u32,
}

impl Bvh {
    pub fn build(items: &[Bounds]) -> Self {
        let mut bvh = Self { nodes: Vec::new(), order: (0..items.len() as u32).collect() };
        if !items.is_empty() {
            bvh.build_range(items, 0, items.len());
        }
        bvh
    }

    fn build_range(&mut self, items: &[Bounds], start: usize, end: usize) {
        let range = &mut self.order[start..end];
        let bounds = range.iter().map(|&i| items[i as usize]).reduce(Bounds::union).expect("range has items");
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, link: start as u32, count: (end - start) as u32 });
        if end - start <= LEAF_SIZE {
            return;
        }
        let centers: Vec<_> = range.iter().map(|&i| items[i as usize].center()).collect();
        let spread = Bounds::of(&centers);
        let extent = spread.max - spread.min;
        let axis = if extent.x >= extent.max_element() {
            0
        } else if extent.y >= extent.z {
            1
        } else {
            2
        };
        let middle = range.len() / 2;
        range.select_nth_unstable_by(middle, |&a, &b| {
            let (ca, cb) = (items[a as usize].center()[axis], items[b as usize].center()[axis]);
            ca.total_cmp(&cb).then(a.cmp(&b))
        });
        self.build_range(items, start, start + middle);
        self.nodes[node].link = self.nodes.len() as u32;
        self.nodes[node].count = 0;
        self.build_range(items, start + middle, end);
    }

    /// Calls `visit(item)` for every item whose box the ray meets no farther than the distance that the last
    /// call returned (the nearest hit so far); the ray's far plane before the first.
    pub fn traverse(&self, ray: &Ray, mut visit: impl FnMut(u32) -> f64) {
        if self.nodes.is_empty() {
            return;
        }
        let slabs = Slabs::new(ray);
        let mut farthest = ray.range[1];
        // Depth of a median-split tree over u32 indices is at most 32; each level leaves one node behind.
        let mut stack = [(0_u32, 0.0_f64); 64];
        let mut top = 0;
        let Some(root) = slabs.entry(&self.nodes[0].bounds, farthest) else { return };
        stack[top] = (0, root);
        top += 1;
        while top > 0 {
            top -= 1;
            let (index, entry) = stack[top];
            if entry > farthest {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for &item in &self.order[node.link as usize..(node.link + node.count) as usize] {
                    farthest = visit(item);
                }
                continue;
            }
            let (first, second) = (index + 1, node.link);
            let first_entry = slabs.entry(&self.nodes[first as usize].bounds, farthest);
            let second_entry = slabs.entry(&self.nodes[second as usize].bounds, farthest);
            let (mut far, mut near) = (first_entry.map(|e| (first, e)), second_entry.map(|e| (second, e)));
            if let (Some(f), Some(n)) = (far, near)
                && n.1 > f.1
            {
                (far, near) = (near, far);
            }
            for child in [far, near].into_iter().flatten() {
                stack[top] = child;
                top += 1;
            }
        }
    }
}

/// The slab test for one ray.
struct Slabs {
    origin: DVec3,
    inverse: DVec3,
    nearest: f64,
}

impl Slabs {
    /// Widens the far bound past the rounding of two subtractions and two products.
    const WIDEN: f64 = 1.0 + 16.0 * f64::EPSILON;

    fn new(ray: &Ray) -> Self {
        // A direction of exactly 0 would give 0 * infinity on a slab's face.
        let inverse = |d: f64| if d.abs() < 1e-150 { 1e150_f64.copysign(d) } else { d.recip() };
        let d = ray.direction;
        Self {
            origin: ray.origin,
            inverse: DVec3::new(inverse(d.x), inverse(d.y), inverse(d.z)),
            nearest: ray.range[0],
        }
    }

    /// The distance at which the ray enters the box, if it does before `farthest`.
    fn entry(&self, bounds: &Bounds, farthest: f64) -> Option<f64> {
        let a = (bounds.min - self.origin) * self.inverse;
        let b = (bounds.max - self.origin) * self.inverse;
        let enter = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z).max(self.nearest));
        let leave = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z).min(farthest));
        let slack = (Self::WIDEN - 1.0) * (enter.abs() + leave.abs());
        (enter <= leave + slack).then_some(enter - slack)
    }
}

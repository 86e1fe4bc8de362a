//! Which parts of which triangles a texel stands for.

use glam::DVec2;

use crate::scene::{Instance, Scene};

/// A triangle on the map, in texels.
struct Flat {
    /// Index among the triangles of all instances.
    index: u32,
    /// The same for triangles that share vertices.
    chart: u32,
    corners: [DVec2; 3],
}

/// The triangles around each texel.
pub struct Texels {
    width: u32,
    triangles: Vec<Flat>,
    /// Of each texel, its part of `list`.
    starts: Vec<u32>,
    /// Indices into `triangles`.
    list: Vec<u32>,
}

/// One texel: what lies within a texel's width of its centre, so that a bilinear filter shows it there.
pub struct Texel<'a> {
    texels: &'a Texels,
    center: DVec2,
    triangles: &'a [u32],
}

impl Texels {
    /// Spreads the instances that have a part of the map over its texels.
    pub fn new(scene: &Scene, [width, height]: [u32; 2]) -> Self {
        let triangles = flatten(scene, [width, height]);
        let mut near: Vec<(u32, u32)> = Vec::new();
        for (index, triangle) in (0..).zip(&triangles) {
            let [a, b, c] = triangle.corners;
            // Centres are at halves.
            let low = (a.min(b).min(c) - 1.5).ceil().max(DVec2::ZERO);
            let most = DVec2::new(f64::from(width), f64::from(height)) - 1.0;
            let high = (a.max(b).max(c) + 0.5).floor().min(most);
            for y in low.y as u32..(high.y + 1.0) as u32 {
                for x in low.x as u32..(high.x + 1.0) as u32 {
                    let center = center(x, y);
                    let (_, nearest) = nearest_in(&triangle.corners, center);
                    if (nearest - center).abs().max_element() <= 1.0 {
                        near.push((y * width + x, index));
                    }
                }
            }
        }
        near.sort_unstable();
        let mut starts = vec![0; width as usize * height as usize + 1];
        near.iter().for_each(|(texel, _)| starts[*texel as usize + 1] += 1);
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        Self { width, triangles, starts, list: near.into_iter().map(|(_, triangle)| triangle).collect() }
    }

    /// The texel in column `x` of row `y`.
    pub fn at(&self, x: u32, y: u32) -> Texel<'_> {
        let index = (y * self.width + x) as usize;
        let triangles = &self.list[self.starts[index] as usize..self.starts[index + 1] as usize];
        Texel { texels: self, center: center(x, y), triangles }
    }
}

impl Texel<'_> {
    /// Whether no triangle is near.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The chart of the triangle that is nearest to the centre.
    pub fn chart(&self) -> Option<u32> {
        (!self.is_empty()).then(|| self.nearest(self.center).0.chart)
    }

    /// A triangle's index and barycentric coordinates at this place of the texel, in \[0, 1\]: there, or where the triangles come
    /// nearest.
    pub fn place(&self, within: [f64; 2]) -> (u32, [f64; 3]) {
        let (triangle, barycentric) = self.nearest(self.center - 0.5 + DVec2::from(within));
        (triangle.index, barycentric)
    }

    fn nearest(&self, point: DVec2) -> (&Flat, [f64; 3]) {
        let candidates = self.triangles.iter().map(|&i| {
            let triangle = &self.texels.triangles[i as usize];
            let (barycentric, nearest) = nearest_in(&triangle.corners, point);
            (triangle, barycentric, nearest.distance_squared(point))
        });
        let best = candidates.reduce(|a, b| if b.2 < a.2 { b } else { a });
        let (triangle, barycentric, _) = best.expect("the texel is not empty");
        (triangle, barycentric)
    }
}

fn center(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y)) + 0.5
}

/// All triangles with area on the map.
fn flatten(scene: &Scene, [width, height]: [u32; 2]) -> Vec<Flat> {
    let size = DVec2::new(f64::from(width), f64::from(height));
    let mut triangles = Vec::new();
    let (mut first_triangle, mut first_chart) = (0, 0);
    for instance in scene.drawn_instances().filter(|instance| !instance.dynamic) {
        let mesh = &scene.meshes[instance.mesh];
        let first = first_triangle;
        first_triangle += mesh.indices.len() as u32 / 3;
        let Some(rect) = lit_rect(scene, instance) else { continue };
        let charts = connected(&mesh.indices, mesh.positions.len());
        for (index, corners) in (first..).zip(mesh.indices.chunks_exact(3)) {
            let place = |i: u32| rect.uv(mesh.texcoords[1][i as usize]).as_dvec2() * size;
            let [a, b, c] = [corners[0], corners[1], corners[2]].map(place);
            if (b - a).perp_dot(c - a) != 0.0 {
                let chart = first_chart + charts[corners[0] as usize];
                triangles.push(Flat { index, chart, corners: [a, b, c] });
            }
        }
        first_chart += mesh.positions.len() as u32;
    }
    triangles
}

fn lit_rect<'a>(scene: &Scene, instance: &'a Instance) -> Option<&'a crate::scene::LightmapRect> {
    let unlit = scene.materials[scene.meshes[instance.mesh].material].unlit;
    instance.lightmap.as_ref().filter(|_| !unlit)
}

/// Of each vertex, a number that it shares with the vertices that it is connected to by triangles.
fn connected(indices: &[u32], vertices: usize) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..vertices as u32).collect();
    fn root(parents: &mut [u32], mut i: u32) -> u32 {
        while parents[i as usize] != i {
            // Halving keeps later ways short.
            parents[i as usize] = parents[parents[i as usize] as usize];
            i = parents[i as usize];
        }
        i
    }
    for corners in indices.chunks_exact(3) {
        let first = root(&mut parents, corners[0]);
        for &corner in &corners[1..] {
            let other = root(&mut parents, corner);
            parents[other as usize] = first;
        }
    }
    (0..vertices as u32).map(|i| root(&mut parents, i)).collect()
}

/// The point of a triangle that is nearest to `point`, and its barycentric coordinates.
fn nearest_in(corners: &[DVec2; 3], point: DVec2) -> ([f64; 3], DVec2) {
    let [a, b, c] = *corners;
    let area = (b - a).perp_dot(c - a);
    let weight = |p: DVec2, q: DVec2| (p - point).perp_dot(q - point) / area;
    let inside = [weight(b, c), weight(c, a), weight(a, b)];
    if inside.iter().all(|w| *w >= 0.0) {
        return (inside, point);
    }
    let edges = (0..3).map(|k| {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let t = ((point - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
        let mut weights = [0.0; 3];
        (weights[k], weights[(k + 1) % 3]) = (1.0 - t, t);
        (weights, from.lerp(to, t))
    });
    let nearer = |x: ([f64; 3], DVec2), y: ([f64; 3], DVec2)| {
        if y.1.distance_squared(point) < x.1.distance_squared(point) { y } else { x }
    };
    edges.reduce(nearer).expect("a triangle has edges")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_of_a_triangle() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]].map(DVec2::from);
        let turned = [corners[0], corners[2], corners[1]];
        let cases = [
            ([1.0, 1.0], [1.0, 1.0]),
            ([-1.0, 2.0], [0.0, 2.0]),
            ([9.0, -1.0], [4.0, 0.0]),
            ([3.0, 3.0], [2.0, 2.0]),
        ];
        for (point, expected) in cases {
            for corners in [corners, turned] {
                let (weights, nearest) = nearest_in(&corners, DVec2::from(point));
                assert!((nearest - DVec2::from(expected)).length() < 1e-12, "{point:?}: {nearest}");
                let back: DVec2 = (0..3).map(|k| corners[k] * weights[k]).sum();
                assert!((back - nearest).length() < 1e-12);
            }
        }
    }
}

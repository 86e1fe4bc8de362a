//! Coordinates that give each part of a surface texels of its own.

use std::collections::HashMap;

use glam::{DMat3, DVec2, DVec3, Vec2, Vec3};

use super::charts::{self, Chart};
use super::overlap::Flat;
use super::pack::{Packed, pack_square};

/// Triangles with one list of vertices: a glTF primitive.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Object space.
    pub positions: &'a [Vec3],
    /// Coordinates that may serve as they are; empty if there are none.
    pub texcoords: &'a [Vec2],
    /// Three per triangle.
    pub indices: &'a [u32],
}

/// A mesh's surface, flattened: its own coordinates, or charts.
#[derive(Debug)]
pub enum Unwrap {
    /// The file's coordinates serve.
    Own {
        /// Metres that the coordinates' unit square stands for, at the mean of its triangles.
        side_m: f64,
    },
    /// Charts to be packed.
    Charts {
        /// Of all parts together.
        charts: Vec<Chart>,
        /// The first triangle of each part in the order of all.
        first_triangles: Vec<u32>,
    },
}

/// An unwrapped mesh at some density.
#[derive(Debug)]
pub struct Layout {
    /// Texels that the mesh's coordinates from (0, 0) to (1, 1) span.
    pub size: [u32; 2],
    /// Texels around them that bilinear sampling reaches.
    pub border: u32,
    packed: Packed,
    texels_per_metre: f64,
}

/// New vertices of a part: copies of old ones with coordinates.
#[derive(Debug, Default, PartialEq)]
pub struct Vertices {
    /// The old vertex of each new one.
    pub sources: Vec<u32>,
    /// In \[0, 1\].
    pub texcoords: Vec<Vec2>,
    /// Three per triangle, of the new vertices.
    pub indices: Vec<u32>,
}

impl Layout {
    /// Texels that the mesh takes in a lightmap.
    pub fn outer_size(&self) -> [u32; 2] {
        self.size.map(|side| side + 2 * self.border)
    }
}

impl Unwrap {
    /// Flattens a mesh as it stands in the world after `world_from_object` (where it is largest, if there are several). Its
    /// own coordinates serve if all parts have some, they lie within \[0, 1\], and no triangle covers another.
    pub fn new(parts: &[Part], world_from_object: &DMat3) -> Self {
        let mut triangles = Vec::new();
        let mut first_triangles = Vec::new();
        for part in parts {
            first_triangles.push(triangles.len() as u32);
            let place = |i: u32| *world_from_object * part.positions[i as usize].as_dvec3();
            triangles.extend(part.indices.chunks_exact(3).map(|t| [place(t[0]), place(t[1]), place(t[2])]));
        }
        match own_side_m(parts, &triangles) {
            Some(side_m) => Self::Own { side_m },
            None => Self::Charts { charts: charts::cut(&triangles), first_triangles },
        }
    }

    /// Where everything lies at this density.
    pub fn lay_out(&self, texels_per_metre: f64) -> Layout {
        match self {
            Self::Own { side_m } => {
                let side = texels(side_m * texels_per_metre).max(1);
                Layout { size: [side; 2], border: 1, packed: pack_square(&[]), texels_per_metre }
            }
            Self::Charts { charts, .. } => {
                // A chart begins a texel inside its rectangle and ends as far before the other side, so that a bilinear filter
                // reads no texel of others.
                let sizes: Vec<_> = charts
                    .iter()
                    .map(|c| (c.extent_m * texels_per_metre).to_array().map(|side| texels(side) + 2))
                    .collect();
                let packed = pack_square(&sizes);
                Layout { size: packed.size.map(|side| side.max(1)), border: 0, packed, texels_per_metre }
            }
        }
    }

    /// The new vertices of all parts; `None` if the old ones serve. Vertices on the border between charts become
    /// several.
    pub fn vertices(&self, parts: &[Part], layout: &Layout) -> Option<Vec<Vertices>> {
        let Self::Charts { charts, first_triangles } = self else { return None };
        let count = parts.iter().map(|p| p.indices.len() / 3).sum();
        // Triangles without area are in no chart: wherever they lie, they show nothing.
        let mut placed: Vec<(usize, [Vec2; 3])> = vec![(usize::MAX, [Vec2::ZERO; 3]); count];
        let size = DVec2::new(f64::from(layout.size[0]), f64::from(layout.size[1]));
        for (index, (chart, corner)) in charts.iter().zip(&layout.packed.places).enumerate() {
            let corner = DVec2::new(f64::from(corner[0]), f64::from(corner[1])) + 1.0;
            for (&triangle, corners) in chart.triangles.iter().zip(&chart.corners_m) {
                let place = |p: DVec2| ((corner + p * layout.texels_per_metre) / size).as_vec2();
                placed[triangle as usize] = (index, corners.map(place));
            }
        }
        let of_part = |(part, &first): (&Part, &u32)| {
            let mut known: HashMap<(u32, usize), u32> = HashMap::new();
            let mut new = Vertices::default();
            for (corners, (chart, uvs)) in part.indices.chunks_exact(3).zip(&placed[first as usize..]) {
                for (&source, &uv) in corners.iter().zip(uvs) {
                    let index = *known.entry((source, *chart)).or_insert_with(|| {
                        new.sources.push(source);
                        new.texcoords.push(uv);
                        new.sources.len() as u32 - 1
                    });
                    new.indices.push(index);
                }
            }
            new
        };
        Some(parts.iter().zip(first_triangles).map(of_part).collect())
    }
}

/// The side in metres that the unit square of the parts' own coordinates stands for; `None` if they cannot serve.
fn own_side_m(parts: &[Part], triangles: &[[DVec3; 3]]) -> Option<f64> {
    if parts.is_empty() || parts.iter().any(|p| p.texcoords.len() != p.positions.len()) {
        return None;
    }
    /// Exporters round.
    const OUTSIDE: f32 = 1e-4;
    let inside = |uv: &Vec2| uv.min_element() >= -OUTSIDE && uv.max_element() <= 1.0 + OUTSIDE;
    if !parts.iter().all(|p| p.indices.iter().all(|&i| inside(&p.texcoords[i as usize]))) {
        return None;
    }
    let (mut area_uv, mut area_m2) = (0.0, 0.0);
    let mut flat = Flat::new((triangles.len().max(1) as f64).sqrt().recip());
    let corners = parts.iter().flat_map(|p| p.indices.chunks_exact(3).map(move |t| (p, t)));
    for ((part, t), [a, b, c]) in corners.zip(triangles) {
        let uv = [t[0], t[1], t[2]].map(|i| part.texcoords[i as usize].as_dvec2());
        let area = (b - a).cross(c - a).length() * 0.5;
        if area == 0.0 {
            continue;
        }
        let on_map = (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs() * 0.5;
        if on_map == 0.0 || flat.overlaps(&uv) {
            return None;
        }
        flat.add(uv);
        area_uv += on_map;
        area_m2 += area;
    }
    (area_uv > 0.0).then(|| (area_m2 / area_uv).sqrt())
}

fn texels(side: f64) -> u32 {
    // Saturates: such a layout fits nowhere, which is for the caller to say.
    side.ceil().min(f64::from(1 << 24)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    const QUAD_INDICES: [u32; 6] = [0, 1, 2, 0, 2, 3];

    fn own(texcoords: &[Vec2]) -> Unwrap {
        let part = Part { positions: &QUAD, texcoords, indices: &QUAD_INDICES };
        Unwrap::new(&[part], &DMat3::from_diagonal(DVec3::splat(3.0)))
    }

    #[test]
    fn coordinates_serve_if_no_texel_is_used_twice() {
        let corners = QUAD.map(|p| p.truncate());
        let Unwrap::Own { side_m } = own(&corners.map(|p| p * 0.5)) else { panic!("they serve") };
        // 3 m on half the square's side.
        assert!((side_m - 6.0).abs() < 1e-6, "{side_m}");
        let folded = [corners[0], corners[1], corners[2], corners[1]];
        for wrong in [&[][..], &corners.map(|p| p * 2.0), &folded, &[Vec2::ZERO; 4]] {
            assert!(matches!(own(wrong), Unwrap::Charts { .. }), "{wrong:?}");
        }
    }

    #[test]
    fn charts_keep_a_texel_from_each_other_and_split_vertices() {
        // A roof of two squares that share an edge at right angles, in two parts of one mesh.
        let other = [Vec3::X, Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 1.0, 1.0), Vec3::new(1.0, 1.0, 0.0)];
        let roof: Vec<_> = QUAD.into_iter().chain([other[1], other[2]]).collect();
        let shared = [0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2];
        let parts = [
            Part { positions: &roof, texcoords: &[], indices: &shared },
            Part { positions: &QUAD.map(|p| p + Vec3::Z * 5.0), texcoords: &[], indices: &QUAD_INDICES },
        ];
        let unwrap = Unwrap::new(&parts, &DMat3::from_diagonal(DVec3::splat(2.0)));
        let layout = unwrap.lay_out(8.0);
        // Three squares of 16 texels and two beside them.
        let [width, height] = layout.size;
        assert!((3 * 18 * 18..=36 * 36).contains(&(width * height)), "{width} x {height}");
        let size = Vec2::new(width as f32, height as f32);
        let vertices = unwrap.vertices(&parts, &layout).unwrap();
        assert_eq!(vertices[0].sources.len(), 8, "the shared edge belongs to both charts");
        assert_eq!(vertices[1].sources.len(), 4);
        for (part, new) in parts.iter().zip(&vertices) {
            let back: Vec<_> = new.indices.iter().map(|&i| new.sources[i as usize]).collect();
            assert_eq!(back, part.indices);
        }
        let mut boxes: Vec<[Vec2; 2]> = Vec::new();
        for new in &vertices {
            for square in new.indices.chunks(6) {
                let texel = |&i: &u32| new.texcoords[i as usize] * size;
                let low = square.iter().map(texel).reduce(Vec2::min).unwrap();
                let high = square.iter().map(texel).reduce(Vec2::max).unwrap();
                assert!((high - low - 16.0).abs().max_element() < 1e-4);
                let reach = [(low - 0.5).floor(), (high - 0.5).floor() + 1.0];
                assert!(reach[0].min_element() >= 0.0 && reach[1].cmplt(size).all());
                for [l, h] in &boxes {
                    assert!(
                        (reach[0].cmpgt(*h) | reach[1].cmplt(*l)).any(),
                        "a filter reaches another chart"
                    );
                }
                boxes.push(reach);
            }
        }
    }
}

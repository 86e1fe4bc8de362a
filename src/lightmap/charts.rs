//! Surfaces cut into charts that lie flat without overlap.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{DVec2, DVec3};

use super::overlap::Flat;

/// Triangles further from a chart's plane than this (the cosine of 45 degrees) start another one: within, an area shrinks
/// to no less than that.
const MIN_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A part of a surface, projected onto the plane of its largest triangle.
#[derive(Debug)]
pub struct Chart {
    /// Indices of its triangles.
    pub triangles: Vec<u32>,
    /// Of each triangle's corners: metres from the chart's lower corner.
    pub corners_m: Vec<[DVec2; 3]>,
    /// Metres.
    pub extent_m: DVec2,
}

/// Cuts triangles into charts: from the largest triangle left, over shared edges, as long as triangles face about its way and
/// do not fall onto others. Triangles without area belong to none.
pub fn cut(triangles: &[[DVec3; 3]]) -> Vec<Chart> {
    let normals: Vec<_> = triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a)).collect();
    let neighbours = Neighbours::new(triangles);
    let mut order: Vec<u32> =
        (0..triangles.len() as u32).filter(|&t| normals[t as usize].length() > 0.0).collect();
    order.sort_by(|&a, &b| {
        let size = |t: u32| normals[t as usize].length_squared();
        size(b).total_cmp(&size(a)).then(a.cmp(&b))
    });
    let mut is_taken: Vec<bool> = normals.iter().map(|n| n.length() == 0.0).collect();
    let mut charts = Vec::new();
    for seed in order {
        if is_taken[seed as usize] {
            continue;
        }
        is_taken[seed as usize] = true;
        let axis = normals[seed as usize].normalize();
        let (right, up) = axis.any_orthonormal_pair();
        let project = |t: u32| triangles[t as usize].map(|p| DVec2::new(p.dot(right), p.dot(up)));
        let mut flat = Flat::new(normals[seed as usize].length().sqrt());
        let mut members = Vec::new();
        let mut open = std::collections::VecDeque::from([seed]);
        flat.add(project(seed));
        while let Some(triangle) = open.pop_front() {
            members.push(triangle);
            for &next in neighbours.of(triangle) {
                let facing = normals[next as usize].dot(axis) >= MIN_COSINE * normals[next as usize].length();
                if is_taken[next as usize] || !facing {
                    continue;
                }
                let corners = project(next);
                if flat.overlaps(&corners) {
                    continue;
                }
                flat.add(corners);
                is_taken[next as usize] = true;
                open.push_back(next);
            }
        }
        charts.push(chart(members, flat.into_triangles()));
    }
    charts
}

/// Turns a chart so that its bounding box is smallest among some directions and that of its longest edge.
fn chart(triangles: Vec<u32>, corners: Vec<[DVec2; 3]>) -> Chart {
    const DIRECTIONS: u32 = 16;
    let edges = corners.iter().flat_map(|c| [c[1] - c[0], c[2] - c[1], c[0] - c[2]]);
    let longest = edges.fold(DVec2::X, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
    let turns = (0..DIRECTIONS).map(|i| {
        let quarter = std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(DIRECTIONS);
        DVec2::from_angle(longest.to_angle() + quarter)
    });
    let bounds = |turn: DVec2| {
        let points = corners.iter().flatten().map(|p| unturn(turn, *p));
        points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
    };
    let area = |turn: DVec2| {
        let (low, high) = bounds(turn);
        (high - low).element_product()
    };
    let turn = turns.min_by(|a, b| area(*a).total_cmp(&area(*b))).expect("there are directions");
    let (low, high) = bounds(turn);
    let place = |p: &DVec2| unturn(turn, *p) - low;
    let corners_m = corners.iter().map(|c| [place(&c[0]), place(&c[1]), place(&c[2])]).collect();
    Chart { triangles, corners_m, extent_m: high - low }
}

/// A point in axes that are turned to `turn`.
fn unturn(turn: DVec2, point: DVec2) -> DVec2 {
    DVec2::new(turn.dot(point), turn.perp_dot(point))
}

/// Which triangles share an edge, by the positions of its ends.
struct Neighbours {
    /// Of each triangle, its part of `list`.
    starts: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    fn new(triangles: &[[DVec3; 3]]) -> Self {
        let mut points: HashMap<[u64; 3], u32> = HashMap::new();
        let mut point = |p: DVec3| {
            let next = points.len() as u32;
            // -0 and 0 are one place.
            *points.entry((p + 0.0).to_array().map(f64::to_bits)).or_insert(next)
        };
        let mut edges: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
        let keys: Vec<_> = triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(&mut point);
                [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q)))
            })
            .collect();
        for (index, keys) in (0..).zip(&keys) {
            for key in keys {
                match edges.entry(*key) {
                    Entry::Occupied(mut known) => known.get_mut().push(index),
                    Entry::Vacant(new) => drop(new.insert(vec![index])),
                }
            }
        }
        let (mut starts, mut list) = (vec![0], Vec::new());
        for (index, keys) in (0..).zip(&keys) {
            list.extend(keys.iter().flat_map(|key| &edges[key]).filter(|&&other| other != index));
            starts.push(list.len() as u32);
        }
        Self { starts, list }
    }

    fn of(&self, triangle: u32) -> &[u32] {
        let at = triangle as usize;
        &self.list[self.starts[at] as usize..self.starts[at + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangles of a grid over the unit square, mapped into space.
    fn grid(steps: u32, place: impl Fn(f64, f64) -> DVec3) -> Vec<[DVec3; 3]> {
        let at = |x: u32, y: u32| place(f64::from(x) / f64::from(steps), f64::from(y) / f64::from(steps));
        let cells = (0..steps * steps).map(|i| (i % steps, i / steps));
        cells
            .flat_map(|(x, y)| {
                let corners = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
                [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
            })
            .collect()
    }

    /// Every triangle is in one chart, none overlaps another there, and areas shrink as much as is allowed at most.
    #[track_caller]
    fn check(triangles: &[[DVec3; 3]], charts: &[Chart]) {
        let mut seen = vec![0; triangles.len()];
        for chart in charts {
            let mut flat = Flat::new(chart.extent_m.max_element() * 0.1);
            for (&triangle, corners) in chart.triangles.iter().zip(&chart.corners_m) {
                seen[triangle as usize] += 1;
                assert!(!flat.overlaps(corners), "triangle {triangle} overlaps");
                flat.add(*corners);
                let [a, b, c] = triangles[triangle as usize];
                let ratio = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0])
                    / (b - a).cross(c - a).length();
                assert!((MIN_COSINE - 1e-9..=1.0 + 1e-9).contains(&ratio), "{ratio}");
                let inside =
                    |p: &DVec2| p.min_element() >= -1e-9 && (chart.extent_m - p).min_element() >= -1e-9;
                assert!(corners.iter().all(inside));
            }
        }
        assert!(seen.iter().all(|&count| count == 1), "{seen:?}");
    }

    #[test]
    fn a_plane_is_one_chart_that_fits_its_box() {
        // Turned in space and in its plane.
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, 0.7);
        let triangles = grid(4, |x, y| turn * DVec3::new(x * 3.0, y, 0.0));
        let charts = cut(&triangles);
        check(&triangles, &charts);
        assert_eq!(charts.len(), 1);
        let extent = charts[0].extent_m;
        assert!((extent.element_product() - 3.0).abs() < 0.05, "{extent}");
    }

    #[test]
    fn a_box_has_six_charts() {
        let sides = [(DVec3::X, DVec3::Y), (DVec3::Y, DVec3::X), (DVec3::Y, DVec3::Z)];
        let sides =
            sides.into_iter().chain([(DVec3::Z, DVec3::Y), (DVec3::Z, DVec3::X), (DVec3::X, DVec3::Z)]);
        let triangles: Vec<_> = sides
            .flat_map(|(u, v)| grid(2, move |x, y| (u * (x - 0.5)) + v * (y - 0.5) + u.cross(v) * 0.5))
            .collect();
        let charts = cut(&triangles);
        check(&triangles, &charts);
        assert_eq!(charts.len(), 6);
    }

    #[test]
    fn a_sphere_needs_few_charts_and_a_spiral_ramp_does_not_fall_onto_itself() {
        use std::f64::consts::{PI, TAU};
        let sphere = grid(24, |x, y| {
            DVec3::new((PI * y).sin() * (TAU * x).cos(), (PI * y).cos(), (PI * y).sin() * (TAU * x).sin())
        });
        let round: Vec<_> =
            sphere.iter().filter(|[a, b, c]| (*b - *a).cross(*c - *a).length() > 1e-12).copied().collect();
        let charts = cut(&round);
        check(&round, &charts);
        assert!((6..40).contains(&charts.len()), "{}", charts.len());

        let ramp = grid(48, |x, y| {
            let angle = 3.0 * TAU * x;
            DVec3::new((1.0 + y) * angle.cos(), x * 2.0, (1.0 + y) * angle.sin())
        });
        let charts = cut(&ramp);
        check(&ramp, &charts);
        assert!((3..12).contains(&charts.len()), "{}", charts.len());
    }
}

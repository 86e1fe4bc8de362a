//! Smoothing edges that depth and normals of neighbours show.
//!
//! Koonce 2007 ("Deferred Shading in Tabula Rasa", GPU Gems 3), 19.5.2 and listing 19-3: along each of four lines through a pixel
//! the change of depth to one side is compared with that to the other, and so are the cosines of the angles to the normals there. A
//! ratio of changes does not depend on the resolution. What is below a share of the distance counts as rounding, where the listing
//! has a constant for its own depths.

use glam::DVec3;

use super::bloom::Light;

/// A change of depth is an edge's where it is so many times the one on the other side (the listing's 25).
pub const DEPTH_RATIO: f64 = 25.0;

/// Changes below this share of the distance are rounding.
pub const LEAST_CHANGE: f64 = 1e-5;

/// Between the cosines of the angles to the normals on either side (the listing's 0.4).
pub const NORMAL_CHANGE: f64 = 0.4;

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Distance along the view axis, metres; finite.
    pub distance_m: f64,
    /// What a step of the stored depth is here, metres; 0 for floats.
    pub step_m: f64,
    /// Unit length; zero where nothing is lit.
    pub normal: DVec3,
}

/// The way to the neighbours: the one opposite to the n-th of the first four is the n-th of the others.
const NEIGHBOURS: [[i64; 2]; 8] = [[-1, -1], [0, -1], [1, -1], [1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0]];

/// How much of an edge a pixel is on: the share of the four lines that cross one.
pub fn edge_weight(size: [usize; 2], places: &[Place], [x, y]: [usize; 2]) -> f64 {
    let at = |[dx, dy]: [i64; 2]| {
        let hold = |v: usize, d: i64, n: usize| (v as i64 + d).clamp(0, n as i64 - 1) as usize;
        &places[hold(y, dy, size[1]) * size[0] + hold(x, dx, size[0])]
    };
    let center = at([0, 0]);
    let change = |i: usize| (at(NEIGHBOURS[i]).distance_m - center.distance_m).abs();
    let cosine = |i: usize| at(NEIGHBOURS[i]).normal.dot(center.normal);
    let least = (LEAST_CHANGE * center.distance_m).max(center.step_m);
    let crosses = |i: &usize| {
        let (a, b) = (change(*i), change(*i + 4));
        a.max(b) >= a.min(b).max(least) * DEPTH_RATIO || (cosine(*i) - cosine(*i + 4)).abs() >= NORMAL_CHANGE
    };
    (0..4).filter(crosses).count() as f64 * 0.25
}

/// The picture (linear display light) with its edges smoothed: four samples between a pixel's centre and its corners.
pub fn edge_filter(picture: &Light, places: &[Place]) -> Light {
    let size = picture.size;
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
    let pixel = |at: [usize; 2]| {
        let reach = 0.5 * edge_weight(size, places, at);
        let [x, y] = at.map(|v| v as f64 + 0.5);
        let corners = [[-reach, -reach], [reach, -reach], [-reach, reach], [reach, reach]];
        corners.iter().map(|[dx, dy]| picture.sample(x + dx, y + dy)).sum::<DVec3>() / 4.0
    };
    Light { size, pixels: pixels.map(pixel).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor that recedes, on which a box stands from x = 8 on.
    fn places(scale: usize) -> ([usize; 2], Vec<Place>) {
        let size = [16 * scale, 16 * scale];
        let place = |x: usize, y: usize| match x < 8 * scale {
            // Distance to a plane goes with the inverse of the height on the image.
            true => {
                Place { distance_m: 40.0 / (1.0 + y as f64 / scale as f64), step_m: 0.0, normal: DVec3::Y }
            }
            false => Place { distance_m: 1.5, step_m: 0.0, normal: DVec3::Z },
        };
        (size, (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| place(x, y))).collect())
    }

    /// At any resolution the edge between the two is found, two pixels wide, and nothing else is one.
    #[test]
    fn edges_are_found_at_any_resolution() {
        for scale in [1, 2, 4, 8] {
            let (size, places) = places(scale);
            for y in 1..size[1] - 1 {
                for x in 1..size[0] - 1 {
                    let on_edge = x + 1 == size[0] / 2 || x == size[0] / 2;
                    let weight = edge_weight(size, &places, [x, y]);
                    assert!(
                        if on_edge { weight >= 0.5 } else { weight == 0.0 },
                        "{scale}, {x}, {y}: {weight}"
                    );
                }
            }
        }
    }

    #[test]
    fn what_is_even_stays() {
        let (size, places) = places(1);
        let even = Light { size, pixels: vec![DVec3::splat(0.7); size[0] * size[1]] };
        assert!(edge_filter(&even, &places).pixels.iter().all(|p| (p.x - 0.7).abs() < 1e-15));
    }
}

//! Which cells a light can reach.

use std::ops::Range;

use glam::{DMat3, DVec3, Vec3};

use super::grid::{Grid, Plane, Planes};
use crate::scene::Camera;
use crate::visible::Reach;

/// The camera's frame: x to the right, y down, z along the view axis.
pub(super) struct View {
    eye_world: DVec3,
    view_from_world: DMat3,
}

/// A light in the frame of the view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) index: u32,
    /// A ball around all that it reaches.
    center: Vec3,
    radius: f32,
    shape: Shape,
}

/// What of the ball it reaches.
#[derive(Clone, Copy, Debug)]
enum Shape {
    /// All.
    Ball,
    Cone {
        apex: Vec3,
        direction: Vec3,
        cos: f32,
        sin: f32,
        range: f32,
    },
    /// Around the ball's centre, from there to the middles of three faces.
    Box {
        half_axes: [Vec3; 3],
    },
}

/// What shaders may lose to rounding, as a share of the coordinates that they compute with, in the view and in the
/// world: lights are taken as so much larger.
const ROUNDING_VIEW: f32 = 1e-5;
const ROUNDING_WORLD: f32 = 1e-6;

impl View {
    pub(super) fn new(camera: &Camera) -> Self {
        let [x, y, z, eye] = camera.world_from_view.as_dmat4().to_cols_array_2d();
        let axis = |c: [f64; 4]| DVec3::new(c[0], c[1], c[2]);
        let view_from_world = DMat3::from_cols(axis(x), -axis(y), -axis(z)).transpose();
        Self { eye_world: axis(eye), view_from_world }
    }

    fn point(&self, world: Vec3) -> Vec3 {
        (self.view_from_world * (world.as_dvec3() - self.eye_world)).as_vec3()
    }

    fn direction(&self, world: Vec3) -> Vec3 {
        (self.view_from_world * world.as_dvec3()).as_vec3()
    }

    /// The light as seen from here; `None` if it ends behind the camera.
    pub(super) fn place(&self, reach: &Reach, index: u32) -> Option<Placed> {
        let (center, radius, shape) = match *reach {
            Reach::Everywhere => (Vec3::ZERO, f32::INFINITY, Shape::Ball),
            Reach::Sphere { center_world, radius_m } => (self.point(center_world), radius_m, Shape::Ball),
            Reach::Cone { apex_world, direction_world, cos, sin, range_m } => {
                let [apex, direction] = [self.point(apex_world), self.direction(direction_world)];
                // Around a narrow cone the ball through apex and rim, around a wide one that on the rim.
                let [along, radius] =
                    if cos > sin { [0.5 / cos, 0.5 / cos] } else { [cos, sin] }.map(|share| share * range_m);
                let center = if range_m.is_finite() { apex + direction * along } else { Vec3::ZERO };
                (center, radius, Shape::Cone { apex, direction, cos, sin, range: range_m })
            }
            Reach::Box { center_world, half_axes_world } => {
                let half_axes = half_axes_world.map(|axis| self.direction(axis));
                let radius = half_axes.iter().map(|axis| axis.length_squared()).sum::<f32>().sqrt();
                (self.point(center_world), radius, Shape::Box { half_axes })
            }
        };
        let mut placed = Placed { index, center, radius, shape };
        let world = self.eye_world.as_vec3().abs().max_element() + placed.center.abs().max_element();
        placed.radius += (placed.center.length() + placed.radius) * ROUNDING_VIEW + world * ROUNDING_WORLD;
        (placed.center.z + placed.radius > 0.0).then_some(placed)
    }
}

/// Between which distances along the view axis lights with an end are, metres.
pub(super) fn distances(lights: &[Placed]) -> [f32; 2] {
    let ended = lights.iter().filter(|l| l.radius.is_finite());
    ended.fold([f32::INFINITY, 0.0], |[nearest, farthest], l| {
        [nearest.min(l.center.z - l.radius), farthest.max(l.center.z + l.radius)]
    })
}

/// The parts between neighbours of `planes` that a ball may touch.
fn touched(planes: &[Plane], within: Range<usize>, across: f32, z: f32, radius: f32) -> Range<usize> {
    let Range { mut start, mut end } = within;
    while start < end && planes[start + 1].distance(across, z) > radius {
        start += 1;
    }
    while start < end && planes[end - 1].distance(across, z) < -radius {
        end -= 1;
    }
    start..end
}

impl Placed {
    /// Hands out the cells that the light may reach, as far as they are neighbours in a row.
    ///
    /// The ball is cut down plane by plane (Persson 2013, "Practical Clustered Shading"): what lies beyond a plane that
    /// does not hold the centre is within the ball around the circle in which the plane cuts it.
    pub(super) fn cells(&self, grid: &Grid, planes: &Planes, add: &mut impl FnMut(Range<u32>)) {
        let Self { center, radius, .. } = *self;
        let columns = touched(&planes.columns, 0..grid.columns as usize, center.x, center.z, radius);
        let rows = touched(&planes.rows, 0..grid.rows as usize, center.y, center.z, radius);
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        for slice in grid.slice(center.z - radius)..=grid.slice(center.z + radius) {
            let [near, far] = planes.slice(slice);
            let z = center.z.max(near).min(far);
            let Some(radius_slice) = cut(radius, z - center.z) else { continue };
            for row in touched(&planes.rows, rows.clone(), center.y, z, radius_slice) {
                let [above, below] = [planes.rows[row], planes.rows[row + 1]];
                let [from_above, from_below] = [above, below].map(|p| p.distance(center.y, z));
                let (z, beyond) = match () {
                    () if from_above < 0.0 => (above.z_of_nearest(z, from_above), from_above),
                    () if from_below > 0.0 => (below.z_of_nearest(z, from_below), from_below),
                    () => (z, 0.0),
                };
                let Some(radius_row) = cut(radius_slice, beyond) else { continue };
                let mut touched = touched(&planes.columns, columns.clone(), center.x, z, radius_row);
                let [near, far] = [near.max(center.z - radius), far.min(center.z + radius)];
                if !matches!(self.shape, Shape::Ball) && far.is_finite() {
                    let row = Edge::new(above, below, [near, far]);
                    self.trim(&mut touched, &planes.columns, &row, [near, far]);
                }
                if !touched.is_empty() {
                    let first = (slice * grid.rows + row as u32) * grid.columns;
                    add(first + touched.start as u32..first + touched.end as u32);
                }
            }
        }
    }

    /// Leaves out cells at both ends of a row that the light misses.
    fn trim(&self, columns: &mut Range<usize>, planes: &[Plane], row: &Edge, [near, far]: [f32; 2]) {
        let half = 0.5 * (far - near);
        let misses = |column: usize| {
            let edge = Edge::new(planes[column], planes[column + 1], [near, far]);
            let center = Vec3::new(edge.middle, row.middle, 0.5 * (near + far));
            self.misses(center, (edge.half_squared + row.half_squared + half * half).sqrt())
        };
        while columns.start < columns.end && misses(columns.start) {
            columns.start += 1;
        }
        while columns.start < columns.end && misses(columns.end - 1) {
            columns.end -= 1;
        }
    }

    /// Whether another ball is outside of what the light reaches, as far as its shape says.
    fn misses(&self, center: Vec3, radius: f32) -> bool {
        match self.shape {
            Shape::Ball => false,
            // Wronski 2017, "Cull that cone!".
            Shape::Cone { apex, direction, cos, sin, range } => {
                let to_center = center - apex;
                let along = to_center.dot(direction);
                let across = (to_center.length_squared() - along * along).max(0.0).sqrt();
                let slack = radius + to_center.length() * ROUNDING_VIEW;
                cos * across - sin * along > slack || along > slack + range || along < -slack
            }
            Shape::Box { half_axes } => {
                let to_center = center - self.center;
                let slack = radius + (to_center.length() + self.radius) * ROUNDING_VIEW;
                half_axes.iter().any(|axis| {
                    let half = axis.length();
                    to_center.dot(*axis).abs() > (half + slack) * half
                })
            }
        }
    }
}

/// The radius of what a plane leaves of a ball at this distance from its centre; `None` if nothing.
fn cut(radius: f32, distance: f32) -> Option<f32> {
    let squared = radius * radius - distance * distance;
    (squared > 0.0).then(|| squared.sqrt())
}

/// A cell's extent across, between two planes: of a ball around it the centre and what it adds to the radius.
struct Edge {
    middle: f32,
    half_squared: f32,
}

impl Edge {
    fn new(low: Plane, high: Plane, [near, far]: [f32; 2]) -> Self {
        let middle_z = 0.5 * (near + far);
        let middle = 0.5 * (low.at(middle_z) + high.at(middle_z));
        let ends = [low.at(near), low.at(far), high.at(near), high.at(far)];
        let half = ends.iter().fold(0.0_f32, |most, end| most.max((end - middle).abs()));
        Self { middle, half_squared: half * half }
    }
}

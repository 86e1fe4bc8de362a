//! Surfaces that send light of their own, and points drawn on them.

use glam::DVec3;

use super::Random;
use crate::reference::visibility::{Hit, Visibility};
use crate::scene::Material;

/// Triangles that send light, each drawn in proportion to area times radiance (textures counted as white), and within by
/// area.
pub struct Emitters {
    /// Index of the triangle, and the sum of weights up to and with it.
    triangles: Vec<(u32, f64)>,
    total: f64,
}

/// A point of a triangle.
pub struct Point {
    pub position_world: DVec3,
    /// As a ray from the front would meet it; its distance means nothing.
    pub hit: Hit,
}

impl Emitters {
    pub fn new(visibility: &Visibility) -> Self {
        let mut total = 0.0;
        let mut triangles = Vec::new();
        for (index, triangle) in (0..).zip(&visibility.triangles) {
            let radiance = radiance(visibility.material(index));
            if radiance > 0.0 {
                let [a, b, c] = triangle.corners_world;
                let weight = (b - a).cross(c - a).length() * 0.5 * radiance;
                if weight > 0.0 {
                    total += weight;
                    triangles.push((index, total));
                }
            }
        }
        Self { triangles, total }
    }

    /// Whether nothing sends light.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// A point; `None` if nothing sends light.
    pub fn draw(&self, visibility: &Visibility, random: &mut Random) -> Option<Point> {
        if self.triangles.is_empty() {
            return None;
        }
        let wanted = random.next() * self.total;
        let place = self.triangles.partition_point(|(_, sum)| *sum <= wanted);
        let (index, _) = self.triangles[place.min(self.triangles.len() - 1)];
        // Uniform in the triangle: Turk, "Generating Random Points in Triangles", Graphics Gems, 1990.
        let (s, t) = (random.next().sqrt(), random.next());
        let barycentric = [1.0 - s, s * (1.0 - t), s * t];
        let corners = visibility.triangles[index as usize].corners_world;
        let position_world = (0..3).map(|k| corners[k] * barycentric[k]).sum();
        let hit = Hit { distance: 0.0, triangle: index, barycentric, front_facing: true };
        Some(Point { position_world, hit })
    }

    /// How densely [`Self::draw`] fills the solid angle, per steradian, around a point seen along `direction` at this distance.
    /// 0 for sides that send nothing.
    pub fn density(&self, visibility: &Visibility, hit: &Hit, direction: DVec3, distance: f64) -> f64 {
        let material = visibility.material(hit.triangle);
        let cosine = -visibility.front_normal(hit).dot(direction);
        let cosine = if material.double_sided { cosine.abs() } else { cosine };
        if cosine <= 0.0 || self.total == 0.0 {
            return 0.0;
        }
        radiance(material) / self.total * distance * distance / cosine
    }
}

/// What decides how often a material's triangles are drawn, in cd/m².
fn radiance(material: &Material) -> f64 {
    let color = if material.unlit { material.base_color_factor.truncate() } else { material.emissive_factor };
    f64::from(color.max_element())
}

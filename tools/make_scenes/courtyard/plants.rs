//! Potted plants.

use super::super::glb::{Glb, Pose};
use super::super::mesh::{Mesh, Vertex};
use super::super::noise::{pick, smoothstep};
use super::super::shape::{circle, lathe};
use super::furnishing::points;
use super::palette::Palette;
use glam::{Vec2, Vec3};

/// Terracotta urns with bushes of leaf cards.
pub fn build(glb: &mut Glb, palette: &Palette) {
    let urn = lathe(
        &points(&[
            (0.24, 0.0),
            (0.25, 0.05),
            (0.22, 0.08),
            (0.26, 0.2),
            (0.33, 0.38),
            (0.36, 0.52),
            (0.34, 0.58),
            (0.39, 0.62),
            (0.4, 0.66),
            (0.36, 0.67),
            (0.32, 0.6),
            (0.0, 0.58),
        ]),
        32,
        2.0,
    );
    let bush = Mesh::merged((0..96).map(|i| {
        // A spiral of directions over most of the sphere.
        let height = 0.95 - 1.5 * (i as f32 + 0.5) / 96.0;
        let around = circle(i as f32 * 0.381_966);
        let out = Vec3::new(around.x, 0.0, around.y) * (1.0 - height * height).sqrt() + Vec3::Y * height;
        let size_m = 0.42 + 0.2 * pick(i, 141);
        let lift = (out + Vec3::Y * 0.5).normalize();
        let side = lift.cross(Vec3::Y).normalize();
        let (side, front) = (side * size_m * 0.5, lift.cross(side.normalize()));
        let stem = out * (0.16 + 0.16 * pick(i, 142)) + Vec3::Y * 1.05;
        Mesh::patch(1, 3, |u, v| {
            let droop = front * (0.15 * v * v * size_m);
            let position = stem + side * (2.0 * u - 1.0) + lift * (v * size_m) - droop;
            // Normals bend outward from the bush's middle, so that it shades as one soft mass.
            let normal = (out + lift * (v - 0.3)).normalize();
            Vertex { position, normal, texcoord: Vec2::new(u, 1.0 - v) }
        })
    }));
    let bush = bush.colored(|p, _| Vec3::splat(smoothstep(0.0, 0.62, (p - Vec3::Y * 1.05).length())));
    let (urn, bush) = (glb.geometry(&urn), glb.geometry(&bush));
    let plant = glb.mesh("potted plant", &[(&urn, palette.terracotta), (&bush, palette.leaves)]);
    let places = [(-2.35, -8.2, 1.0), (2.35, -8.2, 1.0), (4.5, 1.6, 0.9), (-4.5, 4.9, 0.9), (4.5, -4.8, 0.9)];
    for (i, (x_m, z_m, scale)) in places.into_iter().enumerate() {
        let pose = Pose::at(x_m, 0.0, z_m).turned(pick(i, 143)).scaled(scale, scale, scale);
        glb.place(&format!("potted plant {i}"), plant, pose);
    }
}

//! A canyon under the sun: the exterior of "Deferred versus forward shading" (4.8.1). Four large meshes, each with
//! colour, roughness and normal textures and colours per vertex; one directional light.

use super::glb::{Glb, Light, LightKind, Material, Pose};
use super::mesh::{Mesh, Vertex};
use super::noise::{cellular, fractal, smoothstep};
use super::texture::{Surface, Texel, linear, srgb};
use glam::{FloatExt, IVec2, Vec2, Vec3};

/// From one end to the other. The camera stands near +z.
const LENGTH_M: f32 = 420.0;
/// Quads of one of the four meshes: from the river to the rim, and along half of the canyon.
const QUADS: [usize; 2] = [112, 160];
/// The canyon's cross-section from the river outward: metres from the middle, metres above the river.
const PROFILE_M: [[f32; 2]; 10] = [
    [0.0, 0.0],
    [5.0, 0.0],
    [10.0, 1.2],
    [19.0, 8.0],
    [22.5, 27.0],
    [32.0, 31.5],
    [35.5, 55.0],
    [42.0, 58.0],
    [46.0, 71.0],
    [150.0, 76.0],
];
/// Extent of the sample of rock and of that of sand.
const TEXTURE_M: f32 = 14.0;

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    let rock = glb.textured("rock", &rock(), 1.0 / TEXTURE_M);
    for (name, side, half) in [
        ("west wall, near", -1.0, 0.0),
        ("east wall, near", 1.0, 0.0),
        ("west wall, far", -1.0, 1.0),
        ("east wall, far", 1.0, 1.0),
    ] {
        let material = glb.material(&Material { name, ..rock.clone() });
        let geometry = glb.geometry(&wall(side, half));
        let mesh = glb.mesh(name, &[(&geometry, material)]);
        glb.place(name, mesh, Pose::origin());
    }
    let kind = LightKind::Directional { illuminance_lx: 4.2 };
    let sun = Light { name: "sun", color: Vec3::new(1.0, 0.91, 0.77), kind };
    let sun = glb.light(sun, Pose::looking(Vec3::new(-0.62, 0.66, 0.52), Vec3::ZERO));
    // As there: a map that covers half a kilometre would be too coarse.
    glb.extras(sun, serde_json::json!({"shadow": false}));
    let above = |z_m: f32, height_m: f32| Vec3::new(middle_m(z_m), height_m, z_m);
    let view = |name, yfov_deg, from_m, target_m| (name, yfov_deg, Pose::looking(from_m, target_m));
    for (name, yfov_deg, pose) in [
        view("main", 55.0, Vec3::new(-20.0, 82.0, 190.0), above(10.0, 24.0)),
        view("river", 60.0, above(150.0, 9.0), above(78.0, 18.0)),
    ] {
        glb.perspective(name, yfov_deg, pose);
    }
    glb.finish("canyon")
}

/// Where the river is.
fn middle_m(z_m: f32) -> f32 {
    let bends = |length_m: f32, phase: f32| super::shape::circle(z_m / length_m + phase).y;
    26.0 * bends(260.0, 0.1) + 9.0 * bends(97.0, 0.4)
}

/// Half of a wall: `side` -1 is west (-x), `half` 1 is the far one.
fn wall(side: f32, half: f32) -> Mesh {
    // Seen from above, north (-z) up: u must run to the right for triangles to face upward.
    let mesh = Mesh::patch(QUADS[0], QUADS[1], |u, v| {
        let outward = if side > 0.0 { u } else { 1.0 - u };
        let along = (half + v) * 0.5;
        vertex(side, outward, along)
    });
    mesh.colored(tint).with_tangents()
}

fn vertex(side: f32, outward: f32, along: f32) -> Vertex {
    // Small against a quad, large against rounding.
    const STEP: f32 = 1e-3;
    let at = |outward: f32, along: f32| surface(side, outward, along).0;
    let (position, texcoord) = surface(side, outward, along);
    let across = at(outward + STEP, along) - at(outward - STEP, along);
    let ahead = at(outward, along + STEP) - at(outward, along - STEP);
    Vertex { position, normal: across.cross(ahead).normalize() * side, texcoord }
}

/// A point of the ground and its texture coordinate in metres, which follows the cross-section, so that cliffs are
/// not stretched. Both are defined a little beyond [0, 1].
fn surface(side: f32, outward: f32, along: f32) -> (Vec3, Vec2) {
    let z_m = (0.5 - along) * LENGTH_M;
    let (point, arc_m) = profile(outward);
    // Different on both sides, and not periodic within the canyon.
    let noise = |scale_m: f32, octaves: u32, seed: u32| {
        let uv = Vec2::new(arc_m * side, z_m) / (scale_m * 64.0) + 0.5;
        fractal(uv, IVec2::splat(64), octaves, seed)
    };
    let rim = smoothstep(40.0, 60.0, point.x);
    let wall = smoothstep(6.0, 20.0, point.x) * (1.0 - rim);
    // Gullies cut into the walls; the rim undulates.
    let gully = noise(34.0, 4, 5) * 11.0 + noise(9.0, 3, 6) * 3.0;
    let from_middle_m = point.x * (1.0 + 0.22 * noise(90.0, 1, 7) * wall) + gully * wall;
    let rough_m = noise(7.0, 4, 8) * (0.25 + 1.1 * wall) + noise(60.0, 4, 9) * (7.0 * rim + 3.0 * wall);
    let position = Vec3::new(middle_m(z_m) + side * from_middle_m, point.y + rough_m, z_m);
    (position, Vec2::new(arc_m * side, z_m))
}

/// The cross-section's point (metres from the middle, metres up), and the way to it along the section. The share of
/// vertices that a part gets is that of its length; the rim, seldom seen close, gets less.
fn profile(outward: f32) -> (Vec2, f32) {
    const RIM_SHARE: f32 = 0.16;
    let points = PROFILE_M.map(Vec2::from);
    let lengths_m: [f32; PROFILE_M.len() - 1] = std::array::from_fn(|i| points[i].distance(points[i + 1]));
    let wall_m: f32 = lengths_m[..lengths_m.len() - 1].iter().sum();
    let last_m = lengths_m[lengths_m.len() - 1];
    let wall_share = 1.0 - RIM_SHARE;
    if outward > wall_share {
        let t = (outward - wall_share) / RIM_SHARE;
        return (points[PROFILE_M.len() - 2].lerp(points[PROFILE_M.len() - 1], t), wall_m + t * last_m);
    }
    let mut left_m = outward / wall_share * wall_m;
    let arc_m = left_m;
    let mut part = 0;
    while part + 2 < lengths_m.len() && left_m > lengths_m[part] {
        left_m -= lengths_m[part];
        part += 1;
    }
    (points[part].lerp(points[part + 1], left_m / lengths_m[part]), arc_m)
}

/// Layers of red, ochre and cream in the walls, sand on what is level below, scrub above.
fn tint(position: Vec3, normal: Vec3) -> Vec3 {
    let uv = Vec2::new(position.x, position.z) / LENGTH_M + 0.5;
    let height_m = position.y + 2.5 * fractal(uv, IVec2::splat(9), 3, 21);
    let band = fractal(Vec2::new(height_m / 96.0 + 0.2, 0.5), IVec2::new(22, 1), 3, 22);
    let layers = linear(0xb4532f).lerp(linear(0xe3b27c), smoothstep(-0.35, 0.45, band));
    let layers = layers.lerp(linear(0x8a3a2a), smoothstep(0.25, 0.5, -band));
    let level = smoothstep(0.62, 0.9, normal.y);
    let river = smoothstep(1.6, 0.4, position.y);
    let sand = linear(0xd8b088).lerp(linear(0x8e8f86), river);
    let scrub =
        linear(0xa98a5a).lerp(linear(0x6f7a48), smoothstep(-0.1, 0.4, fractal(uv, IVec2::splat(40), 3, 23)));
    layers.lerp(sand.lerp(scrub, smoothstep(40.0, 62.0, position.y)), level)
}

/// Layered rock with cracks across; nearly grey, for the vertices bring the colour.
fn rock() -> Surface {
    Surface::sample(512, TEXTURE_M, |uv| {
        let warp = Vec2::new(fractal(uv, IVec2::splat(5), 4, 31), fractal(uv, IVec2::splat(5), 4, 32)) * 0.06;
        // Blocks and layers lie along v, the river's direction.
        let block = cellular((uv + warp).fract_gl(), IVec2::new(14, 6), 33);
        let open = smoothstep(-0.1, 0.3, fractal(uv, IVec2::splat(4), 2, 36));
        let crack = 1.0 - open * (1.0 - smoothstep(0.0, 0.07, block.second - block.nearest));
        let layer = fractal(Vec2::new(uv.x + warp.x * 0.5, uv.y).fract_gl(), IVec2::new(26, 2), 4, 34);
        let grain = fractal(uv, IVec2::splat(34), 4, 35);
        let tone = 0.84 + 0.2 * layer + 0.16 * grain;
        Texel {
            albedo: srgb(0xc2b6a8).lerp(srgb(0xf2ece4), crack) * tone,
            height_m: 0.1 * crack + 0.42 * layer + 0.16 * grain,
            roughness: 0.94.lerp(0.7 - 0.2 * grain, crack * smoothstep(-0.2, 0.5, layer)),
            metallic: 0.0,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_four_meshes_meet_without_gaps_and_face_outward() {
        for half in [0.0, 1.0] {
            let [west, east] = [-1.0, 1.0].map(|side| wall(side, half));
            for row in 0..=QUADS[1] {
                let first = row * (QUADS[0] + 1);
                // The river: the last column in the west and the first in the east.
                assert_eq!(west.positions[first + QUADS[0]], east.positions[first]);
            }
            for mesh in [&west, &east] {
                let agrees = |corners: &&[u32]| {
                    let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[corners[k] as usize]);
                    let mean: Vec3 = corners.iter().map(|&i| mesh.normals[i as usize]).sum();
                    (b - a).cross(c - a).dot(mean) > 0.0
                };
                let triangles = mesh.indices.chunks_exact(3);
                // All but some at folds that are narrower than a triangle.
                let (count, agreeing) = (triangles.len(), triangles.filter(agrees).count());
                assert!(agreeing * 100 > count * 99, "{agreeing} of {count}");
            }
        }
        for side in [-1.0, 1.0] {
            let (near, far) = (wall(side, 0.0), wall(side, 1.0));
            let row = QUADS[0] + 1;
            assert_eq!(near.positions[QUADS[1] * row..], far.positions[..row]);
        }
    }
}

//! Shapes with exact normals: boxes, spheres, surfaces of revolution, tubes.

use super::mesh::{Mesh, Vertex};
use glam::{Quat, Vec2, Vec3};
use std::ops::Range;

/// The point of the unit circle after this many turns (evaluated in f64, so that quarters are exact to f32).
pub fn circle(turns: f32) -> Vec2 {
    let (sin, cos) = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
    Vec2::new(cos as f32, sin as f32)
}

/// A box around the origin whose edges are cut off at 45 degrees, `bevel_m` from the edge.
pub fn cuboid(size_m: Vec3, bevel_m: f32) -> Mesh {
    let mut mesh = Mesh::default();
    let half = size_m * 0.5;
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    // The point on face `axis` next to the corner with these signs.
    let point = |axis: usize, signs: Vec3| {
        let inset = Vec3::splat(bevel_m) - axes[axis] * bevel_m;
        signs * (half - inset)
    };
    let signs = [-1.0_f32, 1.0];
    for axis in 0..3 {
        let (b, c) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
        for s in signs {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(i, j)| point(axis, axes[axis] * s + b * i + c * j));
            mesh.polygon(&corners, axes[axis] * s);
            if bevel_m == 0.0 {
                continue;
            }
            // The four edges along `b`, between faces `axis` and `c`, are met once for each axis.
            for t in signs {
                let end = |along: f32| axes[axis] * s + c * t + b * along;
                let edge = [
                    point(axis, end(-1.0)),
                    point(axis, end(1.0)),
                    point((axis + 2) % 3, end(1.0)),
                    point((axis + 2) % 3, end(-1.0)),
                ];
                mesh.polygon(&edge, (axes[axis] * s + c * t).normalize());
            }
        }
    }
    if bevel_m > 0.0 {
        for corner in 0..8 {
            let signs = Vec3::new(signs[corner & 1], signs[corner >> 1 & 1], signs[corner >> 2]);
            mesh.polygon(&[0, 1, 2].map(|axis| point(axis, signs)), signs.normalize());
        }
    }
    mesh
}

/// A sphere around the origin. Texture coordinates run once around and once from pole to pole, in metres.
pub fn sphere(radius_m: f32, segments: usize, rings: usize) -> Mesh {
    let circumference_m = radius_m * std::f32::consts::TAU;
    Mesh::patch(segments, rings, |u, v| {
        let (around, up) = (circle(u), circle((v - 0.5) * 0.5));
        let normal = Vec3::new(up.x * around.x, up.y, -up.x * around.y);
        let texcoord = Vec2::new(u, (1.0 - v) * 0.5) * circumference_m;
        Vertex { position: normal * radius_m, normal, texcoord }
    })
}

/// A full surface of revolution around +Y; see [`lathe_arc`].
pub fn lathe(profile: &[Vec2], segments: usize, around_m: f32) -> Mesh {
    lathe_arc(profile, segments, 0.0..1.0, around_m)
}

/// Turns `profile` (radius, height; metres; upward on the outside, so counter-clockwise if closed) around +Y.
///
/// Corners of more than 35 degrees stay sharp. `around_m` is the extent of u: a multiple of the texture's size
/// leaves no seam.
pub fn lathe_arc(profile: &[Vec2], segments: usize, turns: Range<f32>, around_m: f32) -> Mesh {
    const CREASE_COS: f32 = 0.82;
    let directions: Vec<Vec2> = profile.windows(2).map(|w| (w[1] - w[0]).normalize()).collect();
    let closed = profile[0].distance(profile[profile.len() - 1]) < 1e-5;
    let count = directions.len();
    let blended = |segment: usize, neighbour: Option<usize>| match neighbour {
        Some(n) if directions[segment].dot(directions[n]) > CREASE_COS => {
            (directions[segment] + directions[n]).normalize()
        }
        _ => directions[segment],
    };
    let mut mesh = Mesh::default();
    let mut length_m = 0.0;
    for segment in 0..count {
        let before = if segment > 0 { Some(segment - 1) } else { closed.then_some(count - 1) };
        let after = if segment + 1 < count { Some(segment + 1) } else { closed.then_some(0) };
        let (low, high) = (profile[segment], profile[segment + 1]);
        let ends = [(low, blended(segment, before)), (high, blended(segment, after))];
        let strip_m = low.distance(high);
        let strip = Mesh::patch(segments, 1, |u, v| {
            let (point, direction) = ends[v as usize];
            let around = circle(turns.start + (turns.end - turns.start) * u);
            let outward = Vec3::new(around.x, 0.0, -around.y);
            Vertex {
                position: outward * point.x + Vec3::Y * point.y,
                normal: (outward * direction.y - Vec3::Y * direction.x).normalize(),
                texcoord: Vec2::new(u * around_m, -(length_m + v * strip_m)),
            }
        });
        mesh = Mesh::merged([mesh, strip]);
        length_m += strip_m;
    }
    mesh.welded()
}

/// A profile for [`lathe`]: the circle that makes a torus.
pub fn round_profile(center: Vec2, radius_m: f32, sides: usize) -> Vec<Vec2> {
    (0..=sides).map(|i| center + circle(i as f32 / sides as f32) * radius_m).collect()
}

/// A profile for [`lathe`]: the rectangle that makes a flat ring.
pub fn ring_profile(radii_m: Range<f32>, heights_m: Range<f32>) -> [Vec2; 5] {
    let (inner, outer, low, high) = (radii_m.start, radii_m.end, heights_m.start, heights_m.end);
    [(inner, low), (outer, low), (outer, high), (inner, high), (inner, low)].map(Vec2::from)
}

/// A round tube along a path, open at its ends.
pub fn tube(path: &[Vec3], radius_m: f32, sides: usize) -> Mesh {
    let direction = |i: usize| {
        let before = path[i.saturating_sub(1)];
        (path[(i + 1).min(path.len() - 1)] - before).normalize()
    };
    // Carries one frame along the path by the least rotation, so that it does not twist.
    let mut side = direction(0).any_orthonormal_vector();
    let mut length_m = 0.0;
    let mut frames = Vec::new();
    for i in 0..path.len() {
        if i > 0 {
            side = Quat::from_rotation_arc(direction(i - 1), direction(i)) * side;
            length_m += path[i].distance(path[i - 1]);
        }
        frames.push((path[i], side, direction(i).cross(side), length_m));
    }
    let mesh_around_m = radius_m * std::f32::consts::TAU;
    Mesh::patch(sides, path.len() - 1, |u, v| {
        let (center, side, other, length_m) = frames[(v * (path.len() - 1) as f32).round() as usize];
        let around = circle(u);
        let normal = side * around.x + other * around.y;
        Vertex {
            position: center + normal * radius_m,
            normal,
            texcoord: Vec2::new(u * mesh_around_m, -length_m),
        }
    })
}

/// A straight moulding along +X from `-length_m / 2`: flat strips between the (z, y) points of `profile`, given
/// counter-clockwise as seen from +X. Open at its ends.
pub fn moulding(profile: &[Vec2], length_m: f32) -> Mesh {
    let mut mesh = Mesh::default();
    let half = length_m * 0.5;
    for edge in profile.windows(2) {
        let direction = edge[1] - edge[0];
        let corners = [(-half, 0), (half, 0), (half, 1), (-half, 1)]
            .map(|(x, end): (f32, usize)| Vec3::new(x, edge[end].y, edge[end].x));
        mesh.polygon(&corners, Vec3::new(0.0, -direction.x, direction.y).normalize());
    }
    mesh
}

/// A wall with a round-arched opening that springs from y = 0: centred on x = 0, `width_m` wide, `top_m` high,
/// its thickness centred on z = 0.
pub fn arch_wall(width_m: f32, top_m: f32, radius_m: f32, thickness_m: f32, segments: usize) -> Mesh {
    let (half, z) = (width_m * 0.5, thickness_m * 0.5);
    let corner = top_m.atan2(half) / std::f32::consts::TAU;
    let mut turns: Vec<f32> = (0..=segments).map(|i| 0.5 * i as f32 / segments as f32).collect();
    turns.extend([corner, 0.5 - corner]);
    turns.sort_by(f32::total_cmp);
    let inner = |t: f32| (circle(t) * radius_m).extend(0.0);
    let outer = |t: f32| {
        let d = circle(t);
        (d * (half / d.x.abs().max(1e-6)).min(top_m / d.y.max(1e-6))).extend(0.0)
    };
    let mut mesh = Mesh::default();
    for pair in turns.windows(2) {
        let face = [inner(pair[0]), outer(pair[0]), outer(pair[1]), inner(pair[1])];
        mesh.polygon(&face.map(|p| p + Vec3::Z * z), Vec3::Z);
        mesh.polygon(&face.map(|p| p - Vec3::Z * z), Vec3::NEG_Z);
    }
    let level = |from_x: f32, to_x: f32, y: f32| {
        [(from_x, -z), (to_x, -z), (to_x, z), (from_x, z)].map(|(x, z)| Vec3::new(x, y, z))
    };
    for side in [-1.0_f32, 1.0] {
        mesh.polygon(&level(side * radius_m, side * half, 0.0), Vec3::NEG_Y);
        let end = [(0.0, -z), (0.0, z), (top_m, z), (top_m, -z)].map(|(y, z)| Vec3::new(side * half, y, z));
        mesh.polygon(&end, Vec3::X * side);
    }
    mesh.polygon(&level(-half, half, top_m), Vec3::Y);
    let soffit = Mesh::patch(segments, 1, |u, v| {
        let around = circle(0.5 * u);
        Vertex {
            position: (around * radius_m).extend(z - v * thickness_m),
            normal: -around.extend(0.0),
            texcoord: Vec2::new(u * radius_m * std::f32::consts::PI, v * thickness_m),
        }
    });
    Mesh::merged([mesh, flipped_if_inward(soffit)])
}

/// Turns the triangles round where they face away from their normals.
pub fn flipped_if_inward(mut mesh: Mesh) -> Mesh {
    for corners in mesh.indices.chunks_exact_mut(3) {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[corners[k] as usize]);
        if (b - a).cross(c - a).dot(mesh.normals[corners[0] as usize]) < 0.0 {
            corners.swap(1, 2);
        }
    }
    mesh
}

/// A moulded half ring around an arch that springs from y = 0, in front of the plane z = 0.
///
/// `profile` is (radius, z), counter-clockwise: from the outside over the front to the inside.
pub fn archivolt(profile: &[Vec2], segments: usize) -> Mesh {
    let arc = std::f32::consts::PI * profile[0].x;
    // The lathe turns around +Y; a quarter turn about +X makes that +Z.
    let upright = glam::Affine3A::from_quat(Quat::from_xyzw(
        std::f32::consts::FRAC_1_SQRT_2,
        0.0,
        0.0,
        std::f32::consts::FRAC_1_SQRT_2,
    ));
    lathe_arc(profile, segments, 0.0..0.5, arc).transformed(upright)
}

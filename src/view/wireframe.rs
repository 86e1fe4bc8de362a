//! Wireframes of volumes of the world, cut down to what a view shows.

use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::scene::{Camera, Projection};
use crate::visible::Reach;

/// Where a view looks from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Eye {
    /// World space, metres.
    At(Vec3),
    /// From infinitely far away, along this, unit length.
    Along(Vec3),
}

impl Eye {
    pub(super) fn of(camera: &Camera) -> Self {
        let [.., back, place] = [0, 2, 3].map(|i| camera.world_from_view.col(i).truncate());
        match camera.projection {
            Projection::Perspective { .. } => Self::At(place),
            Projection::Orthographic { .. } => Self::Along(-back.normalize()),
        }
    }
}

/// A straight line of the world, homogeneous: ends with w = 0 are infinitely far away. Its number says which of its line's it is.
pub(super) type Chord = ([Vec4; 2], usize);

/// Circles have so many chords, straight edges an eighth of them.
pub(super) fn chords_of(lights: usize) -> usize {
    match lights {
        0..=64 => 128,
        65..=256 => 64,
        _ => 16,
    }
}

/// Hands out the outline of a volume: its edges, and what of it an eye sees as its border; nothing of what has no end at all.
pub(super) fn outline(reach: &Reach, eye: Eye, chords: usize, add: &mut impl FnMut(Chord)) {
    match *reach {
        Reach::Everywhere => {}
        Reach::Sphere { center_world, radius_m } => {
            for [u, v] in [[Vec3::X, Vec3::Y], [Vec3::Y, Vec3::Z], [Vec3::Z, Vec3::X]] {
                circle(center_world, u * radius_m, v * radius_m, chords, add);
            }
            if let Some((center, axis, radius_m)) = silhouette(center_world, radius_m, eye) {
                let (u, v) = axis.any_orthonormal_pair();
                circle(center, u * radius_m, v * radius_m, chords, add);
            }
        }
        Reach::Cone { apex_world, direction_world, cos, sin, range_m } => {
            let (u, v) = direction_world.any_orthonormal_pair();
            let is_endless = range_m.is_infinite();
            // Of a cone without an end the rim is a circle of directions.
            let place = |way: Vec3| {
                if is_endless { way.extend(0.0) } else { (apex_world + way * range_m).extend(1.0) }
            };
            let round = |from: f32, turn: f32| u * (from * turn.cos()) + v * (from * turn.sin());
            let rim = |turn: f32| place(direction_world * cos + round(sin, turn));
            arc(0.0, std::f32::consts::TAU, chords, add, rim);
            for rib in 0..8 {
                line(apex_world.extend(1.0), rim(std::f32::consts::TAU * rib as f32 / 8.0), chords / 8, add);
            }
            let half = sin.atan2(cos);
            for across in [u, v].into_iter().filter(|_| !is_endless) {
                arc(-half, half, chords / 2, add, |a| place(direction_world * a.cos() + across * a.sin()));
            }
        }
        Reach::Box { center_world, half_axes_world: [x, y, z] } => {
            let corner = |[a, b, c]: [f32; 3]| (center_world + x * a + y * b + z * c).extend(1.0);
            cube(corner, chords, add);
        }
    }
}

/// The edges of what a projection shows.
pub(super) fn frustum(clip_from_world: &Mat4, chords: usize, add: &mut impl FnMut(Chord)) {
    let world_from_clip = clip_from_world.inverse();
    cube(|[x, y, z]| world_from_clip * Vec4::new(x, y, z * 0.5 + 0.5, 1.0), chords, add);
}

/// The circle in which a cone from the eye touches a ball: centre, axis and radius. `None` from within.
fn silhouette(center: Vec3, radius_m: f32, eye: Eye) -> Option<(Vec3, Vec3, f32)> {
    match eye {
        Eye::Along(forward) => Some((center, forward, radius_m)),
        Eye::At(place) => {
            let to_eye = place - center;
            let distance = to_eye.length();
            let share = radius_m / distance;
            let axis = to_eye / distance;
            (share < 1.0)
                .then(|| (center + axis * (radius_m * share), axis, radius_m * (1.0 - share * share).sqrt()))
        }
    }
}

fn circle(center: Vec3, u: Vec3, v: Vec3, chords: usize, add: &mut impl FnMut(Chord)) {
    arc(0.0, std::f32::consts::TAU, chords, add, |a| (center + u * a.cos() + v * a.sin()).extend(1.0));
}

fn arc(from: f32, to: f32, chords: usize, add: &mut impl FnMut(Chord), at: impl Fn(f32) -> Vec4) {
    let at = |n: usize| at(from + (to - from) * n as f32 / chords as f32);
    (0..chords).for_each(|n| add(([at(n), at(n + 1)], n)));
}

fn line(from: Vec4, to: Vec4, chords: usize, add: &mut impl FnMut(Chord)) {
    let at = |n: usize| from.lerp(to, n as f32 / chords as f32);
    (0..chords).for_each(|n| add(([at(n), at(n + 1)], n)));
}

/// The edges of a cube whose corners are at -1 and 1.
fn cube(corner: impl Fn([f32; 3]) -> Vec4, chords: usize, add: &mut impl FnMut(Chord)) {
    for axis in 0..3 {
        for side in 0..4 {
            let mut ends = [[0.0; 3]; 2];
            for (end, along) in ends.iter_mut().zip([-1.0, 1.0]) {
                end[axis] = along;
                end[(axis + 1) % 3] = if side & 1 == 0 { -1.0 } else { 1.0 };
                end[(axis + 2) % 3] = if side & 2 == 0 { -1.0 } else { 1.0 };
            }
            line(corner(ends[0]), corner(ends[1]), chords / 8, add);
        }
    }
}

/// What a view shows of a line: both ends in the images, -1 to 1 to the right and down. `None` if it shows nothing of it.
///
/// Liang and Barsky 1984, "A New Concept and Method for Line Clipping", in homogeneous coordinates: the near plane cuts before
/// anything is divided.
pub(super) fn shown(clip_from_world: &Mat4, ends: [Vec4; 2]) -> Option<[Vec2; 2]> {
    let [from, to] = ends.map(|end| *clip_from_world * end);
    let inside = |p: Vec4| [p.w - p.z, p.z, p.w + p.x, p.w - p.x, p.w + p.y, p.w - p.y];
    let (mut begin, mut end) = (0.0_f32, 1.0_f32);
    for (a, b) in inside(from).into_iter().zip(inside(to)) {
        match (a < 0.0, b < 0.0) {
            (true, true) => return None,
            (true, false) => begin = begin.max(a / (a - b)),
            (false, true) => end = end.min(a / (a - b)),
            (false, false) => {}
        }
    }
    let at = |t: f32| from + (to - from) * t;
    let ends = [at(begin), at(end)];
    let is_seen = begin <= end && ends.iter().all(|p| p.w > 0.0);
    is_seen.then(|| ends.map(|p| Vec2::new(p.x, p.y) / p.w)).filter(|ends| ends.iter().all(|p| p.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    const REACH: f32 = 1.5;

    fn chords(reach: &Reach, eye: Eye) -> Vec<Chord> {
        let mut all = Vec::new();
        outline(reach, eye, 64, &mut |chord| all.push(chord));
        all
    }

    fn place(p: Vec4) -> Vec3 {
        p.truncate() / p.w
    }

    #[test]
    fn silhouettes_are_where_lines_from_the_eye_touch() {
        let center_world = vec3(1.0, 2.0, -3.0);
        let sphere = Reach::Sphere { center_world, radius_m: REACH };
        let eye = vec3(2.0, 3.0, 4.0);
        let all = chords(&sphere, Eye::At(eye));
        assert_eq!(all.len(), 4 * 64);
        for ([from, to], _) in &all {
            for p in [from, to] {
                assert!((place(*p).distance(center_world) - REACH).abs() < 1e-5, "{p}");
            }
        }
        for ([p, _], _) in &all[3 * 64..] {
            let p = place(*p);
            assert!((p - center_world).normalize().dot((p - eye).normalize()).abs() < 1e-5, "{p}");
        }
        let inside = chords(&sphere, Eye::At(center_world + Vec3::X));
        assert_eq!(inside.len(), 3 * 64, "from within there is none");
        let along = vec3(0.0, 0.6, -0.8);
        for ([p, _], _) in &chords(&sphere, Eye::Along(along))[3 * 64..] {
            assert!((place(*p) - center_world).dot(along).abs() < 1e-5, "{p}");
        }
    }

    #[test]
    fn cones_and_boxes_are_outlined_where_they_end() {
        let (apex, axis, half) = (vec3(0.0, 3.0, 1.0), vec3(0.6, -0.8, 0.0), 0.4_f32);
        let cone = |range_m| Reach::Cone {
            apex_world: apex,
            direction_world: axis,
            cos: half.cos(),
            sin: half.sin(),
            range_m,
        };
        let mut rims = 0;
        for ([from, to], _) in chords(&cone(2.0), Eye::At(Vec3::ZERO)) {
            for p in [from, to].map(place).into_iter().filter(|p| *p != apex) {
                let (distance, angle) = (p.distance(apex), (p - apex).angle_between(axis));
                let (on_cap, on_side) = ((distance - 2.0).abs() < 1e-4, (angle - half).abs() < 1e-3);
                assert!(on_cap && angle < half + 1e-3 || on_side && distance < 2.0 + 1e-4, "{p}");
                rims += usize::from(on_cap && on_side);
            }
        }
        assert!(rims >= 2 * 64);
        let endless = chords(&cone(f32::INFINITY), Eye::At(Vec3::ZERO));
        assert_eq!(endless.len(), 64 + 8 * 8, "its rim and its ribs");
        assert!(
            endless[..64]
                .iter()
                .all(|([p, _], _)| p.w == 0.0 && p.truncate().angle_between(axis) - half < 1e-3)
        );
        let half_axes_world = [vec3(0.0, 2.0, 0.0), vec3(0.0, 0.0, -1.0), vec3(3.0, 0.0, 0.0)];
        let edges = chords(&Reach::Box { center_world: apex, half_axes_world }, Eye::Along(Vec3::Z));
        assert_eq!(edges.len(), 12 * 8);
        for ([p, _], _) in edges {
            let at = half_axes_world.map(|axis| (place(p) - apex).dot(axis) / axis.length_squared());
            assert!(at.iter().all(|c| c.abs() < 1.0 + 1e-5), "{at:?}");
            assert!(at.iter().filter(|c| c.abs() > 1.0 - 1e-5).count() >= 2, "{at:?}");
        }
        assert!(chords(&Reach::Everywhere, Eye::At(Vec3::ZERO)).is_empty());
    }

    fn clip_from_world() -> Mat4 {
        Projection::Perspective { yfov_rad: 1.0, znear_m: 0.5, zfar_m: Some(20.0) }.clip_from_view(2.0)
    }

    #[test]
    fn lines_are_cut_at_the_near_plane_and_at_the_images_edges() {
        let clip = clip_from_world();
        let at = |x: f32, y: f32, z: f32| vec3(x, y, z).extend(1.0);
        let on_image = |p: Vec4| {
            let p = clip * p;
            Vec2::new(p.x, p.y) / p.w
        };
        let close = |a: [Vec2; 2], b: [Vec2; 2]| {
            assert!(a.iter().zip(b).all(|(a, b)| a.distance(b) < 1e-5), "{a:?} is not {b:?}");
        };
        // From behind the eye to what is seen: cut where it is half a metre away.
        let cut = shown(&clip, [at(0.0, 0.1, 1.0), at(0.0, 0.1, -2.0)]).unwrap();
        close(cut, [on_image(at(0.0, 0.1, -0.5)), on_image(at(0.0, 0.1, -2.0))]);
        let cut = shown(&clip, [at(0.3, 0.0, -3.0), at(0.3, 0.0, -30.0)]).unwrap();
        close(cut, [on_image(at(0.3, 0.0, -3.0)), on_image(at(0.3, 0.0, -20.0))]);
        let across = shown(&clip, [at(-50.0, 0.0, -2.0), at(50.0, 0.0, -2.0)]).unwrap();
        close(across, [Vec2::NEG_X, Vec2::X]);
        for hidden in [
            [at(0.0, 0.0, 1.0), at(0.0, 0.0, 2.0)],
            [at(0.0, 0.0, -0.1), at(0.1, 0.1, -0.4)],
            [at(9.0, 0.0, -2.0), at(9.0, 1.0, -2.0)],
            [at(0.0, 0.0, -21.0), at(0.0, 0.0, -40.0)],
            [at(9.0, 0.0, 5.0), vec3(1.0, 0.0, 0.0).extend(0.0)],
        ] {
            assert_eq!(shown(&clip, hidden), None, "{hidden:?}");
        }
        // An end at infinity is beyond the far plane, and where there is none, a point that parallels meet in.
        let endless =
            Projection::Perspective { yfov_rad: 1.0, znear_m: 0.5, zfar_m: None }.clip_from_view(2.0);
        let far = vec3(0.1, 0.0, -1.0).extend(0.0);
        let [_, end] = shown(&endless, [at(0.5, 0.5, -2.0), far]).unwrap();
        let [_, other] = shown(&endless, [at(-0.5, 0.0, -2.0), far]).unwrap();
        assert!(end.distance(other) < 1e-5, "{end} {other}");
    }

    #[test]
    fn what_a_projection_shows_has_its_corners_at_the_clips() {
        let clip = clip_from_world();
        let mut count = 0;
        frustum(&clip, 64, &mut |([from, _], n)| {
            let p = clip * from;
            let p = p.truncate() / p.w;
            let edges = [p.x.abs() - 1.0, p.y.abs() - 1.0, p.z.min(1.0 - p.z)];
            assert!(edges.iter().filter(|e| e.abs() < 1e-3).count() >= if n == 0 { 3 } else { 2 }, "{p}");
            count += 1;
        });
        assert_eq!(count, 12 * 8);
    }
}

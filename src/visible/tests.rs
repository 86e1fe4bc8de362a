//! What is called missed has no point inside, by points in f64; what is plainly outside is called missed.

use glam::{DVec3, Mat4, Quat, Vec3, camera::rh::view::look_to_mat4};
use proptest::prelude::*;

use super::{Frustum, Reach};
use crate::scene::{Aabb, Light, LightKind, Projection};

const POINTS_A_SIDE: i32 = 8;

fn projection() -> impl Strategy<Value = Projection> {
    prop_oneof![
        (0.1_f32..3.0, 0.01_f32..1.0, prop::option::of(5.0_f32..1e4)).prop_map(
            |(yfov_rad, znear_m, zfar_m)| { Projection::Perspective { yfov_rad, znear_m, zfar_m } }
        ),
        (0.1_f32..50.0, 0.0_f32..1.0, 5.0_f32..1e3).prop_map(|(ymag_m, znear_m, zfar_m)| {
            Projection::Orthographic { xmag_m: ymag_m, ymag_m, znear_m, zfar_m }
        }),
    ]
}

fn unit() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-1.0_f32..1.0)
        .prop_map(Vec3::from_array)
        .prop_filter_map("no direction", |v| (v.length() > 0.01).then(|| v.normalize()))
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from_array)
}

/// A view from somewhere, near the world's origin or far from it.
fn clip_from_world() -> impl Strategy<Value = (Mat4, Vec3)> {
    (projection(), unit(), 0.3_f32..3.0, vector(1.0), prop::sample::select(vec![1.0_f32, 100.0, 1e5]))
        .prop_map(|(projection, forward, aspect, at, far)| {
            let eye = at * far;
            let view_from_world = look_to_mat4(eye, forward, forward.any_orthonormal_vector());
            (projection.clip_from_view(aspect) * view_from_world, eye)
        })
}

fn sees(clip_from_world: &Mat4, point_world: DVec3) -> bool {
    let clip = clip_from_world.as_dmat4() * point_world.extend(1.0);
    clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && 0.0 <= clip.z && clip.z <= clip.w
}

/// Points all over the unit cube, corners included.
fn cube() -> impl Iterator<Item = DVec3> {
    let side = || (0..=POINTS_A_SIDE).map(|i| f64::from(i) / f64::from(POINTS_A_SIDE));
    side().flat_map(move |x| side().flat_map(move |y| side().map(move |z| DVec3::new(x, y, z))))
}

/// Points all over the unit ball.
fn ball() -> impl Iterator<Item = DVec3> {
    cube()
        .map(|p| p * 2.0 - 1.0)
        .map(|p| if p == DVec3::ZERO { p } else { p / p.length() * p.abs().max_element() })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn missed_boxes_have_no_point_inside(
        (clip_from_world, eye) in clip_from_world(), at in vector(20.0), size in vector(10.0)
    ) {
        let bounds = Aabb { min: eye + at, max: eye + at + size.abs() };
        if Frustum::new(&clip_from_world).misses_aabb(&bounds) {
            let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
            prop_assert!(!cube().any(|p| sees(&clip_from_world, min + (max - min) * p)));
        }
    }

    #[test]
    fn missed_spheres_have_no_point_inside(
        (clip_from_world, eye) in clip_from_world(), at in vector(20.0), radius in 0.0_f32..10.0
    ) {
        let center = eye + at;
        if Frustum::new(&clip_from_world).misses_sphere(center, radius) {
            let inside = |p: DVec3| sees(&clip_from_world, center.as_dvec3() + p * f64::from(radius));
            prop_assert!(!ball().any(inside));
        }
    }

    #[test]
    fn missed_spots_light_no_point_inside(
        (clip_from_world, eye) in clip_from_world(), at in vector(20.0), direction_world in unit(),
        outer_cone_rad in 0.01_f32..std::f32::consts::FRAC_PI_2, range_m in prop::option::of(0.1_f32..20.0)
    ) {
        let position_world = eye + at;
        let kind = LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.0, outer_cone_rad };
        let light = Light { position_world, range_m, ..Light::new(kind) }.towards(direction_world);
        let reach = Reach::of(&light);
        if Frustum::new(&clip_from_world).misses(&reach) {
            let range = f64::from(range_m.unwrap_or(1e3));
            // Of the ball's points those that the shader's falloff leaves light: the cosine is that of the cone at least.
            let rotation = Quat::from_rotation_arc(Vec3::Z, direction_world).as_dquat();
            let lit = |p: &DVec3| p.z >= f64::from(outer_cone_rad).cos() * p.length();
            let inside = |p: DVec3| sees(&clip_from_world, position_world.as_dvec3() + rotation * p * range);
            let squeezed = |p: DVec3| DVec3::new(p.x * f64::from(outer_cone_rad).sin(), p.y, p.z);
            prop_assert!(!ball().chain(ball().map(squeezed)).filter(lit).any(inside));
        }
    }

    #[test]
    fn missed_box_lights_light_no_point_inside(
        (clip_from_world, eye) in clip_from_world(), at in vector(20.0), direction_world in unit(),
        size in vector(10.0)
    ) {
        let size_m = size.abs();
        let kind = LightKind::Box { illuminance_lx: 1.0, size_m, falloff_m: 0.0 };
        let light = Light { position_world: eye + at, ..Light::new(kind) }.towards(direction_world);
        if Frustum::new(&clip_from_world).misses(&Reach::of(&light)) {
            let axes = [light.right_world(), light.up_world, -light.direction_world].map(|a| a.as_dvec3());
            let world = |p: DVec3| {
                let local = (p - 0.5) * size_m.as_dvec3();
                light.position_world.as_dvec3() + axes[0] * local.x + axes[1] * local.y + axes[2] * local.z
            };
            prop_assert!(!cube().any(|p| sees(&clip_from_world, world(p))));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn boxes_that_a_light_misses_stay_dark(
        at in vector(10.0), size in vector(4.0), far in prop::sample::select(vec![0.0_f32, 100.0, 1e4]),
        position in vector(10.0), direction_world in unit(), shape in 0..3, range_m in prop::option::of(0.1_f32..8.0),
        outer_cone_rad in 0.01_f32..2.0, size_m in vector(5.0),
    ) {
        let kind = match shape {
            0 => LightKind::Point { intensity_cd: 1.0 },
            1 => LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.0, outer_cone_rad },
            _ => LightKind::Box { illuminance_lx: 1.0, size_m: size_m.abs(), falloff_m: 0.0 },
        };
        let origin = Vec3::splat(far);
        let light = Light { position_world: origin + position, range_m, ..Light::new(kind) }.towards(direction_world);
        let bounds = Aabb { min: origin + at, max: origin + at + size.abs() };
        if Reach::of(&light).misses_aabb(&bounds) {
            let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
            prop_assert!(!cube().any(|p| lights(&light, min + (max - min) * p)), "{light:?}");
        }
    }
}

/// Whether a light adds anything at a point.
fn lights(light: &Light, point_world: DVec3) -> bool {
    let from_light = point_world - light.position_world.as_dvec3();
    let in_range = light.range_m.is_none_or(|range| from_light.length() < f64::from(range));
    let along = from_light.dot(light.direction_world.as_dvec3());
    match light.kind {
        LightKind::Directional { .. } | LightKind::Hemisphere { .. } => true,
        LightKind::Point { .. } => in_range,
        LightKind::Spot { outer_cone_rad, .. } => {
            in_range && along > f64::from(outer_cone_rad).cos() * from_light.length()
        }
        LightKind::Box { size_m, .. } => {
            let axes = [light.right_world(), light.up_world, light.direction_world];
            axes.iter()
                .zip(size_m.to_array())
                .all(|(axis, size)| from_light.dot(axis.as_dvec3()).abs() < 0.5 * f64::from(size))
        }
    }
}

#[test]
fn a_light_misses_what_is_plainly_beyond_its_reach() {
    let bounds = |center: Vec3| Aabb { min: center - 0.5, max: center + 0.5 };
    let sphere = Reach::Sphere { center_world: Vec3::ZERO, radius_m: 1.0 };
    assert!(sphere.misses_aabb(&bounds(Vec3::X * 1.51)) && !sphere.misses_aabb(&bounds(Vec3::X * 1.49)));
    assert!(sphere.misses_aabb(&bounds(Vec3::ONE * 1.1)), "the corner's distance counts");
    let (sin, cos) = 0.4_f32.sin_cos();
    let cone = Reach::Cone { apex_world: Vec3::ZERO, direction_world: Vec3::X, cos, sin, range_m: 9.0 };
    assert!(!cone.misses_aabb(&bounds(Vec3::X * 5.0)) && cone.misses_aabb(&bounds(Vec3::X * -1.5)));
    assert!(cone.misses_aabb(&bounds(Vec3::Y * 3.0)) && cone.misses_aabb(&bounds(Vec3::X * 9.6)));
    let half_axes_world = [Vec3::new(1.0, 1.0, 0.0), Vec3::new(-1.0, 1.0, 0.0), Vec3::Z];
    let turned = Reach::Box { center_world: Vec3::ZERO, half_axes_world };
    assert!(
        turned.misses_aabb(&bounds(Vec3::new(1.8, 1.8, 0.0))) && !turned.misses_aabb(&bounds(Vec3::X * 2.4))
    );
    assert!(!Reach::Everywhere.misses_aabb(&bounds(Vec3::splat(1e9))));
}

/// 90 degrees each way from the origin towards -Z, from 1 m to 10 m.
fn square_view() -> Frustum {
    let projection =
        Projection::Perspective { yfov_rad: std::f32::consts::FRAC_PI_2, znear_m: 1.0, zfar_m: Some(10.0) };
    Frustum::new(&projection.clip_from_view(1.0))
}

#[test]
fn each_plane_misses_what_is_just_behind_it() {
    let view = square_view();
    // A point of each plane and the way out.
    let planes = [
        (Vec3::new(-5.0, 0.0, -5.0), Vec3::new(-1.0, 0.0, 1.0).normalize()),
        (Vec3::new(5.0, 0.0, -5.0), Vec3::new(1.0, 0.0, 1.0).normalize()),
        (Vec3::new(0.0, -5.0, -5.0), Vec3::new(0.0, -1.0, 1.0).normalize()),
        (Vec3::new(0.0, 5.0, -5.0), Vec3::new(0.0, 1.0, 1.0).normalize()),
        (Vec3::new(0.0, 0.0, -1.0), Vec3::Z),
        (Vec3::new(0.0, 0.0, -10.0), Vec3::NEG_Z),
    ];
    const NEARLY_M: f32 = 1e-3;
    for (at, out) in planes {
        for (distance, missed) in [(1.0 + NEARLY_M, true), (1.0 - NEARLY_M, false)] {
            assert_eq!(
                view.misses_sphere(at + out * distance, 1.0),
                missed,
                "sphere at {at}, {distance} m out"
            );
            let corner = at + out * (distance - 1.0);
            let away = corner + out.signum() * out.abs().ceil();
            let bounds = Aabb { min: corner.min(away), max: corner.max(away) };
            assert_eq!(view.misses_aabb(&bounds), missed, "box at {at}, {distance} m out");
            // A cone of 45 degrees whose axis comes back in reaches as far as its range.
            let cone = |direction_world| Reach::Cone {
                apex_world: at + out * distance,
                direction_world,
                cos: std::f32::consts::FRAC_1_SQRT_2,
                sin: std::f32::consts::FRAC_1_SQRT_2,
                range_m: 1.0,
            };
            assert_eq!(view.misses(&cone(-out)), missed, "cone at {at}, {distance} m out");
            assert!(view.misses(&cone(out)), "cone that turns away at {at}, {distance} m out");
        }
    }
}

#[test]
fn a_cone_is_narrower_than_its_sphere() {
    let cone = |direction_world, range_m| {
        let (sin, cos) = 0.3_f32.sin_cos();
        Reach::Cone { apex_world: Vec3::new(0.0, 0.0, 2.0), direction_world, cos, sin, range_m }
    };
    let view = square_view();
    // Behind the camera: shining at it, past it, and away from it.
    for (direction_world, missed) in [(Vec3::NEG_Z, false), (Vec3::X, true), (Vec3::Z, true)] {
        for range_m in [4.0, f32::INFINITY] {
            let infinite_sideways = missed && direction_world == Vec3::X && range_m.is_infinite();
            // Endless, its edge leaves the side's plane behind somewhere, though not inside of the others.
            assert!(view.misses(&cone(direction_world, range_m)) == missed || infinite_sideways);
        }
    }
    assert!(view.misses(&cone(Vec3::NEG_Z, 2.9)), "it ends before the near plane");
}

#[test]
fn nothing_is_missed_without_a_limit_or_by_no_number() {
    let far = Aabb { min: Vec3::splat(-1e15), max: Vec3::splat(1e15) };
    assert!(!square_view().misses_aabb(&far));
    assert!(!square_view().misses(&Reach::Everywhere));
    let endless = Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None }.clip_from_view(1.0);
    assert!(!Frustum::new(&endless).misses_sphere(Vec3::new(0.0, 0.0, -1e15), 1.0));
    let broken = Frustum::new(&Mat4::from_cols_array(&[f32::NAN; 16]));
    assert!(!broken.misses_sphere(Vec3::ZERO, 1.0) && !broken.misses_aabb(&far));
}

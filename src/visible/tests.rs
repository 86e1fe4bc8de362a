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

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    /// At the very edge, where the last bit decides: what a GPU finds inside is not missed.
    #[test]
    fn what_a_gpu_sees_at_the_edge_is_not_missed(
        (clip_from_world, _) in clip_from_world(), at in prop::array::uniform2(-1.0_f64..1.0), depth in 0.0001_f64..1.0,
        edge in 0..4_usize, size in vector(10.0), away in unit(), radius in 0.0_f32..10.0,
    ) {
        let mut ndc = at;
        ndc[edge / 2] = [-1.0, 1.0][edge % 2];
        let point = clip_from_world.as_dmat4().inverse() * DVec3::new(ndc[0], ndc[1], depth).extend(1.0);
        let corner = (point.truncate() / point.w).as_vec3();
        let clip = clip_from_world * corner.extend(1.0);
        let inside = clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && 0.0 <= clip.z && clip.z <= clip.w;
        if inside || sees(&clip_from_world, corner.as_dvec3()) {
            let frustum = Frustum::new(&clip_from_world);
            for sign in cube_corners() {
                let other = corner + size.abs() * sign;
                let bounds = Aabb { min: corner.min(other), max: corner.max(other) };
                prop_assert!(!frustum.misses_aabb(&bounds), "{bounds:?}");
            }
            let center = corner + away * radius;
            let holds = corner.as_dvec3().distance(center.as_dvec3()) <= f64::from(radius);
            prop_assert!(!holds || !frustum.misses_sphere(center, radius), "{radius} m around {center}");
        }
    }

    /// At the very edge of a light: what a shader finds lit, where its rounding puts a pixel of the box, is in the set.
    #[test]
    fn boxes_that_touch_a_light_are_not_missed(
        light in light(), far in prop::sample::select(vec![0.0_f32, 100.0, 1e4]), outside in unit(), size in vector(4.0),
        off in prop::sample::select(cube_corners().to_vec()),
    ) {
        let light = Light { position_world: light.position_world + far, ..light };
        let source = light.position_world.as_dvec3();
        // Where the light ends, from a place that it lights in a straight line to one that it does not.
        let lit = source + light.direction_world.as_dvec3() * 1e-3;
        let dark = source + outside.as_dvec3() * 1e3;
        if lights(&light, lit) && !lights(&light, dark) {
            let mut ends = [lit, dark];
            for _ in 0..60 {
                let middle = (ends[0] + ends[1]) * 0.5;
                ends[usize::from(!lights(&light, middle))] = middle;
            }
            let corner = ends[0].as_vec3();
            let rounding = corner.abs().max_element() * f32::EPSILON;
            if lights(&light, (corner + off * rounding).as_dvec3()) {
                for sign in cube_corners() {
                    let other = corner + size.abs() * sign;
                    let bounds = Aabb { min: corner.min(other), max: corner.max(other) };
                    prop_assert!(!Reach::of(&light).misses_aabb(&bounds), "{light:?} {bounds:?}");
                }
            }
        }
    }

    /// Shaders compare rounded numbers, and find a light to reach a little further than it does.
    #[test]
    fn reaches_hold_what_shaders_let_in(range_m in 0.01_f32..100.0, way in unit(), ulps in -4_i32..=4) {
        let kind = LightKind::Point { intensity_cd: 1.0 };
        let light = Light { range_m: Some(range_m), ..Light::new(kind) };
        let place = way * f32::from_bits(range_m.to_bits().saturating_add_signed(ulps));
        let Reach::Sphere { radius_m, .. } = Reach::of(&light) else { unreachable!() };
        prop_assert!(!reaches(&light, place) || place.as_dvec3().length() <= f64::from(radius_m));
    }
}

fn cube_corners() -> [Vec3; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7]
        .map(|i: i32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0)
}

/// Any light that ends.
fn light() -> impl Strategy<Value = Light> {
    let numbers = (vector(10.0), unit(), 0..3, 0.1_f32..8.0, 0.01_f32..2.0, vector(5.0));
    numbers.prop_map(|(position_world, direction_world, shape, range_m, outer_cone_rad, size_m)| {
        let kind = match shape {
            0 => LightKind::Point { intensity_cd: 1.0 },
            1 => LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.0, outer_cone_rad },
            _ => LightKind::Box { illuminance_lx: 1.0, size_m: size_m.abs(), falloff_m: 0.0 },
        };
        Light { position_world, range_m: Some(range_m), ..Light::new(kind) }.towards(direction_world)
    })
}

/// Whether a shader finds that the light reaches the place, all in `f32`.
pub(super) fn reaches(light: &Light, place: Vec3) -> bool {
    let to_light = light.position_world - place;
    if let LightKind::Box { size_m, .. } = light.kind {
        let axes = [light.right_world(), light.up_world, light.direction_world];
        return (0..3).all(|i| to_light.dot(axes[i]).abs() < 0.5 * size_m[i]);
    }
    let inverse_range = light.range_m.map_or(0.0, f32::recip);
    let in_cone = match light.kind {
        LightKind::Spot { outer_cone_rad, .. } => {
            light.direction_world.dot(-to_light.normalize()) > outer_cone_rad.cos()
        }
        _ => true,
    };
    to_light.length_squared() * (inverse_range * inverse_range) < 1.0 && in_cone
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

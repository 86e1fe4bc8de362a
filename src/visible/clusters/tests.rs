use glam::{Mat4, Quat, Vec3};
use proptest::prelude::*;

use super::*;
use crate::scene::{Light, LightKind, Projection};
use crate::visible::tests::reaches;

prop_compose! {
    fn cameras()(
        eye in prop::array::uniform3(-20.0..20.0_f32),
        turn in prop::array::uniform3(-3.0..3.0_f32),
        half in 0.05..1.4_f32,
        znear_m in 0.01..2.0_f32,
        depth in 1.0..100.0_f32,
        kind in 0..3,
    ) -> Camera {
        let rotation = Quat::from_scaled_axis(turn.into());
        let projection = match kind {
            0 => Projection::Perspective { yfov_rad: 2.0 * half, znear_m, zfar_m: None },
            1 => Projection::Perspective { yfov_rad: 2.0 * half, znear_m, zfar_m: Some(znear_m + depth) },
            _ => Projection::Orthographic {
                xmag_m: 1.0, ymag_m: 10.0 * half, znear_m, zfar_m: znear_m + depth,
            },
        };
        let world_from_view = Mat4::from_rotation_translation(rotation, eye.into());
        Camera { name: String::new(), world_from_view, projection }
    }
}

prop_compose! {
    fn lights(most: usize)(
        all in prop::collection::vec((
            prop::option::weighted(0.25, prop::array::uniform3(0.1..20.0_f32)),
            prop::array::uniform3(-30.0..30.0_f32),
            prop::array::uniform3(-1.0..1.0_f32),
            prop_oneof![Just(None), Just(Some(0.0_f32)), (0.01..1.0_f32).prop_map(Some), (1.0..40.0_f32).prop_map(Some)],
            prop::option::of(0.01..1.6_f32),
        ), 0..most),
    ) -> Vec<Light> {
        all.into_iter().map(|(size, place, direction, range_m, cone)| {
            let kind = match (size, cone) {
                (Some(size), _) => {
                    LightKind::Box { illuminance_lx: 1.0, size_m: size.into(), falloff_m: 0.0 }
                }
                (_, None) => LightKind::Point { intensity_cd: 1.0 },
                (_, Some(outer_cone_rad)) => {
                    LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.0, outer_cone_rad }
                }
            };
            let way = Vec3::from(direction).try_normalize().unwrap_or(Vec3::X);
            Light { position_world: place.into(), range_m, ..Light::new(kind).towards(way) }
        }).collect()
    }
}

/// The middle of a pixel at a distance along the view axis, as shaders compute it.
fn place_of(camera: &Camera, size: [u32; 2], pixel: [u32; 2], distance: f32) -> Vec3 {
    let [width, height] = size.map(|s| s as f32);
    let ndc = [0, 1].map(|i| (pixel[i] as f32 + 0.5) * 2.0 / size[i] as f32 - 1.0);
    let aspect = width / height;
    let (half, along) = match camera.projection {
        Projection::Perspective { yfov_rad, .. } => ((yfov_rad * 0.5).tan(), distance),
        Projection::Orthographic { ymag_m, .. } => (ymag_m, 1.0),
    };
    let view = Vec3::new(ndc[0] * half * aspect * along, -ndc[1] * half * along, -distance);
    camera.world_from_view.transform_point3(view)
}

fn depths(camera: &Camera) -> [f32; 2] {
    match camera.projection {
        Projection::Perspective { znear_m, zfar_m, .. } => [znear_m, zfar_m.unwrap_or(1e4)],
        Projection::Orthographic { znear_m, zfar_m, .. } => [znear_m, zfar_m],
    }
}

fn check_shape(clusters: &Clusters, first: u32, lights: usize) {
    let cells = clusters.grid().cell_count();
    assert!(cells <= Grid::MOST_CELLS && clusters.words().len() <= Clusters::most_words(lights));
    assert_eq!(clusters.words()[0] as usize, cells + 1);
    assert_eq!(clusters.words()[cells] as usize, clusters.words().len());
    for cell in 0..cells {
        let list = clusters.lights_of(cell);
        assert!(list.is_sorted_by(|a, b| a < b), "{list:?}");
        assert!(list.iter().all(|&l| (first..first + lights as u32).contains(&l)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_light_that_reaches_a_pixel_is_in_its_list(
        camera in cameras(),
        size in [1..2000_u32, 1..2000_u32],
        lights in lights(24),
        samples in prop::collection::vec((0.0..1.0_f64, 0.0..1.0_f64, 0.0..1.0_f32), 64),
        first in 0..100_u32,
    ) {
        let reaches_of: Vec<_> = lights.iter().map(Reach::of).collect();
        let mut clusters = Clusters::new(lights.len());
        clusters.build(&camera, size, first, &reaches_of);
        check_shape(&clusters, first, lights.len());
        let [near, far] = depths(&camera);
        // Anywhere in view, and on the way to each light.
        let anywhere = samples.iter().map(|&(x, y, t)| {
            let pixel = [x * f64::from(size[0]), y * f64::from(size[1])].map(|p| p as u32);
            (pixel, near * (far / near).powf(t))
        });
        let at_lights = lights.iter().zip(&samples).filter_map(|(light, &(x, y, t))| {
            let offset = Vec3::new(x as f32 - 0.5, y as f32 - 0.5, t - 0.5) * 2.0 * light.range_m.unwrap_or(5.0);
            let view = camera.world_from_view.inverse().transform_point3(light.position_world + offset);
            let aspect = size[0] as f32 / size[1] as f32;
            let clip = camera.projection.clip_from_view(aspect).project_point3(view);
            let inside = clip.x.abs() < 1.0 && clip.y.abs() < 1.0 && -view.z > near && -view.z < far;
            let pixel = [0, 1].map(|i| ((clip[i] * 0.5 + 0.5) * size[i] as f32) as u32);
            inside.then_some((pixel, -view.z))
        });
        for (pixel, distance) in anywhere.chain(at_lights) {
            let pixel = [0, 1].map(|i| pixel[i].min(size[i] - 1));
            let place = place_of(&camera, size, pixel, distance);
            let list = clusters.lights_of(clusters.grid().cell(pixel, distance));
            for (light, index) in lights.iter().zip(first..) {
                prop_assert!(!reaches(light, place) || list.contains(&index),
                    "{light:?} reaches {place} at pixel {pixel:?}, {distance} m: not in {list:?}, {:?}", clusters.grid());
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Far from the world's origin a shader rounds a pixel's place by more than its distance from the next cell.
    #[test]
    fn a_light_at_a_rounded_place_is_in_the_list_of_its_pixel(
        mut camera in cameras(), far in vec_of(1e5), pixel in [0..1920_u32, 0..1080_u32], depth in 0.0..1.0_f32,
        range_m in 1e-5..1e-3_f32,
    ) {
        const SIZE: [u32; 2] = [1920, 1080];
        camera.world_from_view.w_axis += far.extend(0.0);
        let [near, far] = depths(&camera);
        let distance = near + depth * (far - near).min(2.0);
        let place = place_of(&camera, SIZE, pixel, distance);
        let mut clusters = Clusters::new(1);
        clusters.build(&camera, SIZE, 0, &[Reach::Sphere { center_world: place, radius_m: range_m }]);
        prop_assert_eq!(clusters.lights_of(clusters.grid().cell(pixel, distance)), [0]);
    }
}

fn vec_of(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from_array)
}

/// What a shader may make of a distance: logarithms are off by 3 units in the last place, within 0.5 to 2 by 2^-21 (Vulkan
/// specification, "Precision and Operation of SPIR-V Instructions"), and sums are fused or not.
fn slices_of(grid: &Grid, distance: f32) -> impl Iterator<Item = u32> {
    const LOG2_ULPS: f64 = 3.0;
    const LOG2_NEAR_1: f64 = 1.0 / (1 << 21) as f64;
    let measure = match grid.logarithmic {
        true => f64::from(distance).log2(),
        false => f64::from(distance),
    };
    let off = match grid.logarithmic {
        true => (LOG2_ULPS * f64::from(f32::EPSILON) * measure.abs()).max(LOG2_NEAR_1),
        false => 0.0,
    };
    let Grid { slice_scale, slice_bias, slices, .. } = *grid;
    [-off, 0.0, off].into_iter().flat_map(move |off| {
        let measure = (measure + off) as f32;
        let sums = [measure * slice_scale + slice_bias, measure.mul_add(slice_scale, slice_bias)];
        sums.map(|sum| (sum as u32).min(slices - 1))
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn slices_hold_what_shaders_put_in_them(
        camera in cameras(), size in [1..2000_u32, 1..2000_u32], nearest in 0.01..5.0_f32, thick in 1.0..1000.0_f32,
    ) {
        const ULPS: i32 = 40;
        let grid = Grid::new(&camera, size, [nearest, nearest + thick]);
        let mut planes = Planes::with_room();
        planes.set(&grid, &camera, size);
        for &begin in &planes.slices[1..planes.slices.len() - 1] {
            for ulps in -ULPS..=ULPS {
                let distance = f32::from_bits(begin.to_bits().saturating_add_signed(ulps)).max(planes.slices[0]);
                for slice in slices_of(&grid, distance) {
                    let [near, far] = planes.slice(slice);
                    prop_assert!((near..=far).contains(&distance), "{distance} m in slice {slice}, {near} to {far} m");
                }
            }
        }
    }

    #[test]
    fn coarser_grids_span_the_same(
        camera in cameras(), size in [1..2000_u32, 1..2000_u32], nearest in 0.01..5.0_f32, thick in 1.0..1000.0_f32,
    ) {
        const MOST_OFF: f32 = 1e-4;
        let mut grid = Grid::new(&camera, size, [nearest, nearest + thick]);
        let ends = |grid: &Grid| [0, grid.slices].map(|s| (s as f32 - grid.slice_bias) / grid.slice_scale);
        let (before, cut) = (ends(&grid), grid.slice_scale > 0.0);
        while grid.cell_count() > 1 {
            let Grid { tile_shift, slices, .. } = grid;
            grid.coarsen(size);
            prop_assert_eq!((grid.tile_shift, grid.slices), (tile_shift + 1, slices.div_ceil(2)));
            prop_assert_eq!([grid.columns, grid.rows], size.map(|pixels| pixels.div_ceil(1 << grid.tile_shift)));
            let off = |i: usize| (ends(&grid)[i] - before[i]).abs() / before[i].abs().max(1.0);
            prop_assert!(!cut || off(0).max(off(1)) < MOST_OFF, "{before:?} became {:?}", ends(&grid));
        }
    }
}

fn camera() -> Camera {
    let projection = Projection::Perspective { yfov_rad: 0.9, znear_m: 0.1, zfar_m: None };
    Camera { name: String::new(), world_from_view: Mat4::IDENTITY, projection }
}

/// Lists are not much longer than they need be: against the cells in which some of many points is reached.
#[test]
fn lists_are_short() {
    /// Entries for each cell in which a point was found: a cell that is only touched has seldom one.
    const MOST_ENTRIES_PER_CELL: f32 = 1.5;
    let size = [1280, 720];
    let sphere = Reach::Sphere { center_world: Vec3::new(1.0, -0.5, -12.0), radius_m: 2.5 };
    let tilted = Vec3::new(0.3, -0.8, -0.5).normalize();
    let [cos, sin] = [0.5_f32.cos(), 0.5_f32.sin()];
    let apex_world = Vec3::new(-1.0, 2.0, -9.0);
    let cone = Reach::Cone { apex_world, direction_world: tilted, cos, sin, range_m: 5.0 };
    let crate_axes = Mat4::from_rotation_y(0.5) * Mat4::from_rotation_x(0.4);
    let half_axes_world = [Vec3::X * 2.0, Vec3::Y, Vec3::Z * 1.5].map(|a| crate_axes.transform_vector3(a));
    let slanted = Reach::Box { center_world: Vec3::new(0.5, 1.0, -10.0), half_axes_world };
    for reach in [sphere, cone, slanted] {
        let mut clusters = Clusters::new(1);
        clusters.build(&camera(), size, 0, &[reach]);
        let grid = *clusters.grid();
        let mut found = vec![false; grid.cell_count()];
        for x in (0..size[0]).step_by(8) {
            for y in (0..size[1]).step_by(8) {
                for step in 0..200 {
                    let distance = 6.0 + 0.05 * step as f32;
                    let place = place_of(&camera(), size, [x, y], distance);
                    let inside = match reach {
                        Reach::Sphere { center_world, radius_m } => place.distance(center_world) < radius_m,
                        Reach::Cone { .. } => {
                            let way = place - apex_world;
                            way.length() < 5.0 && way.normalize().dot(tilted) > cos
                        }
                        Reach::Box { center_world, half_axes_world } => half_axes_world
                            .iter()
                            .all(|a| (place - center_world).dot(*a).abs() < a.length_squared()),
                        Reach::Everywhere => true,
                    };
                    found[grid.cell([x, y], distance)] |= inside;
                }
            }
        }
        let cells = found.iter().filter(|f| **f).count();
        let entries = clusters.words().len() - grid.cell_count() - 1;
        let ratio = entries as f32 / cells as f32;
        println!("{entries} entries for {cells} cells: {ratio}");
        assert!(cells > 100 && (1.0..MOST_ENTRIES_PER_CELL).contains(&ratio), "{entries} for {cells} cells");
    }
}

#[test]
fn where_lists_grow_too_long_the_grid_is_coarser() {
    let everywhere = vec![Reach::Everywhere; 5000];
    let mut clusters = Clusters::new(everywhere.len());
    let room = clusters.words.capacity();
    clusters.build(&camera(), [1920, 1080], 7, &everywhere);
    check_shape(&clusters, 7, everywhere.len());
    let all: Vec<_> = (7..5007).collect();
    let cells = clusters.grid().cell_count();
    assert!((0..cells).all(|cell| clusters.lights_of(cell) == all));
    assert_eq!(clusters.words.capacity(), room, "it allocates");

    // Finer again where there is room, and nothing is left of what was.
    clusters.build(&camera(), [1920, 1080], 0, &[Reach::Sphere { center_world: Vec3::Z, radius_m: 0.5 }]);
    assert!(
        clusters.grid().cell_count() >= cells && clusters.words().len() == clusters.grid().cell_count() + 1
    );
}

/// A limit on every path: views and lights of numbers that mean nothing still give lists.
#[test]
fn numbers_that_mean_nothing_do_no_harm() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        let mut broken = camera();
        broken.world_from_view.w_axis.x = bad;
        for camera in [camera(), broken] {
            let mut clusters = Clusters::new(2);
            let lights = [
                Reach::Sphere { center_world: Vec3::splat(bad), radius_m: 1.0 },
                Reach::Sphere { center_world: Vec3::ZERO, radius_m: bad },
            ];
            clusters.build(&camera, [64, 64], 0, &lights);
            check_shape(&clusters, 0, 2);
        }
    }
}

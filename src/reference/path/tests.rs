use super::*;
use crate::reference::testing::{scene_of, square};
use crate::scene::{AlphaMode, Environment, Instance, Material, Mesh, Shadow};
use glam::{Mat4, Vec3, Vec4};
use std::f32::consts::{FRAC_PI_2, PI as PI_32};

const SAMPLES: u32 = 4096;

fn gray(albedo: f32, emission: f32) -> Material {
    Material {
        base_color_factor: Vec3::splat(albedo).extend(1.0),
        emissive_factor: Vec3::splat(emission),
        metallic_factor: 0.0,
        ..Material::default()
    }
}

/// White, at the origin, shining along -Z.
fn lamp(kind: LightKind) -> Light {
    Light { shadow: Some(Shadow::default()), ..Light::new(kind) }
}

/// On a surface that faces +Z.
fn receiver(position: DVec3) -> Receiver {
    Receiver { position_world: position, normal_world: DVec3::Z, plane_normal_world: DVec3::Z }
}

/// The six inner sides of the cube of half extent 1.
fn room(material: Material) -> Scene {
    let side = |rotation: Mat4| (square(1.0), rotation * Mat4::from_translation(Vec3::NEG_Z));
    let around = (0..4).map(|i| side(Mat4::from_rotation_y(FRAC_PI_2 * i as f32)));
    let ends = [-1.0, 1.0].map(|s| side(Mat4::from_rotation_x(FRAC_PI_2 * s)));
    scene_of(material, around.chain(ends).collect())
}

/// Irradiance by paths with a share of the standard error of a few per mille.
fn irradiance(scene: &Scene, bounces: u32, at: DVec3) -> f64 {
    Paths::new(scene, scene.lights.iter().collect(), bounces).irradiance(&receiver(at), SAMPLES, 7).x
}

#[track_caller]
fn assert_near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance * expected, "{value}, expected {expected}");
}

#[test]
fn a_closed_room_that_glows_gathers_the_geometric_series() {
    /// Noise of the two ways to find a wall.
    const NOISE: f64 = 0.01;
    let (albedo, emission) = (0.6, 0.25);
    let scene = room(gray(albedo as f32, emission as f32));
    for bounces in [0, 1, 4, 40] {
        // Radiance after b bounces: E (1 + a + ... + a^b), and irradiance is pi times that.
        let radiance = emission * (1.0 - f64::powi(albedo, bounces + 1)) / (1.0 - albedo);
        assert_near(irradiance(&scene, bounces as u32, DVec3::new(0.3, -0.5, -1.0)), PI * radiance, NOISE);
    }
}

#[test]
fn lights_obey_the_cosine_and_are_blocked() {
    let mut bulb = lamp(LightKind::Point { intensity_cd: 8.0 });
    bulb.position_world = Vec3::new(2.0, 0.0, 2.0);
    let mut sun = lamp(LightKind::Directional { illuminance_lx: 3.0 });
    sun.direction_world = Vec3::new(0.0, 0.6, -0.8);
    let blocker =
        (square(1.0), Mat4::from_translation(Vec3::new(1.0, 0.0, 1.0)) * Mat4::from_rotation_y(-1.0));
    let mut scene = scene_of(gray(0.0, 0.0), vec![(square(3.0), Mat4::IDENTITY)]);
    scene.lights = vec![bulb, sun];
    // 8 cd at sqrt(8) m and 45 degrees; 3 lx at a cosine of 0.8.
    let (from_lamp, from_sun) = (0.5_f64.sqrt(), 2.4);
    assert_near(irradiance(&scene, 3, DVec3::ZERO), from_lamp + from_sun, 1e-6);
    scene.meshes.push(blocker.0);
    scene.instances.push(Instance::new(1, blocker.1));
    // Its back is turned to the lamp: it blocks all the same.
    assert_near(irradiance(&scene, 3, DVec3::ZERO), from_sun, 1e-6);
    // Without shadows, the lamp shines through.
    scene.lights[0].shadow = None;
    assert_near(irradiance(&scene, 3, DVec3::ZERO), from_lamp + from_sun, 1e-6);
    scene.lights[0].shadow = Some(Shadow::default());
    // Of a mask, only what is there blocks.
    scene.meshes[1].colors = vec![Vec4::new(1.0, 1.0, 1.0, 0.4); 4];
    scene.materials[0].alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    assert_near(irradiance(&scene, 3, DVec3::ZERO), from_lamp + from_sun, 1e-6);
}

#[test]
fn a_box_light_is_blocked_within_its_box_only() {
    let kind = LightKind::Box { illuminance_lx: 2.0, size_m: Vec3::splat(2.0), falloff_m: 0.0 };
    let cover = |z: f32| {
        let mut scene = scene_of(gray(0.0, 0.0), vec![(square(0.5), Mat4::from_translation(Vec3::Z * z))]);
        scene.lights = vec![lamp(kind)];
        irradiance(&scene, 0, DVec3::Z * -0.5)
    };
    // The box goes from -1 to 1.
    assert_eq!([cover(0.9), cover(1.1), cover(-0.9)], [0.0, 2.0, 2.0]);
}

#[test]
fn hemispheres_and_back_colours_come_through() {
    let mut scene = scene_of(gray(0.0, 0.0), vec![(square(0.5), Mat4::from_translation(Vec3::Z))]);
    let mut sky = lamp(LightKind::Hemisphere { illuminance_lx: 4.0 });
    (sky.direction_world, sky.back_color) = (Vec3::NEG_X, Vec3::splat(0.5));
    let mut rim = lamp(LightKind::Directional { illuminance_lx: 3.0 });
    (rim.direction_world, rim.back_color) = (Vec3::Z, Vec3::splat(0.25));
    scene.lights = vec![sky, rim];
    // Half of either half sphere; a quarter of the light from behind.
    assert_near(irradiance(&scene, 0, DVec3::ZERO), 2.0 + 1.0 + 0.75, 1e-6);
}

/// From an element to a parallel rectangle with a corner above it: Howell, "A Catalog of Radiation Heat Transfer
/// Configuration Factors", B-3.
fn corner_factor(a: f64, b: f64) -> f64 {
    let (p, q) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
    (a / p * (b / p).atan() + b / q * (a / q).atan()) / (2.0 * PI)
}

#[test]
fn a_glowing_square_has_its_form_factor() {
    /// A small panel is found mostly by drawing points on it, a near one mostly by directions.
    const NOISE: f64 = 0.005;
    for (half, height) in [(1.0_f64, 1.0_f64), (0.1, 1.0), (20.0, 0.5)] {
        let facing_down = Mat4::from_translation(Vec3::Z * height as f32) * Mat4::from_rotation_x(PI_32);
        let scene = scene_of(gray(0.5, 2.0), vec![(square(half as f32), facing_down)]);
        let expected = 2.0 * PI * 4.0 * corner_factor(half / height, half / height);
        assert_near(irradiance(&scene, 5, DVec3::ZERO), expected, NOISE);
        // Its back sends nothing, unless it is drawn.
        let mut turned = scene_of(
            gray(0.5, 2.0),
            vec![(square(half as f32), Mat4::from_translation(Vec3::Z * height as f32))],
        );
        assert_eq!(irradiance(&turned, 5, DVec3::ZERO), 0.0);
        turned.materials[0].double_sided = true;
        assert_near(irradiance(&turned, 5, DVec3::ZERO), expected, NOISE);
    }
}

#[test]
fn two_squares_exchange_what_the_form_factor_says() {
    /// Howell C-11: opposite unit squares one apart.
    const FACTOR: f64 = 0.199_825;
    let facing_down = Mat4::from_translation(Vec3::Z) * Mat4::from_rotation_x(PI_32);
    let mut scene = scene_of(gray(0.5, 2.0), vec![(square(0.5), facing_down)]);
    // As an unlit surface it shines by its colour instead, and as the picture shows it.
    scene.materials[0].unlit = true;
    let paths = Paths::new(&scene, Vec::new(), 2);
    let side = 64;
    let place = |i: i32| (f64::from(i) + 0.5) / f64::from(side) - 0.5;
    let points = (0..side * side).map(|i| receiver(DVec3::new(place(i % side), place(i / side), 0.0)));
    let sum: f64 = points.zip(0..).map(|(point, seed)| paths.irradiance(&point, 16, seed).x).sum();
    assert_near(sum / f64::from(side * side), 0.5 * PI * FACTOR, 0.005);
}

#[test]
fn open_sky_gives_pi_times_its_radiance_and_half_of_it_beside_a_wall() {
    let mut scene = scene_of(gray(0.0, 0.0), vec![(square(1.0), Mat4::IDENTITY)]);
    scene.ambient_nt = Vec3::splat(0.7);
    let open = f64::from(0.7_f32) * PI;
    assert_near(irradiance(&scene, 3, DVec3::ZERO), open, 1e-9);
    // A wall without end, for all that matters: nothing comes from its side.
    let wall = Mat4::from_translation(Vec3::X * 1e-3) * Mat4::from_rotation_y(-FRAC_PI_2);
    let mut scene = scene_of(gray(0.0, 0.0), vec![(square(1e4), wall)]);
    scene.ambient_nt = Vec3::splat(0.7);
    assert_near(irradiance(&scene, 3, DVec3::ZERO), open * 0.5, 2e-3);
}

#[test]
fn an_integrating_sphere_multiplies_its_lamp() {
    /// Flat facets: a sphere of 64 by 32 of them.
    const FACETS: f64 = 0.01;
    let (rings, sectors) = (32, 64);
    let mut sphere = Mesh::default();
    for ring in 0..=rings {
        for sector in 0..=sectors {
            let (theta, phi) = (PI * f64::from(ring) / 32.0, 2.0 * PI * f64::from(sector) / 64.0);
            let point = DVec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos());
            sphere.positions.push(point.as_vec3());
            if ring < rings && sector < sectors {
                let a = (ring * (sectors + 1) + sector) as u32;
                let b = a + 65;
                // Facing inwards.
                sphere.indices.extend([a, a + 1, b, a + 1, b + 1, b]);
            }
        }
    }
    let albedo: f64 = 0.5;
    let mut scene = scene_of(gray(albedo as f32, 0.0), vec![(sphere, Mat4::IDENTITY)]);
    scene.lights = vec![lamp(LightKind::Point { intensity_cd: 2.0 })];
    for bounces in [0, 1, 2, 20] {
        let expected = 2.0 * (1.0 - albedo.powi(bounces + 1)) / (1.0 - albedo);
        assert_near(irradiance(&scene, bounces as u32, DVec3::Z * -0.998), expected, FACETS);
    }
}

#[test]
fn a_receiver_inside_something_says_so() {
    let mut scene = scene_of(gray(0.5, 0.0), vec![(square(1.0), Mat4::from_translation(Vec3::Z))]);
    let enclosed = |scene: &Scene| {
        let paths = Paths::new(scene, Vec::new(), 1);
        paths.sample(&receiver(DVec3::ZERO), [0.0, 0.0], &mut Random::new(1)).is_enclosed
    };
    assert!(enclosed(&scene));
    scene.materials[0].double_sided = true;
    assert!(!enclosed(&scene));
}

#[test]
fn an_environment_is_found_however_small_its_sun() {
    use crate::environment::{Panorama, direction_from_uv};
    /// Noise, and that a texel's light is spread over its neighbours.
    const NOISE: f64 = 0.01;
    let (width, height) = (128, 64);
    let sun = (37, 20);
    let texel = |i: u32| if (i % width, i / width) == sun { Vec3::splat(900.0) } else { Vec3::splat(0.2) };
    let picture = Panorama::new(width, height, (0..width * height).map(texel).collect()).unwrap();
    let mut scene = scene_of(gray(0.0, 0.0), vec![(square(1e-3), Mat4::from_translation(Vec3::Z * -9.0))]);
    let environment = Environment { rotation_deg: 200.0, intensity: 2.0, ..Environment::new("sky", picture) };
    let center = direction_from_uv([(f64::from(sun.0) + 0.5) / 128.0, (f64::from(sun.1) + 0.5) / 64.0]);
    let towards = glam::DQuat::from_rotation_y(200_f64.to_radians()) * center;
    scene.environment = Some(environment);
    let paths = Paths::new(&scene, Vec::new(), 0);
    let facing = Receiver { position_world: DVec3::ZERO, normal_world: towards, plane_normal_world: towards };
    // The filter's tent around a texel has the integral of the texel's own area.
    let area = (2.0 * PI / 128.0) * (PI / 64.0) * (PI * (f64::from(sun.1) + 0.5) / 64.0).sin();
    let expected = 2.0 * (0.2 * PI + (900.0 - 0.2) * area);
    let found = paths.irradiance(&facing, 1 << 16, 3).x;
    assert_near(found, expected, NOISE);
}

//! Scenes in light from far away and from inside boxes.

use std::sync::Arc;

use ontile::environment::{Panorama, Prefiltered, TexelFormat, direction_from_uv};
use ontile::glam::{DVec3, Quat, Vec3};
use ontile::scene::{Background, Environment, Probe, Scene};

use super::scenes::{every_feature, lights_only};

/// All scenes of this file.
pub fn all() -> Vec<Scene> {
    vec![environment(), environment_alone(), probes(), probes_alone()]
}

/// Every feature under a sky, with occlusion textures and ambient light.
pub fn environment() -> Scene {
    Scene { name: "environment".into(), environment: Some(sky()), ..every_feature() }
}

/// Untextured surfaces under a sky, without light sources.
pub fn environment_alone() -> Scene {
    Scene { name: "environment_alone".into(), environment: Some(sky()), lights: Vec::new(), ..lights_only() }
}

/// [`environment`] before its own picture, with two rooms that overlap and end within the scene.
pub fn probes() -> Scene {
    let background = Background::Environment;
    Scene { name: "probes".into(), probes: rooms(), background, ..environment() }
}

/// One room, and nothing far away.
pub fn probes_alone() -> Scene {
    let probes = rooms().drain(..1).collect();
    Scene { name: "probes_alone".into(), probes, environment: None, ..environment_alone() }
}

fn panorama(radiance: impl Fn(DVec3) -> Vec3) -> Panorama {
    let texel = |i: u32| {
        let (x, y) = (f64::from(i % 64) + 0.5, f64::from(i / 64) + 0.5);
        radiance(direction_from_uv([x / 64.0, y / 32.0]))
    };
    Panorama::new(64, 32, (0..64 * 32).map(texel).collect()).expect("a panorama")
}

/// Filtered small: it is made often.
fn filtered(name: &str, panorama: Panorama) -> Environment {
    let prefiltered = Prefiltered::new(&panorama, 32, TexelFormat::E5B9G9R9);
    Environment { prefiltered: Some(Arc::new(prefiltered)), ..Environment::new(name, panorama) }
}

/// Different in all directions.
fn sky() -> Environment {
    let radiance = |d: DVec3| {
        let d = d.as_vec3();
        let sun = if d.dot(Vec3::new(0.48, 0.6, 0.64)) > 0.98 { 20.0 } else { 0.0 };
        (d * 0.4 + 0.5) * if d.y > 0.0 { 1.0 } else { 0.3 } + sun
    };
    Environment { rotation_deg: 40.0, intensity: 0.7, ..filtered("sky", panorama(radiance)) }
}

/// Boxes with a colour for each wall, one of them turned.
pub fn rooms() -> Vec<Probe> {
    let walls = |d: DVec3| {
        let a = d.abs();
        let wall = if a.x > a.y && a.x > a.z { 0 } else { 1 + usize::from(a.z > a.y) };
        let color = [Vec3::new(0.9, 0.3, 0.2), Vec3::new(0.3, 0.8, 0.4), Vec3::new(0.2, 0.3, 0.9)][wall];
        color * if d[wall] > 0.0 { 1.0 } else { 0.4 }
    };
    let room = |name: &str, at: Vec3, turn: f32, half_size_m: Vec3| Probe {
        name: name.into(),
        position_world: at,
        world_from_probe: Quat::from_rotation_y(turn),
        half_size_m,
        falloff_m: 0.4,
        environment: Environment { rotation_deg: -20.0, intensity: 1.5, ..filtered(name, panorama(walls)) },
    };
    vec![
        room("left room", Vec3::new(-1.0, 0.6, 0.1), 0.4, Vec3::new(1.6, 1.2, 1.5)),
        room("right room", Vec3::new(0.9, 0.7, -0.2), -0.2, Vec3::new(1.3, 1.0, 1.2)),
    ]
}

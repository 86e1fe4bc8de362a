//! The camera and the lights that a file without them gets.

use ontile::glam::{Mat4, Vec3, Vec4};
use ontile::scene::{LightKind, Projection, Scene};
use serde_json::json;

use crate::gltf_build::Gltf;

/// A triangle whose bounds are these.
fn spanning(min: [f32; 3], max: [f32; 3]) -> Scene {
    let mut file = Gltf::triangle();
    let mid = [0, 1, 2].map(|i| (min[i] + max[i]) * 0.5);
    let positions = file.floats("VEC3", &[min, max, mid].concat());
    *file.at("/meshes/0/primitives/0/attributes/POSITION") = json!(positions);
    file.load().unwrap()
}

/// The range that the corners of the bounds take in clip space, after division: x, y and depth.
fn framed(scene: &Scene, aspect: f32) -> (Vec3, Vec3) {
    let camera = &scene.cameras[0];
    let clip_from_view = camera.projection.clip_from_view(aspect).as_dmat4();
    let clip_from_world = clip_from_view * camera.world_from_view.as_dmat4().inverse();
    let bounds = scene.bounds_world().unwrap();
    let corners = (0..8).map(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        clip_from_world.project_point3(Vec3::new(pick(0), pick(1), pick(2)).as_dvec3()).as_vec3()
    });
    corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
}

#[test]
fn the_default_camera_frames_scenes_of_all_shapes() {
    let shapes = [
        ("cube", [-1.0; 3], [1.0; 3]),
        ("tiny", [-1e-6; 3], [1e-6; 3]),
        ("huge", [-1e9; 3], [1e9; 3]),
        ("floor", [-5.0, 0.0, -5.0], [5.0, 0.0, 5.0]),
        ("wall", [-5.0, -5.0, 0.0], [5.0, 5.0, 0.0]),
        ("side wall", [0.0, -5.0, -5.0], [0.0, 5.0, 5.0]),
        ("line", [-5.0, 0.0, 0.0], [5.0, 0.0, 0.0]),
        ("tower", [-0.1, 0.0, -0.1], [0.1, 50.0, 0.1]),
        ("far away", [1000.0, 1000.0, 1000.0], [1001.0, 1002.0, 1003.0]),
    ];
    for (name, min, max) in shapes {
        let scene = spanning(min, max);
        assert_eq!(scene.cameras.len(), 1);
        assert_eq!(scene.cameras[0].name, "default");
        for aspect in [1.0, 16.0 / 9.0] {
            let (low, high) = framed(&scene, aspect);
            let widest = low.abs().max(high.abs());
            assert!(widest.x <= 1.0 && widest.y <= 1.0, "{name} at {aspect}: {low} to {high}");
            assert!(low.z > 0.0 && high.z < 1.0, "{name} at {aspect}: depths {low} to {high}");
            if aspect == 1.0 {
                assert!(widest.x.max(widest.y) > 0.7, "{name}: fills too little, {low} to {high}");
            }
        }
        let Projection::Perspective { yfov_rad, .. } = scene.cameras[0].projection else { panic!() };
        assert!((yfov_rad.to_degrees() - 45.0).abs() < 1e-4);
        let back = scene.cameras[0].world_from_view.z_axis;
        assert!(back.x > 0.1 && back.z > back.x && back.y > 0.1 && back.y < back.x, "{back}");
    }
}

#[test]
fn a_scene_of_one_point_still_has_a_camera() {
    let scene = spanning([3.0; 3], [3.0; 3]);
    let (low, high) = framed(&scene, 1.0);
    assert!(low.is_finite() && low.z > 0.0 && high.z < 1.0, "{low} to {high}");
    let empty = Gltf::empty().load().unwrap();
    assert_eq!(empty.cameras[0].name, "default");
    assert!(empty.lights.is_empty() && empty.warnings.iter().any(|w| w.contains("nothing is drawn")));
}

#[test]
fn default_lights_follow_camera_0() {
    let mut file = Gltf::triangle();
    file.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}));
    // Looking along -X: right is -Z.
    let s = std::f32::consts::FRAC_1_SQRT_2;
    file.root_node(json!({"camera": 0, "rotation": [0.0, s, 0.0, s]}));
    let scene = file.load().unwrap();
    let view_from_world: Mat4 = scene.cameras[0].world_from_view.inverse();
    let kinds: Vec<_> = scene.lights.iter().map(|l| l.kind).collect();
    let directional = |illuminance_lx| LightKind::Directional { illuminance_lx };
    assert_eq!(kinds, [directional(3.0), directional(0.8)]);
    let towards: Vec<Vec3> = scene
        .lights
        .iter()
        .map(|l| -(view_from_world * Vec4::from((l.direction_world, 0.0))).truncate())
        .collect();
    let (key, fill) = (towards[0], towards[1]);
    assert!(key.x > 0.0 && key.y > 0.0 && key.z > 0.0, "over the right shoulder: {key}");
    assert!(fill.x < 0.0 && fill.y < 0.0, "from the lower left: {fill}");
    assert!(key.is_normalized() && fill.is_normalized());
    assert!(scene.warnings.iter().any(|w| w.contains("no lights")), "{:?}", scene.warnings);
}

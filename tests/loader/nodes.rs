//! The node tree, cameras and lights.

use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use ontile::glam::{Mat4, Quat, Vec3};
use ontile::scene::{LightKind, Projection};
use serde_json::json;

use crate::gltf_build::Gltf;
use crate::{F32_ROUNDING, close};

/// A quarter turn about +Y as glTF's x, y, z, w.
const QUARTER_TURN_Y: [f32; 4] = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];

#[test]
fn transforms_chain_as_trs_or_matrix() {
    let mut file = Gltf::triangle();
    *file.at("/nodes/0") =
        json!({"mesh": 0, "translation": [1, 2, 3], "rotation": QUARTER_TURN_Y, "scale": [2, 3, 4]});
    let parent = Mat4::from_translation(Vec3::new(0.0, 10.0, 0.0));
    let root = file.push("nodes", json!({"matrix": parent.to_cols_array(), "children": [0]}));
    file.json["scenes"][0]["nodes"] = json!([root]);
    let world = file.load().unwrap().instances[0].world_from_object;
    // A quarter turn about Y takes X to -Z and Z to X.
    assert!(close(world.transform_point3(Vec3::ZERO), [1.0, 12.0, 3.0]));
    assert!(close(world.transform_vector3(Vec3::X), [0.0, 0.0, -2.0]));
    assert!(close(world.transform_vector3(Vec3::Y), [0.0, 3.0, 0.0]));
    assert!(close(world.transform_vector3(Vec3::Z), [4.0, 0.0, 0.0]));
}

#[test]
fn negative_scales_mirror_and_zero_ones_are_left_out() {
    let mut file = Gltf::triangle();
    file.root_node(json!({"mesh": 0, "scale": [1, -1, 1]}));
    file.root_node(json!({"mesh": 0, "scale": [1, 0, 1]}));
    let scene = file.load().unwrap();
    assert_eq!(scene.instances.iter().map(|i| i.is_mirrored()).collect::<Vec<_>>(), [false, true]);
    assert_eq!(scene.meshes.len(), 1, "instances share their mesh");
    assert!(scene.warnings.iter().any(|w| w.starts_with("nodes[2]")), "{:?}", scene.warnings);
}

#[test]
fn only_the_default_scene_is_drawn() {
    let mut file = Gltf::triangle();
    let other = file.push("nodes", json!({"mesh": 0, "translation": [5, 0, 0]}));
    file.push("scenes", json!({"nodes": [other]}));
    let x = |file: &Gltf| {
        let scene = file.load().unwrap();
        scene.instances.iter().map(|i| i.world_from_object.w_axis.x).collect::<Vec<_>>()
    };
    assert_eq!(x(&file), [0.0]);
    file.json["scene"] = json!(1);
    assert_eq!(x(&file), [5.0]);
    file.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(x(&file), [0.0], "scene 0");
    file.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(x(&file), [0.0, 5.0], "all roots");
}

#[test]
fn cameras_lose_their_scale() {
    let mut file = Gltf::triangle();
    file.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.25}}));
    file.push(
        "cameras",
        json!({"name": "flat", "type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "znear": 0, "zfar": 9}}),
    );
    file.root_node(json!({"name": "eye", "camera": 0, "translation": [1, 2, 3], "rotation": QUARTER_TURN_Y, "scale": [2, 3, -4]}));
    file.root_node(json!({"camera": 1}));
    let cameras = file.load().unwrap().cameras;
    let names: Vec<_> = cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["eye", "flat"]);
    let axes = cameras[0].world_from_view;
    assert!((axes.determinant() - 1.0).abs() < F32_ROUNDING, "a rotation, not a reflection");
    assert!(close(axes.transform_vector3(Vec3::Y), [0.0, 1.0, 0.0]));
    // The node's +Z is -X once its scale has turned it round.
    assert!(close(axes.transform_vector3(Vec3::Z), [-1.0, 0.0, 0.0]));
    assert!(close(axes.w_axis.truncate(), [1.0, 2.0, 3.0]));
    assert_eq!(cameras[0].projection, Projection::Perspective { yfov_rad: 0.5, znear_m: 0.25, zfar_m: None });
    let flat = Projection::Orthographic { xmag_m: 3.0, ymag_m: 2.0, znear_m: 0.0, zfar_m: 9.0 };
    assert_eq!(cameras[1].projection, flat);
}

#[test]
fn lights_of_all_kinds() {
    let mut file = Gltf::triangle();
    *file.at("/extensions") = json!({"KHR_lights_punctual": {"lights": [
        {"type": "directional", "intensity": 5, "color": [1, 0.5, 0.25], "name": "sun", "extras": {"a": 1}},
        {"type": "point", "range": 7},
        {"type": "spot", "intensity": 2, "spot": {"innerConeAngle": 0.25, "outerConeAngle": FRAC_PI_2}},
        {"type": "spot", "spot": {}},
    ]}});
    let turned = Quat::from_rotation_x(-FRAC_PI_2).to_array();
    for light in 0..4 {
        file.root_node(json!({
            "extensions": {"KHR_lights_punctual": {"light": light}},
            "translation": [light, 0, 0],
            "rotation": turned,
            "scale": [3, 3, 3],
        }));
    }
    let scene = file.load().unwrap();
    let kinds: Vec<_> = scene.lights.iter().map(|l| l.kind).collect();
    assert_eq!(
        kinds,
        [
            LightKind::Directional { illuminance_lx: 5.0 },
            LightKind::Point { intensity_cd: 1.0 },
            LightKind::Spot { intensity_cd: 2.0, inner_cone_rad: 0.25, outer_cone_rad: FRAC_PI_2 },
            LightKind::Spot {
                intensity_cd: 1.0,
                inner_cone_rad: 0.0,
                outer_cone_rad: std::f32::consts::FRAC_PI_4
            },
        ]
    );
    assert_eq!(scene.lights[0].name, "sun");
    assert_eq!(scene.lights[0].color, Vec3::new(1.0, 0.5, 0.25));
    assert_eq!(scene.lights.iter().map(|l| l.range_m).collect::<Vec<_>>(), [None, Some(7.0), None, None]);
    for (i, light) in scene.lights.iter().enumerate() {
        // A turn of -90 degrees about X takes -Z to -Y.
        assert!(close(light.direction_world, [0.0, -1.0, 0.0]), "{light:?}");
        assert!(close(light.position_world, [i as f32, 0.0, 0.0]), "{light:?}");
    }
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

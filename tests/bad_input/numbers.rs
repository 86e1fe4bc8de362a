//! Numbers out of range.

use serde_json::json;

use crate::gltf_build::Gltf;
use crate::{check, expect_input_error, lit_by, poke, set};

#[test]
fn numbers_that_are_not() {
    check(&[
        (
            "NaN position",
            |f| poke(f, 0, 4, f32::NAN),
            "meshes[0].primitives[0].attributes.POSITION",
            "element 1 of accessors[0]",
        ),
        (
            "infinite normal",
            |f| poke(f, 1, 8, f32::INFINITY),
            "meshes[0].primitives[0].attributes.NORMAL",
            "element 2 of accessors[1]",
        ),
        (
            "translation",
            |f| set(f, "/nodes/0/translation", json!([0.0, 1e39, 0.0])),
            "nodes[0].translation",
            "finite",
        ),
        ("quaternion", |f| set(f, "/nodes/0/rotation", json!([0, 0, 0, 0])), "nodes[0].rotation", "length 0"),
        ("matrix", |f| set(f, "/nodes/0/matrix", json!(vec![1e300; 16])), "nodes[0].matrix", "finite"),
        (
            "projective matrix",
            |f| set(f, "/nodes/0/matrix", json!(vec![1.0; 16])),
            "nodes[0].matrix",
            "last row",
        ),
        (
            "base colour",
            |f| set(f, "/materials/0/pbrMetallicRoughness/baseColorFactor", json!([1, 1e39, 1, 1])),
            "materials[0].pbrMetallicRoughness.baseColorFactor",
            "finite",
        ),
        (
            "roughness",
            |f| set(f, "/materials/0/pbrMetallicRoughness/roughnessFactor", json!(1e39)),
            "materials[0].pbrMetallicRoughness.roughnessFactor",
            "finite",
        ),
        (
            "emission",
            |f| set(f, "/materials/0/emissiveFactor", json!([0, 0, 1e39])),
            "materials[0].emissiveFactor",
            "finite",
        ),
        ("weights", |f| set(f, "/nodes/0/weights", json!([1e39])), "nodes[0].weights", "finite"),
        ("too far", |f| set(f, "/nodes/0/translation", json!([1e20, 0, 0])), "nodes", "beyond"),
        ("chain", |f| set(f, "/nodes/0/scale", json!([1e38, 1e38, 1e38])), "nodes", "beyond"),
    ]);
}

#[test]
fn lights_and_cameras() {
    const LIGHT: &str = "extensions.KHR_lights_punctual.lights[0]";
    let spot = |inner: f64, outer: f64| json!({"type": "spot", "spot": {"innerConeAngle": inner, "outerConeAngle": outer}});
    for (light, field, problem) in [
        (json!({"type": "point", "intensity": 1e39}), "intensity", "finite"),
        (json!({"type": "point", "intensity": -1}), "intensity", "negative"),
        (json!({"type": "point", "color": [1, -1, 1]}), "color", "negative"),
        (json!({"type": "point", "range": 0}), "range", "above 0"),
        (json!({"type": "spot"}), "spot", "missing"),
        (json!({"type": "area"}), "type", "does not define"),
        (spot(0.5, 0.5), "spot", "inner < outer"),
        (spot(-0.1, 0.5), "spot", "inner < outer"),
        (spot(0.1, 1.6), "spot", "pi / 2"),
    ] {
        let mut file = Gltf::triangle();
        lit_by(&mut file, light.clone());
        expect_input_error(&light.to_string(), file.load(), &format!("{LIGHT}.{field}"), problem);
    }
    let perspective = |yfov: f64, near: f64, far: f64| json!({"type": "perspective", "perspective": {"yfov": yfov, "znear": near, "zfar": far}});
    let orthographic = |xmag: f64, ymag: f64, near: f64, far: f64| json!({"type": "orthographic", "orthographic": {"xmag": xmag, "ymag": ymag, "znear": near, "zfar": far}});
    for (camera, field) in [
        (perspective(0.0, 0.1, 1.0), "perspective.yfov"),
        (perspective(3.2, 0.1, 1.0), "perspective.yfov"),
        (perspective(1.0, 0.0, 1.0), "perspective.znear"),
        (perspective(1.0, 0.1, 0.1), "perspective.zfar"),
        (orthographic(0.0, 1.0, 0.0, 1.0), "orthographic.xmag"),
        (orthographic(1.0, -1.0, 0.0, 1.0), "orthographic.ymag"),
        (orthographic(1.0, 1.0, -0.5, 1.0), "orthographic.znear"),
        (orthographic(1.0, 1.0, 1.0, 1.0), "orthographic.zfar"),
        (json!({"type": "perspective"}), "perspective"),
        (json!({"type": "fisheye"}), "type"),
    ] {
        let mut file = Gltf::triangle();
        file.push("cameras", camera.clone());
        set(&mut file, "/nodes/0/camera", json!(0));
        expect_input_error(&camera.to_string(), file.load(), &format!("cameras[0].{field}"), "");
    }
}

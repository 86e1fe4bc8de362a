//! Compressed buffer views.

use serde_json::{Value, json};

use crate::gltf_build::Gltf;
use crate::{check, expect_input_error, set};

const EXTENSION: &str = "KHR_meshopt_compression";

/// The triangle's indices as codes: accessor 3 has view 3, whose bytes are in a fallback that has none.
fn compressed(file: &mut Gltf) {
    let codes = [0xd1, 0, 4, 4, 0, 0, 0, 0];
    let view = file.view(&codes);
    let offset = file.json["bufferViews"][view]["byteOffset"].clone();
    let length = file.bin.len();
    set(
        file,
        "/buffers",
        json!([{"byteLength": length}, {"byteLength": 6, "extensions": {EXTENSION: {"fallback": true}}}]),
    );
    let said = json!({"buffer": 0, "byteOffset": offset, "byteLength": codes.len(), "byteStride": 2, "count": 3, "mode": "INDICES"});
    set(file, "/bufferViews/3", json!({"buffer": 1, "byteLength": 6, "extensions": {EXTENSION: said}}));
    set(file, "/extensionsRequired", json!([EXTENSION]));
}

fn said(file: &mut Gltf, field: &str, value: Value) {
    compressed(file);
    set(file, &format!("/bufferViews/3/extensions/{EXTENSION}/{field}"), value);
}

#[test]
fn compressed_views() {
    let mut file = Gltf::triangle();
    compressed(&mut file);
    assert_eq!(file.load().unwrap().meshes[0].indices, [0, 1, 2]);
    const AT: &str = "bufferViews[3].extensions.KHR_meshopt_compression";
    for (field, value, element, problem) in [
        ("mode", json!("POINTS"), "mode", "'POINTS'"),
        ("filter", json!("COLOR"), "filter", "'COLOR' is none that INDICES"),
        ("byteStride", json!(3), "byteStride", "one of [2, 4]"),
        ("count", json!(0), "count", "is 0"),
        ("count", json!(4), "count", "4 elements of 2 bytes, but the view has 6"),
        ("count", json!(u64::MAX), "count", "but the view has 6"),
        ("byteLength", json!(7), "byteLength", "too short"),
        ("byteLength", json!(3), "byteLength", "padding"),
        ("mode", json!("TRIANGLES"), "byteLength", "begins with 0xd1"),
        ("mode", json!("ATTRIBUTES"), "byteStride", "a multiple of 4"),
    ] {
        let mut file = Gltf::triangle();
        said(&mut file, field, value);
        expect_input_error(field, file.load(), &format!("{AT}.{element}"), problem);
    }
    check(&[
        ("beyond", |f| said(f, "byteOffset", json!(1 << 20)), AT, "lie beyond"),
        (
            "no such buffer",
            |f| said(f, "buffer", json!(7)),
            "bufferViews[3].extensions.KHR_meshopt_compression.buffer",
            "buffers[7]",
        ),
        ("codes in a fallback", |f| said(f, "buffer", json!(1)), "buffers[1]", "a fallback without bytes"),
        (
            "a fallback that is needed",
            |f| {
                compressed(f);
                f.json["bufferViews"][3].as_object_mut().unwrap().remove("extensions");
            },
            "buffers[1]",
            "needed by bufferViews[3].buffer",
        ),
        (
            "more than anything has",
            |f| {
                said(f, "count", json!(1_u64 << 40));
                set(f, "/bufferViews/3/byteLength", json!(1_u64 << 41));
            },
            AT,
            "more than 2147483648 bytes",
        ),
    ]);
}

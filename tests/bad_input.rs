//! Broken glTF files: a clear error for each kind, and never a panic.

#[path = "common/gltf_build.rs"]
#[allow(dead_code, reason = "each test file uses some of this")]
mod gltf_build;

use gltf_build::{F32, Gltf, U8, U16, data_uri, floats, load_bytes, png, shorts, write};
use ontile::Error;
use proptest::prelude::*;
use serde_json::{Value, json};

/// A case: what is wrong, the change to the triangle, the element to blame, a part of the problem.
type Case = (&'static str, fn(&mut Gltf), &'static str, &'static str);

/// The base of all cases loads; with the change it must not, for the reason given and no other.
fn check(cases: &[Case]) {
    Gltf::triangle().load().expect("the base file is valid");
    for &(name, change, element, problem) in cases {
        let mut file = Gltf::triangle();
        change(&mut file);
        expect_input_error(name, file.load(), element, problem);
    }
}

fn expect_input_error(name: &str, got: ontile::Result<ontile::scene::Scene>, element: &str, problem: &str) {
    let error = match got {
        Ok(_) => panic!("{name}: loads"),
        Err(error) => error,
    };
    let message = error.to_string();
    let Error::Input { path, element: found, problem: why, remedy } = error else {
        panic!("{name}: not an input error: {message}")
    };
    assert_eq!(found, element, "{name}: {message}");
    assert!(why.contains(problem), "{name}: {message}");
    assert!(remedy.len() > 5, "{name}: no remedy: {message}");
    assert!(message.contains(path.to_str().unwrap()), "{name}: the file is not named: {message}");
    assert!(message.contains(&remedy), "{name}: the remedy is not told: {message}");
}

fn set(file: &mut Gltf, pointer: &str, value: Value) {
    *file.at(pointer) = value;
}

/// Replaces the float at `index` of the accessor with the same number as its view.
fn poke(file: &mut Gltf, view: usize, index: usize, value: f32) {
    let offset = file.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize + index * 4;
    file.bin[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
}

fn textured(file: &mut Gltf, encoded: &[u8]) {
    let texture = file.texture(encoded);
    set(file, "/materials/0/pbrMetallicRoughness/baseColorTexture", json!({"index": texture}));
}

fn lit_by(file: &mut Gltf, light: Value) {
    set(file, "/extensions", json!({"KHR_lights_punctual": {"lights": [light]}}));
    set(file, "/nodes/0/extensions", json!({"KHR_lights_punctual": {"light": 0}}));
}

/// A skin of one joint (node 1) for the triangle.
fn skinned(file: &mut Gltf) {
    let joints = file.accessor(&[0; 12], U8, "VEC4", 3);
    let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3));
    set(file, "/meshes/0/primitives/0/attributes/JOINTS_0", json!(joints));
    set(file, "/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(weights));
    let joint = file.root_node(json!({}));
    file.push("skins", json!({"joints": [joint]}));
    set(file, "/nodes/0/skin", json!(0));
}

#[test]
fn versions_and_extensions() {
    check(&[
        ("glTF 1.0", |f| set(f, "/asset/version", json!("1.0")), "asset.version", "1.0"),
        ("newer", |f| set(f, "/asset/minVersion", json!("2.1")), "asset.version", "2.1"),
        ("no version", |f| set(f, "/asset", json!({})), "asset.version", "missing"),
        (
            "unknown extension",
            |f| set(f, "/extensionsRequired", json!(["KHR_lights_punctual", "ACME_x"])),
            "extensionsRequired[1]",
            "ACME_x",
        ),
    ]);
    for (extension, remedy) in [
        ("KHR_draco_mesh_compression", "without Draco"),
        ("EXT_meshopt_compression", "without meshopt"),
        ("KHR_texture_basisu", "PNG or JPEG"),
    ] {
        let mut file = Gltf::triangle();
        set(&mut file, "/extensionsRequired", json!([extension]));
        let message = file.load().unwrap_err().to_string();
        assert!(message.contains(extension) && message.contains(remedy), "{message}");
    }
}

#[test]
fn json_that_is_not_gltf() {
    check(&[
        ("wrong type", |f| set(f, "/nodes/0/mesh", json!("zero")), "nodes[0]", "invalid type"),
        ("negative index", |f| set(f, "/nodes/0/mesh", json!(-1)), "nodes[0]", "invalid value"),
        (
            "missing count",
            |f| {
                f.json["accessors"][2].as_object_mut().unwrap().remove("count");
            },
            "accessors[2]",
            "count",
        ),
    ]);
    let truncated = &Gltf::triangle().to_gltf()[..100];
    expect_input_error("cut JSON", load_bytes("a.gltf", truncated), "JSON line 1 column 100", "EOF");
    expect_input_error("empty", load_bytes("a.gltf", b""), "JSON line 1 column 0", "EOF");
    expect_input_error("binary", load_bytes("a.gltf", b"\xff\xd8\xff"), "JSON line 1 column 1", "expected");
}

#[test]
fn indices_out_of_range() {
    const PRIMITIVE: &str = "/meshes/0/primitives/0";
    check(&[
        ("scene", |f| set(f, "/scene", json!(1)), "scene", "scenes[1], but there are 1"),
        ("root", |f| set(f, "/scenes/0/nodes/0", json!(5)), "scenes[0].nodes[0]", "nodes[5]"),
        ("child", |f| set(f, "/nodes/0/children", json!([9])), "nodes[0].children[0]", "nodes[9]"),
        ("mesh", |f| set(f, "/nodes/0/mesh", json!(1)), "nodes[0].mesh", "meshes[1]"),
        ("camera", |f| set(f, "/nodes/0/camera", json!(0)), "nodes[0].camera", "there are 0"),
        ("skin", |f| set(f, "/nodes/0/skin", json!(0)), "nodes[0].skin", "there are 0"),
        (
            "light",
            |f| set(f, "/nodes/0/extensions", json!({"KHR_lights_punctual": {"light": 0}})),
            "nodes[0].extensions.KHR_lights_punctual.light",
            "there are 0",
        ),
        (
            "material",
            |f| set(f, "/meshes/0/primitives/0/material", json!(1)),
            "meshes[0].primitives[0].material",
            "materials[1]",
        ),
        (
            "attribute",
            |f| set(f, &format!("{PRIMITIVE}/attributes/NORMAL"), json!(44)),
            "meshes[0].primitives[0].attributes.NORMAL",
            "accessors[44]",
        ),
        (
            "indices",
            |f| set(f, &format!("{PRIMITIVE}/indices"), json!(44)),
            "meshes[0].primitives[0].indices",
            "accessors[44]",
        ),
        (
            "view",
            |f| set(f, "/accessors/0/bufferView", json!(8)),
            "accessors[0].bufferView",
            "bufferViews[8]",
        ),
        ("buffer", |f| set(f, "/bufferViews/0/buffer", json!(1)), "bufferViews[0].buffer", "buffers[1]"),
        (
            "texture",
            |f| set(f, "/materials/0/normalTexture", json!({"index": 3})),
            "materials[0].normalTexture.index",
            "textures[3]",
        ),
        (
            "image",
            |f| {
                textured(f, &png(1, 1, &[0; 4]));
                set(f, "/textures/0/source", json!(2));
            },
            "textures[0].source",
            "images[2]",
        ),
        (
            "sampler",
            |f| {
                textured(f, &png(1, 1, &[0; 4]));
                set(f, "/textures/0/sampler", json!(0));
            },
            "textures[0].sampler",
            "samplers[0]",
        ),
        (
            "joint node",
            |f| {
                skinned(f);
                set(f, "/skins/0/joints/0", json!(7));
            },
            "skins[0].joints[0]",
            "nodes[7]",
        ),
    ]);
}

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
        ("matrix", |f| set(f, "/nodes/0/matrix", json!([1e300; 16])), "nodes[0].matrix", "finite"),
        ("projective matrix", |f| set(f, "/nodes/0/matrix", json!([1.0; 16])), "nodes[0].matrix", "last row"),
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

#[test]
fn node_graphs_that_are_not_trees() {
    check(&[
        ("own child", |f| set(f, "/nodes/0/children", json!([0])), "nodes[0]", "own ancestor"),
        (
            "cycle beside the scene",
            |f| {
                f.push("nodes", json!({"children": [2]}));
                f.push("nodes", json!({"children": [1]}));
            },
            "nodes[1]",
            "own ancestor",
        ),
        (
            "two parents",
            |f| {
                f.push("nodes", json!({"children": [2]}));
                f.push("nodes", json!({}));
                set(f, "/nodes/0/children", json!([2]));
            },
            "nodes[1].children[0]",
            "already is a child of nodes[0]",
        ),
        (
            "root with a parent",
            |f| {
                f.push("nodes", json!({}));
                set(f, "/nodes/0/children", json!([1]));
                set(f, "/scenes/0/nodes", json!([0, 1]));
            },
            "scenes[0].nodes[1]",
            "not a root",
        ),
    ]);
}

#[test]
fn a_chain_of_many_nodes_neither_overflows_the_stack_nor_hangs() {
    const LENGTH: usize = 200_000;
    let mut file = Gltf::triangle();
    let nodes: Vec<_> =
        (1..LENGTH).map(|child| json!({"children": [child], "translation": [1, 0, 0]})).collect();
    file.json["nodes"] = json!(nodes);
    file.push("nodes", json!({"mesh": 0}));
    let scene = file.load().unwrap();
    assert_eq!(scene.instances[0].world_from_object.w_axis.x, (LENGTH - 1) as f32);
}

#[test]
fn accessors() {
    const POSITION: &str = "meshes[0].primitives[0].attributes.POSITION";
    check(&[
        ("beyond view", |f| set(f, "/accessors/0/byteOffset", json!(4)), "accessors[0]", "needs 36 bytes"),
        ("offset overflow", |f| set(f, "/accessors/0/byteOffset", json!(u64::MAX)), "accessors[0]", "needs"),
        ("stride", |f| set(f, "/bufferViews/0/byteStride", json!(16)), "accessors[0]", "needs 44 bytes"),
        (
            "short stride",
            |f| set(f, "/bufferViews/0/byteStride", json!(4)),
            "bufferViews[0].byteStride",
            "12 bytes",
        ),
        (
            "zero stride",
            |f| set(f, "/bufferViews/0/byteStride", json!(0)),
            "bufferViews[0].byteStride",
            "12 bytes",
        ),
        (
            "view beyond buffer",
            |f| set(f, "/bufferViews/0/byteLength", json!(4000)),
            "bufferViews[0]",
            "beyond",
        ),
        (
            "view overflow",
            |f| set(f, "/bufferViews/0/byteOffset", json!(u64::MAX)),
            "bufferViews[0]",
            "beyond",
        ),
        ("component", |f| set(f, "/accessors/0/componentType", json!(U16)), POSITION, "U16 Vec3"),
        (
            "unknown component",
            |f| set(f, "/accessors/0/componentType", json!(1)),
            "accessors[0].componentType",
            "",
        ),
        ("type", |f| set(f, "/accessors/0/type", json!("VEC2")), POSITION, "F32 Vec2"),
        (
            "unknown type",
            |f| set(f, "/accessors/0/type", json!("VEC9")),
            "accessors[0].type",
            "does not define",
        ),
        (
            "float indices",
            |f| set(f, "/accessors/3/componentType", json!(F32)),
            "meshes[0].primitives[0].indices",
            "F32 Scalar",
        ),
        (
            "plain integer coordinates",
            |f| {
                let texcoords = f.accessor(&shorts(&[0; 6]), U16, "VEC2", 3);
                set(f, "/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(texcoords));
                textured(f, &png(1, 1, &[0; 4]));
            },
            "meshes[0].primitives[0].attributes.TEXCOORD_0",
            "U16 Vec2",
        ),
        (
            "counts differ",
            |f| set(f, "/accessors/1/count", json!(2)),
            "meshes[0].primitives[0].attributes.NORMAL",
            "has 2 elements, but POSITION has 3",
        ),
        (
            "no elements",
            |f| ["0", "1", "2"].map(|i| set(f, &format!("/accessors/{i}/count"), json!(0))).into(),
            "accessors[0].count",
            "is 0",
        ),
        (
            "absurd count",
            |f| ["0", "1", "2"].map(|i| set(f, &format!("/accessors/{i}/count"), json!(1u64 << 60))).into(),
            "meshes[0].primitives[0]",
            "more than",
        ),
        (
            "absurd count without a view",
            |f| {
                let big = 50_000_000;
                f.push("accessors", json!({"componentType": F32, "type": "VEC3", "count": big}));
                set(f, "/meshes/0/primitives/0/attributes", json!({"POSITION": 4}));
            },
            "accessors[4].count",
            "outside",
        ),
        (
            "absurd number of indices",
            |f| set(f, "/accessors/3/count", json!(100_000_000)),
            "accessors[3]",
            "needs 200000000 bytes",
        ),
        (
            "no positions",
            |f| set(f, "/meshes/0/primitives/0/attributes", json!({"NORMAL": 1})),
            POSITION,
            "missing",
        ),
        (
            "mode",
            |f| set(f, "/meshes/0/primitives/0/mode", json!(7)),
            "meshes[0].primitives[0].mode",
            "define",
        ),
        (
            "index beyond vertices",
            |f| {
                let end = f.bin.len();
                f.bin[end - 2] = 3;
            },
            "meshes[0].primitives[0].indices",
            "index 2 is 3, but there are 3 vertices",
        ),
        (
            "sparse index",
            |f| {
                let (indices, values) = (f.view(&[3]), f.view(&floats(&[0.0; 3])));
                let sparse = json!({"count": 1, "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
                set(f, "/accessors/0/sparse", sparse);
            },
            "accessors[0].sparse.indices",
            "element 3 of 3",
        ),
        (
            "sparse values",
            |f| {
                let (indices, values) = (f.view(&[1]), f.view(&floats(&[0.0; 2])));
                let sparse = json!({"count": 1, "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
                set(f, "/accessors/0/sparse", sparse);
            },
            "accessors[0].sparse.values",
            "needs 12 bytes",
        ),
        (
            "sparse count",
            |f| {
                let view = f.view(&[0; 64]);
                let sparse = json!({"count": 4, "indices": {"bufferView": view, "componentType": U8}, "values": {"bufferView": view}});
                set(f, "/accessors/0/sparse", sparse);
            },
            "accessors[0].sparse.count",
            "is 4",
        ),
    ]);
}

#[test]
fn skins_and_morph_targets() {
    let mut valid = Gltf::triangle();
    skinned(&mut valid);
    valid.load().expect("the skinned triangle is valid");
    check(&[
        (
            "joint",
            |f| {
                skinned(f);
                let view = f.json["accessors"][4]["bufferView"].as_u64().unwrap() as usize;
                let offset = f.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
                f.bin[offset + 4] = 1;
            },
            "meshes[0].primitives[0].attributes.JOINTS_0",
            "vertex 1 uses joint 1, but skins[0] has 1",
        ),
        (
            "inverse bind matrices",
            |f| {
                skinned(f);
                let matrices = f.floats("MAT4", &[0.0; 16]);
                set(f, "/skins/0/inverseBindMatrices", json!(matrices));
                set(f, "/skins/0/joints", json!([1, 1]));
            },
            "skins[0].inverseBindMatrices",
            "1 matrices for 2 joints",
        ),
        (
            "no joints",
            |f| {
                skinned(f);
                set(f, "/skins/0/joints", json!([]));
            },
            "skins[0].joints",
            "empty",
        ),
        (
            "no weights",
            |f| {
                skinned(f);
                let attributes = f.at("/meshes/0/primitives/0/attributes").as_object_mut().unwrap();
                attributes.remove("WEIGHTS_0");
            },
            "meshes[0].primitives[0].attributes.WEIGHTS_0",
            "missing",
        ),
        (
            "weights of zero",
            |f| {
                skinned(f);
                poke(f, 5, 4, 0.0);
            },
            "meshes[0].primitives[0].attributes.WEIGHTS_0",
            "vertex 1 add up to 0",
        ),
        (
            "weights without targets",
            |f| set(f, "/nodes/0/weights", json!([1.0])),
            "meshes[0].primitives[0].targets",
            "has 0 targets, but there are 1 weights",
        ),
        (
            "target count",
            |f| {
                let target = f.floats("VEC3", &[0.0; 6]);
                set(f, "/meshes/0/primitives/0/targets", json!([{"POSITION": target}]));
                set(f, "/meshes/0/weights", json!([1.0]));
            },
            "meshes[0].primitives[0].targets[0].POSITION",
            "2 elements for 3",
        ),
    ]);
}

#[test]
fn files_and_uris() {
    check(&[
        (
            "missing buffer",
            |f| set(f, "/buffers", json!([{"byteLength": 8, "uri": "no.bin"}])),
            "buffers[0].uri",
            "no.bin",
        ),
        (
            "folder",
            |f| set(f, "/buffers", json!([{"byteLength": 8, "uri": "."}])),
            "buffers[0].uri",
            "regular",
        ),
        (
            "scheme",
            |f| set(f, "/buffers", json!([{"byteLength": 8, "uri": "https://a/b"}])),
            "buffers[0].uri",
            "relative",
        ),
        (
            "absolute",
            |f| set(f, "/buffers", json!([{"byteLength": 8, "uri": "/dev/zero"}])),
            "buffers[0].uri",
            "relative",
        ),
        (
            "percent",
            |f| set(f, "/buffers", json!([{"byteLength": 8, "uri": "a%2"}])),
            "buffers[0].uri",
            "hexadecimal",
        ),
        (
            "zero byte",
            |f| set(f, "/buffers", json!([{"byteLength": 8, "uri": "a%00"}])),
            "buffers[0].uri",
            "cannot read",
        ),
        (
            "base64",
            |f| set(f, "/buffers", json!([{"byteLength": 8, "uri": "data:;base64,AA*="}])),
            "buffers[0].uri",
            "base64",
        ),
        (
            "no comma",
            |f| set(f, "/buffers", json!([{"byteLength": 8, "uri": "data:x"}])),
            "buffers[0].uri",
            "comma",
        ),
        (
            "short buffer",
            |f| set(f, "/buffers", json!([{"byteLength": 1000, "uri": data_uri("a/b", &[0; 999])}])),
            "buffers[0]",
            "only 999 bytes",
        ),
        (
            "missing image",
            |f| {
                textured(f, &png(1, 1, &[0; 4]));
                set(f, "/images/0", json!({"uri": "absent.png"}));
            },
            "images[0].uri",
            "absent.png",
        ),
        (
            "image without data",
            |f| {
                textured(f, &png(1, 1, &[0; 4]));
                set(f, "/images/0", json!({}));
            },
            "images[0]",
            "neither",
        ),
        ("unknown image", |f| textured(f, b"RIFF0000WEBPVP8 "), "images[0]", "neither PNG nor JPEG"),
        ("cut image", |f| textured(f, &png(9, 9, &[7; 324])[..60]), "images[0]", "cannot be decoded"),
        (
            "wide image",
            |f| {
                // The size in the header is a lie; its checksum is not.
                let mut bytes = png(1, 1, &[0; 4]);
                bytes[16..20].copy_from_slice(&16385u32.to_be_bytes());
                let checksum = crc32(&bytes[12..29]);
                bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
                textured(f, &bytes);
            },
            "images[0]",
            "",
        ),
        (
            "no source",
            |f| {
                textured(f, &png(1, 1, &[0; 4]));
                f.json["textures"][0].as_object_mut().unwrap().remove("source");
            },
            "textures[0].source",
            "missing",
        ),
        (
            "filter",
            |f| {
                textured(f, &png(1, 1, &[0; 4]));
                f.push("samplers", json!({"minFilter": 1}));
                set(f, "/textures/0/sampler", json!(0));
            },
            "samplers[0].minFilter",
            "does not define",
        ),
        (
            "alpha mode",
            |f| set(f, "/materials/0/alphaMode", json!("DITHER")),
            "materials[0].alphaMode",
            "define",
        ),
    ]);
    let mut no_bin = Gltf::triangle();
    set(&mut no_bin, "/buffers", json!([{"byteLength": 8}, {"byteLength": 8}]));
    set(&mut no_bin, "/bufferViews/0/buffer", json!(1));
    expect_input_error("no BIN", load_bytes("a.glb", &no_bin.to_glb()), "buffers[1]", "neither");
}

/// PNG's checksum (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn glb_containers() {
    let glb = Gltf::triangle().to_glb();
    load_bytes("a.glb", &glb).expect("the base GLB is valid");
    let json_length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let changed = |at: usize, word: u32| {
        let mut glb = glb.clone();
        glb[at..at + 4].copy_from_slice(&word.to_le_bytes());
        glb
    };
    for (name, bytes, element, problem) in [
        ("header", glb[..10].to_vec(), "GLB header", "10 of 12"),
        ("version 1", changed(4, 1), "GLB header.version", "is 1"),
        ("truncated", glb[..glb.len() - 1].to_vec(), "GLB header.length", "truncated"),
        ("only a header", changed(8, 12), "GLB chunk 0", "missing"),
        ("chunk header", changed(8, 16), "GLB chunk 0", "truncated"),
        ("chunk length", changed(12, u32::MAX), "GLB chunk 0", "truncated"),
        ("chunk type", changed(16, 0), "GLB chunk 0", "not the JSON chunk"),
        ("BIN length", changed(20 + json_length, u32::MAX), "GLB chunk 1", "truncated"),
    ] {
        expect_input_error(name, load_bytes("a.glb", &bytes), element, problem);
    }
}

#[test]
fn a_file_that_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let error = ontile::scene::Scene::load(&folder.path().join("no.glb")).unwrap_err();
    assert!(matches!(error, Error::Io { action: "read", .. }), "{error}");
    assert!(error.to_string().contains("no.glb"), "{error}");
    let error = ontile::scene::Scene::load(folder.path()).unwrap_err();
    assert!(error.to_string().contains("not a regular file"), "{error}");
    write(folder.path(), "no.glb", &Gltf::triangle().to_glb());
    ontile::scene::Scene::load(&folder.path().join("no.glb")).unwrap();
}

/// Everything that the loader reads, in one file.
fn rich() -> Gltf {
    let mut file = Gltf::triangle();
    skinned(&mut file);
    textured(&mut file, &png(2, 2, &[9; 16]));
    set(
        &mut file,
        "/materials/0/normalTexture",
        json!({"index": 0, "extensions": {"KHR_texture_transform": {"rotation": 1}}}),
    );
    let target = file.floats("VEC3", &[0.5; 9]);
    set(&mut file, "/meshes/0/primitives/0/targets", json!([{"POSITION": target, "NORMAL": target}]));
    set(&mut file, "/meshes/0/weights", json!([0.5]));
    let (indices, values) = (file.view(&[1]), file.view(&floats(&[3.0; 3])));
    let sparse = json!({"count": 1, "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
    set(&mut file, "/accessors/0/sparse", sparse);
    file.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}));
    file.push("samplers", json!({"minFilter": 9984}));
    set(&mut file, "/textures/0/sampler", json!(0));
    file.root_node(json!({"camera": 0, "mesh": 0, "rotation": [0, 1, 0, 0]}));
    lit_by(&mut file, json!({"type": "spot", "spot": {}}));
    file
}

/// The pointers to all values.
fn pointers(value: &Value, at: String, out: &mut Vec<String>) {
    match value {
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, v)| pointers(v, format!("{at}/{i}"), out))
        }
        Value::Object(map) => map.iter().for_each(|(k, v)| pointers(v, format!("{at}/{k}"), out)),
        _ => {}
    }
    out.push(at);
}

fn replacement() -> impl Strategy<Value = Value> {
    prop_oneof![
        Just(Value::Null),
        Just(json!({})),
        Just(json!([])),
        Just(json!("")),
        Just(json!(true)),
        Just(json!(-1)),
        Just(json!(0)),
        Just(json!(1)),
        Just(json!(0.5)),
        Just(json!(1e38)),
        Just(json!(1e300)),
        Just(json!(u32::MAX)),
        Just(json!(u64::MAX)),
        Just(json!("MAT4")),
        (0..12u32).prop_map(|v| json!(v)),
        (5120..5127u32).prop_map(|v| json!(v)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bytes_never_panic(
        glb in any::<bool>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 1..=255u8), 1..6),
    ) {
        let file = rich();
        let mut bytes = if glb { file.to_glb() } else { file.to_gltf() };
        for (at, flip) in flips {
            let at = at.index(bytes.len());
            bytes[at] ^= flip;
        }
        if let Ok(scene) = load_bytes("a", &bytes) {
            consistent(&scene);
        }
    }

    #[test]
    fn truncated_files_never_panic(glb in any::<bool>(), end in any::<prop::sample::Index>()) {
        let file = rich();
        let bytes = if glb { file.to_glb() } else { file.to_gltf() };
        let _ = load_bytes("a", &bytes[..end.index(bytes.len())]);
    }

    #[test]
    fn replaced_values_never_panic(
        glb in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), replacement()), 1..3),
    ) {
        let mut file = rich();
        for (at, value) in changes {
            let mut all = Vec::new();
            pointers(&file.json, String::new(), &mut all);
            all.retain(|pointer| !pointer.is_empty());
            *file.json.pointer_mut(at.get(&all)).unwrap() = value;
            prop_assume!(file.json.is_object());
        }
        let bytes = if glb { file.to_glb() } else { file.to_gltf() };
        if let Ok(scene) = load_bytes("a", &bytes) {
            consistent(&scene);
        }
    }
}

/// What a scene promises.
fn consistent(scene: &ontile::scene::Scene) {
    assert!(!scene.cameras.is_empty());
    for instance in &scene.instances {
        assert!(instance.mesh < scene.meshes.len());
        assert!(instance.world_from_object.is_finite());
    }
    for mesh in &scene.meshes {
        let (n, material) = (mesh.positions.len(), &scene.materials[mesh.material]);
        assert!(mesh.indices.iter().all(|&i| (i as usize) < n) && mesh.indices.len() % 3 == 0);
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(material.unlit || mesh.normals.len() == n);
        assert!(mesh.normals.iter().all(|v| v.is_normalized()));
        assert!(material.normal_texture.is_none() || mesh.tangents.len() == n);
        assert!(mesh.tangents.iter().all(|t| t.truncate().is_normalized() && t.w.abs() == 1.0));
        for len in [mesh.texcoords[0].len(), mesh.texcoords[1].len(), mesh.colors.len()] {
            assert!(len == 0 || len == n);
        }
    }
    assert!(scene.textures.iter().all(|t| t.image < scene.images.len()));
}

#[test]
fn the_seed_of_the_mutations_is_valid() {
    let scene = rich().load().unwrap();
    consistent(&scene);
    assert_eq!((scene.lights.len(), scene.images.len(), scene.meshes.len()), (1, 1, 2));
}

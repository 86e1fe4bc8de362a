//! Broken glTF files: a clear error for each kind, and never a panic.

mod accessors;
mod environments;
mod extras;
mod files;
#[path = "../common/gltf_build.rs"]
#[allow(dead_code, reason = "each test file uses some of this")]
mod gltf_build;
mod meshopt;
mod mutations;
mod numbers;

use gltf_build::{Gltf, U8, load_bytes, png};
use ontile::Error;
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
    let mut file = Gltf::triangle();
    set(&mut file, "/extensionsRequired", json!(["KHR_draco_mesh_compression"]));
    let message = file.load().unwrap_err().to_string();
    assert!(message.contains("KHR_draco_mesh_compression") && message.contains("without Draco"), "{message}");
}

#[test]
fn json_that_is_not_gltf() {
    check(&[
        ("wrong type", |f| set(f, "/nodes/0/mesh", json!("zero")), "nodes[0]", "invalid type"),
        ("negative index", |f| set(f, "/nodes/0/mesh", json!(-1)), "nodes[0]", "integer `-1`"),
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

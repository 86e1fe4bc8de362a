//! Compressed buffer views. meshopt/make.mjs makes the files; how single streams are decoded is tested beside the decoder.

use std::path::Path;

use ontile::scene::Scene;
use serde_json::{Value, json};

use super::gltf_build::{data_uri, write};

const EXT: &[u8] = include_bytes!("meshopt/packed-ext.glb");
const KHR: &[u8] = include_bytes!("meshopt/packed-khr.glb");
/// What the format's author makes of either.
const DECODED: &[u8] = include_bytes!("meshopt/decoded.bin");

fn load(folder: &Path, name: &str, bytes: &[u8]) -> Scene {
    let scene = Scene::load_moving(&write(folder, name, bytes)).unwrap_or_else(|e| panic!("{name}: {e}"));
    Scene { name: String::new(), ..scene }
}

/// The JSON and the BIN chunk of a GLB.
fn split(glb: &[u8]) -> (Value, &[u8]) {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&glb[20..20 + length]).unwrap(), &glb[28 + length..])
}

/// The same file as a program reads it that knows nothing of compression.
fn plain(glb: &[u8], extension: &str) -> Vec<u8> {
    let (mut json, bin) = split(glb);
    json["buffers"][0]["uri"] = json!(data_uri("a/b", bin));
    json["buffers"][1] = json!({"byteLength": DECODED.len(), "uri": data_uri("a/b", DECODED)});
    for view in json["bufferViews"].as_array_mut().unwrap() {
        view.as_object_mut().unwrap().remove("extensions");
    }
    for list in ["extensionsUsed", "extensionsRequired"] {
        json[list].as_array_mut().unwrap().retain(|name| name != extension);
    }
    let text = json.to_string();
    assert!(!text.contains("meshopt"));
    text.into_bytes()
}

#[test]
fn a_compressed_scene_is_the_plain_one() {
    let folder = tempfile::tempdir().unwrap();
    let plain = load(folder.path(), "plain.gltf", &plain(KHR, "KHR_meshopt_compression"));
    // All that filters are for: turning bones, quantised normals, triangles.
    let motion = plain.motion.as_ref().expect("it moves");
    assert!(!motion.skins.is_empty() && !motion.animations[0].channels.is_empty());
    assert!(plain.meshes.iter().map(|mesh| mesh.indices.len()).sum::<usize>() > 3000);
    let wanted = format!("{plain:?}");
    for (name, bytes) in [("ext.glb", EXT), ("khr.glb", KHR)] {
        let got = format!("{:?}", load(folder.path(), name, bytes));
        let differs = got.bytes().zip(wanted.bytes()).position(|(a, b)| a != b);
        let around =
            |text: &str, at: usize| text.chars().skip(at.saturating_sub(80)).take(160).collect::<String>();
        if let Some(at) = differs {
            panic!("{name}: {}\nfor {}", around(&got, at), around(&wanted, at));
        }
        assert_eq!(got.len(), wanted.len(), "{name}");
    }
}

#[test]
fn codes_count_where_there_is_a_fallback() {
    let folder = tempfile::tempdir().unwrap();
    let (mut json, bin) = split(KHR);
    json["buffers"][0]["uri"] = json!(data_uri("a/b", bin));
    // Wrong on purpose: nothing may read it.
    json["buffers"][1]["uri"] = json!("nowhere.bin");
    json["extensionsRequired"].as_array_mut().unwrap().retain(|name| name != "KHR_meshopt_compression");
    let scene = load(folder.path(), "fallback.gltf", json.to_string().as_bytes());
    assert!(format!("{scene:?}") == format!("{:?}", load(folder.path(), "khr.glb", KHR)));
}

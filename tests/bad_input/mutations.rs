//! Files changed at random: errors are fine, panics and inconsistent scenes are not.

use proptest::prelude::*;
use serde_json::{Value, json};

use crate::gltf_build::{Gltf, U8, floats, load_bytes, png};
use crate::{lit_by, set, skinned, textured};

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
    fn damaged_codes_never_panic(
        khr in any::<bool>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 1..=255u8), 1..20),
    ) {
        let mut bytes = match khr {
            true => include_bytes!("../loader/meshopt/packed-khr.glb").to_vec(),
            false => include_bytes!("../loader/meshopt/packed-ext.glb").to_vec(),
        };
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
            *file.json.pointer_mut(&all[at.index(all.len())]).unwrap() = value;
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

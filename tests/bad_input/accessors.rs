//! Byte ranges, formats and counts.

use serde_json::json;

use crate::gltf_build::{F32, Gltf, U8, U16, floats, png, shorts};
use crate::{check, poke, set, skinned, textured};

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
            |f| (0..3).for_each(|i| set(f, &format!("/accessors/{i}/count"), json!(0))),
            POSITION,
            "no elements",
        ),
        (
            "absurd count",
            |f| (0..3).for_each(|i| set(f, &format!("/accessors/{i}/count"), json!(1u64 << 60))),
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

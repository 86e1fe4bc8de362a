//! Containers, URIs and images.

use ontile::Error;
use serde_json::json;

use crate::gltf_build::{Gltf, data_uri, load_bytes, png, write};
use crate::{check, expect_input_error, set, textured};

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
        (
            "unknown image",
            |f| textured(f, b"GIF89a\x01\0\x01\0"),
            "images[0]",
            "neither PNG nor JPEG nor WebP",
        ),
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
            "limit",
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
    let length = no_bin.bin.len();
    set(&mut no_bin, "/buffers", json!([{"byteLength": length}, {"byteLength": 8}]));
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

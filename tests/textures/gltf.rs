//! glTF files that use them.

use super::gltf_build::{Gltf, png};
use super::{BASIS, stored};
use ontile::scene::Texels;
use serde_json::json;

/// A triangle with a texture whose plain source is a PNG and whose better one is `file`.
fn textured(file: &[u8]) -> Gltf {
    let mut gltf = Gltf::triangle();
    let texture = gltf.texture(&png(1, 1, &[1, 2, 3, 4]));
    let view = gltf.view(file);
    let image = gltf.push("images", json!({"name": "better", "bufferView": view, "mimeType": "image/ktx2"}));
    gltf.json["textures"][texture]["extensions"] = json!({"KHR_texture_basisu": {"source": image}});
    gltf.json["extensionsUsed"] = json!(["KHR_texture_basisu"]);
    *gltf.at("/materials/0/pbrMetallicRoughness") = json!({"baseColorTexture": {"index": texture}});
    gltf
}

#[test]
fn the_extension_is_preferred_to_the_plain_source() {
    for required in [false, true] {
        let mut gltf = textured(BASIS[0].1);
        if required {
            gltf.json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
            gltf.json["textures"][0].as_object_mut().unwrap().remove("source");
        }
        let scene = gltf.load().unwrap();
        assert_eq!((scene.images.len(), scene.images[0].name.as_str()), (1, "better"));
        assert_eq!(stored(&scene.images[0]).levels(), 6);
        assert!(scene.warnings.iter().all(|w| !w.contains("basisu")), "{:?}", scene.warnings);
    }
    // Tools that do not know the extension write the file as the plain source.
    let mut gltf = textured(BASIS[2].1);
    gltf.json["textures"][0] = json!({"source": 1});
    assert!(matches!(gltf.load().unwrap().images[0].texels, Texels::Stored(_)));
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let message = |gltf: Gltf| gltf.load().unwrap_err().to_string();
    let damaged = message(textured(&BASIS[0].1[..200]));
    assert!(damaged.contains("images[1]") && damaged.contains("KTX"), "{damaged}");
    let mut gltf = textured(BASIS[0].1);
    gltf.json["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = json!(7);
    let beyond = message(gltf);
    assert!(beyond.contains("textures[0].extensions.KHR_texture_basisu.source"), "{beyond}");
    let mut gltf = textured(BASIS[0].1);
    gltf.json["textures"][0] = json!({"extensions": {"KHR_texture_basisu": {}}});
    assert!(message(gltf).contains("textures[0].source"));
}

#[test]
fn samplers_say_how_much_anisotropy() {
    let mut gltf = textured(BASIS[0].1);
    gltf.json["textures"][0]["sampler"] = json!(0);
    gltf.json["samplers"] = json!([{"extras": {"ontile": {"anisotropy": 8}}}]);
    assert_eq!(gltf.load().unwrap().textures[0].sampler.max_anisotropy, 8);
    gltf.json["samplers"][0]["extras"]["ontile"]["anisotropy"] = json!(17);
    let message = gltf.load().unwrap_err().to_string();
    assert!(
        message.contains("samplers[0].extras.ontile.anisotropy") && message.contains("1 to 16"),
        "{message}"
    );
}

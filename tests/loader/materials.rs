//! Materials, textures, samplers, images, extensions.

use ontile::glam::{Vec2, Vec3, Vec4};
use ontile::scene::{AlphaMode, Sampler, TextureRef, Transmission, Wrap};
use serde_json::json;

use crate::F32_ROUNDING;
use crate::gltf_build::{Gltf, data_uri, encode, png};

#[test]
fn all_factors_and_five_textures() {
    let mut file = Gltf::triangle();
    for shade in 0..5 {
        file.texture(&png(1, 1, &[shade; 4]));
    }
    file.json["materials"][0] = json!({
        "name": "all",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "baseColorTexture": {"index": 0},
            "metallicFactor": 0.5, "roughnessFactor": 0.6, "metallicRoughnessTexture": {"index": 1},
        },
        "normalTexture": {"index": 2, "scale": -0.7},
        "occlusionTexture": {"index": 3, "strength": 0.8},
        "emissiveTexture": {"index": 4}, "emissiveFactor": [0.25, 0.5, 1.0],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
        "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true,
    });
    let scene = file.load().unwrap();
    let m = &scene.materials[0];
    assert_eq!(m.name, "all");
    assert_eq!(m.base_color_factor, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!((m.metallic_factor, m.roughness_factor), (0.5, 0.6));
    assert_eq!((m.normal_scale, m.occlusion_strength), (-0.7, 0.8));
    assert_eq!(m.emissive_factor, Vec3::new(2.0, 4.0, 8.0));
    assert_eq!(m.alpha_mode, AlphaMode::Mask { cutoff: 0.3 });
    assert!(m.double_sided && !m.unlit);
    let shade = |t: &Option<TextureRef>| scene.images[scene.textures[t.unwrap().texture].image].rgba8()[0];
    assert_eq!(shade(&m.base_color_texture), 0);
    assert_eq!(shade(&m.metallic_roughness_texture), 1);
    assert_eq!(shade(&m.normal_texture), 2);
    assert_eq!(shade(&m.occlusion_texture), 3);
    assert_eq!(shade(&m.emissive_texture), 4);
}

#[test]
fn what_nothing_uses_is_not_read() {
    let mut file = Gltf::triangle();
    file.texture(b"not an image");
    file.push("materials", json!({"name": "unused", "normalTexture": {"index": 0}}));
    // Its factor is zero and the material of the other is unlit.
    *file.at("/materials/0/emissiveTexture") = json!({"index": 0});
    file.push("meshes", json!({"primitives": [{"attributes": {"POSITION": 999}}]}));
    file.push("materials", json!({"extensions": {"KHR_materials_unlit": {}}, "normalTexture": {"index": 0}}));
    let second = json!({"attributes": {"POSITION": 0}, "material": 2});
    file.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(second);
    let scene = file.load().unwrap();
    assert_eq!((scene.meshes.len(), scene.materials.len()), (2, 2));
    assert!(scene.textures.is_empty() && scene.images.is_empty());
}

#[test]
fn alpha_modes() {
    let mut file = Gltf::triangle();
    *file.at("/materials/0/alphaMode") = json!("BLEND");
    let scene = file.load().unwrap();
    assert_eq!(scene.materials[0].alpha_mode, AlphaMode::Blend);
    assert!(!scene.warnings.iter().any(|w| w.contains("alphaMode")), "{:?}", scene.warnings);
    *file.at("/materials/0/alphaMode") = json!("MASK");
    assert_eq!(file.load().unwrap().materials[0].alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
}

#[test]
fn factors_out_of_range_are_clamped_with_a_warning() {
    let mut file = Gltf::triangle();
    *file.at("/materials/0/pbrMetallicRoughness") =
        json!({"roughnessFactor": 2, "baseColorFactor": [-1, 0, 1, 5]});
    let scene = file.load().unwrap();
    assert_eq!(scene.materials[0].roughness_factor, 1.0);
    assert_eq!(scene.materials[0].base_color_factor, Vec4::new(0.0, 0.0, 1.0, 1.0));
    assert_eq!(scene.warnings.iter().filter(|w| w.contains("clamped")).count(), 2);
}

#[test]
fn texture_transforms_of_every_slot() {
    let mut file = Gltf::triangle();
    file.texture(&png(1, 1, &[0; 4]));
    let turned = json!({"index": 0, "extensions": {"KHR_texture_transform": {
        "offset": [0.25, 0.5], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2, 3], "texCoord": 1,
    }}});
    file.json["materials"][0] = json!({
        "pbrMetallicRoughness": {"baseColorTexture": turned, "metallicRoughnessTexture": turned},
        "normalTexture": turned, "occlusionTexture": turned,
        "emissiveTexture": turned, "emissiveFactor": [1, 1, 1],
    });
    let scene = file.load().unwrap();
    let m = &scene.materials[0];
    for slot in [
        &m.base_color_texture,
        &m.metallic_roughness_texture,
        &m.normal_texture,
        &m.occlusion_texture,
        &m.emissive_texture,
    ] {
        let slot = slot.unwrap();
        assert_eq!(slot.texcoord, 1);
        // (1, 1) is scaled to (2, 3), turned counter-clockwise (v points down: right goes up) to (3, -2), moved.
        assert!(slot.uv(Vec2::ONE).abs_diff_eq(Vec2::new(3.25, -1.5), F32_ROUNDING), "{slot:?}");
    }
    assert_eq!(scene.textures.len(), 1);
    *file.at("/materials/0/pbrMetallicRoughness/baseColorTexture") = json!({"index": 0});
    let plain = file.load().unwrap().materials[0].base_color_texture.unwrap();
    assert_eq!((plain.texcoord, plain.uv_from_texcoord), (0, TextureRef::IDENTITY));
}

#[test]
fn a_third_texture_coordinate_set_is_left_out_with_a_warning() {
    let mut file = Gltf::triangle();
    file.texture(&png(1, 1, &[0; 4]));
    *file.at("/materials/0/normalTexture") = json!({"index": 0, "texCoord": 2});
    let scene = file.load().unwrap();
    assert!(scene.materials[0].normal_texture.is_none() && scene.images.is_empty());
    assert!(scene.warnings.iter().any(|w| w.contains("TEXCOORD_2")));
}

#[test]
fn samplers() {
    let sampler = |json| {
        let mut file = Gltf::triangle();
        file.texture(&png(1, 1, &[0; 4]));
        *file.at("/materials/0/pbrMetallicRoughness/baseColorTexture") = json!({"index": 0});
        file.push("samplers", json);
        *file.at("/textures/0/sampler") = json!(0);
        file.load().unwrap().textures[0].sampler
    };
    assert_eq!(sampler(json!({})), Sampler::default());
    let default = Sampler::default();
    assert!(default.mag_linear && default.min_linear && default.mip_linear == Some(true));
    assert!(!sampler(json!({"magFilter": 9728})).mag_linear);
    // glTF's names for OpenGL's values: NEAREST, LINEAR, and X_MIPMAP_Y.
    for (value, min_linear, mip_linear) in [
        (9728, false, None),
        (9729, true, None),
        (9984, false, Some(false)),
        (9985, true, Some(false)),
        (9986, false, Some(true)),
        (9987, true, Some(true)),
    ] {
        let found = sampler(json!({"minFilter": value}));
        assert_eq!((found.min_linear, found.mip_linear), (min_linear, mip_linear), "{value}");
    }
    let found = sampler(json!({"wrapS": 33071, "wrapT": 33648}));
    assert_eq!((found.wrap_u, found.wrap_v), (Wrap::ClampToEdge, Wrap::MirroredRepeat));
}

#[test]
fn images_of_all_kinds_become_rgba8() {
    use image::DynamicImage as D;
    let cases: [(&str, D, [u8; 4]); 5] = [
        ("grey", D::ImageLuma8(image::GrayImage::from_raw(1, 1, vec![9]).unwrap()), [9, 9, 9, 255]),
        (
            "grey, alpha",
            D::ImageLumaA8(image::GrayAlphaImage::from_raw(1, 1, vec![9, 8]).unwrap()),
            [9, 9, 9, 8],
        ),
        ("colour", D::ImageRgb8(image::RgbImage::from_raw(1, 1, vec![1, 2, 3]).unwrap()), [1, 2, 3, 255]),
        (
            "16 bits",
            // 257 * n is exactly n of 255.
            D::ImageRgba16(image::ImageBuffer::from_raw(1, 1, vec![257, 514, 771, 65535]).unwrap()),
            [1, 2, 3, 255],
        ),
        (
            "16-bit grey",
            D::ImageLuma16(image::ImageBuffer::from_raw(1, 1, vec![5140]).unwrap()),
            [20, 20, 20, 255],
        ),
    ];
    for (name, picture, expected) in cases {
        assert_eq!(decoded(&encode(&picture)), expected, "{name}");
    }
    // One red texel of a palette, by hand: colour type 3, one entry, deflate's stored block.
    let mut palette = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8], data: &[u8]| {
        palette.extend((data.len() as u32).to_be_bytes());
        let body = [kind, data].concat();
        palette.extend(&body);
        palette.extend(crc32(&body).to_be_bytes());
    };
    chunk(b"IHDR", &[0, 0, 0, 1, 0, 0, 0, 1, 8, 3, 0, 0, 0]);
    chunk(b"PLTE", &[200, 100, 50]);
    chunk(b"IDAT", &[0x78, 1, 1, 2, 0, 0xfd, 0xff, 0, 0, 0, 2, 0, 1]);
    chunk(b"IEND", &[]);
    assert_eq!(decoded(&palette), [200, 100, 50, 255]);
    let mut jpeg = std::io::Cursor::new(Vec::new());
    let grey = image::RgbImage::from_pixel(8, 8, image::Rgb([128; 3]));
    grey.write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
    let texel = decoded(jpeg.get_ref());
    assert!(texel[..3].iter().all(|v| v.abs_diff(128) <= 2) && texel[3] == 255, "{texel:?}");
}

/// The first texel of an image given as a data URI.
fn decoded(bytes: &[u8]) -> [u8; 4] {
    let mut file = Gltf::triangle();
    file.push("images", json!({"uri": data_uri("image/png", bytes)}));
    file.push("textures", json!({"source": 0}));
    *file.at("/materials/0/pbrMetallicRoughness/baseColorTexture") = json!({"index": 0});
    let image = &file.load().unwrap().images[0];
    assert_eq!(image.rgba8().len(), (image.width * image.height * 4) as usize);
    image.rgba8()[..4].try_into().unwrap()
}

/// PNG's checksum (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn optional_extensions_warn_if_they_change_the_look() {
    let mut file = Gltf::triangle();
    *file.at("/extensionsUsed") =
        json!(["KHR_materials_clearcoat", "KHR_xmp_json_ld", "KHR_materials_unlit"]);
    let scene = file.load().unwrap();
    let about: Vec<_> = scene.warnings.iter().filter(|w| w.starts_with("extensionsUsed")).collect();
    assert!(about.len() == 1 && about[0].contains("KHR_materials_clearcoat"), "{about:?}");
    *file.at("/extensionsRequired") = json!(["KHR_materials_unlit", "KHR_texture_transform"]);
    file.load().unwrap();
}

#[test]
fn transmission_volume_and_ior_are_read() {
    let mut file = Gltf::triangle();
    *file.at("/extensionsUsed") =
        json!(["KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior"]);
    let volume = json!({"thicknessFactor": 2, "attenuationColor": [0.2, 0.6, 1], "attenuationDistance": 0.5});
    *file.at("/materials/0/extensions") = json!({
        "KHR_materials_transmission": {"transmissionFactor": 0.75},
        "KHR_materials_volume": volume,
        "KHR_materials_ior": {"ior": 1.333},
    });
    let scene = file.load().unwrap();
    let water = Transmission {
        factor: 0.75,
        ior: 1.333,
        thickness_m: 2.0,
        attenuation_color: Vec3::new(0.2, 0.6, 1.0),
        attenuation_distance_m: 0.5,
    };
    assert_eq!(scene.materials[0].transmission, Some(water));
    assert!(scene.warnings.iter().all(|w| !w.contains("extensions")), "{:?}", scene.warnings);

    *file.at("/materials/0/extensions/KHR_materials_volume/attenuationDistance") = json!(0);
    let error = file.load().unwrap_err().to_string();
    assert!(error.contains("materials[0].extensions") && error.contains("attenuation distance"), "{error}");
    *file.at("/materials/0/extensions") = json!({"KHR_materials_ior": {"ior": 1.333}});
    let scene = file.load().unwrap();
    assert!(scene.materials[0].transmission.is_none());
    assert!(scene.warnings.iter().any(|w| w.contains("without KHR_materials_transmission")));
}

//! Nodes that draw their mesh many times, hidden nodes, textures in WebP, and animations of something else than nodes.

use std::f32::consts::FRAC_1_SQRT_2;

use ontile::glam::Vec3;
use ontile::scene::{Play, Scene};
use serde_json::json;

use crate::close;
use crate::gltf_build::{Gltf, animate, png};

/// Three triangles of node 0: moved, turned about +Z and twice as large, mirrored.
fn instanced() -> Gltf {
    let mut file = Gltf::triangle();
    let translations = file.floats("VEC3", &[1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    let turn = FRAC_1_SQRT_2;
    let rotations = file.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, turn, turn, 0.0, 0.0, 0.0, 1.0]);
    let scales = file.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, -1.0, 1.0, 1.0]);
    let attributes =
        json!({"TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": scales});
    file.json["nodes"][0] = json!({
        "mesh": 0, "translation": [0, 10, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}},
    });
    file.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    file.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    file
}

/// Where each instance has the corner at (1, 0, 0).
fn corners(scene: &Scene) -> Vec<Vec3> {
    scene.instances.iter().map(|i| i.world_from_object.transform_point3(Vec3::X)).collect()
}

#[test]
fn a_node_draws_its_mesh_at_each_of_its_places() {
    let scene = instanced().load().unwrap();
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 3));
    assert!(scene.warnings.iter().all(|w| !w.contains("instancing")), "{:?}", scene.warnings);
    let wanted = [[2.0, 12.0, 3.0], [0.0, 12.0, 0.0], [4.0, 10.0, 0.0]];
    assert!(corners(&scene).iter().zip(wanted).all(|(&a, b)| close(a, b)), "{:?}", corners(&scene));
    let mirrored: Vec<_> = scene.instances.iter().map(|i| i.is_mirrored()).collect();
    assert_eq!(mirrored, [false, false, true]);
    // Places in normalised shorts, as gltfpack writes rotations.
    let mut file = instanced();
    let shorts: Vec<u8> = [0_i16, 0, 23170, 23170].repeat(3).iter().flat_map(|v| v.to_le_bytes()).collect();
    let rotations = file.accessor(&shorts, 5122, "VEC4", 3);
    file.json["accessors"][rotations]["normalized"] = json!(true);
    *file.at("/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes") = json!({"ROTATION": rotations});
    assert!(corners(&file.load().unwrap()).iter().all(|&corner| close(corner, [0.0, 11.0, 0.0])));
}

#[test]
fn instances_move_with_their_node() {
    let mut file = instanced();
    let at_rest = file.load_moving().unwrap();
    assert!(at_rest.motion.is_none());
    animate(
        &mut file,
        &[(0, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 10.0, 0.0, 0.0, 10.0, 4.0])],
    );
    let mut scene = file.load_moving().unwrap();
    assert!(scene.instances.iter().all(|i| i.dynamic));
    assert_eq!(corners(&scene), corners(&at_rest));
    scene.animate(&[Play { animation: 0, time_s: 0.5 }]).unwrap();
    let moved = corners(&at_rest).into_iter().map(|corner| corner + Vec3::new(0.0, 0.0, 2.0));
    assert!(corners(&scene).into_iter().zip(moved).all(|(a, b)| close(a, b.to_array())));
}

#[test]
fn instances_without_volume_or_sense_are_told() {
    let place = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";
    let mut file = instanced();
    let flat = file.floats("VEC3", &[1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    *file.at(place) = json!({"SCALE": flat});
    let scene = file.load().unwrap();
    assert_eq!(scene.instances.len(), 2);
    assert!(scene.warnings.iter().any(|w| w.contains("flattens 1 of 3 instances")), "{:?}", scene.warnings);
    let error = |attributes: fn(&mut Gltf) -> serde_json::Value| {
        let mut file = instanced();
        let attributes = attributes(&mut file);
        *file.at(place) = attributes;
        file.load().unwrap_err().to_string()
    };
    let counts =
        error(|f| json!({"SCALE": f.floats("VEC3", &[1.0; 6]), "TRANSLATION": f.floats("VEC3", &[1.0; 9])}));
    assert!(
        counts.contains("attributes.TRANSLATION: has 3 elements, but another attribute has 2"),
        "{counts}"
    );
    let zero = error(|f| json!({"ROTATION": f.floats("VEC4", &[0.0; 4])}));
    assert!(zero.contains("attributes.ROTATION: element 0 is a quaternion of length 0"), "{zero}");
    assert!(error(|_| json!({})).contains("is empty"));
    assert!(error(|_| json!({"TRANSLATION": 77})).contains("accessors[77]"));
    let wide = error(|f| json!({"TRANSLATION": f.floats("VEC4", &[1.0; 4])}));
    assert!(wide.contains("a float VEC3"), "{wide}");
}

#[test]
fn hidden_nodes_show_nothing_but_keep_their_cameras() {
    let mut file = Gltf::triangle();
    file.push(
        "cameras",
        json!({"name": "eye", "type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}),
    );
    let child =
        file.push("nodes", json!({"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": true}}}));
    let eye = file.push("nodes", json!({"camera": 0}));
    let hidden = json!({"visible": false});
    file.root_node(
        json!({"mesh": 0, "children": [child, eye], "extensions": {"KHR_node_visibility": hidden}}),
    );
    file.json["extensionsRequired"] = json!(["KHR_node_visibility"]);
    let scene = file.load().unwrap();
    assert_eq!((scene.instances.len(), scene.cameras[0].name.as_str()), (1, "eye"));
    *file.at("/nodes/3/extensions/KHR_node_visibility") = json!({});
    assert_eq!(file.load().unwrap().instances.len(), 3, "visible unless it says otherwise");
}

fn webp(side: u32, rgba: &[u8]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_raw(side, side, rgba.to_vec()).unwrap();
    image.write_to(&mut bytes, image::ImageFormat::WebP).unwrap();
    bytes.into_inner()
}

#[test]
fn textures_in_webp() {
    let texels: Vec<u8> = (0..8 * 8 * 4).map(|i| (i * 37 % 251) as u8).collect();
    let mut file = Gltf::triangle();
    let texture = file.texture(&png(1, 1, &[1, 2, 3, 4]));
    let view = file.view(&webp(8, &texels));
    let image = file.push("images", json!({"name": "better", "bufferView": view, "mimeType": "image/webp"}));
    file.json["textures"][texture]["extensions"] = json!({"EXT_texture_webp": {"source": image}});
    file.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    *file.at("/materials/0/pbrMetallicRoughness") = json!({"baseColorTexture": {"index": texture}});
    let scene = file.load().unwrap();
    let [better] = &scene.images[..] else { panic!("{}", scene.images.len()) };
    assert_eq!((better.name.as_str(), better.width, better.rgba8()), ("better", 8, &texels[..]));
    *file.at("/textures/0/extensions/EXT_texture_webp/source") = json!(9);
    let beyond = file.load().unwrap_err().to_string();
    assert!(beyond.contains("textures[0].extensions.EXT_texture_webp.source"), "{beyond}");
}

/// Damaged by the thousand: errors are fine, panics are not.
#[test]
fn damaged_webp_never_panics() {
    let texels: Vec<u8> = (0..16 * 16 * 4_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let whole = webp(16, &texels);
    let mut file = Gltf::triangle();
    let texture = file.texture(&whole);
    *file.at("/materials/0/pbrMetallicRoughness") = json!({"baseColorTexture": {"index": texture}});
    let start = file.bin.len() - whole.len();
    let (mut state, mut refused) = (1_u32, 0);
    for _ in 0..2000 {
        let mut damaged = file.clone();
        for _ in 0..3 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            damaged.bin[start + state as usize / 256 % whole.len()] ^= (state >> 3) as u8 | 1;
        }
        refused += usize::from(damaged.load().is_err());
    }
    assert!(refused > 100, "{refused}");
}

#[test]
fn animations_of_something_else_than_nodes_are_left_out() {
    let mut file = Gltf::triangle();
    animate(&mut file, &[(0, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 4.0])]);
    let pointer = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/materials/0/emissiveFactor"}}});
    let channels = file.at("/animations/0/channels").as_array_mut().unwrap();
    channels.insert(0, json!({"sampler": 0, "target": pointer}));
    file.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    let mut scene = file.load_moving().unwrap();
    for part in ["KHR_animation_pointer is not supported", "1 channels that move something else than nodes"] {
        assert!(scene.warnings.iter().any(|w| w.contains(part)), "{part}: {:?}", scene.warnings);
    }
    scene.animate(&[Play { animation: 0, time_s: 0.5 }]).unwrap();
    assert!(close(corners(&scene)[0], [1.0, 0.0, 2.0]));
    // A channel that is damaged otherwise is still blamed.
    *file.at("/animations/0/channels/1") =
        json!({"sampler": 0, "target": {"node": "zero", "path": "translation"}});
    assert!(file.load().unwrap_err().to_string().contains("animations[0]"));
}

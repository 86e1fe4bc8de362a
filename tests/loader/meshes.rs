//! Attributes, indices, primitives, deformation.

use ontile::glam::{Mat4, Vec2, Vec3, Vec4};
use ontile::scene::Scene;
use serde_json::json;

use crate::gltf_build::{F32, Gltf, U8, U16, U32, floats, load_bytes, png, shorts};
use crate::{F32_ROUNDING, close};

const ATTRIBUTES: &str = "/meshes/0/primitives/0/attributes";

fn attribute(file: &mut Gltf, name: &str, accessor: usize) {
    *file.at(&format!("{ATTRIBUTES}/{name}")) = json!(accessor);
}

fn base_color_texture(file: &mut Gltf, texcoord: u32) {
    let texture = file.texture(&png(1, 1, &[255; 4]));
    *file.at("/materials/0/pbrMetallicRoughness/baseColorTexture") =
        json!({"index": texture, "texCoord": texcoord});
}

fn normal_texture(file: &mut Gltf) {
    let texture = file.texture(&png(1, 1, &[128, 128, 255, 255]));
    *file.at("/materials/0/normalTexture") = json!({"index": texture});
}

/// The corners of all triangles.
fn corners(scene: &Scene) -> Vec<[f32; 3]> {
    let mesh = &scene.meshes[0];
    mesh.indices.iter().map(|&i| mesh.positions[i as usize].to_array()).collect()
}

#[test]
fn the_triangle() {
    let scene = Gltf::triangle().load().unwrap();
    assert_eq!(corners(&scene), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(scene.meshes[0].normals, [Vec3::Z; 3]);
    assert!(scene.meshes[0].texcoords[0].is_empty(), "no texture needs them");
    assert_eq!(scene.instances[0].world_from_object, Mat4::IDENTITY);
    assert_eq!((scene.name.as_str(), scene.triangle_count()), ("scene", 1));
}

#[test]
fn containers_are_alike() {
    let mut file = Gltf::triangle();
    base_color_texture(&mut file, 0);
    let folder = tempfile::tempdir().unwrap();
    // The name in the URI is percent-encoded, that in the folder is not.
    let beside = file.write_beside(folder.path(), "a b");
    let text = std::fs::read_to_string(&beside).unwrap().replace("a b.bin", "a%20b.bin");
    std::fs::write(&beside, text).unwrap();
    let expected = corners(&file.load().unwrap());
    for scene in [load_bytes("x.glb", &file.to_glb()).unwrap(), Scene::load(&beside).unwrap()] {
        assert_eq!(corners(&scene), expected);
        assert_eq!(scene.images[0].rgba8(), [255; 4]);
    }
}

#[test]
fn indices_of_all_sizes_or_none() {
    let expected = [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    for (bytes, component) in [
        (vec![2, 0, 1], U8),
        (shorts(&[2, 0, 1]), U16),
        ([2u32, 0, 1].iter().flat_map(|i| i.to_le_bytes()).collect(), U32),
    ] {
        let mut file = Gltf::triangle();
        let indices = file.accessor(&bytes, component, "SCALAR", 3);
        *file.at("/meshes/0/primitives/0/indices") = json!(indices);
        assert_eq!(corners(&file.load().unwrap()), expected, "{component}");
    }
    let mut file = Gltf::triangle();
    file.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
    assert_eq!(corners(&file.load().unwrap()), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn strips_and_fans() {
    let mode = |mode: u32| {
        let mut file = Gltf::triangle();
        let xs: Vec<f32> = (0..5).flat_map(|i| [i as f32, 0.0, 0.0]).collect();
        let positions = file.floats("VEC3", &xs);
        *file.at("/meshes/0/primitives/0") = json!({"attributes": {"POSITION": positions}, "mode": mode});
        let scene = file.load().unwrap();
        (corners(&scene).into_iter().map(|[x, ..]| x as u32).collect::<Vec<_>>(), scene.warnings)
    };
    // glTF 2.0 section 3.7.2.1, written out for five vertices.
    assert_eq!(mode(5).0, [0, 1, 2, 1, 3, 2, 2, 3, 4]);
    assert_eq!(mode(6).0, [1, 2, 0, 2, 3, 0, 3, 4, 0]);
    assert_eq!(mode(4).0, [0, 1, 2]);
}

#[test]
fn points_and_lines_are_left_out_with_a_warning() {
    for mode in 0..4 {
        let mut file = Gltf::triangle();
        *file.at("/meshes/0/primitives/0/mode") = json!(mode);
        let scene = file.load().unwrap();
        assert!(scene.meshes.is_empty() && scene.materials.is_empty() && scene.lights.is_empty());
        assert!(
            scene.warnings.iter().any(|w| w.starts_with("meshes[0].primitives[0]")),
            "{:?}",
            scene.warnings
        );
    }
}

#[test]
fn strided_and_sparse_accessors() {
    let mut file = Gltf::triangle();
    let rows = [[0.0, 0.0, 5.0, 9.0], [1.0, 0.0, 5.0, 9.0], [0.0, 1.0, 5.0, 0.0]].concat();
    let view = file.view(&floats(&rows)[..44]);
    *file.at(&format!("/bufferViews/{view}/byteStride")) = json!(16);
    let (at, new) = (file.view(&shorts(&[0, 2])), file.view(&floats(&[7.0, 7.0, 7.0, 8.0, 8.0, 8.0])));
    let sparse = json!({"count": 2, "indices": {"bufferView": at, "componentType": U16}, "values": {"bufferView": new}});
    let strided =
        json!({"bufferView": view, "componentType": F32, "type": "VEC3", "count": 3, "sparse": sparse});
    let strided = file.push("accessors", strided);
    attribute(&mut file, "POSITION", strided);
    assert_eq!(corners(&file.load().unwrap()), [[7.0; 3], [1.0, 0.0, 5.0], [8.0; 3]]);
    // Without a base, the rest is zero.
    file.json["accessors"][strided].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(corners(&file.load().unwrap()), [[7.0; 3], [0.0; 3], [8.0; 3]]);
}

#[test]
fn texture_coordinates_of_all_formats_and_both_sets() {
    let expected = [[0.0, 1.0], [0.2, 0.4], [1.0, 0.6]].map(Vec2::from);
    let bytes = [0, 255, 0, 0, 51, 102, 0, 0, 255, 153, 0, 0];
    let wide = shorts(&[0, 65535, 13107, 26214, 65535, 39321]);
    for (data, component) in
        [(floats(&[0.0, 1.0, 0.2, 0.4, 1.0, 0.6]), F32), (bytes.to_vec(), U8), (wide, U16)]
    {
        for set in 0..2 {
            let mut file = Gltf::triangle();
            let texcoords = file.accessor(&data, component, "VEC2", 3);
            if component == U8 {
                let view = file.json["accessors"][texcoords]["bufferView"].clone();
                *file.at(&format!("/bufferViews/{view}/byteStride")) = json!(4);
            }
            *file.at(&format!("/accessors/{texcoords}/normalized")) = json!(component != F32);
            attribute(&mut file, &format!("TEXCOORD_{set}"), texcoords);
            base_color_texture(&mut file, set);
            let mesh = &file.load().unwrap().meshes[0];
            let found = &mesh.texcoords[set as usize];
            assert!(found.iter().zip(expected).all(|(a, b)| a.abs_diff_eq(b, F32_ROUNDING)), "{found:?}");
            assert!(mesh.texcoords[1 - set as usize].is_empty(), "only the used set is kept");
        }
    }
}

#[test]
fn quantised_attributes_where_the_extension_says_so() {
    const I8: u32 = 5120;
    const I16: u32 = 5122;
    let mut file = Gltf::triangle();
    base_color_texture(&mut file, 0);
    // Plain shorts are their own value; rows of a stride that is a multiple of 4.
    let shorts_of = |v: &[i16]| v.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let positions = file.accessor(&shorts_of(&[0, 0, 0, 0, 300, 0, 0, 0, 0, -7, 0, 0]), I16, "VEC3", 3);
    let view = file.json["accessors"][positions]["bufferView"].as_u64().unwrap();
    *file.at(&format!("/bufferViews/{view}/byteStride")) = json!(8);
    // Normalised bytes: 127 is 1, and -128 is -1 like -127.
    let up: Vec<u8> =
        [[0, 0, 127, 0], [0, 0, 127, 0], [0, 0, -128, 0]].concat().iter().map(|&b: &i8| b as u8).collect();
    let normals = file.accessor(&up, I8, "VEC3", 3);
    let view = file.json["accessors"][normals]["bufferView"].as_u64().unwrap();
    *file.at(&format!("/bufferViews/{view}/byteStride")) = json!(4);
    *file.at(&format!("/accessors/{normals}/normalized")) = json!(true);
    let texcoords = file.accessor(&shorts(&[0, 1, 2, 3, 4, 5]), U16, "VEC2", 3);
    attribute(&mut file, "POSITION", positions);
    attribute(&mut file, "NORMAL", normals);
    attribute(&mut file, "TEXCOORD_0", texcoords);

    let refused = file.load().unwrap_err().to_string();
    assert!(refused.contains("I16"), "core glTF has no such positions: {refused}");

    for list in ["extensionsUsed", "extensionsRequired"] {
        file.json[list] = json!(["KHR_mesh_quantization"]);
    }
    let scene = file.load().unwrap();
    assert_eq!(corners(&scene), [[0.0, 0.0, 0.0], [300.0, 0.0, 0.0], [0.0, -7.0, 0.0]]);
    assert_eq!(scene.meshes[0].normals, [Vec3::Z, Vec3::Z, -Vec3::Z]);
    assert_eq!(scene.meshes[0].texcoords[0], [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]].map(Vec2::from));
}

#[test]
fn vertex_colors() {
    let expected = Vec4::new(0.2, 0.4, 0.6, 1.0);
    for (data, component, kind) in [
        (floats(&[0.2, 0.4, 0.6].repeat(3)), F32, "VEC3"),
        (floats(&[0.2, 0.4, 0.6, 1.0].repeat(3)), F32, "VEC4"),
        ([51, 102, 153, 255].repeat(3), U8, "VEC4"),
        (shorts(&[13107, 26214, 39321, 65535].repeat(3)), U16, "VEC4"),
        (shorts(&[13107, 26214, 39321].repeat(3)), U16, "VEC3"),
    ] {
        let mut file = Gltf::triangle();
        let colors = file.accessor(&data, component, kind, 3);
        *file.at(&format!("/accessors/{colors}/normalized")) = json!(component != F32);
        attribute(&mut file, "COLOR_0", colors);
        let mesh = &file.load().unwrap().meshes[0];
        assert!(mesh.colors.len() == 3 && mesh.colors.iter().all(|c| c.abs_diff_eq(expected, F32_ROUNDING)));
    }
}

#[test]
fn missing_normals_are_flat() {
    let mut file = Gltf::empty();
    // Two triangles that share an edge: one in the plane z = 0, one in the plane x = 0.
    let positions = file.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.]);
    let indices = file.accessor(&[0, 1, 2, 0, 2, 3], U8, "SCALAR", 6);
    file.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}, "indices": indices}]}));
    file.root_node(json!({"mesh": 0}));
    let scene = file.load().unwrap();
    assert_eq!(scene.meshes[0].normals, [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::X, Vec3::X, Vec3::X]);
    assert_eq!(scene.meshes[0].positions.len(), 6);
    assert_eq!(scene.materials[0].name, "default");
}

#[test]
fn normals_are_made_unit_and_zero_ones_replaced() {
    let mut file = Gltf::triangle();
    let normals = file.floats("VEC3", &[0.0, 3.0, 4.0, 0.0, 0.0, 0.0, 1e-30, 0.0, 0.0]);
    attribute(&mut file, "NORMAL", normals);
    let scene = file.load().unwrap();
    let found = &scene.meshes[0].normals;
    assert!(close(found[0], [0.0, 0.6, 0.8]) && found[1] == Vec3::Z && found[2] == Vec3::X, "{found:?}");
    assert!(scene.warnings.iter().any(|w| w.contains("NORMAL") && w.contains("1 normals of length 0")));
}

#[test]
fn unlit_meshes_have_no_normals() {
    let mut file = Gltf::triangle();
    *file.at("/materials/0/extensions") = json!({"KHR_materials_unlit": {}});
    let scene = file.load().unwrap();
    assert!(scene.meshes[0].normals.is_empty() && scene.materials[0].unlit && scene.lights.is_empty());
}

#[test]
fn missing_tangents_follow_the_picture() {
    let mut file = Gltf::triangle();
    normal_texture(&mut file);
    // u grows along +X, v falls along +Y: right in the picture is +X, up in the picture +Y = cross(Z, X).
    assert_eq!(file.load().unwrap().meshes[0].tangents, [Vec4::new(1.0, 0.0, 0.0, 1.0); 3]);
    // A mirrored picture.
    let mirrored = file.floats("VEC2", &[1.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
    attribute(&mut file, "TEXCOORD_0", mirrored);
    assert_eq!(file.load().unwrap().meshes[0].tangents, [Vec4::new(-1.0, 0.0, 0.0, -1.0); 3]);
    // The texture is not sampled, yet every attribute is there.
    file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    let tangents = &file.load().unwrap().meshes[0].tangents;
    assert!(tangents.len() == 3 && tangents.iter().all(|t| t.truncate().dot(Vec3::Z).abs() < F32_ROUNDING));
}

#[test]
fn made_tangents_keep_shared_vertices_shared() {
    let mut file = Gltf::empty();
    let positions = file.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let texcoords = file.floats("VEC2", &[0., 1., 1., 1., 1., 0., 0., 0.]);
    let indices = file.accessor(&[0, 1, 2, 0, 2, 3], U8, "SCALAR", 6);
    file.push("materials", json!({}));
    normal_texture(&mut file);
    let attributes = json!({"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": texcoords});
    file.push(
        "meshes",
        json!({"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}),
    );
    file.root_node(json!({"mesh": 0}));
    let scene = file.load().unwrap();
    assert_eq!((scene.meshes[0].positions.len(), scene.meshes[0].indices.len()), (4, 6));
}

#[test]
fn given_tangents_are_kept() {
    let mut file = Gltf::triangle();
    normal_texture(&mut file);
    let tangents = file.floats("VEC4", &[0.0, 2.0, 0.0, -1.0].repeat(3));
    attribute(&mut file, "TANGENT", tangents);
    assert_eq!(file.load().unwrap().meshes[0].tangents, [Vec4::new(0.0, 1.0, 0.0, -1.0); 3]);
    file.json["materials"][0].as_object_mut().unwrap().remove("normalTexture");
    assert!(file.load().unwrap().meshes[0].tangents.is_empty(), "nothing needs them");
}

#[test]
fn a_large_fan_gets_tangents_in_time() {
    // Half a million triangles around one vertex.
    let mut file = Gltf::triangle();
    normal_texture(&mut file);
    let indices = file.accessor(&[0, 1, 2].repeat(500_000), U8, "SCALAR", 1_500_000);
    *file.at("/meshes/0/primitives/0/indices") = json!(indices);
    let scene = file.load().unwrap();
    assert_eq!(scene.meshes[0].tangents.len(), scene.meshes[0].positions.len());
    assert!(scene.warnings.iter().any(|w| w.contains("tangents are arbitrary")));
}

#[test]
fn morph_targets_at_their_weights() {
    let mut file = Gltf::triangle();
    let up = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let aside = file.floats("VEC3", &[2.0, 0.0, 0.0].repeat(3));
    *file.at("/meshes/0/primitives/0/targets") =
        json!([{"POSITION": up, "NORMAL": aside}, {"POSITION": aside}]);
    assert_eq!(corners(&file.load().unwrap())[0], [0.0; 3], "no weights are weights of 0");
    *file.at("/meshes/0/weights") = json!([0.5, 0.25]);
    file.root_node(json!({"mesh": 0, "weights": [0.0, 1.0]}));
    let scene = file.load().unwrap();
    assert_eq!(scene.meshes.len(), 2, "the nodes have weights of their own");
    assert!(close(scene.meshes[0].positions[0], [0.5, 0.0, 0.5]));
    // (0, 0, 1) + 0.5 * (2, 0, 0), normalised.
    assert!(close(scene.meshes[0].normals[0], [0.5_f32.sqrt(), 0.0, 0.5_f32.sqrt()]));
    assert!(close(scene.meshes[1].positions[0], [2.0, 0.0, 0.0]) && scene.meshes[1].normals[0] == Vec3::Z);
}

#[test]
fn skins_at_rest_ignore_their_own_node() {
    let mut file = Gltf::triangle();
    // Vertex 1 halfway between both joints, vertex 2 on the second.
    let joints = file.accessor(&[0, 1, 0, 0].repeat(3), U8, "VEC4", 3);
    let weights = file.floats("VEC4", &[1., 0., 0., 0., 0.5, 0.5, 0., 0., 0., 1., 0., 0.]);
    attribute(&mut file, "JOINTS_0", joints);
    attribute(&mut file, "WEIGHTS_0", weights);
    let inverse_binds = [Mat4::IDENTITY, Mat4::from_translation(Vec3::new(0.0, 0.0, -1.0))];
    let inverse_binds = file.floats("MAT4", &inverse_binds.map(|m| m.to_cols_array()).concat());
    file.push("nodes", json!({"translation": [0, 10, 0]}));
    file.push("nodes", json!({"translation": [0, 0, 5], "children": [1]}));
    let parent = 2;
    file.json["scenes"][0]["nodes"] = json!([0, parent]);
    file.push("skins", json!({"joints": [parent, 1], "inverseBindMatrices": inverse_binds}));
    *file.at("/nodes/0") = json!({"mesh": 0, "skin": 0, "translation": [100, 100, 100]});
    let scene = file.load().unwrap();
    assert_eq!(scene.instances[0].world_from_object, Mat4::IDENTITY);
    // Joint 0 moves by (0, 0, 5); joint 1 by (0, 10, 5) - (0, 0, 1).
    let p = &scene.meshes[0].positions;
    assert!(close(p[0], [0.0, 0.0, 5.0]), "{p:?}");
    assert!(close(p[1], [1.0, 5.0, 4.5]), "{p:?}");
    assert!(close(p[2], [0.0, 11.0, 4.0]), "{p:?}");
}

#[test]
fn a_mirroring_joint_turns_normals_and_winding() {
    let mut file = Gltf::triangle();
    let joints = file.accessor(&[0; 12], U8, "VEC4", 3);
    let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3));
    attribute(&mut file, "JOINTS_0", joints);
    attribute(&mut file, "WEIGHTS_0", weights);
    let joint = file.root_node(json!({"scale": [-1, 1, 1]}));
    file.push("skins", json!({"joints": [joint]}));
    *file.at("/nodes/0/skin") = json!(0);
    let scene = file.load().unwrap();
    assert_eq!(scene.meshes[0].normals, [Vec3::Z; 3]);
    let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(corners(&scene)[k]));
    assert!((b - a).cross(c - a).z > 0.0, "still counter-clockwise from +Z");
}

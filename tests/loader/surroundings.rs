//! Background, fog and lightmap: extras of scenes, and parts of the lightmap, extras of nodes.

use ontile::glam::{Vec2, Vec3};
use ontile::scene::{Background, Fog, FogHeight, LightmapRect};
use serde_json::json;

use crate::gltf_build::{Gltf, png};

#[test]
fn extras_of_the_scene_say_what_is_around() {
    let mut file = Gltf::triangle();
    let images = [[255, 128, 0, 255], [51, 0, 0, 255]].map(|texel| file.texture(&png(1, 1, &texel)));
    *file.at("/scenes/0/extras") = json!({"ontile": {
        "background": "environment",
        "fog": {"density": 0.25, "color": [0.1, 0.2, 0.3], "base": -1, "scale": 2},
        "lightmap": {"color_image": images[0], "scale_image": images[1], "unit_lx": 3},
    }});
    *file.at("/meshes/0/primitives/0/attributes/TEXCOORD_1") = json!(2);
    *file.at("/nodes/0/extras") = json!({"ontile": {"lightmap": [0.25, 0.5, 0.125, 0.375], "dynamic": true}});
    let scene = file.load().unwrap();
    assert_eq!(scene.background, Background::Environment);
    let height = Some(FogHeight { base_m: -1.0, scale_m: 2.0 });
    let fog = Fog { color_nt: Vec3::new(0.1, 0.2, 0.3), density_per_m: 0.25, height };
    assert_eq!(scene.fog, Some(fog));
    let map = scene.lightmap.unwrap();
    assert_eq!((map.width, map.height, map.unit_lx), (1, 1, 3.0));
    assert_eq!((map.color_rgba8, map.scale8), (vec![255, 128, 0, 255], vec![51]));
    let rect = LightmapRect { origin: Vec2::new(0.25, 0.5), size: Vec2::new(0.125, 0.375) };
    assert_eq!(scene.instances[0].lightmap, Some(rect));
    assert!(scene.lights.is_empty() && scene.warnings.is_empty(), "{:?}", scene.warnings);

    *file.at("/scenes/0/extras") = json!({"ontile": {"background": "#ff0000"}});
    let scene = file.load().unwrap();
    assert_eq!(scene.background, Background::Color(Vec3::X));
    let warned = |text: &str| scene.warnings.iter().any(|warning| warning.contains(text));
    assert!(warned("part of a lightmap, but the file has none"), "{:?}", scene.warnings);
}

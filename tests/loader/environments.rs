//! Environments that a file names.

use ontile::environment::{Panorama, Prefiltered, TexelFormat};
use ontile::glam::Vec3;
use ontile::scene::Scene;
use serde_json::json;

use crate::gltf_build::Gltf;

#[test]
fn extras_of_the_scene_name_a_file_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("my skies")).unwrap();
    let white = Panorama::new(8, 4, vec![Vec3::ONE; 32]).unwrap();
    let baked = Prefiltered::new(&white, 16, TexelFormat::B10G11R11);
    baked.write(&folder.path().join("my skies/white.ktx2")).unwrap();

    let mut file = Gltf::triangle();
    *file.at("/scenes/0/extras") = json!({"ontile": {"environment": {
        "file": "my%20skies/white.ktx2", "rotation": -30, "intensity": 2.5,
    }}});
    let scene = Scene::load(&file.write_beside(folder.path(), "a")).unwrap();
    let environment = scene.environment.unwrap();
    assert_eq!((environment.rotation_deg, environment.intensity), (-30.0, 2.5));
    assert_eq!((environment.name.as_str(), environment.panorama), ("white.ktx2", None));
    assert_eq!(*environment.prefiltered.unwrap(), baked);
    assert!(scene.lights.is_empty() && !scene.has_default_lights, "the environment is the light");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn extras_of_nodes_make_probes() {
    let folder = tempfile::tempdir().unwrap();
    let white = Panorama::new(8, 4, vec![Vec3::ONE; 32]).unwrap();
    let baked = Prefiltered::new(&white, 16, TexelFormat::B10G11R11);
    baked.write(&folder.path().join("room.ktx2")).unwrap();

    let mut file = Gltf::triangle();
    let turned = [0.0, std::f32::consts::FRAC_1_SQRT_2, 0.0, std::f32::consts::FRAC_1_SQRT_2];
    let node = file.root_node(json!({
        "name": "hall", "translation": [1, 2, 3], "rotation": turned, "scale": [3, 3, 3],
        "extras": {"ontile": {"probe": {
            "size": [8, 4, 2], "falloff": 0.25, "file": "room.ktx2", "rotation": 15, "intensity": 3,
        }}},
    }));
    assert_eq!(node, 1);
    let scene = Scene::load(&file.write_beside(folder.path(), "a")).unwrap();
    let [probe] = &scene.probes[..] else { panic!("{:?}", scene.probes) };
    assert_eq!((probe.name.as_str(), probe.position_world), ("hall", Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!((probe.half_size_m, probe.falloff_m), (Vec3::new(4.0, 2.0, 1.0), 0.25));
    // The node's +X lies towards the world's -Z.
    assert!((probe.world_from_probe * Vec3::X).abs_diff_eq(Vec3::NEG_Z, 1e-6), "{probe:?}");
    assert_eq!((probe.environment.rotation_deg, probe.environment.intensity), (15.0, 3.0));
    assert_eq!(**probe.environment.prefiltered.as_ref().unwrap(), baked);
    assert!(
        scene.has_default_lights,
        "a probe is no light: the triangle's diffuse light has to come from somewhere"
    );
}

#[test]
fn default_lights_can_be_dropped_for_another_light() {
    let mut scene = Gltf::triangle().load().unwrap();
    assert!(scene.has_default_lights && scene.lights.len() == 2 && scene.warnings.len() == 1);
    scene.drop_default_lights();
    assert!(!scene.has_default_lights && scene.lights.is_empty() && scene.warnings.is_empty());
    let lights = vec![ontile::scene::Light::new(ontile::scene::LightKind::Point { intensity_cd: 1.0 })];
    let mut own = Scene { lights, ..Scene::default() };
    own.drop_default_lights();
    assert_eq!(own.lights.len(), 1, "lights of its own stay");
}

//! Decals that nodes have.

use ontile::glam::{Mat4, Vec3};
use ontile::scene::{Decal, DecalChannels};
use serde_json::json;

use crate::gltf_build::Gltf;

#[test]
fn extras_of_nodes_make_decals() {
    let mut file = Gltf::triangle();
    let turned = [0.0, std::f32::consts::FRAC_1_SQRT_2, 0.0, std::f32::consts::FRAC_1_SQRT_2];
    file.root_node(json!({
        "name": "spot", "translation": [1, 2, 3], "rotation": turned, "scale": [2, 1, 1],
        "extras": {"ontile": {"decal": {
            "material": 0, "size": [1, 3, 0.5], "channels": {"normal": 0.25, "metallic": 1},
            "angle": [30, 90], "falloff": [0.1, 0, 0.2], "priority": -2,
        }}},
    }));
    file.root_node(json!({"extras": {"ontile": {"decal": {"material": 0}}}}));
    let scene = file.load().unwrap();
    let [spot, plain] = &scene.decals[..] else { panic!("{:?}", scene.decals) };
    assert_eq!((spot.name.as_str(), plain.name.as_str()), ("spot", "decal 1"));
    assert_eq!(spot.channels, DecalChannels { normal: 0.25, metallic: 1.0, ..DecalChannels::NONE });
    assert_eq!((spot.angle_rad[1], spot.priority), (std::f32::consts::FRAC_PI_2, -2.0));
    assert_eq!(spot.falloff_m, Vec3::new(0.1, 0.0, 0.2));
    // The node's +Z is the world's +X, and its scale counts.
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| spot.world_from_decal.transform_vector3(axis));
    assert!(x.abs_diff_eq(Vec3::NEG_Z * 2.0, 1e-6) && y.abs_diff_eq(Vec3::Y * 3.0, 1e-6), "{x} {y}");
    assert!(z.abs_diff_eq(Vec3::X * 0.5, 1e-6), "{z}");
    assert_eq!(spot.world_from_decal.transform_point3(Vec3::ZERO), Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(*plain, Decal { name: "decal 1".into(), ..Decal::new(plain.material, Mat4::IDENTITY) });
    assert_eq!((plain.channels, scene.warnings.len()), (DecalChannels::ALL, 1), "{:?}", scene.warnings);
}

//! Particles that nodes have.

use ontile::glam::Vec3;
use ontile::scene::Particle;
use serde_json::{Value, json};

use crate::gltf_build::Gltf;

/// A file with three points, beside its triangle.
fn points(extras: Value) -> Gltf {
    let mut file = Gltf::triangle();
    let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let colors = file.floats("VEC3", &[1.0, 0.5, 0.25, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let sizes = file.floats("SCALAR", &[1.0, 2.0, 3.0]);
    let rotations = file.floats("SCALAR", &[0.0, -1.0, 4.0]);
    let material = file.push("materials", json!({"emissiveFactor": [1, 0.5, 0]}));
    let attributes =
        json!({"POSITION": positions, "COLOR_0": colors, "_SIZE": sizes, "_ROTATION": rotations});
    let primitive = json!({"attributes": attributes, "mode": 0, "material": material});
    let mesh = file.push("meshes", json!({"primitives": [primitive]}));
    file.root_node(json!({
        "name": "sparks", "mesh": mesh, "translation": [1, 2, 3], "scale": [2, 2, 2],
        "extras": {"ontile": extras},
    }));
    file
}

#[test]
fn points_become_particles() {
    let scene = points(json!({"particles": {"size": 0.5, "soft": 0.25}})).load().unwrap();
    let [sparks] = &scene.particles[..] else { panic!("{:?}", scene.particles) };
    assert_eq!((sparks.name.as_str(), sparks.soft_m, sparks.most), ("sparks", 0.25, 3));
    assert_eq!(scene.materials[sparks.material].emissive_factor, Vec3::new(1.0, 0.5, 0.0));
    let second = Particle {
        position_world: Vec3::new(3.0, 2.0, 3.0),
        size_m: 1.0,
        rotation_rad: -1.0,
        color: Vec3::ZERO,
    };
    assert_eq!(sparks.list[1], second, "the node's scale places points, and leaves their size");
    assert_eq!(sparks.list[0].color, Vec3::new(1.0, 0.5, 0.25));
    assert_eq!(scene.meshes.len(), 1, "points are no mesh");
    assert!(scene.warnings.iter().all(|w| !w.contains("points")), "{:?}", scene.warnings);
    let plain = points(json!({"particles": {}})).load().unwrap();
    assert_eq!((plain.particles[0].soft_m, plain.particles[0].list[2].size_m), (0.1, 0.1 * 3.0));
}

#[test]
fn what_makes_no_particles_is_told() {
    let scene = points(json!({})).load().unwrap();
    assert!(scene.particles.is_empty() && scene.warnings.iter().any(|w| w.contains("points and lines")));
    let wrong = [
        (json!({"particles": {"size": 0}}), "nodes[1].extras.ontile.particles.size"),
        (json!({"particles": {"soft": -1}}), "particles.soft"),
        (json!({"particles": {"sise": 1}}), "use one of: size, soft"),
        (json!({"particles": 3}), "must be an object"),
    ];
    for (extras, part) in wrong {
        let error = points(extras).load().unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    let mut file = points(json!({"particles": {}}));
    *file.at("/meshes/1/primitives/0/attributes") = json!({"POSITION": 0, "_SIZE": 1});
    assert!(file.load().unwrap_err().to_string().contains("_SIZE"));
    let mut file = Gltf::triangle();
    *file.at("/nodes/0") = json!({"mesh": 0, "extras": {"ontile": {"particles": {}}}});
    assert!(file.load().unwrap_err().to_string().contains("a node without points"));
    let mut file = points(json!({"particles": {}}));
    *file.at("/materials/1") = json!({});
    assert!(file.load().unwrap().warnings.iter().any(|w| w.contains("emits nothing")));
}

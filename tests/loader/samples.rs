//! Khronos' sample models. The facts are read off their JSON and their documentation, not off the loader.

use std::io::Write;
use std::path::PathBuf;

use ontile::glam::{Vec2, Vec3};
use ontile::scene::{AlphaMode, Scene, Wrap};

fn models() -> Option<PathBuf> {
    let shared = std::env::var_os("ONTILE_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let models = shared.join("assets/models");
    if !models.is_dir() {
        // Past the test harness, which hides what passing tests print.
        let _ = writeln!(std::io::stderr(), "ignored: {} absent", models.display());
        return None;
    }
    Some(models)
}

/// The sample of this name; `None` if there are no samples here.
fn sample(name: &str) -> Option<Scene> {
    let folder = models()?.join(name);
    let file = ["glb", "gltf"].map(|e| folder.join(format!("{name}.{e}"))).into_iter().find(|f| f.is_file());
    let scene = Scene::load(&file.unwrap_or_else(|| panic!("{} has no glTF file", folder.display())));
    Some(scene.unwrap_or_else(|e| panic!("{e}")))
}

#[test]
fn all_samples_load() {
    let Some(models) = models() else { return };
    let mut loaded = 0;
    for entry in models.read_dir().unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let Some(scene) = sample(&name) else { return };
        assert_eq!(scene.name, name);
        assert!(scene.triangle_count() > 0 && !scene.cameras.is_empty(), "{name}");
        for mesh in &scene.meshes {
            let (n, material) = (mesh.positions.len(), &scene.materials[mesh.material]);
            assert!(material.unlit || mesh.normals.len() == n, "{name}");
            assert!(material.normal_texture.is_none() || mesh.tangents.len() == n, "{name}");
            let sets = [mesh.texcoords[0].len(), mesh.texcoords[1].len(), mesh.colors.len()];
            assert!(sets.iter().all(|&len| len == 0 || len == n), "{name}");
        }
        loaded += 1;
    }
    assert_eq!(loaded, 25);
}

#[test]
fn counts_and_bounds() {
    // Triangles: sums of the index accessors' counts over 3 of all drawn nodes. Bounds: the min and max of
    // POSITION, moved by the nodes' matrices.
    type Row = (&'static str, usize, usize, usize, Option<([f32; 3], [f32; 3])>);
    let table: [Row; 8] = [
        ("Box", 12, 1, 0, Some(([-0.5; 3], [0.5; 3]))),
        ("BoxTextured", 12, 1, 1, Some(([-0.5; 3], [0.5; 3]))),
        ("Triangle", 1, 1, 0, Some(([0.0; 3], [1.0, 1.0, 0.0]))),
        ("TriangleWithoutIndices", 1, 1, 0, Some(([0.0; 3], [1.0, 1.0, 0.0]))),
        ("Fox", 576, 1, 1, None),
        ("WaterBottle", 4510, 1, 4, None),
        ("Suzanne", 3936, 1, 2, None),
        ("TextureTransformTest", 24, 12, 5, None),
    ];
    for (name, triangles, instances, images, bounds) in table {
        let Some(scene) = sample(name) else { return };
        assert_eq!(scene.triangle_count(), triangles, "{name}");
        assert_eq!(scene.instances.len(), instances, "{name}");
        assert_eq!(scene.images.len(), images, "{name}");
        if let Some((min, max)) = bounds {
            let found = scene.bounds_world().unwrap();
            assert!(crate::close(found.min, min) && crate::close(found.max, max), "{name}: {found:?}");
        }
    }
}

#[test]
fn a_sparse_accessor_replaces_three_positions() {
    let Some(scene) = sample("SimpleSparseAccessor") else { return };
    // The documentation's picture: vertices 8, 10 and 12 are raised to (1, 2), (3, 3) and (5, 4).
    let positions = &scene.meshes[0].positions;
    let find = |x: f32, y: f32| positions.iter().any(|p| p.abs_diff_eq(Vec3::new(x, y, 0.0), 1e-6));
    assert!(find(1.0, 2.0) && find(3.0, 3.0) && find(5.0, 4.0), "{positions:?}");
}

#[test]
fn a_texture_transform_points_the_arrow_at_the_marker() {
    let Some(scene) = sample("TextureTransformTest") else { return };
    let uv = |name: &str, marker: [f32; 2]| {
        let material = scene.materials.iter().find(|m| m.name == name).unwrap();
        // The quad reaches from -0.5 to 0.5, its texture coordinates from the upper left corner.
        material.base_color_texture.unwrap().uv(Vec2::new(0.5 + marker[0], 0.5 - marker[1]))
    };
    // The picture's arrow lies on u = v and ends at 0.69; the markers are the file's own, at its tip.
    let right = uv("Rotation", [-0.079_048, -0.516_267]);
    assert!((right.x - right.y).abs() < 1e-4 && right.x > 0.69, "{right}");
    let wrong = uv("Rotation", [0.516_267, 0.079_048]);
    assert!((wrong.x - wrong.y).abs() > 0.5, "{wrong}");
    let scaled = uv("Scale", [0.018_545, -0.018_545]);
    assert!((scaled.x - scaled.y).abs() < 1e-4 && (scaled.x - 0.778).abs() < 1e-3, "{scaled}");
    // Placed by hand in the file, to about a twentieth.
    let all = uv("All", [-0.07, -0.25]);
    assert!((all.x - all.y).abs() < 0.05 && all.x > 0.69, "{all}");
}

#[test]
fn cameras_of_both_kinds() {
    let Some(scene) = sample("Cameras") else { return };
    use ontile::scene::Projection as P;
    assert_eq!(
        scene.cameras[0].projection,
        P::Perspective { yfov_rad: 0.7, znear_m: 0.01, zfar_m: Some(100.0) }
    );
    assert_eq!(
        scene.cameras[1].projection,
        P::Orthographic { xmag_m: 1.0, ymag_m: 1.0, znear_m: 0.01, zfar_m: 100.0 }
    );
    assert!(crate::close(scene.cameras[0].world_from_view.w_axis.truncate(), [0.5, 0.5, 3.0]));
}

#[test]
fn a_skin_at_rest_leaves_the_bind_pose() {
    let Some(scene) = sample("SimpleSkin") else { return };
    // Joints at rest times inverse bind matrices are identities: the ribbon stands straight, 1 wide, 2 high.
    let bounds = scene.bounds_world().unwrap();
    assert!(crate::close(bounds.max - bounds.min, [1.0, 2.0, 0.0]), "{bounds:?}");
}

#[test]
fn a_morph_target_at_its_default_weight() {
    let Some(scene) = sample("SimpleMorph") else { return };
    // weights [0.5, 0.5]; targets move vertex 2 by (-1, 1) and (1, 1).
    let last = scene.meshes[0].positions.iter().copied().reduce(|a, b| if b.y > a.y { b } else { a });
    assert!(crate::close(last.unwrap(), [0.5, 1.5, 0.0]), "{last:?}");
}

#[test]
fn materials_of_samples() {
    let Some(scene) = sample("EmissiveStrengthTest") else { return };
    let strongest = scene.materials.iter().map(|m| m.emissive_factor.max_element()).fold(0.0, f32::max);
    assert!((strongest - 0.9 * 16.0).abs() < crate::F32_ROUNDING, "{strongest}");
    let Some(scene) = sample("UnlitTest") else { return };
    assert!(scene.materials.iter().all(|m| m.unlit) && scene.lights.is_empty());
    assert!(scene.meshes.iter().all(|m| m.normals.is_empty()));
    let Some(scene) = sample("AlphaBlendModeTest") else { return };
    let masks: Vec<_> = scene.materials.iter().map(|m| m.alpha_mode).collect();
    assert!(
        [AlphaMode::Mask { cutoff: 0.25 }, AlphaMode::Opaque, AlphaMode::Blend]
            .iter()
            .all(|m| masks.contains(m)),
        "{masks:?}"
    );
    let Some(scene) = sample("TextureSettingsTest") else { return };
    let wraps: Vec<_> = scene.textures.iter().map(|t| t.sampler.wrap_u).collect();
    for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
        assert!(wraps.contains(&wrap), "{wraps:?}");
    }
    assert!(scene.materials.iter().any(|m| m.double_sided));
}

#[test]
fn made_tangents_agree_with_given_ones() {
    // The bottle's normals were baked for the tangents in its file; leave these out and have them made.
    let Some(given) = sample("WaterBottle") else { return };
    let folder = models().unwrap().join("WaterBottle");
    let json = std::fs::read_to_string(folder.join("WaterBottle.gltf")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let attributes = json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
    attributes.remove("TANGENT").expect("the sample has tangents");
    let copy = tempfile::tempdir().unwrap();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, copy.path().join(path.file_name().unwrap())).unwrap();
    }
    let file = crate::gltf_build::write(copy.path(), "made.gltf", json.to_string().as_bytes());
    let made = Scene::load(&file).unwrap();
    let (given, made) = (&given.meshes[0], &made.meshes[0]);
    assert_eq!(given.indices.len(), made.indices.len());
    let mut agree = 0;
    for (&g, &m) in given.indices.iter().zip(&made.indices) {
        let (g, m) = (given.tangents[g as usize], made.tangents[m as usize]);
        agree += usize::from(g.w == m.w && g.truncate().dot(m.truncate()) > 0.9);
    }
    // Another program made the given ones, with other weights at seams and poles.
    let share = agree as f64 / given.indices.len() as f64;
    assert!(share > 0.95, "{share}");
}

#[test]
fn mirrored_instances_of_a_sample() {
    let Some(scene) = sample("NegativeScaleTest") else { return };
    // Four nodes with meshes scale by -1, and so do the parents of four: whoever has both is not mirrored, which
    // leaves the front, one of the first pair and one of each pair below such a parent.
    assert_eq!(scene.instances.iter().filter(|i| i.is_mirrored()).count(), 4);
}

//! Scenes out of glTF files.
use ontile::scene::Scene;
use std::path::PathBuf;

#[test]
fn probe() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/assets/models");
    for d in std::fs::read_dir(root).unwrap() {
        for f in std::fs::read_dir(d.unwrap().path()).unwrap() {
            let p = f.unwrap().path();
            if p.extension().is_some_and(|e| e == "glb" || e == "gltf") {
                let t = std::time::Instant::now();
                match Scene::load(&p) {
                    Ok(s) => println!(
                        "{}: {} meshes {} inst {} mats {} tex {} img {} tris {} lights {:?} {:?} {}ms",
                        s.name,
                        s.meshes.len(),
                        s.instances.len(),
                        s.materials.len(),
                        s.textures.len(),
                        s.images.len(),
                        s.triangle_count(),
                        s.lights.len(),
                        s.cameras.iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
                        s.warnings,
                        t.elapsed().as_millis()
                    ),
                    Err(e) => println!("FAIL {e}"),
                }
            }
        }
    }
}

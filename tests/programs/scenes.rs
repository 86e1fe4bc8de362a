//! The scenes in `assets/` and the program that makes them.

use super::bench::make_scenes::{Arguments, Shipped, check, run};
use clap::{Parser, ValueEnum};
use ontile::scene::{LightKind, Projection, Scene};
use std::fs;
use std::path::{Path, PathBuf};

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
}

fn load(path: &Path) -> Scene {
    Scene::load(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Runs the program with arguments separated by spaces.
fn make(arguments: &str) -> Result<(), String> {
    run(&Arguments::try_parse_from(["make_scenes"].into_iter().chain(arguments.split(' '))).unwrap())
}

#[test]
fn committed_scenes_are_what_the_program_makes() {
    assert_eq!(check(Shipped::value_variants(), &assets()).unwrap(), [""; 0]);
    let committed = fs::read_dir(assets()).unwrap().map(|entry| entry.unwrap().path());
    let committed = committed.filter(|path| path.extension().is_some_and(|e| e == "glb")).count();
    assert_eq!(committed, Shipped::value_variants().len(), "a scene that the program does not make");
}

#[test]
fn scenes_load_without_warnings_and_show_what_they_are_for() {
    let [courtyard, grid, interior, lamps, unlit] =
        ["courtyard", "grid", "interior", "lamps", "unlit"].map(|name| {
            let scene = load(&assets().join(name).with_extension("glb"));
            assert_eq!(scene.warnings, [""; 0], "{name}");
            scene.camera("main").unwrap_or_else(|error| panic!("{name}: {error}"));
            scene
        });
    assert!(courtyard.lights.len() > 40 && courtyard.textures.len() > 10);
    let front = grid.camera("front").unwrap();
    assert!(matches!(front.projection, Projection::Orthographic { .. }));
    let has = |scene: &Scene, wanted: fn(&LightKind) -> bool| scene.lights.iter().any(|l| wanted(&l.kind));
    assert!(has(&grid, |kind| matches!(kind, LightKind::Directional { .. })));
    assert!(has(&grid, |kind| matches!(kind, LightKind::Point { .. })));
    assert!(has(&grid, |kind| matches!(kind, LightKind::Spot { .. })));
    assert_eq!((interior.instances.len(), interior.lights.len()), (72, 9));
    assert!(
        interior
            .instances
            .iter()
            .all(|i| interior.materials[interior.meshes[i.mesh].material].normal_texture.is_some())
    );
    assert!(grid.textures.is_empty() && lamps.textures.is_empty());
    assert!(lamps.instances.iter().any(|instance| instance.is_mirrored()));
    assert!(lamps.materials.iter().any(|m| m.double_sided) && lamps.materials.iter().any(|m| m.unlit));
    assert!(unlit.lights.is_empty() && unlit.materials.iter().all(|m| m.unlit));
    assert!(!unlit.textures.is_empty());
}

#[test]
fn a_tampered_or_absent_scene_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().display();
    make(&format!("lamps unlit -o {output}")).unwrap();
    make(&format!("lamps unlit -o {output} --check")).unwrap();
    let path = folder.path().join("lamps.glb");
    let mut bytes = fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&path, bytes).unwrap();
    let problem = make(&format!("lamps unlit -o {output} --check")).unwrap_err();
    assert!(problem.contains("lamps.glb") && !problem.contains("unlit.glb"), "{problem}");
    let problem = make(&format!("unlit grid -o {output} --check")).unwrap_err();
    assert!(problem.contains("grid.glb") && !problem.contains("unlit.glb"), "{problem}");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn bench_scenes_have_what_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bench.glb");
    let bench = |options: &str| {
        make(&format!("bench {options} -o {}", path.display())).unwrap();
        let scene = load(&path);
        assert_eq!(scene.warnings, [""; 0], "{options}");
        scene
    };
    let scene = bench("--lights 17 --objects 30 --range 2.5");
    // The floor is one instance more.
    assert_eq!((scene.lights.len(), scene.instances.len()), (17, 31));
    assert!(scene.lights.iter().all(|light| light.range_m == Some(2.5)));
    assert!(scene.materials.len() < 30);
    let scene = bench("--lights 1 --objects 30 --distinct");
    assert_eq!((scene.materials.len(), scene.meshes.len()), (31, 31));

    bench("--lights 1 --objects 1 --megabytes 3");
    // The nearest number of textures: half of one of 512 by 512 incompressible RGB texels, and little else.
    const TOLERANCE_BYTES: f64 = 0.5e6;
    let size_bytes = fs::metadata(&path).unwrap().len() as f64;
    assert!((size_bytes - 3e6).abs() < TOLERANCE_BYTES, "{size_bytes}");
}

#[test]
fn the_canyon_is_four_large_meshes_under_one_sun() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("canyon.glb");
    make(&format!("canyon -o {}", path.display())).unwrap();
    let scene = load(&path);
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!((scene.instances.len(), scene.lights.len()), (4, 1));
    assert!(scene.meshes.iter().all(|mesh| mesh.indices.len() > 3 * 30_000));
    assert!(
        scene.materials.iter().all(|m| m.normal_texture.is_some() && m.metallic_roughness_texture.is_some())
    );
}

#[test]
fn arguments_that_make_no_sense_are_usage_errors() {
    for arguments in [
        "attic",
        "bench",
        "bench --lights 4 --objects 2",
        "canyon",
        "bench --lights -4 --objects 2 -o x.glb",
        "bench --lights 4 --objects 2 --range 0 -o x.glb",
        "bench --lights 4 --objects 2 --range inf -o x.glb",
        "--chekc",
    ] {
        let parsed = Arguments::try_parse_from(["make_scenes"].into_iter().chain(arguments.split(' ')));
        let exit_code = parsed.err().map(|error| error.exit_code());
        assert_eq!(exit_code, Some(2), "{arguments}");
    }
}

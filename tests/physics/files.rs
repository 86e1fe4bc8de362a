//! Scenes from files: the shipped ones, and Khronos sample models where they are at hand.

use std::path::{Path, PathBuf};

use ontile::reference::render;
use ontile::scene::Scene;

use crate::common::{ignored, ignored_unless_required};
use crate::error::Errors;
use crate::gpu::{Ask, Gpu};
use crate::textured;

/// The scene, or `None` after a line that says that the file is absent.
fn load(path: &Path, say_absent: fn(&str)) -> Option<Scene> {
    if !path.is_file() {
        say_absent(&format!("{} absent", path.display()));
        return None;
    }
    let scene = Scene::load(path).unwrap_or_else(|error| panic!("{error}"));
    // Tests of shadows know where their edges lie.
    Some(scene.without_shadows())
}

fn shipped(name: &str) -> Option<Scene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name);
    load(&path, ignored_unless_required)
}

/// One of Khronos' glTF sample models, from the folder beside the checkout or in `assets` of `ONTILE_SHARED`.
fn sample(name: &str) -> Option<Scene> {
    let assets = std::env::var_os("ONTILE_SHARED").filter(|path| !path.is_empty()).map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/assets"),
        |shared| PathBuf::from(shared).join("assets"),
    );
    let model = assets.join("models").join(name);
    let found = [format!("{name}.glb"), format!("{name}.gltf")]
        .map(|file| model.join(file))
        .into_iter()
        .find(|path| path.is_file());
    load(&found.unwrap_or(model), ignored)
}

#[test]
fn untextured_files_are_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let shipped = ["grid.glb", "lamps.glb"].map(shipped);
    let samples = ["Box", "BoxVertexColors", "NegativeScaleTest", "Suzanne"].map(sample);
    let mut failed = Vec::new();
    for mut scene in shipped.into_iter().chain(samples).flatten() {
        textured::without_textures(&mut scene);
        let camera = &scene.cameras[0];
        let rendered = gpu.render(&scene, camera, Ask::EXACT);
        let errors = Errors::of_display(&render(&scene, camera, &rendered.settings), &rendered.light());
        println!("{}: {errors}", scene.name);
        if let Err(reason) = errors.check() {
            failed.push(format!("{}: {reason}", scene.name));
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn textured_files_are_shaded_as_the_reference_does() {
    let Some(gpu) = Gpu::open() else { return };
    let samples = ["WaterBottle", "NormalTangentTest", "TextureTransformTest", "Suzanne"].map(sample);
    let mut failed = Vec::new();
    for mut scene in [shipped("courtyard.glb")].into_iter().chain(samples).flatten() {
        scene.cameras.truncate(1);
        for (name, errors) in textured::compare(&gpu, &scene, &scene) {
            println!("{name}: {errors}");
            if let Err(reason) = errors.check() {
                failed.push(format!("{name}: {reason}"));
            }
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

//! From the arguments to a scene and a camera.

use ontile::Result;
use ontile::scene::{Camera, Scene};

use super::args::SceneArgs;
use super::print;
use super::progress::Progress;

/// Loads the scene, applies what the arguments change, and tells the loader's warnings.
pub fn load(args: &SceneArgs) -> Result<Scene> {
    let progress = Progress::of(format!("loading {}", args.scene.display()));
    let mut scene = Scene::load(&args.scene)?;
    drop(progress);
    if let Some(ambient) = args.ambient {
        scene.ambient_nt = ontile::glam::Vec3::splat(ambient);
    }
    if args.no_shadows {
        scene = scene.without_shadows();
    }
    scene.keep_lights(args.max_lights, Some(args.max_shadows));
    for warning in &scene.warnings {
        print::warning(warning);
    }
    Ok(scene)
}

/// The camera that the arguments name; the first by default.
pub fn camera<'a>(scene: &'a Scene, args: &SceneArgs) -> Result<&'a Camera> {
    scene.camera(args.camera.as_deref().unwrap_or("0"))
}

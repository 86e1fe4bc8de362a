//! From the arguments to a scene and a camera.

use ontile::Result;
use ontile::glam::Vec3;
use ontile::scene::{Camera, Fog, Scene};

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
    scene.background = args.background.unwrap_or(scene.background);
    apply_fog(&mut scene, args);
    if args.no_shadows {
        scene = scene.without_shadows();
    }
    scene.keep_lights(args.max_lights, Some(args.max_shadows));
    for warning in &scene.warnings {
        print::warning(warning);
    }
    Ok(scene)
}

fn apply_fog(scene: &mut Scene, args: &SceneArgs) {
    if args.fog.is_none() && args.fog_color.is_none() && args.fog_height.is_none() {
        return;
    }
    let color_nt = Vec3::new(0.5, 0.6, 0.7);
    let own = scene.fog.unwrap_or(Fog { color_nt, density_per_m: 0.0, height: None });
    scene.fog = Some(Fog {
        density_per_m: args.fog.unwrap_or(own.density_per_m),
        color_nt: args.fog_color.unwrap_or(own.color_nt),
        height: args.fog_height.or(own.height),
    });
    if scene.fog.is_some_and(|fog| fog.density_per_m == 0.0) && args.fog.is_none() {
        print::warning(
            "--fog-color and --fog-height are without effect: the scene has no fog, and --fog gives none",
        );
    }
}

/// The camera that the arguments name; the first by default.
pub fn camera<'a>(scene: &'a Scene, args: &SceneArgs) -> Result<&'a Camera> {
    scene.camera(args.camera.as_deref().unwrap_or("0"))
}

//! From the arguments to a scene and a camera.

use ontile::environment::{Cache, DEFAULT_FACE_SIZE, TexelFormat};
use ontile::glam::Vec3;
use ontile::plan::{BloomWay, GBuffer, Options, Path};
use ontile::scene::{Background, Camera, Environment, Fog, Play, Scene};
use ontile::{Error, Result};

use super::args::{FarArgs, PlanArgs, SceneArgs};
use super::print;
use super::progress::Progress;

/// Loads the scene, applies what the arguments change, and tells the loader's warnings.
pub fn load(args: &SceneArgs) -> Result<Scene> {
    let progress = Progress::of(format!("loading {}", args.scene.display()));
    let scene = match (args.time, &args.animation) {
        (None, None) => Scene::load(&args.scene)?,
        (time, animation) => {
            let moving = Scene::load_moving(&args.scene)?;
            at(moving, time.unwrap_or(0.0), animation.as_deref().unwrap_or("0"))?
        }
    };
    drop(progress);
    changed(scene, args)
}

/// The same with what its animations move, where its file has some.
pub fn load_moving(args: &SceneArgs) -> Result<Scene> {
    let progress = Progress::of(format!("loading {}", args.scene.display()));
    let scene = Scene::load_moving(&args.scene)?;
    drop(progress);
    changed(scene, args)
}

fn changed(mut scene: Scene, args: &SceneArgs) -> Result<Scene> {
    if let Some(ambient) = args.ambient {
        scene.ambient_nt = ontile::glam::Vec3::splat(ambient);
    }
    read_environment(&mut scene, &args.far)?;
    scene.background = args.background.unwrap_or(scene.background);
    if scene.background == Background::Environment && scene.environment.is_none() {
        print::warning("the background is to be the environment, but there is none; it is black");
    }
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

/// The scene at a time of one of its animations, or of all.
fn at(mut scene: Scene, time_s: f64, animation: &str) -> Result<Scene> {
    let Some(motion) = &scene.motion else {
        let problem = format!("nothing of scene '{}' is animated, so that it has no --time", scene.name);
        return Err(Error::unsupported(
            problem,
            "leave out --time, or use a file whose animations move what is drawn",
        ));
    };
    let chosen = match animation {
        "all" => 0..motion.animations.len(),
        one => motion.animation(one).map(|one| one..one + 1)?,
    };
    scene.animate(&chosen.map(|animation| Play { animation, time_s }).collect::<Vec<_>>())?;
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

/// The environment that the arguments ask for.
pub fn read_environment(scene: &mut Scene, args: &FarArgs) -> Result<()> {
    if let Some(path) = &args.environment {
        let _progress = Progress::of(format!("loading {}", path.display()));
        let own = scene.environment.take();
        let read = Environment::load(path)?;
        // The scene may say how its environment lies and how bright it is, whichever it is.
        let (rotation_deg, intensity) =
            own.map_or((read.rotation_deg, read.intensity), |own| (own.rotation_deg, own.intensity));
        scene.environment = Some(Environment { rotation_deg, intensity, ..read });
        scene.drop_default_lights();
    }
    match &mut scene.environment {
        Some(environment) => {
            environment.rotation_deg = args.environment_rotation.unwrap_or(environment.rotation_deg);
            environment.intensity = args.environment_intensity.unwrap_or(environment.intensity);
            if let Some(problem) = environment.too_bright() {
                let what = format!("{}: its intensity {problem}", environment.name);
                return Err(Error::unsupported(what, "lower --environment-intensity"));
            }
        }
        None if args.environment_rotation.is_some() || args.environment_intensity.is_some() => {
            print::warning(
                "--environment-rotation and --environment-intensity are without effect: there is no environment",
            );
        }
        None => {}
    }
    Ok(())
}

/// Tells of flags for things that the scene and the path have not.
pub fn tell_idle_flags(scene: &Scene, args: &PlanArgs) {
    let default = Options::default();
    let idle = [
        (
            args.environment_format.is_some() && scene.environments().next().is_none(),
            "--environment-format",
            "there is no environment",
        ),
        (
            args.lightmap_format.is_some() && scene.lightmap.is_none(),
            "--lightmap-format",
            "there is no lightmap",
        ),
        (
            args.no_illumination_sets && args.path != Path::ForwardMultipass,
            "--no-illumination-sets",
            "the path is not forward-multipass",
        ),
        (
            args.bloom == BloomWay::Off
                && [args.bloom_strength, args.bloom_radius] != [default.bloom_strength, default.bloom_radius],
            "--bloom-strength or --bloom-radius",
            "--bloom is off",
        ),
        (
            args.samples == 1 && (args.edges, args.resolve) != (default.edges, default.resolve),
            "--edges or --resolve",
            "a pixel has one sample (--samples)",
        ),
    ];
    for (_, flag, why) in idle.iter().filter(|(is_idle, ..)| *is_idle) {
        print::warning(&format!("{flag} is without effect: {why}"));
    }
}

/// Tells that a part of the scene is further away than the G-buffer can say.
pub fn tell_distance(scene: &Scene, camera: &Camera, gbuffer: &GBuffer) {
    let Some(bounds) = scene.bounds_world() else { return };
    let eye = camera.world_from_view.w_axis.truncate();
    let farthest_m = (eye - bounds.min).abs().max((eye - bounds.max).abs()).length();
    if let Some(most_m) = gbuffer.farthest_m(&camera.projection).filter(|most_m| farthest_m > *most_m) {
        print::warning(&format!(
            "the scene reaches {farthest_m:.0} m from the camera, and the G-buffer has no places beyond {most_m:.0} m: what is there is \
             lit wrongly or not at all; use --depth d32, or a layout that stores depth"
        ));
    }
}

/// An error with the file that it is about.
pub fn about(file: &std::path::Path, error: Error) -> Error {
    match error {
        Error::Unsupported { what, remedy } => {
            Error::unsupported(format!("{}: {what}", file.display()), remedy)
        }
        named => named,
    }
}

/// Filters the scene's environments, or reads what an earlier run has kept of them.
pub fn prefilter(scene: &mut Scene, format: TexelFormat) {
    // One texture holds all.
    let filtered = scene.environments().find_map(|e| e.prefiltered.as_ref());
    let (format, size) = filtered.map_or((format, DEFAULT_FACE_SIZE), |p| (p.format(), p.face_size()));
    for environment in scene.environments_mut() {
        let _progress = Progress::of(format!("filtering {}", environment.name));
        environment.prefilter(size, format, Cache::of_user().as_ref());
    }
}

/// The camera that the arguments name; the first by default.
pub fn camera<'a>(scene: &'a Scene, args: &SceneArgs) -> Result<&'a Camera> {
    scene.camera(args.camera.as_deref().unwrap_or("0")).map_err(|e| about(&args.scene, e))
}

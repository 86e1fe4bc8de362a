//! Other ways to evaluate reflection: `fitted` is the reference's `fitted`, and `mediump` is as far from `exact` as half floats are.

use ontile::environment::TexelFormat;
use ontile::glam::Vec3;
use ontile::plan::{Brdf, Path};
use ontile::reference::{Settings, render};
use ontile::scene::{Camera, Scene};

use crate::around::{sky, under_sky};
use crate::error::Errors;
use crate::gpu::{Ask, Gpu, Rendered};
use crate::scenes;

fn against(brdf: Brdf, rendered: &Rendered, scene: &Scene, camera: &Camera) -> Errors {
    let settings = Settings { brdf, ..rendered.settings.clone() };
    Errors::of_display(&render(scene, camera, &settings), &rendered.light())
}

/// By lights alone, under ambient light, and under a sky.
fn all() -> Vec<Scene> {
    let ambient =
        Scene { ambient_nt: Vec3::new(0.5, 0.4, 0.3), name: "ambient".into(), ..scenes::materials() };
    let sky = under_sky(scenes::surfaces(), &sky(), TexelFormat::Rgba16F);
    vec![scenes::lights(), scenes::grazing(), scenes::surfaces(), ambient, sky]
}

#[test]
fn fitted_is_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let mut failed = Vec::new();
    for scene in all() {
        let camera = &scene.cameras[0];
        for path in [Path::Deferred, Path::Forward, Path::ForwardMultipass] {
            let rendered = gpu.render(&scene, camera, Ask { brdf: Brdf::Fitted, path, ..Ask::EXACT });
            let [fitted, exact] = [Brdf::Fitted, Brdf::Exact].map(|b| against(b, &rendered, &scene, camera));
            println!("{}, {path}: {fitted}; against exact: {exact}", scene.name);
            failed.extend(fitted.check().err().map(|e| format!("{}, {path}: {e}", scene.name)));
            assert!(exact.check().is_err(), "{}, {path}: not told from exact", scene.name);
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// What half floats may change light by, relatively, where roughness is at least this.
///
/// The lobe's slope is at most 2 / alpha (d ln D / d theta of (theta^2 + alpha^2)^-2), times how far n x h may be off: n, v, l, their
/// sum, its inverse length, h, and two products, each rounded by half of 2^-11. Then a rounding for each of the 16 variables between
/// there and the light, each half of 2^-10 at most.
fn bound(roughness: f32) -> f64 {
    const STEP: f64 = 1.0 / 2048.0;
    let alpha = f64::from(roughness).powi(2);
    2.0 / alpha * 8.0 * STEP / 2.0 + 16.0 * STEP
}

#[test]
fn half_floats_cost_what_their_steps_do() {
    let Some(gpu) = Gpu::open() else { return };
    let mut failed = Vec::new();
    // From the least that `mediump` has on.
    for (least, path) in [(0.0895, Path::Deferred), (0.3, Path::Deferred), (0.3, Path::Forward)] {
        for mut scene in all() {
            scene.materials.iter_mut().for_each(|m| m.roughness_factor = m.roughness_factor.max(least));
            let camera = &scene.cameras[0];
            let rendered = gpu.render(&scene, camera, Ask { brdf: Brdf::Mediump, path, ..Ask::EXACT });
            let errors = against(Brdf::Exact, &rendered, &scene, camera);
            println!("{}, {path}, roughness of {least} or more: {errors}", scene.name);
            failed.extend(errors.check_within(bound(least)).err());
            assert!(errors.check().is_err(), "{}: as exact as floats", scene.name);
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

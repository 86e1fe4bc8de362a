//! The choice of a G-buffer by a limit to its error: needs no device.

mod common;

use common::scenes;
use ontile::Error;
use ontile::measure::{ErrorMetric, Goal, PIXELS_PER_DEGREE, Probe, candidates_for, choose, flip};
use ontile::plan::{Choice, DepthStore, Layout, Limits, Needs, Options, Plan};
use ontile::reference::around::Method;
use ontile::reference::{Settings, render};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [480, 270];

fn options() -> Options {
    Options { size: SIZE, ..Options::default() }
}

fn scene(name: &str) -> Scene {
    let mut shipped = scenes::shipped().into_iter();
    shipped.find(|scene| scene.name == name).expect("a shipped scene of this name")
}

fn chosen(scene: &Scene, goal: Goal) -> Result<(Choice, u32, Plan), Error> {
    let limits = Limits::default();
    let chosen = choose(scene, &scene.cameras[0], &options(), 0.0, &limits, goal, &|_| Ok(()))?;
    assert!(goal.is_met_by(chosen.predicted.of(goal.metric)), "{goal}: {chosen:?}");
    let options = Options { gbuffer_why: chosen.why.clone(), ..chosen.choice.apply(&options()) };
    let plan = Plan::new(Needs::of(scene), options, &limits).unwrap();
    assert!(plan.to_string().contains(&chosen.why[0]), "the plan tells why");
    Ok((chosen.choice, plan.bytes_on_tile(), plan))
}

#[test]
fn a_stricter_limit_never_has_fewer_bytes_and_the_strictest_names_the_best() {
    let scene = scene("grid");
    for (metric, limits) in [
        (ErrorMetric::Flip, [0.2, 0.02, 0.01]),
        (ErrorMetric::Psnr, [20.0, 45.0, 52.0]),
        (ErrorMetric::Ciede, [20.0, 1.5, 0.9]),
    ] {
        let bytes = limits.map(|limit| chosen(&scene, Goal { metric, limit }).unwrap().1);
        assert!(bytes.is_sorted(), "{metric}: {bytes:?} for {limits:?}");
        // So lax that bytes alone decide.
        let plans = candidates_for(&Needs::of(&scene)).into_iter().filter_map(|choice| {
            Plan::new(Needs::of(&scene), choice.apply(&options()), &Limits::default()).ok()
        });
        assert_eq!(plans.map(|plan| plan.bytes_on_tile()).min(), Some(bytes[0]), "{metric}");
    }
    let error = chosen(&scene, Goal { metric: ErrorMetric::Flip, limit: 1e-6 }).unwrap_err().to_string();
    assert!(error.contains("the best is ") && error.contains("--max-error"), "{error}");
}

#[test]
fn what_a_scene_does_not_allow_is_not_chosen() {
    // Its lamps cast shadows, and its globes shine by themselves.
    let lax = Goal { metric: ErrorMetric::Flip, limit: 0.9 };
    let (choice, _, plan) = chosen(&scene("lamps"), lax).unwrap();
    assert!(!plan.needs.shadows.lights.is_empty() && !plan.needs.prelit.is_empty(), "{choice}");
    assert_ne!((choice.layout, choice.depth), (Layout::Ontile64, Some(DepthStore::D16)));
    assert_ne!(choice.depth, Some(DepthStore::D16), "{choice}");
    let error = chosen(&scenes::wholly_unlit(), lax).unwrap_err().to_string();
    assert!(error.contains("without a G-buffer"), "{error}");
}

/// The probe looks at windows of the picture; so much may they differ from the whole, as a factor.
const WINDOWS_MAY_MISS: f64 = 1.4;

#[test]
fn windows_stand_for_the_whole_picture() {
    for (name, layout) in [("grid", Layout::Metallic128), ("lamps", Layout::Metallic128)] {
        let scene = scene(name).without_shadows();
        let camera = &scene.cameras[0];
        let choice = Choice::of(layout);
        let plan = Plan::new(Needs::of(&scene), choice.apply(&options()), &Limits::default()).unwrap();
        let predicted = Probe::new(&scene, camera, &options(), 0.0).unwrap().error(&plan);

        let exact = Settings {
            size: SIZE,
            shadows: false,
            around: Method::Prefiltered(plan.options.environment_format),
            lightmap: Some(plan.options.lightmap_format),
            ..Settings::default()
        };
        let stored = Settings {
            gbuffer: Some(plan.gbuffer.clone()),
            light_target: plan.has_light_target(),
            light_scale: f64::from(plan.light_scale()),
            ..exact.clone()
        };
        let [exact, stored] = [exact, stored].map(|settings| render(&scene, camera, &settings));
        let shown = [&exact, &stored].map(|frame| frame.pixels.iter().map(|p| p.display).collect::<Vec<_>>());
        let errors = flip(&shown[0], &shown[1], SIZE, PIXELS_PER_DEGREE);
        let compared: Vec<_> =
            (0..errors.len()).filter(|&i| exact.pixels[i].covered && !exact.pixels[i].edge).collect();
        let whole = compared.iter().map(|&i| errors[i]).sum::<f64>() / compared.len() as f64;
        let factor = predicted.flip / whole;
        println!("{name}, {layout}: FLIP {whole:.4}, by windows {:.4}", predicted.flip);
        assert!(
            factor < WINDOWS_MAY_MISS && factor > 1.0 / WINDOWS_MAY_MISS,
            "{name}, {layout}: {predicted:?}, {whole}"
        );
    }
}

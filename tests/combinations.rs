//! Every two choices of a frame together, with each strategy: the picture is that of the plainest arrangement, bit for bit, or
//! the combination is refused with a reason and a remedy.

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use common::lavapipe::newer_lavapipe;
use common::pairs::pairwise;
use common::render::{Gpu, difference, on_device};
use common::scenes;
use ontile::Error;
use ontile::gpu::{RendererConfig, View};
use ontile::picture::Picture;
use ontile::plan::{
    BloomWay, DecalWay, Edges, Layout, LightWay, Limits, Needs, Options, OutputFormat, Path, Plan,
    Refraction, ResolveWay, Show, Strategy, Tonemap, Translucency,
};
use ontile::scene::{Scene, Shadow};

const SIZE: [u32; 2] = [96, 54];
const SEED: u64 = 5;

/// A choice of the frame, and whether the picture is the same whatever is chosen.
struct Choice {
    name: &'static str,
    keeps_picture: bool,
    values: Vec<Value>,
}

/// Name and effect.
type Value = (String, Box<dyn Fn(&mut Options)>);

fn choice<T: Copy + std::fmt::Debug + 'static>(
    name: &'static str,
    keeps_picture: bool,
    values: &[T],
    set: fn(&mut Options, T),
) -> Choice {
    let value = |&v: &T| -> Value { (format!("{v:?}"), Box::new(move |options| set(options, v))) };
    Choice { name, keeps_picture, values: values.iter().map(value).collect() }
}

/// All choices that are combined; a new one is a line. Scenes come first and are no part of the options.
fn choices(limits: &Limits) -> Vec<Choice> {
    let mut strategies = Strategy::EVERYWHERE.to_vec();
    strategies.extend(limits.merging.local_read.map(|()| Strategy::LocalRead));
    let ways = [LightWay::Fullscreen, LightWay::Volumes, LightWay::Stencil, LightWay::Clusters];
    let paths = [Path::Deferred, Path::Deferred, Path::Forward, Path::ForwardMultipass];
    vec![
        choice("strategy", true, &strategies, |o, v| o.strategy = v),
        choice("recycle", true, &[true, false], |o, v| o.recycle = v),
        choice("output is input", true, &[true, false], |o, v| o.output_is_input_attachment = v),
        choice("depth pre-pass", true, &[false, true], |o, v| o.depth_prepass = v),
        choice("layout", false, Layout::ALL, |o, v| o.layout = v),
        choice("lights", false, &ways, |o, v| o.lights = v),
        choice("decals", true, &[DecalWay::Auto, DecalWay::RasterOrder, DecalWay::Barrier], |o, v| {
            o.decals = v
        }),
        choice("translucency", false, Translucency::ALL, |o, v| o.translucency = v),
        choice(
            "bloom",
            false,
            &[BloomWay::Off, BloomWay::Off, BloomWay::Previous, BloomWay::Store],
            |o, v| {
                o.bloom = v;
            },
        ),
        choice("edge filter", false, &[false, false, false, true], |o, v| o.edge_filter = v),
        choice("refraction", false, &[Refraction::None, Refraction::Pass], |o, v| o.refraction = v),
        choice("shadow volumes", false, &[false, false, true], |o, v| o.shadow_volumes = v),
        choice("overlay", false, &[false, false, true], |o, v| o.overlay = v),
        choice(
            "show",
            false,
            &[Show::Picture, Show::Picture, Show::Channels, Show::Lights, Show::Edges],
            |o, v| {
                o.show = v;
            },
        ),
        choice("path", false, &paths, |o, v| o.path = v),
        choice("samples", false, &[1, 4], |o, v| o.samples = v),
        choice("resolve", false, ResolveWay::ALL, |o, v| o.resolve = v),
        choice("edges", false, Edges::ALL, |o, v| o.edges = v),
        choice("fold", false, &[true, false], |o, v| o.fold = v),
        choice("output", false, OutputFormat::ALL, |o, v| o.output = v),
        choice("tonemap", false, Tonemap::ALL, |o, v| o.tonemap = v),
    ]
}

/// [`scenes::lights_only`], each light with a shadow.
fn shadowed() -> Scene {
    let mut scene = Scene { name: "shadowed".into(), ..scenes::lights_only() };
    scene.lights.iter_mut().for_each(|light| light.shadow = Some(Shadow::default()));
    scene
}

/// The second frame, to which bloom has come.
fn picture(gpu: &Gpu<'_>, scene: &Scene, options: &Options) -> Picture {
    let mut offscreen = gpu.offscreen(scene, gpu.plan(scene, options.clone()), RendererConfig::default());
    let mut frame = || {
        offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 }).unwrap();
        offscreen.picture()
    };
    let first = frame();
    if options.bloom == BloomWay::Off { first } else { frame() }
}

/// Scenes that need different stages.
fn chosen_scenes() -> Vec<Scene> {
    vec![
        scenes::every_feature(),
        scenes::lights_only(),
        scenes::before_sky(),
        scenes::foggy(),
        scenes::lightmapped(),
        scenes::wholly_unlit(),
        scenes::decal_scenes::decals(),
        scenes::decal_scenes::decals_behind_glass(),
        scenes::glass_scenes::glass_in_fog(),
        scenes::media_scenes::water_and_more(),
        shadowed(),
    ]
}

/// The options of a row but for its scene, those of the plainest arrangement of the same picture, and what they are called.
fn arranged(choices: &[Choice], row: &[usize]) -> (Options, Options, String) {
    let mut arranged = Options { size: SIZE, ..Options::default() };
    let (mut plain, mut name) = (arranged.clone(), String::new());
    for (choice, &value) in choices.iter().zip(&row[1..]) {
        let (text, set) = &choice.values[value];
        set(&mut arranged);
        name += &format!(", {} {text}", choice.name);
        if !choice.keeps_picture {
            set(&mut plain);
        }
    }
    (arranged, plain, name)
}

/// Draws the combinations; returns how many there were, and which pairs of values the plan refuses whatever else is chosen.
fn draw(gpu: &Gpu<'_>) -> (usize, Vec<String>) {
    let limits = gpu.device().limits();
    let (scenes, choices) = (chosen_scenes(), choices(&limits));
    let needs: Vec<_> = scenes.iter().map(Needs::of).collect();
    let counts: Vec<_> =
        std::iter::once(scenes.len()).chain(choices.iter().map(|c| c.values.len())).collect();
    let allowed = |row: &[usize]| {
        let (arranged, _, name) = arranged(&choices, row);
        match Plan::new(needs[row[0]].clone(), arranged, &limits) {
            Ok(_) => true,
            Err(Error::Unsupported { .. }) => false,
            Err(error) => panic!("{}{name}: {error}", scenes[row[0]].name),
        }
    };
    let (rows, impossible) = pairwise(&counts, SEED, allowed);
    let mut plainest = BTreeMap::new();
    for row in &rows {
        let scene = &scenes[row[0]];
        let (arranged, plain, name) = arranged(&choices, row);
        println!("{}{name}", scene.name);
        let matters = |i: usize| i == 0 || !choices[i - 1].keeps_picture;
        let key: Vec<_> = (0..row.len()).filter(|&i| matters(i)).map(|i| row[i]).collect();
        let expected = plainest.entry(key).or_insert_with(|| picture(gpu, scene, &plain));
        if let Some(difference) = difference(expected, &picture(gpu, scene, &arranged)) {
            panic!("{}{name}: {difference}", scene.name);
        }
    }
    let told = |choice: usize, value: usize| match choice {
        0 => scenes[value].name.clone(),
        _ => format!("{} {}", choices[choice - 1].name, choices[choice - 1].values[value].0),
    };
    let refused = impossible.iter().map(|&(i, a, j, b)| format!("{} with {}", told(i, a), told(j, b)));
    (rows.len(), refused.collect())
}

#[test]
fn combinations_draw_what_the_plainest_arrangement_draws() {
    on_device(None, |gpu| {
        let (drawn, mut refused) = draw(gpu);
        let strategies = choices(&gpu.device().limits())[0].values.len();
        refused.sort();
        println!("{drawn} combinations, {strategies} strategies; refused: {refused:#?}");
    });
}

/// The same with the third strategy, on a device that has it.
#[test]
fn combinations_with_local_reads_draw_the_same() {
    let Some(mut run) = newer_lavapipe(&std::env::current_exe().unwrap()) else { return };
    let said = run_test(&mut run, "combinations_draw_what_the_plainest_arrangement_draws");
    assert!(said.contains("3 strategies"), "{said}");
}

fn run_test(command: &mut Command, name: &str) -> String {
    let output = command.args(["--exact", name, "--nocapture"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    said.into_owned()
}

#[test]
fn pairs_meet_and_a_seed_decides() {
    let values = [3, 2, 5, 4, 2];
    let (rows, impossible) = pairwise(&values, 1, |_| true);
    assert_eq!(impossible, []);
    for (i, j) in (0..5).flat_map(|j| (0..j).map(move |i| (i, j))) {
        for (a, b) in (0..values[i]).flat_map(|a| (0..values[j]).map(move |b| (a, b))) {
            assert!(
                rows.iter().any(|row| row[i] == a && row[j] == b),
                "{a} of {i} and {b} of {j} never meet"
            );
        }
    }
    // No fewer are possible than pairs of the two longest; the greedy way takes few more.
    assert!((20..30).contains(&rows.len()), "{}", rows.len());
    assert_eq!(rows, pairwise(&values, 1, |_| true).0);
    assert_ne!(rows, pairwise(&values, 2, |_| true).0);
    // What is refused is drawn with nothing, all else is.
    let refuses = |row: &[usize]| row[0] == 2 && row[2] > 1;
    let (rows, impossible) = pairwise(&values, 1, |row| !refuses(row));
    assert!(!rows.iter().any(|row| refuses(row)));
    assert_eq!(BTreeSet::from_iter(impossible), BTreeSet::from([(0, 2, 2, 2), (0, 2, 2, 3), (0, 2, 2, 4)]));
}

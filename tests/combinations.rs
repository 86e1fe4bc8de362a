//! Every two choices of a frame together, with each strategy: the picture is that of the plainest arrangement, bit for bit, or
//! the combination is refused with a reason and a remedy.

mod common;

use std::collections::BTreeMap;
use std::process::Command;

use common::lavapipe::newer_lavapipe;
use common::pairs::pairwise;
use common::render::{Gpu, difference, on_device};
use common::scenes;
use ontile::Error;
use ontile::plan::{
    Edges, Layout, LightWay, Limits, Needs, Options, OutputFormat, Path, Plan, ResolveWay, Strategy, Tonemap,
};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [96, 54];
const SEED: u64 = 5;

/// Of all combinations, refused ones included: what a layout or a way cannot do is refused with all that it is paired with.
const LEAST_DRAWN_SHARE: f64 = 0.5;

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
        choice("path", false, &paths, |o, v| o.path = v),
        choice("samples", false, &[1, 4], |o, v| o.samples = v),
        choice("resolve", false, ResolveWay::ALL, |o, v| o.resolve = v),
        choice("edges", false, Edges::ALL, |o, v| o.edges = v),
        choice("fold", false, &[true, false], |o, v| o.fold = v),
        choice("output", false, OutputFormat::ALL, |o, v| o.output = v),
        choice("tonemap", false, Tonemap::ALL, |o, v| o.tonemap = v),
    ]
}

/// Scenes that need different stages; shadows aside, which are drawn alike before all of them.
fn chosen_scenes() -> Vec<Scene> {
    vec![
        scenes::every_feature(),
        scenes::lights_only(),
        scenes::before_sky(),
        scenes::foggy(),
        scenes::lightmapped(),
        scenes::wholly_unlit(),
    ]
}

/// Draws the combinations; returns how many there were, and how many were refused.
fn draw(gpu: &Gpu<'_>) -> [usize; 2] {
    let limits = gpu.device().limits();
    if limits.merging.local_read.is_ok() {
        // Layers of 1.4 (seen with 309 and 363; 1.3.239 does not) report a hazard of a render pass where a subpass depends on two
        // earlier ones and the nearer orders an attachment by itself. Renderings have no subpasses: nothing of theirs is excused,
        // and render passes are watched by the same test on the machine's own layer.
        gpu.excuse(" in subpass ");
    }
    let (scenes, choices) = (chosen_scenes(), choices(&limits));
    let counts: Vec<_> =
        std::iter::once(scenes.len()).chain(choices.iter().map(|c| c.values.len())).collect();
    let mut plainest = BTreeMap::new();
    let rows = pairwise(&counts, SEED);
    let mut refused = 0;
    for row in &rows {
        let scene = &scenes[row[0]];
        let mut arranged = Options { size: SIZE, ..Options::default() };
        let mut plain = arranged.clone();
        let mut key = vec![row[0]];
        let mut name = scene.name.clone();
        for (choice, &value) in choices.iter().zip(&row[1..]) {
            let (text, set) = &choice.values[value];
            set(&mut arranged);
            name += &format!(", {} {text}", choice.name);
            if !choice.keeps_picture {
                set(&mut plain);
                key.push(value);
            }
        }
        println!("{name}");
        match Plan::new(Needs::of(scene), arranged.clone(), &limits) {
            Ok(_) => {}
            Err(Error::Unsupported { .. }) => {
                refused += 1;
                continue;
            }
            Err(error) => panic!("{name}: {error}"),
        }
        let picture = |options: &Options| gpu.picture(scene, gpu.plan(scene, options.clone()), 0.0);
        let expected = plainest.entry(key).or_insert_with(|| picture(&plain));
        if let Some(difference) = difference(expected, &picture(&arranged)) {
            panic!("{name}: {difference}");
        }
    }
    [rows.len(), refused]
}

#[test]
fn combinations_draw_what_the_plainest_arrangement_draws() {
    on_device(None, |gpu| {
        let [all, refused] = draw(gpu);
        let strategies = choices(&gpu.device().limits())[0].values.len();
        println!("{all} combinations, {refused} of them refused, {strategies} strategies");
        assert!((all - refused) as f64 >= LEAST_DRAWN_SHARE * all as f64, "{refused} of {all} refused");
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
    let rows = pairwise(&values, 1);
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
    assert_eq!(rows, pairwise(&values, 1));
    assert_ne!(rows, pairwise(&values, 2));
}

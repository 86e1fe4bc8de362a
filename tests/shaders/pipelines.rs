//! What pipelines are provided with is what their shaders mention: a scene that has none of a thing pays nothing for it.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use ontile::gpu::PipelineParts;
use ontile::gpu::shader::{Module, Specialization, prune, shared};
use ontile::plan::{
    BloomWay, Brdf, DepthStore, Gamma, Layout, LightFormat, LightWay, Limits, Needs, Normals, Options, Path,
    Plan, Show, Strategy,
};

use rspirv::spirv::Capability;

use super::common::scenes;
use super::reflect::Reflection;
use super::{bytes, invalid};

/// Every way to draw every kind of scene.
fn plans() -> Vec<(String, Plan)> {
    let default = Options::default;
    let ways = [LightWay::Fullscreen, LightWay::Clusters, LightWay::Volumes, LightWay::Stencil];
    let paths = [Path::Forward, Path::ForwardMultipass];
    let mut options: Vec<_> = ways.map(|lights| Options { lights, ..default() }).into();
    options.extend(paths.map(|path| Options { path, ..default() }));
    options.extend([
        Options { lights: LightWay::Clusters, path: Path::Forward, depth_prepass: true, ..default() },
        Options { layout: Layout::Exact, fold: false, ..default() },
        Options { strategy: Strategy::Separate, ..default() },
        Options { bloom: BloomWay::Previous, ..default() },
        Options { edge_filter: true, ..default() },
        Options { shadow_volumes: true, ..default() },
        Options { overlay: true, ..default() },
        Options { bloom: BloomWay::Store, path: Path::ForwardMultipass, ..default() },
    ]);
    options.extend(Layout::ALL.iter().map(|&layout| Options { layout, ..default() }));
    let layout = Layout::Specular160;
    options.extend(Normals::ALL.iter().map(|&n| Options { normals: Some(n), ..default() }));
    options.extend(Gamma::ALL.iter().map(|&g| Options { layout, gamma: Some(g), ..default() }));
    options.extend(DepthStore::ALL.iter().map(|&d| Options { layout, depth: Some(d), ..default() }));
    options.extend(LightFormat::ALL.iter().map(|&l| Options { layout, light_target: Some(l), ..default() }));
    let brdf = [Brdf::Fitted, Brdf::Mediump].into_iter();
    options.extend(brdf.clone().map(|brdf| Options { brdf, ..default() }));
    options.extend(brdf.map(|brdf| Options { brdf, path: Path::Forward, ..default() }));
    let mut plans = shown();
    for scene in scenes::built() {
        let needs = Needs::of(&scene);
        for options in &options {
            // Not every scene is drawn in every way.
            let limits = Limits { depth_clamp: true, ..Limits::default() };
            if let Ok(plan) = Plan::new(needs.clone(), options.clone(), &limits) {
                plans.push((format!("{} with {options:?}", scene.name), plan));
            }
        }
    }
    plans
}

/// All that can be shown of all layouts.
fn shown() -> Vec<(String, Plan)> {
    let mut plans = Vec::new();
    let limits = Limits { max_color_attachments: 8, max_input_attachments: 8, ..Limits::default() };
    for scene in [scenes::every_feature(), scenes::lights_only(), scenes::decal_scenes::decals()] {
        let needs = Needs::of(&scene);
        for &layout in Layout::ALL {
            for &show in &Show::ALL[1..] {
                for (samples, lights) in [(1, LightWay::Fullscreen), (4, LightWay::Clusters)] {
                    let options = Options { layout, show, samples, lights, ..Options::default() };
                    if let Ok(plan) = Plan::new(needs.clone(), options.clone(), &limits) {
                        plans.push((format!("{} with {options:?}", scene.name), plan));
                    }
                }
            }
        }
    }
    plans
}

/// Where a pipeline's shaders differ from what they are provided with.
fn problems(parts: &PipelineParts) -> Vec<String> {
    let vertex = Reflection::new(&parts.shaders.vertex);
    let fragment = parts.shaders.fragment.as_deref().map(Reflection::new);
    let shaders = || std::iter::once(&vertex).chain(&fragment);
    let mut problems = Vec::new();
    let mut compare = |what: &str, provided: String, mentioned: String| {
        if provided != mentioned {
            problems.push(format!("{what}: provided {provided}, mentioned {mentioned}"));
        }
    };
    let bindings: BTreeMap<_, _> = shaders().flat_map(Reflection::bindings).collect();
    compare("bindings", format!("{:?}", parts.bindings), format!("{bindings:?}"));
    compare("attributes", format!("{:?}", parts.attributes), format!("{:?}", vertex.input_locations()));
    let read = fragment.as_ref().map(Reflection::input_locations).unwrap_or_default();
    compare("varyings", format!("{:?}", vertex.output_locations()), format!("{read:?}"));
    let targets: BTreeSet<_> = (0..parts.targets).collect();
    let written = fragment.as_ref().map(Reflection::output_locations).unwrap_or_default();
    compare("targets", format!("{targets:?}"), format!("{written:?}"));
    let pushes = shaders().any(Reflection::has_push_constants);
    compare("push constants", parts.push_constants.to_string(), pushes.to_string());
    let inputs = shaders().any(|shader| shader.has_capability(Capability::InputAttachment));
    let has_inputs = shaders().any(Reflection::has_input_attachments);
    compare("capability of input attachments", inputs.to_string(), has_inputs.to_string());
    problems
}

/// Without what a pipeline shares with others: its material's set, which is bound once and of which passes read more or less, and
/// the G-buffer, which has all attachments of its layout, though where no light has a place or a shadow nothing reads depth.
fn without_shared(plan: &Plan, mut parts: PipelineParts) -> PipelineParts {
    const TEXTURES: (u32, u32) = (shared("SET_MATERIAL"), shared("BINDING_TEXTURES"));
    const INPUTS: u32 = shared("SET_INPUTS");
    let Some(fragment) = &parts.shaders.fragment else { return parts };
    let mentioned = Reflection::new(fragment).bindings();
    let is_read = |at: &(u32, u32)| mentioned.iter().any(|(mentioned, _)| mentioned == at);
    if plan.options.path == Path::ForwardMultipass && !is_read(&TEXTURES) {
        parts.bindings.remove(&TEXTURES);
    }
    if parts.name.starts_with("lighting") {
        parts.bindings.retain(|at, _| at.0 != INPUTS || is_read(at));
    }
    if parts.name.starts_with("edges") {
        // It writes the stencil alone.
        parts.targets = 0;
    }
    parts
}

#[test]
fn pipelines_provide_what_their_shaders_mention_and_no_more() {
    let mut seen = BTreeSet::new();
    for (name, plan) in plans() {
        for parts in PipelineParts::of(&plan).unwrap() {
            let parts = without_shared(&plan, parts);
            assert_eq!(problems(&parts), Vec::<String>::new(), "{name}: {}", parts.name);
            for spirv in std::iter::once(&parts.shaders.vertex).chain(&parts.shaders.fragment) {
                if seen.insert(spirv.clone())
                    && let Some(problem) = invalid(&bytes(spirv))
                {
                    assert_eq!(problem, "", "{name}: {}", parts.name);
                }
            }
        }
    }
    assert!(seen.len() > 150, "only {} shaders differ", seen.len());
}

#[test]
fn pipelines_that_provide_something_else_are_reported() {
    let plan =
        Plan::new(Needs::of(&scenes::every_feature()), Options::default(), &Limits::default()).unwrap();
    let all = PipelineParts::of(&plan).unwrap();
    let lighting = all.iter().find(|parts| parts.name.starts_with("lighting")).unwrap();
    assert_eq!(problems(lighting), Vec::<String>::new());
    type Change = fn(&mut PipelineParts);
    let changes: [(&str, Change); 7] = [
        ("bindings", |parts| parts.bindings.retain(|at, _| *at != (0, 0))),
        ("bindings", |parts| parts.bindings.extend([((0, 15), 1)])),
        ("bindings", |parts| *parts.bindings.values_mut().last().unwrap() += 1),
        ("attributes", |parts| parts.attributes.extend([0])),
        ("targets", |parts| parts.targets += 1),
        ("push constants", |parts| parts.push_constants = true),
        // A module as it was compiled mentions whatever any scene has.
        ("bindings", |parts| {
            parts.shaders.fragment = Some(Module::Lighting.spirv().unwrap().to_vec());
        }),
    ];
    for (what, change) in changes {
        let mut changed = lighting.clone();
        change(&mut changed);
        let problems = problems(&changed);
        assert!(problems.iter().any(|problem| problem.starts_with(what)), "{what}: {problems:?}");
    }
}

/// `cargo test --release --test shaders how_long -- --ignored --nocapture` prints it.
#[test]
#[ignore = "measures, and checks nothing"]
fn how_long_specialisation_takes() {
    let plans = plans();
    for (name, plan) in plans.iter().filter(|(name, _)| name.starts_with("every_feature ")) {
        let (start, parts) = (Instant::now(), PipelineParts::of(plan).unwrap());
        let shaders =
            parts.iter().map(|parts| 1 + usize::from(parts.shaders.fragment.is_some())).sum::<usize>();
        let words =
            parts.iter().map(|p| p.shaders.vertex.len() + p.shaders.fragment.as_ref().map_or(0, Vec::len));
        let (took, bytes) = (start.elapsed(), 4 * words.sum::<usize>());
        println!("{took:?}: {shaders} shaders of {} pipelines, {bytes} bytes left: {name}", parts.len());
    }
    for module in Module::ALL {
        let (spirv, constants) = (module.spirv().unwrap(), Specialization::default());
        let times = (0..50).map(|_| {
            let start = Instant::now();
            prune(module.name(), spirv, &constants, None).unwrap();
            start.elapsed()
        });
        println!("{:?}: {}, {} bytes", times.min().unwrap(), module.name(), 4 * spirv.len());
    }
}

//! What pipelines are provided with is what their shaders mention: a scene that has none of a thing pays nothing for it.

use std::collections::BTreeSet;

use ontile::gpu::PipelineParts;
use ontile::plan::{Layout, LightWay, Limits, Needs, Options, Path, Plan, Strategy};

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
    ]);
    let mut plans = Vec::new();
    for scene in scenes::built() {
        let needs = Needs::of(&scene);
        for options in &options {
            // Not every scene is drawn in every way.
            if let Ok(plan) = Plan::new(needs.clone(), options.clone(), &Limits::default()) {
                plans.push((format!("{} with {options:?}", scene.name), plan));
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
    let bindings: std::collections::BTreeMap<_, _> = shaders().flat_map(Reflection::bindings).collect();
    compare("bindings", format!("{:?}", parts.bindings), format!("{bindings:?}"));
    compare("attributes", format!("{:?}", parts.attributes), format!("{:?}", vertex.input_locations()));
    let read = fragment.as_ref().map(Reflection::input_locations).unwrap_or_default();
    compare("varyings", format!("{:?}", vertex.output_locations()), format!("{read:?}"));
    let targets: BTreeSet<_> = (0..parts.targets).collect();
    let written = fragment.as_ref().map(Reflection::output_locations).unwrap_or_default();
    compare("targets", format!("{targets:?}"), format!("{written:?}"));
    let pushes = shaders().any(Reflection::has_push_constants);
    compare("push constants", format!("{}", parts.push_constants), format!("{pushes}"));
    problems
}

#[test]
fn pipelines_are_provided_with_what_their_shaders_mention() {
    let (mut seen, mut all) = (BTreeSet::new(), BTreeSet::new());
    for (name, plan) in plans() {
        for parts in PipelineParts::of(&plan).unwrap() {
            for p in problems(&parts) {
                all.insert(format!("{name}: {}: {p}", parts.name));
            }
            for spirv in std::iter::once(&parts.shaders.vertex).chain(&parts.shaders.fragment) {
                if seen.insert(spirv.clone())
                    && let Some(problem) = invalid(&bytes(spirv))
                {
                    assert_eq!(problem, "", "{name}: {}", parts.name);
                }
            }
        }
    }
    println!("{} {}", seen.len(), all.len());
    for a in all {
        println!("{a}");
    }
}

//! What a device has of a scene is what `ontile plan --explain` lists, and nothing beside it.

use std::collections::BTreeMap;

use super::common::render::{Gpu, on_device};
use super::common::scenes;
use ontile::gpu::{Explained, ExplainedKind, Explanation, RendererConfig};
use ontile::plan::{BloomWay, Brdf, Edges, LightWay, Options, Path, Plan, Show, Strategy};
use ontile::scene::Scene;

/// How many there are of each name.
type Names = BTreeMap<String, usize>;

fn names<'a>(all: impl Iterator<Item = &'a str>) -> Names {
    let mut names = Names::new();
    all.for_each(|name| *names.entry(name.to_owned()).or_default() += 1);
    names
}

/// Buffers that every frame slot has of its own.
const OF_A_SLOT: [&str; 13] = [
    "overlay vertices",
    "overlay indices",
    "poses",
    "decals",
    "particles",
    "volume caster instances",
    "frame",
    "instances",
    "lights",
    "light lists",
    "lightmap parts",
    "shadow views",
    "casters",
];

/// What the test's own host makes beside the renderer's objects.
const OF_HOST: [(&str, &str); 2] = [("image", "output"), ("buffer", "readback")];

/// How what is explained and what a device has differ.
fn differences(
    plan: &Plan,
    explained: &[Explained],
    live: &BTreeMap<String, Names>,
    slots: usize,
) -> Vec<String> {
    let of = |kinds: &[ExplainedKind]| {
        let listed = explained.iter().filter(|object| kinds.contains(&object.kind));
        names(listed.map(|object| object.name.as_str()))
    };
    let mut images = of(&[ExplainedKind::Attachment, ExplainedKind::Image]);
    // The host's.
    images.remove(&plan.attachments[0].name);
    let mut buffers = of(&[ExplainedKind::Buffer]);
    buffers.iter_mut().filter(|(name, _)| OF_A_SLOT.contains(&name.as_str())).for_each(|(_, n)| *n *= slots);
    let mut passes = of(&[ExplainedKind::Pass]);
    if plan.shadow_map.is_some() {
        passes.insert("shadow tile".into(), 1);
    }
    let expected = [
        ("image", images),
        ("buffer", buffers),
        ("pipeline", of(&[ExplainedKind::Pipeline])),
        ("render_pass", passes),
    ];
    let mut differences = Vec::new();
    for (kind, expected) in expected {
        let mut created = live.get(kind).cloned().unwrap_or_default();
        for (_, name) in OF_HOST.iter().filter(|(of, _)| *of == kind) {
            created.remove(*name);
        }
        if created != expected {
            differences.push(format!("{kind}: created {created:?}, explained {expected:?}"));
        }
    }
    differences
}

/// What is wrong with the explanation of a scene, or with what is created for it.
pub fn problems(gpu: &Gpu<'_>, scene: &Scene, options: Options) -> Vec<String> {
    const SLOTS: usize = 2;
    let what =
        format!("{} {} {} {} {}", scene.name, options.path, options.lights, options.strategy, options.brdf);
    let plan = gpu.plan(scene, options);
    let explained = Explanation::new(scene, &plan).unwrap().objects;
    let unexplained = |object: &&Explained| {
        let Explained { name, why, .. } = object;
        let incomplete = |text: &str| text.is_empty() || text.contains("''") || text.contains("(no light)");
        incomplete(name) || incomplete(why) || name.contains("(without a name)")
    };
    let mut problems: Vec<_> =
        explained.iter().filter(unexplained).map(|o| format!("{what}: {o:?}")).collect();
    let config = RendererConfig { frames_in_flight: SLOTS, ..RendererConfig::default() };
    let offscreen = gpu.offscreen(scene, plan.clone(), config);
    let live = gpu.device().live_by_name();
    drop(offscreen);
    problems.extend(differences(&plan, &explained, &live, SLOTS).iter().map(|d| format!("{what}: {d}")));
    problems
}

#[test]
fn what_is_created_is_what_is_explained() {
    on_device(None, |gpu| {
        let small = || Options { size: [64, 36], ..Options::default() };
        let mut all = Vec::new();
        let samples = scenes::sample_files().into_iter().map(|file| Scene::load(&file).unwrap());
        for scene in scenes::built().into_iter().chain(scenes::shipped()).chain(samples) {
            all.extend(problems(gpu, &scene, small()));
        }
        let shadowed = [scenes::shadow_scenes::shadows(), scenes::shadow_scenes::chosen()];
        for scene in [scenes::every_feature(), scenes::foggy_lights()].into_iter().chain(shadowed) {
            for options in [
                Options { strategy: Strategy::Separate, ..small() },
                Options { path: Path::Forward, depth_prepass: true, ..small() },
                Options { path: Path::ForwardMultipass, ..small() },
                Options { lights: LightWay::Stencil, ..small() },
                Options { bloom: BloomWay::Previous, ..small() },
                Options { shadow_volumes: true, ..small() },
                Options { overlay: true, ..small() },
                Options { show: Show::Channels, ..small() },
                Options { show: Show::Lights, lights: LightWay::Clusters, ..small() },
                Options { show: Show::Edges, samples: 4, ..small() },
                Options { samples: 4, edges: Edges::All, ..small() },
                Options { samples: 4, edges: Edges::Coverage, ..small() },
                Options { bloom: BloomWay::Store, strategy: Strategy::Separate, ..small() },
                Options { brdf: Brdf::Fitted, ..small() },
                Options { brdf: Brdf::Fitted, path: Path::Forward, ..small() },
            ] {
                all.extend(problems(gpu, &scene, options));
            }
        }
        assert!(all.is_empty(), "{}", all.join("\n"));
    });
}

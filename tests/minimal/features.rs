//! Features added one at a time to as little as can be drawn: each costs what this file says, pairs cost no more than both.

use std::collections::BTreeSet;

use super::common::render::on_device;
use super::common::scenes::{one_lit_triangle, one_unlit_triangle};
use joint::is_joint;
use ontile::gpu::{ExplainedKind, Explanation};
use ontile::plan::{Edges, Limits, Needs, Options, Path, Plan};
use ontile::scene::Scene;
use table::{Feature, LIT, OF_BOTH, OF_LIT, OF_UNLIT, UNLIT};

#[path = "joint.rs"]
mod joint;
#[path = "table.rs"]
mod table;

/// What exists, by kind and name. Pipelines go by what they do, without what sets those of a sort apart.
type Objects = BTreeSet<String>;

/// With what shadow volumes take.
pub fn limits() -> Limits {
    Limits { depth_clamp: true, max_color_attachments: 8, ..Limits::default() }
}

pub fn objects(scene: &Scene, options: &Options) -> Objects {
    let plan = Plan::new(Needs::of(scene), options.clone(), &limits());
    let plan = plan.unwrap_or_else(|error| panic!("{}: {error}", scene.name));
    let sort = |pipeline: &str| {
        let sorts = [
            "surface unlit",
            "surface lit",
            "shadow caster",
            "shadow volume",
            "edges",
            "shadow clear",
            "shadow compose",
            "lighting",
            "tonemap",
            "sky",
            "decal",
            "fog",
            "blended surface",
            "particles",
            "medium",
            "absorption",
            "poses",
        ];
        if pipeline.starts_with("light, where its shadow volumes are not") {
            return "shadowed light".to_owned();
        }
        let known = sorts.iter().chain(&["depth"]).find(|sort| pipeline.starts_with(*sort));
        known.unwrap_or_else(|| panic!("{pipeline}")).to_string()
    };
    let explained = Explanation::new(scene, &plan).unwrap().objects;
    let named = explained.iter().flat_map(|object| {
        let name = object.name.split([' ', '[']).next().unwrap_or_default();
        let of = object.of.as_deref().map(sort).unwrap_or_default();
        match object.kind {
            // Which resources share an attachment is another matter.
            ExplainedKind::Attachment => object.name.split('/').map(|n| format!("attachment {n}")).collect(),
            ExplainedKind::Pass => Vec::new(),
            ExplainedKind::Subpass => vec![format!("subpass {}", object.name)],
            ExplainedKind::Pipeline => vec![format!("pipeline {}", sort(&object.name))],
            ExplainedKind::Attribute => vec![format!("{of}: attribute {}", object.name)],
            ExplainedKind::Binding if name == "textures" => vec![format!("{of}: binding textures")],
            ExplainedKind::Binding if name == "input" => {
                let resources = object.name["input ".len()..].split('/');
                resources.filter(|n| *n != "output").map(|n| format!("{of}: input {n}")).collect()
            }
            ExplainedKind::Binding => vec![format!("{of}: binding {}", object.name)],
            ExplainedKind::Push => vec![format!("{of}: push constants")],
            ExplainedKind::Constant => vec![format!("{of}: {name}")],
            ExplainedKind::Image => vec![format!("image {}", object.name)],
            ExplainedKind::Buffer => vec![format!("buffer {}", object.name)],
        }
    });
    named.collect()
}

fn listed(text: &str) -> impl Iterator<Item = String> + '_ {
    text.split(", ").filter(|name| !name.is_empty()).map(|name| name.trim().to_owned())
}

struct Base {
    name: &'static str,
    scene: fn() -> Scene,
    objects: &'static str,
    own: &'static [Feature],
    sort: &'static str,
}

fn unlit() -> Scene {
    let mut scene = one_unlit_triangle();
    scene.materials[0].name = "paper".into();
    scene
}

fn lit() -> Scene {
    let mut scene = one_lit_triangle();
    scene.lights.truncate(1);
    scene
}

const BASES: [Base; 2] = [
    Base { name: "unlit", scene: unlit, objects: UNLIT, own: OF_UNLIT, sort: "surface unlit:" },
    Base { name: "lit", scene: lit, objects: LIT, own: OF_LIT, sort: "surface lit:" },
];

impl Base {
    fn features(&self) -> impl Iterator<Item = &'static Feature> {
        OF_BOTH.iter().chain(self.own)
    }

    fn with(&self, features: &[&Feature]) -> Scene {
        let mut scene = (self.scene)();
        features.iter().for_each(|feature| (feature.add)(&mut scene));
        let names: Vec<_> = features.iter().map(|feature| feature.name).collect();
        scene.name = format!("{} triangle with {}", self.name, names.join(" and "));
        scene
    }

    fn expected(&self, feature: &Feature) -> Objects {
        let mut expected: Objects = listed(self.objects).collect();
        for name in listed(feature.instead_of) {
            assert!(expected.remove(&name), "{}: {name}", feature.name);
        }
        let costs = feature.cost.iter().flat_map(|cost| listed(cost));
        expected.extend(costs.map(|name| match name.strip_prefix("lit:") {
            Some(rest) => format!("{}{rest}", self.sort),
            None => name,
        }));
        expected
    }
}

fn difference(actual: &Objects, expected: &Objects) -> String {
    let more: Vec<_> = actual.difference(expected).collect();
    let less: Vec<_> = expected.difference(actual).collect();
    if more.is_empty() && less.is_empty() {
        String::new()
    } else {
        format!("too much {more:?}, missing {less:?}")
    }
}

#[test]
fn each_feature_costs_its_own() {
    let options = Options::default();
    let mut wrong = Vec::new();
    for base in &BASES {
        let bare = objects(&base.with(&[]), &options);
        assert_eq!(difference(&bare, &listed(base.objects).collect()), "", "{}", base.name);
        for feature in base.features() {
            let scene = base.with(&[feature]);
            let problem = difference(&objects(&scene, &options), &base.expected(feature));
            if !problem.is_empty() {
                wrong.push(format!("{}: {problem}", scene.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn pairs_cost_no_more_than_both() {
    let options = Options::default();
    let mut wrong = Vec::new();
    for base in &BASES {
        let features: Vec<_> = base.features().collect();
        let alone: Vec<_> = features.iter().map(|f| objects(&base.with(&[f]), &options)).collect();
        for (i, first) in features.iter().enumerate() {
            for (j, second) in features.iter().enumerate().skip(i + 1) {
                let scene = base.with(&[first, second]);
                let both: Objects = alone[i].union(&alone[j]).cloned().collect();
                let actual = objects(&scene, &options);
                let more = actual.difference(&both).filter(|object| !is_joint([*first, *second], object));
                let more: Vec<_> = more.collect();
                if !more.is_empty() {
                    wrong.push(format!("{}: {more:?}", scene.name));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn features_are_created_as_explained() {
    on_device(None, |gpu| {
        let options = Options { size: [32, 16], ..Options::default() };
        let mut wrong = Vec::new();
        for base in &BASES {
            for feature in base.features() {
                wrong.extend(super::created::problems(gpu, &base.with(&[feature]), options.clone()));
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    });
}

/// The least of all: one subpass, one attachment, on every path.
#[test]
fn one_unlit_triangle_is_one_subpass_with_one_attachment() {
    for &path in Path::ALL {
        let plan = Plan::new(Needs::of(&unlit()), Options { path, ..Options::default() }, &Limits::default())
            .unwrap();
        assert_eq!((plan.attachments.len(), plan.stage_count(), plan.pipelines.len()), (1, 1, 1), "{path}");
    }
}

/// Four samples: what marks edges and lights them, and nothing where all are lit.
#[test]
fn samples_cost_what_their_edges_take() {
    let bare = objects(&lit(), &Options::default());
    let mut wrong = Vec::new();
    for (edges, more) in
        [(Edges::All, &[][..]), (Edges::Compare, &[MARKED]), (Edges::Coverage, &[MARKED, COVERED])]
    {
        let costly = objects(&lit(), &Options { samples: 4, edges, ..Options::default() });
        let mut expected = bare.clone();
        expected.extend(more.iter().chain(&[SAMPLED]).flat_map(|more| listed(more)));
        let problem = difference(&costly, &expected);
        if !problem.is_empty() {
            wrong.push(format!("{edges}: {problem}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

const SAMPLED: &str = "attachment output_samples, lighting: PER_SAMPLE";
const MARKED: &str = "attachment depth_stencil_test, pipeline edges, edges: SAMPLE_COUNT, edges: input base_metallic, \
                      edges: input depth, edges: input normal_roughness";
const COVERED: &str = "attachment edge, surface lit: EDGE_TARGET, surface lit: SAMPLE_COUNT, edges: EDGE_TARGET, \
                       edges: input edge, lighting: input edge";

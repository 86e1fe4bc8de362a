//! The pass that media which bend light take: where there is one, and what is refused.

mod common;

use common::scenes;
use ontile::plan::{Edges, Layout, Limits, Needs, Options, Plan, Refraction};
use ontile::scene::Scene;

fn plan(scene: &Scene, options: Options) -> Plan {
    // Where decals change light from all around, occlusion has an attachment beside four others.
    let limits = Limits { max_color_attachments: 8, ..Limits::default() };
    Plan::new(Needs::of(scene), options, &limits).unwrap()
}

/// A frame in which no light is bent is the same with and without; and what is refused has a remedy.
#[test]
fn it_is_a_pass_where_something_bends_light() {
    let bent = Options { refraction: Refraction::Pass, ..Options::default() };
    for scene in scenes::built() {
        let (with, without) = (plan(&scene, bent.clone()), plan(&scene, Options::default()));
        let bends = with.needs.refracts.is_some() && with.needs.opaque_triangles() > 0;
        assert_eq!(with.refracts(), bends, "{}", scene.name);
        assert_eq!(with.passes.len(), if bends { 2 } else { 1 }, "{}", scene.name);
        let of = |plan: &Plan| (plan.passes.clone(), plan.attachments.clone(), plan.pipelines.clone());
        assert_eq!(of(&with) == of(&without), !bends, "{}", scene.name);
    }
    let water = scenes::media_scenes::water();
    let refused =
        |options| Plan::new(Needs::of(&water), options, &Limits::default()).unwrap_err().to_string();
    // What is stored and sampled is of all samples; marks of edges would be beside depth.
    let all = Options { edges: Edges::All, ..bent.clone() };
    let bytes = |samples| plan(&water, Options { samples, ..all.clone() }).bytes_moved() - 4;
    assert_eq!([bytes(1), bytes(4)], [24, 96]);
    let split = refused(Options { layout: Layout::Rasa128, ..bent.clone() });
    assert!(split.contains("rasa128 keeps diffuse light apart"), "{split}");
    let mut thin = water;
    thin.materials.iter_mut().filter_map(|m| m.transmission.as_mut()).for_each(|t| t.thickness_m = 0.0);
    let thin = plan(&thin, bent);
    assert!(!thin.refracts() && thin.to_string().contains("nothing has both a thickness"), "{thin}");
}

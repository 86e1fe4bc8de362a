//! Plans as they are printed, against files that people have read, and figures that were derived by hand.

mod common;

use common::expected::Expected;
use common::{environments, scenes};
use ontile::plan::{
    BloomWay, Brdf, DecalWay, DepthStore, Gamma, Layout, LightFormat, LightWay, Limits, Merging, Needs,
    Normals, Options, OutputFormat, Path, Plan, Refraction, Show, Strategy,
};
use ontile::scene::Scene;

fn plan(scene: &Scene, options: Options) -> Plan {
    // Where decals change light from all around, occlusion has an attachment beside four others.
    let needs = Needs::of(scene);
    let max_color_attachments = if needs.occlusion.is_some() { 8 } else { 4 };
    let limits = Limits { max_color_attachments, max_input_attachments: 8, ..Limits::default() };
    Plan::new(needs, options, &limits).unwrap_or_else(|e| panic!("{}: {e}", scene.name))
}

fn separate() -> Options {
    Options { strategy: Strategy::Separate, ..Options::default() }
}

fn by(lights: LightWay) -> Options {
    Options { lights, ..Options::default() }
}

fn bloom(bloom: BloomWay) -> Options {
    Options { bloom, ..Options::default() }
}

fn forward() -> Options {
    Options { path: Path::Forward, ..Options::default() }
}

/// The first line that differs.
fn difference(expected: &str, actual: &str) -> Option<String> {
    if expected == actual {
        return None;
    }
    let lines = expected.lines().zip(actual.lines()).enumerate().find(|(_, (e, a))| e != a);
    Some(match lines {
        Some((i, (e, a))) => format!("line {}:\n  expected {e}\n  actual   {a}", i + 1),
        None => format!("{} lines expected, {} printed", expected.lines().count(), actual.lines().count()),
    })
}

/// Every snapshot's name and text.
fn printed() -> Vec<(String, String)> {
    let features = scenes::every_feature();
    let lights = scenes::lights_only();
    let decals = scenes::decal_scenes::decals();
    let default = Options::default;
    let mut plans = vec![
        ("lit".to_owned(), plan(&lights, default())),
        ("lit_no_fold".into(), plan(&lights, Options { fold: false, ..default() })),
        ("emissive".into(), plan(&scenes::emissive(), default())),
        ("emissive_separate".into(), plan(&scenes::emissive(), separate())),
        ("every_feature_exact".into(), plan(&features, Options { layout: Layout::Exact, ..default() })),
        ("every_feature_no_recycle".into(), plan(&features, Options { recycle: false, ..default() })),
        (
            "every_feature_output_not_input".into(),
            plan(&features, Options { output_is_input_attachment: false, ..default() }),
        ),
        ("every_feature_kept".into(), plan(&features, Options { keep_gbuffer: true, ..default() })),
        ("every_feature_forward".into(), plan(&features, forward())),
        (
            "every_feature_forward_prepass".into(),
            plan(&features, Options { depth_prepass: true, ..forward() }),
        ),
        (
            "every_feature_multipass".into(),
            plan(&features, Options { path: Path::ForwardMultipass, ..default() }),
        ),
        ("environment".into(), plan(&environments::environment(), default())),
        ("probes".into(), plan(&environments::probes(), default())),
        ("environment_forward".into(), plan(&environments::environment_alone(), forward())),
        (
            "environment_fitted".into(),
            plan(&environments::environment(), Options { brdf: Brdf::Fitted, ..default() }),
        ),
        ("lit_mediump".into(), plan(&lights, Options { brdf: Brdf::Mediump, ..default() })),
        ("lit_clusters".into(), plan(&lights, by(LightWay::Clusters))),
        ("lit_volumes".into(), plan(&lights, by(LightWay::Volumes))),
        ("lit_stencil".into(), plan(&lights, by(LightWay::Stencil))),
        (
            "emissive_stencil_separate".into(),
            plan(&scenes::emissive(), Options { lights: LightWay::Stencil, ..separate() }),
        ),
        ("emissive_volumes_packed128".into(), in_words(&scenes::emissive(), Strategy::Subpasses)),
        ("emissive_volumes_packed128_separate".into(), in_words(&scenes::emissive(), Strategy::Separate)),
        ("emissive_bloom_previous".into(), plan(&scenes::emissive(), bloom(BloomWay::Previous))),
        ("lit_bloom_store".into(), plan(&lights, bloom(BloomWay::Store))),
        ("no_lights_clusters".into(), plan(&scenes::no_lights(), by(LightWay::Clusters))),
        ("unlit".into(), plan(&scenes::wholly_unlit(), default())),
        ("unlit_triangle".into(), plan(&scenes::one_unlit_triangle(), default())),
        ("foggy".into(), plan(&scenes::foggy(), default())),
        ("foggy_separate".into(), plan(&scenes::foggy(), separate())),
        ("foggy_lights".into(), plan(&scenes::foggy_lights(), default())),
        ("foggy_unlit".into(), plan(&scenes::foggy_unlit(), default())),
        ("lightmapped".into(), plan(&scenes::lightmapped(), default())),
        ("lightmapped_alone".into(), plan(&scenes::lightmapped_alone(), default())),
        ("before_sky".into(), plan(&scenes::before_sky(), default())),
        ("sky_unlit".into(), plan(&scenes::sky_unlit(), default())),
        ("decals".into(), plan(&decals, default())),
        ("decals_separate".into(), plan(&decals, separate())),
        (
            "decals_ordered_packed128".into(),
            ordered(&decals, Options { layout: Layout::Packed128, ..default() }),
        ),
        ("decals_blended".into(), plan(&scenes::decal_scenes::color_decals(), default())),
        ("water".into(), plan(&scenes::media_scenes::water(), default())),
        (
            "water_refraction".into(),
            plan(
                &scenes::media_scenes::water_and_more(),
                Options { refraction: Refraction::Pass, ..default() },
            ),
        ),
        ("water_and_more".into(), plan(&scenes::media_scenes::water_and_more(), default())),
        ("sparks".into(), plan(&scenes::particle_scenes::sparks(), default())),
        ("sparks_alone_separate".into(), plan(&scenes::particle_scenes::sparks_alone(), separate())),
        ("emissive_local_read".into(), local_read(&scenes::emissive(), LightWay::Auto)),
        ("emissive_local_read_stencil".into(), local_read(&scenes::emissive(), LightWay::Stencil)),
    ];
    let shown = |show, samples| plan(&features, Options { show, samples, ..default() });
    plans.push(("every_feature_show_channels".into(), shown(Show::Channels, 1)));
    plans.push(("every_feature_show_edges".into(), shown(Show::Edges, 4)));
    let samples = Options { samples: 4, ..default() };
    plans.push(("shipped_stop_4_samples".into(), plan(&scenes::tram_stop(), samples)));
    for scene in scenes::shipped() {
        for &strategy in &Strategy::EVERYWHERE {
            let name = format!("shipped_{}_{strategy}", scene.name);
            plans.push((name, plan(&scene, Options { strategy, ..default() })));
        }
    }
    plans.into_iter().map(|(name, plan)| (format!("{name}.txt"), plan.to_string())).collect()
}

#[test]
fn plans_print_as_expected() {
    let mut expected = Expected::in_folder("plans");
    let printed = printed();
    for (name, text) in &printed {
        expected.check(name, text.as_bytes(), |file| difference(&String::from_utf8_lossy(file), text));
    }
    expected.nothing_else(&printed.into_iter().map(|(name, _)| name).collect::<Vec<_>>());
    expected.finish();
}

#[test]
fn missing_changed_and_rewritten_files_fail() {
    let folder = tempfile::tempdir().unwrap();
    let problems = |update, text: &str| {
        let mut expected = Expected::new(folder.path(), update);
        expected.check("a.txt", text.as_bytes(), |file| difference(&String::from_utf8_lossy(file), text));
        expected.problems().join("\n")
    };
    assert!(problems(false, "one\ntwo\n").contains("ONTILE_UPDATE"), "a missing file passes");
    assert!(!folder.path().join("a.txt").exists(), "a missing file is written without being asked");
    assert!(problems(true, "one\ntwo\n").contains("rewritten"), "the run that writes a file passes");
    assert_eq!(problems(false, "one\ntwo\n"), "");
    assert!(problems(false, "one\n2\n").contains("line 2"), "a changed line passes");
    assert!(problems(false, "one\n").contains("2 lines expected"), "a cut file passes");
    assert!(problems(true, "one\n").contains("rewritten"));
    assert_eq!(problems(true, "one\n"), "", "an update that changes nothing fails");
    let mut expected = Expected::new(folder.path(), false);
    expected.nothing_else(&["b.txt".into()]);
    assert!(expected.problems()[0].contains("a.txt"), "a file that nothing expects passes");
}

/// Passes, subpasses, bytes loaded and stored a pixel, colour bits at most on the tile.
fn totals(plan: &Plan) -> [u32; 5] {
    let traffic: Vec<_> = (0..plan.attachments.len()).map(|a| plan.traffic(a)).collect();
    let sum = |way: usize| traffic.iter().map(|t| t[way]).sum();
    let subpasses = || plan.passes.iter().flat_map(|p| &p.subpasses);
    let bits = subpasses().map(|s| s.live_color_bits).max().unwrap_or(0);
    [plan.passes.len() as u32, subpasses().count() as u32, sum(0), sum(1), bits]
}

#[test]
fn totals_are_those_derived_by_hand() {
    let emissive = scenes::emissive();
    let lit = scenes::lights_only();
    let unlit = scenes::wholly_unlit();

    // One pass. The tile holds depth, normal+roughness, base+metallic, which is the output's image too, and light:
    // 4 * 32 bits. Only the output's 4 bytes leave it.
    assert_eq!(totals(&plan(&emissive, Options::default())), [1, 3, 0, 4, 128]);
    // The output has an attachment of its own, but it is written last, when only light is left: still 4 * 32 bits live.
    assert_eq!(totals(&plan(&emissive, Options { recycle: false, ..Options::default() })), [1, 3, 0, 4, 128]);
    // Folded: depth, normal+roughness and base+metallic are read while the output is written: 4 * 32 bits. No light.
    assert_eq!(totals(&plan(&lit, Options::default())), [1, 2, 0, 4, 128]);
    // Nothing but the output.
    assert_eq!(totals(&plan(&unlit, Options::default())), [1, 1, 0, 4, 32]);
    // A float output is 16 bytes and cannot be base+metallic's image: 3 * 32 + 32 of light at most before tonemap,
    // then light and output: 32 + 128.
    let float = Options { output: OutputFormat::Rgba32Float, ..Options::default() };
    assert_eq!(totals(&plan(&emissive, float)), [1, 3, 0, 16, 160]);
    // exact: depth 32, normal+roughness 128, base+metallic 128, light 128; the output comes when only light is left.
    let exact = Options { layout: Layout::Exact, ..Options::default() };
    assert_eq!(totals(&plan(&emissive, exact)), [1, 3, 0, 4, 416]);

    // geometry stores depth, normal+roughness, base+metallic and light: 4 * 4 = 16 bytes; lighting loads those 16 and
    // stores light, 4; tonemap loads light, 4, and stores the output, 4. Loads 16 + 4, stores 16 + 4 + 4. The depth
    // test ends with geometry.
    assert_eq!(totals(&plan(&emissive, separate())), [3, 3, 20, 24, 128]);
    // Folded: geometry stores 3 * 4 = 12; lighting loads them and stores the output, 4.
    assert_eq!(totals(&plan(&lit, separate())), [2, 2, 12, 16, 128]);
    // exact: geometry stores 4 + 16 + 16 + 16 = 52; lighting loads 52 and stores light, 16; tonemap loads 16, stores 4.
    let exact = Options { layout: Layout::Exact, ..separate() };
    assert_eq!(totals(&plan(&emissive, exact)), [3, 3, 68, 72, 416]);
}

#[test]
fn a_wrong_operation_changes_the_totals() {
    use ontile::plan::{Load, Store};
    let mut broken = plan(&scenes::emissive(), Options::default());
    let attachment = broken.passes[0].attachments.iter_mut().find(|a| a.store == Store::DontCare).unwrap();
    attachment.store = Store::Store;
    assert_eq!(totals(&broken), [1, 3, 0, 8, 128]);
    let mut broken = plan(&scenes::emissive(), separate());
    let mut attachments = broken.passes[2].attachments.iter_mut();
    attachments.find(|a| a.load == Load::Load).unwrap().load = Load::Clear;
    assert_eq!(totals(&broken), [3, 3, 16, 24, 128]);
}

#[test]
fn recycling_keeps_the_pass_at_128_declared_bits() {
    let declared = |recycle| {
        let plan = plan(&scenes::every_feature(), Options { recycle, ..Options::default() });
        let colors = plan.attachments.iter().filter(|a| !a.format.is_depth());
        colors.map(|a| a.format.bits()).sum::<u32>()
    };
    assert_eq!(declared(true), 128);
    assert_eq!(declared(false), 160);
}

#[test]
fn a_plan_has_no_more_than_the_scene_needs() {
    let names =
        |plan: &Plan| -> Vec<_> { plan.passes.iter().flat_map(|p| &p.subpasses).map(|s| s.name).collect() };
    let unlit = plan(&scenes::one_unlit_triangle(), Options::default());
    assert_eq!(names(&unlit), ["geometry"]);
    assert_eq!(unlit.attachments.len(), 1, "one triangle needs no depth test");
    let lit = plan(&scenes::lights_only(), Options::default());
    assert_eq!(names(&lit), ["geometry", "lighting"]);
    assert!(lit.attachments.iter().all(|a| a.name != "light"));
    let emissive = plan(&scenes::emissive(), Options::default());
    assert_eq!(names(&emissive), ["geometry", "lighting", "tonemap"]);
    assert!(emissive.attachments.iter().any(|a| a.name == "light"));
}

#[test]
fn auto_paths_follow_how_many_lights_reach_a_point() {
    let mut scene = scenes::no_lights();
    let sun = scenes::lights_only().lights[0].clone();
    let mut path_by = |strategy, suns, on_chip, keep_gbuffer| {
        scene.lights = vec![sun.clone(); suns];
        let options = Options { path: Path::Auto, keep_gbuffer, strategy, ..Options::default() };
        let limits = Limits { gbuffer_on_chip: on_chip, ..Limits::default() };
        let plan = Plan::new(Needs::of(&scene), options, &limits).unwrap();
        assert!(
            plan.to_string().contains(&format!("path: {}, since", plan.path)),
            "the plan does not say why"
        );
        plan.path
    };
    let separate = [20, 21].map(|n| path_by(Strategy::Separate, n, true, false));
    assert_eq!(separate, [Path::Forward, Path::Deferred], "separate passes store a G-buffer on every device");
    let mut path = |suns, on_chip, keep| path_by(Strategy::Subpasses, suns, on_chip, keep);
    assert_eq!([2, 3].map(|n| path(n, true, false)), [Path::Forward, Path::Deferred]);
    assert_eq!([20, 21].map(|n| path(n, false, false)), [Path::Forward, Path::Deferred]);
    assert_eq!(path(1, true, true), Path::Deferred, "forward has no G-buffer to keep");
    for lights in [LightWay::Volumes, LightWay::Stencil] {
        let options = Options { path: Path::Auto, lights, ..Options::default() };
        assert_eq!(
            plan(&scenes::lights_only(), options.clone()).path,
            Path::Deferred,
            "{lights} need a G-buffer"
        );
        // Nothing to add: no way is wrong.
        for path in [Path::Auto, Path::Deferred, Path::Forward] {
            assert_eq!(plan(&scenes::no_lights(), Options { path, ..options.clone() }).path, Path::Forward);
        }
    }
}

/// Lights added one by one to words, on a device that has the feature.
/// As a rendering, on a device that has local reads.
fn local_read(scene: &Scene, lights: LightWay) -> Plan {
    let merging = Merging { local_read: Ok(()), ..Merging::default() };
    let options = Options { strategy: Strategy::LocalRead, lights, ..Options::default() };
    Plan::new(Needs::of(scene), options, &Limits { merging, ..Limits::default() }).unwrap()
}

#[test]
fn local_read_is_refused_with_the_reason_and_chosen_where_it_is_best() {
    let plan = |strategy, layout, merging, most| {
        let limits = Limits { merging, max_color_attachments: most, ..Limits::default() };
        let options = Options { strategy, layout, ..Options::default() };
        Plan::new(Needs::of(&scenes::emissive()), options, &limits)
    };
    let has = |best| Merging { local_read: Ok(()), best, why: "it is told so" };
    let named = |merging, layout, most| plan(Strategy::LocalRead, layout, merging, most);
    let refused = |made: ontile::Result<Plan>| made.unwrap_err().to_string();
    let error = refused(named(Merging::default(), Layout::Metallic128, 8));
    assert!(error.contains("VK_KHR_dynamic_rendering_local_read") && error.contains("subpasses"), "{error}");
    // One more than a stage of it writes at once.
    let many = Layout::Exact;
    let error = refused(named(has(Strategy::LocalRead), many, 4));
    assert!(error.contains("all 5 colour attachments") && error.contains("allows 4"), "{error}");
    assert!(named(has(Strategy::LocalRead), many, 8).is_ok());
    assert!(plan(Strategy::Subpasses, many, has(Strategy::LocalRead), 4).is_ok());

    let auto = |merging, layout, most| plan(Strategy::Auto, layout, merging, most).unwrap();
    for best in [Strategy::LocalRead, Strategy::Subpasses] {
        let made = auto(has(best), Layout::Metallic128, 4);
        assert_eq!(made.strategy, best);
        assert!(made.notes.contains(&format!("strategy: {best}, since it is told so")), "{:?}", made.notes);
    }
    assert_eq!(auto(Merging::default(), Layout::Metallic128, 4).strategy, Strategy::Subpasses);
    // Where the best does not go, the next best does.
    let made = auto(has(Strategy::LocalRead), many, 4);
    assert_eq!(made.strategy, Strategy::Subpasses);
    assert!(made.notes.iter().any(|note| note.contains("all 5 colour attachments")), "{:?}", made.notes);
}

fn in_words(scene: &Scene, strategy: Strategy) -> Plan {
    let lights = LightWay::Volumes;
    ordered(scene, Options { layout: Layout::Packed128, lights, strategy, ..Options::default() })
}

/// On a device whose fragments are in order.
fn ordered(scene: &Scene, options: Options) -> Plan {
    let limits = Limits { ordered_attachment_access: true, max_color_attachments: 8, ..Limits::default() };
    Plan::new(Needs::of(scene), options, &limits).unwrap()
}

#[test]
fn decals_are_ordered_as_the_device_and_the_layout_allow() {
    let [all, colors] = [scenes::decal_scenes::decals(), scenes::decal_scenes::color_decals()];
    let way = |scene: &Scene, layout, decals, ordered_attachment_access| {
        let limits = Limits { ordered_attachment_access, max_color_attachments: 8, ..Limits::default() };
        let options = Options { layout, decals, ..Options::default() };
        Plan::new(Needs::of(scene), options, &limits).map(|plan| plan.decal_way.unwrap())
    };
    let (metallic, packed) = (Layout::Metallic128, Layout::Packed128);
    for (scene, layout, ordered, expected) in [
        (&all, metallic, true, DecalWay::RasterOrder),
        (&all, metallic, false, DecalWay::Barrier),
        (&colors, metallic, true, DecalWay::Fixed),
        (&colors, packed, true, DecalWay::RasterOrder),
        (&colors, Layout::Specular160, false, DecalWay::Barrier),
    ] {
        assert_eq!(
            way(scene, layout, DecalWay::Auto, ordered).unwrap(),
            expected,
            "{}, {layout}",
            scene.name
        );
    }
    for (scene, layout, asked, parts) in [
        (&all, metallic, DecalWay::RasterOrder, ["rasterization-order", "--decals barrier"]),
        (&all, metallic, DecalWay::Fixed, ["decal '", "--decals barrier"]),
        (&colors, packed, DecalWay::Fixed, ["words of integers", "--decals barrier"]),
        (&colors, Layout::Rasa128, DecalWay::Fixed, ["products", "--decals barrier"]),
    ] {
        let error = way(scene, layout, asked, false).unwrap_err().to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
    for path in [Path::Forward, Path::ForwardMultipass] {
        let error = Plan::new(Needs::of(&all), Options { path, ..Options::default() }, &Limits::default());
        let error = error.unwrap_err().to_string();
        assert!(error.contains("painted over a G-buffer") && error.contains("--path deferred"), "{error}");
    }
    assert_eq!(plan(&all, Options { path: Path::Auto, ..Options::default() }).path, Path::Deferred);
}

#[test]
fn light_in_words_is_added_to_only_where_fragments_are_in_order() {
    for layout in [Layout::Metallic256, Layout::Specular256, Layout::Packed128] {
        for lights in [LightWay::Volumes, LightWay::Stencil] {
            let options = Options { layout, lights, ..Options::default() };
            let error = Plan::new(Needs::of(&scenes::lights_only()), options, &Limits::default());
            let error = error.unwrap_err().to_string();
            for part in ["VK_EXT_rasterization_order_attachment_access", "--lights clusters", "ontile128"] {
                assert!(error.contains(part), "{error}");
            }
        }
    }
}

#[test]
fn same_needs_options_and_limits_give_the_same_plan() {
    for scene in scenes::built() {
        for &strategy in &Strategy::EVERYWHERE {
            let options = Options { strategy, ..Options::default() };
            let [a, b] = [(); 2].map(|()| plan(&scene.clone(), options.clone()));
            assert_eq!(a, b, "{}", scene.name);
            assert_eq!(a.to_string(), b.to_string(), "{}", scene.name);
        }
    }
}

#[test]
fn dither_needs_an_output_that_is_rounded() {
    for &output in OutputFormat::ALL {
        let options = Options { dither: true, output, ..Options::default() };
        let made = Plan::new(Needs::of(&scenes::lights_only()), options, &Limits::default());
        match output {
            OutputFormat::Rgba8Srgb | OutputFormat::Bgra8Srgb => assert!(made.is_ok(), "{output}"),
            OutputFormat::Rgba16Float | OutputFormat::Rgba32Float => {
                let error = made.unwrap_err().to_string();
                assert!(error.contains(output.name()) && error.contains("PNG"), "{error}");
            }
        }
    }
}

#[test]
fn choices_without_effect_are_refused_and_costly_ones_warned_of() {
    let plan =
        |scene: ontile::scene::Scene, options| Plan::new(Needs::of(&scene), options, &Limits::default());
    let layout = |layout| Options { layout, ..Options::default() };
    let refused = [
        ("--normals", Options { normals: Some(Normals::Oct8), ..layout(Layout::Packed128) }),
        ("--gamma", Options { gamma: Some(Gamma::Power20), ..layout(Layout::Dissertation192) }),
        ("--light-target", Options { light_target: Some(LightFormat::Rgba16f), ..layout(Layout::Ontile64) }),
        ("--depth", Options { depth: Some(DepthStore::D16), ..layout(Layout::Thibieroz128) }),
        ("--no-fold", Options { fold: false, ..layout(Layout::Packed128) }),
        ("emissive", layout(Layout::Ontile64)),
    ];
    for (what, options) in refused {
        let layout = options.layout;
        let error = plan(scenes::every_feature(), options).unwrap_err().to_string();
        assert!(error.contains(what) && error.contains(layout.name()), "{what}: {error}");
    }
    let few = Limits { max_input_attachments: 2, ..Limits::default() };
    let error = Plan::new(Needs::of(&scenes::lights_only()), layout(Layout::Thibieroz96), &few).unwrap_err();
    assert!(error.to_string().contains("input attachments"), "{error}");

    let coarse = |lights| Options { lights, light_target: Some(LightFormat::Rgb10a2), ..Options::default() };
    let warnings = |lights| plan(scenes::every_feature(), coarse(lights)).unwrap().warnings;
    assert!(warnings(LightWay::Volumes).iter().any(|w| w.contains("--light-target")));
    assert!(warnings(LightWay::Clusters).iter().all(|w| !w.contains("--light-target")));
}

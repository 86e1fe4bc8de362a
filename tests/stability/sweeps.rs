//! Every case of every sweep is within its bound, or the renderer answers it.

use ontile::gpu::HeadlessOptions;
use ontile::measure::stability::{Bench, Findings, Lab, Scale, Study, Sweep, Verdict};

use crate::common::ignored_unless_required;

/// Runs a sweep at its small size and checks its cases; says "ignored" without a device if it needs one.
fn run(name: &str) -> Option<Findings> {
    let sweep = Sweep::named(name).unwrap_or_else(|| panic!("no sweep '{name}'"));
    let bench = if sweep.needs_device {
        let options = HeadlessOptions {
            device_name_part: None,
            validate: true,
            application_name: "ontile tests".into(),
            ..HeadlessOptions::default()
        };
        match Bench::open(&options) {
            Ok(bench) => Some(bench),
            Err(error) => {
                ignored_unless_required(&error.to_string());
                return None;
            }
        }
    } else {
        None
    };
    let findings = sweep.run(&Lab { scale: Scale::Quick, bench: bench.as_ref() });
    let findings = findings.unwrap_or_else(|error| panic!("{name}: {error}"));
    let messages = bench.map(Bench::finish).unwrap_or_default();
    assert!(messages.is_empty(), "the validation layer says:\n{}", messages.join("\n"));
    for case in &findings.cases {
        let (worst, most) = (case.worst, case.bound.most);
        println!("{name}: {}: {worst:.3e} of {most:.3e} {} at {}", case.method, case.bound.unit, case.at);
        assert_ne!(case.verdict(), Verdict::Fails, "{name}: {case:#?}");
        assert!(!case.bound.reason.is_empty() && case.bound.good <= case.bound.most, "{name}: {case:#?}");
        // What fails says what is done about it.
        assert!(
            case.verdict() == Verdict::Holds || case.answer.is_none() || !case.remedy.is_empty(),
            "{case:#?}"
        );
    }
    assert!(!findings.cases.is_empty(), "{name} measures nothing");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut study = Study::new(Scale::Quick, None);
    study.add(sweep, findings.clone());
    study.write(folder.path()).unwrap_or_else(|error| panic!("{name}: {error}"));
    let page = std::fs::read_to_string(folder.path().join("README.md")).expect("a page");
    for picture in page.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        assert!(picture.starts_with('#') || folder.path().join(picture).is_file(), "{name}: no {picture}");
    }
    Some(findings)
}

/// One test a sweep, and one that says which sweep has none.
macro_rules! sweeps {
    ($($test:ident $name:literal),+ $(,)?) => {
        $(#[test] fn $test() { run($name); })+

        #[test]
        fn every_sweep_is_a_test() {
            let tested = [$($name),+];
            let all: Vec<_> = Sweep::ALL.iter().map(|sweep| sweep.name).collect();
            assert_eq!(all, tested);
        }
    };
}

sweeps! {
    roughness_to_0 "roughness",
    grazing_angles "grazing",
    lights_near_and_far "light-distance",
    directions "normal-angles",
    lengths_of_normals "normal-length",
    highlights_of_rounded_normals "highlights",
    steps_of_the_light_target "banding",
    light_above_its_range "overflow",
    greys_that_become_coloured "tint",
    many_lights_one_by_one "sum",
    order_of_blending "order",
    distances_from_depth "depth",
    gamma_of_stored_colour "gamma",
    metal_beside_stone "halos",
    light_as_colour_and_factor "rgbm",
    light_too_bright_for_a_texel "texel-range",
    numbers_that_mean_nothing "inputs",
    meshes_with_flaws "geometry",
    targets_of_any_shape "targets",
    between_which_vertices "lattice",
    cameras_inside_light_volumes "light-volumes",
    pixels_that_nothing_reaches "steady",
    shadow_where_there_is_none "shadow-acne",
    shadows_that_do_not_touch "shadow-gap",
    shadows_that_swim "shadow-shimmer",
    shadows_that_are_counted "shadow-volumes",
    decals_where_boxes_end "decals",
    two_surfaces_in_a_pixel "edges",
    the_curve_and_the_mean "resolve",
    masks_and_samples "masks",
    panes_in_any_order "translucency",
    joints_at_their_limits "posing",
    sparks_at_surfaces "particles",
    water_that_bends "refraction",
}

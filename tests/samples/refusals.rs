//! What cannot have several samples a pixel says why, and what to do.

use super::common::scenes;
use ontile::plan::{Layout, Limits, Needs, Options, Path, Plan, ResolveWay};

fn refused(options: Options, limits: &Limits) -> String {
    let plan = Plan::new(Needs::of(&scenes::every_feature()), options, limits);
    plan.map(|_| String::new()).unwrap_or_else(|error| error.to_string())
}

#[test]
fn options_that_contradict_several_samples_are_refused() {
    let all = Limits { sample_counts: 15, word_sample_counts: 15, ..Limits::default() };
    let few = Limits { word_sample_counts: 1, ..all };
    let pixels = Limits { sample_shading: false, ..all };
    let base = Options { samples: 4, ..Options::default() };
    let of = |change: fn(&mut Options), limits: &Limits| {
        let mut options = base.clone();
        change(&mut options);
        refused(options, limits)
    };
    let cases = [
        (of(|_| (), &all), ""),
        (of(|o| o.samples = 8, &all), ""),
        (of(|o| o.samples = 3, &all), "a pixel cannot have 3 samples"),
        (of(|o| o.samples = 0, &all), "a pixel cannot have 0 samples"),
        (
            of(|o| o.samples = 8, &Limits::default()),
            "cannot have 8 samples a pixel on this device; use --samples 1 or 4",
        ),
        (of(|o| o.keep_gbuffer = true, &all), "cannot be kept"),
        (of(|o| o.layout = Layout::Packed128, &few), "words (rg32ui) cannot have 4 samples"),
        (of(|_| (), &few), ""),
        (of(|_| (), &pixels), "sampleRateShading"),
        (of(|o| o.path = Path::Forward, &pixels), ""),
        (
            of(|o| (o.path, o.resolve) = (Path::Forward, ResolveWay::Plain), &all),
            "the path forward applies the tone curve",
        ),
        (
            of(|o| (o.layout, o.resolve) = (Layout::Packed128, ResolveWay::Plain), &all),
            "layout packed128 has no light target",
        ),
    ];
    for (error, expected) in cases {
        assert!(error.contains(expected) && error.is_empty() == expected.is_empty(), "{expected}: {error}");
    }
}

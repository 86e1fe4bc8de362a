//! No pixel changes with the arrangement of passes, attachments and memory.

use super::common::render::{Gpu, difference, on_device};
use super::common::scenes;
use ontile::plan::{Layout, LightWay, Needs, Options, Path, Plan, ResolveWay, Strategy};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [96, 54];

/// Renders a plan, and the same in other arrangements, and compares; `false` if the layout does not allow the options.
fn check(gpu: &Gpu<'_>, scene: &Scene, options: &Options, others: &[Change]) -> bool {
    let limits = gpu.device().limits();
    if let Err(error) = Plan::new(Needs::of(scene), options.clone(), &limits) {
        assert!(error.to_string().contains(options.layout.name()), "{}, {options:?}: {error}", scene.name);
        return false;
    }
    let expected = gpu.picture(scene, gpu.plan(scene, options.clone()), 0.0);
    for change in others {
        let other = change(options.clone());
        let picture = gpu.picture(scene, gpu.plan(scene, other.clone()), 0.0);
        if let Some(difference) = difference(&expected, &picture) {
            panic!("{}, {other:?}: {difference}", scene.name);
        }
    }
    true
}

/// A change of the options that must not change the picture.
type Change = fn(Options) -> Options;

const SEPARATE: Change = |o| Options { strategy: Strategy::Separate, ..o };

/// All of them.
const CHANGES: [Change; 4] = [
    SEPARATE,
    |o| Options { strategy: Strategy::Separate, recycle: false, ..o },
    |o| Options { recycle: false, ..o },
    |o| Options { depth_prepass: true, ..o },
];

fn base() -> Options {
    Options { size: SIZE, samples: 4, ..Options::default() }
}

#[test]
fn arrangements_do_not_change_the_pixels_of_any_kind_of_scene() {
    on_device(None, |gpu| {
        for scene in scenes::built() {
            assert!(check(gpu, &scene, &base(), &[SEPARATE]), "{}", scene.name);
        }
    });
}

#[test]
fn arrangements_do_not_change_the_pixels_of_any_layout_and_way_of_lights() {
    on_device(None, |gpu| {
        // Each layout with two of the ways, by turns.
        const WAYS: [LightWay; 4] =
            [LightWay::Fullscreen, LightWay::Volumes, LightWay::Clusters, LightWay::Stencil];
        let mut refused = Vec::new();
        let scene = scenes::every_feature();
        for (index, &layout) in Layout::ALL.iter().enumerate() {
            for lights in [WAYS[index % 4], WAYS[(index + 1) % 4]] {
                if !check(gpu, &scene, &Options { layout, lights, ..base() }, &[SEPARATE]) {
                    refused.push(layout);
                }
            }
        }
        assert_eq!(refused, [Layout::Ontile64; 2], "it has no place for light that exists before lighting");
    });
}

#[test]
fn arrangements_do_not_change_the_pixels_of_any_path_and_resolve() {
    on_device(None, |gpu| {
        for scene in [scenes::every_feature(), scenes::before_sky(), scenes::lights_only()] {
            for path in [Path::Forward, Path::ForwardMultipass] {
                assert!(
                    check(gpu, &scene, &Options { path, ..base() }, &[SEPARATE]),
                    "{}, {path}",
                    scene.name
                );
            }
            let plain = Options { resolve: ResolveWay::Plain, ..base() };
            assert!(check(gpu, &scene, &plain, &CHANGES), "{}", scene.name);
        }
    });
}

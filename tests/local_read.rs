//! One rendering with local reads draws what subpasses do where fragments change what they read: decals, and surfaces that are
//! blended in every way, with one sample a pixel and with four.

mod common;

use common::lavapipe::newer_lavapipe;
use common::render::{Gpu, difference, on_device};
use common::scenes::decal_scenes::{color_decals, decals, decals_behind_glass};
use common::scenes::glass_scenes::glass_in_fog;
use ontile::Error;
use ontile::plan::{DecalWay, Layout, Needs, Options, Plan, Strategy, Translucency};
use ontile::scene::Scene;

const SIZE: [u32; 2] = [96, 54];

/// Of every kind: light in a target, in words, apart; depth in a target and in the depth attachment.
const LAYOUTS: [Layout; 5] =
    [Layout::Metallic128, Layout::Metallic256, Layout::Packed128, Layout::Rasa128, Layout::Ontile128];

/// Whether both plans exist and were compared.
fn check(gpu: &Gpu<'_>, scene: &Scene, options: &Options) -> bool {
    let limits = gpu.device().limits();
    let subpasses = Options { strategy: Strategy::Subpasses, ..options.clone() };
    if Plan::new(Needs::of(scene), subpasses.clone(), &limits).is_err() {
        return false;
    }
    let local = Options { strategy: Strategy::LocalRead, ..options.clone() };
    match Plan::new(Needs::of(scene), local.clone(), &limits) {
        Ok(_) => {}
        Err(error @ Error::Unsupported { .. }) => {
            println!("{}, {}: {error}", scene.name, options.layout);
            return false;
        }
        Err(error) => panic!("{error}"),
    }
    let expected = gpu.picture(scene, gpu.plan(scene, subpasses), 0.0);
    let picture = gpu.picture(scene, gpu.plan(scene, local), 0.0);
    if let Some(difference) = difference(&expected, &picture) {
        panic!("{}, {options:?}: {difference}", scene.name);
    }
    true
}

#[test]
#[ignore = "the other test runs it, on a driver with local reads"]
fn draws_what_subpasses_draw() {
    on_device(None, |gpu| {
        // As in tests/combinations: of the render passes that are compared with.
        gpu.excuse("which was previously written during an image layout transition initiated by ");
        let (mut painted, mut blended) = (0, 0);
        // Each layout with several of the ways, by turns.
        for (turn, (samples, layout)) in [1, 4].into_iter().flat_map(|s| LAYOUTS.map(|l| (s, l))).enumerate()
        {
            let options = Options { size: SIZE, samples, layout, ..Options::default() };
            let decal_ways = [DecalWay::Barrier, DecalWay::RasterOrder].into_iter();
            let of_decals = decal_ways.map(|way| (decals(), way)).chain([(color_decals(), DecalWay::Fixed)]);
            for (scene, decals) in of_decals.skip(turn % 2) {
                let options = Options { decals, ..options.clone() };
                painted += usize::from(check(gpu, &scene.without_shadows(), &options));
            }
            let ways = Translucency::ALL.iter().cycle().skip(turn).take(if samples == 1 { 4 } else { 2 });
            for (index, &translucency) in ways.enumerate() {
                let scene = if (index + turn) % 2 == 0 { glass_in_fog() } else { decals_behind_glass() };
                let options = Options { translucency, ..options.clone() };
                blended += usize::from(check(gpu, &scene.without_shadows(), &options));
            }
        }
        assert!(painted > 0 && blended > 0, "{painted} and {blended}");
        println!("{painted} with decals and {blended} with blended surfaces are alike");
    });
}

#[test]
fn what_changes_what_is_read_is_alike() {
    let Some(mut run) = newer_lavapipe(&std::env::current_exe().unwrap()) else { return };
    let output =
        run.args(["--ignored", "--exact", "draws_what_subpasses_draw", "--nocapture"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    println!("{said}");
    assert!(output.status.success(), "{said}");
    assert!(said.contains("are alike"), "{said}");
}

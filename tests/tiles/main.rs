//! Whether a frame stays on the tile, as a tiler's own driver sees it: Mesa's Turnip (Adreno) lays out the tiles of each
//! plan and says what it loads, stores and commits, and the Khronos validation layer of 1.4 watches. Plans that are
//! spoilt on purpose must be found out by the same judge.
//!
//! The driver has its own libc, so each frame is a process: this executable, told to run [`child_renders`] only.

mod beside;
mod child;
#[path = "../common/mod.rs"]
mod common;
mod features;

use child::{Case, Fault, Told};
use common::turnip::{self, Turnip};
use ontile::measure::tiler::{TilerTrace, Verdict};
use ontile::plan::{Bins, DepthStore, Layout, LightWay, Path as LightPath, Strategy, Translucency};
use serde_json::Value;
use std::{path::Path, thread};

/// Three generations: Adreno 6xx of two sizes of tile memory, and 7xx.
const GPUS: [u32; 3] = [630, 660, 740];

/// What a shadow map holds: a depth of 32 bits.
const SHADOW_BYTES_PER_TEXEL: u32 = 4;

/// What the final image needs: 8 bits in each of 4 channels.
const OUTPUT_BYTES_PER_PIXEL: u32 = 4;

const CASE: &str = "ONTILE_TILES_CASE";
const TOLD: &str = "ONTILE_TILES_TOLD";

#[test]
#[ignore = "the other tests run it, each in a process on the driver"]
fn child_renders() {
    let (Ok(case), Some(told)) = (std::env::var(CASE), std::env::var_os(TOLD)) else { return };
    serde_json::from_str::<Case>(&case).unwrap().run(Path::new(&told));
}

/// A frame on the driver.
struct Frame {
    trace: TilerTrace,
    told: Told,
}

impl Frame {
    fn of(turnip: &Turnip, gpu: u32, case: &Case) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let told = folder.path().join("told.json");
        let mut command = turnip.command(gpu, &std::env::current_exe().unwrap());
        command.args(["--ignored", "--exact", "child_renders", "--nocapture"]);
        command.env(CASE, serde_json::to_string(case).unwrap()).env(TOLD, &told);
        let trace = turnip::trace(command).trace;
        let told = std::fs::read(&told).unwrap_or_else(|e| panic!("{case:?} on {gpu} told nothing: {e}"));
        let told: Told = serde_json::from_slice(&told).unwrap();
        Self { trace, told }
    }

    /// Everything that speaks against the frame; empty for a good one.
    fn objections(&self) -> Vec<String> {
        let shadow_tiles = shadow_tiles(&self.told.report);
        let mut all = match self.trace.after(shadow_tiles).verdict(OUTPUT_BYTES_PER_PIXEL) {
            Verdict::OnTile => Vec::new(),
            Verdict::OffTile(reasons) => reasons,
        };
        all.extend(commitments(&self.told.report));
        all.extend(shadow_passes(&self.trace, shadow_tiles));
        all.extend(self.told.messages.iter().map(|m| format!("validation: {m}")));
        all
    }

    #[track_caller]
    fn expect_objection(&self, wanted: &str) {
        let all = self.objections();
        assert!(all.iter().any(|o| o.contains(wanted)), "no '{wanted}' among {all:#?}");
    }
}

/// What speaks against the memory of a report's attachments: all but the first, the output, have to be lazily
/// allocated, and the driver has to say that nothing is behind them.
fn commitments(report: &Value) -> Vec<String> {
    let mut all = Vec::new();
    for a in attachments(report).iter().skip(1) {
        let name = &a["name"];
        if a["transient"] != true {
            all.push(format!("{name} is not transient"));
        }
        if a["lazily_allocated"] != true {
            all.push(format!("{name} is not lazily allocated"));
        }
        let committed = &a["committed_bytes"];
        if committed["value"] != 0.0 || committed["origin"] != "driver" {
            all.push(format!("{name} commits {committed}"));
        }
    }
    all
}

/// How many passes drew tiles of the shadow map.
fn shadow_tiles(report: &Value) -> usize {
    let drawn = |what| report["device"]["shadows"][what].as_u64().unwrap_or(0) as usize;
    drawn("tiles_drawn") + drawn("static_tiles_drawn")
}

/// What speaks against the passes that draw tiles of the shadow map: each has to store its depth, and nothing else.
fn shadow_passes(trace: &TilerTrace, tiles: usize) -> Vec<String> {
    let passes = trace.passes.iter().take(tiles).enumerate();
    let wrong = passes.filter(|(_, p)| {
        let bytes = [p.clear_bytes_per_pixel, p.load_bytes_per_pixel, p.store_bytes_per_pixel];
        p.attachments != 1 || bytes != [0, 0, SHADOW_BYTES_PER_TEXEL] || !p.loads.is_empty() || !p.tiled
    });
    wrong.map(|(index, pass)| format!("shadow pass {index}: {pass:?}")).collect()
}

fn attachments(report: &Value) -> &[Value] {
    report["attachments"].as_array().expect("a report lists attachments")
}

/// Judges a case on each GPU; they run at the same time.
fn frames(turnip: &Turnip, case: &Case, judge: impl Fn(u32, &Frame)) {
    let frames = thread::scope(|s| {
        let all = GPUS.map(|gpu| s.spawn(move || Frame::of(turnip, gpu, case)));
        all.map(|one| one.join().unwrap_or_else(|e| std::panic::resume_unwind(e)))
    });
    for (gpu, frame) in GPUS.into_iter().zip(&frames) {
        judge(gpu, frame);
    }
}

/// A scene that needs every stage.
const ALL_STAGES: &str = "every_feature";

fn metallic(scene: &str) -> Case {
    Case::new(scene, Layout::Metallic128)
}

fn local_read(case: Case) -> Case {
    Case { strategy: Strategy::LocalRead, ..case }
}

fn spoilt(fault: Fault) -> Case {
    Case { fault: Some(fault), ..metallic(ALL_STAGES) }
}

#[test]
fn tiles_of_the_shadow_map_are_composed_without_a_load() {
    let Some(turnip) = turnip::find() else { return };
    frames(&turnip, &Case { moves: true, ..metallic("shadows") }, |gpu, frame| {
        let figures = &frame.told.report["device"]["shadows"];
        assert!(figures["tiles_composed"].as_u64() > Some(0), "{gpu}: {figures}");
        // The second frame's are the last.
        let tiles = shadow_tiles(&frame.told.report);
        let second = frame.trace.after(frame.trace.passes.len() - tiles - 1);
        assert_eq!(shadow_passes(&second, tiles), [""; 0], "{gpu}");
        assert_eq!(frame.told.messages, [""; 0], "{gpu}");
    });
}

#[test]
fn one_pass_stays_on_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    let cases = [
        (3, metallic(ALL_STAGES)),
        (3, Case { recycle: false, ..metallic(ALL_STAGES) }),
        (3, Case::new(ALL_STAGES, Layout::Exact)),
        (3, Case::new(ALL_STAGES, Layout::Specular160)),
        (2, Case::new(ALL_STAGES, Layout::Metallic256)),
        (2, Case::new(ALL_STAGES, Layout::Specular256)),
        (3, Case::new(ALL_STAGES, Layout::Thibieroz128)),
        (3, Case::new(ALL_STAGES, Layout::Thibieroz96)),
        (3, Case::new(ALL_STAGES, Layout::Rasa128)),
        (3, Case::new(ALL_STAGES, Layout::Dissertation192)),
        (3, Case::new(ALL_STAGES, Layout::Ontile128)),
        (3, Case::new(ALL_STAGES, Layout::Ontile96)),
        (2, Case::new("lights_only", Layout::Ontile64)),
        (2, Case::new(ALL_STAGES, Layout::Packed128)),
        (2, Case::new("lights_only", Layout::Packed128)),
        (3, Case { lights: LightWay::Volumes, ..Case::new(ALL_STAGES, Layout::Ontile128) }),
        (3, Case { lights: LightWay::Stencil, ..Case::new(ALL_STAGES, Layout::Ontile128) }),
        (3, Case { depth: Some(DepthStore::D16), ..Case::new(ALL_STAGES, Layout::Ontile128) }),
        (3, Case { depth: Some(DepthStore::D24), ..Case::new(ALL_STAGES, Layout::Ontile128) }),
        (3, metallic("emissive")),
        (2, metallic("lights_only")),
        (2, metallic("shadows")),
        (2, metallic("one_lit_triangle")),
        (2, Case::new("lit_textures", Layout::Exact)),
        (1, metallic("wholly_unlit")),
        (1, metallic("one_unlit_triangle")),
        (3, metallic("before_sky")),
        (1, metallic("sky_alone")),
        (3, metallic("lightmapped")),
        (3, metallic("probes")),
        (3, Case { lights: LightWay::Clusters, ..metallic(ALL_STAGES) }),
        (3, Case { lights: LightWay::Volumes, ..metallic(ALL_STAGES) }),
        (3, Case { lights: LightWay::Stencil, ..metallic(ALL_STAGES) }),
        (2, Case { lights: LightWay::Clusters, ..metallic("lights_only") }),
        (3, Case { lights: LightWay::Volumes, ..metallic("lights_only") }),
        (3, Case { lights: LightWay::Stencil, ..metallic("lights_only") }),
        (1, Case { path: LightPath::Forward, lights: LightWay::Clusters, ..metallic("lights_only") }),
        (1, Case { path: LightPath::Forward, ..metallic(ALL_STAGES) }),
        (1, Case { path: LightPath::Forward, ..metallic("lights_only") }),
        (1, Case { path: LightPath::Forward, ..metallic("before_sky") }),
        (3, Case { path: LightPath::ForwardMultipass, ..metallic(ALL_STAGES) }),
        (3, Case { path: LightPath::ForwardMultipass, ..metallic("before_sky") }),
        (2, Case { path: LightPath::Forward, depth_prepass: true, ..metallic(ALL_STAGES) }),
        (4, Case { depth_prepass: true, ..metallic(ALL_STAGES) }),
        (3, Case { lights: LightWay::Volumes, ..Case::new(ALL_STAGES, Layout::Packed128) }),
        (3, Case { lights: LightWay::Stencil, ..Case::new(ALL_STAGES, Layout::Packed128) }),
        (3, Case { lights: LightWay::Volumes, ..Case::new("lights_only", Layout::Metallic256) }),
        (3, Case { shadow_volumes: true, ..metallic("lights_only") }),
        (3, Case { shadow_volumes: true, ..Case::new("lights_only", Layout::Packed128) }),
        (4, metallic("glass")),
        (4, metallic("glass_in_fog")),
        (4, Case::new("glass", Layout::Packed128)),
        (4, Case::new("glass_in_fog", Layout::Rasa128)),
        (3, Case { path: LightPath::Forward, ..metallic("glass") }),
        (2, metallic("glass_alone")),
        (5, Case { translucency: Translucency::Oit, ..metallic("glass") }),
        (5, Case { translucency: Translucency::Oit, ..Case::new("glass", Layout::Packed128) }),
        (5, Case { translucency: Translucency::Oit, ..Case::new("glass", Layout::Metallic256) }),
        (5, Case { translucency: Translucency::Weighted, ..metallic("glass") }),
        (19, Case { translucency: Translucency::Peeled, ..metallic("glass") }),
        (4, metallic("water")),
        (5, Case::new("water_in_fog", Layout::Rasa128)),
        (6, Case::new("water_and_more", Layout::Packed128)),
        (3, Case { path: LightPath::Forward, ..metallic("water") }),
        (4, local_read(metallic("water"))),
        (4, metallic("sparks")),
        (5, Case::new("sparks_in_fog", Layout::Packed128)),
        (5, Case::new("sparks_and_glass", Layout::Rasa128)),
        (3, Case { path: LightPath::Forward, ..metallic("sparks") }),
        (6, Case { translucency: Translucency::Weighted, ..metallic("sparks_and_glass") }),
        (4, local_read(metallic("sparks"))),
        (5, local_read(Case { translucency: Translucency::Oit, ..Case::new("glass", Layout::Packed128) })),
        (5, local_read(Case { translucency: Translucency::Weighted, ..metallic("glass") })),
        (3, local_read(metallic(ALL_STAGES))),
        (3, local_read(Case { recycle: false, ..metallic(ALL_STAGES) })),
        (3, local_read(Case::new(ALL_STAGES, Layout::Exact))),
        (3, local_read(Case { lights: LightWay::Stencil, ..Case::new(ALL_STAGES, Layout::Ontile128) })),
        (3, local_read(Case { lights: LightWay::Volumes, ..Case::new(ALL_STAGES, Layout::Packed128) })),
        (3, local_read(metallic("before_sky"))),
        (2, local_read(metallic("shadows"))),
        (1, local_read(Case { path: LightPath::Forward, ..metallic(ALL_STAGES) })),
        (4, local_read(Case { depth_prepass: true, ..metallic(ALL_STAGES) })),
    ];
    for (subpasses, case) in &cases {
        frames(&turnip, case, |gpu, frame| on_tile(gpu, case, *subpasses, frame));
    }
}

/// Asserts that nothing speaks against the frame and prints how its attachments cut it into bins.
fn on_tile(gpu: u32, case: &Case, subpasses: usize, frame: &Frame) {
    assert_eq!(frame.objections(), Vec::<String>::new(), "{case:?} on {gpu}");
    let report = &frame.told.report;
    let totals = &report["totals"];
    assert_eq!(totals["loaded_bytes_per_pixel"]["value"], 0.0);
    assert_eq!(totals["stored_bytes_per_pixel"]["value"], f64::from(OUTPUT_BYTES_PER_PIXEL));
    assert_eq!((&totals["passes"], &totals["subpasses"]), (&1.into(), &subpasses.into()), "{case:?}");
    let pass = frame.trace.passes.last().expect("the verdict saw it");
    assert_eq!(pass.attachments as usize, attachments(report).len());
    assert_eq!([pass.width_px, pass.height_px], child::SIZE);

    let chosen = Bins { count: pass.bins, size_px: [pass.bin_width_px, pass.bin_height_px] };
    let predicted =
        frame.told.bins.iter().find(|(id, _)| *id == gpu).expect("each GPU's bins are predicted").1;
    assert_eq!(predicted, Some(chosen), "{case:?} on {gpu}: the bins that the plan predicts");

    let bits: u64 = attachments(report)
        .iter()
        .map(|a| a["bits"].as_u64().unwrap() * a["samples"].as_u64().unwrap())
        .sum();
    println!(
        "Adreno {gpu}: {subpasses} subpasses, {}{}: {} bytes a pixel in all attachments, {} bins of {}x{}",
        case.layout,
        if case.recycle { "" } else { " not recycled" },
        bits / 8,
        pass.bins,
        pass.bin_width_px,
        pass.bin_height_px
    );
}

#[test]
fn stored_attachments_and_several_passes_are_found_out() {
    let Some(turnip) = turnip::find() else { return };
    let separate = Case { strategy: Strategy::Separate, ..metallic(ALL_STAGES) };
    frames(&turnip, &separate, |_, frame| {
        frame.expect_objection("3 render passes instead of 1");
        // Light, depth, normal and base colour at 4 bytes each; lighting adds to the light.
        frame.expect_objection("pass 0: stores 16 bytes per pixel instead of 4");
        frame.expect_objection("pass 1: loads 4 bytes per pixel instead of 0");
        frame.expect_objection("\"normal_roughness\" is not transient");
        // The vendors' checks are on.
        frame.expect_objection("[Arm] [IMG]");
    });
    for (fault, memory) in [(Fault::Stored, "commits {"), (Fault::StoredInMemory, "is not lazily allocated")]
    {
        frames(&turnip, &spoilt(fault), |_, frame| {
            frame.expect_objection("pass 0: stores 8 bytes per pixel instead of 4");
            frame.expect_objection(&format!("\"normal_roughness\" {memory}"));
        });
    }
}

#[test]
fn wrong_dependencies_are_found_out() {
    let Some(turnip) = turnip::find() else { return };
    // What makes the driver give up tiling, which no validation sees: the picture stays right.
    frames(&turnip, &spoilt(Fault::NotByRegion), |_, frame| {
        frame.expect_objection("not tiled");
        frame.expect_objection("Disabling gmem rendering");
        frame.expect_objection("\"normal_roughness\" commits");
        assert_eq!(frame.told.messages, Vec::<String>::new());
    });
    // Of a rendering the layer sees it: its barriers are commands. (A barrier that is missing there nobody sees: the layer does
    // not follow input attachments into renderings. Tests of the plan have to do.)
    frames(&turnip, &local_read(spoilt(Fault::NotByRegion)), |_, frame| {
        frame.expect_objection("VUID-vkCmdPipelineBarrier-dependencyFlags-07891");
    });
    // What only validation sees: the driver tiles and does the wrong thing fast.
    frames(&turnip, &spoilt(Fault::StoreNotCovered), |_, frame| {
        frame.expect_objection("WRITE-AFTER-WRITE");
    });
    frames(&turnip, &spoilt(Fault::DependencyDropped), |_, frame| {
        frame.expect_objection("SYNC-HAZARD");
    });
}

/// Ordinary memory for a debugger's sake: the frame is tiled as before, but the memory is there.
#[test]
fn captured_frames_have_memory() {
    let Some(turnip) = turnip::find() else { return };
    let case = Case { capture: true, ..metallic(ALL_STAGES) };
    frames(&turnip, &case, |_, frame| {
        assert_eq!(frame.trace.verdict(OUTPUT_BYTES_PER_PIXEL), Verdict::OnTile);
        frame.expect_objection("\"normal_roughness\" is not lazily allocated");
        frame.expect_objection("attachment-should-be-transient");
    });
}

/// Queries around the frame and after each stage: no reason to leave the tile.
#[test]
fn queries_do_not_leave_the_tile() {
    let Some(turnip) = turnip::find() else { return };
    let case = Case { stage_timestamps: true, ..metallic(ALL_STAGES) };
    frames(&turnip, &case, |gpu, frame| {
        assert!(frame.told.queries, "{gpu} has no queries to record");
        assert_eq!(frame.objections(), Vec::<String>::new(), "on {gpu}");
    });
}

/// The program on the scenes that are shipped with it and on sample models.
#[cfg(feature = "cli")]
#[test]
fn the_program_stays_on_the_tile() {
    use common::scenes::{sample_files, shipped_files};
    let Some(turnip) = turnip::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (picture, report) = (folder.path().join("frame.png"), folder.path().join("frame.json"));
    let scenes = shipped_files();
    assert!(!scenes.is_empty(), "assets/ ships no scene");
    for scene in scenes.into_iter().chain(sample_files()) {
        let mut command = turnip.command(660, Path::new(env!("CARGO_BIN_EXE_ontile")));
        command.arg("render").arg(&scene).arg("-o").arg(&picture).args(["--size", "1280x720", "--validate"]);
        command.arg("--report").arg(&report).env("XDG_CACHE_HOME", folder.path());
        // The program fails if the validation layer says anything.
        let trace = turnip::trace(command).trace;
        let report: Value = serde_json::from_slice(&std::fs::read(&report).unwrap()).unwrap();
        let tiles = shadow_tiles(&report);
        let verdict = trace.after(tiles).verdict(OUTPUT_BYTES_PER_PIXEL);
        assert_eq!(verdict, Verdict::OnTile, "{}", scene.display());
        assert_eq!(shadow_passes(&trace, tiles), Vec::<String>::new(), "{}", scene.display());
        assert_eq!(commitments(&report), Vec::<String>::new(), "{}", scene.display());
        assert_eq!(report["device"]["validation_messages"], serde_json::json!([]), "{}", scene.display());
    }
}

//! Frame times: one render pass against separate ones, by layout, by folding and by the number of lights.

use std::collections::BTreeMap;

use ontile::Result;
use ontile::gpu::{Device, View};
use ontile::measure::{FrameTimes, Host, Summary};
use ontile::plan::{Layout, Options, Strategy};
use serde::Serialize;

use super::scenes;

const OBJECTS: usize = 64;
const LIGHTS: [usize; 3] = [1, 16, 64];
/// Frames before the first that counts: drivers compile and allocate in them.
const WARM_UP: usize = 2;

/// One way to render, measured.
#[derive(Serialize)]
pub struct Frames {
    lights: usize,
    layout: Layout,
    /// Whether lighting applies the tone curve itself.
    folded: bool,
    subpasses: Times,
    separate: Times,
    /// Time of `subpasses` over that of `separate`, of frames that followed each other.
    ratio: Option<Summary>,
}

#[derive(Serialize)]
struct Times {
    /// By timestamps, where the device has them, else submission and waiting.
    frame_ms: Option<Summary>,
    wall_ms: Option<Summary>,
    /// Median share of each stage in the frame.
    stage_shares: BTreeMap<&'static str, f64>,
}

/// The least and the most bits that can be folded or not; `ontile chart` measures the others.
const LAYOUTS: [Layout; 2] = [Layout::Metallic128, Layout::Exact];

/// Measures all variants of a scene in turns, so that what else the machine does falls on all of them alike.
pub fn measure(
    device: &Device,
    size: [u32; 2],
    frames: usize,
    mut progress: impl FnMut(&str),
) -> Result<Vec<Frames>> {
    let mut results = Vec::new();
    for lights in LIGHTS {
        let scene = scenes::floor(OBJECTS, lights, false);
        progress(&scene.name);
        let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
        let variants: Vec<(Layout, bool)> =
            LAYOUTS.iter().flat_map(|&layout| [(layout, true), (layout, false)]).collect();
        let mut pairs = variants
            .iter()
            .map(|&(layout, fold)| {
                let host = |strategy| {
                    let options = Options { size, strategy, layout, fold, ..Options::default() };
                    Host::new(device, &scene, &options, true)
                };
                Ok([host(Strategy::Subpasses)?, host(Strategy::Separate)?])
            })
            .collect::<Result<Vec<_>>>()?;
        let mut times: Vec<[Vec<FrameTimes>; 2]> = pairs.iter().map(|_| Default::default()).collect();
        for round in 0..frames + WARM_UP {
            for (pair, times) in pairs.iter_mut().zip(&mut times) {
                // Each strategy goes first every other time.
                for which in [round % 2, 1 - round % 2] {
                    let frame = pair[which].frame(&view)?;
                    if round >= WARM_UP {
                        times[which].push(frame);
                    }
                }
            }
        }
        for ((&(layout, folded), pair), times) in variants.iter().zip(&pairs).zip(&times) {
            let ratios = times[0].iter().zip(&times[1]).map(|(a, b)| frame_ms(a) / frame_ms(b));
            results.push(Frames {
                lights,
                layout,
                folded,
                subpasses: Times::of(&pair[0], &times[0]),
                separate: Times::of(&pair[1], &times[1]),
                ratio: Summary::of(ratios),
            });
        }
    }
    Ok(results)
}

fn frame_ms(times: &FrameTimes) -> f64 {
    times.gpu_ms.unwrap_or(times.wall_ms)
}

impl Times {
    fn of(host: &Host, frames: &[FrameTimes]) -> Self {
        let share = |stage: usize| {
            let of_frame = |f: &FrameTimes| Some(f.stages_ms.get(stage)? / f.gpu_ms?);
            Summary::of(frames.iter().filter_map(of_frame)).map(|s| s.median)
        };
        let stages = host.stages().into_iter().enumerate();
        Self {
            frame_ms: Summary::of(frames.iter().map(frame_ms)),
            wall_ms: Summary::of(frames.iter().map(|f| f.wall_ms)),
            stage_shares: stages.filter_map(|(stage, name)| Some((name, share(stage)?))).collect(),
        }
    }
}

/// The results as a table.
pub fn print(results: &[Frames]) {
    println!("Frames: median milliseconds [quartiles] of {OBJECTS} objects; ratio: subpasses / separate");
    println!(
        "{:>6} {:<12} {:<6} {:>25} {:>25} {:>20}  shares of the stages in subpasses",
        "lights", "layout", "folded", "subpasses", "separate", "ratio"
    );
    let show = |s: &Option<Summary>| s.map_or("-".into(), |s| s.to_string());
    for r in results {
        let shares = r.subpasses.stage_shares.iter().map(|(name, s)| format!("{name} {:.0}%", s * 100.0));
        println!(
            "{:>6} {:<12} {:<6} {:>25} {:>25} {:>20}  {}",
            r.lights,
            r.layout,
            if r.folded { "yes" } else { "no" },
            show(&r.subpasses.frame_ms),
            show(&r.separate.frame_ms),
            show(&r.ratio),
            shares.collect::<Vec<_>>().join(", ")
        );
    }
    println!();
}

//! What recording a frame of many draws costs the CPU.

use ontile::Result;
use ontile::gpu::{Device, View};
use ontile::measure::{Host, Summary};
use ontile::plan::Options;
use serde::Serialize;

use super::scenes;

const OBJECTS: usize = 1000;
const FRAMES: usize = 200;

#[derive(Serialize)]
pub struct Recording {
    objects: usize,
    /// Every object has a mesh of its own; otherwise equal meshes share draw calls.
    distinct_meshes: bool,
    draws: usize,
    state_changes: usize,
    record_ms: Option<Summary>,
    /// The most heap allocations that any frame after the first made.
    most_allocations: u64,
}

/// Records frames of 1,000 objects again and again; none is submitted.
pub fn measure(device: &Device) -> Result<Vec<Recording>> {
    [true, false].map(|distinct| measure_scene(device, distinct)).into_iter().collect()
}

fn measure_scene(device: &Device, distinct_meshes: bool) -> Result<Recording> {
    let scene = scenes::floor(OBJECTS, 1, distinct_meshes);
    let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
    let mut host = Host::new(device, &scene, &Options { size: [64, 64], ..Options::default() }, true)?;
    host.record(&view)?;
    let mut record = || {
        let mut record_ms = Ok(0.0);
        let allocations = allocation_counter::measure(|| record_ms = host.record(&view));
        Ok((record_ms?, allocations.count_total))
    };
    let frames = (0..FRAMES).map(|_| record()).collect::<Result<Vec<_>>>()?;
    let counts = host.renderer.recorded().counts;
    Ok(Recording {
        objects: OBJECTS,
        distinct_meshes,
        draws: counts.draws,
        state_changes: counts.state_changes.total(),
        record_ms: Summary::of(frames.iter().map(|(ms, _)| *ms)),
        most_allocations: frames.iter().map(|(_, allocations)| *allocations).max().unwrap_or_default(),
    })
}

/// The results as a table.
pub fn print(results: &[Recording]) {
    println!("Recording a frame of {OBJECTS} objects: median milliseconds [quartiles]");
    for r in results {
        println!(
            "  {:<18} {:>5} draws, {:>4} state changes: {}, {} heap allocations",
            if r.distinct_meshes { "a mesh per object" } else { "8 meshes" },
            r.draws,
            r.state_changes,
            r.record_ms.map_or("-".into(), |s| format!("{s:.3}")),
            r.most_allocations
        );
    }
    println!();
}

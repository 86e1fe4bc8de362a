//! Measures the ways of a row against each other.

use std::rc::Rc;

use ontile::gpu::{Device, Offscreen, PipelineCache, RendererConfig, View};
use ontile::measure::{Clock, Effort, Host, Racer, race, rounded_ms};
use ontile::picture::Pixels;
use ontile::plan::{LightWay, Needs, Options, OutputFormat, Path, Plan};
use ontile::scene::Scene;
use ontile::{Error, Result};

use super::data::{Auto, Cell, Measured, Outcome, Row};
use super::maths::median;

/// Frames before the first that counts.
const WARM_UP: usize = 2;
/// For the stages' medians, which are about where the time goes, not about who wins.
const MOST_STAGE_FRAMES: usize = 9;

/// One row of a table before it is measured.
pub struct Case {
    pub label: String,
    pub x: f64,
    pub size: [u32; 2],
    pub ways: Vec<Way>,
    /// Also tell what each stage takes.
    pub stages: bool,
}

/// One way to draw.
pub struct Way {
    pub name: String,
    pub scene: Rc<Scene>,
    /// The size is the case's.
    pub options: Options,
}

/// Draws a case's ways in turns.
///
/// # Errors
/// What happens after a way has drawn its first frames; what prevents that is told in the way's cell.
pub fn case(device: &Device, case: &Case, effort: Effort) -> Result<Row> {
    let Case { label, x, size, ways, stages } = case;
    let racers = ways.iter().map(|way| {
        let options = Options { size: *size, ..way.options.clone() };
        Racer::new(device, &way.scene, &way.scene.cameras[0], 0.0, &options)
    });
    let mut racers: Vec<_> = racers.collect();
    let first_draws: Vec<_> = racers.iter().map(|racer| racer.as_ref().map_or(0, draws)).collect();
    race(&mut racers, Clock::of(device), effort)?;
    let cells = ways.iter().zip(racers).zip(first_draws).map(|((way, racer), first_draws)| {
        let outcome = match racer {
            Ok(racer) => {
                let mut measured = measured(racer, first_draws);
                if *stages {
                    measured.stage_ms = stage_ms(device, way, *size, effort.rounds.min(MOST_STAGE_FRAMES))?;
                }
                Outcome::Measured(measured)
            }
            Err(reason) => Outcome::Refused(reason.to_string()),
        };
        Ok(Cell { way: way.name.clone(), outcome })
    });
    let cells = cells.collect::<Result<_>>()?;
    let auto = ways.first().and_then(|way| auto(device, &way.scene, *size));
    Ok(Row { label: label.clone(), x: *x, size: *size, auto, cells })
}

/// Of the last frame, into shadow maps too.
fn draws(racer: &Racer<'_>) -> usize {
    let recorded = racer.host.renderer.recorded();
    recorded.counts.draws + recorded.shadows.draws
}

fn measured(racer: Racer<'_>, first_draws: usize) -> Measured {
    let (counts, plan) = (racer.host.renderer.recorded().counts, racer.host.renderer.plan());
    Measured {
        record_ms: rounded_ms(median(&racer.record_ms).unwrap_or_default()),
        first_draws,
        draws: draws(&racer),
        state_changes: counts.state_changes.total(),
        objects: counts.objects.visible,
        lights: counts.lights.visible,
        plan: format!("{}, {}", plan.path, plan.light_way),
        frame_ms: racer.frame_ms,
        ..Measured::default()
    }
}

/// Medians of some frames with a timestamp after each stage. They are frames of their own, since such timestamps may keep
/// stages from overlapping.
fn stage_ms(device: &Device, way: &Way, size: [u32; 2], frames: usize) -> Result<Vec<(String, f64)>> {
    let options = Options { size, ..way.options.clone() };
    let mut host = Host::new(device, &way.scene, &options, true)?;
    let mut frame = || host.frame(&View { camera: &way.scene.cameras[0], exposure_ev: 0.0 });
    for _ in 0..WARM_UP {
        frame()?;
    }
    let frames = (0..frames).map(|_| frame()).collect::<Result<Vec<_>>>()?;
    let names = host.stages().into_iter().enumerate();
    Ok(names
        .filter_map(|(i, name)| {
            let of_stage: Vec<_> = frames.iter().filter_map(|f| f.stages_ms.get(i).copied()).collect();
            Some((name.to_owned(), rounded_ms(median(&of_stage)?)))
        })
        .collect())
}

/// What `auto` would choose.
fn auto(device: &Device, scene: &Scene, size: [u32; 2]) -> Option<Auto> {
    let plan = |path| {
        let options = Options { size, path, lights: LightWay::Auto, ..Options::default() };
        Plan::new(Needs::of(scene), options, &device.caps().limits()).ok()
    };
    let (path, lights) = (plan(Path::Auto)?.path, plan(Path::Deferred)?.light_way);
    Some(Auto { path: path.name().into(), lights: lights.name().into() })
}

/// The share of the screen that a scene's lights reach, by a small picture of it.
pub fn lit_share(device: &Device, scene: &Scene, [width, height]: [u32; 2]) -> Result<f64> {
    const WIDTH: u32 = 160;
    let size = [WIDTH, (WIDTH * height / width).max(1)];
    let options = Options { size, output: OutputFormat::Rgba32Float, ..Options::default() };
    let plan = Plan::new(Needs::of(scene), options, &device.caps().limits())?;
    let cache = PipelineCache::new(device, &[])?;
    let mut frame = Offscreen::new(device, scene, plan, RendererConfig::default(), &cache)?;
    frame.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 })?;
    let Pixels::Rgba32F(pixels) = frame.picture().pixels else {
        return Err(Error::unsupported("a float picture came back as bytes", "report this"));
    };
    let lit = pixels.chunks_exact(4).filter(|pixel| pixel[..3].iter().any(|&c| c > 0.0)).count();
    Ok(lit as f64 / (size[0] * size[1]) as f64)
}

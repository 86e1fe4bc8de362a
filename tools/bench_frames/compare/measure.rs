//! Measures ways to draw in turns: whatever else the machine does falls on all of them alike.

use std::rc::Rc;
use std::time::Instant;

use ontile::gpu::{Device, DeviceType, Offscreen, PipelineCache, RendererConfig, View};
use ontile::picture::Pixels;
use ontile::plan::{LightWay, Needs, Options, OutputFormat, Path, Plan};
use ontile::scene::Scene;
use ontile::{Error, Result};

use super::super::host::Host;
use super::data::{Auto, Cell, Clock, Measured, Outcome, Row};
use super::maths::median;

/// Frames before the first that counts: drivers compile and allocate in them, and shadow maps are drawn.
const WARM_UP: usize = 2;
/// Frames that do not count go on for so long on devices that lower their clocks while scenes are made, seconds.
const WARM_UP_S: f64 = 0.5;
/// Rounds that are measured however long they take.
const LEAST_ROUNDS: usize = 6;

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

/// How long to measure.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    pub rounds: usize,
    /// After so many seconds a case ends with the rounds that it has.
    pub seconds: f64,
}

pub fn clock(device: &Device) -> Clock {
    let caps = device.caps();
    let has_clock = caps.timestamp_valid_bits > 0 && caps.device_type != DeviceType::Cpu;
    if has_clock { Clock::Gpu } else { Clock::Wall }
}

/// Draws a case's ways in turns.
///
/// # Errors
/// What happens after a way has drawn its first frames; what prevents that is told in the way's cell.
pub fn case(device: &Device, case: &Case, effort: Effort) -> Result<Row> {
    let mut racers: Vec<_> = case.ways.iter().map(|way| Racer::new(device, way, case.size)).collect();
    let clock = clock(device);
    let start = Instant::now();
    while clock == Clock::Gpu && start.elapsed().as_secs_f64() < WARM_UP_S {
        for racer in racers.iter_mut().flatten() {
            racer.host.frame(&View { camera: &racer.scene.cameras[0], exposure_ev: 0.0 })?;
        }
    }
    let start = Instant::now();
    for round in 0..effort.rounds {
        if round >= LEAST_ROUNDS && start.elapsed().as_secs_f64() > effort.seconds {
            break;
        }
        // Each goes first as often as the others, and follows its neighbours on either side alike.
        let count = racers.len();
        for turn in 0..count {
            let turn = if round % 2 == 0 { turn } else { count - 1 - turn };
            if let Ok(racer) = &mut racers[(round + turn) % count] {
                racer.frame(clock)?;
            }
        }
    }
    let Case { label, x, size, ways, stages } = case;
    let cells = ways.iter().zip(racers).map(|(way, racer)| {
        let outcome = match racer.map(Racer::finish) {
            Ok(mut measured) => {
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
            Some((name.to_owned(), rounded(median(&of_stage)?)))
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

/// A way that is being measured.
struct Racer {
    host: Host,
    scene: Rc<Scene>,
    record_ms: Vec<f64>,
    measured: Measured,
}

impl Racer {
    fn new(device: &Device, way: &Way, size: [u32; 2]) -> Result<Self> {
        let options = Options { size, ..way.options.clone() };
        let host = Host::new(device, &way.scene, &options, false)?;
        let mut racer =
            Self { host, scene: way.scene.clone(), record_ms: Vec::new(), measured: Measured::default() };
        for frame in 0..WARM_UP {
            racer.frame(Clock::Wall)?;
            if frame == 0 {
                racer.measured.first_draws = racer.draws();
            }
        }
        racer.measured.frame_ms.clear();
        racer.record_ms.clear();
        Ok(racer)
    }

    fn frame(&mut self, clock: Clock) -> Result<()> {
        let times = self.host.frame(&View { camera: &self.scene.cameras[0], exposure_ev: 0.0 })?;
        let wall_ms = times.record_ms + times.wall_ms;
        self.measured.frame_ms.push(rounded(match clock {
            Clock::Wall => wall_ms,
            Clock::Gpu => times.gpu_ms.unwrap_or(wall_ms),
        }));
        self.record_ms.push(times.record_ms);
        Ok(())
    }

    /// Of the last frame, into shadow maps too.
    fn draws(&self) -> usize {
        let recorded = self.host.renderer.recorded();
        recorded.counts.draws + recorded.shadows.draws
    }

    fn finish(self) -> Measured {
        let (counts, plan) = (self.host.renderer.recorded().counts, self.host.renderer.plan());
        Measured {
            record_ms: rounded(median(&self.record_ms).unwrap_or_default()),
            draws: self.draws(),
            state_changes: counts.state_changes.total(),
            objects: counts.objects.visible,
            lights: counts.lights.visible,
            plan: format!("{}, {}", plan.path, plan.light_way),
            ..self.measured
        }
    }
}

/// To tenths of microseconds, which no clock here tells apart: short in files.
pub fn rounded(ms: f64) -> f64 {
    (ms * 1e4).round() / 1e4
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

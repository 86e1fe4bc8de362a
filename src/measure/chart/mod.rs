//! Speed against accuracy: what every G-buffer costs on a device, and how far its picture is from the truth.
//!
//! A cell is a G-buffer ([`Choice`]) in a place: scene, size, device. Its time comes from frames that were drawn in turns with
//! those of other G-buffers, and of [`BASE`] in every race, so that ratios hold across races. Its errors are those of
//! pictures without shadows against the f64 reference, and against the layout `exact` on the same device, which tells what the
//! formats lose from what arithmetic does. Its bytes are planned; bins are predicted, and told by Mesa's Turnip where it is
//! at hand.

mod csv;
mod data;
mod hits;
mod metric;
mod page;
mod plots;
mod scatter;
mod standing;
mod truth;

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;

use sha2::{Digest, Sha256};

pub use data::{Bytes, Cell, DriverFigures, Errors, Measured, Outcome, Place, Report, Tiled, Truth};
pub use metric::{Cost, Metric, pareto};
pub(super) use scatter::{Field, Point, Scatter};
pub(super) use truth::{Stage, is_textured};

use super::{Clock, Effort, Probe, Racer, Summary, candidates_for, race};
use crate::gpu::{Device, PipelineCache};
use crate::plan::{Adreno, Choice, Layout, Limits, Needs, Occupancy, Options, Plan, Strategy};
use crate::scene::Scene;
use crate::{Error, Result};
use truth::Truths;

/// What takes part in every race.
pub const BASE: Choice = Choice::of(Layout::Metallic128);

/// Every layout as it is, each single other choice over [`BASE`], and what `--layout auto` chooses from.
pub fn default_choices() -> Vec<Choice> {
    let mut choices = Choice::one_by_one(BASE);
    for choice in Choice::candidates() {
        if !choices.contains(&choice) {
            choices.push(choice);
        }
    }
    choices
}

/// Others in a race with [`BASE`]: few enough that the memory of a phone holds them.
const RACERS: usize = 6;

/// What is charted.
pub struct Sweep<'a> {
    /// Scenes, each with the camera to look through.
    pub scenes: Vec<(&'a Scene, usize)>,
    /// Widths and heights, pixels.
    pub sizes: Vec<[u32; 2]>,
    /// G-buffers.
    pub choices: Vec<Choice>,
    /// All that is the same everywhere; size and G-buffer are not read.
    pub options: Options,
    /// Exposure, stops.
    pub exposure_ev: f32,
    /// Of each race.
    pub effort: Effort,
    /// This part (from 0) of so many.
    pub shard: [usize; 2],
    /// The program's version, and what else tells builds apart.
    pub program: String,
}

/// Asks a driver how it tiles a G-buffer's frame of a scene at a size, for each of [`Adreno::ALL`].
pub type AskDriver<'a> = dyn Fn(usize, [u32; 2], Choice, &Adreno) -> Result<Option<DriverFigures>> + 'a;

/// The same for a plan, whose passes have these attachments.
type AskPlan<'a> = dyn Fn(Choice, Vec<Vec<Occupancy>>, &Adreno) -> Result<Option<DriverFigures>> + 'a;

impl Sweep<'_> {
    /// The cells of this part, by scene and size.
    fn groups(&self) -> Vec<(usize, [u32; 2], Vec<Choice>)> {
        let places: Vec<_> =
            (0..self.scenes.len()).flat_map(|s| self.sizes.iter().map(move |&size| (s, size))).collect();
        let [part, parts] = self.shard;
        let all = places.len() * self.choices.len();
        // Neighbours stay together: they share the reference.
        let (begin, end) = (all * part / parts, all * (part + 1) / parts);
        let group = |(place, (scene, size)): (usize, (usize, [u32; 2]))| {
            let first = place * self.choices.len();
            let inside = |index: &usize| (begin..end).contains(&(first + index));
            (scene, size, (0..self.choices.len()).filter(inside).map(|i| self.choices[i]).collect())
        };
        places.into_iter().enumerate().map(group).collect()
    }

    /// How many cells this part has.
    pub fn cells(&self) -> usize {
        self.groups().iter().map(|(_, _, choices)| choices.len()).sum()
    }

    fn place(&self, device: &Device, scene: usize, size: [u32; 2]) -> Place {
        let (scene, camera) = self.scenes[scene];
        Place {
            scene: scene.name.clone(),
            scene_sha256: scene_sha256(scene, camera),
            camera: scene.cameras[camera].name.clone(),
            size,
            strategy: self.options.strategy,
            tonemap: self.options.tonemap,
            exposure_ev: self.exposure_ev,
            rounds: self.effort.rounds,
            seconds: self.effort.seconds,
            device: device.caps().name.clone(),
            driver: device.caps().driver.clone(),
            program: self.program.clone(),
        }
    }

    /// Measures what `report` does not have yet, and keeps it in the folder as it grows. `step` is told of each cell.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Vulkan`]; [`Error::Unsupported`] where a scene cannot be charted at all. What single cells
    /// are refused for is told in the report.
    pub fn run(
        &self,
        device: &Device,
        folder: &Path,
        report: &mut Report,
        ask_driver: Option<&AskDriver<'_>>,
        step: &dyn Fn(),
    ) -> Result<()> {
        // What a driver does depends on the attachments alone.
        let told = RefCell::new(HashMap::new());
        for (scene, size, choices) in self.groups() {
            let place = self.place(device, scene, size);
            let (done, missing): (Vec<_>, Vec<_>) = choices.into_iter().partition(|&c| report.has(&place, c));
            done.iter().for_each(|_| step());
            if missing.is_empty() {
                continue;
            }
            let ask = |choice, passes: Vec<Vec<Occupancy>>, gpu: &Adreno| {
                let Some(ask) = ask_driver else { return Ok(None) };
                let key = (passes, size, gpu.id);
                if let Some(&known) = told.borrow().get(&key) {
                    return Ok(known);
                }
                let answer = ask(scene, size, choice, gpu)?;
                told.borrow_mut().insert(key, answer);
                Ok(answer)
            };
            let group = Group::new(self, device, scene, size)?;
            for choices in missing.chunks(RACERS) {
                for (&choice, outcome) in choices.iter().zip(group.race(choices, &ask)?) {
                    report.put(Cell { place: place.clone(), choice, outcome });
                    step();
                }
                // What is measured so far survives what may come.
                report.write(folder)?;
            }
        }
        Ok(())
    }
}

/// Writes what follows from a report: a table for spreadsheets, charts and a page.
///
/// # Errors
/// [`Error::Io`]; [`Error::Unsupported`] if nothing was measured.
pub fn write_all(report: &Report, folder: &Path) -> Result<()> {
    if !report.cells.iter().any(|cell| cell.measured().is_some()) {
        return Err(Error::unsupported(
            "nothing could be measured, so that there is nothing to chart",
            match report.cells.first().map(|cell| &cell.outcome) {
                Some(Outcome::Refused(reason)) => format!("the first reason: {reason}"),
                _ => "give scenes, or folders with results".into(),
            },
        ));
    }
    crate::file::write_whole(&folder.join("chart.csv"), csv::csv(report).as_bytes())?;
    for (name, chart) in plots::plots(report) {
        super::canvas::Drawing::write(&chart, &folder.join(name))?;
    }
    crate::file::write_whole(&folder.join("README.md"), page::page(report).as_bytes())
}

/// What wins for which need, a line each.
pub fn summary(report: &Report) -> String {
    let line = |device: &str, standings: &[standing::Standing]| -> String {
        let winners = standing::winners(standings).into_iter();
        let told = winners
            .map(|w| format!("  {}: {}\n", w.need, w.best.map_or("none".into(), |s| s.choice.to_string())));
        format!("{device}\n{}", told.collect::<String>())
    };
    report
        .devices()
        .iter()
        .map(|device| line(data::device_name(device), &standing::standings(report, device)))
        .collect()
}

/// One scene at one size.
struct Group<'a> {
    sweep: &'a Sweep<'a>,
    device: &'a Device,
    scene: &'a Scene,
    camera: usize,
    /// As the scene is without shadows.
    unshadowed: Scene,
    cache: PipelineCache,
    size: [u32; 2],
    truths: Truths,
    /// `None` if it sees no lit surface.
    probe: Option<Probe<'a>>,
}

impl<'a> Group<'a> {
    fn new(sweep: &'a Sweep<'a>, device: &'a Device, scene: usize, size: [u32; 2]) -> Result<Self> {
        let (scene, camera) = sweep.scenes[scene];
        let unshadowed = scene.clone().without_shadows();
        let cache = PipelineCache::new(device, &[])?;
        let stage = stage(sweep, device, &cache, &unshadowed, camera, size);
        let truths = Truths::new(&stage)?;
        let probe = Probe::new(scene, &scene.cameras[camera], &stage.options, sweep.exposure_ev).ok();
        Ok(Self { sweep, device, scene, camera, unshadowed, cache, size, truths, probe })
    }

    fn options(&self, choice: Choice) -> Options {
        choice.apply(&Options { size: self.size, ..self.sweep.options.clone() })
    }

    /// Measures some G-buffers against each other.
    fn race(&self, choices: &[Choice], ask: &AskPlan<'_>) -> Result<Vec<Outcome>> {
        let camera = &self.scene.cameras[self.camera];
        let racer = |&choice: &Choice| {
            Racer::new(self.device, self.scene, camera, self.sweep.exposure_ev, &self.options(choice))
        };
        // The base is itself, not another of its kind beside it.
        let others: Vec<_> = choices.iter().copied().filter(|&choice| choice != BASE).collect();
        let mut racers: Vec<_> = [BASE].iter().chain(&others).map(racer).collect();
        let clock = Clock::of(self.device);
        race(&mut racers, clock, self.sweep.effort)?;
        let mut times = racers.into_iter().map(|racer| racer.map(|racer| racer.frame_ms));
        let base_ms = times.next().expect("the base comes first")?;
        let mut outcome = |&choice: &Choice| {
            let own = if choice == BASE { Ok(base_ms.clone()) } else { times.next().expect("one for each") };
            self.outcome(choice, own, clock, &base_ms, ask)
        };
        choices.iter().map(&mut outcome).collect()
    }

    fn outcome(
        &self,
        choice: Choice,
        times: Result<Vec<f64>>,
        clock: Clock,
        base_ms: &[f64],
        ask: &AskPlan<'_>,
    ) -> Result<Outcome> {
        let frame_ms = match times {
            Ok(times) => times,
            // Not for lack of a device or memory: this combination is what cannot be.
            Err(refused @ Error::Unsupported { .. }) => return Ok(Outcome::Refused(refused.to_string())),
            Err(error) => return Err(error),
        };
        let ratios = frame_ms.iter().zip(base_ms).map(|(own, base)| own / base);
        let (Some(ratio), Some(frame_ms)) = (Summary::of(ratios), Summary::of(frame_ms.iter().copied()))
        else {
            return Ok(Outcome::Refused("no round was measured; allow one with --frames".into()));
        };
        let stage = stage(self.sweep, self.device, &self.cache, &self.unshadowed, self.camera, self.size);
        let [against_reference, against_exact] = self.truths.errors(&stage, choice)?;
        let limits = self.device.limits();
        let (bytes, plan) = bytes(self.scene, self.options(choice), &limits)?;
        let passes: Vec<_> = (0..plan.passes.len()).map(|pass| plan.occupancy(pass)).collect();
        let bins = Adreno::ALL.map(|gpu| {
            let predicted = passes.last().and_then(|last| gpu.bins(last, self.size));
            Ok(Tiled { gpu: gpu.id, predicted, driver: ask(choice, passes.clone(), &gpu)? })
        });
        let bins = bins.into_iter().collect::<Result<_>>()?;
        let (truth, left_out) = (self.truths.truth, self.truths.left_out);
        Ok(Outcome::Measured(Box::new(Measured {
            clock,
            frame_ms,
            ratio,
            bytes,
            bins,
            truth,
            left_out,
            against_reference,
            against_exact,
            is_candidate: candidates_for(&plan.needs).contains(&choice),
            predicted: self.probe.as_ref().map(|probe| probe.error(&plan)),
        })))
    }
}

fn stage<'a>(
    sweep: &Sweep<'_>,
    device: &'a Device,
    cache: &'a PipelineCache,
    scene: &'a Scene,
    camera: usize,
    size: [u32; 2],
) -> Stage<'a> {
    let options = Options { size, ..sweep.options.clone() };
    Stage { device, cache, scene, camera: &scene.cameras[camera], options, exposure_ev: sweep.exposure_ev }
}

/// What a plan moves and holds, a pixel; and the plan.
fn bytes(scene: &Scene, options: Options, limits: &Limits) -> Result<(Bytes, Plan)> {
    let plan = |strategy| Plan::new(Needs::of(scene), Options { strategy, ..options.clone() }, limits);
    let (own, separate) = (plan(options.strategy)?, plan(Strategy::Separate)?);
    let counted = if limits.gbuffer_on_chip { own.bytes_on_tile() } else { separate.bytes_moved() };
    let bytes = Bytes {
        counted,
        on_tile: own.bytes_on_tile(),
        color_bits: own.color_bits(),
        moved: own.bytes_moved(),
        moved_separate: separate.bytes_moved(),
    };
    Ok((bytes, own))
}

/// Tells scenes apart: a hash of all that is drawn, in the debugger's words.
fn scene_sha256(scene: &Scene, camera: usize) -> String {
    let mut hash = Sha256::new();
    let mut put = |bytes: &[u8]| hash.update(bytes);
    for image in &scene.images {
        put(image.rgba8());
    }
    let mut bare = scene.clone();
    bare.images.iter_mut().for_each(|image| image.texels = Vec::new().into());
    bare.cameras = vec![bare.cameras[camera].clone()];
    put(format!("{bare:?}").as_bytes());
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests;

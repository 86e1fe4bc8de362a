//! Ways to draw, measured in turns: whatever else the machine does falls on all of them alike.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::Host;
use crate::Result;
use crate::gpu::{Device, DeviceType, View};
use crate::plan::Options;
use crate::scene::{Camera, Scene};

/// Frames before the first that counts: drivers compile and allocate in them, and shadow maps are drawn.
const WARM_UP: usize = 2;
/// Frames that do not count go on for so long on devices that lower their clocks while scenes are made, seconds.
const WARM_UP_S: f64 = 0.5;
/// Rounds that are measured however long they take.
const LEAST_ROUNDS: usize = 6;

/// Where frame times come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Clock {
    /// Timestamps that the GPU wrote at the begin and the end of the frame.
    Gpu,
    /// From the begin of recording until the frame is done: where the processor that records also draws.
    Wall,
}

impl Clock {
    /// The one for a device.
    pub fn of(device: &Device) -> Self {
        let caps = device.caps();
        let has_clock = caps.timestamp_valid_bits > 0 && caps.device_type != DeviceType::Cpu;
        if has_clock { Self::Gpu } else { Self::Wall }
    }

    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Gpu => "the GPU's timestamps",
            Self::Wall => "wall clock, recording included",
        }
    }
}

/// How long to measure.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Rounds at most.
    pub rounds: usize,
    /// After so many seconds a race ends with the rounds that it has, but at least six.
    pub seconds: f64,
}

/// A way that is being measured.
pub struct Racer<'a> {
    /// What draws.
    pub host: Host,
    view: View<'a>,
    /// Milliseconds by the clock, one a round, to tenths of microseconds.
    pub frame_ms: Vec<f64>,
    /// Milliseconds that recording took the CPU, one a round.
    pub record_ms: Vec<f64>,
}

impl<'a> Racer<'a> {
    /// Makes it, and draws the first frame.
    ///
    /// # Errors
    /// As [`Host::new`]: what the device or the build does not do.
    pub fn new(
        device: &Device,
        scene: &Scene,
        camera: &'a Camera,
        exposure_ev: f32,
        options: &Options,
    ) -> Result<Self> {
        let mut host = Host::new(device, scene, options, false)?;
        let view = View { camera, exposure_ev };
        host.frame(&view)?;
        Ok(Self { host, view, frame_ms: Vec::new(), record_ms: Vec::new() })
    }

    fn frame(&mut self, clock: Clock) -> Result<()> {
        let times = self.host.frame(&self.view)?;
        let wall_ms = times.record_ms + times.wall_ms;
        self.frame_ms.push(rounded_ms(match clock {
            Clock::Wall => wall_ms,
            Clock::Gpu => times.gpu_ms.unwrap_or(wall_ms),
        }));
        self.record_ms.push(times.record_ms);
        Ok(())
    }
}

/// Draws all in turns; the same place in the racers' times is the same round. What could not be made takes no part.
///
/// # Errors
/// [`crate::Error::Vulkan`], e.g. when the device is lost.
pub fn race<E>(racers: &mut [Result<Racer<'_>, E>], clock: Clock, effort: Effort) -> Result<()> {
    let start = Instant::now();
    let mut warm_up = 1;
    while warm_up < WARM_UP || clock == Clock::Gpu && start.elapsed().as_secs_f64() < WARM_UP_S {
        for racer in racers.iter_mut().flatten() {
            racer.host.frame(&racer.view)?;
        }
        warm_up += 1;
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
    Ok(())
}

/// To tenths of microseconds, which no clock here tells apart: short in files.
pub fn rounded_ms(ms: f64) -> f64 {
    (ms * 1e4).round() / 1e4
}

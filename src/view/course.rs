//! Camera paths that are recorded and flown.

use std::path::{Path, PathBuf};

use egui::Ui;

use super::app::App;
use crate::Result;
use crate::scene::{Flight, FlightKey};

/// What becomes of the camera's way.
#[derive(Debug, Default)]
pub(super) enum Course {
    /// Nothing.
    #[default]
    Free,
    /// Each frame is a key; `None` before the first.
    Recorded { path: PathBuf, flight: Flight, time_s: Option<f64> },
    /// The camera is where the flight has it; `None` before the first frame.
    Flown { flight: Flight, time_s: Option<f64> },
}

/// What the panel asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CourseWish {
    /// Records, or stops and writes what was recorded.
    Record,
    /// Flies what was recorded last, or stops.
    Fly,
}

impl Course {
    /// A flight from its begin.
    pub(super) fn flown(flight: Flight) -> Self {
        Self::Flown { flight, time_s: None }
    }

    pub(super) fn is_flown(&self) -> bool {
        matches!(self, Self::Flown { .. })
    }

    /// Its part of the interface.
    pub(super) fn panel(&self, ui: &mut Ui) -> Option<CourseWish> {
        let record = if matches!(self, Self::Recorded { .. }) { "stop and write" } else { "record" };
        let fly = if self.is_flown() { "stop" } else { "fly what was recorded" };
        ui.horizontal(|ui| {
            let is_recording = ui.button(record).clicked();
            let is_flying = ui.button(fly).clicked();
            match (is_recording, is_flying) {
                (true, _) => Some(CourseWish::Record),
                (_, true) => Some(CourseWish::Fly),
                _ => None,
            }
        })
        .inner
    }
}

impl App {
    /// Flies so many seconds on, or records where the camera is after them.
    pub(super) fn steer(&mut self, seconds: f64) {
        match &mut self.course {
            Course::Free => {}
            Course::Recorded { flight, time_s, .. } => {
                let now_s = time_s.map_or(0.0, |time_s| time_s + seconds);
                flight.record(FlightKey::of(&self.rig.camera, now_s));
                *time_s = Some(now_s);
            }
            Course::Flown { flight, time_s } => {
                let now_s = time_s.map_or(0.0, |time_s| time_s + seconds);
                self.rig.fly_along(flight, now_s);
                *time_s = Some(now_s);
                if now_s >= flight.duration_s() {
                    self.course = Course::Free;
                }
            }
        }
    }

    /// Records the camera's way from now on, for a file of this name.
    pub(super) fn record(&mut self, path: PathBuf) -> Result<()> {
        self.end_course()?;
        self.course = Course::Recorded { path, flight: Flight::default(), time_s: None };
        Ok(())
    }

    /// Flies along what a file says.
    pub(super) fn fly(&mut self, path: &Path) -> Result<()> {
        self.end_course()?;
        self.course = Course::flown(Flight::load(path)?);
        Ok(())
    }

    /// Stops, and writes what was recorded.
    pub(super) fn end_course(&mut self) -> Result<()> {
        if let Course::Recorded { path, flight, .. } = std::mem::take(&mut self.course)
            && !flight.keys().is_empty()
        {
            flight.save(&path)?;
            self.recorded = Some(path);
        }
        Ok(())
    }

    /// Does what keys or panel ask for, and says how it went.
    pub(super) fn set_course(&mut self, wish: CourseWish) {
        let done = match (wish, &self.course) {
            (CourseWish::Record, Course::Recorded { path, .. }) => {
                let told = format!("camera path: {}", path.display());
                self.end_course().map(|()| self.tell_text(&told))
            }
            (CourseWish::Record, _) => self.record(super::app::free_name("flight")),
            (CourseWish::Fly, Course::Flown { .. }) => self.end_course(),
            (CourseWish::Fly, _) => self.end_course().and_then(|()| match self.recorded.clone() {
                Some(path) => self.fly(&path),
                None => {
                    self.tell_text("no camera path was recorded");
                    Ok(())
                }
            }),
        };
        if let Err(error) = done {
            self.tell(&error);
        }
    }
}

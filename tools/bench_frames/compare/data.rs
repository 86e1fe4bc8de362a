//! What was measured, as it is written and read: everything else in a report follows from it.

use std::path::Path;

use clap::ValueEnum;
use ontile::measure::{Clock, Summary};
use ontile::{Error, Result, file};
use serde::{Deserialize, Serialize};

use super::maths::Ratio;

/// Changes whenever older files can no longer be read.
const VERSION: u32 = 1;

/// The runs of one or several machines.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Report {
    version: u32,
    pub runs: Vec<Run>,
}

/// All tables on one device.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    pub device: String,
    pub driver: String,
    pub clock: Clock,
    pub tables: Vec<Table>,
}

/// One question.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Table {
    pub name: TableName,
    pub rows: Vec<Row>,
}

/// Ways that were measured in turns.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    pub label: String,
    /// The place on the chart's axis.
    pub x: f64,
    pub size: [u32; 2],
    /// What `auto` would do; `None` where the build or the device has no such choice.
    #[serde(default)]
    pub auto: Option<Auto>,
    pub cells: Vec<Cell>,
}

/// A plan's choices for a row's scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Auto {
    /// Of all paths.
    pub path: String,
    /// The way of lights, deferred.
    pub lights: String,
}

/// One way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Cell {
    pub way: String,
    #[serde(flatten)]
    pub outcome: Outcome,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    Measured(Measured),
    /// Why the build or the device does not do it.
    Refused(String),
}

/// What the frames of one way took.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Measured {
    /// Milliseconds by the run's clock, one a round; the same place in another cell of the row is the same round.
    pub frame_ms: Vec<f64>,
    /// Milliseconds that recording took the CPU, median.
    pub record_ms: f64,
    /// Milliseconds of each stage, medians of frames with a timestamp after each, in the frame's order; where asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stage_ms: Vec<(String, f64)>,
    /// Draw calls of the first frame, which also draws shadow maps that are then kept.
    pub first_draws: usize,
    /// Draw calls of the last frame.
    pub draws: usize,
    /// State changes of the last frame.
    pub state_changes: usize,
    /// Objects and lights of the last frame that culling left.
    pub objects: usize,
    pub lights: usize,
    /// The path and the way of lights that the plan came to.
    pub plan: String,
}

/// The tables of a report, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum TableName {
    /// The canyon at several sizes
    Exterior,
    /// The generator hall at several sizes
    Interior,
    /// Draw calls with shadows on and off
    Draws,
    /// One and two overlapping spots that cover little and much of the screen
    Coverage,
    /// A light whose volume touches no surface
    Floating,
    /// Forward in many passes with and without illumination sets
    Sets,
    /// From one to many lights of 2 m range over a floor of 24 m with 64 objects
    Lights,
    /// From one to 256 lights that cover about 1 % of the screen each
    Small,
    /// 64 lights that overlap more and more
    Overlap,
    /// Surfaces behind surfaces, drawn from back to front
    Overdraw,
}

impl TableName {
    /// As the command line and files spell it.
    pub fn name(self) -> String {
        self.to_possible_value().expect("no table is hidden").get_name().to_owned()
    }
}

impl Report {
    pub fn new(runs: Vec<Run>) -> Self {
        Self { version: VERSION, runs }
    }

    /// # Errors
    /// [`Error::Io`]; [`Error::Unsupported`] for what is no such report.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
        let bad = |what: String| {
            Error::unsupported(
                format!("{}: {what}", path.display()),
                "give a comparison.json that this version of `tools/bench compare` wrote",
            )
        };
        let report: Self = serde_json::from_slice(&bytes).map_err(|e| bad(e.to_string()))?;
        if report.version != VERSION {
            return Err(bad(format!("version {} of the report, not {VERSION}", report.version)));
        }
        let times = report.cells().filter_map(|(_, _, _, cell)| cell.measured()).flat_map(|m| &m.frame_ms);
        if times.into_iter().any(|ms| !ms.is_finite() || *ms <= 0.0) {
            return Err(bad("a frame time that is not a positive number".into()));
        }
        Ok(report)
    }

    /// # Errors
    /// [`Error::Io`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let json = serde_json::to_string(self).map_err(|e| Error::io(path, "write", e.into()))?;
        file::write_whole(path, json.as_bytes())
    }

    /// Adds another report's runs. A run of a device that is already there adds its tables, and replaces those of
    /// the same name.
    pub fn merge(&mut self, other: Self) {
        for run in other.runs {
            match self.runs.iter_mut().find(|known| known.device == run.device && known.driver == run.driver)
            {
                Some(known) => run.tables.into_iter().for_each(|table| known.put(table)),
                None => self.runs.push(run),
            }
        }
    }

    /// Every cell with where it is.
    pub fn cells(&self) -> impl Iterator<Item = (&Run, &Table, &Row, &Cell)> {
        self.runs.iter().flat_map(|run| {
            run.tables.iter().flat_map(move |table| {
                table
                    .rows
                    .iter()
                    .flat_map(move |row| row.cells.iter().map(move |cell| (run, table, row, cell)))
            })
        })
    }
}

impl Run {
    pub fn table(&self, name: TableName) -> Option<&Table> {
        self.tables.iter().find(|t| t.name == name)
    }

    pub fn put(&mut self, table: Table) {
        self.tables.retain(|t| t.name != table.name);
        self.tables.push(table);
        self.tables.sort_by_key(|t| t.name);
    }

    /// The device's name without what drivers add in brackets.
    pub fn short_name(&self) -> &str {
        self.device.split(" (").next().unwrap_or(&self.device)
    }
}

impl Table {
    /// The ways of all rows, in order of appearance.
    pub fn ways(&self) -> Vec<&str> {
        let mut ways: Vec<&str> = Vec::new();
        for cell in self.rows.iter().flat_map(|row| &row.cells) {
            if !ways.contains(&cell.way.as_str()) {
                ways.push(&cell.way);
            }
        }
        ways
    }

    pub fn row(&self, x: f64) -> Option<&Row> {
        self.rows.iter().find(|row| row.x == x)
    }
}

impl Row {
    pub fn measured(&self, way: &str) -> Option<&Measured> {
        self.cells.iter().find(|cell| cell.way == way)?.measured()
    }

    /// Median milliseconds.
    pub fn ms(&self, way: &str) -> Option<f64> {
        Some(self.measured(way)?.frame()?.median)
    }

    pub fn ratio(&self, way: &str, to: &str) -> Option<Ratio> {
        Ratio::of(&self.measured(way)?.frame_ms, &self.measured(to)?.frame_ms)
    }

    /// The cheapest of these.
    pub fn best<'a>(&self, ways: &[&'a str]) -> Option<(&'a str, f64)> {
        let measured = ways.iter().filter_map(|&way| Some((way, self.ms(way)?)));
        measured.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

impl Cell {
    pub fn measured(&self) -> Option<&Measured> {
        match &self.outcome {
            Outcome::Measured(measured) => Some(measured),
            Outcome::Refused(_) => None,
        }
    }
}

impl Measured {
    pub fn frame(&self) -> Option<Summary> {
        Summary::of(self.frame_ms.iter().copied())
    }
}

//! What was measured, as it is written and read: everything else in a chart's folder follows from it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::measure::{Clock, Comparison, Predicted, Summary};
use crate::plan::{Bins, Choice, Strategy, Tonemap};
use crate::{Error, Result, file};

/// Changes whenever older files can no longer be read.
const SCHEMA: &str = "ontile-chart-1";

/// The file that holds everything.
const FILE: &str = "chart.json";

/// Cells of one or several devices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    schema: String,
    /// In order of measurement.
    pub cells: Vec<Cell>,
}

/// One G-buffer in one place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Where, and by whom.
    pub place: Place,
    /// The G-buffer.
    pub choice: Choice,
    /// What came of it.
    pub outcome: Outcome,
}

/// All that a result depends on, but for the G-buffer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// The scene's name.
    pub scene: String,
    /// SHA-256 of the scene as it is drawn, in hexadecimal digits.
    pub scene_sha256: String,
    /// The camera's name.
    pub camera: String,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// How stages become passes.
    pub strategy: Strategy,
    /// The curve.
    pub tonemap: Tonemap,
    /// Exposure, stops.
    pub exposure_ev: f32,
    /// Rounds at most, and the seconds after which a race ends.
    pub rounds: usize,
    /// See `rounds`.
    pub seconds: f64,
    /// The device's name.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// The program's version, and digits of its hash.
    pub program: String,
}

/// What came of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It was drawn.
    Measured(Box<Measured>),
    /// Why the build, the scene or the device does not do it.
    Refused(String),
}

/// Figures of one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Where times come from.
    pub clock: Clock,
    /// Milliseconds a frame.
    pub frame_ms: Summary,
    /// Time over that of the base choice's frame in the same round.
    pub ratio: Summary,
    /// What the plan asks for.
    pub bytes: Bytes,
    /// On each GPU of [`crate::plan::Adreno::ALL`].
    pub bins: Vec<Tiled>,
    /// What the reference was given.
    pub truth: Truth,
    /// The share of the covered pixels that is left out, because a rasteriser may rightly see something else there.
    pub left_out: f64,
    /// The picture against the f64 reference: all that is lost.
    pub against_reference: Errors,
    /// The picture against that of the layout `exact` on the same device: what the formats lose.
    pub against_exact: Errors,
    /// What the probe of `--layout auto` says of the picture against the reference; `None` if it sees no lit surface.
    pub predicted: Option<Predicted>,
    /// Whether `--layout auto` considers this G-buffer for the scene.
    pub is_candidate: bool,
}

/// Bytes a pixel; planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bytes {
    /// Of all attachments of one pass, depth and the output among them: what the tile holds.
    pub on_tile: u32,
    /// Colour bits of the same.
    pub color_bits: u32,
    /// Loaded from and stored to memory by a frame as it was drawn.
    pub moved: u32,
    /// The same if every stage were a pass of its own.
    pub moved_separate: u32,
    /// Of these, what `--layout auto` counts on this device: the tile's where a G-buffer stays on the chip, else those moved.
    pub counted: u32,
}

/// How a GPU's tile memory cuts the frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tiled {
    /// The number in an Adreno's name.
    pub gpu: u32,
    /// By the driver's rule; `None`: not tiled.
    pub predicted: Option<Bins>,
    /// What the driver said, where it was asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driver: Option<DriverFigures>,
}

/// What Mesa's Turnip said of the frame's last pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DriverFigures {
    /// How it was cut; `None`: not tiled.
    pub bins: Option<Bins>,
    /// Render passes, those of shadow tiles left out.
    pub passes: u32,
    /// Bytes a pixel that all passes load.
    pub loaded: u32,
    /// Bytes a pixel that all passes store.
    pub stored: u32,
}

/// What the reference was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Truth {
    /// The scene: it traces rays, and shades in f64.
    Scene,
    /// The surfaces of the GPU's `exact` G-buffer, which it shades in f64: texture filters are the driver's own.
    Surfaces,
}

/// How far a picture is from another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Of the 8-bit picture; `None`: equal.
    pub psnr_db: Option<f64>,
    /// Mean FLIP of the 8-bit picture.
    pub flip: f64,
    /// CIEDE2000 that 95 % of the 8-bit picture's pixels do not exceed.
    pub ciede2000_p95: f64,
    /// The largest relative error of a channel of linear light, by [`crate::measure::RELATIVE_FLOOR`].
    pub relative_max: f64,
    /// The relative error that 95 % of the channels do not exceed.
    pub relative_p95: f64,
}

impl Errors {
    /// From the comparisons of the 8-bit pictures and of linear light.
    pub fn new(display: &Comparison, light: &Comparison) -> Self {
        Self {
            psnr_db: display.psnr_db.map(|db| rounded(db, 4)),
            flip: rounded(display.flip_mean, 7),
            ciede2000_p95: rounded(display.ciede2000_p95, 5),
            relative_max: rounded(light.relative_error_max.unwrap_or_default(), 7),
            relative_p95: rounded(light.relative_error_p95.unwrap_or_default(), 7),
        }
    }
}

/// Short in files.
fn rounded(x: f64, digits: i32) -> f64 {
    let factor = 10_f64.powi(digits);
    (x * factor).round() / factor
}

impl Report {
    /// Holding these.
    pub fn new(cells: Vec<Cell>) -> Self {
        Self { schema: SCHEMA.into(), cells }
    }

    /// The file of a folder that holds a report.
    pub fn path(folder: &Path) -> PathBuf {
        folder.join(FILE)
    }

    /// Reads a folder's report.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] for what is no such report.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = Self::path(folder);
        let bytes = std::fs::read(&path).map_err(|e| Error::io(&path, "read", e))?;
        let bad = |element: &str, problem: String| {
            let remedy = "give a folder that this version of 'ontile chart' wrote, or an empty one";
            Error::input(&path, element, problem, remedy)
        };
        // The version first: what follows it may be of another shape.
        #[derive(Deserialize)]
        struct Version {
            schema: String,
        }
        let version: Version = serde_json::from_slice(&bytes).map_err(|e| bad("schema", e.to_string()))?;
        if version.schema != SCHEMA {
            return Err(bad("schema", format!("'{}', not '{SCHEMA}'", version.schema)));
        }
        let report: Self = serde_json::from_slice(&bytes).map_err(|e| bad("cells", e.to_string()))?;
        for (i, cell) in report.cells.iter().enumerate() {
            let Outcome::Measured(m) = &cell.outcome else { continue };
            let (r, e) = (&m.against_reference, &m.against_exact);
            let errors = [r, e].into_iter().flat_map(|e| [e.flip, e.ciede2000_p95, e.relative_max]);
            let all = errors.chain([m.frame_ms.median, m.ratio.median, m.left_out]);
            if !(m.frame_ms.median > 0.0 && all.into_iter().all(|x| x.is_finite() && x >= 0.0)) {
                return Err(bad(
                    &format!("cells[{i}]"),
                    "a figure that is negative, infinite or no number".into(),
                ));
            }
        }
        Ok(report)
    }

    /// Writes it into a folder.
    ///
    /// # Errors
    /// [`Error::Io`]; what was there is then as it was.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let path = Self::path(folder);
        let json = serde_json::to_string(self).map_err(|e| Error::io(&path, "write", e.into()))?;
        file::write_whole(&path, json.as_bytes())
    }

    /// Adds a cell, in place of one that was measured under the same conditions.
    pub fn put(&mut self, cell: Cell) {
        match self.cells.iter_mut().find(|known| known.is_of(&cell.place, cell.choice)) {
            Some(known) => *known = cell,
            None => self.cells.push(cell),
        }
    }

    /// Adds another report's cells.
    pub fn merge(&mut self, other: Self) {
        other.cells.into_iter().for_each(|cell| self.put(cell));
    }

    /// Whether there is such a cell.
    pub fn has(&self, place: &Place, choice: Choice) -> bool {
        self.cells.iter().any(|cell| cell.is_of(place, choice))
    }

    /// The cells by place, in order of appearance.
    pub fn by_place(&self) -> Vec<(&Place, Vec<&Cell>)> {
        let mut places: Vec<(&Place, Vec<&Cell>)> = Vec::new();
        for cell in &self.cells {
            match places.iter_mut().find(|(place, _)| **place == cell.place) {
                Some((_, cells)) => cells.push(cell),
                None => places.push((&cell.place, vec![cell])),
            }
        }
        places
    }

    /// The devices, in order of appearance.
    pub fn devices(&self) -> Vec<&str> {
        let mut devices = Vec::new();
        for cell in &self.cells {
            if !devices.contains(&cell.place.device.as_str()) {
                devices.push(&cell.place.device);
            }
        }
        devices
    }
}

impl Cell {
    fn is_of(&self, place: &Place, choice: Choice) -> bool {
        self.choice == choice && self.place == *place
    }

    /// Its figures, if it was drawn.
    pub fn measured(&self) -> Option<&Measured> {
        match &self.outcome {
            Outcome::Measured(measured) => Some(measured),
            Outcome::Refused(_) => None,
        }
    }
}

impl Place {
    /// The device's name without what drivers add in brackets.
    pub fn device_name(&self) -> &str {
        device_name(&self.device)
    }

    /// Scene and size in words.
    pub fn title(&self) -> String {
        let [width, height] = self.size;
        format!("{} at {width} x {height}", self.scene)
    }
}

/// A device's name without what drivers add in brackets.
pub fn device_name(device: &str) -> &str {
    device.split(" (").next().unwrap_or(device)
}

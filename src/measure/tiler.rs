//! What a tiler did with a frame, in the words of its own driver.
//!
//! Mesa's Turnip (Adreno) prints every render pass with its bins and its tile loads and stores as `u_trace` text:
//! `MESA_GPU_TRACES=print TU_DEBUG=gmem,nolrz,perf`. [`TilerTrace::parse`] reads it, from output that may be mixed with
//! the program's own, and [`TilerTrace::verdict`] says whether the frame stayed on the tile.
//!
//! What the figures do not say:
//! - The driver counts the bytes that a tiled pass would store. A pass that it does not tile writes every attachment to
//!   memory all the time and still reports the same figure, so the figure counts only with [`TilerPass::tiled`].
//! - An input attachment that an earlier render pass stored is read as a texture and not counted as loaded; that
//!   traffic shows only as a second pass.
//! - The text appears when the `VkDevice` is destroyed, and not at all if it never is.

use crate::{Error, Result};
use std::{collections::BTreeMap, fmt, path::Path};

/// One `VkRenderPass` (or dynamic rendering) as the driver executed it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TilerPass {
    /// Width of the render area's framebuffer, in pixels.
    pub width_px: u32,
    /// Height of the render area's framebuffer, in pixels.
    pub height_px: u32,
    /// Number of attachments of the render pass, used or not.
    pub attachments: u32,
    /// Bytes per pixel that are cleared when a tile begins.
    pub clear_bytes_per_pixel: u32,
    /// Bytes per pixel that are read from memory when a tile begins.
    pub load_bytes_per_pixel: u32,
    /// Bytes per pixel that are written to memory when a tile ends.
    pub store_bytes_per_pixel: u32,
    /// Number of tiles that the framebuffer was cut into.
    pub bins: u32,
    /// Width of a tile, in pixels.
    pub bin_width_px: u32,
    /// Height of a tile, in pixels.
    pub bin_height_px: u32,
    /// Whether the pass was rendered tile by tile in on-chip memory.
    pub tiled: bool,
    /// Why the driver chose so; empty when it gave no reason. Under `TU_DEBUG=gmem` tiled passes have one too.
    pub reason: String,
    /// Number of draw calls in all subpasses.
    pub draws: u32,
    /// Tile loads recorded, by format: one for each attachment and tile, and one more for each attachment where a binning
    /// pass goes before (the driver leaves it out for very few tiles), because that records them too.
    pub loads: BTreeMap<String, u32>,
    /// Tile stores recorded, by format; counted as `loads` are.
    pub stores: BTreeMap<String, u32>,
}

/// What the driver printed about a run of a program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TilerTrace {
    /// The render passes, in order of execution.
    pub passes: Vec<TilerPass>,
    /// The driver's remarks outside the trace, each once, in order. With `TU_DEBUG=perf` it says here why it will not
    /// tile, e.g. `Disabling gmem rendering due to invalid subpass dependency`.
    pub warnings: Vec<String>,
}

/// Whether a frame stayed on the tile. See [`TilerTrace::verdict`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// One tiled pass that loads nothing and stores the final image only.
    OnTile,
    /// It did not, for each of these reasons (at least one).
    OffTile(Vec<String>),
}

impl TilerTrace {
    /// Reads the output of a program; lines that are not Turnip's are skipped. `source` is named in errors.
    ///
    /// # Errors
    ///
    /// [`Error::Input`] with the number of the line: when there is no trace at all, when a render pass does not end
    /// (output was cut off) or does not begin, or when a figure is missing or not a number.
    pub fn parse(source: &Path, text: &str) -> Result<Self> {
        let mut trace = Self::default();
        let mut open: Option<(usize, TilerPass)> = None;
        let mut events = 0_usize;
        for (index, line) in text.lines().enumerate() {
            let number = index + 1;
            let Some(event) = Event::parse(line) else {
                trace.note_warning(line);
                continue;
            };
            events += 1;
            match event.name {
                "start_render_pass" => {
                    if let Some((started, _)) = open {
                        return Err(malformed(source, number, started_twice(started)));
                    }
                    let pass = begin_pass(&event).map_err(|problem| malformed(source, number, problem))?;
                    open = Some((number, pass));
                }
                "end_render_pass" => {
                    let Some((_, mut pass)) = open.take() else {
                        return Err(malformed(source, number, "a render pass ends that never began".into()));
                    };
                    end_pass(&mut pass, &event).map_err(|problem| malformed(source, number, problem))?;
                    trace.passes.push(pass);
                }
                "start_gmem_load" | "start_gmem_store" => {
                    // Outside a pass these belong to nothing that is counted here (e.g. a stand-alone blit).
                    if let Some((_, pass)) = &mut open {
                        let format =
                            event.text("format").map_err(|problem| malformed(source, number, problem))?;
                        let counts =
                            if event.name == "start_gmem_load" { &mut pass.loads } else { &mut pass.stores };
                        *counts.entry(format.to_owned()).or_default() += 1;
                    }
                }
                _ => {}
            }
        }
        if let Some((started, _)) = open {
            return Err(malformed(source, started, "this render pass does not end".into()));
        }
        if events == 0 {
            return Err(Error::input(
                source,
                "output",
                "holds no driver trace",
                "run on Turnip with MESA_GPU_TRACES=print, and destroy the VkDevice before the program ends",
            ));
        }
        Ok(trace)
    }

    /// Whether the frame stayed on the tile: exactly one render pass, tiled in more than one bin, that loads nothing and
    /// stores `stored_bytes_per_pixel`, with no remark of the driver that it gives up tiling.
    ///
    /// A framebuffer that fits into one bin proves nothing, so it counts as off the tile: use a larger one.
    /// The trace must be that of one frame.
    #[must_use]
    pub fn verdict(&self, stored_bytes_per_pixel: u32) -> Verdict {
        let mut reasons = Vec::new();
        if self.passes.len() != 1 {
            reasons.push(format!("{} render passes instead of 1", self.passes.len()));
        }
        for (index, pass) in self.passes.iter().enumerate() {
            let mut add = |problem: String| reasons.push(format!("pass {index}: {problem}"));
            if !pass.tiled {
                add(format!("not tiled: {}", pass.reason));
            }
            if pass.bins <= 1 {
                add(format!(
                    "{} bin of {}x{} pixels instead of several",
                    pass.bins, pass.bin_width_px, pass.bin_height_px
                ));
            }
            if pass.load_bytes_per_pixel != 0 {
                add(format!("loads {} bytes per pixel instead of 0", pass.load_bytes_per_pixel));
            }
            if !pass.loads.is_empty() {
                add(format!("loads {}", formats(&pass.loads)));
            }
            if pass.store_bytes_per_pixel != stored_bytes_per_pixel {
                add(format!(
                    "stores {} bytes per pixel instead of {stored_bytes_per_pixel} ({})",
                    pass.store_bytes_per_pixel,
                    formats(&pass.stores)
                ));
            }
        }
        reasons.extend(self.warnings.iter().filter(|line| gives_up_tiling(line)).cloned());
        if reasons.is_empty() { Verdict::OnTile } else { Verdict::OffTile(reasons) }
    }

    /// The trace without its first passes, e.g. those that draw shadow maps before the frame's own.
    #[must_use]
    pub fn after(&self, passes: usize) -> Self {
        Self { passes: self.passes.iter().skip(passes).cloned().collect(), warnings: self.warnings.clone() }
    }

    fn note_warning(&mut self, line: &str) {
        let line = line.trim();
        if (line.starts_with("TU: ") || gives_up_tiling(line))
            && !self.warnings.iter().any(|seen| seen == line)
        {
            self.warnings.push(line.to_owned());
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OnTile => f.write_str("on tile"),
            Self::OffTile(reasons) => write!(f, "off tile: {}", reasons.join("; ")),
        }
    }
}

/// One line of the trace: `0000000000000000        +0: start_gmem_store: format=r8g8b8a8_srgb, fast_path=1, `.
struct Event<'a> {
    name: &'a str,
    fields: &'a str,
}

impl<'a> Event<'a> {
    /// `None` if the line is not one: 16 hexadecimal digits of time, a signed difference, a name, perhaps fields.
    fn parse(line: &'a str) -> Option<Self> {
        let (time, rest) = line.split_at_checked(16)?;
        if !time.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return None;
        }
        let (difference, event) = rest.trim_start().split_once(": ")?;
        if !difference.starts_with(['+', '-']) {
            return None;
        }
        let (name, fields) = event.split_once(':').unwrap_or((event, ""));
        Some(Self { name: name.trim(), fields })
    }

    /// The value of `name=value, `, where the value may hold commas but no `, other=`.
    fn text(&self, name: &str) -> Result<&'a str, String> {
        let missing = || format!("{} has no {name}", self.name);
        let mut begin = None;
        let mut offset = 0;
        for piece in self.fields.split_inclusive(", ") {
            let key = piece.trim_start().split_once('=').map(|(key, _)| key);
            if let Some(key) =
                key.filter(|key| key.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_'))
            {
                if let Some(begin) = begin {
                    return Ok(field_value(&self.fields[begin..offset]));
                }
                if key == name {
                    begin = Some(offset);
                }
            }
            offset += piece.len();
        }
        begin.map(|begin| field_value(&self.fields[begin..])).ok_or_else(missing)
    }

    fn number(&self, name: &str) -> Result<u32, String> {
        let value = self.text(name)?;
        value.parse().map_err(|_| format!("{}: {name} is `{value}`, not a count", self.name))
    }

    fn flag(&self, name: &str) -> Result<bool, String> {
        let value = self.text(name)?;
        value.parse().map_err(|_| format!("{}: {name} is `{value}`, not true or false", self.name))
    }
}

/// ` name=value, ` without its name and separator.
fn field_value(field: &str) -> &str {
    let value = field.split_once('=').map_or("", |(_, value)| value);
    value.trim_end().trim_end_matches(',').trim_end()
}

fn begin_pass(event: &Event) -> Result<TilerPass, String> {
    Ok(TilerPass {
        width_px: event.number("width")?,
        height_px: event.number("height")?,
        attachments: event.number("attachment_count")?,
        clear_bytes_per_pixel: event.number("clearCPP")?,
        load_bytes_per_pixel: event.number("loadCPP")?,
        store_bytes_per_pixel: event.number("storeCPP")?,
        bins: event.number("numberOfBins")?,
        bin_width_px: event.number("binWidth")?,
        bin_height_px: event.number("binHeight")?,
        tiled: false,
        reason: String::new(),
        draws: 0,
        loads: BTreeMap::new(),
        stores: BTreeMap::new(),
    })
}

fn end_pass(pass: &mut TilerPass, event: &Event) -> Result<(), String> {
    pass.tiled = event.flag("tiledRender")?;
    pass.reason = event.text("tilingDisableReason")?.to_owned();
    pass.draws = event.number("drawCount")?;
    Ok(())
}

/// The two remarks with which Turnip leaves on-chip memory (which it calls gmem).
fn gives_up_tiling(line: &str) -> bool {
    line.contains("Disabling gmem rendering") || line.contains("Can't fit attachments into gmem")
}

fn formats(counts: &BTreeMap<String, u32>) -> String {
    counts.keys().cloned().collect::<Vec<_>>().join(", ")
}

fn started_twice(line: usize) -> String {
    format!("a render pass begins inside the one of line {line}")
}

fn malformed(source: &Path, line: usize, problem: String) -> Error {
    let remedy =
        "let one program at a time write to this output, and let it end; or the driver's format has changed";
    Error::input(source, format!("line {line}"), problem, remedy)
}

#[cfg(test)]
#[path = "tiler_tests.rs"]
mod tests;

//! What a study found, as a table, a page, JSON and pictures.

use std::fmt::{self, Write};
use std::path::Path;

use serde::Serialize;

use super::{Case, Drawing, Figure, Findings, Scale, Sweep, Verdict};
use crate::measure::canvas::{self, short};
use crate::{Error, Result, file};

/// What several sweeps found.
#[derive(Debug)]
pub struct Study {
    scale: Scale,
    /// The device that drew, if one did.
    device: Option<String>,
    done: Vec<(&'static Sweep, Findings)>,
    /// Sweeps that could not be run, and why.
    skipped: Vec<(&'static Sweep, String)>,
}

#[derive(Serialize)]
struct SweepReport<'a> {
    name: &'a str,
    title: &'a str,
    varies: &'a str,
    cases: Vec<CaseReport<'a>>,
    pictures: Vec<String>,
}

#[derive(Serialize)]
struct CaseReport<'a> {
    verdict: Verdict,
    #[serde(flatten)]
    case: &'a Case,
}

#[derive(Serialize)]
struct StudyReport<'a> {
    scale: Scale,
    device: Option<&'a str>,
    sweeps: Vec<SweepReport<'a>>,
    skipped: Vec<[&'a str; 2]>,
}

impl Study {
    /// Of nothing yet.
    pub fn new(scale: Scale, device: Option<String>) -> Self {
        Self { scale, device, done: Vec::new(), skipped: Vec::new() }
    }

    /// Adds what a sweep found.
    pub fn add(&mut self, sweep: &'static Sweep, findings: Findings) {
        self.done.push((sweep, findings));
    }

    /// Adds a sweep that could not be run.
    pub fn skip(&mut self, sweep: &'static Sweep, why: String) {
        self.skipped.push((sweep, why));
    }

    /// The cases that fail with nothing done about it: sweep, method.
    pub fn failures(&self) -> Vec<(&'static str, &str)> {
        let cases = self.done.iter().flat_map(|(sweep, found)| found.cases.iter().map(|c| (sweep.name, c)));
        let failed = cases.filter(|(_, case)| case.verdict() == Verdict::Fails);
        failed.map(|(sweep, case)| (sweep, case.method.as_str())).collect()
    }

    /// Writes `README.md`, `stability.json` and the pictures into a folder that exists.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Unsupported`] if a chart has nothing to show.
    pub fn write(&self, folder: &Path) -> Result<()> {
        for (sweep, findings) in &self.done {
            for figure in &findings.figures {
                figure.write(&folder.join(stem(sweep, figure)))?;
            }
        }
        let path = folder.join("stability.json");
        let mut json =
            serde_json::to_string_pretty(&self.report()).map_err(|e| Error::io(&path, "write", e.into()))?;
        json.push('\n');
        file::write_whole(&path, json.as_bytes())?;
        // The last to get its name: it refers to the others.
        file::write_whole(&folder.join("README.md"), self.page().as_bytes())
    }

    fn report(&self) -> StudyReport<'_> {
        let sweeps = self.done.iter().map(|(sweep, findings)| SweepReport {
            name: sweep.name,
            title: sweep.title,
            varies: sweep.varies,
            cases: findings.cases.iter().map(|case| CaseReport { verdict: case.verdict(), case }).collect(),
            pictures: findings.figures.iter().map(|figure| format!("{}.png", stem(sweep, figure))).collect(),
        });
        StudyReport {
            scale: self.scale,
            device: self.device.as_deref(),
            sweeps: sweeps.collect(),
            skipped: self.skipped.iter().map(|(sweep, why)| [sweep.name, why.as_str()]).collect(),
        }
    }

    /// One page of Markdown.
    fn page(&self) -> String {
        let mut page = String::from("# Where methods fail\n\n");
        let device = self.device.as_deref().unwrap_or("no device");
        // Writing to a string cannot fail.
        let _ = writeln!(
            page,
            "Each sweep takes methods from where they are right to where they are not. *Holds*: nobody sees the error. \
             *Degrades within bound*: the error is what its formula says. *Fails*: it is more, and the renderer mends it \
             (another formula), guards it (keeps inputs away) or refuses it (with a message). Drawn on {device}.\n"
        );
        page.push_str("| sweep | method | worst | where | bound | verdict |\n|---|---|---|---|---|---|\n");
        for (sweep, findings) in &self.done {
            for case in &findings.cases {
                let Case { method, at, bound, .. } = case;
                let _ = writeln!(
                    page,
                    "| [{}](#{}) | {method} | {} | {at} | {} {} | {} |",
                    sweep.name,
                    sweep.name,
                    short(case.worst),
                    short(bound.most),
                    bound.unit,
                    case.verdict().text()
                );
            }
        }
        for (sweep, why) in &self.skipped {
            let _ = writeln!(page, "\nNot run: {}: {why}", sweep.name);
        }
        for (sweep, findings) in &self.done {
            let _ = writeln!(
                page,
                "\n## {}\n\n{}. {} Varied: {}.\n",
                sweep.name, sweep.title, sweep.about, sweep.varies
            );
            let mut bounds: Vec<_> = findings.cases.iter().map(|case| &case.bound).collect();
            bounds.dedup_by_key(|bound| bound.name);
            for bound in bounds {
                let _ = writeln!(
                    page,
                    "- `{}`: holds up to {}, fails beyond {} {}: {}.",
                    bound.name,
                    short(bound.good),
                    short(bound.most),
                    bound.unit,
                    bound.reason
                );
            }
            for case in findings.cases.iter().filter(|case| !case.remedy.is_empty()) {
                let _ = writeln!(page, "- {}: {}.", case.method, case.remedy);
            }
            for figure in &findings.figures {
                let _ = writeln!(
                    page,
                    "\n![{}]({}.png)\n\n{}",
                    figure.caption,
                    stem(sweep, figure),
                    figure.caption
                );
            }
        }
        page
    }
}

fn stem(sweep: &Sweep, figure: &Figure) -> String {
    format!("{}-{}", sweep.name, figure.name)
}

impl Figure {
    /// Writes `stem` with the extensions that it has.
    fn write(&self, stem: &Path) -> Result<()> {
        match &self.drawing {
            Drawing::Plot(plot) => canvas::Drawing::write(plot.as_ref(), stem),
            Drawing::Picture(picture) => picture.to_srgb8().write(&stem.with_extension("png")),
        }
    }
}

impl fmt::Display for Study {
    /// A table to read.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cases = || self.done.iter().flat_map(|(_, findings)| &findings.cases);
        let width = cases().map(|case| case.method.chars().count()).max().unwrap_or(0).max(6);
        writeln!(
            f,
            "{:<14} {:<width$} {:>10} {:>10} {:<16} verdict",
            "sweep", "method", "worst", "bound", "unit"
        )?;
        for (sweep, findings) in &self.done {
            for case in &findings.cases {
                writeln!(
                    f,
                    "{:<14} {:<width$} {:>10} {:>10} {:<16} {}",
                    sweep.name,
                    case.method,
                    short(case.worst),
                    short(case.bound.most),
                    case.bound.unit,
                    case.verdict().text()
                )?;
            }
        }
        for (sweep, why) in &self.skipped {
            writeln!(f, "{:<14} not run: {why}", sweep.name)?;
        }
        write!(f, "{} cases of {} sweeps, {} fail", cases().count(), self.done.len(), self.failures().len())
    }
}

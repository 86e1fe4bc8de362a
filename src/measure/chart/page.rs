//! One Markdown page that a person reads in two minutes. Every statement follows from the numbers.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::BASE;
use super::data::{Measured, Outcome, Report, Truth, device_name};
use super::hits::{Hits, Predictor, hits};
use super::metric::{Cost, Metric};
use super::plots::{file_name, is_charted};
use super::standing::{Standing, standings, winners};
use crate::measure::canvas::short;
use crate::plan::Bins;

/// The page; charts are expected beside it.
pub(super) fn page(report: &Report) -> String {
    let mut page = String::from("# G-buffers: speed against accuracy\n\n");
    page += "Written by `ontile chart`; every sentence below follows from the measurements in `chart.json` (as a table:\n\
             `chart.csv`). Errors are those of pictures without shadows, on pixels that surfaces cover and no silhouette crosses,\n\
             against a renderer in f64; the worst of all scenes and sizes counts. Times are relative to ";
    let _ = writeln!(page, "`{BASE}`, drawn in\nthe same rounds.\n");
    for device in report.devices() {
        about(&mut page, report, device);
    }
    for device in report.devices() {
        let standings = standings(report, device);
        wins(&mut page, device, &standings);
        numbers(&mut page, device, &standings);
        others(&mut page, device, &standings);
    }
    predictions(&mut page, report);
    charts(&mut page, report);
    tiles(&mut page, report);
    refusals(&mut page, report);
    page
}

fn about(page: &mut String, report: &Report, device: &str) {
    let cells = || report.cells.iter().filter(|cell| cell.place.device == device);
    let Some(first) = cells().next() else { return };
    let measured: Vec<&Measured> = cells().filter_map(|cell| cell.measured()).collect();
    let mut places: Vec<String> = Vec::new();
    for cell in cells() {
        let title = cell.place.title();
        if !places.contains(&title) {
            places.push(title);
        }
    }
    let rounds = measured.iter().map(|m| m.frame_ms.count);
    let (least, most) = rounds.fold((usize::MAX, 0), |(a, b), n| (a.min(n), b.max(n)));
    let rounds = if least >= most { most.to_string() } else { format!("{least} to {most}") };
    let clock = measured.first().map_or("", |m| m.clock.describe());
    let left_out = measured.iter().map(|m| m.left_out).fold(0.0, f64::max);
    let textured = measured.iter().any(|m| m.truth == Truth::Surfaces);
    let _ = write!(
        page,
        "- **{}** ({}): {}; {}, {rounds} rounds; strategy `{}`. At most {:.1} % of the covered pixels are left out",
        name_of(device),
        first.place.driver,
        places.join(", "),
        clock,
        first.place.strategy,
        100.0 * left_out,
    );
    *page += if textured {
        ".\n  Where surfaces have textures, whose filters are the driver's own, the reference shades what `exact` stored of them.\n"
    } else {
        ".\n"
    };
}

/// A device's name, harmless in tables.
fn name_of(device: &str) -> String {
    device_name(device).replace('|', r"\|")
}

fn wins(page: &mut String, device: &str, standings: &[Standing]) {
    let _ = writeln!(page, "\n## What wins on {}\n", name_of(device));
    *page += "| need | G-buffer | FLIP | PSNR | bytes on the tile | time | because |\n|---|---|---|---|---|---|---|\n";
    let base = standings.iter().find(|s| s.choice == BASE);
    for winner in winners(standings) {
        let Some(best) = winner.best else {
            let _ = writeln!(page, "| {} | none | | | | | |", winner.need);
            continue;
        };
        let because = base.map_or(String::new(), |base| because(best, base));
        let _ = writeln!(
            page,
            "| {} | **{}** | {} | {} | {} | {:.2} | {because} |",
            winner.need,
            best.choice,
            short(best.error(Metric::Flip)),
            decibel(best.error(Metric::Psnr)),
            best.bytes_on_tile,
            best.ratio,
        );
    }
}

/// In what it differs from the base.
fn because(best: &Standing, base: &Standing) -> String {
    if best.choice == base.choice {
        return "nothing else does better".into();
    }
    let factor = base.error(Metric::Flip) / best.error(Metric::Flip);
    let error = match factor {
        f if f >= 1.05 => format!("FLIP is {} times smaller than with `{BASE}`", short(f)),
        f if f <= 1.0 / 1.05 => format!("FLIP is {} times larger than with `{BASE}`", short(1.0 / f)),
        _ => format!("FLIP is that of `{BASE}`"),
    };
    let bytes = match i64::from(best.bytes_on_tile) - i64::from(base.bytes_on_tile) {
        0 => "as many bytes".into(),
        more if more > 0 => format!("{more} bytes more"),
        fewer => format!("{} bytes fewer", -fewer),
    };
    format!("{error}, with {bytes}")
}

fn decibel(db: f64) -> String {
    if db.is_finite() { format!("{db:.1} dB") } else { "equal".into() }
}

const COLUMNS: &str = "bytes on the tile | colour bits | bytes moved if separate | time | PSNR | FLIP | CIEDE2000 p95 | \
                       largest relative error | PSNR against `exact` | FLIP against `exact` |";

fn numbers(page: &mut String, device: &str, standings: &[Standing]) {
    let _ = writeln!(page, "\n## Layouts on {}\n", name_of(device));
    let _ = writeln!(page, "| layout | {COLUMNS}\n|---|---|---|---|---|---|---|---|---|---|---|");
    for s in standings.iter().filter(|s| s.choice.is_plain()) {
        row(page, &format!("`{}`", s.choice), s);
    }
    *page += "\nThe last two columns leave out what arithmetic loses: `exact` stores all in 32-bit floats. It is a ruler, and takes no part above.\n";
}

fn row(page: &mut String, name: &str, s: &Standing) {
    let partly = match s.refused {
        0 => String::new(),
        n => format!(" ({n} of {} refused)", s.drawn + n),
    };
    let [flip, flip_exact] = s.worst[Metric::Flip as usize];
    let [psnr, psnr_exact] = s.worst[Metric::Psnr as usize];
    let time = if s.has_time() { format!("{:.2}", s.ratio) } else { "emulated".into() };
    let _ = writeln!(
        page,
        "| {name}{partly} | {} | {} | {} | {time} | {} | {} | {} | {} | {} | {} |",
        s.bytes_on_tile,
        s.color_bits,
        s.moved_separate,
        decibel(psnr),
        short(flip),
        short(s.error(Metric::Ciede)),
        short(s.error(Metric::Relative)),
        decibel(psnr_exact),
        short(flip_exact),
    );
}

fn others(page: &mut String, device: &str, standings: &[Standing]) {
    let others: Vec<_> = standings.iter().filter(|s| !s.choice.is_plain()).collect();
    if others.is_empty() {
        return;
    }
    let _ = writeln!(page, "\n## One thing chosen otherwise, on {}\n", name_of(device));
    let _ = writeln!(page, "| G-buffer | {COLUMNS}\n|---|---|---|---|---|---|---|---|---|---|---|");
    for s in others {
        row(page, &format!("`{}`", s.choice), s);
    }
}

/// How well `--layout auto` would have chosen.
fn predictions(page: &mut String, report: &Report) {
    let mut lines = String::new();
    for device in report.devices() {
        let [probe, others] =
            [Predictor::Probe, Predictor::OtherScenes].map(|predictor| hits(report, device, predictor));
        for ((metric, probe), (_, others)) in probe.into_iter().zip(others) {
            let shares = |hits: Hits| match hits.decisions {
                0 => "| |".into(),
                n => {
                    let percent = |k: usize| format!("{:.0} %", 100.0 * k as f64 / n as f64);
                    format!("| {} | {} ", percent(hits.kept), percent(hits.cheapest))
                }
            };
            if probe.decisions > 0 {
                let (n, probe, others) = (probe.decisions, shares(probe), shares(others));
                let _ = writeln!(lines, "| {} | {metric} | {n} {probe}{others}|", name_of(device));
            }
        }
    }
    if lines.is_empty() {
        return;
    }
    *page += "\n## How well `--layout auto --max-error` would have chosen\n\n\
              | device | metric | decisions | limit kept | and the cheapest | by other scenes: kept | and the cheapest |\n\
              |---|---|---|---|---|---|---|\n";
    *page += &lines;
    *page += "\nA decision is a scene, a size and a limit, from strict to lax. `auto` predicts by a probe of the scene itself; the last \
              columns show what the worst error of all other scenes would have chosen. To promise nothing keeps the limit, but is \
              not the cheapest where something would have done.\n";
}

fn charts(page: &mut String, report: &Report) {
    *page += "\n## Charts\n";
    for (place, cells) in report.by_place() {
        if !cells.iter().any(|cell| is_charted(cell)) {
            continue;
        }
        let _ = writeln!(page, "\n### {} on {}\n", place.title(), name_of(&place.device));
        for cost in Cost::ALL {
            let what = match cost {
                Cost::Time => "Frame time",
                Cost::Bytes => "Bytes on the tile",
            };
            let name = file_name(place, cost);
            let _ = writeln!(page, "![{what} against error: {}]({name}.svg)\n", place.title());
        }
    }
}

/// How Adreno GPUs would tile the layouts: by rule, and by driver where one was asked.
fn tiles(page: &mut String, report: &Report) {
    // The same for all devices and scenes with the same attachments: one line for each size and list of bins.
    let mut rows: BTreeMap<([u32; 2], u32, Vec<String>), Vec<String>> = BTreeMap::new();
    let mut gpus = Vec::new();
    let (mut asked, mut agreed) = (0, 0);
    for cell in &report.cells {
        let Some(m) = cell.measured() else { continue };
        for tiled in m.bins.iter().filter(|t| t.driver.is_some()) {
            asked += 1;
            agreed += usize::from(tiled.driver.is_some_and(|d| d.bins == tiled.predicted));
        }
        if !cell.choice.is_plain() {
            continue;
        }
        if gpus.is_empty() {
            gpus = m.bins.iter().map(|t| t.gpu).collect();
        }
        let bins = m.bins.iter().map(|t| {
            let driver = t.driver.map_or(String::new(), |d| match d.bins == t.predicted {
                true => " ✓".into(),
                false => format!(", driver: {}", bins(d.bins)),
            });
            format!("{}{driver}", bins(t.predicted))
        });
        let names = rows.entry((cell.place.size, m.bytes.on_tile, bins.collect())).or_default();
        let name = format!("`{}`", cell.choice);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    if rows.is_empty() {
        return;
    }
    *page += "\n## Tiles on Adreno\n\n| size | bytes a pixel | layouts |";
    gpus.iter().for_each(|gpu| *page += &format!(" Adreno {gpu} |"));
    *page += "\n|---|---|---|";
    gpus.iter().for_each(|_| *page += "---|");
    *page += "\n";
    for (([width, height], bytes, bins), names) in rows {
        let _ =
            writeln!(page, "| {width} x {height} | {bytes} | {} | {} |", names.join(", "), bins.join(" | "));
    }
    *page += "\nBins predicted from the attachments by the rule of Mesa's Turnip";
    let _ = match asked {
        0 => writeln!(page, "; the driver was not at hand."),
        _ => writeln!(
            page,
            " (✓: the driver chose the same). Of {asked} frames it was asked about, it agreed on {agreed}."
        ),
    };
}

fn bins(bins: Option<Bins>) -> String {
    bins.map_or("not tiled".into(), |Bins { count, size_px: [w, h] }| format!("{count} of {w}x{h}"))
}

fn refusals(page: &mut String, report: &Report) {
    // One line a reason, with what it prevented.
    let mut told: Vec<(&str, Vec<String>)> = Vec::new();
    for cell in &report.cells {
        let Outcome::Refused(reason) = &cell.outcome else { continue };
        let what = format!("`{}` in {}", cell.choice, cell.place.scene);
        match told.iter_mut().find(|(known, _)| known == reason) {
            Some((_, list)) if list.contains(&what) => {}
            Some((_, list)) => list.push(what),
            None => told.push((reason, vec![what])),
        }
    }
    if !told.is_empty() {
        *page += "\n## Refused\n\n";
        for (reason, list) in told {
            let _ = writeln!(page, "- {reason}. Prevented: {}", list.join(", "));
        }
    }
}

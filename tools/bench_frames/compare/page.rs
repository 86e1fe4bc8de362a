//! One Markdown page that a person reads in two minutes. Every statement follows from the numbers.

use std::fmt::Write;

use super::chart::charts;
use super::data::{Outcome, Report, Row, Run, Table, TableName};
use super::findings::{Verdict, findings, floating_cost_ms, targets};
use super::rules::{Rule, rules};
use super::tables::LIGHT_WAYS;

/// A device's name, harmless in tables.
fn name_of(run: &Run) -> String {
    run.short_name().replace('|', r"\|")
}

/// What a table is about.
pub fn heading(name: TableName) -> &'static str {
    match name {
        TableName::Exterior => "Exterior: a canyon under the sun",
        TableName::Interior => "Interior: nine lights, four with shadows",
        TableName::Draws => "Draw calls",
        TableName::Coverage => "Spots and what they cover",
        TableName::Floating => "A light that touches nothing",
        TableName::Sets => "Illumination sets",
        TableName::Lights => "One to many lights of 2 m on 24 m of floor",
        TableName::Small => "Lights of 1 % of the screen",
        TableName::Overlap => "64 lights that overlap",
        TableName::Overdraw => "Layers behind layers",
    }
}

/// The page. Charts are expected beside it.
pub fn page(report: &Report) -> String {
    let mut page = String::from("# Deferred or forward, and how many lights?\n\n");
    page += "Written by `tools/bench compare`; every sentence below follows from the measurements in `comparison.json`.\n\
             Ways of one row were drawn in turns in one run. Times are medians a frame; ratios are medians of the rounds'\n\
             ratios, [95 % interval of the median]; ways within 2 % of each other count as level.\n\n";
    for run in &report.runs {
        let rounds = run.tables.iter().flat_map(|t| &t.rows).flat_map(|r| &r.cells);
        let rounds = rounds.filter_map(|c| Some(c.measured()?.frame_ms.len()));
        let (least, most) = rounds.fold((usize::MAX, 0), |(a, b), n| (a.min(n), b.max(n)));
        let _ = writeln!(
            page,
            "- **{}** ({}): {}, {} rounds",
            name_of(run),
            run.driver,
            run.clock.describe(),
            if least >= most { most.to_string() } else { format!("{least} to {most}") }
        );
    }
    in_short(&mut page, report);
    where_each_wins(&mut page, report);
    target_table(&mut page, report);
    conclusions(&mut page, report);
    page += "\n## The numbers\n";
    let measured = report.cells().filter(|(_, _, _, cell)| cell.measured().is_some());
    let mut names: Vec<_> = measured.map(|(_, table, _, _)| table.name).collect();
    names.sort();
    names.dedup();
    for name in names {
        let _ = writeln!(page, "\n### {}\n", heading(name));
        let shown = report.runs.iter().filter(|run| charts(run).iter().any(|(known, _)| *known == name));
        let shown: Vec<_> = shown
            .map(|run| format!("![{} on {}]({}.svg)", heading(name), name_of(run), chart_name(name, run)))
            .collect();
        if !shown.is_empty() {
            let _ = writeln!(page, "{}\n", shown.join(" "));
        }
        for run in &report.runs {
            if let Some(table) = run.table(name) {
                numbers(&mut page, run, table);
            }
        }
    }
    refusals(&mut page, report);
    page
}

/// The file stem of a chart.
pub fn chart_name(name: TableName, run: &Run) -> String {
    let device: String = run
        .short_name()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' })
        .collect();
    format!("{}-{device}", name.name())
}

/// How many conclusions hold, and how many targets are met.
fn in_short(page: &mut String, report: &Report) {
    *page += "\n";
    for run in &report.runs {
        let findings = findings(run);
        let known = findings.iter().filter(|f| f.verdict != Verdict::Unknown).count();
        let count = |verdict| findings.iter().filter(|f| f.verdict == verdict).count();
        let (hold, partly, fail) = (count(Verdict::Holds), count(Verdict::Partly), count(Verdict::Fails));
        let targets = targets(run);
        let met = targets.iter().filter(|t| t.met == Some(true)).count();
        let _ = write!(
            page,
            "On {}, of {known} conclusions of 2007 that were measured {hold} hold, {partly} hold in part and {fail} do not",
            name_of(run)
        );
        let _ = match targets.len() {
            0 => writeln!(page, "."),
            all => writeln!(page, "; {met} of {all} targets are met."),
        };
    }
}

fn where_each_wins(page: &mut String, report: &Report) {
    let all: Vec<(&Run, Vec<Rule>)> = report.runs.iter().map(|run| (run, rules(run))).collect();
    *page += "\n## Where each wins\n\n| | question |";
    all.iter().for_each(|(run, _)| *page += &format!(" {} |", name_of(run)));
    *page += "\n|---|---|";
    all.iter().for_each(|_| *page += "---|");
    *page += "\n";
    let mut questions: Vec<(TableName, &str)> = Vec::new();
    for rule in all.iter().flat_map(|(_, rules)| rules) {
        if !questions.contains(&(rule.table, rule.question)) {
            questions.push((rule.table, rule.question));
        }
    }
    questions.sort_by_key(|(table, _)| *table);
    for (table, question) in questions {
        let _ = write!(page, "| {} | {question} |", heading(table));
        for (_, rules) in &all {
            let rule = rules.iter().find(|r| r.table == table && r.question == question);
            let _ = write!(page, " {} |", rule.map_or("not measured".into(), Rule::describe));
        }
        *page += "\n";
    }
}

fn target_table(page: &mut String, report: &Report) {
    let rows: Vec<_> =
        report.runs.iter().flat_map(|run| targets(run).into_iter().map(move |t| (run, t))).collect();
    if rows.is_empty() {
        return;
    }
    *page += "\n## Targets\n\n| device | what | limit | measured | |\n|---|---|---|---|---|\n";
    for (run, t) in rows {
        let met = t.met.map_or("not measured", |met| if met { "**met**" } else { "**not met**" });
        let _ = writeln!(page, "| {} | {} | {} | {} | {met} |", name_of(run), t.what, t.limit, t.measured);
    }
}

fn conclusions(page: &mut String, report: &Report) {
    *page += "\n## What \"Deferred versus forward shading\" concluded, and what is left of it\n\n| conclusion | there |";
    report.runs.iter().for_each(|run| *page += &format!(" {} |", name_of(run)));
    *page += "\n|---|---|";
    report.runs.iter().for_each(|_| *page += "---|");
    *page += "\n";
    let all: Vec<_> = report.runs.iter().map(findings).collect();
    let mut unknown = Vec::new();
    for i in 0..all.first().map_or(0, Vec::len) {
        if all.iter().all(|findings| findings[i].verdict == Verdict::Unknown) {
            unknown.push(all[0][i].claim);
            continue;
        }
        let _ = write!(page, "| {} | {} |", all[0][i].claim, all[0][i].said);
        for findings in &all {
            let f = &findings[i];
            let evidence =
                if f.verdict == Verdict::Unknown { String::new() } else { format!(": {}", f.evidence) };
            let _ = write!(page, " **{}**{evidence} |", f.verdict);
        }
        *page += "\n";
    }
    if !unknown.is_empty() {
        let _ = writeln!(page, "\nNot measured: {}.", unknown.join("; "));
    }
}

fn numbers(page: &mut String, run: &Run, table: &Table) {
    let counts = table.name == TableName::Draws;
    let ways = table.ways();
    let shown: Vec<&str> = match table.name {
        // The frames without the light stand in the difference.
        TableName::Floating => LIGHT_WAYS.into_iter().filter(|way| ways.contains(way)).collect(),
        _ => ways,
    };
    let unit = if counts {
        "draw calls of the first frame / of later ones (state changes)"
    } else {
        "ms [quartiles]"
    };
    let sizes: Vec<_> = table.rows.iter().map(|row| row.size).collect();
    let size = match sizes.first() {
        Some(first) if sizes.iter().all(|s| s == first) => format!(", {} x {}", first[0], first[1]),
        _ => String::new(),
    };
    let _ = write!(page, "| {}{size}: {unit} |", name_of(run));
    shown.iter().for_each(|way| *page += &format!(" {way} |"));
    *page += "\n|---|";
    shown.iter().for_each(|_| *page += "---|");
    *page += "\n";
    for row in &table.rows {
        let _ = write!(page, "| {} |", row.label);
        let best = row.best(&shown).map(|(way, _)| way);
        for way in &shown {
            let text = if counts { count(row, way) } else { time(row, way) };
            let bold = if !counts && best == Some(way) && shown.len() > 1 { "**" } else { "" };
            let _ = write!(page, " {bold}{text}{bold} |");
        }
        *page += "\n";
    }
    if table.name == TableName::Floating {
        for row in &table.rows {
            let cost = |way| floating_cost_ms(row, way).map(|ms| format!("{way} {ms:.2} ms"));
            let costs: Vec<_> = LIGHT_WAYS.into_iter().filter_map(cost).collect();
            let _ = writeln!(
                page,
                "\nWhat the light costs, frame with less frame without it: {}.",
                costs.join(", ")
            );
        }
    }
    for row in table
        .rows
        .iter()
        .filter(|row| row.cells.iter().any(|c| c.measured().is_some_and(|m| !m.stage_ms.is_empty())))
    {
        let of_way = |way: &&str| {
            let stages = &row.measured(way)?.stage_ms;
            let stages: Vec<_> = stages.iter().map(|(name, ms)| format!("{name} {ms:.1}")).collect();
            (!stages.is_empty()).then(|| format!("{way}: {}", stages.join(", ")))
        };
        let told: Vec<_> = shown.iter().filter_map(of_way).collect();
        let _ = writeln!(page, "\nMilliseconds of the stages at {}: {}.", row.label, told.join("; "));
    }
    let recorded = |row: &Row, way: &&str| row.measured(way).map(|m| format!("{way} {:.2}", m.record_ms));
    if let (Some(row), TableName::Lights) = (table.rows.last(), table.name) {
        let told: Vec<_> = shown.iter().filter_map(|way| recorded(row, way)).collect();
        let _ = writeln!(
            page,
            "\nCPU milliseconds to record the frame with {} lights: {}.",
            row.label,
            told.join(", ")
        );
    }
    *page += "\n";
}

fn time(row: &Row, way: &str) -> String {
    let summary = row.measured(way).and_then(|m| m.frame());
    summary.map_or("-".into(), |s| format!("{s:.*}", if s.median < 10.0 { 2 } else { 1 }))
}

fn count(row: &Row, way: &str) -> String {
    row.measured(way).map_or("-".into(), |m| format!("{} / {} ({})", m.first_draws, m.draws, m.state_changes))
}

fn refusals(page: &mut String, report: &Report) {
    // One line a reason, with what it prevented.
    let mut told: Vec<(String, Vec<String>)> = Vec::new();
    for (run, table, _, cell) in report.cells() {
        let Outcome::Refused(reason) = &cell.outcome else { continue };
        let reason = format!("{}: {reason}", name_of(run));
        let what = format!("{} ({})", table.name.name(), cell.way);
        match told.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, list)) if list.contains(&what) => {}
            Some((_, list)) => list.push(what),
            None => told.push((reason, vec![what])),
        }
    }
    if !told.is_empty() {
        *page += "\n## Refused by the build or the device\n\n";
        told.iter()
            .for_each(|(reason, list)| *page += &format!("- {reason}. Prevented: {}\n", list.join(", ")));
    }
}

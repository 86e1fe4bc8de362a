//! Where each way wins, and the crossovers that `auto` can be made of.

use serde::Serialize;

use super::data::{Auto, Row, Run, Table, TableName};
use super::maths::{Series, Winner, winners};
use super::tables::{DEFERRED, FORWARD, LIGHT_WAYS, MULTIPASS};

/// Which way wins from where on.
#[derive(Clone, Debug, Serialize)]
pub struct Rule {
    pub question: &'static str,
    pub table: TableName,
    /// What the places count.
    pub axis: &'static str,
    pub winners: Vec<Winner>,
    /// Where the sweep ended.
    pub until: f64,
    /// How much dearer than the best `auto` is where it is worst, and that place.
    pub auto_at_worst: Option<(f64, f64)>,
}

/// All sweeps of a run.
pub fn rules(run: &Run) -> Vec<Rule> {
    let paths = "deferred or forward?";
    let ways = "which way of deferred lights?";
    [
        (paths, TableName::Exterior, "megapixels"),
        (paths, TableName::Interior, "megapixels"),
        (ways, TableName::Lights, "lights of 2 m"),
        (paths, TableName::Lights, "lights of 2 m"),
        (ways, TableName::Small, "lights of 1 % of the screen"),
        (ways, TableName::Overlap, "lights at each pixel"),
        (paths, TableName::Overlap, "lights at each pixel"),
        (paths, TableName::Overdraw, "layers"),
    ]
    .into_iter()
    .filter_map(|(question, name, axis)| {
        let table = run.table(name)?;
        let xs: Vec<f64> = table.rows.iter().map(|row| row.x).collect();
        let series = if question == ways { of_ways(table, &LIGHT_WAYS) } else { of_paths(table) };
        let winners = winners(&xs, &series);
        let choice = if question == ways {
            |auto: &Auto| auto.lights.clone()
        } else {
            |auto: &Auto| auto.path.clone()
        };
        let auto_at_worst = at_worst(table, &series, choice);
        let until = *xs.last()?;
        (!winners.is_empty()).then_some(Rule { question, table: name, axis, winners, until, auto_at_worst })
    })
    .collect()
}

/// The most that a choice costs over the best, and where.
fn at_worst(table: &Table, series: &[Series<'_>], choice: fn(&Auto) -> String) -> Option<(f64, f64)> {
    let ratio = |(i, row): (usize, &Row)| {
        let costs = || series.iter().filter_map(|(name, costs)| Some((*name, costs[i]?)));
        let best = costs().map(|(_, ms)| ms).min_by(f64::total_cmp)?;
        let chosen = choice(row.auto.as_ref()?);
        let (_, ms) = costs().find(|(name, _)| *name == chosen)?;
        Some((ms / best, row.x))
    };
    table.rows.iter().enumerate().filter_map(ratio).max_by(|a, b| a.0.total_cmp(&b.0))
}

fn of_ways<'a>(table: &Table, ways: &[&'a str]) -> Vec<Series<'a>> {
    ways.iter().map(|&way| (way, table.rows.iter().map(|row| row.ms(way)).collect())).collect()
}

/// Deferred stands for the best of its ways where they were measured one by one.
fn of_paths(table: &Table) -> Vec<Series<'static>> {
    let deferred = table.rows.iter().map(|row| row.ms(DEFERRED).or_else(|| Some(row.best(&LIGHT_WAYS)?.1)));
    let mut series = vec![(DEFERRED, deferred.collect())];
    let forward: Vec<_> =
        table.ways().into_iter().filter(|way| way.starts_with(FORWARD)).map(|way| way.to_owned()).collect();
    for way in [FORWARD, super::tables::PREPASS, MULTIPASS] {
        if forward.iter().any(|known| known == way) {
            series.extend(of_ways(table, &[way]));
        }
    }
    series
}

impl Rule {
    /// As a sentence.
    pub fn describe(&self) -> String {
        let mut text = String::new();
        for (i, winner) in self.winners.iter().enumerate() {
            if i > 0 {
                text += &format!(", from {} {} on ", round(winner.from), self.axis);
            }
            text += &winner.name;
        }
        if self.winners.len() == 1 {
            text += &format!(" throughout (up to {} {})", round(self.until), self.axis);
        }
        if let Some((ratio, place)) = self.auto_at_worst {
            let percent = (ratio - 1.0) * 100.0;
            text += &match percent {
                p if p < 0.5 => "; `auto` is the best everywhere".to_owned(),
                p => format!("; `auto` costs at most {p:.0} % more (at {} {})", round(place), self.axis),
            };
        }
        text
    }
}

/// Two significant digits below 10, none after the point above.
fn round(x: f64) -> String {
    if x < 10.0 { format!("{x:.1}").trim_end_matches(".0").to_owned() } else { format!("{x:.0}") }
}

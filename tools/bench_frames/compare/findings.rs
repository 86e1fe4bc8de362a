//! What "Deferred versus forward shading" concluded in 2007, and whether the measurements agree. Its forward renderer
//! drew the surface without lights first and then once for each light, as `forward-multipass` does.

use std::cmp::Ordering;
use std::fmt;

use serde::Serialize;

use super::data::{Row, Run, TableName};
use super::maths::Ratio;
use super::tables::{
    CLUSTERS, DEFERRED, FORWARD, FULLSCREEN, LIGHT_WAYS, MULTIPASS, STENCIL, VOLUMES, WITHOUT,
};

/// A conclusion and what became of it on one device.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// In the dissertation's sense.
    pub claim: &'static str,
    /// The section and the numbers there.
    pub said: &'static str,
    pub verdict: Verdict,
    /// The numbers here.
    pub evidence: String,
    /// The ratios that it rests on, in the order of the evidence.
    pub ratios: Vec<Ratio>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    Holds,
    Partly,
    Fails,
    Unknown,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Holds => "holds",
            Self::Partly => "in part",
            Self::Fails => "does not hold",
            Self::Unknown => "not measured",
        })
    }
}

impl Verdict {
    /// Of the cases that a claim is about.
    fn of(cases: impl IntoIterator<Item = bool>) -> Self {
        let cases: Vec<_> = cases.into_iter().collect();
        match cases.iter().filter(|&&holds| holds).count() {
            _ if cases.is_empty() => Self::Unknown,
            0 => Self::Fails,
            n if n == cases.len() => Self::Holds,
            _ => Self::Partly,
        }
    }
}

/// All conclusions that can be measured, in the dissertation's order.
pub fn findings(run: &Run) -> Vec<Finding> {
    let rows = |name: TableName| run.table(name).map_or(&[][..], |table| &table.rows);
    let (exterior, interior) = (rows(TableName::Exterior), rows(TableName::Interior));
    let draws = rows(TableName::Draws);
    let mut findings = vec![
        faster(
            "Outdoors under one sun forward is faster at every size",
            "6.4: 1.30, 2.06, 2.25 and 2.78 times as fast as deferred",
            exterior,
            (MULTIPASS, DEFERRED),
        ),
        trend(
            "Outdoors forward's lead grows with the resolution",
            "6.4: from 1.30 to 2.78",
            exterior,
            (DEFERRED, MULTIPASS),
            Ordering::Greater,
        ),
        faster(
            "Indoors with several lights deferred is faster at every size",
            "6.4: 1.32, 1.61, 1.13 and 1.11 times as fast as forward",
            interior,
            (DEFERRED, MULTIPASS),
        ),
        trend(
            "Indoors deferred's lead shrinks as the resolution grows",
            "6.4: from 1.32 to 1.11",
            interior,
            (MULTIPASS, DEFERRED),
            Ordering::Less,
        ),
        more_draws(
            "Outdoors forward needs no more draw calls",
            "6.3: 16, deferred 17",
            draws.first(),
            Ordering::Less,
        ),
        more_draws(
            "Indoors with shadows forward needs more draw calls",
            "6.3: 531, deferred 346",
            draws.get(1),
            Ordering::Greater,
        ),
        wider_gap(
            "Indoors without shadows the gap is wider",
            "6.3: 302, deferred 110; from 1.53 to 2.75 times as many",
            [draws.get(1), draws.get(2)],
        ),
    ];
    let coverage = rows(TableName::Coverage);
    let (little, much): (Vec<_>, Vec<_>) = coverage.iter().enumerate().partition(|(i, _)| i % 2 == 0);
    let only = |rows: Vec<(usize, &Row)>| rows.into_iter().map(|(_, row)| row.clone()).collect::<Vec<_>>();
    findings.extend([
        faster(
            "Spots that cover little of the screen: deferred is faster",
            "5.4: 1.81 (one spot) and 1.45 times (two) as fast as forward",
            &only(little),
            (DEFERRED, MULTIPASS),
        ),
        faster(
            "Spots that cover all of the screen: forward is faster",
            "5.4: 1.44 (one spot) and 1.34 times (two) as fast as deferred",
            &only(much),
            (MULTIPASS, DEFERRED),
        ),
        floating(rows(TableName::Floating).first()),
        faster(
            "Illumination sets make forward faster",
            "5.6: 27 ms without, 19.6 ms with: 1.38 times as fast",
            rows(TableName::Sets),
            (MULTIPASS, super::tables::WITHOUT_SETS),
        ),
        many_lights(
            "Many small lights: deferred is faster than forward as it was then, a pass for each light",
            "7.4",
            rows(TableName::Lights),
            MULTIPASS,
        ),
        many_lights(
            "Many small lights: deferred is faster than forward as it is now, one pass over light lists",
            "7.4",
            rows(TableName::Lights),
            FORWARD,
        ),
    ]);
    findings
}

/// Whether the first way beats the second in every row.
fn faster(
    claim: &'static str,
    said: &'static str,
    rows: &[Row],
    (winner, loser): (&'static str, &'static str),
) -> Finding {
    let ratios: Vec<_> =
        rows.iter().filter_map(|row| Some((row.label.clone(), row.ratio(loser, winner)?))).collect();
    of_ratios(claim, said, &ratios)
}

/// Of how many times as fast the claimed winner is, and where.
fn of_ratios(claim: &'static str, said: &'static str, ratios: &[(String, Ratio)]) -> Finding {
    let told: Vec<_> = ratios.iter().map(|(place, ratio)| format!("{:.2} ({place})", ratio.median)).collect();
    let verdict = Verdict::of(ratios.iter().map(|(_, ratio)| ratio.order() == Ordering::Greater));
    let evidence = format!("{} times as fast", told.join(", "));
    Finding { claim, said, verdict, evidence, ratios: ratios.iter().map(|(_, ratio)| *ratio).collect() }
}

fn unknown(claim: &'static str, said: &'static str) -> Finding {
    Finding { claim, said, verdict: Verdict::Unknown, evidence: String::new(), ratios: Vec::new() }
}

/// Whether `a / b` grows (or shrinks) from the first to the last row, beyond what the intervals leave open.
fn trend(
    claim: &'static str,
    said: &'static str,
    rows: &[Row],
    (a, b): (&str, &str),
    wanted: Ordering,
) -> Finding {
    let ratios: Vec<_> = rows.iter().filter_map(|row| row.ratio(a, b)).collect();
    let (Some(first), Some(last), true) = (ratios.first(), ratios.last(), ratios.len() > 1) else {
        return unknown(claim, said);
    };
    let found = if last.low > first.high {
        Ordering::Greater
    } else if last.high < first.low {
        Ordering::Less
    } else {
        Ordering::Equal
    };
    let evidence = format!("from {:.2} to {:.2}", first.median, last.median);
    Finding { claim, said, verdict: Verdict::of([found == wanted]), evidence, ratios: vec![*first, *last] }
}

/// Draw calls of forward in many passes and of deferred, with shadow maps.
fn draw_counts(row: Option<&Row>) -> Option<[usize; 2]> {
    let draws = |way| Some(row?.measured(way)?.first_draws);
    Some([draws(MULTIPASS)?, draws(DEFERRED)?])
}

/// Whether forward in many passes draws more (or: no more) than deferred. Counts, so there is no doubt in them.
fn more_draws(claim: &'static str, said: &'static str, row: Option<&Row>, wanted: Ordering) -> Finding {
    let Some([forward, deferred]) = draw_counts(row) else { return unknown(claim, said) };
    let holds = if wanted == Ordering::Greater { forward > deferred } else { forward <= deferred };
    let one_pass = row.and_then(|row| row.measured(FORWARD));
    let one_pass = one_pass.map_or(String::new(), |m| format!("; forward in one pass {}", m.first_draws));
    let evidence = format!("{forward}, deferred {deferred}{one_pass}");
    Finding { claim, said, verdict: Verdict::of([holds]), evidence, ratios: Vec::new() }
}

/// Whether the ratio of forward's draw calls to deferred's is larger in the second row.
fn wider_gap(claim: &'static str, said: &'static str, rows: [Option<&Row>; 2]) -> Finding {
    let [Some(with), Some(without)] = rows.map(draw_counts) else { return unknown(claim, said) };
    let [from, to] = [with, without].map(|[forward, deferred]| forward as f64 / deferred as f64);
    let evidence =
        format!("{}, deferred {}; from {from:.2} to {to:.2} times as many", without[0], without[1]);
    Finding { claim, said, verdict: Verdict::of([to > from]), evidence, ratios: Vec::new() }
}

/// Milliseconds that the floating light costs in one way: the median of the rounds' differences.
pub fn floating_cost_ms(row: &Row, way: &str) -> Option<f64> {
    let (with, without) = (row.measured(way)?, row.measured(&format!("{way}, {WITHOUT}"))?);
    let differences: Vec<_> = with.frame_ms.iter().zip(&without.frame_ms).map(|(a, b)| a - b).collect();
    super::maths::median(&differences)
}

fn floating(row: Option<&Row>) -> Finding {
    let claim = "The stencil mask makes a light that touches no surface cheaper than its volume alone";
    let said = "5.5: 0.16 ms with the mask, about 2 ms without";
    let costs: Vec<_> =
        LIGHT_WAYS.iter().filter_map(|&way| Some((way, floating_cost_ms(row?, way)?))).collect();
    let told: Vec<_> = costs.iter().map(|(way, ms)| format!("{way} {ms:.2} ms")).collect();
    let ratio = row.and_then(|row| row.ratio(VOLUMES, STENCIL));
    let verdict = ratio.map_or(Verdict::Unknown, |r| Verdict::of([r.order() == Ordering::Greater]));
    Finding { claim, said, verdict, evidence: told.join(", "), ratios: ratio.into_iter().collect() }
}

/// Whether the best way of deferred lights beats `rival` wherever there are 16 lights or more.
fn many_lights(claim: &'static str, said: &'static str, rows: &[Row], rival: &'static str) -> Finding {
    let ratio = |row: &Row| {
        let (best, _) = row.best(&LIGHT_WAYS)?;
        Some((format!("{} lights, {best}", row.label), row.ratio(rival, best)?))
    };
    let ratios: Vec<_> = rows.iter().filter(|row| row.x >= 16.0).filter_map(ratio).collect();
    of_ratios(claim, said, &ratios)
}

/// Of this machine against what the project promised.
#[derive(Clone, Debug, Serialize)]
pub struct Target {
    pub what: String,
    pub limit: String,
    pub measured: String,
    /// `None` where this device or these settings do not answer it.
    pub met: Option<bool>,
}

/// The stated targets that are about this kind of device.
pub fn targets(run: &Run) -> Vec<Target> {
    let mut targets = Vec::new();
    if run.device.contains("llvmpipe") {
        let row = |x: f64| run.table(TableName::Small)?.row(x).filter(|row| row.size == [1280, 720]);
        let many = row(256.0).and_then(|row| row.best(&LIGHT_WAYS));
        let one = row(1.0).and_then(|row| row.best(&LIGHT_WAYS));
        let all = row(256.0).and_then(|row| row.ms(FULLSCREEN));
        let of_one = many.zip(one).map(|((_, many), (_, one))| many / one);
        let of_all = many.zip(all).map(|((_, many), all)| all / many);
        let name = many.map_or(CLUSTERS, |(way, _)| way);
        targets.push(Target {
            what: "256 lights of 1 % of the screen at 1280 x 720: the best way, against one such light"
                .into(),
            limit: "at most 3 times".into(),
            measured: of_one.map_or("not measured".into(), |r| format!("{r:.2} times ({name})")),
            met: of_one.map(|r| r <= 3.0),
        });
        targets.push(Target {
            what: "the same, against fullscreen".into(),
            limit: "at least 20 times as fast".into(),
            measured: of_all.map_or("not measured".into(), |r| format!("{r:.1} times ({name})")),
            met: of_all.map(|r| r >= 20.0),
        });
    }
    if run.device.contains("NVIDIA") {
        for (lights, limit_ms, bevy) in [(64.0, 2.0, "7.3 and 5.4"), (1024.0, 5.0, "28.6 and 28.1")] {
            let row = run.table(TableName::Lights).and_then(|t| t.row(lights));
            let best = row.filter(|row| row.size == [1920, 1080]).and_then(|row| row.best(&LIGHT_WAYS));
            targets.push(Target {
                what: format!(
                    "{lights} lights of 2 m range at 1920 x 1080 (bevy 0.19: {bevy} ms deferred and forward)"
                ),
                limit: format!("at most {limit_ms} ms of GPU time"),
                measured: best.map_or("not measured".into(), |(way, ms)| format!("{ms:.2} ms ({way})")),
                met: best.map(|(_, ms)| ms <= limit_ms),
            });
        }
    }
    targets
}

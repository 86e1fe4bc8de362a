//! From a report to its charts: for each device, scene and size one of times and one of bytes, a field an error.

use super::BASE;
use super::data::{Cell, Place, Report};
use super::metric::{Cost, Metric, pareto};
use super::scatter::{Field, Point, Scatter};
use crate::plan::{Brdf, Layout};

/// File names without extension, and what they show.
pub(super) fn plots(report: &Report) -> Vec<(String, Scatter)> {
    let places = report.by_place();
    let of_place = |(place, cells): &(&Place, Vec<&Cell>)| {
        Cost::ALL.map(|cost| Some((file_name(place, cost), scatter(place, cells, cost)?)))
    };
    places.iter().flat_map(of_place).flatten().collect()
}

/// The file stem of a chart.
pub(super) fn file_name(place: &Place, cost: Cost) -> String {
    let [width, height] = place.size;
    let name = format!("{}-{}-{width}x{height}-{}", cost.name(), place.scene, place.device_name());
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect()
}

/// What is charted: all but `exact`, which is a ruler.
pub(super) fn is_charted(cell: &Cell) -> bool {
    cell.choice.layout != Layout::Exact && cell.measured().is_some()
}

fn scatter(place: &Place, cells: &[&Cell], cost: Cost) -> Option<Scatter> {
    let shown: Vec<&Cell> = cells.iter().copied().filter(|cell| is_charted(cell)).collect();
    // What is emulated takes longer than what it stands for.
    let is_timed = |cell: &&Cell| cell.choice.brdf != Brdf::Mediump;
    let shown: Vec<_> = shown.into_iter().filter(|cell| cost == Cost::Bytes || is_timed(cell)).collect();
    if shown.is_empty() {
        return None;
    }
    // What the base took in its own cell; without that, in each cell's rounds.
    let base = cells.iter().find(|cell| cell.choice == BASE).and_then(|cell| cell.measured());
    let base_ms = base.or(shown[0].measured()).map_or(1.0, |m| m.frame_ms.median / m.ratio.median);
    let fields = Metric::ALL.iter().map(|&metric| field(&shown, cost, base_ms, metric)).collect();
    let what = match cost {
        Cost::Time => "frame time against error",
        Cost::Bytes => "bytes on the tile against error",
    };
    Some(Scatter {
        title: format!("{}, {}: {what}", place.title(), place.device_name()),
        note: "Filled: layouts as they are. Open: one thing chosen otherwise. Ringed, joined by the line: nothing beats \
               them. Bars: quartiles of the times. Names that find no room are in the table."
            .into(),
        fields,
    })
}

fn field(cells: &[&Cell], cost: Cost, base_ms: f64, metric: Metric) -> Field {
    let measured = |cell: &&Cell| cell.measured().cloned().expect("only what was drawn is shown");
    let known = cells.iter().map(measured).map(|m| metric.of(&m.against_reference));
    // What equals the reference to the last bit is as good as the best that can be told from it, and a little better.
    let best = known.filter(|y| y.is_finite()).fold(f64::MIN, f64::max);
    let point = |cell: &&Cell| {
        let m = measured(cell);
        let y = metric.of(&m.against_reference);
        let (x, spread) = cost.of(&m, base_ms);
        Point {
            name: cell.choice.to_string(),
            x,
            spread,
            y: if y.is_finite() { y } else { best + 3.0 },
            is_plain: cell.choice.is_plain(),
            color: Layout::ALL.iter().position(|l| *l == cell.choice.layout).unwrap_or_default(),
        }
    };
    let badness = |cell: &&Cell| {
        let m = measured(cell);
        [cost.of(&m, base_ms).0, metric.badness(&m.against_reference)]
    };
    let x_label = match cost {
        Cost::Time => "milliseconds a frame, by the median ratio to metallic128",
        Cost::Bytes => "bytes a pixel of all attachments (planned)",
    };
    Field {
        x_label: x_label.into(),
        y_label: metric.label().into(),
        logarithmic: metric != Metric::Psnr,
        points: cells.iter().map(point).collect(),
        front: pareto(&cells.iter().map(badness).collect::<Vec<_>>()),
    }
}

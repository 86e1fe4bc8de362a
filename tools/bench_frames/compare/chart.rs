//! Charts of the tables.

use std::ops::Range;

use ontile::measure::canvas::{COLORS, Canvas, Drawing, Drawn, key, short};
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

use super::data::{Run, Table, TableName};

const SIZE: (u32, u32) = (880, 520);

/// A table as lines over a logarithmic axis, or as bars in groups.
pub struct Chart {
    pub title: String,
    pub x_label: &'static str,
    pub y_label: String,
    /// Names, and (place, median, first and third quartile).
    pub series: Vec<(String, Vec<[f64; 4]>)>,
    /// One a place: bars instead of lines.
    pub groups: Option<Vec<String>>,
}

/// A run's tables that make a chart.
pub fn charts(run: &Run) -> Vec<(TableName, Chart)> {
    let axis = |name: TableName| match name {
        TableName::Exterior | TableName::Interior | TableName::Coverage => Some((true, "")),
        TableName::Lights => Some((false, "lights of 2 m range")),
        TableName::Small => Some((false, "lights, each 1 % of the screen")),
        TableName::Overlap => Some((false, "lights in range of each pixel, on average")),
        TableName::Overdraw => Some((false, "layers, the farthest drawn first")),
        TableName::Draws | TableName::Floating | TableName::Sets => None,
    };
    let chart = |table: &Table| {
        let (bars, x_label) = axis(table.name)?;
        let series: Vec<_> =
            table.ways().into_iter().map(|way| (way.to_owned(), points(table, way))).collect();
        let series: Vec<_> = series.into_iter().filter(|(_, points)| !points.is_empty()).collect();
        (!series.is_empty()).then(|| {
            let chart = Chart {
                title: format!("{} on {}", super::page::heading(table.name), run.short_name()),
                x_label,
                y_label: format!("milliseconds a frame ({})", run.clock.describe()),
                series,
                groups: bars.then(|| table.rows.iter().map(|row| row.label.clone()).collect()),
            };
            (table.name, chart)
        })
    };
    run.tables.iter().filter_map(chart).collect()
}

fn points(table: &Table, way: &str) -> Vec<[f64; 4]> {
    let bars = matches!(table.name, TableName::Exterior | TableName::Interior | TableName::Coverage);
    let rows = table.rows.iter().enumerate();
    rows.filter_map(|(i, row)| {
        let frame = row.measured(way)?.frame()?;
        let x = if bars { i as f64 } else { row.x };
        Some([x, frame.median, frame.first_quartile, frame.third_quartile])
    })
    .collect()
}

impl Drawing for Chart {
    fn title(&self) -> &str {
        &self.title
    }

    fn size(&self) -> (u32, u32) {
        SIZE
    }

    fn draw<B: DrawingBackend<ErrorType: 'static>>(&self, canvas: &Canvas<B>) -> Drawn {
        match &self.groups {
            Some(groups) => self.draw_bars(canvas, groups),
            None => self.draw_lines(canvas),
        }
    }
}

impl Chart {
    fn draw_lines<B: DrawingBackend<ErrorType: 'static>>(&self, canvas: &Canvas<B>) -> Drawn {
        let [xs, ys] =
            [0, 1].map(|axis| self.series.iter().flat_map(move |(_, p)| p.iter().map(move |p| p[axis])));
        let (xs, ys) = (padded(xs, 1.15), padded(ys, 1.4));
        let mut chart = self.frame(canvas, xs.log_scale().base(4.0), ys.log_scale().base(2.0))?;
        chart
            .configure_mesh()
            .x_desc(self.x_label)
            .y_desc(&self.y_label)
            .x_label_formatter(&|x| short(*x))
            .y_label_formatter(&|y| short(*y))
            .light_line_style(WHITE.mix(0.0))
            .bold_line_style(BLACK.mix(0.12))
            .label_style(canvas.font(14))
            .draw()?;
        for (i, (name, points)) in self.series.iter().enumerate() {
            let color = COLORS[i % COLORS.len()];
            let line =
                LineSeries::new(points.iter().map(|p| (p[0], p[1])), color.stroke_width(2 * canvas.scale));
            chart.draw_series(line)?.label(name).legend(move |(x, y)| key(x, y, canvas.scale, color));
            let spread = |p: &[f64; 4]| {
                PathElement::new([(p[0], p[2]), (p[0], p[3])], color.stroke_width(canvas.scale))
            };
            chart.draw_series(points.iter().map(spread))?;
            chart.draw_series(
                points.iter().map(|p| Circle::new((p[0], p[1]), 4 * canvas.scale, color.filled())),
            )?;
        }
        legend(canvas, &mut chart)
    }

    fn draw_bars<B: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &Canvas<B>,
        groups: &[String],
    ) -> Drawn {
        let highest = self.series.iter().flat_map(|(_, p)| p).map(|p| p[3].max(p[1])).fold(0.0, f64::max);
        let mut chart = self.frame(canvas, -0.5..groups.len() as f64 - 0.5, 0.0..highest * 1.3)?;
        chart
            .configure_mesh()
            .y_desc(&self.y_label)
            .x_labels(groups.len() * 2 + 1)
            .x_label_formatter(&|x| {
                let name = groups.get(x.round().max(0.0) as usize);
                name.filter(|_| (x - x.round()).abs() < 1e-6).cloned().unwrap_or_default()
            })
            .y_label_formatter(&|y| short(*y))
            .disable_x_mesh()
            .light_line_style(WHITE.mix(0.0))
            .bold_line_style(BLACK.mix(0.12))
            .label_style(canvas.font(14))
            .draw()?;
        let width = 0.8 / self.series.len() as f64;
        for (i, (name, points)) in self.series.iter().enumerate() {
            let color = COLORS[i % COLORS.len()];
            let left = |p: &[f64; 4]| p[0] - 0.4 + width * i as f64;
            let bar = |p: &[f64; 4]| {
                Rectangle::new([(left(p), 0.0), (left(p) + width * 0.92, p[1])], color.filled())
            };
            chart
                .draw_series(points.iter().map(bar))?
                .label(name)
                .legend(move |(x, y)| key(x, y, canvas.scale, color));
            let spread = |p: &[f64; 4]| {
                let x = left(p) + width * 0.46;
                PathElement::new([(x, p[2]), (x, p[3])], BLACK.stroke_width(canvas.scale))
            };
            chart.draw_series(points.iter().map(spread))?;
            let scale = canvas.scale as i32;
            let told = |p: &[f64; 4]| {
                let style = canvas.font(13).into_font().color(&BLACK);
                let text = short(p[1]);
                // Half of the text is about four pixels a character to the left of the bar's middle.
                EmptyElement::at((left(p) + width * 0.46, p[1].max(p[3])))
                    + Text::new(text.clone(), (-4 * scale * text.len() as i32, -16 * scale), style)
            };
            chart.draw_series(points.iter().map(told))?;
        }
        legend(canvas, &mut chart)
    }

    fn frame<'a, B: DrawingBackend, X, Y>(&self, canvas: &'a Canvas<B>, xs: X, ys: Y) -> Framed<'a, B, X, Y>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        ChartBuilder::on(&canvas.area)
            .caption(&self.title, canvas.font(19))
            .margin(14 * canvas.scale)
            .x_label_area_size(48 * canvas.scale)
            .y_label_area_size(70 * canvas.scale)
            .build_cartesian_2d(xs, ys)
    }
}

type Framed<'a, B, X, Y> = std::result::Result<
    ChartContext<
        'a,
        B,
        Cartesian2d<<X as AsRangedCoord>::CoordDescType, <Y as AsRangedCoord>::CoordDescType>,
    >,
    DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>,
>;

fn legend<'a, B: DrawingBackend + 'a, X, Y>(
    canvas: &Canvas<B>,
    chart: &mut ChartContext<'a, B, Cartesian2d<X, Y>>,
) -> Drawn
where
    B::ErrorType: 'static,
    X: plotters::coord::ranged1d::Ranged<ValueType = f64>,
    Y: plotters::coord::ranged1d::Ranged<ValueType = f64>,
{
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .margin(6 * canvas.scale)
        .legend_area_size(24 * canvas.scale)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.25))
        .label_font(canvas.font(14))
        .draw()?;
    Ok(())
}

/// From the smallest to the largest, and a little more at both ends of a logarithmic axis.
fn padded(values: impl Iterator<Item = f64>, factor: f64) -> Range<f64> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    low / factor..high * factor
}

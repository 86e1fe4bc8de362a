//! Line charts.

use std::ops::Range;

use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;

use super::canvas::{COLORS, Canvas, Drawing, Drawn, key, short};

const SIZE: (u32, u32) = (880, 520);

/// One direction of a [`Plot`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Equal distances are equal differences.
    Linear,
    /// Equal distances are equal factors; what is not above 0 is left out.
    Logarithmic,
}

/// Curves over one quantity.
#[derive(Clone, Debug)]
pub struct Plot {
    /// What is shown.
    pub title: String,
    /// Quantity and unit along x.
    pub x_label: String,
    /// Quantity and unit along y.
    pub y_label: String,
    /// Along x and y.
    pub axes: [Axis; 2],
    /// Names and points, in order of x.
    pub curves: Vec<(String, Vec<[f64; 2]>)>,
    /// Heights that are marked across the whole chart, e.g. bounds.
    pub levels: Vec<(String, f64)>,
}

impl Plot {
    /// Whether a point has a place on both axes.
    fn shows(&self, point: &[f64; 2]) -> bool {
        let fits = |axis: Axis, v: f64| v.is_finite() && (axis == Axis::Linear || v > 0.0);
        fits(self.axes[0], point[0]) && fits(self.axes[1], point[1])
    }

    fn range(&self, axis: usize) -> Result<Range<f64>, &'static str> {
        let shown = self.curves.iter().flat_map(|(_, points)| points).filter(|p| self.shows(p));
        let values = shown.map(|p| p[axis]);
        let levels =
            self.levels.iter().map(|(_, level)| *level).filter(|level| {
                axis == 1 && level.is_finite() && (self.axes[1] == Axis::Linear || *level > 0.0)
            });
        let (low, high) =
            values.chain(levels).fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            return Err("it has no point");
        }
        Ok(match self.axes[axis] {
            // Room for the legend above.
            Axis::Logarithmic if axis == 1 => low / 1.5..high * (high / low).powf(0.25).max(2.0),
            Axis::Logarithmic => low..(high).max(low * 1.01),
            Axis::Linear => {
                let room = (high - low).max(1e-12 * high.abs()).max(f64::MIN_POSITIVE);
                low - if axis == 1 { 0.03 * room } else { 0.0 }
                    ..high + if axis == 1 { 0.35 * room } else { 0.0 }
            }
        })
    }

    fn draw_over<B, X, Y>(&self, canvas: &Canvas<B>, xs: X, ys: Y) -> Drawn
    where
        B: DrawingBackend<ErrorType: 'static>,
        X: plotters::coord::ranged1d::AsRangedCoord<Value = f64>,
        Y: plotters::coord::ranged1d::AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
        Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    {
        let scale = canvas.scale;
        let mut chart = ChartBuilder::on(&canvas.area)
            .caption(&self.title, canvas.font(18))
            .margin(14 * scale)
            .x_label_area_size(48 * scale)
            .y_label_area_size(76 * scale)
            .build_cartesian_2d(xs, ys)?;
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_label_formatter(&|x| short(*x))
            .y_label_formatter(&|y| short(*y))
            .light_line_style(WHITE.mix(0.0))
            .bold_line_style(BLACK.mix(0.12))
            .label_style(canvas.font(14))
            .draw()?;
        let (left, right) = {
            let shown = self.curves.iter().flat_map(|(_, points)| points).filter(|p| self.shows(p));
            shown.map(|p| p[0]).fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)))
        };
        for (i, (name, points)) in self.curves.iter().enumerate() {
            let color = COLORS[i % COLORS.len()];
            // After the colours are used up, thinner lines begin anew.
            let width = if i < COLORS.len() { 2 * scale } else { scale };
            let shown: Vec<_> = points.iter().filter(|p| self.shows(p)).map(|p| (p[0], p[1])).collect();
            let markers = if shown.len() <= 40 { 3 * scale } else { 0 };
            let dots = shown.clone().into_iter().map(|p| Circle::new(p, markers, color.filled()));
            chart
                .draw_series(LineSeries::new(shown, color.stroke_width(width)))?
                .label(name)
                .legend(move |(x, y)| key(x, y, scale, color));
            if markers > 0 {
                chart.draw_series(dots)?;
            }
        }
        for (name, level) in &self.levels {
            let color = RGBColor(120, 120, 120);
            let line = DashedLineSeries::new(
                [(left, *level), (right, *level)],
                6 * scale,
                4 * scale,
                color.stroke_width(scale),
            );
            chart.draw_series(line)?.label(name).legend(move |(x, y)| key(x, y, scale, color));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .margin(6 * scale)
            .legend_area_size(24 * scale)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.25))
            .label_font(canvas.font(13))
            .draw()?;
        Ok(())
    }
}

impl Drawing for Plot {
    fn title(&self) -> &str {
        &self.title
    }

    fn size(&self) -> (u32, u32) {
        SIZE
    }

    fn draw<B: DrawingBackend<ErrorType: 'static>>(&self, canvas: &Canvas<B>) -> Drawn {
        let (xs, ys) = (self.range(0)?, self.range(1)?);
        match self.axes {
            [Axis::Linear, Axis::Linear] => self.draw_over(canvas, xs, ys),
            [Axis::Logarithmic, Axis::Linear] => self.draw_over(canvas, xs.log_scale(), ys),
            [Axis::Linear, Axis::Logarithmic] => self.draw_over(canvas, xs, ys.log_scale()),
            [Axis::Logarithmic, Axis::Logarithmic] => self.draw_over(canvas, xs.log_scale(), ys.log_scale()),
        }
    }
}

//! Line charts, as SVG and as PNG. The font is embedded, so that they look the same on every machine.

use std::ops::Range;

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

use crate::{Error, Result};

const SIZE: (u32, u32) = (880, 520);
/// Pixels of the PNG for one of the SVG, so that its letters are crisp.
const PNG_SCALE: u32 = 2;
const FONT: &str = "sans-serif";
/// Okabe and Ito's colours, which people with any colour vision can tell apart, the yellow left out.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

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
    /// The chart as an SVG document.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if nothing can be drawn: no point is finite, or on a logarithmic axis positive.
    pub fn svg(&self) -> Result<String> {
        let mut svg = String::new();
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        self.draw(&Canvas { area, scale: 1 })?;
        Ok(svg)
    }

    /// The chart as a PNG file's bytes.
    ///
    /// # Errors
    /// As [`Self::svg`].
    pub fn png(&self) -> Result<Vec<u8>> {
        let (width, height) = (SIZE.0 * PNG_SCALE, SIZE.1 * PNG_SCALE);
        let mut texels = vec![0; (width * height * 3) as usize];
        let area = BitMapBackend::with_buffer(&mut texels, (width, height)).into_drawing_area();
        self.draw(&Canvas { area, scale: PNG_SCALE })?;
        let mut png = Vec::new();
        let written = PngEncoder::new(&mut png).write_image(&texels, width, height, ExtendedColorType::Rgb8);
        written.map_err(|e| self.undrawable(&e.to_string()))?;
        Ok(png)
    }

    fn undrawable(&self, why: &str) -> Error {
        Error::unsupported(
            format!("the chart '{}' cannot be drawn: {why}", self.title),
            "measure more places",
        )
    }

    /// Whether a point has a place on both axes.
    fn shows(&self, point: &[f64; 2]) -> bool {
        let fits = |axis: Axis, v: f64| v.is_finite() && (axis == Axis::Linear || v > 0.0);
        fits(self.axes[0], point[0]) && fits(self.axes[1], point[1])
    }

    fn range(&self, axis: usize) -> Result<Range<f64>> {
        let shown = self.curves.iter().flat_map(|(_, points)| points).filter(|p| self.shows(p));
        let values = shown.map(|p| p[axis]);
        let levels =
            self.levels.iter().map(|(_, level)| *level).filter(|level| {
                axis == 1 && level.is_finite() && (self.axes[1] == Axis::Linear || *level > 0.0)
            });
        let (low, high) =
            values.chain(levels).fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            return Err(self.undrawable("it has no point"));
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

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<B>) -> Result<()> {
        // Fails only for bytes that are no font, and these are compiled in.
        let _ = register_font(FONT, FontStyle::Normal, dejavu::sans::regular());
        let (xs, ys) = (self.range(0)?, self.range(1)?);
        let drawn = match self.axes {
            [Axis::Linear, Axis::Linear] => self.draw_on(canvas, xs, ys),
            [Axis::Logarithmic, Axis::Linear] => self.draw_on(canvas, xs.log_scale(), ys),
            [Axis::Linear, Axis::Logarithmic] => self.draw_on(canvas, xs, ys.log_scale()),
            [Axis::Logarithmic, Axis::Logarithmic] => self.draw_on(canvas, xs.log_scale(), ys.log_scale()),
        };
        drawn.map_err(|e| self.undrawable(&e.to_string()))
    }

    fn draw_on<B, X, Y>(&self, canvas: &Canvas<B>, xs: X, ys: Y) -> Drawn<B>
    where
        B: DrawingBackend,
        X: plotters::coord::ranged1d::AsRangedCoord<Value = f64>,
        Y: plotters::coord::ranged1d::AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
        Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    {
        canvas.area.fill(&WHITE)?;
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
                .legend(move |(x, y)| key(x, y, scale as i32, color));
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
            chart.draw_series(line)?.label(name).legend(move |(x, y)| key(x, y, scale as i32, color));
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
        canvas.area.present()
    }
}

/// Where a chart is drawn, and how many pixels make one of its own.
struct Canvas<B: DrawingBackend> {
    area: DrawingArea<B, plotters::coord::Shift>,
    scale: u32,
}

impl<B: DrawingBackend> Canvas<B> {
    fn font(&self, size: u32) -> (&'static str, u32) {
        (FONT, size * self.scale)
    }
}

type Drawn<B> = std::result::Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

fn key(x: i32, y: i32, scale: i32, color: RGBColor) -> Rectangle<(i32, i32)> {
    Rectangle::new([(x, y - 5 * scale), (x + 16 * scale, y + 5 * scale)], color.filled())
}

/// Three significant digits, without trailing zeros.
pub(crate) fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let magnitude = x.abs().log10().floor() as i32;
    if !(-4..6).contains(&magnitude) {
        let mantissa = x / 10_f64.powi(magnitude);
        let text = format!("{mantissa:.2}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        return format!("{text}e{magnitude}");
    }
    let digits = (2 - magnitude).max(0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (0.5, "0.5"),
            (1234.5, "1234"),
            (1e-7, "1e-7"),
            (2.5e9, "2.5e9"),
            (0.012_34, "0.0123"),
        ];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
    }

    #[test]
    fn a_plot_draws_what_can_be_drawn() {
        let plot = |axes, curve: Vec<[f64; 2]>| Plot {
            title: "t".into(),
            x_label: "x".into(),
            y_label: "y".into(),
            axes,
            curves: vec![("curve".into(), curve)],
            levels: vec![("bound".into(), 2.0)],
        };
        let points = vec![[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0], [10.0, 0.0]];
        for axes in [[Axis::Linear; 2], [Axis::Logarithmic; 2], [Axis::Linear, Axis::Logarithmic]] {
            let svg = plot(axes, points.clone()).svg().unwrap();
            assert!(svg.starts_with("<svg") && svg.contains("curve") && svg.contains("bound"));
        }
        assert!(plot([Axis::Linear; 2], points).png().unwrap().starts_with(b"\x89PNG"));
        let nothing = Plot { levels: Vec::new(), ..plot([Axis::Logarithmic; 2], vec![[0.0, 0.0]]) };
        assert!(nothing.svg().unwrap_err().to_string().contains("no point"));
    }
}

//! Points with names in several fields; names that find no place of their own are left out, so that none overlap.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

use crate::measure::canvas::{COLORS, Canvas, Drawing, Drawn, mark};

/// Width and height of a field.
const FIELD: (u32, u32) = (720, 520);
const TITLE_HEIGHT: u32 = 40;
const NOTE_HEIGHT: u32 = 30;
const LABEL: u32 = 13;

/// Several fields, two in a row, that share their points' names.
pub struct Scatter {
    pub title: String,
    /// How to read it.
    pub note: String,
    pub fields: Vec<Field>,
}

/// Points over one cost and one error.
pub struct Field {
    pub x_label: String,
    pub y_label: String,
    pub logarithmic: bool,
    pub points: Vec<Point>,
    /// Indices of the points that nothing beats, in order of x.
    pub front: Vec<usize>,
}

/// A G-buffer's place.
#[derive(Clone)]
pub struct Point {
    pub name: String,
    pub x: f64,
    /// First and third quartile of x.
    pub spread: Option<[f64; 2]>,
    pub y: f64,
    /// Drawn larger, and named even off the front.
    pub is_plain: bool,
    /// Which of the colours.
    pub color: usize,
}

impl Drawing for Scatter {
    fn title(&self) -> &str {
        &self.title
    }

    fn size(&self) -> (u32, u32) {
        let rows = self.fields.len().div_ceil(2) as u32;
        (2 * FIELD.0, TITLE_HEIGHT + rows * FIELD.1 + NOTE_HEIGHT)
    }

    fn draw<B: DrawingBackend<ErrorType: 'static>>(&self, canvas: &Canvas<B>) -> Drawn {
        let scale = canvas.scale;
        let (title, rest) = canvas.area.split_vertically(TITLE_HEIGHT * scale);
        let place = (18 * scale as i32, 12 * scale as i32);
        title.draw(&Text::new(self.title.as_str(), place, canvas.font(20).into_font()))?;
        let (fields, note) = rest.split_vertically((self.size().1 - TITLE_HEIGHT - NOTE_HEIGHT) * scale);
        let place = (18 * scale as i32, 4 * scale as i32);
        note.draw(&Text::new(self.note.as_str(), place, canvas.font(LABEL).into_font()))?;
        let areas = fields.split_evenly((self.fields.len().div_ceil(2), 2));
        for (field, area) in self.fields.iter().zip(areas) {
            field.draw(canvas, &area)?;
        }
        Ok(())
    }
}

/// From the least to the most shown: a logarithmic scale of less has hardly a mark, or marks that read alike.
const LEAST_FACTOR: f64 = 8.0;

impl Field {
    fn draw<B: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &Canvas<B>,
        area: &DrawingArea<B, Shift>,
    ) -> Drawn {
        let xs = self.points.iter().flat_map(|p| p.spread.unwrap_or([p.x; 2]).into_iter().chain([p.x]));
        let (low, high) = bounds(xs).ok_or("it has no point")?;
        let room = (high - low).max(0.02 * high.abs());
        let (xs, length) = (low - 0.06 * room..high + 0.16 * room, room);
        // What is equal has no logarithm: it lies at the lower border.
        let (low, high) =
            bounds(self.points.iter().map(|p| p.y).filter(|y| *y > 0.0)).unwrap_or((1e-6, 1e-6));
        let has_zero = self.points.iter().any(|p| p.y <= 0.0);
        let floor = if has_zero { low / 3.0 } else { low };
        if self.logarithmic && (high / floor >= LEAST_FACTOR || has_zero) {
            let room = (high / floor).powf(0.08).max(1.1);
            let ys = (floor / room..high * room).log_scale().base(2.0);
            self.draw_over(canvas, area, xs, ys, [length, 0.0], floor)
        } else {
            let (low, high) = bounds(self.points.iter().map(|p| p.y)).ok_or("it has no point")?;
            // A few decibels at least.
            let room = (high - low).max(if self.logarithmic { 0.02 * high.abs() } else { 3.0 });
            let ys = low - 0.08 * room..high + 0.08 * room;
            self.draw_over(canvas, area, xs, ys, [length, room], f64::MIN)
        }
    }

    fn draw_over<B, Y>(
        &self,
        canvas: &Canvas<B>,
        area: &DrawingArea<B, Shift>,
        xs: Range<f64>,
        ys: Y,
        lengths: [f64; 2],
        floor: f64,
    ) -> Drawn
    where
        B: DrawingBackend<ErrorType: 'static>,
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    {
        let scale = canvas.scale;
        let mut chart = ChartBuilder::on(area)
            .margin(12 * scale)
            .x_label_area_size(44 * scale)
            .y_label_area_size(70 * scale)
            .build_cartesian_2d(xs, ys)?;
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_label_formatter(&|x| mark(*x, lengths[0]))
            .y_label_formatter(&|y| mark(*y, lengths[1]))
            .light_line_style(WHITE.mix(0.0))
            .bold_line_style(BLACK.mix(0.12))
            .label_style(canvas.font(LABEL))
            .draw()?;
        let at = |p: &Point| (p.x, p.y.max(floor));
        // What lies beyond a step of this line is beaten by the step's corner.
        let front: Vec<_> = self.front.iter().map(|&i| at(&self.points[i])).collect();
        let steps = front.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1), pair[1]]);
        let steps: Vec<_> = front.first().copied().into_iter().chain(steps).collect();
        chart.draw_series(LineSeries::new(steps.iter().copied(), BLACK.mix(0.35).stroke_width(2 * scale)))?;
        // Smaller points last, so that larger ones do not hide them.
        let mut order: Vec<_> = (0..self.points.len()).collect();
        order.sort_by_key(|&i| !self.points[i].is_plain);
        for &i in &order {
            let point = &self.points[i];
            let color = COLORS[point.color % COLORS.len()];
            if let Some([first, third]) = point.spread {
                let y = at(point).1;
                let spread = PathElement::new([(first, y), (third, y)], color.mix(0.5).stroke_width(scale));
                chart.draw_series([spread])?;
            }
            let style = if point.is_plain { color.filled() } else { color.stroke_width(2 * scale) };
            chart.draw_series([Circle::new(at(point), point.radius() * scale, style)])?;
            if self.front.contains(&i) {
                let ring = BLACK.stroke_width(scale);
                chart.draw_series([Circle::new(at(point), (point.radius() + 4) * scale, ring)])?;
            }
        }
        // Names keep off lines too.
        let line = |from: (f64, f64), to: (f64, f64)| {
            let [from, to] = [from, to].map(|place| chart.backend_coord(&place));
            Box2::spanning(from, to, 2 * scale as i32)
        };
        let lines = steps.windows(2).map(|pair| line(pair[0], pair[1]));
        let spreads = self.points.iter().filter_map(|p| {
            let [first, third] = p.spread?;
            Some(line((first, at(p).1), (third, at(p).1)))
        });
        let lines: Vec<_> = lines.chain(spreads).collect();
        let markers: Vec<_> = self
            .points
            .iter()
            .map(|p| Box2::around(chart.backend_coord(&at(p)), (p.radius() + 4) as i32 * scale as i32))
            .collect();
        let (x_range, y_range) = chart.plotting_area().get_pixel_range();
        let field = Box2 { left: x_range.start, right: x_range.end, top: y_range.start, bottom: y_range.end };
        self.draw_names(canvas, &markers, &lines, field)
    }

    /// Names the points on the front, then the other layouts, each at the nearest place that is free.
    fn draw_names<B: DrawingBackend<ErrorType: 'static>>(
        &self,
        canvas: &Canvas<B>,
        markers: &[Box2],
        lines: &[Box2],
        field: Box2,
    ) -> Drawn {
        let others = (0..self.points.len()).filter(|i| self.points[*i].is_plain && !self.front.contains(i));
        let mut taken: Vec<Box2> = markers.iter().chain(lines).copied().collect();
        for i in self.front.iter().copied().chain(others) {
            let point = &self.points[i];
            let (width, height) = canvas.text_size(&point.name, LABEL);
            let size = (width as i32 + 4, height as i32 + 2);
            let center = markers[i].center();
            let free =
                |place: &Box2| place.is_inside(&field) && !taken.iter().any(|other| other.touches(place));
            let Some(place) = places(center, size, canvas.scale as i32).find(free) else { continue };
            let color = COLORS[point.color % COLORS.len()];
            let near = place.nearest(center);
            let apart = (near.0 - center.0).abs().max((near.1 - center.1).abs());
            if apart > 14 * canvas.scale as i32 {
                let leader = PathElement::new([center, near], color.mix(0.6).stroke_width(canvas.scale));
                canvas.area.draw(&leader)?;
            }
            let style = canvas.font(LABEL).into_font().color(&color);
            canvas.area.draw(&Text::new(point.name.as_str(), (place.left + 2, place.top + 1), style))?;
            taken.push(place);
        }
        Ok(())
    }
}

impl Point {
    fn radius(&self) -> u32 {
        if self.is_plain { 5 } else { 3 }
    }
}

/// Smallest and largest.
fn bounds(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    (low <= high).then_some((low, high))
}

/// Where a name of this size may stand around a point, the nearest first.
fn places(center: (i32, i32), (width, height): (i32, i32), scale: i32) -> impl Iterator<Item = Box2> {
    /// Right, left, above, below, and between.
    const DIRECTIONS: [(i32, i32); 12] = [
        (2, 0),
        (-2, 0),
        (0, -2),
        (0, 2),
        (2, -2),
        (2, 2),
        (-2, -2),
        (-2, 2),
        (2, -1),
        (2, 1),
        (-2, -1),
        (-2, 1),
    ];
    const DISTANCES: [i32; 9] = [12, 18, 26, 38, 52, 70, 92, 120, 150];
    DISTANCES.into_iter().flat_map(move |distance| {
        DIRECTIONS.into_iter().map(move |(dx, dy)| {
            let (x, y) = (center.0 + dx * distance * scale / 2, center.1 + dy * distance * scale / 2);
            let left = match dx.signum() {
                1 => x,
                -1 => x - width,
                _ => x - width / 2,
            };
            let top = match (dy.signum(), dx) {
                (1, 0) => y,
                (-1, 0) => y - height,
                _ => y - height / 2,
            };
            Box2 { left, top, right: left + width, bottom: top + height }
        })
    })
}

/// A rectangle of the canvas.
#[derive(Clone, Copy, Debug)]
struct Box2 {
    left: i32,
    top: i32,
    right: i32,
    bottom: i32,
}

impl Box2 {
    fn around((x, y): (i32, i32), radius: i32) -> Self {
        Self { left: x - radius, top: y - radius, right: x + radius, bottom: y + radius }
    }

    fn spanning(a: (i32, i32), b: (i32, i32), room: i32) -> Self {
        Self {
            left: a.0.min(b.0) - room,
            right: a.0.max(b.0) + room,
            top: a.1.min(b.1) - room,
            bottom: a.1.max(b.1) + room,
        }
    }

    fn center(&self) -> (i32, i32) {
        ((self.left + self.right) / 2, (self.top + self.bottom) / 2)
    }

    fn touches(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    fn is_inside(&self, other: &Self) -> bool {
        self.left >= other.left
            && self.right <= other.right
            && self.top >= other.top
            && self.bottom <= other.bottom
    }

    fn nearest(&self, (x, y): (i32, i32)) -> (i32, i32) {
        (x.clamp(self.left, self.right), y.clamp(self.top, self.bottom))
    }
}

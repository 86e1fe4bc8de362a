//! Lights as the frame has them, drawn over it: outlines of their volumes, and the cells that they are listed in.

use std::collections::BTreeMap;

use egui::{Color32, FontId, Pos2, Rect, Shape, Stroke, Ui};
use glam::{Vec2, Vec3};

use super::wireframe::{Eye, chords_of, frustum, outline, shown};
use crate::gpu::{SeenLight, SeenLights};
use crate::picture::srgb_from_linear;
use crate::plan::heat;
use crate::scene::Camera;
use crate::visible::Clusters;

/// What is outlined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Outlines {
    /// The volumes of lights, and those that directional lights' cascades see.
    pub(super) volumes: bool,
    pub(super) cells: Option<Cells>,
}

/// Which of the cells behind each tile of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cells {
    /// The one that lists the most lights.
    Most,
    /// That of a slice, 0 the nearest; of the last if there are fewer.
    Slice(u32),
}

/// What was outlined, in numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Outlined {
    lights: usize,
    shadowed: usize,
    endless: usize,
    cascades: usize,
    /// Of the cells, if there are any.
    slices: u32,
    cells: String,
}

const CASCADE: Color32 = Color32::from_rgb(255, 255, 255);
const DIGITS: FontId = FontId::monospace(10.0);

impl Outlines {
    /// Its part of the interface: what the user makes of it, if something.
    pub(super) fn panel(self, ui: &mut Ui, outlined: &Outlined) -> Option<Self> {
        let mut now = self;
        ui.checkbox(&mut now.volumes, "volumes of lights, views of shadow cascades");
        if self.volumes {
            let Outlined { lights, shadowed, endless, cascades, .. } = outlined;
            ui.label(format!(
                "{lights} lights are listed: {shadowed} cast shadows (solid lines), {endless} have no end; {cascades} cascades (white)"
            ));
        }
        let mut has_cells = self.cells.is_some();
        ui.checkbox(&mut has_cells, "lights that cells list");
        now.cells = has_cells.then_some(self.cells.unwrap_or(Cells::Most));
        if let Some(cells) = self.cells {
            ui.label(&outlined.cells);
            let mut slice = if let Cells::Slice(slice) = cells { i64::from(slice) } else { -1 };
            let name = |n: f64, _: std::ops::RangeInclusive<usize>| match n {
                ..0.0 => "most".to_owned(),
                n => format!("slice {n}"),
            };
            let last = i64::from(outlined.slices) - 1;
            if last > 0 && ui.add(egui::Slider::new(&mut slice, -1..=last).custom_formatter(name)).changed() {
                now.cells = Some(u32::try_from(slice).map_or(Cells::Most, Cells::Slice));
            }
            // All digits are in the image of letters before they are drawn.
            ui.fonts_mut(|fonts| fonts.layout_no_wrap("0123456789".into(), DIGITS, Color32::WHITE));
        }
        (now != self).then_some(now)
    }

    /// Draws what a frame of this camera is lit by, over a picture with so many pixels a point.
    pub(super) fn draw(
        self,
        seen: &SeenLights<'_>,
        camera: &Camera,
        pixels_per_point: f32,
        context: &egui::Context,
        shapes: &mut Vec<Shape>,
    ) -> Outlined {
        let place = Place::new(seen, pixels_per_point);
        let mut outlined = Outlined::default();
        if let (Some(cells), clusters) = (self.cells, seen.clusters) {
            outlined.cells = match clusters {
                None => "The plan's way of lights has no cells: 'lights' chooses clusters.".into(),
                Some(clusters) => {
                    outlined.slices = clusters.grid().slices;
                    draw_cells(cells, clusters, &place, context, shapes)
                }
            };
        }
        if self.volumes {
            draw_volumes(seen, Eye::of(camera), &place, shapes);
            let count = |is: fn(&SeenLight) -> bool| seen.lights.iter().filter(|light| is(light)).count();
            outlined.lights = seen.lights.len();
            outlined.shadowed = count(|light| light.has_shadow);
            outlined.endless = count(|light| light.reach == crate::visible::Reach::Everywhere);
            outlined.cascades = seen.clips_of_cascades.len();
        }
        outlined
    }
}

/// From images to points of the picture.
struct Place {
    points: Vec2,
    seen: (glam::Mat2, Vec2),
}

impl Place {
    fn new(seen: &SeenLights<'_>, pixels_per_point: f32) -> Self {
        let size = Vec2::from(seen.size.map(|n| n as f32));
        let picture = (seen.picture_from_image * size).abs();
        Self { points: picture / pixels_per_point, seen: (seen.picture_from_image, size) }
    }

    /// Of a place in the image, -1 to 1.
    fn at(&self, image: Vec2) -> Pos2 {
        let at = (self.seen.0 * image * 0.5 + 0.5) * self.points;
        Pos2::new(at.x, at.y)
    }

    /// Of a pixel's left upper corner, in the image.
    fn at_pixel(&self, pixel: Vec2) -> Pos2 {
        self.at(pixel / self.seen.1 * 2.0 - 1.0)
    }
}

/// As bright as can be, of the light's colour.
fn color(intensity: Vec3) -> Color32 {
    let most = intensity.max_element();
    let [r, g, b] = if most > 0.0 { (intensity / most).to_array() } else { [1.0; 3] }
        .map(|c| (srgb_from_linear(c.clamp(0.0, 1.0)) * 255.0).round() as u8);
    Color32::from_rgb(r, g, b)
}

fn draw_volumes(seen: &SeenLights<'_>, eye: Eye, place: &Place, shapes: &mut Vec<Shape>) {
    let chords = chords_of(seen.lights.len());
    let mut add = |ends, stroke: Stroke| {
        let shown = shown(&seen.clip_from_world, ends);
        shapes.extend(shown.map(|ends| Shape::line_segment(ends.map(|end| place.at(end)), stroke)));
    };
    for clip_of_cascade in &seen.clips_of_cascades {
        frustum(clip_of_cascade, chords, &mut |(ends, _)| add(ends, Stroke::new(1.0, CASCADE)));
    }
    for light in &seen.lights {
        let color = color(light.intensity);
        let stroke = match light.has_shadow {
            true => Stroke::new(1.5, color),
            false => Stroke::new(1.0, color.gamma_multiply(0.7)),
        };
        outline(&light.reach, eye, chords, &mut |(ends, n)| {
            // Without a shadow, dashes.
            if light.has_shadow || n % 4 == 0 {
                add(ends, stroke);
            }
        });
    }
    for light in &seen.lights {
        let Some(at) = light.place_world else { continue };
        let at = shown(&seen.clip_from_world, [at.extend(1.0), at.extend(1.0)]);
        let color = color(light.intensity);
        shapes.extend(at.map(|[at, _]| match light.has_shadow {
            true => Shape::circle_filled(place.at(at), 3.0, color),
            false => Shape::circle_stroke(place.at(at), 3.0, Stroke::new(1.0, color)),
        }));
    }
}

/// Draws a number and its colour in each tile that lists a light, and the tiles; says what of them.
fn draw_cells(
    cells: Cells,
    clusters: &Clusters,
    place: &Place,
    context: &egui::Context,
    shapes: &mut Vec<Shape>,
) -> String {
    let grid = clusters.grid();
    let last = grid.slices.saturating_sub(1);
    let (slices, told) = match cells {
        Cells::Most => (0..=last, format!("of {} slices, the cell with the most lights", grid.slices)),
        Cells::Slice(slice) => {
            let slice = slice.min(last);
            let begin = if slice == 0 { 0.0 } else { grid.begin(slice) };
            let end = if slice == last { f32::INFINITY } else { grid.begin(slice + 1) };
            (slice..=slice, format!("slice {slice} of {}: {begin:.2} m to {end:.2} m away", grid.slices))
        }
    };
    let corner = |[column, row]: [u32; 2]| {
        let pixel = Vec2::new((column << grid.tile_shift) as f32, (row << grid.tile_shift) as f32);
        place.at_pixel(pixel.min(place.seen.1))
    };
    let mut galleys = BTreeMap::new();
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let lights = |slice| clusters.lights_of(grid.cell_at([column, row], slice)).len();
            let count = slices.clone().map(lights).max().unwrap_or(0);
            let tile = Rect::from_two_pos(corner([column, row]), corner([column + 1, row + 1]));
            let line = Stroke::new(1.0, Color32::from_white_alpha(40));
            let [left, right] = [tile.left_top(), tile.right_top()];
            shapes.push(Shape::line_segment([left, right], line));
            shapes.push(Shape::line_segment([left, tile.left_bottom()], line));
            if count == 0 {
                continue;
            }
            let [r, g, b] = heat(count as u32).map(|x| (x * 255.0).round() as u8);
            shapes.push(Shape::rect_filled(tile, 0.0, Color32::from_rgba_unmultiplied(r, g, b, 70)));
            let galley = galleys.entry(count).or_insert_with(|| {
                context.fonts_mut(|fonts| fonts.layout_no_wrap(count.to_string(), DIGITS, Color32::WHITE))
            });
            let at = tile.center() - galley.size() * 0.5;
            shapes.push(Shape::galley(at, std::sync::Arc::clone(galley), Color32::WHITE));
        }
    }
    told
}

//! What the interface shows: times, the plan as a picture, the ledger, switches.

use std::collections::VecDeque;
use std::path::Path;

use egui::{
    Align2, CollapsingHeader, Color32, ComboBox, FontId, LayerId, Rect, RichText, Sense, Stroke, Ui, pos2,
    vec2,
};

use super::compare::{Compare, GAIN, How, MIDDLE};
use super::course::{Course, CourseWish};
use super::keys::HELP;
use super::outline::{Outlined, Outlines};
use super::player::{Controls, Player};
use super::scenes::{SceneWish, Scenes};
use super::shown::Shown;
use crate::gpu::ExplainedKind;
use crate::plan::{Layout, LightWay, Load, Options, Plan, Show, Store, Strategy, Tonemap, heat};

/// What there is to show.
pub(super) struct Shows<'a> {
    pub(super) shown: &'a Shown,
    pub(super) options: &'a Options,
    pub(super) compare: &'a Compare,
    pub(super) exposure_ev: f32,
    /// Of a scene that moves.
    pub(super) player: Option<&'a Player>,
    pub(super) course: &'a Course,
    pub(super) scenes: &'a Scenes,
    /// The file of the open one.
    pub(super) scene: &'a Path,
    /// Of the picture, pixels.
    pub(super) size: [u32; 2],
    /// Between the last two frames.
    pub(super) frame_ms: f32,
    /// Nanoseconds since the frame's begin: at its end, or after each stage.
    pub(super) stamps_ns: &'a [f64],
    /// What the user was told last.
    pub(super) message: &'a str,
    pub(super) asks_help: bool,
    pub(super) outlines: Outlines,
}

/// What the user asks for.
#[derive(Default)]
pub(super) struct Asked {
    /// An option by its name, and its value.
    pub(super) set: Option<(String, &'static str)>,
    pub(super) how: Option<How>,
    pub(super) outlines: Option<Outlines>,
    /// How far A and B are apart.
    pub(super) measures: bool,
    pub(super) exposure_ev: Option<f32>,
    pub(super) controls: Option<Controls>,
    pub(super) course: Option<CourseWish>,
    pub(super) scene: Option<SceneWish>,
}

/// What panels remember.
#[derive(Default)]
pub(super) struct Panels {
    frames_ms: VecDeque<f32>,
    gpu_ms: VecDeque<f32>,
    /// What was outlined last.
    pub(super) outlined: Outlined,
}

/// Frames whose times are shown.
const HISTORY: usize = 180;
const GOOD: Color32 = Color32::from_rgb(70, 150, 90);
const STORED: Color32 = Color32::from_rgb(200, 130, 40);
const LOADED: Color32 = Color32::from_rgb(200, 70, 60);
const LIVE: Color32 = Color32::from_rgb(60, 75, 95);

type Switch = (&'static str, fn() -> Vec<&'static str>, fn(&Options) -> String);

/// Options with their values, all by name.
const SWITCHES: [Switch; 6] = [
    ("strategy", || Strategy::ALL.iter().map(|v| v.name()).collect(), |o| o.strategy.to_string()),
    ("layout", || Layout::ALL.iter().map(|v| v.name()).collect(), |o| o.layout.to_string()),
    ("lights", || LightWay::ALL.iter().map(|v| v.name()).collect(), |o| o.lights.to_string()),
    ("samples", || vec!["1", "2", "4", "8"], |o| o.samples.to_string()),
    ("show", || Show::ALL.iter().map(|v| v.name()).collect(), |o| o.show.to_string()),
    ("tonemap", || Tonemap::ALL.iter().map(|v| v.name()).collect(), |o| o.tonemap.to_string()),
];

impl Panels {
    pub(super) fn show(&mut self, context: &egui::Context, shows: &Shows<'_>) -> Asked {
        let remember = |times: &mut VecDeque<f32>, ms| {
            times.truncate(HISTORY - 1);
            times.push_front(ms);
        };
        remember(&mut self.frames_ms, shows.frame_ms);
        if let Some(end) = shows.stamps_ns.last() {
            remember(&mut self.gpu_ms, (end * 1e-6) as f32);
        }
        let mut asked = Asked::default();
        let height = (context.content_rect().height() - 60.0).max(100.0);
        egui::Window::new("ontile").default_pos([8.0, 8.0]).default_width(360.0).default_height(height).show(
            context,
            |ui| {
                egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
                    if !shows.message.is_empty() {
                        ui.label(RichText::new(shows.message).color(Color32::LIGHT_RED));
                    }
                    if shows.asks_help {
                        ui.label(RichText::new(HELP).monospace());
                    }
                    self.times(ui, shows);
                    switches(ui, shows, &mut asked);
                    comparing(ui, shows, &mut asked);
                    if let Some(player) = shows.player {
                        section(ui, "Animation", true, |ui| asked.controls = player.panel(ui));
                    }
                    section(ui, "Scenes", false, |ui| asked.scene = shows.scenes.panel(ui, shows.scene));
                    section(ui, "Camera path", false, |ui| asked.course = shows.course.panel(ui));
                    section(ui, "Lights", false, |ui| {
                        asked.outlines = shows.outlines.panel(ui, &self.outlined);
                    });
                    if shows.shown.renderer.plan().options.show == Show::Lights
                        || shows.outlines.cells.is_some()
                    {
                        legend(ui);
                    }
                    let title = if shows.compare.how == How::Alone { "Plan" } else { "Plan of B" };
                    section(ui, title, true, |ui| plan(ui, shows.shown.renderer.plan()));
                    section(ui, "Bytes", true, |ui| bytes(ui, shows, mean(&self.frames_ms)));
                    section(ui, "Every object and its reason", false, |ui| objects(ui, shows.shown));
                    section(ui, "Notes", false, |ui| {
                        for note in &shows.shown.renderer.plan().notes {
                            ui.label(note);
                        }
                    });
                });
            },
        );
        name_strips(context, shows);
        divider(context, shows);
        asked
    }

    fn times(&self, ui: &mut Ui, shows: &Shows<'_>) {
        section(ui, "Times", true, |ui| {
            let frame_ms = mean(&self.frames_ms);
            let gpu = if self.gpu_ms.is_empty() {
                "not told".into()
            } else {
                format!("{:.2} ms", mean(&self.gpu_ms))
            };
            ui.label(format!("frame {frame_ms:.2} ms ({:.0} a second), GPU {gpu}", 1e3 / frame_ms.max(1e-3)));
            history(ui, &self.frames_ms, &self.gpu_ms);
            let plan = shows.shown.renderer.plan();
            let stages = plan.stage_count();
            if shows.stamps_ns.len() != stages + 1 {
                ui.label("The device tells no times of subpasses, or draws them tile by tile, one within the other.");
                return;
            }
            let total = shows.stamps_ns.last().copied().unwrap_or(1.0).max(1.0);
            for (stage, ns) in shows.stamps_ns.windows(2).enumerate() {
                let own = ns[1] - ns[0];
                let text = format!("{} {:.3} ms", plan.subpass(stage).2.name, own * 1e-6);
                ui.add(egui::ProgressBar::new((own / total) as f32).desired_height(14.0).text(text));
            }
        });
    }
}

fn section(ui: &mut Ui, title: &str, is_open: bool, show: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(title).default_open(is_open).show(ui, show);
}

fn mean(times: &VecDeque<f32>) -> f32 {
    times.iter().sum::<f32>() / times.len().max(1) as f32
}

/// The newest at the right; the scale is that of the slowest.
fn history(ui: &mut Ui, frames_ms: &VecDeque<f32>, gpu_ms: &VecDeque<f32>) {
    let (rect, _) = ui.allocate_exact_size(vec2(340.0, 44.0), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, Color32::from_black_alpha(120));
    let most = frames_ms.iter().copied().fold(1.0, f32::max);
    for (times, color) in [(frames_ms, STORED), (gpu_ms, GOOD)] {
        let at = |(i, ms): (usize, &f32)| {
            let x = rect.right() - rect.width() * i as f32 / HISTORY as f32;
            pos2(x, rect.bottom() - rect.height() * (ms / most).min(1.0))
        };
        let line: Vec<_> = times.iter().enumerate().map(at).collect();
        painter.add(egui::Shape::line(line, Stroke::new(1.0, color)));
    }
    let font = FontId::monospace(10.0);
    let label = format!("{most:.1} ms  frame (orange), GPU (green)");
    painter.text(rect.left_top() + vec2(3.0, 2.0), Align2::LEFT_TOP, label, font, Color32::GRAY);
}

fn switches(ui: &mut Ui, shows: &Shows<'_>, asked: &mut Asked) {
    section(ui, "Options", true, |ui| {
        egui::Grid::new("options").num_columns(4).show(ui, |ui| {
            choices(ui, "", shows.options, asked);
            ui.label("exposure");
            let mut ev = shows.exposure_ev;
            if ui.add(egui::DragValue::new(&mut ev).speed(0.05).range(-64.0..=64.0).suffix(" EV")).changed() {
                asked.exposure_ev = Some(ev);
            }
        });
    });
}

/// A box for each of the switches; names begin like this.
fn choices(ui: &mut Ui, prefix: &str, options: &Options, asked: &mut Asked) {
    for (i, (name, values, value)) in SWITCHES.iter().enumerate() {
        let (now, name) = (value(options), format!("{prefix}{name}"));
        ui.label(&name);
        ComboBox::from_id_salt(&name).width(110.0).selected_text(now.as_str()).show_ui(ui, |ui| {
            for value in values() {
                if ui.selectable_label(now == value, value).clicked() {
                    asked.set = Some((name.clone(), value));
                }
            }
        });
        if i % 2 == 1 {
            ui.end_row();
        }
    }
}

/// A beside B.
fn comparing(ui: &mut Ui, shows: &Shows<'_>, asked: &mut Asked) {
    section(ui, "A and B", false, |ui| {
        let now = shows.compare.how;
        ui.horizontal(|ui| {
            for (name, how) in
                [("A", How::Alone), ("A | B", How::Split(MIDDLE)), ("A - B", How::Difference(GAIN))]
            {
                let is_now = std::mem::discriminant(&now) == std::mem::discriminant(&how);
                if ui.selectable_label(is_now, name).clicked() && !is_now {
                    asked.how = Some(how);
                }
            }
            asked.measures = ui.button("measure").clicked();
        });
        if let How::Difference(gain) = now {
            let mut gain = gain;
            let slider = egui::Slider::new(&mut gain, 1.0..=256.0).logarithmic(true).text("times");
            if ui.add(slider).drag_stopped() {
                asked.how = Some(How::Difference(gain));
            }
        }
        let Ok(options) = shows.compare.beside(shows.options) else { return };
        egui::Grid::new("beside").num_columns(4).show(ui, |ui| choices(ui, "b.", &options, asked));
    });
}

/// The line between A and B, and which is which.
fn divider(context: &egui::Context, shows: &Shows<'_>) {
    let How::Split(share) = shows.compare.how else { return };
    let (rect, painter) = (context.content_rect(), context.layer_painter(LayerId::background()));
    let x = rect.left() + rect.width() * share;
    painter.vline(x, rect.y_range(), Stroke::new(2.0, Color32::WHITE));
    for (name, align, by) in [("A", Align2::RIGHT_TOP, -8.0), ("B", Align2::LEFT_TOP, 8.0)] {
        painter.text(pos2(x + by, rect.top() + 8.0), align, name, FontId::proportional(18.0), Color32::WHITE);
    }
}

/// What colours of `--show lights` say.
fn legend(ui: &mut Ui) {
    ui.horizontal(|ui| {
        ui.label("lights");
        for lights in [0, 1, 2, 3, 5, 8, 12, 20, 31, 45, 63] {
            let [r, g, b] = heat(lights).map(|x| (x * 255.0).round() as u8);
            let (rect, _) = ui.allocate_exact_size(vec2(24.0, 16.0), Sense::hover());
            let painter = ui.painter_at(rect);
            painter.rect_filled(rect, 0.0, Color32::from_rgb(r, g, b));
            let is_bright = u32::from(r) + 2 * u32::from(g) + u32::from(b) > 400;
            let color = if is_bright { Color32::BLACK } else { Color32::WHITE };
            let text = if lights == 63 { "63+".to_owned() } else { lights.to_string() };
            painter.text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(10.0), color);
        }
    });
}

/// The names of what is shown in strips, at the lower edge of each.
fn name_strips(context: &egui::Context, shows: &Shows<'_>) {
    let strips = shows.shown.renderer.plan().strips();
    let rect = context.content_rect();
    let painter = context.layer_painter(LayerId::background());
    for (index, strip) in strips.iter().enumerate() {
        let x = |at: f32| rect.left() + rect.width() * at / strips.len() as f32;
        if index > 0 {
            painter.vline(x(index as f32), rect.y_range(), Stroke::new(1.0, Color32::from_white_alpha(120)));
        }
        let place = pos2(x(index as f32 + 0.5), rect.bottom() - 12.0);
        let text = painter.layout_no_wrap(strip.name().into(), FontId::proportional(13.0), Color32::WHITE);
        let behind = Align2::CENTER_CENTER.anchor_size(place, text.size());
        painter.rect_filled(behind.expand(3.0), 3.0, Color32::from_black_alpha(190));
        painter.galley(behind.min, text, Color32::WHITE);
    }
}

/// A row an attachment, a column a subpass: where it is live, written and read.
fn plan(ui: &mut Ui, plan: &Plan) {
    let passes =
        || plan.passes.iter().flat_map(|pass| pass.subpasses.iter().map(move |subpass| (pass, subpass)));
    let count = plan.passes.len();
    let several = if count == 1 { "" } else { "es" };
    ui.label(format!(
        "{count} render pass{several}, {} subpasses; path {}, {}",
        plan.stage_count(),
        plan.path,
        plan.strategy
    ));
    egui::Grid::new("plan").spacing([2.0, 2.0]).show(ui, |ui| {
        ui.label("");
        for (_, subpass) in passes() {
            let title = RichText::new(subpass.name).small();
            ui.label(title).on_hover_text(format!(
                "{}\nlive on the tile: {} colour bits, {} depth bits a pixel",
                subpass.why, subpass.live_color_bits, subpass.live_depth_bits
            ));
        }
        ui.end_row();
        for (index, attachment) in plan.attachments.iter().enumerate() {
            let samples =
                if attachment.samples > 1 { format!(" x{}", attachment.samples) } else { String::new() };
            let why = format!("{}\n{}", attachment.holds.join("; "), attachment.why.join("; "));
            let name = RichText::new(format!("{} {}{samples}", attachment.name, attachment.format)).small();
            ui.label(name).on_hover_text(why.as_str());
            for (stage, (pass, subpass)) in passes().enumerate() {
                let own = |position: &usize| pass.attachments[*position].attachment == index;
                let is_written = subpass.colors.iter().any(own);
                let is_depth = subpass.depth.iter().any(own);
                let is_read = subpass.inputs.iter().any(own);
                let is_resolved = subpass.resolve.iter().any(|resolve| own(&resolve.to));
                let text = match (is_written, is_read) {
                    (true, true) => "read, written",
                    (true, false) => "written",
                    (false, true) => "read",
                    _ if is_depth && subpass.depth_write => "tested, written",
                    _ if is_depth => "tested",
                    _ if is_resolved => "resolved",
                    _ => "",
                };
                let (first, last) = attachment.lifetime;
                let is_live = (first..=last).contains(&stage);
                let color = if text.is_empty() { LIVE } else { GOOD };
                cell(ui, if is_live || !text.is_empty() { Some(color) } else { None }, text, &why);
            }
            let of_passes =
                || plan.passes.iter().flat_map(|p| &p.attachments).filter(|a| a.attachment == index);
            let loads = of_passes().filter(|a| a.load == Load::Load).count();
            let stores = of_passes().filter(|a| a.store == Store::Store).count();
            let (color, text) = match (loads, stores) {
                (0, 0) => (GOOD, "stays on the tile".to_owned()),
                (0, _) => (STORED, format!("stored x{stores}")),
                _ => (LOADED, format!("loaded x{loads}, stored x{stores}")),
            };
            ui.label(RichText::new(text).small().color(color)).on_hover_text(why);
            ui.end_row();
        }
        ui.label(RichText::new("live bits").small());
        for (_, subpass) in passes() {
            let bits = format!("{}+{}", subpass.live_color_bits, subpass.live_depth_bits);
            ui.label(RichText::new(bits).small()).on_hover_text("colour and depth bits a pixel on the tile");
        }
        ui.end_row();
    });
}

fn cell(ui: &mut Ui, color: Option<Color32>, text: &str, why: &str) {
    let (rect, response): (Rect, _) = ui.allocate_exact_size(vec2(84.0, 15.0), Sense::hover());
    let Some(color) = color else { return };
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, color);
    painter.text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(10.0), Color32::WHITE);
    response.on_hover_text(why);
}

fn bytes(ui: &mut Ui, shows: &Shows<'_>, frame_ms: f32) {
    let totals = &shows.shown.report.totals;
    let pixels = f64::from(shows.size[0]) * f64::from(shows.size[1]);
    let per_second = pixels * 1e3 / f64::from(frame_ms.max(1e-3));
    let loaded = totals.loaded_bytes_per_pixel.value + totals.post_loaded_bytes_per_pixel.value;
    let stored = totals.stored_bytes_per_pixel.value + totals.post_stored_bytes_per_pixel.value;
    egui::Grid::new("bytes").num_columns(3).show(ui, |ui| {
        ui.label("attachments, planned");
        ui.label("a pixel");
        ui.label("a second at this rate");
        ui.end_row();
        for (name, bytes) in [("loaded", loaded), ("stored", stored)] {
            ui.label(name);
            ui.label(format!("{bytes:.1} B"));
            ui.label(format!("{:.1} MB", bytes * per_second * 1e-6));
            ui.end_row();
        }
    });
    if totals.shadow_tile_passes > 0 {
        let mb = totals.shadow_stored_bytes.value * 1e-6;
        let tiles = totals.shadow_tile_passes;
        ui.label(format!(
            "shadow map: {mb:.1} MB stored when all {tiles} tiles are drawn; those that stand still are kept"
        ));
    }
    ui.label(format!(
        "scene and shadow maps in memory: {:.1} MB",
        shows.shown.renderer.scene_bytes() as f64 * 1e-6
    ));
}

fn objects(ui: &mut Ui, shown: &Shown) {
    for object in &shown.explanation.objects {
        let is_part = object.of.is_some() || object.kind == ExplainedKind::Subpass;
        let indent = if is_part { "    " } else { "" };
        ui.label(RichText::new(format!("{indent}{}", object.name)).small())
            .on_hover_text(object.why.as_str());
    }
}

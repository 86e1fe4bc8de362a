//! What keys ask for, done.

use winit::event_loop::ActiveEventLoop;
use winit::window::Fullscreen;

use super::app::{App, free_name};
use super::compare::{GAIN, How, MIDDLE};
use super::keys::{HELP, Wish};
use super::outline::{Cells, Outlines};
use super::rig::{Motion, Rig};
use crate::plan::Options;

impl App {
    pub(super) fn wish(&mut self, wish: Wish, events: &ActiveEventLoop) {
        match wish {
            Wish::Quit => events.exit(),
            Wish::Help if self.viewer.options.overlay => self.asks_help = !self.asks_help,
            Wish::Help => (self.viewer.tell)(HELP),
            Wish::Overlay => {
                let overlay = !self.viewer.options.overlay;
                self.set_options(Options { overlay, ..self.viewer.options.clone() });
            }
            Wish::Volumes => {
                self.set_outlines(Outlines { volumes: !self.outlines.volumes, ..self.outlines });
            }
            Wish::Clusters => {
                let cells = if self.outlines.cells.is_some() { None } else { Some(Cells::Most) };
                self.set_outlines(Outlines { cells, ..self.outlines });
            }
            Wish::Show(backwards) => self.show_next(backwards),
            Wish::Split => self.toggle(How::Split(MIDDLE)),
            Wish::Difference => self.toggle(How::Difference(GAIN)),
            Wish::Motion => {
                self.rig.motion = match self.rig.motion {
                    Motion::Orbit => Motion::Fly,
                    Motion::Fly => Motion::Orbit,
                };
            }
            Wish::Camera(index) if index >= self.world.scene().cameras.len() => {}
            Wish::Camera(index) => {
                self.rig = Rig::new(self.world.scene(), index, self.rig.motion);
            }
            Wish::NextCamera => {
                let cameras = &self.world.scene().cameras;
                let count = cameras.len();
                let now = cameras.iter().position(|c| c.name == self.rig.camera.name);
                self.wish(Wish::Camera(now.map_or(0, |n| (n + 1) % count)), events);
            }
            Wish::Play => {
                let _ = self.control(|controls| controls.is_playing = !controls.is_playing);
            }
            Wish::NextAnimation => self.next_animation(),
            Wish::Step(steps) => self.step_animation(steps),
            Wish::Hasten(doublings) => self.hasten(doublings),
            Wish::Course(wish) => self.set_course(wish),
            Wish::Expose(half_stops) => {
                let ev = self.viewer.exposure_ev + 0.5 * half_stops as f32;
                self.viewer.exposure_ev = ev.clamp(-64.0, 64.0);
            }
            Wish::Screenshot => {
                let path = free_name("png");
                self.tell_text(&format!("screenshot: {}", path.display()));
                self.steps.want_shot(path);
            }
            Wish::Fullscreen => {
                let Some(open) = &self.open else { return };
                let is_full = open.window.fullscreen().is_some();
                open.window.set_fullscreen((!is_full).then_some(Fullscreen::Borderless(None)));
            }
        }
    }
}

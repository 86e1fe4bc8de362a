//! The overlay in the window's life.

use winit::event_loop::ActiveEventLoop;

use super::app::{App, Open};
use super::outline::Outlines;
use super::overlay::Overlay;
use super::panels::Shows;
use crate::plan::{Needs, Options, Plan, Show};
use crate::{Error, Result};

impl App {
    /// Shows the first scene; without the overlay if it does not go with the options.
    pub(super) fn show_first(&mut self) -> Result<()> {
        let Some(open) = &mut self.open else { return Ok(()) };
        match open.frames.show(self.world.scene(), &self.viewer.options, &self.compare) {
            Err(error @ Error::Unsupported { .. }) if self.viewer.options.overlay => {
                self.viewer.options.overlay = false;
                open.frames.show(self.world.scene(), &self.viewer.options, &self.compare)?;
                self.tell(&error);
                Ok(())
            }
            shown => shown,
        }
    }

    /// The system is short of memory: while nobody looks, what draws goes, and is made anew with the next frame that somebody sees.
    pub(super) fn give_back(&mut self, events: &ActiveEventLoop) {
        let is_seen = !self.is_occluded && !self.is_suspended;
        if let Some(open) = self.open.as_mut().filter(|_| !is_seen)
            && let Err(error) = open.frames.release()
        {
            self.fail(error, events);
        }
    }

    /// Makes the overlay's next frame and does what it is asked; there is one only while the plan has it.
    pub(super) fn lay_out(&mut self, seconds: f32) {
        if self.viewer.options.overlay {
            self.look_for_scenes(false);
        }
        let Some(Open { frames, window, overlay }) = &mut self.open else { return };
        let (Some(shown), Some(size)) = (frames.shown(), frames.size()) else { return };
        if !shown.renderer.plan().options.overlay {
            *overlay = None;
            return;
        }
        let (overlay, _) = overlay
            .get_or_insert_with(|| (Overlay::new(window, frames.limits().max_image_size), frames.shows()));
        let asked = overlay.lay_out(
            window,
            &Shows {
                shown,
                options: &self.viewer.options,
                compare: &self.compare,
                exposure_ev: self.viewer.exposure_ev,
                player: self.player.as_ref(),
                course: &self.course,
                scenes: &self.scenes,
                scene: &self.viewer.scene,
                size,
                frame_ms: seconds * 1e3,
                stamps_ns: frames.stamps_ns(),
                message: &self.message.borrow(),
                asks_help: self.asks_help,
                outlines: self.outlines,
            },
        );
        self.viewer.exposure_ev = asked.exposure_ev.unwrap_or(self.viewer.exposure_ev);
        if let (Some(player), Some(controls)) = (&mut self.player, asked.controls) {
            player.controls = controls;
        }
        if let Some(wish) = asked.course {
            self.set_course(wish);
        }
        if let Some(Err(error)) = asked.scene.map(|wish| self.set_scene(wish)) {
            self.tell(&error);
        }
        if let Some((name, value)) = asked.set {
            self.set_option(&name, value);
        }
        if let Some(outlines) = asked.outlines {
            self.set_outlines(outlines);
        }
        if let Some(how) = asked.how {
            self.set_how(how);
        }
        if asked.measures
            && let Err(error) = self.measure(None)
        {
            self.tell(&error);
        }
        let Some(Open { frames, overlay: Some((overlay, shows)), .. }) = &mut self.open else { return };
        if std::mem::replace(shows, frames.shows()) != frames.shows() {
            overlay.renew();
        }
    }

    /// Shows the next of all that the scene and the options have to show.
    pub(super) fn show_next(&mut self, backwards: bool) {
        let Some(open) = &self.open else { return };
        let options = &self.viewer.options;
        let now = Show::ALL.iter().position(|show| *show == options.show).unwrap_or(0);
        let (count, needs, limits) = (Show::ALL.len(), Needs::of(self.world.scene()), open.frames.limits());
        let others = (1..count).map(|n| Show::ALL[(now + if backwards { count - n } else { n }) % count]);
        let mut others = others.map(|show| Options { show, ..options.clone() });
        if let Some(next) = others.find(|o| Plan::new(needs.clone(), o.clone(), &limits).is_ok()) {
            self.set_options(next);
        }
    }

    /// Outlines these, in the overlay.
    pub(super) fn set_outlines(&mut self, outlines: Outlines) {
        if outlines == Outlines::default()
            || self.viewer.options.overlay
            || self.set_options(Options { overlay: true, ..self.viewer.options.clone() })
        {
            self.outlines = outlines;
        }
    }

    /// Builds the frame by other options, or goes on with those before; whether it could be built.
    pub(super) fn set_options(&mut self, options: Options) -> bool {
        let Some(open) = &mut self.open else { return false };
        let shown = open.frames.show(self.world.scene(), &options, &self.compare);
        match &shown {
            Ok(()) => {
                self.viewer.options = options;
                self.message.borrow_mut().clear();
            }
            Err(error) => self.tell(error),
        }
        shown.is_ok()
    }

    /// Sets an option by its name, or goes on with those before.
    pub(super) fn set_option(&mut self, name: &str, value: &str) {
        if let Some(name) = name.strip_prefix("b.") {
            return self.set_beside(name, value);
        }
        let mut options = self.viewer.options.clone();
        match options.set(name, value) {
            Ok(()) => {
                self.set_options(options);
            }
            Err(error) => self.tell(&error),
        }
    }
}

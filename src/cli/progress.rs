//! Progress of long work on standard error; silent unless that is a terminal.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// Work that goes on until this is dropped; its line then goes away.
pub struct Progress(ProgressBar);

impl Progress {
    /// Work of unknown length, e.g. "Loading scene.glb".
    pub fn of(what: impl Into<String>) -> Self {
        let bar = ProgressBar::new_spinner().with_message(what.into());
        bar.enable_steady_tick(Duration::from_millis(100));
        Self(bar)
    }

    /// Work of `count` steps, each told by [`Self::step`].
    pub fn of_steps(what: impl Into<String>, count: u64) -> Self {
        const TEMPLATE: &str = "{msg} {wide_bar} {pos}/{len} {eta}";
        let style = ProgressStyle::with_template(TEMPLATE).expect("a valid template");
        Self(ProgressBar::new(count).with_style(style).with_message(what.into()))
    }

    /// What is being done now.
    pub fn tell(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }

    /// One step is done.
    pub fn step(&self) {
        self.0.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

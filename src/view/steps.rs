//! A script as it runs.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::DVec2;
use winit::dpi::PhysicalSize;
use winit::event_loop::ActiveEventLoop;

use super::app::App;
use super::compare::How;
use super::hand;
use super::outline::Outlines;
#[cfg(feature = "shader-compiler")]
use super::reload::Reload;
use super::scenes::SceneWish;
use super::script::{Script, Step};
use crate::plan::Options;
use crate::{Error, Result};

/// The commands that are left, and what is waited for.
#[derive(Debug, Default)]
pub(super) struct Steps {
    left: VecDeque<Step>,
    wait: Option<Wait>,
    /// The file of a picture that the next frame is to be.
    shot: Option<PathBuf>,
    /// The window closes after the last command.
    closes: bool,
}

#[derive(Debug)]
enum Wait {
    Frames(u32),
    Shot,
    Loading,
    Flight,
    #[cfg(feature = "shader-compiler")]
    Modules,
    Size([u32; 2], Instant),
}

/// How long a window is waited for to take a size.
const MOST_WAIT: Duration = Duration::from_secs(10);

impl Steps {
    pub(super) fn new(script: Option<Script>) -> Self {
        let closes = script.is_some();
        let left = script.unwrap_or_default().steps.into();
        Self { left, closes, ..Self::default() }
    }

    /// Whether nobody but a script is there.
    pub(super) fn is_script(&self) -> bool {
        self.closes
    }

    /// Whether something is still to be done.
    pub(super) fn are_left(&self) -> bool {
        self.closes || self.shot.is_some()
    }

    /// Wants the next frame as a picture.
    pub(super) fn want_shot(&mut self, path: PathBuf) {
        self.shot = Some(path);
    }

    pub(super) fn shot(&self) -> Option<&Path> {
        self.shot.as_deref()
    }

    /// A frame is on its way; the picture was written if one was wanted.
    pub(super) fn frame_drawn(&mut self) {
        self.shot = None;
        if matches!(self.wait, Some(Wait::Shot)) {
            self.wait = None;
        }
        self.frame_passed();
    }

    /// It was time for a frame, drawn or not.
    pub(super) fn frame_passed(&mut self) {
        if let Some(Wait::Frames(left)) = &mut self.wait {
            *left = left.saturating_sub(1);
        }
    }
}

impl App {
    /// Carries out commands until one has to be waited for.
    pub(super) fn run_steps(&mut self, events: &ActiveEventLoop) -> Result<()> {
        // Until there is a frame there is nothing to command.
        let has_begun = self.open.as_ref().is_some_and(|open| open.frames.shows() > 0);
        if !has_begun || !self.steps.closes {
            return Ok(());
        }
        loop {
            match &self.steps.wait {
                Some(Wait::Frames(0)) | None => {}
                Some(Wait::Loading) if !self.is_loading() => {}
                #[cfg(feature = "shader-compiler")]
                Some(Wait::Modules)
                    if !self.is_drawn() || !self.reload.as_ref().is_some_and(Reload::is_busy) => {}
                Some(Wait::Flight) if !self.is_drawn() || !self.course.is_flown() => {}
                Some(Wait::Size(size, since)) => {
                    if self.open.as_ref().and_then(|open| open.frames.size()) != Some(*size) {
                        if since.elapsed() > MOST_WAIT {
                            let [width, height] = size;
                            return Err(Error::unsupported(
                                format!("the window does not take the size {width}x{height}"),
                                "ask for one that the screen has room for",
                            ));
                        }
                        return Ok(());
                    }
                }
                Some(_) => return Ok(()),
            }
            self.steps.wait = None;
            let Some(step) = self.steps.left.pop_front() else {
                events.exit();
                return Ok(());
            };
            self.run_step(step, events)?;
            if !self.steps.closes {
                return Ok(());
            }
        }
    }

    #[cfg(feature = "shader-compiler")]
    fn compile_changed(&mut self) -> Result<()> {
        let reload = self.reload.as_mut().ok_or_else(|| {
            Error::unsupported("no folder of GLSL is watched", "name one: 'ontile view --glsl DIR'")
        })?;
        reload.look_now();
        self.steps.wait = Some(Wait::Modules);
        Ok(())
    }

    #[cfg(not(feature = "shader-compiler"))]
    fn compile_changed(&mut self) -> Result<()> {
        let what = "this build has no compiler of GLSL";
        Err(Error::unsupported(what, "build it with the feature shader-compiler"))
    }

    fn run_step(&mut self, step: Step, events: &ActiveEventLoop) -> Result<()> {
        match step {
            Step::Frames(count) => self.steps.wait = Some(Wait::Frames(count)),
            Step::Size([0, _] | [_, 0]) => {
                self.is_minimised = true;
                self.open.iter_mut().for_each(|open| open.frames.outdate());
            }
            Step::Size(size) => {
                let Some(open) = &mut self.open else { return Ok(()) };
                let [width, height] = size;
                let resized = open.window.request_inner_size(PhysicalSize::new(width, height));
                // What has its size at once, as windows on Wayland do, is not told of it.
                if std::mem::take(&mut self.is_minimised) || resized.is_some() {
                    open.frames.outdate();
                }
                self.steps.wait = Some(Wait::Size(size, Instant::now()));
            }
            Step::Open(path) => {
                self.load(&path);
                self.steps.wait = Some(Wait::Loading);
            }
            Step::Scenes(path) => {
                self.look_for_scenes(true);
                crate::file::write_whole(&path, self.scenes.to_text().as_bytes())?;
            }
            Step::Pick(index) => {
                self.set_scene(SceneWish::Open(index))?;
                self.steps.wait = Some(Wait::Loading);
            }
            Step::Set(name, value) => self.set_option(&name, &value),
            Step::Camera(wanted) => self.set_camera(&wanted)?,
            Step::Play(is_playing) => self.control(|controls| controls.is_playing = is_playing)?,
            Step::Time(time_s) => self.control(|controls| controls.time_s = time_s)?,
            Step::Speed(speed) => self.control(|controls| controls.speed = speed)?,
            Step::Animation(wanted) => self.set_animation(&wanted)?,
            Step::Record(path) => self.record(path)?,
            Step::Stop => self.end_course()?,
            Step::Fly(path) => {
                self.fly(&path)?;
                self.steps.wait = Some(Wait::Flight);
            }
            Step::Reload => self.compile_changed()?,
            Step::Exposure(ev) => self.viewer.exposure_ev = ev,
            Step::Drag([x, y]) => {
                let size = self.open.as_ref().and_then(|open| open.frames.size());
                let [_, height] = size.unwrap_or(self.viewer.options.size);
                hand::turn(&mut self.rig, DVec2::new(x.into(), y.into()), height.into());
            }
            Step::Screenshot(path) => {
                self.steps.want_shot(path);
                self.steps.wait = Some(Wait::Shot);
            }
            Step::Live(path) => {
                if let Some(open) = &self.open {
                    open.frames.write_live(&path)?;
                }
            }
            Step::Overlay(is_on) => {
                self.set_options(Options { overlay: is_on, ..self.viewer.options.clone() });
            }
            Step::Volumes(volumes) => self.set_outlines(Outlines { volumes, ..self.outlines }),
            Step::Clusters(cells) => self.set_outlines(Outlines { cells, ..self.outlines }),
            Step::Split(share) => self.set_how(share.map_or(How::Alone, How::Split)),
            Step::Difference(gain) => self.set_how(gain.map_or(How::Alone, How::Difference)),
            Step::Measure(path) => self.measure(Some(&path))?,
            Step::Turn(pre_rotation) => {
                self.open.iter_mut().for_each(|open| open.frames.pretend(pre_rotation));
            }
            Step::LowMemory => self.give_back(events),
            Step::Suspend => self.suspend(events),
            Step::Resume => self.resume(events),
            Step::Stay => self.steps.closes = false,
        }
        Ok(())
    }
}

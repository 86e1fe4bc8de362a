//! Frames to a window: its surface and images, made anew when they are lost or do not fit, and what is drawn to them.

use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use super::Viewer;
use super::overlay::Overlay;
use super::shown::Shown;
use crate::gpu::{
    HeadlessOptions, PipelineCache, PresentMode, Presented, Presenter, Renderer, Surface, Swapchain, View,
    WindowHandles, WindowHost,
};
use crate::plan::{Limits, Options};
use crate::scene::{PreRotation, Scene};
use crate::{Error, Result};

/// A window's device and all that is made from it.
pub(super) struct Frames {
    // In order of destruction; `close` waits for the GPU first.
    shown: Option<Shown>,
    swapchain: Option<Swapchain>,
    surface: Option<Rc<Surface>>,
    presenter: Presenter,
    cache: PipelineCache,
    host: WindowHost,
    window: Arc<dyn WindowHandles>,
    mode: PresentMode,
    frames_in_flight: usize,
    /// How the screen is said to be turned, where it is not.
    pretended: PreRotation,
    /// The window has changed since the swapchain was made.
    is_outdated: bool,
    /// Nanoseconds since the begin of the last frame that the GPU has told of: see [`QueryResults`](crate::gpu::QueryResults).
    stamps_ns: Vec<f64>,
    /// How often something else was shown.
    shows: u64,
    /// What the validation layer may say of all that was shown.
    excused: Vec<&'static str>,
}

/// Reads what the slot's last frame took, and sets what is drawn over the next.
fn prepare(
    renderer: &mut Renderer,
    slot: usize,
    is_recorded: &mut bool,
    stamps_ns: &mut Vec<f64>,
    overlay: Option<&Overlay>,
) -> Result<()> {
    if std::mem::replace(is_recorded, true)
        && let Some(stamps) = renderer.query_results(slot)?.timestamps_ns
    {
        *stamps_ns = stamps;
    }
    overlay.map_or(Ok(()), |overlay| renderer.set_overlay(slot, &overlay.frame()))
}

/// How pictures are turned, on a screen that is or that is said to be.
fn turned(swapchain: &Swapchain, pretended: PreRotation) -> PreRotation {
    match swapchain.pre_rotation() {
        PreRotation::Identity => pretended,
        turned => turned,
    }
}

/// Arm's advice against all that is asked for by other modes.
const NOT_FIFO: [&str; 1] = ["swapchain-presentmode-not-fifo"];

/// What came of drawing.
pub(super) enum Drawn {
    /// A frame is on its way.
    Frame,
    /// There is nothing to draw to now.
    Nothing,
    /// There was nothing to draw to, but there will be: draw again.
    Again,
}

impl Frames {
    pub(super) fn new(viewer: &Viewer, window: Arc<dyn WindowHandles>) -> Result<Self> {
        let options = HeadlessOptions {
            device_name_part: viewer.device.clone(),
            validate: viewer.validate,
            application_name: "ontile".into(),
        };
        let host = WindowHost::new(&options, &window)?;
        let cache = PipelineCache::load(host.device())?;
        let presenter = Presenter::new(host.device(), viewer.frames_in_flight)?;
        Ok(Self {
            shown: None,
            swapchain: None,
            surface: None,
            presenter,
            cache,
            host,
            window,
            mode: viewer.present,
            frames_in_flight: viewer.frames_in_flight.max(1),
            pretended: PreRotation::Identity,
            is_outdated: false,
            stamps_ns: Vec::new(),
            shows: 0,
            excused: NOT_FIFO.iter().filter(|_| viewer.present != PresentMode::Fifo).copied().collect(),
        })
    }

    /// What is shown, once something is.
    pub(super) fn shown(&self) -> Option<&Shown> {
        self.shown.as_ref()
    }

    /// Width and height of what the images show, while there are some.
    pub(super) fn size(&self) -> Option<[u32; 2]> {
        self.swapchain.as_ref().map(|swapchain| swapchain.pre_rotation().size(swapchain.size()))
    }

    /// Draws as if the screen was turned.
    pub(super) fn pretend(&mut self, pre_rotation: PreRotation) {
        self.pretended = pre_rotation;
        self.outdate();
    }

    /// Times of a frame that the GPU has finished.
    pub(super) fn stamps_ns(&self) -> &[f64] {
        &self.stamps_ns
    }

    /// Changes when something else is shown.
    pub(super) fn shows(&self) -> u64 {
        self.shows
    }

    /// What the device allows.
    pub(super) fn limits(&self) -> Limits {
        self.host.device().limits()
    }

    /// Has the images made anew with the next frame.
    pub(super) fn outdate(&mut self) {
        self.is_outdated = true;
    }

    /// Gives up images and surface: the system takes the window.
    pub(super) fn suspend(&mut self) -> Result<()> {
        self.presenter.wait()?;
        self.shown.iter_mut().for_each(|shown| shown.target = None);
        self.swapchain = None;
        self.surface = None;
        Ok(())
    }

    /// Gives up what draws the scene, which [`Self::show`] makes anew.
    pub(super) fn release(&mut self) -> Result<()> {
        self.presenter.wait()?;
        self.shown = None;
        Ok(())
    }

    /// Makes sure that there are images of the window's size, and a surface; whether there are.
    pub(super) fn prepare(&mut self, window_size: [u32; 2]) -> Result<bool> {
        let surface = match &self.surface {
            Some(surface) => Rc::clone(surface),
            None => Rc::clone(self.surface.insert(Rc::new(self.host.surface(&self.window)?))),
        };
        if self.swapchain.is_some() && !self.is_outdated {
            return Ok(true);
        }
        self.presenter.wait()?;
        self.shown.iter_mut().for_each(|shown| shown.target = None);
        let old = self.swapchain.take();
        self.swapchain = match Swapchain::new(&surface, window_size, self.mode, old.as_ref()) {
            Err(error) if Surface::is_lost(&error) => {
                drop((old, surface));
                self.surface = None;
                return Ok(false);
            }
            made => made?,
        };
        self.is_outdated = false;
        Ok(self.swapchain.is_some())
    }

    /// Shows a scene by some options from now on. What was shown goes on if that fails.
    pub(super) fn show(&mut self, scene: &Arc<Scene>, options: &Options) -> Result<()> {
        let Some(swapchain) = &self.swapchain else {
            return Err(Error::unsupported("the window has no pixels", "make it larger"));
        };
        let device = self.host.device();
        let images = (swapchain, turned(swapchain, self.pretended));
        let shown = Shown::new(device, &self.cache, scene, options, images, self.frames_in_flight)?;
        self.cache.store();
        self.excused.extend(&shown.excused);
        self.presenter.wait()?;
        self.shown = Some(shown);
        self.shows += 1;
        self.stamps_ns.clear();
        Ok(())
    }

    /// Draws a frame to images that [`Self::prepare`] has made, and reads it back if that is asked for.
    pub(super) fn draw(
        &mut self,
        view: &View<'_>,
        shot: Option<&Path>,
        mut overlay: Option<&mut Overlay>,
    ) -> Result<Drawn> {
        let (Some(swapchain), Some(shown)) = (&self.swapchain, &mut self.shown) else {
            return Ok(Drawn::Nothing);
        };
        if !shown.suits(swapchain) {
            let (scene, options) = (Arc::clone(&shown.scene), shown.renderer.plan().options.clone());
            self.show(&scene, &options)?;
            return Ok(Drawn::Again);
        }
        if shown.target.is_none() {
            shown.fit(swapchain, turned(swapchain, self.pretended))?;
        }
        let Shown { renderer, recorded, target: Some(target), .. } = shown else { return Ok(Drawn::Nothing) };
        let pre_rotation = target.pre_rotation();
        let readback = shot.map(|path| Ok::<_, Error>((path, swapchain.readback()?))).transpose()?;
        if let Some(overlay) = overlay.as_mut().filter(|overlay| overlay.has_new_image()) {
            self.presenter.wait()?;
            overlay.set_image(renderer)?;
        }
        let stamps_ns = &mut self.stamps_ns;
        let mut prepared = Ok(());
        let presented = self.presenter.frame(swapchain, |recorder, slot, image| {
            prepared = prepare(renderer, slot, &mut recorded[slot], stamps_ns, overlay.as_deref());
            renderer.record(recorder, slot, target, image, view);
            if let Some((_, readback)) = &readback {
                swapchain.read(recorder, image, readback);
            }
        })?;
        prepared?;
        if readback.is_some() {
            self.presenter.wait()?;
        }
        match presented {
            Presented::Shown => {}
            // Some systems say so of every frame while the screen is turned.
            Presented::Suboptimal => self.is_outdated = swapchain.is_outdated()?,
            Presented::OutOfDate => {
                self.is_outdated = true;
                return Ok(Drawn::Again);
            }
            Presented::SurfaceLost => {
                self.suspend()?;
                return Ok(Drawn::Again);
            }
        }
        if let Some((path, readback)) = readback {
            swapchain.picture(&readback).upright(pre_rotation).write(path)?;
        }
        Ok(Drawn::Frame)
    }

    /// Writes what exists on the device as JSON.
    pub(super) fn write_live(&self, path: &Path) -> Result<()> {
        let json = serde_json::to_string(&self.host.device().live())
            .map_err(|e| Error::io(path, "write", e.into()))?;
        crate::file::write_whole(path, json.as_bytes())
    }

    /// Destroys all; what the validation layer said that it should not have.
    pub(super) fn close(mut self) -> Result<Vec<String>> {
        let waited = self.presenter.wait();
        let Self { shown, swapchain, surface, presenter, cache, host, window, excused, .. } = self;
        drop((shown, swapchain, surface, presenter, cache));
        let mut messages = host.finish();
        drop(window);
        messages.retain(|message| !excused.iter().any(|part| message.contains(part)));
        waited.map(|()| messages)
    }
}

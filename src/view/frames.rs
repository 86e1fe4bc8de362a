//! Frames to a window: its surface and images, made anew when they are lost or do not fit, and what is drawn to them.

use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use super::Viewer;
use super::compare::{Apart, Compare};
use super::overlay::Overlay;
use super::shown::Shown;
#[cfg(feature = "shader-compiler")]
use crate::gpu::shader::Modules;
use crate::gpu::{
    HeadlessOptions, PipelineCache, PresentMode, Presented, Presenter, Recorder, Renderer, Surface,
    Swapchain, Target, View, WindowHandles, WindowHost,
};
use crate::plan::{Limits, Options};
use crate::scene::{PreRotation, Scene, World};
use crate::{Error, Result};

/// A window's device and all that is made from it.
pub(super) struct Frames {
    // In order of destruction; `close` waits for the GPU first.
    /// All that is drawn for a frame, in order.
    shown: Vec<Shown>,
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
    over: Option<(&mut Overlay, &Target, &View<'_>)>,
) -> Result<()> {
    if std::mem::replace(is_recorded, true)
        && let Some(stamps) = renderer.query_results(slot)?.timestamps_ns
    {
        *stamps_ns = stamps;
    }
    over.map_or(Ok(()), |(overlay, target, view)| {
        overlay.outline(renderer, target, view);
        renderer.set_overlay(slot, &overlay.frame())
    })
}

/// Brings renderer and target to where the world is; what was the target, of which frames may be on the GPU, if there is another.
fn follow(
    shown: &mut Shown,
    before: Option<&Shown>,
    images: (&Swapchain, PreRotation),
    world: &World,
    recorder: &Recorder<'_>,
) -> Result<Option<Target>> {
    if world.changes().is_empty() || !shown.renderer.update(world, recorder)?.new_targets {
        return Ok(None);
    }
    let old = shown.target.take();
    shown.fit(images, before)?;
    Ok(old)
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
            ..HeadlessOptions::default()
        };
        let host = WindowHost::new(&options, &window)?;
        let cache = PipelineCache::load(host.device())?;
        let presenter = Presenter::new(host.device(), viewer.frames_in_flight)?;
        Ok(Self {
            shown: Vec::new(),
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

    /// What is shown, once something is; of two that are compared, the second.
    pub(super) fn shown(&self) -> Option<&Shown> {
        self.shown.last()
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
        self.shown.clear();
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
        // Frames go on to what was there; nothing waits for them.
        self.shown.iter_mut().for_each(|shown| self.presenter.retire(shown.take_images()));
        let made = Swapchain::new(&surface, window_size, self.mode, self.swapchain.as_ref());
        match (self.swapchain.take(), made) {
            (old, Err(error)) if Surface::is_lost(&error) => {
                self.presenter.wait()?;
                drop((old, surface));
                self.surface = None;
                return Ok(false);
            }
            (Some(old), Ok(Some(new))) => {
                self.swapchain = Some(new);
                self.presenter.retire_swapchain(old)?;
            }
            // No other has replaced it: the window can have a new one only when it is gone.
            (old, Ok(None)) => {
                self.presenter.wait()?;
                drop(old);
            }
            (old, made) => {
                self.swapchain = old;
                self.swapchain = made?;
            }
        }
        self.is_outdated = false;
        Ok(self.swapchain.is_some())
    }

    /// Shows a scene by some options from now on. What was shown goes on if that fails.
    pub(super) fn show(&mut self, scene: &Scene, options: &Options, compare: &Compare) -> Result<()> {
        let Some(swapchain) = &self.swapchain else {
            return Err(Error::unsupported("the window has no pixels", "make it larger"));
        };
        let (device, frames) = (self.host.device(), self.frames_in_flight);
        let images = (swapchain, turned(swapchain, self.pretended));
        let mut shown: Vec<Shown> = Vec::new();
        for options in compare.drawn(options)? {
            let before = shown.last();
            shown.push(Shown::new(device, &self.cache, scene, &options, images, frames, before)?);
        }
        self.cache.store();
        self.excused.extend(shown.iter().flat_map(|shown| &shown.excused));
        self.presenter.wait()?;
        self.shown = shown;
        self.shows += 1;
        self.stamps_ns.clear();
        Ok(())
    }

    /// Shows the same by other shader modules. What was shown goes on if that fails.
    #[cfg(feature = "shader-compiler")]
    pub(super) fn set_modules(
        &mut self,
        modules: Modules,
        scene: &Scene,
        options: &Options,
        compare: &Compare,
    ) -> Result<()> {
        let others = self.cache.with_modules(modules);
        let before = std::mem::replace(&mut self.cache, others);
        let shown = self.show(scene, options, compare);
        if shown.is_err() {
            self.cache = before;
        }
        shown
    }

    /// Whether what is shown is for images like these.
    pub(super) fn suits(&self) -> bool {
        self.swapchain.iter().all(|swapchain| self.shown.iter().all(|shown| shown.suits(swapchain)))
    }

    /// Draws a frame to images that [`Self::prepare`] has made, and reads it back if that is asked for.
    ///
    /// What it shows goes to where the world is, if that is the one that was shown last, and things have changed in it.
    pub(super) fn draw(
        &mut self,
        world: &World,
        view: &View<'_>,
        shot: Option<&Path>,
        mut overlay: Option<&mut Overlay>,
        compare: &Compare,
    ) -> Result<Drawn> {
        let Some(swapchain) = &self.swapchain else { return Ok(Drawn::Nothing) };
        let images = (swapchain, turned(swapchain, self.pretended));
        for index in 0..self.shown.len() {
            let (before, rest) = self.shown.split_at_mut(index);
            if rest[0].target.is_none() {
                rest[0].fit(images, before.last())?;
            }
        }
        let readback = shot.map(|path| Ok::<_, Error>((path, swapchain.readback()?))).transpose()?;
        if let Some(overlay) = overlay.as_mut().filter(|overlay| overlay.has_new_image()) {
            self.presenter.wait()?;
            let over = self.shown.iter_mut().filter(|shown| shown.renderer.plan().options.overlay);
            over.map(|shown| &mut shown.renderer).try_for_each(|renderer| overlay.set_image(renderer))?;
            overlay.image_is_set();
        }
        let (stamps_ns, shown, parts) =
            (&mut self.stamps_ns, &mut self.shown, compare.parts(images.1.size(swapchain.size())));
        let (mut prepared, mut replaced) = (Ok(()), Vec::new());
        let presented = self.presenter.frame(swapchain, |recorder, slot, image| {
            for (index, part) in (0..shown.len()).zip(parts) {
                let (before, rest) = shown.split_at_mut(index);
                let left = follow(&mut rest[0], before.last(), images, world, recorder);
                let output = rest[0].output(image);
                let Shown { renderer, recorded, target: Some(target), .. } = &mut rest[0] else { continue };
                let over = overlay.as_deref_mut().filter(|_| renderer.plan().options.overlay);
                let over = over.map(|overlay| (overlay, &*target, view));
                let ready = left.and_then(|old| {
                    replaced.extend(old);
                    prepare(renderer, slot, &mut recorded[slot], stamps_ns, over)
                });
                prepared = std::mem::replace(&mut prepared, Ok(())).and(ready);
                if renderer.created(target) {
                    renderer.record_part(recorder, slot, target, output, view, part);
                }
            }
            if let Some((_, readback)) = &readback {
                swapchain.read(recorder, image, readback);
            }
        })?;
        replaced.into_iter().for_each(|target| self.presenter.retire(target));
        if readback.is_some() {
            self.presenter.wait()?;
        }
        prepared?;
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
            swapchain.picture(&readback).upright(images.1).write(path)?;
        }
        Ok(Drawn::Frame)
    }

    /// Draws the two that are compared one after the other, each whole, and says how far they are apart; nothing without an image.
    pub(super) fn apart(&mut self, view: &View<'_>) -> Result<Option<Apart>> {
        let (Some(swapchain), [a, b]) = (&self.swapchain, &mut self.shown[..]) else { return Ok(None) };
        let pictures = [swapchain.readback()?, swapchain.readback()?];
        let mut is_drawn = false;
        self.presenter.frame(swapchain, |recorder, slot, image| {
            for (shown, picture) in [a, b].into_iter().zip(&pictures) {
                let Shown { renderer, recorded, target: Some(target), .. } = shown else { return };
                recorded[slot] = true;
                renderer.record(recorder, slot, target, image, view);
                swapchain.read(recorder, image, picture);
            }
            is_drawn = true;
        })?;
        self.presenter.wait()?;
        let [a, b] = pictures.each_ref().map(|picture| swapchain.picture(picture));
        Ok(is_drawn.then(|| Apart::new(&a, &b)))
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

//! The window's life: events of the system, scenes that are opened, frames.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, StartCause, TouchPhase, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::clock::Clock;
use super::compare::{Compare, Divider};
use super::course::Course;
use super::frames::{Drawn, Frames};
use super::hand::Hand;
use super::keys::Keys;
use super::outline::Outlines;
use super::overlay::Overlay;
use super::player::Player;
#[cfg(feature = "shader-compiler")]
use super::reload::Reload;
use super::rig::{Motion, Rig};
use super::scenes::Scenes;
use super::steps::Steps;
use super::{Viewer, no_window};
use crate::gpu::{PresentMode, View, WindowHandles};
use crate::scene::{Scene, World};
use crate::{Error, Result};

/// A viewer that runs.
pub(super) struct App {
    pub(super) viewer: Viewer,
    pub(super) world: World,
    /// Of a scene that moves.
    pub(super) player: Option<Player>,
    pub(super) open: Option<Open>,
    pub(super) rig: Rig,
    pub(super) course: Course,
    /// The file of the camera path that was recorded last.
    pub(super) recorded: Option<PathBuf>,
    pub(super) steps: Steps,
    #[cfg(feature = "shader-compiler")]
    pub(super) reload: Option<Reload>,
    /// What the script says of the window's size, where the system would not do it.
    pub(super) is_minimised: bool,
    /// The system has the window's surface.
    pub(super) is_suspended: bool,
    hand: Hand,
    keys: Keys,
    wake: EventLoopProxy<()>,
    loading: Option<Receiver<(PathBuf, Result<Scene>)>>,
    /// What was loaded and not shown yet.
    loaded: Option<(PathBuf, Scene)>,
    pub(super) is_occluded: bool,
    clock: Clock,
    /// What the user was told last.
    pub(super) message: RefCell<String>,
    pub(super) asks_help: bool,
    pub(super) outlines: Outlines,
    pub(super) scenes: Scenes,
    pub(super) compare: Compare,
    pub(super) divider: Divider,
    /// Why the window closes.
    failed: Option<Error>,
}

/// The window and what draws to it.
pub(super) struct Open {
    pub(super) frames: Frames,
    pub(super) window: Arc<Window>,
    /// While it is shown, and the [`Frames::shows`] whose renderer has its image.
    pub(super) overlay: Option<(Overlay, u64)>,
}

/// A file's name that is not taken.
pub(super) fn free_name(extension: &str) -> PathBuf {
    let name = |n: u32| PathBuf::from(format!("ontile-{n:04}.{extension}"));
    (1..10_000).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(10_000))
}

/// A frame plays no more seconds than this, however long the one before was.
const MOST_PLAYED_S: f64 = 1.0;

/// The number of the camera with this number or name.
fn camera_index(scene: &Scene, wanted: &str) -> Result<usize> {
    let camera = scene.camera(wanted)?;
    Ok(scene.cameras.iter().position(|one| std::ptr::eq(one, camera)).unwrap_or(0))
}

impl App {
    pub(super) fn new(mut viewer: Viewer, scene: Scene, wake: EventLoopProxy<()>) -> Result<Self> {
        let camera = camera_index(&scene, viewer.camera.as_deref().unwrap_or("0"))?;
        let rig = Rig::new(&scene, camera, Motion::Orbit);
        let Viewer { animation, time_s, script, .. } = &viewer;
        let player = Player::first(&scene, animation.as_deref(), *time_s, script.is_none())?;
        let steps = Steps::new(viewer.script.take());
        Ok(Self {
            rig,
            steps,
            player,
            course: viewer.flight.take().map(Course::flown).unwrap_or_default(),
            recorded: None,
            #[cfg(feature = "shader-compiler")]
            reload: viewer.glsl.take().map(Reload::of_folder),
            world: scene.into(),
            open: None,
            is_minimised: false,
            is_suspended: false,
            hand: Hand::default(),
            keys: Keys::default(),
            wake,
            loading: None,
            loaded: None,
            is_occluded: false,
            clock: Clock::new(),
            message: RefCell::default(),
            asks_help: false,
            outlines: Outlines::default(),
            scenes: Scenes::default(),
            compare: Compare::default(),
            divider: Divider::default(),
            failed: None,
            viewer,
        })
    }

    /// Destroys all, and says how it went.
    pub(super) fn finish(mut self) -> Result<()> {
        let written = self.end_course();
        let messages = self.open.take().map(|open| open.frames.close()).transpose();
        if let Some(error) = self.failed {
            return Err(error);
        }
        match messages?.unwrap_or_default().as_slice() {
            [] => written,
            all @ [first, ..] => Err(Error::unsupported(
                format!("the validation layer has {} messages, first: {first}", all.len()),
                "report this as a bug of ontile or of the driver",
            )),
        }
    }

    /// Reads a scene on another thread; the one that is shown goes on.
    pub(super) fn load(&mut self, path: &Path) {
        let (sender, receiver) = channel();
        let (load, wake, path) = (Arc::clone(&self.viewer.load), self.wake.clone(), path.to_owned());
        self.loading = Some(receiver);
        std::thread::spawn(move || {
            let scene = load(&path);
            // A window that was closed, or has been given another file, wants it no more.
            let _ = sender.send((path, scene));
            let _ = wake.send_event(());
        });
    }

    /// Whether a scene is on its way, and will be shown as things are.
    pub(super) fn is_loading(&self) -> bool {
        self.loading.is_some() || self.loaded.is_some() && self.is_drawn()
    }

    /// Whether the window has pixels, as far as a script has it.
    pub(super) fn is_drawn(&self) -> bool {
        !self.is_minimised && !self.is_suspended
    }

    /// Takes a scene that was loaded.
    fn take_loaded(&mut self) {
        let Some(receiver) = &self.loading else { return };
        match receiver.try_recv() {
            Ok((path, Ok(scene))) => self.loaded = Some((path, scene)),
            Ok((_, Err(error))) => self.tell(&error),
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => {
                self.tell_text("the scene could not be loaded: its loader panicked")
            }
        }
        self.loading = None;
    }

    /// Shows a scene that was loaded, or goes on with the one before.
    fn show_loaded(&mut self) {
        let Some((path, scene)) = self.loaded.take() else { return };
        let Some(open) = &mut self.open else { return };
        match open.frames.show(&scene, &self.viewer.options, &self.compare) {
            Ok(()) => {
                self.rig = Rig::new(&scene, 0, self.rig.motion);
                self.player = Player::new(&scene, !self.steps.is_script());
                (self.world, self.viewer.scene) = (scene.into(), path);
            }
            Err(error) => self.tell(&error),
        }
    }

    /// Looks from one of the scene's cameras.
    pub(super) fn set_camera(&mut self, wanted: &str) -> Result<()> {
        let index = camera_index(self.world.scene(), wanted)?;
        self.rig = Rig::new(self.world.scene(), index, self.rig.motion);
        Ok(())
    }

    pub(super) fn tell(&self, error: &Error) {
        self.tell_text(&error.to_string());
    }

    pub(super) fn tell_text(&self, text: &str) {
        self.message.replace(text.to_owned());
        (self.viewer.tell)(text);
    }

    fn create_window(&mut self, events: &ActiveEventLoop) -> Result<Open> {
        let [width, height] = self.viewer.options.size;
        let attributes = Window::default_attributes()
            .with_title(format!("{} - ontile", self.world.scene().name))
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(events.create_window(attributes).map_err(|e| no_window(&e))?);
        let handles: Arc<dyn WindowHandles> = Arc::clone(&window) as _;
        Ok(Open { frames: Frames::new(&self.viewer, handles)?, window, overlay: None })
    }

    /// Width and height of the window's inside, pixels.
    fn window_size(&self) -> [u32; 2] {
        match &self.open {
            Some(open) if !self.is_minimised => open.window.inner_size().into(),
            _ => [0; 2],
        }
    }

    /// Draws a frame, if there is something to draw to.
    fn draw(&mut self) -> Result<()> {
        let size = self.window_size();
        if self.is_suspended {
            self.steps.frame_passed();
            return Ok(());
        }
        let Some(open) = &mut self.open else { return Ok(()) };
        if !open.frames.prepare(size)? {
            self.steps.frame_passed();
            return Ok(());
        }
        if open.frames.shown().is_none() || !open.frames.suits() {
            self.show_first()?;
        }
        self.show_loaded();
        #[cfg(feature = "shader-compiler")]
        self.take_modules();
        let seconds = self.clock.begin();
        let flight = self.keys.flight();
        if flight != glam::Vec3::ZERO {
            self.rig.fly(flight * seconds.min(0.1));
        }
        self.play(f64::from(seconds).min(MOST_PLAYED_S));
        self.steer(f64::from(seconds));
        self.lay_out(seconds);
        let Some(open) = &mut self.open else { return Ok(()) };
        let overlay = open.overlay.as_mut().map(|(overlay, _)| overlay);
        let view = View { camera: &self.rig.camera, exposure_ev: self.viewer.exposure_ev };
        let shot = self.steps.shot();
        open.window.pre_present_notify();
        match open.frames.draw(&self.world, &view, shot, overlay, &self.compare)? {
            Drawn::Frame => {
                self.world.clear_changes();
                self.steps.frame_drawn();
                let refresh = self.refresh();
                let gpu_ns = self.open.as_ref().and_then(|open| open.frames.stamps_ns().last());
                self.clock.drawn(gpu_ns.map(|ns| Duration::from_secs_f64(ns * 1e-9)), refresh);
                self.show_rate();
            }
            Drawn::Nothing => self.steps.frame_passed(),
            Drawn::Again => {}
        }
        Ok(())
    }

    /// Between two refreshes of the screen; what most have where the system does not tell.
    fn refresh(&self) -> Duration {
        let monitor = self.open.as_ref().and_then(|open| open.window.current_monitor());
        let millihertz = monitor.and_then(|m| m.refresh_rate_millihertz()).filter(|rate| *rate > 0);
        Duration::from_secs_f64(1e3 / f64::from(millihertz.unwrap_or(60_000)))
    }

    /// Tells the time of a frame in the title, twice a second.
    fn show_rate(&mut self) {
        let Some(open) = &self.open else { return };
        let Some(ms) = self.clock.tell_ms() else { return };
        open.window.set_title(&format!("{} - ontile - {ms:.1} ms", self.world.scene().name));
    }

    pub(super) fn fail(&mut self, error: Error, events: &ActiveEventLoop) {
        self.failed.get_or_insert(error);
        events.exit();
    }

    /// The system gives the window its surface, for the first time or again.
    pub(super) fn resume(&mut self, events: &ActiveEventLoop) {
        self.is_suspended = false;
        if self.open.is_none() {
            match self.create_window(events) {
                Ok(open) => self.open = Some(open),
                Err(error) => self.fail(error, events),
            }
        }
    }

    /// The system takes the surface.
    pub(super) fn suspend(&mut self, events: &ActiveEventLoop) {
        self.is_suspended = true;
        self.hand.release();
        self.keys.release();
        if let Some(open) = &mut self.open
            && let Err(error) = open.frames.suspend()
        {
            self.fail(error, events);
        }
    }
}

impl ApplicationHandler for App {
    fn new_events(&mut self, _: &ActiveEventLoop, _: StartCause) {
        self.take_loaded();
    }

    fn resumed(&mut self, events: &ActiveEventLoop) {
        self.resume(events);
    }

    fn suspended(&mut self, events: &ActiveEventLoop) {
        self.suspend(events);
    }

    fn memory_warning(&mut self, events: &ActiveEventLoop) {
        self.give_back(events);
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let height_px = f64::from(self.window_size()[1]);
        let is_taken = match &mut self.open {
            Some(Open { window, overlay: Some((overlay, _)), .. }) => overlay.event(window, &event),
            _ => false,
        };
        let is_divider = !is_taken && self.drag_divider(&event);
        if !(is_taken || is_divider) || is_release(&event) {
            self.hand.event(&event, self.keys.shift(), height_px, &mut self.rig);
        }
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                self.open.iter_mut().for_each(|open| open.frames.outdate());
            }
            WindowEvent::Occluded(is_occluded) => self.is_occluded = is_occluded,
            WindowEvent::Focused(false) => self.keys.release(),
            WindowEvent::DroppedFile(path) if path.extension().is_some_and(|e| e == "flight") => {
                self.fly(&path).unwrap_or_else(|error| self.tell(&error));
            }
            WindowEvent::DroppedFile(path) => self.load(&path),
            WindowEvent::KeyboardInput { event, .. } if !is_taken || !event.state.is_pressed() => {
                if let Some(wish) = self.keys.event(&event) {
                    self.wish(wish, events);
                }
            }
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.draw() {
                    self.fail(error, events);
                }
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        if self.failed.is_some() {
            return;
        }
        if let Err(error) = self.run_steps(events) {
            return self.fail(error, events);
        }
        let is_seen = !self.is_occluded && !self.is_suspended && !self.window_size().contains(&0);
        let draws = is_seen || self.steps.are_left();
        let next = self.clock.next();
        let is_paced = self.viewer.present == PresentMode::Fifo && !self.steps.are_left();
        if draws && is_paced && next > Instant::now() {
            return events.set_control_flow(ControlFlow::WaitUntil(next));
        }
        events.set_control_flow(if draws { ControlFlow::Poll } else { ControlFlow::Wait });
        if let Some(open) = self.open.as_ref().filter(|_| draws) {
            open.window.request_redraw();
        }
    }
}

/// Whether something is let go of, which whoever holds it wants to know.
fn is_release(event: &WindowEvent) -> bool {
    match event {
        WindowEvent::MouseInput { state, .. } => *state == ElementState::Released,
        WindowEvent::Touch(touch) => matches!(touch.phase, TouchPhase::Ended | TouchPhase::Cancelled),
        _ => false,
    }
}

//! A window that shows a scene: an app for programs of the desktop and of phones.
//!
//! The app owns window, device and frames, and draws straight into the window's images. A program gives it a [`Viewer`] and, where
//! the system asks for that, the event loop; it comes back when the window is closed.
//!
//! ```no_run
//! use ontile::view::Viewer;
//!
//! # fn main() -> ontile::Result<()> {
//! Viewer::new("scene.glb").run()
//! # }
//! ```

#[cfg(all(feature = "android", target_os = "android"))]
mod android;
mod app;
mod clock;
mod compare;
mod course;
mod frames;
mod hand;
mod interface;
mod keys;
mod outline;
mod overlay;
mod panels;
mod player;
#[cfg(any(test, feature = "shader-compiler"))]
mod reload;
mod rig;
mod scenes;
mod script;
mod shown;
mod steps;
mod wireframe;
mod wishes;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use winit::event_loop::EventLoop;

pub use crate::gpu::PresentMode;
pub use keys::HELP;
pub use script::Script;

use crate::environment::{Cache, DEFAULT_FACE_SIZE, TexelFormat};
use crate::plan::Options;
use crate::scene::{Flight, Scene};
use crate::{Error, Result};

/// How a scene file becomes a scene, on any thread.
pub type Load = Arc<dyn Fn(&Path) -> Result<Scene> + Send + Sync>;

/// The files of all scenes that can be opened, beside the one that is; some may be made only when they are loaded.
pub type List = Arc<dyn Fn(&Path) -> Vec<PathBuf> + Send + Sync>;

/// What is shown, and how. [`Viewer::run`] shows it.
pub struct Viewer {
    /// The scene's file.
    pub scene: PathBuf,
    /// Reads it, and those that are opened later.
    pub load: Load,
    /// What the panel "Scenes" lists: by default the `.glb` and `.gltf` files of the open one's folder.
    pub list: List,
    /// How the frame is built, and whether the overlay is shown. `size` is the window's at first, in pixels; what concerns the output follows from the window.
    pub options: Options,
    /// Stops.
    pub exposure_ev: f32,
    /// The camera to begin with, by its number or name; the first by default.
    pub camera: Option<String>,
    /// The animation to begin with, by its number or name, or `all` at once; the first by default.
    pub animation: Option<String>,
    /// Where in it the scene stands to begin with, seconds. By default it is played from its begin, unless there is a script.
    pub time_s: Option<f64>,
    /// Flown to begin with.
    pub flight: Option<Flight>,
    /// A folder of GLSL whose changes are drawn with: what has changed is compiled while frames go on.
    #[cfg(feature = "shader-compiler")]
    pub glsl: Option<PathBuf>,
    /// When frames are shown.
    pub present: PresentMode,
    /// Frames on the GPU at a time, at least 1.
    pub frames_in_flight: usize,
    /// Take the first device whose name or driver contains this.
    pub device: Option<String>,
    /// Run under the Khronos validation layer; any message of it is a failure.
    pub validate: bool,
    /// Done in the place of a user.
    pub script: Option<Script>,
    /// Tells the user what went wrong, or was done.
    pub tell: Box<dyn Fn(&str)>,
}

impl Viewer {
    /// Shows a scene with default options and the overlay.
    pub fn new(scene: impl Into<PathBuf>) -> Self {
        let load = |path: &Path| {
            let mut scene = Scene::load_moving(path)?;
            for environment in scene.environments_mut() {
                environment.prefilter(DEFAULT_FACE_SIZE, TexelFormat::E5B9G9R9, Cache::of_user().as_ref());
            }
            Ok(scene)
        };
        Self {
            scene: scene.into(),
            load: Arc::new(load),
            list: Arc::new(scenes::beside),
            options: Options { overlay: true, ..Options::default() },
            exposure_ev: 0.0,
            camera: None,
            animation: None,
            time_s: None,
            flight: None,
            #[cfg(feature = "shader-compiler")]
            glsl: None,
            present: PresentMode::Fifo,
            frames_in_flight: 2,
            device: None,
            validate: false,
            script: None,
            tell: Box::new(|message| log::warn!("{message}")),
        }
    }

    /// Opens the window, and returns when it is closed.
    ///
    /// # Errors
    /// What loading the scene, making the device and drawing may say; [`Error::Unsupported`] where no window can be opened, or
    /// if the validation layer said something.
    ///
    /// # Panics
    /// As [`EventLoop::new`]: when called from another thread than the main one, where the system does not allow that.
    pub fn run(self) -> Result<()> {
        let events = EventLoop::new().map_err(|e| no_window(&e))?;
        self.run_on(events)
    }

    /// As [`Self::run`], with the system's event loop.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn run_on(self, events: EventLoop<()>) -> Result<()> {
        let scene = (self.load)(&self.scene)?;
        // A camera or an animation that is not there is told before there is a window.
        let mut app = app::App::new(self, scene, events.create_proxy())?;
        let ran = events.run_app(&mut app).map_err(|e| no_window(&e));
        let done = app.finish();
        ran.and(done)
    }
}

fn no_window(error: &dyn std::error::Error) -> Error {
    // Before the reason winit says where in its source it is.
    let told = error.to_string();
    let reason = told.rsplit(": ").next().unwrap_or(&told).trim_end_matches('.');
    Error::unsupported(
        format!("no window can be opened: {reason}"),
        "run in a desktop session (X11 or Wayland), or use 'ontile render'",
    )
}

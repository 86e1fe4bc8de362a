//! Light from far away in all directions.

use std::path::Path;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use crate::Result;
use crate::environment::{self, Cache, Content, Panorama, Prefiltered, TexelFormat};

/// Radiance that arrives from each direction alike everywhere.
#[derive(Clone, Debug)]
pub struct Environment {
    /// A name for messages: the file's, or what the builder chose.
    pub name: String,
    /// The picture; `None` where only what was filtered from it is at hand.
    pub panorama: Option<Arc<Panorama>>,
    /// What shading looks up; a renderer makes it from the panorama where it is `None` or stored in another format than
    /// the options ask for. See [`environment::cached`].
    pub prefiltered: Option<Arc<Prefiltered>>,
    /// How far the environment is turned about +Y, in degrees: at 90 its centre, which lies towards +Z at 0, lies towards
    /// +X.
    pub rotation_deg: f32,
    /// Multiplies its radiance.
    pub intensity: f32,
}

impl Environment {
    /// A panorama as it is.
    pub fn new(name: impl Into<String>, panorama: Panorama) -> Self {
        Self {
            name: name.into(),
            panorama: Some(Arc::new(panorama)),
            prefiltered: None,
            rotation_deg: 0.0,
            intensity: 1.0,
        }
    }

    /// Reads a panorama (.hdr, .exr) or a prefiltered environment (.ktx2), told apart by their content.
    ///
    /// # Errors
    /// As [`environment::read`].
    pub fn load(path: &Path) -> Result<Self> {
        let name = path.file_name().map_or("environment".into(), |name| name.to_string_lossy().into_owned());
        let (panorama, prefiltered) = match environment::read(path)? {
            Content::Panorama(panorama) => (Some(Arc::new(panorama)), None),
            Content::Prefiltered(prefiltered) => (None, Some(Arc::new(prefiltered))),
        };
        Ok(Self { name, panorama, prefiltered, rotation_deg: 0.0, intensity: 1.0 })
    }

    /// Filters the panorama, or reads what `cache` has of it, unless something was made of it already or nothing is needed.
    ///
    /// # Panics
    /// If `face_size` is none of [`environment::FACE_SIZES`].
    pub fn prefilter(&mut self, face_size: u32, format: TexelFormat, cache: Option<&Cache>) {
        if self.prefiltered.is_none() && !self.is_dark() {
            let made = self.panorama.as_ref().map(|p| environment::cached(p, face_size, format, cache));
            self.prefiltered = made.map(Arc::new);
        }
    }

    /// What is wrong if its brightest radiance times its intensity exceeds [`environment::MAX_RADIANCE_NT`].
    pub fn too_bright(&self) -> Option<String> {
        let panorama = self.panorama.as_ref().map(|p| p.brightest_nt());
        let prefiltered = || self.prefiltered.as_ref().map(|p| p.brightest_nt());
        let radiance = panorama.or_else(prefiltered).unwrap_or(0.0);
        // What was filtered of a panorama at the limit may have been rounded up.
        let most = f64::from(environment::MAX_RADIANCE_NT) * 1.01;
        (f64::from(radiance) * f64::from(self.intensity) > most).then(|| {
            format!(
                "makes the environment's brightest texel, {radiance:e} cd/m², {:e} times as bright, but at most {:e} cd/m² are supported",
                self.intensity,
                environment::MAX_RADIANCE_NT
            )
        })
    }

    /// Whether it adds nothing anywhere.
    pub fn is_dark(&self) -> bool {
        self.intensity == 0.0
    }

    /// Turns a direction of the world into the environment's own space.
    pub fn environment_from_world(&self, direction_world: DVec3) -> DVec3 {
        DQuat::from_rotation_y(-f64::from(self.rotation_deg).to_radians()) * direction_world
    }
}

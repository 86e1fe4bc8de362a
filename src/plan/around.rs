//! Light that arrives from all around, besides that of light sources.

use serde::Serialize;

use super::{Needs, Options};
use crate::environment::{DEFAULT_FACE_SIZE, TexelFormat, level_count, split_sum};
use crate::scene::Scene;

/// What a lit surface receives from all around. Each kind includes those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Around {
    /// Nothing.
    #[default]
    Nothing,
    /// The same radiance from everywhere.
    Ambient,
    /// Radiance by direction.
    Environment,
}

impl Around {
    /// What the surfaces of a scene receive.
    pub fn of(scene: &Scene) -> Self {
        if scene.environment.as_ref().is_some_and(|e| !e.is_dark()) {
            Self::Environment
        } else if scene.ambient_nt != glam::Vec3::ZERO {
            Self::Ambient
        } else {
            Self::Nothing
        }
    }

    /// Whether there is any.
    pub const fn any(self) -> bool {
        !matches!(self, Self::Nothing)
    }
}

/// A scene's environment, as far as a plan depends on it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EnvironmentNeed {
    /// The environment's name.
    pub name: String,
    /// Texels and edge of what was filtered already; it is used as it is.
    pub prefiltered: Option<(TexelFormat, u32)>,
}

impl EnvironmentNeed {
    /// Of a scene whose environment is not dark.
    pub(super) fn of(scene: &Scene) -> Option<Self> {
        let environment = scene.environment.as_ref().filter(|e| !e.is_dark())?;
        let prefiltered = environment.prefiltered.as_ref().map(|p| (p.format(), p.face_size()));
        Some(Self { name: environment.name.clone(), prefiltered })
    }
}

/// An image that surfaces sample wherever they are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AroundImage {
    /// Name in plans and reports.
    pub name: &'static str,
    /// Texels along the edges of the largest level.
    pub size: [u32; 2],
    /// Faces; 1 for a plain image.
    pub faces: u32,
    /// Mip levels.
    pub levels: u32,
    /// How texels are stored.
    pub format: &'static str,
    /// Of all levels and faces.
    pub bytes: u64,
    /// The scene element that needs it.
    pub why: String,
}

/// The table of albedos, the cube of radiance and the lightmap, where the scene needs them.
pub(super) fn images(needs: &Needs, options: &Options) -> Vec<AroundImage> {
    let side = split_sum::SIZE as u32;
    let first = needs.kinds.iter().find(|n| n.kind.around.any());
    let mut images = Vec::new();
    images.extend(first.map(|first| AroundImage {
        name: "split_sum",
        size: [side; 2],
        faces: 1,
        levels: 1,
        format: "rg16_float",
        bytes: split_sum::TABLE.len() as u64,
        why: format!("{} reflects light from all around", first.why),
    }));
    images.extend(needs.environment.as_ref().map(|environment| {
        let (format, size) = environment_texels(environment, options);
        let levels = level_count(size);
        let texels: u64 = (0..levels).map(|level| 6 * u64::from(size >> level).pow(2)).sum();
        AroundImage {
            name: "radiance",
            size: [size; 2],
            faces: 6,
            levels,
            format: format.name(),
            bytes: texels * format.bytes() as u64,
            why: format!(
                "environment '{}'{}",
                environment.name,
                if needs.sky { ", seen as sky too" } else { "" }
            ),
        }
    }));
    images.extend(needs.lightmap.map(|map| {
        let format = options.lightmap_format;
        AroundImage {
            name: "lightmap",
            size: map.size,
            faces: 1,
            levels: 1,
            format: format.name(),
            bytes: u64::from(map.size[0]) * u64::from(map.size[1]) * format.bytes() as u64,
            why: "diffuse light on surfaces that do not move".into(),
        }
    }));
    images
}

/// Format and edge of the cube.
pub(super) fn environment_texels(environment: &EnvironmentNeed, options: &Options) -> (TexelFormat, u32) {
    environment.prefiltered.unwrap_or((options.environment_format, DEFAULT_FACE_SIZE))
}

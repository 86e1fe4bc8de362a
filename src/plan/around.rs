//! Light that arrives from all around, besides that of light sources.

use serde::Serialize;

use super::{Brdf, KindNeed, Needs, Options};
use crate::environment::{DEFAULT_FACE_SIZE, TexelFormat, level_count, split_sum};
use crate::scene::{Environment, Scene};
use crate::{Error, Result};

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
    /// Radiance by direction, other inside boxes.
    Probes,
}

impl Around {
    /// What the surfaces of a scene receive.
    pub fn of(scene: &Scene) -> Self {
        if !scene.probes.is_empty() {
            Self::Probes
        } else if scene.environment.as_ref().is_some_and(|e| !e.is_dark()) {
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

/// An environment, as far as a plan depends on it: the scene's, or what a probe captured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EnvironmentNeed {
    /// The environment's name.
    pub name: String,
    /// Texels and edge of what was filtered already; it is used as it is.
    pub prefiltered: Option<(TexelFormat, u32)>,
}

impl EnvironmentNeed {
    pub(super) fn new(environment: &Environment) -> Self {
        let prefiltered = environment.prefiltered.as_ref().map(|p| (p.format(), p.face_size()));
        Self { name: environment.name.clone(), prefiltered }
    }
}

/// An image that surfaces sample wherever they are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AroundImage {
    /// Name in plans and reports.
    pub name: &'static str,
    /// Texels along the edges of the largest level.
    pub size: [u32; 2],
    /// Cubes; 0 for a plain image.
    pub cubes: u32,
    /// Mip levels.
    pub levels: u32,
    /// How texels are stored.
    pub format: &'static str,
    /// Of all levels and faces.
    pub bytes: u64,
    /// The scene element that needs it.
    pub why: String,
}

/// The table of albedos, which a fit may stand in for, the cube of radiance and the lightmap, where the scene needs them.
pub(super) fn images(needs: &Needs, options: &Options) -> Vec<AroundImage> {
    let side = split_sum::SIZE as u32;
    let reflects = |n: &&KindNeed| n.kind.around.any() || (needs.painted_around.any() && !n.kind.unlit);
    let first = needs.kinds.iter().find(reflects);
    let first = first.filter(|_| options.brdf != Brdf::Fitted);
    let mut images = Vec::new();
    images.extend(first.map(|first| AroundImage {
        name: "split_sum",
        size: [side; 2],
        cubes: 0,
        levels: 1,
        format: "rg16_float",
        bytes: split_sum::TABLE.len() as u64,
        why: format!("{} reflects light from all around", first.why),
    }));
    images.extend(environment_texels(needs, options).map(|(format, size)| {
        let levels = level_count(size);
        let texels: u64 = (0..levels).map(|level| 6 * u64::from(size >> level).pow(2)).sum();
        let cubes = needs.probes.len() + usize::from(needs.environment.is_some());
        let probe = needs.probes.iter().map(|probe| format!("probe '{}'", probe.name));
        let sky = if needs.sky { ", seen as sky too" } else { "" };
        let environment = needs.environment.iter().map(|e| format!("environment '{}'{sky}", e.name));
        AroundImage {
            name: "radiance",
            size: [size; 2],
            cubes: cubes as u32,
            levels,
            format: format.name(),
            bytes: texels * format.bytes() as u64 * cubes as u64,
            why: environment.chain(probe).collect::<Vec<_>>().join(", "),
        }
    }));
    images.extend(needs.lightmap.map(|map| {
        let format = options.lightmap_format;
        AroundImage {
            name: "lightmap",
            size: map.size,
            cubes: 0,
            levels: 1,
            format: format.name(),
            bytes: u64::from(map.size[0]) * u64::from(map.size[1]) * format.bytes() as u64,
            why: "diffuse light on surfaces that do not move".into(),
        }
    }));
    images
}

/// Format and edge of all cubes: those of what was filtered already, else what the options ask for.
pub(super) fn environment_texels(needs: &Needs, options: &Options) -> Option<(TexelFormat, u32)> {
    let mut all = needs.probes.iter().chain(&needs.environment).peekable();
    all.peek()?;
    Some(all.find_map(|e| e.prefiltered).unwrap_or((options.environment_format, DEFAULT_FACE_SIZE)))
}

/// # Errors
/// [`Error::Unsupported`] if what was filtered already is of different kinds: one texture holds all of it.
pub(super) fn check(needs: &Needs) -> Result<()> {
    let all = needs.probes.iter().chain(&needs.environment);
    let mut filtered = all.filter_map(|e| Some((e.prefiltered?, &e.name)));
    let Some((first, of)) = filtered.next() else { return Ok(()) };
    match filtered.find(|(other, _)| *other != first) {
        None => Ok(()),
        Some((other, name)) => Err(Error::unsupported(
            format!(
                "'{of}' was filtered to {} of {} texels and '{name}' to {} of {}, but one texture holds all environments",
                first.0, first.1, other.0, other.1
            ),
            "filter all with the same --size and --environment-format",
        )),
    }
}

//! Particles: the kinds that a scene has.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{SurfaceKind, element};
use crate::scene::{Particles, Scene, TextureRef};

/// The slot of materials that particles sample: what they emit.
const EMISSIVE: usize = 4;

/// What sets pipelines of particles apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ParticleKind {
    /// Whether the emissive texture is sampled.
    pub texture: bool,
    /// Whether its texture coordinates are transformed.
    pub transformed: bool,
}

impl ParticleKind {
    /// Of particles; `None` if there is nothing to see of them.
    ///
    /// # Panics
    /// If their material is none of the scene's.
    pub fn new(scene: &Scene, particles: &Particles) -> Option<Self> {
        let material = &scene.materials[particles.material];
        let texture = material.emissive_texture;
        let transforms = |t: TextureRef| t.uv_from_texcoord != TextureRef::IDENTITY;
        let kind = Self { texture: texture.is_some(), transformed: texture.is_some_and(transforms) };
        particles.shine(material).then_some(kind)
    }

    /// The same as of a surface whose material is used like this.
    pub fn surface(&self) -> SurfaceKind {
        SurfaceKind::of_decal(u8::from(self.texture) << EMISSIVE, u8::from(self.transformed) << EMISSIVE)
    }
}

impl std::fmt::Display for ParticleKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match (self.texture, self.transformed) {
            (false, _) => "plain",
            (true, false) => "textured",
            (true, true) => "textured (transformed)",
        })
    }
}

/// One kind of particles, and the scene elements that need it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParticleNeed {
    /// What the pipeline must do.
    pub kind: ParticleKind,
    /// How many particles of it there may be.
    pub particles: usize,
    /// The first element of [`Scene::particles`] that needs it.
    pub why: String,
}

/// The kinds of particles of a scene.
pub(super) fn of(scene: &Scene) -> Vec<ParticleNeed> {
    let mut kinds: BTreeMap<ParticleKind, ParticleNeed> = BTreeMap::new();
    for (index, particles) in scene.particles.iter().enumerate() {
        let Some(kind) = ParticleKind::new(scene, particles) else { continue };
        let why = || element("particles", &particles.name, index);
        kinds.entry(kind).or_insert_with(|| ParticleNeed { kind, particles: 0, why: why() }).particles +=
            particles.most;
    }
    kinds.into_values().collect()
}

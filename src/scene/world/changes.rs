//! What was done to a world.

/// What was done to a [`World`](super::World) since somebody last looked: what must be looked at again, and what is as it was.
///
/// Of values that changed it holds places, each once or more often; it grows with the first frames and not with later ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Instances that only stand elsewhere.
    pub(crate) instances: Vec<usize>,
    /// Lights that have other numbers.
    pub(crate) lights: Vec<usize>,
    /// Decals likewise.
    pub(crate) decals: Vec<usize>,
    /// Lists of particles that are others.
    pub(crate) particles: Vec<usize>,
    /// Meshes that are posed otherwise.
    pub(crate) poses: Vec<usize>,
    /// Meshes that came, or have other contents.
    pub(crate) meshes: Vec<usize>,
    /// Pictures likewise.
    pub(crate) images: Vec<usize>,
    /// Environment, probes, ambient light, background, fog.
    pub(crate) surroundings: bool,
    /// More than the above: elements came or went, or look different.
    pub(crate) elements: bool,
}

impl Changes {
    /// Whether nothing was done.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether more was done than moving instances, posing meshes and changing the numbers of lights, decals and particles: a renderer makes new objects
    /// then.
    pub fn is_structural(&self) -> bool {
        self.elements || self.surroundings
    }

    /// Forgets, and keeps its memory.
    pub(super) fn clear(&mut self) {
        let Self { instances, lights, decals, particles, poses, meshes, images, surroundings, elements } =
            self;
        [instances, lights, decals, particles, poses, meshes, images].into_iter().for_each(Vec::clear);
        (*surroundings, *elements) = (false, false);
    }

    /// Adds a place, unless it came last: what changes many times between two looks is there once.
    pub(in crate::scene) fn note(places: &mut Vec<usize>, index: usize) {
        if places.last() != Some(&index) {
            places.push(index);
        }
    }
}

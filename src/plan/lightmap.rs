//! Lightmaps: which surfaces have one.

use serde::Serialize;

use super::{Around, DecalKind};
use crate::scene::{Instance, Scene};

/// Where a mesh's TEXCOORD_1 leads to a lightmap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LightmapUse {
    /// No instance of the mesh has a part of the lightmap.
    #[default]
    Nowhere,
    /// Other instances of the mesh have one: the vertices carry TEXCOORD_1 all the same.
    Elsewhere,
    /// This instance has one.
    Here,
}

/// A scene's lightmap, as far as a plan depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LightmapNeed {
    /// Width and height in texels.
    pub size: [u32; 2],
    /// [`Lightmap::unit_lx`](crate::scene::Lightmap::unit_lx).
    pub unit_lx: f32,
}

impl LightmapNeed {
    pub(super) fn of(scene: &Scene) -> Option<Self> {
        scene.lightmap.as_ref().map(|map| Self { size: [map.width, map.height], unit_lx: map.unit_lx })
    }
}

/// What the kinds of all surfaces of a scene depend on.
pub struct SceneKinds<'a> {
    pub(super) scene: &'a Scene,
    pub(super) around: Around,
    /// Whether decals change what opaque surfaces reflect of it, so that it is added once these are painted.
    pub(super) is_painted: bool,
    /// Of each mesh, whether an instance of it has a part of the lightmap.
    lightmapped: Vec<bool>,
}

impl<'a> SceneKinds<'a> {
    /// Of a scene.
    pub fn new(scene: &'a Scene) -> Self {
        let mut kinds = Self {
            scene,
            around: Around::of(scene),
            is_painted: false,
            lightmapped: vec![false; scene.meshes.len()],
        };
        for instance in scene.drawn_instances().filter(|i| has_part(scene, i)) {
            kinds.lightmapped[instance.mesh] = true;
        }
        // Where a lightmap has the diffuse part of it, only geometry knows.
        let paints = scene.decals.iter().any(|decal| DecalKind::new(scene, decal).is_some());
        kinds.is_painted = paints && kinds.around.any() && !kinds.lightmapped.contains(&true);
        kinds
    }

    pub(super) fn lightmap_of(&self, instance: &Instance) -> LightmapUse {
        match self.lightmapped[instance.mesh] {
            false => LightmapUse::Nowhere,
            true if has_part(self.scene, instance) => LightmapUse::Here,
            true => LightmapUse::Elsewhere,
        }
    }
}

/// Whether an instance is lit by the scene's lightmap.
fn has_part(scene: &Scene, instance: &Instance) -> bool {
    let mesh = &scene.meshes[instance.mesh];
    scene.lightmap.is_some()
        && instance.lightmap.is_some()
        && !mesh.texcoords[1].is_empty()
        && !scene.materials[mesh.material].unlit
}

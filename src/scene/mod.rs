//! What is to be drawn: meshes, materials, lights and cameras as plain data.
//!
//! World space is right-handed with +Y up, in metres. Colours are linear Rec.709. A scene can be loaded from
//! glTF ([`Scene::load`]) or built by hand; nothing here knows about Vulkan.

mod block_decoder;
mod budget;
mod camera;
mod check;
mod decal;
mod deformation;
mod environment;
mod globe_layers;
mod gltf;
mod ktx;
mod light;
mod lightmap;
mod material;
mod mesh;
mod mipmaps;
mod motion;
mod particles;
mod pre_rotation;
mod probe;
mod surroundings;
mod texels;
mod transmission;
mod world;

pub use camera::{Camera, Projection};
#[cfg(feature = "capi")]
pub(crate) use check::Checked;
pub use decal::{Decal, DecalChannels};
#[cfg(feature = "measure")]
pub(crate) use deformation::Posed;
pub(crate) use deformation::PosedBounds;
pub use deformation::{Deformation, Influence, MorphTarget, Pose};
pub use environment::Environment;
pub use globe_layers::GlobeLayers;
#[cfg(feature = "measure")]
pub(crate) use gltf::edit;
pub use light::{GlobeMap, GlobePicture, Light, LightKind, Shadow};
pub use lightmap::{Lightmap, LightmapRect};
pub use material::{AlphaMode, Image, Material, Sampler, Texture, TextureRef, Wrap};
pub use mesh::{Aabb, Instance, Mesh};
pub use mipmaps::{MipLevel, mip_level_count, mipmaps};
pub use motion::{
    Animation, Channel, Follower, Follows, Interpolation, Motion, Node, NodeTransform, Play, Property, Skin,
};
pub use particles::{Particle, Particles};
pub use pre_rotation::PreRotation;
pub use probe::Probe;
pub use surroundings::{Background, Fog, FogHeight};
pub(crate) use texels::level_size;
pub use texels::{AstcBlock, Stored, Texels, TextureFormat};
pub use transmission::Transmission;
pub use world::{Changes, Element, Id, World};

use glam::Vec3;

/// Everything that a frame shows.
///
/// Indices between the lists (`Instance::mesh`, `Mesh::material`, `TextureRef::texture`, `Texture::image`) are
/// always in range for a scene that [`Scene::load`] returned.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// A name for messages and reports: the file's stem, or what the builder chose.
    pub name: String,
    /// Triangle lists with one material each (one glTF primitive).
    pub meshes: Vec<Mesh>,
    /// Placements of meshes in the world.
    pub instances: Vec<Instance>,
    /// Surface descriptions.
    pub materials: Vec<Material>,
    /// Image and sampler pairs that materials refer to.
    pub textures: Vec<Texture>,
    /// Decoded pictures.
    pub images: Vec<Image>,
    /// Lights without extent.
    pub lights: Vec<Light>,
    /// Whether `lights` are those that [`Scene::load`] adds where a file has none.
    pub has_default_lights: bool,
    /// Radiance that arrives from every direction alike, in cd/m², linear Rec.709. Zero means none.
    pub ambient_nt: Vec3,
    /// Diffuse light that was computed ahead for the surfaces of instances that have a part of it.
    ///
    /// It is all the diffuse light that static things bring, so these surfaces get no other diffuse light of `ambient_nt` and
    /// the environment (their specular light stays), and [baked](Light::baked) lights shine no more.
    pub lightmap: Option<Lightmap>,
    /// What is seen where there is no surface.
    pub background: Background,
    /// Between the surfaces and the viewer.
    pub fog: Option<Fog>,
    /// Radiance from far away, in addition to `ambient_nt`.
    pub environment: Option<Environment>,
    /// What glossy surfaces reflect inside boxes.
    pub probes: Vec<Probe>,
    /// What is painted over surfaces.
    pub decals: Vec<Decal>,
    /// Light without surfaces.
    pub particles: Vec<Particles>,
    /// View points. [`Scene::load`] always gives at least one.
    pub cameras: Vec<Camera>,
    /// What moves of all this, and how; `None`: nothing does by itself.
    pub motion: Option<Motion>,
    /// What the loader had to leave out or change, one sentence each.
    pub warnings: Vec<String>,
}

impl Scene {
    /// The bounds of all instances in world space; `None` if nothing is drawn.
    pub fn bounds_world(&self) -> Option<Aabb> {
        let shown = self.instances.iter().filter(|i| !i.hidden);
        shown
            .filter_map(|i| Some(self.meshes[i.mesh].bounds()?.transformed(&i.world_from_object)))
            .reduce(|a, b| a.union(&b))
    }

    /// The environment and what probes captured.
    pub fn environments(&self) -> impl Iterator<Item = &Environment> {
        self.probes.iter().map(|probe| &probe.environment).chain(&self.environment)
    }

    /// As [`Self::environments`].
    pub fn environments_mut(&mut self) -> impl Iterator<Item = &mut Environment> {
        self.probes.iter_mut().map(|probe| &mut probe.environment).chain(&mut self.environment)
    }

    /// The instances that have triangles to draw.
    pub(crate) fn drawn_instances(&self) -> impl Iterator<Item = &Instance> {
        self.instances.iter().filter(|i| self.is_drawn(i))
    }

    /// Whether an instance's material shows what is behind it ([`Material::shows_behind`]).
    pub(crate) fn is_blended(&self, instance: &Instance) -> bool {
        self.materials[self.meshes[instance.mesh].material].shows_behind()
    }

    /// Whether an instance has triangles to draw and is not hidden.
    pub(crate) fn is_drawn(&self, instance: &Instance) -> bool {
        !instance.hidden && !self.meshes[instance.mesh].indices.is_empty()
    }

    /// The number of triangles that one frame draws, instances counted.
    pub fn triangle_count(&self) -> usize {
        self.triangles_of(|_| true)
    }

    /// The number of triangles of some of the instances.
    pub(crate) fn triangles_of(&self, wanted: impl Fn(&Instance) -> bool) -> usize {
        let wanted = self.drawn_instances().filter(|i| wanted(i));
        wanted.map(|i| self.meshes[i.mesh].indices.len() / 3).sum()
    }

    /// The camera with this index or name.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] that lists the cameras there are.
    pub fn camera(&self, wanted: &str) -> crate::Result<&Camera> {
        let by_index = wanted.parse::<usize>().ok().and_then(|i| self.cameras.get(i));
        let by_name = || self.cameras.iter().find(|c| c.name == wanted);
        by_index.or_else(by_name).ok_or_else(|| {
            let known: Vec<_> =
                self.cameras.iter().enumerate().map(|(i, c)| format!("{i} ({})", c.name)).collect();
            crate::Error::unsupported(
                format!("scene '{}' has no camera '{wanted}'", self.name),
                format!("use one of: {}", known.join(", ")),
            )
        })
    }
}

//! The kinds of elements that a world has.

use glam::Mat4;

use super::super::check::Checked;
use super::super::{
    Camera, Decal, GlobePicture, Image, Instance, Light, LightKind, Material, Mesh, Particles, Projection,
    Sampler, Scene, Texture,
};
use super::Changes;

/// What a [`World`](super::World) has lists of: [`Mesh`], [`Instance`], [`Material`], [`Texture`], [`Image`], [`Light`],
/// [`Decal`], [`Camera`] and [`Particles`].
pub trait Element: Listed {}

impl<T: Listed> Element for T {}

/// The lists of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Mesh,
    Instance,
    Material,
    Texture,
    Image,
    Light,
    Decal,
    Camera,
    Particles,
}

impl Kind {
    pub const COUNT: usize = 9;

    /// The list's name in messages.
    pub fn list(self) -> &'static str {
        ["meshes", "instances", "materials", "textures", "images", "lights", "decals", "cameras", "particles"]
            [self as usize]
    }
}

/// An element as its list knows it.
pub trait Listed: Checked + Sized + 'static {
    const KIND: Kind;

    fn list(scene: &Scene) -> &[Self];

    fn list_mut(scene: &mut Scene) -> &mut Vec<Self>;

    /// What is in the place of an element that went: it shows nothing, and nothing is made for it.
    fn gone() -> Self;

    /// What it refers to.
    fn uses(&self) -> impl Iterator<Item = (Kind, usize)>;

    /// Notes what is different once this takes the place of `old`.
    fn note(&self, old: Option<&Self>, index: usize, changes: &mut Changes);
}

macro_rules! listed {
    ($ty:ident, $list:ident) => {
        const KIND: Kind = Kind::$ty;

        fn list(scene: &Scene) -> &[Self] {
            &scene.$list
        }

        fn list_mut(scene: &mut Scene) -> &mut Vec<Self> {
            &mut scene.$list
        }
    };
}

impl Listed for Mesh {
    listed!(Mesh, meshes);

    fn gone() -> Self {
        Self::default()
    }

    fn uses(&self) -> impl Iterator<Item = (Kind, usize)> {
        std::iter::once((Kind::Material, self.material))
    }

    fn note(&self, _: Option<&Self>, index: usize, changes: &mut Changes) {
        Changes::note(&mut changes.meshes, index);
        changes.elements = true;
    }
}

impl Listed for Instance {
    listed!(Instance, instances);

    fn gone() -> Self {
        Self { hidden: true, ..Self::new(0, Mat4::IDENTITY) }
    }

    fn uses(&self) -> impl Iterator<Item = (Kind, usize)> {
        std::iter::once((Kind::Mesh, self.mesh))
    }

    fn note(&self, old: Option<&Self>, index: usize, changes: &mut Changes) {
        let only_moved = |old: &Self| Self { world_from_object: self.world_from_object, ..*old } == *self;
        match old.is_some_and(only_moved) {
            true => Changes::note(&mut changes.instances, index),
            false => changes.elements = true,
        }
    }
}

impl Listed for Material {
    listed!(Material, materials);

    fn gone() -> Self {
        Self::default()
    }

    fn uses(&self) -> impl Iterator<Item = (Kind, usize)> {
        let textures = [
            self.base_color_texture,
            self.metallic_roughness_texture,
            self.normal_texture,
            self.occlusion_texture,
            self.emissive_texture,
        ];
        textures.into_iter().flatten().map(|texture| (Kind::Texture, texture.texture))
    }

    fn note(&self, _: Option<&Self>, _: usize, changes: &mut Changes) {
        changes.elements = true;
    }
}

impl Listed for Texture {
    listed!(Texture, textures);

    fn gone() -> Self {
        Self { image: 0, sampler: Sampler::default() }
    }

    fn uses(&self) -> impl Iterator<Item = (Kind, usize)> {
        std::iter::once((Kind::Image, self.image))
    }

    fn note(&self, _: Option<&Self>, _: usize, changes: &mut Changes) {
        changes.elements = true;
    }
}

impl Listed for Image {
    listed!(Image, images);

    fn gone() -> Self {
        Self { name: String::new(), width: 0, height: 0, texels: Vec::new().into() }
    }

    fn uses(&self) -> impl Iterator<Item = (Kind, usize)> {
        std::iter::empty()
    }

    fn note(&self, _: Option<&Self>, index: usize, changes: &mut Changes) {
        Changes::note(&mut changes.images, index);
        changes.elements = true;
    }
}

impl Listed for Light {
    listed!(Light, lights);

    fn gone() -> Self {
        Self::new(LightKind::Directional { illuminance_lx: 0.0 })
    }

    fn uses(&self) -> impl Iterator<Item = (Kind, usize)> {
        let images: &[usize] = match &self.globe_map {
            None => &[],
            Some(map) => match &map.picture {
                GlobePicture::Flat { image } => std::slice::from_ref(image),
                GlobePicture::Cube { images } => images,
            },
        };
        images.iter().map(|&image| (Kind::Image, image))
    }

    fn note(&self, old: Option<&Self>, index: usize, changes: &mut Changes) {
        // What decides which maps there are, and which shaders.
        let kind =
            |light: &Self| (light.is_dark(), light.shadow.is_some(), light.globe_map.map(|map| map.picture));
        match old.is_some_and(|old| kind(old) == kind(self)) {
            true => Changes::note(&mut changes.lights, index),
            false => changes.elements = true,
        }
    }
}

impl Listed for Decal {
    listed!(Decal, decals);

    fn gone() -> Self {
        Self { channels: super::super::DecalChannels::NONE, ..Self::new(0, Mat4::IDENTITY) }
    }

    fn uses(&self) -> impl Iterator<Item = (Kind, usize)> {
        std::iter::once((Kind::Material, self.material))
    }

    fn note(&self, old: Option<&Self>, index: usize, changes: &mut Changes) {
        match old.is_some_and(|old| old.channels != super::super::DecalChannels::NONE) {
            true => Changes::note(&mut changes.decals, index),
            false => changes.elements = true,
        }
    }
}

impl Listed for Camera {
    listed!(Camera, cameras);

    fn gone() -> Self {
        let projection = Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None };
        Self { name: String::new(), world_from_view: Mat4::IDENTITY, projection }
    }

    fn uses(&self) -> impl Iterator<Item = (Kind, usize)> {
        std::iter::empty()
    }

    /// Whoever views a frame brings a camera along.
    fn note(&self, _: Option<&Self>, _: usize, _: &mut Changes) {}
}

impl Listed for Particles {
    listed!(Particles, particles);

    fn gone() -> Self {
        Self::default()
    }

    fn uses(&self) -> impl Iterator<Item = (Kind, usize)> {
        std::iter::once((Kind::Material, self.material))
    }

    fn note(&self, old: Option<&Self>, index: usize, changes: &mut Changes) {
        let others = |old: &Self| {
            (old.material, old.soft_m, old.most) == (self.material, self.soft_m, self.most) && old.most > 0
        };
        match old.is_some_and(others) {
            true => Changes::note(&mut changes.particles, index),
            false => changes.elements = true,
        }
    }
}

/// How long each list is, in the order of [`Kind`].
pub fn lengths(scene: &Scene) -> [usize; Kind::COUNT] {
    [
        scene.meshes.len(),
        scene.instances.len(),
        scene.materials.len(),
        scene.textures.len(),
        scene.images.len(),
        scene.lights.len(),
        scene.decals.len(),
        scene.cameras.len(),
        scene.particles.len(),
    ]
}

/// Every place whose element refers to this one.
pub fn users(scene: &Scene, kind: Kind, index: usize) -> impl Iterator<Item = (Kind, usize)> + '_ {
    fn of<T: Listed>(scene: &Scene, used: (Kind, usize)) -> impl Iterator<Item = (Kind, usize)> + '_ {
        let uses = move |element: &T| element.uses().any(|other| other == used);
        let places = T::list(scene).iter().enumerate().filter(move |(_, element)| uses(element));
        places.map(|(place, _)| (T::KIND, place))
    }
    let used = (kind, index);
    of::<Instance>(scene, used)
        .chain(of::<Mesh>(scene, used))
        .chain(of::<Decal>(scene, used))
        .chain(of::<Particles>(scene, used))
        .chain(of::<Material>(scene, used))
        .chain(of::<Texture>(scene, used))
        .chain(of::<Light>(scene, used))
}

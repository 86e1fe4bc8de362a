//! A scene that is built and changed piece by piece.

mod changes;
mod element;

use std::fmt;
use std::hash::{Hash, Hasher};
use std::marker::PhantomData;

use glam::{Mat4, Vec3};

use super::motion::Posture;
use super::{Background, Environment, Fog, Instance, Mesh, Play, Pose, Probe, Scene};
use crate::{Error, Result};
pub use changes::Changes;
pub use element::Element;
pub(super) use element::{Kind, Listed, lengths};

/// Names an element of a [`World`]: a mesh, a material, a light and so on. It stays valid, and the element at its place,
/// whatever comes and goes beside it. Once the element was removed the name is refused, even after another took the place.
pub struct Id<T> {
    index: u32,
    generation: u32,
    of: PhantomData<fn() -> T>,
}

impl<T> Id<T> {
    /// The element's place in its list of [`World::scene`]: what elements refer to each other by, e.g. in
    /// [`Instance::mesh`].
    pub fn index(self) -> usize {
        self.index as usize
    }

    /// As one number that is not 0, for interfaces that have no such type.
    pub fn to_bits(self) -> u64 {
        u64::from(self.generation) << 32 | u64::from(self.index)
    }

    /// What [`Self::to_bits`] was made of; other numbers give names that a world refuses.
    pub fn from_bits(bits: u64) -> Self {
        Self { index: bits as u32, generation: (bits >> 32) as u32, of: PhantomData }
    }
}

impl<T> Clone for Id<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Id<T> {}

impl<T> PartialEq for Id<T> {
    fn eq(&self, other: &Self) -> bool {
        self.to_bits() == other.to_bits()
    }
}

impl<T> Eq for Id<T> {}

impl<T> Hash for Id<T> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.to_bits().hash(state);
    }
}

impl<T> fmt::Debug for Id<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.index, self.generation)
    }
}

/// Which places of a list are taken. A place's generation is odd while it is.
#[derive(Clone, Debug, Default)]
struct Places {
    generations: Vec<u32>,
    free: Vec<u32>,
}

impl Places {
    fn taken(count: usize) -> Self {
        Self { generations: vec![1; count], free: Vec::new() }
    }

    fn is_taken(&self, index: usize) -> bool {
        self.generations.get(index).is_some_and(|generation| generation % 2 == 1)
    }
}

/// A [`Scene`] whose elements have names, and come, change and go between frames.
///
/// ```
/// use ontile::glam::{Mat4, Vec3};
/// use ontile::scene::{Instance, Light, LightKind, Material, Mesh, World};
///
/// # fn main() -> ontile::Result<()> {
/// let mut world = World::new("triangle");
/// let red = world.add(Material { base_color_factor: Vec3::X.extend(1.0), ..Material::default() })?;
/// let triangle = world.add(Mesh {
///     positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
///     normals: vec![Vec3::Z; 3],
///     indices: vec![0, 1, 2],
///     material: red.index(),
///     ..Mesh::default()
/// })?;
/// let object = world.add(Instance::new(triangle.index(), Mat4::IDENTITY))?;
/// world.add(Light::new(LightKind::Directional { illuminance_lx: 3.0 }))?;
///
/// world.place(object, Mat4::from_rotation_y(0.5))?;
/// world.remove(object)?;
/// world.remove(triangle)?;
/// assert!(world.get(triangle).is_none());
/// # Ok(())
/// # }
/// ```
///
/// A place that an element has left stays empty until another takes it, so that the others keep theirs: it holds something that
/// shows nothing and needs nothing. What happened since [`Self::clear_changes`] is in [`Self::changes`], by which
/// [`Renderer::update`](crate::gpu::Renderer::update) finds out what there is to do.
#[derive(Clone, Debug, Default)]
pub struct World {
    scene: Scene,
    places: [Places; Kind::COUNT],
    changes: Changes,
    posture: Posture,
}

impl From<Scene> for World {
    /// All elements have names then: [`World::ids`].
    fn from(scene: Scene) -> Self {
        let places = lengths(&scene).map(Places::taken);
        Self { scene, places, changes: Changes::default(), posture: Posture::default() }
    }
}

impl World {
    /// An empty one.
    pub fn new(name: &str) -> Self {
        Scene { name: name.to_owned(), ..Scene::default() }.into()
    }

    /// As it stands.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What was done since [`Self::clear_changes`].
    pub fn changes(&self) -> &Changes {
        &self.changes
    }

    /// Once everybody has looked at [`Self::changes`].
    pub fn clear_changes(&mut self) {
        self.changes.clear();
    }

    /// Takes an element in.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if a number of it means nothing, or it refers to an element that is not there.
    pub fn add<T: Element>(&mut self, element: T) -> Result<Id<T>> {
        self.check(&element)?;
        let places = &mut self.places[T::KIND as usize];
        let index = match places.free.pop() {
            Some(index) => index,
            None => {
                let index = places.generations.len();
                let index = u32::try_from(index)
                    .map_err(|_| Error::unsupported("the world is full", "remove what is not needed"))?;
                places.generations.push(0);
                T::list_mut(&mut self.scene).push(T::gone());
                index
            }
        };
        let generation = &mut places.generations[index as usize];
        *generation = generation.wrapping_add(1);
        let id = Id { index, generation: *generation, of: PhantomData };
        element.note(None, index as usize, &mut self.changes);
        T::list_mut(&mut self.scene)[index as usize] = element;
        Ok(id)
    }

    /// The element, unless it was removed.
    pub fn get<T: Element>(&self, id: Id<T>) -> Option<&T> {
        self.is_there(id).then(|| &T::list(&self.scene)[id.index()])
    }

    /// The names of all elements of a kind, in the order of their places.
    pub fn ids<T: Element>(&self) -> impl Iterator<Item = Id<T>> + '_ {
        let taken = (0..).zip(&self.places[T::KIND as usize].generations).filter(|(_, g)| *g % 2 == 1);
        taken.map(|(index, &generation)| Id { index, generation, of: PhantomData })
    }

    /// Puts another element in an element's place, for all that refer to it.
    ///
    /// # Errors
    /// As [`Self::add`], and if the element was removed. Nothing is changed then.
    pub fn set<T: Element>(&mut self, id: Id<T>, element: T) -> Result<()> {
        self.find(id)?;
        self.check(&element)?;
        let place = &mut T::list_mut(&mut self.scene)[id.index()];
        element.note(Some(place), id.index(), &mut self.changes);
        *place = element;
        Ok(())
    }

    /// Moves an instance.
    ///
    /// # Errors
    /// As [`Self::set`].
    pub fn place(&mut self, id: Id<Instance>, world_from_object: Mat4) -> Result<()> {
        let instance = *self.find(id)?;
        self.set(id, Instance { world_from_object, ..instance })
    }

    /// Poses a mesh that has a [`Deformation`](super::Deformation).
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it has none, the pose is of others, or the mesh was removed. Nothing is changed then.
    pub fn pose(&mut self, id: Id<Mesh>, pose: Pose) -> Result<()> {
        let refused = |problem: String| {
            let list = Kind::Mesh.list();
            Error::unsupported(
                format!("{list}[{}] cannot be posed: {problem}", id.index()),
                "give each of its joints an affine matrix, and each morph target a weight",
            )
        };
        let Some(deformation) = &self.find(id)?.deformation else {
            return Err(refused("nothing bends it".into()));
        };
        if let Some(problem) = deformation.pose_problem(&pose) {
            return Err(refused(problem));
        }
        self.scene.meshes[id.index()].deformation.iter_mut().for_each(|d| d.pose.clone_from(&pose));
        Changes::note(&mut self.changes.poses, id.index());
        Ok(())
    }

    /// As [`Scene::animate`]; once it has been called, it allocates no more for later times.
    ///
    /// # Errors
    /// As there.
    pub fn animate(&mut self, playing: &[Play]) -> Result<()> {
        self.scene.animate_with(playing, &mut self.posture, &mut self.changes)
    }

    /// Takes an element out. No animation moves what takes its place.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it was removed before, or another element refers to it. Nothing is changed then.
    pub fn remove<T: Element>(&mut self, id: Id<T>) -> Result<T> {
        self.find(id)?;
        if let Some((list, user)) = self.user_of(T::KIND, id.index()) {
            let name = T::KIND.list();
            return Err(Error::unsupported(
                format!("{name}[{}] cannot be removed: {list}[{user}] uses it", id.index()),
                format!("remove what uses it first, or let {list}[{user}] use another"),
            ));
        }
        self.scene.motion.iter_mut().for_each(|motion| motion.leave(T::KIND, id.index()));
        let places = &mut self.places[T::KIND as usize];
        places.generations[id.index()] = places.generations[id.index()].wrapping_add(1);
        places.free.push(id.index);
        let gone = T::gone();
        let place = &mut T::list_mut(&mut self.scene)[id.index()];
        gone.note(Some(place), id.index(), &mut self.changes);
        Ok(std::mem::replace(place, gone))
    }

    /// Radiance that arrives from every direction alike: [`Scene::ambient_nt`].
    ///
    /// # Errors
    /// [`Error::Unsupported`] if a number means nothing. Nothing is changed then.
    pub fn set_ambient(&mut self, ambient_nt: Vec3) -> Result<()> {
        self.surround(|scene| &mut scene.ambient_nt, ambient_nt)
    }

    /// What is seen where there is no surface.
    ///
    /// # Errors
    /// As [`Self::set_ambient`].
    pub fn set_background(&mut self, background: Background) -> Result<()> {
        self.surround(|scene| &mut scene.background, background)
    }

    /// What is between the surfaces and the viewer.
    ///
    /// # Errors
    /// As [`Self::set_ambient`].
    pub fn set_fog(&mut self, fog: Option<Fog>) -> Result<()> {
        self.surround(|scene| &mut scene.fog, fog)
    }

    /// Radiance from far away.
    ///
    /// # Errors
    /// As [`Self::set_ambient`].
    pub fn set_environment(&mut self, environment: Option<Environment>) -> Result<()> {
        self.surround(|scene| &mut scene.environment, environment)
    }

    /// What glossy surfaces reflect inside boxes.
    ///
    /// # Errors
    /// As [`Self::set_ambient`].
    pub fn set_probes(&mut self, probes: Vec<Probe>) -> Result<()> {
        self.surround(|scene| &mut scene.probes, probes)
    }

    fn surround<T>(&mut self, place: impl Fn(&mut Scene) -> &mut T, value: T) -> Result<()> {
        let old = std::mem::replace(place(&mut self.scene), value);
        if let Err(error) = self.scene.check_surroundings() {
            *place(&mut self.scene) = old;
            return Err(error);
        }
        self.changes.surroundings = true;
        Ok(())
    }

    fn is_there<T: Element>(&self, id: Id<T>) -> bool {
        let generation = self.places[T::KIND as usize].generations.get(id.index());
        id.generation % 2 == 1 && generation == Some(&id.generation)
    }

    fn find<T: Element>(&self, id: Id<T>) -> Result<&T> {
        self.get(id).ok_or_else(|| {
            Error::unsupported(
                format!("{}[{}] was removed, or is of another world", T::KIND.list(), id.index()),
                "use the name that `World::add` gave, until the element is removed",
            )
        })
    }

    fn check<T: Element>(&self, element: &T) -> Result<()> {
        let list = T::KIND.list();
        let mut missing = element.uses().filter(|(kind, i)| !self.places[*kind as usize].is_taken(*i));
        if let Some((kind, index)) = missing.next() {
            return Err(Error::unsupported(
                format!("an element for {list} uses {}[{index}], which is not there", kind.list()),
                "add that first, and refer to it by its `Id::index`",
            ));
        }
        match element.problem() {
            Some(problem) => Err(Error::unsupported(
                format!("an element for {list}: {problem}"),
                "give numbers within the range that the element's description names",
            )),
            None => Ok(()),
        }
    }

    /// An element that refers to this one.
    fn user_of(&self, kind: Kind, index: usize) -> Option<(&'static str, usize)> {
        element::users(&self.scene, kind, index)
            .find(|(user, place)| self.places[*user as usize].is_taken(*place))
            .map(|(user, place)| (user.list(), place))
    }
}

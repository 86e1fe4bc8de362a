//! glTF 2.0 files into a [`Scene`](super::Scene).
//!
//! Data flows one way: `source` gives bytes, `document` parsed JSON and checked byte ranges, `accessor` typed
//! lists, and `node`, `material`, `mesh` and `image` what the scene holds. Nothing in a file is trusted: every
//! index, range and number is checked before it is used.

mod accessor;
mod around;
mod decal;
mod defaults;
mod document;
#[cfg(feature = "measure")]
pub(crate) mod edit;
mod environment;
mod extras;
mod image;
mod instancing;
mod light;
mod material;
mod mesh;
mod meshopt;
mod motion;
mod node;
mod particles;
mod pose;
mod source;
mod tangent;
mod unknown;

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{DMat3, Mat4, Vec3};

use super::{Aabb, Follows, Instance, LightmapRect, Mesh, Scene};
use crate::Result;
use around::NodeLightmap;
use document::{Document, MAX_INSTANCES};
use material::Materials;
use mesh::{Budget, Primitive};
use motion::{Followers, Moving};
use node::NodeTree;
use pose::{Bend, Skin};

/// World coordinates beyond this (metres) would overflow f32 where lengths are squared.
const MAX_COORDINATE_M: f32 = 1e15;

/// What [`Scene::warnings`] say of lights that no file has.
const DEFAULT_LIGHTS: &str = "scene: it has no lights; a default key and fill light were added";

impl Scene {
    /// Takes away the lights that [`Self::load`] added because the file has none: for a scene that is lit otherwise.
    pub fn drop_default_lights(&mut self) {
        if std::mem::take(&mut self.has_default_lights) {
            self.lights.clear();
            self.warnings.retain(|warning| warning != DEFAULT_LIGHTS);
        }
    }

    /// Loads a glTF 2.0 file (`.gltf` or `.glb`) with the buffers and images that it uses.
    ///
    /// The scene is the file's default one (else the first, else all nodes), as it stands without animations:
    /// morph targets at their default weights, skins at rest. Only what is drawn is kept. Normals and tangents
    /// are made where a material needs them and the file has none (flat ones; MikkTSpace).
    ///
    /// A file without a camera gets one named `default` that shows everything. A file without lights and environment gets,
    /// if anything in it can be lit, a key light of 3 lx over the right shoulder of camera 0 and a fill light of
    /// 0.8 lx from its lower left. [`Scene::warnings`] tells what was left out, replaced or added.
    ///
    /// # Errors
    /// [`crate::Error::Io`] if `path` cannot be read. [`crate::Error::Input`] for anything in it that breaks
    /// the rules of glTF 2.0, needs an unsupported extension, or refers to data that is missing or broken.
    pub fn load(path: &Path) -> Result<Self> {
        Self::read(path, false)
    }

    /// As [`Self::load`], but for what the file's animations move: [`Scene::motion`] knows how, and [`Scene::animate`] moves it. Instances
    /// and lights that move are dynamic; meshes that bend have a [`Deformation`](super::Deformation), and one of their own for each node.
    /// A mesh without normals gets those of the triangles of its bind pose. What no animation moves, and a file without animations, is as
    /// there.
    ///
    /// Weights of joints count by their share of all of a vertex; of a vertex without weight there is none. Skinned triangles go round as they
    /// do without animations: what an animation turns inside out shows its backs.
    ///
    /// # Errors
    /// As there, for animations too.
    pub fn load_moving(path: &Path) -> Result<Self> {
        Self::read(path, true)
    }

    fn read(path: &Path, moves: bool) -> Result<Self> {
        let mut scene = load(&Document::read(path)?, moves)?;
        if scene.lightmap.is_none() && scene.instances.iter().any(|i| i.lightmap.is_some()) {
            let ignored =
                "nodes: some have a part of a lightmap, but the file has none; they are lit without";
            scene.warnings.push(ignored.into());
        }
        Ok(scene)
    }
}

/// What [`Scene::load`] does once the file is read.
fn load(doc: &Document, moves: bool) -> Result<Scene> {
    let mut tree = NodeTree::read(doc)?;
    let moving = if moves { Moving::read(doc, &mut tree)? } else { Moving::default() };
    let name = doc.path.file_stem().map_or("scene".into(), |stem| stem.to_string_lossy().into_owned());
    let mut scene = Scene { name, warnings: doc.extension_warnings(), ..Scene::default() };

    let mut materials = Materials::default();
    let mut followers = read_meshes(doc, &tree, &moving, &mut scene, &mut materials)?;
    scene.lights = light::read_lights(doc, &tree, &mut materials)?;
    scene.decals = decal::read_decals(doc, &tree, &mut materials)?;
    scene.particles =
        particles::read_particles(doc, &tree, &moving, &mut followers, &mut materials, &mut scene.warnings)?;
    scene.images = image::decode_all(doc, &materials.images)?;
    scene.materials = materials.materials;
    scene.textures = materials.textures;
    scene.warnings.append(&mut materials.warnings);

    for instance in &scene.instances {
        let bounds = scene.meshes[instance.mesh].bounds().map(|b| b.transformed(&instance.world_from_object));
        if let Some(Aabb { min, max }) = bounds.filter(|b| !is_representable(b)) {
            let mesh = &scene.meshes[instance.mesh].name;
            let problem = format!("mesh '{mesh}' reaches from {min} to {max}, beyond {MAX_COORDINATE_M:e} m");
            return Err(doc.bad("nodes", problem, "scale the scene down"));
        }
    }
    let bounds = scene.bounds_world();
    if bounds.is_none() {
        scene.warnings.push("scene: it has no triangles, so nothing is drawn".into());
    }
    scene.background = around::read_background(doc)?;
    scene.fog = around::read_fog(doc)?;
    scene.lightmap = around::read_lightmap(doc)?;
    scene.cameras = node::read_cameras(doc, &tree)?;
    if scene.cameras.is_empty() {
        scene.cameras.push(defaults::camera(bounds));
    }
    scene.environment = environment::read_environment(doc)?;
    scene.probes = environment::read_probes(doc, &tree)?;
    scene.motion = followers.finish(doc, &tree, &moving, &mut scene)?;
    let is_lit = scene.meshes.iter().any(|mesh| !scene.materials[mesh.material].unlit);
    let is_lit_by_nothing =
        scene.lights.is_empty() && scene.environment.is_none() && scene.lightmap.is_none();
    if is_lit && is_lit_by_nothing {
        scene.lights = defaults::lights(&scene.cameras[0]);
        scene.has_default_lights = true;
        scene.warnings.push(DEFAULT_LIGHTS.into());
    }
    Ok(scene)
}

fn is_representable(bounds: &Aabb) -> bool {
    [bounds.min, bounds.max].iter().all(|p| p.is_finite() && p.abs().max_element() <= MAX_COORDINATE_M)
}

/// Meshes, their instances and the materials they use.
fn read_meshes(
    doc: &Document,
    tree: &NodeTree,
    moving: &Moving,
    scene: &mut Scene,
    materials: &mut Materials,
) -> Result<Followers> {
    let mut followers = Followers::default();
    // Undeformed primitives are shared by all nodes; deformed ones belong to theirs. `None` had no triangles.
    let mut known: HashMap<(usize, usize, Option<usize>), Option<usize>> = HashMap::new();
    let mut skins: HashMap<usize, Skin> = HashMap::new();
    let mut budget = Budget::default();
    let lightmaps = Lightmaps::read(doc, tree)?;
    for &node_index in &tree.drawn {
        let node = &doc.root.nodes[node_index];
        let Some(mesh_index) = node.mesh else { continue };
        let element = format!("nodes[{node_index}]");
        let mesh = doc.get(&doc.root.meshes, "meshes", mesh_index, format!("{element}.mesh"))?;
        let weights = pose::morph_weights(doc, node_index, mesh_index)?;
        let skin = match node.skin {
            Some(index) => match skins.entry(index.value()) {
                Entry::Occupied(known) => Some(known.into_mut()),
                Entry::Vacant(new) => {
                    Some(new.insert(Skin::read(doc, tree, index, &format!("{element}.skin"))?))
                }
            },
            None => None,
        };
        let world_from_node = tree.world_from_node[node_index];
        let moves = moving.place(node_index);
        if skin.is_none() && !moves && DMat3::from_mat4(world_from_node).determinant() == 0.0 {
            scene.warnings.push(format!("{element}: its scale flattens the mesh, which was left out"));
            continue;
        }
        let skin = skin.as_deref();
        let bends = skin.is_some_and(|skin| moving.bends(skin)) || moving.weights(node_index);
        // What moves far away is no less accurate for being placed by its instance.
        let origin = skin.filter(|_| bends).map_or(Vec3::ZERO, |skin| skin.origin(tree));
        let world_from_object = match skin {
            Some(_) => Mat4::from_translation(origin),
            None => world_from_node.as_mat4(),
        };
        let own = (skin.is_some() || node.weights.is_some() || bends).then_some(node_index);
        let placements = instancing::placements(doc, node_index)?;
        if skin.is_some() && placements.is_some() {
            let ignored = "its skin decides where the mesh is; EXT_mesh_gpu_instancing was left out";
            scene.warnings.push(format!("{element}: {ignored}"));
        }
        let placements = placements.filter(|_| skin.is_none());
        let bend = Bend { weights, skin: skin.map(|skin| (skin, origin)), moves: bends };
        let has_particles = particles::said(doc, node_index)?.is_some();
        for (j, json) in mesh.primitives.iter().enumerate() {
            if has_particles && particles::is_points(json) {
                continue;
            }
            let element = format!("meshes[{}].primitives[{j}]", mesh_index.value());
            let key = (mesh_index.value(), j, own);
            let index = match known.get(&key) {
                Some(&index) => index,
                None => {
                    let name = match (&mesh.name, mesh.primitives.len()) {
                        (Some(name), 1) => name.clone(),
                        (Some(name), _) => format!("{name} {j}"),
                        (None, _) => format!("mesh {} {j}", mesh_index.value()),
                    };
                    let lightmapped = lightmaps.meshes.contains(&mesh_index.value());
                    let primitive = Primitive { json, name, element, lightmapped };
                    let index = read_primitive(doc, &primitive, &bend, scene, materials, &mut budget)?;
                    known.insert(key, index);
                    index
                }
            };
            let Some(mesh) = index else { continue };
            let count = placements.as_ref().map_or(1, Vec::len);
            if scene.instances.len() + count > MAX_INSTANCES {
                let problem = format!("there are more than {MAX_INSTANCES} meshes to draw");
                return Err(doc.bad("nodes", problem, "split the scene into smaller files"));
            }
            let lightmap = lightmaps.of(doc, node_index, &scene.meshes[mesh], materials)?;
            let dynamic = tree.dynamic[node_index] || bends;
            let weights = moving.weights(node_index).then_some(Follows::Weights { mesh });
            followers.list.extend(weights.map(|what| (node_index, what)));
            if let Some(placements) = &placements {
                // Instances would share one part of the lightmap.
                let instance = Instance { dynamic, ..Instance::new(mesh, Mat4::IDENTITY) };
                let before = scene.instances.len();
                for node_from_object in placements {
                    let world_from_object = world_from_node * *node_from_object;
                    if !moves && DMat3::from_mat4(world_from_object).determinant() == 0.0 {
                        continue;
                    }
                    let world_from_object = world_from_object.as_mat4();
                    if !world_from_object.is_finite() {
                        let problem = "an instance's place in world space exceeds what f32 can hold";
                        return Err(doc.bad(format!("nodes[{node_index}]"), problem, "scale the scene down"));
                    }
                    if moves {
                        let place = (node_index, node_from_object.as_mat4(), scene.instances.len());
                        followers.instances.push(place);
                    }
                    scene.instances.push(Instance { world_from_object, ..instance });
                }
                let flat = before + count - scene.instances.len();
                if flat > 0 {
                    let problem = format!("scale flattens {flat} of {count} instances, which were left out");
                    scene.warnings.push(format!("nodes[{node_index}]: {problem}"));
                }
                continue;
            }
            let instance = scene.instances.len();
            let follows = match skin.filter(|_| bends) {
                Some(skin) => Some(Follows::Skin { mesh, instance, skin: followers.skin(skin) }),
                None => (skin.is_none() && moves).then_some(Follows::Instance(instance)),
            };
            followers.list.extend(follows.map(|what| (node_index, what)));
            scene.instances.push(Instance { dynamic, lightmap, ..Instance::new(mesh, world_from_object) });
        }
    }
    Ok(followers)
}

/// Which nodes have a part of the lightmap, and the meshes that they draw.
struct Lightmaps {
    rects: HashMap<usize, LightmapRect>,
    meshes: HashSet<usize>,
}

impl Lightmaps {
    fn read(doc: &Document, tree: &NodeTree) -> Result<Self> {
        let (mut rects, mut meshes) = (HashMap::new(), HashSet::new());
        for &node in &tree.drawn {
            if let (Some(mesh), Some(NodeLightmap::Rect(rect))) =
                (doc.root.nodes[node].mesh, around::node_lightmap(doc, node)?)
            {
                rects.insert(node, rect);
                meshes.insert(mesh.value());
            }
        }
        Ok(Self { rects, meshes })
    }

    /// The part of a node for one of its meshes; unlit ones have none.
    fn of(
        &self,
        doc: &Document,
        node: usize,
        mesh: &Mesh,
        materials: &Materials,
    ) -> Result<Option<LightmapRect>> {
        let unlit = materials.materials[mesh.material].unlit;
        let Some(rect) = self.rects.get(&node).filter(|_| !unlit) else { return Ok(None) };
        if mesh.texcoords[1].is_empty() {
            let problem = format!("is there, but mesh '{}' has no TEXCOORD_1", mesh.name);
            let element = format!("nodes[{node}].extras.ontile.lightmap");
            return Err(doc.bad(element, problem, "bake the lightmap again, or remove it"));
        }
        Ok(Some(*rect))
    }
}

/// Adds the mesh and its material to the scene; `None` if there are no triangles.
fn read_primitive(
    doc: &Document,
    primitive: &Primitive,
    bend: &Bend,
    scene: &mut Scene,
    materials: &mut Materials,
    budget: &mut Budget,
) -> Result<Option<usize>> {
    let Some(indices) = primitive.triangles(doc, budget, &mut scene.warnings)? else { return Ok(None) };
    let material = primitive.json.material;
    let material = materials.use_material(doc, material, &format!("{}.material", primitive.element))?;
    let mesh =
        primitive.read(doc, indices, &materials.materials[material], bend, budget, &mut scene.warnings)?;
    scene.meshes.push(Mesh { material, ..mesh });
    Ok(Some(scene.meshes.len() - 1))
}

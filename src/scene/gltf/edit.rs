//! A file that is changed in a few places and written again as GLB; everything else in it stays as it is.

use std::path::{Path, PathBuf};

use glam::{DMat3, DMat4, Vec2, Vec3};
use gltf::json::Index;
use gltf::json::mesh::Semantic;
use serde_json::{Map, Value, json};

use super::accessor::{Format, Reader};
use super::around::{self, NodeLightmap};
use super::document::Document;
use super::light;
use super::material::Materials;
use super::mesh::{Budget, Primitive};
use super::node::NodeTree;
use super::source::{self, Container};
use super::{image, load};
use crate::scene::Scene;
use crate::{Error, Result};

/// Extensions of views' bytes, which are written as they are once decoded.
const DECODED: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// A glTF file in memory: its JSON as it was, and one buffer with all bytes.
pub(crate) struct Edit {
    path: PathBuf,
    json: Value,
    bin: Vec<u8>,
}

/// A mesh that is drawn and lit.
pub(crate) struct Surface {
    /// Index in the file.
    pub mesh: usize,
    /// The nodes that draw it, and their placement.
    pub nodes: Vec<(usize, DMat4)>,
    /// Its lit primitives.
    pub parts: Vec<Part>,
}

/// A primitive of triangles.
pub(crate) struct Part {
    /// Index in the mesh.
    pub primitive: usize,
    pub positions: Vec<Vec3>,
    /// TEXCOORD_1, empty without.
    pub texcoords: Vec<Vec2>,
    /// Three per triangle.
    pub indices: Vec<u32>,
    /// The material's textures use TEXCOORD_1.
    pub uses_texcoords: bool,
}

/// What a primitive's vertices become.
pub(crate) struct Replacement<'a> {
    pub mesh: usize,
    pub primitive: usize,
    /// The old vertex of each new one.
    pub sources: &'a [u32],
    /// The new TEXCOORD_1.
    pub texcoords: &'a [Vec2],
    /// Three per triangle, of the new vertices.
    pub indices: &'a [u32],
}

impl Edit {
    /// Reads a file with its buffers and images.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn read(path: &Path) -> Result<Self> {
        let container = source::read_container(path)?;
        let not_json =
            |e| Error::input(path, "JSON", format!("cannot be parsed: {e}"), "export the file again");
        let mut json: Value = serde_json::from_slice(&container.json).map_err(not_json)?;
        let doc = Document::new(path, container)?;
        let mut bin = Vec::new();
        for index in 0..doc.root.buffer_views.len() {
            let bytes = doc.view(Index::new(index as u32), &format!("bufferViews[{index}]"))?;
            let view = &mut json["bufferViews"][index];
            view["buffer"] = json!(0);
            view["byteOffset"] = json!(append(&mut bin, bytes));
            forget(view, &DECODED);
        }
        for list in ["extensionsUsed", "extensionsRequired"] {
            let Some(names) = json.get_mut(list).and_then(Value::as_array_mut) else { continue };
            names.retain(|name| !DECODED.iter().any(|decoded| name == decoded));
            // glTF has no empty lists.
            if names.is_empty() {
                remove(&mut json, list);
            }
        }
        let mut edit = Self { path: path.into(), json, bin };
        for index in 0..doc.root.images.len() {
            // An image that nothing uses may well be missing.
            let is_outside = doc.root.images[index].uri.is_some();
            let Some(bytes) = is_outside.then(|| image::encoded_bytes(&doc, index).ok()).flatten() else {
                continue;
            };
            let view = edit.add_view(&bytes, None);
            let mime = match bytes.as_ref() {
                png if png.starts_with(b"\x89PNG") => "image/png",
                webp if webp.starts_with(b"RIFF") => "image/webp",
                ktx if ktx.starts_with(&ktx2::MAGIC) => "image/ktx2",
                _ => "image/jpeg",
            };
            let image = &mut edit.json["images"][index];
            image["bufferView"] = json!(view);
            image["mimeType"] = json!(mime);
            remove(image, "uri");
        }
        Ok(edit)
    }

    /// The meshes that are drawn and lit, in order of index; nodes that move, or whose extras keep them
    /// out of the lightmap, are left out.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn surfaces(&self) -> Result<Vec<Surface>> {
        let doc = self.document()?;
        let tree = NodeTree::read(&doc)?;
        let mut surfaces: Vec<Surface> = Vec::new();
        for &node in &tree.drawn {
            let Some(mesh) = doc.root.nodes[node].mesh else { continue };
            let never = around::node_lightmap(&doc, node)? == Some(NodeLightmap::Never);
            let world_from_node = tree.world_from_node[node];
            let is_flat = DMat3::from_mat4(world_from_node).determinant() == 0.0;
            // Instances would share one part of the lightmap.
            let is_many = doc.instancing[node].is_some();
            if never || is_flat || is_many || tree.dynamic[node] {
                continue;
            }
            doc.get(&doc.root.meshes, "meshes", mesh, format!("nodes[{node}].mesh"))?;
            let mesh = mesh.value();
            match surfaces.iter_mut().find(|s| s.mesh == mesh) {
                Some(known) => known.nodes.push((node, world_from_node)),
                None => {
                    let parts = parts(&doc, mesh)?;
                    surfaces.push(Surface { mesh, nodes: vec![(node, world_from_node)], parts });
                }
            }
        }
        surfaces.retain(|s| !s.parts.is_empty());
        surfaces.sort_by_key(|s| s.mesh);
        Ok(surfaces)
    }

    /// Gives primitives other vertices. Attributes and morph targets are copied vertex by vertex.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn replace_vertices(&mut self, replacements: &[Replacement]) -> Result<()> {
        // The document is of the file before any of them.
        let before = Self { path: self.path.clone(), json: self.json.clone(), bin: self.bin.clone() };
        let doc = before.document()?;
        for new in replacements {
            let element = format!("meshes[{}].primitives[{}]", new.mesh, new.primitive);
            let pointer = format!("/meshes/{}/primitives/{}", new.mesh, new.primitive);
            let mut primitive = self.json.pointer(&pointer).cloned().unwrap_or_default();
            let mut attributes = primitive["attributes"].take();
            let targets = primitive["targets"].as_array_mut().into_iter().flatten();
            let lists = targets.chain([&mut attributes]).filter_map(Value::as_object_mut);
            for (name, index) in lists.flat_map(Map::iter_mut) {
                let Some(old) = index.as_u64() else { continue };
                *index = json!(self.copy_accessor(&doc, old as usize, name, new.sources, &element)?);
            }
            let texcoords: Vec<u8> =
                new.texcoords.iter().flat_map(Vec2::to_array).flat_map(f32::to_le_bytes).collect();
            let view = self.add_view(&texcoords, Some(8));
            let count = new.texcoords.len();
            attributes["TEXCOORD_1"] = json!(self.push(
                "accessors",
                json!({"bufferView": view, "componentType": 5126, "type": "VEC2", "count": count}),
            ));
            let indices: Vec<u8> = new.indices.iter().flat_map(|i| i.to_le_bytes()).collect();
            let view = self.add_view(&indices, None);
            let count = new.indices.len();
            primitive["indices"] = json!(self.push(
                "accessors",
                json!({"bufferView": view, "componentType": 5125, "type": "SCALAR", "count": count}),
            ));
            primitive["attributes"] = attributes;
            primitive["mode"] = json!(4);
            if let Some(place) = self.json.pointer_mut(&pointer) {
                *place = primitive;
            }
        }
        Ok(())
    }

    /// Embeds a PNG; its index among the images.
    pub fn add_png(&mut self, name: &str, bytes: &[u8]) -> usize {
        let view = self.add_view(bytes, None);
        self.push("images", json!({"name": name, "bufferView": view, "mimeType": "image/png"}))
    }

    /// Sets a value of the `ontile` object in the extras of the scene that is drawn.
    pub fn set_scene_extra(&mut self, key: &str, value: Value) {
        if !self.json["scenes"].is_array() {
            // Without scenes all roots are drawn.
            let nodes = self.json["nodes"].as_array().into_iter().flatten();
            let children: Vec<_> = nodes
                .clone()
                .filter_map(|n| n["children"].as_array())
                .flatten()
                .filter_map(Value::as_u64)
                .collect();
            let roots: Vec<_> = (0..nodes.count() as u64).filter(|i| !children.contains(i)).collect();
            self.json["scenes"] = json!([{"nodes": roots}]);
        }
        let index = self.json["scene"].as_u64().unwrap_or(0);
        self.set_extra(&format!("/scenes/{index}"), key, value);
    }

    /// Sets a value of the `ontile` object in the extras of the element at a JSON pointer.
    pub fn set_extra(&mut self, pointer: &str, key: &str, value: Value) {
        let Some(mut object) = self.json.pointer_mut(pointer) else { return };
        for name in ["extras", "ontile"] {
            object = &mut object[name];
            // Extras that are no object have no place for one.
            if !object.is_object() {
                *object = json!({});
            }
        }
        object[key] = value;
    }

    /// The scene as it stands now.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn scene(&self) -> Result<Scene> {
        load(&self.document()?, false)
    }

    /// The nodes that have the scene's lights, in their order; none if the file has no lights.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn light_nodes(&self) -> Result<Vec<usize>> {
        let doc = self.document()?;
        let tree = NodeTree::read(&doc)?;
        Ok(light::nodes(&doc, &tree).collect())
    }

    /// The file as GLB.
    pub fn to_glb(&self) -> Vec<u8> {
        let mut bytes = b"glTF".to_vec();
        let Container { mut json, bin } = self.container();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = bin.unwrap_or_default();
        bin.resize(bin.len().next_multiple_of(4), 0);
        for word in [2, 12 + 8 + json.len() + 8 + bin.len(), json.len()] {
            bytes.extend((word as u32).to_le_bytes());
        }
        bytes.extend(b"JSON");
        bytes.extend(json);
        bytes.extend((bin.len() as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(bin);
        bytes
    }

    fn container(&self) -> Container {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bin.len()}]);
        Container { json: json.to_string().into_bytes(), bin: Some(self.bin.clone()) }
    }

    fn document(&self) -> Result<Document<'_>> {
        Document::new(&self.path, self.container())
    }

    fn push(&mut self, list: &str, item: Value) -> usize {
        if !self.json[list].is_array() {
            self.json[list] = json!([]);
        }
        let items = self.json[list].as_array_mut().expect("it is one now");
        items.push(item);
        items.len() - 1
    }

    fn add_view(&mut self, bytes: &[u8], stride: Option<usize>) -> usize {
        let mut view = json!({"buffer": 0, "byteLength": bytes.len()});
        view["byteOffset"] = json!(append(&mut self.bin, bytes));
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        self.push("bufferViews", view)
    }

    /// An accessor with the elements of another one.
    fn copy_accessor(
        &mut self,
        doc: &Document,
        old: usize,
        name: &str,
        sources: &[u32],
        element: &str,
    ) -> Result<usize> {
        let reader = Reader::new(doc, Index::new(old as u32), format!("{element}.{name}"), Format::ANY)?;
        let (bytes, stride) = reader.rows(sources);
        let view = self.add_view(&bytes, Some(stride));
        let mut accessor = self.json["accessors"][old].clone();
        accessor["bufferView"] = json!(view);
        accessor["count"] = json!(sources.len());
        remove(&mut accessor, "byteOffset");
        remove(&mut accessor, "sparse");
        Ok(self.push("accessors", accessor))
    }
}

/// Adds bytes at the next multiple of four; where.
fn append(bin: &mut Vec<u8>, bytes: &[u8]) -> usize {
    bin.resize(bin.len().next_multiple_of(4), 0);
    let offset = bin.len();
    bin.extend_from_slice(bytes);
    offset
}

/// Takes extensions away, with their object if it has no others.
fn forget(item: &mut Value, extensions: &[&str]) {
    let Some(said) = item.get_mut("extensions").and_then(Value::as_object_mut) else { return };
    said.retain(|name, _| !extensions.contains(&name.as_str()));
    if said.is_empty() {
        remove(item, "extensions");
    }
}

fn remove(object: &mut Value, key: &str) {
    object.as_object_mut().map(|o| o.remove(key));
}

/// The lit triangles of a mesh.
fn parts(doc: &Document, mesh: usize) -> Result<Vec<Part>> {
    let mut parts = Vec::new();
    let mut materials = Materials::default();
    for (index, primitive) in doc.root.meshes[mesh].primitives.iter().enumerate() {
        let element = format!("meshes[{mesh}].primitives[{index}]");
        let material = materials.use_material(doc, primitive.material, &format!("{element}.material"))?;
        let material = &materials.materials[material];
        if material.unlit {
            continue;
        }
        let read = Primitive { json: primitive, name: String::new(), element, lightmapped: true };
        let (mut budget, mut warnings) = (Budget::default(), Vec::new());
        let Some(indices) = read.triangles(doc, &mut budget, &mut warnings)? else { continue };
        let positions = read.floats::<3>(doc, Semantic::Positions, Format::VEC3)?;
        let texcoords = read.floats::<2>(doc, Semantic::TexCoords(1), Format::TEXCOORD)?;
        parts.push(Part {
            primitive: index,
            positions: positions.into_iter().map(Vec3::from_array).collect(),
            texcoords: texcoords.into_iter().map(Vec2::from_array).collect(),
            indices,
            uses_texcoords: material.uses_texcoord(1),
        });
    }
    Ok(parts)
}

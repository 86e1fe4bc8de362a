//! Small valid glTF files, to be changed in one thing.

use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine;
use ontile::scene::Scene;
use serde_json::{Value, json};

pub const U8: u32 = 5121;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A file in the making: its JSON and its one buffer.
#[derive(Clone)]
pub struct Gltf {
    pub json: Value,
    pub bin: Vec<u8>,
}

/// The little-endian bytes of floats.
pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// The little-endian bytes of shorts.
pub fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A PNG with these texels.
pub fn png(width: u32, height: u32, rgba: &[u8]) -> Vec<u8> {
    let image = image::RgbaImage::from_raw(width, height, rgba.to_vec()).expect("four bytes a texel");
    encode(&image.into())
}

/// A PNG of any colour type.
pub fn encode(image: &image::DynamicImage) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).expect("PNG takes every type used here");
    bytes.into_inner()
}

pub fn data_uri(mime: &str, bytes: &[u8]) -> String {
    format!("data:{mime};base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

impl Gltf {
    /// No nodes, an empty scene.
    pub fn empty() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [], "meshes": [], "materials": [], "textures": [], "images": [], "samplers": [],
            "cameras": [], "skins": [], "accessors": [], "bufferViews": [],
        });
        Self { json, bin: Vec::new() }
    }

    /// One lit triangle in the plane z = 0, facing +Z, with 16-bit indices: mesh 0 on node 0 with material 0.
    /// Accessors: 0 positions, 1 normals, 2 texture coordinates, 3 indices.
    pub fn triangle() -> Self {
        let mut file = Self::empty();
        let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let normals = file.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        let texcoords = file.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
        let indices = file.accessor(&shorts(&[0, 1, 2]), U16, "SCALAR", 3);
        file.push("materials", json!({"pbrMetallicRoughness": {}}));
        file.push(
            "meshes",
            json!({"primitives": [{
                "attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": texcoords},
                "indices": indices,
                "material": 0,
            }]}),
        );
        file.root_node(json!({"mesh": 0}));
        file
    }

    /// Adds an item to a top-level list; its index.
    pub fn push(&mut self, list: &str, item: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("a top-level list");
        list.push(item);
        list.len() - 1
    }

    /// Adds a node to the scene.
    pub fn root_node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(json!(index));
        index
    }

    /// Adds a buffer view with these bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// Adds an accessor with a view of its own.
    pub fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let accessor = json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        self.push("accessors", accessor)
    }

    /// Adds an accessor of floats.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(&floats(values), F32, kind, values.len() / width)
    }

    /// Adds a texture of one image; its index.
    pub fn texture(&mut self, encoded: &[u8]) -> usize {
        let view = self.view(encoded);
        let image = self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        self.push("textures", json!({"source": image}))
    }

    /// The value at a JSON pointer, made if its parent is an object.
    pub fn at(&mut self, pointer: &str) -> &mut Value {
        if self.json.pointer(pointer).is_none() {
            let (parent, key) = pointer.rsplit_once('/').expect("a pointer has a slash");
            self.json.pointer_mut(parent).expect("the parent is there")[key] = Value::Null;
        }
        self.json.pointer_mut(pointer).expect("it is there now")
    }

    fn with_buffer(&self, uri: Option<&str>) -> Value {
        let mut json = self.json.clone();
        // glTF has no empty lists.
        json.as_object_mut().expect("an object").retain(|_, v| v.as_array().is_none_or(|l| !l.is_empty()));
        if !self.bin.is_empty() && json.get("buffers").is_none() {
            json["buffers"] = json!([{"byteLength": self.bin.len()}]);
        }
        if let (Some(uri), Some(buffer)) = (uri, json.pointer_mut("/buffers/0"))
            && buffer.get("uri").is_none()
        {
            buffer["uri"] = json!(uri);
        }
        json
    }

    /// The JSON with the buffer as a data URI.
    pub fn to_gltf(&self) -> Vec<u8> {
        self.with_buffer(Some(&data_uri("application/octet-stream", &self.bin))).to_string().into_bytes()
    }

    /// A GLB.
    pub fn to_glb(&self) -> Vec<u8> {
        let mut json = self.with_buffer(None).to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF".to_vec();
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

    /// Writes `name.gltf` with `name.bin` beside it.
    pub fn write_beside(&self, folder: &Path, name: &str) -> PathBuf {
        fs::write(folder.join(format!("{name}.bin")), &self.bin).expect("the folder is writable");
        let json = self.with_buffer(Some(&format!("{name}.bin"))).to_string();
        write(folder, &format!("{name}.gltf"), json.as_bytes())
    }

    /// Loads the file as `.gltf` with a data URI.
    pub fn load(&self) -> ontile::Result<Scene> {
        load_bytes("scene.gltf", &self.to_gltf())
    }

    /// The same with what animations move.
    pub fn load_moving(&self) -> ontile::Result<Scene> {
        let folder = tempfile::tempdir().expect("temporary files can be made");
        Scene::load_moving(&write(folder.path(), "scene.gltf", &self.to_gltf()))
    }
}

/// Node, path, interpolation, times, the values' type, values.
pub type Channel<'a> = (usize, &'a str, &'a str, &'a [f32], &'a str, &'a [f32]);

/// Adds an animation of these channels: node, property, interpolation, times, the type of values, values.
pub fn animate(file: &mut Gltf, channels: &[Channel]) {
    let (mut samplers, mut list): (Vec<Value>, Vec<Value>) = (Vec::new(), Vec::new());
    for (node, path, interpolation, times, kind, values) in channels {
        let (input, output) = (file.floats("SCALAR", times), file.floats(kind, values));
        list.push(json!({"sampler": samplers.len(), "target": {"node": node, "path": path}}));
        samplers.push(json!({"input": input, "output": output, "interpolation": interpolation}));
    }
    let animation = json!({"name": "go", "channels": list, "samplers": samplers});
    match file.json.get_mut("animations").and_then(Value::as_array_mut) {
        Some(animations) => animations.push(animation),
        None => file.json["animations"] = json!([animation]),
    }
}

pub fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).expect("the folder is writable");
    path
}

/// Loads a file of this name and content from a folder of its own.
pub fn load_bytes(name: &str, bytes: &[u8]) -> ontile::Result<Scene> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    Scene::load(&write(folder.path(), name, bytes))
}

//! A parsed file: its JSON, its buffers, and checked access to both.

use std::borrow::Cow;
use std::cell::{Cell, OnceCell};
use std::path::Path;

use gltf::json::validation::Checked;
use gltf::json::{self, Index, Root};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::instancing::Attributes;
use super::meshopt::Compressed;
use super::source;
use super::unknown::{Transforms, Unknown};
use crate::{Error, Result};

const SUPPORTED_EXTENSIONS: [&str; 14] = [
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_lights_punctual",
];

/// Extensions that change what is seen, but without which a file still is useful.
const LOOK_EXTENSIONS: [&str; 12] = [
    "KHR_animation_pointer",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "EXT_lights_image_based",
    "EXT_texture_avif",
    "MSFT_texture_dds",
];

/// More vertices, indices, instances or texels than any sensible scene has. Small files can ask for far more
/// by using the same data again and again.
pub const MAX_VERTICES: usize = 1 << 26;
/// See [`MAX_VERTICES`].
pub const MAX_INDICES: usize = 1 << 28;
/// See [`MAX_VERTICES`].
pub const MAX_INSTANCES: usize = 1 << 22;
/// See [`MAX_VERTICES`].
pub const MAX_TEXELS: u64 = 1 << 30;
/// See [`MAX_VERTICES`]: a kilobyte of meshopt's codes can stand for a megabyte.
const MAX_DECODED_BYTES: u64 = 1 << 31;

/// A file whose version and required extensions are known to be supported.
pub struct Document<'a> {
    pub path: &'a Path,
    pub root: Root,
    /// By material.
    pub transforms: Vec<Transforms>,
    /// By texture: see [`Unknown::sources`].
    pub sources: Vec<Option<(&'static str, Index<json::Image>)>>,
    /// By node: see [`Unknown::instancing`].
    pub instancing: Vec<Option<Attributes>>,
    /// By node: see [`Unknown::hidden`].
    pub hidden: Vec<bool>,
    /// How many channels of animations move no node.
    pub pointers: usize,
    bin: Option<Vec<u8>>,
    /// By index; read when first used.
    buffers: Vec<OnceCell<Vec<u8>>>,
    /// By buffer: see [`Unknown::fallbacks`].
    fallbacks: Vec<bool>,
    /// By buffer view: see [`Unknown::compressed`].
    compressed: Vec<Option<(&'static str, Compressed)>>,
    /// By buffer view: what is compressed, decoded when first used.
    decoded: Vec<OnceCell<Vec<u8>>>,
    decoded_bytes: Cell<u64>,
}

/// What decides whether a file can be read at all.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Option<Asset>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: Option<String>,
    min_version: Option<String>,
}

impl<'a> Document<'a> {
    /// Whether attributes may be small integers (KHR_mesh_quantization).
    pub fn is_quantized(&self) -> bool {
        let mut extensions = self.root.extensions_used.iter().chain(&self.root.extensions_required);
        extensions.any(|name| name == "KHR_mesh_quantization")
    }

    pub fn read(path: &'a Path) -> Result<Self> {
        Self::new(path, source::read_container(path)?)
    }

    /// A document of this content; `path` is for messages and for files beside it.
    pub fn new(path: &'a Path, source::Container { json, bin }: source::Container) -> Result<Self> {
        check_head(path, &json)?;
        let (root, pointers) = match serde_json::from_slice(&json) {
            Ok(root) => (root, 0),
            Err(e) => without_pointers(&json).ok_or_else(|| locate(path, &json, &e))?,
        };
        let buffers = root.buffers.iter().map(|_| OnceCell::new()).collect();
        let mut unknown: Unknown = serde_json::from_slice(&json).map_err(|e| malformed(path, &e))?;
        Ok(Self {
            path,
            sources: unknown.sources(),
            instancing: unknown.instancing(),
            hidden: unknown.hidden(),
            pointers,
            bin,
            buffers,
            fallbacks: unknown.fallbacks(),
            compressed: unknown.compressed(),
            decoded: root.buffer_views.iter().map(|_| OnceCell::new()).collect(),
            decoded_bytes: Cell::new(0),
            transforms: unknown.materials,
            root,
        })
    }

    /// An [`Error::Input`] about this file.
    pub fn bad(
        &self,
        element: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Error {
        Error::input(self.path, element, problem, remedy)
    }

    /// The item that `index` refers to; `element` is the path of the reference.
    pub fn get<'l, T>(
        &self,
        list: &'l [T],
        name: &str,
        index: Index<T>,
        element: impl Into<String>,
    ) -> Result<&'l T> {
        list.get(index.value()).ok_or_else(|| {
            let problem = format!("refers to {name}[{}], but there are {}", index.value(), list.len());
            self.bad(element, problem, "correct the index or export the file again")
        })
    }

    /// `value` unless it is one that glTF does not define.
    pub fn valid<T: Copy>(&self, value: Checked<T>, element: impl Into<String>) -> Result<T> {
        match value {
            Checked::Valid(value) => Ok(value),
            Checked::Invalid => {
                Err(self.bad(element, "has a value that glTF 2.0 does not define", "export the file again"))
            }
        }
    }

    /// `values` unless one of them is NaN or infinite.
    pub fn finite<const N: usize>(&self, values: [f32; N], element: impl Into<String>) -> Result<[f32; N]> {
        if values.iter().all(|v| v.is_finite()) {
            return Ok(values);
        }
        Err(self.bad(element, format!("{values:?} is not finite"), "replace it by finite numbers"))
    }

    /// The bytes of a buffer view.
    pub fn view(&self, index: Index<json::buffer::View>, element: &str) -> Result<&[u8]> {
        let view = self.get(&self.root.buffer_views, "bufferViews", index, element)?;
        let name = format!("bufferViews[{}]", index.value());
        if let Some((extension, said)) = &self.compressed[index.value()] {
            let cell = &self.decoded[index.value()];
            if let Some(bytes) = cell.get() {
                return Ok(bytes);
            }
            let name = format!("{name}.extensions.{extension}");
            let decoded_bytes = self.decoded_bytes.get().saturating_add(view.byte_length.0);
            if decoded_bytes > MAX_DECODED_BYTES {
                let problem = format!("brings what is decoded to more than {MAX_DECODED_BYTES} bytes");
                return Err(self.bad(name, problem, "split the scene into smaller files"));
            }
            let codes = self.range(said.buffer, said.byte_offset, said.byte_length, &name)?;
            let decoded = said.decode(codes, view.byte_length.0).map_err(|(field, problem)| {
                self.bad(format!("{name}.{field}"), problem, "compress or copy the file again")
            })?;
            self.decoded_bytes.set(decoded_bytes);
            return Ok(cell.get_or_init(|| decoded));
        }
        self.range(view.buffer, view.byte_offset.unwrap_or_default().0, view.byte_length.0, &name)
    }

    /// Bytes of a buffer, as `name` asks for them.
    fn range(&self, buffer: Index<json::Buffer>, offset: u64, length: u64, name: &str) -> Result<&[u8]> {
        let bytes = self.buffer(buffer, &format!("{name}.buffer"))?;
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
        end.map(|end| &bytes[offset as usize..end as usize]).ok_or_else(|| {
            self.bad(
                name,
                format!(
                    "bytes {offset} to {offset} + {length} lie beyond the {} of buffers[{}]",
                    bytes.len(),
                    buffer.value()
                ),
                "correct byteOffset and byteLength or export the file again",
            )
        })
    }

    fn buffer(&self, index: Index<json::Buffer>, element: &str) -> Result<&[u8]> {
        let buffer = self.get(&self.root.buffers, "buffers", index, element)?;
        let cell = &self.buffers[index.value()];
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let name = format!("buffers[{}]", index.value());
        if buffer.uri.is_none() && self.fallbacks[index.value()] {
            let problem = format!("is needed by {element}, but is a fallback without bytes");
            return Err(self.bad(name, problem, "compress the file again"));
        }
        let length = buffer.byte_length.0;
        let bytes = match (&buffer.uri, &self.bin) {
            (Some(uri), _) => Cow::Owned(source::read_uri(self.path, &format!("{name}.uri"), uri, length)?),
            (None, Some(bin)) if index.value() == 0 => Cow::Borrowed(bin.as_slice()),
            (None, _) => {
                let remedy = "give the buffer a uri, or store the file as GLB with a BIN chunk";
                return Err(self.bad(name, "has neither a uri nor a GLB BIN chunk", remedy));
            }
        };
        if (bytes.len() as u64) < length {
            let problem = format!("byteLength is {length}, but only {} bytes are there", bytes.len());
            return Err(self.bad(name, problem, "the data is truncated: export or copy it again"));
        }
        let mut bytes = bytes.into_owned();
        bytes.truncate(length as usize);
        Ok(cell.get_or_init(|| bytes))
    }

    /// A warning for each extension that is left out although it changes the look.
    pub fn extension_warnings(&self) -> Vec<String> {
        let used = self.root.extensions_used.iter();
        let mut warnings: Vec<String> = used
            .filter(|name| LOOK_EXTENSIONS.contains(&name.as_str()))
            .map(|name| format!("extensionsUsed: {name} is not supported and was left out"))
            .collect();
        if self.pointers > 0 {
            let count = self.pointers;
            warnings.push(format!(
                "animations: {count} channels that move something else than nodes were left out"
            ));
        }
        warnings
    }
}

fn check_head(path: &Path, json: &[u8]) -> Result<()> {
    let head: Head = serde_json::from_slice(json).map_err(|e| malformed(path, &e))?;
    let asset = head.asset.unwrap_or(Asset { version: None, min_version: None });
    let Some(version) = asset.version else {
        return Err(Error::input(path, "asset.version", "is missing", "use a glTF 2.0 file"));
    };
    // A later 2.x without a minVersion promises that a reader for 2.0 understands it.
    let supported = match &asset.min_version {
        Some(needed) => needed == "2.0",
        None => version.split('.').next() == Some("2"),
    };
    if !supported {
        let needed = asset.min_version.unwrap_or(version);
        let problem = format!("is glTF {needed}, but only 2.0 can be read");
        return Err(Error::input(path, "asset.version", problem, "convert the file to glTF 2.0"));
    }
    for (i, name) in head.extensions_required.iter().enumerate() {
        if SUPPORTED_EXTENSIONS.contains(&name.as_str()) {
            continue;
        }
        let remedy = match name.as_str() {
            "KHR_draco_mesh_compression" => {
                "export without Draco compression, or decompress, e.g. with `gltf-transform copy in out`"
            }
            "EXT_texture_avif" | "MSFT_texture_dds" => "store the textures as PNG, JPEG, WebP or KTX2",
            _ => "export the scene without this extension, or make it optional",
        };
        let name = source::shortened(name);
        let problem = format!("the required extension {name} is not supported");
        return Err(Error::input(path, format!("extensionsRequired[{i}]"), problem, remedy));
    }
    Ok(())
}

/// The document without the channels of animations that move no node, which the JSON library takes for damaged, and their number: glTF
/// has readers ignore what extensions let them move instead (KHR_animation_pointer). `None`: it has none, or is damaged.
fn without_pointers(json: &[u8]) -> Option<(Root, usize)> {
    let mut root: Value = serde_json::from_slice(json).ok()?;
    let mut pointers = 0;
    for animation in root.get_mut("animations")?.as_array_mut()? {
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else { continue };
        let before = channels.len();
        channels
            .retain(|channel| channel["target"]["path"].is_null() || !channel["target"]["node"].is_null());
        pointers += before - channels.len();
    }
    let root = (pointers > 0).then(|| serde_json::from_value(root).ok())??;
    Some((root, pointers))
}

fn malformed(path: &Path, error: &serde_json::Error) -> Error {
    let element = format!("JSON line {} column {}", error.line(), error.column());
    let problem = format!("cannot be parsed as glTF: {error}");
    Error::input(path, element, problem, "correct the JSON or export the file again")
}

/// Why the JSON is not a glTF document, with the top-level list item to blame if there is one.
fn locate(path: &Path, json: &[u8], error: &serde_json::Error) -> Error {
    fn first_bad<T: DeserializeOwned>(root: &Value, list: &str) -> Option<(String, serde_json::Error)> {
        let items = root.get(list)?.as_array()?;
        items.iter().enumerate().find_map(|(i, item)| {
            let error = T::deserialize(item).err()?;
            Some((format!("{list}[{i}]"), error))
        })
    }
    let Ok(root) = serde_json::from_slice::<Value>(json) else { return malformed(path, error) };
    let found = first_bad::<json::Accessor>(&root, "accessors")
        .or_else(|| first_bad::<json::Animation>(&root, "animations"))
        .or_else(|| first_bad::<json::Buffer>(&root, "buffers"))
        .or_else(|| first_bad::<json::buffer::View>(&root, "bufferViews"))
        .or_else(|| first_bad::<json::Camera>(&root, "cameras"))
        .or_else(|| first_bad::<json::Image>(&root, "images"))
        .or_else(|| first_bad::<json::Material>(&root, "materials"))
        .or_else(|| first_bad::<json::Mesh>(&root, "meshes"))
        .or_else(|| first_bad::<json::Node>(&root, "nodes"))
        .or_else(|| first_bad::<json::texture::Sampler>(&root, "samplers"))
        .or_else(|| first_bad::<json::Scene>(&root, "scenes"))
        .or_else(|| first_bad::<json::Skin>(&root, "skins"))
        .or_else(|| first_bad::<json::Texture>(&root, "textures"));
    match found {
        Some((element, error)) => {
            let problem = format!("cannot be parsed as glTF: {error}");
            Error::input(path, element, problem, "correct the JSON or export the file again")
        }
        None => malformed(path, error),
    }
}

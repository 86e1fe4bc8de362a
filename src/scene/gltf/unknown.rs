//! Extensions that the JSON library does not know, or not everywhere.

use gltf::json::extensions::texture::TextureTransform;
use gltf::json::{self, Index};
use serde::Deserialize;

use super::instancing::Attributes;
use super::meshopt::Compressed;

/// What is read beside the JSON library's document.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Unknown {
    #[serde(default)]
    pub materials: Vec<Transforms>,
    #[serde(default)]
    textures: Vec<Extended<TextureExtensions>>,
    #[serde(default)]
    buffers: Vec<Extended<BufferExtensions>>,
    #[serde(default)]
    buffer_views: Vec<Extended<ViewExtensions>>,
    #[serde(default)]
    nodes: Vec<Extended<NodeExtensions>>,
}

/// Something with extensions.
#[derive(Deserialize)]
struct Extended<T> {
    extensions: Option<T>,
}

#[derive(Deserialize)]
struct TextureExtensions {
    #[serde(rename = "KHR_texture_basisu")]
    basis: Option<Source>,
    #[serde(rename = "EXT_texture_webp")]
    webp: Option<Source>,
}

#[derive(Deserialize)]
struct Source {
    source: Option<Index<json::Image>>,
}

#[derive(Deserialize)]
struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<Visibility>,
}

#[derive(Deserialize)]
struct Instancing {
    attributes: Attributes,
}

#[derive(Deserialize)]
struct Visibility {
    visible: Option<bool>,
}

#[derive(Deserialize)]
struct BufferExtensions {
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Option<Fallback>,
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Option<Fallback>,
}

#[derive(Deserialize)]
struct Fallback {
    #[serde(default)]
    fallback: bool,
}

#[derive(Deserialize)]
struct ViewExtensions {
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Option<Compressed>,
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Option<Compressed>,
}

impl Unknown {
    /// By texture: the extension that names another image than the plain one, and which.
    pub fn sources(&self) -> Vec<Option<(&'static str, Index<json::Image>)>> {
        let source = |texture: &Extended<TextureExtensions>| {
            let TextureExtensions { basis, webp } = texture.extensions.as_ref()?;
            let named = |source: &Option<Source>, name| Some((name, source.as_ref()?.source?));
            named(basis, "KHR_texture_basisu").or(named(webp, "EXT_texture_webp"))
        };
        self.textures.iter().map(source).collect()
    }

    /// By node: the attributes of its instances.
    pub fn instancing(&mut self) -> Vec<Option<Attributes>> {
        let of = |node: &mut Extended<NodeExtensions>| {
            Some(node.extensions.as_mut()?.instancing.take()?.attributes)
        };
        self.nodes.iter_mut().map(of).collect()
    }

    /// By node: whether KHR_node_visibility hides it with all below.
    pub fn hidden(&self) -> Vec<bool> {
        let visible =
            |node: &Extended<NodeExtensions>| node.extensions.as_ref()?.visibility.as_ref()?.visible;
        self.nodes.iter().map(|node| visible(node) == Some(false)).collect()
    }

    /// By buffer: whether it is what programs read that cannot decode, and may have no bytes.
    pub fn fallbacks(&self) -> Vec<bool> {
        let is = |buffer: &Extended<BufferExtensions>| {
            let extensions = buffer.extensions.as_ref();
            extensions.is_some_and(|e| [&e.khr, &e.ext].into_iter().flatten().any(|said| said.fallback))
        };
        self.buffers.iter().map(is).collect()
    }

    /// By buffer view: the name of the extension that compresses it, and what it says.
    pub fn compressed(&mut self) -> Vec<Option<(&'static str, Compressed)>> {
        let said = |view: Extended<ViewExtensions>| {
            let ViewExtensions { khr, ext } = view.extensions?;
            let khr = khr.map(|said| ("KHR_meshopt_compression", said));
            khr.or(ext.map(|said| ("EXT_meshopt_compression", said)))
        };
        std::mem::take(&mut self.buffer_views).into_iter().map(said).collect()
    }
}

/// KHR_texture_transform of one material's normal and occlusion textures.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Transforms {
    normal_texture: Option<TextureInfo>,
    occlusion_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
struct TextureInfo {
    extensions: Option<json::extensions::texture::Info>,
}

impl Transforms {
    pub fn normal(&self) -> Option<&TextureTransform> {
        self.normal_texture.as_ref()?.extensions.as_ref()?.texture_transform.as_ref()
    }

    pub fn occlusion(&self) -> Option<&TextureTransform> {
        self.occlusion_texture.as_ref()?.extensions.as_ref()?.texture_transform.as_ref()
    }
}

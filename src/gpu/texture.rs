//! Textures of a scene on the GPU.

use super::{Device, Image, ImageDesc, Owned, Upload};
use crate::scene::{self, Wrap};
use crate::{Error, Result};
use ash::vk;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// How a texture's bytes are meant; alpha always is linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorEncoding {
    /// Colours: base colour, emissive.
    Srgb,
    /// Data: normals, roughness, metallicness, occlusion.
    Linear,
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureKey {
    /// Index into `Scene::textures`.
    pub texture: usize,
    /// Colour or data.
    pub encoding: ColorEncoding,
}

/// Images and samplers of the textures that a scene's materials use. Each picture is uploaded once per
/// encoding, each combination of filters and wrapping is one sampler.
#[derive(Debug)]
pub struct Textures {
    bindings: HashMap<TextureKey, (vk::ImageView, vk::Sampler)>,
    /// Views of level 0, for samplers that use no mips of an image that has some.
    base_views: HashMap<ImageKey, Owned<vk::ImageView>>,
    images: HashMap<ImageKey, Image>,
    samplers: SamplerCache,
}

/// Index into `Scene::images`, and its encoding.
type ImageKey = (usize, ColorEncoding);

impl Textures {
    /// Makes images for what is wanted, with a full mip chain where one of their samplers uses mips, and
    /// gathers their contents in `upload`; they can be sampled after that was recorded.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for an index out of range, a picture whose bytes do not fit its size or whose
    /// size the device does not support; [`Error::Vulkan`].
    pub fn new(
        device: &Device,
        upload: &mut Upload,
        images: &[scene::Image],
        textures: &[scene::Texture],
        wanted: &[TextureKey],
    ) -> Result<Self> {
        let mut mipped: HashMap<ImageKey, bool> = HashMap::new();
        for key in wanted {
            let texture = element(textures, key.texture, "texture")?;
            *mipped.entry((texture.image, key.encoding)).or_default() |= texture.sampler.mip_linear.is_some();
        }
        let mut all = Self {
            bindings: HashMap::new(),
            base_views: HashMap::new(),
            images: HashMap::new(),
            samplers: SamplerCache::new(device),
        };
        // In the order wanted, so that runs are alike.
        for &key in wanted {
            let texture = &textures[key.texture];
            let image_key = (texture.image, key.encoding);
            let image = match all.images.entry(image_key) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => {
                    let picture = element(images, texture.image, "image")?;
                    entry.insert(image(device, upload, picture, key.encoding, mipped[&image_key])?)
                }
            };
            let view = if texture.sampler.mip_linear.is_some() || image.levels() == 1 {
                image.view()
            } else {
                match all.base_views.entry(image_key) {
                    Entry::Occupied(entry) => entry.get().raw(),
                    Entry::Vacant(entry) => entry.insert(image.create_view(0..1, "level 0")?).raw(),
                }
            };
            all.bindings.insert(key, (view, all.samplers.get(texture.sampler)?));
        }
        Ok(all)
    }

    /// The view and sampler of a texture, in layout SHADER_READ_ONLY_OPTIMAL; `None` if it was not wanted.
    pub fn get(&self, key: TextureKey) -> Option<(vk::ImageView, vk::Sampler)> {
        self.bindings.get(&key).copied()
    }

    /// The image behind a picture (index into `Scene::images`).
    pub fn image(&self, image: usize, encoding: ColorEncoding) -> Option<&Image> {
        self.images.get(&(image, encoding))
    }

    /// The size of all images' memory.
    pub fn allocated_bytes(&self) -> u64 {
        self.images.values().map(Image::allocated_bytes).sum()
    }
}

fn image(
    device: &Device,
    upload: &mut Upload,
    picture: &scene::Image,
    encoding: ColorEncoding,
    mipped: bool,
) -> Result<Image> {
    let size = [picture.width, picture.height];
    let bytes = u64::from(size[0]) * u64::from(size[1]) * 4;
    if bytes == 0 || picture.rgba8.len() as u64 != bytes {
        return Err(Error::unsupported(
            format!(
                "image '{}' has {} bytes for {}x{} texels",
                picture.name,
                picture.rgba8.len(),
                size[0],
                size[1]
            ),
            "give four bytes a texel",
        ));
    }
    let (format, srgb) = match encoding {
        ColorEncoding::Srgb => (vk::Format::R8G8B8A8_SRGB, true),
        ColorEncoding::Linear => (vk::Format::R8G8B8A8_UNORM, false),
    };
    let levels = if mipped { scene::mip_level_count(size[0], size[1]) } else { 1 };
    // TRANSFER_SRC so that textures can be read back.
    let usage =
        vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC;
    let image =
        Image::new(device, &ImageDesc { levels, ..ImageDesc::new(&picture.name, format, size, usage) })?;
    let smaller = if mipped { scene::mipmaps(picture, srgb) } else { Vec::new() };
    let contents: Vec<&[u8]> =
        std::iter::once(&picture.rgba8[..]).chain(smaller.iter().map(|level| &level.rgba8[..])).collect();
    upload.image(&image, &contents)?;
    Ok(image)
}

fn element<'a, T>(list: &'a [T], index: usize, what: &str) -> Result<&'a T> {
    list.get(index).ok_or_else(|| {
        Error::unsupported(
            format!("{what} {index} is used, but the scene has {}", list.len()),
            "make the scene's indices refer to what it has",
        )
    })
}

/// One sampler per combination of filters and wrapping.
#[derive(Debug)]
pub struct SamplerCache {
    device: Device,
    samplers: HashMap<scene::Sampler, Owned<vk::Sampler>>,
}

impl SamplerCache {
    /// An empty cache.
    pub fn new(device: &Device) -> Self {
        Self { device: device.clone(), samplers: HashMap::new() }
    }

    /// The sampler for these settings, made at its first use; valid as long as the cache.
    ///
    /// A sampler that uses no mips differs from one that takes the nearest only by the view it goes with:
    /// level 0 alone. (Clamping the level of detail instead is slow on Mali.)
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn get(&mut self, settings: scene::Sampler) -> Result<vk::Sampler> {
        let settings = scene::Sampler { mip_linear: Some(settings.mip_linear == Some(true)), ..settings };
        match self.samplers.entry(settings) {
            Entry::Occupied(entry) => Ok(entry.get().raw()),
            Entry::Vacant(entry) => {
                // SAFETY: the structure uses no feature and no extension.
                let sampler = unsafe { self.device.create_sampler(&sampler_info(&settings), "texture") }?;
                Ok(entry.insert(sampler).raw())
            }
        }
    }

    /// The number of samplers made so far.
    pub fn len(&self) -> usize {
        self.samplers.len()
    }

    /// Whether none was made yet.
    pub fn is_empty(&self) -> bool {
        self.samplers.is_empty()
    }
}

fn sampler_info(settings: &scene::Sampler) -> vk::SamplerCreateInfo<'static> {
    let filter = |linear| if linear { vk::Filter::LINEAR } else { vk::Filter::NEAREST };
    let wrap = |wrap| match wrap {
        Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
        Wrap::MirroredRepeat => vk::SamplerAddressMode::MIRRORED_REPEAT,
        Wrap::ClampToEdge => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    };
    vk::SamplerCreateInfo::default()
        .mag_filter(filter(settings.mag_linear))
        .min_filter(filter(settings.min_linear))
        .mipmap_mode(match settings.mip_linear {
            Some(true) => vk::SamplerMipmapMode::LINEAR,
            _ => vk::SamplerMipmapMode::NEAREST,
        })
        .address_mode_u(wrap(settings.wrap_u))
        .address_mode_v(wrap(settings.wrap_v))
        // Never used by two-dimensional images; alike, because drivers like it.
        .address_mode_w(wrap(settings.wrap_u))
        .max_lod(vk::LOD_CLAMP_NONE)
}

//! Textures of a scene on the GPU.

use super::{Device, Image, ImageDesc, Owned, Upload};
use crate::scene::{self, Wrap};
use crate::{Error, Result};
use ash::vk;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

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
    images: HashMap<ImageKey, Arc<TextureImage>>,
    samplers: SamplerCache,
}

/// How the samplers of a picture use its mip levels.
#[derive(Clone, Copy, Default)]
struct Use {
    /// One uses them.
    mips: bool,
    /// One uses level 0 alone.
    base: bool,
}

impl Use {
    fn levels(self, picture: &scene::Image) -> u32 {
        if self.mips { scene::mip_level_count(picture.width, picture.height) } else { 1 }
    }

    fn has_base_view(self, picture: &scene::Image) -> bool {
        self.base && self.levels(picture) > 1
    }
}

/// A picture on the device.
#[derive(Debug)]
struct TextureImage {
    /// Of level 0, for samplers that use no mips of an image that has some.
    base_view: Option<Owned<vk::ImageView>>,
    image: Image,
}

/// Index into `Scene::images`, and its encoding.
type ImageKey = (usize, ColorEncoding);

impl Textures {
    /// Makes images for what is wanted, with a full mip chain where one of their samplers uses mips, and
    /// gathers their contents in `upload`; they can be sampled after that was recorded. Images that `kept` has as they are wanted,
    /// and whose pictures are not among its changed ones, are shared with it.
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
        kept: Option<(&Self, &[usize])>,
    ) -> Result<Self> {
        let mut uses: HashMap<ImageKey, Use> = HashMap::new();
        for key in wanted {
            let texture = element(textures, key.texture, "texture")?;
            let of_image = uses.entry((texture.image, key.encoding)).or_default();
            match texture.sampler.mip_linear {
                Some(_) => of_image.mips = true,
                None => of_image.base = true,
            }
        }
        let kept = |key: &ImageKey, picture: &scene::Image| {
            let (old, changed) = kept?;
            let wanted = uses[key];
            let is_same = |old: &&Arc<TextureImage>| {
                old.image.levels() == wanted.levels(picture)
                    && old.base_view.is_some() == wanted.has_base_view(picture)
            };
            let image = old.images.get(key).filter(is_same)?;
            (!changed.contains(&key.0)).then(|| Arc::clone(image))
        };
        let mut all =
            Self { bindings: HashMap::new(), images: HashMap::new(), samplers: SamplerCache::new(device) };
        // In the order wanted, so that runs are alike.
        for &key in wanted {
            let texture = &textures[key.texture];
            let image_key = (texture.image, key.encoding);
            let image = match all.images.entry(image_key) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => {
                    let picture = element(images, texture.image, "image")?;
                    entry.insert(match kept(&image_key, picture) {
                        Some(image) => image,
                        None => Arc::new(image(device, upload, picture, key.encoding, uses[&image_key])?),
                    })
                }
            };
            let whole = image.image.view();
            let view = match texture.sampler.mip_linear {
                Some(_) => whole,
                None => image.base_view.as_ref().map_or(whole, Owned::raw),
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
        self.images.get(&(image, encoding)).map(|image| &image.image)
    }

    /// The size of all images' memory.
    pub fn allocated_bytes(&self) -> u64 {
        self.images.values().map(|image| image.image.allocated_bytes()).sum()
    }
}

fn image(
    device: &Device,
    upload: &mut Upload,
    picture: &scene::Image,
    encoding: ColorEncoding,
    wanted: Use,
) -> Result<TextureImage> {
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
    let levels = wanted.levels(picture);
    // TRANSFER_SRC so that textures can be read back.
    let usage =
        vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC;
    let image =
        Image::new(device, &ImageDesc { levels, ..ImageDesc::new(&picture.name, format, size, usage) })?;
    let smaller = if wanted.mips { scene::mipmaps(picture, srgb) } else { Vec::new() };
    let contents: Vec<&[u8]> =
        std::iter::once(&picture.rgba8[..]).chain(smaller.iter().map(|level| &level.rgba8[..])).collect();
    upload.image(&image, &contents)?;
    let base_view = wanted.has_base_view(picture).then(|| image.create_view(0..1, "level 0")).transpose()?;
    Ok(TextureImage { base_view, image })
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

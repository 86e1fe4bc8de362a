//! Textures of a scene on the GPU.

use super::{Device, Features, Image, ImageDesc, Owned, Upload, conv};
use crate::scene::{self, Texels, TextureFormat, Wrap};
use crate::{Error, Result};
use ash::vk;
use std::borrow::Cow;
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
        match &picture.texels {
            _ if !self.mips => 1,
            Texels::Rgba8(_) => scene::mip_level_count(picture.width, picture.height),
            Texels::Stored(stored) => stored.levels(),
        }
    }

    fn has_base_view(self, picture: &scene::Image) -> bool {
        self.base && self.levels(picture) > 1
    }
}

/// What the device is given of a picture: the first of its formats that is enabled there.
fn format(enabled: Features, picture: &scene::Image) -> TextureFormat {
    use TextureFormat as T;
    let is_enabled = |format: &T| match format {
        T::Rgba8 => true,
        T::Bc1 | T::Bc1Alpha | T::Bc3 | T::Bc7 => enabled.texture_compression_bc,
        T::Etc2 | T::Etc2Mask | T::Etc2Alpha => enabled.texture_compression_etc2,
        T::Astc(_) => enabled.texture_compression_astc,
    };
    match &picture.texels {
        Texels::Rgba8(_) => T::Rgba8,
        Texels::Stored(stored) => stored.formats().into_iter().find(is_enabled).unwrap_or(T::Rgba8),
    }
}

/// How each picture is used that is wanted.
fn uses(textures: &[scene::Texture], wanted: &[TextureKey]) -> Result<HashMap<ImageKey, Use>> {
    let mut uses: HashMap<ImageKey, Use> = HashMap::new();
    for key in wanted {
        let texture = element(textures, key.texture, "texture")?;
        let of_image = uses.entry((texture.image, key.encoding)).or_default();
        match texture.sampler.mip_linear {
            Some(_) => of_image.mips = true,
            None => of_image.base = true,
        }
    }
    Ok(uses)
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
        let uses = uses(textures, wanted)?;
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

    /// What the images of all that is wanted would hold, with their mip levels.
    pub(super) fn bytes(
        enabled: Features,
        images: &[scene::Image],
        textures: &[scene::Texture],
        wanted: &[TextureKey],
    ) -> Result<u64> {
        let bytes = |(&(image, _), of_image): (&ImageKey, &Use)| {
            let picture = element(images, image, "image")?;
            let (format, size) = (format(enabled, picture), [picture.width, picture.height]);
            let level = |level| format.level_bytes(scene::level_size(size, level));
            Ok((0..of_image.levels(picture)).map(level).sum::<u64>())
        };
        uses(textures, wanted)?.iter().map(bytes).sum()
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
    picture.check()?;
    let srgb = encoding == ColorEncoding::Srgb;
    let format = format(device.features(), picture);
    let levels = wanted.levels(picture);
    // TRANSFER_SRC so that textures can be read back.
    let usage =
        vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC;
    let texels = conv::texture_format(format, srgb);
    let image =
        Image::new(device, &ImageDesc { levels, ..ImageDesc::new(&picture.name, texels, size, usage) })?;
    let contents: Vec<Cow<[u8]>> = match &picture.texels {
        Texels::Stored(stored) => (0..levels).map(|level| stored.level(level, format)).collect(),
        Texels::Rgba8(whole) => {
            let smaller = if wanted.mips { scene::mipmaps(picture, srgb) } else { Vec::new() };
            let smaller = smaller.into_iter().map(|level| level.rgba8.into());
            std::iter::once(whole.into()).chain(smaller).collect()
        }
    };
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
        let most = match self.device.features().sampler_anisotropy {
            true => self.device.caps().max_sampler_anisotropy as u8,
            false => 1,
        };
        let settings = scene::Sampler {
            mip_linear: Some(settings.mip_linear == Some(true)),
            max_anisotropy: settings.max_anisotropy.clamp(1, most),
            ..settings
        };
        match self.samplers.entry(settings) {
            Entry::Occupied(entry) => Ok(entry.get().raw()),
            Entry::Vacant(entry) => {
                // SAFETY: the structure uses no extension, and anisotropy only where it is enabled.
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
        .anisotropy_enable(settings.max_anisotropy > 1)
        .max_anisotropy(settings.max_anisotropy.into())
        .max_lod(vk::LOD_CLAMP_NONE)
}

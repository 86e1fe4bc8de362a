//! Surfaces: glTF 2.0 metallic-roughness, its five textures, and how they are sampled.

use glam::{Vec2, Vec3, Vec4};

use super::{Texels, Transmission};
use crate::{Error, Result};

/// A surface as glTF 2.0 section 3.9 describes it.
#[derive(Clone, Debug)]
pub struct Material {
    /// A name for messages.
    pub name: String,
    /// Linear Rec.709 and alpha; multiplies `base_color_texture` and the vertex colour.
    pub base_color_factor: Vec4,
    /// sRGB-encoded colour, linear alpha.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric to 1 metal; multiplies the texture's blue.
    pub metallic_factor: f32,
    /// Perceptual roughness (alpha = roughness²); multiplies the texture's green.
    pub roughness_factor: f32,
    /// Green roughness, blue metallicness; linear.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normals; linear.
    pub normal_texture: Option<TextureRef>,
    /// Scales x and y of the sampled normal.
    pub normal_scale: f32,
    /// Red occlusion; linear. It dims ambient light only.
    pub occlusion_texture: Option<TextureRef>,
    /// 0 ignores the occlusion texture, 1 applies it fully.
    pub occlusion_strength: f32,
    /// Linear Rec.709 in cd/m², KHR_materials_emissive_strength multiplied in.
    pub emissive_factor: Vec3,
    /// sRGB-encoded; multiplied by `emissive_factor`.
    pub emissive_texture: Option<TextureRef>,
    /// How alpha is used.
    pub alpha_mode: AlphaMode,
    /// Drawn from both sides; the normal faces the viewer.
    pub double_sided: bool,
    /// KHR_materials_unlit: the base colour is shown as it is.
    pub unlit: bool,
    /// Light goes through it; without effect where it is unlit.
    pub transmission: Option<Transmission>,
}

impl Default for Material {
    /// glTF's default material: white, metallic 1, roughness 1, opaque, single-sided.
    fn default() -> Self {
        Self {
            name: "default".into(),
            base_color_factor: Vec4::ONE,
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive_factor: Vec3::ZERO,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            transmission: None,
        }
    }
}

impl Material {
    /// The transmission, if any light goes through.
    pub fn transmits(&self) -> Option<&Transmission> {
        self.transmission.as_ref().filter(|t| t.factor > 0.0 && !self.unlit)
    }

    /// Whether something is seen behind it: it transmits, or is blended over that. It casts no shadow then.
    pub fn shows_behind(&self) -> bool {
        self.alpha_mode == AlphaMode::Blend || self.transmits().is_some()
    }
}

/// What alpha does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Fragments with alpha below `cutoff` are discarded.
    Mask {
        /// Compared with the product of factor, texture and vertex alpha.
        cutoff: f32,
    },
    /// Alpha is coverage: the surface's light is laid over what is behind, as much of it as alpha says ("over", Porter and Duff
    /// 1984). Such surfaces receive shadows and cast none, since a depth cannot hold a part of a shadow.
    Blend,
}

/// A texture as one material slot uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into `Scene::textures`.
    pub texture: usize,
    /// Which of `Mesh::texcoords` is used: 0 or 1.
    pub texcoord: usize,
    /// KHR_texture_transform as two rows: `uv = (dot(row[0], (u, v, 1)), dot(row[1], (u, v, 1)))`.
    pub uv_from_texcoord: [Vec3; 2],
}

impl TextureRef {
    /// The transform that changes nothing.
    pub const IDENTITY: [Vec3; 2] = [Vec3::X, Vec3::Y];

    /// The texture coordinate that is sampled for this mesh coordinate.
    pub fn uv(&self, texcoord: Vec2) -> Vec2 {
        let h = texcoord.extend(1.0);
        Vec2::new(self.uv_from_texcoord[0].dot(h), self.uv_from_texcoord[1].dot(h))
    }
}

/// A picture and how to sample it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Texture {
    /// Index into `Scene::images`.
    pub image: usize,
    /// Filtering and wrapping.
    pub sampler: Sampler,
}

/// glTF's sampler, with filters said separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// Linear (else nearest) when magnified.
    pub mag_linear: bool,
    /// Linear (else nearest) when minified, within one mip level.
    pub min_linear: bool,
    /// Between mip levels: `None` uses level 0 only, `Some(true)` blends, `Some(false)` takes the nearest.
    pub mip_linear: Option<bool>,
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// Where a pixel covers a long, narrow part of the picture, at most so many samples along it keep what runs across it sharp
    /// (Vulkan 1.3, section 16.8.2): 1 for none, up to 16; a device may do with less.
    pub max_anisotropy: u8,
}

impl Default for Sampler {
    /// Trilinear and repeating: what this project does where glTF leaves the choice open.
    fn default() -> Self {
        Self {
            mag_linear: true,
            min_linear: true,
            mip_linear: Some(true),
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            max_anisotropy: 1,
        }
    }
}

/// What lies outside [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// The picture again, every other time mirrored.
    MirroredRepeat,
    /// The edge texels.
    ClampToEdge,
}

/// A picture of 8 bits a channel.
#[derive(Clone, Debug)]
pub struct Image {
    /// A name for messages.
    pub name: String,
    /// Texels, at least 1.
    pub width: u32,
    /// Texels, at least 1.
    pub height: u32,
    /// As bytes, or as blocks that a GPU decodes.
    pub texels: Texels,
}

impl Image {
    /// `width * height * 4` bytes, rows from the top: red, green, blue, alpha, as encoded in the file. What is compressed is
    /// decoded at the first call.
    pub fn rgba8(&self) -> &[u8] {
        match &self.texels {
            Texels::Rgba8(bytes) => bytes,
            Texels::Stored(stored) => stored.rgba8(),
        }
    }

    /// The same, to be changed; what is compressed is plain from then on.
    pub fn rgba8_mut(&mut self) -> &mut [u8] {
        if let Texels::Stored(stored) = &self.texels {
            self.texels = stored.rgba8().to_vec().into();
        }
        match &mut self.texels {
            Texels::Rgba8(bytes) => bytes,
            Texels::Stored(_) => unreachable!("it is plain now"),
        }
    }

    /// # Errors
    /// [`Error::Unsupported`] for texels that are not of its size.
    pub(crate) fn check(&self) -> Result<()> {
        let wrong = |problem| {
            Error::unsupported(format!("image '{}': {problem}", self.name), "give as many as its size says")
        };
        self.problem().map_or(Ok(()), |problem| Err(wrong(problem)))
    }

    /// What is wrong with it, if anything: texels that are not of its size.
    pub(crate) fn problem(&self) -> Option<String> {
        let size = format!("{}x{} texels", self.width, self.height);
        match &self.texels {
            Texels::Rgba8(bytes) => {
                let expected = u64::from(self.width) * u64::from(self.height) * 4;
                (expected == 0 || bytes.len() as u64 != expected)
                    .then(|| format!("{} bytes are not four for each of {size}", bytes.len()))
            }
            Texels::Stored(stored) => (stored.size() != [self.width, self.height])
                .then(|| format!("the compressed picture has {:?} texels, not {size}", stored.size())),
        }
    }
}

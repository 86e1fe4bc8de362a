//! Materials, textures and samplers; only those that something drawn uses.
//!
//! | `extras.ontile` of a sampler | value | without it |
//! |---|---|---|
//! | `anisotropy` | how many samples it takes at most: 1 to 16 | 1 |

use std::collections::HashMap;
use std::hash::Hash;

use glam::{Vec2, Vec3, Vec4};
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::texture::{MagFilter, MinFilter, WrappingMode};
use gltf::json::{self, Index};

use super::document::Document;
use super::extras::Extras;
use crate::Result;
use crate::scene::{AlphaMode, Material, Sampler, Texture, TextureRef, Transmission, Wrap};

/// What the JSON says about a material's use of a texture.
struct Slot<'a> {
    texture: Index<json::Texture>,
    texcoord: u32,
    transform: Option<&'a TextureTransform>,
    /// For messages.
    element: String,
}

/// The materials and textures that have been used so far.
#[derive(Default)]
pub struct Materials {
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    /// For each image of the scene, the glTF image it comes from.
    pub images: Vec<usize>,
    pub warnings: Vec<String>,
    by_index: HashMap<Option<usize>, usize>,
    texture_indices: HashMap<Texture, usize>,
    image_indices: HashMap<usize, usize>,
}

impl Materials {
    /// The scene's material for a glTF material; `None` is the default material.
    pub fn use_material(
        &mut self,
        doc: &Document,
        index: Option<Index<json::Material>>,
        element: &str,
    ) -> Result<usize> {
        let key = index.map(|i| i.value());
        if let Some(&known) = self.by_index.get(&key) {
            return Ok(known);
        }
        let material = match index {
            Some(index) => {
                let found = doc.get(&doc.root.materials, "materials", index, element)?;
                self.read(doc, found, index.value())?
            }
            None => Material::default(),
        };
        self.materials.push(material);
        self.by_index.insert(key, self.materials.len() - 1);
        Ok(self.materials.len() - 1)
    }

    fn read(&mut self, doc: &Document, material: &json::Material, index: usize) -> Result<Material> {
        let at = |field: &str| format!("materials[{index}].{field}");
        let pbr = &material.pbr_metallic_roughness;
        let extensions = material.extensions.as_ref();
        let factor = doc.finite(pbr.base_color_factor.0, at("pbrMetallicRoughness.baseColorFactor"))?;
        let factor = self.within_unit(factor, at("pbrMetallicRoughness.baseColorFactor"));
        let base_color_slot =
            pbr.base_color_texture.as_ref().map(|t| slot(t, at("pbrMetallicRoughness.baseColorTexture")));
        let shared = Material {
            name: material.name.clone().unwrap_or_else(|| format!("material {index}")),
            base_color_factor: Vec4::from_array(factor),
            base_color_texture: self.use_texture(doc, base_color_slot)?,
            alpha_mode: self.alpha_mode(doc, material, index)?,
            double_sided: material.double_sided,
            unlit: extensions.is_some_and(|e| e.unlit.is_some()),
            ..Material::default()
        };
        // KHR_materials_unlit: everything else is for renderers that do not know the extension.
        if shared.unlit {
            return Ok(shared);
        }

        let mut unit = |value: f32, field: &str| -> Result<f32> {
            let value = doc.finite([value], at(field))?;
            Ok(self.within_unit(value, at(field))[0])
        };
        let metallic_factor = unit(pbr.metallic_factor.0, "pbrMetallicRoughness.metallicFactor")?;
        let roughness_factor = unit(pbr.roughness_factor.0, "pbrMetallicRoughness.roughnessFactor")?;
        let occlusion_strength = match &material.occlusion_texture {
            Some(t) => unit(t.strength.0, "occlusionTexture.strength")?,
            None => 1.0,
        };
        let normal_scale = match &material.normal_texture {
            Some(t) => doc.finite([t.scale], at("normalTexture.scale"))?[0],
            None => 1.0,
        };
        let emissive_factor = self.emissive_factor(doc, material, index)?;

        let transforms = doc.transforms.get(index);
        let metallic_roughness = pbr
            .metallic_roughness_texture
            .as_ref()
            .map(|t| slot(t, at("pbrMetallicRoughness.metallicRoughnessTexture")));
        let normal = material.normal_texture.as_ref().map(|t| Slot {
            texture: t.index,
            texcoord: t.tex_coord,
            transform: transforms.and_then(|t| t.normal()),
            element: at("normalTexture"),
        });
        let occlusion = material.occlusion_texture.as_ref().map(|t| Slot {
            texture: t.index,
            texcoord: t.tex_coord,
            transform: transforms.and_then(|t| t.occlusion()),
            element: at("occlusionTexture"),
        });
        let emissive = material.emissive_texture.as_ref().map(|t| slot(t, at("emissiveTexture")));
        let emits = emissive_factor != Vec3::ZERO;
        Ok(Material {
            metallic_factor,
            roughness_factor,
            metallic_roughness_texture: self.use_texture(doc, metallic_roughness)?,
            normal_texture: self.use_texture(doc, normal)?,
            normal_scale,
            occlusion_texture: self.use_texture(doc, occlusion)?,
            occlusion_strength,
            emissive_factor,
            emissive_texture: self.use_texture(doc, emissive.filter(|_| emits))?,
            transmission: self.transmission(doc, material, index)?,
            ..shared
        })
    }

    fn emissive_factor(&mut self, doc: &Document, material: &json::Material, index: usize) -> Result<Vec3> {
        let strength = material.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |s| s.emissive_strength.0);
        let element = format!("materials[{index}].emissiveFactor");
        let factor = Vec3::from_array(doc.finite(material.emissive_factor.0, &element)?) * strength;
        doc.finite(factor.to_array(), format!("{element} times emissiveStrength"))?;
        if factor.min_element() < 0.0 {
            self.warnings.push(format!("{element}: {factor} is negative and was raised to 0"));
        }
        Ok(factor.max(Vec3::ZERO))
    }

    /// KHR_materials_transmission with KHR_materials_volume and KHR_materials_ior, of which the last two say nothing without the first.
    fn transmission(
        &mut self,
        doc: &Document,
        material: &json::Material,
        index: usize,
    ) -> Result<Option<Transmission>> {
        let at = |field: &str| format!("materials[{index}].extensions.{field}");
        let Some(extensions) = material.extensions.as_ref() else { return Ok(None) };
        let Some(transmission) = extensions.transmission.as_ref() else {
            if extensions.volume.is_some() || extensions.ior.is_some() {
                let element = format!("materials[{index}].extensions");
                let what = "KHR_materials_volume and KHR_materials_ior without KHR_materials_transmission";
                self.warnings.push(format!("{element}: {what} were left out"));
            }
            return Ok(None);
        };
        let field = at("KHR_materials_transmission.transmissionFactor");
        let [factor] = self.within_unit(doc.finite([transmission.transmission_factor.0], &field)?, field);
        let mut read = Transmission { factor, ..Transmission::default() };
        let mut left_out = |texture: &Option<json::texture::Info>, field: &str| {
            if texture.is_some() {
                self.warnings.push(format!("{}: is not supported; texture left out", at(field)));
            }
        };
        left_out(&transmission.transmission_texture, "KHR_materials_transmission.transmissionTexture");
        if let Some(volume) = &extensions.volume {
            left_out(&volume.thickness_texture, "KHR_materials_volume.thicknessTexture");
            let volume_at = |field: &str| at(&format!("KHR_materials_volume.{field}"));
            [read.thickness_m] = doc.finite([volume.thickness_factor.0], volume_at("thicknessFactor"))?;
            let color = doc.finite(volume.attenuation_color.0, volume_at("attenuationColor"))?;
            read.attenuation_color = self.within_unit(color, volume_at("attenuationColor")).into();
            read.attenuation_distance_m = volume.attenuation_distance.0;
        }
        if let Some(ior) = &extensions.ior {
            [read.ior] = doc.finite([ior.ior.0], at("KHR_materials_ior.ior"))?;
        }
        match read.problem() {
            Some(problem) => {
                let remedy = "correct the values of KHR_materials_volume and KHR_materials_ior there";
                Err(doc.bad(format!("materials[{index}].extensions"), problem, remedy))
            }
            None => Ok(Some(read)),
        }
    }

    fn alpha_mode(&mut self, doc: &Document, material: &json::Material, index: usize) -> Result<AlphaMode> {
        use json::material::AlphaMode as A;
        let element = format!("materials[{index}].alphaMode");
        Ok(match doc.valid(material.alpha_mode, &element)? {
            A::Opaque => AlphaMode::Opaque,
            A::Mask => {
                let cutoff = material.alpha_cutoff.map_or(0.5, |c| c.0);
                let [cutoff] = doc.finite([cutoff], format!("materials[{index}].alphaCutoff"))?;
                AlphaMode::Mask { cutoff }
            }
            A::Blend => AlphaMode::Blend,
        })
    }

    fn within_unit<const N: usize>(&mut self, values: [f32; N], element: String) -> [f32; N] {
        let clamped = values.map(|v| v.clamp(0.0, 1.0));
        if clamped != values {
            self.warnings.push(format!("{element}: {values:?} was clamped to [0, 1]"));
        }
        clamped
    }

    fn use_texture(&mut self, doc: &Document, slot: Option<Slot>) -> Result<Option<TextureRef>> {
        let Some(Slot { texture, texcoord, transform, element }) = slot else { return Ok(None) };
        let texcoord = transform.and_then(|t| t.tex_coord).unwrap_or(texcoord) as usize;
        if texcoord > 1 {
            self.warnings.push(format!("{element}: TEXCOORD_{texcoord} is not supported; texture left out"));
            return Ok(None);
        }
        let image = self.use_image(doc, texture, &format!("{element}.index"))?;
        let name = format!("textures[{}]", texture.value());
        let sampler = match doc.root.textures[texture.value()].sampler {
            Some(index) => {
                let json = doc.get(&doc.root.samplers, "samplers", index, format!("{name}.sampler"))?;
                read_sampler(doc, json, index.value())?
            }
            None => Sampler::default(),
        };
        let texture = index_of(&mut self.textures, &mut self.texture_indices, Texture { image, sampler });
        let uv_from_texcoord = match transform {
            Some(transform) => uv_rows(doc, transform, &element)?,
            None => TextureRef::IDENTITY,
        };
        Ok(Some(TextureRef { texture, texcoord, uv_from_texcoord }))
    }

    /// The scene's image for a glTF texture; `element` is the path of the reference.
    pub fn use_image(
        &mut self,
        doc: &Document,
        texture: Index<json::Texture>,
        element: &str,
    ) -> Result<usize> {
        let found = doc.get(&doc.root.textures, "textures", texture, element)?;
        let name = format!("textures[{}]", texture.value());
        // The plain source is for readers that do not know the extension.
        let (source, element) = match doc.sources[texture.value()] {
            Some((extension, source)) => (source, format!("{name}.extensions.{extension}.source")),
            None => (found.source, format!("{name}.source")),
        };
        // The JSON library's way to say that there is no source.
        if source.value() == u32::MAX as usize {
            return Err(doc.bad(
                element,
                "is missing",
                "give it a PNG, JPEG, WebP or KTX2 image as its source",
            ));
        }
        doc.get(&doc.root.images, "images", source, element)?;
        Ok(index_of(&mut self.images, &mut self.image_indices, source.value()))
    }
}

fn slot(info: &json::texture::Info, element: String) -> Slot<'_> {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
    Slot { texture: info.index, texcoord: info.tex_coord, transform, element }
}

/// KHR_texture_transform: scale, then rotation, then offset. With v pointing down as it does in glTF, a
/// counter-clockwise rotation takes (1, 0) to (cos, -sin).
fn uv_rows(doc: &Document, transform: &TextureTransform, element: &str) -> Result<[Vec3; 2]> {
    let at = |field: &str| format!("{element}.extensions.KHR_texture_transform.{field}");
    let offset = Vec2::from_array(doc.finite(transform.offset.0, at("offset"))?);
    let scale = Vec2::from_array(doc.finite(transform.scale.0, at("scale"))?);
    let [rotation] = doc.finite([transform.rotation.0], at("rotation"))?;
    let (sin, cos) = rotation.sin_cos();
    Ok([
        Vec3::new(cos * scale.x, sin * scale.y, offset.x),
        Vec3::new(-sin * scale.x, cos * scale.y, offset.y),
    ])
}

fn read_sampler(doc: &Document, sampler: &json::texture::Sampler, index: usize) -> Result<Sampler> {
    let at = |field: &str| format!("samplers[{index}].{field}");
    let default = Sampler::default();
    let extras = Extras::read(doc, &[(&sampler.extras, format!("samplers[{index}]"))], &["anisotropy"])?;
    let mag_linear = match sampler.mag_filter {
        Some(filter) => doc.valid(filter, at("magFilter"))? == MagFilter::Linear,
        None => default.mag_linear,
    };
    let (min_linear, mip_linear) = match sampler.min_filter {
        Some(filter) => match doc.valid(filter, at("minFilter"))? {
            MinFilter::Nearest => (false, None),
            MinFilter::Linear => (true, None),
            MinFilter::NearestMipmapNearest => (false, Some(false)),
            MinFilter::LinearMipmapNearest => (true, Some(false)),
            MinFilter::NearestMipmapLinear => (false, Some(true)),
            MinFilter::LinearMipmapLinear => (true, Some(true)),
        },
        None => (default.min_linear, default.mip_linear),
    };
    let wrap = |mode| match mode {
        WrappingMode::ClampToEdge => Wrap::ClampToEdge,
        WrappingMode::MirroredRepeat => Wrap::MirroredRepeat,
        WrappingMode::Repeat => Wrap::Repeat,
    };
    Ok(Sampler {
        mag_linear,
        min_linear,
        mip_linear,
        wrap_u: wrap(doc.valid(sampler.wrap_s, at("wrapS"))?),
        wrap_v: wrap(doc.valid(sampler.wrap_t, at("wrapT"))?),
        max_anisotropy: extras.number_or("anisotropy", 1.0, " from 1 to 16", |v| (1.0..=16.0).contains(&v))?
            as u8,
    })
}

/// The position of `item` in `list`, to which it is added if it is new.
fn index_of<T: Copy + Eq + Hash>(list: &mut Vec<T>, indices: &mut HashMap<T, usize>, item: T) -> usize {
    *indices.entry(item).or_insert_with(|| {
        list.push(item);
        list.len() - 1
    })
}

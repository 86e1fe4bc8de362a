//! What surfaces sample to receive light from all around: the table of albedos, the environment and the lightmap.

use std::sync::Arc;

use ash::vk;

use super::descriptor::Content;
use super::shader::shared;
use super::shared::EnvironmentUniforms;
use super::{Buffer, BufferDesc, Device, Image, ImageDesc, MemoryUse, Owned, Upload, conv};
use crate::environment::{Prefiltered, split_sum};
use crate::plan::Plan;
use crate::scene::{Environment, Lightmap, Scene};
use crate::{Error, Result};

/// Images and numbers of the plan's `around`; nothing where the plan has none.
#[derive(Default)]
pub(super) struct AroundData {
    split_sum: Option<Image>,
    environment: Option<EnvironmentData>,
    lightmap: Option<Image>,
    /// Linear, clamped; there if any image is.
    sampler: Option<Owned<vk::Sampler>>,
}

struct EnvironmentData {
    uniforms: Buffer,
    radiance: Image,
}

const USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::SAMPLED.as_raw() | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

impl AroundData {
    pub(super) fn new(device: &Device, upload: &mut Upload, scene: &Scene, plan: &Plan) -> Result<Self> {
        if plan.around.is_empty() {
            return Ok(Self::default());
        }
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
            .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .max_lod(vk::LOD_CLAMP_NONE);
        // SAFETY: the structure uses no feature and no extension.
        let sampler = unsafe { device.create_sampler(&info, "around") }?;
        let environment = scene.environment.as_ref().filter(|_| plan.needs.environment.is_some());
        let lightmap = scene.lightmap.as_ref().filter(|_| plan.needs.lightmap.is_some());
        let reflects = plan.needs.kinds.iter().any(|need| need.kind.around.any());
        Ok(Self {
            split_sum: reflects.then(|| split_sum_table(device, upload)).transpose()?,
            lightmap: lightmap.map(|map| lightmap_image(device, upload, map, plan)).transpose()?,
            environment: environment.map(|e| EnvironmentData::new(device, upload, e, plan)).transpose()?,
            sampler: Some(sampler),
        })
    }

    /// What a binding of `SET_FRAME` is written with, if it is one of these.
    pub(super) fn content(&self, binding: u32) -> Option<Content<'_>> {
        let environment = self.environment.as_ref();
        let image = match binding {
            b if b == const { shared("BINDING_SPLIT_SUM") } => self.split_sum.as_ref()?,
            b if b == const { shared("BINDING_RADIANCE") } => &environment?.radiance,
            b if b == const { shared("BINDING_LIGHTMAP") } => self.lightmap.as_ref()?,
            b if b == const { shared("BINDING_ENVIRONMENT") } => {
                let uniforms = &environment?.uniforms;
                return Some(Content::Buffer(uniforms, 0, uniforms.size_bytes()));
            }
            _ => return None,
        };
        let info = vk::DescriptorImageInfo::default()
            .image_view(image.view())
            .sampler(self.sampler.as_ref()?.raw())
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        Some(Content::Images(vec![info]))
    }

    /// Device memory of images and buffers.
    pub(super) fn allocated_bytes(&self) -> u64 {
        let environment = self.environment.as_ref();
        let images = self.split_sum.iter().chain(environment.map(|e| &e.radiance));
        let images = images.chain(&self.lightmap);
        images.map(Image::allocated_bytes).sum::<u64>()
            + environment.map_or(0, |e| e.uniforms.allocated_bytes())
    }
}

fn split_sum_table(device: &Device, upload: &mut Upload) -> Result<Image> {
    let size = [split_sum::SIZE as u32; 2];
    let table = Image::new(device, &ImageDesc::new("split sum", vk::Format::R16G16_SFLOAT, size, USAGE))?;
    upload.image(&table, &[split_sum::TABLE])?;
    Ok(table)
}

fn lightmap_image(device: &Device, upload: &mut Upload, map: &Lightmap, plan: &Plan) -> Result<Image> {
    let size = [map.width, map.height];
    let texels = map.width as usize * map.height as usize;
    if texels == 0 || map.color_rgba8.len() != texels * 4 || map.scale8.len() != texels {
        let (colors, scales) = (map.color_rgba8.len(), map.scale8.len());
        return Err(Error::unsupported(
            format!("the lightmap has {colors} and {scales} bytes for {}x{} texels", size[0], size[1]),
            "give four bytes of colour and one of scale a texel",
        ));
    }
    let format = plan.options.lightmap_format;
    let image = Image::new(device, &ImageDesc::new("lightmap", conv::radiance_format(format), size, USAGE))?;
    upload.image(&image, &[&map.texels(format)])?;
    Ok(image)
}

impl EnvironmentData {
    fn new(device: &Device, upload: &mut Upload, environment: &Environment, plan: &Plan) -> Result<Self> {
        let prefiltered = prefiltered(environment, plan)?;
        let levels = prefiltered.levels();
        let size = [prefiltered.face_size(); 2];
        let format = conv::radiance_format(prefiltered.format());
        let desc = ImageDesc {
            levels: levels.len() as u32,
            layers: 6,
            cube: true,
            ..ImageDesc::new("radiance", format, size, USAGE)
        };
        let radiance = Image::new(device, &desc)?;
        upload.image(&radiance, &levels.iter().map(Vec::as_slice).collect::<Vec<_>>())?;
        let content = uniforms(environment, &prefiltered);
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let bytes = size_of::<EnvironmentUniforms>() as u64;
        let desc = BufferDesc { name: "environment", bytes, usage, memory: MemoryUse::Device };
        let buffer = Buffer::new(device, &desc)?;
        upload.buffer(&buffer, 0, bytemuck::bytes_of(&content))?;
        Ok(Self { uniforms: buffer, radiance })
    }
}

/// What the scene brings, else made of its panorama.
fn prefiltered(environment: &Environment, plan: &Plan) -> Result<Arc<Prefiltered>> {
    let texels = plan.environment_texels();
    match (&environment.prefiltered, &environment.panorama, texels) {
        (Some(prefiltered), ..) => Ok(prefiltered.clone()),
        (None, Some(panorama), Some((format, size))) => {
            Ok(Arc::new(Prefiltered::new(panorama, size, format)))
        }
        _ => Err(Error::unsupported(
            format!("environment '{}' has neither a panorama nor anything made of one", environment.name),
            "give it one of them",
        )),
    }
}

fn uniforms(environment: &Environment, prefiltered: &Prefiltered) -> EnvironmentUniforms {
    let (sin, cos) = f64::from(environment.rotation_deg).to_radians().sin_cos();
    EnvironmentUniforms {
        irradiance: prefiltered.irradiance().map(|c| (c * environment.intensity).extend(0.0).to_array()),
        rotation: [cos as f32, sin as f32],
        scale: prefiltered.scale() * environment.intensity,
        last_level: (prefiltered.levels().len() - 1) as f32,
    }
}

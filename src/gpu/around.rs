//! What surfaces sample to receive light from all around: the table of albedos, the environment, probes and the lightmap.

use std::borrow::Cow;

use ash::vk;

use super::descriptor::Content;
use super::shader::shared;
use super::shared::{EnvironmentUniforms, ProbeData};
use super::{Buffer, BufferDesc, Cubes, Device, Image, ImageDesc, MemoryUse, Owned, Upload, conv};
use crate::environment::{Prefiltered, split_sum};
use crate::plan::{AroundImage, Plan};
use crate::scene::{Environment, Lightmap, Probe, Scene};
use crate::{Error, Result};

/// Images and numbers of the plan's `around`; nothing where the plan has none.
#[derive(Default)]
pub(super) struct AroundData {
    /// The plan's list, without reasons.
    images: Vec<AroundImage>,
    split_sum: Option<Image>,
    radiance: Option<Image>,
    environment: Option<Buffer>,
    probes: Option<Buffer>,
    lightmap: Option<Image>,
    /// Linear, clamped; there if any image is.
    sampler: Option<Owned<vk::Sampler>>,
}

const USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::SAMPLED.as_raw() | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

impl AroundData {
    pub(super) fn new(device: &Device, upload: &mut Upload, scene: &Scene, plan: &Plan) -> Result<Self> {
        if plan.around.is_empty() {
            return Ok(Self::default());
        }
        let has_probes = !plan.needs.probes.is_empty();
        let environment = scene.environment.as_ref().filter(|_| plan.needs.environment.is_some());
        let probes = if has_probes { &scene.probes[..] } else { &[] };
        probes.iter().try_for_each(Probe::check)?;
        let lightmap = scene.lightmap.as_ref().filter(|_| plan.needs.lightmap.is_some());
        let has_table = plan.around.iter().any(|image| image.name == "split_sum");
        let mut data = Self {
            images: without_reasons(plan),
            split_sum: has_table.then(|| split_sum_table(device, upload)).transpose()?,
            lightmap: lightmap.map(|map| lightmap_image(device, upload, map, plan)).transpose()?,
            sampler: Some(edge_sampler(device, "around")?),
            ..Self::default()
        };
        let all = environment.into_iter().chain(probes.iter().map(|probe| &probe.environment));
        let filtered: Vec<_> = all.map(|e| prefiltered(e, plan)).collect::<Result<_>>()?;
        if filtered.is_empty() {
            return Ok(data);
        }
        data.radiance = Some(radiance(device, upload, plan, &filtered)?);
        let content = environment_uniforms(environment, &filtered[0]);
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER;
        data.environment = Some(buffer(device, upload, "environment", usage, bytemuck::bytes_of(&content))?);
        if has_probes {
            let of_probes = &filtered[filtered.len() - probes.len()..];
            let content: Vec<_> = probes.iter().zip(of_probes).map(|(p, f)| probe_data(p, f)).collect();
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
            data.probes = Some(buffer(device, upload, "probes", usage, bytemuck::cast_slice(&content))?);
        }
        Ok(data)
    }

    /// Whether it is what the plan lists; what the images show is another question.
    pub(super) fn is_of(&self, plan: &Plan) -> bool {
        self.images == without_reasons(plan)
    }

    /// What a binding of `SET_FRAME` is written with, if it is one of these.
    pub(super) fn content(&self, binding: u32) -> Option<Content<'_>> {
        fn buffer(buffer: &Option<Buffer>) -> Option<Content<'_>> {
            buffer.as_ref().map(|buffer| Content::Buffer(buffer, 0, buffer.size_bytes()))
        }
        let image = |image: &Option<Image>| {
            let info = vk::DescriptorImageInfo::default()
                .image_view(image.as_ref()?.view())
                .sampler(self.sampler.as_ref()?.raw())
                .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
            Some(Content::Images(vec![info]))
        };
        match binding {
            b if b == const { shared("BINDING_SPLIT_SUM") } => image(&self.split_sum),
            b if b == const { shared("BINDING_RADIANCE") } => image(&self.radiance),
            b if b == const { shared("BINDING_LIGHTMAP") } => image(&self.lightmap),
            b if b == const { shared("BINDING_ENVIRONMENT") } => buffer(&self.environment),
            b if b == const { shared("BINDING_PROBES") } => buffer(&self.probes),
            _ => None,
        }
    }

    /// Device memory of images and buffers.
    pub(super) fn allocated_bytes(&self) -> u64 {
        let images =
            self.split_sum.iter().chain(&self.radiance).chain(&self.lightmap).map(Image::allocated_bytes);
        let buffers = self.environment.iter().chain(&self.probes).map(Buffer::allocated_bytes);
        images.chain(buffers).sum()
    }
}

fn without_reasons(plan: &Plan) -> Vec<AroundImage> {
    plan.around.iter().map(|image| AroundImage { why: String::new(), ..image.clone() }).collect()
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

/// Linear, edges going on.
pub(super) fn edge_sampler(device: &Device, name: &str) -> Result<Owned<vk::Sampler>> {
    let info = vk::SamplerCreateInfo::default()
        .mag_filter(vk::Filter::LINEAR)
        .min_filter(vk::Filter::LINEAR)
        .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
        .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
        .max_lod(vk::LOD_CLAMP_NONE);
    // SAFETY: the structure uses no feature and no extension.
    unsafe { device.create_sampler(&info, name) }
}

/// What the scene brings, else made of its panorama.
fn prefiltered<'a>(environment: &'a Environment, plan: &Plan) -> Result<Cow<'a, Prefiltered>> {
    match (&environment.prefiltered, &environment.panorama, plan.environment_texels()) {
        (Some(prefiltered), ..) => Ok(Cow::Borrowed(prefiltered)),
        (None, Some(panorama), Some((format, size))) => {
            Ok(Cow::Owned(Prefiltered::new(panorama, size, format)))
        }
        _ => Err(Error::unsupported(
            format!("environment '{}' has neither a panorama nor anything made of one", environment.name),
            "give it one of them",
        )),
    }
}

/// One cube, or where there are probes an array of them: the environment's if there is one, then the probes' in order.
fn radiance(
    device: &Device,
    upload: &mut Upload,
    plan: &Plan,
    filtered: &[Cow<'_, Prefiltered>],
) -> Result<Image> {
    let cubes = if plan.needs.probes.is_empty() { Cubes::One } else { Cubes::Array };
    if cubes == Cubes::Array && !device.features().image_cube_array {
        return Err(Error::unsupported(
            format!("the scene has probes, and the device {} has no arrays of cube maps", device.caps().name),
            "use a device with the feature imageCubeArray, or remove the probes",
        ));
    }
    let first = &filtered[0];
    let desc = ImageDesc {
        levels: first.levels().len() as u32,
        layers: 6 * filtered.len() as u32,
        cubes,
        ..ImageDesc::new("radiance", conv::radiance_format(first.format()), [first.face_size(); 2], USAGE)
    };
    let image = Image::new(device, &desc)?;
    // Level by level, in each cube by cube.
    let levels: Vec<Vec<u8>> = (0..first.levels().len())
        .map(|level| filtered.iter().flat_map(|f| f.levels()[level].iter().copied()).collect())
        .collect();
    upload.image(&image, &levels.iter().map(Vec::as_slice).collect::<Vec<_>>())?;
    Ok(image)
}

fn buffer(
    device: &Device,
    upload: &mut Upload,
    name: &str,
    usage: vk::BufferUsageFlags,
    content: &[u8],
) -> Result<Buffer> {
    let usage = usage | vk::BufferUsageFlags::TRANSFER_DST;
    let desc = BufferDesc { name, bytes: content.len() as u64, usage, memory: MemoryUse::Device };
    let buffer = Buffer::new(device, &desc)?;
    upload.buffer(&buffer, 0, content)?;
    Ok(buffer)
}

/// Without an environment, probes still need to know the last level.
fn environment_uniforms(environment: Option<&Environment>, prefiltered: &Prefiltered) -> EnvironmentUniforms {
    let last_level = (prefiltered.levels().len() - 1) as f32;
    let Some(environment) = environment else {
        return EnvironmentUniforms { last_level, ..EnvironmentUniforms::default() };
    };
    EnvironmentUniforms {
        irradiance: prefiltered.irradiance().map(|c| (c * environment.intensity).extend(0.0).to_array()),
        rotation: rotation(environment),
        scale: prefiltered.scale() * environment.intensity,
        last_level,
    }
}

fn probe_data(probe: &Probe, prefiltered: &Prefiltered) -> ProbeData {
    let origin = probe.probe_from_world(glam::DVec3::ZERO);
    let axes = [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z].map(|a| probe.probe_from_world(a) - origin);
    let row = |i: usize| [axes[0][i] as f32, axes[1][i] as f32, axes[2][i] as f32, origin[i] as f32];
    ProbeData {
        probe_from_world_rows: [row(0), row(1), row(2)],
        half_size: probe.half_size_m.to_array(),
        falloff: probe.falloff_m,
        rotation: rotation(&probe.environment),
        scale: prefiltered.scale() * probe.environment.intensity,
        padding: 0.0,
    }
}

/// Cosine and sine.
fn rotation(environment: &Environment) -> [f32; 2] {
    let (sin, cos) = f64::from(environment.rotation_deg).to_radians().sin_cos();
    [cos as f32, sin as f32]
}

//! Triangles that a host draws over the picture, in the pass and after all else: its interface.

use std::ops::Range;

use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::{Mat2, Vec2};

use super::descriptor::{Content, DescriptorSets};
use super::pipeline::FamilyLayout;
use super::shader::shared;
use super::shared::OverlayPush;
use super::{Buffer, BufferDesc, Commands, Device, Image, ImageDesc, MemoryUse, Owned, Recorder, Upload};
use crate::plan::FrameCounts;
use crate::scene::PreRotation;
use crate::{Error, Result};

/// A corner of a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct OverlayVertex {
    /// From the left upper corner of the picture, points.
    pub position: [f32; 2],
    /// Where in the image: 0 to 1.
    pub texcoord: [f32; 2],
    /// RGBA that the image's is multiplied by: encoded as sRGB and multiplied by alpha after that.
    pub color: [u8; 4],
}

/// Triangles that one draw draws.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OverlayPart {
    /// What of the picture they may cover: left, top, right and bottom, pixels.
    pub clip_px: [u32; 4],
    /// Their part of the indices, three a triangle.
    pub indices: Range<u32>,
}

/// What is drawn over a frame, in order.
#[derive(Clone, Copy, Debug)]
pub struct OverlayFrame<'a> {
    /// Corners.
    pub vertices: &'a [OverlayVertex],
    /// Which of them make triangles.
    pub indices: &'a [u32],
    /// The draws.
    pub parts: &'a [OverlayPart],
    /// Pixels a point: of vertices, not of what clips.
    pub pixels_per_point: f32,
}

/// Image, buffers and descriptors of an overlay.
pub(super) struct Overlay {
    /// Index into `Plan::pipelines`.
    pipeline: usize,
    sets: DescriptorSets,
    sampler: Owned<vk::Sampler>,
    image: Image,
    slots: Vec<Slot>,
}

/// What a frame slot draws.
struct Slot {
    vertices: Buffer,
    indices: Buffer,
    parts: Vec<OverlayPart>,
    pixels_per_point: f32,
}

const BINDING: u32 = shared("BINDING_POST_COLOR");

impl Overlay {
    pub(super) fn new(
        device: &Device,
        pipeline: usize,
        layout: &FamilyLayout,
        slots: usize,
        upload: &mut Upload,
    ) -> Result<Self> {
        let wanted = [(layout.sets[0].raw(), layout.bindings[1].as_slice())];
        let sets = DescriptorSets::new(device, &wanted, "overlay")?;
        let sets =
            sets.ok_or_else(|| Error::unsupported("an overlay without an image", "report this as a bug"))?;
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .max_lod(vk::LOD_CLAMP_NONE);
        // SAFETY: the structure uses no feature and no extension.
        let sampler = unsafe { device.create_sampler(&info, "overlay") }?;
        let image = image(device, [1, 1])?;
        upload.image(&image, &[&[255; 4]])?;
        let slots = (0..slots).map(|_| Slot::new(device)).collect::<Result<_>>()?;
        let overlay = Self { pipeline, sets, sampler, image, slots };
        overlay.write_set();
        Ok(overlay)
    }

    fn write_set(&self) {
        let image = vk::DescriptorImageInfo::default()
            .sampler(self.sampler.raw())
            .image_view(self.image.view())
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        let ty = vk::DescriptorType::COMBINED_IMAGE_SAMPLER;
        self.sets.write(0, BINDING, ty, &Content::Images(vec![image]));
    }

    /// The image that was before.
    pub(super) fn set_image(&mut self, device: &Device, size: [u32; 2], texels: &[u8]) -> Result<Image> {
        let image = image(device, size)?;
        let mut upload = Upload::new(device);
        upload.image(&image, &[texels])?;
        Commands::run(device, "overlay image", |recorder| {
            upload.record(recorder);
            Ok(())
        })?;
        let before = std::mem::replace(&mut self.image, image);
        self.write_set();
        Ok(before)
    }

    pub(super) fn set(&mut self, device: &Device, slot: usize, frame: &OverlayFrame<'_>) -> Result<()> {
        let vertices = frame.vertices.len() as u32;
        let all = frame.indices.len() as u32;
        let beyond =
            frame.parts.iter().any(|part| part.indices.start > part.indices.end || part.indices.end > all);
        if beyond || frame.indices.iter().any(|index| *index >= vertices) {
            return Err(Error::unsupported(
                format!(
                    "an overlay of {vertices} vertices and {all} indices has parts or indices beyond them"
                ),
                "give indices of vertices, and parts of the indices",
            ));
        }
        if !(frame.pixels_per_point > 0.0 && frame.pixels_per_point.is_finite()) {
            return Err(Error::unsupported(
                format!("a point of an overlay cannot be {} pixels", frame.pixels_per_point),
                "give a number above 0",
            ));
        }
        let slot = &mut self.slots[slot];
        fill(device, &mut slot.vertices, bytemuck::cast_slice(frame.vertices))?;
        fill(device, &mut slot.indices, bytemuck::cast_slice(frame.indices))?;
        slot.parts.clear();
        slot.parts.extend_from_slice(frame.parts);
        slot.pixels_per_point = frame.pixels_per_point;
        Ok(())
    }

    pub(super) fn pipeline(&self) -> usize {
        self.pipeline
    }

    /// Draws what another has drawn, whose frames may be on the GPU; pipeline and layout of the set are its own.
    pub(super) fn take(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.image, &mut other.image);
        std::mem::swap(&mut self.slots, &mut other.slots);
        self.write_set();
    }

    pub(super) fn set_of_image(&self) -> vk::DescriptorSet {
        self.sets.raw(0)
    }

    pub(super) fn is_empty(&self, slot: usize) -> bool {
        self.slots[slot].parts.is_empty()
    }

    /// Records the draws; pipeline and image are bound.
    pub(super) fn draw(
        &self,
        recorder: &Recorder<'_>,
        slot: usize,
        layout: vk::PipelineLayout,
        extent: vk::Extent2D,
        pre_rotation: PreRotation,
        area: vk::Rect2D,
    ) -> FrameCounts {
        let slot = &self.slots[slot];
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let size = pre_rotation.size([extent.width, extent.height]);
        let turn = pre_rotation.image_from_picture();
        let scale = size.map(|pixels| 2.0 * slot.pixels_per_point / pixels as f32);
        let clip_from_point = turn * Mat2::from_diagonal(scale.into());
        let push = OverlayPush {
            clip_from_point: clip_from_point.to_cols_array_2d(),
            origin_clip: (-(turn * Vec2::ONE)).to_array(),
        };
        let stages = vk::ShaderStageFlags::VERTEX;
        let mut counts = FrameCounts::default();
        // SAFETY: the pipeline is bound; the layout has these bytes for this stage; the buffers are of this slot, which the
        // GPU does not use, and the indices were checked.
        unsafe {
            device.cmd_push_constants(raw, layout, stages, 0, bytemuck::bytes_of(&push));
            device.cmd_bind_vertex_buffers(raw, 0, &[slot.vertices.raw()], &[0]);
            device.cmd_bind_index_buffer(raw, slot.indices.raw(), 0, vk::IndexType::UINT32);
        }
        for part in &slot.parts {
            let within = scissor(part.clip_px, size, pre_rotation).and_then(|rect| common(rect, area));
            let Some(scissor) = within.filter(|_| !part.indices.is_empty()) else {
                continue;
            };
            let count = part.indices.end - part.indices.start;
            // SAFETY: as above; the rectangle lies in the picture.
            unsafe {
                device.cmd_set_scissor(raw, 0, &[scissor]);
                device.cmd_draw_indexed(raw, count, 1, part.indices.start, 0, 0);
            }
            counts.draws += 1;
            counts.triangles += u64::from(count / 3);
        }
        counts
    }
}

impl Slot {
    fn new(device: &Device) -> Result<Self> {
        /// A small interface.
        const LEAST_BYTES: u64 = 1 << 16;
        let buffer = |name, usage| {
            let desc = BufferDesc { name, bytes: LEAST_BYTES, usage, memory: MemoryUse::Upload };
            Buffer::new(device, &desc)
        };
        Ok(Self {
            vertices: buffer("overlay vertices", vk::BufferUsageFlags::VERTEX_BUFFER)?,
            indices: buffer("overlay indices", vk::BufferUsageFlags::INDEX_BUFFER)?,
            parts: Vec::new(),
            pixels_per_point: 1.0,
        })
    }
}

/// Writes a buffer from its begin, a larger one if it is too small. The GPU does not use it.
fn fill(device: &Device, buffer: &mut Buffer, content: &[u8]) -> Result<()> {
    let wanted = content.len() as u64;
    if buffer.size_bytes() < wanted {
        let name = match buffer.usage().contains(vk::BufferUsageFlags::INDEX_BUFFER) {
            true => "overlay indices",
            false => "overlay vertices",
        };
        let (bytes, usage) = (wanted.next_power_of_two(), buffer.usage());
        *buffer = Buffer::new(device, &BufferDesc { name, bytes, usage, memory: MemoryUse::Upload })?;
    }
    buffer.mapped_mut()[..content.len()].copy_from_slice(content);
    Ok(())
}

fn image(device: &Device, size: [u32; 2]) -> Result<Image> {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    Image::new(device, &ImageDesc::new("overlay", vk::Format::R8G8B8A8_UNORM, size, usage))
}

/// Where in the image that part of a rectangle is that lies in the picture, of this size; `None` if none does.
pub(super) fn scissor(
    [left, top, right, bottom]: [u32; 4],
    [width, height]: [u32; 2],
    pre_rotation: PreRotation,
) -> Option<vk::Rect2D> {
    let (right, bottom) = (right.min(width), bottom.min(height));
    let is_empty = left >= right || top >= bottom;
    let (x, y) = match pre_rotation {
        _ if is_empty => return None,
        PreRotation::Identity => (left, top),
        PreRotation::Rotate90 => (height - bottom, left),
        PreRotation::Rotate180 => (width - right, height - bottom),
        PreRotation::Rotate270 => (top, width - right),
    };
    let [width, height] = pre_rotation.size([right - left, bottom - top]);
    Some(vk::Rect2D {
        offset: vk::Offset2D { x: x as i32, y: y as i32 },
        extent: vk::Extent2D { width, height },
    })
}

/// What two rectangles have in common; `None` if nothing.
fn common(a: vk::Rect2D, b: vk::Rect2D) -> Option<vk::Rect2D> {
    let end = |rect: vk::Rect2D| {
        [rect.offset.x + rect.extent.width as i32, rect.offset.y + rect.extent.height as i32]
    };
    let (x, y) = (a.offset.x.max(b.offset.x), a.offset.y.max(b.offset.y));
    let [right, bottom] = [0, 1].map(|axis| end(a)[axis].min(end(b)[axis]));
    (x < right && y < bottom).then(|| vk::Rect2D {
        offset: vk::Offset2D { x, y },
        extent: vk::Extent2D { width: (right - x) as u32, height: (bottom - y) as u32 },
    })
}

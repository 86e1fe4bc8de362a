//! Fixed-function state of pipelines.

use ash::vk;

use super::super::scene_data::vertex_streams;
use super::super::shader::shared;
use super::super::{StreamKind, texel_bytes};
use crate::Result;
use crate::plan::SurfaceKind;

/// Vertex attributes in the order of their streams.
#[derive(Default)]
pub(super) struct VertexInput {
    pub(super) bindings: Vec<vk::VertexInputBindingDescription>,
    pub(super) attributes: Vec<vk::VertexInputAttributeDescription>,
}

impl VertexInput {
    pub(super) fn new(kind: &SurfaceKind) -> Result<Self> {
        Self::of(kind, |stream| stream != StreamKind::Texcoords || kind.reads_texcoords())
    }

    /// What depth and masks need; the rest may be bound and is not read.
    pub(super) fn of_depth(kind: &SurfaceKind) -> Result<Self> {
        Self::of(kind, |stream| match stream {
            StreamKind::Position => true,
            StreamKind::Texcoords => kind.alpha_mask && kind.textures != 0,
            StreamKind::Color => kind.alpha_mask,
            StreamKind::Normal | StreamKind::Tangent => false,
        })
    }

    fn of(kind: &SurfaceKind, wanted: impl Fn(StreamKind) -> bool) -> Result<Self> {
        let mut input = Self::default();
        let streams = (0..).zip(vertex_streams(kind).list());
        for (binding, (stream, format)) in streams.filter(|(_, (stream, _))| wanted(*stream)) {
            let location = match stream {
                StreamKind::Position => const { shared("ATTRIBUTE_POSITION") },
                StreamKind::Normal => const { shared("ATTRIBUTE_NORMAL") },
                StreamKind::Tangent => const { shared("ATTRIBUTE_TANGENT") },
                StreamKind::Texcoords => const { shared("ATTRIBUTE_TEXCOORD") },
                StreamKind::Color => const { shared("ATTRIBUTE_COLOR") },
            };
            let stride = texel_bytes(format)?;
            let input_rate = vk::VertexInputRate::VERTEX;
            input.bindings.push(vk::VertexInputBindingDescription { binding, stride, input_rate });
            input.attributes.push(vk::VertexInputAttributeDescription {
                location,
                binding,
                format,
                offset: 0,
            });
        }
        Ok(input)
    }
}

/// Fixed-function state of a subpass's pipelines.
pub(super) struct FixedState {
    pub(super) raster: vk::PipelineRasterizationStateCreateInfo<'static>,
    pub(super) depth: Option<vk::PipelineDepthStencilStateCreateInfo<'static>>,
    pub(super) blend: Vec<vk::PipelineColorBlendAttachmentState>,
}

impl FixedState {
    /// A full-screen triangle at the far plane, seen where nothing is before it.
    pub(super) fn sky(subpass: &crate::plan::Subpass) -> Self {
        let state = Self::new(subpass, None);
        let at_clear_depth = |depth: vk::PipelineDepthStencilStateCreateInfo<'static>| {
            depth.depth_write_enable(false).depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL)
        };
        Self { depth: state.depth.map(at_clear_depth), ..state }
    }

    pub(super) fn new(subpass: &crate::plan::Subpass, kind: Option<&SurfaceKind>) -> Self {
        let cull = match kind {
            Some(kind) if !kind.double_sided => vk::CullModeFlags::BACK,
            _ => vk::CullModeFlags::NONE,
        };
        // Clip space has y down, so triangles that are counter-clockwise in the world stay so on the image.
        let front = match kind {
            Some(kind) if kind.mirrored => vk::FrontFace::CLOCKWISE,
            _ => vk::FrontFace::COUNTER_CLOCKWISE,
        };
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(cull)
            .front_face(front)
            .line_width(1.0);
        let depth = subpass.depth.map(|_| {
            vk::PipelineDepthStencilStateCreateInfo::default()
                .depth_test_enable(true)
                .depth_write_enable(subpass.depth_write)
                .depth_compare_op(match subpass.depth_write {
                    true => vk::CompareOp::GREATER,
                    false => vk::CompareOp::EQUAL,
                })
        });
        let all =
            vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
        let one = if subpass.blend {
            all.blend_enable(true)
                .src_color_blend_factor(vk::BlendFactor::ONE)
                .dst_color_blend_factor(vk::BlendFactor::ONE)
                .color_blend_op(vk::BlendOp::ADD)
                .src_alpha_blend_factor(vk::BlendFactor::ONE)
                .dst_alpha_blend_factor(vk::BlendFactor::ONE)
                .alpha_blend_op(vk::BlendOp::ADD)
        } else {
            all
        };
        Self { raster, depth, blend: vec![one; subpass.colors.len()] }
    }
}

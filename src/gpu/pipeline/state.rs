//! Fixed-function state of pipelines.

use std::collections::BTreeSet;
use std::mem::offset_of;

use ash::vk;

use super::super::scene_data::vertex_streams;
use super::super::shader::shared;
use super::super::{OverlayVertex, StreamKind, conv, texel_bytes};
use crate::Result;
use crate::plan::{COUNT_BITS, Edges, LightWay, Pipeline, Plan, Subpass, VolumeShape};

/// Vertex attributes in the order of their streams.
#[derive(Default)]
pub(super) struct VertexInput {
    pub(super) bindings: Vec<vk::VertexInputBindingDescription>,
    pub(super) attributes: Vec<vk::VertexInputAttributeDescription>,
}

impl VertexInput {
    /// The attributes at these locations; others may be bound and are not read.
    pub(super) fn new(pipeline: &Pipeline, attributes: &BTreeSet<u32>) -> Result<Self> {
        if *pipeline == Pipeline::Overlay {
            return Ok(overlay_input());
        }
        let (Pipeline::Surface(kind)
        | Pipeline::Absorb(kind)
        | Pipeline::Light(kind)
        | Pipeline::Depth(kind)
        | Pipeline::Peel { kind, .. }) = pipeline
        else {
            return Ok(Self::default());
        };
        let mut input = Self::default();
        let streams = (0..).zip(vertex_streams(kind).list());
        for (binding, (stream, format)) in streams {
            let location = match stream {
                StreamKind::Position => const { shared("ATTRIBUTE_POSITION") },
                StreamKind::Normal => const { shared("ATTRIBUTE_NORMAL") },
                StreamKind::Tangent => const { shared("ATTRIBUTE_TANGENT") },
                StreamKind::Texcoords => const { shared("ATTRIBUTE_TEXCOORD") },
                StreamKind::Color => const { shared("ATTRIBUTE_COLOR") },
            };
            if !attributes.contains(&location) {
                continue;
            }
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

/// As [`OverlayVertex`] has them.
fn overlay_input() -> VertexInput {
    let attribute = |location, format, offset: usize| vk::VertexInputAttributeDescription {
        location,
        binding: 0,
        format,
        offset: offset as u32,
    };
    let stride = size_of::<OverlayVertex>() as u32;
    let input_rate = vk::VertexInputRate::VERTEX;
    let float2 = vk::Format::R32G32_SFLOAT;
    VertexInput {
        bindings: vec![vk::VertexInputBindingDescription { binding: 0, stride, input_rate }],
        attributes: vec![
            attribute(const { shared("ATTRIBUTE_POSITION") }, float2, offset_of!(OverlayVertex, position)),
            attribute(const { shared("ATTRIBUTE_TEXCOORD") }, float2, offset_of!(OverlayVertex, texcoord)),
            attribute(
                const { shared("ATTRIBUTE_COLOR") },
                vk::Format::R8G8B8A8_UNORM,
                offset_of!(OverlayVertex, color),
            ),
        ],
    }
}

/// Fixed-function state of a subpass's pipelines.
pub(super) struct FixedState {
    pub(super) samples: vk::SampleCountFlags,
    pub(super) raster: vk::PipelineRasterizationStateCreateInfo<'static>,
    pub(super) depth: Option<vk::PipelineDepthStencilStateCreateInfo<'static>>,
    pub(super) blend: Vec<vk::PipelineColorBlendAttachmentState>,
    pub(super) blend_flags: vk::PipelineColorBlendStateCreateFlags,
}

impl FixedState {
    pub(super) fn new(plan: &Plan, stage: usize, pipeline: &Pipeline) -> Self {
        let subpass = plan.subpass(stage).2;
        let cull = match pipeline {
            Pipeline::Surface(kind)
            | Pipeline::Absorb(kind)
            | Pipeline::Depth(kind)
            | Pipeline::Light(kind)
            | Pipeline::Peel { kind, .. }
                if !kind.double_sided =>
            {
                vk::CullModeFlags::BACK
            }
            // The far side of a volume is there wherever the camera is, and covers each pixel once.
            Pipeline::LightVolume(shape) | Pipeline::EdgeVolume(shape) if *shape != VolumeShape::Screen => {
                vk::CullModeFlags::FRONT
            }
            // The triangle that stands in for a box that the far plane cuts is turned like its far sides.
            Pipeline::Decal(_) => vk::CullModeFlags::FRONT,
            _ => vk::CullModeFlags::NONE,
        };
        // Clip space has y down, so triangles that are counter-clockwise in the world stay so on the image.
        let front = match pipeline {
            Pipeline::Surface(kind)
            | Pipeline::Absorb(kind)
            | Pipeline::Depth(kind)
            | Pipeline::Light(kind)
            | Pipeline::Peel { kind, .. }
                if kind.mirrored =>
            {
                vk::FrontFace::CLOCKWISE
            }
            _ => vk::FrontFace::COUNTER_CLOCKWISE,
        };
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            // Volumes that go on for ever end neither at the near plane nor at the far one.
            .depth_clamp_enable(*pipeline == Pipeline::ShadowVolume)
            .cull_mode(cull)
            .front_face(front)
            .line_width(1.0);
        let depth = subpass.depth.map(|_| depth_stencil(plan, subpass, pipeline));
        let all =
            vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
        let one = if matches!(
            pipeline,
            Pipeline::LightMask(_) | Pipeline::ShadowNearEnds | Pipeline::ShadowVolume | Pipeline::Edges
        ) {
            vk::PipelineColorBlendAttachmentState::default()
        } else if matches!(pipeline, Pipeline::Decal(_)) && subpass.blend {
            // Alpha is the opacity, and what the target has there stays.
            all.color_write_mask(
                vk::ColorComponentFlags::R | vk::ColorComponentFlags::G | vk::ColorComponentFlags::B,
            )
            .blend_enable(true)
            .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .color_blend_op(vk::BlendOp::ADD)
            .src_alpha_blend_factor(vk::BlendFactor::ZERO)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE)
            .alpha_blend_op(vk::BlendOp::ADD)
        } else if matches!(pipeline, Pipeline::Absorb(_)) {
            // Colours are what is left of those that are there; alpha is the part that is covered.
            all.blend_enable(true)
                .src_color_blend_factor(vk::BlendFactor::ZERO)
                .dst_color_blend_factor(vk::BlendFactor::SRC_COLOR)
                .color_blend_op(vk::BlendOp::ADD)
                .src_alpha_blend_factor(vk::BlendFactor::ONE)
                .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
                .alpha_blend_op(vk::BlendOp::ADD)
        } else if *pipeline == Pipeline::Overlay {
            // Colours are multiplied by alpha already; the picture stays opaque.
            all.blend_enable(true)
                .src_color_blend_factor(vk::BlendFactor::ONE)
                .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
                .color_blend_op(vk::BlendOp::ADD)
                .src_alpha_blend_factor(vk::BlendFactor::ZERO)
                .dst_alpha_blend_factor(vk::BlendFactor::ONE)
                .alpha_blend_op(vk::BlendOp::ADD)
        } else if subpass.blend {
            // Over what is there, colours multiplied by alpha already; or added to it; or summed, while alpha holds what is left of
            // what is behind.
            let sums = subpass.color_names.contains(&"weights");
            let left = vk::BlendFactor::ONE_MINUS_SRC_ALPHA;
            let [kept, alpha_kept] = match pipeline {
                Pipeline::Surface(_) if sums => [vk::BlendFactor::ONE, left],
                Pipeline::Surface(kind) if kind.transmits => [vk::BlendFactor::ONE; 2],
                Pipeline::Surface(_) | Pipeline::Fog | Pipeline::Composite => [left; 2],
                _ => [vk::BlendFactor::ONE; 2],
            };
            all.blend_enable(true)
                .src_color_blend_factor(vk::BlendFactor::ONE)
                .dst_color_blend_factor(kept)
                .color_blend_op(vk::BlendOp::ADD)
                .src_alpha_blend_factor(if sums { vk::BlendFactor::ZERO } else { vk::BlendFactor::ONE })
                .dst_alpha_blend_factor(alpha_kept)
                .alpha_blend_op(vk::BlendOp::ADD)
        } else {
            all
        };
        let blend_flags = match subpass.ordered {
            true => vk::PipelineColorBlendStateCreateFlags::RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXT,
            false => vk::PipelineColorBlendStateCreateFlags::empty(),
        };
        let samples = conv::samples(plan.samples(stage));
        Self { samples, raster, depth, blend: vec![one; subpass.colors.len()], blend_flags }
    }
}

/// Depth is reversed: nearer is greater.
fn depth_stencil(
    plan: &Plan,
    subpass: &Subpass,
    pipeline: &Pipeline,
) -> vk::PipelineDepthStencilStateCreateInfo<'static> {
    let test = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(true)
        .depth_write_enable(subpass.depth_write);
    // Edges keep their bit while volumes are counted in the others.
    let edge = if plan.edges == Edges::All { 0 } else { const { shared("STENCIL_EDGE") } };
    let count = const { shared("STENCIL_COUNT") } | (const { shared("STENCIL_EDGE") } ^ edge);
    let every = vk::StencilOpState::default().compare_mask(0xff).write_mask(count);
    // Marked pixels, or the others.
    let own_edge = if pipeline.per_pixel() == *pipeline { 0 } else { edge };
    match pipeline {
        // Surfaces whose depth is there already pass where they are what was found nearest.
        Pipeline::Surface(_)
        | Pipeline::Absorb(_)
        | Pipeline::Depth(_)
        | Pipeline::Light(_)
        | Pipeline::Particles(_) => {
            // What is blended is tested against what is opaque, or was peeled.
            let blended = matches!(pipeline, Pipeline::Surface(kind) if kind.blend)
                || matches!(pipeline, Pipeline::Particles(_) | Pipeline::Absorb(_));
            let found = !subpass.depth_write && (!blended || subpass.tests_peeled);
            test.depth_compare_op(if found { vk::CompareOp::EQUAL } else { vk::CompareOp::GREATER })
        }
        Pipeline::Overlay => test.depth_test_enable(false).depth_write_enable(false),
        // The farthest of what is left.
        Pipeline::Peel { .. } => test.depth_compare_op(vk::CompareOp::LESS),
        // All of it, whatever was there.
        Pipeline::Backdrop => test.depth_compare_op(vk::CompareOp::ALWAYS),
        // At the far plane: seen where nothing is before it.
        Pipeline::Sky => test.depth_write_enable(false).depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL),
        // A surface in front of the volume has both of its sides behind it, one behind the volume none, and one within
        // it the far side only: it alone is left with a count that is not 0, whatever side is counted first. Without a
        // near plane's end it holds too: what the near plane cuts off would have been in front of all surfaces.
        Pipeline::LightMask(_) => {
            let count = every.compare_op(vk::CompareOp::ALWAYS);
            test.depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL)
                .stencil_test_enable(true)
                .front(count.depth_fail_op(vk::StencilOp::DECREMENT_AND_WRAP))
                .back(count.depth_fail_op(vk::StencilOp::INCREMENT_AND_WRAP))
        }
        // Behind each surface more volumes end than begin if it is within some. What ends where the surface itself is, the near
        // end of its own volume, is behind it: it does not shadow itself.
        Pipeline::ShadowNearEnds | Pipeline::ShadowVolume => {
            let count = every.compare_op(vk::CompareOp::ALWAYS).write_mask(COUNT_BITS);
            test.depth_compare_op(vk::CompareOp::GREATER)
                .stencil_test_enable(true)
                .front(count.depth_fail_op(vk::StencilOp::DECREMENT_AND_WRAP))
                .back(count.depth_fail_op(vk::StencilOp::INCREMENT_AND_WRAP))
        }
        // Covers all pixels, so that no count is left to the next light.
        Pipeline::ShadowedLight => {
            let none = every.compare_mask(COUNT_BITS).write_mask(COUNT_BITS);
            let none = none.compare_op(vk::CompareOp::EQUAL).fail_op(vk::StencilOp::ZERO);
            test.depth_compare_op(vk::CompareOp::LESS).stencil_test_enable(true).front(none).back(none)
        }
        // Shades what was marked and clears the mark, so that the next light finds none: edges first, whose counts are then out of
        // the way.
        Pipeline::EdgeVolume(shape)
            if plan.light_way == LightWay::Stencil && *shape != VolumeShape::Screen =>
        {
            let marked = every.reference(edge).compare_op(vk::CompareOp::LESS).pass_op(vk::StencilOp::ZERO);
            test.depth_compare_op(vk::CompareOp::LESS).stencil_test_enable(true).front(marked).back(marked)
        }
        Pipeline::LightVolume(shape)
            if plan.light_way == LightWay::Stencil && *shape != VolumeShape::Screen =>
        {
            let marked = every.compare_mask(count).compare_op(vk::CompareOp::NOT_EQUAL);
            let marked = marked.pass_op(vk::StencilOp::ZERO);
            test.depth_compare_op(vk::CompareOp::LESS).stencil_test_enable(true).front(marked).back(marked)
        }
        Pipeline::Edges => {
            let mark = every.write_mask(edge).reference(edge).compare_op(vk::CompareOp::ALWAYS);
            let mark = mark.pass_op(vk::StencilOp::REPLACE);
            test.depth_test_enable(false).stencil_test_enable(true).front(mark).back(mark)
        }
        Pipeline::Show | Pipeline::ShowEdges => {
            let own = every.compare_mask(edge).write_mask(0).reference(own_edge);
            let own = own.compare_op(vk::CompareOp::EQUAL);
            test.depth_test_enable(false).stencil_test_enable(true).front(own).back(own)
        }
        Pipeline::Lighting | Pipeline::EdgeLighting | Pipeline::LightVolume(_) | Pipeline::EdgeVolume(_)
            if edge != 0 =>
        {
            let own =
                every.compare_mask(edge).write_mask(0).reference(own_edge).compare_op(vk::CompareOp::EQUAL);
            // Where the tone curve is applied too, the background is drawn as well.
            test.depth_test_enable(!plan.folded)
                .depth_compare_op(vk::CompareOp::LESS)
                .stencil_test_enable(true)
                .front(own)
                .back(own)
        }
        // Surfaces in front of what is drawn: of a volume's far side, or of a triangle at an infinite distance, which
        // leaves out where there is none.
        _ => test.depth_compare_op(vk::CompareOp::LESS),
    }
}

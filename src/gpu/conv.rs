//! From the plan's words to Vulkan's: one exhaustive match each.

use ash::vk;

use crate::environment::TexelFormat;
use crate::plan::{Access, Attachment, Format, Load, Scope, State, Store, Usage};
use crate::scene::{AstcBlock, TextureFormat};

/// The Vulkan format.
pub const fn format(f: Format) -> vk::Format {
    match f {
        Format::R32Float => vk::Format::R32_SFLOAT,
        Format::Rgba8Unorm => vk::Format::R8G8B8A8_UNORM,
        Format::Rgba8Srgb => vk::Format::R8G8B8A8_SRGB,
        Format::Bgra8Srgb => vk::Format::B8G8R8A8_SRGB,
        Format::Rgb10a2Unorm => vk::Format::A2B10G10R10_UNORM_PACK32,
        Format::B10g11r11Float => vk::Format::B10G11R11_UFLOAT_PACK32,
        Format::R16Float => vk::Format::R16_SFLOAT,
        Format::R8Unorm => vk::Format::R8_UNORM,
        Format::Rg16Float => vk::Format::R16G16_SFLOAT,
        Format::Rg8Unorm => vk::Format::R8G8_UNORM,
        Format::Rgba16Unorm => vk::Format::R16G16B16A16_UNORM,
        Format::R32Uint => vk::Format::R32_UINT,
        Format::Rg32Uint => vk::Format::R32G32_UINT,
        Format::Rgba32Uint => vk::Format::R32G32B32A32_UINT,
        Format::Rgba16Float => vk::Format::R16G16B16A16_SFLOAT,
        Format::Rgba32Float => vk::Format::R32G32B32A32_SFLOAT,
        Format::D32Float => vk::Format::D32_SFLOAT,
        Format::D24Unorm => vk::Format::X8_D24_UNORM_PACK32,
        Format::D16Unorm => vk::Format::D16_UNORM,
        Format::D32FloatS8 => vk::Format::D32_SFLOAT_S8_UINT,
        Format::D24UnormS8 => vk::Format::D24_UNORM_S8_UINT,
    }
}

/// The Vulkan format of an environment's radiance.
pub const fn radiance_format(f: TexelFormat) -> vk::Format {
    match f {
        TexelFormat::Rgbm => vk::Format::R8G8B8A8_UNORM,
        TexelFormat::B10G11R11 => vk::Format::B10G11R11_UFLOAT_PACK32,
        TexelFormat::E5B9G9R9 => vk::Format::E5B9G9R9_UFLOAT_PACK32,
        TexelFormat::Rgba16F => vk::Format::R16G16B16A16_SFLOAT,
    }
}

/// The Vulkan format of a material's texture: its colours are sRGB-encoded or not.
pub const fn texture_format(f: TextureFormat, srgb: bool) -> vk::Format {
    use vk::Format as F;
    let [linear, encoded] = match f {
        TextureFormat::Rgba8 => [F::R8G8B8A8_UNORM, F::R8G8B8A8_SRGB],
        TextureFormat::Bc1 => [F::BC1_RGB_UNORM_BLOCK, F::BC1_RGB_SRGB_BLOCK],
        TextureFormat::Bc1Alpha => [F::BC1_RGBA_UNORM_BLOCK, F::BC1_RGBA_SRGB_BLOCK],
        TextureFormat::Bc3 => [F::BC3_UNORM_BLOCK, F::BC3_SRGB_BLOCK],
        TextureFormat::Bc7 => [F::BC7_UNORM_BLOCK, F::BC7_SRGB_BLOCK],
        TextureFormat::Etc2 => [F::ETC2_R8G8B8_UNORM_BLOCK, F::ETC2_R8G8B8_SRGB_BLOCK],
        TextureFormat::Etc2Mask => [F::ETC2_R8G8B8A1_UNORM_BLOCK, F::ETC2_R8G8B8A1_SRGB_BLOCK],
        TextureFormat::Etc2Alpha => [F::ETC2_R8G8B8A8_UNORM_BLOCK, F::ETC2_R8G8B8A8_SRGB_BLOCK],
        TextureFormat::Astc(block) => astc_formats(block),
    };
    if srgb { encoded } else { linear }
}

const fn astc_formats(block: AstcBlock) -> [vk::Format; 2] {
    use vk::Format as F;
    match block {
        AstcBlock::B4x4 => [F::ASTC_4X4_UNORM_BLOCK, F::ASTC_4X4_SRGB_BLOCK],
        AstcBlock::B5x4 => [F::ASTC_5X4_UNORM_BLOCK, F::ASTC_5X4_SRGB_BLOCK],
        AstcBlock::B5x5 => [F::ASTC_5X5_UNORM_BLOCK, F::ASTC_5X5_SRGB_BLOCK],
        AstcBlock::B6x5 => [F::ASTC_6X5_UNORM_BLOCK, F::ASTC_6X5_SRGB_BLOCK],
        AstcBlock::B6x6 => [F::ASTC_6X6_UNORM_BLOCK, F::ASTC_6X6_SRGB_BLOCK],
        AstcBlock::B8x5 => [F::ASTC_8X5_UNORM_BLOCK, F::ASTC_8X5_SRGB_BLOCK],
        AstcBlock::B8x6 => [F::ASTC_8X6_UNORM_BLOCK, F::ASTC_8X6_SRGB_BLOCK],
        AstcBlock::B8x8 => [F::ASTC_8X8_UNORM_BLOCK, F::ASTC_8X8_SRGB_BLOCK],
        AstcBlock::B10x5 => [F::ASTC_10X5_UNORM_BLOCK, F::ASTC_10X5_SRGB_BLOCK],
        AstcBlock::B10x6 => [F::ASTC_10X6_UNORM_BLOCK, F::ASTC_10X6_SRGB_BLOCK],
        AstcBlock::B10x8 => [F::ASTC_10X8_UNORM_BLOCK, F::ASTC_10X8_SRGB_BLOCK],
        AstcBlock::B10x10 => [F::ASTC_10X10_UNORM_BLOCK, F::ASTC_10X10_SRGB_BLOCK],
        AstcBlock::B12x10 => [F::ASTC_12X10_UNORM_BLOCK, F::ASTC_12X10_SRGB_BLOCK],
        AstcBlock::B12x12 => [F::ASTC_12X12_UNORM_BLOCK, F::ASTC_12X12_SRGB_BLOCK],
    }
}

/// The image layout.
pub const fn layout(s: State) -> vk::ImageLayout {
    match s {
        State::Undefined => vk::ImageLayout::UNDEFINED,
        State::Color => vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        State::Depth => vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
        State::DepthInput => vk::ImageLayout::DEPTH_STENCIL_READ_ONLY_OPTIMAL,
        State::DepthInputStencil => vk::ImageLayout::DEPTH_READ_ONLY_STENCIL_ATTACHMENT_OPTIMAL,
        State::Input | State::Sampled => vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        State::InputColor => vk::ImageLayout::GENERAL,
        State::LocalRead => vk::ImageLayout::RENDERING_LOCAL_READ_KHR,
        State::CopySource => vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
        State::Present => vk::ImageLayout::PRESENT_SRC_KHR,
    }
}

/// The load operation.
pub const fn load_op(l: Load) -> vk::AttachmentLoadOp {
    match l {
        Load::Load => vk::AttachmentLoadOp::LOAD,
        Load::Clear => vk::AttachmentLoadOp::CLEAR,
        Load::DontCare => vk::AttachmentLoadOp::DONT_CARE,
    }
}

/// The store operation.
pub const fn store_op(s: Store) -> vk::AttachmentStoreOp {
    match s {
        Store::Store => vk::AttachmentStoreOp::STORE,
        Store::DontCare => vk::AttachmentStoreOp::DONT_CARE,
    }
}

/// What an attachment is cleared to.
pub fn clear_value(attachment: &Attachment) -> vk::ClearValue {
    let color = attachment.clear.unwrap_or_default();
    match attachment.format.is_depth() {
        true => vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: color[0], stencil: 0 } },
        false => vk::ClearValue { color: vk::ClearColorValue { float32: color } },
    }
}

/// Whether only the same pixel matters.
pub fn by_region(by_region: bool) -> vk::DependencyFlags {
    if by_region { vk::DependencyFlags::BY_REGION } else { vk::DependencyFlags::empty() }
}

/// Image usage, without the transient flag.
pub fn usage(u: Usage) -> vk::ImageUsageFlags {
    let flags = [
        (u.color, vk::ImageUsageFlags::COLOR_ATTACHMENT),
        (u.depth, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT),
        (u.input, vk::ImageUsageFlags::INPUT_ATTACHMENT),
        (u.sampled, vk::ImageUsageFlags::SAMPLED),
        (u.copy_source, vk::ImageUsageFlags::TRANSFER_SRC),
    ];
    flags.iter().filter(|(on, _)| *on).fold(vk::ImageUsageFlags::empty(), |all, (_, flag)| all | *flag)
}

/// Pipeline stages and access flags of a set.
pub fn scope(s: &Scope) -> (vk::PipelineStageFlags, vk::AccessFlags) {
    let none = (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty());
    s.iter().map(|&a| access(a)).fold(none, |all, one| (all.0 | one.0, all.1 | one.1))
}

/// Pipeline stages and access flags.
pub fn access(a: Access) -> (vk::PipelineStageFlags, vk::AccessFlags) {
    use vk::{AccessFlags as A, PipelineStageFlags as S};
    let tests = S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS;
    match a {
        Access::ColorRead => (S::COLOR_ATTACHMENT_OUTPUT, A::COLOR_ATTACHMENT_READ),
        Access::ColorWrite => (S::COLOR_ATTACHMENT_OUTPUT, A::COLOR_ATTACHMENT_WRITE),
        Access::DepthRead => (tests, A::DEPTH_STENCIL_ATTACHMENT_READ),
        Access::DepthWrite => (tests, A::DEPTH_STENCIL_ATTACHMENT_WRITE),
        Access::InputRead => (S::FRAGMENT_SHADER, A::INPUT_ATTACHMENT_READ),
        Access::SampledRead => (S::FRAGMENT_SHADER, A::SHADER_READ),
        Access::TransferRead => (S::TRANSFER, A::TRANSFER_READ),
    }
}

/// A number of samples a pixel, of those that a plan can have.
pub fn samples(count: u32) -> vk::SampleCountFlags {
    // Each flag's value is its count.
    vk::SampleCountFlags::from_raw(count)
}

/// The fixed-function features that a format must have for a usage.
pub fn format_features(u: Usage) -> vk::FormatFeatureFlags {
    let flags = [
        (u.color, vk::FormatFeatureFlags::COLOR_ATTACHMENT),
        (u.blend, vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND),
        (u.depth, vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT),
        (u.sampled, vk::FormatFeatureFlags::SAMPLED_IMAGE),
    ];
    flags.iter().filter(|(on, _)| *on).fold(vk::FormatFeatureFlags::empty(), |all, (_, flag)| all | *flag)
}

/// All of an area, and all depths.
pub fn viewport(area: vk::Rect2D) -> vk::Viewport {
    vk::Viewport {
        x: area.offset.x as f32,
        y: area.offset.y as f32,
        width: area.extent.width as f32,
        height: area.extent.height as f32,
        min_depth: 0.0,
        max_depth: 1.0,
    }
}

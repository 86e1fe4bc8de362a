//! The images of a window.

use std::cell::Cell;
use std::rc::Rc;

use ash::{khr, vk};
use serde::{Deserialize, Serialize};

use super::owned::Object;
use super::{Called, Device, OutputImage, Owned, Readback, Recorder, Surface, conv, offscreen};
use crate::picture::Picture;
use crate::plan::{Format, OutputFormat, named_enum};
use crate::scene::PreRotation;
use crate::{Error, Result};

named_enum! {
    /// When a frame that is done gets to the screen.
    PresentMode {
        /// With the screen's next refresh, in order: no frame is lost and none torn. Every device has it.
        Fifo = "fifo",
        /// With the next refresh, in the place of one that still waits: less delay, frames drawn in vain.
        Mailbox = "mailbox",
        /// At once: the least delay, torn.
        Immediate = "immediate",
    }
}

impl PresentMode {
    fn raw(self) -> vk::PresentModeKHR {
        match self {
            Self::Fifo => vk::PresentModeKHR::FIFO,
            Self::Mailbox => vk::PresentModeKHR::MAILBOX,
            Self::Immediate => vk::PresentModeKHR::IMMEDIATE,
        }
    }
}

/// The images that a window shows in turn, sRGB-encoded by the attachment.
///
/// Dropped only when the GPU has finished with them and none waits to be shown ([`Presenter::wait`](super::Presenter::wait),
/// [`Presenter::retire_swapchain`](super::Presenter::retire_swapchain)).
pub struct Swapchain {
    /// Signalled when a frame to the image is done.
    finished: Vec<Owned<vk::Semaphore>>,
    views: Vec<Owned<vk::ImageView>>,
    raw: Owned<vk::SwapchainKHR>,
    images: Vec<vk::Image>,
    /// The frame that presented each image last; 0: none.
    presented: Vec<Cell<u64>>,
    functions: khr::swapchain::Device,
    format: OutputFormat,
    usage: vk::ImageUsageFlags,
    extent: vk::Extent2D,
    pre_rotation: PreRotation,
    made_for: (vk::Extent2D, vk::SurfaceTransformFlagsKHR),
    surface: Rc<Surface>,
}

impl Object for vk::SwapchainKHR {
    unsafe fn destroy(self, device: &Device) {
        let functions = khr::swapchain::Device::new(device.instance(), device.raw());
        // SAFETY: the caller's promise; who made it has enabled the extension.
        unsafe { functions.destroy_swapchain(self, device.callbacks()) }
    }
}

/// The formats that are taken, the best first: base colours have the first, so that the image can hold them until it is written.
const FORMATS: [OutputFormat; 2] = [OutputFormat::Rgba8Srgb, OutputFormat::Bgra8Srgb];

impl Swapchain {
    /// Makes the images of a window; its size in pixels counts where the surface has none of its own. `None` where the window has no
    /// pixels now, e.g. while it is minimised.
    ///
    /// Where the screen is turned the images lie as it does ([`Self::pre_rotation`]), so that the system need not turn them.
    /// `old` is the window's swapchain so far, which the new one replaces and may share memory with.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the surface has no sRGB format, shows only mirrored images, or lacks the present mode;
    /// [`Error::Vulkan`], of which ERROR_SURFACE_LOST_KHR asks for a new surface.
    pub fn new(
        surface: &Rc<Surface>,
        window_size: [u32; 2],
        mode: PresentMode,
        old: Option<&Self>,
    ) -> Result<Option<Self>> {
        let device = surface.device();
        let can = surface.capabilities()?;
        let (pre_rotation, transform) = choose_pre_rotation(&can)?;
        let extent = extent(&can, window_size, pre_rotation);
        if extent.width == 0 || extent.height == 0 {
            return Ok(None);
        }
        check_mode(&surface.present_modes()?, mode)?;
        let (format, colors) = choose_format(&surface.formats()?)?;
        let wanted = vk::ImageUsageFlags::INPUT_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | (wanted & can.supported_usage_flags);
        let raw_format = conv::format(Format::from(format));
        let most = if can.max_image_count == 0 { u32::MAX } else { can.max_image_count };
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw())
            .min_image_count((can.min_image_count + 1).min(most))
            .image_format(raw_format)
            .image_color_space(colors)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(usage)
            .pre_transform(transform)
            .composite_alpha(composite_alpha(can.supported_composite_alpha))
            .present_mode(mode.raw())
            .clipped(true)
            .old_swapchain(old.map_or(vk::SwapchainKHR::null(), |old| old.raw.raw()));
        let functions = khr::swapchain::Device::new(device.instance(), device.raw());
        // SAFETY: all values are those that the surface offers, and its former swapchain is the old one.
        let raw = unsafe { functions.create_swapchain(&info, device.callbacks()) };
        let raw = Owned::new(device, raw.called("vkCreateSwapchainKHR")?, "window");
        // SAFETY: the swapchain was just made.
        let images = unsafe { functions.get_swapchain_images(raw.raw()) };
        let images = images.called("vkGetSwapchainImagesKHR")?;
        let view = |&image: &vk::Image| {
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(raw_format)
                .subresource_range(RANGE);
            // SAFETY: the image is alive as long as the swapchain, which is dropped after its views.
            unsafe { device.create_image_view(&info, "window") }
        };
        let views = images.iter().map(view).collect::<Result<_>>()?;
        let semaphore = |_: &vk::Image| {
            // SAFETY: nothing to promise.
            unsafe { device.create_semaphore(&vk::SemaphoreCreateInfo::default(), "frame finished") }
        };
        let finished = images.iter().map(semaphore).collect::<Result<_>>()?;
        let made_for = (can.current_extent, can.current_transform);
        let surface = Rc::clone(surface);
        Ok(Some(Self {
            finished,
            views,
            raw,
            presented: vec![Cell::new(0); images.len()],
            images,
            functions,
            format,
            usage,
            extent,
            pre_rotation,
            made_for,
            surface,
        }))
    }

    /// The images' format.
    pub fn format(&self) -> OutputFormat {
        self.format
    }

    /// Width and height of the images, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.extent.width, self.extent.height]
    }

    /// How pictures have to be turned that are drawn to the images: what [`Target::pre_rotate`](super::Target::pre_rotate) asks.
    pub fn pre_rotation(&self) -> PreRotation {
        self.pre_rotation
    }

    /// Whether the images may be input attachments: what [`Options::output_is_input_attachment`](crate::plan::Options) asks.
    pub fn is_input_attachment(&self) -> bool {
        self.usage.contains(vk::ImageUsageFlags::INPUT_ATTACHMENT)
    }

    /// The images, to make a [`Target`](super::Target) of.
    pub fn outputs(&self) -> Vec<OutputImage> {
        let all = self.images.iter().zip(&self.views);
        all.map(|(&image, view)| OutputImage { image, view: view.raw() }).collect()
    }

    /// Whether the surface has changed since, so that a new swapchain would fit it better.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn is_outdated(&self) -> Result<bool> {
        let can = self.surface.capabilities()?;
        Ok((can.current_extent, can.current_transform) != self.made_for)
    }

    /// A buffer for [`Self::read`].
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the surface's images cannot be copied; [`Error::Vulkan`].
    pub fn readback(&self) -> Result<Readback> {
        if !self.usage.contains(vk::ImageUsageFlags::TRANSFER_SRC) {
            return Err(Error::unsupported(
                "the window's images cannot be read back",
                "use 'ontile render' with the same camera",
            ));
        }
        Readback::new(self.surface.device(), conv::format(Format::from(self.format)), self.size())
    }

    /// Records the copy of a frame, after it and before it is presented.
    pub fn read(&self, recorder: &Recorder<'_>, image: usize, readback: &Readback) {
        let layout = vk::ImageLayout::PRESENT_SRC_KHR;
        readback.record_raw(recorder, self.images[image], RANGE, (layout, layout));
    }

    /// What was copied, once the frame has finished, turned as the images are.
    pub fn picture(&self, readback: &Readback) -> Picture {
        offscreen::picture(readback, Format::from(self.format))
    }

    /// The next image, which `acquired` will be signalled for.
    pub(super) fn acquire(&self, acquired: &Owned<vk::Semaphore>) -> Result<(u32, bool), vk::Result> {
        let no_fence = vk::Fence::null();
        // SAFETY: the semaphore is unsignalled, and nothing waits to signal it.
        unsafe { self.functions.acquire_next_image(self.raw.raw(), u64::MAX, acquired.raw(), no_fence) }
    }

    pub(super) fn finished(&self, image: u32) -> vk::Semaphore {
        self.finished[image as usize].raw()
    }

    /// An image is presented by the frame of this number; by which it was before, 0: by none.
    pub(super) fn presents(&self, image: u32, frame: u64) -> u64 {
        self.presented[image as usize].replace(frame)
    }

    /// Presents an image once its semaphore is signalled.
    pub(super) fn present(&self, image: u32) -> Result<bool, vk::Result> {
        let (swapchains, images) = ([self.raw.raw()], [image]);
        let finished = [self.finished(image)];
        let info = vk::PresentInfoKHR::default()
            .swapchains(&swapchains)
            .image_indices(&images)
            .wait_semaphores(&finished);
        let queue = self.surface.device().queue();
        // SAFETY: the image was acquired and its frame submitted, which signals the semaphore; the queue is locked.
        unsafe { self.functions.queue_present(*queue, &info) }
    }
}

const RANGE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// None if the window has none; the surface's own; or where it follows its images (as on Wayland) the window's. Both are of the upright
/// picture, images those of the screen.
fn extent(
    can: &vk::SurfaceCapabilitiesKHR,
    window_size: [u32; 2],
    pre_rotation: PreRotation,
) -> vk::Extent2D {
    if window_size.contains(&0) {
        return vk::Extent2D::default();
    }
    let own = can.current_extent;
    if own.width != u32::MAX {
        let [width, height] = pre_rotation.size([own.width, own.height]);
        return vk::Extent2D { width, height };
    }
    let [width, height] = pre_rotation.size(window_size);
    let (least, most) = (can.min_image_extent, can.max_image_extent);
    vk::Extent2D {
        width: width.clamp(least.width, most.width),
        height: height.clamp(least.height, most.height),
    }
}

/// As the screen is turned, if images may be; else upright.
fn choose_pre_rotation(
    can: &vk::SurfaceCapabilitiesKHR,
) -> Result<(PreRotation, vk::SurfaceTransformFlagsKHR)> {
    use vk::SurfaceTransformFlagsKHR as Transform;
    let known = [
        (PreRotation::Identity, Transform::IDENTITY),
        (PreRotation::Rotate90, Transform::ROTATE_90),
        (PreRotation::Rotate180, Transform::ROTATE_180),
        (PreRotation::Rotate270, Transform::ROTATE_270),
    ];
    let offered =
        |wanted| known.into_iter().find(|(_, t)| *t == wanted && can.supported_transforms.contains(wanted));
    offered(can.current_transform).or_else(|| offered(Transform::IDENTITY)).ok_or_else(|| {
        Error::unsupported(
            format!("the screen is turned ({:?}) and takes only images turned alike", can.current_transform),
            "turn the screen back",
        )
    })
}

fn check_mode(offered: &[vk::PresentModeKHR], mode: PresentMode) -> Result<()> {
    if offered.contains(&mode.raw()) {
        return Ok(());
    }
    let has = PresentMode::ALL.iter().filter(|m| offered.contains(&m.raw())).map(|m| m.name());
    Err(Error::unsupported(
        format!("the window does not present by '{mode}'"),
        format!("use --present {}", has.collect::<Vec<_>>().join("|")),
    ))
}

fn choose_format(offered: &[vk::SurfaceFormatKHR]) -> Result<(OutputFormat, vk::ColorSpaceKHR)> {
    let colors = vk::ColorSpaceKHR::SRGB_NONLINEAR;
    let has = |format: OutputFormat| {
        let format = conv::format(Format::from(format));
        offered.iter().any(|o| o.format == format && o.color_space == colors)
    };
    let found = FORMATS.into_iter().find(|&format| has(format));
    found.map(|format| (format, colors)).ok_or_else(|| {
        Error::unsupported(
            "the window has no format that encodes sRGB (B8G8R8A8_SRGB or R8G8B8A8_SRGB)",
            "use 'ontile render', or another driver",
        )
    })
}

/// Opaque where the surface allows it.
fn composite_alpha(can: vk::CompositeAlphaFlagsKHR) -> vk::CompositeAlphaFlagsKHR {
    use vk::CompositeAlphaFlagsKHR as Alpha;
    let wanted = [Alpha::OPAQUE, Alpha::INHERIT, Alpha::PRE_MULTIPLIED];
    wanted.into_iter().find(|alpha| can.contains(*alpha)).unwrap_or(Alpha::POST_MULTIPLIED)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(width: u32, height: u32) -> vk::Extent2D {
        vk::Extent2D { width, height }
    }

    #[test]
    fn the_surface_decides_its_size_unless_it_leaves_that_open() {
        let fixed = vk::SurfaceCapabilitiesKHR { current_extent: at(30, 20), ..Default::default() };
        let upright = PreRotation::Identity;
        assert_eq!(extent(&fixed, [640, 480], upright), at(30, 20));
        assert_eq!(extent(&fixed, [640, 480], PreRotation::Rotate90), at(20, 30));
        let open = vk::SurfaceCapabilitiesKHR {
            current_extent: at(u32::MAX, u32::MAX),
            min_image_extent: at(1, 1),
            max_image_extent: at(100, 100),
            ..Default::default()
        };
        assert_eq!(extent(&open, [640, 48], upright), at(100, 48));
        assert_eq!(extent(&open, [640, 48], PreRotation::Rotate270), at(48, 100));
        assert_eq!(extent(&open, [640, 0], upright), at(0, 0));
        assert_eq!(extent(&fixed, [0, 480], upright), at(0, 0));
    }

    #[test]
    fn images_lie_as_the_screen_does_where_they_may() {
        use vk::SurfaceTransformFlagsKHR as Transform;
        let chosen = |current_transform, supported_transforms| {
            let can =
                vk::SurfaceCapabilitiesKHR { current_transform, supported_transforms, ..Default::default() };
            choose_pre_rotation(&can)
        };
        let all = Transform::IDENTITY | Transform::ROTATE_90 | Transform::ROTATE_180 | Transform::ROTATE_270;
        let turned = (PreRotation::Rotate270, Transform::ROTATE_270);
        assert_eq!(chosen(Transform::ROTATE_270, all).unwrap(), turned);
        let upright = (PreRotation::Identity, Transform::IDENTITY);
        assert_eq!(chosen(Transform::ROTATE_90, Transform::IDENTITY).unwrap(), upright);
        assert_eq!(chosen(Transform::HORIZONTAL_MIRROR, Transform::IDENTITY).unwrap(), upright);
        assert!(chosen(Transform::ROTATE_90, Transform::INHERIT).is_err());
    }

    #[test]
    fn what_a_surface_lacks_is_told() {
        let modes = [vk::PresentModeKHR::FIFO, vk::PresentModeKHR::IMMEDIATE];
        assert!(check_mode(&modes, PresentMode::Fifo).is_ok());
        let error = check_mode(&modes, PresentMode::Mailbox).unwrap_err().to_string();
        assert!(error.contains("'mailbox'; use --present fifo|immediate"), "{error}");
        let of = |format| vk::SurfaceFormatKHR { format, color_space: vk::ColorSpaceKHR::SRGB_NONLINEAR };
        let offered = [of(vk::Format::B8G8R8A8_UNORM), of(vk::Format::R8G8B8A8_SRGB)];
        assert_eq!(choose_format(&offered).unwrap().0, OutputFormat::Rgba8Srgb);
        assert!(choose_format(&offered[..1]).is_err());
    }
}

//! A device of our own that presents to windows, and the surfaces of those windows.

use std::sync::Arc;

use ash::{khr, vk};
use raw_window_handle::{HandleError, HasDisplayHandle, HasWindowHandle};

use super::headless::{Candidate, OwnedInstance};
use super::{Called, Device, Headless, HeadlessOptions};
use crate::{Error, Result};

/// A window of the system's, by the handles that it lends.
pub trait WindowHandles: HasWindowHandle + HasDisplayHandle {}

impl<W: HasWindowHandle + HasDisplayHandle> WindowHandles for W {}

/// Instance, device and queue of our own, for windows of one display.
pub struct WindowHost {
    host: Headless,
    functions: khr::surface::Instance,
    entry: ash::Entry,
}

impl WindowHost {
    /// Loads Vulkan and makes a device of version 1.1 with one queue that draws and presents to this window.
    ///
    /// # Errors
    /// As [`Headless::new`], and [`Error::Unsupported`] without a device that presents to the window.
    pub fn new(options: &HeadlessOptions, window: &Arc<dyn WindowHandles>) -> Result<Self> {
        let display = window.display_handle().map_err(no_handle)?.as_raw();
        let extensions =
            ash_window::enumerate_required_extensions(display).called("enumerate_required_extensions")?;
        let instance = OwnedInstance::new(&options.application_name, options.validate, extensions)?;
        let (entry, raw) = instance.functions();
        let (entry, functions) = (entry.clone(), khr::surface::Instance::new(entry, raw));
        let candidates = {
            // The device makes the surface that is drawn to: this one only tells which device can.
            let surface = RawSurface::new(&entry, raw, &functions, window)?;
            let all = instance.candidates()?;
            let names: Vec<_> = all.iter().map(|c| c.caps.name.clone()).collect();
            let can: Vec<_> = all.into_iter().filter(|c| surface.presents(raw, c)).collect();
            if can.is_empty() && !names.is_empty() {
                return Err(Error::unsupported(
                    format!("no device presents to this window: neither of {}", names.join(", ")),
                    "use a driver with VK_KHR_swapchain and one queue family for graphics and presentation",
                ));
            }
            can
        };
        let host = Headless::of(instance, &candidates, options, &[khr::swapchain::NAME])?;
        Ok(Self { host, functions, entry })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        self.host.device()
    }

    /// What the validation layer has said so far.
    pub fn messages(&self) -> Vec<String> {
        self.host.messages()
    }

    /// As [`Headless::finish`].
    pub fn finish(self) -> Vec<String> {
        self.host.finish()
    }

    /// The surface of a window: of the one that the device was made for, again after it was lost, or of another one.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device does not present to that window; [`Error::Vulkan`].
    pub fn surface(&self, window: &Arc<dyn WindowHandles>) -> Result<Surface> {
        let device = self.device();
        let raw = RawSurface::new(&self.entry, device.instance(), &self.functions, window)?;
        if !raw.is_supported(device.physical_device(), device.queue_family()) {
            return Err(Error::unsupported(
                format!("'{}' does not present to this window", device.caps().name),
                "start the program anew with --device, on the screen where it is to run",
            ));
        }
        device.counters().add(vk::ObjectType::SURFACE_KHR, NAME);
        Ok(Surface { raw, device: device.clone() })
    }
}

const NAME: &str = "window";

fn no_handle(error: HandleError) -> Error {
    Error::unsupported(format!("the window has no handle ({error})"), "wait until it is shown")
}

/// A window's surface; it is destroyed before the device, and keeps the window.
pub struct Surface {
    raw: RawSurface,
    device: Device,
}

impl Surface {
    /// The device that presents to it.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Whether an error says that the surface is gone, so that the window wants another.
    pub fn is_lost(error: &Error) -> bool {
        matches!(error, Error::Vulkan { result: vk::Result::ERROR_SURFACE_LOST_KHR, .. })
    }

    pub(super) fn raw(&self) -> vk::SurfaceKHR {
        self.raw.raw
    }

    /// What the surface is now: its size, the images that it allows.
    pub(super) fn capabilities(&self) -> Result<vk::SurfaceCapabilitiesKHR> {
        let functions = &self.raw.functions;
        // SAFETY: device and surface are alive.
        unsafe {
            functions.get_physical_device_surface_capabilities(self.device.physical_device(), self.raw())
        }
        .called("vkGetPhysicalDeviceSurfaceCapabilitiesKHR")
    }

    pub(super) fn formats(&self) -> Result<Vec<vk::SurfaceFormatKHR>> {
        let functions = &self.raw.functions;
        // SAFETY: device and surface are alive.
        unsafe { functions.get_physical_device_surface_formats(self.device.physical_device(), self.raw()) }
            .called("vkGetPhysicalDeviceSurfaceFormatsKHR")
    }

    pub(super) fn present_modes(&self) -> Result<Vec<vk::PresentModeKHR>> {
        let functions = &self.raw.functions;
        // SAFETY: device and surface are alive.
        unsafe {
            functions.get_physical_device_surface_present_modes(self.device.physical_device(), self.raw())
        }
        .called("vkGetPhysicalDeviceSurfacePresentModesKHR")
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        self.device.counters().remove(vk::ObjectType::SURFACE_KHR, NAME);
    }
}

/// A surface while its instance lives.
struct RawSurface {
    raw: vk::SurfaceKHR,
    functions: khr::surface::Instance,
    _window: Arc<dyn WindowHandles>,
}

impl RawSurface {
    fn new(
        entry: &ash::Entry,
        instance: &ash::Instance,
        functions: &khr::surface::Instance,
        window: &Arc<dyn WindowHandles>,
    ) -> Result<Self> {
        let display = window.display_handle().map_err(no_handle)?.as_raw();
        let handle = window.window_handle().map_err(no_handle)?.as_raw();
        // SAFETY: the instance has the display's extensions, and the window is kept as long as its surface.
        let raw = unsafe { ash_window::create_surface(entry, instance, display, handle, None) };
        let raw = raw.called("vkCreateSurface")?;
        Ok(Self { raw, functions: functions.clone(), _window: Arc::clone(window) })
    }

    fn is_supported(&self, device: vk::PhysicalDevice, queue_family: u32) -> bool {
        // SAFETY: device and surface are of one instance, and the family is the device's.
        unsafe { self.functions.get_physical_device_surface_support(device, queue_family, self.raw) }
            .unwrap_or(false)
    }

    fn presents(&self, instance: &ash::Instance, candidate: &Candidate) -> bool {
        let device = candidate.physical_device;
        // SAFETY: the device was enumerated from this instance.
        let offered = unsafe { instance.enumerate_device_extension_properties(device) }.unwrap_or_default();
        let has_swapchain = offered.iter().any(|e| e.extension_name_as_c_str() == Ok(khr::swapchain::NAME));
        has_swapchain && self.is_supported(device, candidate.queue_family)
    }
}

impl Drop for RawSurface {
    fn drop(&mut self) {
        // SAFETY: its swapchains are gone: they keep what has this surface. Its instance outlives it: see the owners.
        unsafe { self.functions.destroy_surface(self.raw, None) };
    }
}

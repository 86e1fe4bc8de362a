//! Frames in flight to a window.

use ash::vk;

use super::{Called, Commands, Device, Owned, Recorder, Swapchain};
use crate::{Error, Result};

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented {
    /// It will be shown.
    Shown,
    /// It will be shown, and another swapchain may fit the window better ([`Swapchain::is_outdated`]).
    Suboptimal,
    /// The swapchain does not fit the window any more: make another.
    OutOfDate,
    /// The window's surface is gone: make another, and then a swapchain.
    SurfaceLost,
}

/// Command buffers and semaphores of the frames that are on their way to a window.
pub struct Presenter {
    slots: Vec<Slot>,
    next: usize,
    device: Device,
}

struct Slot {
    /// Waits for the GPU when it is dropped, so it goes first.
    commands: Commands,
    acquired: Owned<vk::Semaphore>,
}

impl Presenter {
    /// For so many frames on the GPU at a time, at least 1.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn new(device: &Device, frames_in_flight: usize) -> Result<Self> {
        let slot = |_| {
            let commands = Commands::new(device, "window frame")?;
            // SAFETY: nothing to promise.
            let acquired =
                unsafe { device.create_semaphore(&vk::SemaphoreCreateInfo::default(), "image acquired") }?;
            Ok(Slot { commands, acquired })
        };
        let slots = (0..frames_in_flight.max(1)).map(slot).collect::<Result<_>>()?;
        Ok(Self { slots, next: 0, device: device.clone() })
    }

    /// Waits for the slot's last frame and for an image, records with (recorder, slot, index of the image), submits and presents. Nothing
    /// is recorded unless an image was there.
    ///
    /// What is recorded leaves the image in PRESENT_SRC_KHR ([`OutputUse::Present`](crate::plan::OutputUse::Present)).
    ///
    /// # Errors
    /// [`Error::Vulkan`], e.g. when the device was lost.
    pub fn frame(
        &mut self,
        swapchain: &Swapchain,
        record: impl FnOnce(&Recorder<'_>, usize, usize),
    ) -> Result<Presented> {
        let Slot { commands, acquired } = &mut self.slots[self.next];
        commands.wait()?;
        let (image, fits) = match told(swapchain.acquire(acquired), "vkAcquireNextImageKHR")? {
            Ok((image, suboptimal)) => (image, !suboptimal),
            Err(gone) => return Ok(gone),
        };
        commands.record(|recorder| {
            record(recorder, self.next, image as usize);
            Ok(())
        })?;
        let (waited, finished) = ([acquired.raw()], [swapchain.finished(image)]);
        let info = vk::SubmitInfo::default()
            .wait_semaphores(&waited)
            .wait_dst_stage_mask(&[vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT])
            .signal_semaphores(&finished);
        commands.submit_as(info)?;
        self.next = (self.next + 1) % self.slots.len();
        Ok(match told(swapchain.present(image), "vkQueuePresentKHR")? {
            Ok(false) if fits => Presented::Shown,
            Ok(_) => Presented::Suboptimal,
            Err(gone) => gone,
        })
    }

    /// Waits until no frame is on the GPU and none waits to be shown: what they used may be dropped then.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn wait(&mut self) -> Result<()> {
        self.slots.iter_mut().try_for_each(|slot| slot.commands.wait())?;
        let queue = self.device.queue();
        // SAFETY: the queue is locked.
        unsafe { self.device.raw().queue_wait_idle(*queue) }.called("vkQueueWaitIdle")
    }
}

/// What a window's call came to, its failures that are none sorted out.
fn told<T>(result: Result<T, vk::Result>, call: &'static str) -> Result<Result<T, Presented>> {
    match result {
        Ok(value) => Ok(Ok(value)),
        Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Err(Presented::OutOfDate)),
        Err(vk::Result::ERROR_SURFACE_LOST_KHR) => Ok(Err(Presented::SurfaceLost)),
        Err(result) => Err(Error::Vulkan { call, result }),
    }
}

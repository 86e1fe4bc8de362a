//! Frames in flight to a window.

use std::any::Any;

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
    /// What frames that the GPU has not finished, or that wait to be shown, may use.
    retired: Vec<Retired>,
    /// How many frames were submitted; each goes by the number that it made this.
    submitted: u64,
    /// The last frame that the GPU has finished, and the last one whose image the system has taken: those before it too.
    done: Done,
    device: Device,
}

/// Up to which frame something is known; 0: nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Done {
    drawn: u64,
    taken: u64,
}

struct Retired {
    /// The last frames that concern it.
    until: Done,
    _what: Box<dyn Any>,
}

struct Slot {
    /// Waits for the GPU when it is dropped, so it goes first.
    commands: Commands,
    acquired: Owned<vk::Semaphore>,
    /// What is known once its last frame has finished: an image that is acquired again was taken by the system before.
    proves: Done,
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
            Ok(Slot { commands, acquired, proves: Done::default() })
        };
        let slots = (0..frames_in_flight.max(1)).map(slot).collect::<Result<_>>()?;
        Ok(Self {
            slots,
            next: 0,
            retired: Vec::new(),
            submitted: 0,
            done: Done::default(),
            device: device.clone(),
        })
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
        let Slot { commands, acquired, proves } = &mut self.slots[self.next];
        commands.wait()?;
        self.done = self.done.later(*proves);
        self.retired.retain(|retired| !self.done.covers(retired.until));
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
        self.submitted += 1;
        *proves = Done { drawn: self.submitted, taken: swapchain.presents(image, self.submitted) };
        self.next = (self.next + 1) % self.slots.len();
        Ok(match told(swapchain.present(image), "vkQueuePresentKHR")? {
            Ok(false) if fits => Presented::Shown,
            Ok(_) => Presented::Suboptimal,
            Err(gone) => gone,
        })
    }

    /// Keeps what frames use until the GPU has finished those that were submitted so far. Nothing waits.
    pub fn retire(&mut self, what: impl Any) {
        let until = Done { drawn: self.submitted, taken: 0 };
        self.retired.push(Retired { until, _what: Box::new(what) });
    }

    /// Keeps a swapchain that another one has replaced until its images were shown, which the system tells by giving an image of the
    /// other one a second time.
    ///
    /// # Errors
    /// As [`Self::wait`], which is what happens if many were kept before: those of a window that changes faster than it shows frames.
    pub fn retire_swapchain(&mut self, swapchain: Swapchain) -> Result<()> {
        /// A window's images take much memory.
        const MOST: usize = 4;
        if self.retired.iter().filter(|retired| retired.until.taken > 0).count() >= MOST {
            self.wait()?;
        }
        let until = Done { drawn: self.submitted, taken: self.submitted };
        self.retired.push(Retired { until, _what: Box::new(swapchain) });
        Ok(())
    }

    /// Waits until no frame is on the GPU and none waits to be shown: what they used may be dropped then. What was retired is.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn wait(&mut self) -> Result<()> {
        self.slots.iter_mut().try_for_each(|slot| slot.commands.wait())?;
        let queue = self.device.queue();
        // SAFETY: the queue is locked.
        unsafe { self.device.raw().queue_wait_idle(*queue) }.called("vkQueueWaitIdle")?;
        drop(queue);
        self.retired.clear();
        Ok(())
    }
}

impl Done {
    fn later(self, other: Self) -> Self {
        Self { drawn: self.drawn.max(other.drawn), taken: self.taken.max(other.taken) }
    }

    fn covers(self, until: Self) -> bool {
        self.drawn >= until.drawn && self.taken >= until.taken
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

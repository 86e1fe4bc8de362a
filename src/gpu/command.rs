//! Recording commands, and running them for programs and tests.

use super::{Called, Device, Owned};
use crate::{Error, Result};
use ash::vk;
use std::ffi::CStr;

/// A command buffer in the recording state: a host's or our own.
///
/// What is recorded refers to buffers, images and so on; whoever submits keeps those alive until the GPU is
/// done.
#[derive(Clone, Copy, Debug)]
pub struct Recorder<'a> {
    device: &'a Device,
    raw: vk::CommandBuffer,
}

impl<'a> Recorder<'a> {
    /// Records into a host's command buffer.
    ///
    /// # Safety
    /// `raw` is a primary command buffer from a pool of [`Device::queue_family`], in the recording state, outside of a
    /// render pass unless a function says otherwise, and not used by another thread while the recorder
    /// exists. What is recorded is kept alive until its execution has finished.
    pub unsafe fn from_host(device: &'a Device, raw: vk::CommandBuffer) -> Self {
        Self { device, raw }
    }

    /// The device.
    pub fn device(&self) -> &'a Device {
        self.device
    }

    /// The command buffer.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.raw
    }

    /// Opens a label that debuggers and traces show; dropping the guard closes it. Nothing happens without
    /// VK_EXT_debug_utils. Names are cut at 63 bytes: recording a frame allocates nothing.
    #[must_use = "the label ends when the guard is dropped"]
    pub fn label(&self, name: &str) -> Label<'a> {
        let debug_utils = self.device.debug_utils();
        if let Some(debug_utils) = debug_utils {
            let mut text = [0; 64];
            let length = name.len().min(text.len() - 1);
            text[..length].copy_from_slice(&name.as_bytes()[..length]);
            let name = CStr::from_bytes_until_nul(&text).expect("the last byte is never written");
            let info = vk::DebugUtilsLabelEXT::default().label_name(name);
            // SAFETY: the command buffer is recording.
            unsafe { debug_utils.cmd_begin_debug_utils_label(self.raw, &info) };
        }
        Label { recorder: *self, open: debug_utils.is_some() }
    }
}

/// A label that is open; see [`Recorder::label`].
pub struct Label<'a> {
    recorder: Recorder<'a>,
    open: bool,
}

impl Drop for Label<'_> {
    fn drop(&mut self) {
        if let (true, Some(debug_utils)) = (self.open, self.recorder.device.debug_utils()) {
            // SAFETY: the command buffer is recording, and the label was opened in it.
            unsafe { debug_utils.cmd_end_debug_utils_label(self.recorder.raw) };
        }
    }
}

/// One command buffer with its pool and fence, to record and run again and again.
///
/// For programs and tests: [`Self::wait`] blocks. Hosts use command buffers of their own with
/// [`Recorder::from_host`].
#[derive(Debug)]
pub struct Commands {
    fence: Owned<vk::Fence>,
    pool: Owned<vk::CommandPool>,
    raw: vk::CommandBuffer,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Nothing to submit.
    Empty,
    /// Recorded and not submitted yet.
    Recorded,
    /// Submitted and not waited for yet.
    Pending,
}

impl Commands {
    /// Makes an empty command buffer.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn new(device: &Device, name: &str) -> Result<Self> {
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(device.queue_family());
        // SAFETY: the family is the device's.
        let pool = unsafe { device.create_command_pool(&info, name) }?;
        // SAFETY: nothing to promise.
        let fence = unsafe { device.create_fence(&vk::FenceCreateInfo::default(), name) }?;
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(pool.raw())
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool is alive; it frees the buffer with itself.
        let buffers = unsafe { device.raw().allocate_command_buffers(&info) };
        let raw = buffers.called("vkAllocateCommandBuffers")?[0];
        device.set_name(raw, name);
        Ok(Self { fence, pool, raw, state: State::Empty })
    }

    /// Records and runs commands once, and waits for them.
    ///
    /// # Errors
    /// What `record` returned (then nothing runs), or [`Error::Vulkan`].
    pub fn run<T>(device: &Device, name: &str, record: impl FnOnce(&Recorder<'_>) -> Result<T>) -> Result<T> {
        let mut commands = Self::new(device, name)?;
        let value = commands.record(record)?;
        commands.submit()?;
        commands.wait()?;
        Ok(value)
    }

    /// Records anew, after waiting for the last submission.
    ///
    /// # Errors
    /// What `record` returned (then there is nothing to submit), or [`Error::Vulkan`].
    pub fn record<T>(&mut self, record: impl FnOnce(&Recorder<'_>) -> Result<T>) -> Result<T> {
        self.wait()?;
        self.state = State::Empty;
        let device = self.pool.device();
        let raw = device.raw();
        // SAFETY: the GPU has finished with the pool's only buffer.
        unsafe { raw.reset_command_pool(self.pool.raw(), vk::CommandPoolResetFlags::empty()) }
            .called("vkResetCommandPool")?;
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the buffer is in the initial state.
        unsafe { raw.begin_command_buffer(self.raw, &info) }.called("vkBeginCommandBuffer")?;
        let value = record(&Recorder { device, raw: self.raw })?;
        // SAFETY: the buffer is recording.
        unsafe { raw.end_command_buffer(self.raw) }.called("vkEndCommandBuffer")?;
        self.state = State::Recorded;
        Ok(value)
    }

    /// Submits what was recorded, once.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if nothing was recorded since; [`Error::Vulkan`].
    pub fn submit(&mut self) -> Result<()> {
        self.submit_as(vk::SubmitInfo::default())
    }

    /// As [`Self::submit`], with the semaphores of `info`.
    pub(super) fn submit_as(&mut self, info: vk::SubmitInfo<'_>) -> Result<()> {
        if self.state != State::Recorded {
            return Err(Error::unsupported(
                "there are no commands to submit",
                "record some before each submission",
            ));
        }
        let device = self.pool.device();
        let buffers = [self.raw];
        let submits = [info.command_buffers(&buffers)];
        let queue = device.queue();
        // SAFETY: the fence is unsignalled and not in use (`record` waited), and the queue is locked.
        unsafe { device.raw().queue_submit(*queue, &submits, self.fence.raw()) }.called("vkQueueSubmit")?;
        drop(queue);
        self.state = State::Pending;
        Ok(())
    }

    /// Waits until the GPU has finished; returns at once if nothing was submitted.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn wait(&mut self) -> Result<()> {
        if self.state != State::Pending {
            return Ok(());
        }
        let device = self.pool.device().raw();
        let fences = [self.fence.raw()];
        // SAFETY: the fence is alive and was submitted.
        unsafe { device.wait_for_fences(&fences, true, u64::MAX) }.called("vkWaitForFences")?;
        self.state = State::Empty;
        // SAFETY: the fence is signalled, so no queue uses it.
        unsafe { device.reset_fences(&fences) }.called("vkResetFences")
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        if let Err(e) = self.wait() {
            log::error!("{e}");
        }
    }
}

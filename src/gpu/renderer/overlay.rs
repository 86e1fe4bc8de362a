//! What a host draws over the picture.

use super::Renderer;
use crate::gpu::OverlayFrame;
use crate::{Error, Result};

impl Renderer {
    /// Sets the image that an overlay's triangles take their colours from: RGBA, encoded as sRGB and multiplied by alpha after that,
    /// row by row from the top. At first it is one white texel. Waits until it is copied.
    ///
    /// No frame of this renderer is on the GPU.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the plan has no overlay ([`Options::overlay`](crate::plan::Options::overlay)), or there are not 4 bytes
    /// a texel; [`Error::Vulkan`].
    pub fn set_overlay_image(&mut self, size: [u32; 2], texels: &[u8]) -> Result<()> {
        let Self { overlay, device, upload, .. } = self;
        let before = overlay.as_mut().ok_or_else(no_overlay)?.set_image(device, size, texels)?;
        if let Some(upload) = upload {
            upload.keep(before);
        }
        Ok(())
    }

    /// Sets what is drawn over the frames that are recorded with this slot; the GPU has finished the one recorded with it before. Without
    /// that, nothing is.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the plan has no overlay, or an index is not one of a vertex; [`Error::Vulkan`] if buffers have to
    /// grow, which they do by doubling.
    ///
    /// # Panics
    /// If `slot` is out of range.
    pub fn set_overlay(&mut self, slot: usize, frame: &OverlayFrame<'_>) -> Result<()> {
        let Self { overlay, device, .. } = self;
        overlay.as_mut().ok_or_else(no_overlay)?.set(device, slot, frame)
    }
}

fn no_overlay() -> Error {
    Error::unsupported("the plan has no overlay", "ask for one in `Options::overlay`")
}

//! What devices there are, for people.

use super::Caps;
use super::headless::OwnedInstance;
use crate::Result;
use std::fmt;

/// All devices that could be used, in the order in which [`Headless`](super::Headless) prefers them.
///
/// # Errors
/// [`crate::Error::Unsupported`] without a Vulkan loader, [`crate::Error::Vulkan`] without a driver.
pub fn devices() -> Result<Vec<Caps>> {
    let instance = OwnedInstance::new("ontile", false, &[])?;
    Ok(instance.candidates()?.into_iter().map(|c| c.caps).collect())
}

impl fmt::Display for Caps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let yes = |b: bool| if b { "yes" } else { "no" };
        let [major, minor, patch] = self.api_version;
        writeln!(f, "{} ({:?})", self.name, self.device_type)?;
        writeln!(f, "  driver                      {}", self.driver)?;
        writeln!(f, "  Vulkan                      {major}.{minor}.{patch}")?;
        writeln!(f, "  lazily allocated memory     {}", yes(self.lazily_allocated_memory))?;
        writeln!(
            f,
            "  input attachments           {} per stage, {} per set",
            self.max_per_stage_descriptor_input_attachments, self.max_descriptor_set_input_attachments
        )?;
        writeln!(f, "  colour attachments          {}", self.max_color_attachments)?;
        writeln!(
            f,
            "  largest framebuffer         {} x {}",
            self.max_framebuffer_size[0], self.max_framebuffer_size[1]
        )?;
        let samples: Vec<_> = self.sample_counts.iter().map(u32::to_string).collect();
        writeln!(f, "  samples                     {}", samples.join(", "))?;
        match self.timestamp_valid_bits {
            0 => writeln!(f, "  timestamps                  no")?,
            bits => {
                writeln!(f, "  timestamps                  {bits} bits, {} ns", self.timestamp_period_ns)?
            }
        }
        writeln!(f, "  pipeline statistics         {}", yes(self.pipeline_statistics))?;
        writeln!(f, "  arrays of cube maps         {}", yes(self.image_cube_array))?;
        writeln!(f, "  local read                  {}", yes(self.local_read))?;
        writeln!(f, "  rasterization-order access  {}", yes(self.rasterization_order_attachment_access))?;
        writeln!(f, "  subpass merge feedback      {}", yes(self.subpass_merge_feedback))?;
        for (i, ty) in self.memory_types.iter().enumerate() {
            let mib = ty.heap_bytes >> 20;
            writeln!(
                f,
                "  memory type {i:<2}              heap {} of {mib} MiB: {}",
                ty.heap,
                ty.properties.join(", ")
            )?;
        }
        Ok(())
    }
}

//! What devices there are, for people.

use super::headless::{Candidate, OwnedInstance};
use super::{Caps, Counter, counters};
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

/// The same with the performance counters of each; empty where the device has none.
///
/// # Errors
/// As [`devices`].
pub fn devices_with_counters() -> Result<Vec<(Caps, Vec<Counter>)>> {
    let owner = OwnedInstance::new("ontile", false, &[])?;
    let (entry, instance) = owner.functions();
    // SAFETY: the instance was made with this entry.
    let calls = unsafe { counters::instance_calls(entry, instance) };
    let with_counters = |candidate: Candidate| {
        let Candidate { physical_device, queue_family, caps } = candidate;
        let all = match caps.performance_counters {
            // SAFETY: the functions are of this instance, and the device has the extension.
            true => unsafe { counters::list(&calls, physical_device, queue_family) }?.0,
            false => Vec::new(),
        };
        Ok((caps, all))
    };
    owner.candidates()?.into_iter().map(with_counters).collect()
}

impl fmt::Display for Counter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, category, description, unit, scope, .. } = self;
        write!(f, "{name} ({category}; {unit}, per {})", scope.replace('_', " "))?;
        if self.performance_impacting {
            write!(f, ", slows down")?;
        }
        if self.concurrently_impacted {
            write!(f, ", counts others too")?;
        }
        match description.is_empty() || description == name {
            true => Ok(()),
            false => write!(f, ": {description}"),
        }
    }
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
        writeln!(f, "  performance counters        {}", yes(self.performance_counters))?;
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

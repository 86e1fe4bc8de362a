//! Compiled pipelines, kept between runs.
//!
//! A driver may crash on damaged cache data, so ours goes into an envelope with a checksum and the identity
//! of device and driver; whatever does not match is thrown away and made again.

use super::pass::VulkanPass;
use super::pipeline::Pipelines;
use super::poses::prepare_poses;
use super::post::PostPasses;
use super::shader::Modules;
use super::shadow::prepare_casters;
use super::{Called, Caps, Device, Owned};
use crate::plan::Plan;
use crate::{Error, Result};
use ash::vk;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A pipeline cache. Clones are the same cache.
#[derive(Clone, Debug)]
pub struct PipelineCache {
    raw: Arc<Owned<vk::PipelineCache>>,
    modules: Modules,
}

impl PipelineCache {
    /// Makes a cache from what [`Self::blob`] gave earlier; from nothing if that was damaged, cut short, or
    /// came from another device or driver.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn new(device: &Device, blob: &[u8]) -> Result<Self> {
        let initial = open(device.caps(), blob).unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(initial);
        // SAFETY: the data is what this driver itself returned: identity and checksum were compared.
        let raw = unsafe { device.create_pipeline_cache(&info, "pipelines") }?;
        Ok(Self { raw: Arc::new(raw), modules: Modules::default() })
    }

    /// The same cache, for pipelines that are made of these shader modules from now on.
    #[doc(hidden)]
    pub fn with_modules(&self, modules: Modules) -> Self {
        Self { raw: Arc::clone(&self.raw), modules }
    }

    /// What pipelines are made of.
    pub(super) fn modules(&self) -> &Modules {
        &self.modules
    }

    /// Makes a cache from the file of this device in the user's cache directory; from nothing without one.
    ///
    /// # Errors
    /// [`Error::Vulkan`]; never because of the file.
    pub fn load(device: &Device) -> Result<Self> {
        let blob = file(device.caps()).and_then(|path| std::fs::read(path).ok());
        Self::new(device, &blob.unwrap_or_default())
    }

    /// Writes the file that [`Self::load`] reads. A failure costs only the time of the next run, so it is
    /// logged and no more.
    pub fn store(&self) {
        let Some(path) = file(self.raw.device().caps()) else { return };
        if let Err(e) = self.blob().and_then(|blob| replace(&path, &blob)) {
            log::warn!("pipelines are not kept: {e}");
        }
    }

    /// Compiles all pipelines of a plan ([`Plan::pipelines`], those of its shadow map and of its passes after the frame's own), so that
    /// [`Renderer::new`](super::Renderer::new) finds them here, and so do later runs that start from [`Self::blob`]. It may run on any
    /// thread, e.g. while a level is loaded.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device lacks a format; [`Error::Vulkan`].
    pub fn prepare(&self, plan: &Plan) -> Result<()> {
        let device = self.raw.device();
        super::check_formats(device, plan)?;
        let passes: Vec<_> =
            plan.passes.iter().map(|pass| VulkanPass::new(device, plan, pass)).collect::<Result<_>>()?;
        let pipelines = Pipelines::new(device, plan, &passes, self)?;
        PostPasses::new(device, plan, &pipelines, self)?;
        plan.needs.posed.as_ref().map_or(Ok(()), |_| prepare_poses(device, self))?;
        plan.shadow_map.as_ref().map_or(Ok(()), |map| prepare_casters(device, map, self))
    }

    /// The handle, valid as long as this owner.
    pub fn raw(&self) -> vk::PipelineCache {
        self.raw.raw()
    }

    /// The content, for [`Self::new`] in a later run.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn blob(&self) -> Result<Vec<u8>> {
        let device = self.raw.device();
        // SAFETY: the cache is alive.
        let data =
            unsafe { device.raw().get_pipeline_cache_data(self.raw()) }.called("vkGetPipelineCacheData")?;
        Ok(seal(device.caps(), &data))
    }
}

/// The envelope: magic, vendor, device, cache UUID, and the content's length and checksum; all little-endian.
const MAGIC: &[u8; 8] = b"ONTILEP1";
const ENVELOPE_BYTES: usize = 8 + 4 + 4 + 16 + 8 + 8;

fn seal(caps: &Caps, content: &[u8]) -> Vec<u8> {
    let mut blob = Vec::with_capacity(ENVELOPE_BYTES + content.len());
    blob.extend(MAGIC);
    blob.extend(caps.vendor_id.to_le_bytes());
    blob.extend(caps.device_id.to_le_bytes());
    blob.extend(caps.pipeline_cache_uuid);
    blob.extend((content.len() as u64).to_le_bytes());
    blob.extend(fnv1a(content).to_le_bytes());
    blob.extend(content);
    blob
}

/// The content of an envelope that is whole and of this device and driver.
fn open<'a>(caps: &Caps, blob: &'a [u8]) -> Option<&'a [u8]> {
    let (envelope, content) = blob.split_at_checked(ENVELOPE_BYTES)?;
    // The envelope follows from device and content, so it is right only if it is what sealing would write.
    (envelope == &seal(caps, content)[..ENVELOPE_BYTES] && is_of_driver(caps, content)).then_some(content)
}

/// Vulkan's own header, VkPipelineCacheHeaderVersionOne: length 32, version 1, vendor, device, UUID.
fn is_of_driver(caps: &Caps, content: &[u8]) -> bool {
    let word =
        |i: usize| content.get(i * 4..i * 4 + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    word(0).is_some_and(|length| length >= 32)
        && word(1) == Some(1)
        && word(2) == Some(caps.vendor_id)
        && word(3) == Some(caps.device_id)
        && content.get(16..32) == Some(&caps.pipeline_cache_uuid[..])
}

/// Fowler, Noll and Vo's 64-bit hash, variant 1a: enough against accidents.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, &b| (hash ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// One file per device and driver; `None` without a cache folder.
fn file(caps: &Caps) -> Option<PathBuf> {
    let uuid: String = caps.pipeline_cache_uuid.iter().map(|b| format!("{b:02x}")).collect();
    let name = format!("pipelines-{:04x}-{:04x}-{uuid}.bin", caps.vendor_id, caps.device_id);
    Some(crate::file::cache_folder()?.join(name))
}

/// Replaces a file at once: readers see the old content or the new, never a part.
fn replace(path: &Path, content: &[u8]) -> Result<()> {
    let directory = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(directory).map_err(|e| Error::io(directory, "create", e))?;
    let temporary = path.with_extension(format!("{}.tmp", std::process::id()));
    let written = std::fs::write(&temporary, content).and_then(|()| std::fs::rename(&temporary, path));
    written.map_err(|e| {
        // It may not even exist.
        let _ = std::fs::remove_file(&temporary);
        Error::io(path, "write", e)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn caps() -> Caps {
        Caps {
            vendor_id: 0x1234,
            device_id: 0x5678,
            pipeline_cache_uuid: std::array::from_fn(|i| i as u8),
            ..Default::default()
        }
    }

    /// What a driver would return: Vulkan's header and something behind it.
    fn content(caps: &Caps) -> Vec<u8> {
        let words = [32, 1, caps.vendor_id, caps.device_id];
        let header = words.iter().flat_map(|w| w.to_le_bytes()).chain(caps.pipeline_cache_uuid);
        header.chain(*b"pipelines").collect()
    }

    #[test]
    fn what_was_sealed_opens() {
        let caps = caps();
        assert_eq!(open(&caps, &seal(&caps, &content(&caps))), Some(&content(&caps)[..]));
    }

    #[test]
    fn any_damage_is_noticed() {
        let caps = caps();
        let blob = seal(&caps, &content(&caps));
        for i in 0..blob.len() {
            let mut damaged = blob.clone();
            damaged[i] ^= 0x10;
            assert_eq!(open(&caps, &damaged), None, "byte {i} changed");
            assert_eq!(open(&caps, &blob[..i]), None, "cut at {i}");
        }
        let longer = [&blob[..], &[0]].concat();
        assert_eq!(open(&caps, &longer), None);
    }

    #[test]
    fn other_devices_and_drivers_are_refused() {
        let caps = caps();
        let blob = seal(&caps, &content(&caps));
        let others = [
            Caps { vendor_id: 1, ..caps.clone() },
            Caps { device_id: 1, ..caps.clone() },
            Caps { pipeline_cache_uuid: [7; 16], ..caps.clone() },
        ];
        for other in &others {
            assert_eq!(open(other, &blob), None);
            // A driver's header of another device in an envelope of this one.
            assert_eq!(open(&caps, &seal(&caps, &content(other))), None);
        }
    }

    #[test]
    fn files_are_replaced_whole() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("deep").join("cache.bin");
        replace(&path, b"old").unwrap();
        replace(&path, b"new").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "a temporary file is left");
        // The directory's place is taken by a file: an error, not a panic.
        assert!(replace(&path.join("below"), b"").is_err());
    }
}

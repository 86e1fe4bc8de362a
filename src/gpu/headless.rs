//! A device of our own, without a window: what programs and tests use.

use super::validation::Messages;
use super::{Called, Caps, Counters, Device, Features, HostDevice};
use crate::{Error, Result};
use ash::{ext, khr, vk};
use std::ffi::{CStr, CString};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
const DRIVER_REMEDY: &str =
    "install a Vulkan loader and driver (on Debian: apt-get install libvulkan1 mesa-vulkan-drivers)";

/// How to make a [`Headless`].
#[derive(Clone, Debug, Default)]
pub struct HeadlessOptions {
    /// Take the first device whose name or driver contains this, whatever its case. Otherwise the best by
    /// type: discrete, integrated, virtual, CPU.
    pub device_name_part: Option<String>,
    /// Run under the Khronos validation layer (core, synchronisation and best practices) and collect its
    /// messages.
    pub validate: bool,
    /// Told to the driver.
    pub application_name: String,
    /// Enable VK_KHR_performance_query, for [`Headless::counters`]; a device without it is refused.
    pub performance_counters: bool,
}

/// Instance, device and queue of our own.
pub struct Headless {
    device: Device,
    messages: Messages,
    /// Keeps the Vulkan library loaded.
    entry: ash::Entry,
}

impl std::fmt::Debug for Headless {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Headless").field(&self.device).finish()
    }
}

impl Headless {
    /// Loads Vulkan and makes a device of version 1.1 with one graphics queue.
    ///
    /// # Errors
    /// [`Error::Unsupported`] without a loader, a driver, a device that matches, or (if asked for) the
    /// validation layer; [`Error::Vulkan`] if a call fails.
    pub fn new(options: &HeadlessOptions) -> Result<Self> {
        let instance = OwnedInstance::new(&options.application_name, options.validate, &[])?;
        let candidates = instance.candidates()?;
        Self::of(instance, &candidates, options, &[])
    }

    /// Makes the device that the options ask for, with some extensions that it has.
    pub(super) fn of(
        instance: OwnedInstance,
        candidates: &[Candidate],
        options: &HeadlessOptions,
        extensions: &[&'static CStr],
    ) -> Result<Self> {
        let messages = (*instance.messages).clone();
        let chosen = choose(candidates, options.device_name_part.as_deref())?;
        log::info!("using {} ({})", chosen.caps.name, chosen.caps.driver);
        let entry = instance.entry.clone();
        let device = open(instance, chosen, options.performance_counters, extensions)?;
        Ok(Self { device, messages, entry })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The device's performance counters.
    ///
    /// # Errors
    /// [`Error::Unsupported`] without [`HeadlessOptions::performance_counters`]; [`Error::Vulkan`].
    pub fn counters(&self) -> Result<Counters> {
        // SAFETY: the device's instance was made with this entry.
        unsafe { Counters::from_host(&self.entry, &self.device) }
    }

    /// What the validation layer has said so far.
    pub fn messages(&self) -> Vec<String> {
        self.messages.all()
    }

    /// Destroys the device and returns all that the validation layer said, during destruction too.
    ///
    /// An object that is still alive keeps the device alive; then one more message says so.
    pub fn finish(self) -> Vec<String> {
        let Self { device, messages, entry: _entry } = self;
        let others = device.owners() - 1;
        if others > 0 {
            messages.push(format!("device still in use by {others} owners: {:?}", device.live()));
        }
        drop(device);
        messages.all()
    }
}

/// A physical device that could be used.
pub(super) struct Candidate {
    pub(super) physical_device: vk::PhysicalDevice,
    pub(super) queue_family: u32,
    pub(super) caps: Caps,
}

/// The instance and its messenger; destroyed in that order reversed.
pub(super) struct OwnedInstance {
    raw: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    debug_utils: bool,
    /// Boxed: the layer holds its address until the instance is gone.
    messages: Box<Messages>,
    /// Unloads the Vulkan library, so it goes last.
    entry: ash::Entry,
}

impl OwnedInstance {
    /// With further extensions, which the loader offers.
    pub(super) fn new(
        application_name: &str,
        validate: bool,
        further: &[*const std::ffi::c_char],
    ) -> Result<Self> {
        // SAFETY: the loader runs its initialisers; it is the system's Vulkan library.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| {
            Error::unsupported(format!("the Vulkan loader cannot be loaded ({e})"), DRIVER_REMEDY)
        })?;
        // SAFETY: no preconditions.
        let version = unsafe { entry.try_enumerate_instance_version() }
            .called("vkEnumerateInstanceVersion")?
            .unwrap_or(vk::API_VERSION_1_0);
        if version < vk::API_VERSION_1_1 {
            return Err(Error::unsupported("the Vulkan loader is of version 1.0", DRIVER_REMEDY));
        }
        let debug_utils = validate || offers(&entry, None, ext::debug_utils::NAME)?;
        let layer_extensions = if validate { layer_extensions(&entry)? } else { Vec::new() };
        let layer_has = |name: &CStr| layer_extensions.iter().any(|e| e == name);

        let mut extensions = further.to_vec();
        if debug_utils {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        // The newer extension can also ask for the checks of vendors.
        let layer_settings = layer_has(ext::layer_settings::NAME);
        let validation_features = !layer_settings && layer_has(ext::validation_features::NAME);
        if layer_settings {
            extensions.push(ext::layer_settings::NAME.as_ptr());
        }
        if validation_features {
            extensions.push(ext::validation_features::NAME.as_ptr());
        }
        let layers: &[_] = if validate { &[VALIDATION_LAYER.as_ptr()] } else { &[] };

        let name = CString::new(application_name).unwrap_or_default();
        let application = vk::ApplicationInfo::default()
            .application_name(&name)
            .engine_name(c"ontile")
            .api_version(vk::API_VERSION_1_1);
        let messages = Box::new(Messages::default());
        let mut messenger_info = messages.messenger_info();
        let enables = [
            vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION,
            vk::ValidationFeatureEnableEXT::BEST_PRACTICES,
        ];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enables);
        let on = vk::TRUE.to_ne_bytes();
        let setting = |name| {
            vk::LayerSettingEXT::default()
                .layer_name(VALIDATION_LAYER)
                .setting_name(name)
                .ty(vk::LayerSettingTypeEXT::BOOL32)
                .values(&on)
        };
        // `values` counts bytes; the structure counts values.
        let settings = [
            c"validate_sync",
            c"validate_best_practices",
            c"validate_best_practices_arm",
            c"validate_best_practices_img",
        ]
        .map(|name| vk::LayerSettingEXT { value_count: 1, ..setting(name) });
        let mut settings_info = vk::LayerSettingsCreateInfoEXT::default().settings(&settings);

        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_extension_names(&extensions)
            .enabled_layer_names(layers);
        if validate {
            info = info.push_next(&mut messenger_info);
        }
        if validation_features {
            info = info.push_next(&mut features);
        }
        if layer_settings {
            info = info.push_next(&mut settings_info);
        }
        // SAFETY: all that `info` points to is alive; layers and extensions were offered.
        let raw = unsafe { entry.create_instance(&info, None) }.called("vkCreateInstance")?;
        let mut instance = Self { raw, messenger: None, debug_utils, messages, entry };
        if validate {
            let functions = ext::debug_utils::Instance::new(&instance.entry, &instance.raw);
            // SAFETY: the messages live in the instance's owner, which destroys the messenger first.
            let messenger =
                unsafe { functions.create_debug_utils_messenger(&instance.messages.messenger_info(), None) }
                    .called("vkCreateDebugUtilsMessengerEXT")?;
            instance.messenger = Some((functions, messenger));
        }
        Ok(instance)
    }

    /// The function table, and what it was loaded from.
    pub(super) fn functions(&self) -> (&ash::Entry, &ash::Instance) {
        (&self.entry, &self.raw)
    }

    /// Devices of Vulkan 1.1 or later with a graphics queue, best first.
    pub(super) fn candidates(&self) -> Result<Vec<Candidate>> {
        // SAFETY: the instance is alive.
        let devices =
            unsafe { self.raw.enumerate_physical_devices() }.called("vkEnumeratePhysicalDevices")?;
        let mut candidates: Vec<_> = devices.into_iter().filter_map(|d| self.candidate(d)).collect();
        // Stable: the driver's order among equals.
        candidates.sort_by_key(|c| c.caps.device_type);
        Ok(candidates)
    }

    fn candidate(&self, physical_device: vk::PhysicalDevice) -> Option<Candidate> {
        // SAFETY: the device was enumerated from this instance.
        let version = unsafe { self.raw.get_physical_device_properties(physical_device) }.api_version;
        // SAFETY: as above.
        let families = unsafe { self.raw.get_physical_device_queue_family_properties(physical_device) };
        let graphics = families.iter().position(|f| f.queue_flags.contains(vk::QueueFlags::GRAPHICS));
        let queue_family = graphics.filter(|_| version >= vk::API_VERSION_1_1)? as u32;
        // SAFETY: as above; the version was checked.
        let caps = unsafe { Caps::query(&self.raw, physical_device, queue_family) };
        Some(Candidate { physical_device, queue_family, caps })
    }
}

impl Drop for OwnedInstance {
    fn drop(&mut self) {
        if let Some((functions, messenger)) = self.messenger.take() {
            // SAFETY: created from this instance and used by nothing else.
            unsafe { functions.destroy_debug_utils_messenger(messenger, None) };
        }
        // SAFETY: `OwnedDevice` keeps this owner until its device is gone.
        unsafe { self.raw.destroy_instance(None) };
    }
}

/// Our own VkDevice: destroyed when dropped, then the instance.
pub(super) struct OwnedDevice {
    raw: ash::Device,
    _instance: OwnedInstance,
}

impl Drop for OwnedDevice {
    fn drop(&mut self) {
        // SAFETY: every object holds a `Device`, so none is left; nothing was submitted that nobody waited for.
        unsafe { self.raw.destroy_device(None) };
    }
}

fn open(
    instance: OwnedInstance,
    candidate: &Candidate,
    performance_counters: bool,
    further: &[&'static CStr],
) -> Result<Device> {
    let &Candidate { physical_device, queue_family, ref caps } = candidate;
    if performance_counters && !caps.performance_counters {
        return Err(Error::unsupported(
            format!("'{}' has no performance counters (VK_KHR_performance_query)", caps.name),
            "use a device that has by 'ontile info', or do without --counters; some drivers must be told to have them (Mesa's Turnip by TU_DEBUG=perfc)",
        ));
    }
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
    let features = vk::PhysicalDeviceFeatures::default()
        .pipeline_statistics_query(caps.pipeline_statistics)
        .image_cube_array(caps.image_cube_array)
        .occlusion_query_precise(caps.occlusion_precise)
        .independent_blend(caps.local_read)
        .sample_rate_shading(caps.sample_rate_shading)
        .depth_clamp(caps.depth_clamp)
        .shader_clip_distance(caps.depth_clamp)
        .sampler_anisotropy(caps.max_sampler_anisotropy > 1.0)
        .texture_compression_bc(caps.texture_compression_bc)
        .texture_compression_etc2(caps.texture_compression_etc2)
        .texture_compression_astc_ldr(caps.texture_compression_astc);
    // SAFETY: the device was enumerated from this instance.
    let offered = unsafe { instance.raw.enumerate_device_extension_properties(physical_device) };
    let offered = offered.called("vkEnumerateDeviceExtensionProperties")?;
    let order = [
        ext::rasterization_order_attachment_access::NAME,
        ash::arm::rasterization_order_attachment_access::NAME,
    ];
    let mut order =
        order.into_iter().filter(|name| offered.iter().any(|e| e.extension_name_as_c_str() == Ok(name)));
    let order = order.next().filter(|_| caps.rasterization_order_attachment_access);
    // The last three are what the first builds on before Vulkan 1.3.
    let rendering = [
        khr::dynamic_rendering_local_read::NAME,
        khr::dynamic_rendering::NAME,
        khr::depth_stencil_resolve::NAME,
        khr::create_renderpass2::NAME,
    ];
    // Not where it would crash.
    let has_local_read = caps.limits().merging.local_read.is_ok();
    let rendering = rendering.iter().filter(|_| has_local_read);
    let feedback = [ext::subpass_merge_feedback::NAME, khr::create_renderpass2::NAME];
    let feedback = feedback.iter().filter(|_| caps.subpass_merge_feedback);
    let counting = performance_counters.then_some(khr::performance_query::NAME);
    let mut extensions: Vec<_> =
        order.iter().chain(rendering).chain(feedback).chain(&counting).chain(further).copied().collect();
    extensions.sort();
    extensions.dedup();
    let extensions: Vec<_> = extensions.into_iter().map(|name| name.as_ptr()).collect();
    let mut local_read =
        vk::PhysicalDeviceDynamicRenderingLocalReadFeaturesKHR::default().dynamic_rendering_local_read(true);
    let mut dynamic_rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
    let mut ordered_access = vk::PhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT::default()
        .rasterization_order_color_attachment_access(true);
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .enabled_features(&features);
    let info = if order.is_some() { info.push_next(&mut ordered_access) } else { info };
    let info = match has_local_read {
        true => info.push_next(&mut local_read).push_next(&mut dynamic_rendering),
        false => info,
    };
    let mut merge_feedback =
        vk::PhysicalDeviceSubpassMergeFeedbackFeaturesEXT::default().subpass_merge_feedback(true);
    let info = match caps.subpass_merge_feedback {
        true => info.push_next(&mut merge_feedback),
        false => info,
    };
    let mut counters =
        vk::PhysicalDevicePerformanceQueryFeaturesKHR::default().performance_counter_query_pools(true);
    let info = if performance_counters { info.push_next(&mut counters) } else { info };
    // SAFETY: the family exists, and the features are those that the device has.
    let raw = unsafe { instance.raw.create_device(physical_device, &info, None) }.called("vkCreateDevice")?;
    let host = HostDevice {
        instance: instance.raw.clone(),
        physical_device,
        device: raw.clone(),
        queue_family,
        // SAFETY: the device was created with one queue of this family.
        queue: unsafe { raw.get_device_queue(queue_family, 0) },
        callbacks: None,
        allocator: None,
        features: Features {
            debug_utils: instance.debug_utils,
            pipeline_statistics: caps.pipeline_statistics,
            image_cube_array: caps.image_cube_array,
            occlusion_precise: caps.occlusion_precise,
            ordered_attachment_access: order.is_some(),
            local_read: has_local_read,
            subpass_merge_feedback: caps.subpass_merge_feedback,
            performance_counters,
            sample_rate_shading: caps.sample_rate_shading,
            depth_clamp: caps.depth_clamp,
            sampler_anisotropy: caps.max_sampler_anisotropy > 1.0,
            texture_compression_bc: caps.texture_compression_bc,
            texture_compression_etc2: caps.texture_compression_etc2,
            texture_compression_astc: caps.texture_compression_astc,
        },
    };
    let owned = OwnedDevice { raw, _instance: instance };
    // SAFETY: the handles were made together just above, and `owned` keeps them alive.
    unsafe { Device::new(host, Some(owned)) }
}

fn choose<'a>(candidates: &'a [Candidate], name_part: Option<&str>) -> Result<&'a Candidate> {
    let all: Vec<_> = candidates.iter().map(|c| &c.caps).collect();
    best(&all, name_part).map(|index| &candidates[index])
}

/// The index of the first (best first) device that matches.
fn best(devices: &[&Caps], name_part: Option<&str>) -> Result<usize> {
    let part = name_part.unwrap_or_default().to_lowercase();
    let matches = |c: &&Caps| format!("{} ({})", c.name, c.driver).to_lowercase().contains(&part);
    devices.iter().position(matches).ok_or_else(|| {
        if devices.is_empty() {
            return Error::unsupported("no device of Vulkan 1.1 or later was found", DRIVER_REMEDY);
        }
        let known: Vec<_> = devices.iter().map(|c| format!("{} ({})", c.name, c.driver)).collect();
        Error::unsupported(
            format!("no device's name contains '{part}'"),
            format!("use one of: {}", known.join(", ")),
        )
    })
}

fn offers(entry: &ash::Entry, layer: Option<&CStr>, extension: &CStr) -> Result<bool> {
    // SAFETY: no preconditions.
    let offered = unsafe { entry.enumerate_instance_extension_properties(layer) }
        .called("vkEnumerateInstanceExtensionProperties")?;
    Ok(offered.iter().any(|e| e.extension_name_as_c_str() == Ok(extension)))
}

/// The extensions of the validation layer.
fn layer_extensions(entry: &ash::Entry) -> Result<Vec<CString>> {
    // SAFETY: no preconditions.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }
        .called("vkEnumerateInstanceLayerProperties")?;
    if !layers.iter().any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER)) {
        return Err(Error::unsupported(
            "the Khronos validation layer is not installed",
            "install it (on Debian: apt-get install vulkan-validationlayers) or do without --validate",
        ));
    }
    // SAFETY: no preconditions.
    let offered = unsafe { entry.enumerate_instance_extension_properties(Some(VALIDATION_LAYER)) }
        .called("vkEnumerateInstanceExtensionProperties")?;
    Ok(offered.iter().filter_map(|e| e.extension_name_as_c_str().ok().map(CStr::to_owned)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::DeviceType;

    #[test]
    fn the_name_part_decides() {
        let caps = |name: &str| Caps { name: name.into(), driver: "Mesa".into(), ..Default::default() };
        let (fast, slow) = (caps("Fast GPU"), caps("llvmpipe"));
        let all = [&fast, &slow];
        assert_eq!(best(&all, None).unwrap(), 0);
        assert_eq!(best(&all, Some("LLVM")).unwrap(), 1);
        assert_eq!(best(&all, Some("mesa")).unwrap(), 0);
        let error = best(&all, Some("nothing")).unwrap_err().to_string();
        assert!(error.contains("Fast GPU (Mesa), llvmpipe (Mesa)"), "{error}");
        let error = best(&[], None).unwrap_err().to_string();
        assert!(error.contains("mesa-vulkan-drivers"), "{error}");
    }

    #[test]
    fn faster_kinds_come_first() {
        use DeviceType::*;
        let mut kinds = [Cpu, Other, Integrated, Discrete, Virtual];
        kinds.sort();
        assert_eq!(kinds, [Discrete, Integrated, Virtual, Cpu, Other]);
    }
}

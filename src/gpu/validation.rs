//! Collects what the validation layer says.

use ash::vk;
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use crate::plan::{Edges, Load, Pass, PassAttachment, Path, Plan, Store};

/// Messages of one instance, in order; shared, so that they outlive it.
#[derive(Clone, Debug, Default)]
pub(super) struct Messages(Arc<Mutex<Vec<String>>>);

impl Messages {
    pub(super) fn push(&self, message: String) {
        log::warn!("{message}");
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }

    pub(super) fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// A description of the messenger, for an instance's or a messenger's creation.
    ///
    /// Its owner keeps `self` at this address until what is created with it is gone.
    pub(super) fn messenger_info(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
        let user_data: *const Self = self;
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            // GENERAL would be the loader's remarks about drivers that it skips.
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                    | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
            )
            .pfn_user_callback(Some(collect))
            .user_data(user_data.cast_mut().cast())
    }
}

unsafe extern "system" fn collect(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `messenger_info` passed a `Messages` that its owner keeps until the instance is gone.
    let messages = unsafe { &*user_data.cast_const().cast::<Messages>() };
    // SAFETY: the layer passes valid data for the duration of the call.
    let data = unsafe { &*data };
    let text = |s: *const std::ffi::c_char| match s.is_null() {
        true => String::new(),
        // SAFETY: a non-null text of the layer is NUL-terminated and valid during the call.
        false => unsafe { CStr::from_ptr(s) }.to_string_lossy().into_owned(),
    };
    let (id, message) = (text(data.p_message_id_name), text(data.p_message));
    if is_about_ourselves(&id, &message) || is_mistaken(&id) || is_about_the_scene(&id) {
        return vk::FALSE;
    }
    messages.push(format!("{severity:?} {types:?} {id}: {message}"));
    vk::FALSE
}

/// Best practices advise against the very extensions that validating and counting take.
fn is_about_ourselves(id: &str, message: &str) -> bool {
    let ours = [
        "VK_EXT_debug_utils",
        "VK_EXT_validation_features",
        "VK_EXT_layer_settings",
        "VK_KHR_performance_query",
    ];
    id.contains("specialuse-extension") && ours.iter().any(|extension| message.contains(extension))
}

/// The layer of 1.4.309 does not see that features were asked for by vkGetPhysicalDeviceFeatures2.
fn is_mistaken(id: &str) -> bool {
    id.ends_with("vkCreateDevice-physical-device-features-not-retrieved")
}

/// Arm's advice against wrapping u and v differently. Scenes ask for it and must get it: the advice itself says that it is
/// to be disregarded then.
fn is_about_the_scene(id: &str) -> bool {
    id.ends_with("vkCreateSampler-different-wrapping-modes")
}

/// What best practices say of a plan that means just that, by a part of each message.
pub fn expected_advice(plan: &Plan) -> Vec<&'static str> {
    let attachments = || plan.passes.iter().flat_map(|pass| &pass.attachments);
    let clears = |a: &PassAttachment| [a.load, a.stencil.0].map(|load| load == Load::Clear);
    let clears_only_stencil = |pass: &Pass| {
        pass.attachments.iter().any(|a| clears(a)[1]) && !pass.attachments.iter().any(|a| clears(a)[0])
    };
    let several = |a: &PassAttachment| plan.attachments[a.attachment].samples > 1;
    let told = [
        // Arm and IMG advise against loads, which are all that `separate` is there for.
        (attachments().any(|a| a.load == Load::Load), "attachment-needs-readback"),
        // The same for several samples a pixel, for which Arm advises against all memory.
        (attachments().any(|a| several(a) && a.store == Store::Store), "image-requires-memory"),
        (attachments().any(|a| several(a) && a.store == Store::Store), "non-transient-ms-image"),
        // Mali takes longer to blend several samples of wide formats; the plan says so.
        (plan.blends_samples_of_floats(), "multisampled-blending"),
        // Likewise of more than 4 samples.
        (plan.options.samples > 4, "too-large-sample-count"),
        // Separate passes load depth with the stencil that says what edges are, and may need it no more.
        (plan.passes.len() > 1 && plan.edges != Edges::All, "redundant-attachment-on-tile"),
        // The host's image takes in what an earlier pass needs; no memory would be saved without.
        (attachments().any(|a| a.attachment == 0 && a.store == Store::DontCare), "should-be-transient"),
        // What a stage clears because another used the attachment before could be cleared with its pass, were it alone in one.
        (plan.passes.iter().any(|pass| !pass.subpasses[0].clears.is_empty()), "ClearCmdBeforeDraw"),
        // The same, of what an earlier pass stored.
        (plan.passes.iter().any(|pass| !pass.subpasses[0].clears.is_empty()), "clear-after-load"),
        // A draw for each light and small object is the way of multi-pass shading, and one for each tile and small caster
        // that of shadow maps. (What can be drawn at once is.)
        (plan.path == Path::ForwardMultipass || plan.shadow_map.is_some(), "many-small-indexed-drawcalls"),
        // Said mistakenly of a pass that clears no attachment but a stencil.
        (plan.passes.iter().any(clears_only_stencil), "ClearValueWithoutLoadOpClear"),
        // Textures ask for it.
        (plan.needs.anisotropy > 1, "vkCreateSampler-anisotropy"),
        // The layer looks for indices at the begin of mapped memory, of which an overlay's buffer is some part.
        (plan.options.overlay, "sparse-index-buffer"),
        // A pass that only clears is all that a scene of nothing needs.
        (plan.pipelines.is_empty(), "redundant-attachment-on-tile"),
    ];
    told.into_iter().filter_map(|(is_meant, message)| is_meant.then_some(message)).collect()
}

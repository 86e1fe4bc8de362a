//! What the host may choose about frames.

use std::ffi::c_char;

use super::call::{OntileResult, call, destroy, get_mut, give, text};
use crate::plan::Options;

/// Choices about frames, by name.
pub struct OntileOptions {
    pub(super) options: Options,
}

/// Makes options that leave everything as it is by default.
///
/// # Safety
/// `options` is a valid pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_options_create(options: *mut *mut OntileOptions) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe { give(options, "options", || Ok(OntileOptions { options: Options::default() })) }
    })
}

/// Sets an option by its name on the command line of the program `ontile`, e.g. "layout" to "packed128", "samples" to "4", "size" to
/// "1280x720". Of the host's images it wants to know "output" ("rgba8_srgb", "bgra8_srgb", "rgba16_float", "rgba32_float"), "output-use"
/// ("copy", "present", "sample", "draw") and "output-is-input-attachment" (whether they have that usage). What is on or off takes "true" or
/// "false"; what may be left open takes "auto". The message of an error lists the names, or the values, that there are. Whether values
/// go together, and with the device, is told by ontile_renderer_create.
///
/// # Safety
/// All pointers are valid; the texts end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_options_set(
    options: *mut OntileOptions,
    name: *const c_char,
    value: *const c_char,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (options, name, value) =
            unsafe { (get_mut(options, "options")?, text(name, "name")?, text(value, "value")?) };
        Ok(options.options.set(name, value)?)
    })
}

/// Destroys options; null is none.
///
/// # Safety
/// `options` came from ontile_options_create and was not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_options_destroy(options: *mut OntileOptions) {
    // SAFETY: the caller's promise.
    unsafe { destroy(options) }
}

//! What frames took.

use super::call::{OntileResult, call, get, put};
use super::frame::{OntileRenderer, check_slot};

/// Nanoseconds of the GPU from the begin to the end of the frame that was recorded with this slot and has finished; 0 where the device tells no
/// times, the frame had no queries (ontile_renderer_set_queries), or it has not finished.
///
/// # Safety
/// All pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_frame_time(
    renderer: *const OntileRenderer,
    slot: u32,
    nanoseconds: *mut f64,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let renderer = &unsafe { get(renderer, "renderer") }?.renderer;
        check_slot(renderer, slot)?;
        let times = renderer.query_results(slot as usize)?.timestamps_ns;
        let end = times.and_then(|times| times.last().copied()).unwrap_or_default();
        // SAFETY: the caller's promise.
        unsafe { put(nanoseconds, "nanoseconds", end) }
    })
}

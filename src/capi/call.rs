//! What every function of the interface has in common.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::Error;

/// Rises with every change that programs compiled against an older header would notice.
pub const ONTILE_ABI_VERSION: u32 = 1;

/// What came of a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OntileResult {
    /// It was done.
    Ok = 0,
    /// An argument is null, or no text, or not of the values that its type names.
    ErrorArgument = 1,
    /// A file's content cannot be used.
    ErrorInput = 2,
    /// A file cannot be read or written.
    ErrorIo = 3,
    /// The plan, the device or the world cannot do what was asked for; the message says what would do.
    ErrorUnsupported = 4,
    /// A Vulkan call failed: ontile_last_vulkan_result says how.
    ErrorVulkan = 5,
    /// A defect of ontile. The objects that the call was given must only be destroyed.
    ErrorInternal = 6,
}

/// Why a call failed.
pub(super) enum Failure {
    Argument(String),
    Error(Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

pub(super) type Outcome<T = ()> = Result<T, Failure>;

#[derive(Default)]
struct Last {
    message: CString,
    vulkan: i32,
}

thread_local! {
    static LAST: RefCell<Last> = RefCell::default();
}

fn remember(message: &str, vulkan: i32) {
    let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
    LAST.with(|last| *last.borrow_mut() = Last { message, vulkan });
}

/// Runs the body of a function of the interface.
pub(super) fn call(body: impl FnOnce() -> Outcome) -> OntileResult {
    match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => OntileResult::Ok,
        Ok(Err(Failure::Argument(message))) => {
            remember(&message, 0);
            OntileResult::ErrorArgument
        }
        Ok(Err(Failure::Error(error))) => {
            let vulkan = if let Error::Vulkan { result, .. } = &error { result.as_raw() } else { 0 };
            remember(&error.to_string(), vulkan);
            match error {
                Error::Input { .. } => OntileResult::ErrorInput,
                Error::Io { .. } => OntileResult::ErrorIo,
                Error::Unsupported { .. } => OntileResult::ErrorUnsupported,
                Error::Vulkan { .. } => OntileResult::ErrorVulkan,
            }
        }
        Err(panic) => {
            remember(&format!("defect of ontile: {}", told(&*panic)), 0);
            OntileResult::ErrorInternal
        }
    }
}

fn told(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// Destroys an object; null is none.
///
/// # Safety
/// `object` is null or came from [`give`] and was not destroyed.
pub(super) unsafe fn destroy<T>(object: *mut T) {
    if !object.is_null() {
        // SAFETY: the caller's promise.
        let object = unsafe { Box::from_raw(object) };
        // What a panic would leave is lost, and that is all that can be done.
        let _ = catch_unwind(AssertUnwindSafe(|| drop(object)));
    }
}

/// Hands an object out.
///
/// # Safety
/// `out` is null or can be written.
pub(super) unsafe fn give<T>(out: *mut *mut T, name: &str, make: impl FnOnce() -> Outcome<T>) -> Outcome {
    if out.is_null() {
        return Err(Failure::Argument(format!("{name} is null")));
    }
    let object = Box::into_raw(Box::new(make()?));
    // SAFETY: not null; the caller's promise.
    unsafe { out.write(object) };
    Ok(())
}

/// Writes a result.
///
/// # Safety
/// As [`give`].
pub(super) unsafe fn put<T>(out: *mut T, name: &str, value: T) -> Outcome {
    if out.is_null() {
        return Err(Failure::Argument(format!("{name} is null")));
    }
    // SAFETY: not null; the caller's promise.
    unsafe { out.write(value) };
    Ok(())
}

/// What a pointer points to.
///
/// # Safety
/// `pointer` is null or points to a `T` that nobody changes during `'a`.
pub(super) unsafe fn get<'a, T>(pointer: *const T, name: &str) -> Outcome<&'a T> {
    // SAFETY: the caller's promise.
    unsafe { pointer.as_ref() }.ok_or_else(|| Failure::Argument(format!("{name} is null")))
}

/// The same, to change it.
///
/// # Safety
/// `pointer` is null or points to a `T` that nobody else uses during `'a`.
pub(super) unsafe fn get_mut<'a, T>(pointer: *mut T, name: &str) -> Outcome<&'a mut T> {
    // SAFETY: the caller's promise.
    unsafe { pointer.as_mut() }.ok_or_else(|| Failure::Argument(format!("{name} is null")))
}

/// A list; empty if it has no elements, wherever it begins.
///
/// # Safety
/// `first` is null or points to `count` elements that nobody changes during `'a`.
pub(super) unsafe fn list<'a, T>(first: *const T, count: usize, name: &str) -> Outcome<&'a [T]> {
    match (count, first.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(Failure::Argument(format!("{name} is null, but not empty"))),
        // SAFETY: the caller's promise.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts(first, count) }),
    }
}

/// A list that may be left out.
///
/// # Safety
/// As [`list`].
pub(super) unsafe fn optional<'a, T>(first: *const T, count: usize) -> &'a [T] {
    match first.is_null() || count == 0 {
        true => &[],
        // SAFETY: the caller's promise.
        false => unsafe { std::slice::from_raw_parts(first, count) },
    }
}

/// A text; null is empty.
///
/// # Safety
/// `text` is null or ends with a zero, and nobody changes it during `'a`.
pub(super) unsafe fn text<'a>(text: *const c_char, name: &str) -> Outcome<&'a str> {
    if text.is_null() {
        return Ok("");
    }
    // SAFETY: not null; the caller's promise.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| Failure::Argument(format!("{name} is not UTF-8")))
}

/// Copies bytes to a host's buffer as Vulkan does: without one it says how many there are, else it writes as many as fit and
/// says how many that are.
///
/// # Safety
/// `count` is null or points to a number; `out` is null or can hold as many bytes as it says.
pub(super) unsafe fn copy_out(bytes: &[u8], count: *mut usize, out: *mut u8) -> Outcome {
    // SAFETY: the caller's promise.
    let count = unsafe { get_mut(count, "count") }?;
    if out.is_null() {
        *count = bytes.len();
        return Ok(());
    }
    *count = bytes.len().min(*count);
    // SAFETY: the caller's promise; the two do not overlap, since ours was made just now.
    unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), out, *count) };
    Ok(())
}

/// The ABI version of the library: a program compares it with ONTILE_ABI_VERSION of the header that it was compiled with.
#[unsafe(no_mangle)]
pub extern "C" fn ontile_abi_version() -> u32 {
    ONTILE_ABI_VERSION
}

/// Why the last call of this thread that failed did so, with what and where, and a remedy. It is valid until the next call that fails;
/// before the first one it is empty.
#[unsafe(no_mangle)]
pub extern "C" fn ontile_last_error() -> *const c_char {
    LAST.with(|last| last.borrow().message.as_ptr())
}

/// The VkResult of the last call that failed, if that was ONTILE_RESULT_ERROR_VULKAN; else 0.
#[unsafe(no_mangle)]
pub extern "C" fn ontile_last_vulkan_result() -> i32 {
    LAST.with(|last| last.borrow().vulkan)
}

//! How stages become passes: what was asked for, and what comes of it on a device.

use serde::Serialize;

use super::{Limits, Options, Strategy};
use crate::{Error, Result};

/// What a driver makes of the strategies, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Merging {
    /// Whether one rendering with local reads works, or why it does not.
    pub local_read: std::result::Result<(), &'static str>,
    /// What keeps a frame on the chip: what [`Strategy::Auto`] comes to.
    pub best: Strategy,
    /// Why.
    pub why: &'static str,
}

impl Default for Merging {
    /// Of any Vulkan 1.1 device.
    fn default() -> Self {
        Self {
            local_read: Err("the device has no VK_KHR_dynamic_rendering_local_read"),
            best: Strategy::Subpasses,
            why: "every device runs subpasses",
        }
    }
}

/// The strategies to try, the best first, none of them [`Strategy::Auto`]; and why, where that was not asked for.
///
/// # Errors
/// [`Error::Unsupported`] if the device does not run what was asked for.
pub(super) fn resolve(options: &Options, limits: &Limits) -> Result<(Strategy, Option<String>)> {
    let Merging { local_read, best, why } = limits.merging;
    match (options.strategy, local_read) {
        (Strategy::Auto, Ok(())) => Ok((best, Some(format!("strategy: {best}, since {why}")))),
        (Strategy::Auto, Err(_)) => {
            Ok((Strategy::Subpasses, Some(format!("strategy: subpasses, since {why}"))))
        }
        (Strategy::LocalRead, Err(reason)) => Err(Error::unsupported(
            format!("strategy local-read: {reason}"),
            "use --strategy subpasses, which has the same picture and loads and stores as little",
        )),
        (asked, _) => Ok((asked, None)),
    }
}

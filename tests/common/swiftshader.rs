//! A second software rasteriser, to compare lavapipe with.

use super::ignored;
use std::path::PathBuf;

/// The environment that makes the Vulkan loader see SwiftShader only; says "ignored" and returns `None` if absent.
///
/// From `ONTILE_SWIFTSHADER_ICD` (its ICD manifest), or where `tools/swiftshader` unpacks it.
pub fn swiftshader_env() -> Option<[(&'static str, PathBuf); 2]> {
    let named = std::env::var_os("ONTILE_SWIFTSHADER_ICD").filter(|path| !path.is_empty()).map(PathBuf::from);
    let manifest = named.unwrap_or_else(|| super::target_dir().join("swiftshader/vk_swiftshader_icd.json"));
    if manifest.is_file() {
        // The second name is the one that loaders before 1.3.207 know.
        return Some([("VK_DRIVER_FILES", manifest.clone()), ("VK_ICD_FILENAMES", manifest)]);
    }
    ignored(&format!("SwiftShader: {} absent (tools/swiftshader unpacks it)", manifest.display()));
    None
}

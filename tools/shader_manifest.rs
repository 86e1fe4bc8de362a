//! `glsl/spirv/manifest.json`: what every module was compiled from, so that stale modules are seen without a compiler.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

/// The manifest; paths are relative to `glsl/`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// SHA-256 of every source that some module includes.
    pub sources: BTreeMap<String, String>,
    /// By module name.
    pub modules: BTreeMap<String, ModuleRecord>,
}

/// One module's origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModuleRecord {
    /// The entry point's file first, then every file that it includes, directly or not, in order of name.
    pub sources: Vec<String>,
    /// SHA-256 of the SPIR-V file.
    pub spirv_sha256: String,
}

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

//! Compiles every module of [`Module::ALL`] from `glsl/` into `glsl/spirv/`.
//!
//! `compile_shaders` writes; `compile_shaders --check` compiles to memory and compares byte for byte.

#[path = "shader_manifest.rs"]
mod shader_manifest;

use ontile::gpu::shader::{Compiled, Module, compile};
use shader_manifest::{Manifest, ModuleRecord, sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

type Files = BTreeMap<String, Vec<u8>>;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let glsl = Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl");
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => compile_all(&glsl).and_then(|files| write(&glsl.join("spirv"), &files)),
        ["--check"] => compile_all(&glsl).and_then(|files| check(&glsl.join("spirv"), &files)),
        _ => {
            eprintln!("usage: compile_shaders [--check]");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Everything that belongs into `glsl/spirv/`, by file name.
fn compile_all(glsl: &Path) -> Result<Files, Box<dyn Error>> {
    let mut files = Files::new();
    let mut manifest = Manifest { sources: BTreeMap::new(), modules: BTreeMap::new() };
    for module in Module::ALL {
        let Compiled { spirv, sources } = compile(glsl, module)?;
        let spirv: Vec<u8> = spirv.iter().flat_map(|word| word.to_le_bytes()).collect();
        for source in &sources {
            manifest.sources.insert(source.clone(), sha256(&std::fs::read(glsl.join(source))?));
        }
        let record = ModuleRecord { sources, spirv_sha256: sha256(&spirv) };
        manifest.modules.insert(module.name().to_owned(), record);
        files.insert(format!("{}.spv", module.name()), spirv);
    }
    let names: String = manifest.modules.keys().map(|name| format!("    \"{name}\",\n")).collect();
    files.insert("modules.rs".into(), format!("// Written by tools/shaders.\nembed![\n{names}]\n").into());
    files.insert("manifest.json".into(), (serde_json::to_string_pretty(&manifest)? + "\n").into());
    Ok(files)
}

/// Replaces what differs and removes what does not belong, the list of modules last: it names files that exist.
fn write(directory: &Path, files: &Files) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(directory)?;
    let (lists, modules): (Vec<_>, Vec<_>) = differences(directory, files)?
        .into_iter()
        .filter(|name| files.contains_key(name))
        .partition(|name| name == "modules.rs");
    for name in modules.iter().chain(&lists) {
        let temporary = directory.join(format!("{name}.tmp"));
        std::fs::write(&temporary, &files[name])?;
        std::fs::rename(&temporary, directory.join(name))?;
        println!("wrote {name}");
    }
    for name in differences(directory, files)? {
        std::fs::remove_file(directory.join(&name))?;
        println!("removed {name}");
    }
    let bytes: usize = files.iter().filter(|(name, _)| name.ends_with(".spv")).map(|(_, f)| f.len()).sum();
    println!("{} modules, {bytes} bytes of SPIR-V", files.len() - 2);
    Ok(())
}

fn check(directory: &Path, files: &Files) -> Result<(), Box<dyn Error>> {
    let stale = differences(directory, files)?;
    if stale.is_empty() {
        println!("{} modules are what glsl/ compiles to", files.len() - 2);
        return Ok(());
    }
    Err(format!("glsl/spirv is stale; run ./tools/shaders:\n  {}", stale.join("\n  ")).into())
}

/// The names of files that are missing, differ or do not belong.
fn differences(directory: &Path, files: &Files) -> Result<Vec<String>, Box<dyn Error>> {
    let mut present = Files::new();
    for entry in std::fs::read_dir(directory)? {
        let entry = entry?;
        present.insert(entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path())?);
    }
    let names: BTreeSet<_> = files.keys().chain(present.keys()).cloned().collect();
    Ok(names.into_iter().filter(|name| files.get(name) != present.get(name)).collect())
}

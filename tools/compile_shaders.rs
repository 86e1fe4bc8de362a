//! Compiles every module of [`Module::ALL`] from `glsl/` into `glsl/spirv/`.
//!
//! `compile_shaders` writes; `compile_shaders --check` compiles to memory and compares byte for byte.

#[path = "shader_manifest.rs"]
mod shader_manifest;

use ontile::gpu::shader::{Module, Stage};
use shader_manifest::{Manifest, ModuleRecord, sha256};
use std::cell::RefCell;
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
    let compiler = shaderc::Compiler::new()?;
    let mut files = Files::new();
    let mut manifest = Manifest { sources: BTreeMap::new(), modules: BTreeMap::new() };
    for module in Module::ALL {
        let (spirv, sources) = compile(&compiler, glsl, module)?;
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

/// The SPIR-V, and the sources that it was compiled from.
fn compile(
    compiler: &shaderc::Compiler,
    glsl: &Path,
    module: Module,
) -> Result<(Vec<u8>, Vec<String>), Box<dyn Error>> {
    let included = RefCell::new(BTreeSet::new());
    let mut options = shaderc::CompileOptions::new()?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_1 as u32);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    for define in module.defines() {
        options.add_macro_definition(define, None);
    }
    // Targets are numbered by what they hold; the places that a pipeline gives them are within every device's limit.
    options.set_limit(shaderc::Limit::MaxDrawBuffers, 32);
    // Keeps names, by which tests match members; `without_source` removes the rest of what this adds.
    options.set_generate_debug_info();
    options.set_include_callback(|name, _, from, _| {
        let content = std::fs::read_to_string(glsl.join(name))
            .map_err(|error| format!("{from} includes glsl/{name}: {error}"))?;
        included.borrow_mut().insert(name.to_owned());
        Ok(shaderc::ResolvedInclude { resolved_name: name.to_owned(), content })
    });
    let kind = match module.stage() {
        Stage::Vertex => shaderc::ShaderKind::Vertex,
        Stage::Fragment => shaderc::ShaderKind::Fragment,
        Stage::Compute => shaderc::ShaderKind::Compute,
    };
    let text = std::fs::read_to_string(glsl.join(module.source()))?;
    let artifact = compiler
        .compile_into_spirv(&text, kind, module.source(), "main", Some(&options))
        .map_err(|error| format!("{}: {error}", module.name()))?;
    let spirv = without_source(artifact.as_binary()).iter().flat_map(|word| word.to_le_bytes()).collect();
    drop(options);
    let sources = std::iter::once(module.source().to_owned()).chain(included.into_inner()).collect();
    Ok((spirv, sources))
}

/// The module without source text and line numbers (SPIR-V specification, 3.49.2 Debug Instructions).
fn without_source(spirv: &[u32]) -> Vec<u32> {
    const SOURCE_CONTINUED: u32 = 2;
    const SOURCE: u32 = 3;
    const SOURCE_EXTENSION: u32 = 4;
    const STRING: u32 = 7;
    const LINE: u32 = 8;
    const NO_LINE: u32 = 317;
    const MODULE_PROCESSED: u32 = 330;
    const HEADER_WORDS: usize = 5;

    let (header, mut rest) = spirv.split_at(HEADER_WORDS);
    let mut kept = header.to_vec();
    while let Some(&first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        match first & 0xffff {
            SOURCE_CONTINUED | SOURCE | SOURCE_EXTENSION | STRING | LINE | NO_LINE | MODULE_PROCESSED => {}
            _ => kept.extend_from_slice(instruction),
        }
        rest = after;
    }
    kept
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

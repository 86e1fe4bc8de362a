//! GLSL to SPIR-V, by shaderc.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;

use super::{Module, Stage};

/// What a module was compiled to, and from.
pub struct Compiled {
    /// SPIR-V.
    pub spirv: Vec<u32>,
    /// The entry point's file first, then every file that it includes, directly or not, in order of name; relative to the folder.
    pub sources: Vec<String>,
}

/// Compiles a module from the GLSL of a folder.
///
/// # Errors
/// What the compiler says, with file and line.
pub fn compile(glsl: &Path, module: Module) -> Result<Compiled, String> {
    let compiler = shaderc::Compiler::new().map_err(|e| e.to_string())?;
    let included = RefCell::new(BTreeSet::new());
    let mut options = shaderc::CompileOptions::new().map_err(|e| e.to_string())?;
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
            .map_err(|error| format!("{from} includes {}: {error}", glsl.join(name).display()))?;
        included.borrow_mut().insert(name.to_owned());
        Ok(shaderc::ResolvedInclude { resolved_name: name.to_owned(), content })
    });
    let kind = match module.stage() {
        Stage::Vertex => shaderc::ShaderKind::Vertex,
        Stage::Fragment => shaderc::ShaderKind::Fragment,
        Stage::Compute => shaderc::ShaderKind::Compute,
    };
    let path = glsl.join(module.source());
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let artifact = compiler
        .compile_into_spirv(&text, kind, module.source(), "main", Some(&options))
        .map_err(|error| format!("{}: {error}", module.name()))?;
    let spirv = without_source(artifact.as_binary());
    drop(options);
    let sources = std::iter::once(module.source().to_owned()).chain(included.into_inner()).collect();
    Ok(Compiled { spirv, sources })
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

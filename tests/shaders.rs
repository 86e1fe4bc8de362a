//! GLSL, the compiled SPIR-V and Rust agree.
//!
//! Each check returns the problems it finds, so that a tampered input shows that it can find any.

#[path = "shaders/blocks.rs"]
mod blocks;
mod common;
#[path = "shaders/pipelines.rs"]
mod pipelines;
#[path = "shaders/reflect.rs"]
mod reflect;
#[path = "../tools/shader_manifest.rs"]
mod shader_manifest;

use blocks::blocks;
use ontile::gpu::shader::{
    DecalConstants, GBufferConstants, GeometryConstants, KIND_COUNT, LightingConstants, Module,
    OutputConstants, SampleConstants, Specialization, embedded_names, prune, shared,
};
use ontile::plan::{BloomWay, Brdf, GBuffer, ResolveWay, Show, Tonemap, Translucency};
use reflect::Reflection;
use rspirv::dr::Operand;
use rspirv::spirv::{Decoration, Op};
use shader_manifest::{Manifest, sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

fn glsl() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("glsl")
}

fn reflections() -> Vec<(Module, Reflection)> {
    Module::ALL.into_iter().map(|m| (m, Reflection::new(m.spirv().unwrap()))).collect()
}

/// `#define NAME NUMBER` lines, read without the crate's own parser.
fn shared_numbers() -> BTreeMap<String, u32> {
    let text = std::fs::read_to_string(glsl().join("shared.h")).unwrap();
    let mut numbers = BTreeMap::new();
    for line in text.lines().filter(|line| line.starts_with("#define")) {
        let [_, name, number] = line.split_whitespace().collect::<Vec<_>>()[..] else {
            panic!("shared.h: not `#define NAME NUMBER`: {line}")
        };
        assert_eq!(numbers.insert(name.into(), number.parse().unwrap()), None, "{name} twice");
    }
    numbers
}

// What a stale or foreign file in glsl/spirv looks like to someone without a compiler.
fn manifest_problems(
    manifest: &Manifest,
    modules: &[Module],
    read: &dyn Fn(&str) -> Option<Vec<u8>>,
) -> Vec<String> {
    let mut problems = Vec::new();
    for (source, hash) in &manifest.sources {
        if read(source).is_none_or(|bytes| sha256(&bytes) != *hash) {
            problems.push(format!("{source} changed: run ./tools/shaders"));
        }
    }
    let expected: BTreeSet<_> = modules.iter().map(|m| m.name().to_owned()).collect();
    let compiled: BTreeSet<_> = manifest.modules.keys().cloned().collect();
    problems
        .extend(expected.symmetric_difference(&compiled).map(|name| format!("{name}: not in both lists")));
    for module in modules {
        let name = module.name();
        let Some(record) = manifest.modules.get(name) else { continue };
        if record.sources[0] != module.source() {
            problems.push(format!("{name}: compiled from something else"));
        }
        if record.sources.iter().any(|source| !manifest.sources.contains_key(source)) {
            problems.push(format!("{name}: a source has no hash"));
        }
        if read(&format!("spirv/{name}.spv")).is_none_or(|bytes| sha256(&bytes) != record.spirv_sha256) {
            problems.push(format!("{name}: not what was compiled"));
        }
    }
    problems
}

fn manifest() -> Manifest {
    serde_json::from_slice(&std::fs::read(glsl().join("spirv/manifest.json")).unwrap()).unwrap()
}

fn read(path: &str) -> Option<Vec<u8>> {
    std::fs::read(glsl().join(path)).ok()
}

#[test]
fn modules_are_fresh() {
    assert_eq!(manifest_problems(&manifest(), &Module::ALL, &read), Vec::<String>::new());
    let embedded: BTreeSet<_> = embedded_names().map(String::from).collect();
    assert_eq!(embedded, Module::ALL.iter().map(|m| m.name().to_owned()).collect());
    for module in Module::ALL {
        let file = read(&format!("spirv/{}.spv", module.name())).unwrap();
        let words: Vec<_> = file.chunks_exact(4).map(|w| u32::from_le_bytes(w.try_into().unwrap())).collect();
        assert_eq!(module.spirv().unwrap(), words, "{}", module.name());
    }
    let spv_files = std::fs::read_dir(glsl().join("spirv"))
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().path().extension().is_some_and(|e| e == "spv"))
        .count();
    assert_eq!(spv_files, Module::ALL.len());
}

#[test]
fn stale_modules_are_reported() {
    let (fresh, all) = (manifest(), Module::ALL);
    let edited = |path: &str| {
        let mut bytes = read(path)?;
        if path == "brdf.glsl" || path == "spirv/tonemap.frag.spv" {
            *bytes.last_mut().unwrap() ^= 1;
        }
        Some(bytes)
    };
    let problems = manifest_problems(&fresh, &all, &edited);
    assert_eq!(problems.len(), 2, "{problems:?}");

    assert_eq!(manifest_problems(&fresh, &all[1..], &read).len(), 1, "a module too many");
    let mut fewer = fresh.clone();
    fewer.modules.pop_first();
    assert_eq!(manifest_problems(&fewer, &all, &read).len(), 1, "a module too few");
    let mut other = fresh.clone();
    other.modules.get_mut("lighting.frag").unwrap().sources[0] = "tonemap.frag".into();
    assert_eq!(manifest_problems(&other, &all, &read).len(), 1, "another source");
    let no_file = |path: &str| if path == "tonemap.glsl" { None } else { read(path) };
    assert_eq!(manifest_problems(&fresh, &all, &no_file).len(), 1, "a source too few");
}

#[test]
fn names_are_unique() {
    let all = Module::ALL;
    assert_eq!(all.iter().map(|m| m.name()).collect::<BTreeSet<_>>().len(), all.len());
}

#[test]
fn shared_structs_have_the_shaders_offsets() {
    let blocks = blocks();
    let mut seen = BTreeSet::new();
    for (module, reflection) in reflections() {
        for block in &blocks {
            if let Some(problems) = reflection.block_problems(block) {
                assert_eq!(problems, Vec::<String>::new(), "{}", module.name());
                seen.insert(block.name);
            }
        }
    }
    assert_eq!(seen.len(), blocks.len(), "each block is in some module: {seen:?}");
}

#[test]
fn wrong_offsets_are_reported() {
    let frag = Module::Lighting.spirv().unwrap();
    let light = &blocks()[3];

    // Rust's side: two members change places, one is forgotten.
    let mut swapped = light.clone();
    let (a, b) = (swapped.members[1].offset, swapped.members[3].offset);
    (swapped.members[1].offset, swapped.members[3].offset) = (b, a);
    assert_eq!(Reflection::new(frag).block_problems(&swapped).unwrap().len(), 2);
    let mut fewer = light.clone();
    fewer.members.pop();
    assert!(!Reflection::new(frag).block_problems(&fewer).unwrap().is_empty());

    // SPIR-V's side: another member offset, another array stride.
    for (op, decoration) in
        [(Op::MemberDecorate, Decoration::Offset), (Op::Decorate, Decoration::ArrayStride)]
    {
        let mut tampered = Reflection::new(frag);
        let mut changed = 0;
        for instruction in &mut tampered.module.annotations {
            if instruction.class.opcode == op
                && instruction.operands.contains(&Operand::Decoration(decoration))
            {
                let Some(Operand::LiteralBit32(number)) = instruction.operands.last_mut() else { panic!() };
                *number += 4;
                changed += 1;
            }
        }
        assert!(changed > 0);
        assert!(!tampered.block_problems(light).unwrap().is_empty(), "{decoration:?}");
    }
}

#[test]
fn interfaces_have_the_numbers_of_shared_h() {
    let numbers = shared_numbers();
    let mut used = BTreeSet::new();
    for (module, reflection) in reflections() {
        let (names, problems) = reflection.interface_problems(&numbers);
        assert_eq!(problems, Vec::<String>::new(), "{}", module.name());
        used.extend(names);
    }
    let interface = ["SET_", "BINDING_", "INPUT_", "ATTRIBUTE_", "VARYING_", "TARGET_", "ID_"];
    let unused: Vec<_> = numbers
        .keys()
        .filter(|name| interface.iter().any(|prefix| name.starts_with(prefix)) && !used.contains(*name))
        // What stages read in its place has its number.
        .filter(|name| !(name.starts_with("INPUT_") && numbers[*name] == numbers["INPUT_PEEL_A"]))
        // What is drawn in place of the light, or of the output, is known by its number.
        .filter(|name| {
            let replaced = name.replace("REFRACTED_", "").replace("TARGET_PICTURE", "TARGET_OUTPUT");
            replaced == **name || numbers.get(&replaced) != numbers.get(*name)
        })
        .collect();
    assert!(unused.is_empty(), "no module has {unused:?}");
    for (name, number) in &numbers {
        assert_eq!(shared(name), *number, "{name}");
    }
}

#[test]
fn wrong_interfaces_are_reported() {
    let numbers = shared_numbers();
    let vertex = Module::GeometryVertex;
    let lighting = Module::Lighting;
    for (module, decoration) in [
        (vertex, Decoration::Location),
        (vertex, Decoration::DescriptorSet),
        (lighting, Decoration::Binding),
        (lighting, Decoration::InputAttachmentIndex),
        (lighting, Decoration::SpecId),
    ] {
        let mut tampered = Reflection::new(module.spirv().unwrap());
        let instruction = tampered
            .module
            .annotations
            .iter_mut()
            .find(|i| i.operands.contains(&Operand::Decoration(decoration)))
            .unwrap();
        *instruction.operands.last_mut().unwrap() = Operand::LiteralBit32(77);
        assert_eq!(tampered.interface_problems(&numbers).1.len(), 1, "{decoration:?}");
    }
}

/// Without the curve, which other builders have too.
fn every_constant_of_bloom() -> Specialization {
    let mut bloom = Specialization::bloom(0, None);
    let curve = bloom.ids.iter().position(|id| *id == shared("ID_TONEMAP")).expect("it may undo one");
    bloom.ids.remove(curve);
    bloom.data.remove(curve);
    bloom
}

/// A value for every constant that the typed builders know.
fn every_constant() -> Specialization {
    let output = OutputConstants {
        tonemap: Tonemap::Neutral,
        dither: false,
        float: false,
        background: None,
        fog: None,
        translucency: false,
        bloom: BloomWay::Off,
    };
    let samples = SampleConstants {
        samples: 4,
        per_sample: true,
        edge_target: true,
        edge_masks: true,
        sample_depth: true,
        resolve: ResolveWay::Plain,
    };
    let surface = GeometryConstants::default().specialization();
    surface
        .and(LightingConstants::default().specialization())
        .and(output.specialization())
        .and(samples.specialization())
        .and(GBufferConstants::new(&GBuffer::exact()).specialization())
        .and(Specialization::brdf(Brdf::Exact))
        .and(Specialization::volume(0))
        .and(DecalConstants::default().specialization())
        .and(every_constant_of_bloom())
        .and(Specialization::edge_filter(0.0))
        .and(Specialization::translucency(Translucency::Oit, 4, true))
        .and(Specialization::behind(Some(true)))
        .and(Specialization::medium(true, true))
        .and(Specialization::show(Show::Channels, &[], true))
        .and(Specialization::difference(8.0))
}

#[test]
fn builders_know_every_specialisation_constant() {
    let given = every_constant();
    assert_eq!(given.ids.len(), given.data.len());
    assert_eq!(given.ids.iter().collect::<BTreeSet<_>>().len(), given.ids.len(), "an id twice");
    for (module, reflection) in reflections() {
        for (name, id) in reflection.specialisation_ids() {
            assert!(given.ids.contains(&id), "{}: {name} is never given", module.name());
        }
    }
}

/// What is wrong with a module; `None` where there is nobody to ask.
fn invalid(spirv: &[u8]) -> Option<String> {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    std::io::Write::write_all(&mut file, spirv).unwrap();
    let mut command = std::process::Command::new("spirv-val");
    let Ok(output) = command.args(["--target-env", "vulkan1.1"]).arg(file.path()).output() else {
        println!("ignored: spirv-val is absent (on Debian: apt-get install spirv-tools)");
        return None;
    };
    Some(if output.status.success() { String::new() } else { String::from_utf8_lossy(&output.stderr).into() })
}

fn bytes(spirv: &[u32]) -> Vec<u8> {
    spirv.iter().flat_map(|word| word.to_le_bytes()).collect()
}

#[test]
fn modules_are_valid() {
    for module in Module::ALL {
        let Some(problem) = invalid(&bytes(module.spirv().unwrap())) else { return };
        assert_eq!(problem, "", "{}", module.name());
    }
    // A module that ends too early is not valid.
    let whole = read("spirv/tonemap.frag.spv").unwrap();
    assert_ne!(invalid(&whole[..whole.len() - 4]).unwrap(), "");
}

/// Values for a module's constants, one set for each number.
fn constants(reflection: &Reflection, set: u32) -> Specialization {
    let (ids, data) = (reflection.specialisation_ids().into_iter())
        .map(|(name, id)| {
            // Sets 0 and 1 are all off and all on; the others switch by the bits of a product that looks like noise.
            let noise = set.wrapping_mul(0x9e37_79b9).wrapping_mul(2 * id + 1) >> 13;
            let on = if set < 2 { set } else { noise & 1 };
            match name.as_str() {
                "TEXTURE_COUNT" => (id, KIND_COUNT as u32),
                slot if slot.starts_with("SLOT_") => {
                    (id, if on == 1 { noise % KIND_COUNT as u32 } else { u32::MAX })
                }
                "TONEMAP" | "VOLUME_SHAPE" | "SHADOW_FILTER" => (id, (noise >> 1) % 4),
                "FORM" => (id, (noise >> 1) % 9),
                "NORMALS" => (id, (noise >> 1) % 8),
                "GAMMA" => (id, (noise >> 1) % 3),
                _ => (id, on),
            }
        })
        .unzip();
    Specialization { ids, data }
}

/// What is left of every module is valid, whatever its constants; here, as much as drivers' checks see of it.
#[test]
fn specialised_modules_are_valid() {
    const SETS: u32 = 24;
    for (module, reflection) in reflections() {
        let sizes = (0..SETS).map(|set| {
            let constants = constants(&reflection, set);
            let spirv = prune("whole", module.spirv().unwrap(), &constants, None).unwrap().spirv;
            let left = Reflection::new(&spirv);
            assert!(left.specialisation_ids().is_empty(), "{}", module.name());
            if let Some(problem) = invalid(&bytes(&spirv)) {
                assert_eq!(problem, "", "{} with {constants:?}", module.name());
            }
            // What is left has nothing more to lose.
            assert_eq!(
                prune("left", &spirv, &constants, None).unwrap().spirv,
                spirv,
                "{} with {constants:?}",
                module.name()
            );
            spirv.len()
        });
        let (least, most) =
            sizes.fold((usize::MAX, 0), |(least, most), size| (least.min(size), most.max(size)));
        let whole = module.spirv().unwrap().len();
        assert!(most <= whole, "{}: {whole} words, and then {most}", module.name());
        let has_switches = !reflection.specialisation_ids().is_empty();
        assert!(!has_switches || least < most, "{}: {least} words whatever is switched off", module.name());
    }
}

/// Passes that repeat each other's geometry test for equal depth, and drivers compile each pipeline by itself.
#[test]
fn repeated_positions_are_invariant() {
    const SETS: u32 = 24;
    for module in [Module::GeometryVertex, Module::LightVolume] {
        let whole = Reflection::new(module.spirv().unwrap());
        for set in 0..SETS {
            let pruned = prune("whole", module.spirv().unwrap(), &constants(&whole, set), None).unwrap();
            assert!(Reflection::new(&pruned.spirv).has_invariant_position(), "{}, set {set}", module.name());
        }
        let mut varying = whole;
        varying
            .module
            .annotations
            .retain(|i| !i.operands.contains(&Operand::Decoration(Decoration::Invariant)));
        assert!(!varying.has_invariant_position(), "{}: not seen", module.name());
    }
}

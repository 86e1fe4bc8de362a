//! GLSL, the compiled SPIR-V and Rust agree.
//!
//! Each check returns the problems it finds, so that a tampered input shows that it can find any.

#[path = "shaders/reflect.rs"]
mod reflect;
#[path = "../tools/shader_manifest.rs"]
mod shader_manifest;

use ontile::gpu::shader::{
    GeometryConstants, LightInputs, LightLoop, LightingConstants, Module, OutputConstants, Specialization,
    embedded_names, shared,
};
use ontile::gpu::shared::{
    ClusterGrid, EnvironmentUniforms, FrameUniforms, InstanceData, LightData, LightPush, MaterialData,
    ShadowPush, ShadowViewData,
};
use ontile::plan::Tonemap;
use reflect::{Block, Reflection, block};
use rspirv::dr::Operand;
use rspirv::spirv::{Decoration, Op};
use shader_manifest::{Manifest, sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

const ALL_LIGHTS: LightInputs = LightInputs { scan: LightLoop::All, shadows: false, globe_maps: false };

fn glsl() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("glsl")
}

fn reflections() -> Vec<(Module, Reflection)> {
    Module::all().into_iter().map(|m| (m, Reflection::new(m.spirv().unwrap()))).collect()
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
    let expected: BTreeSet<_> = modules.iter().map(|m| m.name()).collect();
    let compiled: BTreeSet<_> = manifest.modules.keys().cloned().collect();
    problems
        .extend(expected.symmetric_difference(&compiled).map(|name| format!("{name}: not in both lists")));
    for module in modules {
        let name = module.name();
        let Some(record) = manifest.modules.get(&name) else { continue };
        if record.defines != module.defines() || record.sources[0] != module.source() {
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
    assert_eq!(manifest_problems(&manifest(), &Module::all(), &read), Vec::<String>::new());
    let embedded: BTreeSet<_> = embedded_names().map(String::from).collect();
    assert_eq!(embedded, Module::all().iter().map(|m| m.name()).collect());
    for module in Module::all() {
        let file = read(&format!("spirv/{}.spv", module.name())).unwrap();
        let words: Vec<_> = file.chunks_exact(4).map(|w| u32::from_le_bytes(w.try_into().unwrap())).collect();
        assert_eq!(module.spirv().unwrap(), words, "{}", module.name());
    }
    let spv_files = std::fs::read_dir(glsl().join("spirv"))
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().path().extension().is_some_and(|e| e == "spv"))
        .count();
    assert_eq!(spv_files, Module::all().len());
}

#[test]
fn stale_modules_are_reported() {
    let (fresh, all) = (manifest(), Module::all());
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
    other.modules.get_mut("lighting_exact.frag").unwrap().defines = vec!["LAYOUT_METALLIC128".into()];
    assert_eq!(manifest_problems(&other, &all, &read).len(), 1, "another define");
    let no_file = |path: &str| if path == "tonemap.glsl" { None } else { read(path) };
    assert_eq!(manifest_problems(&fresh, &all, &no_file).len(), 1, "a source too few");
}

#[test]
fn names_are_unique_and_unknown_keys_are_errors() {
    let all = Module::all();
    assert_eq!(all.iter().map(|m| m.name()).collect::<BTreeSet<_>>().len(), all.len());
    let tangent_only = Module::GeometryVertex { normal: false, texcoord: false, tangent: true, color: false };
    assert!(tangent_only.spirv().unwrap_err().to_string().contains("geometry_t.vert"));
}

fn blocks() -> [Block; 9] {
    [
        block!(
            "Frame" = FrameUniforms {
                clip_from_world,
                camera_position_world,
                right_world,
                down_world,
                forward_world,
                distance_from_depth,
                inverse_size,
                exposure,
                light_scale,
                ambient_nt,
                light_counts,
                hemispheres,
            }
        ),
        block!("Instance" = InstanceData { world_from_object_rows }),
        block!(
            "Material" = MaterialData {
                base_color_factor,
                emissive_factor_alpha_cutoff,
                metallic_factor,
                roughness_factor,
                normal_scale,
                occlusion_strength,
                uv_rows,
            }
        ),
        block!(
            "Light" = LightData {
                position_world,
                inverse_range,
                intensity,
                edge,
                direction_world,
                spot_offset,
                up_world,
                globe_rotation,
                back_intensity,
                shadow,
                half_size,
                globe_map,
            }
        ),
        block!("LightPush" = LightPush { light }),
        block!("ClusterGrid" = ClusterGrid { tile_shift, columns, rows, slices, slice_scale, slice_bias }),
        block!(
            "ShadowView" =
                ShadowViewData { map_from_world, tile, texel_m, spread_texels, offset_texels, lift_texels }
        ),
        block!("ShadowPush" = ShadowPush { clip_from_world, nearest_depth }),
        block!("Environment" = EnvironmentUniforms { irradiance, rotation, scale, last_level }),
    ]
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
    let frag = Module::Lighting { layout: ontile::plan::Layout::Exact, lights: ALL_LIGHTS }.spirv().unwrap();
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
        .collect();
    assert!(unused.is_empty(), "no module has {unused:?}");
    for (name, number) in &numbers {
        assert_eq!(shared(name), *number, "{name}");
    }
}

#[test]
fn wrong_interfaces_are_reported() {
    let numbers = shared_numbers();
    let nutc = Module::GeometryVertex { normal: true, texcoord: true, tangent: true, color: true };
    let lighting = Module::Lighting { layout: ontile::plan::Layout::Metallic128, lights: ALL_LIGHTS };
    for (module, decoration) in [
        (nutc, Decoration::Location),
        (nutc, Decoration::DescriptorSet),
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

#[test]
fn fragments_read_what_vertices_write() {
    let all = reflections();
    let mut pairs = 0;
    for (vertex, written) in &all {
        let Module::GeometryVertex { texcoord, .. } = *vertex else { continue };
        for (fragment, read) in &all {
            let (Module::GeometryFragment { textured, .. }
            | Module::Unlit { textured }
            | Module::Forward { textured, .. }
            | Module::Base { textured, .. }
            | Module::Light { textured, .. }
            | Module::Mask { textured }) = *fragment
            else {
                continue;
            };
            if textured && !texcoord {
                continue;
            }
            let missing: Vec<_> = read.inputs().difference(&written.outputs()).cloned().collect();
            assert!(missing.is_empty(), "{} after {}: {missing:?}", fragment.name(), vertex.name());
            pairs += 1;
        }
    }
    // Untextured fragments follow all 10 vertex modules, textured ones the 6 with texture coordinates.
    let textured = all.iter().filter(|(module, _)| module.defines().contains(&"TEXTURED")).count();
    assert_eq!(pairs, textured * (10 + 6), "as many untextured as textured ones");
}

#[test]
fn vertices_have_the_attributes_of_their_key() {
    for (module, reflection) in reflections() {
        let Module::GeometryVertex { normal, texcoord, tangent, color } = module else { continue };
        let has = [
            (true, "attribute_position"),
            (normal, "attribute_normal"),
            (texcoord, "attribute_texcoord"),
            (tangent, "attribute_tangent"),
            (color, "attribute_color"),
        ];
        let expected: BTreeSet<_> =
            has.iter().filter(|(has, _)| *has).map(|(_, name)| name.to_string()).collect();
        assert_eq!(reflection.inputs(), expected, "{}", module.name());
    }
}

/// A value for every constant that the typed builders know for this module.
fn specialization(module: Module) -> Specialization {
    let geometry = GeometryConstants::default().specialization();
    let output = OutputConstants { tonemap: Tonemap::Neutral, dither: false, background: None, fog: None };
    match module {
        Module::GeometryVertex { .. } | Module::Fullscreen | Module::ShadowVertex { .. } => {
            Specialization::default()
        }
        Module::LightVolume => Specialization::volume(0),
        Module::GeometryFragment { .. } | Module::Mask { .. } => geometry,
        Module::Unlit { .. } => geometry.and(output.specialization()),
        Module::Forward { .. } | Module::Base { .. } | Module::Light { .. } => {
            let shadow_filter = Some(ontile::plan::ShadowFilter::Grid3);
            let lighting = LightingConstants { fold: Some(output), shadow_filter, ..Default::default() };
            geometry.and(lighting.specialization())
        }
        Module::Lighting { .. } => {
            let shadow_filter = Some(ontile::plan::ShadowFilter::Grid3);
            LightingConstants { fold: Some(output), shadow_filter, ..Default::default() }.specialization()
        }
        Module::Tonemap { .. } => output.specialization(),
    }
}

#[test]
fn builders_know_every_specialisation_constant() {
    for (module, reflection) in reflections() {
        let given = specialization(module);
        assert_eq!(given.ids.len(), given.data.len());
        assert_eq!(given.ids.iter().collect::<BTreeSet<_>>().len(), given.ids.len(), "an id twice");
        for (name, id) in reflection.specialisation_ids() {
            assert!(given.ids.contains(&id), "{}: {name} is never given", module.name());
        }
    }
}

#[test]
fn modules_are_valid() {
    let validate = |path: &std::path::Path| {
        std::process::Command::new("spirv-val").args(["--target-env", "vulkan1.1"]).arg(path).output()
    };
    for module in Module::all() {
        let path = glsl().join(format!("spirv/{}.spv", module.name()));
        let Ok(output) = validate(&path) else {
            println!("ignored: spirv-val is absent (on Debian: apt-get install spirv-tools)");
            return;
        };
        assert!(output.status.success(), "{path:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    // A module that ends too early is not valid.
    let whole = read("spirv/tonemap.frag.spv").unwrap();
    let mut broken = tempfile::NamedTempFile::new().unwrap();
    std::io::Write::write_all(&mut broken, &whole[..whole.len() - 4]).unwrap();
    assert!(!validate(broken.path()).unwrap().status.success());
}

/// Every module with several values for its specialisation constants.
#[test]
fn pruned_modules_are_valid() {
    let dir = tempfile::tempdir().unwrap();
    let mut all = Vec::new();
    for (module, reflection) in reflections() {
        let mut ids: Vec<_> = reflection.specialisation_ids().into_iter().map(|(_, id)| id).collect();
        ids.sort();
        ids.dedup();
        for value in 0..4 {
            let constants = Specialization { ids: ids.clone(), data: vec![value; ids.len()] };
            let start = std::time::Instant::now();
            let pruned = ontile::gpu::shader::prune(module.spirv().unwrap(), &constants).unwrap();
            let t = start.elapsed();
            println!(
                "{} {value} {} -> {} {t:?}",
                module.name(),
                module.spirv().unwrap().len() * 4,
                pruned.len() * 4
            );
            let path = dir.path().join(format!("{}.{value}.spv", module.name()));
            std::fs::write(&path, bytemuck::cast_slice(&pruned)).unwrap();
            all.push(path);
        }
    }
    for p in all {
        let o = std::process::Command::new("spirv-val")
            .args(["--target-env", "vulkan1.1"])
            .arg(&p)
            .output()
            .unwrap();
        if !o.status.success() {
            println!("{p:?} {}", String::from_utf8_lossy(&o.stderr));
        }
    }
}

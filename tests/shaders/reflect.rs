//! Names, offsets and numbers of a SPIR-V module, compared with Rust's.

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{BuiltIn, Capability, Decoration, Op, StorageClass};
use std::collections::{BTreeMap, BTreeSet};

/// How a value lies in memory: (count, stride in bytes) from the outermost array to the components.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    pub dimensions: Vec<(usize, usize)>,
    pub component: &'static str,
}

/// Rust types that shared structs are made of.
pub trait Shaped {
    fn shape() -> Shape;
}

impl Shaped for f32 {
    fn shape() -> Shape {
        Shape { dimensions: vec![], component: "f32" }
    }
}

impl Shaped for u32 {
    fn shape() -> Shape {
        Shape { dimensions: vec![], component: "u32" }
    }
}

impl<T: Shaped, const N: usize> Shaped for [T; N] {
    fn shape() -> Shape {
        let inner = T::shape();
        let dimensions = std::iter::once((N, size_of::<T>())).chain(inner.dimensions).collect();
        Shape { dimensions, ..inner }
    }
}

/// The shape of the field that an accessor returns.
pub fn shape_of<T, F: Shaped>(_: fn(&T) -> &F) -> Shape {
    F::shape()
}

#[derive(Clone, Debug)]
pub struct Member {
    pub name: &'static str,
    pub offset: usize,
    pub shape: Shape,
}

/// A Rust struct that mirrors the GLSL struct or block `name`.
#[derive(Clone, Debug)]
pub struct Block {
    pub name: &'static str,
    pub size: usize,
    pub members: Vec<Member>,
}

macro_rules! block {
    ($name:literal = $rust:ident { $($field:ident),* $(,)? }) => {{
        // Does not compile when a field is left out.
        let _ = |value: $rust| { let $rust { $($field: _),* } = value; };
        $crate::reflect::Block {
            name: $name,
            size: size_of::<$rust>(),
            members: vec![$($crate::reflect::Member {
                name: stringify!($field),
                offset: std::mem::offset_of!($rust, $field),
                shape: $crate::reflect::shape_of(|value: &$rust| &value.$field),
            }),*],
        }
    }};
}
pub(crate) use block;

pub struct Reflection {
    pub module: Module,
}

impl Reflection {
    pub fn new(spirv: &[u32]) -> Self {
        Self { module: rspirv::dr::load_words(spirv).unwrap() }
    }

    fn global(&self, id: u32) -> &Instruction {
        self.module.types_global_values.iter().find(|i| i.result_id == Some(id)).unwrap()
    }

    fn name(&self, id: u32) -> Option<&str> {
        self.module.debug_names.iter().find_map(|i| match &i.operands[..] {
            [Operand::IdRef(of), Operand::LiteralString(name)] if *of == id => Some(name.as_str()),
            _ => None,
        })
    }

    fn decoration(&self, id: u32, wanted: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|i| match &i.operands[..] {
            [Operand::IdRef(of), Operand::Decoration(d), Operand::LiteralBit32(number)]
                if *of == id && *d == wanted =>
            {
                Some(*number)
            }
            _ => None,
        })
    }

    fn member_decoration(&self, id: u32, member: u32, wanted: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|i| match &i.operands[..] {
            [
                Operand::IdRef(of),
                Operand::LiteralBit32(at),
                Operand::Decoration(d),
                Operand::LiteralBit32(number),
            ] if *of == id && *at == member && *d == wanted => Some(*number),
            _ => None,
        })
    }

    /// Whether another module that computes the position alike gets the same bits.
    pub fn has_invariant_position(&self) -> bool {
        let of = |i: &Instruction| {
            let decoration = i.operands.iter().position(|o| matches!(o, Operand::Decoration(_)))?;
            let (target, decoration) = i.operands.split_at(decoration);
            Some((target.to_vec(), decoration.to_vec()))
        };
        let all: Vec<_> = self.module.annotations.iter().filter_map(of).collect();
        let position = [Operand::Decoration(Decoration::BuiltIn), Operand::BuiltIn(BuiltIn::Position)];
        let invariant = [Operand::Decoration(Decoration::Invariant)];
        let target = all.iter().find(|(_, decoration)| *decoration == position).map(|(target, _)| target);
        target.is_some_and(|target| all.contains(&(target.clone(), invariant.to_vec())))
    }

    fn member_names(&self, id: u32) -> Vec<&str> {
        let names = self.module.debug_names.iter().filter_map(|i| match &i.operands[..] {
            [Operand::IdRef(of), Operand::LiteralBit32(member), Operand::LiteralString(name)]
                if *of == id =>
            {
                Some((*member, name.as_str()))
            }
            _ => None,
        });
        names.collect::<BTreeMap<_, _>>().into_values().collect()
    }

    /// The shape of a member type; matrices' strides are decorations of the member that they are.
    fn shape(&self, type_id: u32, matrix_stride: Option<u32>) -> Shape {
        let ty = self.global(type_id);
        let nested = |count: usize, stride: usize| {
            let inner = self.shape(ty.operands[0].unwrap_id_ref(), matrix_stride);
            let dimensions = std::iter::once((count, stride)).chain(inner.dimensions).collect();
            Shape { dimensions, ..inner }
        };
        match ty.class.opcode {
            Op::TypeFloat => Shape { dimensions: vec![], component: "f32" },
            Op::TypeInt => Shape { dimensions: vec![], component: "u32" },
            Op::TypeVector => nested(ty.operands[1].unwrap_literal_bit32() as usize, 4),
            Op::TypeMatrix => nested(
                ty.operands[1].unwrap_literal_bit32() as usize,
                matrix_stride.expect("a matrix has a stride") as usize,
            ),
            Op::TypeArray => {
                let length = self.global(ty.operands[1].unwrap_id_ref());
                let stride =
                    self.decoration(type_id, Decoration::ArrayStride).expect("an array has a stride");
                nested(length.operands[0].unwrap_literal_bit32() as usize, stride as usize)
            }
            other => panic!("a shared struct with {other:?}"),
        }
    }

    /// How the struct of the same name differs; `None` if the module has none.
    pub fn block_problems(&self, block: &Block) -> Option<Vec<String>> {
        let ty = self.module.types_global_values.iter().find(|i| {
            i.class.opcode == Op::TypeStruct && i.result_id.and_then(|id| self.name(id)) == Some(block.name)
        })?;
        let id = ty.result_id.unwrap();
        let names = self.member_names(id);
        let mut problems = Vec::new();
        let expected: Vec<_> = block.members.iter().map(|m| m.name).collect();
        if names != expected || names.len() != ty.operands.len() {
            problems.push(format!("{}: members {names:?}, in Rust {expected:?}", block.name));
        }
        for (index, name) in names.iter().enumerate() {
            let Some(member) = block.members.iter().find(|m| m.name == *name) else { continue };
            let at = index as u32;
            let offset = self.member_decoration(id, at, Decoration::Offset).map(|o| o as usize);
            let stride = self.member_decoration(id, at, Decoration::MatrixStride);
            let shape = self.shape(ty.operands[index].unwrap_id_ref(), stride);
            if offset != Some(member.offset) || shape != member.shape {
                problems.push(format!("{}.{name}: {offset:?} {shape:?}, in Rust {member:?}", block.name));
            }
        }
        // Arrays of the struct step by Rust's size; a uniform block ends where Rust's struct does.
        let element = Operand::IdRef(id);
        for array in self.module.types_global_values.iter().filter(|i| {
            matches!(i.class.opcode, Op::TypeRuntimeArray | Op::TypeArray) && i.operands[0] == element
        }) {
            let stride = self.decoration(array.result_id.unwrap(), Decoration::ArrayStride);
            if stride != Some(block.size as u32) {
                problems.push(format!("{}: array stride {stride:?}, in Rust {}", block.name, block.size));
            }
        }
        let end = block.members.last().map_or(0, |m| {
            m.offset + m.shape.dimensions.first().map_or(size_of::<u32>(), |(count, stride)| count * stride)
        });
        if end != block.size {
            problems.push(format!("{}: Rust pads {} bytes at the end", block.name, block.size - end));
        }
        Some(problems)
    }

    /// Variables as (name, storage class, id); a block without an instance name goes by its type's.
    fn variables(&self) -> Vec<(String, StorageClass, u32)> {
        let variables = self.module.types_global_values.iter().filter(|i| i.class.opcode == Op::Variable);
        let named = variables.map(|i| {
            let (id, pointer) = (i.result_id.unwrap(), self.global(i.result_type.unwrap()));
            let own = self.name(id).filter(|name| !name.is_empty());
            let of_type = || self.name(pointer.operands[1].unwrap_id_ref());
            let name = own.or_else(of_type).unwrap_or_default().to_owned();
            (name, i.operands[0].unwrap_storage_class(), id)
        });
        named.collect()
    }

    fn locations(&self, class: StorageClass) -> BTreeSet<u32> {
        let variables = self.variables().into_iter().filter(|(_, c, _)| *c == class);
        variables.filter_map(|(.., id)| self.decoration(id, Decoration::Location)).collect()
    }

    /// Locations of the stage's inputs.
    pub fn input_locations(&self) -> BTreeSet<u32> {
        self.locations(StorageClass::Input)
    }

    /// Locations of the stage's outputs.
    pub fn output_locations(&self) -> BTreeSet<u32> {
        self.locations(StorageClass::Output)
    }

    /// How many descriptors it mentions, by set and binding.
    pub fn bindings(&self) -> Vec<((u32, u32), u32)> {
        let bound = self.variables().into_iter().filter_map(|(_, _, id)| {
            let set = self.decoration(id, Decoration::DescriptorSet)?;
            let pointer = self.global(self.global(id).result_type?);
            let of = self.global(pointer.operands[1].unwrap_id_ref());
            let count = match of.class.opcode {
                Op::TypeArray => {
                    self.global(of.operands[1].unwrap_id_ref()).operands[0].unwrap_literal_bit32()
                }
                _ => 1,
            };
            Some(((set, self.decoration(id, Decoration::Binding)?), count))
        });
        bound.collect()
    }

    /// Whether it has push constants.
    pub fn has_push_constants(&self) -> bool {
        self.variables().iter().any(|(_, class, _)| *class == StorageClass::PushConstant)
    }

    /// Whether it declares a capability.
    pub fn has_capability(&self, wanted: Capability) -> bool {
        self.module.capabilities.iter().any(|i| i.operands[0] == Operand::Capability(wanted))
    }

    /// Whether it has input attachments.
    pub fn has_input_attachments(&self) -> bool {
        let variables = self.variables();
        variables.iter().any(|(.., id)| self.decoration(*id, Decoration::InputAttachmentIndex).is_some())
    }

    /// Specialisation constants by name.
    pub fn specialisation_ids(&self) -> Vec<(String, u32)> {
        let constants = self.module.types_global_values.iter().filter_map(|i| {
            let id = i.result_id?;
            let constant = self.decoration(id, Decoration::SpecId)?;
            Some((self.name(id).unwrap_or_default().to_owned(), constant))
        });
        constants.collect()
    }

    /// The names of shared.h that the module uses, and where its numbers differ from theirs.
    pub fn interface_problems(&self, numbers: &BTreeMap<String, u32>) -> (BTreeSet<String>, Vec<String>) {
        let (mut used, mut problems) = (BTreeSet::new(), Vec::new());
        let has = |wanted: fn(&str) -> bool| self.variables().iter().any(|(name, ..)| wanted(name));
        let has_material = has(|name| name == "material");
        // What surfaces and particles read of depth is after their material, as layers are.
        let reads_behind = self.specialisation_ids().iter().any(|(name, _)| name == "HAS_BEHIND");
        let reads_others =
            !reads_behind && has(|name| name.starts_with("input_") && !name.starts_with("input_layer_"));
        let mut compare = |of: &str, what: &str, found: Option<u32>, name: String| {
            if found.is_none() || numbers.get(&name) != found.as_ref() {
                problems.push(format!("{of}: {what} {found:?}, but {name} is {:?}", numbers.get(&name)));
            }
            used.insert(name);
        };
        for (name, class, id) in self.variables() {
            let decoration = |wanted| self.decoration(id, wanted);
            let mut resource = |set: &str, binding: String| {
                compare(&name, "set", decoration(Decoration::DescriptorSet), set.into());
                compare(&name, "binding", decoration(Decoration::Binding), binding);
            };
            let upper = |prefix: &str| name.strip_prefix(prefix).map(|rest| rest.to_uppercase());
            // Decals have input attachments where surfaces have their material, and blended surfaces have theirs after it.
            let of_material = match reads_others {
                true => "SET_DECAL_MATERIAL",
                false => "SET_MATERIAL",
            };
            match class {
                StorageClass::Uniform | StorageClass::StorageBuffer => {
                    let set =
                        if ["material", "medium"].contains(&&*name) { of_material } else { "SET_FRAME" };
                    resource(set, format!("BINDING_{}", name.to_uppercase()));
                }
                StorageClass::UniformConstant => match upper("input_") {
                    Some(input) => {
                        let input = format!("INPUT_{input}");
                        let of_surfaces = (reads_behind || input.starts_with("INPUT_LAYER_")) && has_material;
                        resource(if of_surfaces { "SET_LAYERS" } else { "SET_INPUTS" }, input.clone());
                        // Later passes sample what was an input.
                        let index = decoration(Decoration::InputAttachmentIndex);
                        if index.is_some() {
                            compare(&name, "input attachment index", index, input);
                        }
                    }
                    None => match upper("material_") {
                        Some(texture) => resource(of_material, format!("BINDING_{texture}")),
                        None => {
                            let set = match name.as_str() {
                                "bloom" | "edge_color" | "other" => "SET_INPUTS",
                                name if name.starts_with("behind_") && has_material => "SET_LAYERS",
                                name if name.starts_with("behind_") => "SET_INPUTS",
                                name if name.starts_with("post_") => "SET_POST",
                                _ => "SET_FRAME",
                            };
                            resource(set, format!("BINDING_{}", name.to_uppercase()));
                        }
                    },
                },
                StorageClass::Input | StorageClass::Output if decoration(Decoration::Location).is_some() => {
                    let without_space = name.trim_end_matches("_world").to_uppercase();
                    compare(&name, "location", decoration(Decoration::Location), without_space);
                }
                _ => {}
            }
        }
        for (name, id) in self.specialisation_ids() {
            compare(&name, "constant id", Some(id), format!("ID_{name}"));
        }
        (used, problems)
    }
}

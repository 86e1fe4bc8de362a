//! SPIR-V as instructions, functions and blocks: as much of the grammar as this crate's modules use (SPIR-V 1.3,
//! sections 2.3, 2.4 and 3.32).

use std::borrow::Cow;

use super::{Malformed, Result};

/// Numbers of instructions.
pub(super) mod op {
    pub const UNDEF: u16 = 1;
    pub const NAME: u16 = 5;
    pub const MEMBER_NAME: u16 = 6;
    pub const EXT_INST_IMPORT: u16 = 11;
    pub const ENTRY_POINT: u16 = 15;
    pub const EXECUTION_MODE: u16 = 16;
    pub const CAPABILITY: u16 = 17;
    pub const TYPE_VOID: u16 = 19;
    pub const TYPE_BOOL: u16 = 20;
    pub const TYPE_INT: u16 = 21;
    pub const TYPE_FLOAT: u16 = 22;
    pub const TYPE_IMAGE: u16 = 25;
    pub const TYPE_FUNCTION: u16 = 33;
    pub const CONSTANT_TRUE: u16 = 41;
    pub const CONSTANT_FALSE: u16 = 42;
    pub const CONSTANT: u16 = 43;
    pub const CONSTANT_COMPOSITE: u16 = 44;
    pub const CONSTANT_NULL: u16 = 46;
    pub const SPEC_CONSTANT_TRUE: u16 = 48;
    pub const SPEC_CONSTANT_FALSE: u16 = 49;
    pub const SPEC_CONSTANT: u16 = 50;
    pub const SPEC_CONSTANT_COMPOSITE: u16 = 51;
    pub const SPEC_CONSTANT_OP: u16 = 52;
    pub const FUNCTION: u16 = 54;
    pub const FUNCTION_PARAMETER: u16 = 55;
    pub const FUNCTION_END: u16 = 56;
    pub const FUNCTION_CALL: u16 = 57;
    pub const VARIABLE: u16 = 59;
    pub const STORE: u16 = 62;
    pub const ACCESS_CHAIN: u16 = 65;
    pub const IN_BOUNDS_ACCESS_CHAIN: u16 = 66;
    pub const DECORATE: u16 = 71;
    pub const MEMBER_DECORATE: u16 = 72;
    pub const COMPOSITE_EXTRACT: u16 = 81;
    pub const COPY_OBJECT: u16 = 83;
    pub const IMAGE_QUERY_SIZE_LOD: u16 = 103;
    pub const IMAGE_QUERY_SAMPLES: u16 = 107;
    pub const BITCAST: u16 = 124;
    pub const LOGICAL_OR: u16 = 166;
    pub const LOGICAL_AND: u16 = 167;
    pub const SELECT: u16 = 169;
    pub const PHI: u16 = 245;
    pub const LOOP_MERGE: u16 = 246;
    pub const SELECTION_MERGE: u16 = 247;
    pub const LABEL: u16 = 248;
    pub const BRANCH: u16 = 249;
    pub const BRANCH_CONDITIONAL: u16 = 250;
    pub const SWITCH: u16 = 251;
    pub const UNREACHABLE: u16 = 255;
}

/// What the operands of an instruction are, in order: `r` its own id, `i` an id that it uses, `l` a literal, `s` a text, and at
/// the end `I` ids, `L` literals, `P` pairs of a literal and an id, `O` image operands (a mask of bits, then ids).
fn operands_of(op: u16) -> Option<&'static str> {
    Some(match op {
        op::NAME | op::EXECUTION_MODE | op::DECORATE => "ilL",
        op::MEMBER_NAME | op::MEMBER_DECORATE => "illL",
        10 => "L",  // Extension
        14 => "ll", // MemoryModel
        op::EXT_INST_IMPORT => "rL",
        op::ENTRY_POINT => "lisI",
        op::CAPABILITY => "l",
        op::TYPE_VOID | op::TYPE_BOOL | 26 => "r", // 26: TypeSampler
        op::TYPE_INT => "rll",
        op::TYPE_FLOAT => "rl",
        23 | 24 => "ril", // TypeVector, TypeMatrix
        op::TYPE_IMAGE => "rillllllL",
        27 | 29 => "ri",                // TypeSampledImage, TypeRuntimeArray
        28 => "rii",                    // TypeArray
        30 | op::TYPE_FUNCTION => "rI", // 30: TypeStruct
        32 => "rli",                    // TypePointer
        op::UNDEF | op::CONSTANT_TRUE | op::CONSTANT_FALSE | op::CONSTANT_NULL => "ir",
        op::SPEC_CONSTANT_TRUE | op::SPEC_CONSTANT_FALSE | op::FUNCTION_PARAMETER => "ir",
        op::CONSTANT | op::SPEC_CONSTANT => "irlL",
        op::CONSTANT_COMPOSITE | op::SPEC_CONSTANT_COMPOSITE => "irI",
        op::FUNCTION => "irli",
        op::FUNCTION_END => "",
        12 => "irilI", // ExtInst
        op::FUNCTION_CALL => "iriI",
        op::VARIABLE => "irlI",
        61 => "iriL",            // Load
        op::STORE | 63 => "iiL", // 63: CopyMemory
        op::ACCESS_CHAIN | op::IN_BOUNDS_ACCESS_CHAIN => "iriI",
        68 => "iril",          // ArrayLength
        77 => "irii",          // VectorExtractDynamic
        78 => "iriii",         // VectorInsertDynamic
        79 | 82 => "iriiL",    // VectorShuffle, CompositeInsert
        80 | op::PHI => "irI", // 80: CompositeConstruct
        op::COMPOSITE_EXTRACT => "iriL",
        op::COPY_OBJECT | 84 => "iri",           // 84: Transpose
        86 => "irii",                            // SampledImage
        87 | 88 | 91 | 92 | 95 | 98 => "iriiO",  // ImageSample* but for those below, ImageFetch, ImageRead
        89 | 90 | 93 | 94 | 96 | 97 => "iriiiO", // ImageSample*Dref*, ImageGather, ImageDrefGather
        99 => "iiiO",                            // ImageWrite
        100 | 104 | 106 | 107 => "iri",          // Image, ImageQuery* of an image
        103 | 105 => "irii",                     // ImageQuery* of an image and a level or place
        109..=116 | op::BITCAST => "iri",        // conversions
        126 | 127 => "iri",                      // SNegate, FNegate
        128..=152 => "irii",                     // arithmetic
        154..=157 | 168 => "iri",                // Any, All, IsNan, IsInf, LogicalNot
        164..=167 | 170..=191 => "irii",         // logic, comparisons
        op::SELECT => "iriii",
        194..=199 => "irii",      // shifts, bitwise logic
        200 | 204 | 205 => "iri", // Not, BitReverse, BitCount
        201 => "iriiii",          // BitFieldInsert
        202 | 203 => "iriii",     // BitFieldExtract
        207..=215 => "iri",       // derivatives
        op::LOOP_MERGE => "iilL",
        op::SELECTION_MERGE => "il",
        op::LABEL => "r",
        op::BRANCH | 254 => "i", // 254: ReturnValue
        op::BRANCH_CONDITIONAL => "iiiL",
        op::SWITCH => "iiP",
        252 | 253 | op::UNREACHABLE => "", // Kill, Return
        _ => return None,
    })
}

/// One instruction.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Instruction<'a> {
    pub op: u16,
    /// The words after the first.
    pub operands: Cow<'a, [u32]>,
}

impl<'a> Instruction<'a> {
    pub(super) fn new(op: u16, operands: Vec<u32>) -> Self {
        Self { op, operands: operands.into() }
    }

    /// The id that it defines.
    pub(super) fn result(&self) -> Option<u32> {
        let pattern = operands_of(self.op).unwrap_or("irl");
        pattern.find('r').and_then(|at| self.operands.get(at).copied())
    }

    /// Where the operands are that use ids; `None` if they are not what the instruction has.
    fn places_of_uses(&self) -> Option<Vec<usize>> {
        let pattern = match self.op {
            op::SPEC_CONSTANT_OP => match self.operands.get(2).copied()? as u16 {
                79 => "irliiL", // VectorShuffle
                op::COMPOSITE_EXTRACT => "irliL",
                82 => "irliiL", // CompositeInsert
                _ => "irlI",
            },
            other => operands_of(other)?,
        };
        let (mut places, mut at, len) = (Vec::new(), 0, self.operands.len());
        for kind in pattern.bytes() {
            match kind {
                b'i' => {
                    places.push(at);
                    at += 1;
                }
                b'I' => places.extend(std::mem::replace(&mut at, len)..len),
                b'O' if at < len => places.extend(std::mem::replace(&mut at, len) + 1..len),
                b'O' => {}
                b'P' if (len.checked_sub(at)?) % 2 == 0 => {
                    places.extend((std::mem::replace(&mut at, len) + 1..len).step_by(2))
                }
                b'P' => return None,
                b'L' => at = at.max(len),
                b's' => at += 1 + self.operands.get(at..)?.iter().position(|word| word >> 24 == 0)?,
                _ => at += 1,
            }
        }
        (at == len).then_some(places)
    }

    /// The ids that it uses, its type among them.
    pub(super) fn uses(&self) -> impl Iterator<Item = u32> {
        self.places_of_uses().unwrap_or_default().into_iter().map(|at| self.operands[at])
    }

    /// Puts another id in place of each one that it uses.
    pub(super) fn map_uses(&mut self, other: impl Fn(u32) -> u32) {
        for at in self.places_of_uses().unwrap_or_default() {
            let (id, new) = (self.operands[at], other(self.operands[at]));
            if new != id {
                self.operands.to_mut()[at] = new;
            }
        }
    }

    /// Whether it ends a block.
    fn is_end(&self) -> bool {
        matches!(self.op, op::BRANCH..=op::UNREACHABLE)
    }
}

/// A basic block.
#[derive(Clone, Debug)]
pub(super) struct Block<'a> {
    pub label: u32,
    pub body: Vec<Instruction<'a>>,
    /// What makes it the header of a selection or a loop.
    pub merge: Option<Instruction<'a>>,
    pub end: Instruction<'a>,
}

impl Block<'_> {
    /// Where control goes from here.
    pub(super) fn successors(&self) -> impl Iterator<Item = u32> {
        let operands = &self.end.operands;
        let (labels, step) = match self.end.op {
            op::BRANCH => (&operands[..1], 1),
            op::BRANCH_CONDITIONAL => (&operands[1..3], 1),
            op::SWITCH => (&operands[1..], 2),
            _ => (&operands[..0], 1),
        };
        labels.iter().copied().step_by(step)
    }

    /// Where control meets again after what this block is the header of.
    pub(super) fn merge_label(&self) -> Option<u32> {
        self.merge.as_ref().map(|merge| merge.operands[0])
    }

    /// Where the loop that this block is the header of goes on.
    pub(super) fn continue_label(&self) -> Option<u32> {
        self.merge.as_ref().filter(|merge| merge.op == op::LOOP_MERGE).map(|merge| merge.operands[1])
    }
}

/// A function.
#[derive(Clone, Debug)]
pub(super) struct Function<'a> {
    /// OpFunction and its parameters.
    pub head: Vec<Instruction<'a>>,
    /// At least one; the first is where it begins.
    pub blocks: Vec<Block<'a>>,
}

/// A module.
#[derive(Clone, Debug)]
pub(super) struct Module<'a> {
    /// One more than the greatest id.
    pub bound: u32,
    version: u32,
    generator: u32,
    /// Everything before the functions.
    pub global: Vec<Instruction<'a>>,
    pub functions: Vec<Function<'a>>,
}

const MAGIC: u32 = 0x0723_0203;

/// SPIR-V 1.3, section 2.17: no module needs ids that are greater.
const GREATEST_BOUND: u32 = 0x003f_ffff;

impl<'a> Module<'a> {
    pub(super) fn read(words: &'a [u32]) -> Result<Self> {
        let &[MAGIC, version, generator, bound, _, ref rest @ ..] = words else {
            return Err(Malformed("it does not begin like SPIR-V of this machine's byte order".into()));
        };
        if bound > GREATEST_BOUND {
            return Err(Malformed(format!("ids up to {bound}")));
        }
        let mut module = Self { bound, version, generator, global: Vec::new(), functions: Vec::new() };
        let mut reader = Reader { rest, bound, defined: vec![false; bound as usize] };
        while let Some(instruction) = reader.next()? {
            if instruction.op != op::FUNCTION {
                module.global.push(instruction);
                continue;
            }
            module.functions.push(reader.function(instruction)?);
        }
        Ok(module)
    }

    pub(super) fn write(&self) -> Vec<u32> {
        let mut words = vec![MAGIC, self.version, self.generator, self.bound, 0];
        let mut write = |op: u16, operands: &[u32]| {
            words.push((operands.len() as u32 + 1) << 16 | u32::from(op));
            words.extend(operands);
        };
        self.global.iter().for_each(|i| write(i.op, &i.operands));
        for function in &self.functions {
            function.head.iter().for_each(|i| write(i.op, &i.operands));
            for block in &function.blocks {
                write(op::LABEL, &[block.label]);
                let rest = block.body.iter().chain(&block.merge).chain([&block.end]);
                rest.for_each(|i| write(i.op, &i.operands));
            }
            write(op::FUNCTION_END, &[]);
        }
        words
    }
}

struct Reader<'a> {
    rest: &'a [u32],
    bound: u32,
    defined: Vec<bool>,
}

impl<'a> Reader<'a> {
    /// The next instruction, whose ids are within bounds and whose own id is new.
    fn next(&mut self) -> Result<Option<Instruction<'a>>> {
        let Some(&first) = self.rest.first() else { return Ok(None) };
        let (op, count) = (first as u16, (first >> 16) as usize);
        if count == 0 || count > self.rest.len() {
            return Err(Malformed(format!("instruction {op} is longer than the module")));
        }
        let (words, rest) = self.rest.split_at(count);
        self.rest = rest;
        let instruction = Instruction { op, operands: Cow::Borrowed(&words[1..]) };
        let Some(places) = instruction.places_of_uses() else {
            return Err(Malformed(format!("instruction {op} with {} operands is not known", count - 1)));
        };
        let result = instruction.result();
        for id in places.iter().map(|at| instruction.operands[*at]).chain(result) {
            if id == 0 || id >= self.bound {
                return Err(Malformed(format!("id {id} where all are less than {}", self.bound)));
            }
        }
        if let Some(id) = result
            && std::mem::replace(&mut self.defined[id as usize], true)
        {
            return Err(Malformed(format!("id {id} is defined twice")));
        }
        Ok(Some(instruction))
    }

    fn in_function(&mut self) -> Result<Instruction<'a>> {
        self.next()?.ok_or_else(|| Malformed("it ends within a function".into()))
    }

    fn function(&mut self, first: Instruction<'a>) -> Result<Function<'a>> {
        let mut function = Function { head: vec![first], blocks: Vec::new() };
        loop {
            let instruction = self.in_function()?;
            match instruction.op {
                op::FUNCTION_PARAMETER if function.blocks.is_empty() => function.head.push(instruction),
                op::LABEL => function.blocks.push(self.block(instruction.operands[0])?),
                op::FUNCTION_END if !function.blocks.is_empty() => return Ok(function),
                other => return Err(Malformed(format!("instruction {other} outside of a block"))),
            }
        }
    }

    fn block(&mut self, label: u32) -> Result<Block<'a>> {
        let (mut body, mut merge) = (Vec::new(), None);
        loop {
            let instruction = self.in_function()?;
            match instruction.op {
                _ if instruction.is_end() => return Ok(Block { label, body, merge, end: instruction }),
                _ if merge.is_some() => {
                    return Err(Malformed(format!("block {label} goes on after its merge")));
                }
                op::LOOP_MERGE | op::SELECTION_MERGE => merge = Some(instruction),
                op::LABEL | op::FUNCTION | op::FUNCTION_PARAMETER | op::FUNCTION_END => {
                    return Err(Malformed(format!("block {label} does not end")));
                }
                _ => body.push(instruction),
            }
        }
    }
}

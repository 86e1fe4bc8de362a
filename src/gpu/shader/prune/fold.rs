//! Constants: what specialisation freezes, and what follows from it.

use std::collections::HashMap;

use super::words::{Block, Instruction, Module, op};
use super::{Malformed, Result};
use crate::gpu::shader::Specialization;

const DECORATION_SPEC_ID: u32 = 1;

/// What an instruction comes down to.
enum Folded {
    /// A constant of its type: bits.
    Value(u32),
    /// Another id.
    Id(u32),
}

/// What is known of ids.
pub(super) struct Constants {
    /// Scalar constants: a bool is 0 or 1, a number its 32 bits.
    values: HashMap<u32, u32>,
    /// Types whose constants have such values.
    scalars: HashMap<u32, bool>,
    /// The parts of composite constants.
    composites: HashMap<u32, Vec<u32>>,
    /// The constant of a type and value.
    ids: HashMap<(u32, u32), u32>,
    /// Undefined values, by type.
    undefined: HashMap<u32, u32>,
    /// Ids in whose place others stand; these are not keys themselves.
    replaced: HashMap<u32, u32>,
    /// Constants that the module had not.
    made: Vec<Instruction<'static>>,
    bound: u32,
}

impl Constants {
    /// Makes ordinary constants of a module's specialisation constants: with the values given, or else their defaults.
    pub(super) fn freeze(module: &mut Module<'_>, given: &Specialization) -> Result<Self> {
        let mut constants = Self {
            values: HashMap::new(),
            scalars: HashMap::new(),
            composites: HashMap::new(),
            ids: HashMap::new(),
            undefined: HashMap::new(),
            replaced: HashMap::new(),
            made: Vec::new(),
            bound: module.bound,
        };
        let given: HashMap<_, _> = given.ids.iter().copied().zip(given.data.iter().copied()).collect();
        let mut wanted = HashMap::new();
        for instruction in &mut module.global {
            match (instruction.op, &instruction.operands[..]) {
                (op::DECORATE, &[id, DECORATION_SPEC_ID, number]) => {
                    if let Some(value) = given.get(&number) {
                        wanted.insert(id, *value);
                    }
                }
                (op::TYPE_BOOL, &[id]) => drop(constants.scalars.insert(id, true)),
                (op::TYPE_INT, &[id, 32, _]) | (op::TYPE_FLOAT, &[id, 32]) => {
                    constants.scalars.insert(id, false);
                }
                // The literals of a switch would be wider, too.
                (op::TYPE_INT, &[_, width, _]) => return Err(Malformed(format!("integers of {width} bits"))),
                _ => constants.freeze_one(instruction, &wanted),
            }
        }
        module.global.retain(|i| i.op != op::DECORATE || i.operands[1] != DECORATION_SPEC_ID);
        Ok(constants)
    }

    fn freeze_one(&mut self, instruction: &mut Instruction<'_>, wanted: &HashMap<u32, u32>) {
        let (Some(id), Some(&ty)) = (instruction.result(), instruction.operands.first()) else { return };
        let wanted = wanted.get(&id).copied();
        let scalar = self.scalars.contains_key(&ty);
        let value = match instruction.op {
            op::CONSTANT_TRUE => Some(1),
            op::CONSTANT_FALSE => Some(0),
            op::CONSTANT_NULL if scalar => Some(0),
            op::CONSTANT if scalar => Some(instruction.operands[2]),
            op::SPEC_CONSTANT_TRUE => Some(wanted.map_or(1, |w| u32::from(w != 0))),
            op::SPEC_CONSTANT_FALSE => Some(wanted.map_or(0, |w| u32::from(w != 0))),
            op::SPEC_CONSTANT if scalar => Some(wanted.unwrap_or(instruction.operands[2])),
            op::SPEC_CONSTANT_OP => {
                let (op, operands) = (instruction.operands[2] as u16, &instruction.operands[3..]);
                match self.fold(op, ty, operands) {
                    Some(Folded::Value(value)) => Some(value),
                    Some(Folded::Id(other)) => self.values.get(&other).copied().filter(|_| scalar),
                    None => None,
                }
            }
            op::CONSTANT_COMPOSITE | op::SPEC_CONSTANT_COMPOSITE => {
                instruction.op = op::CONSTANT_COMPOSITE;
                self.composites.insert(id, instruction.operands[2..].to_vec());
                None
            }
            _ => None,
        };
        if let Some(value) = value {
            self.values.insert(id, value);
            self.ids.entry((ty, value)).or_insert(id);
            *instruction = self.constant(ty, id, value);
        }
    }

    fn constant(&self, ty: u32, id: u32, value: u32) -> Instruction<'static> {
        match (self.scalars.get(&ty), value) {
            (Some(true), 0) => Instruction::new(op::CONSTANT_FALSE, vec![ty, id]),
            (Some(true), _) => Instruction::new(op::CONSTANT_TRUE, vec![ty, id]),
            _ => Instruction::new(op::CONSTANT, vec![ty, id, value]),
        }
    }

    /// Adds the constants that were made to the module.
    pub(super) fn finish(self, module: &mut Module<'_>) {
        module.global.extend(self.made);
        module.bound = self.bound;
    }

    /// The value of a scalar constant.
    pub(super) fn value(&self, id: u32) -> Option<u32> {
        self.values.get(&id).copied()
    }

    /// An undefined value of this type.
    pub(super) fn undefined(&mut self, ty: u32) -> u32 {
        let next = self.bound;
        let id = *self.undefined.entry(ty).or_insert(next);
        if id == next {
            self.bound += 1;
            self.made.push(Instruction::new(op::UNDEF, vec![ty, id]));
        }
        id
    }

    fn id_of(&mut self, ty: u32, value: u32) -> u32 {
        if let Some(id) = self.ids.get(&(ty, value)) {
            return *id;
        }
        let id = self.bound;
        self.bound += 1;
        self.ids.insert((ty, value), id);
        self.values.insert(id, value);
        self.made.push(self.constant(ty, id, value));
        id
    }

    /// What stands for an id.
    fn resolve(&self, mut id: u32) -> u32 {
        while let Some(other) = self.replaced.get(&id) {
            id = *other;
        }
        id
    }

    /// Removes instructions that come down to something simpler; returns whether there were any.
    pub(super) fn fold_block(&mut self, block: &mut Block<'_>) -> bool {
        let before = block.body.len();
        block.body.retain_mut(|instruction| {
            instruction.map_uses(|id| self.resolve(id));
            let [ty, result, ref operands @ ..] = instruction.operands[..] else { return true };
            if instruction.result() != Some(result) {
                return true;
            }
            let id = match self.fold(instruction.op, ty, operands) {
                Some(Folded::Value(value)) => self.id_of(ty, value),
                Some(Folded::Id(id)) => id,
                None if instruction.op == op::PHI => match self.only_value(result, operands) {
                    Some(id) => id,
                    None => return true,
                },
                None => return true,
            };
            if id == result {
                return true;
            }
            self.replaced.insert(result, id);
            false
        });
        block.end.map_uses(|id| self.resolve(id));
        block.body.len() != before
    }

    /// What a phi is, if it is the same whichever way control came. Ways that control never comes from are undefined.
    fn only_value(&self, result: u32, operands: &[u32]) -> Option<u32> {
        let undefined = |id: &u32| self.undefined.values().any(|u| u == id);
        let mut values = operands.iter().step_by(2).filter(|id| **id != result && !undefined(id));
        let first = *values.next()?;
        values.all(|id| *id == first).then_some(first)
    }

    fn fold(&self, op: u16, ty: u32, operands: &[u32]) -> Option<Folded> {
        let value = |at: usize| self.value(*operands.get(at)?);
        match (op, operands) {
            (op::SELECT, &[_, yes, no]) if value(0).is_some() => {
                return Some(Folded::Id(if value(0) == Some(1) { yes } else { no }));
            }
            (op::COPY_OBJECT, &[of]) => return Some(Folded::Id(of)),
            (op::COMPOSITE_EXTRACT, &[of, at]) => {
                return self.composites.get(&of)?.get(at as usize).map(|id| Folded::Id(*id));
            }
            // What one side decides; the other need not be known.
            (op::LOGICAL_AND | op::LOGICAL_OR, &[a, b]) => {
                let decides = u32::from(op == op::LOGICAL_OR);
                return match (value(0), value(1)) {
                    (Some(known), _) if known == decides => Some(Folded::Value(decides)),
                    (_, Some(known)) if known == decides => Some(Folded::Value(decides)),
                    (Some(_), _) => Some(Folded::Id(b)),
                    (_, Some(_)) => Some(Folded::Id(a)),
                    _ => None,
                };
            }
            _ => {}
        }
        self.scalars.get(&ty)?;
        match *operands {
            [_] => evaluate_one(op, value(0)?),
            [_, _] => evaluate_two(op, value(0)?, value(1)?),
            _ => None,
        }
        .map(Folded::Value)
    }
}

fn evaluate_one(op: u16, a: u32) -> Option<u32> {
    Some(match op {
        op::BITCAST => a,
        126 => a.wrapping_neg(),  // SNegate
        168 => u32::from(a == 0), // LogicalNot
        200 => !a,                // Not
        _ => return None,
    })
}

/// Integers, logic and comparisons, exactly. Arithmetic of floats is left to the driver, whose rounding it is.
fn evaluate_two(op: u16, a: u32, b: u32) -> Option<u32> {
    let (sa, sb) = (a as i32, b as i32);
    let (fa, fb) = (f32::from_bits(a), f32::from_bits(b));
    let unordered = fa.is_nan() || fb.is_nan();
    let truth = match op {
        164 | 170 => a == b,           // LogicalEqual, IEqual
        165 | 171 => a != b,           // LogicalNotEqual, INotEqual
        172 => a > b,                  // UGreaterThan
        173 => sa > sb,                // SGreaterThan
        174 => a >= b,                 // UGreaterThanEqual
        175 => sa >= sb,               // SGreaterThanEqual
        176 => a < b,                  // ULessThan
        177 => sa < sb,                // SLessThan
        178 => a <= b,                 // ULessThanEqual
        179 => sa <= sb,               // SLessThanEqual
        180 => fa == fb,               // FOrdEqual
        181 => fa == fb || unordered,  // FUnordEqual
        182 => fa != fb && !unordered, // FOrdNotEqual
        183 => fa != fb,               // FUnordNotEqual
        184 => fa < fb,                // FOrdLessThan
        185 => fa < fb || unordered,   // FUnordLessThan
        186 => fa > fb,                // FOrdGreaterThan
        187 => fa > fb || unordered,   // FUnordGreaterThan
        188 => fa <= fb,               // FOrdLessThanEqual
        189 => fa <= fb || unordered,  // FUnordLessThanEqual
        190 => fa >= fb,               // FOrdGreaterThanEqual
        191 => fa >= fb || unordered,  // FUnordGreaterThanEqual
        _ => {
            return match op {
                128 => Some(a.wrapping_add(b)),                         // IAdd
                130 => Some(a.wrapping_sub(b)),                         // ISub
                132 => Some(a.wrapping_mul(b)),                         // IMul
                134 => a.checked_div(b),                                // UDiv
                137 => a.checked_rem(b),                                // UMod
                194 => a.checked_shr(b),                                // ShiftRightLogical
                195 => sa.checked_shr(b).map(|shifted| shifted as u32), // ShiftRightArithmetic
                196 => a.checked_shl(b),                                // ShiftLeftLogical
                197 => Some(a | b),                                     // BitwiseOr
                198 => Some(a ^ b),                                     // BitwiseXor
                199 => Some(a & b),                                     // BitwiseAnd
                _ => None,
            };
        }
    };
    Some(truth.into())
}

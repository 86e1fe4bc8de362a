//! What nothing uses.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::words::{Function, Instruction, Module, op};

const DECORATION_LOCATION: u32 = 30;

const DECORATION_BUILT_IN: u32 = 11;
const BUILT_IN_SAMPLE_ID: u32 = 18;

const STORAGE_INPUT: u32 = 1;
const STORAGE_OUTPUT: u32 = 3;
const STORAGE_PRIVATE: u32 = 6;
const STORAGE_FUNCTION: u32 = 7;

const DIM_CUBE: u32 = 3;
const DIM_SUBPASS_DATA: u32 = 6;

const CAPABILITY_IMAGE_CUBE_ARRAY: u32 = 34;
const CAPABILITY_SAMPLE_RATE_SHADING: u32 = 35;
const CAPABILITY_INPUT_ATTACHMENT: u32 = 40;
const CAPABILITY_SAMPLED_CUBE_ARRAY: u32 = 45;
const CAPABILITY_IMAGE_QUERY: u32 = 50;

/// The locations of the module's inputs.
pub(super) fn inputs(module: &Module<'_>) -> BTreeSet<u32> {
    let locations = locations(module);
    let inputs = module.global.iter().filter(|i| i.op == op::VARIABLE && i.operands[2] == STORAGE_INPUT);
    inputs.filter_map(|i| locations.get(&i.operands[1]).copied()).collect()
}

/// Locations by variable.
fn locations(module: &Module<'_>) -> HashMap<u32, u32> {
    let decorations = module.global.iter().filter(|i| i.op == op::DECORATE);
    let located = decorations.filter_map(|i| match i.operands[..] {
        [id, DECORATION_LOCATION, location] => Some((id, location)),
        _ => None,
    });
    located.collect()
}

/// Removes instructions without effect whose results are not used, and everything that only they mention. Outputs with a location
/// that is not `read` have no effect.
pub(super) fn remove(module: &mut Module<'_>, read: Option<&BTreeSet<u32>>) {
    let Live { used, stores_used, pointers, .. } = Live::of(module, read);
    module.functions.retain(|function| used.contains(&function.head[0].operands[1]));
    for block in module.functions.iter_mut().flat_map(|function| &mut function.blocks) {
        block.body.retain(|instruction| match instruction.result() {
            Some(id) => used.contains(&id) || has_effect(instruction),
            None => local_of(&pointers, instruction).is_none_or(|variable| stores_used.contains(&variable)),
        });
    }
    for entry in module.global.iter_mut().filter(|i| i.op == op::ENTRY_POINT) {
        let interface = interface_of(entry);
        let mut at = 0;
        entry.operands.to_mut().retain(|id| {
            at += 1;
            at <= interface || used.contains(id)
        });
    }
    module.global.retain(|instruction| match instruction.op {
        op::NAME | op::MEMBER_NAME | op::DECORATE | op::MEMBER_DECORATE => {
            used.contains(&instruction.operands[0])
        }
        _ => instruction.result().is_none_or(|id| used.contains(&id)),
    });
    remove_capabilities(module);
}

/// Capabilities stand for device features, some of which a device need not enable for what is left.
fn remove_capabilities(module: &mut Module<'_>) {
    let image = |wanted: fn(u32, u32) -> bool| {
        // Result, sampled type, dimensions, depth, arrayed
        module.global.iter().any(|i| i.op == op::TYPE_IMAGE && wanted(i.operands[2], i.operands[4]))
    };
    let inputs = image(|dim, _| dim == DIM_SUBPASS_DATA);
    let cube_arrays = image(|dim, arrayed| dim == DIM_CUBE && arrayed == 1);
    let blocks = module.functions.iter().flat_map(|function| &function.blocks);
    let queries = blocks
        .flat_map(|block| &block.body)
        .any(|i| matches!(i.op, op::IMAGE_QUERY_SIZE_LOD..=op::IMAGE_QUERY_SAMPLES));
    let samples = module
        .global
        .iter()
        .any(|i| i.op == op::DECORATE && i.operands[1..] == [DECORATION_BUILT_IN, BUILT_IN_SAMPLE_ID]);
    module.global.retain(|i| match (i.op, &i.operands[..]) {
        (op::CAPABILITY, [CAPABILITY_SAMPLE_RATE_SHADING]) => samples,
        (op::CAPABILITY, [CAPABILITY_INPUT_ATTACHMENT]) => inputs,
        (op::CAPABILITY, [CAPABILITY_IMAGE_CUBE_ARRAY | CAPABILITY_SAMPLED_CUBE_ARRAY]) => cube_arrays,
        (op::CAPABILITY, [CAPABILITY_IMAGE_QUERY]) => queries,
        _ => true,
    });
}

/// How many operands of an entry point come before its interface: model, function, and the name.
fn interface_of(entry: &Instruction<'_>) -> usize {
    let name = entry.operands[2..].iter().position(|word| word >> 24 == 0).unwrap_or(0);
    2 + name + 1
}

/// Calls are taken to have effects.
fn has_effect(instruction: &Instruction<'_>) -> bool {
    instruction.op == op::FUNCTION_CALL
}

/// Where pointers into variables that nobody else sees begin.
type Pointers = HashMap<u32, u32>;

/// The variable that an instruction stores to, if nobody else sees it.
fn local_of(pointers: &Pointers, instruction: &Instruction<'_>) -> Option<u32> {
    match instruction.op {
        op::STORE => pointers.get(&instruction.operands[0]).copied(),
        _ => None,
    }
}

/// The search for what is used.
struct Live<'a, 'm> {
    definitions: HashMap<u32, &'a Instruction<'m>>,
    functions: HashMap<u32, &'a Function<'m>>,
    pointers: Pointers,
    /// Stores to local variables, by variable: they matter only if it is read.
    stores: HashMap<u32, Vec<&'a Instruction<'m>>>,
    used: HashSet<u32>,
    stores_used: HashSet<u32>,
    open: Vec<u32>,
}

impl<'a, 'm> Live<'a, 'm> {
    fn of(module: &'a Module<'m>, read: Option<&BTreeSet<u32>>) -> Self {
        let mut live = Self {
            definitions: HashMap::new(),
            functions: HashMap::new(),
            pointers: HashMap::new(),
            stores: HashMap::new(),
            used: HashSet::new(),
            stores_used: HashSet::new(),
            open: Vec::new(),
        };
        let locations = locations(module);
        for instruction in &module.global {
            live.define(instruction);
            if let (op::VARIABLE, &[_, id, STORAGE_OUTPUT, ..]) = (instruction.op, &instruction.operands[..])
                && let (Some(read), Some(location)) = (read, locations.get(&id))
                && !read.contains(location)
            {
                live.pointers.insert(id, id);
            }
        }
        for function in &module.functions {
            live.functions.insert(function.head[0].operands[1], function);
            function.head.iter().for_each(|i| live.define(i));
            function.blocks.iter().flat_map(|block| &block.body).for_each(|i| live.define(i));
        }
        for instruction in &module.global {
            match instruction.op {
                op::ENTRY_POINT => live.open.push(instruction.operands[1]),
                op::EXECUTION_MODE => live.open.push(instruction.operands[0]),
                _ => {}
            }
        }
        while let Some(id) = live.open.pop() {
            live.visit(id);
        }
        live
    }

    fn define(&mut self, instruction: &'a Instruction<'m>) {
        let Some(id) = instruction.result() else { return };
        self.definitions.insert(id, instruction);
        match (instruction.op, &instruction.operands[..]) {
            (op::VARIABLE, &[_, _, STORAGE_FUNCTION | STORAGE_PRIVATE, ..]) => {
                self.pointers.insert(id, id);
            }
            (op::ACCESS_CHAIN | op::IN_BOUNDS_ACCESS_CHAIN | op::COPY_OBJECT, &[_, _, base, ..]) => {
                if let Some(variable) = self.pointers.get(&base).copied() {
                    self.pointers.insert(id, variable);
                }
            }
            _ => {}
        }
    }

    fn visit(&mut self, id: u32) {
        if !self.used.insert(id) {
            return;
        }
        if let Some(definition) = self.definitions.get(&id) {
            self.open.extend(definition.uses());
        }
        if let Some(function) = self.functions.get(&id).copied() {
            self.visit_function(function);
        }
        // Whoever reads a variable reads what is stored in it.
        if self.pointers.get(&id) == Some(&id) && self.stores_used.insert(id) {
            for store in self.stores.remove(&id).unwrap_or_default() {
                self.open.extend(store.uses());
            }
        }
    }

    fn visit_function(&mut self, function: &'a Function<'m>) {
        function.head.iter().for_each(|i| self.open.extend(i.uses()));
        self.open.extend(function.head[1..].iter().filter_map(Instruction::result));
        for block in &function.blocks {
            self.open.extend(block.end.uses());
            for instruction in &block.body {
                let wanted = instruction.result().is_none() || has_effect(instruction);
                match local_of(&self.pointers, instruction) {
                    Some(variable) if !self.stores_used.contains(&variable) => {
                        self.stores.entry(variable).or_default().push(instruction);
                    }
                    _ if wanted => self.open.extend(instruction.uses().chain(instruction.result())),
                    _ => {}
                }
            }
        }
    }
}

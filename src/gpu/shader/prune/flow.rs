//! Control flow: branches that constants decide, and blocks that are never reached (SPIR-V 1.3, section 2.11).

use std::collections::{HashMap, HashSet};

use super::fold::Constants;
use super::words::{Block, Function, Instruction, op};
use super::{Malformed, Result};

/// Takes the branches that are decided and removes what is not reached; returns whether there was anything to do.
pub(super) fn simplify(function: &mut Function<'_>, constants: &mut Constants) -> Result<bool> {
    let decided = decide(function, constants);
    let graph = Graph::new(function)?;
    let dropped = drop_merges(function, &graph);
    let graph = Graph::new(function)?;
    let removed = keep_reached(function, &graph);
    let mended = mend_phis(function, constants);
    Ok(decided || dropped || removed || mended)
}

/// Leaves one target to each branch whose condition is constant. Headers of selections keep their merge for now: the branch
/// says the target twice, or a switch has no case but the default.
fn decide(function: &mut Function<'_>, constants: &Constants) -> bool {
    let mut changed = false;
    for block in &mut function.blocks {
        let end = &block.end;
        let (condition, value) = match end.operands.first() {
            Some(&id) => (id, constants.value(id)),
            None => continue,
        };
        let target = match (end.op, &end.operands[..]) {
            (op::BRANCH_CONDITIONAL, &[_, yes, no, ..]) if yes == no => yes,
            (op::BRANCH_CONDITIONAL, &[_, yes, no, ..]) => match value {
                Some(value) => {
                    if value != 0 {
                        yes
                    } else {
                        no
                    }
                }
                None => continue,
            },
            (op::SWITCH, &[_, default]) => default,
            (op::SWITCH, &[_, default, ref cases @ ..]) => match value {
                Some(value) => {
                    cases.chunks_exact(2).find(|case| case[0] == value).map_or(default, |case| case[1])
                }
                None => continue,
            },
            _ => continue,
        };
        let selects = block.merge.as_ref().is_some_and(|merge| merge.op == op::SELECTION_MERGE);
        let new = match (selects, end.op) {
            (false, _) => Instruction::new(op::BRANCH, vec![target]),
            (true, op::SWITCH) => Instruction::new(op::SWITCH, vec![condition, target]),
            (true, _) => Instruction::new(op::BRANCH_CONDITIONAL, vec![condition, target, target]),
        };
        changed |= *end != new;
        block.end = new;
    }
    changed
}

/// The target of a selection that is none any more.
fn only_target(block: &Block<'_>) -> Option<u32> {
    let selects = block.merge.as_ref()?.op == op::SELECTION_MERGE;
    let mut targets = block.successors();
    let first = targets.next()?;
    (selects && targets.all(|target| target == first)).then_some(first)
}

/// Makes plain branches of selections with one target, unless a block of a construct within leaves for the merge block: such
/// an exit is allowed to merge blocks only (`break` in a `switch`, or an early return).
fn drop_merges(function: &mut Function<'_>, graph: &Graph) -> bool {
    let headers = graph.headers(function);
    let plain: Vec<(usize, u32)> = function
        .blocks
        .iter()
        .enumerate()
        .filter_map(|(index, header)| {
            let target = only_target(header)?;
            let merge = header.merge_label()?;
            let mut before =
                graph.predecessors.get(&merge).into_iter().flatten().filter(|label| **label != header.label);
            let directly = before.all(|label| {
                let block = &function.blocks[graph.index[label]];
                block.end.op == op::BRANCH
                    && block.merge.is_none()
                    && headers.get(label) == Some(&header.label)
            });
            (!graph.reached.contains(&header.label) || directly).then_some((index, target))
        })
        .collect();
    for (index, target) in &plain {
        let block = &mut function.blocks[*index];
        (block.merge, block.end) = (None, Instruction::new(op::BRANCH, vec![*target]));
    }
    !plain.is_empty()
}

/// Puts blocks into an order in which all come after those that dominate them, without those that are never reached. A merge
/// block or continue target stays while there is its header, as nothing but an end.
fn keep_reached(function: &mut Function<'_>, graph: &Graph) -> bool {
    let mut loops = HashMap::new();
    for block in function.blocks.iter().filter(|block| graph.reached.contains(&block.label)) {
        loops.extend(block.continue_label().map(|label| (label, block.label)));
    }
    let before: Vec<_> = function.blocks.iter().map(|block| block.label).collect();
    let mut changed = before != graph.order;
    let mut blocks: HashMap<_, _> = function.blocks.drain(..).map(|block| (block.label, block)).collect();
    function.blocks.extend(graph.order.iter().filter_map(|label| blocks.remove(label)));
    for block in function.blocks.iter_mut().filter(|block| !graph.reached.contains(&block.label)) {
        let end = match loops.get(&block.label) {
            Some(header) => Instruction::new(op::BRANCH, vec![*header]),
            None => Instruction::new(op::UNREACHABLE, Vec::new()),
        };
        changed |= !block.body.is_empty() || block.merge.is_some() || block.end != end;
        *block = Block { label: block.label, body: Vec::new(), merge: None, end };
    }
    changed
}

/// Leaves to each phi the values of those blocks that control comes from.
fn mend_phis(function: &mut Function<'_>, constants: &mut Constants) -> bool {
    let mut from = HashMap::<u32, Vec<u32>>::new();
    for block in &function.blocks {
        block.successors().for_each(|label| from.entry(label).or_default().push(block.label));
    }
    // Continue targets that are never reached still go back to the header, with no value.
    let entry = function.blocks[0].label;
    let labels = function.blocks.iter().map(|block| block.label);
    let unreached: HashSet<_> = labels.filter(|label| *label != entry && !from.contains_key(label)).collect();
    let mut changed = false;
    for block in &mut function.blocks {
        let from = from.get(&block.label).map_or(&[][..], Vec::as_slice);
        for phi in block.body.iter_mut().filter(|i| i.op == op::PHI) {
            let mut mended = phi.operands[..2].to_vec();
            for pair in phi.operands[2..].chunks_exact(2) {
                if from.contains(&pair[1]) && !unreached.contains(&pair[1]) {
                    mended.extend(pair);
                }
            }
            for &label in from.iter().filter(|label| unreached.contains(label)) {
                mended.extend([constants.undefined(phi.operands[0]), label]);
            }
            if phi.operands[..] != mended[..] {
                phi.operands = mended.into();
                changed = true;
            }
        }
    }
    changed
}

/// Where control can go.
struct Graph {
    /// Places of blocks by label.
    index: HashMap<u32, usize>,
    /// Labels that control reaches.
    reached: HashSet<u32>,
    /// Of blocks that are reached.
    predecessors: HashMap<u32, Vec<u32>>,
    /// Labels of what is reached, and of the merge blocks and continue targets that go with it, each after those that dominate it.
    order: Vec<u32>,
}

impl Graph {
    fn new(function: &Function<'_>) -> Result<Self> {
        let index: HashMap<_, _> =
            function.blocks.iter().enumerate().map(|(i, block)| (block.label, i)).collect();
        for block in &function.blocks {
            let labels = block.successors().chain(block.merge_label()).chain(block.continue_label());
            if let Some(label) = labels.into_iter().find(|label| !index.contains_key(label)) {
                return Err(Malformed(format!("block {} goes to {label}, which is no block", block.label)));
            }
        }
        let blocks = &function.blocks;
        let mut graph =
            Self { index, reached: HashSet::new(), predecessors: HashMap::new(), order: Vec::new() };
        let entry = blocks[0].label;
        let reached = graph.post_order(entry, |label| blocks[graph.index[&label]].successors().collect());
        graph.reached = reached.into_iter().collect();
        for block in blocks.iter().filter(|block| graph.reached.contains(&block.label)) {
            for label in block.successors() {
                graph.predecessors.entry(label).or_default().push(block.label);
            }
        }
        // What a construct merges into is visited first, so that in reverse it comes after all of the construct.
        graph.order = graph.post_order(entry, |label| {
            let block = &blocks[graph.index[&label]];
            if !graph.reached.contains(&label) {
                return Vec::new();
            }
            block.merge_label().into_iter().chain(block.continue_label()).chain(block.successors()).collect()
        });
        graph.order.reverse();
        Ok(graph)
    }

    /// Labels from `entry` on, each after all that follow it but for those that lead back.
    fn post_order(&self, entry: u32, next: impl Fn(u32) -> Vec<u32>) -> Vec<u32> {
        let (mut order, mut seen) = (Vec::new(), HashSet::from([entry]));
        let mut path = vec![(entry, next(entry).into_iter())];
        while let Some((label, rest)) = path.last_mut() {
            match rest.next() {
                Some(label) if seen.insert(label) => path.push((label, next(label).into_iter())),
                Some(_) => {}
                None => {
                    order.push(*label);
                    path.pop();
                }
            }
        }
        order
    }

    /// The header of the innermost construct that each block is in.
    fn headers(&self, function: &Function<'_>) -> HashMap<u32, u32> {
        let mut headers = HashMap::new();
        for label in &self.order {
            let block = &function.blocks[self.index[label]];
            let outer = headers.get(label).copied();
            if let (Some(merge), Some(outer)) = (block.merge_label(), outer) {
                headers.entry(merge).or_insert(outer);
            }
            let inner = if block.merge.is_some() { Some(block.label) } else { outer };
            let Some(inner) = inner else { continue };
            for next in block.continue_label().into_iter().chain(block.successors()) {
                if Some(next) != block.merge_label() {
                    headers.entry(next).or_insert(inner);
                }
            }
        }
        headers
    }
}

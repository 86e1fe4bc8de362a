//! What specialisation constants leave of a shader module.
//!
//! A module may do much that a pipeline has no use for. Its driver would skip that, but not what it mentions: a descriptor,
//! an input or an output that code could use has to be there even if a constant says that it is not used. [`prune`] makes the
//! module that would have been compiled had the constants been known: it *freezes* them, *folds* what follows from them, takes
//! the branches that they decide, and removes what is then left without use.

mod flow;
mod fold;
mod unused;
mod words;

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use super::Specialization;
use fold::Constants;
use words::Module;

/// Why a module cannot be pruned: it is not SPIR-V, or has what [`words`] does not know.
#[derive(Debug)]
struct Malformed(String);

type Result<T, E = Malformed> = std::result::Result<T, E>;

/// What is left of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pruned {
    /// The module: it has no specialisation constant, and no variable that it does not use.
    pub spirv: Vec<u32>,
    /// Locations of the inputs that it reads.
    pub inputs: BTreeSet<u32>,
}

/// The module with specialisation constants of the values given, or else their defaults, and without everything that these make
/// useless. Of the outputs that have a location, those are written that the next stage reads: `None`, all. `name` is for errors.
///
/// # Errors
/// [`crate::Error::Unsupported`] if the words are not SPIR-V, or have instructions that no shader of this crate has.
pub fn prune(
    name: &str,
    spirv: &[u32],
    constants: &Specialization,
    read: Option<&BTreeSet<u32>>,
) -> crate::Result<Pruned> {
    pruned(spirv, constants, read).map_err(|Malformed(problem)| {
        crate::Error::unsupported(
            format!("shader module '{name}' cannot be specialised: {problem}"),
            "run ./tools/shaders",
        )
    })
}

fn pruned(spirv: &[u32], given: &Specialization, read: Option<&BTreeSet<u32>>) -> Result<Pruned> {
    let mut module = Module::read(spirv)?;
    let mut constants = Constants::freeze(&mut module, given)?;
    for function in &mut module.functions {
        loop {
            let mut changed = false;
            for block in &mut function.blocks {
                changed |= constants.fold_block(block);
            }
            changed |= flow::simplify(function, &mut constants)?;
            if !changed {
                break;
            }
        }
    }
    constants.finish(&mut module);
    unused::remove(&mut module, read);
    Ok(Pruned { spirv: module.write(), inputs: unused::inputs(&module) })
}

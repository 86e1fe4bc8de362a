//! Which specialisation constants a module has.

use std::collections::BTreeMap;

/// The specialisation constants of a SPIR-V module: ids, and defaults as 32 bits (a bool is 0 or 1).
pub(in crate::gpu) fn declared(spirv: &[u32]) -> BTreeMap<u32, u32> {
    const HEADER_WORDS: usize = 5;
    const SPEC_ID: u32 = 1;
    const DECORATE: u32 = 71;
    const TRUE: u32 = 48;
    const FALSE: u32 = 49;
    const NUMBER: u32 = 50;
    let mut id_of = BTreeMap::new();
    let mut declared = BTreeMap::new();
    let mut rest = spirv.get(HEADER_WORDS..).unwrap_or_default();
    while let [first, ..] = *rest {
        let (op, length) = (first & 0xffff, (first >> 16).max(1) as usize);
        let Some(words) = rest.get(1..length) else { break };
        // Decorations come before what they decorate.
        let default = match (op, words) {
            (DECORATE, &[target, SPEC_ID, id]) => {
                id_of.insert(target, id);
                None
            }
            (TRUE, &[_, result]) => Some((result, 1)),
            (FALSE, &[_, result]) => Some((result, 0)),
            (NUMBER, &[_, result, value]) => Some((result, value)),
            _ => None,
        };
        if let Some((result, value)) = default
            && let Some(&id) = id_of.get(&result)
        {
            declared.insert(id, value);
        }
        rest = &rest[length..];
    }
    declared
}

#[cfg(test)]
mod tests {
    use super::declared;
    use crate::gpu::shader::{Module, shared};

    #[test]
    fn constants_of_a_module_are_found_with_their_defaults() {
        let found = declared(Module::Tonemap.spirv().unwrap());
        assert_eq!(found.get(&shared("ID_TONEMAP")), Some(&shared("TONEMAP_NEUTRAL")));
        assert_eq!(found.get(&shared("ID_DITHER")), Some(&0));
        assert_eq!(found.get(&shared("ID_HAS_POINT")), None);
        let found = declared(Module::GeometryVertex.spirv().unwrap());
        assert!(found.values().all(|&default| default <= 1 || default == u32::MAX), "{found:?}");
        assert!(declared(&[]).is_empty());
    }
}

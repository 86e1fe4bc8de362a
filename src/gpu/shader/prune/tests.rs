use proptest::prelude::*;

use super::words::{Instruction, Module, op};
use super::{Malformed, prune, pruned};
use crate::gpu::shader::{Module as Shader, Specialization};

/// What every fragment shader here has: `%7` and `%8` are specialisation constants 0 (false) and 1 (0), `%9` and `%10` the
/// numbers 1 and 2, `%12` the output, `%14` an input, `%18` a local variable's type, `%20` an input attachment.
const GLOBAL: &str = "
    Capability 1
    Capability 40
    MemoryModel 0 1
    EntryPoint 4 1 0x6e69616d 0 12 14
    ExecutionMode 1 7
    Decorate 7 1 0
    Decorate 8 1 1
    Decorate 12 30 0
    Decorate 14 30 0
    Decorate 20 34 1
    Decorate 20 33 0
    Decorate 20 43 0
    TypeVoid 2
    TypeFunction 3 2
    TypeBool 4
    TypeInt 5 32 0
    TypeFloat 6 32
    SpecConstantFalse 4 7
    SpecConstant 5 8 0
    Constant 6 9 0x3f800000
    Constant 6 10 0x40000000
    TypePointer 11 3 6
    Variable 11 12 3
    TypePointer 13 1 6
    Variable 13 14 1
    Constant 5 15 0
    Constant 5 16 1
    TypeVector 17 6 4
    TypePointer 18 7 6
    TypeImage 19 6 6 0 0 0 2 0
    TypePointer 21 0 19
    Variable 21 20 0
    TypeInt 22 32 1
    TypeVector 23 22 2
    Constant 22 24 0
    ConstantComposite 23 25 24 24
";

/// The words of GLOBAL and of a function with this body.
fn assembled(body: &str) -> Vec<u32> {
    let text = format!("{GLOBAL} Function 2 1 0 3 \n {body} \n FunctionEnd");
    let mut words = vec![0x0723_0203, 0x0001_0300, 0, 100, 0];
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let mut parts = line.split_whitespace();
        let op = number_of(parts.next().unwrap());
        let operands = parts.map(|p| match p.strip_prefix("0x") {
            Some(hex) => u32::from_str_radix(hex, 16).unwrap(),
            None => p.parse().unwrap(),
        });
        let operands: Vec<_> = operands.collect();
        words.push((operands.len() as u32 + 1) << 16 | u32::from(op));
        words.extend(operands);
    }
    words
}

const NAMES: &[(&str, u16)] = &[
    ("Capability", op::CAPABILITY),
    ("MemoryModel", 14),
    ("EntryPoint", op::ENTRY_POINT),
    ("ExecutionMode", op::EXECUTION_MODE),
    ("Decorate", op::DECORATE),
    ("TypeVoid", op::TYPE_VOID),
    ("TypeFunction", op::TYPE_FUNCTION),
    ("TypeBool", op::TYPE_BOOL),
    ("TypeInt", op::TYPE_INT),
    ("TypeFloat", op::TYPE_FLOAT),
    ("TypeVector", 23),
    ("TypeImage", op::TYPE_IMAGE),
    ("TypePointer", 32),
    ("SpecConstantFalse", op::SPEC_CONSTANT_FALSE),
    ("SpecConstant", op::SPEC_CONSTANT),
    ("Constant", op::CONSTANT),
    ("ConstantComposite", op::CONSTANT_COMPOSITE),
    ("Variable", op::VARIABLE),
    ("Function", op::FUNCTION),
    ("FunctionEnd", op::FUNCTION_END),
    ("Load", 61),
    ("Store", op::STORE),
    ("CompositeExtract", op::COMPOSITE_EXTRACT),
    ("ImageRead", 98),
    ("IAdd", 128),
    ("FOrdLessThan", 184),
    ("LogicalAnd", op::LOGICAL_AND),
    ("LogicalNot", 168),
    ("IEqual", 170),
    ("Select", op::SELECT),
    ("Phi", op::PHI),
    ("LoopMerge", op::LOOP_MERGE),
    ("SelectionMerge", op::SELECTION_MERGE),
    ("Label", op::LABEL),
    ("Branch", op::BRANCH),
    ("BranchConditional", op::BRANCH_CONDITIONAL),
    ("Switch", op::SWITCH),
    ("Kill", 252),
    ("Return", 253),
    ("Unreachable", op::UNREACHABLE),
];

fn number_of(name: &str) -> u16 {
    NAMES.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("no instruction {name}")).1
}

fn constants(values: [u32; 2]) -> Specialization {
    Specialization { ids: vec![0, 1], data: values.into() }
}

/// The function that is left of this one, in the same notation; validated where there is spirv-val.
fn left_of(body: &str, values: [u32; 2]) -> String {
    let words = pruned(&assembled(body), &constants(values), None).unwrap().spirv;
    validate(&words);
    let module = Module::read(&words).unwrap();
    let mut text = Vec::new();
    for block in &module.functions[0].blocks {
        let label = Instruction::new(op::LABEL, vec![block.label]);
        for i in std::iter::once(&label).chain(&block.body).chain(&block.merge).chain([&block.end]) {
            let name = NAMES.iter().find(|(_, number)| *number == i.op).unwrap().0;
            let operands = i.operands.iter().map(|operand| format!(" {operand}"));
            text.push(format!("{name}{}", operands.collect::<String>()));
        }
    }
    text.join("; ")
}

fn validate(words: &[u32]) {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    std::io::Write::write_all(&mut file, bytemuck::cast_slice(words)).unwrap();
    let mut command = std::process::Command::new("spirv-val");
    let Ok(output) = command.args(["--target-env", "vulkan1.1"]).arg(file.path()).output() else { return };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Instructions of the module around that function.
fn global_of(body: &str, values: [u32; 2], op: u16) -> Vec<Vec<u32>> {
    let words = pruned(&assembled(body), &constants(values), None).unwrap().spirv;
    let module = Module::read(&words).unwrap();
    module.global.iter().filter(|i| i.op == op).map(|i| i.operands.to_vec()).collect()
}

const IF: &str = "
    Label 50
    SelectionMerge 53 0
    BranchConditional 7 51 52
    Label 51
    Load 6 60 14
    Branch 53
    Label 52
    Load 19 62 20
    ImageRead 17 63 62 25
    CompositeExtract 6 64 63 0
    Branch 53
    Label 53
    Phi 6 61 60 51 64 52
    Store 12 61
    Return";

#[test]
fn a_branch_that_is_not_taken_takes_its_variables_with_it() {
    assert_eq!(
        left_of(IF, [1, 0]),
        "Label 50; Branch 51; Label 51; Load 6 60 14; Branch 53; Label 53; Store 12 60; Return"
    );
    assert_eq!(
        left_of(IF, [0, 0]),
        "Label 50; Branch 52; Label 52; Load 19 62 20; ImageRead 17 63 62 25; CompositeExtract 6 64 63 0; \
         Branch 53; Label 53; Store 12 64; Return"
    );
    // The interface and the capability follow, and so do types and decorations.
    let main = 0x6e69_616d;
    assert_eq!(global_of(IF, [1, 0], op::ENTRY_POINT), [[4, 1, main, 0, 12, 14]]);
    assert_eq!(global_of(IF, [0, 0], op::ENTRY_POINT), [[4, 1, main, 0, 12]]);
    assert_eq!(global_of(IF, [1, 0], op::CAPABILITY), [[1]]);
    assert_eq!(global_of(IF, [0, 0], op::CAPABILITY), [[1], [40]]);
    assert_eq!(global_of(IF, [1, 0], op::DECORATE), [[12, 30, 0], [14, 30, 0]]);
    assert_eq!(global_of(IF, [1, 0], op::TYPE_IMAGE), Vec::<Vec<u32>>::new());
    assert_eq!(global_of(IF, [1, 0], op::SPEC_CONSTANT_FALSE), Vec::<Vec<u32>>::new());
    // Without values, the defaults.
    let defaults = pruned(&assembled(IF), &Specialization::default(), None).unwrap();
    assert_eq!(defaults, pruned(&assembled(IF), &constants([0, 0]), None).unwrap());
}

#[test]
fn conditions_are_folded_through_logic_and_phis() {
    // The way `SPEC && x < 1` is compiled, and a select that needs no branch.
    let body = "
        Label 50
        LogicalNot 4 70 7
        SelectionMerge 52 0
        BranchConditional 7 51 52
        Label 51
        Load 6 60 14
        FOrdLessThan 4 61 60 9
        Branch 52
        Label 52
        Phi 4 62 7 50 61 51
        LogicalAnd 4 63 62 62
        IEqual 4 64 8 16
        LogicalAnd 4 65 63 64
        Select 6 66 70 9 10
        SelectionMerge 54 0
        BranchConditional 65 53 54
        Label 53
        Store 12 66
        Branch 54
        Label 54
        Return";
    assert_eq!(left_of(body, [0, 1]), "Label 50; Branch 52; Label 52; Branch 54; Label 54; Return");
    assert_eq!(
        left_of(body, [1, 1]),
        "Label 50; Branch 51; Label 51; Load 6 60 14; FOrdLessThan 4 61 60 9; Branch 52; Label 52; \
         LogicalAnd 4 63 61 61; SelectionMerge 54 0; BranchConditional 63 53 54; Label 53; Store 12 10; \
         Branch 54; Label 54; Return"
    );
    assert!(!left_of(body, [1, 0]).contains("Store"));
}

/// A function with an early return, as the optimiser writes it: a switch that is left from a selection within.
fn early_return(condition: u32) -> String {
    format!(
        "
        Label 50
        Load 6 60 14
        FOrdLessThan 4 61 60 9
        SelectionMerge 59 0
        Switch 15 51
        Label 51
        SelectionMerge 53 0
        BranchConditional {condition} 52 53
        Label 52
        Store 12 9
        Branch 59
        Label 53
        Store 12 10
        Branch 59
        Label 59
        Return"
    )
}

#[test]
fn a_selection_stays_where_others_are_left_through_it() {
    let dynamic = left_of(&early_return(61), [0, 0]);
    assert!(dynamic.contains("SelectionMerge 59 0; Switch 15 51"), "{dynamic}");
    let fixed = left_of(&early_return(7), [1, 0]);
    assert_eq!(
        fixed,
        "Label 50; Branch 51; Label 51; Branch 52; Label 52; Store 12 9; Branch 59; Label 59; Return"
    );
}

#[test]
fn switches_take_their_case() {
    let body = "
        Label 50
        SelectionMerge 54 0
        Switch 8 51 1 52 2 53
        Label 51
        Branch 54
        Label 52
        Branch 53
        Label 53
        Phi 6 60 9 52 10 50
        Store 12 60
        Branch 54
        Label 54
        Return";
    assert_eq!(left_of(body, [0, 7]), "Label 50; Branch 51; Label 51; Branch 54; Label 54; Return");
    let fallen =
        "Label 50; Branch 52; Label 52; Branch 53; Label 53; Store 12 9; Branch 54; Label 54; Return";
    assert_eq!(left_of(body, [0, 1]), fallen);
    let second = "Label 50; Branch 53; Label 53; Store 12 10; Branch 54; Label 54; Return";
    assert_eq!(left_of(body, [0, 2]), second);
}

#[test]
fn loops_keep_their_shape() {
    let body = "
        Label 50
        Branch 51
        Label 51
        Phi 5 60 15 50 61 54
        LoopMerge 55 54 0
        Branch 52
        Label 52
        IEqual 4 62 60 16
        BranchConditional 7 55 53
        Label 53
        BranchConditional 62 55 54
        Label 54
        IAdd 5 61 60 16
        Branch 51
        Label 55
        Store 12 9
        Return";
    assert!(left_of(body, [0, 0]).contains("Phi 5 60 15 50 61 54; LoopMerge 55 54 0"));
    assert_eq!(
        left_of(body, [1, 0]),
        "Label 50; Branch 51; Label 51; LoopMerge 55 54 0; Branch 52; Label 52; Branch 55; \
         Label 54; Branch 51; Label 55; Store 12 9; Return"
    );
}

#[test]
fn merge_blocks_that_are_not_reached_stay_with_their_header() {
    let body = "
        Label 50
        Load 6 60 14
        FOrdLessThan 4 61 60 9
        SelectionMerge 54 0
        BranchConditional 61 51 52
        Label 51
        Kill
        Label 52
        SelectionMerge 55 0
        BranchConditional 7 53 55
        Label 53
        Kill
        Label 55
        Branch 54
        Label 54
        Store 12 9
        Return";
    assert!(left_of(body, [0, 0]).contains("Label 54; Store"));
    let killed = left_of(body, [1, 0]);
    assert!(killed.ends_with("Label 54; Unreachable"), "{killed}");
    assert!(!killed.contains("Label 55"), "{killed}");
}

#[test]
fn what_is_stored_and_never_read_goes() {
    let body = |read: &str| {
        format!(
            "
            Label 50
            Variable 18 70 7
            Load 6 60 14
            Store 70 60
            Load 6 61 70
            {read}
            Return"
        )
    };
    assert_eq!(left_of(&body(""), [0, 0]), "Label 50; Return");
    assert!(left_of(&body("Store 12 61"), [0, 0]).contains("Store 70 60"));
}

#[test]
fn outputs_that_are_not_read_take_their_inputs_with_them() {
    let body = "Label 50; Load 6 60 14; Store 12 60; Return";
    let left = |read: &[u32]| {
        let read = read.iter().copied().collect();
        pruned(&assembled(&body.replace(';', "\n")), &constants([0, 0]), Some(&read)).unwrap()
    };
    let (read, unread) = (left(&[0]), left(&[1]));
    assert_eq!((read.inputs.len(), unread.inputs.len()), (1, 0));
    assert_eq!(Module::read(&unread.spirv).unwrap().functions[0].blocks[0].body, []);
    validate(&unread.spirv);
}

#[test]
fn bad_modules_are_errors() {
    let good = assembled(IF);
    assert!(prune("good", &good, &Specialization::default(), None).is_ok());
    let problem = |words: &[u32]| {
        pruned(words, &Specialization::default(), None).map_err(|Malformed(p)| p).unwrap_err()
    };
    let changed = |from: &str, to: &str| problem(&assembled(&IF.replace(from, to)));
    assert!(problem(&[]).contains("does not begin"));
    assert!(problem(&good[..good.len() - 1]).contains("within a function"));
    assert!(problem(&good[..good.len() - 3]).contains("longer than the module"));
    assert!(changed("Branch 53", "Branch 99").contains("99, which is no block"));
    assert!(changed("Load 6 60 14", "Load 6 60 100").contains("id 100"));
    assert!(changed("Load 6 60 14", "Load 6 60 0").contains("id 0"));
    assert!(changed("Load 6 60 14", "Load 6 9 14").contains("defined twice"));
    assert!(changed("Load 6 60 14", "Load 6").contains("with 1 operands"));
    assert!(changed("Return", "").contains("does not end"));
    assert!(changed("Label 50", "").contains("outside of a block"));
    let mut wide = good.clone();
    wide[3] = u32::MAX;
    assert!(problem(&wide).contains("ids up to"));
    let text = prune("zeros", &[0; 9], &Specialization::default(), None).unwrap_err().to_string();
    assert!(text.contains("'zeros'") && text.contains("tools/shaders"), "{text}");
}

proptest! {
    /// Whatever words a module has, it is an error at worst.
    #[test]
    fn no_module_makes_it_panic(
        which in 0..Shader::ALL.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), prop_oneof![0..300_u32, any::<u32>()]), 1..4),
        value in 0..4_u32,
    ) {
        let mut words = Shader::ALL[which].spirv().unwrap().to_vec();
        for (at, word) in changes {
            let at = at.index(words.len());
            words[at] = word;
        }
        let ids = (0..64).collect();
        let _ = prune("changed", &words, &Specialization { ids, data: vec![value; 64] }, None);
    }
}

// SPDX-License-Identifier: Apache-2.0
//! Reactions to `shutdown` in modes that have been left run together with the reactions of the active mode, and their
//! order is the program's, not that of levels.

use std::collections::BTreeMap;

use lf_compiler::plan::Plan;
use lf_compiler::{Style, compile};

/// Returns the plan of a program with a reactor `F` and one that sends to it.
fn plan(f: &str, kind: &str) -> Result<Plan, String> {
    let text = format!(
        "target Rust\n\
         reactor Source {{ output x: u32 reaction(shutdown) -> x {{= =}} }}\n\
         reactor C {{ input i: u32 output o: u32 reaction(i) -> o {{= =}} }}\n\
         reactor Through {{ input i: u32 output o: u32 i -> o }}\n\
         {f}\n\
         {kind} reactor {{ s = new Source() f = new F() s.x -> f.x }}\n"
    );
    let files = BTreeMap::from([("T.lf".to_owned(), text)]);
    let compilation = compile("T.lf", &files);
    compilation.plan.ok_or_else(|| compilation.diagnostics.render(Style::Plain))
}

/// Returns such a plan in which the outputs of `f` come back to it.
fn plan_around(f: &str, kind: &str) -> Result<Plan, String> {
    let text = format!(
        "target Rust\nreactor Through {{ input i: u32 output o: u32 i -> o }}\n{f}\n\
         {kind} reactor {{ t = new Through() f = new F() f.z -> t.i t.o -> f.y }}\n"
    );
    let files = BTreeMap::from([("T.lf".to_owned(), text)]);
    let compilation = compile("T.lf", &files);
    compilation.plan.ok_or_else(|| compilation.diagnostics.render(Style::Plain))
}

/// Returns the order in which the steps of `f` run, federated; unfederated it has to be the same. The order within a
/// level is undefined, so no two steps may share a level.
fn order(f: &str) -> Vec<String> {
    let names = |kind: &str| -> Vec<String> {
        let plan = plan(f, kind).unwrap_or_else(|error| panic!("{error}"));
        let reactions = plan.federates.last().expect("there is one").reactions.iter();
        let of_f: Vec<_> = reactions.filter(|it| it.name.starts_with("f.") && !it.name.starts_with("f.c.")).collect();
        assert!(of_f.windows(2).all(|pair| pair[0].level < pair[1].level), "{of_f:#?}");
        of_f.iter().map(|it| it.name.clone()).collect()
    };
    assert_eq!(names("federated"), names("main"));
    names("main")
}

#[test]
fn they_follow_each_other_as_declared() {
    let before = "reactor F { input x: u32 timer t(0, 1 ms)
        initial mode A { reaction(t) -> B {= =} reaction(shutdown) {= =} }
        mode B { reaction(x) {= =} } }";
    assert_eq!(order(before), ["f.reaction_1", "f.reaction_2", "f.reaction_3"]);
    let behind = "reactor F { input x: u32 timer t(0, 1 ms)
        mode B { reaction(x) {= =} }
        initial mode A { reaction(t) -> B {= =} reaction(shutdown) {= =} } }";
    let plan = plan(behind, "main").expect("it compiles");
    let level = |name: &str| plan.federates[0].reactions.iter().find(|it| it.name == name).map(|it| it.level);
    // The first two never run at one tag.
    assert!(level("f.reaction_1") < level("f.reaction_3") && level("f.reaction_2") < level("f.reaction_3"));
}

/// A mode drives a contained reactor whose output another one reads, and which is declared before it.
#[test]
fn data_flow_comes_before_declaration() {
    let driven = "reactor F { input x: u32 c = new C()
        initial mode A { reaction(c.o) -> B {= =} }
        mode B { reaction(shutdown) -> c.i {= =} } }";
    assert_eq!(order(driven), ["f.reaction_2", "f.reaction_1"]);
    let shared = "reactor F { input x: u32 c = new C()
        initial mode A { reaction(c.o) -> B {= =} reaction(shutdown) {= =} }
        mode B { reaction(x) -> c.i {= =} } }";
    assert_eq!(order(shared), ["f.reaction_3", "f.reaction_1", "f.reaction_2"]);
}

/// Reactions of other modes also see a value that reaches a port through connections alone.
#[test]
fn a_port_is_set_before_it_is_read_at_the_last_tag() {
    let through = "reactor F { input x: u32 c = new Through()
        initial mode A { reaction(c.o) -> B {= =} }
        mode B { reaction(shutdown) -> c.i {= =} } }";
    assert_eq!(order(through), ["f.reaction_2", "f.reaction_1"]);
}

#[test]
fn a_connection_of_the_active_mode_sets_a_port_last() {
    let both = "reactor F { input x: u32 output o: u32
        initial mode A { reaction(shutdown) -> o, B {= =} }
        mode B { x -> o } }";
    assert_eq!(order(both), ["f.reaction_1", "f.x -> f.o"]);
}

/// Federated, the mode at the time of sending is unknown when a message comes back, and unfederated the rule is the
/// same.
#[test]
fn a_value_that_comes_back_through_other_federates_is_data_flow() {
    let f = "reactor F { input x: u32 input y: u32 output z: u32
        initial mode A { reaction(y) -> B {= =} }
        mode B { reaction(shutdown) {= =} reaction(x) -> z {= =} } }";
    let names = |kind: &str| -> Vec<String> {
        let plan = plan_around(f, kind).unwrap_or_else(|error| panic!("{error}"));
        let reactions = plan.federates.iter().flat_map(|federate| &federate.reactions);
        reactions.filter(|it| it.name.starts_with("f.reaction")).map(|it| it.name.clone()).collect()
    };
    for kind in ["federated", "main"] {
        let place = |name: &str| names(kind).iter().position(|it| it == name);
        assert!(place("f.reaction_2") < place("f.reaction_1"), "{kind}");
        assert!(place("f.reaction_2") < place("f.reaction_3"), "{kind}");
    }
}

/// Each of two reactions writes a port that the other one reads at the last tag.
#[test]
fn reactions_that_wait_for_each_other_at_the_last_tag_are_refused() {
    let loops = "reactor F { input x: u32 c = new Through() d = new Through()
        initial mode A { reaction(d.o) -> c.i, B {= =} }
        mode B { reaction(shutdown) c.o -> d.i {= =} } }";
    let error = plan(loops, "main").expect_err("it is a loop");
    assert!(error.contains("these reactions wait for each other at the same time"), "{error}");
}

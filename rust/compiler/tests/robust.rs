// SPDX-License-Identifier: Apache-2.0
//! The compiler ends without a panic for any text, and every plan is valid.

use std::collections::BTreeMap;

use lf_compiler::plan::{Argument, Federate, Plan, ReactionKind, TriggerKind};
use lf_compiler::{Style, compile};
use proptest::prelude::*;

const PROGRAMS: &[&str] = &[
    include_str!("plans/hello.lf"),
    include_str!("plans/hierarchy.lf"),
    include_str!("plans/federation.lf"),
    include_str!("plans/older_forms.lf"),
    include_str!("plans/c_bodies.lf"),
    include_str!("grammar.lf"),
];

fn files(main: String) -> BTreeMap<String, String> {
    let parts = include_str!("plans/lib/parts.lf").to_owned();
    BTreeMap::from([("main.lf".to_owned(), main), ("lib/parts.lf".to_owned(), parts)])
}

/// Compiles, renders the diagnostics, and checks the plan if there is one.
fn compile_and_check(main: String) -> bool {
    let compilation = compile("main.lf", &files(main));
    let said = compilation.diagnostics.render(Style::Plain);
    assert_eq!(compilation.plan.is_none(), compilation.diagnostics.has_errors(), "{said}");
    if let Some(plan) = &compilation.plan {
        check(plan);
    }
    compilation.plan.is_some()
}

/// Asserts that every index is in range, and that every reaction follows those that write its inputs.
fn check(plan: &Plan) {
    for federate in &plan.federates {
        check_reactions(plan, federate);
        check_triggers(federate);
        for output in &federate.outputs {
            let receiver = &plan.federates[usize::from(output.federate)];
            let input = &receiver.inputs[receiver.input_of(output.port).expect("an input has this port").0];
            assert_eq!((usize::from(input.federate), input.delay_ns), (usize::from(federate.id), output.delay_ns));
            assert_eq!(input.name, output.name);
            assert!(receiver.upstream.iter().any(|upstream| upstream.federate == federate.id));
            assert!(federate.downstream.contains(&output.federate));
        }
    }
}

fn check_reactions(plan: &Plan, federate: &Federate) {
    let mut written = vec![None; federate.ports.len()];
    let mut level = 0;
    for (position, reaction) in federate.reactions.iter().enumerate() {
        assert!(reaction.level >= level, "levels do not fall");
        level = reaction.level;
        match &reaction.kind {
            ReactionKind::Send(output) => {
                let source = federate.outputs[output.0].source.0;
                assert!(written[source].is_none_or(|writer| writer < reaction.level));
                assert!(federate.ports[source].reactions.iter().any(|it| it.0 == position));
            }
            ReactionKind::Copy { from, to } => {
                assert!(written[from.0].is_none_or(|writer| writer < reaction.level));
                written[to.0] = written[to.0].max(Some(reaction.level));
                assert!(federate.ports[from.0].reactions.iter().any(|it| it.0 == position));
            }
            // Reactions in different modes need no order.
            ReactionKind::Body { .. } if reaction.mode.is_some() => {}
            ReactionKind::Body { instance, reaction: number, arguments } => {
                let class = plan.class(&federate.instances[instance.0]);
                let declared = &class.reactions[number - 1];
                assert_eq!(declared.parameters.len(), arguments.len());
                for (parameter, argument) in declared.parameters.iter().zip(arguments) {
                    if let Argument::Trigger(trigger) = argument {
                        assert!(trigger.0 < federate.triggers.len());
                    }
                    for port in argument.ports() {
                        if parameter.effect {
                            written[port.0] = written[port.0].max(Some(reaction.level));
                            let readers = &federate.ports[port.0].reactions;
                            assert!(readers.iter().all(|reader| reader.0 > position), "written before it is read");
                        } else {
                            assert!(written[port.0].is_none_or(|writer| writer < reaction.level));
                        }
                    }
                }
            }
        }
    }
    for port in &federate.ports {
        assert!(port.reactions.is_sorted_by(|a, b| a.0 < b.0));
    }
}

fn check_triggers(federate: &Federate) {
    for (position, trigger) in federate.triggers.iter().enumerate() {
        assert!(trigger.capacity >= 1);
        assert!(trigger.reactions.is_sorted_by(|a, b| a.0 < b.0));
        assert!(trigger.reactions.iter().all(|reaction| reaction.0 < federate.reactions.len()));
        match trigger.kind {
            TriggerKind::Delay { source, fills, delay_ns, .. } => {
                assert!(delay_ns >= 0 && fills.0 < federate.ports.len());
                assert!(federate.ports[source.0].delays.iter().any(|delay| delay.0 == position));
            }
            TriggerKind::NetworkInput { input, fills } => {
                assert!(fills.0 < federate.ports.len());
                assert_eq!(federate.inputs[input.0].trigger.0, position);
            }
            _ => {}
        }
    }
}

const WORDS: &[&str] = &[
    "after 0",
    "after 1 ms",
    "",
    " ",
    "\n",
    "a",
    "b",
    "c",
    "x",
    "in",
    "out",
    "t",
    "1",
    "0",
    "s",
    "i32",
    "time",
    "{= =}",
    "{",
    "}",
    "(",
    ")",
    "->",
    "~>",
    ",",
    ".",
    ":",
    "=",
    "\"",
    "@capacity(3)",
    "new",
    "reactor",
    "main",
    "federated",
    "reaction",
    "input",
    "output",
    "state",
    "timer",
    "é",
];

proptest! {
    #[test]
    fn mutated_programs_compile_or_are_refused(
        program in proptest::sample::select(PROGRAMS),
        changes in proptest::collection::vec(
            (any::<prop::sample::Index>(), 0_usize..8, proptest::sample::select(WORDS)), 0..4
        ),
    ) {
        let mut text: Vec<char> = program.chars().collect();
        for (at, length, word) in changes {
            let at = at.index(text.len());
            let end = (at + length).min(text.len());
            text.splice(at..end, word.chars());
        }
        compile_and_check(text.into_iter().collect());
    }

    #[test]
    fn random_networks_have_sound_plans(network in network()) {
        compile_and_check(network);
    }
}

/// Returns instances of a few reactors, connected at random; half of the connections are delayed.
fn network() -> impl Strategy<Value = String> {
    let connection = (0_usize..6, 0_usize..6, 0_usize..2, proptest::option::of(0_u32..30));
    let nodes = proptest::collection::vec(proptest::sample::select(&["Source", "Pass", "Relay", "Group"][..]), 6);
    (any::<bool>(), nodes, proptest::collection::vec(connection, 0..8)).prop_map(|(federated, nodes, connections)| {
        let mut lines = vec![NODES.to_owned()];
        lines.push(if federated { "federated reactor {" } else { "main reactor {" }.to_owned());
        lines.extend(nodes.iter().enumerate().map(|(index, kind)| format!("n{index} = new {kind}()")));
        lines.extend(connections.into_iter().map(|(from, to, input, delay)| {
            let after = delay.map_or_else(String::new, |delay| format!(" after {delay} ms"));
            format!("@capacity(9) n{from}.out -> n{to}.in{input}{after}")
        }));
        lines.push("}".to_owned());
        lines.join("\n")
    })
}

const NODES: &str = "target Rust
reactor Source { input in0: i32 input in1: i32 output out: i32 timer t(0, 1 ms)
  reaction(t) -> out {= =} reaction(in0) in1 {= =} }
reactor Pass { input in0: i32 input in1: i32 output out: i32 in0 -> out reaction(in1) {= =} }
reactor Relay { input in0: i32 input in1: i32 output out: i32 logical action a(1 ms, 1 ms): i32
  reaction(in0) -> a {= =} reaction(a, in1) -> out {= =} }
reactor Group { input in0: i32 input in1: i32 output out: i32 inner = new Relay() pass = new Pass()
  in0, in1, pass.out, inner.out -> inner.in0, pass.in0, inner.in1, out reaction(inner.out) pass.out {= =} }
";

#[test]
fn the_random_networks_are_not_all_refused() {
    let main = "main reactor { n0 = new Source() n1 = new Group() n0.out -> n1.in0 n1.out -> n0.in1 after 3 ms }";
    assert!(compile_and_check(format!("{NODES}{main}")));
}

#[test]
fn a_long_chain_of_reactors_ends() {
    let chain = (0..3000).map(|index| format!("reactor R{index} {{ r = new R{}() }}", index + 1));
    let lines: Vec<_> = chain.collect();
    let text = format!("target Rust\nmain reactor {{ r = new R0() }}\n{}\nreactor R3000 {{ }}", lines.join("\n"));
    assert!(!compile_and_check(text));
}

#[test]
fn a_tree_that_doubles_at_each_level_ends() {
    let tree = (0..60).map(|index| format!("reactor R{index} {{ a = new R{0}() b = new R{0}() }}", index + 1));
    let lines: Vec<_> = tree.collect();
    let text = format!("target Rust\nmain reactor {{ r = new R0() }}\n{}\nreactor R60 {{ }}", lines.join("\n"));
    assert!(!compile_and_check(text));
}

#[test]
fn a_long_chain_of_connections_ends() {
    let after = |index: usize| if index.is_multiple_of(9) { " after 1 ms" } else { "" };
    let instances = (0..5000).map(|index| format!("  p{index} = new P()"));
    let connections = (1..5000).map(|index| format!("  @capacity(2) p{}.y -> p{index}.x{}", index - 1, after(index)));
    let lines: Vec<_> = instances.chain(connections).collect();
    let node = "reactor P { input x: i32 output y: i32 reaction(x) -> y {= =} }";
    assert!(compile_and_check(format!("target Rust\n{node}\nmain reactor {{\n{}\n}}", lines.join("\n"))));
}

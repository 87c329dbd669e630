// SPDX-License-Identifier: Apache-2.0
//! Multiports and banks have the same meaning as the program with every channel and member written out.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use lf_compiler::plan::{Argument, Plan, ReactionKind, TriggerKind};
use lf_compiler::{Style, compile};
use proptest::prelude::*;

/// An instance, or a bank of them, with an input and an output of this width.
#[derive(Clone, Debug)]
struct Node {
    members: Option<usize>,
    width: Option<usize>,
    /// The connection to its input, if there is one.
    input: Option<Connection>,
}

#[derive(Clone, Debug)]
struct Connection {
    /// Earlier nodes, each with whether it is interleaved.
    left: Vec<(usize, bool)>,
    right_interleaved: bool,
    iterated: bool,
    delayed: bool,
}

fn program() -> impl Strategy<Value = Vec<Node>> {
    let width = || prop::option::of(1..4_usize);
    let connection = || {
        let left = prop::collection::vec((any::<prop::sample::Index>(), any::<bool>()), 1..4);
        (left, any::<bool>(), any::<bool>(), prop::bool::weighted(0.3))
    };
    prop::collection::vec((width(), width(), prop::option::weighted(0.8, connection())), 2..6).prop_map(|nodes| {
        let nodes = nodes.into_iter().enumerate().map(|(position, (members, width, input))| {
            let input = input.filter(|_| position > 0).map(|(left, right_interleaved, iterated, delayed)| Connection {
                left: left.into_iter().map(|(node, interleaved)| (node.index(position), interleaved)).collect(),
                right_interleaved,
                iterated,
                delayed,
            });
            // A mismatch of single ports is an error, and not only a warning.
            let width = width.or(members.is_none().then_some(1));
            Node { members, width, input }
        });
        nodes.collect()
    })
}

/// Returns the program with multiports and banks; some widths are parameters of the main reactor.
fn wide(nodes: &[Node]) -> String {
    let mut text = "target Rust\n".to_owned();
    for (index, node) in nodes.iter().enumerate() {
        let width = if node.width.is_some() { "[width]" } else { "" };
        let _ = writeln!(text, "reactor N{index}(width: usize = 1) {{");
        let _ = writeln!(text, "  input{width} x: u32\n  output{width} y: u32\n  timer t(0, 1 s)");
        let _ = writeln!(text, "  reaction(x, t) -> y {{= =}}\n}}");
    }
    text.push_str("main reactor(three: usize = 3) {\n");
    for (index, node) in nodes.iter().enumerate() {
        let number = |number: usize| if number == 3 { "three".to_owned() } else { number.to_string() };
        let bank = node.members.map_or(String::new(), |members| format!("[{}]", number(members)));
        let _ = writeln!(text, "  n{index} = new{bank} N{index}(width = {})", number(node.width.unwrap_or(1)));
    }
    let end = |node: usize, port: &str, interleaved: bool| {
        if interleaved { format!("interleaved(n{node}.{port})") } else { format!("n{node}.{port}") }
    };
    for (index, node) in nodes.iter().enumerate() {
        let Some(connection) = &node.input else { continue };
        let left: Vec<_> = connection.left.iter().map(|(node, interleaved)| end(*node, "y", *interleaved)).collect();
        let left = if connection.iterated { format!("({})+", left.join(", ")) } else { left.join(", ") };
        let after = if connection.delayed { " after 5 ms" } else { "" };
        let capacity = if connection.delayed { "@capacity(99) " } else { "" };
        let _ = writeln!(text, "  {capacity}{left} -> {}{after}", end(index, "x", connection.right_interleaved));
    }
    text + "}\n"
}

/// Returns the names of all channels of a node's port, in the order in which connections take them.
fn channels(node: &Node, index: usize, port: &str, interleaved: bool) -> Vec<String> {
    let name = |member: usize, channel: usize| {
        let member = node.members.map_or(String::new(), |_| format!("_{member}"));
        let channel = node.width.map_or(String::new(), |_| format!("_{channel}"));
        format!("n{index}{member}.{port}{channel}")
    };
    let (members, width) = (node.members.unwrap_or(1), node.width.unwrap_or(1));
    let mut names = Vec::new();
    if interleaved {
        (0..width).for_each(|channel| names.extend((0..members).map(|member| name(member, channel))));
    } else {
        (0..members).for_each(|member| names.extend((0..width).map(|channel| name(member, channel))));
    }
    names
}

/// Returns the same program with everything written out.
fn narrow(nodes: &[Node]) -> String {
    let mut text = "target Rust\n".to_owned();
    let mut main = String::new();
    for (index, node) in nodes.iter().enumerate() {
        let names = |port: &str| match node.width {
            Some(width) => (0..width).map(|channel| format!("{port}_{channel}")).collect::<Vec<_>>(),
            None => vec![port.to_owned()],
        };
        let _ = writeln!(text, "reactor N{index} {{\n  timer t(0, 1 s)");
        for (word, port) in [("input", "x"), ("output", "y")] {
            for name in names(port) {
                let _ = writeln!(text, "  {word} {name}: u32");
            }
        }
        let _ = writeln!(text, "  reaction({}, t) -> {} {{= =}}\n}}", names("x").join(", "), names("y").join(", "));
        let members = node.members.map_or(vec![String::new()], |count| (0..count).map(|at| format!("_{at}")).collect());
        for member in members {
            let _ = writeln!(main, "  n{index}{member} = new N{index}()");
        }
    }
    for (index, node) in nodes.iter().enumerate() {
        let Some(connection) = &node.input else { continue };
        let mut left = Vec::new();
        for (from, interleaved) in &connection.left {
            left.extend(channels(&nodes[*from], *from, "y", *interleaved));
        }
        for (position, to) in channels(node, index, "x", connection.right_interleaved).iter().enumerate() {
            let from = if connection.iterated { left.get(position % left.len()) } else { left.get(position) };
            let Some(from) = from else { continue };
            let (before, after) = if connection.delayed { ("@capacity(99) ", " after 5 ms") } else { ("", "") };
            let _ = writeln!(main, "  {before}{from} -> {to}{after}");
        }
    }
    text + "main reactor {\n" + &main + "}\n"
}

/// Returns the part of a plan that has to be the same: of each reaction its level and its ports, the ports that trigger
/// it, and all connections with a delay.
fn meaning(program: &str) -> BTreeSet<String> {
    let sources = BTreeMap::from([("Main.lf".to_owned(), program.to_owned())]);
    let compilation = compile("Main.lf", &sources);
    let plan: Plan =
        compilation.plan.unwrap_or_else(|| panic!("{}\n{program}", compilation.diagnostics.render(Style::Plain)));
    let federate = &plan.federates[0];
    let normal = |path: &str| path.replace('[', "_").replace(']', "");
    let port = |index: usize| normal(&federate.ports[index].path);
    let mut meaning = BTreeSet::new();
    for (position, reaction) in federate.reactions.iter().enumerate() {
        let ReactionKind::Body { arguments, .. } = &reaction.kind else { continue };
        let ports: Vec<_> = arguments.iter().flat_map(Argument::ports).map(|index| port(index.0)).collect();
        let triggers = |one: &lf_compiler::plan::Port| one.reactions.iter().any(|index| index.0 == position);
        let triggers: Vec<_> = federate.ports.iter().filter(|one| triggers(one)).map(|one| normal(&one.path)).collect();
        meaning.insert(format!("{} {} {ports:?} {triggers:?}", reaction.level, normal(&reaction.name)));
    }
    for trigger in &federate.triggers {
        if let TriggerKind::Delay { source, fills, delay_ns, .. } = &trigger.kind {
            meaning.insert(format!("{} -> {} after {delay_ns}", port(source.0), port(fills.0)));
        }
    }
    meaning
}

proptest! {
    #[test]
    fn every_channel_is_connected_as_if_it_were_written_out(nodes in program()) {
        let (wide, narrow) = (wide(&nodes), narrow(&nodes));
        prop_assert_eq!(meaning(&wide), meaning(&narrow), "\n{}\n{}", wide, narrow);
    }
}

// SPDX-License-Identifier: Apache-2.0
//! The connections between federates, numbered at both ends.
//!
//! The numbers are part of the wire protocol: a message names the port of its receiver by its number, so they have to
//! equal those of LF's own compiler.

use std::collections::BTreeSet;

use super::graph::{Graph, Link, LinkId, Node};
use crate::arena::Arena;
use crate::instances::InstanceId;
use crate::resolve::Variable;
use crate::syntax::ast::Direction;

/// The connections that leave and enter each federate, by their positions in the graph.
#[derive(Debug)]
pub(super) struct NetworkPorts {
    /// Per federate, in the order of connections.
    pub(super) outputs: Vec<Vec<LinkId>>,
    /// Per federate, in the order of their port numbers on the wire.
    pub(super) inputs: Vec<Vec<LinkId>>,
    /// Per federate, ascending: the port numbers between those of the inputs that belong to connections from the
    /// federate to itself.
    pub(super) own_ports: Vec<Vec<u16>>,
    /// Per connection of the graph: whether values are sent over it.
    pub(super) used: Arena<LinkId, bool>,
}

/// Numbers the connections between federates. A connection without a writer or a reader has no number, because no value
/// is sent.
///
/// A receiver's connections are numbered by their sending federates, then by the declarations of the sending ports,
/// then by the text. Connections from a federate to itself count, though in this runtime they do not leave it.
pub(super) fn number(graph: &Graph<'_>) -> NetworkPorts {
    let (uses, count) = (Uses::of(graph), graph.program.parts.list.len());
    let mut network = NetworkPorts {
        outputs: vec![Vec::new(); count],
        inputs: vec![Vec::new(); count],
        own_ports: vec![Vec::new(); count],
        used: graph.links.values().map(|link| link.network && uses.is_used(link)).collect(),
    };
    for (position, link) in graph.links.iter() {
        let is_own = !link.network && uses.is_between_federates(link) && uses.is_used(link);
        // LF's own compiler sees no readers behind a delay, and gives such a connection no number.
        let is_numbered = network.used[position] || is_own && !uses.is_read_late(link);
        if let Some(part) = graph.part(link.from).filter(|_| network.used[position]) {
            network.outputs[part].push(position);
        }
        if let Some(part) = graph.part(link.to).filter(|_| is_numbered) {
            network.inputs[part].push(position);
        }
    }
    for (inputs, own_ports) in network.inputs.iter_mut().zip(&mut network.own_ports) {
        inputs.sort_by_key(|position| {
            let link = &graph.links[*position];
            (uses.is_read_late(link), graph.part(link.from), graph.port_of(link.from), *position)
        });
        let is_own = |position: LinkId| !graph.links[position].network;
        let last = inputs.iter().rposition(|position| !is_own(*position)).unwrap_or_default();
        own_ports.extend((0..).zip(&inputs[..last]).filter(|(_, position)| is_own(**position)).map(|(port, _)| port));
        inputs.retain(|position| !is_own(*position));
    }
    network
}

/// A declared port of a federate, with all its channels and for all members of a bank: the position of the instance in
/// the federated reactor, and that of the port in its class.
type Declared = (Option<usize>, usize);

/// The ports of federates that have reactions before or behind them, in the same federate or beyond other ones.
struct Uses<'a> {
    graph: &'a Graph<'a>,
    written: BTreeSet<Declared>,
    read: BTreeSet<Declared>,
    /// Those of them that are read without a delay on the way.
    read_at_once: BTreeSet<Declared>,
}

impl<'a> Uses<'a> {
    fn of(graph: &'a Graph<'a>) -> Self {
        let (written, read) = named(graph);
        let at_once = |link: &&Link| link.delay.is_none() && !link.physical;
        let forth: Vec<_> = graph.links.values().map(|link| (link.from, link.to)).collect();
        let back: Vec<_> = graph.links.values().map(|link| (link.to, link.from)).collect();
        let back_at_once: Vec<_> = graph.links.values().filter(at_once).map(|link| (link.to, link.from)).collect();
        let mut uses = Self { graph, written: BTreeSet::new(), read: BTreeSet::new(), read_at_once: BTreeSet::new() };
        uses.written = uses.declared(&reached(written, &forth));
        uses.read = uses.declared(&reached(read.clone(), &back));
        uses.read_at_once = uses.declared(&reached(read, &back_at_once));
        uses
    }

    /// Returns those of these ports that belong to federates.
    fn declared(&self, ports: &Arena<Node, bool>) -> BTreeSet<Declared> {
        let ports = ports.ids().filter(|node| ports[*node]);
        let of_federates = ports.filter(|node| {
            self.graph.program.tree.instances[self.graph.instance[*node]].parent == Some(InstanceId::MAIN)
        });
        of_federates.map(|node| self.declaration(node)).collect()
    }

    fn declaration(&self, node: Node) -> Declared {
        (self.graph.program.tree.instances[self.graph.instance[node]].child, self.graph.port_of(node))
    }

    /// Returns whether it is a connection of the federated reactor itself.
    fn is_between_federates(&self, link: &Link) -> bool {
        let instances = [link.from, link.to].map(|node| &self.graph.program.tree.instances[self.graph.instance[node]]);
        let source = self.graph.port(link.from);
        // A path through a federate begins at an input of it.
        instances.iter().all(|instance| instance.parent == Some(InstanceId::MAIN))
            && source.direction == Direction::Output
    }

    fn is_used(&self, link: &Link) -> bool {
        self.written.contains(&self.declaration(link.from)) && self.read.contains(&self.declaration(link.to))
    }

    fn is_read_late(&self, link: &Link) -> bool {
        !self.read_at_once.contains(&self.declaration(link.to))
    }
}

/// Returns the ports that reactions name: whether they write them, and whether they read them.
fn named(graph: &Graph<'_>) -> (Arena<Node, bool>, Arena<Node, bool>) {
    let (mut written, mut read) = (Arena::of(&graph.root, false), Arena::of(&graph.root, false));
    for (position, step) in graph.steps.iter() {
        let reaction = graph.reaction(position);
        for parameter in reaction.iter().flat_map(|reaction| &reaction.parameters) {
            let Variable::Port(port) = parameter.variable else { continue };
            let named = if parameter.effect { &mut written } else { &mut read };
            graph.nodes(step.instance, port).into_iter().for_each(|node| named[node] = true);
        }
    }
    (written, read)
}

/// Returns the nodes that are reachable over these steps, including the starting points.
fn reached(mut found: Arena<Node, bool>, steps: &[(Node, Node)]) -> Arena<Node, bool> {
    let mut next: Arena<Node, Vec<Node>> = Arena::of(&found, Vec::new());
    for (from, to) in steps {
        next[*from].push(*to);
    }
    let mut open: Vec<Node> = found.ids().filter(|node| found[*node]).collect();
    while let Some(at) = open.pop() {
        for to in &next[at] {
            if !std::mem::replace(&mut found[*to], true) {
                open.push(*to);
            }
        }
    }
    found
}

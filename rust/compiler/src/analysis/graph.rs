// SPDX-License-Identifier: Apache-2.0
//! The ports and reactions of all instances, and how they are joined.

use super::serializer;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::federates::Parts;
use crate::instances::Tree;
use crate::plan::Serializer;
use crate::resolve::{Class, PortRef, Variable};

/// A port of an instance, by its number in the whole program.
pub(super) type Node = usize;

/// A reaction of an instance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) instance: usize,
    /// Its position in the class.
    pub(super) reaction: usize,
}

/// A connection of two ports of instances.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) from: Node,
    pub(super) to: Node,
    /// Nanoseconds; none without `after`.
    pub(super) delay: Option<i64>,
    /// Whether the delay counts from physical time.
    pub(super) physical: bool,
    pub(super) capacity: Option<usize>,
    /// Whether it leaves a federate.
    pub(super) network: bool,
    /// `@maxwait` in nanoseconds.
    pub(super) max_wait: Option<i64>,
    /// `@absent_after` in nanoseconds.
    pub(super) absent_after: Option<i64>,
    /// How values become bytes, where it leaves a federate and the type alone does not say it.
    pub(super) serializer: Option<Serializer>,
    pub(super) span: Span,
}

impl Link {
    /// Whether the destination is the source's storage.
    fn is_alias(&self) -> bool {
        self.delay.is_none() && !self.network && !self.physical
    }

    /// Whether it carries messages with tags from federate to federate.
    pub(super) fn is_logical_network(&self) -> bool {
        self.network && !self.physical
    }

    /// Whether it has a queue of its own inside a federate.
    pub(super) fn is_delayed(&self) -> bool {
        !self.network && !self.is_alias()
    }
}

/// All ports, connections and reactions of a program.
#[derive(Debug)]
pub(super) struct Graph {
    /// The number of the first port of each instance.
    base: Vec<usize>,
    /// The instance of each port.
    pub(super) instance: Vec<usize>,
    /// All connections, in the order of the text within each container.
    pub(super) links: Vec<Link>,
    /// The connection into each port.
    pub(super) into: Vec<Option<usize>>,
    /// The port whose storage each port uses.
    pub(super) root: Vec<Node>,
    /// All reactions, in order of instances and then of declaration.
    pub(super) steps: Vec<Step>,
    /// Per storing port: the reactions that write it.
    pub(super) writers: Vec<Vec<usize>>,
    /// Per storing port: the reactions that read it, each with whether it triggers them.
    pub(super) readers: Vec<Vec<(usize, bool)>>,
}

impl Graph {
    /// Joins everything. Nothing if connections alone form a cycle.
    pub(super) fn build(
        classes: &[Class<'_>],
        tree: &Tree,
        parts: &Parts,
        diagnostics: &mut Diagnostics,
    ) -> Option<Self> {
        let mut graph = Self {
            base: Vec::new(),
            instance: Vec::new(),
            links: Vec::new(),
            into: Vec::new(),
            root: Vec::new(),
            steps: Vec::new(),
            writers: Vec::new(),
            readers: Vec::new(),
        };
        for (position, instance) in tree.instances.iter().enumerate() {
            graph.base.push(graph.instance.len());
            graph.instance.extend(classes[instance.class.0].ports.iter().map(|_| position));
        }
        graph.link(classes, tree, parts, diagnostics);
        graph.alias(classes, tree, diagnostics)?;
        graph.place_reactions(classes, tree);
        Some(graph)
    }

    /// The port that a reactor's reference means in an instance of it.
    pub(super) fn node(&self, tree: &Tree, instance: usize, port: PortRef) -> Node {
        match port {
            PortRef::Own(port) => self.base[instance] + port,
            PortRef::Child(child, port) => self.base[tree.instances[instance].children[child]] + port,
        }
    }

    /// The position of a port in its class.
    pub(super) fn port_of(&self, node: Node) -> usize {
        node - self.base[self.instance[node]]
    }

    /// The path of a port: `unit_a.sensor.voltage`.
    pub(super) fn path(&self, node: Node, tree: &Tree, classes: &[Class<'_>]) -> String {
        let instance = &tree.instances[self.instance[node]];
        let name = &classes[instance.class.0].ports[self.port_of(node)].name.text;
        format!("{}.{name}", instance.path)
    }

    fn link(&mut self, classes: &[Class<'_>], tree: &Tree, parts: &Parts, diagnostics: &mut Diagnostics) {
        self.into = vec![None; self.instance.len()];
        for (position, instance) in tree.instances.iter().enumerate() {
            for connection in &classes[instance.class.0].connections {
                // A delay that is not known has been reported, and there will be no plan.
                let mut known = |value| tree.time(position, value, classes, diagnostics).unwrap_or_default();
                let delay = connection.after.map(&mut known);
                let max_wait = connection.max_wait.map(|wait| known(wait.value));
                let absent_after = connection.absent_after.map(|wait| known(wait.value));
                let from = self.node(tree, position, connection.from);
                let to = self.node(tree, position, connection.to);
                let network = parts.of[self.instance[from]] != parts.of[self.instance[to]];
                self.into[to] = Some(self.links.len());
                let (capacity, span) = (connection.capacity, connection.span);
                let physical = connection.physical;
                let port = |node: Node| &classes[tree.instances[self.instance[node]].class.0].ports[self.port_of(node)];
                let serializer =
                    network.then(|| serializer::of_connection(connection, port(from), port(to), diagnostics)).flatten();
                self.links.push(Link {
                    from,
                    to,
                    delay,
                    physical,
                    capacity,
                    network,
                    max_wait,
                    absent_after,
                    serializer,
                    span,
                });
            }
        }
    }

    /// Follows undelayed connections backwards to the port that stores the value.
    fn alias(&mut self, classes: &[Class<'_>], tree: &Tree, diagnostics: &mut Diagnostics) -> Option<()> {
        for node in 0..self.instance.len() {
            let mut root = node;
            let mut passed = Vec::new();
            while let Some(link) = self.into[root].map(|link| &self.links[link]).filter(|link| link.is_alias()) {
                if passed.contains(&link.from) {
                    let start = passed.iter().position(|node| *node == link.from).unwrap_or_default();
                    let mut names: Vec<_> = passed[start..].iter().map(|n| self.path(*n, tree, classes)).collect();
                    names.reverse();
                    names.push(names[0].clone());
                    let message = format!("these connections form a loop without a source: {}", names.join(" -> "));
                    let diagnostic = Diagnostic::new(Code::CausalityLoop, link.span, message);
                    diagnostics.push(diagnostic.hint("remove one of the connections"));
                    return None;
                }
                root = link.from;
                passed.push(root);
            }
            self.root.push(root);
        }
        Some(())
    }

    fn place_reactions(&mut self, classes: &[Class<'_>], tree: &Tree) {
        self.writers = vec![Vec::new(); self.instance.len()];
        self.readers = vec![Vec::new(); self.instance.len()];
        for (position, instance) in tree.instances.iter().enumerate() {
            for (index, reaction) in classes[instance.class.0].reactions.iter().enumerate() {
                let step = self.steps.len();
                self.steps.push(Step { instance: position, reaction: index });
                for parameter in &reaction.parameters {
                    let Variable::Port(port) = parameter.variable else { continue };
                    let root = self.root[self.node(tree, position, port)];
                    if parameter.effect {
                        self.writers[root].push(step);
                    } else {
                        self.readers[root].push((step, parameter.triggers));
                    }
                }
            }
        }
    }

    /// The name of a reaction: `unit_a.sensor.reaction_1`, or with its own name in place of the last part.
    pub(super) fn step_name(&self, step: usize, tree: &Tree, classes: &[Class<'_>]) -> String {
        let Step { instance, reaction } = self.steps[step];
        let instance = &tree.instances[instance];
        match &classes[instance.class.0].reactions[reaction].ast.name {
            Some(name) => format!("{}.{}", instance.path, name.text),
            None => format!("{}.reaction_{}", instance.path, reaction + 1),
        }
    }
}

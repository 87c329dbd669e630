// SPDX-License-Identifier: Apache-2.0
//! The ports and reactions of all instances, and the connections between them.

use std::collections::{BTreeMap, BTreeSet};

use super::serializer;
use crate::arena::{Arena, ArenaId as _, arena_ids};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::elaborated::Elaborated;
use crate::instances::{InstanceId, ModeInstanceId};
use crate::plan::{Serializer, Shape};
use crate::resolve::{
    CheckedConnection, CheckedPort, CheckedReaction, ConnectionEnd, PortRef, Variable, type_mismatch,
};
use crate::syntax::ast::{ReactionKeyword, Transition};

arena_ids! {
    /// A port of an instance, or a channel of a multiport, by its number in the whole program.
    pub(super) Node;
    /// A position in [`Graph::links`].
    pub(super) LinkId;
    /// A position in [`Graph::steps`].
    pub(super) StepId;
}

/// A reaction of an instance, or a connection that copies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) instance: InstanceId,
    /// The innermost mode that it is in.
    pub(super) mode: Option<ModeInstanceId>,
    /// The mode outside of which it never runs: none for a reaction to `shutdown`, which also runs at the last tag if
    /// its mode has been left.
    pub(super) confined: Option<ModeInstanceId>,
    pub(super) work: Work,
}

/// The work of a step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Work {
    /// A reaction, by its position in the class.
    Reaction(usize),
    /// A copy of the value at one end of a connection to the other.
    Copy(LinkId),
}

/// A connection of two ports of instances.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) from: Node,
    pub(super) to: Node,
    /// The delay in nanoseconds; none without `after`.
    pub(super) delay: Option<i64>,
    /// Whether the delay counts from physical time.
    pub(super) physical: bool,
    pub(super) capacity: Option<usize>,
    /// Whether it leaves a federate.
    pub(super) network: bool,
    /// The innermost mode that it is in.
    pub(super) mode: Option<ModeInstanceId>,
    /// Whether values are copied while its mode is active, because the destination is not in that mode.
    pub(super) copies: bool,
    /// `@maxwait` in nanoseconds.
    pub(super) max_wait: Option<i64>,
    /// `@absent_after` in nanoseconds.
    pub(super) absent_after: Option<i64>,
    /// The serializer, if it leaves a federate and the type alone does not determine the bytes.
    pub(super) serializer: Option<Serializer>,
    /// The layouts of values at the source and at the destination, if these are in different languages.
    pub(super) shapes: Option<(Shape, Shape)>,
    pub(super) span: Span,
}

impl Link {
    /// Returns whether the destination is the source's storage.
    fn is_alias(&self) -> bool {
        self.delay.is_none() && !self.network && !self.physical && !self.copies
    }

    /// Returns whether it carries messages with tags from federate to federate.
    pub(super) fn is_logical_network(&self) -> bool {
        self.network && !self.physical
    }

    /// Returns whether it has a queue of its own inside a federate.
    pub(super) fn is_delayed(&self) -> bool {
        !self.network && !self.copies && !self.is_alias()
    }
}

/// The maximum number of ports and channels in a program.
const PORTS_MAX: usize = 1_000_000;

/// All ports, connections and reactions of a program.
#[derive(Debug)]
pub(super) struct Graph<'a> {
    /// The program behind the graph.
    pub(super) program: &'a Elaborated<'a>,
    /// The number of each port of each instance, or that of its first channel.
    first: Arena<InstanceId, Vec<Node>>,
    /// The instance of each port.
    pub(super) instance: Arena<Node, InstanceId>,
    /// The position of each port in its class, and the channel of a multiport.
    declared: Arena<Node, (usize, Option<usize>)>,
    /// All connections, in the order of the text within each container.
    pub(super) links: Arena<LinkId, Link>,
    /// The connection into each port.
    pub(super) into: Arena<Node, Option<LinkId>>,
    /// The port whose storage each port uses.
    pub(super) root: Arena<Node, Node>,
    /// All reactions, in order of instances and then of declaration; then the connections that copy.
    pub(super) steps: Arena<StepId, Step>,
    /// The first of each instance's reactions, and the end of the last one's.
    first_steps: Arena<InstanceId, StepId>,
    /// The modes that can be entered by reset.
    pub(super) resets: BTreeSet<ModeInstanceId>,
    /// Per storing port: the reactions that write it.
    pub(super) writers: Arena<Node, Vec<StepId>>,
    /// Per storing port: the reactions that read it, each with whether it triggers them.
    pub(super) readers: Arena<Node, Vec<(StepId, bool)>>,
}

impl<'a> Graph<'a> {
    /// Builds the graph. Returns `None` if connections alone form a cycle.
    pub(super) fn build(program: &'a Elaborated<'a>, diagnostics: &mut Diagnostics) -> Option<Self> {
        let tree = &program.tree;
        let mut graph = Self {
            program,
            first: Arena::default(),
            instance: Arena::default(),
            declared: Arena::default(),
            links: Arena::default(),
            into: Arena::default(),
            root: Arena::default(),
            steps: Arena::default(),
            first_steps: Arena::default(),
            resets: BTreeSet::new(),
            writers: Arena::default(),
            readers: Arena::default(),
        };
        for (position, instance) in tree.instances.iter() {
            let mut first = Vec::new();
            for (port, width) in instance.widths.iter().enumerate() {
                first.push(graph.instance.next_id());
                let channels = width.map_or(vec![None], |width| (0..width).map(Some).collect());
                graph.instance.extend(channels.iter().map(|_| position));
                graph.declared.extend(channels.iter().map(|channel| (port, *channel)));
            }
            graph.first.push(first);
        }
        if graph.instance.len() > PORTS_MAX {
            let message = format!("this program has more than {PORTS_MAX} ports and channels of ports");
            diagnostics.push(Diagnostic::new(Code::TooLarge, tree.instances[InstanceId::MAIN].span, message));
            return None;
        }
        graph.link(diagnostics);
        graph.alias(diagnostics)?;
        graph.place_reactions();
        Some(graph)
    }

    /// Returns the ports behind a reactor's reference in an instance of it: each channel of a multiport, for each
    /// member of a bank.
    pub(super) fn nodes(&self, instance: InstanceId, port: PortRef) -> Vec<Node> {
        self.members(instance, port).into_iter().flatten().collect()
    }

    /// Returns the same ports, separately for each member of a bank.
    pub(super) fn members(&self, instance: InstanceId, port: PortRef) -> Vec<Vec<Node>> {
        let tree = &self.program.tree;
        let channels = |instance: InstanceId, port: usize| {
            let first = self.first[instance][port].position();
            (first..first + tree.instances[instance].widths[port].unwrap_or(1)).map(Node::at).collect()
        };
        match port {
            PortRef::Own(port) => vec![channels(instance, port)],
            PortRef::Child(child, port) => {
                tree.instances[instance].children[child].iter().map(|member| channels(*member, port)).collect()
            }
        }
    }

    /// Returns the ports at an end of a connection. If it is interleaved, the first channels of all members come first.
    fn channels(&self, instance: InstanceId, end: &ConnectionEnd<'_>) -> Vec<Node> {
        let members = self.members(instance, end.port);
        if !end.ast.interleaved {
            return members.into_iter().flatten().collect();
        }
        let widest = members.iter().map(Vec::len).max().unwrap_or_default();
        let channel = |channel: usize| members.iter().filter_map(move |member| member.get(channel).copied());
        (0..widest).flat_map(channel).collect()
    }

    /// Returns the position of a port in its class.
    pub(super) fn port_of(&self, node: Node) -> usize {
        self.declared[node].0
    }

    /// Returns the declaration of a port.
    pub(super) fn port(&self, node: Node) -> &'a CheckedPort<'a> {
        &self.program.class(self.instance[node]).ports[self.port_of(node)]
    }

    /// Returns the federate that a port belongs to.
    pub(super) fn part(&self, node: Node) -> Option<usize> {
        self.program.part(self.instance[node])
    }

    /// Returns the path of a port: `unit_a.sensor.voltage`, or `unit_a.voltages[1]` for a channel.
    pub(super) fn path(&self, node: Node) -> String {
        let instance = &self.program.tree.instances[self.instance[node]];
        let name = &self.port(node).name.text;
        match self.declared[node].1 {
            Some(channel) => format!("{}.{name}[{channel}]", instance.path),
            None => format!("{}.{name}", instance.path),
        }
    }

    fn link(&mut self, diagnostics: &mut Diagnostics) {
        let program = self.program;
        let tree = &program.tree;
        self.into = Arena::of(&self.instance, None);
        for position in tree.instances.ids().filter(|position| !tree.is_share(*position)) {
            let sources = self.sources(position);
            for connection in &program.class(position).connections {
                // An unknown delay has been reported, and there will be no plan.
                let mut known = |value| program.time(position, value, diagnostics).unwrap_or_default();
                let delay = connection.after.map(&mut known);
                let max_wait = connection.max_wait.map(|wait| known(wait.value));
                let absent_after = connection.absent_after.map(|wait| known(wait.value));
                let (capacity, span) = (connection.capacity, connection.span);
                let physical = connection.physical;
                let mode = tree.mode_of(position, connection.mode);
                for (from, to) in self.pairs(connection, position, diagnostics) {
                    let network = self.part(from) != self.part(to);
                    // Elements of the mode itself read nothing while the mode is inactive.
                    let copies = connection.mode.is_some() && tree.instances[self.instance[to]].mode != mode;
                    let is_delayed = delay.is_some() || physical;
                    // The only source of a port fills it, whether or not it is in a mode.
                    let shares = sources.get(&to).is_some_and(|sources| *sources > 1);
                    let to = if copies && is_delayed && shares { self.copied(to, mode, span) } else { to };
                    let copies = copies && !is_delayed;
                    if !copies {
                        self.into[to] = Some(self.links.next_id());
                    }
                    let serializer = network
                        .then(|| serializer::of_connection(connection, self.port(from), self.port(to), diagnostics))
                        .flatten();
                    self.links.push(Link {
                        from,
                        to,
                        delay,
                        physical,
                        capacity,
                        network,
                        mode,
                        copies,
                        max_wait,
                        absent_after,
                        serializer,
                        shapes: None,
                        span,
                    });
                }
            }
        }
    }

    /// Returns the number of connections and reactions of an instance with modes that can write a port.
    fn sources(&self, position: InstanceId) -> BTreeMap<Node, usize> {
        let class = self.program.class(position);
        let mut sources = BTreeMap::new();
        if class.ast.body.modes.is_empty() {
            return sources;
        }
        let connected = class.connections.iter().flat_map(|connection| &connection.right).map(|end| end.port);
        let effects = class.reactions.iter().flat_map(|reaction| reaction.parameters.iter().filter(|it| it.effect));
        let written = effects.filter_map(|effect| match effect.variable {
            Variable::Port(port) => Some(port),
            _ => None,
        });
        for node in connected.chain(written).flat_map(|port| self.nodes(position, port)) {
            *sources.entry(node).or_default() += 1;
        }
        sources
    }

    /// Adds a port that represents another one in a mode, and a connection that copies from the first to the second.
    fn copied(&mut self, to: Node, mode: Option<ModeInstanceId>, span: Span) -> Node {
        let from = self.instance.push(self.instance[to]);
        self.declared.push(self.declared[to]);
        self.into.push(None);
        self.links.push(Link {
            from,
            to,
            delay: None,
            physical: false,
            capacity: None,
            network: false,
            mode,
            copies: true,
            max_wait: None,
            absent_after: None,
            serializer: None,
            shapes: None,
            span,
        });
        from
    }

    /// Returns the pairs of connected ports; reports unconnected channels, and different types.
    fn pairs(
        &self,
        connection: &CheckedConnection<'_>,
        position: InstanceId,
        diagnostics: &mut Diagnostics,
    ) -> Vec<(Node, Node)> {
        let (tree, class) = (&self.program.tree, self.program.class(position));
        let side = |ends: &[ConnectionEnd<'_>]| -> Vec<(Node, usize)> {
            let nodes = ends.iter().enumerate().map(|(end, it)| (end, self.channels(position, it)));
            nodes.flat_map(|(end, nodes)| nodes.into_iter().map(move |node| (node, end))).collect()
        };
        let (left, right) = (side(&connection.left), side(&connection.right));
        let (sources, destinations) = (left.len(), right.len());
        let fits = match sources {
            0 => destinations == 0,
            _ if connection.iterated => destinations.is_multiple_of(sources),
            _ => destinations == sources,
        };
        if !fits {
            let message = format!(
                "{sources} channels on the left side are connected to {destinations} on the right side (in `{}`)",
                tree.instances[position].path
            );
            let hint = match sources {
                0 => "nothing comes there; remove the connection",
                _ if connection.iterated => "the last repetition of the left side is not whole",
                _ if sources > destinations => "what is set on the others is not seen anywhere",
                _ => "nothing comes to the others; `( … )+` around the left side repeats it",
            };
            diagnostics.push(Diagnostic::new(Code::UnequalWidths, connection.span, message).hint(hint));
        }
        let times = if connection.iterated { destinations } else { sources };
        let mut checked = BTreeSet::new();
        let pairs = left.iter().cycle().take(times).zip(&right).map(|((from, from_end), (to, to_end))| {
            if checked.insert((from_end, to_end)) {
                let ends = (&connection.left[*from_end], &connection.right[*to_end]);
                diagnostics.extend(type_mismatch(ends.0, ends.1, class, self.program.classes));
            }
            (*from, *to)
        });
        pairs.collect()
    }

    /// Follows undelayed connections backwards to the port that stores the value.
    fn alias(&mut self, diagnostics: &mut Diagnostics) -> Option<()> {
        for node in self.instance.ids() {
            let mut root = node;
            let mut passed = Vec::new();
            while let Some(link) = self.into[root].map(|link| &self.links[link]).filter(|link| link.is_alias()) {
                if passed.contains(&link.from) {
                    let start = passed.iter().position(|node| *node == link.from).unwrap_or_default();
                    let mut cycle = passed.split_off(start);
                    cycle.reverse();
                    diagnostics.push(self.endless(&cycle));
                    return None;
                }
                root = link.from;
                passed.push(root);
            }
            self.root.push(root);
        }
        Some(())
    }

    /// Returns the diagnostic for ports that are connected in a circle, each to the next one.
    fn endless(&self, cycle: &[Node]) -> Diagnostic {
        let around = cycle.iter().chain(cycle.first());
        let names: Vec<_> = around.map(|node| self.path(*node)).collect();
        let message = format!("these connections form a loop without a source: {}", names.join(" -> "));
        let links = cycle.iter().cycle().skip(1).zip(&names);
        let mut links = links.filter_map(|(to, from)| Some((self.links[self.into[*to]?].span, from)));
        let (first, from) = links.next().unwrap_or((self.program.tree.instances[InstanceId::MAIN].span, &names[0]));
        let label = |from: &String, to: &String| format!("`{from}` sets `{to}`");
        let mut diagnostic = Diagnostic::new(Code::CausalityLoop, first, message).label(label(from, &names[1]));
        for ((span, from), to) in links.zip(&names[2..]) {
            diagnostic = diagnostic.also(span, label(from, to));
        }
        diagnostic.hint("remove one of the connections")
    }

    /// Returns the port by whose name a reaction reads the value that another one stores.
    pub(super) fn node_read(&self, step: StepId, root: Node) -> Option<Node> {
        let read = self.reaction(step)?.parameters.iter().filter(|parameter| !parameter.effect);
        let nodes = read.filter_map(|parameter| match parameter.variable {
            Variable::Port(port) => Some(self.nodes(self.steps[step].instance, port)),
            _ => None,
        });
        nodes.flatten().find(|node| self.root[*node] == root)
    }

    /// Returns the connections from the storing port to a port with its value.
    pub(super) fn connections_to(&self, mut node: Node) -> Vec<LinkId> {
        let mut found = Vec::new();
        while let Some(link) = self.into[node].filter(|link| self.links[*link].is_alias()) {
            found.push(link);
            node = self.links[link].from;
        }
        found.reverse();
        found
    }

    fn place_reactions(&mut self) {
        let program = self.program;
        let tree = &program.tree;
        self.writers = Arena::of(&self.instance, Vec::new());
        self.readers = Arena::of(&self.instance, Vec::new());
        for (position, instance) in tree.instances.iter() {
            self.first_steps.push(self.steps.next_id());
            let is_split = tree.is_share(position) || program.part(position).is_none();
            for (index, reaction) in program.class(position).reactions.iter().enumerate() {
                // A federate has those reactions of the federated reactor that name no other one.
                let mut children = reaction.children().into_keys();
                if is_split
                    && (position == InstanceId::MAIN || children.any(|child| instance.children[child].is_empty()))
                {
                    continue;
                }
                let mode = tree.mode_of(position, reaction.ast.mode);
                let ends = reaction.parameters.iter().any(|it| it.variable == Variable::Shutdown);
                let confined = mode.filter(|_| !ends);
                let step = self.steps.push(Step { instance: position, mode, confined, work: Work::Reaction(index) });
                for parameter in &reaction.parameters {
                    if let Variable::Mode(mode, Transition::Reset) = parameter.variable {
                        self.resets.extend(tree.mode_of(position, Some(mode)));
                    }
                    let Variable::Port(port) = parameter.variable else { continue };
                    for node in self.nodes(position, port) {
                        let root = self.root[node];
                        // Several channels can have one source.
                        if parameter.effect {
                            add(&mut self.writers[root], step);
                        } else {
                            add(&mut self.readers[root], (step, parameter.triggers));
                        }
                    }
                }
            }
        }
        self.first_steps.push(self.steps.next_id());
        // Resetting a mode resets its contents, and these begin in their initial modes.
        for (position, mode) in tree.modes.iter().filter(|(_, mode)| mode.initial) {
            if tree.instances[mode.instance].mode.is_some_and(|around| self.resets.contains(&around)) {
                self.resets.insert(position);
            }
        }
        for (position, link) in self.links.iter().filter(|(_, link)| link.copies) {
            let (instance, mode) = (self.instance[link.to], link.mode);
            let step = self.steps.push(Step { instance, mode, confined: mode, work: Work::Copy(position) });
            self.writers[self.root[link.to]].push(step);
            self.readers[self.root[link.from]].push((step, true));
        }
    }

    /// Returns the steps of an instance's reactions, in the order of their declarations.
    pub(super) fn reactions_of(&self, instance: InstanceId) -> impl Iterator<Item = StepId> + use<> {
        let ends = [instance, InstanceId::at(instance.position() + 1)].map(|at| self.first_steps[at].position());
        (ends[0]..ends[1]).map(StepId::at)
    }

    /// Returns the reaction of a step; `None` for a connection that copies.
    pub(super) fn reaction(&self, step: StepId) -> Option<&'a CheckedReaction<'a>> {
        let Step { instance, work: Work::Reaction(reaction), .. } = self.steps[step] else { return None };
        self.program.class(instance).reactions.get(reaction)
    }

    /// Returns the name of a connection: `a.x -> b.y`.
    pub(super) fn link_name(&self, link: LinkId) -> String {
        let link = &self.links[link];
        format!("{} -> {}", self.path(link.from), self.path(link.to))
    }

    /// Returns the name of a reaction: `unit_a.sensor.reaction_1`, or with its own name instead of the last part.
    pub(super) fn step_name(&self, step: StepId) -> String {
        let Step { instance, work, .. } = self.steps[step];
        let reaction = match work {
            Work::Reaction(reaction) => reaction,
            Work::Copy(link) => return self.link_name(link),
        };
        let reactions = &self.program.class(instance).reactions;
        let instance = &self.program.tree.instances[instance];
        // Handlers of watchdogs have names, and do not count.
        let counts = |reaction: &&CheckedReaction<'_>| reaction.ast.kind != ReactionKeyword::Watchdog;
        match &reactions[reaction].ast.name {
            Some(name) => format!("{}.{}", instance.path, name.text),
            None => format!("{}.reaction_{}", instance.path, reactions[..=reaction].iter().filter(counts).count()),
        }
    }
}

fn add<T: PartialEq>(list: &mut Vec<T>, item: T) {
    if list.last() != Some(&item) {
        list.push(item);
    }
}

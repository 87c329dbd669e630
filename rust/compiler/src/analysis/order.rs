// SPDX-License-Identifier: Apache-2.0
//! Levels: reactions that write precede those that read, and within an instance the order of declaration counts.
//!
//! Of two reactions that can run at one tag, and share a reactor's state or a port, one waits for the other. So levels,
//! which differ if the program is federated, have no visible effect.
//!
//! They are common to all federates: the level of a reaction to a message without `after` is higher than that of
//! sending. So federates that wait for each other within a tag cannot all wait, because one of them waits at the lowest
//! level.

use std::collections::BTreeMap;

use super::followers::{Followers, Reason, Vertex};
use super::graph::{Graph, LinkId, Node, Step, StepId, Work};
use super::last_tag;
use super::zero_delay::is_immediate;
use crate::arena::{Arena, ArenaId as _};
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::instances::InstanceId;

/// The levels of all steps and sends.
#[derive(Debug)]
pub(super) struct Levels {
    /// Per reaction of the graph.
    pub(super) steps: Arena<StepId, u16>,
    /// Per connection of the graph, the level of sending over it; 0 for those that stay inside a federate.
    pub(super) sends: Arena<LinkId, u16>,
}

/// Returns the level of every reaction and of every connection to another federate. Returns `None`, with a diagnostic,
/// if some wait for each other.
pub(super) fn order(graph: &Graph<'_>, diagnostics: &mut Diagnostics) -> Option<Levels> {
    let mut followers = collect_followers(graph);
    let mut sorted = sort(&followers);
    if sorted.order.len() < followers.len() {
        if let Some(cycle) = find_cycle(&followers, &sorted.missing) {
            diagnostics.push(CycleNames { graph }.report(&cycle));
        }
        return None;
    }
    if last_tag::order(graph, &mut followers) {
        sorted = sort(&followers);
    }
    let Sorted { order, mut levels, .. } = sorted;
    let deadlines = inherited(deadlines(graph), &order, &followers);
    by_deadline(&mut levels, &deadlines);
    // The highest number stands for "no level".
    let level = |level: usize| u16::try_from(level).ok().filter(|level| *level < u16::MAX);
    let Some(mut steps) = levels.values().copied().map(level).collect::<Option<Vec<_>>>() else {
        let message = "this program has more than 65535 levels of reactions";
        diagnostics.push(Diagnostic::new(Code::TooLarge, graph.program.tree.instances[InstanceId::MAIN].span, message));
        return None;
    };
    let sends = steps.split_off(graph.steps.len());
    Some(Levels { steps: steps.into(), sends: sends.into() })
}

/// All vertices that are neither in a cycle nor behind one.
struct Sorted {
    /// The order: each vertex behind all that it follows.
    order: Vec<Vertex>,
    levels: Arena<Vertex, usize>,
    /// By vertex: the number of its predecessors that are not in the order.
    missing: Arena<Vertex, usize>,
}

fn sort(followers: &Followers) -> Sorted {
    let mut missing = Arena::of(followers, 0_usize);
    for (follower, _) in followers.values().flatten() {
        missing[*follower] += 1;
    }
    let mut levels = Arena::of(followers, 0_usize);
    let mut ready: Vec<_> = followers.ids().filter(|vertex| missing[*vertex] == 0).collect();
    let mut order = Vec::with_capacity(followers.len());
    while let Some(vertex) = ready.pop() {
        order.push(vertex);
        for (follower, _) in &followers[vertex] {
            levels[*follower] = levels[*follower].max(levels[vertex] + 1);
            missing[*follower] -= 1;
            if missing[*follower] == 0 {
                ready.push(*follower);
            }
        }
    }
    Sorted { order, levels, missing }
}

/// Returns the deadlines that order reactions, in nanoseconds; the highest number for none. Unknown deadlines are
/// reported elsewhere.
fn deadlines(graph: &Graph<'_>) -> impl Iterator<Item = i64> {
    let deadline = |step: &Step| {
        let Work::Reaction(reaction) = step.work else { return None };
        let class = graph.program.class(step.instance);
        let deadline = class.reactions[reaction].ast.deadline.as_ref();
        let value = &deadline.filter(|_| class.language.facts().deadlines_come_first)?.value;
        graph.program.time(step.instance, value, &mut Diagnostics::default())
    };
    graph.steps.values().map(move |step| deadline(step).unwrap_or(i64::MAX))
}

/// Passes deadlines on to predecessors: a reaction can meet its deadline only if these do.
fn inherited(deadlines: impl Iterator<Item = i64>, order: &[Vertex], followers: &Followers) -> Arena<Vertex, i64> {
    let sends = core::iter::repeat(i64::MAX);
    let mut deadlines: Arena<Vertex, i64> = deadlines.chain(sends).take(followers.len()).collect();
    for vertex in order.iter().rev() {
        let behind = followers[*vertex].iter().map(|(follower, _)| deadlines[*follower]);
        deadlines[*vertex] = behind.min().map_or(deadlines[*vertex], |least| least.min(deadlines[*vertex]));
    }
    deadlines
}

/// Orders vertices with an earlier deadline before all with a later one or none. No vertex waits for one with a later
/// deadline, so followers stay behind.
fn by_deadline(levels: &mut Arena<Vertex, usize>, deadlines: &Arena<Vertex, i64>) {
    let mut ends: BTreeMap<i64, usize> = BTreeMap::new();
    for (level, deadline) in levels.values().zip(deadlines.values()) {
        let end = ends.entry(*deadline).or_default();
        *end = (*end).max(level + 1);
    }
    let mut begin = 0;
    for end in ends.values_mut() {
        begin += core::mem::replace(end, begin);
    }
    for (level, deadline) in levels.values_mut().zip(deadlines.values()) {
        *level += ends[deadline];
    }
}

fn collect_followers(graph: &Graph<'_>) -> Followers {
    let tree = &graph.program.tree;
    let mut followers: Followers = vec![Vec::new(); graph.steps.len() + graph.links.len()].into();
    declared_order(graph, &mut followers);
    // The readers and senders of each storing port.
    let mut behind: Arena<Node, Vec<Vertex>> = graph
        .readers
        .values()
        .map(|readers| readers.iter().map(|(reader, _)| Vertex::from(*reader)).collect())
        .collect();
    for (position, link) in graph.links.iter().filter(|(_, link)| link.network) {
        behind[graph.root[link.from]].push(sending(graph, position));
    }
    let mode = |vertex| step(graph, vertex).and_then(|step| graph.steps[step].confined);
    let mut follow = |vertex: Vertex, node: Node| {
        // Those that exclude each other never wait for each other.
        let behind = behind[node].iter().filter(|follower| !tree.exclude(mode(vertex), mode(**follower)));
        followers[vertex].extend(behind.map(|follower| (*follower, Reason::Port(node))));
    };
    for (node, writers) in graph.writers.iter() {
        for writer in writers {
            follow(Vertex::from(*writer), node);
        }
    }
    for (position, link) in graph.links.iter().filter(|(_, link)| is_immediate(link)) {
        follow(sending(graph, position), link.to);
    }
    order_copies(graph, &mut followers);
    followers
}

/// Returns the vertex of sending over a connection.
fn sending(graph: &Graph<'_>, link: LinkId) -> Vertex {
    Vertex::at(graph.steps.len() + link.position())
}

/// Returns the step of a vertex, unless it is one of sending.
fn step(graph: &Graph<'_>, vertex: Vertex) -> Option<StepId> {
    (vertex.position() < graph.steps.len()).then(|| StepId::at(vertex.position()))
}

/// Orders copies. A connection of a mode and a reaction to `shutdown` of another mode can set a port at one tag; the
/// connection does so last.
fn order_copies(graph: &Graph<'_>, followers: &mut Followers) {
    let tree = &graph.program.tree;
    for writers in graph.writers.values() {
        let copies = |writer: StepId| matches!(graph.steps[writer].work, Work::Copy(_));
        for reaction in writers.iter().copied().filter(|writer| !copies(*writer)) {
            let apart = |copy: StepId| tree.exclude(graph.steps[reaction].confined, graph.steps[copy].confined);
            let behind = writers.iter().copied().filter(|copy| copies(*copy) && !apart(*copy));
            followers[reaction.into()].extend(behind.map(|copy| (copy.into(), Reason::Declared)));
        }
    }
}

/// Orders the reactions of an instance as they are declared, unless they are in different modes. For the last tag,
/// [`last_tag`] has more.
fn declared_order(graph: &Graph<'_>, followers: &mut Followers) {
    let tree = &graph.program.tree;
    // The last reactions of the instance so far: any other one precedes one of them.
    let mut last: Vec<StepId> = Vec::new();
    let reactions = graph.steps.iter().filter(|(_, step)| matches!(step.work, Work::Reaction(_)));
    for (position, step) in reactions {
        last.retain(|before| graph.steps[*before].instance == step.instance);
        let apart = |before: &StepId| tree.exclude(graph.steps[*before].mode, step.mode);
        last.iter().filter(|before| !apart(before)).for_each(|before| {
            followers[(*before).into()].push((position.into(), Reason::Declared));
        });
        let in_mode = step.mode != tree.instances[step.instance].mode;
        last.retain(|before| in_mode && graph.steps[*before].mode != step.mode);
        last.push(position);
    }
}

/// Names the members of a cycle.
struct CycleNames<'a> {
    graph: &'a Graph<'a>,
}

impl CycleNames<'_> {
    fn report(&self, cycle: &[(Vertex, Reason)]) -> Diagnostic {
        let mut text = String::new();
        for (index, (vertex, reason)) in cycle.iter().enumerate() {
            text.push_str(&self.name(*vertex));
            text.push_str(" -> ");
            let Reason::Port(node) = reason else { continue };
            let next = cycle[(index + 1) % cycle.len()].0;
            let connected = self.connections(*node, next).into_iter().map(|link| self.graph.links[link].to);
            let own = Some(*node).filter(|node| !self.is_end(*vertex, *node));
            for node in own.into_iter().chain(connected) {
                text.push_str(&self.path(node));
                text.push_str(" -> ");
            }
        }
        text.push_str(&self.name(cycle[0].0));
        let reactions = cycle.iter().any(|(vertex, _)| self.link(*vertex).is_none());
        let message = if reactions {
            format!("these reactions wait for each other at the same time: {text}")
        } else {
            format!("these connections form a loop without a source: {text}")
        };
        let mut connected = cycle.iter().any(|(vertex, _)| self.link(*vertex).is_some());
        let mut diagnostic = Diagnostic::new(Code::CausalityLoop, self.span(cycle[0].0), message);
        for (index, (vertex, reason)) in cycle.iter().enumerate() {
            let next = cycle[(index + 1) % cycle.len()].0;
            let label = self.label(*vertex, *reason, next);
            diagnostic = if index == 0 { diagnostic.label(label) } else { diagnostic.also(self.span(*vertex), label) };
            let Reason::Port(node) = reason else { continue };
            for link in self.connections(*node, next) {
                connected = true;
                let link = &self.graph.links[link];
                let label = format!("without `after`, this connection sets `{}` at once", self.path(link.to));
                diagnostic = diagnostic.also(link.span, label);
            }
        }
        let declared = cycle.iter().any(|(_, reason)| matches!(reason, Reason::Declared));
        diagnostic.hint(match (reactions, connected, declared) {
            (false, ..) => "remove one of the connections",
            (true, true, false) => "delay one of the connections by `after` (`after 0` is one microstep)",
            (true, true, true) => {
                "delay one of the connections by `after` (`after 0` is one microstep), or change the order of the \
                 reactions"
            }
            (true, false, true) => {
                "change the order of the reactions, or have one of them schedule a logical action instead of writing \
                 a port"
            }
            (true, false, false) => "have one of them schedule a logical action instead of writing a port",
        })
    }

    /// Returns the connections inside a federate over which a value that is written to a port reaches the reading
    /// vertex.
    fn connections(&self, root: Node, reader: Vertex) -> Vec<LinkId> {
        let end = match self.work(reader) {
            Ok(step) => self.graph.node_read(step, root),
            Err(link) => Some(self.graph.links[link].from),
        };
        end.map_or(Vec::new(), |end| self.graph.connections_to(end))
    }

    fn label(&self, vertex: Vertex, reason: Reason, next: Vertex) -> String {
        let Reason::Port(node) = reason else {
            return format!("`{}` comes before `{}`, which is declared later", self.name(vertex), self.name(next));
        };
        let follows = match self.link(next) {
            Some(link) if self.graph.links[link].network => format!("which is sent to `{}`", self.name(next)),
            Some(_) => format!("which is copied to `{}`", self.name(next)),
            None => format!("which `{}` reads", self.name(next)),
        };
        match self.link(vertex) {
            Some(_) => format!("without `after`, this connection sets `{}` at once, {follows}", self.path(node)),
            None => format!("`{}` writes `{}`, {follows}", self.name(vertex), self.path(node)),
        }
    }

    /// Returns the vertex's reaction, or else its connection.
    fn work(&self, vertex: Vertex) -> Result<StepId, LinkId> {
        let Some(step) = step(self.graph, vertex) else {
            return Err(LinkId::at(vertex.position() - self.graph.steps.len()));
        };
        match self.graph.steps[step].work {
            Work::Copy(link) => Err(link),
            Work::Reaction(_) => Ok(step),
        }
    }

    fn link(&self, vertex: Vertex) -> Option<LinkId> {
        self.work(vertex).err()
    }

    /// Returns whether a connection ends at this port, so that its name is the port's.
    fn is_end(&self, vertex: Vertex, node: Node) -> bool {
        self.link(vertex).is_some_and(|link| self.graph.links[link].to == node)
    }

    fn path(&self, node: Node) -> String {
        self.graph.path(node)
    }

    /// Returns the name of a reaction, or of the port at a connection's end.
    fn name(&self, vertex: Vertex) -> String {
        match self.work(vertex) {
            Ok(step) => self.graph.step_name(step),
            Err(link) => self.path(self.graph.links[link].to),
        }
    }

    fn span(&self, vertex: Vertex) -> Span {
        let step = match self.work(vertex) {
            Ok(step) => step,
            Err(link) => return self.graph.links[link].span,
        };
        let class = self.graph.program.class(self.graph.steps[step].instance);
        self.graph.reaction(step).map_or(class.ast.span(), |reaction| reaction.ast.keyword)
    }
}

/// Returns a shortest cycle through the first vertex that has one, with the reason for each step.
fn find_cycle(followers: &Followers, missing: &Arena<Vertex, usize>) -> Option<Vec<(Vertex, Reason)>> {
    missing.ids().filter(|vertex| missing[*vertex] > 0).find_map(|start| {
        // Breadth first, so that the path is a short one.
        let mut from: Arena<Vertex, Option<(Vertex, Reason)>> = Arena::of(missing, None);
        let mut queue = std::collections::VecDeque::from([start]);
        while let Some(vertex) = queue.pop_front() {
            for (follower, reason) in followers[vertex].iter().filter(|(follower, _)| missing[*follower] > 0) {
                if from[*follower].is_some() {
                    continue;
                }
                from[*follower] = Some((vertex, *reason));
                if *follower == start {
                    return Some(path_back(&from, start));
                }
                queue.push_back(*follower);
            }
        }
        None
    })
}

fn path_back(from: &Arena<Vertex, Option<(Vertex, Reason)>>, start: Vertex) -> Vec<(Vertex, Reason)> {
    let mut path = Vec::new();
    let mut at = start;
    while let Some((vertex, reason)) = from[at] {
        path.push((vertex, reason));
        at = vertex;
        if at == start {
            break;
        }
    }
    path.reverse();
    path
}

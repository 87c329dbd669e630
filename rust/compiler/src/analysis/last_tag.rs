// SPDX-License-Identifier: Apache-2.0
//! The order of reactions that meet only at the last tag: those to `shutdown` of modes that have been left, and those
//! of the active mode.
//!
//! They follow each other in the order of declaration, unless the later one precedes for another reason. So a mode can
//! write a port that another mode reads, without a cycle. The reasons must not depend on whether the program is
//! federated, so they are taken from the common part of both forms.

use std::collections::BTreeSet;

use super::followers::{Followers, Reason, Vertex};
use super::graph::{Graph, Node, Step, StepId, Work};
use crate::instances::InstanceId;
use crate::resolve::Variable;

/// Adds that order to the followers, which have no cycles. Returns whether there are such reactions.
pub(super) fn order(graph: &Graph<'_>, followers: &mut Followers) -> bool {
    let tree = &graph.program.tree;
    let outlasts = |position: StepId| graph.steps[position].confined != graph.steps[position].mode;
    let last: Vec<_> = graph.steps.ids().filter(|position| outlasts(*position)).collect();
    if last.is_empty() {
        return false;
    }
    let mut common = followers.clone();
    join_shares(graph, &mut common);
    join_around(graph, &mut common);
    for position in last {
        let step = graph.steps[position];
        for other in graph.reactions_of(step.instance) {
            let is_second_look = other < position && outlasts(other);
            if is_second_look || !tree.exclude(step.mode, graph.steps[other].mode) {
                continue;
            }
            let (first, second) = (Vertex::from(position.min(other)), Vertex::from(position.max(other)));
            let is_reversed = leads(&common, second, first) && !leads(followers, first, second);
            let (first, second) = if is_reversed { (second, first) } else { (first, second) };
            followers[first].push((second, Reason::Declared));
            common[first].push((second, Reason::Declared));
        }
    }
    true
}

/// Joins the shares of the federated reactor: unfederated, its reactions belong to one instance, and follow each other.
fn join_shares(graph: &Graph<'_>, followers: &mut Followers) {
    let declared = |(position, step): (StepId, &Step)| match step.work {
        Work::Reaction(reaction) if graph.program.tree.is_share(step.instance) => Some((reaction, position)),
        _ => None,
    };
    let mut shared: Vec<_> = graph.steps.iter().filter_map(declared).collect();
    shared.sort_unstable();
    for pair in shared.windows(2) {
        followers[pair[0].1.into()].push((pair[1].1.into(), Reason::Declared));
    }
}

/// Joins reactions of other modes: federated, the mode at the time of sending is unknown when a value comes back by
/// connections of the federated reactor, so they follow that value, too.
fn join_around(graph: &Graph<'_>, followers: &mut Followers) {
    for (position, step) in graph.steps.iter().filter(|(_, step)| step.mode.is_some()) {
        for node in reads(graph, position).into_iter().filter(|node| is_from_around(graph, *node)) {
            let root = graph.root[node];
            for writer in &graph.writers[root] {
                if graph.program.tree.exclude(graph.steps[*writer].confined, step.confined) {
                    followers[(*writer).into()].push((position.into(), Reason::Port(root)));
                }
            }
        }
    }
}

/// Returns the ports that a step reads, by the names that it uses.
fn reads(graph: &Graph<'_>, position: StepId) -> Vec<Node> {
    let step = graph.steps[position];
    if let Work::Copy(link) = step.work {
        return vec![graph.links[link].from];
    }
    let parameters = graph.reaction(position).map_or(&[][..], |reaction| &reaction.parameters);
    let ports = parameters.iter().filter(|it| !it.effect).filter_map(|parameter| match parameter.variable {
        Variable::Port(port) => Some(port),
        _ => None,
    });
    ports.flat_map(|port| graph.nodes(step.instance, port)).collect()
}

/// Returns whether the source of a port is a connection between two instances in the main reactor, without a delay.
fn is_from_around(graph: &Graph<'_>, node: Node) -> bool {
    let is_top = |node: Node| graph.program.tree.instances[graph.instance[node]].parent == Some(InstanceId::MAIN);
    let mut at = node;
    while at != graph.root[at] {
        let Some(link) = graph.into[at].map(|link| &graph.links[link]) else { return false };
        if is_top(link.from) && is_top(link.to) {
            return true;
        }
        at = link.from;
    }
    false
}

/// Returns whether one vertex follows another one, directly or indirectly.
fn leads(followers: &Followers, from: Vertex, to: Vertex) -> bool {
    let mut seen = BTreeSet::from([from]);
    let mut open = vec![from];
    while let Some(vertex) = open.pop() {
        if vertex == to {
            return true;
        }
        open.extend(followers[vertex].iter().map(|(follower, _)| *follower).filter(|follower| seen.insert(*follower)));
    }
    false
}

// SPDX-License-Identifier: Apache-2.0
//! The delay from a physical action, or a value on a physical connection, to a message to another federate.

use super::builder::Context;
use super::graph::{Node, StepId, Work};
use crate::arena::Arena;
use crate::diagnostics::Diagnostics;
use crate::instances::{InstanceId, ModeInstanceId};
use crate::resolve::{ReactionVariable, Variable};
use crate::syntax::ast::ActionKind;

/// Returns the least delay in nanoseconds from a physical action of a federate, its minimum delay included, to a port
/// that is sent to another federate over a logical connection; `None` if there is no such path. The end of a physical
/// connection counts as a physical action.
///
/// In a zero-delay cycle it is the least minimum delay of all physical actions with reactions: there the next event
/// that a federate announces decides which federates may be at a tag at the same time, so it has to be an exact one,
/// not only a bound of its messages. A federate with a later grant could no longer be called to the event's tag.
pub(super) fn least_delay(context: &Context<'_>, federate: usize) -> Option<i64> {
    let paths = PhysicalSearch { context, federate };
    if context.zero_delay.is_in_one(federate) {
        let actions = context.graph.steps.ids().filter_map(|step| paths.physical_start(step));
        return actions.chain(paths.physical_ends().map(|(_, delay)| delay)).min();
    }
    least_delay_to_output(&paths)
}

fn least_delay_to_output(paths: &PhysicalSearch<'_>) -> Option<i64> {
    let context = paths.context;
    let steps = &context.graph.steps;
    let mut least: Arena<StepId, Option<i64>> = steps.ids().map(|step| paths.physical_start(step)).collect();
    // A shorter path to a reaction can shorten the paths behind it; each round settles at least one reaction.
    let mut open: Vec<StepId> = steps.ids().filter(|step| least[*step].is_some()).collect();
    let mut sent: Option<i64> = None;
    for (end, delay) in paths.physical_ends() {
        for (root, added) in paths.ports_behind(end) {
            let total = delay.saturating_add(added);
            for (reader, _) in context.graph.readers[root].iter().filter(|(_, triggers)| *triggers) {
                if least[*reader].is_none_or(|known| total < known) {
                    least[*reader] = Some(total);
                    open.push(*reader);
                }
            }
            if paths.is_sent(root) {
                sent = Some(sent.map_or(total, |known| known.min(total)));
            }
        }
    }
    // A reaction of a transient federate can end it at once.
    let is_transient = context.program.parts.list[paths.federate].is_transient;
    let ends: Vec<StepId> = if is_transient { paths.final_steps().collect() } else { Vec::new() };
    while let Some(step) = open.pop() {
        let Some(delay) = least[step] else { continue };
        let mut reach = |to: StepId, added: i64| {
            let total = delay.saturating_add(added);
            if least[to].is_none_or(|known| total < known) {
                least[to] = Some(total);
                open.push(to);
            }
        };
        let behind = paths.written(step).into_iter().flat_map(|node| paths.ports_behind(context.graph.root[node]));
        for (root, added) in behind {
            for (reader, _) in context.graph.readers[root].iter().filter(|(_, triggers)| *triggers) {
                reach(*reader, added);
            }
            if paths.is_sent(root) {
                let total = delay.saturating_add(added);
                sent = Some(sent.map_or(total, |known| known.min(total)));
            }
        }
        if context.graph.reaction(step).is_some() {
            for to in &ends {
                reach(*to, 0);
            }
        }
        for effect in paths.parameters(step).iter().filter(|parameter| parameter.effect) {
            match effect.variable {
                Variable::Mode(mode, _) => {
                    let entered = context.program.tree.mode_of(paths.instance(step), Some(mode));
                    paths.steps_in(entered).for_each(|to| reach(to, 0));
                }
                Variable::Action(action) => {
                    let added = paths.min_delay(paths.instance(step), action);
                    for to in paths.triggered_by(paths.instance(step), action) {
                        reach(to, added);
                    }
                }
                _ => {}
            }
        }
    }
    sent
}

struct PhysicalSearch<'a> {
    context: &'a Context<'a>,
    federate: usize,
}

impl PhysicalSearch<'_> {
    fn instance(&self, step: StepId) -> InstanceId {
        self.context.graph.steps[step].instance
    }

    fn parameters(&self, step: StepId) -> &[ReactionVariable] {
        self.context.graph.reaction(step).map_or(&[], |reaction| &reaction.parameters)
    }

    /// Returns the ports that a step writes.
    fn written(&self, step: StepId) -> Vec<Node> {
        let graph = self.context.graph;
        if let Work::Copy(link) = graph.steps[step].work {
            return vec![graph.links[link].to];
        }
        let effects = self.parameters(step).iter().filter(|parameter| parameter.effect);
        let nodes = effects.filter_map(|effect| match effect.variable {
            Variable::Port(port) => Some(graph.nodes(self.instance(step), port)),
            _ => None,
        });
        nodes.flatten().collect()
    }

    /// Returns the steps that can run because a mode is entered.
    fn steps_in(&self, mode: Option<ModeInstanceId>) -> impl Iterator<Item = StepId> {
        let (graph, tree) = (self.context.graph, &self.context.program.tree);
        let is_in = move |step: &StepId| tree.modes_around(graph.steps[*step].mode).any(|around| Some(around) == mode);
        graph.steps.ids().filter(is_in)
    }

    /// Returns the steps of this federate that run at its end.
    fn final_steps(&self) -> impl Iterator<Item = StepId> {
        let ends = |step: &StepId| {
            self.context.program.part(self.instance(*step)) == Some(self.federate)
                && self.parameters(*step).iter().any(|it| it.triggers && it.variable == Variable::Shutdown)
        };
        self.context.graph.steps.ids().filter(ends)
    }

    fn min_delay(&self, instance: InstanceId, action: usize) -> i64 {
        let class = self.context.program.class(instance);
        let value = class.actions[action].ast.min_delay.as_ref();
        // Invalid times have been reported with the trigger.
        let mut ignored = Diagnostics::default();
        let time = |value| self.context.program.time(instance, value, &mut ignored);
        value.and_then(time).unwrap_or_default()
    }

    /// Returns the delay with which a physical action triggers a reaction of this federate directly.
    fn physical_start(&self, step: StepId) -> Option<i64> {
        let instance = self.instance(step);
        if self.context.program.part(instance) != Some(self.federate) {
            return None;
        }
        let class = self.context.program.class(instance);
        let triggers = self.parameters(step).iter().filter(|parameter| parameter.triggers);
        let physical = triggers.filter_map(|parameter| match parameter.variable {
            Variable::Action(action) if class.actions[action].ast.kind == ActionKind::Physical => {
                Some(self.min_delay(instance, action))
            }
            _ => None,
        });
        physical.min()
    }

    /// Returns the ports of this federate that physical connections fill, each with the connection's delay.
    fn physical_ends(&self) -> impl Iterator<Item = (Node, i64)> {
        let graph = self.context.graph;
        let links = graph.links.values().filter(|link| link.physical);
        let own = links.filter(|link| graph.part(link.to) == Some(self.federate));
        own.map(|link| (link.to, link.delay.unwrap_or_default()))
    }

    fn triggered_by(&self, instance: InstanceId, action: usize) -> Vec<StepId> {
        let is_triggered = |step: &StepId| {
            self.instance(*step) == instance
                && self.parameters(*step).iter().any(|it| it.triggers && it.variable == Variable::Action(action))
        };
        self.context.graph.steps.ids().filter(is_triggered).collect()
    }

    /// Returns a storing port and those that delayed connections fill from it, with the least added delay.
    fn ports_behind(&self, root: Node) -> Vec<(Node, i64)> {
        let graph = self.context.graph;
        let mut found: Vec<(Node, i64)> = vec![(root, 0)];
        let mut next = 0;
        while let Some((from, delay)) = found.get(next).copied() {
            next += 1;
            for link in
                graph.links.values().filter(|link| graph.root[link.from] == from && !link.network && !link.physical)
            {
                let Some(added) = link.delay else { continue };
                let (to, total) = (graph.root[link.to], delay.saturating_add(added));
                // A port has one source, so there is one path to it.
                if !found.iter().any(|(node, _)| *node == to) {
                    found.push((to, total));
                }
            }
        }
        found
    }

    fn is_sent(&self, root: Node) -> bool {
        let graph = self.context.graph;
        let links = self.context.network.outputs[self.federate].iter().map(|link| &graph.links[*link]);
        links.filter(|link| !link.physical).any(|link| graph.root[link.from] == root)
    }
}

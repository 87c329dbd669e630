// SPDX-License-Identifier: Apache-2.0
//! The waits of federates for messages in decentralized coordination, and handlers of late messages.
//!
//! A federate begins a tag when it knows all earlier messages, or when it has waited for its `@maxwait` (LF's STA).
//! Within a tag, an input counts as absent when its `@absent_after` (STAA) is over as well. Older programs write the
//! first as a parameter of the federate's reactor and the second behind reactions.

use std::collections::BTreeMap;

use super::graph::{Graph, LinkId, StepId};
use super::network::NetworkPorts;
use super::zero_delay::Cycles;
use crate::arena::Arena;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Span};
use crate::instances::InstanceId;
use crate::plan::Time;
use crate::plan::{Coordination, Target};
use crate::resolve::Wait;

/// Names of the parameter by which older programs set the `@maxwait` of a federate, in small letters.
const OLDER_PARAMETERS: [&str; 2] = ["sta", "stp_offset"];

/// The waits of a federate at one of its inputs, in nanoseconds; [`i64::MAX`] is forever.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Waits {
    pub(super) max_wait_ns: i64,
    /// The wait within a tag, less the connection's delay.
    pub(super) absent_after_ns: i64,
}

/// Computes the waits of every connection of the graph; 0 for a connection without any.
pub(super) fn waits(
    graph: &Graph<'_>,
    network: &NetworkPorts,
    target: &Target,
    diagnostics: &mut Diagnostics,
) -> Arena<LinkId, Waits> {
    // Federates of micro LF wait for nobody unless they say so.
    let otherwise_ns = if target.c.is_micro { 0 } else { i64::MAX };
    let mut search = WaitSearch { graph, diagnostics, otherwise_ns, older: BTreeMap::new() };
    if target.coordination == Coordination::Centralized {
        search.report_idle();
        return Arena::of(&graph.links, Waits::default());
    }
    search.report_idle_connections();
    search.report_older_handlers();
    let federates: Vec<i64> = (0..graph.program.parts.list.len()).map(|part| search.max_wait(part)).collect();
    search.report_older_parameters();
    let handlers: Arena<StepId, i64> = graph.steps.ids().map(|step| search.absent_after(step)).collect();
    let mut waits = Arena::default();
    for link in graph.links.values() {
        let receiver = graph.part(link.to).filter(|_| link.is_logical_network());
        waits.push(receiver.map_or_else(Waits::default, |receiver| {
            let readers = graph.readers[link.to].iter().map(|(reader, _)| handlers[*reader]);
            let absent_after = link.absent_after.or_else(|| readers.max()).unwrap_or_default();
            Waits {
                max_wait_ns: link.max_wait.unwrap_or(federates[receiver]),
                absent_after_ns: less(absent_after, link.delay.unwrap_or_default()),
            }
        }));
    }
    search.report_deadlocks(network, &waits);
    waits
}

/// Returns the remainder of a time; forever stays forever.
fn less(time_ns: i64, taken_ns: i64) -> i64 {
    if time_ns == i64::MAX { time_ns } else { time_ns.saturating_sub(taken_ns).max(0) }
}

struct WaitSearch<'a> {
    graph: &'a Graph<'a>,
    diagnostics: &'a mut Diagnostics,
    /// The `@maxwait` of federates that have none.
    otherwise_ns: i64,
    /// The older parameters by their places.
    older: BTreeMap<Span, Older<'a>>,
}

/// An older parameter: its name, and the federates that have it with their waits in nanoseconds.
type Older<'a> = (&'a str, Vec<(usize, i64)>);

impl<'a> WaitSearch<'a> {
    /// Returns the instances and connections of the main or federated reactor, with their kinds and their attributes.
    fn attributes(&self) -> Vec<(&'static str, Wait<'a>)> {
        let main = self.graph.program.main();
        let mut found: BTreeMap<Span, (&'static str, Wait<'a>)> = BTreeMap::new();
        let mut add = |name, wait: Option<Wait<'a>>| {
            if let Some(wait) = wait {
                found.insert(wait.span, (name, wait));
            }
        };
        main.children.iter().for_each(|child| add("@maxwait", child.max_wait));
        for connection in &main.connections {
            add("@maxwait", connection.max_wait);
            add("@absent_after", connection.absent_after);
        }
        found.into_values().collect()
    }

    /// Reports settings without an effect because the coordination is not decentralized.
    fn report_idle(&mut self) {
        let (reason, hint) = if self.graph.program.parts.federated {
            (
                "the RTI lets no federate go on too early",
                "remove it, or write `coordination: decentralized` in the target",
            )
        } else {
            ("this program is not federated", "remove it, or make the main reactor `federated`")
        };
        for (name, wait) in self.attributes() {
            let message = format!("`{name}` has no effect: {reason}");
            self.diagnostics.push(Diagnostic::new(Code::NoEffect, wait.span, message).hint(hint));
        }
        for (_, tardy) in self.handlers() {
            let message = format!("`{}` has no effect: {reason}", tardy.word.text);
            self.diagnostics.push(Diagnostic::new(Code::NoEffect, tardy.word.span, message).hint(hint));
        }
    }

    /// Returns the handlers of the instantiated reactors, each once, with the position of the reaction's class.
    fn handlers(&self) -> Vec<(usize, &'a crate::syntax::ast::TardySyntax)> {
        let mut found: BTreeMap<Span, _> = BTreeMap::new();
        let program = self.graph.program;
        for instance in program.tree.instances.values() {
            for reaction in &program.classes[instance.class.0].reactions {
                if let Some(tardy) = &reaction.ast.tardy {
                    found.insert(tardy.word.span, (instance.class.0, tardy));
                }
            }
        }
        found.into_values().collect()
    }

    /// Reports connections with attributes that have no meaning there.
    fn report_idle_connections(&mut self) {
        let main = self.graph.program.main();
        let counts = |span: Span| self.graph.links.values().any(|link| link.span == span && link.is_logical_network());
        let mut idle: BTreeMap<Span, (&str, bool)> = BTreeMap::new();
        for connection in main.connections.iter().filter(|connection| !counts(connection.span)) {
            for (name, wait) in [("@maxwait", connection.max_wait), ("@absent_after", connection.absent_after)] {
                if let Some(wait) = wait {
                    idle.insert(wait.span, (name, connection.physical));
                }
            }
        }
        for (span, (name, physical)) in idle {
            let reason = if physical {
                "messages of a physical connection have no tag, so nobody waits for them"
            } else {
                "this connection stays within a federate"
            };
            let message = format!("`{name}` has no effect: {reason}");
            self.diagnostics.push(Diagnostic::new(Code::NoEffect, span, message).hint("remove it"));
        }
    }

    /// Reports older handlers, with today's form.
    fn report_older_handlers(&mut self) {
        for (_, tardy) in self.handlers() {
            if tardy.absent_after.is_none() {
                continue;
            }
            let message = format!("`{}(…)` is an older form of `tardy`", tardy.word.text);
            let hint = "write `tardy {= … =}`, and the time as `@absent_after(…)` before the connection";
            self.diagnostics.push(Diagnostic::new(Code::OlderForm, tardy.word.span, message).hint(hint));
        }
    }

    /// Returns the `@maxwait` of a federate. An older parameter takes precedence over the attribute, as in LF.
    fn max_wait(&mut self, part: usize) -> i64 {
        let program = self.graph.program;
        let top = self.graph.program.parts.list[part].top;
        let instance = &program.tree.instances[top];
        let class = program.class(top);
        let child = instance.child.map(|child| &program.main().children[child]);
        let attribute = child.and_then(|child| child.max_wait);
        let is_older = |name: &str| OLDER_PARAMETERS.contains(&name.to_lowercase().as_str());
        let older = class.parameters.iter().position(|it| it.is_time && is_older(&it.name.text));
        let Some(older) = older else {
            let known = attribute.and_then(|wait| program.time(InstanceId::MAIN, wait.value, self.diagnostics));
            if let Some(wait) = attribute.filter(|_| !self.has_logical_input(part)) {
                let message = format!("`@maxwait` has no effect: `{}` gets no messages to wait for", instance.path);
                self.diagnostics.push(Diagnostic::new(Code::NoEffect, wait.span, message).hint("remove it"));
            }
            return known.unwrap_or(self.otherwise_ns);
        };
        let parameter = &class.parameters[older].name;
        if let Some(wait) = attribute {
            let message = format!(
                "`@maxwait` has no effect: the parameter `{}` of `{}` goes before it",
                parameter.text, class.name
            );
            let diagnostic = Diagnostic::new(Code::NoEffect, wait.span, message).hint("remove the parameter");
            self.diagnostics.push(diagnostic.also(parameter.span, "the parameter"));
        }
        let Some(max_wait_ns) = program.tree.parameter(top, older) else {
            let message = format!("how long `{}` waits is not known when the program is compiled", instance.path);
            let hint = "the parameter is given as code somewhere; write a time there, like `10 ms`";
            self.diagnostics.push(Diagnostic::new(Code::NotATime, parameter.span, message).hint(hint));
            return i64::MAX;
        };
        let older = self.older.entry(parameter.span).or_insert_with(|| (&parameter.text, Vec::new()));
        older.1.push((part, max_wait_ns));
        max_wait_ns
    }

    /// Reports older parameters, with today's form.
    fn report_older_parameters(&mut self) {
        for (span, (name, federates)) in std::mem::take(&mut self.older) {
            let waiting = federates.iter().filter(|(part, _)| self.has_logical_input(*part));
            let attributes: Vec<_> = waiting
                .map(|(part, ns)| {
                    format!(
                        "`@maxwait({})` before the instance `{}`",
                        Time(*ns),
                        self.graph.program.parts.list[*part].name
                    )
                })
                .collect();
            let hint = match &attributes[..] {
                [] => "remove it: no messages come to wait for".to_owned(),
                attributes => format!("remove it and write {}", attributes.join(", ")),
            };
            let message = format!("the parameter `{name}` of a federate is an older form of `@maxwait`");
            self.diagnostics.push(Diagnostic::new(Code::OlderForm, span, message).hint(hint));
        }
    }

    /// Reports each cycle that no federate can leave: all wait without end for messages that would come at once.
    fn report_deadlocks(&mut self, network: &NetworkPorts, waits: &Arena<LinkId, Waits>) {
        let (graph, parts) = (self.graph, &self.graph.program.parts);
        let cycles = Cycles::over(graph, |position, link| {
            let is_awaited = network.used[position] && waits[position].max_wait_ns == i64::MAX;
            is_awaited && link.is_logical_network() && link.delay.unwrap_or_default() == 0
        });
        let mut told = vec![false; parts.list.len()];
        for link in graph.links.values().filter(|link| link.is_logical_network()) {
            let ends = (graph.part(link.from), graph.part(link.to));
            let (Some(from), Some(to)) = ends else { continue };
            if !cycles.is_common(from, to) || told[from] {
                continue;
            }
            let all: Vec<usize> = (0..told.len()).filter(|part| cycles.is_common(from, *part)).collect();
            for part in &all {
                told[*part] = true;
            }
            let names: Vec<String> = all.iter().map(|part| format!("`{}`", parts.list[*part].name)).collect();
            let message = format!("{} wait for each other without end after the start", names.join(", "));
            let hint = "write `@maxwait(TIME)` before one of them, or before a connection of the cycle: how long it \
                        waits for messages, 0 where it need not wait";
            self.diagnostics.push(Diagnostic::new(Code::EndlessWait, link.span, message).hint(hint));
        }
    }

    fn has_logical_input(&self, part: usize) -> bool {
        let mut links = self.graph.links.values().filter(|link| link.is_logical_network());
        links.any(|link| self.graph.part(link.to) == Some(part))
    }

    /// Returns the offset of a reaction's older handler, 0 if it has none.
    fn absent_after(&mut self, step: StepId) -> i64 {
        let instance = self.graph.steps[step].instance;
        let reaction = self.graph.reaction(step);
        let tardy = reaction.and_then(|reaction| reaction.ast.tardy.as_ref());
        let offset = tardy.and_then(|tardy| tardy.absent_after.as_ref());
        let known = |value| self.graph.program.time(instance, value, self.diagnostics);
        offset.and_then(known).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::less;

    #[test]
    fn a_delay_shortens_a_wait_but_not_one_for_ever() {
        assert_eq!(less(5, 3), 2);
        assert_eq!(less(3, 5), 0);
        assert_eq!(less(i64::MAX, 5), i64::MAX);
    }
}

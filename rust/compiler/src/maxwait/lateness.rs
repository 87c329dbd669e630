// SPDX-License-Identifier: Apache-2.0
//! Computes the lateness of messages with the program's own waits, and finds waits that are too short.
//!
//! A federate that waits longer than necessary sends later than necessary, so these numbers differ from the smallest
//! offsets. The possible causes of an output matter: a federate that only answers messages of one other federate sends
//! when these have arrived, however long it would wait for them.

use std::collections::BTreeSet;

use serde::Serialize;

use super::connections::{TaggedConnections, send};
use crate::plan::{
    Argument, Federate, InputIndex, NetworkInput, Plan, PortIndex, ReactionIndex, ReactionKind, ReactionParameter,
    TriggerKind,
};

/// An input at which the program's wait is too short.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ShortWait {
    /// The connection; its position in [`Offsets::connections`](super::Offsets::connections).
    pub connection: usize,
    /// `@maxwait` in nanoseconds.
    pub max_wait_ns: i64,
    /// `@absent_after` in nanoseconds, less the delay.
    pub absent_after_ns: i64,
    /// The maximum time after its tag's time at which a message can arrive, in nanoseconds; `None` if there is no
    /// bound.
    pub needed_ns: Option<i64>,
}

impl ShortWait {
    /// Returns whether a message still arrives in time for its own tag, although a later one may have begun.
    pub fn absent_after_helps(&self) -> bool {
        self.needed_ns.is_some_and(|needed| self.max_wait_ns.saturating_add(self.absent_after_ns) >= needed)
    }
}

/// The absence of a bound, or of the end of a wait.
const FOREVER: i64 = i64::MAX;

/// The cause of a value at an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Cause {
    /// The first tag, which begins at once.
    Startup,
    /// A timer, an action or the like: its tag begins when no awaited message can precede it.
    OwnEvent,
    /// A message at an input.
    Message(InputIndex),
}

/// Returns the inputs at which a message can arrive after the wait for it has ended.
pub(super) fn short_waits(plan: &Plan, network: &TaggedConnections) -> Vec<ShortWait> {
    let lateness = lateness(plan, network);
    let mut short = Vec::new();
    for (connection, late) in lateness.into_iter().enumerate() {
        let ends = &network.connections[connection];
        let federate = &plan.federates[usize::from(ends.to)];
        let NetworkInput { max_wait_ns, absent_after_ns, .. } = federate.inputs[ends.input.0];
        if max_wait_ns < late && has_other_tags(plan, federate, ends.input) {
            let needed_ns = Some(late).filter(|late| *late < FOREVER);
            short.push(ShortWait { connection, max_wait_ns, absent_after_ns, needed_ns });
        }
    }
    short
}

/// Returns whether a federate has tags at which no message at this input can come, so that one can be late.
fn has_other_tags(plan: &Plan, federate: &Federate, input: InputIndex) -> bool {
    let others = federate.triggers.iter().any(|trigger| match trigger.kind {
        // No federate waits for a requested stop; all wait for the last tag of a time-out.
        TriggerKind::Startup | TriggerKind::Shutdown => false,
        TriggerKind::NetworkInput { input: other, .. } => other != input,
        _ => true,
    });
    others || plan.target.timeout_ns.is_some()
}

/// Returns, per connection, the maximum time after its tag's time at which a message arrives.
fn lateness(plan: &Plan, network: &TaggedConnections) -> Vec<i64> {
    let connections = &network.connections;
    let causes: Vec<_> = connections
        .iter()
        .map(|connection| {
            let federate = &plan.federates[usize::from(connection.from)];
            causes(plan, federate, federate.outputs[connection.output.0].source)
        })
        .collect();
    let mut late = vec![0_i64; connections.len()];
    // Without a cycle that adds lateness, each round settles one more connection of each path.
    for round in 0..=2 * connections.len() {
        let mut grown = false;
        for (position, connection) in connections.iter().enumerate() {
            let federate = &plan.federates[usize::from(connection.from)];
            let arrival = |input: InputIndex| {
                let into = connections.iter().position(|it| it.to == connection.from && it.input == input);
                into.map_or(0, |into| late[into])
            };
            let level = federate.reactions[send(federate, connection.output)].level;
            let sent = causes[position].iter().map(|cause| sending(federate, level, *cause, &arrival)).max();
            let arrives = match sent.unwrap_or(0) {
                FOREVER => FOREVER,
                sent => sent.saturating_add(connection.demand_ns()).max(0),
            };
            if arrives > late[position] {
                grown = true;
                late[position] = if round < connections.len() { arrives } else { FOREVER };
            }
        }
        if !grown {
            break;
        }
    }
    late
}

/// Returns the maximum time after the tag's time at which an output of this level is sent, if its value has this cause.
fn sending(federate: &Federate, level: u16, cause: Cause, arrival: &impl Fn(InputIndex) -> i64) -> i64 {
    let unknown = || {
        let inputs = federate.inputs.iter().enumerate();
        inputs.filter(|(index, input)| input.awaited && cause != Cause::Message(InputIndex(*index)))
    };
    let begin = match cause {
        Cause::Startup => 0,
        Cause::OwnEvent => unknown().map(|(_, input)| input.max_wait_ns).max().unwrap_or(0),
        Cause::Message(input) => unknown().map(|(_, input)| input.max_wait_ns).max().unwrap_or(0).max(arrival(input)),
    };
    let before = unknown().filter(|(_, input)| input.level <= level);
    let absent = before.map(|(_, input)| input.max_wait_ns.saturating_add(input.absent_after_ns)).max();
    begin.max(absent.unwrap_or(0))
}

/// Returns the possible causes of a port's value, within a federate.
fn causes(plan: &Plan, federate: &Federate, port: PortIndex) -> BTreeSet<Cause> {
    let mut causes = BTreeSet::new();
    let (mut open, mut seen) = (vec![port], BTreeSet::from([port]));
    while let Some(port) = open.pop() {
        for trigger in &federate.triggers {
            match trigger.kind {
                TriggerKind::NetworkInput { input, fills } if fills == port => {
                    let physical = federate.inputs[input.0].physical;
                    causes.insert(if physical { Cause::OwnEvent } else { Cause::Message(input) });
                }
                TriggerKind::Delay { fills, .. } if fills == port => {
                    causes.insert(Cause::OwnEvent);
                }
                _ => {}
            }
        }
        for (position, reaction) in federate.reactions.iter().enumerate() {
            if let ReactionKind::Copy { from, to } = reaction.kind {
                open.extend((to == port && seen.insert(from)).then_some(from));
            }
            let Some(dependencies) = dependencies(plan, federate, &reaction.kind) else { continue };
            if !dependencies.iter().any(|(it, argument)| it.effect && argument.ports().contains(&port)) {
                continue;
            }
            for (_, argument) in dependencies.iter().filter(|(parameter, _)| parameter.triggers) {
                if let Argument::Trigger(_) = argument {
                    causes.insert(Cause::OwnEvent);
                }
                open.extend(argument.ports().iter().filter(|port| seen.insert(**port)));
            }
            // Startup and shutdown are no arguments.
            for trigger in &federate.triggers {
                let cause = match trigger.kind {
                    TriggerKind::Startup if reaction.mode.is_none() => Cause::Startup,
                    TriggerKind::Startup | TriggerKind::Shutdown | TriggerKind::Reset => Cause::OwnEvent,
                    _ => continue,
                };
                if trigger.reactions.contains(&ReactionIndex(position)) {
                    causes.insert(cause);
                }
            }
        }
    }
    causes
}

/// Returns the variables of a reaction's body with their meanings.
fn dependencies<'p>(
    plan: &'p Plan,
    federate: &'p Federate,
    kind: &'p ReactionKind,
) -> Option<Vec<(&'p ReactionParameter, &'p Argument)>> {
    let ReactionKind::Body { instance, reaction, arguments } = kind else { return None };
    let declared = &plan.class(&federate.instances[instance.0]).reactions[reaction - 1];
    Some(declared.parameters.iter().zip(arguments).collect())
}

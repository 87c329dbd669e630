// SPDX-License-Identifier: Apache-2.0
//! The connections between federates, with the bounds of each.

use serde::Serialize;

use super::bounds::{Bounds, MissingBound};
use super::longest_paths::Edge;
use crate::plan::{Federate, InputIndex, OutputIndex, Plan, ReactionKind};

/// A connection from federate to federate, with the delays of its messages; times in nanoseconds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Connection {
    /// The name for messages: `unit_a.out -> unit_b.in`.
    pub name: String,
    /// The sending federate.
    pub from: u16,
    /// The receiving federate.
    pub to: u16,
    /// The time of the sender's reactions before the message is sent (L).
    pub lag_ns: i64,
    /// From sending to arrival (N).
    pub latency_ns: i64,
    /// Between the two clocks (E).
    pub clock_error_ns: i64,
    /// `after` (α).
    pub delay_ns: i64,
    #[serde(skip)]
    pub(super) output: OutputIndex,
    #[serde(skip)]
    pub(super) input: InputIndex,
}

impl Connection {
    /// Returns the additional wait of the receiver compared with the sender (X); negative if the delay exceeds the sum
    /// of all other terms.
    pub fn demand_ns(&self) -> i64 {
        let parts = [self.latency_ns, self.clock_error_ns];
        parts.iter().fold(self.lag_ns, |sum, part| sum.saturating_add(*part)).saturating_sub(self.delay_ns)
    }
}

/// All connections that carry tags.
#[derive(Debug)]
pub(super) struct TaggedConnections {
    pub(super) connections: Vec<Connection>,
}

impl TaggedConnections {
    /// Applies the bounds to a program; returns the missing ones.
    pub(super) fn of(plan: &Plan, bounds: &Bounds) -> Result<Self, Vec<MissingBound>> {
        let (mut connections, mut missing) = (Vec::new(), Vec::new());
        for to in &plan.federates {
            for (position, input) in to.inputs.iter().enumerate().filter(|(_, input)| !input.physical) {
                let from = &plan.federates[usize::from(input.federate)];
                let output = output(from, to, position);
                let lag = bounds.lag(plan, from, send(from, output));
                let latency = bounds.latency(plan, to, input);
                let latency = latency.ok_or_else(|| MissingBound::Latency(input.name.clone()));
                let clock_error = bounds.clock_error(from, to);
                let clock_error =
                    clock_error.ok_or_else(|| MissingBound::ClockError(from.name.clone(), to.name.clone()));
                match (lag, latency, clock_error) {
                    (Ok(lag_ns), Ok(latency_ns), Ok(clock_error_ns)) => connections.push(Connection {
                        name: input.name.clone(),
                        from: from.id,
                        to: to.id,
                        lag_ns,
                        latency_ns,
                        clock_error_ns,
                        delay_ns: input.delay_ns.unwrap_or_default(),
                        output,
                        input: InputIndex(position),
                    }),
                    (lag, latency, clock_error) => {
                        missing.extend([lag.err(), latency.err(), clock_error.err()].into_iter().flatten());
                    }
                }
            }
        }
        missing.sort();
        missing.dedup();
        if missing.is_empty() { Ok(Self { connections }) } else { Err(missing) }
    }

    /// Returns the connections as edges of a graph of federates.
    pub(super) fn edges(&self) -> Vec<Edge> {
        let edge = |connection: &Connection| Edge {
            from: usize::from(connection.from),
            to: usize::from(connection.to),
            weight: connection.demand_ns(),
        };
        self.connections.iter().map(edge).collect()
    }
}

/// Returns the output of a federate that sends the messages of another one's input.
fn output(from: &Federate, to: &Federate, input: usize) -> OutputIndex {
    let is_it =
        |output: &crate::plan::NetworkOutput| output.federate == to.id && output.port == to.port_of(InputIndex(input));
    OutputIndex(from.outputs.iter().position(is_it).expect("a plan has an output for every input"))
}

/// Returns the position of sending in the order of execution.
pub(super) fn send(federate: &Federate, output: OutputIndex) -> usize {
    let sends = federate.reactions.iter().position(|reaction| reaction.kind == ReactionKind::Send(output));
    sends.expect("a plan has a reaction for every output")
}

// SPDX-License-Identifier: Apache-2.0
//! Bounds the rate of events, and from that the number of events that can be in transit at the same time.
//!
//! A stream of events has a minimum spacing, or occurs once. A port's events are the streams of all reactions that
//! write it, a reaction's are those of its triggers. Timers and actions with a minimum spacing have a known spacing.
//! Actions without one do not, because a body may schedule them at any rate.

use std::collections::BTreeSet;

use super::graph::{Graph, Node, StepId, Work};
use crate::arena::Arena;
use crate::diagnostics::Diagnostics;
use crate::instances::{InstanceId, ModeInstanceId};
use crate::resolve::Variable;
use crate::syntax::ast::ActionKind;

/// The maximum number of distinct streams; more count as unknown.
const STREAMS_MAX: usize = 64;

/// The maximum number of reactions in a row that are followed back; streams from farther away count as unknown.
const CHAIN_MAX: usize = 200;

/// The minimum distance of two events of a stream in nanoseconds; `None` for a stream of one event.
pub(crate) type Stream = Option<i64>;

/// The streams of events at a port.
#[derive(Clone, Debug, Default)]
pub(super) struct Rate {
    /// The known streams.
    pub(super) streams: Vec<Stream>,
    /// Whether these are all streams.
    pub(super) complete: bool,
    /// The innermost modes that contain their timers and actions, or none: the distances hold in the time of these
    /// modes.
    modes: BTreeSet<Option<ModeInstanceId>>,
}

impl Rate {
    const NONE: Rate = Rate { streams: Vec::new(), complete: true, modes: BTreeSet::new() };
    const UNKNOWN: Rate = Rate { streams: Vec::new(), complete: false, modes: BTreeSet::new() };

    fn one(stream: Stream, mode: Option<ModeInstanceId>) -> Self {
        // A single event has no distance to others.
        let counts = stream.is_some() || mode.is_some();
        let modes = counts.then_some(mode).into_iter().collect();
        Rate { streams: vec![stream], complete: true, modes }
    }

    fn add(&mut self, other: Rate) {
        self.complete &= other.complete;
        self.streams.extend(other.streams);
        self.modes.extend(other.modes);
        if self.streams.len() > STREAMS_MAX {
            self.streams.truncate(STREAMS_MAX);
            self.complete = false;
        }
    }
}

/// Computes the rates of events at the ports of a program.
pub(super) struct Rates<'a> {
    graph: &'a Graph<'a>,
    /// The results so far, per storing port.
    known: Arena<Node, Option<Rate>>,
    depth: usize,
}

impl<'a> Rates<'a> {
    pub(super) fn new(graph: &'a Graph<'a>) -> Self {
        Self { graph, known: Arena::of(&graph.instance, None), depth: 0 }
    }

    /// Returns the events at a storing port, with their distances in the time of a mode, or of the program.
    pub(super) fn of_port_in(&mut self, root: Node, mode: Option<ModeInstanceId>) -> Rate {
        let mut rate = self.of_port(root);
        // The time of another mode stops at other times. A mode that is entered by history only is never earlier.
        let keeps = |origin: &Option<ModeInstanceId>| {
            let mut inner = self.graph.program.tree.modes_around(*origin).take_while(|around| Some(*around) != mode);
            let contains =
                mode.is_none() || self.graph.program.tree.modes_around(*origin).any(|around| Some(around) == mode);
            contains && inner.all(|around| !self.graph.resets.contains(&around))
        };
        rate.complete &= rate.modes.iter().all(keeps);
        rate
    }

    /// Returns the events at a storing port.
    fn of_port(&mut self, root: Node) -> Rate {
        if let Some(known) = &self.known[root] {
            return known.clone();
        }
        if self.depth == CHAIN_MAX {
            return Rate::UNKNOWN;
        }
        // During the computation, a cycle back to the port is unknown.
        self.known[root] = Some(Rate::UNKNOWN);
        self.depth += 1;
        let rate = if let Some(link) = self.graph.into[root].filter(|link| self.graph.links[*link].physical) {
            // The rate is that of the source, but physical time determines the distances.
            let source = self.of_port(self.graph.root[self.graph.links[link].from]);
            let once = source.complete && source.streams.iter().all(Option::is_none);
            if once { source } else { Rate::UNKNOWN }
        } else if let Some(link) = self.graph.into[root] {
            self.of_port(self.graph.root[self.graph.links[link].from])
        } else {
            let writers = self.graph.writers[root].clone();
            self.of_steps(&writers)
        };
        self.depth -= 1;
        self.known[root] = Some(rate.clone());
        rate
    }

    /// Returns the events that trigger any of these reactions.
    pub(super) fn of_steps(&mut self, steps: &[StepId]) -> Rate {
        let mut rate = Rate::NONE;
        for step in steps {
            if let Work::Copy(link) = self.graph.steps[*step].work {
                rate.add(self.of_port(self.graph.root[self.graph.links[link].from]));
            }
            let Some(reaction) = self.graph.reaction(*step) else { continue };
            let instance = self.graph.steps[*step].instance;
            for parameter in reaction.parameters.iter().filter(|parameter| parameter.triggers) {
                rate.add(self.of_variable(instance, parameter.variable));
            }
        }
        rate
    }

    fn of_variable(&mut self, instance: InstanceId, variable: Variable) -> Rate {
        // Invalid times have been reported before.
        let mut ignored = Diagnostics::default();
        let class = self.graph.program.class(instance);
        let mut time = |value: Option<&_>| {
            let time = value.and_then(|value| self.graph.program.time(instance, value, &mut ignored));
            time.filter(|ns| *ns > 0)
        };
        match variable {
            Variable::Startup | Variable::Shutdown => Rate::one(None, None),
            // The rate is that of entering a mode.
            Variable::Reset | Variable::Mode(..) => Rate::UNKNOWN,
            Variable::Timer(timer) => {
                let mode = self.graph.program.tree.mode_of(instance, class.timers[timer].mode);
                Rate::one(time(class.timers[timer].period.as_ref()), mode)
            }
            Variable::Action(action) => {
                let declared = class.actions[action].ast;
                // A watchdog is restarted only after it has expired.
                let is_watchdog = declared.kind == ActionKind::Watchdog;
                let spacing = if is_watchdog { &declared.min_delay } else { &declared.min_spacing };
                let mode = self.graph.program.tree.mode_of(instance, declared.mode);
                time(spacing.as_ref()).map_or(Rate::UNKNOWN, |spacing| Rate::one(Some(spacing), mode))
            }
            Variable::Port(port) => {
                let mut rate = Rate::NONE;
                for node in self.graph.nodes(instance, port) {
                    rate.add(self.of_port(self.graph.root[node]));
                }
                rate
            }
        }
    }
}

/// The additional capacity of a network input's queue in decentralized coordination, where no RTI counts the messages
/// in transit: the connection's buffers slow the sender when there is no room.
const DIRECT_CAPACITY: usize = 8;

/// The maximum number of messages in such a queue that follows from waits, so that a wait that is only meant to be
/// sufficient takes no memory. More messages arrive when there is room.
const WAITING_MAX: usize = 256;

/// Returns the default capacity of a network input's queue in decentralized coordination: messages of these streams
/// continue to arrive while their receiver waits.
pub(crate) fn direct_capacity(streams: &[Stream], delay: i64, wait: i64) -> usize {
    let waiting = in_flight(streams, delay.saturating_add(wait)).min(WAITING_MAX);
    in_flight(streams, delay).max(waiting).saturating_add(DIRECT_CAPACITY)
}

/// Returns the maximum number of events of these streams in transit at the same time when each takes `delay`
/// nanoseconds.
pub(crate) fn in_flight(streams: &[Stream], delay: i64) -> usize {
    let one = |stream: &Stream| match stream {
        None => 1,
        Some(spacing) => usize::try_from(delay / spacing).unwrap_or(usize::MAX).saturating_add(1),
    };
    streams.iter().map(one).fold(0, usize::saturating_add).max(1)
}

#[cfg(test)]
mod tests {
    use super::{direct_capacity, in_flight};

    #[test]
    fn a_delay_holds_what_it_spans_and_the_event_that_leaves() {
        assert_eq!(in_flight(&[Some(10)], 25), 3);
        assert_eq!(in_flight(&[Some(10)], 20), 3);
        assert_eq!(in_flight(&[Some(10), None], 0), 2);
        assert_eq!(in_flight(&[], 100), 1);
        assert_eq!(in_flight(&[Some(1), Some(1)], i64::MAX), usize::MAX);
    }

    #[test]
    fn a_queue_holds_what_comes_during_a_wait_up_to_a_limit() {
        assert_eq!(direct_capacity(&[Some(10)], 20, 0), 3 + 8);
        assert_eq!(direct_capacity(&[Some(10)], 20, 50), 8 + 8);
        assert_eq!(direct_capacity(&[Some(10)], 0, 100_000), 256 + 8);
        assert_eq!(direct_capacity(&[Some(10)], 5_000, 100_000), 501 + 8);
        assert_eq!(direct_capacity(&[], 0, 100_000), 1 + 8);
    }
}

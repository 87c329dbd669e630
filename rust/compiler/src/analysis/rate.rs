// SPDX-License-Identifier: Apache-2.0
//! How often events can occur, and from that how many can be on their way at the same time.
//!
//! A stream of events has a least spacing, or occurs once. A port's events are the streams of all reactions that write
//! it, a reaction's are those of its triggers. Timers and actions with a minimum spacing have a known spacing. Actions
//! without one do not, because a body may schedule them as often as it likes.

use super::graph::Graph;
use crate::diagnostics::Diagnostics;
use crate::instances::Tree;
use crate::resolve::{Class, Variable};

/// How many streams are told apart; more count as not known.
const STREAMS_MAX: usize = 64;

/// How many reactions in a row are followed back; events that come from further away count as not known.
const CHAIN_MAX: usize = 200;

/// The least distance of two events of a stream in nanoseconds; nothing for a stream of one event.
pub(super) type Stream = Option<i64>;

/// The streams of events at a port; nothing if they are not known.
type Answer = Option<Vec<Stream>>;

/// Answers how often the ports of a program can have events.
pub(super) struct Rates<'a> {
    graph: &'a Graph,
    tree: &'a Tree,
    classes: &'a [Class<'a>],
    /// Per storing port: the answer, if it has been asked for.
    known: Vec<Option<Answer>>,
    depth: usize,
}

impl<'a> Rates<'a> {
    pub(super) fn new(graph: &'a Graph, tree: &'a Tree, classes: &'a [Class<'a>]) -> Self {
        Self { graph, tree, classes, known: vec![None; graph.instance.len()], depth: 0 }
    }

    /// The streams of events at a storing port; nothing if they are not known.
    pub(super) fn of_port(&mut self, root: usize) -> Option<Vec<Stream>> {
        if let Some(known) = &self.known[root] {
            return known.clone();
        }
        if self.depth == CHAIN_MAX {
            return None;
        }
        // While it is being worked out, a cycle back to it is not known.
        self.known[root] = Some(None);
        self.depth += 1;
        let streams = if let Some(link) = self.graph.into[root] {
            self.of_port(self.graph.root[self.graph.links[link].from])
        } else {
            let writers = self.graph.writers[root].clone();
            self.of_steps(&writers)
        };
        self.depth -= 1;
        self.known[root] = Some(streams.clone());
        streams
    }

    /// The streams of all these reactions together.
    pub(super) fn of_steps(&mut self, steps: &[usize]) -> Option<Vec<Stream>> {
        let mut streams = Vec::new();
        for step in steps {
            let step = self.graph.steps[*step];
            let class = &self.classes[self.tree.instances[step.instance].class.0];
            let reaction = &class.reactions[step.reaction];
            for parameter in reaction.parameters.iter().filter(|parameter| parameter.triggers) {
                streams.extend(self.of_variable(step.instance, parameter.variable)?);
                if streams.len() > STREAMS_MAX {
                    return None;
                }
            }
        }
        Some(streams)
    }

    fn of_variable(&mut self, instance: usize, variable: Variable) -> Option<Vec<Stream>> {
        // What is not a time has been reported before.
        let mut ignored = Diagnostics::default();
        let class = &self.classes[self.tree.instances[instance].class.0];
        match variable {
            Variable::Startup | Variable::Shutdown => Some(vec![None]),
            Variable::Timer(timer) => {
                let period = class.timers[timer].period.as_ref();
                let period = period.and_then(|period| self.tree.time(instance, period, self.classes, &mut ignored));
                Some(vec![period.filter(|period| *period > 0)])
            }
            Variable::Action(action) => {
                let spacing = class.actions[action].ast.min_spacing.as_ref()?;
                let spacing = self.tree.time(instance, spacing, self.classes, &mut ignored)?;
                (spacing > 0).then(|| vec![Some(spacing)])
            }
            Variable::Port(port) => self.of_port(self.graph.root[self.graph.node(self.tree, instance, port)]),
        }
    }
}

/// How many events of these streams can be on their way at the same time when each takes `delay` nanoseconds.
pub(super) fn in_flight(streams: &[Stream], delay: i64) -> usize {
    let one = |stream: &Stream| match stream {
        None => 1,
        Some(spacing) => usize::try_from(delay / spacing).unwrap_or(usize::MAX).saturating_add(1),
    };
    streams.iter().map(one).fold(0, usize::saturating_add).max(1)
}

#[cfg(test)]
mod tests {
    use super::in_flight;

    #[test]
    fn a_delay_holds_what_it_spans_and_the_event_that_leaves() {
        assert_eq!(in_flight(&[Some(10)], 25), 3);
        assert_eq!(in_flight(&[Some(10)], 20), 3);
        assert_eq!(in_flight(&[Some(10), None], 0), 2);
        assert_eq!(in_flight(&[], 100), 1);
        assert_eq!(in_flight(&[Some(1), Some(1)], i64::MAX), usize::MAX);
    }
}

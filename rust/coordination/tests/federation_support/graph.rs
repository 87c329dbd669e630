// SPDX-License-Identifier: Apache-2.0
//! Random federations, and the inputs of each federate in a run without faults.

use std::collections::{BTreeMap, BTreeSet};

use lf_model::time::{Instant, Interval, Tag};
use proptest::collection::vec;
use proptest::prelude::*;

/// The time-out of every program, in ns after the start.
pub(crate) const END_NS: i64 = 40;

/// A connection between federates; its position in the list is its port, and its position in the order within a tag.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub(crate) from: u16,
    pub(crate) to: u16,
    /// The delay; `None` without `after`.
    pub(crate) delay: Option<Interval>,
}

/// The connections of a federation. The value on connection `i` depends on the timer, on the inputs of connections with
/// a delay, and on those of connections before `i` at the same tag. So there are cycles without delay, but no federate
/// waits for itself.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    pub(crate) edges: Vec<Edge>,
    /// The period of each federate's timer in ns; 0 for none.
    pub(crate) periods: Vec<i64>,
}

/// The inputs of a federate at each of its tags, as (port, value).
pub(crate) type Trace = BTreeMap<Tag, Inputs>;
pub(crate) type Inputs = BTreeSet<(u16, u32)>;

pub(crate) fn any_graph() -> impl Strategy<Value = Graph> {
    (2..6u16, any::<bool>()).prop_flat_map(|(federates, cycles)| {
        let edge = (0..federates, 0..federates, 0..4i64, 1..12i64).prop_map(move |(from, to, kind, ns)| {
            // No cycle has a delay of microsteps only, because it could continue without end at one time; and a
            // federate reaches itself within a tag only by way of others.
            let delay = match kind {
                0 if from < to && !cycles => Some(Interval::ZERO),
                1 | 2 if from < to || (cycles && from != to) => None,
                _ => Some(Interval::from_nanos(ns)),
            };
            Edge { from, to, delay }
        });
        let periods = vec(prop_oneof![1 => Just(0i64), 3 => 1..15i64], usize::from(federates));
        (vec(edge, 1..10), periods).prop_map(|(edges, periods)| Graph { edges, periods })
    })
}

impl Graph {
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (u16, Edge)> {
        (0..).zip(self.edges.iter().copied())
    }

    /// Returns whether a federate reaches another one, or itself, over connections without delay.
    fn reaches(&self, from: u16, to: u16) -> bool {
        let mut reached = BTreeSet::new();
        let mut open = vec![from];
        while let Some(at) = open.pop() {
            let next = self.edges.iter().filter(|edge| edge.from == at && edge.delay.is_none()).map(|edge| edge.to);
            open.extend(next.filter(|next| reached.insert(*next)));
        }
        reached.contains(&to)
    }

    /// Returns whether the receiver waits within a tag for messages over this connection.
    pub(crate) fn is_awaited(&self, edge: Edge) -> bool {
        edge.delay.is_none() && self.reaches(edge.to, edge.from)
    }

    /// Returns whether the sender reports absences to the receiver.
    pub(crate) fn tells_absence(&self, edge: Edge) -> bool {
        edge.delay.is_none() && self.reaches(edge.from, edge.from) && self.reaches(edge.to, edge.to)
    }

    /// Returns the value on connection `port` at a tag, if there is one. `fires`: whether the sender's timer fires.
    pub(crate) fn value(&self, port: u16, offset: i64, fires: bool, inputs: &Inputs) -> Option<u32> {
        let is_seen = |input: u16| self.edges[usize::from(input)].delay.is_some() || input < port;
        let seen_inputs: Vec<_> = inputs.iter().filter(|(input, _)| is_seen(*input)).collect();
        let value = seen_inputs.iter().fold(u32::from(port) * 7 + 1, |sum, (port, value)| {
            sum.wrapping_mul(31).wrapping_add(u32::from(*port)).wrapping_mul(31).wrapping_add(*value)
        });
        let acts = fires || !seen_inputs.is_empty();
        // At some tags there is no value.
        (acts && value.wrapping_add(u32::try_from(offset).unwrap()) % 3 != 0).then_some(value)
    }

    /// Returns the next time at which the timer fires after this tag; all timers fire at the start.
    pub(crate) fn next_timer(&self, federate: u16, tag: Tag) -> Option<Tag> {
        let period = self.periods[usize::from(federate)];
        (period > 0).then(|| Tag::at(tag.time + Interval::from_nanos(period)))
    }

    /// Returns the inputs of each federate: runs the whole federation as one program, tag by tag.
    pub(crate) fn expected(&self) -> Vec<Trace> {
        let end = Tag::at(Instant::from_nanos(END_NS));
        let mut traces = vec![Trace::new(); self.periods.len()];
        // By tag and federate, whether its timer fires, and its inputs.
        let mut pending: BTreeMap<Tag, BTreeMap<u16, (bool, Inputs)>> = BTreeMap::new();
        for federate in (0..).take(self.periods.len()) {
            pending.entry(Tag::at(Instant::from_nanos(0))).or_default().entry(federate).or_default().0 = true;
            pending.entry(end).or_default().entry(federate).or_default();
        }
        while let Some((tag, mut events)) = pending.pop_first().filter(|(tag, _)| *tag <= end) {
            for (port, edge) in self.numbered() {
                let (fires, inputs) = events.get(&edge.from).cloned().unwrap_or_default();
                let Some(value) = self.value(port, tag.time.as_nanos(), fires, &inputs) else { continue };
                let target = match edge.delay {
                    None => &mut events,
                    Some(delay) => pending.entry(tag.after(delay)).or_default(),
                };
                target.entry(edge.to).or_default().1.insert((port, value));
            }
            for (federate, (fires, inputs)) in events {
                if let Some(next) = self.next_timer(federate, tag).filter(|_| fires) {
                    pending.entry(next).or_default().entry(federate).or_default().0 = true;
                }
                traces[usize::from(federate)].insert(tag, inputs);
            }
        }
        traces
    }
}

// SPDX-License-Identifier: Apache-2.0
//! The tags of all federates: announced, completed and granted tags, the graph between the federates, and messages in
//! transit.
//!
//! This part knows neither connections nor when a grant can be sent: it receives the tags of federates and the grants
//! that were sent, and computes what can be granted (module `grants`), which next events matter to those upstream, and
//! how far a receiver is behind.

use lf_model::time::{Instant, Tag};

use super::graph::{Graph, Node};
#[cfg(feature = "transients")]
use super::horizon::Horizon;
use super::idle::Idle;
use super::in_transit::InTransit;
use super::storage::id;
use super::suspected_violation::SuspectedViolation;
use super::tag_state::TagState;
use crate::{Deadline, FederateId};

/// The tags of all federates.
pub(super) struct Tags<'s> {
    pub(super) graph: Graph<'s>,
    /// The storage for messages in transit, the same number of entries for each federate.
    pub(super) in_transit: &'s mut [Tag],
    pub(super) start: Option<Instant>,
    pub(super) idle: Idle,
    #[cfg(feature = "transients")]
    pub(super) horizon: Horizon,
}

impl<'s> Tags<'s> {
    /// Returns the state before the start.
    pub(super) fn new(graph: Graph<'s>, in_transit: &'s mut [Tag]) -> Self {
        Self {
            graph,
            in_transit,
            start: None,
            idle: Idle::default(),
            #[cfg(feature = "transients")]
            horizon: Horizon::default(),
        }
    }

    /// Returns the number of federates.
    pub(super) fn federates(&self) -> usize {
        self.graph.nodes.len()
    }

    pub(super) fn state(&self, federate: usize) -> &TagState {
        &self.graph.nodes[federate].tags
    }

    pub(super) fn state_mut(&mut self, federate: usize) -> &mut TagState {
        &mut self.graph.nodes[federate].tags
    }

    /// Returns the number of different tags of messages in transit to one federate that are stored.
    pub(super) fn in_transit_max(&self) -> usize {
        self.in_transit.len() / self.federates()
    }

    /// Returns the messages in transit to a federate.
    pub(super) fn in_transit(&mut self, federate: usize) -> InTransit<'_> {
        let share = self.in_transit_max();
        InTransit {
            ring: &mut self.graph.nodes[federate].tags.in_transit,
            storage: &mut self.in_transit[federate * share..][..share],
        }
    }

    /// Begins logical time, when all neighbor structures are there.
    pub(super) fn begin(&mut self, start: Instant) {
        self.start = Some(start);
        self.graph.find_paths();
    }

    /// Sets the next event of a federate to `tag`, or to that of the first message in transit to it. Returns whether
    /// the federate needs a grant for it.
    pub(super) fn set_next_event(&mut self, federate: usize, tag: Tag) -> bool {
        let tag = tag.min(self.in_transit(federate).earliest());
        self.graph.set_next_event(federate, tag);
        let needs_grant = self.graph.upstreams(federate) > 0;
        if !needs_grant {
            // This counts as a grant.
            self.state_mut(federate).granted = tag;
        }
        needs_grant
    }

    /// Records whether any federate has a next event, after one has announced its own.
    pub(super) fn record_next_event(&mut self, next_event: Tag) {
        let mut idle = self.idle;
        idle.note(next_event, || self.is_idle());
        self.idle = idle;
    }

    /// Handles that there may have been no event for some time. Returns whether to grant FOREVER to all.
    pub(super) fn handle_idleness(&mut self, now: Instant) -> bool {
        let mut idle = self.idle;
        let told = idle.handle_timeout(now, || self.is_idle());
        self.idle = idle;
        told
    }

    /// Returns whether no federate has a next event. Looks at every federate once.
    fn is_idle(&self) -> bool {
        #[cfg(feature = "transients")]
        if self.expects_transients() {
            return false;
        }
        let none = |node: &Node| node.tags.departed || node.next_event == Tag::FOREVER;
        self.start.is_some() && self.graph.nodes.iter().all(none)
    }

    /// Records a message in transit to a federate. Returns whether it is too late, and whether this is the first that
    /// cannot be stored one by one.
    pub(super) fn message_forwarded(&mut self, to: usize, tag: Tag) -> (bool, bool) {
        let state = self.state(to);
        let late = state.completed >= tag;
        let reach = state.reach();
        (late, !late && self.in_transit(to).insert(tag, reach))
    }

    /// Handles that a federate has left: the others go on without it. Returns whether others may wait for it within a
    /// tag.
    pub(super) fn depart(&mut self, federate: usize) -> bool {
        let is_awaited = self.graph.in_zero_delay_cycle(federate) || self.graph.nodes[federate].deserted;
        self.state_mut(federate).departed = true;
        self.graph.set_next_event(federate, Tag::FOREVER);
        self.graph.cut_off(federate);
        is_awaited
    }

    /// Returns whether `other` is connected into `federate`.
    pub(super) fn is_upstream(&self, federate: usize, other: usize) -> bool {
        let mut upstreams = (0..self.graph.upstreams(federate)).map(|index| self.graph.upstream(federate, index).0);
        upstreams.any(|upstream| upstream == other)
    }

    /// Returns whether `other` was connected into `federate` and has left.
    pub(super) fn is_upstream_left(&self, federate: usize, other: usize) -> bool {
        self.state(other).departed && self.is_upstream(federate, other)
    }

    /// Handles that all have left.
    pub(super) fn depart_all(&mut self) {
        for node in self.graph.nodes.iter_mut() {
            node.tags = TagState { departed: true, ..TagState::EMPTY };
        }
    }

    /// Limits all next events to the stop tag.
    pub(super) fn stop(&mut self, tag: Tag) {
        self.graph.limit_next_events(tag);
    }

    /// Returns the tag up to which the next events of a federate do not matter downstream of it, if it is to be told:
    /// its last DNET is another one, and its known next event is not beyond that tag. In and before a cycle without
    /// delay, all its next events matter, and that tag is NEVER.
    pub(super) fn downstream_next_event(&self, federate: usize) -> Option<Tag> {
        let told = self.state(federate).dnet;
        if self.graph.leads_to_zero_delay_cycle(federate) || self.graph.in_zero_delay_cycle(federate) {
            // A federate that has come may have closed the cycle since.
            return (told != Tag::NEVER).then_some(Tag::NEVER);
        }
        let earliest = self.graph.earliest_needed(federate);
        // The next event of one of those downstream may be unknown.
        let is_known = self.start.is_some_and(|start| earliest >= Tag::at(start));
        (is_known && earliest != told && self.graph.next_event(federate) <= earliest).then_some(earliest)
    }

    /// Returns whether a receiver is too far behind the sender of the next message (module `window`).
    pub(super) fn is_behind(&mut self, receiver: usize, sender: usize, stop: Option<Tag>, window: u16) -> bool {
        // Not later than the tag at which the sender has sent the message at the front of its connection.
        let position = self.graph.next_event(sender).min(stop.unwrap_or(Tag::FOREVER));
        self.in_transit(receiver).has_before(position, window.into())
    }

    /// Returns the suspected violation if a federate completes this tag without a grant. Federates without upstream
    /// federates need no grants, and neither do those that announce nothing, as with decentralized coordination.
    pub(super) fn check_completed(&self, federate: usize, tag: Tag) -> Option<SuspectedViolation> {
        let asks = self.graph.upstreams(federate) > 0 && self.graph.next_event(federate) != Tag::NEVER;
        (asks && tag > self.state(federate).reach()).then_some(SuspectedViolation::NotGranted(tag))
    }

    /// Returns the suspected violation if a federate announces an event that is over.
    pub(super) fn check_next_event(&self, federate: usize, next: Tag) -> Option<SuspectedViolation> {
        let completed = self.state(federate).completed;
        (next <= completed && completed != Tag::FOREVER).then_some(SuspectedViolation::Backwards { next, completed })
    }

    /// Returns the time of the first announced event of any federate after this time.
    pub(super) fn next_event_after(&self, now: Instant) -> Deadline {
        let there = self.graph.nodes.iter().filter(|node| !node.tags.departed);
        let times = there.map(|node| node.next_event.time).filter(|time| *time > now && *time < Instant::FOREVER);
        times.min().into()
    }

    /// Returns the tag whose grant a federate waits for.
    pub(super) fn awaited(&self, federate: usize) -> Option<Tag> {
        let next = self.graph.next_event(federate);
        let waits = self.graph.upstreams(federate) > 0 && next > self.state(federate).reach();
        (waits && next != Tag::NEVER && next != Tag::FOREVER).then_some(next)
    }

    /// Returns the federate that keeps the RTI from granting more to another one, and its next event.
    pub(super) fn blocking_federate(&self, federate: usize) -> Option<(FederateId, Tag)> {
        let by = self.graph.earliest_source(federate)?;
        Some((id(by), self.graph.next_event(by)))
    }

    /// Clears caches and meaningless values.
    pub(super) fn normalize(&mut self) {
        for federate in 0..self.federates() {
            self.in_transit(federate).normalize();
            self.graph.nodes[federate].blocking = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use lf_model::time::Interval;
    use lf_wire::{DELAY_NONE, NeighborStructure};

    use super::super::grants::Grant;
    use super::super::graph::Node;
    use super::super::path::PathWords;
    use super::*;

    const START: Instant = Instant::from_nanos(1_000);
    const FEDERATES: usize = 3;

    fn at(time: i64) -> Tag {
        Tag::at(START + Interval::from_nanos(time))
    }

    /// Calls `look` with the tags of three federates with these connections, after the start.
    fn with_tags(edges: &[(u16, u16, i64)], look: impl FnOnce(&mut Tags<'_>)) {
        let mut nodes = [Node::EMPTY; FEDERATES];
        let mut upstream = [PathWords::default(); FEDERATES * FEDERATES];
        let mut paths = [PathWords::default(); 2 * FEDERATES * FEDERATES];
        let mut in_transit = [Tag::NEVER; 2 * FEDERATES];
        let graph = Graph::new(&mut nodes, &mut upstream, &mut paths, true);
        let mut tags = Tags::new(graph, &mut in_transit);
        for to in 0..FEDERATES {
            let into = edges.iter().filter(|edge| usize::from(edge.1) == to).map(|edge| (edge.0, edge.2));
            let list: std::vec::Vec<_> = into.collect();
            let neighbors = NeighborStructure::new(&list, &[]);
            assert_eq!(tags.graph.set_upstream(to, neighbors.upstream()), Ok(()));
        }
        tags.begin(START);
        look(&mut tags);
    }

    #[test]
    fn a_grant_reaches_to_just_before_what_can_come() {
        with_tags(&[(0, 1, 5)], |tags| {
            assert!(!tags.set_next_event(0, at(10)) && tags.set_next_event(1, at(12)));
            assert_eq!(tags.grant(1), Some(Grant::Final(at(15).before())));
            tags.granted(1, Grant::Final(at(15).before()));
            assert_eq!((tags.grant(1), tags.awaited(1)), (None, None));
            tags.set_next_event(1, at(15));
            assert_eq!((tags.grant(1), tags.awaited(1)), (None, Some(at(15))));
            assert_eq!(tags.blocking_federate(1), Some((FederateId(0), at(10))));
            // A federate that has left sends nothing any more.
            tags.depart(0);
            assert_eq!(tags.grant(1), Some(Grant::Final(Tag::FOREVER)));
        });
    }

    #[test]
    fn a_provisional_grant_calls_those_upstream_of_it_to_its_tag() {
        with_tags(&[(0, 1, DELAY_NONE), (1, 0, DELAY_NONE)], |tags| {
            tags.set_next_event(0, at(10));
            tags.set_next_event(1, at(20));
            assert_eq!(tags.grant(1), None);
            assert_eq!(tags.grant(0), Some(Grant::Provisional(at(10))));
            tags.granted(0, Grant::Provisional(at(10)));
            assert_eq!([0; 3].map(|_| tags.graph.take_mark()), [Some(0), Some(1), None]);
            assert_eq!(tags.grant(1), Some(Grant::Provisional(at(10))));
        });
    }

    #[test]
    fn a_message_on_its_way_counts_as_an_event_until_it_has_been_seen() {
        with_tags(&[(0, 1, 5), (1, 2, DELAY_NONE)], |tags| {
            tags.set_next_event(1, at(30));
            assert_eq!(tags.message_forwarded(1, at(20)), (false, false));
            tags.set_next_event(1, at(30));
            assert_eq!(tags.graph.next_event(1), at(20));
            assert!(tags.is_behind(1, 0, None, 1) == (tags.graph.next_event(0) > at(20)));
            tags.state_mut(1).completed = at(20);
            tags.in_transit(1).complete(at(20));
            tags.set_next_event(1, at(30));
            assert_eq!(tags.graph.next_event(1), at(30));
            assert_eq!(tags.message_forwarded(1, at(20)), (true, false));
        });
    }

    #[test]
    fn the_form_of_the_memory_does_not_depend_on_the_past() {
        with_tags(&[(0, 1, 5)], |tags| {
            for time in [20, 30] {
                tags.message_forwarded(1, at(time));
            }
            tags.in_transit(1).complete(at(20));
            tags.graph.nodes[1].blocking = 1;
            tags.normalize();
            let InTransit { ring, storage } = tags.in_transit(1);
            assert_eq!((ring.head, &*storage), (0, &[at(30), Tag::NEVER][..]));
            assert_eq!(tags.graph.nodes[1].blocking, 0);
        });
    }

    #[test]
    fn those_upstream_are_told_what_matters_and_only_when_it_changes() {
        with_tags(&[(0, 1, 5)], |tags| {
            tags.set_next_event(0, at(3));
            tags.set_next_event(1, at(20));
            let needed = tags.downstream_next_event(0);
            assert!(needed.is_some_and(|tag| tag >= at(15) && tag < at(16)));
            tags.state_mut(0).dnet = needed.unwrap_or(Tag::NEVER);
            assert_eq!(tags.downstream_next_event(0), None);
        });
    }

    #[test]
    fn all_are_idle_when_nobody_who_is_there_has_an_event() {
        with_tags(&[(0, 1, 5)], |tags| {
            for federate in 0..2 {
                tags.set_next_event(federate, Tag::FOREVER);
                tags.record_next_event(Tag::FOREVER);
            }
            assert_eq!(tags.idle.deadline(), Deadline::Never);
            tags.depart(2);
            tags.record_next_event(Tag::FOREVER);
            assert_eq!(tags.idle.deadline(), Deadline::Now);
        });
    }
}

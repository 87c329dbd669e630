// SPDX-License-Identifier: Apache-2.0
//! The tags that a federate may advance to.
//!
//! The RTI sends a TAG when nothing can arrive any more up to it, for one of two reasons: the federates immediately
//! upstream have completed everything that could lead there, or the next events of all upstream federates are too late.
//! It sends a PTAG in a cycle without delay, where the next event of every federate waits for that of the others. A
//! PTAG also makes the federates upstream advance to that tag if they can, because the receiver may wait for their
//! messages at it.

use lf_derive::outlined;
use lf_model::time::{Instant, Tag};

use super::delay::latest_before;
use super::graph::number;
use super::idle::Idle;
use super::tag_state::TagState;
use super::tags::Tags;

/// A grant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Grant {
    Final(Tag),
    Provisional(Tag),
}

impl Tags<'_> {
    /// Records that a federate has been sent this grant. Marks federates in the graph that may be granted more because
    /// of it: after a PTAG, those upstream of it that it may wait for, and itself.
    ///
    /// Each PTAG is later than the one before to the same federate and is one of the tags that the federates have
    /// announced, so processing the marks ends.
    pub(super) fn granted(&mut self, federate: usize, grant: Grant) {
        let (Grant::Final(tag) | Grant::Provisional(tag)) = grant;
        self.in_transit(federate).grant(tag);
        let state = self.state_mut(federate);
        match grant {
            Grant::Final(_) => state.granted = tag,
            Grant::Provisional(_) => state.provisional = tag,
        }
        if self.demand(federate).is_some() {
            // Another federate waits for a later tag.
            self.graph.mark(federate);
        }
        if grant == Grant::Provisional(tag) {
            self.demand_upstream(federate, tag);
            // Those upstream may have been granted more than this already.
            self.graph.mark(federate);
        }
    }

    /// Marks the federates immediately upstream of one that has received a PTAG. The earliest demand comes first,
    /// because a later one may depend on it.
    fn demand_upstream(&mut self, federate: usize, tag: Tag) {
        let by = number(federate);
        for index in 0..self.graph.upstreams(federate) {
            let (from, _) = self.graph.upstream(federate, index);
            if self.demand(from).is_none_or(|demanded| tag < demanded) {
                self.state_mut(from).demand = Some((tag, by));
            }
            self.graph.mark(from);
        }
    }

    /// Returns what a federate can be granted now beyond its last grant.
    #[outlined]
    pub(super) fn grant(&mut self, federate: usize) -> Option<Grant> {
        let grant = self.possible_grant(federate)?;
        #[cfg(feature = "transients")]
        let grant = self.limited_grant(federate, grant)?;
        Some(grant)
    }

    /// Returns what a federate can be granted if nobody else comes.
    fn possible_grant(&mut self, federate: usize) -> Option<Grant> {
        let start = self.start?;
        let TagState { granted, provisional, .. } = *self.state(federate);
        let new = |tag: Tag| tag > granted && tag >= provisional;
        let waits = self.graph.upstreams(federate) > 0;
        if waits && let Some(completed) = self.completed_upstream(federate) {
            return Some(Grant::Final(completed));
        }
        let earliest = self.graph.earliest_incoming(federate, start);
        if waits {
            // The question for the earliest message may have set an unknown next event to the start.
            let next_event = self.graph.next_event(federate);
            if earliest > next_event && next_event != Tag::NEVER && new(latest_before(earliest)) {
                return Some(Grant::Final(latest_before(earliest)));
            }
            if earliest == next_event
                && self.graph.in_zero_delay_cycle(federate)
                && next_event > granted.max(provisional)
                && self.earliest_incoming_strict(federate, start) > next_event
            {
                return Some(Grant::Provisional(next_event));
            }
        }
        if waits && self.idle == Idle::Told && earliest == Tag::FOREVER && new(Tag::FOREVER) {
            return Some(Grant::Final(Tag::FOREVER));
        }
        if let Some(demanded) = self.demand(federate) {
            if earliest > demanded {
                return Some(Grant::Final(demanded));
            }
            if earliest == demanded
                && demanded > provisional
                && self.earliest_incoming_strict(federate, start) > demanded
            {
                return Some(Grant::Provisional(demanded));
            }
        }
        let complete = self.state(federate).completed >= provisional || granted >= provisional;
        if complete || !self.may_wait_for_ever(federate) {
            return None;
        }
        let is_known = earliest > provisional || self.upstream_is_past(federate, provisional, start);
        is_known.then_some(Grant::Final(provisional))
    }

    /// Returns whether each federate immediately upstream has completed everything that can lead to a message at this
    /// tag, or has nothing that can.
    fn upstream_is_past(&mut self, federate: usize, tag: Tag, start: Instant) -> bool {
        (0..self.graph.upstreams(federate)).all(|index| {
            let (from, delay) = self.graph.upstream(federate, index);
            self.graph.begins_after(from, tag) || self.completed_by(federate, index) >= tag || {
                // A TAG promises that nothing comes up to it, though a path may lead there through a federate that has
                // come since, and begins later.
                let promised = self.state(from).granted.next_microstep();
                let earliest = self.graph.earliest_incoming(from, start).max(promised);
                delay.after(self.graph.next_event(from).min(earliest)) > tag
            }
        })
    }

    /// Returns whether a federate at a provisionally granted tag may wait there without end: it is there only because
    /// others have an event at that tag, and one whose message or absence it needs has been granted the tag otherwise
    /// and passes by it, or has left, or has come and begins later.
    fn may_wait_for_ever(&self, federate: usize) -> bool {
        let tag = self.state(federate).provisional;
        let mut upstream = (0..self.graph.upstreams(federate)).map(|index| self.graph.upstream(federate, index).0);
        let passes_by = |from: usize| {
            let is_silent = self.state(from).completed < tag || self.graph.begins_after(from, tag);
            self.graph.share_zero_delay_cycle(from, federate) && is_silent
        };
        self.graph.nodes[federate].deserted || upstream.any(passes_by)
    }

    /// Returns the earliest tag at which a federate immediately downstream waits for this one, if this one has not
    /// reached it. The stored demand is one of those; when it is met, looks for another one.
    pub(super) fn demand(&mut self, federate: usize) -> Option<Tag> {
        let (tag, by) = self.state(federate).demand?;
        if !self.is_demanded(federate, tag, by.into()) {
            self.state_mut(federate).demand = self.find_demand(federate);
        }
        self.state(federate).demand.map(|(tag, _)| tag)
    }

    /// Looks at all federates downstream.
    fn find_demand(&self, federate: usize) -> Option<(Tag, u16)> {
        let row = self.graph.nodes[federate].outgoing;
        let downstream = (0..row.len).map(|index| self.graph.other_end(row, index));
        let waiting = downstream.filter(|by| {
            let upstream = |index| self.graph.upstream(*by, index).0 == federate;
            self.is_demanded(federate, self.state(*by).provisional, *by) && (0..self.graph.upstreams(*by)).any(upstream)
        });
        waiting.map(|by| (self.state(by).provisional, number(by))).min()
    }

    /// Returns whether a federate downstream still waits at a tag for this one, and this one has not reached it.
    fn is_demanded(&self, federate: usize, tag: Tag, by: usize) -> bool {
        let TagState { granted, provisional, completed, .. } = *self.state(federate);
        let downstream = self.state(by);
        let waits = !downstream.departed
            && downstream.completed < tag
            && downstream.granted < tag
            && downstream.provisional == tag;
        waits && completed < tag && granted < tag && provisional <= tag
    }

    /// Returns the tag up to which all federates immediately upstream have completed what can lead to a message, if
    /// that reaches the next event and is more than has been granted.
    ///
    /// Otherwise it stores a federate that has not completed enough and asks it first the next time. So this costs one
    /// step, unless that federate has proceeded; and it passes each federate that has proceeded once for each grant.
    fn completed_upstream(&mut self, federate: usize) -> Option<Tag> {
        let TagState { granted, provisional, .. } = *self.state(federate);
        let next_event = self.graph.next_event(federate);
        let count = self.graph.upstreams(federate);
        let mut index = self.graph.nodes[federate].blocking;
        let mut earliest = Tag::FOREVER;
        for _ in 0..count {
            // The connections may have changed since it was stored.
            index = if index < count { index } else { 0 };
            let completed = self.completed_by(federate, index);
            if completed < next_event || completed < provisional || completed <= granted {
                self.graph.nodes[federate].blocking = index;
                return None;
            }
            earliest = earliest.min(completed);
            index += 1;
        }
        Some(earliest)
    }

    /// Returns what one federate immediately upstream has completed, seen from this one. One that is not there sends
    /// nothing.
    fn completed_by(&self, federate: usize, index: usize) -> Tag {
        let (from, delay) = self.graph.upstream(federate, index);
        let upstream = self.state(from);
        if upstream.departed { Tag::FOREVER } else { delay.after_strictly(upstream.completed) }
    }

    /// Returns the earliest tag with which a message may still come, but only over the immediate connections from
    /// federates that are not in the same cycle without delay.
    ///
    /// The receiver of a PTAG waits for the messages of those in the same cycle at the tag. It does not wait for those
    /// in another cycle, so nothing may come from them any more; the stock RTI exempts them too.
    fn earliest_incoming_strict(&mut self, federate: usize, start: Instant) -> Tag {
        let mut earliest = Tag::FOREVER;
        for index in 0..self.graph.upstreams(federate) {
            let (from, delay) = self.graph.upstream(federate, index);
            if self.graph.share_zero_delay_cycle(from, federate) {
                continue;
            }
            let incoming = self.graph.earliest_incoming(from, start);
            earliest = earliest.min(delay.after(self.graph.next_event(from).min(incoming)));
        }
        earliest
    }
}

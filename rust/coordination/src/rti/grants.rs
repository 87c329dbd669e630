// SPDX-License-Identifier: Apache-2.0
//! Which tags a federate may advance to.
//!
//! A TAG is sent when nothing can arrive any more up to it, for one of two reasons: the federates immediately upstream
//! have completed all that could lead there, or the next events of all upstream federates are too late. A PTAG is sent
//! in a cycle without delay, where the next event of every federate waits for that of the others. It also makes the
//! federates upstream go to that tag if they can, for the receiver may wait for what they do at it.

use lf_model::time::{Instant, Tag};
use lf_wire::june_2026::Message;

use super::delay::latest_before;
use super::graph::Graph;
use super::storage::Membership;
use super::{Outlet, Rti, Slot, id};
use crate::tag::to_wire;

/// What can be granted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grant {
    Final(Tag),
    Provisional(Tag),
}

impl Rti<'_> {
    /// Grants a federate what it can be granted, and, if that is a PTAG, federates upstream of it what it may wait for.
    /// Does nothing for a federate that is not there; puts the grant off if there is no room.
    ///
    /// Each PTAG is later than the one before to the same federate and is one of the tags that the federates have
    /// announced, so this ends.
    pub(super) fn advance(&mut self, federate: usize, outlet: &mut impl Outlet) {
        let mut granted = self.advance_one(federate, outlet).map(|tag| (federate, tag));
        while let Some((federate, tag)) = granted.take() {
            self.demand_upstream(federate, tag);
            while let Some(next) = self.slots.iter().position(|slot| slot.look) {
                self.slots[next].look = false;
                if let Some(tag) = self.advance_one(next, outlet) {
                    granted = Some((next, tag));
                    break;
                }
            }
        }
    }

    /// Sends one federate its grant. Returns the tag if it is a provisional one.
    fn advance_one(&mut self, federate: usize, outlet: &mut impl Outlet) -> Option<Tag> {
        let start = self.start?;
        self.connection_of(federate)?;
        let grant = grant(self.slots, &self.graph, federate, start)?;
        let Some(connection) = self.ready_for_tag(federate, outlet) else {
            self.slots[federate].pending.grant = true;
            return None;
        };
        match grant {
            Grant::Final(tag) => {
                outlet.send(connection, &Message::TagGrant(to_wire(tag)));
                self.slots[federate].granted = tag;
                None
            }
            Grant::Provisional(tag) => {
                outlet.send(connection, &Message::ProvisionalTagGrant(to_wire(tag)));
                self.slots[federate].provisional = tag;
                Some(tag)
            }
        }
    }

    /// A federate has got a PTAG: those immediately upstream are looked at.
    fn demand_upstream(&mut self, federate: usize, tag: Tag) {
        let by = id(federate).0;
        for connection in self.graph.upstream(federate) {
            let upstream = &mut self.slots[connection.federate()];
            if upstream.demand.is_none_or(|(demanded, _)| demanded < tag) {
                upstream.demand = Some((tag, by));
            }
            upstream.look = true;
        }
    }
}

/// What a federate can be granted now beyond what it has been granted already.
fn grant(slots: &mut [Slot], graph: &Graph<'_>, federate: usize, start: Instant) -> Option<Grant> {
    let Slot { next_event, granted, provisional, .. } = slots[federate];
    let new = |tag: Tag| tag > granted && tag >= provisional;
    let waits = !graph.upstream(federate).is_empty();
    if waits {
        let completed = completed_upstream(slots, graph, federate);
        if completed >= next_event && new(completed) {
            return Some(Grant::Final(completed));
        }
    }
    let earliest = earliest_incoming(slots, graph, federate, start);
    if waits {
        // Asking for the earliest message may have made an unknown next event one at the start.
        let next_event = slots[federate].next_event;
        if earliest > next_event && next_event != Tag::NEVER && new(latest_before(earliest)) {
            return Some(Grant::Final(latest_before(earliest)));
        }
        if earliest == next_event
            && graph.in_zero_delay_cycle(federate)
            && next_event > granted.max(provisional)
            && earliest_incoming_strict(slots, graph, federate, start) > next_event
        {
            return Some(Grant::Provisional(next_event));
        }
    }
    let demanded = demand(slots, federate)?;
    if earliest > demanded {
        return new(demanded).then_some(Grant::Final(demanded));
    }
    let provisionally = earliest == demanded
        && demanded > granted.max(provisional)
        && earliest_incoming_strict(slots, graph, federate, start) > demanded;
    provisionally.then_some(Grant::Provisional(demanded))
}

/// The tag at which a federate downstream may wait for what this one does, unless it has got on meanwhile.
fn demand(slots: &[Slot], federate: usize) -> Option<Tag> {
    let (tag, by) = slots[federate].demand?;
    let downstream = &slots[usize::from(by)];
    let waits = slots[federate].completed < tag
        && matches!(downstream.membership, Membership::Joined(_))
        && downstream.completed < tag
        && downstream.granted < tag
        && downstream.provisional == tag;
    waits.then_some(tag)
}

/// Up to which tag all federates immediately upstream have completed what can lead to a message.
fn completed_upstream(slots: &[Slot], graph: &Graph<'_>, federate: usize) -> Tag {
    let connections = graph.upstream(federate).iter();
    let present = connections.filter(|upstream| matches!(slots[upstream.federate()].membership, Membership::Joined(_)));
    let completed = present.map(|upstream| upstream.delay().after_strictly(slots[upstream.federate()].completed));
    completed.min().unwrap_or(Tag::FOREVER)
}

/// The earliest tag with which a message may still come from any federate upstream, however indirectly.
///
/// A federate that has not announced anything is taken to have its next event at the start, from now on.
fn earliest_incoming(slots: &mut [Slot], graph: &Graph<'_>, federate: usize, start: Instant) -> Tag {
    let mut earliest = Tag::FOREVER;
    for (slot, delay) in slots.iter_mut().zip(graph.delays_to(federate)) {
        if delay.is_path() {
            if slot.next_event == Tag::NEVER {
                slot.next_event = Tag::at(start);
            }
            earliest = earliest.min(delay.after(slot.next_event));
        }
    }
    earliest
}

/// The same, but only over the immediate connections from federates that are not in the same cycle without delay.
///
/// What those in the same cycle send at the tag is what the receiver of a PTAG waits for. Those in another cycle are
/// not waited for, so nothing may come from them any more; the stock RTI exempts them too.
fn earliest_incoming_strict(slots: &mut [Slot], graph: &Graph<'_>, federate: usize, start: Instant) -> Tag {
    let mut earliest = Tag::FOREVER;
    for upstream in graph.upstream(federate) {
        let from = upstream.federate();
        if graph.share_zero_delay_cycle(from, federate) {
            continue;
        }
        let incoming = earliest_incoming(slots, graph, from, start);
        earliest = earliest.min(upstream.delay().after(slots[from].next_event.min(incoming)));
    }
    earliest
}

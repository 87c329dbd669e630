// SPDX-License-Identifier: Apache-2.0
//! The notifications about federates that come and go, and the messages that are lost for them.

use lf_model::time::Tag;
use lf_wire::Message;

use super::incarnation::rest;
use super::log_event::RtiEvent;
use super::members::Members;
use super::outlet::{ConnectionId, Outlet};
use super::sending::Sending;
use super::storage::{extended, id};
use crate::tag::to_wire;

impl Members<'_> {
    /// Records that a federate wants to be informed about another one, if that is transient.
    pub(super) fn register(&mut self, federate: usize, other: u16, is_transient: bool) {
        let place = federate * self.slots.len() + usize::from(other);
        if is_transient && let Some(registered) = self.registrations.get_mut(place) {
            *registered = true;
        }
    }

    fn is_registered(&self, federate: usize, other: usize) -> bool {
        self.registrations.get(federate * self.slots.len() + other) == Some(&true)
    }

    pub(super) fn forget_registrations(&mut self, federate: usize) {
        let count = self.slots.len();
        if let Some(own) = self.registrations.get_mut(federate * count..(federate + 1) * count) {
            own.fill(false);
        }
    }
}

impl<O: Outlet> Sending<'_, '_, O> {
    /// Returns whether a message with this tag is lost for its destination, because that does not take part then.
    pub(super) fn misses(&self, to: u16, tag: Tag) -> bool {
        let Some(slot) = self.members.slots.get(usize::from(to)) else { return false };
        slot.is_transient() && (self.members.running(to.into()).is_none() || slot.incarnation.misses(tag))
    }

    /// Records a message that is forwarded: the next incarnations of its sender and its destination begin after it.
    pub(super) fn record_in_incarnations(&mut self, from: usize, to: usize, tag: Tag) {
        self.members.slots[to].incarnation.record(tag);
        if self.members.slots[from].is_transient() {
            let mut upstream = (0..self.tags.graph.upstreams(to)).map(|index| self.tags.graph.upstream(to, index));
            if let Some((_, delay)) = upstream.find(|(other, _)| *other == from) {
                self.members.slots[from].incarnation.record_sent(delay.before(tag));
            }
        }
    }

    /// Drops such a message.
    pub(super) fn drop_missed(&mut self, from: usize, to: u16, tag: Tag) {
        self.members.slots[usize::from(to)].incarnation.record(tag);
        let times = self.members.slots[from].tallies.dropped.count();
        self.outlet.log(RtiEvent::Missed { from: id(from), to: to.into(), times });
    }

    /// Returns whether to tell a federate that one directly upstream of it has left, also if that has come back since.
    pub(super) fn has_left(&self, federate: usize, other: u16) -> bool {
        let came = self.members.slots[federate].pending.notifications.upstream_came;
        let has_returned = came.is_some_and(|(first, last)| (first..=last).contains(&other));
        self.tags.is_upstream(federate, other.into()) && (has_returned || self.tags.state(other.into()).departed)
    }

    /// Sends a transient federate its effective start, and before it who is upstream of it. Returns false if there is
    /// not room for all of it.
    pub(super) fn send_before_start(&mut self, federate: usize, connection: ConnectionId) -> bool {
        let slot = &self.members.slots[federate];
        if !slot.is_transient() || !slot.pending.start {
            return true;
        }
        if !self.send_arrivals(federate, connection) {
            return false;
        }
        let start = self.tags.start.unwrap_or_default().as_nanos();
        let message = Message::EffectiveStart { start, tag: to_wire(self.members.slots[federate].incarnation.begin) };
        let sent = self.send_with_room(connection, &message);
        self.members.slots[federate].pending.start = !sent;
        sent
    }

    /// Sends a federate what it is to be told because of transient federates. Returns false if there is not room for
    /// all of it.
    pub(super) fn send_notifications(&mut self, federate: usize, connection: ConnectionId) -> bool {
        if !self.send_arrivals(federate, connection) {
            return false;
        }
        while let Some((first, last)) = self.members.slots[federate].pending.notifications.outbound_left {
            let came = self.members.slots[federate].pending.notifications.outbound_came;
            let has_returned = came.is_some_and(|(first_came, last_came)| (first_came..=last_came).contains(&first));
            let is_told = self.members.is_registered(federate, first.into())
                && (has_returned || self.members.running(first.into()).is_none());
            if is_told && !self.send_with_room(connection, &Message::OutboundDisconnected { federate: first }) {
                return false;
            }
            self.members.slots[federate].pending.notifications.outbound_left = rest(first, last);
        }
        while let Some((first, last)) = self.members.slots[federate].pending.notifications.outbound_came {
            let is_told = self.members.is_registered(federate, first.into())
                && self.members.slots[usize::from(first)].is_transient()
                && self.members.running(first.into()).is_some();
            if is_told && !self.send_with_room(connection, &Message::OutboundConnected { federate: first }) {
                return false;
            }
            self.members.slots[federate].pending.notifications.outbound_came = rest(first, last);
        }
        if self.members.slots[federate].pending.notifications.stop {
            let sent = self.send_with_room(connection, &Message::Stop);
            self.members.slots[federate].pending.notifications.stop = !sent;
            return sent;
        }
        true
    }

    /// Advances the federates downstream of one that has just come, where they wait for a grant: those that have waited
    /// for the clock need not, up to its effective start.
    pub(super) fn advance_waiting_downstream(&mut self, federate: usize) {
        let row = self.tags.graph.nodes[federate].outgoing;
        for index in 0..row.len {
            let other = self.tags.graph.other_end(row, index);
            if other != federate && self.tags.awaited(other).is_some() {
                self.advance(other);
            }
        }
    }

    /// Sends a federate which transient federates directly upstream of it have come since the last time.
    fn send_arrivals(&mut self, federate: usize, connection: ConnectionId) -> bool {
        while let Some((first, last)) = self.members.slots[federate].pending.notifications.upstream_came {
            let is_told = self.members.slots[usize::from(first)].is_transient()
                && self.members.running(first.into()).is_some()
                && self.tags.is_upstream(federate, first.into());
            if is_told && !self.send_with_room(connection, &Message::UpstreamConnected { federate: first }) {
                return false;
            }
            self.members.slots[federate].pending.notifications.upstream_came = rest(first, last);
        }
        true
    }

    fn send_with_room(&mut self, connection: ConnectionId, message: &Message<'_>) -> bool {
        let has_room = self.outlet.room(connection) >= message.encoded_len();
        if has_room {
            self.outlet.send(connection, message);
        }
        has_room
    }

    /// Tells those directly downstream of a transient federate, and those who are registered, that it has come or left.
    pub(super) fn announce(&mut self, other: usize, has_come: bool, stop_tag: Tag) {
        let number = id(other).0;
        for federate in (0..self.members.slots.len()).filter(|federate| *federate != other) {
            if self.members.running(federate).is_none() {
                continue;
            }
            let is_registered = self.members.is_registered(federate, other);
            let is_downstream = self.tags.is_upstream(federate, other);
            let pending = &mut self.members.slots[federate].pending;
            let notifications = &mut pending.notifications;
            match has_come {
                true if is_downstream => {
                    notifications.upstream_came = Some(extended(notifications.upstream_came, number));
                }
                false if is_downstream => pending.record_departure(number),
                _ => {}
            }
            let notifications = &mut pending.notifications;
            match has_come {
                true if is_registered => {
                    notifications.outbound_came = Some(extended(notifications.outbound_came, number));
                }
                false if is_registered => {
                    notifications.outbound_left = Some(extended(notifications.outbound_left, number));
                }
                _ => {}
            }
            self.flush(federate, stop_tag);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::storage::Slot;
    use super::*;

    const FEDERATES: usize = 4;

    #[test]
    fn each_federate_is_told_of_those_that_it_has_asked_for() {
        let mut slots = [Slot::EMPTY; FEDERATES];
        let mut registrations = [false; FEDERATES * FEDERATES];
        let mut members = Members::new(&mut slots, &mut []).with_registrations(&mut registrations);
        let pairs = || (0..FEDERATES).flat_map(|federate| (0..FEDERATES).map(move |other| (federate, other)));
        let asks = |federate: usize, other: usize| (federate + 2 * other) % 3 == 1;
        for (federate, other) in pairs() {
            members.register(federate, id(other).0, asks(federate, other));
        }
        for forgotten in [None, Some(2), Some(0), Some(3)] {
            if let Some(federate) = forgotten {
                members.forget_registrations(federate);
            }
            let forgets = |federate| match forgotten {
                None => false,
                Some(0) => [0, 2].contains(&federate),
                Some(3) => federate != 1,
                last => last == Some(federate),
            };
            for (federate, other) in pairs() {
                let expected = asks(federate, other) && !forgets(federate);
                assert_eq!(members.is_registered(federate, other), expected, "{federate} {other} {forgotten:?}");
            }
        }
    }
}

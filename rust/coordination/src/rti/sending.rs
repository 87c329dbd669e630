// SPDX-License-Identifier: Apache-2.0
//! Sends messages now or as soon as there is room: grants and DNETs, messages to all, and forwarded messages.

use lf_model::time::Tag;
use lf_wire::{Message, MessageType};

use super::grants::Grant;
use super::log_event::{RtiEvent, Violation};
use super::members::Members;
use super::outlet::{ConnectionId, Outlet};
use super::storage::{Pending, Slot, id};
use super::suspected_violation::SuspectedViolation;
use super::tags::Tags;
use crate::tag::to_wire;

/// Bytes of TAG, PTAG, DNET and the stop messages, which carry a tag only.
const TAG_MESSAGE_BYTES: usize = MessageType::TagGrant.fixed_bytes();

/// The consequence of a message.
pub(super) enum Step {
    /// The message is handled.
    Done,
    /// There is no room on this connection yet.
    NoRoom(ConnectionId),
}

/// The members, their tags, and the outlet.
pub(super) struct Sending<'r, 's, O> {
    pub(super) members: &'r mut Members<'s>,
    pub(super) tags: &'r mut Tags<'s>,
    pub(super) outlet: &'r mut O,
}

impl<O: Outlet> Sending<'_, '_, O> {
    /// Returns the connection of the federate if a message of this many bytes can be sent to it now.
    fn ready(&self, federate: usize, bytes: usize) -> Option<ConnectionId> {
        let connection = self.members.running(federate)?;
        let ready = !self.members.slots[federate].pending.comes_first() && self.outlet.room(connection) >= bytes;
        ready.then_some(connection)
    }

    /// Grants a federate what it can be granted, and, if that is a PTAG, grants federates upstream of it what it may
    /// wait for. Does nothing for a federate that is not there; puts the grant off if there is no room.
    pub(super) fn advance(&mut self, federate: usize) {
        let mut next = Some(federate);
        while let Some(federate) = next {
            if self.members.running(federate).is_some()
                && let Some(grant) = self.tags.grant(federate)
            {
                self.send_grant(federate, grant);
            }
            next = self.tags.graph.take_mark();
        }
    }

    fn send_grant(&mut self, federate: usize, grant: Grant) {
        let Some(connection) = self.ready(federate, TAG_MESSAGE_BYTES) else {
            self.members.slots[federate].pending.grant = true;
            return;
        };
        let message = match grant {
            Grant::Final(tag) => Message::TagGrant(to_wire(tag)),
            Grant::Provisional(tag) => Message::ProvisionalTagGrant(to_wire(tag)),
        };
        self.outlet.send(connection, &message);
        self.tags.granted(federate, grant);
    }

    /// Advances the federates downstream of one whose state has changed.
    pub(super) fn advance_downstream(&mut self, federate: usize) {
        let row = self.tags.graph.nodes[federate].outgoing;
        for index in 0..row.len {
            self.advance(self.tags.graph.other_end(row, index));
        }
    }

    /// Sets the next event of a federate to `tag`, or to that of the first message in transit to it.
    pub(super) fn next_event(&mut self, federate: usize, tag: Tag) {
        if self.tags.set_next_event(federate, tag) {
            self.advance(federate);
        }
        self.advance_downstream(federate);
        self.send_dnets(federate);
    }

    /// Handles that a federate announces its next event, which counts as `limited`. Once all are to stop, it is not
    /// checked.
    pub(super) fn announced(&mut self, federate: usize, tag: Tag, limited: Tag, stops: bool) {
        self.report_suspected(federate, self.tags.check_next_event(federate, tag).filter(|_| !stops));
        self.tags.in_transit(federate).announce(tag);
        self.next_event(federate, limited);
        self.tags.record_next_event(self.tags.graph.next_event(federate));
    }

    /// Handles that a federate has completed a tag, and with it the messages up to it. Once all are to stop, each goes
    /// to the stop tag, and that is not checked.
    pub(super) fn completed(&mut self, federate: usize, tag: Tag, stops: bool) {
        self.report_suspected(federate, self.tags.check_completed(federate, tag).filter(|_| !stops));
        let state = self.tags.state_mut(federate);
        state.completed = state.completed.max(tag);
        self.advance_downstream(federate);
        self.tags.in_transit(federate).complete(tag);
    }

    fn report_suspected(&mut self, federate: usize, violation: Option<SuspectedViolation>) {
        if let Some(violation) = violation {
            self.members.report_suspected(federate, violation, self.outlet);
        }
    }

    /// Sends new DNETs to those upstream of a federate whose next event has changed: they need not announce next events
    /// that do not matter downstream.
    fn send_dnets(&mut self, federate: usize) {
        if !self.tags.graph.dnet {
            return;
        }
        let row = self.tags.graph.nodes[federate].incoming;
        for index in 0..row.len {
            let upstream = self.tags.graph.other_end(row, index);
            if upstream != federate {
                self.offer_downstream_next_event(upstream);
            }
        }
    }

    fn offer_downstream_next_event(&mut self, federate: usize) {
        let Some(tag) = self.tags.downstream_next_event(federate) else { return };
        if self.members.running(federate).is_none() {
            return;
        }
        match self.ready(federate, TAG_MESSAGE_BYTES) {
            Some(connection) => {
                self.outlet.send(connection, &Message::DownstreamNextEventTag(to_wire(tag)));
                self.tags.state_mut(federate).dnet = tag;
            }
            None => self.members.slots[federate].pending.dnet = true,
        }
    }

    /// Sends what is pending for a federate, in the order of [`Pending`], as far as there is room. `stop_tag` is the
    /// tag for stop messages.
    pub(super) fn flush(&mut self, federate: usize, stop_tag: Tag) {
        let Some(connection) = self.members.running(federate) else { return };
        #[cfg(feature = "transients")]
        if !self.send_before_start(federate, connection) {
            return;
        }
        let stop_tag = to_wire(stop_tag);
        let pending = &mut self.members.slots[federate].pending;
        let start = Message::Timestamp(self.tags.start.unwrap_or_default().as_nanos());
        let mut send = |flag: &mut bool, message| send_pending(flag, &message, connection, self.outlet);
        let went_out = send(&mut pending.start, start)
            && send(&mut pending.stop_request, Message::StopRequest(stop_tag))
            && send(&mut pending.revoked, Message::ProvisionalTagGrant(stop_tag))
            && send(&mut pending.stop_granted, Message::StopGranted(stop_tag));
        if !went_out || !self.send_departures(federate, connection) {
            return;
        }
        #[cfg(feature = "transients")]
        if !self.send_notifications(federate, connection) {
            return;
        }
        if core::mem::take(&mut self.members.slots[federate].pending.grant) {
            self.advance(federate);
        }
        if core::mem::take(&mut self.members.slots[federate].pending.dnet) {
            self.offer_downstream_next_event(federate);
        }
    }

    /// Sends a federate which of those directly upstream of it have left since the last time. Returns false if there is
    /// not room for all of it.
    pub(super) fn send_departures(&mut self, federate: usize, connection: ConnectionId) -> bool {
        while let Some((first, last)) = self.members.slots[federate].pending.left {
            #[cfg(feature = "transients")]
            let has_left = self.has_left(federate, first);
            #[cfg(not(feature = "transients"))]
            let has_left = self.tags.is_upstream_left(federate, first.into());
            if has_left {
                let message = Message::UpstreamDisconnected { federate: first };
                if self.outlet.room(connection) < message.encoded_len() {
                    return false;
                }
                self.outlet.send(connection, &message);
            }
            self.members.slots[federate].pending.left = (first < last).then_some((first + 1, last));
        }
        true
    }

    /// Handles that a federate of a cycle without delay has left: those that may wait for it at a tag need not wait any
    /// more. No grant says so while they are in a cycle without it. Only federates with an ordered stop receive it; the
    /// stock ones before LF 0.13 would fail.
    pub(super) fn announce_departure(&mut self, left: usize, stop_tag: Tag) {
        for federate in 0..self.members.slots.len() {
            if self.members.connection_of(federate).is_some()
                && self.members.slots[federate].ordered_stop
                && self.tags.is_upstream_left(federate, left)
            {
                self.members.slots[federate].pending.record_departure(id(left).0);
                self.flush(federate, stop_tag);
            }
        }
    }

    /// Marks a message to be sent to every federate that `choose` picks among those that are there, and sends it to
    /// those that have room.
    pub(super) fn broadcast(&mut self, stop_tag: Tag, choose: impl Fn(&Slot) -> bool, mark: impl Fn(&mut Pending)) {
        for federate in 0..self.members.slots.len() {
            if self.members.running(federate).is_some() && choose(&self.members.slots[federate]) {
                mark(&mut self.members.slots[federate].pending);
                self.flush(federate, stop_tag);
            }
        }
    }

    /// Forwards a message unchanged, if its destination is there.
    pub(super) fn forward(&mut self, from: usize, to: u16, message: &Message<'_>) -> Result<Step, Violation> {
        if usize::from(to) >= self.members.slots.len() {
            return Err(Violation::NoSuchFederate(to));
        }
        let Some(connection) = self.members.running(to.into()) else {
            #[cfg(feature = "transients")]
            if self.members.slots[usize::from(to)].is_transient() {
                return Ok(Step::Done);
            }
            let times = self.members.slots[from].tallies.dropped.count();
            self.outlet.log(RtiEvent::Dropped { from: id(from), to: to.into(), times });
            return Ok(Step::Done);
        };
        if self.ready(to.into(), message.encoded_len()).is_none() {
            return Ok(Step::NoRoom(connection));
        }
        self.outlet.send(connection, message);
        Ok(Step::Done)
    }

    /// Forwards a message with a tag. It is recorded until its destination has seen it.
    pub(super) fn forward_tagged(
        &mut self,
        from: usize,
        to: u16,
        tag: Tag,
        message: &Message<'_>,
    ) -> Result<Step, Violation> {
        #[cfg(feature = "transients")]
        if self.misses(to, tag) {
            self.drop_missed(from, to, tag);
            return Ok(Step::Done);
        }
        let step = self.forward(from, to, message)?;
        let to = usize::from(to);
        if matches!(step, Step::NoRoom(_)) || self.members.running(to).is_none() {
            return Ok(step);
        }
        #[cfg(feature = "transients")]
        self.record_in_incarnations(from, to, tag);
        let (late, is_full) = self.tags.message_forwarded(to, tag);
        if late {
            let times = self.members.slots[from].tallies.late.count();
            self.outlet.log(RtiEvent::Late { from: id(from), to: id(to), times });
        }
        if is_full {
            self.outlet.log(RtiEvent::InTransitFull(id(to)));
        }
        if tag < self.tags.graph.next_event(to) {
            self.next_event(to, tag);
        }
        Ok(step)
    }
}

/// Sends the message if it is pending. Returns false if it still is.
fn send_pending(flag: &mut bool, message: &Message<'_>, connection: ConnectionId, outlet: &mut impl Outlet) -> bool {
    if *flag && outlet.room(connection) >= message.encoded_len() {
        outlet.send(connection, message);
        *flag = false;
    }
    !*flag
}

// SPDX-License-Identifier: Apache-2.0
//! What federates say once they have joined.

use lf_model::time::{Instant, Tag};
use lf_wire::{ADDRESS_PORT_UNKNOWN, DecodeError, Decoded, Message, MessageType, decode};

use super::storage::{Membership, Phase};
use super::{Cause, ConnectionId, Notice, Outlet, Rti, Verdict, Violation, id};
use crate::tag::from_wire;

/// What a message leads to.
enum Step {
    /// The message is done with.
    Done,
    /// What it leads to has no room on this connection yet.
    NoRoom(ConnectionId),
}

/// What a federate did by sending such bytes.
fn wrong(error: DecodeError) -> Violation {
    match error {
        DecodeError::OverLimit { message, found, limit, .. } if message == MessageType::TaggedMessage.name() => {
            Violation::TooLong { bytes: found, max: limit }
        }
        error => Violation::Bytes(error),
    }
}

impl Rti<'_> {
    /// A connection has this to say, and maybe more later. Handles at most one message.
    pub fn handle_input(
        &mut self,
        now: Instant,
        connection: ConnectionId,
        bytes: &[u8],
        outlet: &mut impl Outlet,
    ) -> Verdict {
        let verdict = self.dispatch(now, connection, bytes, outlet);
        self.limit_start(now);
        verdict
    }

    fn dispatch(&mut self, now: Instant, connection: ConnectionId, bytes: &[u8], outlet: &mut impl Outlet) -> Verdict {
        let Some(known) = self.connections.get(connection.0) else { return Verdict::Closed };
        match (known.phase, known.federate) {
            (Phase::Vacant, _) => Verdict::Closed,
            (_, _) if bytes.is_empty() => Verdict::Incomplete(1),
            (Phase::Draining, _) => Verdict::Consumed(bytes.len()),
            (Phase::Joined, Some(federate)) => self.handle_federate(now, federate.into(), connection, bytes, outlet),
            _ => self.handle_handshake(now, connection, bytes, outlet),
        }
    }

    fn handle_federate(
        &mut self,
        now: Instant,
        federate: usize,
        connection: ConnectionId,
        bytes: &[u8],
        outlet: &mut impl Outlet,
    ) -> Verdict {
        if self.connections[connection.0].ended && self.awaits_stop_tag(federate) {
            self.conclude(federate, bytes, outlet);
        }
        let step = match decode(bytes, &self.limits) {
            Ok(Decoded::Incomplete { need, .. }) => return Verdict::Incomplete(need),
            Ok(Decoded::Complete { message, len }) => {
                if let Some(verdict) = self.hold(federate, &message, bytes, len, outlet) {
                    return verdict;
                }
                self.handle_message(now, federate, connection, &message, outlet).map(|step| (step, len))
            }
            // The stock programs skip such a byte, so that a message without content can be added to the protocol.
            Err(DecodeError::UnknownType { found }) => {
                let times = self.slots[federate].tallies.unknown.count();
                outlet.notice(Notice::UnknownType { federate: id(federate), found, times });
                Ok((Step::Done, 1))
            }
            Err(error) => Err(wrong(error)),
        };
        match step {
            Ok((Step::Done, len)) => {
                self.await_clock(now, federate, connection);
                match self.connections[connection.0].phase {
                    Phase::Vacant => Verdict::Closed,
                    _ => Verdict::Consumed(len),
                }
            }
            Ok((Step::NoRoom(connection), _)) => Verdict::Blocked(connection),
            Err(violation) => {
                self.expel(federate, Cause::Violation(violation), outlet);
                Verdict::Closed
            }
        }
    }

    fn handle_message(
        &mut self,
        now: Instant,
        federate: usize,
        connection: ConnectionId,
        message: &Message<'_>,
        outlet: &mut impl Outlet,
    ) -> Result<Step, Violation> {
        let unexpected = Err(Violation::Unexpected(message.message_type()));
        match *message {
            Message::Timestamp(clock) => self.on_timestamp(federate, Instant(clock), outlet)?,
            Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN } => self.slots[federate].stops_in_turn = true,
            Message::AddressAdvertisement { port } => self.slots[federate].port = port,
            Message::AddressQuery { federate: asked } => return self.on_address_query(connection, asked, outlet),
            Message::Resign => self.on_resign(now, federate, outlet),
            Message::Failed => self.on_failed(federate, outlet),
            _ if self.start.is_none() => return unexpected,
            Message::TaggedMessage { federate: to, tag, .. } => {
                return self.on_tagged_message(federate, to, from_wire(tag), message, outlet);
            }
            Message::PortAbsent { federate: to, .. } => return self.forward(federate, to, message, outlet),
            Message::NextEventTag(tag) => {
                self.doubt_next_event(federate, from_wire(tag), outlet);
                self.in_transit(federate).announce(from_wire(tag));
                self.on_next_event(federate, self.not_after_stop(federate, from_wire(tag)), outlet);
                self.note_idleness(self.graph.next_event(federate));
            }
            Message::LatestTagComplete(tag) => {
                self.doubt_completed(federate, from_wire(tag), outlet);
                self.on_complete(federate, from_wire(tag), outlet);
            }
            Message::StopRequest(tag) => self.on_stop_request(now, federate, from_wire(tag), outlet),
            Message::StopReply(tag) => self.on_stop_reply(federate, from_wire(tag), outlet),
            _ => return unexpected,
        }
        Ok(Step::Done)
    }

    /// The next event of a federate is at `tag`, or at that of the first message on its way to it.
    fn on_next_event(&mut self, federate: usize, tag: Tag, outlet: &mut impl Outlet) {
        let tag = tag.min(self.in_transit(federate).earliest());
        self.graph.set_next_event(federate, tag);
        if self.graph.upstreams(federate) == 0 {
            // It needs no grant, so this counts as one.
            self.slots[federate].granted = tag;
        } else {
            self.advance(federate, outlet);
        }
        self.advance_downstream(federate, outlet);
        self.tell_upstream(federate, outlet);
    }

    /// A federate has completed a tag, and with it the messages up to it.
    fn on_complete(&mut self, federate: usize, tag: Tag, outlet: &mut impl Outlet) {
        let slot = &mut self.slots[federate];
        slot.completed = slot.completed.max(tag);
        self.advance_downstream(federate, outlet);
        self.in_transit(federate).complete(tag);
    }

    /// Something has changed that can let the federates downstream of this one advance.
    pub(super) fn advance_downstream(&mut self, federate: usize, outlet: &mut impl Outlet) {
        let row = self.graph.nodes[federate].outgoing;
        for index in 0..row.len {
            self.advance(self.graph.other_end(row, index), outlet);
        }
    }

    fn on_tagged_message(
        &mut self,
        from: usize,
        to: u16,
        tag: Tag,
        message: &Message<'_>,
        outlet: &mut impl Outlet,
    ) -> Result<Step, Violation> {
        let step = self.forward(from, to, message, outlet)?;
        let to = usize::from(to);
        if matches!(step, Step::NoRoom(_)) || self.connection_of(to).is_none() {
            return Ok(step);
        }
        if self.slots[to].completed < tag {
            let granted = self.slots[to].granted.max(self.slots[to].provisional);
            if self.in_transit(to).insert(tag, granted) {
                outlet.notice(Notice::InTransitFull(id(to)));
            }
        } else {
            let times = self.slots[from].tallies.late.count();
            outlet.notice(Notice::Late { from: id(from), to: id(to), times });
        }
        if tag < self.graph.next_event(to) {
            self.on_next_event(to, tag, outlet);
        }
        Ok(step)
    }

    /// Forwards a message unchanged, if its destination is there.
    fn forward(
        &mut self,
        from: usize,
        to: u16,
        message: &Message<'_>,
        outlet: &mut impl Outlet,
    ) -> Result<Step, Violation> {
        let Some(slot) = self.slots.get(usize::from(to)) else { return Err(Violation::NoSuchFederate(to)) };
        let Membership::Joined(connection) = slot.membership else {
            let times = self.slots[from].tallies.dropped.count();
            outlet.notice(Notice::Dropped { from: id(from), to: to.into(), times });
            return Ok(Step::Done);
        };
        if self.ready(to.into(), message.encoded_len(), outlet).is_none() {
            return Ok(Step::NoRoom(connection));
        }
        outlet.send(connection, message);
        Ok(Step::Done)
    }

    fn on_address_query(
        &mut self,
        connection: ConnectionId,
        asked: u16,
        outlet: &mut impl Outlet,
    ) -> Result<Step, Violation> {
        let slot = self.slots.get(usize::from(asked)).ok_or(Violation::NoSuchFederate(asked))?;
        let reply = Message::AddressQueryReply { port: slot.port, address: slot.address };
        if outlet.room(connection) < reply.encoded_len() {
            return Ok(Step::NoRoom(connection));
        }
        outlet.send(connection, &reply);
        Ok(Step::Done)
    }
}

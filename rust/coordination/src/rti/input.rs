// SPDX-License-Identifier: Apache-2.0
//! The messages of federates that have joined.

use lf_derive::outlined;
use lf_model::time::Instant;
#[cfg(feature = "transients")]
use lf_wire::HANDED_OVER_PORT;
use lf_wire::{ADDRESS_PORT_UNKNOWN, DecodeError, Decoded, Message, MessageType, decode};

use super::log_event::{Cause, RtiEvent, Violation};
use super::machine::Rti;
use super::outlet::{ConnectionId, Outlet, Verdict};
use super::sending::{Sending, Step};
use super::storage::{Phase, Slot, id};
use super::suspected_violation::SuspectedViolation;
use super::window;
use crate::tag::from_wire;
use crate::{FederateId, IpAddress, flow};

/// Returns the violation of a federate that sends such bytes.
fn wrong(error: DecodeError) -> Violation {
    match error {
        DecodeError::OverLimit { message: MessageType::TaggedMessage, found, limit, .. } => {
            Violation::TooLong { bytes: found, max: limit }
        }
        error => Violation::Bytes(error),
    }
}

/// The answer to a question for an address that is not known, or must not be sent: the federate asks again.
const NO_ADDRESS: Message<'static> = Message::AddressQueryReply { port: ADDRESS_PORT_UNKNOWN, address: [0; 4] };

/// Returns the address of a federate for one that has connected from the address `asking`; `None` if that one cannot
/// receive it. Only federates that have connected over IPv6 receive IPv6 addresses, so none of the stock programs does.
#[cfg_attr(not(feature = "ipv6"), expect(clippy::unnecessary_wraps, reason = "an IPv4 address can always be told"))]
fn address_reply(slot: &Slot, asking: IpAddress) -> Option<Message<'static>> {
    let port = slot.port;
    Some(match (slot.address, asking) {
        (IpAddress::V4(address), _) => Message::AddressQueryReply { port, address: address.octets() },
        #[cfg(feature = "ipv6")]
        (IpAddress::V6(address, scope), IpAddress::V6(..)) => {
            Message::AddressQueryReplyIpv6 { port, address: address.octets(), scope }
        }
        // On one computer both families lead to the same port.
        #[cfg(feature = "ipv6")]
        (IpAddress::V6(address, _), IpAddress::V4(asking)) if address.is_loopback() && asking.is_loopback() => {
            Message::AddressQueryReply { port, address: asking.octets() }
        }
        #[cfg(feature = "ipv6")]
        (IpAddress::V6(..), IpAddress::V4(_)) => return None,
    })
}

impl Rti<'_> {
    /// Handles the input of a connection, at most one message; there may be more.
    pub fn handle_input(
        &mut self,
        now: Instant,
        connection: ConnectionId,
        bytes: &[u8],
        outlet: &mut impl Outlet,
    ) -> Verdict {
        self.set_now(now);
        let Some(known) = self.members.connections.get(connection.0) else { return Verdict::Closed };
        let verdict = match (known.phase, known.federate) {
            (Phase::Vacant, _) => Verdict::Closed,
            (_, _) if bytes.is_empty() => Verdict::Incomplete(1),
            (Phase::Draining, _) => Verdict::Consumed(bytes.len()),
            #[cfg(feature = "transients")]
            (Phase::Successor, Some(federate)) => self.hold_successor(federate.into()),
            (Phase::Joined, Some(federate)) => self.handle_federate(now, federate.into(), connection, bytes, outlet),
            _ => self.handle_handshake(now, connection, bytes, outlet),
        };
        self.limit_start(now);
        verdict
    }

    fn handle_federate(
        &mut self,
        now: Instant,
        federate: usize,
        connection: ConnectionId,
        bytes: &[u8],
        outlet: &mut impl Outlet,
    ) -> Verdict {
        if self.members.connections[connection.0].ended && self.awaits_stop_tag(federate) {
            // It sends nothing any more behind these bytes, and agrees to a stop as it says there, or in silence.
            self.find_stop_reply(federate, bytes, true, outlet);
        }
        if let Some((asked, is_transient)) = self.members.slots[federate].query_end.take(bytes) {
            self.register(federate, asked, is_transient);
            return Verdict::Consumed(1);
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
                let times = self.members.slots[federate].tallies.unknown.count();
                outlet.log(RtiEvent::UnknownType { federate: id(federate), found, times });
                Ok((Step::Done, 1))
            }
            Err(error) => Err(wrong(error)),
        };
        match step {
            Ok((Step::Done, len)) => {
                self.members.await_clock(now + self.config.clock_time_out, federate, connection);
                match self.members.phase(connection) {
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

    #[outlined]
    fn handle_message(
        &mut self,
        now: Instant,
        federate: usize,
        connection: ConnectionId,
        message: &Message<'_>,
        outlet: &mut impl Outlet,
    ) -> Result<Step, Violation> {
        let unexpected = Err(Violation::Unexpected(message.message_type()));
        let has_started = self.tags.start.is_some();
        let takes_part = has_started && self.members.running(federate).is_some();
        let slot = &mut self.members.slots[federate];
        match *message {
            Message::Timestamp(clock) if !has_started => {
                self.take_clock(now, federate, Instant::from_nanos(clock), outlet)?;
            }
            #[cfg(feature = "transients")]
            Message::Timestamp(clock) if !takes_part => {
                self.begin_incarnation(now, federate, Instant::from_nanos(clock), outlet)?;
            }
            Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN } => slot.ordered_stop = true,
            Message::AddressAdvertisement { port } => slot.port = port,
            #[cfg(feature = "transients")]
            Message::AddressQuery { federate: asked, .. } if !takes_part && self.has_gone(asked) => {
                self.refuse_late(federate, connection, outlet);
            }
            Message::AddressQuery { federate: asked, is_transient } => {
                let step = self.answer_address_query(connection, asked, outlet)?;
                if matches!(step, Step::Done) {
                    self.members.slots[federate].query_end.follow(message);
                    self.register(federate, asked, is_transient == Some(true));
                }
                return Ok(step);
            }
            #[cfg(feature = "transients")]
            Message::TaggedMessage { port: HANDED_OVER_PORT, federate: to, .. } if usize::from(to) == federate => {
                return Ok(self.hand_over(federate, message, outlet));
            }
            Message::Resign => self.resign(now, federate, outlet),
            Message::Failed => self.expel(federate, Cause::Failed, outlet),
            _ if !takes_part => return unexpected,
            _ => {
                let own = id(federate);
                let answer =
                    flow::offer_in(message, own).map(|offer| flow::answer(own, self.take_offer(federate, offer)));
                let message = answer.as_ref().unwrap_or(message);
                let mut sending = Sending { members: &mut self.members, tags: &mut self.tags, outlet };
                match *message {
                    Message::TaggedMessage { federate: to, tag, .. } => {
                        let tag = from_wire(tag);
                        if !tag.is_finite() {
                            return Err(Violation::NoTag { to });
                        }
                        return sending.forward_tagged(federate, to, tag, message);
                    }
                    Message::PortAbsent { federate: to, .. } => return sending.forward(federate, to, message),
                    Message::NextEventTag(tag) => {
                        let tag = from_wire(tag);
                        let slot = &sending.members.slots[federate];
                        let limited = self.stop.limit(slot, tag);
                        sending.announced(federate, tag, limited, self.stop.granted().is_some());
                    }
                    Message::LatestTagComplete(tag) => {
                        sending.completed(federate, from_wire(tag), self.stop.granted().is_some());
                    }
                    Message::StopRequest(tag) => {
                        let deadline = now + self.config.stop_reply_time_out;
                        self.stop.request(deadline, federate, from_wire(tag), &mut sending);
                    }
                    Message::StopReply(tag) => self.stop.reply(federate, from_wire(tag), &mut sending),
                    _ => return unexpected,
                }
            }
        }
        Ok(Step::Done)
    }

    /// Handles that a federate has asked for the address of another one: if that is transient, it is informed about
    /// its comings and goings from now on.
    fn register(&mut self, federate: usize, asked: u16, is_transient: bool) {
        #[cfg(feature = "transients")]
        self.members.register(federate, asked, is_transient);
        #[cfg(not(feature = "transients"))]
        let _ = (federate, asked, is_transient);
    }

    fn answer_address_query(
        &mut self,
        connection: ConnectionId,
        asked: u16,
        outlet: &mut impl Outlet,
    ) -> Result<Step, Violation> {
        let slot = self.members.slots.get(usize::from(asked)).ok_or(Violation::NoSuchFederate(asked))?;
        let asking = self.members.connections[connection.0].address;
        let reply = address_reply(slot, asking);
        if outlet.room(connection) < reply.unwrap_or(NO_ADDRESS).encoded_len() {
            return Ok(Step::NoRoom(connection));
        }
        if reply.is_none()
            && let Some(federate) = self.members.joined_on(connection)
        {
            self.members.report_suspected(federate, SuspectedViolation::OtherFamily(FederateId(asked)), outlet);
        }
        outlet.send(connection, &reply.unwrap_or(NO_ADDRESS));
        Ok(Step::Done)
    }

    /// Decides whether the message at the front, which is `len` bytes long, has to wait because its receiver is too far
    /// behind its sender (module `window`). If so, returns the verdict.
    fn hold(
        &mut self,
        sender: usize,
        message: &Message<'_>,
        bytes: &[u8],
        len: usize,
        outlet: &mut impl Outlet,
    ) -> Option<Verdict> {
        let Message::TaggedMessage { federate: receiver, tag, port, .. } = *message else { return None };
        #[cfg(not(feature = "transients"))]
        let _ = (tag, port);
        #[cfg(feature = "transients")]
        if port == HANDED_OVER_PORT {
            return None;
        }
        let receiver = usize::from(receiver);
        let connection = self.members.running(receiver)?;
        #[cfg(feature = "transients")]
        if self.members.slots[receiver].incarnation.misses(from_wire(tag)) {
            return None;
        }
        if !self.tags.is_behind(receiver, sender, self.stop.granted(), self.window) {
            return None;
        }
        if !self.awaits_stop_tag(sender) || self.find_stop_reply(sender, &bytes[len..], false, outlet) {
            return Some(Verdict::Held(connection));
        }
        (!window::is_full(bytes, len, &self.limits)).then_some(Verdict::HeldReadOn(connection))
    }

    fn awaits_stop_tag(&self, federate: usize) -> bool {
        self.stop.awaits(&self.members.slots[federate])
    }

    /// Looks for a federate's answer to a stop in its later bytes. Returns whether there is one. Where there is none
    /// and there will not be any, it agrees.
    fn find_stop_reply(&mut self, federate: usize, bytes: &[u8], ends: bool, outlet: &mut impl Outlet) -> bool {
        let reply = window::look_ahead(bytes, &self.limits).or(ends.then_some(lf_model::time::Tag::NEVER));
        if let Some(tag) = reply {
            let mut sending = Sending { members: &mut self.members, tags: &mut self.tags, outlet };
            self.stop.reply(federate, tag, &mut sending);
        }
        reply.is_some()
    }
}

// SPDX-License-Identifier: Apache-2.0
//! The way from a new connection to a federate that is part of the federation.
//!
//! The messages have a fixed order: with authentication `FED_NONCE`, which is answered by `RTI_RESPONSE`, and
//! `FED_RESPONSE`, where a right proof has no answer; `FED_IDS` or `TRANSIENT_FED_IDS`, which is answered by ACK (the
//! module `admission` decides who may join a running federation); `NEIGHBOR_STRUCTURE`; `UDP_PORT`; then, if both sides
//! want it, the initial clock synchronization (`exchange`). Anything else is refused, as soon as there are as many
//! bytes as the header of the right message has. A connection that comes when all federates are there learns the true
//! reason of the refusal, once it has sent its id.

use lf_derive::outlined;
use lf_model::time::Instant;
use lf_wire::{
    Decoded, KIND_TRANSIENT, Limits, Message, MessageType, NeighborStructure, RejectCode, UDP_PORT_CLOCK_SYNC_OFF,
    decode,
};

#[cfg(feature = "transients")]
use super::admission::Admission;
use super::barrier::Barrier;
use super::config::{ClockSync, Config};
use super::exchange::{Exchanges, TIME_MESSAGE_BYTES};
use super::graph::{Graph, NeighborError};
use super::log_event::{RtiEvent, Violation};
use super::members::Members;
use super::outlet::{ConnectionId, Outlet, Verdict};
use super::storage::{Connection, Membership, Phase};
use super::strangers::Strangers;
use crate::auth::{Authenticator, Nonce, Proof};
use crate::{FederateId, IpAddress};

/// The reason to refuse a connection.
#[derive(Clone, Copy)]
struct Refusal<'a> {
    code: RejectCode,
    federate: Option<FederateId>,
    federation_id: Option<&'a [u8]>,
    violation: Option<Violation>,
}

impl Refusal<'_> {
    fn of(code: RejectCode, violation: Violation) -> Self {
        Self { code, federate: None, federation_id: None, violation: Some(violation) }
    }
}

impl From<Violation> for Refusal<'_> {
    fn from(violation: Violation) -> Self {
        Self::of(RejectCode::UnexpectedMessage, violation)
    }
}

/// The consequence of a message of the handshake.
enum HandshakeStep {
    /// The message is handled.
    Done,
    /// There is no room for the reply yet.
    NoRoom,
}

/// The parts that a handshake needs: its connection, the id that it claims, and those that wait for its end.
pub(super) struct Handshake<'r, 's> {
    pub(super) config: &'r Config<'s>,
    pub(super) limits: &'r Limits,
    pub(super) members: &'r mut Members<'s>,
    pub(super) graph: &'r mut Graph<'s>,
    pub(super) exchanges: &'r mut Exchanges,
    pub(super) strangers: &'r mut Strangers,
    pub(super) barrier: &'r mut Barrier,
    #[cfg(feature = "transients")]
    pub(super) admission: Admission,
}

impl Handshake<'_, '_> {
    /// Handles a new connection of a peer with this address. Returns false if the number of the connection is beyond
    /// the storage, or in use.
    pub(super) fn begin(&mut self, now: Instant, connection: ConnectionId, address: IpAddress, nonce: Nonce) -> bool {
        match self.members.connections.get_mut(connection.0) {
            Some(known) if known.phase == Phase::Vacant => {
                let authenticates = self.config.authentication.is_some();
                let phase = if authenticates { Phase::Nonce { own: nonce } } else { Phase::Ids { claimed: None } };
                *known = Connection { phase, address, ..Connection::EMPTY };
                self.members.set_deadline(connection, Some(now + self.config.connection_time_out));
                self.exchanges.record_handshake(now);
                true
            }
            _ => false,
        }
    }

    /// Handles the message at the front of a connection's input, if it is the next one of the handshake. After
    /// [`Verdict::Closed`] the connection is to be closed.
    #[outlined]
    pub(super) fn handle_input(
        &mut self,
        now: Instant,
        connection: ConnectionId,
        bytes: &[u8],
        outlet: &mut impl Outlet,
    ) -> Verdict {
        let expected = match self.members.phase(connection) {
            Phase::Nonce { .. } => MessageType::FedNonce,
            Phase::Proof { .. } => MessageType::FedResponse,
            Phase::Ids { .. } => MessageType::FedIds,
            Phase::Neighbors => MessageType::NeighborStructure,
            Phase::UdpPort => MessageType::UdpPort,
            Phase::AwaitsExchange { .. } | Phase::Asked { .. } | Phase::Full { .. } | Phase::ClockSync { .. } => {
                MessageType::T3
            }
            Phase::Vacant | Phase::Joined | Phase::Draining => return Verdict::Closed,
            #[cfg(feature = "transients")]
            Phase::Successor => return Verdict::Closed,
        };
        // A message of another type may be shorter than the expected one, and its sender waits for an answer.
        let found = MessageType::from_byte(bytes[0]).map_or(usize::MAX, MessageType::fixed_bytes);
        let needed = expected.fixed_bytes().min(found);
        if bytes.len() < needed {
            return Verdict::Incomplete(needed);
        }
        if !is_expected(expected, bytes[0]) {
            return self.refuse_type(connection, expected, bytes, outlet);
        }
        let (message, len) = match decode(bytes, self.limits) {
            Ok(Decoded::Complete { message, len }) => (message, len),
            Ok(Decoded::Incomplete { need, .. }) => return Verdict::Incomplete(need),
            Err(error) => return self.refuse(connection, Violation::Bytes(error).into(), outlet),
        };
        match self.take_step(now, connection, message, outlet) {
            Ok(HandshakeStep::Done) => {
                if expected != MessageType::T3 {
                    self.exchanges.record_handshake(now);
                }
                // A federate that waits for its exchanges is silent because of the RTI.
                let awaits_exchange = matches!(self.members.phase(connection), Phase::AwaitsExchange { .. });
                match self.members.joined_on(connection) {
                    Some(federate) => {
                        self.members.await_clock(now + self.config.clock_time_out, federate, connection);
                    }
                    None if awaits_exchange => self.members.set_deadline(connection, None),
                    #[cfg(feature = "transients")]
                    None if self.members.phase(connection) == Phase::Successor => {
                        // Until then the federate in its place has to stop.
                        self.members.set_deadline(connection, Some(now + self.config.stop_reply_time_out));
                    }
                    None => self.members.set_deadline(connection, Some(now + self.config.connection_time_out)),
                }
                Verdict::Consumed(len)
            }
            Ok(HandshakeStep::NoRoom) => Verdict::Blocked(connection),
            Err(refusal) => self.refuse(connection, refusal, outlet),
        }
    }

    fn take_step<'m>(
        &mut self,
        now: Instant,
        connection: ConnectionId,
        message: Message<'m>,
        outlet: &mut impl Outlet,
    ) -> Result<HandshakeStep, Refusal<'m>> {
        let known = self.members.connections[connection.0];
        match (message, known.phase, known.federate) {
            (Message::FedNonce { federate, nonce }, Phase::Nonce { own }, _) => {
                Ok(self.on_nonce(connection, federate, nonce, own, outlet))
            }
            (Message::FedResponse { hmac }, Phase::Proof { own, claimed }, _) => {
                self.on_proof(connection, claimed, own, hmac)
            }
            (Message::TransientFedIds { federate, kind: KIND_TRANSIENT, .. }, ..) if self.config.transients() == 0 => {
                Err(Refusal { federate: Some(FederateId(federate)), ..Violation::Transient.into() })
            }
            (
                Message::FedIds { federate, federation_id } | Message::TransientFedIds { federate, federation_id, .. },
                Phase::Ids { claimed },
                _,
            ) => {
                if claimed.is_some_and(|claimed| claimed != federate) {
                    return Err(Violation::OtherFederate(federate).into());
                }
                let is_transient = matches!(message, Message::TransientFedIds { kind: KIND_TRANSIENT, .. });
                self.on_ids(connection, federate, is_transient, federation_id, outlet)
            }
            (Message::NeighborStructure(neighbors), _, Some(federate)) => {
                self.on_neighbors(connection, federate, &neighbors)
            }
            (Message::UdpPort(port), _, Some(federate)) => {
                Ok(self.on_udp_port(now, connection, federate, port, outlet))
            }
            (Message::T3 { federate }, Phase::ClockSync { left }, Some(own)) => {
                if federate != own {
                    return Err(Violation::OtherFederate(federate).into());
                }
                Ok(self.on_t3(now, connection, left, outlet))
            }
            (other, ..) => Err(Violation::Unexpected(other.message_type()).into()),
        }
    }

    /// Handles that a federate wants to authenticate: sends the RTI's proof, and expects the federate's.
    fn on_nonce(
        &mut self,
        connection: ConnectionId,
        federate: u16,
        nonce: Nonce,
        own: Nonce,
        outlet: &mut impl Outlet,
    ) -> HandshakeStep {
        if outlet.room(connection) < MessageType::RtiResponse.fixed_bytes() {
            return HandshakeStep::NoRoom;
        }
        let Some(authenticator) = self.config.authentication else { return HandshakeStep::Done };
        let hmac = (authenticator.rti_proof)(self.config.federation_id, federate, nonce);
        outlet.send(connection, &Message::RtiResponse { nonce: own, hmac });
        self.members.connections[connection.0].phase = Phase::Proof { own, claimed: federate };
        HandshakeStep::Done
    }

    fn on_proof<'m>(
        &mut self,
        connection: ConnectionId,
        claimed: u16,
        own: Nonce,
        proof: Proof,
    ) -> Result<HandshakeStep, Refusal<'m>> {
        let is_right = |by: Authenticator| (by.is_federate_proof)(self.config.federation_id, own, &proof);
        if !self.config.authentication.is_some_and(is_right) {
            let (code, federate) = (RejectCode::HmacMismatch, Some(FederateId(claimed)));
            return Err(Refusal { code, federate, federation_id: None, violation: None });
        }
        self.members.connections[connection.0].phase = Phase::Ids { claimed: Some(claimed) };
        Ok(HandshakeStep::Done)
    }

    fn on_ids<'m>(
        &mut self,
        connection: ConnectionId,
        federate: u16,
        is_transient: bool,
        federation_id: &'m [u8],
        outlet: &mut impl Outlet,
    ) -> Result<HandshakeStep, Refusal<'m>> {
        let refusal = |code| Refusal {
            code,
            federate: Some(FederateId(federate)),
            federation_id: (code == RejectCode::FederationIdMismatch).then_some(federation_id),
            violation: None,
        };
        if federation_id != self.config.federation_id {
            return Err(refusal(RejectCode::FederationIdMismatch));
        }
        if usize::from(federate) >= self.members.slots.len() {
            return Err(refusal(RejectCode::IdOutOfRange));
        }
        #[cfg(feature = "security")]
        if !outlet.may_be(connection, FederateId(federate)) {
            let violation = Some(Violation::OtherFederate(federate));
            return Err(Refusal { violation, ..refusal(RejectCode::Insecure) });
        }
        let succeeds = self.succeeds(federate, is_transient);
        let succeeds = succeeds.map_err(|(code, violation)| Refusal { violation, ..refusal(code) })?;
        if outlet.room(connection) < Message::Ack.encoded_len() {
            return Ok(HandshakeStep::NoRoom);
        }
        outlet.send(connection, &Message::Ack);
        let known = &mut self.members.connections[connection.0];
        known.federate = Some(federate);
        known.phase = Phase::Neighbors;
        if !succeeds {
            let slot = &mut self.members.slots[usize::from(federate)];
            slot.membership = Membership::Joining(connection);
            slot.address = known.address;
            #[cfg(feature = "transients")]
            slot.incarnation.join(is_transient);
        }
        Ok(HandshakeStep::Done)
    }

    /// Returns whether a peer takes the place of another instance, which runs, with the id that it claims, or why it
    /// cannot have that.
    fn succeeds(&self, federate: u16, is_transient: bool) -> Result<bool, (RejectCode, Option<Violation>)> {
        #[cfg(feature = "transients")]
        if let Some(entry) = self.admission.entry(self.members, federate, is_transient) {
            return entry;
        }
        #[cfg(not(feature = "transients"))]
        let _ = is_transient;
        match self.members.slots[usize::from(federate)].membership {
            Membership::Free => Ok(false),
            Membership::Departed => Err((RejectCode::IdInUse, Some(Violation::HasLeft))),
            Membership::Joining(_) | Membership::Joined(_) => Err((RejectCode::IdInUse, None)),
        }
    }

    /// Stores the upstream half only: the downstream half follows from those of the others.
    #[outlined]
    fn on_neighbors<'m>(
        &mut self,
        connection: ConnectionId,
        federate: u16,
        neighbors: &NeighborStructure<'_>,
    ) -> Result<HandshakeStep, Refusal<'m>> {
        let wrong = neighbors.downstream().find(|id| usize::from(*id) >= self.members.slots.len());
        if let Some(id) = wrong {
            return Err(Violation::NoSuchFederate(id).into());
        }
        #[cfg(feature = "transients")]
        if self.members.slots[usize::from(federate)].incarnation.has_neighbors {
            // Others rely on the connections, also while it is absent.
            if !self.graph.has_upstream(federate.into(), &neighbors.upstream()) {
                return Err(Violation::OtherNeighbors.into());
            }
            self.members.connections[connection.0].phase = Phase::UdpPort;
            return Ok(HandshakeStep::Done);
        }
        let set = self.graph.set_upstream(federate.into(), neighbors.upstream());
        set.map_err(|error| match error {
            NeighborError::NoSuchFederate(id) => Violation::NoSuchFederate(id),
            NeighborError::Delay { upstream, delay_ns } => Violation::Delay { upstream, delay_ns },
            NeighborError::TooMany { max } => Violation::TooManyUpstream { max },
        })?;
        self.members.connections[connection.0].phase = Phase::UdpPort;
        #[cfg(feature = "transients")]
        {
            self.members.slots[usize::from(federate)].incarnation.has_neighbors = true;
        }
        Ok(HandshakeStep::Done)
    }

    fn on_udp_port(
        &mut self,
        now: Instant,
        connection: ConnectionId,
        federate: u16,
        port: u16,
        outlet: &mut impl Outlet,
    ) -> HandshakeStep {
        let trials = match self.config.clock_sync {
            ClockSync::Init { trials } | ClockSync::On { trials, .. } if port != UDP_PORT_CLOCK_SYNC_OFF => trials,
            _ => 0,
        };
        if trials > 0 {
            if outlet.room(connection) < TIME_MESSAGE_BYTES {
                return HandshakeStep::NoRoom;
            }
            self.exchanges.await_exchange(now, self.members, connection, trials);
        } else {
            self.join(connection, federate, outlet);
        }
        #[cfg(feature = "transients")]
        {
            self.members.connections[connection.0].udp_port = port;
            if self.members.is_successor(connection) {
                return HandshakeStep::Done;
            }
        }
        self.members.slots[usize::from(federate)].udp_port = port;
        HandshakeStep::Done
    }

    /// Handles the federate's answer to T1: sends T4, and makes the next T1 due unless this was the last exchange.
    fn on_t3(&mut self, now: Instant, connection: ConnectionId, left: u32, outlet: &mut impl Outlet) -> HandshakeStep {
        let left = left.saturating_sub(1);
        let messages = if left > 0 { 2 } else { 1 };
        if outlet.room(connection) < messages * TIME_MESSAGE_BYTES {
            return HandshakeStep::NoRoom;
        }
        outlet.send(connection, &Message::T4(now.as_nanos()));
        if left > 0 {
            self.exchanges.ask_again(self.members, connection, left);
        } else if let Some(federate) = self.members.connections[connection.0].federate {
            self.join(connection, federate, outlet);
        }
        HandshakeStep::Done
    }

    fn join(&mut self, connection: ConnectionId, federate: u16, outlet: &mut impl Outlet) {
        self.exchanges.leave(self.members, connection);
        #[cfg(feature = "transients")]
        if self.members.is_successor(connection) {
            self.members.connections[connection.0].phase = Phase::Successor;
            return;
        }
        self.members.connections[connection.0].phase = Phase::Joined;
        self.members.slots[usize::from(federate)].membership = Membership::Joined(connection);
        self.barrier.occupy(self.members.slots, federate.into());
        outlet.log(RtiEvent::Joined(FederateId(federate)));
    }

    /// Refuses another message than the expected one.
    fn refuse_type(
        &mut self,
        connection: ConnectionId,
        expected: MessageType,
        bytes: &[u8],
        outlet: &mut impl Outlet,
    ) -> Verdict {
        // A federate that does not accept the RTI's proof says so, and needs no answer.
        if expected == MessageType::FedResponse
            && bytes[0] == MessageType::Reject.byte()
            && let Phase::Proof { claimed, .. } = self.members.phase(connection)
        {
            let Some(code) = bytes.get(1) else { return Verdict::Incomplete(MessageType::Reject.fixed_bytes()) };
            let (federate, code) = (FederateId(claimed), RejectCode::from_byte(*code));
            let times = self.strangers.rejected_by.count();
            outlet.log(RtiEvent::RejectedBy { federate, code, times });
            return Verdict::Closed;
        }
        self.refuse(connection, wrong_type(expected, bytes[0]), outlet)
    }

    fn refuse(&mut self, connection: ConnectionId, refusal: Refusal<'_>, outlet: &mut impl Outlet) -> Verdict {
        let Refusal { code, federate, federation_id, violation } = refusal;
        let federate = federate.or(self.members.connections[connection.0].federate.map(FederateId));
        let message = Message::Reject(code);
        if outlet.room(connection) >= message.encoded_len() {
            outlet.send(connection, &message);
        }
        let times = self.strangers.rejected.count();
        outlet.log(RtiEvent::Rejected { code, federate, federation_id, violation, times });
        Verdict::Closed
    }
}

/// Returns whether a message whose first byte is `found` is of the expected type, or one that stands for it.
fn is_expected(expected: MessageType, found: u8) -> bool {
    found == expected.byte() || (expected == MessageType::FedIds && found == MessageType::TransientFedIds.byte())
}

/// Returns the answer to another message than the expected one.
fn wrong_type<'m>(expected: MessageType, found: u8) -> Refusal<'m> {
    let Some(message_type) = MessageType::from_byte(found) else {
        return Violation::Bytes(lf_wire::DecodeError::UnknownType { found }).into();
    };
    if expected == MessageType::FedNonce && is_expected(MessageType::FedIds, found) {
        return Violation::NoAuthentication.into();
    }
    let code = match message_type {
        MessageType::P2pSendingFedId | MessageType::P2pTaggedMessage
            if matches!(expected, MessageType::FedIds | MessageType::FedNonce) =>
        {
            RejectCode::WrongServer
        }
        MessageType::FedNonce if expected == MessageType::FedIds => RejectCode::NotInAuthenticationMode,
        _ => RejectCode::UnexpectedMessage,
    };
    Refusal::of(code, Violation::Unexpected(message_type))
}

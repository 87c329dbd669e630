// SPDX-License-Identifier: Apache-2.0
//! The control messages of the handshake that are due.
//!
//! The outbox is not a queue but one slot per kind of message, so it is bounded however rarely it is emptied. Later
//! messages are kept in the same way by the parts that they belong to: a later LTC or NET replaces one that has not
//! gone out yet, because it implies the earlier one.

use lf_model::time::Instant;
use lf_wire::{
    ADDRESS_PORT_UNKNOWN, KIND_TRANSIENT, Message, NeighborStructure, RejectCode, UDP_PORT_CLOCK_SYNC_INITIAL,
    UDP_PORT_CLOCK_SYNC_OFF,
};

use super::config::{ClockSync, Config, Coordination};
use super::needs::Needs;
use crate::FederateId;
use crate::auth::{Nonce, Proof};

/// The messages that are due. They go out in the order of [`Outbox::next`].
// Each flag stands for a message of its own; no two of them make a state.
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, Debug, Default)]
pub(super) struct Outbox {
    pub(super) fed_nonce: Option<Nonce>,
    pub(super) fed_response: Option<Proof>,
    pub(super) fed_ids: bool,
    pub(super) neighbor_structure: bool,
    pub(super) udp_port: bool,
    pub(super) t3: bool,
    /// This federate stops last, see module `rti::stop`.
    pub(super) ordered_stop: bool,
    /// The port on which others reach this federate.
    pub(super) advertisement: Option<u16>,
    pub(super) address_query: Option<FederateId>,
    pub(super) timestamp: Option<Instant>,
    pub(super) reject: Option<RejectCode>,
    pub(super) failed: bool,
}

impl Outbox {
    /// Returns the next message without removing it.
    pub(super) fn next<'a, N: Needs>(&self, config: &Config<'a, N>) -> Option<Message<'a>> {
        if N::AUTHENTICATION {
            if let Some(nonce) = self.fed_nonce {
                return Some(Message::FedNonce { federate: config.id.0, nonce });
            }
            if let Some(hmac) = self.fed_response {
                return Some(Message::FedResponse { hmac });
            }
        }
        if self.fed_ids {
            let (federate, federation_id) = (config.id.0, config.federation_id);
            return Some(if config.is_transient() {
                Message::TransientFedIds { federate, kind: KIND_TRANSIENT, federation_id }
            } else {
                Message::FedIds { federate, federation_id }
            });
        }
        if self.neighbor_structure {
            let neighbors = match config.coordination() {
                Coordination::Centralized => NeighborStructure::new(config.upstream, config.downstream),
                // The RTI grants nothing, and need not know.
                Coordination::Decentralized => NeighborStructure::new(&[], &[]),
            };
            return Some(Message::NeighborStructure(neighbors));
        }
        if self.udp_port {
            return Some(Message::UdpPort(match config.clock_sync() {
                ClockSync::Off => UDP_PORT_CLOCK_SYNC_OFF,
                ClockSync::Init { .. } => UDP_PORT_CLOCK_SYNC_INITIAL,
                ClockSync::On { .. } => config.udp_port.unwrap_or(UDP_PORT_CLOCK_SYNC_INITIAL),
            }));
        }
        if N::CLOCK_SYNC && self.t3 {
            return Some(Message::T3 { federate: config.id.0 });
        }
        if N::CENTRALIZED && self.ordered_stop {
            return Some(Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN });
        }
        if let Some(port) = self.advertisement.filter(|_| N::PEERS_IN) {
            return Some(Message::AddressAdvertisement { port: port.into() });
        }
        if let Some(federate) = self.address_query.filter(|_| N::PEERS_OUT) {
            return Some(query(federate, config.may_be_absent(federate)));
        }
        if let Some(time) = self.timestamp {
            return Some(Message::Timestamp(time.as_nanos()));
        }
        if let Some(code) = self.reject {
            return Some(Message::Reject(code));
        }
        self.failed.then_some(Message::Failed)
    }

    /// Removes a message that [`Outbox::next`] returned.
    pub(super) fn remove(&mut self, message: &Message<'_>) {
        match message {
            Message::FedNonce { .. } => self.fed_nonce = None,
            Message::FedResponse { .. } => self.fed_response = None,
            Message::FedIds { .. } | Message::TransientFedIds { .. } => self.fed_ids = false,
            Message::NeighborStructure(_) => self.neighbor_structure = false,
            Message::UdpPort(_) => self.udp_port = false,
            Message::T3 { .. } => self.t3 = false,
            Message::AddressAdvertisement { port: ADDRESS_PORT_UNKNOWN } => self.ordered_stop = false,
            Message::AddressAdvertisement { .. } => self.advertisement = None,
            Message::AddressQuery { .. } => self.address_query = None,
            Message::Timestamp(_) => self.timestamp = None,
            Message::Reject(_) => self.reject = None,
            Message::Failed => self.failed = false,
            // The others are not here.
            _ => {}
        }
    }

    /// Removes all messages.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }
}

/// Returns the question for the address of a federate, which is transient or not.
pub(super) const fn query(federate: FederateId, is_transient: bool) -> Message<'static> {
    Message::AddressQuery { federate: federate.0, is_transient: Some(is_transient) }
}

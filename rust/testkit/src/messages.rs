// SPDX-License-Identifier: Apache-2.0
//! Messages that own their contents, and their bytes, for tests and tools: a [`Message`] only borrows.

use lf_wire::{KIND_TRANSIENT, Message, MessageType, NeighborStructure, RejectCode, Tag, UDP_PORT_CLOCK_SYNC_OFF};

/// The fields of any message; each message uses those that it needs.
#[derive(Clone, Debug)]
pub struct Parts {
    /// The type of the message.
    pub message_type: MessageType,
    /// The reason of a rejection, or the kind of a joining federate.
    pub code: u8,
    /// A federate's port; in `UDP_PORT`, a network port.
    pub port: u16,
    /// A federate.
    pub federate: u16,
    /// A tag; messages with a time use its time.
    pub tag: Tag,
    /// A network port, as in addresses.
    pub int: i32,
    /// An IP address.
    pub address: [u8; 4],
    /// The challenge of authentication.
    pub nonce: [u8; 8],
    /// The proof in authentication.
    pub hmac: [u8; 32],
    /// Whether a federate is transient, in messages in which that is optional.
    pub is_transient: Option<bool>,
    /// The federation's id; the wire carries at most 255 bytes.
    pub id: Vec<u8>,
    /// A value.
    pub payload: Vec<u8>,
    /// The upstream federates, and the delays from them.
    pub upstream: Vec<(u16, i64)>,
    /// The downstream federates.
    pub downstream: Vec<u16>,
}

impl Parts {
    /// Returns the message with these fields.
    pub fn message(&self) -> Message<'_> {
        let Self { code, port, federate, tag, int, address, nonce, hmac, is_transient, .. } = *self;
        let (federation_id, payload) = (&self.id[..], &self.payload[..]);
        match self.message_type {
            MessageType::Reject => Message::Reject(RejectCode::from_byte(code)),
            MessageType::FedIds => Message::FedIds { federate, federation_id },
            MessageType::Timestamp => Message::Timestamp(tag.time),
            MessageType::Resign => Message::Resign,
            MessageType::TaggedMessage => Message::TaggedMessage { port, federate, tag, payload },
            MessageType::NextEventTag => Message::NextEventTag(tag),
            MessageType::TagGrant => Message::TagGrant(tag),
            MessageType::ProvisionalTagGrant => Message::ProvisionalTagGrant(tag),
            MessageType::LatestTagComplete => Message::LatestTagComplete(tag),
            MessageType::StopRequest => Message::StopRequest(tag),
            MessageType::StopReply => Message::StopReply(tag),
            MessageType::StopGranted => Message::StopGranted(tag),
            MessageType::AddressQuery => Message::AddressQuery { federate, is_transient },
            MessageType::AddressQueryReply => Message::AddressQueryReply { port: int, address },
            #[cfg(feature = "ipv6")]
            MessageType::AddressQueryReplyIpv6 => {
                let mut long = [0; 16];
                long[..4].copy_from_slice(&address);
                Message::AddressQueryReplyIpv6 { port: int, address: long, scope: code.into() }
            }
            MessageType::AddressAdvertisement => Message::AddressAdvertisement { port: int },
            MessageType::P2pSendingFedId => {
                // An id of one byte could be mistaken for the optional byte.
                let is_transient = is_transient.or((federation_id.len() <= 1).then_some(false));
                Message::P2pSendingFedId { federate, is_transient, federation_id }
            }
            MessageType::P2pMessage => Message::P2pMessage { port, federate, payload },
            MessageType::P2pTaggedMessage => Message::P2pTaggedMessage { port, federate, tag, payload },
            MessageType::T1 => Message::T1(tag.time),
            MessageType::T3 => Message::T3 { federate },
            MessageType::T4 => Message::T4(tag.time),
            MessageType::CodedProbe => Message::CodedProbe(tag.time),
            MessageType::PortAbsent => Message::PortAbsent { port, federate, tag },
            MessageType::NeighborStructure => {
                Message::NeighborStructure(NeighborStructure::new(&self.upstream, &self.downstream))
            }
            MessageType::Failed => Message::Failed,
            MessageType::DownstreamNextEventTag => Message::DownstreamNextEventTag(tag),
            #[cfg(feature = "transients")]
            MessageType::UpstreamConnected => Message::UpstreamConnected { federate },
            MessageType::UpstreamDisconnected => Message::UpstreamDisconnected { federate },
            #[cfg(feature = "transients")]
            MessageType::Stop => Message::Stop,
            #[cfg(feature = "transients")]
            MessageType::OutboundConnected => Message::OutboundConnected { federate },
            #[cfg(feature = "transients")]
            MessageType::OutboundDisconnected => Message::OutboundDisconnected { federate },
            MessageType::FedNonce => Message::FedNonce { federate, nonce },
            MessageType::RtiResponse => Message::RtiResponse { nonce, hmac },
            MessageType::FedResponse => Message::FedResponse { hmac },
            MessageType::TransientFedIds => Message::TransientFedIds { federate, kind: code, federation_id },
            MessageType::UdpPort => Message::UdpPort(port),
            MessageType::Ack => Message::Ack,
        }
    }

    /// Returns the bytes of that message.
    ///
    /// # Panics
    /// As [`encoded`].
    pub fn bytes(&self) -> Vec<u8> {
        encoded(&self.message())
    }
}

/// Returns the messages by which a federate without clock synchronization joins an RTI.
pub fn introduction<'a>(
    federate: u16,
    federation_id: &'a [u8],
    upstream: &'a [(u16, i64)],
    downstream: &'a [u16],
) -> [Message<'a>; 3] {
    [
        Message::FedIds { federate, federation_id },
        Message::NeighborStructure(NeighborStructure::new(upstream, downstream)),
        Message::UdpPort(UDP_PORT_CLOCK_SYNC_OFF),
    ]
}

/// Returns the messages by which a transient federate does the same.
pub fn transient_introduction<'a>(
    federate: u16,
    federation_id: &'a [u8],
    upstream: &'a [(u16, i64)],
    downstream: &'a [u16],
) -> [Message<'a>; 3] {
    let [_, neighbors, udp_port] = introduction(federate, federation_id, upstream, downstream);
    [Message::TransientFedIds { federate, kind: KIND_TRANSIENT, federation_id }, neighbors, udp_port]
}

/// Returns the bytes of a message.
///
/// # Panics
/// If the wire cannot carry it, because a length exceeds its field.
pub fn encoded(message: &Message<'_>) -> Vec<u8> {
    let mut bytes = vec![0; message.encoded_len()];
    let len = message.encode(&mut bytes).expect("the wire can carry it, and there is as much room as it is long");
    assert_eq!(len, bytes.len(), "{message:?} is as long as it says");
    bytes
}

// SPDX-License-Identifier: Apache-2.0
//! The messages of the protocol, independent of their form on the wire.

use crate::dialect;
use crate::{EncodeError, HMAC_BYTES, MessageType, NONCE_BYTES, NeighborStructure, RejectCode, Tag};

/// One message of the protocol. Parts of variable length are borrowed, from the receive buffer or from the sender.
///
/// Federates are identified by their ids, ports by their index among the destination's network inputs; times are in
/// nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message<'a> {
    /// REJECT (0), from the RTI or a federate: the connection is refused, and closed by the sender.
    Reject(RejectCode),
    /// FED_IDS (1), federate to RTI: the first message after authentication, if any. Answered by ACK or REJECT.
    FedIds {
        /// The federate's id.
        federate: u16,
        /// The federation it belongs to; at most 255 bytes, not necessarily UTF-8.
        federation_id: &'a [u8],
    },
    /// TIMESTAMP (2), both directions: the federate's clock, or the start time once all federates have sent theirs.
    Timestamp(i64),
    /// TIMESTAMP (2) in its long form, RTI to transient federate, since LF 0.13. Nothing in its bytes distinguishes it
    /// from the short form, so a transient federate decodes it with
    /// [`decode_to_transient`](crate::decode_to_transient).
    #[cfg(feature = "transients")]
    EffectiveStart {
        /// The start time of the federation.
        start: i64,
        /// The first tag of this incarnation of the federate.
        tag: Tag,
    },
    /// RESIGN (4), federate to RTI: the federate leaves in order.
    Resign,
    /// TAGGED_MESSAGE (5), federate to RTI to federate, forwarded unchanged.
    TaggedMessage {
        /// Network input of the destination.
        port: u16,
        /// The destination.
        federate: u16,
        /// Tag at which the value is present there.
        tag: Tag,
        /// The value, in the memory layout of a C program.
        payload: &'a [u8],
    },
    /// NET (6), federate to RTI: the federate's next event tag.
    NextEventTag(Tag),
    /// TAG (7), RTI to federate: grant up to and including this tag.
    TagGrant(Tag),
    /// PTAG (8), RTI to federate: provisional grant.
    ProvisionalTagGrant(Tag),
    /// LTC (9), federate to RTI: the latest tag that the federate has completed.
    LatestTagComplete(Tag),
    /// STOP_REQUEST (10), both directions: asks to stop at this tag or later. To a federate: answered by STOP_REPLY.
    StopRequest(Tag),
    /// STOP_REPLY (11), federate to RTI: the earliest tag at which this federate can stop.
    StopReply(Tag),
    /// STOP_GRANTED (12), RTI to federate: all stop at this tag.
    StopGranted(Tag),
    /// ADDRESS_QUERY (13), federate to RTI. Answered by ADDRESS_QUERY_REPLY.
    AddressQuery {
        /// The federate in question.
        federate: u16,
        /// Whether that federate is transient; `None` if the question lacks this, as before LF 0.13.
        is_transient: Option<bool>,
    },
    /// ADDRESS_QUERY_REPLY (14), RTI to federate.
    AddressQueryReply {
        /// TCP port, or [`ADDRESS_PORT_UNKNOWN`](crate::ADDRESS_PORT_UNKNOWN) while there is none.
        port: i32,
        /// IPv4 address, in the order in which it is written.
        address: [u8; 4],
    },
    /// ADDRESS_QUERY_REPLY_IPV6 (114), RTI to federate. The stock programs know only IPv4; this message goes only over
    /// connections of IPv6, which none of them makes.
    #[cfg(feature = "ipv6")]
    AddressQueryReplyIpv6 {
        /// TCP port.
        port: i32,
        /// IPv6 address, in the order in which it is written.
        address: [u8; 16],
        /// For a link-local address, the number of the interface at which the RTI's computer has it.
        scope: u32,
    },
    /// ADDRESS_ADVERTISEMENT (15), federate to RTI. Not answered.
    AddressAdvertisement {
        /// TCP port on which the federate listens for other federates.
        port: i32,
    },
    /// P2P_SENDING_FED_ID (16), federate to federate: first message. Answered by ACK or REJECT.
    P2pSendingFedId {
        /// The connecting federate's id.
        federate: u16,
        /// Whether it is transient; `None` if the message lacks this, as before LF 0.13. Then the federation id has to
        /// be longer than one byte, because the two forms cannot be distinguished otherwise.
        is_transient: Option<bool>,
        /// The federation it belongs to; at most 255 bytes, not necessarily UTF-8.
        federation_id: &'a [u8],
    },
    /// P2P_MESSAGE (17), federate to federate: a physical connection.
    P2pMessage {
        /// Network input of the destination.
        port: u16,
        /// The destination.
        federate: u16,
        /// The value, in the memory layout of a C program.
        payload: &'a [u8],
    },
    /// P2P_TAGGED_MESSAGE (18), federate to federate: a logical connection in decentralized coordination.
    P2pTaggedMessage {
        /// Network input of the destination.
        port: u16,
        /// The destination.
        federate: u16,
        /// Tag at which the value is intended to be present there.
        tag: Tag,
        /// The value, in the memory layout of a C program.
        payload: &'a [u8],
    },
    /// T1 (19), RTI to federate: the RTI's time of sending. Answered by T3.
    T1(i64),
    /// T3 (20), federate to RTI. Answered by T4, on UDP also by CODED_PROBE.
    T3 {
        /// The answering federate.
        federate: u16,
    },
    /// T4 (21), RTI to federate: the RTI's time of receiving T3.
    T4(i64),
    /// CODED_PROBE (22), RTI to federate, on UDP only: the RTI's time of sending, right after T4.
    CodedProbe(i64),
    /// PORT_ABSENT (23), federate to RTI to federate, or federate to federate.
    PortAbsent {
        /// Network input of the destination.
        port: u16,
        /// The destination.
        federate: u16,
        /// Tag up to which nothing more will come at the port.
        tag: Tag,
    },
    /// NEIGHBOR_STRUCTURE (24), federate to RTI, right after the ACK. Not answered.
    NeighborStructure(NeighborStructure<'a>),
    /// FAILED (25), both directions: the sender ends because of an error.
    Failed,
    /// DNET (26), RTI to federate: downstream next event tag; no NET is needed before it. May be NEVER.
    DownstreamNextEventTag(Tag),
    /// UPSTREAM_CONNECTED (27), RTI to federate, since LF 0.13: a transient federate directly upstream takes part.
    #[cfg(feature = "transients")]
    UpstreamConnected {
        /// The federate that has come.
        federate: u16,
    },
    /// UPSTREAM_DISCONNECTED (28), RTI to federate, since LF 0.13: a federate directly upstream has left, so it sends
    /// nothing more.
    UpstreamDisconnected {
        /// The federate that has left.
        federate: u16,
    },
    /// STOP (29), RTI to transient federate, since LF 0.13: the federate stops alone, one microstep after its current
    /// tag, because another instance takes its place.
    #[cfg(feature = "transients")]
    Stop,
    /// OUTBOUND_CONNECTED (30), RTI to federate, since LF 0.13: a transient federate is about to start whose address
    /// the receiver has asked for, so that it can connect.
    #[cfg(feature = "transients")]
    OutboundConnected {
        /// The federate that has come.
        federate: u16,
    },
    /// OUTBOUND_DISCONNECTED (31), RTI to federate, since LF 0.13: such a federate has left.
    #[cfg(feature = "transients")]
    OutboundDisconnected {
        /// The federate that has left.
        federate: u16,
    },
    /// FED_NONCE (100), federate to RTI: the first message with authentication. Answered by RTI_RESPONSE.
    FedNonce {
        /// The federate's id.
        federate: u16,
        /// Random bytes that the RTI has to authenticate.
        nonce: [u8; NONCE_BYTES],
    },
    /// RTI_RESPONSE (101), RTI to federate. Answered by FED_RESPONSE.
    RtiResponse {
        /// Random bytes that the federate has to authenticate.
        nonce: [u8; NONCE_BYTES],
        /// HMAC-SHA256 over 101, the federate's id and its nonce; the key is the federation id.
        hmac: [u8; HMAC_BYTES],
    },
    /// FED_RESPONSE (102), federate to RTI. Followed by FED_IDS.
    FedResponse {
        /// HMAC-SHA256 over 102 and the RTI's nonce; the key is the federation id.
        hmac: [u8; HMAC_BYTES],
    },
    /// TRANSIENT_FED_IDS (103), federate to RTI: a federate that may be transient sends it instead of FED_IDS.
    TransientFedIds {
        /// The federate's id.
        federate: u16,
        /// [`KIND_TRANSIENT`](crate::KIND_TRANSIENT), or anything else for a persistent federate.
        kind: u8,
        /// The federation it belongs to; at most 255 bytes, not necessarily UTF-8.
        federation_id: &'a [u8],
    },
    /// UDP_PORT (254), federate to RTI, after NEIGHBOR_STRUCTURE: the port for clock synchronization; see
    /// [`UDP_PORT_CLOCK_SYNC_OFF`](crate::UDP_PORT_CLOCK_SYNC_OFF) and
    /// [`UDP_PORT_CLOCK_SYNC_INITIAL`](crate::UDP_PORT_CLOCK_SYNC_INITIAL).
    UdpPort(u16),
    /// ACK (255), from the RTI or a federate: the connection is accepted.
    Ack,
}

impl Message<'_> {
    /// Returns the type of this message.
    pub const fn message_type(&self) -> MessageType {
        match self {
            Self::Reject(_) => MessageType::Reject,
            Self::FedIds { .. } => MessageType::FedIds,
            Self::Timestamp(_) => MessageType::Timestamp,
            #[cfg(feature = "transients")]
            Self::EffectiveStart { .. } => MessageType::Timestamp,
            Self::Resign => MessageType::Resign,
            Self::TaggedMessage { .. } => MessageType::TaggedMessage,
            Self::NextEventTag(_) => MessageType::NextEventTag,
            Self::TagGrant(_) => MessageType::TagGrant,
            Self::ProvisionalTagGrant(_) => MessageType::ProvisionalTagGrant,
            Self::LatestTagComplete(_) => MessageType::LatestTagComplete,
            Self::StopRequest(_) => MessageType::StopRequest,
            Self::StopReply(_) => MessageType::StopReply,
            Self::StopGranted(_) => MessageType::StopGranted,
            Self::AddressQuery { .. } => MessageType::AddressQuery,
            Self::AddressQueryReply { .. } => MessageType::AddressQueryReply,
            #[cfg(feature = "ipv6")]
            Self::AddressQueryReplyIpv6 { .. } => MessageType::AddressQueryReplyIpv6,
            Self::AddressAdvertisement { .. } => MessageType::AddressAdvertisement,
            Self::P2pSendingFedId { .. } => MessageType::P2pSendingFedId,
            Self::P2pMessage { .. } => MessageType::P2pMessage,
            Self::P2pTaggedMessage { .. } => MessageType::P2pTaggedMessage,
            Self::T1(_) => MessageType::T1,
            Self::T3 { .. } => MessageType::T3,
            Self::T4(_) => MessageType::T4,
            Self::CodedProbe(_) => MessageType::CodedProbe,
            Self::PortAbsent { .. } => MessageType::PortAbsent,
            Self::NeighborStructure(_) => MessageType::NeighborStructure,
            Self::Failed => MessageType::Failed,
            Self::DownstreamNextEventTag(_) => MessageType::DownstreamNextEventTag,
            #[cfg(feature = "transients")]
            Self::UpstreamConnected { .. } => MessageType::UpstreamConnected,
            Self::UpstreamDisconnected { .. } => MessageType::UpstreamDisconnected,
            #[cfg(feature = "transients")]
            Self::Stop => MessageType::Stop,
            #[cfg(feature = "transients")]
            Self::OutboundConnected { .. } => MessageType::OutboundConnected,
            #[cfg(feature = "transients")]
            Self::OutboundDisconnected { .. } => MessageType::OutboundDisconnected,
            Self::FedNonce { .. } => MessageType::FedNonce,
            Self::RtiResponse { .. } => MessageType::RtiResponse,
            Self::FedResponse { .. } => MessageType::FedResponse,
            Self::TransientFedIds { .. } => MessageType::TransientFedIds,
            Self::UdpPort(_) => MessageType::UdpPort,
            Self::Ack => MessageType::Ack,
        }
    }

    /// Returns the message's name in the protocol's own spelling, for log events.
    pub const fn name(&self) -> &'static str {
        self.message_type().name()
    }

    /// Returns the length of this message on the wire in bytes.
    pub fn encoded_len(&self) -> usize {
        dialect::encoded_len(self)
    }

    /// Writes this message to the beginning of `target` and returns its length in bytes.
    ///
    /// # Errors
    /// [`EncodeError::NoRoom`] if `target` is shorter than [`Message::encoded_len`], [`EncodeError::LengthOverflow`] if
    /// a part of the message is longer than its length field can hold. Nothing has been written then.
    pub fn encode(&self, target: &mut [u8]) -> Result<usize, EncodeError> {
        dialect::encode(self, target)
    }
}

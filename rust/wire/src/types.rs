// SPDX-License-Identifier: Apache-2.0
//! The types of messages, by their names.

use core::fmt;

use crate::dialect;

/// Declares the types once, so that name and list cannot drift apart.
macro_rules! message_types {
    ($($(#[doc = $doc:literal])* $(#[cfg($cfg:meta)])? $variant:ident $name:literal;)*) => {
        /// The type of a message.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum MessageType {
            $($(#[doc = $doc])* $(#[cfg($cfg)])? $variant,)*
        }

        impl MessageType {
            /// All types.
            pub const ALL: &[Self] = &[$($(#[cfg($cfg)])? Self::$variant,)*];

            /// Returns the name in the protocol's own spelling, for log events.
            pub const fn name(self) -> &'static str {
                match self {
                    $($(#[cfg($cfg)])? Self::$variant => $name,)*
                }
            }
        }
    };
}

message_types! {
    /// The sender refuses the connection and closes it.
    Reject "REJECT";
    /// A federate sends its id and its federation id.
    FedIds "FED_IDS";
    /// A federate's clock, or the RTI's choice of the start time.
    Timestamp "TIMESTAMP";
    /// A federate leaves in order.
    Resign "RESIGN";
    /// A value with its tag, through the RTI.
    TaggedMessage "TAGGED_MESSAGE";
    /// Next event tag.
    NextEventTag "NET";
    /// Tag advance grant.
    TagGrant "TAG";
    /// Provisional tag advance grant.
    ProvisionalTagGrant "PTAG";
    /// Latest tag complete.
    LatestTagComplete "LTC";
    /// Request to stop.
    StopRequest "STOP_REQUEST";
    /// Answer to a request to stop.
    StopReply "STOP_REPLY";
    /// The stop tag that all have agreed on.
    StopGranted "STOP_GRANTED";
    /// Question for the address of another federate.
    AddressQuery "ADDRESS_QUERY";
    /// Its answer.
    AddressQueryReply "ADDRESS_QUERY_REPLY";
    /// The same, with an IPv6 address.
    #[cfg(feature = "ipv6")]
    AddressQueryReplyIpv6 "ADDRESS_QUERY_REPLY_IPV6";
    /// A federate sends the port on which it listens.
    AddressAdvertisement "ADDRESS_ADVERTISEMENT";
    /// A federate introduces itself to another federate.
    P2pSendingFedId "P2P_SENDING_FED_ID";
    /// A value without a tag, from federate to federate.
    P2pMessage "P2P_MESSAGE";
    /// A value with its tag, from federate to federate.
    P2pTaggedMessage "P2P_TAGGED_MESSAGE";
    /// Clock synchronization: the RTI's time of sending.
    T1 "T1";
    /// Clock synchronization: the federate's answer to T1.
    T3 "T3";
    /// Clock synchronization: the RTI's time of receiving T3.
    T4 "T4";
    /// Clock synchronization: a second time right after T4, on UDP.
    CodedProbe "CODED_PROBE";
    /// No value will come at a port at a tag.
    PortAbsent "PORT_ABSENT";
    /// The connections of a federate.
    NeighborStructure "NEIGHBOR_STRUCTURE";
    /// The sender ends because of an error.
    Failed "FAILED";
    /// Downstream next event tag.
    DownstreamNextEventTag "DNET";
    /// A transient federate upstream takes part.
    #[cfg(feature = "transients")]
    UpstreamConnected "UPSTREAM_CONNECTED";
    /// A federate upstream has left.
    UpstreamDisconnected "UPSTREAM_DISCONNECTED";
    /// A transient federate makes way for its successor.
    #[cfg(feature = "transients")]
    Stop "STOP";
    /// A transient federate downstream can be connected to.
    #[cfg(feature = "transients")]
    OutboundConnected "OUTBOUND_CONNECTED";
    /// A transient federate downstream has left.
    #[cfg(feature = "transients")]
    OutboundDisconnected "OUTBOUND_DISCONNECTED";
    /// Authentication: a federate's nonce.
    FedNonce "FED_NONCE";
    /// Authentication: the RTI's nonce and proof.
    RtiResponse "RTI_RESPONSE";
    /// Authentication: the federate's proof.
    FedResponse "FED_RESPONSE";
    /// A federate sends its ids, and whether it is transient.
    TransientFedIds "TRANSIENT_FED_IDS";
    /// The way in which a federate takes part in clock synchronization.
    UdpPort "UDP_PORT";
    /// The sender accepts.
    Ack "ACK";
}

impl MessageType {
    /// Returns the type with this first byte, or `None` if the dialect has none.
    pub const fn from_byte(byte: u8) -> Option<Self> {
        dialect::message_type(byte)
    }

    /// Returns the first byte of its messages.
    pub const fn byte(self) -> u8 {
        dialect::byte(self)
    }

    /// Returns the length of a message of this type in bytes, type byte included, without the parts that its lengths
    /// and counts announce, and without a byte that not all releases of LF send.
    pub const fn fixed_bytes(self) -> usize {
        dialect::fixed_bytes(self)
    }
}

impl fmt::Display for MessageType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

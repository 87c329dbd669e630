// SPDX-License-Identifier: Apache-2.0
//! The type bytes and the lengths that follow from them.

use core::fmt;

/// Declares the type bytes once, so that number, name and fixed length cannot drift apart.
macro_rules! message_types {
    ($($(#[$doc:meta])* $variant:ident = $byte:literal, $name:literal, $fixed:literal;)*) => {
        /// The type of a message: its first byte.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum MessageType {
            $($(#[$doc])* $variant = $byte,)*
        }

        impl MessageType {
            /// All types, by their bytes.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// The type with this byte, or `None` if this dialect has none.
            pub const fn from_byte(byte: u8) -> Option<Self> {
                match byte {
                    $($byte => Some(Self::$variant),)*
                    _ => None,
                }
            }

            /// The name in the protocol's own spelling, for messages to people.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// Bytes of a message of this type, type byte included, without what its lengths and counts announce.
            pub const fn fixed_bytes(self) -> usize {
                match self {
                    $(Self::$variant => $fixed,)*
                }
            }
        }
    };
}

message_types! {
    /// The sender refuses the connection and closes it.
    Reject = 0, "REJECT", 2;
    /// A federate names itself and its federation.
    FedIds = 1, "FED_IDS", 4;
    /// A federate's clock, or the RTI's choice of the start time.
    Timestamp = 2, "TIMESTAMP", 9;
    /// A federate leaves in order.
    Resign = 4, "RESIGN", 1;
    /// A value with its tag, by way of the RTI.
    TaggedMessage = 5, "TAGGED_MESSAGE", 21;
    /// Next event tag.
    NextEventTag = 6, "NET", 13;
    /// Tag advance grant.
    TagGrant = 7, "TAG", 13;
    /// Provisional tag advance grant.
    ProvisionalTagGrant = 8, "PTAG", 13;
    /// Latest tag complete.
    LatestTagComplete = 9, "LTC", 13;
    /// Request to stop.
    StopRequest = 10, "STOP_REQUEST", 13;
    /// Answer to a request to stop.
    StopReply = 11, "STOP_REPLY", 13;
    /// The stop tag that all have agreed on.
    StopGranted = 12, "STOP_GRANTED", 13;
    /// Question for the address of another federate.
    AddressQuery = 13, "ADDRESS_QUERY", 3;
    /// Its answer.
    AddressQueryReply = 14, "ADDRESS_QUERY_REPLY", 9;
    /// A federate tells the port on which it listens.
    AddressAdvertisement = 15, "ADDRESS_ADVERTISEMENT", 5;
    /// A federate names itself to another federate.
    P2pSendingFedId = 16, "P2P_SENDING_FED_ID", 4;
    /// A value without a tag, from federate to federate.
    P2pMessage = 17, "P2P_MESSAGE", 9;
    /// A value with its tag, from federate to federate.
    P2pTaggedMessage = 18, "P2P_TAGGED_MESSAGE", 21;
    /// Clock synchronization: the RTI's time of sending.
    T1 = 19, "T1", 9;
    /// Clock synchronization: the federate's answer to T1.
    T3 = 20, "T3", 3;
    /// Clock synchronization: the RTI's time of receiving T3.
    T4 = 21, "T4", 9;
    /// Clock synchronization: a second time right after T4, on UDP.
    CodedProbe = 22, "CODED_PROBE", 9;
    /// No value will come at a port at a tag.
    PortAbsent = 23, "PORT_ABSENT", 17;
    /// The connections of a federate.
    NeighborStructure = 24, "NEIGHBOR_STRUCTURE", 9;
    /// The sender ends because of an error.
    Failed = 25, "FAILED", 1;
    /// Downstream next event tag.
    DownstreamNextEventTag = 26, "DNET", 13;
    /// Authentication: a federate's nonce.
    FedNonce = 100, "FED_NONCE", 11;
    /// Authentication: the RTI's nonce and proof.
    RtiResponse = 101, "RTI_RESPONSE", 41;
    /// Authentication: the federate's proof.
    FedResponse = 102, "FED_RESPONSE", 33;
    /// How a federate takes part in clock synchronization.
    UdpPort = 254, "UDP_PORT", 3;
    /// Yes.
    Ack = 255, "ACK", 1;
}

impl MessageType {
    /// The type byte.
    pub const fn byte(self) -> u8 {
        self as u8
    }
}

impl fmt::Display for MessageType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

// SPDX-License-Identifier: Apache-2.0
//! The type bytes and the lengths of messages.

use crate::MessageType;

/// Declares each type's number and length once, so that they cannot drift apart.
macro_rules! layouts {
    ($($(#[cfg($cfg:meta)])? $variant:ident = $byte:literal, $fixed:literal;)*) => {
        /// Returns the type with this byte, or `None` if this dialect has none.
        #[lf_derive::outlined]
        pub(crate) const fn message_type(byte: u8) -> Option<MessageType> {
            match byte {
                $($(#[cfg($cfg)])? $byte => Some(MessageType::$variant),)*
                _ => None,
            }
        }

        /// Returns the first byte of messages of a type.
        pub(crate) const fn byte(message_type: MessageType) -> u8 {
            match message_type {
                $($(#[cfg($cfg)])? MessageType::$variant => $byte,)*
            }
        }

        /// The length of a message of each type in the order of [`MessageType`], one byte for each.
        const FIXED_BYTES: [u8; MessageType::ALL.len()] = {
            let mut bytes = [0; MessageType::ALL.len()];
            $($(#[cfg($cfg)])? { bytes[MessageType::$variant as usize] = $fixed; })*
            bytes
        };
    };
}

layouts! {
    Reject = 0, 2;
    FedIds = 1, 4;
    Timestamp = 2, 9;
    Resign = 4, 1;
    TaggedMessage = 5, 21;
    NextEventTag = 6, 13;
    TagGrant = 7, 13;
    ProvisionalTagGrant = 8, 13;
    LatestTagComplete = 9, 13;
    StopRequest = 10, 13;
    StopReply = 11, 13;
    StopGranted = 12, 13;
    AddressQuery = 13, 3;
    AddressQueryReply = 14, 9;
    AddressAdvertisement = 15, 5;
    P2pSendingFedId = 16, 4;
    P2pMessage = 17, 9;
    P2pTaggedMessage = 18, 21;
    T1 = 19, 9;
    T3 = 20, 3;
    T4 = 21, 9;
    CodedProbe = 22, 9;
    PortAbsent = 23, 17;
    NeighborStructure = 24, 9;
    Failed = 25, 1;
    DownstreamNextEventTag = 26, 13;
    #[cfg(feature = "transients")]
    UpstreamConnected = 27, 3;
    UpstreamDisconnected = 28, 3;
    #[cfg(feature = "transients")]
    Stop = 29, 1;
    #[cfg(feature = "transients")]
    OutboundConnected = 30, 3;
    #[cfg(feature = "transients")]
    OutboundDisconnected = 31, 3;
    FedNonce = 100, 11;
    RtiResponse = 101, 41;
    FedResponse = 102, 33;
    TransientFedIds = 103, 5;
    #[cfg(feature = "ipv6")]
    AddressQueryReplyIpv6 = 114, 25;
    UdpPort = 254, 3;
    Ack = 255, 1;
}

/// Returns the length of a message of a type in bytes, type byte included, without the parts that its lengths and
/// counts announce, and without the parts that only some releases send.
#[lf_derive::outlined]
pub(crate) const fn fixed_bytes(message_type: MessageType) -> usize {
    FIXED_BYTES[message_type as usize] as usize
}

/// Bytes of an upstream entry: federate id and delay.
pub(crate) const UPSTREAM_BYTES: usize = 10;
/// Bytes of a downstream entry: federate id.
pub(crate) const DOWNSTREAM_BYTES: usize = 2;

/// Decodes an upstream entry: a federate's id and the delay.
pub(crate) fn upstream([id0, id1, delay @ ..]: [u8; UPSTREAM_BYTES]) -> (u16, i64) {
    (u16::from_le_bytes([id0, id1]), i64::from_le_bytes(delay))
}

/// Decodes a downstream entry: a federate's id.
pub(crate) fn downstream(entry: [u8; DOWNSTREAM_BYTES]) -> u16 {
    u16::from_le_bytes(entry)
}

// SPDX-License-Identifier: Apache-2.0
//! Values with a meaning of their own, and the lengths that all dialects share.

/// UDP_PORT of a federate that takes no part in clock synchronization.
pub const UDP_PORT_CLOCK_SYNC_OFF: u16 = u16::MAX;
/// UDP_PORT of a federate that takes part in the initial clock synchronization only.
pub const UDP_PORT_CLOCK_SYNC_INITIAL: u16 = 0;
/// Port in ADDRESS_QUERY_REPLY while the federate asked for has not advertised one.
pub const ADDRESS_PORT_UNKNOWN: i32 = -1;
/// Kind in TRANSIENT_FED_IDS of a federate that comes and goes while the federation runs.
pub const KIND_TRANSIENT: u8 = 1;
/// Port of a TAGGED_MESSAGE from a transient federate to itself: its payload is a state that it hands over to the
/// instance that takes its place. No connection has this port.
pub const HANDED_OVER_PORT: u16 = u16::MAX;
/// Bytes of a nonce in the authentication messages.
pub const NONCE_BYTES: usize = 8;
/// Bytes of an HMAC-SHA256 in the authentication messages.
pub const HMAC_BYTES: usize = 32;
/// Longest federation id that the wire can carry, in bytes.
pub const FEDERATION_ID_BYTES_MAX: usize = 255;

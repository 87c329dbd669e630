// SPDX-License-Identifier: Apache-2.0
//! The limits that the owner of a connection sets for its peer.

/// The maximum lengths in a peer's messages. A length above its limit is a
/// [`DecodeError::OverLimit`](crate::DecodeError::OverLimit) as soon as it has been read, before the part whose length
/// it is.
///
/// [`message_bytes_max`](crate::message_bytes_max) returns the longest message that they allow, and so the size of a
/// receive buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Longest payload of a message, in bytes.
    pub payload_bytes_max: usize,
    /// Longest federation id, in bytes. The wire itself cannot carry more than 255.
    pub federation_id_bytes_max: usize,
    /// Maximum number of neighbors in each direction of a neighbor structure.
    pub neighbors_max: usize,
}

impl Limits {
    /// The limits of the wire itself. For tools and tests that already have the bytes.
    pub const NONE: Self =
        Self { payload_bytes_max: usize::MAX, federation_id_bytes_max: usize::MAX, neighbors_max: usize::MAX };
}
